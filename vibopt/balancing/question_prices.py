"""What a wider limit is worth, found by solving again with the limit moved; and limits that cannot hold together."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import replace
from math import ceil, inf
from typing import Any

from vibopt.answer.answer import Conflict
from vibopt.answer.entry import Entry
from vibopt.balancing.question import Question, Solved
from vibopt.records import dataclass
from vibopt.units import show
from vibopt.work import Budget, metered

Solver = Callable[[Question], Solved]
THOROUGH = "`vibopt explain FILE --thorough`"
ALLOWANCE = 2_000
"""Work for all prices of an answer [nominal ms]; what takes more is said to have none."""
WHATEVER = 10**12
STEP = 1.1
"""How much wider a bound is tried."""
SOLVES = 4
"""Solutions that one price takes: wider, without the limit, the bound where it stops to matter, and with that."""
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


@dataclass(frozen=True, slots=True)
class Bound:
    """A limit or a cap of known masses or of an engine, and what another bound would do.

    path, now, unit, dimension
        In the file, its value [SI], and how it is shown.
    best
        Goal and answer with another bound (inf: without it); None where there is none.
    until
        The bound from which on the goal is as good as `free`, what `best(inf)` gave; None where that is not known.
    """

    path: str
    now: float
    unit: str
    dimension: str
    best: Callable[[float], tuple[float, Any] | None]
    until: Callable[[tuple[float, Any]], float | None]

    def words(self, now: float, goal: Callable[[float], str], grain: float) -> str:
        """ "20 g -> 22 g buys 812 N -> 640 N; nothing more to gain beyond 41 g"; "" where it buys nothing.

        `now` is the goal of the answer, which `goal` shows; `grain` is what counts as nothing.
        """
        bound, further = (show(one, self.unit, self.dimension) for one in (self.now, self.now * STEP))
        free, then = self.best(inf), self.best(self.now * STEP)
        target = now * (1.0 - 1e-6) - grain
        if free is None or then is None or not min(free[0], then[0]) < target:
            return ""
        reached = self.until(free)
        until = "" if reached is None else show(reached, self.unit, self.dimension)
        if not then[0] < target:
            more = f", {until} buys {goal(now)} -> {goal(free[0])}" if until else ""
            return f"{bound} -> {further} buys nothing{more}"
        more = f"; nothing more to gain beyond {until}" if until else ""
        return f"{bound} -> {further} buys {goal(now)} -> {goal(then[0])}{more}"


def prices_of(
    bounds: Iterable[Bound], now: float, goal: Callable[[float], str], grain: float, work: float, budget: Budget
) -> tuple[dict[str, str], tuple[str, ...]]:
    """What wider bounds buy, in words by path, and a sentence where a price was not found out.

    `work` is what the answer took, which is expected of each further solution, and `budget` what all may take.
    """
    words, left = {}, []
    for one in bounds:
        if budget.over or budget.spent + SOLVES * work > budget.most:
            left.append(one.path)
            continue
        with metered() as meter:
            said = one.words(now, goal, grain)
        budget.spend(ceil(meter.done))
        if said:
            words[one.path] = said
    return words, left_out(left, SOLVES * len(left))


Step = tuple[str, Entry, Entry]
"""A limit, its bound now, and the bound that alone makes the job possible."""


def smallest_set(names: Sequence[str], possible: Callable[[tuple[str, ...]], bool]) -> tuple[str, ...]:
    """Limits that cannot hold together, none of which can be left out; empty where it is not the limits.

    Parameters
    ----------
    names
        All limits; together they are impossible.
    possible
        Whether an answer keeps the limits named.
    """
    if not possible(()):
        return ()
    kept = tuple(names)
    for name in names:
        fewer = tuple(one for one in kept if one != name)
        if not possible(fewer):
            kept = fewer
    return kept


def clash(
    names: Sequence[str], possible: Callable[[tuple[str, ...]], bool],
    loosened: Callable[[tuple[str, ...]], list[Step]], proof: str, solves: int, work: float, budget: Budget,
) -> tuple[Conflict | None, str]:  # fmt: skip
    """The limits that cannot hold together with the smallest loosening of one, and all this in words.

    Parameters
    ----------
    names, possible
        As for `smallest_set`.
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
    kept = smallest_set(names, possible)
    if not kept:
        return None, ""
    conflict = Conflict(kept, tuple(loosened(kept)), proof)
    together = "These cannot hold together" if len(kept) > 1 else "This cannot hold"
    told = ", or ".join(f"{name} {now.shown} -> {then.shown}" for name, now, then in conflict.loosenings)
    return conflict, f"{together}: {', '.join(kept)}." + (f" Smallest loosening of one: {told}." if told else "")
