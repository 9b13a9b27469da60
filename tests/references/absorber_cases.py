"""The worked absorber cases solved without vibopt, by brute force.

Every machine is written down here as a dynamic stiffness, absorbers as the force they give back. A dense
grid of designs (six numbers: differential evolution) over a dense grid of speeds finds the region of the
best design; from there a local search holds every limit at a set of speeds, to which the worst speeds of
ten thousand are added until none is worse. Where the best design is flat that leaves five digits; the rest come
from the equations that it solves: peaks at one height, and slopes that balance. All numbers in SI; amplitudes
are peak.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from math import pi, sqrt
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import mmread
from scipy.linalg import eigh
from scipy.optimize import Bounds, differential_evolution, minimize, minimize_scalar, root

Array = Any
Answers = dict[str, Any]
Levels = Callable[[Array, Array], Array]
"""Designs (n_numbers, n_designs) and speeds (n_speeds,) to responses over limits (n_limits, n_designs, n_speeds)."""


@dataclass(frozen=True)
class Case:
    """What is chosen within which ends, over which speeds, and how near to its limit every response comes.

    `goal` gives what is to be smallest; without it that is the highest level itself.
    """

    ends: tuple[tuple[float, float], ...]
    bands: tuple[tuple[float, float], ...]
    levels: Levels
    goal: Callable[[Array], Array] | None = None

    def speeds(self, count: int) -> Array:
        """A grid of all bands that holds their ends."""
        return np.concatenate([np.linspace(low, high, count) for low, high in self.bands])

    def highest(self, designs: Array, speeds: Array) -> Array:
        """Highest level of each design."""
        return self.levels(designs, speeds).max(axis=(0, 2))

    def badness(self, designs: Array) -> Array:
        """What the first search makes small: the goal, and much more where a limit is broken."""
        top = self.highest(designs, self.speeds(120))
        if self.goal is None:
            return top
        whole = self.goal(np.array(self.ends)[:, 1])
        return self.goal(designs) / whole + np.where(top > 1, 1 + top, 0)


def scaled(case: Case, points: Array) -> Array:
    """Designs from numbers between 0 and 1, by equal steps of the logarithm."""
    low, high = np.log(np.array(case.ends)).T
    return np.exp(low + (high - low) * points.T).T


def grid(case: Case, count: int = 25) -> Array:
    """The best of all designs on a grid of the box; numbers between 0 and 1."""
    axes = np.meshgrid(*[np.linspace(0, 1, count)] * len(case.ends), indexing="ij")
    points = np.array([axis.ravel() for axis in axes])
    badness = [case.badness(scaled(case, part)) for part in np.array_split(points, 1 + points.shape[1] // 500, axis=1)]
    return points[:, np.argmin(np.concatenate(badness))]


def evolved(case: Case) -> Array:
    """The best design of a differential evolution, which gives the same one every time."""

    def badness(points: Array) -> Array:
        return case.badness(scaled(case, points))

    found = differential_evolution(
        badness,
        Bounds(np.zeros(len(case.ends)), np.ones(len(case.ends))),
        vectorized=True,
        updating="deferred",
        popsize=12,
        maxiter=250,
        tol=1e-10,
        polish=False,
        rng=1,
    )
    return found.x


def refined(case: Case, start: Array) -> tuple[float, Array]:
    """The least goal near a start, and the design there: worst speeds are added until none is worse."""
    fine, held = case.speeds(10_000), case.speeds(40)
    top = case.highest(scaled(case, start)[:, None], fine)[0]
    point = np.append(start, 1.0 if case.goal else top)
    whole = case.goal(np.array(case.ends)[:, 1]) if case.goal else top
    for _ in range(12):
        point = held_at(case, point, held, whole)
        levels = case.levels(scaled(case, point[:-1])[:, None], fine)[:, 0]
        worst = fine[np.argmax(levels, axis=1)]
        if levels.max() <= point[-1] * (1 + 1e-10):
            break
        inner = (levels[:, 1:-1] >= levels[:, :-2]) & (levels[:, 1:-1] >= levels[:, 2:])
        held = np.unique(np.concatenate([held, worst, fine[1:-1][inner.any(axis=0)]]))
    design = scaled(case, settled(case, point[:-1]))
    return float(case.goal(design) if case.goal else case.highest(design[:, None], fine)[0]), design


Height = tuple[int, float, bool]
"""A level that binds: which, its speed, and whether that is a peak that moves with the design."""


def binding(case: Case, point: Array) -> list[Height]:
    """The local maxima of all levels that stand on the limit, or as high as the highest."""
    fine = case.speeds(10_000).reshape(len(case.bands), -1)
    levels = case.levels(scaled(case, point)[:, None], fine.ravel())[:, 0]
    top = 1.0 if case.goal else levels.max()
    found = []
    for which, level in enumerate(levels):
        for speeds, heights in zip(fine, level.reshape(fine.shape), strict=True):
            padded = np.pad(heights, 1)
            tops = (heights >= padded[:-2]) & (heights > padded[2:]) & (heights > top * (1 - 1e-5))
            last = len(speeds) - 1
            found += [(which, float(speeds[at]), 0 < at < last) for at in np.flatnonzero(tops)]
    return found


@dataclass(frozen=True)
class Conditions:
    """What holds at the best design: the levels that bind are at one height, and their slopes balance the goal's.

    `point` is a design nearly there, numbers between 0 and 1; what rests on an end of its range stays there.
    """

    case: Case
    point: Array
    heights: list[Height]

    @property
    def inside(self) -> Array:
        """Which numbers are free."""
        return np.flatnonzero((self.point > 1e-6) & (self.point < 1 - 1e-6))

    def whole(self, at: Array) -> Array:
        """A design of given free numbers, all of it."""
        full = self.point.copy()
        full[self.inside] = at
        return full

    def level(self, at: Array, which: int, speed: float) -> float:
        design = scaled(self.case, self.whole(at))
        return float(self.case.levels(design[:, None], np.array([speed]))[which, 0, 0])

    def peak(self, at: Array, height: Height) -> tuple[float, float]:
        """A level at its top, and the speed there."""
        which, speed, moves = height
        if not moves:
            return self.level(at, which, speed), speed
        found = minimize_scalar(
            lambda w: -self.level(at, which, w),
            bounds=(speed * (1 - 1e-3), speed * (1 + 1e-3)),
            method="bounded",
            options={"xatol": 1e-11 * speed},
        )
        return -found.fun, float(found.x)

    def pulls(self, at: Array) -> tuple[Array, Array]:
        """Heights, and their slopes (n_heights, n_free)."""
        tops = [self.peak(at, one) for one in self.heights]
        slopes = [
            sloped(partial(self.level, which=one[0], speed=top[1]), at)
            for one, top in zip(self.heights, tops, strict=True)
        ]
        return np.array([top[0] for top in tops]), np.array(slopes)

    def toward(self, at: Array) -> Array:
        """Slope of the goal, its greatest part one; none where the level itself is the goal."""
        goal = self.case.goal
        if goal is None:
            return np.zeros(len(at))
        own = sloped(lambda here: float(goal(scaled(self.case, self.whole(here)))), at)
        return own / np.abs(own).max()

    def __call__(self, unknown: Array) -> Array:
        """What is zero, of free numbers, weights of the heights, and the height of all."""
        size = len(self.inside)
        at, weights, top = unknown[:size], unknown[size:-1], unknown[-1]
        heights, slopes = self.pulls(at)
        closing = top - 1 if self.case.goal else weights.sum() - 1
        return np.concatenate([self.toward(at) + slopes.T @ weights, heights - top, [closing]])


def sloped(value: Callable[[Array], float], at: Array) -> Array:
    """Slope of a value, by central differences."""
    return np.array([(value(at + step) - value(at - step)) / 6e-5 for step in 3e-5 * np.eye(len(at))])


def settled(case: Case, point: Array) -> Array:
    """The best design by Newton's method on its conditions, from one that is nearly so; numbers between 0 and 1."""
    conditions = Conditions(case, point, binding(case, point))
    start = point[conditions.inside]
    heights, slopes = conditions.pulls(start)
    rows = np.vstack([slopes.T, np.full(len(heights), float(case.goal is None))])
    weights = np.linalg.lstsq(rows, np.append(-conditions.toward(start), rows[-1, 0]), rcond=None)[0]
    found = root(conditions, np.concatenate([start, weights, [heights.max()]]), options={"xtol": 1e-13, "eps": 1e-7})
    moved = np.abs(found.x[: len(start)] - start).max()
    if np.abs(found.fun).max() > 1e-7 * max(1.0, heights.max()) or moved > 1e-3:
        raise ArithmeticError(f"the conditions of the best design are not met: {found.fun}")
    return conditions.whole(found.x[: len(start)])


def held_at(case: Case, point: Array, speeds: Array, whole: float) -> Array:
    """The best design and level with the limits at some speeds."""

    def room(at: Array) -> Array:
        return (at[-1] - case.levels(scaled(case, at[:-1])[:, None], speeds)).ravel() / point[-1]

    def goal(at: Array) -> float:
        return float(case.goal(scaled(case, at[:-1])) / whole) if case.goal else at[-1] / whole

    level = (1.0, 1.0) if case.goal else (0.0, 10 * point[-1])
    bounds = [(0.0, 1.0)] * len(case.ends) + [level]
    found = minimize(
        goal,
        point,
        bounds=bounds,
        constraints={"type": "ineq", "fun": room},
        method="SLSQP",
        options={"ftol": 1e-15, "maxiter": 300},
    )
    return np.asarray(found.x)


# --- machines --------------------------------------------------------------------------------


def pull(absorber: Array, speeds: Array) -> tuple[Array, Array]:
    """Dynamic stiffness that an absorber adds where it sits, and its stroke over the motion there.

    The absorber is mass, own frequency and damping ratio, each of one or of many designs.
    """
    m, own, zeta = (np.asarray(value)[..., None] for value in absorber)
    spring = m * (own**2 + 2j * zeta * own * speeds)
    free = spring - m * speeds**2
    return -spring * m * speeds**2 / free, m * speeds**2 / free


def hertz(*ends: float) -> tuple[float, float]:
    return 2 * pi * ends[0], 2 * pi * ends[1]


def rpm(*ends: float) -> tuple[float, float]:
    return ends[0] * pi / 30, ends[1] * pi / 30


def skid(designs: Array, speeds: Array) -> Array:
    """800 kg on 95 MN/m with two absorbers: velocity, and the stroke of each."""
    stiff, mass = 95e6, 800.0
    own = stiff + 2j * 0.01 * sqrt(stiff * mass) * speeds - mass * speeds**2
    first, second = (pull(designs[i : i + 3], speeds) for i in (0, 3))
    motion = 2e-3 * speeds**2 / (own + first[0] + second[0])
    velocity = np.abs(motion) * speeds / (1.4e-3 * sqrt(2))
    return np.array([velocity, np.abs(motion * first[1]) / 0.5e-3, np.abs(motion * second[1]) / 0.5e-3])


def bridge(designs: Array, speeds: Array) -> Array:
    """The mode of 1.97 Hz, 0.4 %, 38 t, with an absorber at midspan: acceleration and stroke."""
    own, mass = 2 * pi * 1.97, 38e3
    mode = mass * (own**2 + 2j * 0.004 * own * speeds - speeds**2)
    added, stroke = pull(designs, speeds)
    motion = 700 / (mode + added)
    return np.array([np.abs(motion) * speeds**2 / 0.4, np.abs(motion * stroke) / 25e-3])


def frame(floor: int, designs: Array, speeds: Array) -> Array:
    """Three storeys with an absorber on one: motion of the first in micrometres."""
    chain = np.array([[2, -1, 0], [-1, 2, -1], [0, -1, 1]])
    second_mode = sqrt(80e6 / 60e3 * np.linalg.eigvalsh(chain)[1])
    added, _ = pull((np.full_like(designs[0], 3e3), designs[0] * second_mode, designs[1]), speeds)
    dynamic = np.zeros((*added.shape, 3, 3), complex)
    dynamic += chain * (80e6 + 120e3j * speeds)[:, None, None] - 60e3 * (speeds**2)[:, None, None] * np.eye(3)
    dynamic[..., floor, floor] += added
    motion = np.linalg.solve(dynamic, np.array([0, 5e3, 0])[:, None])[..., 0, 0]
    return np.abs(motion)[None] * 1e6


def tool(designs: Array, speeds: Array) -> Array:
    """240 kg on 19 MN/m and 3 kN s/m with an absorber: displacement and stroke."""
    own = 19e6 + 3e3j * speeds - 240 * speeds**2
    added, stroke = pull(designs, speeds)
    motion = 300e-6 * speeds**2 / (own + added)
    return np.array([np.abs(motion) / 5e-6, np.abs(motion * stroke) / 60e-6])


def detuned(designs: Array, speeds: Array) -> Array:
    """40 t on 6.3 MN/m and 8 kN s/m with 800 kg, deck and absorber off by their tolerances either way: acceleration.

    The damper is built for the frequency that is aimed at.
    """
    own, found = sqrt(6.3e6 / 40e3), []
    for heavier in (0.97, 1.03):
        for faster in (0.98, 1.02):
            added, _ = pull((np.full_like(designs[0], 800.0), designs[0] * faster * own, designs[1] / faster), speeds)
            found.append(600 * speeds**2 / np.abs(6.3e6 + 8e3j * speeds - 40e3 * heavier * speeds**2 + added))
    return np.array(found)


GALLERY = Path(__file__).parents[2] / "problems" / "absorbers"
THIRD, MIDDLE = 7, 11


@cache
def girder_modes() -> tuple[Array, Array, Array]:
    """Squared frequencies (n,), dampings (n,) and shapes (n_coordinates, n) from the dense matrices."""
    mass, damping, stiffness = (
        mmread(GALLERY / f"gallery_{part}.mtx").toarray() for part in ("mass", "damping", "stiffness")
    )
    squares, shapes = eigh(stiffness, mass)
    modal = shapes.T @ damping @ shapes
    assert np.abs(modal - np.diag(np.diag(modal))).max() < 1e-9 * np.abs(modal).max()
    return squares, np.diag(modal), shapes


def girder(designs: Array, speeds: Array) -> tuple[Array, Array]:
    """The girder shaken at a third by 0.15 kg m with 60 kg at midspan: motion of midspan, and the stroke [mm]."""
    squares, damping, shapes = girder_modes()
    modes = 1 / (squares[:, None] + 1j * damping[:, None] * speeds - speeds**2)
    across, own = ((shapes[MIDDLE] * shapes[point]) @ modes for point in (THIRD, MIDDLE))
    added, stroke = pull((np.full_like(designs[0], 60.0), designs[0], designs[1]), speeds)
    motion = across * 0.15 * speeds**2 / (1 + own * added)
    return 1e3 * np.abs(motion), 1e3 * np.abs(motion * stroke)


ONE = ((0.005, 0.5),)
MASS_OF_TWO = ((1.0, 60.0), hertz(40, 75), *ONE) * 2
SKID = Case(MASS_OF_TWO, (rpm(2850, 3000), rpm(3420, 3600)), skid, lambda x: x[0] + x[3])
BRIDGE = Case(((50.0, 2000.0), hertz(1.5, 2.5), (0.01, 0.5)), (hertz(1.6, 2.4),), bridge, lambda x: x[0])
TOOL = Case(
    ((2.0, 60.0), hertz(25, 75), (0.005, 0.6)),
    (rpm(2205, 2250), rpm(2646, 2700), rpm(3087, 3150)),
    tool,
    lambda x: x[0],
)


@cache
def skid_answers() -> Answers:
    goal, design = refined(SKID, evolved(SKID))
    first, second = sorted((design[:3], design[3:]), key=lambda one: -float(one[0]))
    masses = {"variables.absorbers.first.mass": first[0], "variables.absorbers.second.mass": second[0]}
    tuned = {"variables.absorbers.first.frequency": first[1], "variables.absorbers.second.frequency": second[1]}
    return {"goal": goal, **masses, **tuned}


def single(case: Case, name: str) -> Answers:
    """One absorber of the least mass."""
    goal, design = refined(case, grid(case))
    path = f"variables.absorbers.{name}."
    return {"status": "optimal", "goal": goal, path + "frequency": design[1], path + "damping_ratio": design[2]}


@cache
def bridge_answers() -> Answers:
    return single(BRIDGE, "absorber")


@cache
def tool_answers() -> Answers:
    return single(TOOL, "absorber")


@cache
def frame_answers() -> Answers:
    """Every floor, and the best of them."""
    ends, band = ((0.7, 1.3), (0.01, 0.5)), (rpm(360, 540),)
    cases = [Case(ends, band, partial(frame, floor)) for floor in range(3)]
    found = [refined(case, grid(case)) for case in cases]
    best = min(range(3), key=lambda floor: found[floor][0])
    path = "variables.absorbers.absorber."
    place = {path + "on": ("first", "second", "third")[best], "goal": found[best][0] / 1e6}
    return {"status": "optimal", **place, path + "tuning": found[best][1][0], path + "damping_ratio": found[best][1][1]}


DETUNED = Case(((0.8, 1.1), (0.01, 0.3)), (hertz(1.6, 2.4),), detuned)
GIRDER = Case((hertz(5, 20), (0.01, 0.5)), (rpm(300, 900),), lambda designs, speeds: girder(designs, speeds)[0][None])


@cache
def detuned_answers() -> Answers:
    goal, design = refined(DETUNED, grid(DETUNED))
    path = "variables.absorbers.tmd."
    return {"goal": goal, path + "tuning": design[0], path + "damping_ratio": design[1]}


@cache
def girder_answers() -> Answers:
    """The stroke is far from its limit of 25 mm."""
    goal, design = refined(GIRDER, grid(GIRDER))
    stroke = girder(design[:, None], GIRDER.speeds(100_000))[1].max()
    assert stroke < 25
    return {"goal": goal / 1e3, "variables.absorbers.tmd.frequency": design[0], "limits.stroke.value": stroke / 1e3}


CASES: dict[str, Callable[[], Answers]] = {
    "pump_skid_two_grids": skid_answers,
    "footbridge_marching": bridge_answers,
    "footbridge_detuned": detuned_answers,
    "gallery_girder": girder_answers,
    "frame_three_storeys": frame_answers,
    "machine_tool_three_speeds": tool_answers,
}
