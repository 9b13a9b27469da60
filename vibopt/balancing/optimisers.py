"""Which optimiser answers a question, and the work that what is found out beside an answer may take."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from contextvars import ContextVar

from vibopt.balancing.question import Question, Solved
from vibopt.records import replace
from vibopt.work import Budget, metered, within

Solver = Callable[[Question], Solved]
THOROUGH = "`vibopt explain FILE --thorough`"
ALLOWANCE = 2_000
"""Work for the limits that clash, and for what comes nearest [nominal ms]; what takes more is said not to be known."""
WHATEVER = 10**12

_BARE: ContextVar[bool] = ContextVar("answers alone", default=False)


def answers_alone() -> AbstractContextManager[None]:
    """Answers inside do not say what clashes, nor what comes nearest: no point of a sweep shows it."""
    return within(_BARE, True)


def allowance(thorough: bool = False) -> Budget:
    """The work that may be done beside one answer."""
    most = 0 if _BARE.get() else WHATEVER if thorough else ALLOWANCE
    return Budget(most, "ms of nominal work")


def solve_question(question: Question, most: float | None = None) -> Solved:
    """The answer by the optimiser that the question asks for; a search takes no more than `most` [nominal ms]."""
    with metered() as meter:
        if question.is_discrete:
            from vibopt.balancing.discrete import solve_discrete
            from vibopt.balancing.option_tree import BOX

            solved = solve_discrete(question, None if most is None else Budget(int(most / BOX), "boxes"))
        else:
            from vibopt.balancing.continuous import PROGRAM, solve_continuous

            budget = None if most is None or not question.is_search else Budget(int(most / PROGRAM) + 1, "programs")
            solved = solve_continuous(question, budget)
    return replace(solved, work=meter.done)
