"""Arrays by what they hold: every area names them alike."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    FloatArray = NDArray[np.float64]
    ComplexArray = NDArray[np.complex128]
    BoolArray = NDArray[np.bool_]
    IntArray = NDArray[np.intp]
else:  # numpy.typing is slow to load, and only a type checker reads it
    FloatArray = ComplexArray = BoolArray = IntArray = np.ndarray

np.empty(1 << 24, np.uint8)
"""Freed at once.  From then on glibc keeps what is freed up to this size; it gave back each array from 128 KB on, and
took its pages anew for the next, which was a third of the time of a sweep.  No effect elsewhere."""
Values = TypeVar("Values", FloatArray, ComplexArray)
_LAPACK: Any = getattr(np.linalg, "_umath_linalg", np.linalg)
inverted, solved = _LAPACK.inv, getattr(_LAPACK, "solve1", _LAPACK.solve)
"""Of small matrices, without what takes numpy.linalg longer than LAPACK: singular ones give nan, or its LinAlgError."""


def some(number: Any) -> bool:
    """Whether a number is not zero, or one at least of many in an array."""
    return bool(np.count_nonzero(number)) if isinstance(number, np.ndarray) else bool(number)


def every(chosen: BoolArray) -> bool:
    """Whether all of them are."""
    return bool(np.count_nonzero(chosen) == chosen.size)


def joined(parts: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    """Parts of a line in rising order, those that meet as one."""
    found: list[tuple[float, float]] = []
    for low, high in sorted(parts):
        if found and low <= found[-1][1]:
            found[-1] = found[-1][0], max(high, found[-1][1])
        else:
            found.append((low, high))
    return found


def crossing(function: Callable[[float], float], low: float, high: float) -> float:
    """Where a continuous function that has other signs at both ends is zero, to the last digits (Chandrupatla 1997)."""
    a, b = low, high
    at_a, at_b = function(a), function(b)
    c, at_c, part, floor = a, at_a, 0.5, 1e-17 * abs(high - low)
    while True:
        best = a if abs(at_a) < abs(at_b) else b
        room = 4.5e-16 * abs(best) + floor
        if at_a == 0.0 or at_b == 0.0 or abs(b - a) <= 2.0 * room:
            return best
        least = room / abs(b - a)
        new = a + min(max(part, least), 1.0 - least) * (b - a)
        value = function(new)
        if (value > 0.0) == (at_a > 0.0):
            c, at_c = a, at_a
        else:
            c, at_c, b, at_b = b, at_b, a, at_a
        a, at_a = new, value
        far, rise = (a - b) / (c - b), (at_a - at_b) / (at_c - at_b) if at_c != at_b else 2.0  # level but for rounding
        part = 0.5
        if rise * rise < far and (1.0 - rise) ** 2 < 1.0 - far:
            part = at_a / (at_b - at_a) * at_c / (at_b - at_c)
            part += (c - a) / (b - a) * at_a / (at_c - at_a) * at_b / (at_c - at_b)
