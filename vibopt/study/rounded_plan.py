"""A balancing plan with weights that can be weighed out: rounded, and measured as rounded."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING, Any, cast

from vibopt.answer.answer import EMPTY
from vibopt.answer.entry import Entry
from vibopt.balancing import is_rotor
from vibopt.errors import InputError
from vibopt.jobs import answer, facts, is_scene, kept_plan, with_changes
from vibopt.study.grids import Number
from vibopt.study.nearby import Near, Rounded, Rounding, Value
from vibopt.study.rounded import rounded
from vibopt.verify.measured_goal import MEASURED

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer
    from vibopt.balancing import BalancingJob
    from vibopt.jobs import Job


def drawn(job: Job, answer: Answer[Any], asked: Sequence[str]) -> Rounded:
    """What rounding does to an answer of any kind; parameters and errors as of `rounded`."""
    return rounded(answer, asked) if is_scene(job) else rounded_plan(job, answer, asked)


def rounded_plan(job: BalancingJob, answer: Answer[Any], asked: Sequence[str]) -> Rounded:
    """Round the weights of a plan, and measure it anew.

    Parameters
    ----------
    job, found
        A balancing job and its answer.
    asked
        Significant digits for all ("3"), a step for all of a kind ("0.5 g", "5 deg"), or for one number
        ("planes.left.weight.mass=0.5 g").

    Raises
    ------
    InputError
        What is asked cannot be read, there is no plan, or nothing in it can be rounded.
    """
    if not job.choices:
        raise InputError(f"{job.name}: there is nothing to round: nothing is chosen.")
    if answer.status in EMPTY:
        raise InputError(f"{job.name}: there is no design to round: {answer.status}.")
    return _OfPlan(job, answer).rounded(asked)


class _OfPlan(Rounding):
    """Of a balancing job: the weights of a plan."""

    def __init__(self, job: BalancingJob, answer: Answer[Any]) -> None:
        super().__init__(job, answer)
        self.known: dict[tuple[int, tuple[str, ...]], Near | None] = {}

    def kept(self, answer: Answer[Any]) -> BalancingJob:
        made: BalancingJob = kept_plan(self.job, answer)
        return made

    def numbers(self, kept: BalancingJob) -> list[Number]:
        decided = self.job.decided_at
        sizes = (fact for fact in facts(kept) if not fact.path.endswith(".radius"))
        own = [Number(size, least=0) for size in sizes if size.path.startswith(decided)]
        if not own:
            words = "what is chosen are weights of the shelf, or cranks"
            raise InputError(f"{self.job.name}: there is nothing to round: {words}.")
        return own

    def measured(self, kept: BalancingJob, texts: Mapping[str, str]) -> Near | None:
        key = id(kept), tuple(texts.values())
        if key not in self.known:
            self.known[key] = self._measured(kept, texts)
        return self.known[key]

    def _measured(self, kept: BalancingJob, texts: Mapping[str, str]) -> Near | None:
        try:
            here = with_changes(kept, texts)
        except InputError:
            if is_rotor(self.job) and self.job.pairs:
                return None  # of two weights that are no pair the runs say nothing
            raise
        found = answer(here, explain=False)
        margins = {name: limit.margin for name, limit in found.limits.items() if not limit.met}
        margins |= dict.fromkeys(self.job.beyond(cast(Any, here)), -inf)
        worst = min(margins, key=lambda name: margins[name], default="")
        return Near(texts, here, found, worst, -margins.get(worst, 0.0))

    def cost(self, kept: BalancingJob, texts: Mapping[str, str]) -> float | None:
        near = self.measured(kept, texts)
        if near is None:
            return None
        goal = self.goal(near)
        return 0.0 if goal is None else goal.value

    def goal(self, best: Near) -> Entry | None:
        answer = best.answer
        row = answer.measures.get(MEASURED["minimise"])
        return row.value if row is not None else None if answer.goal is None else answer.goal[1]

    def design(self, best: Near, values: Mapping[str, Value]) -> Answer[Any]:
        return best.answer

    def again(self, changes: Mapping[str, str | float]) -> Answer[Any] | None:
        found = answer(with_changes(self.job, changes), explain=False)
        return None if found.status in EMPTY else found
