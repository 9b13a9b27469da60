"""A design made as good as it can be near where it is, limits exact; discrete values stay."""

from __future__ import annotations

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.program.program import Program
from vibopt.solve.branch import Judge
from vibopt.solve.measured_pieces import SLOPES, Exact
from vibopt.solve.ranges import log_box, on_values, starts
from vibopt.solve.sqp import Sqp
from vibopt.work import Budget, late

_CLEAR = 1e-6
_MEASUREMENTS, _FOLLOWED = 1000, 24
"""Exact measurements from anywhere, and from what is near an optimum."""
_STEP = 0.8
"""Work of a step beside its measurement [nominal ms]."""


def improved(program: Program, x: FloatArray, judge: Judge) -> FloatArray:
    """A feasible design no worse than the feasible `x` (n_vars,), sharp where the limits are regular."""
    x, value = _to_ends(program, judge, np.array(x, dtype=float))
    if program.aim is None:
        return x
    there = refined(program, x)
    if there is not None and judge.feasible(there):
        other = judge.goal(there).value
        if other <= value + 1e-15 * abs(value):
            return _to_ends(program, judge, there)[0]
    return x


def rescued(program: Program, middles: FloatArray, judge: Judge) -> FloatArray | None:
    """A feasible design from the middles of boxes (n, n_vars) or from starts spread over the whole range."""
    spread = np.exp(starts(program, 6))
    for x in [*middles, *spread]:
        x = on_values(program, x)
        if judge.feasible(x):
            return x
        there = refined(program, x, only_feasible=True)
        if there is not None and judge.feasible(there):
            return there
    return None


def from_starts(program: Program, x: FloatArray, judge: Judge) -> FloatArray:
    """The best of the feasible `x` (n_vars,) and of what eight starts spread over the range lead to."""
    best, value = x, judge.goal(x).value
    for start in np.exp(starts(program, 8)):
        if late("the search from other starts"):
            break
        there = refined(program, on_values(program, start))
        if there is not None and judge.feasible(there) and judge.goal(there).value < value:
            best, value = there, judge.goal(there).value
    return best


def refined(program: Program, x: FloatArray, *, only_feasible: bool = False, near: bool = False) -> FloatArray | None:
    """Where sequential programming on the exact peaks leads from x (n_vars,); None where nothing is continuous.

    What is `near` an optimum is followed by Newton first, and not far where that leads nowhere.
    """
    low, high = log_box(program)
    for i, axis in enumerate(program.axes):
        if axis.values is not None:
            low[i] = high[i] = np.log(max(x[i], 1e-300))
    if not (high > low).any():
        return None
    most, cost = _FOLLOWED if near else _MEASUREMENTS, _STEP + SLOPES * program.cost
    exact = Exact(program, low, high, Budget(most, "exact measurements", cost))
    start = np.log(np.maximum(x, np.exp(low)))
    beside = Sqp(exact).beside(start) if near else None
    point = beside or Sqp(exact).run(start, only_feasible=only_feasible)
    there = np.exp(point.y)
    for i, axis in enumerate(program.axes):
        if axis.values is not None:
            there[i] = x[i]
        elif point.y[i] >= high[i] and np.isfinite(axis.high):
            there[i] = axis.high
        elif point.y[i] <= low[i] and axis.low > 0.0:
            there[i] = axis.low
    return there


def _to_ends(program: Program, judge: Judge, x: FloatArray) -> tuple[FloatArray, float]:
    """Each continuous variable moved to the better end of its range where the limits allow it."""
    value = judge.goal(x).value
    for i, axis in enumerate(program.axes):
        for end in (axis.low, axis.high):
            if axis.values is not None or end == x[i]:
                continue
            there = x.copy()
            there[i] = end
            if _no_better(program, there, value):
                continue
            other = judge.goal(there).value
            if other < value and judge.feasible(there):
                x, value = there, other
    return x, value


def _no_better(program: Program, x: FloatArray, value: float) -> bool:
    """Whether a look at some speeds shows already that the goal at x (n_vars,) is no less than `value`."""
    aim = program.aim
    if aim is None or aim.sense < 0 or not aim.form.drives or (x <= 0.0).any():
        return False
    found = aim.form.glance(aim.model, x[None, :])
    return found is not None and bool(found[0] > (1.0 + _CLEAR) * value)
