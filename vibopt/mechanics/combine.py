"""Several numbers as one: harmonics added up, and the extreme of many, of several equals the one that is meant."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import gcd, isfinite, lcm

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.records import dataclass
from vibopt.signals import Combine


@dataclass(frozen=True, slots=True)
class Extreme:
    """Value of a response and the speed [rad/s] at which it is reached."""

    value: float
    speed: float


def combined(lines: Sequence[ComplexArray] | ComplexArray, orders: tuple[float, ...], combine: Combine) -> FloatArray:
    """Combine complex amplitudes (n_lines, ...) into one non-negative array (...)."""
    if len(lines) == 1:
        modulus: FloatArray = np.abs(lines[0])
        return modulus
    moduli = np.abs(np.asarray(lines))
    if combine == "sum":
        total: FloatArray = moduli.sum(axis=0)
        return total
    if combine == "rss":
        root: FloatArray = np.sqrt((moduli**2).sum(axis=0))
        return root
    return _true_peak(np.asarray(lines), orders)


def _true_peak(lines: ComplexArray, orders: tuple[float, ...]) -> FloatArray:
    """Greatest |sum_h Re(A_h e^{i h s})| over one period of s, lines of shape (n_lines, ...)."""
    numbers = whole_orders(orders)
    if numbers is None:
        total: FloatArray = np.abs(lines).sum(axis=0)
        return total
    shape = lines.shape[1:]
    flat = lines.reshape(len(numbers), -1)
    infinite = ~np.isfinite(np.abs(flat)).all(axis=0)
    flat = np.where(infinite, 0.0, flat)
    count = 16 * int(numbers.max())
    angle = 2.0 * np.pi * np.arange(count) / count
    signal = np.einsum("hj,ht->jt", flat, np.exp(1j * np.outer(numbers, angle))).real
    best = _refined(flat, numbers, angle, np.abs(signal))
    return np.where(infinite, np.inf, best).reshape(shape)


def _refined(flat: ComplexArray, numbers: FloatArray, angle: FloatArray, size: FloatArray) -> FloatArray:
    """Newton from the highest samples of each signal."""
    best = np.zeros(flat.shape[1])
    for column in np.argsort(size, axis=1)[:, -6:].T:
        s = angle[column]
        for _ in range(6):
            turn = flat * np.exp(1j * numbers[:, None] * s)
            first = -(numbers[:, None] * turn.imag).sum(axis=0)
            second = -(numbers[:, None] ** 2 * turn.real).sum(axis=0)
            safe = np.abs(second) > 1e-300
            s = s - np.clip(np.where(safe, first / np.where(safe, second, 1.0), 0.0), -0.1, 0.1)
        value = np.abs((flat * np.exp(1j * numbers[:, None] * s)).sum(axis=0).real)
        best = np.maximum(best, value)
    highest: FloatArray = np.maximum(best, size.max(axis=1))
    return highest


def whole_orders(orders: tuple[float, ...]) -> FloatArray | None:
    """Orders as whole multiples of their common base; None when there is no sensible one."""
    parts = [Fraction(order).limit_denominator(1000) for order in orders]
    if any(abs(float(part) - order) > 1e-12 * order for part, order in zip(parts, orders, strict=True)):
        return None
    common = lcm(*[part.denominator for part in parts])
    whole = [int(part * common) for part in parts]
    base = gcd(*whole)
    numbers = np.array([n // base for n in whole], dtype=float)
    return numbers if numbers.max() <= 500 else None


EVEN = 1e-11
"""Part by which two values may differ and still be equal: rounding of one measurement."""
FOUND = 1e-9
"""The same for what a search has found."""


def foremost(values: Sequence[float] | FloatArray, *, least: bool = False, even: float = EVEN) -> int:
    """Index of the first of the values that are the greatest (the least), up to rounding.

    Parameters
    ----------
    values
        Not empty; may be infinite, not nan.
    least
        Look for the least instead.
    even
        Part by which equals may differ.
    """
    size = [-value if least else value for value in values]
    top = max(size)
    if not isfinite(top):
        return size.index(top)
    return next(index for index, one in enumerate(size) if one >= top - even * abs(top))


def beyond(value: float, other: float, sign: float = 1.0) -> bool:
    """Whether a value is greater than another (less, with sign -1) by more than a search can tell."""
    if not (np.isfinite(value) and np.isfinite(other)):
        return sign * value > sign * other
    return sign * (value - other) > FOUND * max(abs(value), abs(other))
