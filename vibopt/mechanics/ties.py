"""Which of several equals is meant: the first, by rule, for rounding would choose another one on another machine."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vibopt.forms import FloatArray

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
    size = -np.asarray(values, dtype=float) if least else np.asarray(values, dtype=float)
    top = float(size.max())
    if not np.isfinite(top):
        return int(size.argmax())
    return int((size >= top - even * abs(top)).argmax())


def beyond(value: float, other: float, sign: float = 1.0) -> bool:
    """Whether a value is greater than another (less, with sign -1) by more than a search can tell."""
    if not (np.isfinite(value) and np.isfinite(other)):
        return sign * value > sign * other
    return sign * (value - other) > FOUND * max(abs(value), abs(other))


__all__ = ["EVEN", "FOUND", "beyond", "foremost"]
