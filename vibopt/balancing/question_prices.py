"""What a wider limit is worth, found by solving again with the limit moved; and limits that cannot hold together."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import replace
from typing import Literal

import numpy as np

from vibopt.answer.answer import Conflict
from vibopt.answer.entry import Entry
from vibopt.balancing.question import Question, Solved
from vibopt.records import dataclass
from vibopt.work import Budget, metered

Which = Literal["reading", "cap", "total"]
Solver = Callable[[Question], Solved]
BINDS = 1e-6
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


@dataclass(frozen=True)
class Price:
    """What one limit costs.

    which, place
        "reading" or "cap" with its place, or "total".
    rate
        Fall of the goal per unit of the limit, from the multipliers; nan for discrete answers.
    wider, tighter
        Fall of the goal when the limit is widened by `step`, and its rise when it is tightened by as much (inf: then
        nothing keeps the limits; nan: not found).
    step
        How far it was moved, in its own unit.
    grain
        What the values themselves may be off by.
    """

    which: Which
    place: int
    rate: float
    wider: float
    tighter: float
    step: float
    grain: float

    @property
    def confirmed(self) -> bool:
        """Whether the rate lies between both differences, as it must for a convex program."""
        slack = 1e-7 * max(abs(self.wider), 1e-300) + self.rate * self.step * 1e-4 + self.grain
        return self.wider - slack <= self.rate * self.step <= self.tighter + slack


def binding(question: Question, solved: Solved) -> list[tuple[Which, int]]:
    """The limits that the answer touches, within a millionth."""
    if solved.u is None:
        return []
    left = np.abs(question.residual(solved.u))
    found: list[tuple[Which, int]] = [
        ("reading", int(k)) for k in np.flatnonzero(left >= question.limits * (1 - BINDS))
    ]
    touched = (np.abs(solved.u) >= question.caps * (1 - BINDS)) & (question.caps > 0)
    found += [("cap", int(p)) for p in np.flatnonzero(touched)]
    if question.masses(solved.u).sum() >= question.total_cap * (1 - BINDS):
        found.append(("total", 0))
    return found


def by_solving_again(
    question: Question,
    solved: Solved,
    which: Which,
    place: int = 0,
    share: float = 1e-3,
    solve: Callable[[Question], Solved] = solve_question,
) -> Price:
    """The price of one limit, confirmed by two more solutions with the limit moved by `share` of itself.

    A discrete answer moves in steps: take a larger share there (5 %), and read `wider` and `tighter`, not the rate.
    """
    step = share * _limit(question, which, place)
    rate = float("nan")
    if solved.prices is not None:
        prices = solved.prices
        rate = (
            float({"reading": prices.readings, "cap": prices.caps}[which][place]) if which != "total" else prices.total
        )
    after = [solve(_moved(question, which, place, sign * step)) for sign in (1.0, -1.0)]
    wider, tighter = (_change(solved.value, other) for other in after)
    grain = 1e-8 * abs(solved.value)
    return Price(which, place, rate, -wider, tighter, step, grain)


def _change(value: float, other: Solved) -> float:
    """How much higher the goal of another solution is."""
    if other.status == "infeasible":
        return float("inf")
    return other.value - value


def _limit(question: Question, which: Which, place: int) -> float:
    if which == "total":
        return question.total_cap
    return float((question.limits if which == "reading" else question.caps)[place])


def _moved(question: Question, which: Which, place: int, by: float) -> Question:
    """The question with one limit moved."""
    if which == "total":
        return replace(question, total_cap=question.total_cap + by)
    if which == "reading":
        limits = question.limits.copy()
        limits[place] += by
        return replace(question, limits=limits)
    caps = question.caps.copy()
    caps[place] += by
    return replace(question, caps=caps)


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
