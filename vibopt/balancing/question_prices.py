"""What a wider limit is worth, by solving again with it moved; limits that clash, and what comes nearest to them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import field, replace
from functools import partial
from math import ceil, inf
from typing import Any, Generic, TypeVar

import numpy as np

from vibopt.answer.answer import Conflict, Least, Nearest
from vibopt.answer.clashes import every_clash
from vibopt.answer.entry import Checked, Entry, Price, Value
from vibopt.answer.plan import DeferredMapping
from vibopt.balancing.question import Question, Solved
from vibopt.balancing.rotor_tables import Bounded
from vibopt.records import dataclass
from vibopt.units import show
from vibopt.work import Budget, is_limited, late, metered

T = TypeVar("T")
B = TypeVar("B", bound=Bounded)
Solver = Callable[[Question], Solved]
THOROUGH = "`vibopt explain FILE --thorough`"
ALLOWANCE = 2_000
"""Work for all prices of an answer [nominal ms]; what takes more is said to have none."""
WHATEVER = 10**12
STEP = 1.1
"""How much wider a bound is tried."""
BETTER = 1e-7
"""Part by which a goal has to be better to be said so."""
ACTIVE = 1e-4
"""A limit is touched within this part of itself."""


_UNPRICED: ContextVar[bool] = ContextVar("no prices", default=False)


@contextmanager
def without_prices() -> Iterator[None]:
    """Answers inside have no prices: one point of a sweep shows none."""
    token = _UNPRICED.set(True)
    try:
        yield
    finally:
        _UNPRICED.reset(token)


def allowance(thorough: bool = False) -> Budget:
    """The work that the prices of one answer may take."""
    most = 0 if _UNPRICED.get() else WHATEVER if thorough else ALLOWANCE
    return Budget(most, "ms of nominal work")


def left_out(names: Sequence[str], solves: int) -> tuple[str, ...]:
    """That limits have no price, and what computes it."""
    if not names:
        return ()
    many = f"{solves} more solution{'s' * (solves > 1)} would exceed the budget"
    them = "them" if len(names) > 1 else "it"
    return (f"No price was computed for {', '.join(names)}: {many}. {THOROUGH} computes {them}.",)


def solve_question(question: Question, most: float | None = None) -> Solved:
    """The answer by the optimiser that the question asks for; a search takes no more than `most` [nominal ms]."""
    with metered() as meter:
        solved = _solved(question, most)
    return replace(solved, work=meter.done)


def _solved(question: Question, most: float | None) -> Solved:
    if question.is_discrete:
        from vibopt.balancing.discrete import solve_discrete
        from vibopt.balancing.option_tree import BOX

        return solve_discrete(question, None if most is None else Budget(int(most / BOX), "boxes", BOX))
    if question.fans:
        from vibopt.balancing.split_weights import PROGRAM, solve_split, takes

        if takes(question):
            return solve_split(question, None if most is None else Budget(int(most / PROGRAM) + 1, "programs"))
    from vibopt.balancing.continuous import solve_continuous

    return solve_continuous(question)


class OpenError(Exception):
    """Whether another bound buys anything was not found out."""


Best = Callable[[float], tuple[float, Any] | None]


@dataclass(frozen=True, slots=True)
class Bound:
    """A limit or a cap, and what another bound would do.

    path, now, unit, dimension
        In the file, its value [SI], and how it is shown.
    best
        Goal and answer with another bound (inf: without it); None where there is none.
    until
        The bound from which on the goal is as good as without it, from what `best(inf)` gave and `best` itself as far
        as there is room for it; None where that is not known.  None: it is not looked for.
    solves
        Solutions that this takes.
    stepped
        Whether more may buy something where a tenth more buys nothing.
    """

    path: str
    now: float
    unit: str
    dimension: str
    best: Best
    until: Callable[[tuple[float, Any], Best], float | None] | None
    solves: int = 3
    stepped: bool = False


class Prices:
    """What wider bounds buy, one after the other from one allowance of work.

    Parameters
    ----------
    bounds
        Those that may hold the answer back.
    now, goal, grain
        Goal of the answer, how it is shown, and what counts as nothing.
    work, budget
        What the answer took, which is expected of each further solution, and what all may take [nominal ms].
    searched
        Whether nobody knows before what a solution takes: prices are then worked out at once and their work is counted.
        Others are planned, and worked out where they are looked at.
    behind
        What is said behind what a bound buys.

    Attributes
    ----------
    words
        By path; "" of those that buy nothing.
    notes
        What was left out.
    """

    def __init__(
        self, bounds: Iterable[Bound], now: float, goal: Callable[[float], str], work: float, budget: Budget,
        *, searched: bool, grain: float = 0.0, behind: str = "",
    ) -> None:  # fmt: skip
        every = tuple(bounds)
        self.now, self.goal, self.target = now, goal, now * (1.0 - BETTER) - grain
        self.work, self.budget, self.searched, self.behind = max(work, 1.0), budget, searched, behind
        self.left: list[str] = []
        self.endless: list[Bound] = []
        for one in () if searched else every:  # what will be left out
            if not self._spent(1):
                self.left.append(one.path)
            elif one.until is not None and not self._spent(one.solves):
                self.endless.append(one)
        later: Mapping[str, str] = DeferredMapping(lambda: {one.path: self._priced(one) for one in every})
        self.words = dict(later) if searched or is_limited() else later
        self.notes = (*left_out(self.left, len(self.left)), *self._endless())

    def _spent(self, solves: int) -> bool:
        """Whether so many more solutions fit into what is left, which they are taken from."""
        room = self._room(solves)
        self.budget.spend(ceil(solves * self.work) if room else 0)
        return room

    def _room(self, solves: int) -> bool:
        """Whether so many more solutions fit into what is left."""
        return not self.budget.over and self.budget.spent + solves * self.work <= self.budget.most

    def _may(self, solves: int) -> bool:
        """Whether there is room and time; of what was planned before there is room."""
        return self._room(solves) if self.searched else not late("prices")

    def _priced(self, one: Bound) -> str:
        """ "20 g -> 22 g buys 812 N -> 640 N; nothing more to gain beyond 41 g"; "" where it buys nothing."""
        if one.path in self.left:
            return ""
        try:
            return self._said(one, self._asked(one, one.now * STEP))
        except OpenError:
            self.left.append(one.path)
            return ""

    def _asked(self, one: Bound, bound: float) -> tuple[float, Any] | None:
        """One more solution; OpenError where there is no room for it."""
        if not self._may(1):
            raise OpenError
        with metered() as meter:
            found = one.best(bound)
        self.budget.spend(ceil(meter.done) if self.searched else 0)
        return found

    def _said(self, one: Bound, then: tuple[float, Any] | None) -> str:
        better = then is not None and then[0] < self.target
        free, until = self._range(one) if better or one.stepped else (None, "")
        bound, further = (show(value, one.unit, one.dimension) for value in (one.now, one.now * STEP))
        if then is not None and better:
            more = f"; nothing more to gain beyond {until}" if until else ""
            return f"{bound} -> {further} buys {self.goal(self.now)} -> {self.goal(then[0])}{self.behind}{more}"
        more = f", {until} buys {self.goal(self.now)} -> {self.goal(free[0])}" if free is not None and until else ""
        return f"{bound} -> {further} buys nothing{more}" if free is not None else ""

    def _range(self, one: Bound) -> tuple[tuple[float, Any] | None, str]:
        """The answer without the bound, where it is better, and the bound from which on it is as good."""
        if one.until is None or one in self.endless:
            return None, ""
        free = reached = None
        try:
            if not self._may(one.solves):
                raise OpenError
            free = self._asked(one, inf)
            free = free if free is not None and free[0] < self.target else None
            reached = None if free is None else one.until(free, partial(self._asked, one))
        except OpenError:
            self.endless.append(one)
        return free, "" if reached is None else show(reached, one.unit, one.dimension)

    def _endless(self) -> tuple[str, ...]:
        """That it was not looked for where bounds stop to matter."""
        names, solves = ", ".join(one.path for one in self.endless), sum(one.solves for one in self.endless)
        ends = f"{solves} more solutions would exceed the budget. {THOROUGH} looks for it"
        return (f"Where {names} stops to matter was not looked for: {ends}.",) if names else ()


@dataclass(frozen=True)
class Priced:
    """The limits of the file at an answer, what wider ones and caps buy by name, and what is left out in words.

    rates
        Dual prices of limits, where they are known.
    """

    limits: Mapping[str, Checked]
    words: Mapping[str, str]
    notes: tuple[str, ...] = ()
    rates: Mapping[str, float] = field(default_factory=dict)

    def with_words(self) -> dict[str, Checked]:
        """The limits with their prices."""
        said = {name: Price(words) for name, words in self.words.items() if words}
        said |= {name: Price(self.words.get(name, ""), rate=rate) for name, rate in self.rates.items()}
        return {name: replace(one, price=said.get(name)) for name, one in self.limits.items()}

    def caps(self) -> dict[str, Price]:
        """Prices of the planes' own caps, by their path."""
        return {name: Price(said) for name, said in self.words.items() if name not in self.limits and said}


Step = tuple[str, Entry, Entry]
"""A limit, its bound now, and the bound that alone makes the job possible."""


def clash(
    names: Sequence[str], possible: Callable[[tuple[str, ...]], bool],
    loosened: Callable[[tuple[str, ...]], list[Step]], proof: str, solves: int, work: float, budget: Budget,
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
    conflict = Conflict(kept, tuple(loosened(shared)), proof, (), tuple(others), found.complete)
    told = ", or ".join(f"{name} {now.shown} -> {then.shown}" for name, now, then in conflict.loosenings)
    smallest = [f"Smallest loosening of one: {told}."] if told else []
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
    """

    def common(some: Sequence[str]) -> Narrowest[T] | None:
        return narrowest(lambda factor: answered(dict.fromkeys(some, factor)), budget)

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

    best = nearest_by_factor(tuple(limits), at, rows_at, costing(work, thorough=thorough))
    if best is None:
        return None
    found, rows, least, left = best
    return Nearest(values=values(found), limits=rows, least=least, left=left)


def costing(work: float, *, thorough: bool) -> Budget:
    """How many answers the nearest one and the least of each limit may take, where each takes `work` [nominal ms]."""
    return Budget(int(allowance(thorough).most / max(work, 1.0)), "answers")


def left_words(near: Nearest | None) -> tuple[str, ...]:
    """What was left out because of the work, and what computes it."""
    if near is None:
        return (f"The nearest weights were not looked for, which would exceed the budget. {THOROUGH} looks for them.",)
    return (f"What {', '.join(near.left)} could be alone was not looked for. {THOROUGH} does.",) if near.left else ()
