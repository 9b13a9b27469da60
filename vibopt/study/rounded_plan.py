"""A balancing plan with weights that can be weighed out: rounded, and measured as rounded."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from math import inf, prod
from typing import TYPE_CHECKING, Any, cast

from vibopt.answer.answer import EMPTY
from vibopt.answer.entry import Entry
from vibopt.errors import InputError
from vibopt.jobs import answer, facts, is_scene, kept_plan, with_changes
from vibopt.records import dataclass
from vibopt.study.freeze import MEASURED
from vibopt.study.grids import DIGITS, Grid, Number, grids
from vibopt.study.nearby import ROOMS
from vibopt.study.rounded import Rounded, Value, asked_words, claim_of, rounded

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer
    from vibopt.balancing import BalancingJob
    from vibopt.jobs import Job

_MOST = 256
"""Most roundings that are all tried; of more numbers each is moved by itself."""
_SAME = 1e-12


@dataclass(frozen=True)
class _Tried:
    """One rounding: the texts by path, the job with them as facts, and its answer; how far limits or caps are kept."""

    texts: Mapping[str, str]
    kept: BalancingJob
    found: Answer[Any]
    goal: Entry | None
    broken: str
    by: float

    @property
    def rank(self) -> tuple[float, float]:
        """The better the less: first what is broken, then the goal."""
        return self.by, self.goal.value if self.goal is not None else 0.0


def drawn(job: Job, found: Answer[Any], asked: Sequence[str]) -> Rounded:
    """What rounding does to an answer of any kind; parameters and errors as of `rounded`."""
    return rounded(found, asked) if is_scene(job) else rounded_plan(job, found, asked)


def rounded_plan(job: BalancingJob, found: Answer[Any], asked: Sequence[str]) -> Rounded:
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

    Notes
    -----
    The nearest values are taken where they keep every limit and cap; else the best of those next to the exact ones; at
    last those near the best plan for limits that are tighter by up to a tenth.
    """
    if not job.choices:
        raise InputError(f"{job.name}: there is nothing to round: nothing is chosen.")
    if found.status in EMPTY:
        raise InputError(f"{job.name}: there is no design to round: {found.status}.")
    kept = kept_plan(job, found)
    own = _numbers(job, kept)
    if not own:
        raise InputError(f"{job.name}: there is nothing to round: what is chosen are weights of the shelf, or cranks.")
    steps = grids(own, asked)
    best, tried = _search(job, kept, steps)
    enough = None
    for roomy in _roomy_plans(job) if best.broken else ():
        near = grids(_numbers(job, roomy), asked)
        other, more = _search(job, roomy, near)
        tried += more
        if not other.broken and [one.path for one in near] == [step.path for step in steps]:
            best = other
            break
    if best.broken:
        finer = range(min(max(step.digits for step in steps) + 1, DIGITS), DIGITS + 1)
        enough = next((n for n in finer if not _try(job, kept, _nearest(grids(own, (str(n),)))).broken), None)
    return _made(job, found, steps, best, tried, enough)


def _numbers(job: BalancingJob, kept: BalancingJob) -> list[Number]:
    """What is rounded of a plan."""
    return [
        Number(fact, least=0) for fact in facts(kept) if fact.path.startswith(job.decided_at) and _is_size(fact.path)
    ]


def _roomy_plans(job: BalancingJob) -> Iterator[BalancingJob]:
    """Plans that are best for tighter limits, each under the limits as they are."""
    bounds = [fact for fact in facts(job) if fact.path.startswith("limits.") and fact.value > 0.0]
    for part in ROOMS:
        tighter: dict[str, str | float] = {}
        as_they_are: dict[str, str | float] = {}
        for bound in bounds:
            tighter |= bound.changes(bound.value * (1.0 - part))
            as_they_are |= bound.changes(bound.value)
        here = with_changes(job, tighter)
        found = answer(here, explain=False)
        if found.status in EMPTY:
            return
        yield with_changes(kept_plan(here, found), as_they_are)


def _is_size(path: str) -> bool:
    return not path.endswith(".radius")


def _nearest(steps: Sequence[Grid]) -> dict[str, str]:
    return {step.path: step.nearest for step in steps}


def _search(job: BalancingJob, kept: BalancingJob, steps: Sequence[Grid]) -> tuple[_Tried, int]:
    best = _try(job, kept, _nearest(steps))
    if not best.broken:
        return best, 1
    lists = {step.path: step.around(1) for step in steps}
    if prod(map(len, lists.values())) <= _MOST:
        many = [_try(job, kept, dict(zip(lists, texts, strict=True))) for texts in product(*lists.values())]
        return min([best, *many], key=lambda one: one.rank), 1 + len(many)
    tried = 1
    for path, texts in lists.items():
        others = [_try(job, kept, {**best.texts, path: text}) for text in texts]
        best, tried = min([best, *others], key=lambda one: one.rank), tried + len(others)
    return best, tried


def _try(job: BalancingJob, kept: BalancingJob, texts: Mapping[str, str]) -> _Tried:
    """The plan with these values, measured."""
    here = with_changes(kept, texts)
    found = answer(here, explain=False)
    margins = {name: limit.margin for name, limit in found.limits.items() if not limit.met}
    margins |= dict.fromkeys(job.beyond(cast(Any, here)), -inf)
    worst = min(margins, key=lambda name: margins[name], default="")
    best = found.goal[1] if found.goal is not None else None
    row = found.measures.get(MEASURED["minimise"])
    return _Tried(texts, here, found, row.value if row is not None else best, worst, -margins.get(worst, 0.0))


def _made(
    job: BalancingJob, found: Answer[Any], steps: Sequence[Grid], best: _Tried, tried: int, enough: int | None
) -> Rounded:
    values = {step.path: Value(step.exact, step.shown(best.texts[step.path])) for step in steps}
    same = all(
        abs(value.rounded.value - value.exact.value) <= _SAME * abs(value.exact.value) for value in values.values()
    )
    worse = _worse(found, best.goal)
    status = "violated" if best.broken else found.status if same else "feasible"
    words = asked_words(steps)
    done = Rounded(best.found, best.kept, found, values, worse, tried, best.goal, best.broken, best.by, enough)
    goal = None if found.goal is None or best.goal is None else (found.goal[0], best.goal)
    details = {**best.found.details, "rounded": {"asked": words, "worse_by": worse, "values": values, "tried": tried}}
    claim = found.claim if same and not best.broken else claim_of(done, words)
    return replace(done, design=replace(best.found, status=status, claim=claim, goal=goal, details=details))


def _worse(found: Answer[Any], goal: Entry | None) -> float | None:
    """What rounding costs as a part of the exact goal; None where that is nothing but rounding."""
    if found.goal is None or goal is None:
        return None
    exact = found.goal[1].value
    size = max(abs(exact), abs(goal.value))
    return (goal.value - exact) / abs(exact) if abs(exact) > 0.01 * size else 0.0 if not size else None
