"""Linear motion under a harmonic load, by Taylor's series in even steps, up to where a row of it falls through zero."""

from __future__ import annotations

from bisect import insort
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from math import cos, sin
from typing import NamedTuple

import numpy as np

from vibopt.arrays import FloatArray, crossing
from vibopt.records import cached_property, dataclass
from vibopt.verify.motion_in_time import TAYLOR, TURN

_HALVED, _HIDDEN, _GRAZING = 40, 1e-13, 1e-6
"""How often a first step is halved to find where what begins at zero is above it; part that rounding hides; part of
what falls by which it may begin below zero and begin there."""


class Run(NamedTuple):
    """States (N, n_times) against time up to an end [s], and whether it was stopped there."""

    moved: Callable[[FloatArray], FloatArray]
    end: float
    stopped: bool


@dataclass(frozen=True)
class Going:
    """Motion x' = system x + pushed cos(omega t) + stays; below its states go the cosine, the sine, and one.

    falls
        Row over all of these (N + 3,) that stops it where it falls through zero; None where nothing does.
    """

    system: FloatArray
    pushed: FloatArray
    stays: FloatArray
    omega: float
    falls: FloatArray | None = None

    @cached_property
    def whole(self) -> FloatArray:
        """Rates of all from all, (N + 3, N + 3)."""
        size = len(self.system)
        whole = np.zeros((size + 3, size + 3))
        whole[:size] = np.column_stack([self.system, self.pushed, np.zeros(size), self.stays])
        whole[size, size + 1], whole[size + 1, size] = -self.omega, self.omega
        return whole

    @cached_property
    def step(self) -> float:
        """Of the series [s]: a part of a turn of what is fastest."""
        return TURN / max(self.omega, float(np.abs(np.linalg.eigvals(self.system)).max()))

    @cached_property
    def series(self) -> FloatArray:
        """Coefficients of all against powers of time in steps, from all, (n_terms, N + 3, N + 3)."""
        found = [np.eye(len(self.whole))]
        for k in range(1, TAYLOR):
            found.append(found[-1] @ self.whole * (self.step / k))
        return np.array(found)

    @cached_property
    def rows(self) -> FloatArray:
        """The same of what falls, (n_terms, N + 3)."""
        assert self.falls is not None
        return np.asarray(self.falls @ self.series)

    @cached_property
    def _doubled(self) -> list[FloatArray]:
        """All so many steps later, from all: 1, 2, 4, ... of them, as many as were asked for."""
        return [self.series.sum(axis=0)]

    def _steps(self, start: FloatArray, count: int) -> FloatArray:
        """All from a start on after so many steps, (N + 3, n_steps + 1)."""
        states, many, powers = start[:, None], 0, self._doubled
        while states.shape[1] <= count:
            if many == len(powers):
                powers.append(powers[-1] @ powers[-1])
            states, many = np.hstack([states, powers[many] @ states]), many + 1
        return states[:, : count + 1]

    def run(self, span: tuple[float, float], now: FloatArray) -> Run:
        """From states (N,) at the beginning of a span of time [s] on."""
        (low, high), step, size = span, self.step, len(now)
        count = int((high - low) / step) + 1
        states = self._steps(np.array([*now, cos(self.omega * low), sin(self.omega * low), 1.0]), count)

        def moved(at: FloatArray) -> FloatArray:
            part = (np.asarray(at, dtype=float) - low) / step
            k = np.clip(part.astype(int), 0, count - 1)
            part -= k
            terms = self.series[:, :size] @ states[:, k]
            found: FloatArray = terms[-1]
            for term in terms[-2::-1]:
                found *= part
                found += term
            return found

        for k in [] if self.falls is None else self._down(states):
            part = _falls((self.rows @ states[:, k]).tolist(), begins=not k)
            if part is not None:
                end = low + step * (k + part)
                return Run(moved, min(end, high), end < high)
        return Run(moved, high, False)

    def _down(self, states: FloatArray) -> list[int]:
        """Steps between states (N + 3, n_steps + 1) in which what falls may be down, at the end or by its slopes.

        What begins below zero by no more than rounding begins there.
        """
        values, slopes = self.rows[:2] @ states
        if -_GRAZING * np.abs(values).max() < values[0] < 0.0:
            values[0] = 0.0
        first, last, slope, then = values[:-1], values[1:], slopes[:-1], slopes[1:]
        dips = (slope < 0.0) & (then > 0.0)
        lowest = first + slope * (last - first - then) / np.where(dips, slope - then, -1.0)
        return np.flatnonzero(((first >= 0.0) & (last <= 0.0)) | (dips & (lowest <= 0.0))).tolist()


def _falls(series: list[float], *, begins: bool) -> float | None:
    """Where a power series falls to zero between 0 and 1; None where it does not.

    One that `begins` at zero is counted from where rounding does not hide that it is above.
    """
    slopes = [k * one for k, one in enumerate(series)][1:]
    hidden, parts = _HIDDEN * max(map(abs, series)), [0.0, *(0.5**k for k in range(_HALVED if begins else 0, -1, -1))]
    if _sum(slopes, 0.0) < 0.0 < _sum(slopes, 1.0):
        insort(parts, crossing(partial(_sum, slopes), 0.0, 1.0))
    above = next((k for k, part in enumerate(parts) if _sum(series, part) > hidden), len(parts))
    if above == len(parts) or (above and not begins):
        return 0.0
    for low, high in pairwise(parts[above:]):
        if _sum(series, high) <= 0.0:
            return crossing(partial(_sum, series), low, high)
    return None


def _sum(series: list[float], at: float) -> float:
    """A power series at a place."""
    found = 0.0
    for one in reversed(series):
        found = found * at + one
    return found
