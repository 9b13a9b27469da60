"""Every local maximum of a sum of fractions over stretches of the frequency axis, with none left out.

The maxima of |g h| are wanted, h a sum of fractions and g a real weight.  On cells that are short against the
distance to the nearest pole, |g h|^2 is a polynomial and an error that is bounded.  Its Bernstein coefficients
say of each cell that it is too low, that it has no maximum inside, or that it is concave: then it has at most
one, which Newton finds.  A cell of which nothing is certain is halved.
"""

from __future__ import annotations

from functools import lru_cache
from math import comb, inf, sqrt

import numpy as np

from vibopt.arrays import FloatArray, IntArray
from vibopt.mechanics.cells import Stretches, cells
from vibopt.mechanics.polynomials import Fractions, Weight, derivative_sizes, weighted
from vibopt.records import dataclass

_FLAT = 1e-13
_ROUNDS = 40
_MOST = 20_000
_SETTLED = 3e-3
_NEWTON = 40
_EDGE = 1.0 + 1e-5
_SAME = 1e-5
_LEAST, _SQUARED = 1e-300, 1e150
_HIGHEST = 0.999
_PROBES = 4
_LEIBNIZ = np.zeros((3, 3, 3))
_LEIBNIZ[0, 0, 0] = _LEIBNIZ[0, 1, 1] = _LEIBNIZ[1, 0, 1] = _LEIBNIZ[0, 2, 2] = _LEIBNIZ[2, 0, 2] = 1.0
_LEIBNIZ[1, 1, 2] = 2.0
_LEIBNIZ.shape = (9, 3)
"""Which products of derivatives of two factors make each derivative of their product."""

Cells = tuple[FloatArray, FloatArray, IntArray]


@dataclass(frozen=True, slots=True)
class Maxima:
    """Local maxima and ends of stretches, ascending, and some frequencies between them; each with its value.

    at, value
        Shape (n,).
    probes, sizes
        Shape (m,): where the values can be compared with another way to find them.
    """

    at: FloatArray
    value: FloatArray
    probes: FloatArray
    sizes: FloatArray


def local_maxima(
    h: Fractions, weight: Weight | None, stretches: Stretches, ends: FloatArray, within: float
) -> Maxima | None:
    """Where |g h| has a local maximum, or an end of a stretch, no lower than `within` times the greatest.

    `ends` are the ends of all stretches in turn (2 n_stretches,).  Call it with warnings of numpy off.  None where a
    pole on the axis, a value of zero or rounding leaves a doubt.
    """
    made = cells(h.poles, stretches)
    if made is None:
        return None
    search = _Search(h, weight, ends, within)
    w, value = search.begin(made)
    if not 0.0 < search.best < _SQUARED or not search.run():
        return None
    count, last = len(ends), len(w) - 1
    probes = [i * last // _PROBES for i in range(_PROBES + 1)]
    floor = within * search.best
    beside = search.falling() if within < _HIGHEST else [True] * count
    both = zip(ends.tolist(), value[:count].tolist(), beside, strict=True)
    found = search.found + [(at, size) for at, size, falls in both if falls]
    maxima = np.array(_distinct(h, [one for one in found if one[1] >= floor])).reshape(-1, 2)
    return Maxima(maxima[:, 0], maxima[:, 1], w[probes], value[probes])


def _distinct(h: Fractions, found: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Each maximum once: two cells may claim the one on their common edge."""
    if len(found) < 2:
        return found
    made: list[tuple[float, float]] = []
    for w, value in sorted(found):
        if made and w - made[-1][0] <= _SAME * min(abs(w - pole) for pole, _ in h.pairs):
            made[-1] = max(made[-1], (w, value), key=lambda one: one[1])
        else:
            made.append((w, value))
    return made


@dataclass
class _Search:
    """State of one search: the greatest value met, the cells that are open, and the maxima found."""

    h: Fractions
    weight: Weight | None
    ends: FloatArray
    within: float

    def begin(self, made: Cells) -> tuple[FloatArray, FloatArray]:
        """Ends of stretches and middles of cells, and values there; keeps the cells that may be high enough."""
        h, weight, ends, (middle, half, which) = self.h, self.weight, self.ends, made
        count = len(ends)
        w = np.concatenate([ends, middle])
        apart = h.apart(w)
        value = np.abs(h.value(w, apart))
        top = h.ceiling(middle, half, apart[count:])
        if weight is not None:
            value *= weight.at(w, np.concatenate([np.arange(count) // 2, which]))
            top *= weight.ceiling(middle, half, which)
        self.best = float(value.max())
        chosen = (top >= self.within * self.best).nonzero()[0]
        self.open: Cells = (middle[chosen], half[chosen], which[chosen])
        self.apart = apart[count + chosen]
        self.found: list[tuple[float, float]] = []
        return w, value

    def falling(self) -> list[bool]:
        """Which ends of stretches, one after the other, have no higher values beside them."""
        ends = self.ends.tolist()
        falling = []
        for i, w in enumerate(ends):
            value, along, _ = self._derivatives(w, i // 2)
            slope = (value.conjugate() * along).real
            falling.append(slope >= 0.0 if i % 2 else slope <= 0.0)
        for i in range(1, len(ends) - 1, 2):
            if ends[i] == ends[i + 1]:
                falling[i] = falling[i + 1] = falling[i] and falling[i + 1]
        return falling

    def _derivatives(self, w: float, which: int) -> tuple[complex, complex, complex]:
        found = self.h.derivatives(w)
        return found if self.weight is None else self.weight.times(w, which, *found)

    def run(self) -> bool:
        """Find the maxima in all open cells; whether every cell was settled."""
        for _ in range(_ROUNDS):
            if len(self.open[0]) > _MOST:
                return False
            rest = self._judge() if len(self.open[0]) else self.open[2]
            if not len(rest):
                return True
            middle, half, which = self.open[0][rest], 0.5 * self.open[1][rest], self.open[2][rest]
            w = np.concatenate([middle - half, middle + half])
            self.open = (w, np.concatenate([half, half]), np.concatenate([which, which]))
            self.apart = self.h.apart(w)
        return False

    def _judge(self) -> IntArray:
        """Settle what can be settled, and say which cells must be halved."""
        middle, half, which = self.open
        series, missed = self.h.series(middle, half, self.apart)
        if self.weight is not None:
            series, missed = weighted(self.weight.series(middle, half, which), series, missed)
        count, n = series.shape
        table, parts = _bernstein(n)
        made = (series[:, :, None] * series.conj()[:, None, :]).real.reshape(count, n * n) @ table
        error = _errors(derivative_sizes(series), missed)
        low, high = np.minimum.reduceat(made, parts, axis=1) - error, np.maximum.reduceat(made, parts, axis=1) + error
        floor = (self.within * self.best) ** 2
        top, rise, bend = high.T
        left: IntArray = ((top >= floor) & (rise >= 0.0) & (low[:, 1] <= 0.0)).nonzero()[0]
        if not len(left):
            return left
        concave = bend[left] < 0.0
        for i in left[concave].tolist():
            self._climb(float(middle[i]), float(half[i]), int(which[i]), series[i].tolist())
        left = left[~concave]
        left = left[low[left, 2] <= 0.0]
        if not len(left):
            return left
        level = top[left] - low[left, 0] <= _FLAT * top[left]
        self.found += zip(middle[left[level]].tolist(), np.sqrt(top[left[level]]).tolist(), strict=True)
        rest: IntArray = left[~level]
        return rest

    def _climb(self, middle: float, half: float, which: int, series: list[complex]) -> None:
        """The maximum within a cell on which |g h|^2 is concave, unless the cell's end or beyond is higher."""
        left = max(middle - _EDGE * half, self.ends.item(2 * which))
        right = min(middle + _EDGE * half, self.ends.item(2 * which + 1))
        w = min(max(middle + half * _top(series), left), right)
        for _ in range(_NEWTON):
            step, square = _step(*self._derivatives(w, which))
            moved = min(max(w + step, left), right)
            if moved != w + step and moved == w:
                return
            settled = moved == w + step and abs(step) <= _SETTLED * half
            w = moved
            if settled:
                self.found.append((w, sqrt(max(square, 0.0))))
                self.best = max(self.best, self.found[-1][1])
                return
        self.best = inf  # nothing is certain then


def _top(series: list[complex]) -> float:
    """Where in [-1, 1] the sum of c_k t^k has its greatest size, as good as the steps of Newton are."""
    t = 0.0
    for _ in range(_NEWTON):
        value, along, twice = series[-1], 0j, 0j
        for one in series[-2::-1]:
            twice = twice * t + along
            along = along * t + value
            value = value * t + one
        moved = min(max(t + _step(value, along, 2.0 * twice)[0], -1.0), 1.0)
        if abs(moved - t) <= _SETTLED:
            return moved
        t = moved
    return t


def _step(value: complex, along: complex, twice: complex) -> tuple[float, float]:
    """Newton's step to where 1 / |value|^2 is least, and |value|^2 there, from a value and its derivatives.

    Beside a single pole the inverse is a parabola, and one step is enough.
    """
    turned = value.conjugate()
    slope = turned * along
    rise, square = slope.real, (value * turned).real
    # |slope|^2 is |value|^2 |along|^2
    fall = (3.0 * rise * rise - slope.imag**2) / max(square, _LEAST) - (turned * twice).real
    step = rise / max(fall, _LEAST)
    return step, square + rise * step


def _errors(sizes: FloatArray, missed: FloatArray) -> FloatArray:
    """By how much |series|^2 and its first two derivatives can be wrong on a cell, shape (n, 3).

    From bounds of the series and its derivatives, (n, 3), and of what it misses of them, (n, 3).
    """
    both = (2.0 * sizes + missed)[:, :, None] * missed[:, None, :]
    error: FloatArray = both.reshape(-1, 9) @ _LEIBNIZ
    return error


@lru_cache(maxsize=16)
def _bernstein(n: int) -> tuple[FloatArray, IntArray]:
    """From products c_i c_j* of n coefficients (n * n) to Bernstein coefficients of |sum c_k t^k|^2 on [-1, 1].

    Columns: 2n - 1 of the square, 2n - 2 of its derivative, 2n - 3 of its second derivative; where each begins.
    """
    degree = 2 * n - 2
    rows = []
    for k in range(degree + 1):
        first = _of_power(k, degree)
        second = [k * value for value in _of_power(k - 1, degree - 1)]
        third = [k * (k - 1) * value for value in _of_power(k - 2, degree - 2)]
        rows.append(first + second + third)
    power = np.arange(n)[:, None] + np.arange(n)
    return np.array(rows)[power].reshape(n * n, -1), np.array([0, 2 * n - 1, 4 * n - 3])


def _of_power(k: int, degree: int) -> list[float]:
    """Bernstein coefficients of t^k on [-1, 1]."""
    if k < 0:
        return [0.0] * (degree + 1)
    found = []
    for i in range(degree + 1):
        parts = [(-1) ** j * comb(degree - i, j) * comb(i, k - j) for j in range(k + 1)]
        found.append(sum(parts) / comb(degree, k))
    return found
