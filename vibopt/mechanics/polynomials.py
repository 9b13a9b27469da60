"""A response as a sum of fractions: h(w) = sum_j r_j / (w - p_j) + c0 + c1 w, with bounds of its Taylor series."""

from __future__ import annotations

from functools import lru_cache
from math import comb

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.records import cached_property, dataclass

_LEADS = 1e-6
"""Part of the greatest coefficient from which on one may be divided by."""


def roots(ascending: FloatArray) -> ComplexArray:
    """Roots of a polynomial (degree + 1,); those at zero or without end are left out, all are nan without digits.

    A coefficient that leads and is small, or nothing but rounding, takes half or all of the digits of every root: the
    greater end leads, and where both are small neither is divided by.
    """
    used = np.flatnonzero(ascending)
    if len(used) < 2:
        return np.zeros(0, dtype=complex)
    rows = ascending[used[0] : used[-1] + 1]
    n = len(rows) - 1
    if not np.isfinite(rows).all():
        return np.full(n, np.nan, dtype=complex)
    rows = rows / np.abs(rows).max()
    turned = bool(abs(rows[0]) > abs(rows[-1]))
    if turned:
        rows = rows[::-1]
    companion = np.zeros((n, n))
    companion[np.arange(1, n), np.arange(n - 1)] = 1.0
    companion[0] = -rows[-2::-1]
    with np.errstate(all="ignore"):
        if abs(rows[-1]) >= _LEADS:
            companion[0] /= rows[-1]
            found = np.linalg.eigvals(companion)
        else:
            from scipy.linalg import eigvals

            found = eigvals(companion, np.diag(np.append(rows[-1], np.ones(n - 1))))
        found = np.asarray(1.0 / found if turned else found, dtype=complex)
    return np.asarray(found[np.isfinite(found) & (found != 0.0)])


def moved_by_rounding(ascending: FloatArray, found: ComplexArray) -> FloatArray:
    """By how much rounding may have moved the roots that `roots` found, to first order, shape (n,).

    A root of n that lie close together moves by a great deal, as the slope there is next to nothing.
    """
    size, slope = np.abs(found), ascending[1:] * np.arange(1, len(ascending))
    lost = np.finfo(float).eps * len(found) * np.abs(ascending).max()
    with np.errstate(all="ignore"):
        steep = np.abs((found[:, None] ** np.arange(len(slope))) @ slope)
        return np.asarray(lost * (size[:, None] ** np.arange(len(ascending))).sum(axis=1) / steep)


def real_roots(ascending: FloatArray, near: float, steps: int, least: float = 0.0) -> FloatArray:
    """Real roots of a polynomial, polished by Newton's rule.

    Parameters
    ----------
    ascending
        Coefficients, shape (degree + 1,).
    near
        Imaginary part over the size of a root up to which it counts as real.
    steps
        Of Newton's rule.
    least
        Size that a small root is taken to have for that.
    """
    every = roots(ascending)
    real = every[np.abs(every.imag) <= near * np.maximum(np.abs(every.real), least)].real
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(steps):
            value, slope = np.zeros(len(real)), np.zeros(len(real))
            for one in ascending[::-1].tolist():
                value, slope = value * real + one, slope * real + value
            real = real - np.divide(value, slope, out=np.zeros(len(real)), where=slope != 0.0)
    if len(ascending) > 1 and ascending[0] == 0.0 and ascending.any():
        real = np.append(real, 0.0)
    found: FloatArray = real
    return found


def stationary(top: ComplexArray, bottom: ComplexArray, power: int) -> FloatArray:
    """Coefficients in u = v^2, ascending, whose roots make u^power |N|^2 / |D|^2 stationary."""
    p, q = _squared(top), _squared(bottom)
    dp, dq = p[1:] * np.arange(1, len(p)), q[1:] * np.arange(1, len(q))
    left, right = np.convolve(dp, q) if len(dp) else np.zeros(1), np.convolve(p, dq)
    total = np.zeros(len(p) + len(q))
    shift = 1 if power else 0
    total[shift : shift + len(left)] += left
    total[shift : shift + len(right)] -= right
    if power:
        both = np.convolve(p, q)
        total[: len(both)] += power * both
    return total


def _squared(turned: ComplexArray) -> FloatArray:
    """|.|^2 on real v as a polynomial in v^2, from coefficients in v of which even are real and odd imaginary."""
    even, odd = turned[::2].real, turned[1::2].imag
    square = np.zeros(len(turned))
    first = np.convolve(even, even)
    square[: len(first)] += first
    if len(odd):
        second = np.convolve(odd, odd)
        square[1 : 1 + len(second)] += second
    return square


ORDER = 7
"""Order of the Taylor series on a cell."""
_RHO = 0.34
_NEXT = ORDER + 1
_TAIL = np.array(
    [
        1.0 / (1.0 - _RHO),
        _NEXT / (1.0 - _RHO) + _RHO / (1.0 - _RHO) ** 2,
        _NEXT * ORDER / (1.0 - _RHO) + 2.0 * _NEXT * _RHO / (1.0 - _RHO) ** 2 + 2.0 * _RHO**2 / (1.0 - _RHO) ** 3,
    ]
)
"""sum rho^k, sum k rho^k and sum k (k - 1) rho^k over k > ORDER, in units of rho^(ORDER + 1), for rho <= _RHO."""
_ROUNDING = 1e-14
_MISSED = np.array([[_ROUNDING] * 3, _TAIL])


@dataclass(frozen=True)
class Fractions:
    """h(w) = sum_j residues_j / (w - poles_j) + constant + growth w; poles, residues (m,), sizes = |residues|."""

    poles: ComplexArray
    residues: ComplexArray
    sizes: FloatArray
    constant: complex = 0.0
    growth: complex = 0.0

    @property
    def rest(self) -> bool:
        """Whether there is more than the fractions."""
        return bool(self.constant or self.growth)

    def apart(self, w: FloatArray) -> ComplexArray:
        """1 / (w - p_j), shape (n, m)."""
        return np.reciprocal(w[:, None] - self.poles)

    def value(self, w: FloatArray, apart: ComplexArray) -> ComplexArray:
        """h at frequencies w (n,), shape (n,)."""
        found: ComplexArray = apart @ self.residues
        return found + self.constant + self.growth * w if self.rest else found

    def derivatives(self, w: float) -> tuple[complex, complex, complex]:
        """h and its first two derivatives at one frequency."""
        value, along, twice = self.constant + self.growth * w, self.growth, 0j
        for pole, part in self.pairs:
            apart = 1.0 / (w - pole)
            part *= apart
            value += part
            part *= apart
            along -= part
            twice += part * apart
        return value, along, 2.0 * twice

    @cached_property
    def pairs(self) -> list[tuple[complex, complex]]:
        """Poles and their residues as plain numbers, quicker one by one."""
        return list(zip(self.poles.tolist(), self.residues.tolist(), strict=True))

    def ceiling(self, w: FloatArray, half: FloatArray, apart: ComplexArray) -> FloatArray:
        """No |h| is greater on the cells w +- half, shape (n,)."""
        size = np.abs(apart)
        found: FloatArray = (size / (1.0 - half[:, None] * size)) @ self.sizes
        if self.rest:
            found += abs(self.constant) + abs(self.growth) * (np.abs(w) + half)
        return found

    def series(self, w: FloatArray, half: FloatArray, apart: ComplexArray) -> tuple[ComplexArray, FloatArray]:
        """Taylor coefficients on cells in t = (w - middle) / half, (n, ORDER + 1), and what they miss, (n, 3).

        The second bounds the rest of the series, and that of its first and second derivative in t.
        """
        count, poles = apart.shape
        powers: ComplexArray = np.empty((_NEXT + 1, count, poles), dtype=complex)
        ratio = apart * -half[:, None]
        np.multiply(apart, self.residues, out=powers[0])
        np.multiply(powers[0], ratio, out=powers[1])
        square = ratio * ratio
        np.multiply(powers[:2], square, out=powers[2:4])
        square *= square
        np.multiply(powers[:4], square, out=powers[4:8])
        np.multiply(powers[4], square, out=powers[8])
        ones = _ones(poles)
        sums = np.asarray(powers[:8].reshape(_NEXT * count, poles) @ ones, dtype=complex)
        coefficients = sums.reshape(_NEXT, count).T
        missed: FloatArray = (np.abs(powers[::8]) @ ones).T @ _MISSED
        if self.rest:
            coefficients[:, 0] = coefficients[:, 0] + self.constant + self.growth * w
            coefficients[:, 1] = coefficients[:, 1] + self.growth * half
            missed += _ROUNDING * (abs(self.constant) + abs(self.growth) * np.abs(w))[:, None]
        return coefficients, missed


@dataclass(frozen=True, slots=True)
class Weight:
    """Real weights (constant + slope w) w**power, one per stretch of the axis; all shape (n_stretches,)."""

    constant: FloatArray
    slope: FloatArray
    power: IntArray

    @property
    def degree(self) -> int:
        """Greatest degree in w."""
        return int(self.power.max()) + bool(self.slope.any())

    def at(self, w: FloatArray, which: IntArray) -> FloatArray:
        """Size of the weight of stretch `which` (n,) at w (n,), shape (n,)."""
        value: FloatArray = np.abs(self.constant[which] + self.slope[which] * w) * w ** self.power[which]
        return value

    def ceiling(self, w: FloatArray, half: FloatArray, which: IntArray) -> FloatArray:
        """No size of the weight is greater on the cells w +- half, shape (n,)."""
        constant, slope, high = self.constant[which], self.slope[which], w + half
        line = np.maximum(np.abs(constant + slope * (w - half)), np.abs(constant + slope * high))
        value: FloatArray = line * high ** self.power[which]
        return value

    def times(
        self, w: float, which: int, value: complex, along: complex, twice: complex
    ) -> tuple[complex, complex, complex]:
        """The weight of a stretch times a function at one frequency, and two derivatives."""
        power, slope = int(self.power[which]), float(self.slope[which])
        line = float(self.constant[which]) + slope * w
        q = w**power
        q1 = power * w ** max(power - 1, 0)
        q2 = power * (power - 1) * w ** max(power - 2, 0)
        g, g1, g2 = line * q, line * q1 + slope * q, line * q2 + 2.0 * slope * q1
        return g * value, g1 * value + g * along, g2 * value + 2.0 * g1 * along + g * twice

    def series(self, w: FloatArray, half: FloatArray, which: IntArray) -> FloatArray:
        """Taylor coefficients on cells in t = (w - middle) / half, shape (n, degree + 1)."""
        found = np.zeros((len(w), self.degree + 1))
        power, line = self.power[which], self.constant[which] + self.slope[which] * w
        for i in range(int(self.power.max()) + 1):
            ways = np.array([comb(one, i) for one in power.tolist()], dtype=float)
            part = ways * w ** np.maximum(power - i, 0) * half**i
            found[:, i] += part * line
            if self.slope.any():
                found[:, i + 1] += part * self.slope[which] * half
        return found


def weighted(weight: FloatArray, coefficients: ComplexArray, missed: FloatArray) -> tuple[ComplexArray, FloatArray]:
    """Series of a weight (n, d + 1) times a series that misses some, as (coefficients, missed)."""
    n, d = coefficients.shape[1], weight.shape[1]
    found = np.zeros((len(weight), n + d - 1), dtype=complex)
    for i in range(d):
        found[:, i : i + n] += weight[:, i, None] * coefficients
    g, g1, g2 = derivative_sizes(weight).T
    e, e1, e2 = missed.T
    return found, np.array([g * e, g1 * e + g * e1, g2 * e + 2.0 * g1 * e1 + g * e2]).T


def derivative_sizes(coefficients: ComplexArray | FloatArray) -> FloatArray:
    """Bounds of a polynomial and of its first and second derivative on [-1, 1], shape (n, 3)."""
    found: FloatArray = np.abs(coefficients) @ _counts(coefficients.shape[1])
    return found


@lru_cache(maxsize=128)
def _ones(n: int) -> FloatArray:
    return np.ones(n)


@lru_cache(maxsize=32)
def _counts(n: int) -> FloatArray:
    k = np.arange(n, dtype=float)
    return np.array([np.ones(n), k, k * (k - 1.0)]).T
