"""A response at fixed speeds on boxes of designs: linear in the logs of the variables, and how far off that may be.

With N and D multi-affine in the impedances kappa of groups of terms (`rational`), moved to the middle of a box,

    N / N0 = 1 + n,  D / D0 = 1 + d,  n and d sums over sets S of N_S / N0 and D_S / D0 times prod of delta kappa,

log|1 + d| is at most Re d + |d|^2 / 2, and log|1 + n| at least Re n - |n|^2 / (2 (1 - |n|)) while |n| < 1.  What of n
and d is linear in the logs is the slope; all else is bounded by its size.  On wide boxes the least |N| and the greatest
|D| with each impedance in a disc around its range say more.
"""

from __future__ import annotations

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray
from vibopt.forms.rational import Sampled
from vibopt.records import dataclass

_NONE = 1e-12
_ROUNDING = 1e-9
"""Part of a response that rounding may take: determinants lose digits."""


@dataclass(frozen=True, slots=True)
class Rows:
    """Rows value + slope . t, below the log of what is bounded for each t within the half widths of a box.

    value
        At the middle less all that is not linear, shape (n_boxes, n_rows); -inf where nothing is known.
    slope
        Shape (n_boxes, n_rows, n_vars).
    """

    value: FloatArray
    slope: FloatArray

    def less(self, log: float) -> Rows:
        """Of the quotient to a number, by its log."""
        return Rows(self.value - log, self.slope)

    def falling(self) -> Rows:
        """Of one over what is bounded, where that is linear in the logs."""
        return Rows(-self.value - 2.0 * _ROUNDING, -self.slope)

    def lows(self, half: FloatArray) -> FloatArray:
        """The least of each row on its box, shape (n_boxes, n_rows)."""
        return np.asarray(self.value - (np.abs(self.slope) * half[:, None]).sum(axis=-1))

    def highest(self, most: int) -> Rows:
        """Those that are highest at the middle of each box."""
        best = np.argsort(-self.value, axis=1, kind="stable")[:, :most]
        return Rows(
            *(np.take_along_axis(one, at, axis=1) for one, at in ((self.value, best), (self.slope, best[..., None])))
        )

    @classmethod
    def joined(cls, every: list[Rows]) -> Rows:
        """All of several."""
        kinds = [one.value for one in every], [one.slope for one in every]
        return cls(*(np.concatenate(some, axis=1) for some in kinds))


def response_rows(line: Sampled, middle: FloatArray, half: FloatArray) -> Rows:
    """Log of |N / D| at each of its speeds on boxes around `middle` (n_boxes, n_vars), logs within `half` of it."""
    turned = _Turned.of(line)
    kappa, turn, beyond, size = turned.ways(*_impedances(line, middle, half))
    top, bottom = (_moved(one, kappa) for one in (turned.top, turned.bottom))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        at = np.log(np.abs(top[..., 0])) - np.log(np.abs(bottom[..., 0]))
        n_slope, n_rest, n_size = _parts(top, turn, beyond, size)
        d_slope, d_rest, d_size = _parts(bottom, turn, beyond, size)
        fall = np.where(n_size < 1.0, n_rest + 0.5 * n_size**2 / (1.0 - n_size), np.inf)
        slope, value = (n_slope - d_slope).real, at - fall - d_rest - 0.5 * d_size**2
        flat = _hull(turned, line, middle, half)
        known = np.isfinite(value) & np.isfinite(slope).all(axis=-1)
        linear = known & (Rows(value, slope).lows(half) > flat)
        value = np.where(linear, value, flat) - _ROUNDING
    return Rows(np.where(np.isfinite(value), value, -np.inf), np.where(linear[..., None], slope, 0.0))


def _hull(turned: _Turned, line: Sampled, middle: FloatArray, half: FloatArray) -> FloatArray:
    """Log of the least |N| over the greatest |D| with each impedance in a disc, shape (n_boxes, n_samples)."""
    groups = line.groups
    used = groups.selector.any(axis=1)
    reach = half @ np.abs(groups.model.exponents[used]).T
    p = groups.model.values(middle)[:, used]
    each = line.factors[:, used, None] * groups.selector[used] / line.scale[:, None, :]
    kappa = np.einsum("bt,stg->bsg", p * np.cosh(reach), each)
    real, imag = (np.einsum("bt,stg->bsg", p * np.sinh(reach), np.abs(one)) for one in (each.real, each.imag))
    disc, radius = turned.discs(kappa, np.hypot(real, imag))
    least, most = _sums(np.abs(_moved(turned.top, disc)), radius)
    greatest = _sums(np.abs(_moved(turned.bottom, disc)), radius)[1]
    return np.asarray(np.log(np.maximum(2.0 * least - most, 0.0)) - np.log(greatest))


@dataclass(frozen=True, slots=True)
class _Turned:
    """N and D in 1 / (kappa + shift) instead of kappa, with the shift at which N vanishes where there are no others.

    Of devices side by side N is then constant, and what is left of D nearly linear.

    top, bottom
        Coefficients, shape (n_samples, 2**G).
    shift, on
        Shape (n_samples, G); not `on` where N does not depend on that impedance, which is then left as it is.
    """

    top: ComplexArray
    bottom: ComplexArray
    shift: ComplexArray
    on: BoolArray

    @classmethod
    def of(cls, line: Sampled) -> _Turned:
        top, count = line.top, len(line.groups.members)
        single = top[:, [1 << (count - 1 - g) for g in range(count)]]
        on = np.abs(single) > _NONE * np.abs(top[:, :1])
        shift = np.where(on, top[:, :1] / np.where(on, single, 1.0), 0.0)
        tables = []
        for table in (line.top, line.bottom):
            for g in range(count):
                cut = table.reshape(len(top), 1 << g, 2, -1)
                low, high = cut[:, :, 0], cut[:, :, 1]
                way, moved = on[:, g, None, None], low - shift[:, g, None, None] * high
                table = np.stack([np.where(way, high, low), np.where(way, moved, high)], axis=2).reshape(len(top), -1)
            tables.append(table)
        return cls(tables[0], tables[1], shift, on)

    def discs(self, kappa: ComplexArray, radius: FloatArray) -> tuple[ComplexArray, FloatArray]:
        """Discs of kappa, by middles and radii, as those of what is in its place; none has an end that holds a pole."""
        there = kappa + self.shift
        room = np.abs(there) ** 2 - radius**2
        middle = np.where(self.on, np.conj(there) / room, kappa)
        return middle, np.where(self.on, np.where(room > 0.0, radius / room, np.inf), radius)

    def ways(
        self, kappa: ComplexArray, turn: ComplexArray, beyond: FloatArray, size: FloatArray
    ) -> tuple[ComplexArray, ComplexArray, FloatArray, FloatArray]:
        """As `_impedances`, of what stands in the place of kappa."""
        inverse = 1.0 / (kappa + self.shift)
        part = np.abs(inverse) * size
        left = np.where(part < 1.0, np.abs(inverse) ** 2 * beyond + np.abs(inverse) * part**2 / (1.0 - part), np.inf)
        ends = np.where(part < 1.0, np.abs(inverse) * part / (1.0 - part), np.inf)
        return (
            np.where(self.on, inverse, kappa),
            np.where(self.on[..., None], -(inverse**2)[..., None] * turn, turn),
            np.where(self.on, left, beyond),
            np.where(self.on, ends, size),
        )


def _sums(sizes: FloatArray, radius: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The first of the sizes (n_boxes, n_samples, 2**G), and the sum of all times the radii (..., G) of their sets."""
    most = sizes
    for g in range(radius.shape[-1]):
        cut = most.shape[-1] // 2
        most = most[..., :cut] + most[..., cut:] * radius[..., g, None]
    return sizes[..., 0], most[..., 0]


def power_rows(scale: FloatArray, exponents: FloatArray, middle: FloatArray, half: FloatArray) -> Rows:
    """Log of sum_j scale_j x**exponents_j, all positive, as one row: it is convex in the logs."""
    parts = scale * np.exp(np.log(middle) @ exponents.T)
    total = parts.sum(axis=1, keepdims=True)
    slope = ((parts / total) @ exponents)[:, None, :]
    return Rows(np.log(total) - _ROUNDING, slope)


def _impedances(
    line: Sampled, middle: FloatArray, half: FloatArray
) -> tuple[ComplexArray, ComplexArray, FloatArray, FloatArray]:
    """Impedance of each group at the middle, its slopes in the logs, what is left of it, and how far it may move.

    Shapes (n_boxes, n_samples, n_groups), the slopes with n_vars behind.
    """
    groups = line.groups
    model, selector = groups.model, groups.selector
    used = selector.any(axis=1)
    exponents, factors, selector = model.exponents[used], line.factors[:, used], selector[used]
    p = model.values(middle)[:, used]
    reach = half @ np.abs(exponents).T  # (n_boxes, n_terms)
    each = factors[:, :, None] * selector / line.scale[:, None, :]  # (n_samples, n_terms, n_groups)
    kappa = np.einsum("bt,stg->bsg", p, each)
    turn = np.einsum("bt,stg,tv->bsgv", p, each, exponents, optimize=True)
    beyond = np.einsum("bt,stg->bsg", p * (np.expm1(reach) - reach), np.abs(each))
    return kappa, turn, beyond, (np.abs(turn) * half[:, None, None, :]).sum(axis=-1) + beyond


def _moved(coefficients: ComplexArray, kappa: ComplexArray) -> ComplexArray:
    """Coefficients (n_samples, 2**G) of a multi-affine function about kappa (n_boxes, n_samples, G)."""
    count = kappa.shape[-1]
    table = np.broadcast_to(coefficients, (*kappa.shape[:-1], coefficients.shape[-1]))
    table = table.reshape(*kappa.shape[:-1], *([2] * count))
    for g in range(count):
        axis = 2 + g
        low, high = np.take(table, 0, axis=axis), np.take(table, 1, axis=axis)
        table = np.stack([low + high * kappa[..., g].reshape(*kappa.shape[:-1], *([1] * (count - 1))), high], axis=axis)
    return table.reshape(*kappa.shape[:-1], -1)


def _parts(
    moved: ComplexArray, turn: ComplexArray, beyond: FloatArray, size: FloatArray
) -> tuple[ComplexArray, FloatArray, FloatArray]:
    """Of the sum over all sets but the empty one, over the empty one: its slope, the rest, its size."""
    count = size.shape[-1]
    parts = moved / moved[..., :1]
    sizes, slope = np.abs(parts), np.zeros(turn.shape[:2] + turn.shape[-1:], dtype=complex)
    whole = _sums(sizes, size)[1] - 1.0
    single = np.zeros(whole.shape)
    rest = np.zeros(whole.shape)
    for g in range(count):
        at = 1 << (count - 1 - g)
        slope += parts[..., at, None] * turn[..., g, :]
        single += sizes[..., at] * size[..., g]
        rest += sizes[..., at] * beyond[..., g]
    return slope, rest + np.maximum(whole - single, 0.0), whole


__all__ = ["Rows", "power_rows", "response_rows"]
