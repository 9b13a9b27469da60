"""Limits that cannot hold together, what loosening one of them takes, and what comes nearest to all of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from math import inf, sqrt
from typing import Any, Generic, Protocol, TypeVar

from vibopt.answer.answer import Answer, Least, Nearest
from vibopt.answer.clashes import Conflict, every_clash
from vibopt.answer.entry import Checked, Entry, Value
from vibopt.balancing.optimisers import THOROUGH, allowance
from vibopt.balancing.rotor_tables import Bounded
from vibopt.records import dataclass
from vibopt.values.soft import softness, widened
from vibopt.work import Budget, late, metered

A = TypeVar("A", bound=Answer[Any])
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
        clashes = every_clash(names, lambda some: not possible(some), lambda: meter.done <= _OF_SETS * budget.most)
    if not clashes.sets:
        return None, ""
    kept, *others = clashes.sets
    shared = tuple(one for one in kept if all(one in other for other in others))
    conflict = Conflict(
        kept, tuple(loosened(shared)), proof, (), tuple(others), clashes.complete, soft, clashes.doubtful
    )
    told = conflict.steps
    smallest = [f"Smallest loosening of one: {', or '.join(told)}."] if told else []
    return conflict, " ".join([conflict.said(), *conflict.others_said(), *smallest])


_OF_SETS = 0.2
"""Part of the work for a conflict that the sets behind the first may take."""
_CLOSE = 1e-6
"""Part by which a common factor of all bounds is known."""
_WIDEST, _NARROWEST, _FURTHER = 1e12, 1e-9, 4.0
LOOSER = 1.0005
"""So much wider a loosening is said than is needed at least: shown digits are fewer."""


@dataclass(frozen=True, slots=True)
class Narrowest(Generic[T]):
    """An answer, the factor of the bounds that it needs, and whether there is none with a lesser one."""

    found: T
    factor: float
    proven: bool


def narrowest(
    at: Callable[[float], T | None], budget: Budget, needs: Callable[[T], float] | None = None
) -> Narrowest[T] | None:
    """The answer with the least factor of the bounds, by halving; None where there is none, or the work is done.

    needs
        The factor that an answer takes by itself, which may be less than the one at which it was found.
    """

    def over() -> bool:
        return budget.over or late("the search for the nearest answer")

    best: T | None = None
    low, high, place = 0.0, inf, 1.0
    while place < _FURTHER * _WIDEST and high > max(low * (1.0 + _CLOSE), _NARROWEST) and not over():
        budget.spend()
        found = at(place)
        if found is None:
            low = place
        else:
            best, high = found, place if needs is None else min(place, max(needs(found), low))
        place = _FURTHER * low if best is None else sqrt(low * high) if low else high / _FURTHER
    return None if best is None else Narrowest(best, high, high <= max(low * (1.0 + _CLOSE), _NARROWEST))


class Solved(Protocol):
    """An answer of an optimiser."""

    @property
    def status(self) -> str: ...


S = TypeVar("S", bound=Solved)


NOTHING_FOUND = ("infeasible", "unproven")
"""Statuses of answers for known masses and engines in which nothing is chosen."""


@dataclass(frozen=True)
class Asking(Generic[S, B]):
    """How a job that has no answer is asked again with other limits.

    limits
        Of the job, by name.
    solved
        The answer with other limits.
    rows_at, values, words
        Every limit of the job, every number, and what is to be done, at an answer.
    least
        The least bound of one limit with which the others hold; None: it is looked for by halving.
    work, thorough
        What an answer takes [nominal ms], and whether all is found out whatever the work.
    """

    limits: Mapping[str, B]
    solved: Callable[[Mapping[str, B]], S]
    rows_at: Callable[[S], Mapping[str, Checked]]
    values: Callable[[S], Mapping[str, Value]]
    work: float
    thorough: bool
    least: Callable[[str], float | None] | None = None
    words: Callable[[S], tuple[str, ...]] = lambda _: ()

    def told(self, none: A) -> A:
        """The answer that there is none with what stands in the way, and what comes nearest."""
        near, budget, limits = self._nearest(), allowance(self.thorough), self.limits
        if none.status != "infeasible":
            return with_nearest(none, near)

        def possible(kept: tuple[str, ...]) -> bool:
            return self.solved({name: limits[name] for name in kept}).status != "infeasible"

        def loosened(names: tuple[str, ...]) -> list[Step]:
            return [step for name in names if (step := self._loosening(name))]

        solves = (1 if self.least is None else 3) * len(limits) + 1
        conflict, reason = clash(
            tuple(limits), possible, loosened, none.claim, solves, self.work, budget, softness(limits)
        )
        return with_nearest(replace(none, conflict=conflict, reason=reason), near)

    def _kept(self, bounds: Mapping[str, float], others: Iterable[str] = ()) -> S | None:
        """The answer with these bounds, and others as they are; None where there is none."""
        limits = {name: self.limits[name] for name in others}
        found = self.solved({**limits, **{name: self.limits[name].at(bound) for name, bound in bounds.items()}})
        return found if found.status in ("optimal", "feasible") else None

    @property
    def _answers(self) -> Budget:
        return Budget(int(allowance(self.thorough).most / max(self.work, 1.0)), "answers")

    def _loosening(self, name: str) -> Step | None:
        """The least bound of one limit that lets the others hold."""
        table, every = self.limits[name], tuple(self.limits)
        if self.least is not None:
            bound = self.least(name)
            if bound is None or self._kept({name: bound * LOOSER}, every) is None:
                return None
        else:
            best = narrowest(lambda factor: self._kept({name: table.bound * factor}, every), self._answers)
            if best is None or not best.proven:
                return None
            bound = table.bound * best.factor
        now, then = (Entry(value, table.dimension, table.unit) for value in (table.bound, bound * LOOSER))
        return name, now, then

    def _nearest(self) -> Nearest | None:
        """What misses the worst limit by the least factor, with the least of each limit; None where none was found."""
        soft, budget, least = softness(self.limits), self._answers, {}

        def common(some: Sequence[str]) -> Narrowest[S] | None:
            weights = {name: soft.get(name, 1.0) if len(some) > 1 else 1.0 for name in some}

            def at(factor: float) -> S | None:
                return self._kept({name: self.limits[name].bound * widened(factor, weights[name]) for name in some})

            return narrowest(at, budget)

        best = common(tuple(self.limits))
        if best is None:
            return None
        for name in self.limits:
            alone = common((name,))
            if alone is not None:
                row = self.rows_at(alone.found)[name]
                nothing = row.limit is not None and row.value.value <= _NARROWEST * row.limit.value
                least[name] = Least(replace(row.value, value=0.0) if nothing else row.value, alone.proven, row.met)
        left = tuple(name for name in self.limits if name not in least)
        return Nearest(
            values=self.values(best.found), words=self.words(best.found), limits=dict(self.rows_at(best.found)),
            least=least, left=left, soft=soft,
        )  # fmt: skip


def with_nearest(none: A, near: Nearest | None) -> A:
    """The answer with what comes nearest, by how much all limits at once have to give way, and what was left out."""
    if near is None:
        left = [f"The nearest weights were not looked for, which would exceed the budget. {THOROUGH} looks for them."]
    else:
        left = [f"What {', '.join(near.left)} could be alone was not looked for. {THOROUGH} does."] if near.left else []
    reason = " ".join(filter(None, (none.reason, *(near.together if near is not None else ()))))
    return replace(none, nearest=near, reason=reason, notes=(*none.notes, *left))
