"""The question an optimiser is asked, and its answer: arrays in SI, and no words of the file.

A correction u is what is added to the rotor; what is left at the readings is y0 + H u.  Phasors are
peak amplitude * exp(i angle) in the internal sense of `vibopt.balancing.conventions`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import field
from math import isfinite
from typing import Any, Literal

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from vibopt.balancing.fan import Fan
from vibopt.errors import InputError
from vibopt.records import cached_property, dataclass, replace

_ROUNDING = 1e-13
Goal = Literal["rms", "worst", "sum", "huber", "correction"]
Sectors = tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Options:
    """What a plane of holes and shelf weights offers.

    u
        Internal unbalances (n,) [kg m], the empty plane first.
    masses
        Of all weights of an option together (n,) [kg].
    uses
        How many of each counted mass an option takes (n, n_kinds); empty where none is counted.
    items
        Per option the indices into `offers`, -1 for none, (n, most_weights).
    offers
        (hole index, mass [kg], radius [m]) of single weights.
    """

    u: ComplexArray
    masses: FloatArray
    uses: FloatArray = field(default_factory=lambda: np.empty((0, 0)))
    items: IntArray = field(default_factory=lambda: np.empty((0, 0), dtype=np.int64))
    offers: tuple[tuple[int, float, float], ...] = ()

    def take(self, rows: Any) -> Options:
        """The list with some of its options."""
        columns = {name: getattr(self, name) for name in ("u", "masses", "uses", "items")}
        return replace(self, **{name: column[rows] for name, column in columns.items() if len(column)})

    def nearest(self, u: complex) -> int:
        """Place of the option next to an unbalance."""
        return int(np.argmin(np.abs(self.u - u)))

    def weights(self, index: int) -> tuple[tuple[int, float, float], ...]:
        """Hole, mass and radius of each weight of an option."""
        return tuple(self.offers[item] for item in self.items[index] if item >= 0)


@dataclass(frozen=True)
class Question:
    """What is left at each reading, what may be fitted in each plane, and what is to be small.

    Parameters
    ----------
    y0
        Readings as found, shape (n_readings,), peak [SI], runout subtracted.
    H
        Response per unit unbalance, shape (n_readings, n_planes) [SI per kg m].
    importance
        Factor on each amplitude in the goal (not in its limit), shape (n_readings,), zero or more.
    limits
        Greatest amplitude left, shape (n_readings,), inf where there is none.
    caps
        Greatest |u| per plane [kg m], shape (n_planes,); 0 for a plane that is kept, inf where there is none.  Of a
        list it caps the mass of an option over `mass_per_unbalance`: the sum of its weights, not what they do together.
    total_cap
        Greatest sum of correction masses [kg] (of |u| where `mass_per_unbalance` is 1).
    sectors
        Per plane the forbidden open arcs (from, to) [rad], with growing angle from `from` to `to`; empty: none.
    options
        Per plane what it chooses from; None: continuous; empty: continuous everywhere.  Zero belongs to the list where
        the plane may stay empty.
    goal
        "rms": sqrt(mean((importance |r|)²)); "worst": their greatest; "sum": their sum; "huber": sum of t² up to
        `huber` and 2 huber t - huber² beyond; "correction": the sum of correction masses.
    huber
        Amplitude (times importance) from which a reading counts linearly; only for the goal "huber".
    mass_per_unbalance
        1/radius per plane [1/m], shape (n_planes,); empty: 1 everywhere (masses are counted as unbalances).

    stock
        How many of each kind of weight there are for all planes together, shape (n_kinds,), inf without end; empty:
        none is counted.  Not with pairs; options of one unbalance may stand more than once, with different uses.

    fans
        Per plane the holes of a weight cut in two, u being what both parts do; None elsewhere, empty: nowhere.
    pairs
        (i, j, ratio): u[j] = ratio * u[i]; ratio 1 is a static pair, -1 a couple (equal radii of action).  Not of
        planes with lists.
    ends
        Per plane the ends (from, to) of a share, a real number of which nothing is weighed; None: a weight; empty: no
        shares.
    sums
        Per reading a number, shape (n_readings,): amplitudes of one number are added up before they are held against
        their limit, and before the worst is taken; limit and importance are the same for all of them.  Empty: each
        stands by itself.
    """

    y0: ComplexArray
    H: ComplexArray
    importance: FloatArray
    limits: FloatArray
    caps: FloatArray
    total_cap: float = float("inf")
    sectors: tuple[Sectors, ...] = ()
    options: tuple[Options | None, ...] = ()
    goal: Goal = "rms"
    huber: float = float("inf")
    mass_per_unbalance: FloatArray = field(default_factory=lambda: np.empty(0))

    pairs: tuple[tuple[int, int, complex], ...] = ()
    fans: tuple[Fan | None, ...] = ()
    stock: FloatArray = field(default_factory=lambda: np.empty(0))
    ends: tuple[tuple[float, float] | None, ...] = ()
    sums: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))

    def __post_init__(self) -> None:
        if len(self.stock) and self.pairs:
            raise InputError("a stock of weights and pairs of planes do not go together. Leave one of them out.")
        if any(self.options[plane] is not None for pair in self.pairs for plane in pair[:2] if self.options):
            raise InputError("a plane of a pair has a list of weights, but a pair needs free weights. Leave one out.")

    @property
    def n_readings(self) -> int:
        return int(self.H.shape[0])

    @property
    def n_planes(self) -> int:
        return int(self.H.shape[1])

    @cached_property
    def is_discrete(self) -> bool:
        """Whether any plane chooses from a list."""
        return any(option is not None for option in self.options)

    @property
    def has_caps_alone(self) -> bool:
        """Whether nothing but caps holds its answer back."""
        more = any(self.sectors) or self.fans or self.ends or np.isfinite(self.limits).any()
        return not more and not np.isfinite(self.total_cap)

    @property
    def is_search(self) -> bool:
        """Whether the answer takes a search, of which nobody knows before how long it is."""
        return self.is_discrete or bool(self.fans)

    @property
    def densities(self) -> FloatArray:
        """Mass per unbalance [1/m], shape (n_planes,)."""
        return self.mass_per_unbalance if len(self.mass_per_unbalance) else np.ones(self.n_planes)

    @property
    def base(self) -> ComplexArray:
        """What is there where least is taken, (n_planes,): the lower ends of shares, no weights."""
        base = np.zeros(self.n_planes, dtype=complex)
        for plane, ends in enumerate(self.ends):
            base[plane] = 0.0 if ends is None else ends[0]
        return base

    @cached_property
    def square(self) -> ComplexArray:
        """(importance H)* importance H, shape (n_planes, n_planes)."""
        rows = self.importance[:, None] * self.H
        return np.asarray(rows.conj().T @ rows)

    @cached_property
    def triangle(self) -> ComplexArray:
        """R of (importance H, importance y0) = Q R: all that least squares and condition numbers see of the rows."""
        rows = np.column_stack([self.importance[:, None] * self.H, self.importance * self.y0])
        return np.asarray(np.linalg.qr(rows, mode="r"))

    def chosen_only(self, chosen: Sequence[int]) -> Question:
        """The same with only the options of an answer in the lists, so that `masses` knows which one was taken."""
        if not self.is_discrete or not chosen:
            return self
        pairs = zip(self.options, chosen, strict=True)
        return replace(
            self, options=tuple(None if options is None else options.take(slice(k, k + 1)) for options, k in pairs)
        )

    def without(self, planes: Sequence[int]) -> Question:
        """The same with planes left untouched."""
        caps = self.caps.copy()
        caps[list(planes)] = 0.0
        return replace(self, caps=caps)

    @cached_property
    def adds_up(self) -> bool:
        """Whether any amplitudes are added up."""
        return len(np.unique(self.sums)) < len(self.sums)

    def with_rows(self, y0: ComplexArray, H: ComplexArray, importance: FloatArray, limits: FloatArray) -> Question:
        """The same with further readings below its own; those that repeat them are added up as they are."""
        sums = self.sums
        if len(sums):
            alike, most = len(y0) % len(sums) == 0, int(sums.max()) + 1
            more = np.tile(sums, len(y0) // len(sums)) if alike else np.arange(len(y0))
            turn = np.arange(len(y0)) // len(sums) * most if alike else np.zeros(len(y0), dtype=np.int64)
            sums = np.concatenate([sums, most + turn + more])
        return replace(
            self,
            sums=sums,
            y0=np.concatenate([self.y0, y0]),
            H=np.concatenate([self.H, H]),
            importance=np.concatenate([self.importance, importance]),
            limits=np.concatenate([self.limits, limits]),
        )

    def residual(self, u: ComplexArray) -> ComplexArray:
        """What is left at the readings (..., n_readings) after the correction u (..., n_planes)."""
        left: ComplexArray = self.y0 + u @ self.H.T
        return left

    def sizes(self, u: ComplexArray) -> FloatArray:
        """Unbalance that is fitted in each plane [kg m], shape (n_planes,): both parts of a weight cut in two."""
        sizes: FloatArray = np.abs(u)
        for plane, fan in enumerate(self.fans):
            if fan is not None and u[plane] != 0.0:
                sizes[plane] = float(fan.gauge(complex(u[plane])))
        return sizes

    def masses(self, u: ComplexArray) -> FloatArray:
        """Correction mass per plane [kg], shape (n_planes,); an option's own mass where u is one of a list."""
        masses = self.sizes(u) * self.densities
        for plane, option in enumerate(self.options):
            if option is not None:
                masses[plane] = option.masses[option.nearest(u[plane])]
        return masses

    def value(self, u: ComplexArray) -> float:
        """The goal at the correction u, in its own unit (amplitude; mass; amplitude² for "huber")."""
        if self.goal == "correction":
            return float(self.masses(u).sum())
        return float(self.measure(np.abs(self.residual(u))))

    def amount(self, value: float) -> float:
        """A value of the goal as an amplitude (or mass): for "huber" the rms of readings that would cost as much."""
        return float(np.sqrt(value / self.n_readings)) if self.goal == "huber" else value

    def measure(self, amplitudes: FloatArray) -> FloatArray:
        """The goal of the amplitudes left (..., n_readings); not for "correction"."""
        sizes = self.importance * amplitudes
        return combined(self.goal, together(sizes, self.sums) if self.goal == "worst" else sizes, self.huber)


def combined(goal: str, t: FloatArray, huber: float = float("inf"), n: float = 0.0) -> FloatArray:
    """Amplitudes t (..., n_rows) taken together as a goal says; `n` rows are meant where t has merged some of them."""
    if goal == "rms":
        return np.asarray(np.sqrt((t * t).sum(axis=-1) / (n or t.shape[-1])))
    if goal == "worst":
        return np.asarray(t.max(axis=-1, initial=0.0))
    if goal == "sum":
        return np.asarray(t.sum(axis=-1))
    inside = np.minimum(t, huber)
    return np.asarray((inside * inside + 2.0 * np.where(t > inside, inside * (t - inside), 0.0)).sum(axis=-1))


def together(t: FloatArray, sums: IntArray) -> FloatArray:
    """Amplitudes t (..., n_rows) as limits count them: the sum of all with the number of a row in `sums`, if any."""
    if not len(sums):
        return t
    if t.ndim == 1:
        return np.asarray(np.bincount(sums, t)[sums])
    _, own = np.unique(sums, return_inverse=True)
    order = np.argsort(own, kind="stable")
    first = np.searchsorted(own[order], np.arange(own.max() + 1))
    return np.asarray(np.add.reduceat(t[..., order], first, axis=-1)[..., own])


def greatest(t: FloatArray, sums: IntArray) -> FloatArray:
    """The greatest of all t (n_rows,) that have the number of a row in `sums`; as they are without numbers."""
    if not len(sums):
        return t
    most = np.zeros(int(sums.max()) + 1)
    np.maximum.at(most, sums, t)
    return most[sums]


def held_by(t: FloatArray, sums: IntArray) -> float:
    """What multipliers of sizes t (n_rows,) take of limits of one: of amplitudes that are added up the greatest."""
    if not len(sums):
        return float(t.sum())
    return float((greatest(t, sums) / together(np.ones(len(t)), sums)).sum())


@dataclass(frozen=True)
class Prices:
    """How fast the goal falls when a limit is widened: -d goal / d limit, zero where it does not bind.

    readings
        Per limit on a reading, shape (n_readings,).
    caps
        Per cap [per kg m], shape (n_planes,).
    total
        Of the cap on the total mass [per kg].
    """

    readings: FloatArray
    caps: FloatArray
    total: float


@dataclass(frozen=True)
class Solved:
    """Answer of an optimiser with its evidence.

    u
        Correction added per plane [kg m], shape (n_planes,); None where there is none.
    status
        "optimal" (proven to `gap`), "feasible" (stopped early, `gap` said), "infeasible" (certified) or "unproven".
    claim
        How that is known, in words.
    value, bound
        The goal at u, and the number no other allowed correction can come below (our own arithmetic).
    gap
        (value - bound) / max(|value|, tiny), zero when both are equal.
    prices
        Dual prices; None for discrete answers.
    chosen
        Per plane the index into its options, -1 for a continuous plane.
    least_factor
        Only when infeasible: with caps and total as they are every limit on a reading would have to be at least this
        many times as wide; nan where unknown.
    details
        Counts of the method.
    work
        What it took [nominal ms].
    """

    u: ComplexArray | None
    status: str
    claim: str
    value: float = float("nan")
    bound: float = float("nan")
    gap: float = float("nan")
    prices: Prices | None = None
    chosen: tuple[int, ...] = ()
    least_factor: float = float("nan")
    details: dict[str, Any] = field(default_factory=dict)
    work: float = 0.0


def wider_words(question: Question, factor: float) -> str:
    """That no correction keeps the limits unless those on readings are this many times as wide, caps held as they are.

    A cap may be a limit of the file, so that not every limit of it is said to need that much.
    """
    held = bool(np.isfinite(question.caps).any()) or np.isfinite(question.total_cap)
    which = "with the weights that are allowed, those on what is left" if held else "all of them"
    return f"no correction keeps the limits: {which} would have to be at least {factor:.4g} times as wide"


def tied(n_planes: int, pairs: Iterable[tuple[int, int, complex]]) -> ComplexArray:
    """One column per set of planes tied by pairs; a set that closes on itself with two ratios can only be zero."""
    spread = np.eye(n_planes, dtype=complex)
    for i, j, ratio in pairs:
        a, b = np.flatnonzero(spread[i]), np.flatnonzero(spread[j])
        if not len(a) or not len(b):
            spread[:, np.concatenate([a, b])] = 0.0
            continue
        factor = ratio * spread[i, a[0]] / spread[j, b[0]]
        if a[0] == b[0]:
            if abs(factor - 1.0) > 1e-9:
                spread[:, a[0]] = 0.0
            continue
        spread[:, a[0]] += factor * spread[:, b[0]]
        spread[:, b[0]] = 0.0
    return spread[:, np.any(spread != 0, axis=0)]


def worst_part(question: Question, limits: FloatArray) -> Question:
    """The same without limits on readings, where the worst of them as a part of its limit is to be least.

    limits
        Per reading, above zero (n_readings,); infinite ones are left out.
    """
    parts = np.where(np.isfinite(limits), 1.0 / limits, 0.0)
    return replace(question, importance=parts, limits=np.full(len(limits), np.inf), goal="worst")


def left_over(y0: ComplexArray, H: ComplexArray, u: ComplexArray) -> ComplexArray:
    """What is left, y0 + H u (..., n_readings), after corrections u (..., n_planes); zero where it is but rounding."""
    left, scale = y0 + u @ H.T, np.abs(y0) + np.abs(u) @ np.abs(H).T
    return np.where(np.abs(left) > _ROUNDING * scale, left, 0.0)


def first_greatest(values: FloatArray) -> int:
    """Place of the greatest value; the first of several that differ by rounding alone."""
    return int(np.flatnonzero(values >= values.max() - 1e-7 * abs(values.max()))[0])


def felt(y0: ComplexArray, H: ComplexArray) -> float:
    """An unbalance that the readings could not miss [kg m]; zero where none is known."""
    most = float(np.abs(H).max(initial=0.0))
    size = float(np.abs(y0).max(initial=0.0)) / most if most else 0.0
    return size if isfinite(size) else 0.0


def relative_gap(value: float, bound: float, size: float) -> float:
    """(value - bound) relative to the value, or to 1e-3 of the goal's natural `size` where the value is about zero."""
    return max(value - bound, 0.0) / max(abs(value), 1e-3 * size, 1e-300)


def breaks(question: Question, u: ComplexArray, slack: float = 1e-8) -> Sequence[str]:
    """The limits, caps, sectors, pairs, lists and ends that the correction u does not keep, by name; empty: none."""
    left = together(np.abs(question.residual(u)), question.sums)
    found = [f"limit {k}" for k in np.flatnonzero(left > question.limits * (1 + slack))]
    masses = question.masses(u)
    found += [f"cap {p}" for p in np.flatnonzero(masses > question.caps * question.densities * (1 + slack))]
    for plane, fan in enumerate(question.fans):
        if fan is not None and u[plane] != 0.0 and not fan.bears(complex(u[plane]), slack):
            found.append(f"holes of {plane}")
    if masses.sum() > question.total_cap * (1 + slack):
        found.append("total")
    for plane, ends in enumerate(question.ends):
        room = slack * max(abs(u[plane]), 1.0)
        if ends is not None and not (ends[0] - room <= u[plane].real <= ends[1] + room and u[plane].imag == 0.0):
            found.append(f"share {plane}")
    size = float(np.abs(u).max(initial=0.0))
    for plane, sectors in enumerate(question.sectors):
        if any(inside_arc(u[plane : plane + 1], *sector, slack * size)[0] for sector in sectors):
            found.append(f"sector of {plane}")
    found += [f"pair {i}, {j}" for i, j, ratio in question.pairs if abs(u[j] - ratio * u[i]) > slack * size]
    for plane, option in enumerate(question.options):
        if option is not None and np.abs(option.u - u[plane]).min() > slack * size:
            found.append(f"list of {plane}")
    return found


def inside_arc(u: ComplexArray, low: float, high: float, slack: float) -> BoolArray:
    """Which of u lie inside the open arc low..high [rad], further than `slack` [kg m] from its edges."""
    turn = 2.0 * np.pi
    width = (high - low) % turn or turn
    angle = (np.angle(u) - low) % turn
    edge = np.minimum(angle, width - angle)
    inside: BoolArray = (angle < width) & (np.abs(u) * np.sin(np.clip(edge, 0.0, 0.5 * np.pi)) > slack)
    return inside
