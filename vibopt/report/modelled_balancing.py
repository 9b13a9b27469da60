"""A rotor of discs as a balancing job: what a weight on each disc does, by the model instead of trial runs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from math import degrees
from typing import Any

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray
from vibopt.errors import InputError
from vibopt.excitations.excitation import Excitation
from vibopt.mechanics.built import Motion
from vibopt.mechanics.harmonic import motion
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import Model
from vibopt.mechanics.orbits import spun
from vibopt.records import dataclass
from vibopt.report.what_to_build import machine_in
from vibopt.responses import Response
from vibopt.responses.motion import Displacement
from vibopt.responses.response import HarmonicResponse
from vibopt.scene.assemble import model_of
from vibopt.scene.check_bearings import in_planes
from vibopt.scene.drives import bands_for, names_for
from vibopt.scene.scene import Design, Scene
from vibopt.signals import Band
from vibopt.verify.routes import rounded

_PARTS, _SAME, _SURE, _APART = 8, 1e-8, 1e-5, 0.02
"""Speeds at which a range is looked at, beside its peaks; part of the greatest by which two routes may differ, and of
what they tell where rounding moves it as far; part by which speeds differ, as runs of a meter at nearly one speed count
as repeated."""
_TRIED, _BETWEEN, _COVERED, _MORE, _LEAST_APART = 201, 1.03, 1e-3, 24, 0.0101
"""Speeds of a range at which a bound is looked at, beside those near poles; bound from which on a speed is added, what
covers speeds between those, most that are added, and the part by which they differ."""
_IN_VAIN, _GAIN = 4, 0.995
"""Speeds that are added at most while the greatest bound stays above a part of what it was."""
_SQUARES, _EVERY, _ROUNDING, _UNSURE, _LOOSE, _AT_ONCE = 20, 5, 1e-9, 1e9, 0.7, 1_000_000
"""Least squares that approach a least sum, one in how many is looked at, the least part of it that counts, condition
from which on nothing is sure, the part of a limit below which it is left as it is, and said so, and numbers of an array
that is held at once."""
_SENSES, _DIRECTIONS = {1: "forward", -1: "backward"}, (6, 12)
"""Senses of the sensors of an ellipse, and directions along which it is looked at: at speeds, and between them."""
_RPM = 30.0 / np.pi
_SENSORS = 'no displacement is asked, and balancing reads one. Add a measure with response = "displacement".'
_PLANES = "no rotor has a disc that could take a weight. Add one to its discs."
_SPEEDS = "nothing says at which speeds to balance. Add an unbalance with its speed."
_ONE = "has several unbalances, and nothing says at which angles they stand. Write one, and the others in its also."
_CONVENTIONS = {
    "phase": "lead",
    "readings": "phase",
    "angles": "with rotation",
    "detector": "pk",
    "zero": "unbalances of the model",
}


@dataclass(frozen=True, slots=True)
class Probe:
    """A sensor at a place: of its circle, or of the forward (1) or the backward (-1) whirl of its ellipse."""

    point: str
    sense: int = 0

    @property
    def name(self) -> str:
        return f"{self.point}_{_SENSES[self.sense]}" if self.sense else self.point

    def of(self, motion: Motion) -> ComplexArray:
        moved = motion.points[self.point]
        return 0.5 * (moved[0] + 1j * self.sense * moved[1]) if self.sense else moved


def balancing_document(design: Design) -> dict[str, Any]:
    """Planes are the discs, sensors the points whose displacement is asked; as found are the unbalances of the file.

    Between bearings that differ in both planes each point has one of its forward and one of its backward whirl, which
    add up to the greater half axis.  Speeds are those at which a displacement is asked: of a range eight, where one
    that was asked is greatest, and those that keep it in hand between them.  Limits are tighter by what any weights
    that keep them at all of these speeds may do at others.

    Raises
    ------
    InputError
        There is no design, not one unbalance, no displacement asked, a limit that a balancing job does not have, or a
        whirl without end.
    """
    scene = design.scene
    machine, sensors, planes, unbalance = _modelled(design)
    senses = list(_SENSES) if in_planes(scene) else [0]
    places = {point: [Probe(point, sense) for sense in senses] for point in sensors}
    probes = [probe for own in places.values() for probe in own]
    speeds, part = held_between(scene, machine, planes, sensors, places, _speeds(scene, machine))
    effects = {plane: _effects(scene, design, machine, plane, probes, speeds) for plane in planes}
    found = sum(
        unbalance.swung * share * _effects(scene, design, machine, place, probes, speeds)
        for place, share in unbalance.acts.items()
    )
    written = [f"{speed * _RPM:.15g} rpm" for speed in speeds]
    runs = [
        {
            "name": f"as modelled, {speed * _RPM:.5g} rpm",
            "speed": text,
            "readings": {probe.name: _phasor(one, 1e3, "mm") for probe, one in zip(probes, row, strict=True)},
        }
        for speed, text, row in zip(speeds, written, np.asarray(found), strict=True)
    ]
    influence = [
        {"speed": text, "sensor": probe.name, "plane": plane, "value": _phasor(effects[plane][i, j], 1e-3, "mm/(g mm)")}
        for i, text in enumerate(written)
        for j, probe in enumerate(probes)
        for plane in planes
    ]
    size = part if part >= _LOOSE else 1.0
    limits = {
        key: row
        for point, (first, *_) in places.items()
        for name in sensors[point]
        for key, row in _limits(scene, name, first, speeds, size)
    }
    added = {second.name: {"added_to": first.name} for first, *rest in places.values() for second in rest}
    told = _told(part, bool(limits), bool(added))
    return {
        "title": f"Balancing of {scene.title}, modelled",
        **({"statement": told} if told else {}),
        "conventions": _CONVENTIONS,
        **({"sensors": {probe.name: added.get(probe.name, {}) for probe in probes}} if added else {}),
        "planes": {plane: {"unbalance": {"from": "0 g mm", "to": "1 kg m"}} for plane in planes},
        "runs": runs,
        "influence": influence,
        **({"limits": limits} if limits else {}),
        "goal": {"minimise": "residual", "combine": "worst"},
    }


def _told(part: float, limited: bool, added: bool) -> str:
    """What limits hold for, and what sensors read, in words; "" where both are as in the file."""
    words = []
    if limited and _LOOSE <= part < 1.0:
        tighter = f"Limits are {1e2 * (1.0 - part):.1f} % tighter here"
        words.append(f"{tighter}, so that they hold at every speed of their ranges.")
    if limited and part < _LOOSE:
        words.append("What is left between the speeds of the runs is not known.")
    if added:
        words.append("Forward and backward whirl of a place add up to the greater half axis of its orbit.")
    return " ".join(words)


def _modelled(design: Design) -> tuple[Machine, dict[str, list[str]], list[str], Excitation]:
    """The machine as built, its points with their limits, its discs, and the one unbalance that shakes it."""
    scene, machine = design.scene, machine_in(design)
    if machine is None:
        raise InputError(f"{scene.name}: there is no design ({design.status}), so no rotor to balance.")
    for row in (row for row in (*design.limits.values(), *design.measures.values()) if row.unsteady):
        raise InputError(f"{scene.name}: {row.unsteady}.")
    sensors, planes = _sensors(scene), [disc.name for rotor in scene.rotors.values() for disc in rotor.discs]
    there = {_SENSORS: sensors, _PLANES: planes, _SPEEDS: scene.excitations}
    for lacks in (words for words, collection in there.items() if not collection):
        raise InputError(f"{scene.name}: {lacks}")
    (name, excitation), *others = scene.excitations.items()
    if excitation.anywhere or len(excitation.loose) > 1:
        raise InputError(
            f"{scene.name}: excitations.{name} is an unbalance at places or angles that nobody knows, so nothing says "
            "what to take back. Leave or_on and angles out."
        )
    if others:
        raise InputError(f"{scene.name}: {_ONE}")
    return machine, sensors, planes, excitation


def _sensors(scene: Scene) -> dict[str, list[str]]:
    """Points whose displacement is asked, each with the names of its limits."""
    found: dict[str, list[str]] = {}
    for name, response in _asked(scene):
        limits = name in scene.limits
        if type(response) is Displacement and not (limits and response.at_most is None):
            found.setdefault(response.of, []).extend([name] if limits else [])
        elif limits and isinstance(response, HarmonicResponse):
            raise InputError(
                f"{scene.name}: limits.{name} asks for the {response.response}, and a balancing job limits "
                "displacements from above. Leave it out, or write the displacement that belongs to it."
            )
    return found


def _asked(scene: Scene) -> list[tuple[str, Response]]:
    goal = [] if scene.goal is None else [("", scene.goal.response)]
    return [*scene.limits.items(), *((f"measures.{key}", measure) for key, measure in scene.measures.items()), *goal]


def held_between(
    scene: Scene,
    machine: Machine,
    planes: list[str],
    sensors: Mapping[str, list[str]],
    places: Mapping[str, list[Probe]],
    speeds: FloatArray,
) -> tuple[FloatArray, float]:
    """More speeds [rad/s], and the part of its limits to keep at all of them so that each holds at every speed.

    A whirl c(w) u at a speed between is sum_k l_k (a_k u) of those a_k u at the speeds that are listed wherever
    sum_k l_k a_k = c, so that it is at most sum_k |l_k| times what bounds these, whatever the unbalances u are.  Of
    forward and backward whirl, whose sum is bounded, the greater |l_k| counts.  The least of these sums is approached
    by weighted least squares, of which each is a bound; where it is greatest a speed is added.
    """
    ((_, imbalance),) = scene.excitations.items()
    columns = [{name: 1.0 + 0j} for name in planes] + [imbalance.acts] * (not {*imbalance.acts} <= {*planes})
    asked = [
        (probes, _bound(scene, name), _bands(scene, name)) for at, probes in places.items() for name in sensors[at]
    ]

    def rows(speeds: FloatArray, each: Iterable[FloatArray]) -> ComplexArray:
        """What a unit of each column does at those of the speeds that each limit has, as a part of it, by senses."""
        units = ({place: (part * speeds**2).astype(complex) for place, part in column.items()} for column in columns)
        moved = [machine.shake(speeds, unit, {}) for unit in units]
        found = [
            np.array([[probe.of(motion) for motion in moved] for probe in probes], dtype=complex).T[
                np.searchsorted(speeds, own)
            ]
            / most
            for (probes, most, _), own in zip(asked, each, strict=True)
        ]
        return np.asarray(np.concatenate(found).swapaxes(1, 2), dtype=complex)

    def listed(speeds: FloatArray) -> ComplexArray:
        return rows(speeds, (speeds[_within(speeds, bands)] for _, _, bands in asked))

    tried = [_tried(bands, machine.known_poles) for _, _, bands in asked]
    if not any(map(len, tried)):
        return speeds, 1.0
    at, kept, held = np.concatenate(tried), speeds, listed(speeds)
    between, reach, tops = rows(np.unique(at), tried), np.full(len(at), np.inf), list[float]()
    while True:
        above = reach > _BETWEEN  # a row more only lowers them
        reach[above] = np.minimum(reach[above], _reach(held, between[above]))
        apart = np.abs(at[:, None] - kept).min(axis=1) > _LEAST_APART * at
        worst = int(np.where(apart, reach, 0.0).argmax())
        tops.append(float(reach.max()))
        idle = len(tops) > _IN_VAIN and tops[-1] > _GAIN * tops[-1 - _IN_VAIN]  # beside a speed there is room for none
        if not apart[worst] or reach[worst] <= _BETWEEN or idle or len(kept) >= len(speeds) + _MORE:
            return kept, 1.0 / (_COVERED + tops[-1])
        kept, held = np.sort([*kept, at[worst]]), np.concatenate([held, listed(at[worst : worst + 1])])


def _tried(bands: list[Band], poles: ComplexArray) -> FloatArray:
    """Speeds of ranges [rad/s]: evenly, and close to each pole."""
    found = [np.linspace(band.low, band.high, _TRIED)[1:] for band in bands if not band.is_point]
    near = [pole.real + abs(pole.imag) * np.linspace(-6.0, 6.0, 41) for pole in poles]
    close = np.concatenate([*near, np.zeros(0)])
    return np.unique(np.concatenate([*found, close[_within(close, bands)]])) if found else np.zeros(0)


def _within(speeds: FloatArray, bands: list[Band]) -> BoolArray:
    inside = [(speeds >= band.low) & (speeds <= band.high) & (speeds > 0.0) for band in bands]
    return np.asarray(np.any(inside, axis=0))


def _reach(rows: ComplexArray, between: ComplexArray) -> FloatArray:
    """Bound of sum_s |c_s u| of each c between (n, n_senses, n_columns), where sum_s |a_s u| <= 1 of all rows a.

    Infinite where the rows (n_rows, n_senses, n_columns) do not bound u; what they leave of c is counted by how far
    they bound it.  A sum of two is the greatest along all directions of its ellipse, of which some are looked at.
    """
    if rows.shape[1] == 1:
        return _along(rows[:, 0], between[:, 0], np.ones((1, 1), dtype=complex))
    few, many = (np.pi / count * np.arange(count) for count in _DIRECTIONS)
    turns, looks = (np.exp(1j * np.outer(angles, [-1.0, 1.0])) for angles in (few, many))
    seen = _along((turns @ rows).reshape(-1, rows.shape[2]), (looks @ between).reshape(-1, rows.shape[2]), turns)
    return np.asarray(seen.reshape(len(between), -1).max(axis=1) / np.cos(0.5 * many[1]))


def _along(rows: ComplexArray, between: ComplexArray, turns: ComplexArray) -> FloatArray:
    """The same along one direction each (n_columns,), of rows that follow each other by `turns` (n_turns, n_senses)."""
    right, turn = np.linalg.qr(rows)
    if len(turn) < rows.shape[1] or np.linalg.cond(turn / np.linalg.norm(turn, axis=0)) > _UNSURE:
        return np.full(len(between), np.inf)
    squares = np.ascontiguousarray(right[:, :, None] * right.conj()[:, None]).reshape(len(rows), -1).view(float)
    turned = np.asarray(np.linalg.solve(turn.T, between.T).T, dtype=complex)
    parts = np.array_split(turned, len(turned) * len(rows) // _AT_ONCE + 1)
    return np.concatenate([_least_sums(right, squares, part, turns) for part in parts])


def _least_sums(right: ComplexArray, squares: FloatArray, turned: ComplexArray, turns: ComplexArray) -> FloatArray:
    """Bound of the least sum |l_k| where sum l_k right_k is one of (n, n_columns), by weighted squares.

    Of the senses of one place the greater share counts.
    """
    weight, least, many = np.ones((len(turned), len(right))), np.full(len(turned), np.inf), right.shape[1]
    for count in range(1, _SQUARES + 1):
        normal = (weight @ squares).view(complex).reshape(-1, many, many)
        share = weight * (np.linalg.solve(normal, turned[..., None])[..., 0] @ right.conj().T)
        if not count % _EVERY:
            of_senses = share.reshape(len(turned), -1, len(turns)) @ turns
            lost = np.linalg.norm(turned - share @ right, axis=1) * np.sqrt(len(right))
            least = np.minimum(least, np.abs(of_senses).max(axis=2).sum(axis=1) + lost)
        weight = np.abs(share)
        weight += _ROUNDING * weight.sum(axis=1)[:, None]
    return least


def _bands(scene: Scene, name: str) -> list[Band]:
    response = scene.limits[name]
    assert isinstance(response, Displacement)
    return [band for one in names_for(scene, response) for band in bands_for(scene, response, one)]


def _bound(scene: Scene, name: str) -> float:
    bound = scene.limits[name].at_most
    assert bound is not None
    return float(bound.value)


def _limits(
    scene: Scene, name: str, probe: Probe, speeds: FloatArray, part: float
) -> Iterator[tuple[str, dict[str, str]]]:
    """A part of a limit on what is left at a sensor; at each of its speeds where it does not speak of all."""
    asked = speeds[_within(speeds, _bands(scene, name))].tolist()
    most = f"{_bound(scene, name) * part * 1e3:.15g} mm pk"
    row = {"response": "residual", "at": probe.name, "at_most": most}
    if len(asked) == len(speeds):
        yield name, row
        return
    for one in asked:
        yield f"{name}_at_{one * _RPM:.5g}".replace(".", "_"), {**row, "speed": f"{one * _RPM:.15g} rpm"}


def _speeds(scene: Scene, machine: Machine) -> FloatArray:
    """Where a plan is looked at first [rad/s], ascending, no two of them nearly the same.

    A whirl w^2 / |(w - p)(w + p*)| of one pole p is greatest at |p|^2 / sqrt(Re p^2).
    """
    ((name, imbalance),) = scene.excitations.items()
    bands = set(imbalance.own_bands())
    for _, response in _asked(scene):
        if type(response) is Displacement:
            bands |= set(bands_for(scene, response, name))
    square = np.sort((machine.known_poles**2)[machine.known_poles.real > 0.0])
    peaks = (np.abs(square) / np.sqrt(np.maximum(square.real, 1e-300))).tolist()
    points, even = [band.low for band in bands if band.is_point], []
    for band in (one for one in bands if not one.is_point):
        points += [peak for peak in peaks if band.low < peak < band.high]
        even += np.linspace(band.low, band.high, _PARTS + 1)[::-1].tolist()
    kept: list[float] = []
    for speed in [*points, *even]:
        if speed > 0.0 and all(abs(speed - value) > _APART * value for value in kept):
            kept.append(speed)
    return np.sort(kept)


def _effects(
    scene: Scene, design: Design, machine: Machine, place: str, probes: list[Probe], speeds: FloatArray
) -> ComplexArray:
    """Displacement at probes per unbalance at a place, (n_speeds, n_probes) [m per kg m], agreed on by both routes."""
    model, chosen = model_of(scene), design.scene.named(design.x)
    x = np.array([chosen[variable.path] for variable in scene.variables])
    shaken = machine.shake(speeds, {place: (speeds**2).astype(complex)}, {})
    other, one = np.array([probe.of(shaken) for probe in probes]).T, _in_model(model, x, place, probes, speeds)
    apart, size, known = np.abs(one - other), np.abs(other), bool(np.all(np.isfinite(other)))
    for i, j in np.argwhere(apart > _SAME * size.max()) if known else ():
        known &= bool(apart[i, j] <= min(_SURE * size[i, j], _rounded(model, x, place, probes[j], speeds[i])))
    if not known:
        raise InputError(
            f"{scene.name}: what an unbalance on {place} does is not known: at a critical speed without damping a "
            "whirl has no end. Give the bearings a damping, or look at other speeds."
        )
    return other


def _in_model(model: Model, x: FloatArray, place: str, probes: list[Probe], speeds: FloatArray) -> ComplexArray:
    """The same by the model."""
    lines, load = np.array([model.points[probe.point] for probe in probes]), model.points[place].astype(complex)
    if not model.bearings:
        return np.asarray(motion(model, model.values(x), load, speeds) @ lines.T * speeds[:, None] ** 2)
    forward, backward = spun(model, x).seen(lines[:, : model.n_free], load[: model.n_free], speeds)
    ahead = np.array([probe.sense > 0 for probe in probes])
    return np.asarray(np.where(ahead, forward, backward) * speeds[:, None] ** 2)


def _rounded(model: Model, x: FloatArray, place: str, probe: Probe, speed: float) -> float:
    """How far rounding may move what a probe reads of a unit of unbalance; nothing where no adjoint tells it."""
    if model.bearings:
        return 0.0
    p, row = model.values(x), model.points[probe.point]
    u = motion(model, p, model.points[place].astype(complex), np.array(speed))
    return speed**2 * rounded(model, p, u, row, speed)


def _phasor(value: complex, times: float, unit: str) -> str:
    """With all digits, its angle counted ahead in the sense of rotation."""
    return f"{abs(value) * times:.15g} {unit} @ {degrees(np.angle(value)):.15g} deg"
