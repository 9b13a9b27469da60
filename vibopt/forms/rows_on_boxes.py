"""A response at fixed speeds on boxes of designs: linear in the logs of the variables, and how far off that may be.

With N and D multi-affine in the impedances kappa of groups of terms (`rational`), moved to the middle of a box,

    N / N0 = 1 + n,  D / D0 = 1 + d,  n and d sums over sets S of N_S / N0 and D_S / D0 times prod of delta kappa,

log|1 + d| is at most Re d + |d|^2 / 2, and Re d + (Im d / (1 - |Re d|))^2 / 2 while |Re d| < 1; log|1 + n| is at least
Re n - (Re n)^2 / (2 (1 - |Re n|)) while |Re n| < 1.  What of n and d is linear in the logs is the slope; all else is
bounded by its size.  On wide boxes the least |N| and the greatest |D| with each impedance in a disc around its range
say more.
"""

from __future__ import annotations

import math
from itertools import permutations
from typing import Any

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from vibopt.forms.monomials import Monomials
from vibopt.forms.rational import Sampled
from vibopt.mechanics.model import INERTIA
from vibopt.records import dataclass

_NONE, _TELLS = 1e-12, 1e-6
"""Parts of the greatest coefficient below which others are rounding, and say too little to be worth its digits."""
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

    def over(self, single: Monomials, middle: FloatArray) -> Rows:
        """Of the quotient to one product of powers, at `middle` (n_boxes, n_vars): that is linear in the logs."""
        return Rows(self.value - np.log(single.at(middle))[:, None], self.slope - single.exponents[0])

    def falling(self) -> Rows:
        """Of one over what is bounded, where that is linear in the logs."""
        return Rows(-self.value - 2.0 * _ROUNDING, -self.slope)

    def lows(self, half: FloatArray) -> FloatArray:
        """The least of each row on its box, shape (n_boxes, n_rows)."""
        return np.asarray(self.value - (np.abs(self.slope) * half[:, None]).sum(axis=-1))

    def within(self, level: FloatArray, half: FloatArray) -> tuple[FloatArray, FloatArray]:
        """How far from the low and from the high end of each side no row is above its level (n_rows,).

        Each of shape (n_boxes, n_vars).
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = np.where(self.slope == 0.0, np.inf, (level - self.lows(half))[..., None] / np.abs(self.slope))
        up, down = (np.where(way, reach, np.inf).min(axis=1) for way in (self.slope > 0.0, self.slope < 0.0))
        return up, down

    def highest(self, most: int) -> Rows:
        """Those that are highest at the middle of each box."""
        best = np.argsort(-self.value, axis=1, kind="stable")[:, :most]
        return Rows(
            *(np.take_along_axis(one, at, axis=1) for one, at in ((self.value, best), (self.slope, best[..., None])))
        )

    def of(self, boxes: IntArray) -> Rows:
        """On some of the boxes."""
        return Rows(self.value[boxes], self.slope[boxes])

    @classmethod
    def joined(cls, every: list[Rows]) -> Rows:
        """All of several."""
        kinds = [rows.value for rows in every], [rows.slope for rows in every]
        return cls(*(np.concatenate(some, axis=1) for some in kinds))


def response_rows(line: Sampled, middle: FloatArray, half: FloatArray, down: BoolArray | None = None) -> Rows:
    """Log of |N / D| at each of its speeds on boxes around `middle` (n_boxes, n_vars), logs within `half` of it.

    Variables that may go `down` to zero, (n_boxes, n_vars), have that as their greatest; no inertia depends on one.
    """
    turned = _Turned.of(line)
    terms = _Terms.of(line, turned.pairs, middle, half, np.zeros(half.shape, dtype=bool) if down is None else down)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # at an undamped resonance kappa has no end
        kappa, turn, beyond, size = turned.ways(terms)
        top, bottom = (_moved(one, kappa) for one in (turned.top, turned.bottom))
        at = np.log(np.abs(top[..., 0])) - np.log(np.abs(bottom[..., 0]))
        n_slope, n_rest = _parts(top, turn, beyond, size)
        d_slope, d_rest = _parts(bottom, turn, beyond, size)
        n_along, d_along, d_across = (
            (np.abs(way) * half[:, None]).sum(axis=-1) + rest
            for way, rest in ((n_slope.real, n_rest), (d_slope.real, d_rest), (d_slope.imag, d_rest))
        )
        fall = np.where(n_along < 1.0, n_rest + 0.5 * n_along**2 / (1.0 - n_along), np.inf)
        beside = np.where(d_along < 1.0, d_across / (1.0 - d_along), np.inf)
        rise = d_rest + 0.5 * np.minimum(beside**2, d_along**2 + d_across**2)
        slope, value = (n_slope - d_slope).real, at - fall - rise
        flat = _hull(turned, terms)
        known = np.isfinite(value) & np.isfinite(slope).all(axis=-1)
        linear = known & (Rows(value, slope).lows(half) > flat)
        value = np.where(linear, value, flat) - _ROUNDING
    return Rows(np.where(np.isfinite(value), value, -np.inf), np.where(linear[..., None], slope, 0.0))


def _hull(turned: _Turned, terms: _Terms) -> FloatArray:
    """Log of the least |N| over the greatest |D| with each impedance in a disc, shape (n_boxes, n_samples)."""
    disc, radius = turned.discs(terms)
    least, most = _sums(np.abs(_moved(turned.top, disc)), radius)
    greatest = _sums(np.abs(_moved(turned.bottom, disc)), radius)[1]
    return np.asarray(np.log(np.maximum(2.0 * least - most, 0.0)) - np.log(greatest))


_Moving = tuple[ComplexArray, ComplexArray, FloatArray, FloatArray]
"""Numbers at the middles, their slopes in the logs, what is left of them, and how far they may move."""


@dataclass(frozen=True, slots=True)
class _Turned:
    """N and D in other numbers than kappa, in which they are nearly linear.

    A mass M = -m w^2 that hangs on one link only stands for Z = M (1 - 1 / (1 + kappa / M)) at its host.
    And 1 / (kappa + shift) is taken instead of kappa, with the shift at which N vanishes whatever the others are, or
    where there are none: of devices side by side, and of what is handed on by mount on mount, N is then constant.

    top, bottom
        Coefficients, shape (n_samples, 2**G).
    pairs
        Of masses that hang on a link.
    shift, on
        Shape (n_samples, G); not `on` where N does not depend on that impedance, which is then left as it is.
    """

    top: ComplexArray
    bottom: ComplexArray
    pairs: tuple[_Pair, ...]
    shift: ComplexArray
    on: BoolArray

    @classmethod
    def of(cls, line: Sampled) -> _Turned:
        top, bottom, pairs = _paired(line)
        count = int(top.shape[1]).bit_length() - 1
        on, shift = np.empty((len(top), count), dtype=bool), np.empty((len(top), count), dtype=complex)
        for g in range(count):
            on[:, g], shift[:, g] = _vanishing(top.reshape(len(top), 1 << g, 2, -1))
        tables = []
        for table in (top, bottom):
            for g in range(count):
                cut = table.reshape(len(top), 1 << g, 2, -1)
                low, high = cut[:, :, 0], cut[:, :, 1]
                way, moved = on[:, g, None, None], low - shift[:, g, None, None] * high
                table = np.stack([np.where(way, high, low), np.where(way, moved, high)], axis=2).reshape(len(top), -1)
            tables.append(table)
        return cls(tables[0], tables[1], pairs, shift, on)

    def discs(self, terms: _Terms) -> tuple[ComplexArray, FloatArray]:
        """Discs of what is in the place of kappa, by middles and radii; without end where one holds a pole."""
        kappa, sides = terms.discs()
        radius = np.abs(sides)
        for place, mass, reach in terms.masses:
            middle, wide = _inverse_disc(1.0 + kappa[..., place], radius[..., place], sides[..., place])
            size, even, odd = np.abs(1.0 - middle), np.cosh(reach), np.sinh(reach)
            kappa[..., place] = mass * even * (1.0 - middle)
            radius[..., place] = np.abs(mass) * (even * wide + odd * (size + wide))
            sides[..., place] = (1.0 + 1.0j) * radius[..., place]
        middle, wide = _inverse_disc(kappa + self.shift, radius, sides)
        return np.where(self.on, middle, kappa), np.where(self.on, wide, radius)

    def ways(self, terms: _Terms) -> _Moving:
        """What is in the place of kappa, as it moves."""
        kappa, turn, beyond, size = terms.ways()
        for place, mass, reach, steps in ((*one, terms.steps[i]) for i, one in enumerate(terms.masses)):
            value, way, left, far = _inverse(
                1.0 + kappa[..., place], turn[:, :, place], beyond[..., place], size[..., place]
            )
            rest, grown = np.abs(1.0 - value), np.expm1(reach)
            kappa[..., place] = mass * (1.0 - value)
            turn[:, :, place] = mass[..., None] * ((1.0 - value)[..., None] * steps - way)
            beyond[..., place] = np.abs(mass) * (left + rest * (grown - reach) + far * grown)
            size[..., place] = np.abs(mass) * (far * (1.0 + grown) + rest * grown)
        made = _inverse(kappa + self.shift, turn, beyond, size)
        on = self.on
        return (
            np.where(on, made[0], kappa),
            np.where(on[..., None], made[1], turn),
            np.where(on, made[2], beyond),
            np.where(on, made[3], size),
        )


@dataclass(frozen=True, slots=True)
class _Pair:
    """A mass of one term that hangs on one link, by their places among the groups."""

    link: int
    mass: int


@dataclass(frozen=True, slots=True)
class _Terms:
    """Impedances of the groups on boxes, those of a pair's link over its mass, as sums of powers of the variables.

    p, reach
        Each term at the middles, and how far its log may be away, shape (n_boxes, n_terms).
    down
        Which of them may be less, down to zero, and move by no law but that, (n_boxes, n_terms).
    each
        What each term adds to each group, shape (n_terms, n_samples, G).
    exponents
        Shape (n_terms, n_vars).
    half
        Half widths, shape (n_boxes, n_vars).
    masses
        Of each pair: place of its link among the groups that are left, M (n_boxes, n_samples), reach (n_boxes, 1).
    steps
        Of each pair the exponents of its mass, (n_vars,).
    """

    p: FloatArray
    reach: FloatArray
    down: BoolArray
    each: ComplexArray
    exponents: FloatArray
    half: FloatArray
    masses: tuple[tuple[int, ComplexArray, FloatArray], ...]
    steps: tuple[FloatArray, ...]

    @classmethod
    def of(
        cls, line: Sampled, pairs: tuple[_Pair, ...], middle: FloatArray, half: FloatArray, down: BoolArray
    ) -> _Terms:
        members, model = line.groups.members, line.groups.model
        values, exponents = model.values(middle, static=line.static), model.exponents.copy()
        factors = line.factors / 1.0
        each = factors[:, :, None] * line.groups.selector / line.scale[:, None, :]
        left = [g for g in range(len(members)) if g not in {one.mass for one in pairs}]
        masses, steps = [], []
        for pair in pairs:
            (heavy,), own = members[pair.mass], list(members[pair.link])
            mass = values[:, heavy, None] * factors[:, heavy]
            step = model.exponents[heavy]
            masses.append((left.index(pair.link), mass / line.scale[:, pair.link], (half @ np.abs(step))[:, None]))
            steps.append(step)
            values[:, own] /= values[:, heavy, None]
            exponents[own] -= step
            each[:, own, pair.link] = factors[:, own] / factors[:, heavy, None]
        used = np.array([t for g in left for t in members[g]], dtype=np.intp)
        reach = half @ np.abs(exponents[used]).T
        return cls(
            values[:, used],
            reach,
            down @ (exponents[used].T != 0.0),
            each[:, used][:, :, left].swapaxes(0, 1),
            exponents[used],
            half,
            tuple(masses),
            tuple(steps),
        )

    def discs(self) -> tuple[ComplexArray, ComplexArray]:
        """Middles of all that each group may be, and half widths of its real and imaginary part."""
        wide = np.where(self.down, np.abs(self._most), np.abs(self.p) * np.sinh(self.reach))
        return _summed(np.where(self.down, self._most, self.p * np.cosh(self.reach)), self.each), self._across(wide)

    @property
    def _most(self) -> FloatArray:
        """Half of what each term is at most."""
        return np.asarray(0.5 * self.p * np.exp(self.reach))

    def _across(self, sizes: FloatArray) -> ComplexArray:
        """Sums of real and of imaginary parts of terms of these sizes (n_boxes, n_terms)."""
        return np.asarray(_summed(sizes, np.abs(self.each.real) + 1j * np.abs(self.each.imag)))

    def ways(self) -> _Moving:
        """Each group as it moves; shapes (n_boxes, n_samples, G), the slopes with n_vars behind."""
        moved = np.where(self.down, 0.0, self.p)
        turn = _summed(moved, self.each[..., None] * self.exponents[:, None, None])
        left = np.where(self.down, np.abs(self._most), np.abs(self.p) * (np.expm1(self.reach) - self.reach))
        beyond = np.abs(self._across(left))
        real, imag = ((np.abs(way) * self.half[:, None, None, :]).sum(axis=-1) for way in (turn.real, turn.imag))
        size = np.hypot(real, imag) + beyond
        return _summed(np.where(self.down, self._most, self.p), self.each), turn, beyond, size


def _summed(p: FloatArray, each: Any) -> Any:
    """Terms (n_boxes, n_terms) times what each adds (n_terms, ...), shape (n_boxes, ...)."""
    return (p @ each.reshape(len(each), math.prod(each.shape[1:]))).reshape(len(p), *each.shape[1:])


def _paired(line: Sampled) -> tuple[ComplexArray, ComplexArray, tuple[_Pair, ...]]:
    """Coefficients with links and the masses that hang on them alone as one, and which those are.

    Such a link and mass appear as (kappa + m) P + kappa m Q only, in N and D alike: as P + Z Q, for the ratio.
    """
    count, samples = len(line.groups.members), line.count
    tables = [one.reshape(samples, *([2] * count)) for one in (line.top, line.bottom)]
    pairs, left = [], list(range(count))
    for link, mass in permutations(range(count), 2):
        if not {link, mass} <= set(left):
            continue
        if len(line.groups.members[mass]) > 1 or line.groups.model.kinds[line.groups.members[mass][0]] != INERTIA:
            continue
        ratio = line.scale[:, mass] / line.scale[:, link]
        at = 1 + left.index(link), 1 + left.index(mass)
        cuts = [np.moveaxis(table, at, (1, 2)).reshape(samples, 2, 2, -1) for table in tables]
        if all(_hangs(cut, ratio[:, None]) for cut in cuts):
            shape = (samples, 2, *([2] * (len(left) - 2)))
            each = [np.stack([cut[:, 1, 0], cut[:, 1, 1] / ratio[:, None]], axis=1).reshape(shape) for cut in cuts]
            left.remove(mass)
            tables = [np.moveaxis(one, 1, 1 + left.index(link)) for one in each]
            pairs.append(_Pair(link, mass))
    top, bottom = (table.reshape(samples, -1) for table in tables)
    return top, bottom, tuple(pairs)


def _hangs(cut: ComplexArray, ratio: FloatArray) -> bool:
    """Whether coefficients (n_samples, 2, 2, ...) of two impedances are those of one behind the other."""
    room = _NONE * np.abs(cut).max(axis=(1, 2, 3), keepdims=False)[:, None]
    none = np.abs(cut[:, 0, 0]) <= room
    return bool((none & (np.abs(cut[:, 0, 1] - cut[:, 1, 0] * ratio) <= room * (1.0 + ratio))).all())


def _vanishing(cut: ComplexArray) -> tuple[BoolArray, ComplexArray]:
    """Whether N depends on an impedance, and the negative of that at which it vanishes, each (n_samples,).

    `cut` holds its coefficients (n_samples, n, 2, m), those without that impedance before those with it.
    """
    low, high = (cut[:, :, i].reshape(len(cut), -1) for i in (0, 1))
    size = (np.abs(high) ** 2).sum(axis=1)
    shift = (low * high.conj()).sum(axis=1) / np.where(size > 0.0, size, 1.0)
    most = np.abs(cut).max(axis=(1, 2, 3))
    always = np.sqrt(size) > _TELLS * most
    always &= (np.abs(low - shift[:, None] * high) <= _NONE * most[:, None]).all(axis=1)
    alone = np.abs(high[:, 0]) > _TELLS * np.abs(low[:, 0])
    on = always | alone
    return on, np.where(always, shift, np.where(alone, low[:, 0] / np.where(alone, high[:, 0], 1.0), 0.0))


def _inverse_disc(middle: ComplexArray, radius: FloatArray, sides: ComplexArray) -> tuple[ComplexArray, FloatArray]:
    """A disc around one over what is in a disc and no farther from its middle than `sides` along both axes.

    Without end where that may be zero.  One over what is beyond a is in the disc from zero to 1 / a.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        room = np.abs(middle) ** 2 - radius**2
        found = np.asarray(np.conj(middle) / room, dtype=complex)
        wide = np.where(room > 0.0, radius / room, np.inf)
        for at, half, way in ((middle.real, sides.real, 1.0), (middle.imag, sides.imag, -1.0j)):
            beyond = np.abs(at) - half
            other = np.where(beyond > 0.0, 0.5 / beyond, np.inf)
            less = other < wide
            found, wide = np.where(less, way * np.sign(at) * other, found), np.where(less, other, wide)
        return found, wide


def _inverse(value: ComplexArray, turn: ComplexArray, beyond: FloatArray, size: FloatArray) -> _Moving:
    """One over numbers that move."""
    with np.errstate(divide="ignore", invalid="ignore"):
        there = 1.0 / value
        far, part = np.abs(there), np.abs(there) * size
        left = np.where(part < 1.0, far**2 * beyond + far * part**2 / (1.0 - part), np.inf)
        return there, -(there**2)[..., None] * turn, left, np.where(part < 1.0, far * part / (1.0 - part), np.inf)


def _sums(sizes: FloatArray, radius: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The first of the sizes (n_boxes, n_samples, 2**G), and the sum of all times the radii (..., G) of their sets."""
    most = sizes
    for g in range(radius.shape[-1]):
        cut = most.shape[-1] // 2
        most = most[..., :cut] + most[..., cut:] * radius[..., g, None]
    return sizes[..., 0], most[..., 0]


def coefficients(line: Sampled) -> int:
    """How many numbers a row is made of."""
    return int(_paired(line)[0].shape[1])


def power_rows(powers: Monomials, middle: FloatArray, half: FloatArray, down: BoolArray, *, least: bool) -> Rows:
    """Log of sum_j scale_j x**exponents_j, all positive, as one row: it is convex in the logs.

    With `least` of one over a single such term.  Variables that may go `down` to zero, (n_boxes, n_vars), leave terms
    out, and of one over a term they are at their greatest.
    """
    moves = (down @ (powers.exponents.T != 0.0)) & (not least)
    middle = np.where(down, middle * np.exp(half), middle) if least else middle
    parts = np.where(moves, 0.0, powers.scale * np.exp(np.log(middle) @ powers.exponents.T))
    total = parts.sum(axis=1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.where(down | (total == 0.0), 0.0, (parts / total) @ powers.exponents)[:, None, :]
        rows = Rows(np.log(total) - _ROUNDING, slope)
    return rows.falling() if least else rows


def _moved(coefficients: ComplexArray, kappa: ComplexArray) -> ComplexArray:
    """Coefficients (n_samples, 2**G) of a multi-affine function about kappa (n_boxes, n_samples, G)."""
    table = np.repeat(coefficients[None], len(kappa), axis=0)
    for g in range(kappa.shape[-1]):
        halves = table.reshape(*kappa.shape[:-1], 1 << g, 2, -1)  # a view: it is written to
        halves[..., 0, :] += halves[..., 1, :] * kappa[..., g, None, None]
    return table


def _parts(
    moved: ComplexArray, turn: ComplexArray, beyond: FloatArray, size: FloatArray
) -> tuple[ComplexArray, FloatArray]:
    """Of the sum over all sets but the empty one, over the empty one: its slope, and the size of the rest."""
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
    return slope, rest + np.maximum(whole - single, 0.0)
