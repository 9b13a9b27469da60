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
from vibopt.verify.motion_in_time import TAYLOR, TURN, carried, even_steps

_HALVED, _HIDDEN = 40, 1e-13
"""How often a first step is halved to find where what begins at zero is above it; part that rounding hides."""


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
    def onward(self) -> FloatArray:
        """All a step later, from all."""
        return carried(self.whole, np.eye(len(self.whole)), self.step)

    @cached_property
    def rows(self) -> FloatArray:
        """Coefficients of what falls against powers of time, from all, (n_terms, N + 3)."""
        rows = [np.zeros(len(self.whole)) if self.falls is None else self.falls]
        for k in range(1, TAYLOR):
            rows.append(rows[-1] @ self.whole / k)
        return np.array(rows)

    def run(self, span: tuple[float, float], now: FloatArray) -> Run:
        """From states (N,) at the beginning of a span of time [s] on."""
        (low, high), step, size = span, self.step, len(now)
        count = int((high - low) / step) + 1
        start = np.array([*now, cos(self.omega * low), sin(self.omega * low), 1.0])
        states = even_steps(self.onward, start, np.zeros((count + 1, len(start)))).T

        def moved(at: FloatArray) -> FloatArray:
            after = np.asarray(at, dtype=float) - low
            k = np.clip((after / step).astype(int), 0, count - 1)
            return carried(self.whole, states[:, k], after - k * step)[:size]

        for k in [] if self.falls is None else self._down(states):
            part = _falls((self.rows @ states[:, k]).tolist(), step, begins=not k)
            if part is not None:
                end = low + step * k + part
                return Run(moved, min(end, high), end < high)
        return Run(moved, high, False)

    def _down(self, states: FloatArray) -> list[int]:
        """Steps between states (N + 3, n_steps + 1) in which what falls may be down, at the end or by its slopes."""
        values, slopes = self.rows[:2] @ states
        first, last, slope, then = values[:-1], values[1:], slopes[:-1], slopes[1:]
        dips = (slope < 0.0) & (then > 0.0)
        lowest = first + slope * (last - first - then * self.step) / np.where(dips, slope - then, -1.0)
        return np.flatnonzero(((first >= 0.0) & (last <= 0.0)) | (dips & (lowest <= 0.0))).tolist()


def _falls(series: list[float], step: float, *, begins: bool) -> float | None:
    """Where a power series falls to zero within a step; None where it does not.

    One that `begins` at zero is counted from where rounding does not hide that it is above.
    """
    slopes = [k * one for k, one in enumerate(series)][1:]
    hidden = _HIDDEN * max(abs(one) * step**k for k, one in enumerate(series))
    parts = [0.0, *(step * 0.5**k for k in range(_HALVED if begins else 0, -1, -1))]
    if _sum(slopes, 0.0) < 0.0 < _sum(slopes, step):
        insort(parts, crossing(partial(_sum, slopes), 0.0, step))
    above = next((k for k, part in enumerate(parts) if _sum(series, part) > hidden), len(parts))
    if above == len(parts) or (above and not begins):
        return 0.0
    for low, high in pairwise(parts[above:]):
        if _sum(series, high) <= 0.0:
            return crossing(partial(_sum, series), low, high)
    return None


def _sum(series: list[float], at: float) -> float:
    """A power series at a time."""
    found = 0.0
    for one in reversed(series):
        found = found * at + one
    return found
