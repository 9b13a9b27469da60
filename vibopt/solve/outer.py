"""Outer approximation: the program at a few speeds is solved globally and exactly, then speeds are added.

Fewer speeds are fewer limits, so each answer is a proven bound; when the exact measurement finds
nothing broken any more, bound and design are the same.
"""

from __future__ import annotations

from dataclasses import field
from functools import lru_cache

import numpy as np

from vibopt.forms import FloatArray, IntArray, Modulus, StaticRow
from vibopt.mechanics.polynomials import real_roots
from vibopt.program.program import Limit, Program
from vibopt.records import dataclass
from vibopt.solve.branch import Judge, violation
from vibopt.solve.method import Found, Progress
from vibopt.solve.rows import LineRows, PlaneRows, direction
from vibopt.solve.worst_speeds import local_extremes

_ROUNDS = 25
_DONE = 1e-11


@dataclass
class Speeds:
    """Speeds sampled so far per limit (by index) [rad/s]."""

    program: Program
    known: list[list[float]] = field(default_factory=list)
    fresh: list[list[float]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.known = [_first(limit) for limit in self.program.limits]
        self.fresh = [list(speeds) for speeds in self.known]

    def take(self) -> list[tuple[Limit, FloatArray]]:
        """Limits with the speeds added since the last call."""
        new = [(limit, np.array(one)) for limit, one in zip(self.program.limits, self.fresh, strict=True) if one]
        self.fresh = [[] for _ in self.known]
        return new

    def learn(self, x: FloatArray) -> float:
        """Add the worst speeds at x (n_vars,); the greatest violation found.

        A limit without a range of speeds is a row of its own, which x meets already.
        """
        worst = 0.0
        for index, limit in enumerate(self.program.limits):
            if not isinstance(limit.form, Modulus) or all(band.is_point for band in limit.form.drives[0].bands):
                continue
            least = limit.side == "at_least"
            found = local_extremes(limit.model, limit.form, x, least=least)
            missed = violation(limit, (min if least else max)(value for _, value in found), x)
            worst = max(worst, missed)
            if missed > _DONE:
                broken = [speeds[0] for speeds, value in found if violation(limit, value, x) > _DONE]
                fresh = [speed for speed in broken if speed not in self.known[index]]
                self.known[index] += fresh
                self.fresh[index] += fresh
        return worst


def _first(limit: Limit) -> list[float]:
    if not isinstance(limit.form, Modulus):
        return [0.0]
    ends = [speed for band in limit.form.drives[0].bands for speed in (band.low, band.high)]
    return list(dict.fromkeys(ends))


class OneVariable:
    """One design variable: every limit is a polynomial inequality at each speed."""

    name = "closed_form"
    summary = "roots of polynomials in the one variable, over the worst speeds"

    def refuses(self, program: Program) -> str | None:
        if program.several:
            return "the limits speak of several machines, the same design within its tolerances."
        if len(program.axes) != 1 or program.axes[0].values is not None:
            return "there is not exactly one continuous variable."
        if program.aim is not None and direction(program.aim, program.aim.model, 0) is None:
            return f"the goal {program.aim.name} does not simply rise or fall with {program.axes[0].path}."
        rows = LineRows.of(program)
        for limit in program.limits:
            if not rows.accepts(limit):
                return f"the limit {limit.name} is no polynomial inequality."
        return None

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """Status "optimal" or "infeasible", both proven."""
        rows, speeds = LineRows.of(program), Speeds(program)
        upward = direction(program.aim, program.aim.model, 0) if program.aim is not None else 1.0
        table: list[FloatArray] = []
        for round_number in range(1, _ROUNDS + 1):
            table += [row for limit, new in speeds.take() for row in rows.at(limit, new)]
            best = self._relaxed(program, rows, table, upward or 1.0)
            if best is None:
                return _none(self.name, round_number)
            x = np.array(best[:1])
            if speeds.learn(x) <= _DONE:
                return _found(program, self.name, x, round_number, best[1:])
        return Found("unproven", None, "the worst speeds did not settle", self.name)

    def _relaxed(
        self, program: Program, rows: LineRows, table: list[FloatArray], upward: float
    ) -> tuple[float, float] | None:
        """Best x at the sampled speeds, and the upper end of the range that was searched; None without any."""
        axis = program.axes[0]
        scale = rows.reference ** (1.0 / rows.root)
        low, high = axis.low ** (1.0 / rows.root) / scale, axis.high ** (1.0 / rows.root) / scale
        roots = np.concatenate([np.zeros(0), *[_roots(row) for row in table]])
        if axis.open_high:
            high = max(high, 4.0 * float(roots.max(initial=0.0)))
        cuts = np.concatenate([np.array([low, high]), roots])
        cuts = np.array(sorted({*cuts[(cuts >= low) & (cuts <= high)].tolist()}))
        best = _extreme_cut(cuts, table, upward)
        if best is None:
            return None
        top = (high * scale) ** rows.root if axis.open_high else axis.high
        ends = {float(low): axis.low, float(high): top}
        return ends.get(best, (best * scale) ** rows.root), top


def _extreme_cut(cuts: FloatArray, polynomials: list[FloatArray], upward: float) -> float | None:
    """The outermost cut that ends an interval where every row holds, or that alone does."""
    middles = 0.5 * (cuts[:-1] + cuts[1:])
    good = np.ones(len(middles), dtype=bool)
    for row in polynomials:
        good &= np.polyval(row[::-1], middles) <= 0.0
    ends = np.concatenate([cuts[1:][good], cuts[:-1][good]])
    touching = np.ones(len(cuts), dtype=bool)
    for row in polynomials:
        size = np.polyval(np.abs(row[::-1]), cuts)
        touching &= np.polyval(row[::-1], cuts) <= 1e-14 * size
    ends = np.concatenate([ends, cuts[touching]])
    if not len(ends):
        return None
    return float(ends.max() if upward > 0 else ends.min())


def _roots(row: FloatArray) -> FloatArray:
    """Real roots of an ascending polynomial, quadratics without cancellation, polished."""
    row = np.trim_zeros(row, "b")
    if len(row) < 2:
        return np.zeros(0)
    if len(row) == 2:
        return np.array([-row[0] / row[1]])
    return _many_roots(row[None, ::-1]) if len(row) == 3 else real_roots(row, 1e-7, 3)


class StiffnessAndDamping:
    """One mass on (k, c): for each k the limits leave an interval of c^2."""

    name = "closed_form_kc"
    summary = "exact in damping and stiffness, over the worst speeds"

    def __init__(self) -> None:
        self._last: tuple[Program, PlaneRows | None] | None = None

    def _rows(self, program: Program) -> PlaneRows | None:
        """The rows of a program; those of the last one are kept."""
        if self._last is None or self._last[0] is not program:
            self._last = (program, PlaneRows.of(program))
        return self._last[1]

    def refuses(self, program: Program) -> str | None:
        if program.several:
            return "the limits speak of several machines, the same design within its tolerances."
        rows = self._rows(program)
        if rows is None:
            return "the variables are not the stiffness and the damping of one link under one mass."
        if any(axis.values is not None for axis in program.axes):
            return "a variable is discrete."
        if self.goal(program, rows) is None:
            name = program.aim.name if program.aim is not None else ""
            return f"the goal {name} does not simply rise or fall with stiffness or damping."
        for limit in program.limits:
            if not rows.accepts(limit):
                return f"the limit {limit.name} is not linear in the square of the damping."
        return None

    def goal(self, program: Program, rows: PlaneRows) -> tuple[int, float] | None:
        """Which of (k, c) the goal moves, and in which direction."""
        if program.aim is None:
            return 0, 1.0
        model = program.aim.model
        for place, index in enumerate(rows.order):
            sense = direction(program.aim, model, index)
            if sense is not None and not (place == 1 and isinstance(program.aim.form, StaticRow)):
                return place, sense
        return None

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """Status "optimal" or "infeasible", both proven."""
        rows, speeds = self._rows(program), Speeds(program)
        assert rows is not None
        goal = self.goal(program, rows)
        assert goal is not None
        table = np.zeros((0, 4))
        for round_number in range(1, _ROUNDS + 1):
            table = np.concatenate([table, *[rows.at(limit, new) for limit, new in speeds.take()]])
            box = self._box(program, rows, table)
            best = Plane(table, *box).best(*goal)
            if best is None:
                return _none(self.name, round_number)
            x, reach = np.zeros(2), np.zeros(2)
            x[list(rows.order)], reach[list(rows.order)] = best, box[1]
            if speeds.learn(x) <= _DONE:
                return _found(program, self.name, x, round_number, tuple(reach))
        return Found("unproven", None, "the worst speeds did not settle", self.name)

    def _box(self, program: Program, rows: PlaneRows, table: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Box of (k, c); an open end is moved beyond everything that the rows turn at."""
        order = list(rows.order)
        low, high = program.low[order], program.high[order]
        if any(program.axes[i].open_high for i in order):
            far = Plane(table, low, high)
            if program.axes[order[0]].open_high:
                high[0] = max(high[0], 4.0 * far.farthest_k())
            if program.axes[order[1]].open_high:
                high[1] = max(high[1], 2.0 * far.highest_c(high[0]))
        return low, high


class Plane:
    """Rows alpha k^2 + beta k + gamma + delta q <= 0 over a box of k and c, q = c^2."""

    def __init__(self, table: FloatArray, low: FloatArray, high: FloatArray) -> None:
        self.low, self.high = low, high
        self.scale = _sizes(table, high)
        box = np.array([[0.0, 0.0, -(high[1] ** 2), 1.0], [0.0, 0.0, low[1] ** 2, -1.0]])
        rows = np.concatenate([table, box]) * np.array([self.scale[0] ** 2, self.scale[0], 1.0, self.scale[1]])
        size = np.abs(rows).max(axis=1, keepdims=True)
        self.rows = rows / np.where(size == 0.0, 1.0, size)
        flat = np.abs(self.rows[:, 3]) <= 1e-15
        self.walls = self.rows[flat, :3]
        slanted = self.rows[~flat]
        self.curves = -slanted[:, :3] / slanted[:, 3:]
        self.upper = slanted[:, 3] > 0.0

    def best(self, place: int, sense: float) -> FloatArray | None:
        """k and c of the extreme point; None where no point satisfies all rows."""
        cuts = self._cuts(place)
        inside, low, high = self._interval(cuts)
        if not inside.any():
            return None
        k, low, high = cuts[inside], low[inside], high[inside]
        if place == 0:
            index = int(k.argmax() if sense > 0 else k.argmin())
            q = low[index]
        else:
            index = int(high.argmax() if sense > 0 else low.argmin())
            q = high[index] if sense > 0 else low[index]
        return self._design(float(k[index]), float(q))

    def _design(self, k: float, q: float) -> FloatArray:
        stiffness = min(max(k * self.scale[0], self.low[0]), self.high[0])
        damping = min(max(float(np.sqrt(max(q * self.scale[1], 0.0))), self.low[1]), self.high[1])
        return np.array([stiffness, damping])

    def farthest_k(self) -> float:
        """Greatest stiffness [SI] at which any two rows meet."""
        return float(self._meetings().max(initial=0.0)) * float(self.scale[0])

    def highest_c(self, k: float) -> float:
        """Damping [SI] that no lower curve exceeds between zero and `k`, at the cuts."""
        cuts = np.append(self._meetings(), k / self.scale[0])
        cuts = cuts[(cuts >= 0.0) & (cuts <= k / self.scale[0])]
        values = self.curves[~self.upper] @ np.stack([cuts**2, cuts, np.ones_like(cuts)])
        return float(np.sqrt(max(values.max(initial=0.0), 0.0) * self.scale[1]))

    def _meetings(self) -> FloatArray:
        first, second = _pairs(len(self.curves))
        return _many_roots(np.concatenate([self.curves[first] - self.curves[second], self.walls]))

    def _cuts(self, place: int) -> FloatArray:
        """Every k [scaled] at which the feasible interval of q may open, close or turn."""
        low, high = self.low[0] / self.scale[0], self.high[0] / self.scale[0]
        found = [np.array([low, high]), self._meetings()]
        if place == 1:
            with np.errstate(divide="ignore", invalid="ignore"):
                found.append(-self.curves[:, 1] / (2.0 * self.curves[:, 0]))
        cuts = np.concatenate(found)
        inside: FloatArray = cuts[(cuts >= low) & (cuts <= high)]
        return inside

    def _interval(self, k: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Whether q exists at each k, and its interval, rounding allowed for."""
        powers = np.stack([k**2, k, np.ones_like(k)])
        values = self.curves @ powers
        room = 4e-15 * (np.abs(self.curves) @ powers)
        high = np.where(self.upper[:, None], values, np.inf)
        low = np.where(self.upper[:, None], -np.inf, values)
        top, bottom = high.min(axis=0), low.max(axis=0)
        slack = room[high.argmin(axis=0), np.arange(len(k))] + room[low.argmax(axis=0), np.arange(len(k))]
        good = top - bottom >= -slack
        if len(self.walls):
            good &= np.all(self.walls @ powers <= 4e-15 * (np.abs(self.walls) @ powers), axis=0)
        return good, bottom, np.maximum(top, bottom)


def _sizes(table: FloatArray, high: FloatArray) -> FloatArray:
    """Sizes of k and q = c^2 at which the rows turn, no greater than the ends of the box.

    A far end, as that of an open range, would hide all but the highest powers in rounding.
    """
    made = np.array([high[0], high[1] ** 2])
    for place, (column, power) in enumerate(((0, 0.5), (3, 1.0))):
        own, rest = np.abs(table[:, column]), np.abs(table[:, 2])
        good = (own > 0.0) & (rest > 0.0)
        if good.any():
            size = float(np.exp(power * np.log(rest[good] / own[good]).mean()))
            made[place] = min(made[place], size)
    return made


@lru_cache(maxsize=64)
def _pairs(count: int) -> tuple[IntArray, IntArray]:
    first, second = np.triu_indices(count, 1)
    return first, second


def _many_roots(rows: FloatArray) -> FloatArray:
    """Real roots of many quadratics a k^2 + b k + c, shape (n, 3), without cancellation."""
    a, b, c = rows.T
    square = b * b - 4.0 * a * c
    near = square >= -1e-14 * (b * b + np.abs(4.0 * a * c))
    root = np.sqrt(np.maximum(square, 0.0))
    large = -0.5 * (b + np.copysign(root, b))
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.concatenate([(large / a)[near], (c / large)[near]])
    finite: FloatArray = found[np.isfinite(found)]
    return finite


def _none(name: str, rounds: int) -> Found:
    claim = "proven in closed form: at a few speeds alone the limits leave no design"
    return Found("infeasible", None, claim, name, details={"rounds": rounds})


def _found(program: Program, name: str, x: FloatArray, rounds: int, reach: tuple[float, ...]) -> Found:
    aim = program.aim
    value = Judge(program).goal(x).value
    goal = value * (aim.sense if aim is not None else 1.0)
    claim = "proven in closed form: the best design at its worst speeds meets every limit at all speeds"
    return Found("optimal", x, claim, name, value, {"rounds": rounds, "goal": goal, "reach": reach})
