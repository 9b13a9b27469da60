"""The mechanical model: rank-one terms whose coefficients are monomials of the design variables."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable
from dataclasses import field, replace
from typing import Any, TypeVar

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from vibopt.mechanics.bearings import Bearing
from vibopt.mechanics.monomial import Monomial
from vibopt.records import cached_property, dataclass

K = TypeVar("K")
T = TypeVar("T")
INERTIA, STIFFNESS, DAMPING, HYSTERETIC = 0, 1, 2, 3
_NOTHING = 1e-13
"""A term whose vector shrinks below this part of itself has no part in a reduced model."""


@dataclass(frozen=True, slots=True)
class Term:
    """coefficient * b b^T with coefficient = scale * prod_i x_i**exponents_i.

    kind
        INERTIA [kg], STIFFNESS [N/m], DAMPING [N s/m] or HYSTERETIC (imaginary stiffness) [N/m].
    vector
        b, shape (n_coords,).
    static_scale
        `scale` where only weights act: static and dynamic stiffness differ for rubber, and gravity has no
        hold on an inertia that turns (0).
    owner
        Name of the body or link that it belongs to.
    across
        Whether it acts between the two ends of its owner, as springs, dampers and inerters do.
    shares
        Of its owner's ends, first and second, how far each moves it, held ones too; what is between them has (-1, 1).
    polar
        Whether it is an INERTIA less than nothing, the polar one of what spins, in a whirl forward with the spin.
    tilts
        Of a span of a shaft, how far tilting its left and its right end moves it.
    apart
        Whether it is a correction to another term of a span whose length may be chosen, and holds nothing by itself.
    """

    kind: int
    vector: FloatArray
    scale: float
    exponents: FloatArray
    owner: str
    static_scale: float
    across: bool = False
    shares: tuple[float, float] = (0.0, 0.0)
    polar: bool = False
    tilts: tuple[float, float] = (0.0, 0.0)
    apart: bool = False


@dataclass(frozen=True)
class Model:
    """Linear model M, C, K on named coordinates, affine in its terms.

    points
        Per point (body, base) the row that reads its displacement, shape (n_coords,).
    n_free
        Number of free coordinates.
    terms
        The rank-one terms.
    links
        Per link the signed incidence vector, shape (n_coords,): row . u is its extension [m].
    ends
        Per link its two ends, as in the file ("ground" has no coordinate).
    counts
        Per link the number of identical mounts in it, and of one that bends or twists the stretch at which its stress
        is one ("shaft stress").
    ratios
        Per link that has one, its damping ratio.
    properties
        Own numbers of a device by its name and the word for them, ("tmd", "tuning").
    readings
        What is read of a beam with a mass, by its name and a word: how its spring pulls, how its mass does as its mean
        moves, and as its shape moves beside that; of impedance times motion.
    families
        Names by the family of the file that they come from.
    rotating
        Dampers that turn with a shaft, which steady whirl does not feel.
    gears
        Per body that is geared to another that one, and how many times as fast it turns.
    bearings
        Those that are not alike in both planes: whirl then has a forward and a backward part.
    axes
        Per link of a mount its direction in space, shape (3,); any other link is along z.
    basis
        Coordinates of the full model from these, shape (n_full, n_coords); empty where they are the same.
    left_out, remarks
        Degrees of freedom of structures that the points do not need, and how good the rest is, in words.
    precision
        Relative error of the receptances of its structures.
    """

    points: dict[str, FloatArray]
    n_free: int
    terms: tuple[Term, ...]
    links: dict[str, FloatArray] = field(default_factory=dict)
    ends: dict[str, tuple[str, str]] = field(default_factory=dict)
    counts: dict[str, Monomial] = field(default_factory=dict)
    ratios: dict[str, Monomial] = field(default_factory=dict)
    properties: dict[tuple[str, str], Monomial] = field(default_factory=dict)
    readings: dict[tuple[str, str], tuple[float, float, float]] = field(default_factory=dict)
    families: dict[str, tuple[str, ...]] = field(default_factory=dict)
    rotating: tuple[Term, ...] = ()
    gears: dict[str, tuple[str, float]] = field(default_factory=dict)
    bearings: tuple[Bearing, ...] = ()
    axes: dict[str, FloatArray] = field(default_factory=dict)
    basis: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    left_out: int = 0
    remarks: tuple[str, ...] = ()
    precision: float = 0.0

    @cached_property
    def kinds(self) -> IntArray:
        """Kind of each term, shape (n_terms,)."""
        return np.array([term.kind for term in self.terms], dtype=int)

    @cached_property
    def alone(self) -> tuple[list[int], list[float]]:
        """Kind of each term, and its part in the first coordinate, as plain numbers."""
        return self.kinds.tolist(), self.vectors[:, 0].tolist()

    @cached_property
    def across(self) -> BoolArray:
        """Whether each term acts between the two ends of its owner, shape (n_terms,)."""
        return np.array([term.across for term in self.terms], dtype=bool)

    @cached_property
    def inerters(self) -> BoolArray:
        """Inertia terms that act between two ends, shape (n_terms,)."""
        return np.asarray(self.across & (self.kinds == INERTIA))

    @cached_property
    def with_beams(self) -> bool:
        """Whether the mass of a beam is spread between two ends."""
        return any(term.kind == INERTIA and not term.across and any(term.shares) for term in self.terms)

    @cached_property
    def spins(self) -> bool:
        """Whether something spins, and each frequency is that of a whirl with the spin."""
        return any(term.polar for term in self.terms)

    @property
    def spun_in_time(self) -> bool:
        """Whether what is free hangs on the spin: by gyroscopic moments, dampers that turn, or bearings in planes."""
        return self.spins or bool(self.rotating or self.bearings)

    @property
    def acting(self) -> FloatArray:
        """Exponents of all that may act on a whirl, rows of (n_vars,)."""
        held = [power.row(self.n_vars) for bearing in self.bearings for power in bearing.powers]
        return np.vstack([self.exponents, *(term.exponents for term in self.rotating), *held])

    @cached_property
    def backward(self) -> Model:
        """The model of a whirl against the spin, as fast as it spins: polar inertia adds to the other one."""
        turned = (replace(term, scale=-term.scale) if term.polar else term for term in self.terms)
        return replace(self, terms=tuple(turned)) if self.spins else self

    @cached_property
    def undamped(self) -> Model:
        """The model without dampers and loss factors."""
        held = (term for term in self.terms if term.kind in (STIFFNESS, INERTIA))
        bearings = tuple(bearing.undamped for bearing in self.bearings)
        return replace(self, terms=tuple(held), rotating=(), bearings=bearings)

    @cached_property
    def massless(self) -> BoolArray:
        """Whether no inertia acts on each free coordinate: joints without mass, shape (n_free,)."""
        return np.asarray(~self.vectors[self.kinds == INERTIA, : self.n_free].any(axis=0))

    @cached_property
    def vectors(self) -> FloatArray:
        """b of each term, shape (n_terms, n_coords)."""
        return np.array([term.vector for term in self.terms], dtype=float)

    @cached_property
    def scales(self) -> FloatArray:
        return np.array([term.scale for term in self.terms], dtype=float)

    @cached_property
    def static_scales(self) -> FloatArray:
        return np.array([term.static_scale for term in self.terms], dtype=float)

    @cached_property
    def exponents(self) -> FloatArray:
        """Shape (n_terms, n_vars)."""
        return np.array([term.exponents for term in self.terms], dtype=float)

    @cached_property
    def sprung(self) -> bool:
        """Whether springs plainly hold all that moves: each coordinate by one, beside those held without it."""
        springs = [term for term in self.terms if term.kind not in (DAMPING, INERTIA) and term.scale > 0.0]
        rows, held, count = [term.vector[: self.n_free].tolist() for term in springs], set[int](), -1
        while count < len(held) < self.n_free:
            count = len(held)
            for row in rows:
                loose = [i for i, one in enumerate(row) if one and i not in held]
                if len(loose) == 1 and abs(row[loose[0]]) >= 0.5 * max(map(abs, row)):
                    held.add(loose[0])
        return len(held) == self.n_free

    @property
    def n_vars(self) -> int:
        return int(self.exponents.shape[1])

    def values(self, x: FloatArray, *, static: bool = False) -> FloatArray:
        """Coefficient of each term at design `x`, shape (..., n_terms) for x (..., n_vars)."""
        scales = self.static_scales if static else self.scales
        if np.ndim(x) > 1:
            products: FloatArray = scales * self.products(np.asarray(x))[..., self.alike[1]]
            return products
        value: FloatArray = scales * np.multiply.reduce(np.asarray(x) ** self.exponents, axis=-1)
        return value

    @cached_property
    def alike(self) -> tuple[FloatArray, IntArray]:
        """The different rows of exponents, and which of them each term has: mounts of a group share theirs."""
        rows: dict[tuple[float, ...], int] = {}
        which = [rows.setdefault(tuple(one), len(rows)) for one in self.exponents.tolist()]
        return np.array(list(rows), dtype=float).reshape(len(rows), self.n_vars), np.array(which, dtype=int)

    def products(self, x: FloatArray) -> FloatArray:
        """Product of powers of each different row of exponents at many designs, (..., n_rows) for x (..., n_vars)."""
        rows = self.alike[0]
        found = np.ones((*x.shape[:-1], len(rows)))
        for row, variable in zip(*np.nonzero(rows), strict=True):
            found[..., row] *= x[..., variable] ** rows[row, variable]
        return found

    def static_blocks(self) -> tuple[FloatArray, FloatArray]:
        """Static stiffness (n_rows, n_free, n_free) and weighing mass (n_rows, n_free) of each row of `products`."""
        n, rows = self.n_free, range(len(self.alike[0]))
        springs, heavy = (np.where(self.kinds == kind, self.static_scales, 0.0) for kind in (STIFFNESS, INERTIA))
        free, which = self.vectors[:, :n], self.alike[1]
        stiff = np.array([(free[which == r].T * springs[which == r]) @ free[which == r] for r in rows])
        return stiff, np.array([heavy[which == r] @ free[which == r] for r in rows])

    def extent(self, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Least and greatest coefficient of each term on boxes (..., n_vars), each (..., n_terms)."""
        rising = self.exponents > 0.0
        here, there = np.asarray(low)[..., None, :], np.asarray(high)[..., None, :]
        with np.errstate(divide="ignore"):
            least = np.where(rising, here, there) ** self.exponents
            most = np.where(rising, there, here) ** self.exponents
        unused = self.exponents == 0.0
        small: FloatArray = self.scales * np.where(unused, 1.0, least).prod(axis=-1)
        large: FloatArray = self.scales * np.where(unused, 1.0, most).prod(axis=-1)
        return small, large

    @cached_property
    def mixed(self) -> bool:
        """Whether a variable raises some term and lowers another."""
        return bool(((self.exponents > 0.0).any(axis=0) & (self.exponents < 0.0).any(axis=0)).any())

    def matrix(self, kind: int, p: FloatArray) -> FloatArray:
        """Sum of the terms of one kind, shape (n_coords, n_coords), at coefficients p (n_terms,)."""
        chosen = self.kinds == kind
        vectors = self.vectors[chosen]
        total: FloatArray = (vectors.T * p[chosen]) @ vectors
        return total

    def sums(self, kind: int, p: FloatArray) -> FloatArray:
        """As `matrix`, (..., n_coords, n_coords), at coefficients that are `values` of designs, p (..., n_terms)."""
        picks, blocks = self._blocks[kind]
        return np.asarray(np.tensordot(p[..., picks] / self.scales[picks], blocks, axes=1))

    @cached_property
    def _blocks(self) -> list[tuple[IntArray, FloatArray]]:
        """Of each kind one term of every product of powers in it, and the matrix of all that go with it."""
        found = []
        for kind in range(4):
            chosen = np.flatnonzero((self.kinds == kind) & (self.scales != 0.0))
            alike = self.alike[1][chosen]
            groups = [chosen[alike == row] for row in np.unique(alike)]
            blocks = [(self.vectors[some].T * self.scales[some]) @ self.vectors[some] for some in groups]
            picks = np.array([some[0] for some in groups], dtype=int)
            found.append((picks, np.array(blocks).reshape(-1, self.n_coords, self.n_coords)))
        return found

    def turning(self, x: FloatArray) -> FloatArray:
        """Of dampers that turn with a shaft at a design (n_vars,), on the free coordinates, (n_free, n_free)."""
        found = np.zeros((self.n_free, self.n_free))
        for term in self.rotating:
            size = term.scale * float(np.where(term.exponents == 0.0, 1.0, np.asarray(x) ** term.exponents).prod())
            found += size * np.outer(term.vector[: self.n_free], term.vector[: self.n_free])
        return found

    @property
    def rubbing(self) -> tuple[str, tuple[Monomial, ...]] | None:
        """The link that has dry friction, and how much [N]; None where none has.

        Of several, which slip together, the first, and what adds to its friction.
        """
        every = {name: one for (name, word), one in self.properties.items() if word == "friction_force" and one.scale}
        return (next(iter(every)), tuple(every.values())) if every else None

    @property
    def n_coords(self) -> int:
        """Free coordinates and those of moving bases."""
        return int(self.terms[0].vector.shape[0])

    def weights(self, p: FloatArray) -> FloatArray:
        """Mass that gravity acts on per coordinate [kg], shape (n_coords,), at coefficients p (n_terms,).

        Every body's own row points along gravity, so each inertia term weighs on its own coordinate; with
        the static coefficients, of those that turn nothing is left.
        """
        chosen = self.kinds == INERTIA
        total: FloatArray = p[chosen] @ self.vectors[chosen]
        return total

    def held(self, kept: IntArray, values: FloatArray) -> Model:
        """The model in the variables `kept` (indices) only, all others at their `values` (n_vars,)."""
        fixed = np.setdiff1d(np.arange(len(values)), kept)

        def fewer(term: Term) -> Term:
            powers = term.exponents[fixed]
            size = float(np.where(powers == 0.0, 1.0, np.asarray(values)[fixed] ** powers).prod())
            scales = term.scale * size, term.static_scale * size
            return replace(term, scale=scales[0], static_scale=scales[1], exponents=term.exponents[kept])

        return self._counted_anew(fewer, lambda one: one.held(kept, values))

    def placed(self, where: IntArray, count: int) -> Model:
        """The model in `count` variables, of which variable i is number `where[i]` (n_vars,)."""

        def among(term: Term) -> Term:
            powers = np.zeros(count)
            powers[where] = term.exponents
            return replace(term, exponents=powers)

        return self._counted_anew(among, lambda one: one.placed(where))

    def _counted_anew(self, new: Callable[[Term], Term], change: Callable[[Monomial], Monomial]) -> Model:
        def changed(table: dict[K, Monomial]) -> dict[K, Monomial]:
            return {key: change(one) for key, one in table.items()}

        return replace(
            self,
            terms=tuple(map(new, self.terms)),
            rotating=tuple(map(new, self.rotating)),
            bearings=tuple(bearing.changed(change) for bearing in self.bearings),
            counts=changed(self.counts),
            ratios=changed(self.ratios),
            properties=changed(self.properties),
        )

    def on_basis(self, basis: FloatArray, *, drop: bool = False) -> Model:
        """The model on fewer free coordinates, u_free = basis @ v; basis (n_free, n_new).

        With `drop`, terms that have no part in it are left out; outputs must then be written anew.
        """
        n_base = self.n_coords - self.n_free
        whole = np.zeros((self.n_coords, basis.shape[1] + n_base))
        whole[: self.n_free, : basis.shape[1]] = basis
        whole[self.n_free :, basis.shape[1] :] = np.eye(n_base)
        size = np.abs(whole)
        moved = [(replace(term, vector=term.vector @ whole), np.abs(term.vector) @ size) for term in self.terms]
        terms = [term for term, most in moved if not drop or np.abs(term.vector).max() > _NOTHING * most.max()]
        return replace(
            self,
            points={name: row @ whole for name, row in self.points.items()},
            n_free=basis.shape[1],
            terms=tuple(terms),
            rotating=tuple(replace(term, vector=term.vector @ whole) for term in self.rotating),
            links={name: row @ whole for name, row in self.links.items()},
            basis=whole,
        )

    def through(self, whole: FloatArray, nothing: float) -> Model:
        """The model in as many other coordinates v, u = whole @ v, whole (n_coords, n_coords).

        The last ones are those of the bases, as they were.  A sum below the part `nothing` of its terms is rounding.
        """

        def moved(row: FloatArray) -> FloatArray:
            new = row @ whole
            return np.asarray(np.where(np.abs(new) <= nothing * (np.abs(row) @ np.abs(whole)), 0.0, new))

        return replace(
            self,
            points={name: moved(row) for name, row in self.points.items()},
            terms=tuple(replace(term, vector=moved(term.vector)) for term in self.terms),
            rotating=tuple(replace(term, vector=moved(term.vector)) for term in self.rotating),
            links={name: moved(row) for name, row in self.links.items()},
            basis=self.basis @ whole if self.basis.size else whole,
        )


def kept(
    model: Model, what: Hashable, x: FloatArray, measured: Callable[[FloatArray], Iterable[T]], most: int = 4096
) -> list[T]:
    """What is measured of a model in each row of x (n, m), of which the last ones stay with the model."""
    known: dict[bytes, T] = vars(model).setdefault("kept", {}).setdefault(what, {})
    rows = {one.tobytes(): i for i, one in enumerate(x)}
    found = {key: known[key] for key in rows if key in known}
    if new := {key: i for key, i in rows.items() if key not in found}:
        for key, one in zip(new, measured(x[list(new.values())]), strict=True):
            while len(known) >= most:
                known.pop(next(iter(known)))
            known[key] = found[key] = one
    return [found[one.tobytes()] for one in x]


def factors(kinds: IntArray, omega: FloatArray | ComplexArray) -> ComplexArray:
    """Frequency factor of each term, shape (..., n_terms): -w^2, 1, i w, i."""
    omega = np.asarray(omega, dtype=complex)[..., None]
    result = np.empty((*omega.shape[:-1], len(kinds)), dtype=complex)
    for kind in set(kinds.tolist()):
        result[..., kinds == kind] = _FACTOR[kind](omega)
    return result


_FACTOR: tuple[Callable[[ComplexArray], Any], ...] = (
    lambda omega: -(omega**2), lambda omega: 1.0, lambda omega: 1j * omega, lambda omega: 1j,
)  # fmt: skip


def stressed(link: str) -> str:
    """What `counts` calls the stretch or twist at which the stress of a link is one."""
    return f"{link} stress"


def forced(link: str) -> str:
    """What `counts` calls the force on all beams of a link at which its stress is one."""
    return f"{link} stress by force"
