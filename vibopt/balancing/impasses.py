"""Limits that cannot hold together, what loosening one of them takes, and what comes nearest to all of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Generic, TypeVar

import numpy as np

from vibopt.answer.answer import Conflict, Least, Nearest
from vibopt.answer.clashes import every_clash
from vibopt.answer.entry import Checked, Entry, Value
from vibopt.balancing.optimisers import THOROUGH, allowance
from vibopt.balancing.rotor_tables import Bounded
from vibopt.records import dataclass
from vibopt.values.soft import softness, widened
from vibopt.work import Budget, late, metered

T = TypeVar("T")
B = TypeVar("B", bound=Bounded)
Step = tuple[str, Entry, Entry]
"""A limit, its bound now, and the bound that alone makes the job possible."""


def clash(
    names: Sequence[str], possible: Callable[[tuple[str, ...]], bool],
    loosened: Callable[[tuple[str, ...]], list[Step]], proof: str, solves: int, work: float, budget: Budget,
    soft: Mapping[str, float],
) -> tuple[Conflict | None, str]:  # fmt: skip
    """The limits that cannot hold together with the smallest loosening of one, and all this in words.

    Parameters
    ----------
    names, possible
        All limits, which together are impossible, and whether an answer keeps those named.
    loosened
        What helps alone, of some limits.
    proof
        How it is known that there is no answer.
    solves, work, budget
        How many solutions that takes at most, what each takes, and what all may take [nominal ms].
    soft
        How easily limits may be loosened.
    """
    if solves * work > budget.most:
        many = f"{solves} more solutions would exceed the budget"
        return None, f"Which limits stand in the way was not computed: {many}. {THOROUGH} computes it."
    with metered() as meter:
        found = every_clash(names, lambda some: not possible(some), lambda: meter.done <= _OF_SETS * budget.most)
    if not found.sets:
        return None, ""
    kept, *others = found.sets
    shared = tuple(one for one in kept if all(one in other for other in others))
    conflict = Conflict(kept, tuple(loosened(shared)), proof, (), tuple(others), found.complete, soft)
    told = conflict.steps
    smallest = [f"Smallest loosening of one: {', or '.join(told)}."] if told else []
    return conflict, " ".join([conflict.said(), *conflict.others_said(), *smallest])


_OF_SETS = 0.2
"""Part of the work for a conflict that the sets behind the first may take."""
_CLOSE = 1e-6
"""Part by which a common factor of all bounds is known."""
_WIDEST, _NARROWEST, _FURTHER = 1e12, 1e-9, 4.0


def nearest_by_factor(
    names: Sequence[str],
    answered: Callable[[Mapping[str, float]], T | None],
    rows_at: Callable[[T], Mapping[str, Checked]],
    budget: Budget,
    soft: Mapping[str, float],
) -> tuple[T, dict[str, Checked], dict[str, Least], tuple[str, ...]] | None:
    """The answer with which the worst limit is missed by the least factor, its rows, the least of each limit, the rest.

    Parameters
    ----------
    names
        Of all limits.
    answered
        The answer with bounds so many times as wide, and without those that are not named; None where there is none.
    rows_at
        Every limit of the job at an answer.
    budget
        Of answers.
    soft
        How easily limits may be loosened.
    """

    def common(some: Sequence[str]) -> Narrowest[T] | None:
        weights = {name: soft.get(name, 1.0) if len(some) > 1 else 1.0 for name in some}
        return narrowest(lambda factor: answered({name: widened(factor, one) for name, one in weights.items()}), budget)

    best = common(names)
    if best is None:
        return None
    least = {}
    for name in names:
        alone = common((name,))
        if alone is not None:
            row = rows_at(alone.found)[name]
            nothing = row.limit is not None and row.value.value <= _NARROWEST * row.limit.value
            least[name] = Least(replace(row.value, value=0.0) if nothing else row.value, alone.proven, row.met)
    return best.found, dict(rows_at(best.found)), least, tuple(name for name in names if name not in least)


@dataclass(frozen=True, slots=True)
class Narrowest(Generic[T]):
    """An answer, the factor of the bounds that it needs, and whether there is none with a lesser one."""

    found: T
    factor: float
    proven: bool


def narrowest(at: Callable[[float], T | None], budget: Budget) -> Narrowest[T] | None:
    """The answer with the least factor of the bounds, by halving; None where there is none, or the work is done."""

    def over() -> bool:
        return budget.over or late("the search for the nearest answer")

    def tried(factor: float) -> T | None:
        budget.spend()
        return at(factor)

    high = 1.0
    found = None if over() else tried(high)
    low = high if found is None else 0.0
    while found is None and high < _WIDEST and not over():
        low, high = high, _FURTHER * high
        found = tried(high)
    if found is None:
        return None
    while low == 0.0 and high > _NARROWEST and not over():
        lower = tried(high / _FURTHER)
        if lower is None:
            low = high / _FURTHER
        else:
            found, high = lower, high / _FURTHER
    while low > 0.0 and high > low * (1.0 + _CLOSE) and not over():
        middle = float(np.sqrt(low * high))
        there = tried(middle)
        if there is None:
            low = middle
        else:
            found, high = there, middle
    return Narrowest(found, high, high <= max(low * (1.0 + _CLOSE), _NARROWEST))


def nearest_of(
    limits: Mapping[str, B], answered: Callable[[Mapping[str, B]], T | None],
    rows_at: Callable[[T], Mapping[str, Checked]], values: Callable[[T], Mapping[str, Value]], work: float,
    *, thorough: bool,
) -> Nearest | None:  # fmt: skip
    """What misses the worst limit by the least factor, measured like every other answer; None where none was found.

    `answered` takes other limits; each answer takes `work` [nominal ms].
    """

    def at(factors: Mapping[str, float]) -> T | None:
        return answered({name: limits[name].at(limits[name].bound * factor) for name, factor in factors.items()})

    soft = softness(limits)
    best = nearest_by_factor(tuple(limits), at, rows_at, costing(work, thorough=thorough), soft)
    if best is None:
        return None
    found, rows, least, left = best
    return Nearest(values=values(found), limits=rows, least=least, left=left, soft=soft)


def costing(work: float, *, thorough: bool) -> Budget:
    """How many answers the nearest one and the least of each limit may take, where each takes `work` [nominal ms]."""
    return Budget(int(allowance(thorough).most / max(work, 1.0)), "answers")


def with_together(reason: str, near: Nearest | None) -> str:
    """Why there is no answer, and by how much all limits at once have to give way."""
    return " ".join(filter(None, (reason, *(near.together if near is not None else ()))))


def left_words(near: Nearest | None) -> tuple[str, ...]:
    """What was left out because of the work, and what computes it."""
    if near is None:
        return (f"The nearest weights were not looked for, which would exceed the budget. {THOROUGH} looks for them.",)
    return (f"What {', '.join(near.left)} could be alone was not looked for. {THOROUGH} does.",) if near.left else ()
