"""One convex program solved to a checked gap: only the rows that matter are shown to the solver."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from vibopt.balancing.cone import solve_cone
from vibopt.balancing.scaled import Dual, Scaled, into_wedge, weak_duality
from vibopt.forms import ComplexArray, FloatArray
from vibopt.records import dataclass

Places = NDArray[np.intp]

KEPT = 1e-9  # a limit is kept when it is exceeded by no more than this share
MANY_PLANES = 20
FEW = 30  # up to so many rows all of them are shown at once
ROUNDS = 40
TOLERANCES = (1e-10, 1e-11, 1e-8)
CLOSE = 1e-8


@dataclass(frozen=True)
class Convex:
    """Answer of one convex program in scaled variables.

    x
        None where no correction keeps the limits (then `factor` > 1 is proven) or none was found.
    factor
        Every limit would have to be at least this many times as wide; 0 where not asked, nan where unknown.
    impossible
        The solver says that no correction keeps the limits (its word only; `factor` is the proof).
    """

    x: ComplexArray | None
    value: float
    bound: float
    dual: Dual | None
    factor: float = 0.0
    rounds: int = 0
    impossible: bool = False

    @property
    def gap(self) -> float:
        """Scaled gap, relative to the value or to 1e-3 where that is about zero."""
        return (self.value - self.bound) / max(abs(self.value), 1e-3) if self.x is not None else np.inf


def solve_convex(scene: Scaled) -> Convex:
    """Least goal over discs, arcs, total and limits; the bound is our own."""
    if not scene.n_planes:
        return _nothing_to_choose(scene)
    found = _patient(scene)
    if found.x is not None:
        return found
    ratio = _patient(least_factor(scene))
    if ratio.bound > 1.0 + KEPT:
        return Convex(None, np.inf, np.inf, None, ratio.bound, found.rounds)
    if ratio.x is not None and ratio.value <= 1.0 + KEPT:
        return Convex(ratio.x, scene.value(ratio.x), found.bound, found.dual, 1.0, found.rounds)
    return Convex(None, np.inf, found.bound, None, float("nan"), found.rounds)


def least_factor(scene: Scaled) -> Scaled:
    """The program whose answer is the least common factor on all limits."""
    none = np.empty((0, scene.n_planes), dtype=complex)
    return replace(
        scene,
        G=scene.F,
        g=scene.f,
        F=none,
        f=none[:, 0],
        limited=np.empty(0, dtype=np.intp),
        goal="worst",
        goal_size=1.0,
    )


def _patient(scene: Scaled) -> Convex:
    """The solver asked for less where it stumbles over too much; best answer and best bound of all."""
    found = _rounds(scene, TOLERANCES[0])
    for tolerance in TOLERANCES[1:]:
        if found.gap <= CLOSE or found.impossible:
            break
        again = _rounds(scene, tolerance)
        better = again if again.value < found.value else found
        surer = again if again.bound > found.bound else found
        found = replace(better, bound=surer.bound, dual=surer.dual, rounds=found.rounds + again.rounds)
    return found


def _rounds(scene: Scaled, tolerance: float) -> Convex:
    """Solve, look at the rows left out, add the violated ones, until the gap is closed or nothing is left to add."""
    goal_rows, limit_rows = _first_rows(scene)
    best_x, best_value, best_bound, best_dual, impossible, count = None, np.inf, -np.inf, None, False, 0
    for count in range(1, ROUNDS + 1):  # noqa: B007 - read after the loop
        answer = solve_cone(scene, goal_rows, limit_rows, tolerance)
        x = pull_in(scene, answer.x) if np.all(np.isfinite(answer.x)) else np.zeros(scene.n_planes, dtype=complex)
        limits_left = np.abs(scene.F @ x + scene.f)
        value = scene.value(x) if limits_left.max(initial=0.0) <= 1.0 + KEPT else np.inf
        dual = weak_duality(scene, answer.z, answer.v, float(np.abs(x).max()))
        if dual.bound > best_bound:
            best_bound, best_dual = dual.bound, dual
        if value < best_value:
            best_x, best_value = x, value
        impossible = answer.status == "PrimalInfeasible"
        if impossible or "Infeasible" in answer.status or "Numerical" in answer.status:
            break
        if best_x is not None and best_value - best_bound <= 1e-10 * max(abs(best_value), 1e-6):
            break
        more_goal, more_limits = _missing(scene, goal_rows, x), _add(limit_rows, limits_left, 1.0, scene)
        if not len(more_goal) and not len(more_limits):
            break
        goal_rows, limit_rows = np.union1d(goal_rows, more_goal), np.union1d(limit_rows, more_limits)
    return Convex(best_x, best_value, best_bound, best_dual, rounds=count, impossible=impossible)


def _missing(scene: Scaled, rows: Places, x: ComplexArray) -> Places:
    """Goal rows left out although they are the worst at x; only "worst" leaves rows out."""
    if scene.goal != "worst" or len(rows) == len(scene.g):
        return np.empty(0, dtype=np.intp)
    left = np.abs(scene.G @ x + scene.g)
    return _add(rows, left, float(left[rows].max(initial=0.0)) * (1.0 + 1e-11), scene)


def _add(rows: Places, left: FloatArray, level: float, scene: Scaled) -> Places:
    """The rows above `level` that are not shown yet, the worst few of them."""
    above = np.setdiff1d(np.flatnonzero(left > level), rows, assume_unique=True)
    return above[np.argsort(-left[above])[: 2 * scene.n_planes + 4]]


def _first_rows(scene: Scaled) -> tuple[Places, Places]:
    """Goal and limit rows shown first: all where few, else the worst after a few rounds of Lawson's weights."""
    every = np.arange(len(scene.g))
    goal_rows = every[:0] if scene.goal == "correction" else every
    limit_rows = np.arange(len(scene.f))
    if scene.goal == "worst" and len(every) > FEW:
        goal_rows = likely_worst(scene, scene.G, scene.g)
    if len(limit_rows) > FEW:
        limit_rows = likely_worst(scene, scene.F, scene.f)
    return goal_rows, limit_rows


def likely_worst(scene: Scaled, M: ComplexArray, c: ComplexArray) -> Places:
    """Rows that are likely to be worst at the answer: weighted least squares, weights times residual, a few times.

    Two rows per free plane and one per plane at its cap are what an answer rests on; a few more are shown.
    (Lawson, 1961; Ellacott and Williams, 1976, for complex data.)
    """
    weights, left = np.full(len(c), 1.0 / len(c)), np.abs(c)
    x = np.zeros(scene.n_planes, dtype=complex)
    for _ in range(8 if scene.n_planes <= MANY_PLANES else 20):
        heavy = M.conj().T * weights
        square = heavy @ M
        square.flat[:: len(square) + 1] += 1e-12 * np.trace(square).real + 1e-300
        x = pull_in(scene, np.linalg.solve(square, -heavy @ c))
        left = np.abs(M @ x + c)
        weights = weights * left
        weights /= weights.sum() or 1.0
    at_cap = int(np.count_nonzero(np.abs(x) >= 0.999 * scene.caps))
    count = min(int(2.2 * (scene.n_planes - at_cap)) + at_cap + 12, len(c))
    score = left / (left.max() or 1.0) + weights / (weights.max() or 1.0)
    return np.sort(np.argpartition(-score, count - 1)[:count])


def pull_in(scene: Scaled, x: ComplexArray) -> ComplexArray:
    """x brought into its discs, arcs and the total mass, by as little as rounding asks for."""
    for plane, wedge in enumerate(scene.wedges):
        if wedge is not None:
            x[plane] = into_wedge(x[plane], *wedge)
    size = np.abs(x)
    over = size > scene.caps
    if over.any():
        x = np.where(over, x * (scene.caps / np.where(over, size, 1.0)), x)
    if np.isfinite(scene.total):
        mass = float(scene.mass @ np.abs(x))
        if mass > scene.total:
            x = x * (scene.total / mass)
    return x


def _nothing_to_choose(scene: Scaled) -> Convex:
    """No plane is free: the readings stay as they are."""
    factor = float(np.abs(scene.f).max(initial=0.0))
    if factor > 1.0 + KEPT:
        return Convex(None, np.inf, np.inf, None, factor)
    value = scene.value(np.empty(0, dtype=complex))
    return Convex(np.empty(0, dtype=complex), value, value, None)
