"""A mean square under white noise on boxes of designs, as a quotient of two polynomials in the variables.

With H(s) = N(s) / D(s) of order n, D = sum a_j s^(n-j) and N(s) N(-s) = sum b_j s^(2 (n-1-j)),

    1 / (2 pi) integral of |H(i w)|^2 over all w  =  (-1)^(n+1) / (2 a_0) det B / det A,

A the Hurwitz matrix of the a_j and B the same with the b_j for its first row (James, Nichols and Phillips, Theory of
Servomechanisms, 1947, section 7.9).  The a_j and the numbers of N are multi-affine in the impedances, so both
determinants are polynomials in the variables, and their Bernstein coefficients bound the quotient on a box.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.forms.characteristic import ROUNDING, circle, nodes, plain, powers, tables, typical_rate
from vibopt.forms.monomials import mounts
from vibopt.forms.rational import determinants, expanded, ratio_bounds
from vibopt.mechanics.harmonic import bordered
from vibopt.mechanics.model import HYSTERETIC, Model, factors
from vibopt.signals import Noise

if TYPE_CHECKING:
    from vibopt.forms.bounds import FormBounds
    from vibopt.forms.form import Bounds
    from vibopt.forms.root_mean_square import RootMeanSquare

_BODIES = 4
"""Free coordinates: determinants of twice as many rows take ever longer and lose digits."""
_NOTHING, _AGREE = 1e-9, 1e-6
"""Part of the greatest number of N that is rounding, and of a value by which both routes to it may differ."""
_RATES, _SURE, _BOUND = (1.0, 1.3), 1e-10, 1e-4
"""Rates that numbers are counted in, by parts of a typical one, the part of a value by which what they make of it may
differ, and the part that a bound of all rounding, which counts the worst of it, may be of a mean square."""


def bounded(form: RootMeanSquare, model: Model) -> bool:
    """Whether such polynomials are known."""
    if model.spins or model.mixed or model.massless.any() or (model.kinds == HYSTERETIC).any():
        return False
    return 0 < model.n_free <= _BODIES


def on_boxes(form: RootMeanSquare, known: FormBounds, low: FloatArray, high: FloatArray) -> Bounds:
    """Bounds of the root mean square on boxes low, high (n_boxes, n_vars), each (n_boxes,).

    Nothing is known where another road to its value at the reference does not agree.
    """
    here = known.reference[None]
    if "agrees" not in known.kept:
        least, most = _single(form, known, here, here)
        value = form.value(known.model, known.reference)
        known.kept["agrees"] = bool((1.0 - _AGREE) * most[0] <= value <= (1.0 + _AGREE) * least[0])
    if not known.kept["agrees"]:
        return np.zeros(len(low)), np.full(len(low), np.inf)
    return _single(form, known, low, high)


def at_designs(form: RootMeanSquare, model: Model, x: FloatArray) -> FloatArray:
    """Root mean squares at designs x (n, n_vars) all at once, (n,); not a number where rounding may decide.

    Numbers are counted in two rates: what rounding makes of them differs.
    """
    with np.errstate(all="ignore"):
        first, other = (_at(form, model, x, part * typical_rate(model, x[0])) for part in _RATES)
        told = np.isfinite(first) & (np.abs(first - other) <= _SURE * first)
    return np.where(told, first, np.nan) / mounts(model, form.output).at(x)


def _at(form: RootMeanSquare, model: Model, x: FloatArray, rate: float) -> FloatArray:
    """By numbers counted in one rate [rad/s]."""
    omega = circle(model, rate)
    numbers = model.values(x)[:, None] * factors(model.kinds, omega)
    size = np.sqrt(np.abs(numbers[:1, 0]) @ model.vectors[:, : model.n_free] ** 2)
    squares = np.zeros(len(x))
    for noise in form.noises:
        both = bordered(model, numbers, form.output, noise.vector.astype(complex))
        bottom, top = (determinants(one.reshape(-1, *one.shape[2:]), size).reshape(len(x), -1) for one in both)
        made = _quotient(*(np.moveaxis(one, -1, 0) for one in _coefficients(form, model, noise, top, bottom, rate)))
        above, off, below, shift = (one[:, 0] for one in made)
        sure = (off <= _BOUND * above) & (shift <= _BOUND * below)
        squares += np.where(sure, np.pi * noise.density * rate * above / below, np.nan)
    return np.sqrt(squares)


def _single(form: RootMeanSquare, known: FormBounds, low: FloatArray, high: FloatArray) -> Bounds:
    """Of what one mount bears, where several share it."""
    least, most = _bounds(form, known, low, high)
    few, many = mounts(known.model, form.output).extent(low, high)
    return least / many, most / few


def _bounds(form: RootMeanSquare, known: FormBounds, low: FloatArray, high: FloatArray) -> Bounds:
    rate, above, off = typical_rate(known.model, known.reference), np.zeros(0), np.zeros(0)
    for noise in form.noises:
        top, bottom = _polynomials(form, known, noise, low, high, rate)
        parts, size = _quotient(top, bottom), np.pi * noise.density * rate
        above = size * parts[0] + (above if above.size else 0.0)
        off = size * parts[1] + (off if off.size else 0.0)
    below, shift = parts[2:]
    with np.errstate(invalid="ignore"):
        least = ratio_bounds((above - off)[:, None], (below + shift)[:, None])[0]
        most = ratio_bounds((above + off)[:, None], (below - shift)[:, None])[1]
    told = np.isfinite(above).all(axis=1) & np.isfinite(below).all(axis=1) & (below > 0.0).any(axis=1)
    return np.sqrt(np.where(told, least[:, 0], 0.0)), np.sqrt(np.where(told, most[:, 0], np.inf))


def _polynomials(
    form: RootMeanSquare, known: FormBounds, noise: Noise, low: FloatArray, high: FloatArray, rate: float
) -> tuple[FloatArray, FloatArray]:
    """N and D on boxes by ascending powers of s / rate, (order, n_boxes, ...) and (order + 1, n_boxes, ...).

    Each as Bernstein coefficients times binomials, one axis a variable: so a product of two is a convolution.  N is not
    a number where white noise is left of the response at high speeds or at rest.
    """
    model, groups = known.model, form.groups(known.model)
    if (noise.name, 0) not in known.samples:
        vector = noise.vector.astype(complex)
        made = expanded(model, form.output, vector, circle(model, rate), known.reference)
        known.samples[noise.name, 0] = made
    top, bottom = known.samples[noise.name, 0].at(nodes(groups, low, high))
    above, below = _coefficients(form, model, noise, top, bottom, rate)
    return tables(above, groups), tables(below, groups)


def _coefficients(
    form: RootMeanSquare, model: Model, noise: Noise, top: ComplexArray, bottom: ComplexArray, rate: float
) -> tuple[FloatArray, FloatArray]:
    """N (..., order) and D (..., order + 1) by ascending powers of s / rate, from values (..., n) on the circle."""
    order, above, below = 2 * model.n_free, powers(top), powers(bottom)
    moved = form.output.power - 2 * (bool(noise.vector[model.n_free :].any()) and not noise.displaced)
    kept = np.roll(above, moved, axis=-1) * rate**moved
    left = np.abs(kept[..., order:]).max(axis=-1)
    kept[left > _NOTHING * np.abs(kept).max(axis=-1)] = np.nan
    return kept[..., :order], below[..., : order + 1]


def _quotient(top: FloatArray, bottom: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """-det B and 2 a_0 det A, each with what rounding may take of it: Bernstein coefficients (n_boxes, ...)."""
    order = len(top)
    squared, sizes = dict[int, FloatArray](), dict[int, FloatArray]()
    for i, j in np.ndindex(order, order):
        if (i + j) % 2 == 0:
            at, sign = order - 1 - (i + j) // 2, (-1.0) ** j
            squared[at] = squared.get(at, 0.0) + sign * _times(top[i], top[j])
            sizes[at] = sizes.get(at, 0.0) + _size(top[i]) * _size(top[j])
    polynomials, numbers = list(bottom), [_size(one) for one in bottom]
    minors, rounded = _minors(polynomials, signed=True), _minors(numbers, signed=False)
    first, own = _row(polynomials, 0), _row(numbers, 0)
    above, below = (_along(one, minors, order, signed=True) for one in (squared, first))
    off, shift = (_along(one, rounded, order, signed=False) for one in (sizes, own))
    below, shift = _times(polynomials[-1], below), numbers[-1] * shift
    return -plain(above), ROUNDING * off[:, None], 2.0 * plain(below), 2.0 * ROUNDING * shift[:, None]


def _row(bottom: Sequence[FloatArray], i: int) -> dict[int, FloatArray]:
    """Row i of the Hurwitz matrix of D, its numbers by ascending powers: what is not zero, by its column."""
    order = len(bottom) - 1
    return {j: bottom[order - (2 * j + 1 - i)] for j in range(order) if 0 <= 2 * j + 1 - i <= order}


def _minors(bottom: Sequence[FloatArray], *, signed: bool) -> dict[int, FloatArray]:
    """Determinants of all rows of the Hurwitz matrix but the first, by the columns that they have, as bits."""
    found: dict[int, FloatArray] = {}
    for i in range(len(bottom) - 2, 0, -1):
        row, last = _row(bottom, i), found
        found = {1 << j: one for j, one in row.items()} if not last else {}
        for columns, minor in last.items():
            for j, one in row.items():
                if not columns >> j & 1:
                    odd = signed and (columns & ((1 << j) - 1)).bit_count() % 2
                    part = _times(one, minor)
                    found[columns | 1 << j] = found.get(columns | 1 << j, 0.0) + (-part if odd else part)
    return found


def _along(first: dict[int, FloatArray], minors: dict[int, FloatArray], order: int, *, signed: bool) -> FloatArray:
    """The determinant with a first row, by its columns; of numbers above zero all that rounding may move."""
    whole, total = (1 << order) - 1, np.zeros(())
    for j, one in first.items():
        minor = minors.get(whole ^ 1 << j)
        if minor is not None:
            total = total + (-1.0 if signed and j % 2 else 1.0) * _times(one, minor)
    return total


def _times(one: FloatArray, other: FloatArray) -> FloatArray:
    """Products of polynomials, Bernstein coefficients times binomials (n_boxes, ...); or of numbers (n_boxes,)."""
    if one.ndim == 1:
        return one * other
    if one.size > other.size:
        one, other = other, one
    shape = [a + b - 1 for a, b in zip(one.shape[1:], other.shape[1:], strict=True)]
    found = np.zeros((len(other), *shape))
    for at in np.ndindex(*one.shape[1:]):
        place = tuple(slice(i, i + n) for i, n in zip(at, other.shape[1:], strict=True))
        found[(slice(None), *place)] += one[(slice(None), *at)].reshape(-1, *[1] * len(shape)) * other
    return found


def _size(one: FloatArray) -> FloatArray:
    """The greatest Bernstein coefficient on each box, (n_boxes,)."""
    return np.asarray(np.abs(plain(one)).max(axis=1))
