"""What a wider limit is worth, by solving again with it moved: one service for rotors, known masses and engines."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import field, replace
from functools import partial
from math import ceil, inf
from typing import Any

from vibopt.answer.entry import Checked, Price
from vibopt.answer.plan import DeferredMapping
from vibopt.balancing.question import Question, Solved
from vibopt.records import dataclass
from vibopt.units import show
from vibopt.work import Budget, is_limited, late, metered

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
        return {name: replace(limit, price=said.get(name)) for name, limit in self.limits.items()}

    def caps(self) -> dict[str, Price]:
        """Prices of the planes' own caps, by their path."""
        return {name: Price(said) for name, said in self.words.items() if name not in self.limits and said}
