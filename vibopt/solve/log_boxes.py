"""Boxes of all variables in logs: whole ranges, values of lists, and what fades to zero."""

from __future__ import annotations

import numpy as np

from vibopt.arrays import BoolArray, FloatArray, IntArray
from vibopt.program.program import Program
from vibopt.records import cached_property, dataclass
from vibopt.solve.ranges import FLOOR

_SAME = 1e-9
"""Difference of logs that rounding may make."""


@dataclass(frozen=True)
class LogBoxes:
    """Boxes of logs, low and high (n_boxes, n_vars).

    orders
        Variables (i, j) of which x_i <= x_j may be asked.
    """

    program: Program
    orders: tuple[tuple[int, int], ...]

    @cached_property
    def whole(self) -> tuple[FloatArray, FloatArray]:
        """The one box of all designs, each (1, n_vars)."""
        low = np.where(self._from_zero, FLOOR * self.program.high, self.program.low)
        return np.log(low)[None], np.log(self.program.high)[None]

    @cached_property
    def lists(self) -> list[tuple[int, FloatArray]]:
        """Variables that are listed, and the logs of their values."""
        return [(i, np.log(np.sort(a.values))) for i, a in enumerate(self.program.axes) if a.values is not None]

    @cached_property
    def _from_zero(self) -> BoolArray:
        return np.array([axis.open_low or axis.low <= 0.0 for axis in self.program.axes])

    def fades(self, low: FloatArray) -> BoolArray:
        """Which variables of boxes go down to zero, (n_boxes, n_vars)."""
        return np.asarray(self._from_zero & (low <= self.whole[0]))

    def ends(self, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Least and greatest values [SI], each (n_boxes, n_vars)."""
        return np.where(self.fades(low), 0.0, np.exp(low)), np.exp(high)

    def in_other_order(self, low: FloatArray, high: FloatArray) -> BoolArray:
        """Boxes of which others hold the like of all designs, (n_boxes,)."""
        found = np.zeros(len(low), dtype=bool)
        for i, j in self.orders:  # what boxes that touch share is in others, too
            gap, wide = low[:, i] - high[:, j], (high > low)[:, i] & (high > low)[:, j]
            found |= (gap > 0.0) | (wide & (gap == 0.0))
        return found

    def halves(self, low: FloatArray, high: FloatArray, side: IntArray) -> tuple[FloatArray, FloatArray]:
        """Boxes (n_boxes, n_vars) cut in two across a side of each; what is listed goes from one value to another.

        Both ends of a box are values, so each half has one.
        """
        rows = np.arange(len(low))
        first, second = high.copy(), low.copy()
        first[rows, side] = second[rows, side] = 0.5 * (low + high)[rows, side]
        lows = np.stack([low, second], axis=1).reshape(-1, low.shape[1])
        highs = np.stack([first, high], axis=1).reshape(-1, low.shape[1])
        for i, values in self.lists:
            lows[:, i] = values[np.searchsorted(values, lows[:, i] - _SAME)]
            highs[:, i] = values[np.searchsorted(values, highs[:, i] + _SAME) - 1]
        return lows, highs
