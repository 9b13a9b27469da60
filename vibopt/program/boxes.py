"""Numbers on boxes of factors and speeds: value and slopes at the middle, and how far off they may be elsewhere."""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias

import numpy as np

from vibopt.arrays import FloatArray, IntArray
from vibopt.records import cached_property, dataclass
from vibopt.signals import Line

Numbers: TypeAlias = "np.ndarray[Any, np.dtype[Any]]"
"""Real or complex."""


class Scalar(NamedTuple):
    """A number on boxes around their middles: |value - at - slope . t| <= rest, |value - at| <= spread.

    Shapes (n_boxes, ...), slope (n_boxes, ..., n_axes); t is the way from the middle along each axis, of factors in
    logarithms.
    """

    at: Numbers
    slope: Numbers
    rest: FloatArray

    def spread(self, half: FloatArray) -> FloatArray:
        """Greatest distance from the middle, (n_boxes, ...)."""
        far: FloatArray = (np.abs(self.slope) * half).sum(axis=-1) + self.rest
        return far

    def times(self, other: Scalar, half: FloatArray) -> Scalar:
        """The product."""
        slope = self.at[..., None] * other.slope + other.at[..., None] * self.slope
        rest = np.abs(self.at) * other.rest + np.abs(other.at) * self.rest + self.spread(half) * other.spread(half)
        return Scalar(self.at * other.at, slope, rest)


@dataclass(frozen=True)
class Boxes:
    """Boxes of factors and, as the last axis, of the speed [rad/s]; low and high (n_boxes, n_axes)."""

    low: FloatArray
    high: FloatArray

    @cached_property
    def middle(self) -> FloatArray:
        """Of factors in ratio, of the speed in the middle; (n_boxes, n_axes)."""
        found = np.sqrt(self.low * self.high)
        found[:, -1] = 0.5 * (self.low[:, -1] + self.high[:, -1])
        return found

    @cached_property
    def half(self) -> FloatArray:
        """Half widths, of factors in logarithms; (n_boxes, n_axes)."""
        with np.errstate(divide="ignore", invalid="ignore"):
            found = 0.5 * np.log(self.high / self.low)
        found[:, -1] = 0.5 * (self.high[:, -1] - self.low[:, -1])
        return found

    def part(self, chosen: slice) -> Boxes:
        return Boxes(self.low[chosen], self.high[chosen])

    def halves(self, weight: FloatArray) -> Boxes:
        """Each box cut in two across the axis of most weight (n_boxes, n_axes)."""
        axis, rows = weight.argmax(axis=1), np.arange(len(weight))
        cut = self.middle[rows, axis]
        high, low = self.high.copy(), self.low.copy()
        high[rows, axis] = low[rows, axis] = cut
        return Boxes(np.concatenate([self.low, low]), np.concatenate([high, self.high]))


def powers_on(boxes: Boxes, exponents: FloatArray, powers: IntArray) -> Scalar:
    """prod_i f_i**exponents_gi * speed**powers_g on boxes, powers 0, 1 or 2; shapes (n_boxes, n_groups)."""
    middle, half = boxes.middle, boxes.half
    at = np.exp(np.log(np.maximum(middle[:, :-1], 1e-300)) @ exponents.T)
    far = half[:, :-1] @ np.abs(exponents).T
    bent = at * (np.exp(far) - 1.0 - far)
    slope = np.zeros((*at.shape, middle.shape[1]))
    if not powers.any():
        slope[..., :-1] = at[..., None] * exponents
        return Scalar(at, slope, bent)
    speed, wide = middle[:, -1:], half[:, -1:]
    size, steep = speed**powers, powers * speed ** np.maximum(powers - 1, 0)
    slope[..., :-1] = (at * size)[..., None] * exponents
    slope[..., -1] = at * steep
    rest = np.where(powers == 2, wide**2, 0.0)
    beyond = at * rest + size * bent + (at * far + bent) * (steep * wide + rest)  # as of any product
    return Scalar(at * size, slope, beyond)


def amplitude_on(boxes: Boxes, line: Line, power: int) -> Scalar:
    """amplitude * frequency**power of a line on boxes that lie within one piece of it each."""
    speed, wide = boxes.middle[:, -1], boxes.half[:, -1]
    pieces = line.amplitude.pieces
    which = np.searchsorted([piece.band.high for piece in pieces[:-1]], speed, side="left")
    first, steep, own = (
        np.array([getattr(piece, key) for piece in pieces])[which] for key in ("constant", "slope", "power")
    )
    k, size = own + float(power), abs(line.order) ** power
    bent, tilted = first * k * (k - 1.0), steep * k * (k + 1.0)
    rest = 0.5 * wide**2 * (_most(bent, k - 2.0, boxes) + _most(tilted, k - 1.0, boxes))
    slope = np.zeros_like(boxes.low)
    slope[:, -1] = size * (_power(first * k, speed, k - 1.0) + _power(steep * (k + 1.0), speed, k))
    return Scalar(size * (first + steep * speed) * _power(np.ones_like(k), speed, k), slope, size * rest)


def _power(scale: FloatArray, speed: FloatArray, power: FloatArray) -> FloatArray:
    """scale * speed**power, nothing where the scale is."""
    with np.errstate(divide="ignore", invalid="ignore"):
        value: FloatArray = np.where(scale == 0.0, 0.0, scale * speed**power)
    return value


def _most(scale: FloatArray, power: FloatArray, boxes: Boxes) -> FloatArray:
    """Greatest |scale| * speed**power on boxes."""
    ends = (_power(np.abs(scale), boxes.low[:, -1], power), _power(np.abs(scale), boxes.high[:, -1], power))
    return np.maximum(*ends)


def modulus_on(value: Scalar, half: FloatArray) -> FloatArray:
    """Greatest modulus of a complex value on boxes, (n_boxes,)."""
    size = np.abs(value.at)
    turn = np.where(size > 0.0, np.conj(value.at) / np.where(size > 0.0, size, 1.0), 1.0)
    turned = value.slope * turn[:, None]
    along = size + (np.abs(turned.real) * half).sum(axis=1)
    across = (np.abs(turned.imag) * half).sum(axis=1)
    most: FloatArray = np.hypot(along, across) + value.rest
    return most
