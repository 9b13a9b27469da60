"""Tangents: what a form is no less than on a box around a design.

Coordinates are s = x / x0 - 1, so that a box may reach down to zero.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vibopt.arrays import FloatArray, IntArray
from vibopt.mechanics.kernel_bounds import Element, Nearby
from vibopt.mechanics.model import Model
from vibopt.records import dataclass
from vibopt.signals import Output


@dataclass(frozen=True, slots=True)
class Tangent:
    """On |s| <= reach the form is at least value + slope . s - rest.

    slope, sides
        Shape (n_vars,); of `rest`, which may be infinite, about what would be left of it on that side alone.
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


def flat(value: float, count: int) -> Tangent:
    """Of what none of so many variables moves."""
    return Tangent(value, np.zeros(count), 0.0, np.zeros(count))


def bent(exponents: FloatArray, reach: FloatArray) -> FloatArray:
    """How far prod_j (1 + s_j)**e_ij can be from 1 + sum_j e_ij s_j on |s| <= reach <= 1, (..., n_vars) to (..., n)."""
    reach = reach[..., None, :]
    with np.errstate(divide="ignore"):
        ends = [np.abs((1.0 + s) ** exponents - 1.0 - exponents * s) for s in (reach, -reach)]
    linear = np.abs(exponents) * reach
    off: FloatArray = np.prod(1.0 + linear + np.maximum(*ends), axis=-1) - 1.0 - linear.sum(axis=-1)
    return np.maximum(off, 0.0)


class Opened:
    """Coefficients of a machine that follow the design, and tangents of what is read at a time by its slopes in them.

    active, exponents
        Which they are, (k,), and of which powers of the variables, (k, n_vars).
    elements
        What each multiplies, and its weight in what is read.
    ways
        Of those that follow the same variables alike, which coefficients they are, (k, n_terms).
    """

    def __init__(self, model: Model, output: Output) -> None:
        self.active = np.flatnonzero(model.exponents.any(axis=1))
        self.elements = [Element(int(model.kinds[i]), model.vectors[i], float(output.signs[i])) for i in self.active]
        self.exponents = model.exponents[self.active]
        self._alike, group = np.unique(self.exponents, axis=0, return_inverse=True)
        self.ways = (np.arange(len(self._alike))[:, None] == group.ravel()) @ np.eye(len(model.terms))[self.active]

    def tangents(
        self,
        near: Nearby,
        p: FloatArray,
        slopes: Callable[[IntArray], FloatArray],
        reach: FloatArray,
        share: float,
    ) -> list[Tangent]:
        """At coefficients p (n, n_terms), on boxes that reach so far (n, n_vars), of a `share` of what is read.

        slopes
            Of what is read along each of the ways, in logarithms, at some of p, (k,) to (k, n_ways): where nothing
            bounds the rest they are not asked for, and told as zero.
        """
        count = reach.shape[1]
        boxes = reach[:, None] * np.vstack([np.ones(count), np.eye(count)])  # (n, 1 + n_vars, n_vars)
        off = boxes @ np.abs(self.exponents).T + bent(self.exponents, boxes)
        rests, along = near.rests(p[:, None, self.active] * off), np.zeros((len(p), len(self.ways)))
        known = np.flatnonzero(np.isfinite(rests[:, 0]))
        if len(known):
            along[known] = slopes(known)
        rests = rests + (bent(self._alike, boxes) @ np.abs(along)[..., None])[..., 0]
        along = along @ self._alike * np.copysign(share, near.value)[:, None]
        return [
            Tangent(abs(float(value)) * share, slope, float(rest[0]), rest[1:])
            for value, slope, rest in zip(near.value, along, rests * share, strict=True)
        ]
