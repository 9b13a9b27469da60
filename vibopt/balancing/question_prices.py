"""What a wider limit is worth, found by solving again with the limit moved; and limits that cannot hold together."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import replace

from vibopt.answer.answer import Conflict
from vibopt.answer.entry import Entry
from vibopt.balancing.question import Question, Solved
from vibopt.work import Budget, metered

Solver = Callable[[Question], Solved]
THOROUGH = "`vibopt explain FILE --thorough`"
ALLOWANCE = 2_000
"""Work for all prices of an answer [nominal ms]; what takes more is said to have none."""
WHATEVER = 10**12


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
    return (f"No price was computed for {', '.join(names)}: {many}. {THOROUGH} computes {_them(names)}.",)


def _them(names: Sequence[str]) -> str:
    return "them" if len(names) > 1 else "it"


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
            return solve_split(question, None if most is None else Budget(int(most / PROGRAM) + 1, "programs", PROGRAM))
    from vibopt.balancing.continuous import solve_continuous

    return solve_continuous(question)


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
