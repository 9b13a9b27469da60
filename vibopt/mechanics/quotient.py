"""Where a numerator over a denominator, both polynomials of a frequency, is greatest in a band, and its derivatives.

Stationary points are roots of one more polynomial.  What rounding could spoil is found by checks, and then there is no
answer.
"""

from __future__ import annotations

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray
from vibopt.mechanics.polynomials import moved_by_rounding, roots, stationary
from vibopt.records import cached_property, dataclass

_LIGHT, _SHARP = 1e-7, 1e-2
"""Damping of a pole, of critical, that is next to none, and below which a root may be too far from its peak."""
_BESIDE = 2.0
"""How far beside a band, as a factor, points count that may lie in it."""
_LOOKED_AT, _SPREAD = np.sinh(np.linspace(-3.0, 3.0, 25)), 34
"""Distances from a pole, over its damping, at which the slope is looked at; and how many speeds from end to end."""
_APART = 1e-6
"""Part of a frequency within which the slope beside a stationary point says nothing."""
_POLISHES = 8
_DONE = 1e-11
_AT_REST = 1e-7
_TURN = np.array([1j**k for k in range(32)])


@dataclass(frozen=True)
class Polynomials:
    """N and D of one design against v = w / unit.

    tables
        Of N and of D: coefficients of the value and of its first and second derivative in v, each
        (degree + 1, n_columns).
    sizes
        Absolute coefficients of N and of D.
    unit, size
        What v and the value are multiplied by.
    """

    tables: tuple[tuple[ComplexArray, ...], tuple[ComplexArray, ...]]
    sizes: tuple[FloatArray, FloatArray]
    unit: float
    size: float
    power: int

    @classmethod
    def of(cls, top: FloatArray, bottom: FloatArray, power: int) -> Polynomials | None:
        """From coefficients in s; None without a numerator or where the denominator has no turning point."""
        n, d = top[:, 0], bottom[:, 0]
        used_n, used_d = np.flatnonzero(n), np.flatnonzero(d)
        if not len(used_n) or len(used_d) < 2:
            return None
        first, last = int(used_d[0]), int(used_d[-1])
        unit = float((d[first] / d[last]) ** (1.0 / (last - first)))
        if not 1e-30 < unit < 1e30:
            return None
        tables, sizes, scales = [], [], []
        for side in (top[: used_n[-1] + 1], bottom[: last + 1]):
            powers = unit ** np.arange(len(side))
            made = side * powers[:, None]
            scales.append(float(np.abs(made[:, 0]).max()))
            made = made / scales[-1]
            turned = made * _TURN[: len(side), None]
            steps = np.arange(1.0, len(side))[:, None]
            once = turned[1:] * steps
            tables.append((turned, once, once[1:] * steps[:-1]))
            sizes.append(np.abs(made[:, 0]))
        size = scales[0] / scales[1]
        if not (np.isfinite(size) and size > 0.0):
            return None
        return cls((tables[0], tables[1]), (sizes[0], sizes[1]), unit, size, power)

    @cached_property
    def turning(self) -> tuple[FloatArray, BoolArray, FloatArray]:
        """Points near which the value may be stationary, whether it must be, and those where rounding hides whether."""
        slope = stationary(self.tables[0][0][:, 0], self.tables[1][0][:, 0], self.power)
        turning = roots(slope)
        turning = turning[turning.real > 0.0]
        off, size = np.abs(turning.imag), np.abs(turning)
        near = off <= 1e-3 * size
        hidden = ~near & ~(off > moved_by_rounding(slope, turning))
        return np.sqrt(turning[near].real), off[near] <= 1e-10 * size[near], np.sqrt(size[hidden])

    @cached_property
    def poles(self) -> ComplexArray:
        """Complex v at which D is zero."""
        turned = self.tables[1][0][:, 0] / _TURN[: len(self.sizes[1])]
        return roots(turned.real) * -1j

    def sides(self, v: FloatArray) -> tuple[list[ComplexArray], list[ComplexArray]]:
        """N and D with their derivatives in v (none, one, two), each (n_points, n_columns)."""
        powers = v[:, None] ** np.arange(max(len(self.sizes[0]), len(self.sizes[1])))
        top, bottom = ([powers[:, : len(one)] @ one for one in table] for table in self.tables)
        return top, bottom

    def doubt(self, v: FloatArray, side: int) -> FloatArray:
        """By how much rounding grows in N (0) or D (1) at points v, shape of `v`."""
        powers = v[:, None] ** np.arange(len(self.sizes[side]))
        value = np.abs(powers @ self.tables[side][0][:, 0])
        grown: FloatArray = (powers @ self.sizes[side]) / value
        return np.where(np.isnan(grown), np.inf, grown)

    def rise(self, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """First and second derivative of the log of the value in v."""
        values = (v[:, None] ** np.arange(len(self._both))) @ self._both
        once = values[:, 2:4] / values[:, :2]
        both = once.real, (values[:, 4:] / values[:, :2] - once**2).real
        first, second = (one[:, 0] - one[:, 1] for one in both)
        if self.power:
            first += self.power / v
            second -= self.power / v**2
        return first, second

    @cached_property
    def _both(self) -> ComplexArray:
        """Coefficients of N and D, of their first and of their second derivatives in v, (degree + 1, 6)."""
        both = np.zeros((max(len(self.sizes[0]), len(self.sizes[1])), 6), dtype=complex)
        for side, table in enumerate(self.tables):
            for order, one in enumerate(table):
                both[: len(one), 2 * order + side] = one[:, 0]
        return both

    def in_band(self, low: float, high: float) -> FloatArray | None:
        """Local maxima in [low, high] and ends from which the value falls, (n, 2): v, and 1 where it is a maximum.

        None where maxima and minima do not take turns, a pole in reach has next to no damping, or rounding hides some:
        beside absorbers nearly alike a maximum and a minimum may be lost together.
        """
        if low == high:
            return np.array([[low, 0.0]])
        start = max(low, _AT_REST * high)
        reach = np.abs(self.poles.real)
        near = (reach >= 0.999 * start) & (reach <= 1.001 * high)
        damping = np.abs(self.poles.imag) / np.abs(self.poles)
        if (near & (damping <= _LIGHT)).any():
            return None
        ends = self.rise(np.array([start, high]))[0]
        at = self._polished(start, high, reach[near & (damping < _SHARP)])
        if at is None or not np.isfinite(ends).all():
            return None
        kinds = np.concatenate([[np.sign(ends[0])], at[1], [np.sign(ends[1])]])
        if not _take_turns(kinds) or not self._turns_as_told(start, high, at[0], kinds[0]):
            return None
        found = [[v, 1.0] for v in at[0][at[1] < 0.0]]
        found += [[low, 0.0]] if ends[0] <= 0.0 else []
        found += [[high, 0.0]] if ends[1] >= 0.0 else []
        return np.array(found)

    def _turns_as_told(self, low: float, high: float, at: FloatArray, begun: float) -> bool:
        """Whether the value rises and falls between the stationary points as they say, where rounding may hide some.

        Looked at as densely as the poles are damped: no peak is narrower.
        """
        hidden = self.turning[2]
        if not ((hidden >= low / _BESIDE) & (hidden <= high * _BESIDE)).any():
            return True
        beside = np.abs(self.poles.real)[:, None] + np.abs(self.poles.imag)[:, None] * _LOOKED_AT
        v = np.concatenate([beside.ravel(), np.linspace(low, high, _SPREAD)[1:-1]])
        v = v[(v > low) & (v < high)]
        if len(at):
            v = v[np.abs(v[:, None] - at).min(axis=1) > _APART * v]
        turned = np.where((v[:, None] > at).sum(axis=1) % 2, -begun, begun)
        return bool((np.sign(self.rise(v)[0]) == turned).all())

    def _polished(self, low: float, high: float, resonances: FloatArray) -> tuple[FloatArray, FloatArray] | None:
        """Stationary points inside, ascending, and the sign of the bend at each."""
        v = np.concatenate([self.turning[0], resonances])
        must = np.concatenate([self.turning[1], np.zeros(len(resonances), dtype=bool)])
        inside = (v > 0.999 * low) & (v < 1.001 * high)
        v, must = v[inside], must[inside]
        settled = np.zeros(len(v), dtype=bool)
        second = np.zeros(len(v))
        for _ in range(_POLISHES):
            if not len(v):
                break
            first, second = self.rise(v)
            step = np.where(second != 0.0, -first / second, v)
            settled = np.abs(second) * step**2 <= _DONE
            v = v + np.clip(step, -0.1 * v, 0.1 * v)
            if settled.all():
                break
        if (must & ~settled).any():
            return None
        order = np.argsort(v[settled])
        v, second = v[settled][order], second[settled][order]
        inside = (v > low) & (v < high)
        v, second = v[inside], second[inside]
        fresh = np.append(True, (v[1:] - v[:-1]) * np.sqrt(np.abs(second[1:])) > 1e-5) if len(v) else np.zeros(0, bool)
        return v[fresh], np.sign(second[fresh])


def _take_turns(kinds: FloatArray) -> bool:
    """Whether signs of slope at the start, of bends and of slope at the end fit a smooth curve.

    Up at the start wants a maximum next, down at the end wants one last, and so between.
    """
    if (kinds == 0.0).any():
        return False
    here = kinds[0]
    for bend in kinds[1:-1]:
        if bend == here:
            return False
        here = bend
    return bool(here == kinds[-1])
