"""Greatest values of readings in time, of one machine and of many, as pieces of a motion are searched."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from vibopt.arrays import BoolArray, FloatArray, IntArray
from vibopt.records import dataclass


@dataclass(frozen=True, slots=True)
class Peak:
    """Greatest size of a reading: `value` with its sign [SI] at `time` [s]; infinite where it grows without end.

    within, part
        Index of the segment in which it lies, one past the last in the free vibration behind, and seconds from its
        beginning.  Infinite, with `time`, where it is what lasting sines near again and again.
    open
        Whether something greater may come later: what is next to undamped is followed over a thousand periods alone.
    """

    value: float
    time: float
    within: int = 0
    part: float = 0.0
    open: bool = False


@dataclass(frozen=True, slots=True)
class Peaks:
    """Those of many machines, (n,) each."""

    value: FloatArray
    time: FloatArray
    within: IntArray
    part: FloatArray
    open: BoolArray

    @classmethod
    def none(cls, count: int) -> Peaks:
        zeros = [np.zeros(count) for _ in range(3)]
        return cls(zeros[0], zeros[1], np.zeros(count, dtype=int), zeros[2], np.zeros(count, dtype=bool))

    @classmethod
    def of(cls, every: Iterable[Peaks]) -> Peaks:
        """Behind each other."""
        rows = [(peaks.value, peaks.time, peaks.within, peaks.part, peaks.open) for peaks in every]
        return cls(*(np.concatenate(column) for column in zip(*rows, strict=True)))

    def take(
        self, value: FloatArray, time: FloatArray, within: IntArray | int, part: FloatArray | float,
        those: IntArray | BoolArray | slice = slice(None),
    ) -> None:  # fmt: skip
        """Take up what was found of `those`; zero is nothing."""
        there = np.flatnonzero(value)
        which = np.arange(len(self.value))[those][there]
        for own, new in ((self.value, value), (self.time, time), (self.within, within), (self.part, part)):
            own[which] = new if np.ndim(new) == 0 else np.asarray(new)[there]

    def put(self, those: IntArray, others: Peaks) -> None:
        """Others in place of `those`."""
        for own, new in ((self.value, others.value), (self.time, others.time), (self.within, others.within),
                         (self.part, others.part), (self.open, others.open)):  # fmt: skip
            own[those] = new

    def each(self) -> list[Peak]:
        """One by one."""
        columns = (self.value, self.time, self.within, self.part, self.open)
        return [Peak(*row) for row in zip(*(column.tolist() for column in columns), strict=True)]
