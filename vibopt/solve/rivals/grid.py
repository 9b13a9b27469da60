"""Grid search: every combination of values, limits looked at on 200 speeds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vibopt.arrays import FloatArray
from vibopt.errors import counted
from vibopt.program.program import Axis, Limit, Program
from vibopt.records import dataclass
from vibopt.solve.method import Found, Progress
from vibopt.solve.ranges import log_box
from vibopt.solve.rivals.sampled import outside_rows, values_on
from vibopt.work import late

_PER_AXIS = {1: 2000, 2: 121, 3: 25, 4: 11, 5: 7, 6: 5}
_MOST = 100_000
"""Points of a grid: 40 values of each of three numbers are fewer, and those of four take minutes."""


@dataclass
class Grid:
    """Best point of a log-spaced grid whose limits hold on the sampled speeds.

    per_axis
        Values per variable; 0 takes as many as make a few ten thousand points.
    """

    per_axis: int = 0
    speeds: int = 200
    name: str = "grid"
    summary: str = "grid search, limits on 200 sampled speeds"

    def refuses(self, program: Program) -> str | None:
        """More than six variables, or a hundred thousand points."""
        free = sum(axis.values is None and axis.high > axis.low for axis in program.axes)
        if free > 6:
            return f"grid takes at most 6 continuous variables, and there are {free}."
        many = self.per_axis**free
        return (
            f"grid takes at most {_MOST} points, and {self.per_axis} of each number are {many}."
            if many > _MOST
            else None
        )

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """Walk the grid; the goal decides the order, so the first point that holds is the best."""
        points = self._points(program)
        many = counted(len(points), "points")
        points = points[np.argsort(self._goals(program, points), kind="stable")]
        for begin in range(0, len(points), 64):
            if late(counted(begin, "points of a grid")):
                return Found("unproven", None, f"time is over after {begin} of {many}", self.name)
            chunk = points[begin : begin + 64]
            good = self._holding(program, chunk)
            if len(good):
                claim = f"best of a grid of {many} (limits at {counted(self.speeds, 'sampled speeds')})"
                return Found("feasible", good[0], claim, self.name)
        return Found("unproven", None, f"no point of a grid of {many} meets every limit", self.name)

    def _points(self, program: Program) -> FloatArray:
        low, high = log_box(program)
        free = sum(axis.values is None and axis.high > axis.low for axis in program.axes)
        count = self.per_axis or _PER_AXIS.get(free, 5)
        rows = [_values(axis, a, b, count) for axis, a, b in zip(program.axes, low, high, strict=True)]
        return np.stack([one.ravel() for one in np.meshgrid(*rows, indexing="ij")], axis=-1)

    def _goals(self, program: Program, points: FloatArray) -> FloatArray:
        aim = program.aim
        if aim is None:
            return np.zeros(len(points))
        return aim.sense * values_on(aim.form, aim.model, points, self.speeds, least_wanted=aim.sense < 0)

    def _holding(self, program: Program, points: FloatArray) -> FloatArray:
        for limit in program.limits:
            if len(points):
                points = points[self._holds(limit, points)]
        return points

    def _holds(self, limit: Limit, points: FloatArray) -> NDArray[np.bool_]:
        if limit.side == "outside":
            return np.array([outside_rows(limit, np.log(x))[0].max() <= 0.0 for x in points])
        least_wanted = limit.side == "at_least"
        values = values_on(limit.form, limit.model, points, self.speeds, least_wanted=least_wanted)
        return values >= limit.bound if least_wanted else values <= limit.bound


def _values(axis: Axis, low: float, high: float, count: int) -> FloatArray:
    if axis.values is not None:
        return np.array(axis.values)
    if axis.high <= axis.low:
        return np.array([axis.low])
    made: FloatArray = np.clip(np.exp(np.linspace(low, high, count)), axis.low, axis.high)
    return made
