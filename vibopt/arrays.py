"""Arrays by what they hold: every area names them alike."""

from __future__ import annotations

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

Values = TypeVar("Values", FloatArray, ComplexArray)


def some(number: Any) -> bool:
    """Whether a number is not zero, or one at least of many in an array."""
    return bool(number.any()) if isinstance(number, np.ndarray) else bool(number)
