"""Studies in the charts: one fact of a mount varied, the best mount at each value, and where designs begin.

One mass on one mount: which mounts hold its floor and its start-up is told by formulas, so that the stiffest of them
and the value from which on there is one are known to rounding.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.charts.machines import one_mass
from vibopt.charts.scene_rivals import method as rival
from vibopt.charts.trial import DEFAULT, Case, Said, Trial, judged
from vibopt.charts.verdicts import FEASIBLE, REFUSES
from vibopt.program.pose import pose
from vibopt.records import cached_property, dataclass
from vibopt.scene.read import from_text, with_changes
from vibopt.scene.scene import Scene
from vibopt.solve.branch import Judge
from vibopt.solve.ranges import closed

POINTS = 9
"""Values of a study."""
_WIDE = 1e4
"""Ends of stiffness and damping over those of the machine's own scale."""
_CLOSE = 1e-7
"""Distance of the two sides up to which a rival halves, as a part."""
START_UP, FLOOR, FORCE = "limits.start_up.at_most", "limits.floor.at_most", "excitations.shaft.amplitude"
FACTS = {START_UP: "m", FLOOR: "N", FORCE: "N"}
"""What is varied, and its unit."""


@dataclass(frozen=True)
class Study:
    """A machine of so much mass [kg] at up to so many rad/s, and one of its facts from a value to another [SI].

    force
        Amplitude [N], which grows with the square of the speed or not.
    floor, start_up
        Most force on the floor at full speed [N], and most amplitude on the way there [m].
    """

    mass: float
    top: float
    force: float
    growing: bool
    floor: float
    start_up: float
    fact: str
    ends: tuple[float, float]

    def at(self, value: float) -> Study:
        """With the fact at a value."""
        changed: dict[str, Any] = {{START_UP: "start_up", FLOOR: "floor", FORCE: "force"}[self.fact]: value}
        return replace(self, **changed)

    @cached_property
    def values(self) -> FloatArray:
        """Those that are asked, (POINTS,)."""
        return np.linspace(*self.ends, POINTS)

    @property
    def text(self) -> str:
        """The problem file."""
        scale = self.mass * self.top**2
        spring, dash = (
            f'{{ from = "{value / _WIDE!r} {unit}", to = "{value * 10.0!r} {unit}" }}'
            for value, unit in ((scale, "N/m"), (scale / self.top, "N s/m"))
        )
        return one_mass(
            mass=f'"{self.mass!r} kg"', stiffness=spring, damping=f"damping = {dash}",
            force=f'kind = "force"\namplitude = "{self.force!r} N"\nspeed = "{self.top!r} rad/s"\n'
            f'varies = "{"speed^2" if self.growing else "constant"}"',
            limits=f'[limits.floor]\nresponse = "transmitted_force"\ninto = "ground"\nat_most = "{self.floor!r} N"\n\n'
            f'[limits.start_up]\nresponse = "displacement"\nof = "machine"\nover = "0..{self.top!r} rad/s"\n'
            f'at_most = "{self.start_up!r} m"',
        )  # fmt: skip

    def peak(self, stiffness: float) -> float:
        """Least start-up [m] that a mount of this stiffness can have whose floor holds; infinite where it cannot.

        The floor bounds the damping, (F^2 - T^2)(k^2 + w^2 c^2) + 2 T^2 m w^2 k <= T^2 m^2 w^4, and more damping moves
        less on the way; the greatest of one mass is in every textbook.
        """
        allowed, load, w = self.floor, self.force, self.top
        left = (allowed * self.mass * w**2) ** 2 - 2.0 * allowed**2 * self.mass * w**2 * stiffness
        left -= (load**2 - allowed**2) * stiffness**2
        if left <= 0.0:
            return math.inf
        damping = math.sqrt(left / (load**2 - allowed**2)) / w
        own = math.sqrt(stiffness / self.mass)
        ratio = damping / (2.0 * math.sqrt(stiffness * self.mass))
        inner = 2.0 * ratio**2 < 1.0
        if self.growing:
            at = min(w / own, 1.0 / math.sqrt(1.0 - 2.0 * ratio**2) if inner else math.inf)
            size = at**2 / math.hypot(1.0 - at**2, 2.0 * ratio * at)
            return load / (w**2 * self.mass) * size
        return load / stiffness / (2.0 * ratio * math.sqrt(1.0 - ratio**2) if inner else 1.0)

    @cached_property
    def least(self) -> tuple[float, float]:
        """The least start-up of all mounts whose floor holds [m], and the stiffness of that one [N/m]."""
        from scipy.optimize import minimize_scalar

        stiffest = self.mass * self.top**2 / (1.0 + self.force / self.floor)
        low = math.log(self.mass * self.top**2 / _WIDE)
        ys = np.linspace(low, math.log(stiffest), 400)
        place = int(np.argmin([self.peak(math.exp(y)) for y in ys.tolist()]))
        found = minimize_scalar(
            lambda y: self.peak(math.exp(y)), bounds=(ys[max(place - 1, 0)], ys[min(place + 1, 399)]), method="bounded",
            options={"xatol": 1e-12},
        )  # fmt: skip
        return float(found.fun), math.exp(found.x)

    @property
    def stiffest(self) -> float:
        """The stiffest mount that holds both [N/m]; nan without one."""
        from scipy.optimize import brentq

        best, at = self.least
        if best > self.start_up:
            return math.nan
        end = self.mass * self.top**2 / (1.0 + self.force / self.floor) * (1.0 - 1e-15)
        if self.peak(end) <= self.start_up:
            return end
        over = partial(_over, self)
        return float(math.exp(brentq(over, math.log(at), math.log(end), xtol=1e-15, rtol=1e-14)))

    @cached_property
    def truth(self) -> FloatArray:
        """Where designs begin or end, then the stiffest mount at each value, nan without one, (1 + POINTS,)."""
        from scipy.optimize import brentq

        edge = brentq(lambda v: math.log(self.at(v).least[0] / self.at(v).start_up), *self.ends, rtol=1e-14)
        return np.array([edge, *(self.at(value).stiffest for value in self.values.tolist())])


def _over(study: Study, y: float) -> float:
    return min(math.log(study.peak(math.exp(y)) / study.start_up), 50.0)


def _vibopt(study: Study) -> Said:
    from vibopt.study.sweep import sweep

    unit = FACTS[study.fact]
    low, high = study.ends
    found = sweep(from_text(study.text, name="study"), study.fact, f"{low!r} {unit}..{high!r} {unit}", POINTS)
    edges = [edge for edge in found.boundaries if edge.of_feasibility]
    best = [point.goal.value if point.good and point.goal is not None else math.nan for point in found.points]
    proven = {point.status for point in found.points} <= {"optimal", "infeasible"}
    if len(edges) != 1:
        return Said("unproven", f"{len(edges)} places where designs begin or end")
    return Said(
        "optimal" if proven else "feasible", "every point, and the place between", np.array([edges[0].at, *best])
    )


def _halved(study: Study, name: str) -> Said:
    """Every value asked of a solver, and the place between the last two of different answers halved."""
    scene = from_text(study.text, name="study")
    unit = FACTS[study.fact]

    def best(value: float) -> float:
        return _stiffest(with_changes(scene, {study.fact: f"{value!r} {unit}"}), name)

    found = [best(value) for value in study.values.tolist()]
    holds = np.isfinite(found)
    turns = np.flatnonzero(holds[1:] != holds[:-1])
    if len(turns) != 1:
        return Said("unproven", f"{len(turns)} places where designs begin or end")
    place = int(turns[0])
    low, high = study.values[place : place + 2].tolist()
    while high - low > _CLOSE * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if math.isfinite(best(middle)) == holds[place] else (low, middle)
    return Said("feasible", f"{name} at every value, and halved", np.array([0.5 * (low + high), *found]))


def _direct(study: Study, name: str) -> Said:
    """The place as the least of the limit's own response, then every value on the good side asked of a solver."""
    if study.fact == FORCE:
        return Said(REFUSES, "takes a limit that is varied")
    scene = from_text(study.text, name="study")
    begun, goal = study.text[: study.text.index("[goal]")], _LEAST[study.fact].replace("TOP", repr(study.top))
    before, _, behind = begun.partition(f"[{study.fact.removesuffix('.at_most')}]")
    program = closed(pose(from_text(f"{before}{behind.partition(chr(10) * 2)[2]}{goal}", name="study")))
    found = rival(name).solve(program)
    if found.x is None or found.status not in ("optimal", "feasible"):
        return Said("unproven", found.claim)
    edge = Judge(program).goal(found.x).value
    unit = FACTS[study.fact]
    best = [_stiffest(with_changes(scene, {study.fact: f"{value!r} {unit}"}), name) if value > edge else math.nan
            for value in study.values.tolist()]  # fmt: skip
    return Said("feasible", f"{name} at every value that has a mount", np.array([edge, *best]))


_LEAST = {
    START_UP: '[goal]\nminimise = "displacement"\nof = "machine"\nover = "0..TOP rad/s"\n',
    FLOOR: '[goal]\nminimise = "transmitted_force"\ninto = "ground"\n',
}


def _stiffest(scene: Scene, name: str) -> float:
    program = closed(pose(scene))
    found = rival(name).solve(program)
    if found.x is None or found.status not in ("optimal", "feasible"):
        return math.nan
    return float(np.asarray(found.x)[next(i for i, axis in enumerate(program.axes) if axis.path.endswith("stiffness"))])


def judge(case: Case, study: Study, method: str, said: Said) -> Trial:
    """By formulas: the greatest part by which the place or a mount is off; a mount where there is none is broken."""
    if said.answer is None:
        return judged(case, method, said, np.nan, np.nan)
    given, true = np.asarray(said.answer), study.truth
    both = np.isfinite(given) & np.isfinite(true)
    wrong = bool((np.isfinite(given) != np.isfinite(true)).any())
    over = (given[1:] / true[1:] - 1.0)[both[1:]].max(initial=0.0)
    off = np.abs(given / true - 1.0)[both].max(initial=0.0)
    return judged(case, method, said, math.inf if wrong else max(float(over), 0.0), float(off))


METHODS: Mapping[str, Callable[[Study], Said]] = {
    DEFAULT: _vibopt,
    **{f"{name}, halved": partial(_halved, name=name)
       for name in ("slsqp 50", "slsqp 200", "cvxpy 1e-08")},
    **{f"{name}, direct": partial(_direct, name=name) for name in ("slsqp 200", "slsqp exchange 1e-11")},
}  # fmt: skip
QUICK_METHODS = {name: METHODS[name] for name in (DEFAULT, "slsqp 200, halved", "slsqp exchange 1e-11, direct")}


def drawn(rng: np.random.Generator, name: str) -> tuple[Case, Study]:
    """The limit of start-up, that of the floor, or the force of a random machine; somewhere between, designs begin."""
    mass, top = float(10.0 ** rng.uniform(1.0, 3.5)), float(rng.uniform(60.0, 600.0))
    force = float(10.0 ** rng.uniform(1.0, 4.0))
    study = Study(
        mass, top, force, bool(rng.integers(2)), force * float(rng.uniform(0.1, 0.6)), 1.0, START_UP, (0.0, 0.0)
    )
    study = replace(study, start_up=study.least[0], fact=str(rng.choice(list(FACTS))))
    edge = {START_UP: study.start_up, FLOOR: study.floor, FORCE: study.force}[study.fact]
    study = replace(study, ends=(edge * float(rng.uniform(0.6, 0.95)), edge * float(rng.uniform(1.05, 1.4))))
    return Case(name, f"# {study.fact} from {study.ends[0]!r} to {study.ends[1]!r}\n{study.text}", FEASIBLE, 1.0,
                "formulas of one mass", "studies"), study  # fmt: skip
