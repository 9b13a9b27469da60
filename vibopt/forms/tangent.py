"""Tangents: what a form is no less than on a box around a design.

Coordinates are s = x / x0 - 1, so that a box may reach down to zero.
"""

from __future__ import annotations

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.records import dataclass


@dataclass(frozen=True, slots=True)
class Tangent:
    """On |s| <= reach the form is at least value + slope . s - rest.

    slope, sides
        Shape (n_vars,); of `rest`, about what would be left of it on that side alone.
    """

    value: float
    slope: FloatArray
    rest: float
    sides: FloatArray

    def least(self, reach: FloatArray) -> float:
        """The form is no less than this on the box."""
        return float(self.value - np.abs(self.slope) @ reach - self.rest)

    def signed(self, sign: float) -> Tangent:
        """Of the form times 1 or -1, where both are known."""
        return Tangent(sign * self.value, sign * self.slope, self.rest, self.sides)

    def scaled(self, offset: float, size: float) -> Tangent:
        """Of the form less `offset`, in parts of `size`."""
        return Tangent((self.value - offset) / size, self.slope / size, self.rest / size, self.sides / size)


def bent(exponents: FloatArray, reach: FloatArray) -> FloatArray:
    """How far prod_j (1 + s_j)**e_ij can be from 1 + sum_j e_ij s_j on |s| <= reach <= 1, (..., n_vars) to (..., n)."""
    reach = reach[..., None, :]
    with np.errstate(divide="ignore"):
        ends = [np.abs((1.0 + s) ** exponents - 1.0 - exponents * s) for s in (reach, -reach)]
    linear = np.abs(exponents) * reach
    off: FloatArray = np.prod(1.0 + linear + np.maximum(*ends), axis=-1) - 1.0 - linear.sum(axis=-1)
    return np.maximum(off, 0.0)
