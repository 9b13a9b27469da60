"""One variable of any machine: the program at a few speeds is solved exactly, then speeds are added.

Each limit at a speed is a polynomial inequality; one mass is answered by the closed form of many questions.
"""

from __future__ import annotations

from dataclasses import field

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.program.program import Limit, Program
from vibopt.records import dataclass
from vibopt.solve.branch import violation
from vibopt.solve.closed_form import best_found, closed_found, none_found
from vibopt.solve.closed_program import NotClosedError, Question, question
from vibopt.solve.method import Found, Progress
from vibopt.solve.rows import LineRows

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
            if not limit.form.drives or all(band.is_point for band in limit.form.drives[0].bands):
                continue
            least, found = limit.least_wanted, limit.candidates(x)
            missed = violation(limit, (min if least else max)(value for _, value in found), x)
            worst = max(worst, missed)
            if missed > _DONE:
                broken = [speeds[0] for speeds, value in found if violation(limit, value, x) > _DONE]
                fresh = [speed for speed in broken if speed not in self.known[index]]
                self.known[index] += fresh
                self.fresh[index] += fresh
        return worst


def _first(limit: Limit) -> list[float]:
    if not limit.form.drives:
        return [0.0]
    ends = [speed for band in limit.form.drives[0].bands for speed in (band.low, band.high)]
    return list(dict.fromkeys(ends))


class OneVariable:
    """One design variable: every limit is a polynomial inequality at each speed."""

    name = "closed_form"
    summary = "roots of polynomials in the one variable, over the worst speeds"

    def __init__(self) -> None:
        self._last: tuple[Program, Question | None] | None = None

    def _asked(self, program: Program) -> Question | None:
        """The program as numbers of one mass; None where it is no such."""
        if self._last is None or self._last[0] is not program:
            try:
                self._last = program, question(program)
            except NotClosedError:
                self._last = program, None
        return self._last[1]

    def refuses(self, program: Program) -> str | None:
        if program.several:
            return "the limits speak of several machines, the same design within its tolerances."
        if len(program.axes) != 1 or program.axes[0].values is not None:
            return "there is not exactly one continuous variable."
        if self._asked(program) is not None:
            return None
        if program.aim is not None and program.aim.direction(0) is None:
            return f"the goal {program.aim.name} does not simply rise or fall with {program.axes[0].path}."
        rows = LineRows.of(program)
        for limit in program.limits:
            if not rows.accepts(limit):
                return f"the limit {limit.name} is no polynomial inequality."
        return None

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """Status "optimal" or "infeasible", both proven."""
        asked = self._asked(program)
        if asked is not None:
            return closed_found(program, asked, self.name)
        rows, speeds = LineRows.of(program), Speeds(program)
        upward = program.aim.direction(0) if program.aim is not None else 1.0
        table: list[FloatArray] = []
        for round_number in range(1, _ROUNDS + 1):
            table += [row for limit, new in speeds.take() for row in rows.at(limit, new)]
            best = self._relaxed(program, rows, table, upward or 1.0)
            if best is None:
                return none_found(self.name, round_number)
            x = np.array(best[:1])
            if speeds.learn(x) <= _DONE:
                return best_found(program, self.name, x, round_number, best[1:])
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
    if len(row) > 3:
        from vibopt.mechanics.polynomials import real_roots

        return real_roots(row, 1e-7, 3)
    c, b, a = row.tolist()
    square = b * b - 4.0 * a * c
    if square < -1e-14 * (b * b + abs(4.0 * a * c)):
        return np.zeros(0)
    large = -0.5 * (b + np.copysign(np.sqrt(max(square, 0.0)), b))
    return np.array([large / a, c / large]) if large else np.zeros(1)
