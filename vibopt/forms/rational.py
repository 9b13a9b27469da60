"""Responses at fixed speeds as ratios of polynomials in the design variables.

Every group of variable terms that share a vector b adds kappa b b^T to the dynamic stiffness, with
kappa = sum of its terms' impedances.  Determinants are affine in each kappa (rank one), so the
response at one speed is N(kappa) / D(kappa), both multi-affine: 2**groups numbers each.
Written in y with x = y**root, they are polynomials, and Bernstein coefficients bound them on a box.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache, reduce
from itertools import pairwise, product
from math import comb, prod
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.harmonic import bordered
from vibopt.mechanics.model import INERTIA, STIFFNESS, Model, factors
from vibopt.records import cached_property, dataclass
from vibopt.signals import Line, Output

TELLING = 4
"""Speeds at which a response is greatest at the middle of a box, and as many at which it is least."""
_FEW_NODES = 27
"""Coefficients up to which a table of all products is the quicker way to a square."""
_NEAR = 1 << 17
"""Numbers of a table that stay near the processor from one step to the next."""


_VALUE, _PAIR = 0.2, 0.1
"""Work of a term of a value, and of a product in a square, as parts of that of a coefficient."""


@dataclass(frozen=True)
class Groups:
    """Variable terms of a model, sorted by their vector.

    members
        Per group the indices of its terms.
    rank
        How many of them a determinant can hold as factors: its rows, and one more where they are in what is read.
    """

    model: Model
    members: tuple[tuple[int, ...], ...]
    rank: int

    @classmethod
    def of(cls, model: Model, signs: FloatArray | None = None, *, static: bool = False) -> Groups:
        """Groups of a model; with `static` only springs and weights, kept apart.

        Terms that an output reads with different `signs` (n_terms,) are kept apart too: a mass and a
        mount on the same coordinate move it alike, but only the mount hands on a force.
        """
        found: dict[tuple[float, ...], list[int]] = {}
        for t in np.flatnonzero(model.exponents.any(axis=1)):
            if static and model.kinds[t] not in (STIFFNESS, INERTIA):
                continue
            row = model.vectors[t]
            first = row[np.flatnonzero(row)[0]] if row.any() else 1.0
            read = 0.0 if signs is None else float(signs[t])
            key = (float(static and model.kinds[t] == INERTIA), read, *(np.round(row * np.sign(first), 14) + 0.0))
            found.setdefault(key, []).append(int(t))
        rank = model.n_free + int(static or (signs is not None and bool(np.any(signs))))
        return cls(model, tuple(tuple(members) for members in found.values()), rank)

    @cached_property
    def selector(self) -> FloatArray:
        """Shape (n_terms, n_groups): 1 where a term belongs to a group."""
        table = np.zeros((len(self.model.terms), len(self.members)))
        for g, members in enumerate(self.members):
            table[list(members), g] = 1.0
        return table

    @cached_property
    def alike(self) -> tuple[tuple[int, ...], ...]:
        """Groups whose kappa are the same but for a factor, at any design and speed."""
        found: dict[tuple[Any, ...], list[int]] = {}
        for g, members in enumerate(self.members):
            own, first = self.model, abs(self.model.scales[members[0]])
            sizes = own.scales[list(members)] / first, own.static_scales[list(members)] / first
            rows = zip(own.kinds[list(members)], *sizes, *own.exponents[list(members)].T, strict=True)
            found.setdefault(tuple(sorted(tuple(float(f"{one:.13g}") for one in row) for row in rows)), []).append(g)
        return tuple(tuple(own) for own in found.values())

    @cached_property
    def lengths(self) -> tuple[int, ...]:
        """How many coefficients N and D have in what is alike."""
        return tuple(min(len(own), self.rank) + 1 for own in self.alike)

    @cached_property
    def fold(self) -> tuple[IntArray, IntArray]:
        """Coefficients over subsets that a determinant can hold, and where each counts in what is alike, each (n,)."""
        on = np.array(list(product((0, 1), repeat=len(self.members))))
        counts = np.array([on[:, list(own)].sum(axis=1) for own in self.alike])
        kept = np.flatnonzero((counts < np.array(self.lengths)[:, None]).all(axis=0))
        return kept, np.ravel_multi_index(tuple(counts[:, kept]), self.lengths)

    def folded(self, table: ComplexArray) -> ComplexArray:
        """Coefficients over subsets (n_samples, 2**n_groups), those of as many factors alike added up."""
        kept, places = self.fold
        found = np.zeros((prod(self.lengths), len(table)), dtype=complex)
        np.add.at(found, places, table[:, kept].T)
        return np.ascontiguousarray(found.T)

    @cached_property
    def roots(self) -> FloatArray:
        """x_i = y_i**root_i makes every exponent whole, and not negative, shape (n_vars,)."""
        exponents = self.model.exponents
        half = (np.abs(exponents * 2 % 2) == 1).any(axis=0)
        falling = (exponents <= 0.0).all(axis=0) & exponents.any(axis=0)
        return np.where(half, 2.0, 1.0) * np.where(falling, -1.0, 1.0)

    @cached_property
    def degrees(self) -> tuple[int, ...]:
        """Degree of N and D in each y_i."""
        each = [(self.model.exponents[list(members)] * self.roots).max(axis=0) for members in self.members]
        factors = np.sort(np.array(each).reshape(len(each), self.model.n_vars), axis=0)
        return tuple(round(d) for d in factors[-self.rank :].sum(axis=0).tolist())

    @property
    def work(self) -> int:
        """To bound one quotient on a box [coefficients of small ones]: values at nodes, their squares, quotients."""
        nodes, kept = prod(degree + 1 for degree in self.degrees), prod(self.lengths)
        return prod(2 * degree + 1 for degree in self.degrees) + int(nodes * (_VALUE * kept + _PAIR * nodes))


@dataclass(frozen=True)
class Sampled:
    """N and D of one line of a response at several speeds.

    factors
        Frequency factor of each term, shape (n_samples, n_terms).
    top, bottom
        Coefficients of N and D over subsets of groups, shape (n_samples, 2**n_groups); the row's
        power of i w and the amplitude are in `top`.
    scale
        What each kappa is divided by, shape (n_samples, n_groups).
    static
        Whether static stiffnesses are meant.
    """

    groups: Groups
    factors: ComplexArray
    top: ComplexArray
    bottom: ComplexArray
    scale: FloatArray
    static: bool = False

    @property
    def count(self) -> int:
        """Number of speeds."""
        return len(self.top)

    def joined(self, other: Sampled) -> Sampled:
        """The speeds of both; `scale` of each is kept."""
        return replace(
            self,
            factors=np.concatenate([self.factors, other.factors]),
            top=np.concatenate([self.top, other.top]),
            bottom=np.concatenate([self.bottom, other.bottom]),
            scale=np.concatenate([self.scale, other.scale]),
        )

    def chosen(self, rows: IntArray) -> Sampled:
        """Those of some of the speeds, by their places (n,)."""
        parts = (self.factors[rows], self.top[rows], self.bottom[rows], self.scale[rows])
        return Sampled(self.groups, *parts, static=self.static)

    def square(self, x: FloatArray) -> FloatArray:
        """|N / D|^2 at designs x (n, n_vars), shape (n, n_samples); not a number where it is not known."""
        top, bottom = self.at(x)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            value: FloatArray = np.abs(top / bottom) ** 2
        return value

    def at(self, x: FloatArray, rows: IntArray | None = None) -> tuple[ComplexArray, ComplexArray]:
        """N and D at designs x (..., n_vars), each (..., n_samples).

        At `rows` (n, k) of its speeds alone, which differ from box to box, x is (n, m, n_vars) and they (n, m, k).
        """
        values = self.groups.model.values(x, static=self.static)
        (top, bottom), first = self._folded, [own[0] for own in self.groups.alike]
        scale, selector = self.scale[:, first], self.groups.selector[:, first]
        if rows is None:
            each = self.factors.T[:, :, None] * selector[:, None] / scale  # (n_terms, n_samples, G)
            kappa = values @ each.reshape(len(each), -1)
        else:
            top, bottom, scale = top[rows][:, None], bottom[rows][:, None], scale[rows]
            each = self.factors[rows].swapaxes(1, 2)[..., None] * selector[:, None] / scale[:, None]
            kappa = values @ each.reshape(*each.shape[:2], -1)  # of each box (n_terms, k, G)
        kappa, lengths = kappa.reshape(*values.shape[:-1], *scale.shape[-2:]), self.groups.lengths
        return _evaluated(top, kappa, lengths), _evaluated(bottom, kappa, lengths)

    @cached_property
    def _folded(self) -> tuple[ComplexArray, ComplexArray]:
        """N and D in what is alike, each (n_samples, n_left)."""
        if len(self.groups.alike) == len(self.groups.members):
            return self.top, self.bottom
        return self.groups.folded(self.top), self.groups.folded(self.bottom)


def _evaluated(coefficients: ComplexArray, kappa: ComplexArray, lengths: tuple[int, ...]) -> ComplexArray:
    """A polynomial with so many coefficients in each of kappa (..., n, G), in all (..., n, n_left)."""
    count = prod(kappa.shape[:-1]) * coefficients.shape[-1]
    if count > _NEAR and kappa.ndim > 2 and len(kappa) > 1:
        ends = np.linspace(0, len(kappa), min(len(kappa), -(-count // _NEAR)) + 1).astype(int)
        own = coefficients.ndim == kappa.ndim
        parts = [slice(*some) for some in pairwise(ends)]
        each = [(coefficients[part] if own else coefficients, kappa[part]) for part in parts]
        return np.concatenate([_evaluated(*one, lengths) for one in each])
    value = np.broadcast_to(coefficients, (*kappa.shape[:-1], coefficients.shape[-1]))
    for g, length in enumerate(lengths):
        powers = value.reshape(*value.shape[:-1], length, value.shape[-1] // length)
        value = powers[..., -1, :]
        for power in range(length - 2, -1, -1):
            value = powers[..., power, :] + value * kappa[..., g, None]
    return value[..., 0]


def sampled(model: Model, output: Output, line: Line, speeds: FloatArray, reference: FloatArray) -> Sampled:
    """Coefficients of one line at `speeds` (n,) [rad/s]; `reference` (n_vars,) is a typical design."""
    omega = line.order * speeds
    made = expanded(model, output, line.vector, omega, reference)
    push = (1j * omega) ** output.power * line.amplitude.at(speeds)
    return replace(made, top=made.top * push[:, None])


def sampled_lines(
    model: Model, output: Output, lines: Sequence[Line], speeds: FloatArray, reference: FloatArray
) -> Sampled:
    """Those of several lines, (n_speeds n_lines,) samples: all lines at the first speed, then at the next."""
    alike: dict[bytes, list[int]] = {}
    for index, line in enumerate(lines):
        alike.setdefault(line.vector.tobytes(), []).append(index)
    if len(lines) == 1:
        return sampled(model, output, lines[0], speeds, reference)
    made, place = list[Sampled](), np.empty((len(speeds), len(lines)), dtype=int)
    for own in alike.values():  # lines that push alike are one line at the speeds of all of them
        omega = np.concatenate([lines[index].order * speeds for index in own])
        sizes = np.concatenate([lines[index].amplitude.at(speeds) for index in own])
        one = expanded(model, output, lines[own[0]].vector, omega, reference)
        begin = sum(other.count for other in made)
        place[:, own] = begin + np.arange(len(omega)).reshape(len(own), -1).T
        made.append(replace(one, top=one.top * ((1j * omega) ** output.power * sizes)[:, None]))
    return reduce(Sampled.joined, made).chosen(place.ravel())


def expanded(
    model: Model, output: Output, vector: ComplexArray, omega: ComplexArray | FloatArray, reference: FloatArray
) -> Sampled:
    """The same without power and amplitude of what shakes by `vector` (n_coords,); omega (n,) [rad/s], s = i omega."""
    groups = Groups.of(model, output.signs)
    phi = factors(model.kinds, omega)
    fixed = np.where(model.exponents.any(axis=1), 0.0, model.scales)
    typical = model.values(reference) * phi
    scale = np.abs(typical) @ groups.selector
    scale = np.where(scale == 0.0, 1.0, scale)
    size = np.sqrt(np.abs(typical) @ (model.vectors[:, : model.n_free] ** 2))
    size = np.where(size == 0.0, 1.0, size)
    tops, bottoms = [], []
    for z in _corners(groups, scale, fixed * phi):
        stiff, border = bordered(model, z, output, vector)
        tops.append(determinants(border, size))
        bottoms.append(determinants(stiff, size))
    top, bottom = (_mobius(np.concatenate(one).T) for one in (tops, bottoms))
    return Sampled(groups, phi, top, bottom, scale)


def sampled_static(model: Model, row: FloatArray, reference: FloatArray) -> Sampled:
    """Deflection `row . u` under the weights as one sample; K u = m g with static stiffness."""
    groups = Groups.of(model, static=True)
    n = model.n_free
    holds, weighs = model.kinds == STIFFNESS, model.kinds == INERTIA
    phi = (holds | weighs)[None, :].astype(complex)
    fixed = np.where(model.exponents.any(axis=1), 0.0, model.static_scales)
    scale = (model.values(reference, static=True) * phi.real) @ groups.selector
    scale = np.where(scale == 0.0, 1.0, scale)
    tops, bottoms = [], []
    for z in (one for some in _corners(groups, scale, fixed * phi) for one in some):
        p = z[0].real
        stiff = model.matrix(STIFFNESS, p)[:n, :n]
        border = np.zeros((n + 1, n + 1))
        border[:n, :n] = stiff
        border[:n, n] = GRAVITY * model.weights(p)[:n]
        border[n, :n] = -row[:n]
        size = np.sqrt((model.values(reference, static=True) * holds) @ (model.vectors[:, :n] ** 2))
        size = np.concatenate([np.where(size == 0.0, 1.0, size), [1.0]])
        tops.append(np.linalg.det(border / np.outer(size, size)))
        bottoms.append(np.linalg.det(stiff / np.outer(size[:n], size[:n])))
    top, bottom = (_mobius(np.array([one], dtype=complex)) for one in (tops, bottoms))
    return Sampled(groups, phi, top, bottom, scale, static=True)


def _corners(groups: Groups, scale: FloatArray, fixed: ComplexArray) -> Iterator[ComplexArray]:
    """Terms (some, n, n_terms) with every choice of groups at their sizes, the others nothing; the last turns first."""
    on = np.array(list(product((0.0, 1.0), repeat=len(groups.members))))
    first = [members[0] for members in groups.members]
    for some in np.array_split(on, max(len(on) * fixed.size * groups.rank // _NEAR, 1)):
        z = np.tile(fixed, (len(some), 1, 1))
        z[..., first] += some[:, None] * scale
        yield z


def determinants(matrix: ComplexArray, size: FloatArray) -> ComplexArray:
    """Determinants, rows and columns of free coordinates scaled alike at every subset: nothing over- or underflows."""
    n = matrix.shape[-1]
    if size.shape[1] == 1:
        m = matrix
        return m[..., 0, 0] if n == 1 else m[..., 0, 0] * m[..., 1, 1] - m[..., 0, 1] * m[..., 1, 0]
    if n > size.shape[1]:
        size = np.concatenate([size, np.ones((len(size), 1))], axis=1)
    value: ComplexArray = np.linalg.det(matrix / (size[:, :, None] * size[:, None, :]))
    return value


def _mobius(values: ComplexArray) -> ComplexArray:
    """From values at the corners kappa in {0, scale} to multi-affine coefficients, shape (n, 2**G)."""
    count = int(np.log2(values.shape[-1]))
    table = values.reshape(values.shape[0], *([2] * count)).copy()
    for axis in range(1, count + 1):
        low, high = table.swapaxes(0, axis)
        high -= low
    return table.reshape(values.shape)


@lru_cache(maxsize=64)
def to_bernstein(degree: int) -> FloatArray:
    """From values at degree+1 even points on [0, 1] to Bernstein coefficients."""
    t = np.linspace(0.0, 1.0, degree + 1) if degree else np.zeros(1)
    basis = np.array([[comb(degree, k) * s**k * (1 - s) ** (degree - k) for k in range(degree + 1)] for s in t])
    inverse: FloatArray = np.linalg.inv(basis)
    return inverse


@lru_cache(maxsize=64)
def _product(degree: int) -> FloatArray:
    """Shape (2d+1, d+1, d+1): Bernstein coefficients of a product of two polynomials of degree d."""
    table = np.zeros((2 * degree + 1, degree + 1, degree + 1))
    for i in range(degree + 1):
        for j in range(degree + 1):
            table[i + j, i, j] = comb(degree, i) * comb(degree, j) / comb(2 * degree, i + j)
    return table


@lru_cache(maxsize=64)
def transforms(degrees: tuple[int, ...]) -> tuple[FloatArray, FloatArray, FloatArray | None]:
    """Nodes on the unit box (n_nodes, n_vars), values-to-coefficients, and the table of squares.

    The table has shape (n_products, n_pairs), of pairs of coefficients as `np.triu_indices` has them; None of many.
    """
    grids = np.meshgrid(*[np.linspace(0, 1, d + 1) if d else np.zeros(1) for d in degrees], indexing="ij")
    nodes = np.stack([grid.ravel() for grid in grids], axis=-1) if degrees else np.zeros((1, 0))
    change: FloatArray = np.ones((1, 1))
    product: FloatArray = np.ones((1, 1, 1))
    for degree in degrees:
        change = np.asarray(np.kron(change, to_bernstein(degree)), dtype=float)
    if len(change) > _FEW_NODES:
        return nodes, change, None
    for degree in degrees:
        product = np.asarray(np.kron(product, _product(degree)), dtype=float)
    i, j = np.triu_indices(len(change))
    return nodes, change, np.where(i == j, product[:, i, j], product[:, i, j] + product[:, j, i])


def box_coefficients(
    line: Sampled, low: FloatArray, high: FloatArray, rows: IntArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Bernstein coefficients of |N|^2 and |D|^2 on boxes, each (n_boxes, n_samples, n_products).

    low, high
        Corners of the boxes in x, shape (n_boxes, n_vars).
    rows
        At which of its speeds, for each box, shape (n_boxes, k) in place of all; then (n_boxes, k, n_products).
    """
    groups = line.groups
    nodes, _, _ = transforms(groups.degrees)
    root = 1.0 / groups.roots
    y_low, y_high = low**root, high**root
    y = y_low[:, None, :] + (y_high - y_low)[:, None, :] * nodes
    top, bottom = line.at(y**groups.roots, rows)
    return _square(top, groups.degrees), _square(bottom, groups.degrees)


def _square(values: ComplexArray, degrees: tuple[int, ...]) -> FloatArray:
    """|.|^2 from values at the nodes (n_boxes, n_nodes, n_samples), shape (n_boxes, n_samples, n_products)."""
    _, change, pairs = transforms(degrees)
    parts = change @ values.real, change @ values.imag
    if pairs is None:
        return _convolved(parts, degrees).swapaxes(1, 2)
    i, j = np.triu_indices(len(change))
    found: FloatArray = pairs @ sum((one[:, i] * one[:, j] for one in parts), np.zeros(()))
    return found.swapaxes(1, 2)


def _convolved(parts: Sequence[FloatArray], degrees: tuple[int, ...]) -> FloatArray:
    """Bernstein coefficients of the sum of squares of polynomials that have these (n_boxes, n_nodes, n_samples)."""
    begin, count, end = parts[0].shape
    columns = [part.swapaxes(0, 1).reshape(count, -1) * _binomials(degrees)[:, None] for part in parts]
    weights = _binomials(tuple(2 * degree for degree in degrees))[:, None]
    ends = np.linspace(0, begin * end, min(begin * end, -(-begin * end * len(weights) // _NEAR)) + 1).astype(int)
    found = [_squares_added([one[:, low:high] for one in columns], degrees) / weights for low, high in pairwise(ends)]
    return np.concatenate(found, axis=1).reshape(-1, begin, end).swapaxes(0, 1)


def _squares_added(columns: Sequence[FloatArray], degrees: tuple[int, ...]) -> FloatArray:
    """Sum of squares of polynomials with coefficients (n_nodes, n) of powers, in so many variables, (n_products, n)."""
    first, *others = [degree + 1 for degree in degrees]
    found = np.zeros((*[2 * degree + 1 for degree in degrees], columns[0].shape[1]))
    for column in columns:
        each = column.reshape(first, *others, -1)
        for lead in range(first):  # of two that differ in the first power, either may be the first
            both = np.concatenate([each[lead : lead + 1], 2.0 * each[lead + 1 :]])
            for place in np.ndindex(*others):
                into = [slice(k, k + long) for k, long in zip(place, others, strict=True)]
                found[(slice(2 * lead, lead + first), *into)] += each[(lead, *place)] * both
    return found.reshape(-1, found.shape[-1])


@lru_cache(maxsize=64)
def _binomials(degrees: tuple[int, ...]) -> FloatArray:
    """Products of the binomial coefficients of all degrees, (n_nodes,)."""
    rows = product(*[[comb(degree, k) for k in range(degree + 1)] for degree in degrees])
    return np.array([float(prod(row)) for row in rows])


def ratio_bounds(top: FloatArray, bottom: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Bounds of top/bottom on each box from Bernstein coefficients, shape (n_boxes, n_samples).

    The lower bound is the least quotient of coefficients with positive denominator; it is valid
    because top - low * bottom then has no negative coefficient.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        quotient, positive = top / bottom, bottom > 0.0
        if positive.all():
            return np.maximum(quotient.min(axis=-1), 0.0), np.maximum(quotient.max(axis=-1), 0.0)
        low = np.where(positive, quotient, np.inf).min(axis=-1)
        low = np.where((~positive & (top < low[..., None] * bottom)).any(axis=-1), 0.0, low)
        high = np.where(positive.all(axis=-1), np.where(positive, quotient, -np.inf).max(axis=-1), np.inf)
    return np.maximum(low, 0.0), np.maximum(high, 0.0)
