"""What may be fitted in a plane: fillings of its holes, the two holes around an angle, and its own caps."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import inf, isclose, pi, tau
from typing import Any

import numpy as np

from vibopt.answer.plan import Weight
from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.conventions import Conventions
from vibopt.balancing.fan import Fan
from vibopt.balancing.planes import Plane
from vibopt.balancing.question import Options, Question
from vibopt.records import dataclass, replace
from vibopt.units.showing import show_angle
from vibopt.work import worked

MOST_OPTIONS = 200_000
ALL_FORBIDDEN = (
    "has forbidden sectors all the way round: no weight could sit anywhere. Narrow them, or write keep = true."
)
KEPT_AND_REMOVED = "has keep = true and remove = true. Leave one out: nothing is removed from a plane that is kept."
_HAIR = 1e-9
_WORK = 1.4e-3
"""Of one filling, and of all that is made of it [nominal ms]."""


@dataclass(frozen=True)
class Posed:
    """The question and what its answer is read with; rows of the nominal rotor come first, (speed, sensor) each."""

    question: Question
    n_rows: int

    def chosen_only(self, chosen: Sequence[int]) -> Posed:
        """The same with only what an answer takes in the lists: options of one unbalance are then told apart."""
        question = self.question.chosen_only(chosen)
        return self if question is self.question else replace(self, question=question)


def posed(planes: Sequence[Plane], conventions: Conventions, **asked: Any) -> Posed:
    """The question with what may be fitted in each plane; `asked` are the other fields of it."""
    stock = counted([plane for plane in planes if plane.is_discrete])
    options = tuple(options_of(plane, conventions, tuple(stock)) if plane.is_discrete else None for plane in planes)
    fans = tuple(_fan(plane, conventions) for plane in planes)

    question = Question(
        sectors=tuple(
            () if plane.is_discrete or plane.split else plane.internal_sectors(conventions) for plane in planes
        ),
        options=options,
        mass_per_unbalance=np.array([1.0 / plane.radius for plane in planes]),
        stock=np.array(list(stock.values())),
        fans=fans if any(fan is not None for fan in fans) else (),
        **asked,
    )
    return Posed(question, question.n_readings)


def _fan(plane: Plane, conventions: Conventions) -> Fan | None:
    """The holes of a plane whose weight is cut in two, and the most that each of them takes."""
    if not plane.split or plane.keep or plane.is_discrete:
        return None
    turn = pi if plane.remove else 0.0
    used = [hole for hole in plane.holes if plane.may_sit_at(hole)]
    each = plane.drill.most * plane.radius if plane.drill is not None else inf
    return Fan.of([float(np.angle(conventions.weight(1.0, hole))) + turn for hole in used], each)


def caps_of(planes: Sequence[Plane], bounds: Iterable[tuple[int, float]]) -> FloatArray:
    """Greatest unbalance of each plane [kg m], under `bounds` [kg; kg m] on planes by index, too."""
    most = [0.0 if plane.keep else plane.most for plane in planes]
    for plane, bound in bounds:
        most[plane] = min(most[plane], bound)
    return np.array([value * plane.radius for value, plane in zip(most, planes, strict=True)])


def decided_of(options: Sequence[Options | None]) -> ComplexArray:
    """Unbalances of planes of which nothing is chosen (n_planes,) [kg m]."""
    return np.array([0.0 if option is None else option.u[0] for option in options], dtype=complex)


def counted(planes: Sequence[Plane]) -> dict[float, float]:
    """Masses of which there are only so many, for all planes together [kg], with their number."""
    return {mass: many for plane in planes for mass, many in zip(plane.shelf, plane.stock, strict=False) if many < inf}


def options_of(plane: Plane, conventions: Conventions, kinds: Sequence[float] = ()) -> Options:
    """Every allowed filling of the holes of a plane with weights of the shelf, lightest first among equals.

    `kinds` are the masses [kg] that are counted; fillings that take different numbers of them are all kept.
    """
    if plane.fitted is not None:
        return _decided(plane.fitted, plane, conventions, kinds)
    offers = tuple(
        (hole, mass, radius)
        for hole, angle in enumerate(plane.holes)
        if plane.may_sit_at(angle)
        for mass in plane.shelf
        if plane.drill is None or mass <= plane.drill.most * (1.0 + _HAIR)
        for radius in (plane.radii or (1.0,))
    )
    sign = -1.0 if plane.remove else 1.0
    single = np.array([sign * conventions.weight(m * r, plane.holes[h]) for h, m, r in offers], dtype=complex)
    mass = np.array([m for _, m, _ in offers])
    items = _fillings(np.array([h for h, _, _ in offers], dtype=np.int64), plane.most_weights)
    worked(_WORK * len(items))
    padded_u, padded_mass = np.append(single, 0.0), np.append(mass, 0.0)
    u, masses = padded_u[items].sum(axis=1), padded_mass[items].sum(axis=1)
    same = np.isclose(mass[:, None], np.array(kinds, dtype=float)[None, :], rtol=1e-9, atol=0.0)
    takes = np.append(same.astype(float), np.zeros((1, len(kinds))), axis=0)
    filled = np.append([m * r / plane.radius for _, m, r in offers], 0.0)[items].sum(axis=1) if plane.moment else masses
    kept = filled <= plane.cap * (1.0 + 1e-12)
    return _without_doubles(Options(u, masses, takes[items].sum(axis=1), items, offers).take(kept))


def missing(planes: Sequence[Plane], fitted: Sequence[Sequence[Weight]]) -> list[str]:
    """Counted weights of which more are taken, by all planes with a list together, than there are."""
    shown = next((plane for plane in planes if plane.stock), None)
    masses = [weight.mass for plane, own in zip(planes, fitted, strict=True) if plane.is_discrete for weight in own]
    taken = {kind: sum(isclose(mass, kind) for mass in masses) for kind in counted(planes)}
    return [] if shown is None else [shown.show(kind) for kind, many in counted(planes).items() if taken[kind] > many]


def _decided(fitted: Sequence[Weight], plane: Plane, conventions: Conventions, kinds: Sequence[float]) -> Options:
    """The one option of a plane whose weights are decided; a weight away from holes has hole -1."""
    u = plane.made(fitted, conventions)
    uses = [[sum(isclose(weight.mass, kind) for weight in fitted) for kind in kinds]]
    return Options(
        np.array([u]), np.array([sum(weight.mass for weight in fitted)]),
        np.array(uses, dtype=float).reshape(1, len(kinds)),
        np.arange(len(fitted), dtype=np.int64)[None, :],
        tuple((-1 if weight.hole is None else weight.hole, weight.mass, weight.radius or 1.0) for weight in fitted),
    )  # fmt: skip


def count_options(plane: Plane) -> int:
    """How many fillings there are before caps, at most MOST_OPTIONS + 1."""
    per_hole = len(plane.shelf) * max(len(plane.radii), 1)
    total, ways = 1, 1
    for k in range(1, plane.most_weights + 1):
        ways = ways * (len(plane.holes) - k + 1) // k
        total += ways * per_hole**k
    return min(total, MOST_OPTIONS + 1)


def _fillings(
    holes: np.ndarray[tuple[int], np.dtype[np.int64]], most: int
) -> np.ndarray[tuple[int, int], np.dtype[np.int64]]:
    """Indices of offers that may sit together, (n, most), -1 where fewer; one weight a hole."""
    rows = [np.full((1, most), -1, dtype=np.int64)]
    last = np.full((1, most), -1, dtype=np.int64)
    for k in range(most):
        ahead = np.where(last[:, k - 1] >= 0, holes[last[:, k - 1]], -1) if k else np.array([-1])
        pairs = np.argwhere(holes[None, :] > ahead[:, None])
        if not len(pairs):
            break
        grown = last[pairs[:, 0]].copy()
        grown[:, k] = pairs[:, 1]
        rows.append(grown)
        last = grown
    return np.concatenate(rows)


def _without_doubles(options: Options) -> Options:
    """Only those with different unbalances or counted weights, the lightest of each."""
    size = max(float(np.abs(options.u).max(initial=0.0)), 1e-300)
    key = np.round(options.u / size, 12) + 0.0
    keys = np.column_stack([options.uses, key.imag, key.real])
    order = np.lexsort((options.masses, *keys.T))
    first = np.ones(len(order), dtype=bool)
    first[1:] = np.any(keys[order][1:] != keys[order][:-1], axis=1)
    return options.take(np.sort(order[first]))


def listed_twice(holes: Sequence[float]) -> str:
    """What is wrong with angles of holes [rad] of which two are the same; "" where none are."""
    for k, hole in enumerate(holes):
        for other in holes[:k]:
            if abs((hole - other + pi) % tau - pi) < _HAIR:
                same = f"{show_angle(hole)} twice" if hole == other else f"{show_angle(other)} again, a full turn on"
                return f"lists {same}. List each hole once."
    return ""
