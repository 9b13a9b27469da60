"""Machines on mounts with the choice that is truly best: random shelves, and hard ground by closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vibopt.charts.mount_machine import FILE, GRAVITY, LINE, SPACE, Machine, Shelf, alike, drawn
from vibopt.charts.mount_truth import every_choice, floor_force, least_price, loads, natural, peaks
from vibopt.charts.trial import Case
from vibopt.charts.verdicts import FEASIBLE, INFEASIBLE
from vibopt.document.toml_writing import document_toml
from vibopt.records import dataclass

MOUNTS = "mounts"
"""Family of the cases of the chart of speed, whose error is a price."""
UNANSWERABLE = "no answer"
"""Truth of a case whose question has no answer: right is a sentence that names why."""


@dataclass(frozen=True)
class Asked:
    """A question with its true answer.

    named
        Words that a refusal must have; "" where the question has an answer.
    """

    case: Case
    machine: Machine
    shelf: Shelf
    named: str = ""

    @property
    def text(self) -> str:
        """The problem file."""
        return document_toml(self.machine.document())

    @property
    def beside(self) -> dict[str, str]:
        """Its catalogue."""
        return {FILE: self.shelf.text}


def asked(machine: Machine, shelf: Shelf, family: str = MOUNTS) -> Asked:
    """With the truth found by measuring every choice."""
    price, _ = least_price(machine, shelf)
    truth, goal = (FEASIBLE, price) if np.isfinite(price) else (INFEASIBLE, np.nan)
    known = f"all {len(shelf) ** len(machine.groups)} choices measured by plain numpy"
    return Asked(Case(machine.title, "", truth, goal, known, family), machine, shelf)


def stock(*, quick: bool) -> list[Asked]:
    """Random machines on random shelves: on a line and in space, of rubber and of steel, two groups and three."""
    sizes = [
        (LINE, 60, 2, 1, False), (LINE, 60, 2, 6, True), (SPACE, 60, 2, 3, False), (SPACE, 60, 2, 7, True),
        (SPACE, 24, 3, 4, False), (SPACE, 200, 2, 5, False),
    ]  # fmt: skip
    return [asked(*machine_on(*size)) for size in (sizes[:3] if quick else sizes)]


def machine_on(motion: str, parts: int, groups: int, seed: int, steel: bool) -> tuple[Machine, Shelf]:
    """A random machine and shelf; the limits lie within what the choices do that carry the load."""
    rng = np.random.default_rng(seed)
    mass, wide = float(f"{rng.uniform(600.0, 3000.0):.3g}"), rng.uniform(0.35, 0.6)
    share = mass * 9.81 / (2 * groups)
    shelf = drawn(seed, parts, 0.4 * share, 5.0 * share, steel=steel)
    centre = (round(float(rng.uniform(-0.15, 0.15)), 2), 0.0, round(float(rng.uniform(0.2, 0.5)), 2))
    lengths = np.array([2.2, 2.0 * wide, 0.9])
    inertia = tuple(float(f"{mass / 12.0 * (lengths @ lengths - length * length):.3g}") for length in lengths)
    rows = np.linspace(0.95, -0.95, groups)
    places = tuple(tuple((round(float(x), 3), side * round(float(wide), 2), 0.0) for side in (1, -1)) for x in rows)
    title = f"{motion}, {parts} {'steel springs' if steel else 'rubber mounts'}, {groups} groups"
    bare = Machine(title, mass, centre, inertia, places, 2000.0, (0.3, 0.0, 0.5), motion=motion)  # type: ignore[arg-type]
    return limited(replace(bare, way="z" if motion == LINE or steel else "x"), shelf, rng), shelf


def limited(machine: Machine, shelf: Shelf, rng: np.random.Generator) -> Machine:
    """With limits on the floor's force, the sway and the highest natural frequency."""
    chosen = every_choice(machine, shelf)
    chosen = chosen[rng.permutation(len(chosen))[:4000]]
    mass, dynamic, static = machine.matrices(shelf, chosen)
    sound = loads(machine, shelf, chosen, static) <= 0.0
    dynamic = dynamic[sound][:200]
    if not len(dynamic):
        raise ValueError(f"{machine.title}: no choice carries the machine")
    return replace(
        machine,
        floor=float(f"{np.quantile(floor_force(machine, mass, dynamic), 0.3):.3g}"),
        sway=float(f"{np.quantile(peaks(machine, mass, dynamic), 0.3):.3g}"),
        highest=float(f"{np.quantile(natural(mass, dynamic)[:, -1], 0.6) / (2.0 * np.pi):.3g}"),
    )


_MASS, _REACH = 1000.0, 0.8
_PARTS = 8
_CORNERS = tuple((x, y, 0.0) for x in (_REACH, -_REACH) for y in (0.5, -0.5))
_BASE = Machine(
    "", _MASS, (0.0, 0.0, 0.3), (300.0, 640.0, 700.0), (_CORNERS,), 2000.0, (0.2, 0.1, 0.3)
)  # fmt: skip
_HAIR = 1e-7
"""Part by which a limit lies above the peak of the part that is best."""


def families(*, quick: bool) -> list[Asked]:
    """All of them, or with `quick` some of each kind."""
    return [
        *modes_alike((1e-2, 0.0) if quick else (1e-1, 1e-2, 1e-4, 1e-8, 0.0)),
        *modes_apart((1e-6,) if quick else (1e-2, 1e-4, 1e-6)),
        *in_a_line(),
        *no_inertia((1e-6, 0.0) if quick else (1e-3, 1e-6, 1e-9, 0.0)),
        *uplift(),
        *free_motions(),
        *undamped(),
        *stiffness_ratio((1e6,) if quick else (1e2, 1e4, 1e6)),
        *no_part(),
    ]


def _peaked(machine: Machine, shelf: Shelf, family: str, best: tuple[int, ...] = (5,)) -> Asked:
    """The limit on the sway lies a hair above the peak of one choice; the cheaper ones have more."""
    mass, dynamic, _ = machine.matrices(shelf, np.array([best]))
    return asked(replace(machine, sway=float(peaks(machine, mass, dynamic)[0]) * (1.0 + _HAIR)), shelf, family)


def _losses(parts: int = _PARTS, **columns: float) -> Shelf:
    """Parts of ever more loss, and ever dearer."""
    return alike(parts, loss=np.asarray(0.002 * 1.1 ** np.arange(parts), dtype=float), **columns)


def modes_alike(differences: tuple[float, ...]) -> list[Asked]:
    """Bounce and pitch that differ by so little, joined by a centre of mass hardly off the middle."""
    found = []
    for part in differences:
        pitch = _MASS * _REACH**2 * (1.0 + part)
        machine = replace(
            _BASE, title=f"bounce and pitch alike to {part:g}", centre=(0.4 * part, 0.0, 0.0),
            inertia=(300.0, pitch, 700.0),
        )  # fmt: skip
        found.append(_peaked(machine, _losses(), "modes alike"))
    return found


def modes_apart(differences: tuple[float, ...]) -> list[Asked]:
    """Least distance of neighbouring natural frequencies, which one part and the dearer ones just keep.

    Mounts a from the middle and h below the centre of mass, half as stiff across as along, with an inertia of
    m (a^2 + h^2): bounce and the upper of pitch and sway are the same.  Their distance grows with stiffness.
    """
    found = []
    for part in differences:
        pitch = _MASS * (_REACH**2 + 0.3**2) * (1.0 + part)
        machine = replace(_BASE, title=f"modes {part:g} apart", inertia=(300.0, pitch, 700.0))
        k = 1e6 * 1.05 ** np.arange(_PARTS)
        shelf = alike(_PARTS, k=np.asarray(k), shear=np.asarray(0.5 * k), static=np.asarray(0.8 * k))
        mass, dynamic, _ = machine.matrices(shelf, np.array([[5]]))
        least = float(np.diff(natural(mass, dynamic)[0]).min()) / (2.0 * np.pi)
        found.append(asked(replace(machine, apart=least * (1.0 - 1e-6)), shelf, "modes alike"))
    return found


def in_a_line() -> list[Asked]:
    """Mounts that stand in one line: nothing holds the turn about it."""
    found = []
    for name, way in (("along x", (1.0, 0.0)), ("askew", (0.8, 0.6))):
        row = tuple((float(s * way[0]), float(s * way[1]), 0.0) for s in (0.9, 0.3, -0.3, -0.9))
        machine = replace(_BASE, title=f"mounts in a line {name}", groups=(row,), sway=1e-2)
        found.append(_unanswerable(machine, _losses(), "mounts in a line", "its mounts stand in one line"))
    return found


def no_inertia(parts: tuple[float, ...]) -> list[Asked]:
    """A rod: its inertia about its own axis is nothing, or next to nothing."""
    found = []
    for part in parts:
        rod = replace(_BASE, title=f"inertia about x of {part:g}", inertia=(640.0 * part, 640.0, 640.0))
        found.append(_peaked(replace(rod, way="y"), _losses(), "no inertia"))
    rod = replace(_BASE, title="no inertia, every mode below 50 Hz", inertia=(0.0, 640.0, 640.0), highest=50.0)
    one = asked(rod, _losses(), "no inertia")
    return [*found, one]


def uplift() -> list[Asked]:
    """The centre of mass over the edge of the mounts, a little inside and outside of it; the lever decides."""
    found = []
    for part in (1.5, 1.0 + 1e-6, 1.0 - 1e-6):
        machine = replace(_BASE, title=f"centre at {part:.7g} of the mounts", centre=(part * _REACH, 0.0, 0.3))
        one = asked(replace(machine, sway=1.0), _losses(), "uplift")
        found.append(replace(one, named="is lifted") if part > 1.0 else one)
    return found


def free_motions() -> list[Asked]:
    """Mounts that hold nothing sideways, one mount only, and mounts that hardly hold."""
    machine = replace(_BASE, title="no stiffness sideways", sway=1e-2)
    alone = replace(_BASE, title="one mount only", groups=(((0.0, 0.0, 0.0),),), centre=(0.0, 0.0, 0.3), sway=1e-2)
    soft = replace(_BASE, title="a millionth of the stiffness sideways")
    return [
        _unanswerable(machine, _losses(shear=0.0), "free motion", "shear stiffness"),
        _unanswerable(alone, _losses(), "free motion", "it has one mount only"),
        _peaked(soft, _losses(shear=1.0), "free motion"),
    ]


def undamped() -> list[Asked]:
    """No loss at all: a resonance in the range has no bound, whatever lies between the sampled speeds."""
    k = np.linspace(0.4e6, 1.1e6, _PARTS)
    line = replace(_BASE, title="every resonance in the range", motion=LINE, sway=2e-2)
    above = np.append(k[:-1], 8.0 * _MASS * line.omega**2)
    space = replace(_BASE, title="every resonance in the range, in space", sway=2e-2)
    shelf = alike(_PARTS, k=k, static=k, loss=0.0)
    stiff = alike(_PARTS, k=above, static=above, shear=above, loss=0.0)
    return [
        asked(line, shelf, "no damping"),
        asked(replace(line, title="one part above the range"), stiff, "no damping"),
        asked(space, replace(shelf, shear=0.5 * k), "no damping"),
        asked(replace(space, title="one part above the range, in space"), stiff, "no damping"),
    ]


def stiffness_ratio(ratios: tuple[float, ...]) -> list[Asked]:
    """Stiff mounts on one side and soft ones on the other, or stiff along and soft across."""
    found = []
    for ratio in ratios:
        half = _PARTS // 2
        k = np.concatenate([np.full(half, 1e6 * ratio), np.full(half, 1e6)])
        loss = np.tile(_losses(half).loss, 2)
        least = np.concatenate([np.full(half, 2000.0), np.zeros(half)])
        most = np.concatenate([np.full(half, 9000.0), np.full(half, 3000.0)])
        shelf = alike(_PARTS, k=k, shear=0.5 * k, static=k, loss=loss, least=least, most=most)
        two = replace(
            _BASE,
            title=f"one end {ratio:g} times as stiff",
            groups=(_CORNERS[:2], _CORNERS[2:]),
            centre=(0.3, 0.0, 0.3),
        )
        found.append(_peaked(two, shelf, "stiffness ratio", (0, half + 2)))
        across = replace(_BASE, title=f"stiff along, {ratio:g} times as soft across", way="x", at=(0.2, 0.1, 0.9))
        found.append(_peaked(across, _losses(k=1e6 * np.sqrt(ratio), static=1e6 * np.sqrt(ratio),
                                             shear=1e6 / np.sqrt(ratio)), "stiffness ratio"))  # fmt: skip
    return found


def no_part() -> list[Asked]:
    """An empty shelf, parts that all carry too little, and one whose rating is its load to nine digits."""
    load = _MASS * GRAVITY / 4.0
    machine = replace(_BASE, title="empty catalogue", sway=1.0)
    empty = _unanswerable(machine, alike(0), "no part", "there is no part below the heading")
    weak = asked(replace(machine, title="no part carries the load"), alike(_PARTS, most=0.5 * load), "no part")
    hair = alike(_PARTS, most=np.append(np.full(_PARTS - 1, load * (1.0 - 1e-4)), load * (1.0 + 1e-9)))
    return [empty, weak, asked(replace(machine, title="rating a billionth above the load"), hair, "no part")]


def _unanswerable(machine: Machine, shelf: Shelf, family: str, named: str) -> Asked:
    case = Case(machine.title, "", UNANSWERABLE, np.nan, "rank of the stiffness, or no row", family)
    return Asked(case, machine, shelf, named)
