"""Sequential quadratic programming on the exact local peaks, and Newton on those that hold.

Everything is in y = log x.  The peaks' slopes are exact wherever the peaks move to, so there is
nothing to sample here and the answer is as sharp as the measurement.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field, replace

import numpy as np

from vibopt.answer.entry import TOLERANCE
from vibopt.arrays import BoolArray, FloatArray
from vibopt.cones import LINEAR, solve_cones
from vibopt.records import dataclass
from vibopt.solve.measured_pieces import Exact, Piece, Point
from vibopt.solve.working_set import least_of

_STEP = 1e-5
_INSIDE = 2e-10
_FEW = 4
_WITHIN = 1e-6
_SETTLED = 1e-14
_SQUARED = 1e-9
"""A Newton step this short leaves nothing: the next is as short as its square."""
_NEAR = 0.1
_DASHES = 8
_BESIDE = 0.3
"""Longest Newton step next to a start that is nearly an optimum."""
_ALONG = 1e-3
"""Log distance up to which a step runs along a limit."""
_LIGHT = 4.0
"""Weight of what limits are missed by to begin with: steps may leave limits a little on their way, and go further."""
_MET = 1e-7
"""Log violation up to which a heavier weight of limits is not tried."""
_ALL, _DEAR = 0.999, 8
"""Part of the light weight that missed limits cost where it is too little, and rounds after which that is believed."""
_PRICED = 1e-6
"""Part of the greatest price below which a limit has none."""
_LAGS, _AHEAD = 10, 4.0
"""Rounds, and times what was gained in them that would have to be gained to be as good as the best known."""
_SOFT = 1e-9
_FLAT = 1e-12
_STIFFER = (1.0, 10.0, 100.0, 1000.0)
"""By how much a bend may be stiffened across the active pieces, in parts of its size."""


@dataclass
class Sqp:
    """Trust-region SQP from a start, then Newton on what holds.

    hopeless
        Log violation beyond which a start that no longer improves is given up.
    bar
        Goal of the best design known: what gains little and is far above it is not followed to its end.
    guess
        The last bend of the Lagrangian, where the pieces know theirs.
    behind
        Whether the last way was left because it would not come near the bar.
    """

    exact: Exact
    rounds: int = 60
    hopeless: float = 1e-3
    bar: float = np.inf
    guess: FloatArray | None = field(default=None, init=False)
    behind: bool = field(default=False, init=False)

    def run(self, start: FloatArray, *, only_feasible: bool = False, within: bool = False) -> Point:
        """The best design reached from `start` (y); with `only_feasible` the first within the limits.

        A way `within` them stays next to those that hold at the start.
        """
        if only_feasible and self.exact.program.aim is not None:
            exact = replace(self.exact, program=self.exact.program.aiming(None), known={})
            return Sqp(exact, self.rounds, self.hopeless).run(start, only_feasible=True)
        here, self.behind = self.exact.at(np.clip(start, self.exact.low, self.exact.high)), False
        for weight in (1e2,) if only_feasible else (1e3, 1e5) if within else (_LIGHT, 1e2, 1e5):
            here = self._descend(here, weight, -_WITHIN if only_feasible else -np.inf)
            if self.behind:
                return here
            if here.missed <= _MET or (here.missed > self.hopeless and weight > _LIGHT):
                break
        return here if only_feasible else self._finish(here)

    def beside(self, start: FloatArray) -> Point | None:
        """The optimum next to a start that is nearly one, by Newton alone; None where it does not lead there."""
        here = self.exact.at(np.clip(start, self.exact.low, self.exact.high))
        settled = (there for there, size in self._dashes(here, _BESIDE) if size <= _SQUARED)
        found = next(settled, None)
        return None if found is None or found.missed > TOLERANCE else found

    def _dashes(self, at: Point, reach: float) -> Iterator[tuple[Point, float]]:
        """A few Newton steps as long as they shrink: where each leads, and its length."""
        last = np.inf
        for _ in range(_DASHES):
            there = self._newton(at, 0.0, reach)
            size = np.inf if there is None else float(np.abs(there.y - at.y).max(initial=0.0))
            if there is None or size > 0.7 * last:
                return
            yield there, size
            at, last = there, size

    def _descend(self, here: Point, weight: float, enough: float) -> Point:
        """Steps until nothing is gained, or the limits are missed by no more than `enough`."""
        radius, moved, near = 1.0, False, _NEAR
        bend = _convex(_first_bend(here))
        missed: list[float] = []
        merits: list[float] = []
        dear = 0
        for _ in range(self.rounds):
            merits.append(_merit(here, weight))
            missed.append(here.missed if weight > _LIGHT else merits[-1])
            self.behind = len(merits) > _LAGS and _AHEAD * (merits[-1 - _LAGS] - merits[-1]) < merits[-1] - self.bar
            stuck = here.missed > self.hopeless and len(missed) > 8 and missed[-8] - missed[-1] < 0.05 * here.missed
            if self.behind or stuck or here.missed <= enough or self.exact.budget.over:
                break
            step, promised, multipliers = _quadratic(here, bend, radius, weight, self.exact)
            costs = float(multipliers[len(here.goals) :].sum())
            dear = dear + 1 if here.goals and here.missed > _MET and costs > _ALL * weight else 0
            if moved:
                multipliers = _at_least(here, multipliers)
                bend = _convex_along(self._bend(here, multipliers), here, multipliers, self.exact)
                step, promised, _ = _quadratic(here, bend, radius, weight, self.exact)
            size = float(np.abs(step).max(initial=0.0))
            if size < 1e-10 or promised <= 1e-13 or (weight == _LIGHT and dear >= _DEAR):
                break
            if moved and size < near and here.bends_known:
                near = 0.5 * size
                there = self._dashed(here, weight)
                if there is not here:
                    here = there
                    continue
            there = self.exact.at(np.clip(here.y + step, self.exact.low, self.exact.high))
            gained = _merit(here, weight) - _merit(there, weight)
            if gained <= 0.3 * promised:
                there = self._corrected(here, there, bend, radius, weight)
                gained = _merit(here, weight) - _merit(there, weight)
            if gained > 0.05 * promised:
                radius = min(max(radius, 2.5 * size) if gained > 0.7 * promised else radius, 6.0)
                here, moved = there, True
            else:
                radius, moved = 0.3 * min(radius, size), False
            if radius < 1e-12:
                break
        return here

    def _dashed(self, here: Point, weight: float) -> Point:
        """The best of a few Newton steps as long as they shrink, each free to break limits a little on its way."""
        best = here
        for there, size in self._dashes(here, _NEAR):
            if _merit(there, weight) < _merit(best, weight):
                best = there
            if size < _SQUARED:
                break
        return best

    def _corrected(self, here: Point, there: Point, bend: FloatArray, radius: float, weight: float) -> Point:
        """Second try after a step that curved limits spoilt: the step again, with the pieces found where it led."""
        moved = there.y - here.y
        limits, goals = (
            tuple(_seen_from(here, piece, moved) for piece in pieces) for pieces in (there.limits, there.goals)
        )
        step, _, _ = _quadratic(Point(here.y, limits, goals), bend, radius, weight, self.exact)
        other = self.exact.at(np.clip(here.y + step, self.exact.low, self.exact.high))
        return other if _merit(other, weight) < _merit(there, weight) else there

    def _bend(self, here: Point, multipliers: FloatArray) -> FloatArray:
        """Second derivative of the Lagrangian along the moving peaks: known, or by differences of exact slopes."""
        n = len(here.y)
        pieces = (*here.goals, *here.limits)
        active = [(piece, m) for piece, m in zip(pieces, multipliers, strict=True) if m > 1e-9]
        bend = np.zeros((n, n))
        if all(piece.bend is not None for piece, _ in active):
            self.guess = sum((m * piece.bend for piece, m in active if piece.bend is not None), bend)
            return self.guess
        free = np.flatnonzero(self.exact.free)
        steps = np.where(here.y + _STEP <= self.exact.high, _STEP, -_STEP)[free]
        places = here.y + np.eye(n)[free] * steps[:, None]
        every = self.exact.some(places, {piece.part for piece, _ in active})
        for i, step, there in zip(free, steps, every, strict=True):
            for piece, m in active:
                other = _same(piece, there)
                if other is not None:
                    bend[i] += m * (other.slope - piece.slope) / step
        return 0.5 * (bend + bend.T)

    def _finish(self, here: Point) -> Point:
        """Newton on the pieces that hold, then a step inside where rounding left a limit broken."""
        if here.missed > 1e-4:
            return here
        settled = np.inf
        for target in (0.0, 0.0, 0.0, -_INSIDE, -_INSIDE):
            if self.exact.budget.over or (target < 0.0 and here.missed <= 0.5 * _INSIDE):
                break
            if target == settled:
                continue
            there = self._newton(here, target)
            if there is None or not _better(there, here):
                settled = target
                continue
            if np.abs(there.y - here.y).max() <= _SQUARED:
                settled = target
            here = there
        return here

    def _newton(self, here: Point, target: float, reach: float = 0.01) -> Point | None:
        guess = _first_bend(here) if self.guess is None or not here.bends_known else self.guess
        step, _, multipliers = _quadratic(here, _convex(guess), reach, 1e5, self.exact)
        bend = self._bend(here, multipliers)
        if not here.bends_known:
            step, _, multipliers = _quadratic(here, _convex(bend), reach, 1e5, self.exact)
        chosen = multipliers > 1e-7
        n_goals = len(here.goals)
        goals = [piece for piece, on in zip(here.goals, chosen[:n_goals], strict=True) if on]
        limits = [piece for piece, on in zip(here.limits, chosen[n_goals:], strict=True) if on]
        y = here.y + step
        room = 1e-9
        free = self.exact.free & (y > self.exact.low + room) & (y < self.exact.high - room)
        held = np.where(free, here.y, np.where(y <= self.exact.low + room, self.exact.low, self.exact.high))
        held = np.where(self.exact.free, held, here.y)
        moved = held - here.y
        solved = _stationary(here, goals, limits, bend, free, moved, target)
        if solved is None or np.abs(solved).max(initial=0.0) > reach:
            return None
        there = np.clip(held + np.where(free, solved, 0.0), self.exact.low, self.exact.high)
        return here if np.abs(there - here.y).max(initial=0.0) <= _SETTLED else self.exact.at(there)


def _stationary(
    here: Point,
    goals: list[Piece],
    limits: list[Piece],
    bend: FloatArray,
    free: BoolArray,
    moved: FloatArray,
    target: float,
) -> FloatArray | None:
    """Newton step of the conditions of an optimum with these pieces holding, shape (n_vars,)."""
    n, count = int(free.sum()), len(goals)
    rows = np.array([piece.slope for piece in (*goals, *limits)]).reshape(-1, len(here.y))
    lift = np.array([1.0] * count + [0.0] * len(limits))
    values = np.array([piece.value - here.goal for piece in goals] + [piece.value - target for piece in limits])
    if not len(values):
        return None
    size, m = n + 1, len(values)
    matrix = np.zeros((size + m, size + m))
    matrix[:n, :n] = bend[np.ix_(free, free)]
    matrix[:n, size:] = rows[:, free].T
    matrix[n, size:] = -lift
    matrix[size:, :n] = rows[:, free]
    matrix[size:, n] = -lift
    right = np.concatenate([-(bend[free] @ moved), [-1.0], -(values + rows @ moved)])
    scale = np.abs(matrix).max(axis=1, initial=0.0)
    scale = np.where(scale == 0.0, 1.0, scale)
    solved = np.linalg.lstsq(matrix / scale[:, None], right / scale, rcond=1e-13)[0]
    step = moved.copy()
    step[free] = solved[:n]
    return step if np.isfinite(step).all() else None


def _quadratic(
    here: Point, bend: FloatArray, radius: float, weight: float, exact: Exact
) -> tuple[FloatArray, float, FloatArray]:
    """Best step within the radius to first order in the pieces: step, promised gain, multipliers.

    Unknowns: step (n), top of the goal's pieces, greatest violation.
    """
    n, pieces = len(here.y), (*here.goals, *here.limits)
    rows = np.array([piece.slope for piece in pieces]).reshape(len(pieces), n)
    values = np.array([piece.value for piece in pieces])
    count = len(here.goals)
    values[:count] -= here.goal
    size = np.maximum(np.abs(rows).max(axis=1, initial=0.0), 1.0)
    lift = np.zeros((len(pieces), 2))
    lift[:count, 0] = lift[count:, 1] = -1.0
    low = np.maximum(exact.low - here.y, -radius)
    high = np.minimum(exact.high - here.y, radius)
    box = np.concatenate([np.eye(n), -np.eye(n)])
    sides = np.concatenate([box, np.zeros((2 * n, 2))], axis=1)
    slack = np.zeros((1, n + 2))
    slack[0, n + 1] = -1.0
    table = np.concatenate([np.concatenate([rows, lift], axis=1) / size[:, None], sides, slack])
    right = np.concatenate([-values / size, high, -low, [0.0]])
    if not count:
        table[-1, n] = 0.0
    quadratic = np.zeros((n + 2, n + 2))
    quadratic[:n, :n] = bend
    linear = np.zeros(n + 2)
    linear[n], linear[n + 1] = (1.0 if count else 0.0), weight
    found = None
    if n <= _FEW and count:
        quadratic[:n, :n] += _SOFT * np.eye(n)
        highest = int(values[:count].argmax())
        walls = len(pieces) + np.arange(n) + n * (rows[highest] > 0.0)
        for working in ([highest, len(right) - 1], [highest, len(right) - 1, *walls.tolist()]):
            found = found or least_of(quadratic, linear, table, right, working)
        quadratic[:n, :n] = bend
    if found is None:
        cone_point = solve_cones(linear, table, right, [(LINEAR, len(right))], quadratic=quadratic)
        found = cone_point.x, cone_point.z
    answer, prices = found
    step, duals = answer[:n], prices[: len(pieces)] / size
    if not np.isfinite(step).all():
        return np.zeros(n), 0.0, np.zeros(len(pieces))
    step = np.where(exact.free, np.clip(step, low, high), 0.0)
    reached = values + rows @ step
    top = float(reached[:count].max(initial=-np.inf)) if count else 0.0
    missed = max(float(reached[count:].max(initial=0.0)), 0.0)
    promised = weight * (max(here.missed, 0.0) - missed) - top - 0.5 * float(step @ bend @ step)
    return step, promised, duals


def _first_bend(here: Point) -> FloatArray:
    """Bend of the highest piece of the goal, where it is known: a guess at that of the whole."""
    top = max(here.goals, key=lambda piece: piece.value, default=None)
    return np.zeros((len(here.y),) * 2) if top is None or top.bend is None else top.bend


def _at_least(here: Point, multipliers: FloatArray) -> FloatArray:
    """Prices that show the bends of limits which a step runs along, also where the radius holds it and not they."""
    if not here.goals:
        return multipliers
    made, steep = multipliers.copy(), float(np.abs(here.goals[0].slope).max())
    for i, piece in enumerate(here.limits, start=len(here.goals)):
        if piece.value > -_ALONG and piece.bend is not None and made[i] <= _PRICED * made.max():
            made[i] = max(made[i], steep / max(float(np.abs(piece.slope).max()), 1e-300))
    return made


def _merit(point: Point, weight: float) -> float:
    return point.goal + weight * max(point.missed, 0.0)


def _better(there: Point, here: Point) -> bool:
    """Whether a Newton step led to a design at least as good, both judged at the rounding of limits."""
    if there.missed > max(1e-10, here.missed):
        return False
    return there.goal <= here.goal + 1e-12 + 1e3 * max(here.missed, 0.0) or here.missed > 1e-10


def _seen_from(here: Point, piece: Piece, moved: FloatArray) -> Piece:
    """A piece found where a step led, along the slope it has where the step began: the bend is not counted twice."""
    known = _same(piece, here)
    slope = piece.slope if known is None else known.slope
    return replace(piece, slope=slope, value=piece.value - float(slope @ moved))


def _same(piece: Piece, there: Point) -> Piece | None:
    """The piece of another, near design that continues this one."""
    pool = there.goals if piece.part < 0 else there.limits
    near = [one for one in pool if one.part == piece.part and len(one.mark) == len(piece.mark)]
    if not near:
        return None
    return min(near, key=lambda one: max((abs(a - b) for a, b in zip(one.mark, piece.mark, strict=True)), default=0.0))


def _convex_along(bend: FloatArray, here: Point, multipliers: FloatArray, exact: Exact) -> FloatArray:
    """A convex matrix that bends as `bend` along what the active pieces hold, so that steps stay those of Newton.

    Across them, where their own rows hold the step, it is stiffened; where that is not enough, what it bends along them
    is made convex by itself, so that nothing holds a step back where the bend is negative.
    """
    size = float(np.abs(bend).max(initial=0.0))
    values = np.linalg.eigvalsh(bend)
    if not size or values[0] >= -_FLAT * size:
        return bend if values[0] >= 0.0 else _convex(bend)
    count, on = len(here.goals), multipliers > 1e-9
    goals, limits = (
        np.array([piece.slope for piece, active in zip(pieces, chosen, strict=True) if active]).reshape(-1, len(bend))
        for pieces, chosen in ((here.goals, on[:count]), (here.limits, on[count:]))
    )
    ends = np.eye(len(bend))[(here.y <= exact.low) | (here.y >= exact.high)]
    rows = np.concatenate([goals[1:] - goals[:1], limits, ends])
    turned, lengths, _ = np.linalg.svd(rows.T, full_matrices=True)
    rank = int((lengths > _FLAT * lengths.max(initial=0.0)).sum())
    held, along = turned[:, :rank], turned[:, rank:]
    for stiffness in _STIFFER:
        stiff = bend + stiffness * size * held @ held.T
        if np.linalg.eigvalsh(stiff)[0] >= 0.0:
            return np.asarray(stiff)
    return np.asarray(along @ _convex(along.T @ bend @ along) @ along.T + size * held @ held.T)


def _convex(bend: FloatArray) -> FloatArray:
    """The nearest matrix without directions of negative bend."""
    values, vectors = np.linalg.eigh(bend)
    made: FloatArray = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return made
