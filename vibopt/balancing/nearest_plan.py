"""Where no weights keep every limit: those that miss them least, and what each limit could be alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Generic, TypeVar

import numpy as np

from vibopt.answer.answer import Least, Nearest
from vibopt.answer.entry import Checked, Value
from vibopt.balancing.fitting import fitting_of, greatest_readings, plan_text
from vibopt.balancing.influence import Identified
from vibopt.balancing.limit_prices import Limit, measured, with_limits
from vibopt.balancing.plan_values import todo
from vibopt.balancing.question import Question, Solved
from vibopt.balancing.question_prices import THOROUGH, allowance, solve_question
from vibopt.balancing.rotor_job import ResidualLimit, RotorJob
from vibopt.balancing.rotor_question import Posed, rows_of
from vibopt.balancing.rotor_tables import Bounded
from vibopt.balancing.verification import simulated
from vibopt.records import dataclass
from vibopt.work import Budget, late

AGREES = 1e-6
"""Part of the readings by which a simulated rotor may differ from what is said of a plan."""
_CLOSE = 1e-6
"""Part by which a common factor of all bounds is known."""
_WIDEST, _NARROWEST, _STEP = 1e12, 1e-9, 4.0

T = TypeVar("T")
B = TypeVar("B", bound=Bounded)


def nearest_plan(
    job: RotorJob, identified: Identified, posed: Posed, solved: Solved, *, thorough: bool = False
) -> Nearest | None:
    """The plan that misses the limits on residuals least, all others kept.

    None where there is no limit on a residual, where it would take more than the prices of an answer may, and where
    the simulated rotor does not show what the plan says.
    """
    budget = allowance(thorough)
    if not job.residual_limits or (1 + len(job.residual_limits)) * solved.work > budget.most:
        return None
    bound = posed.question.limits
    asked = np.isfinite(bound) & (bound > 0.0)
    if not asked.any():
        return None
    best = _least(posed.question, np.where(asked, 1.0 / np.where(asked, bound, 1.0), 0.0), budget)
    if best.u is None:
        return None
    there = posed.chosen_only(best.chosen)
    fitting = fitting_of(job, identified, best.u, there.options)
    shown = simulated(job, plan_text(job, fitting))
    scale = np.abs(identified.y0) + np.abs(identified.H) @ np.abs([one.u for one in fitting.planes])
    if (np.abs(shown - np.abs(fitting.left)) > AGREES * np.maximum(scale, 1e-300)).any():
        return None
    greatest = greatest_readings(job)
    limits: tuple[Limit, ...] = (*job.residual_limits, *job.correction_limits)
    rows = {one.name: measured(job, there, one, best.u, greatest) for one in limits}
    alone = with_limits(replace(job, residual_limits=(), correction_limits=()), posed)
    least = {}
    for limit in job.residual_limits:
        if (one := _alone(job, replace(posed, question=alone), limit, budget)) is not None:
            least[limit.name] = one
    left = tuple(one.name for one in job.residual_limits if one.name not in least)
    return Nearest(words=todo(job, fitting), values=fitting.entries(), limits=rows, least=least, left=left)


def _least(question: Question, importance: object, budget: Budget) -> Solved:
    """Without limits on residuals, the least of the greatest amplitude times its importance."""
    free = np.full(len(question.limits), np.inf)
    asked = replace(question, limits=free, importance=np.asarray(importance, dtype=float), goal="worst")
    most = None if not question.is_search or budget.most > 1e9 else float(max(budget.most - budget.spent, 1))
    solved = solve_question(asked, most)
    budget.spend(int(np.ceil(solved.work)))
    return solved


def _alone(job: RotorJob, posed: Posed, limit: ResidualLimit, budget: Budget) -> Least | None:
    """What one limit could be, within the caps of the planes; None where the work is done."""
    if budget.over:
        return None
    rows = np.arange(len(posed.question.limits)) % posed.n_rows
    best = _least(posed.question, np.isin(rows, rows_of(job, limit.sensor, limit.speed)).astype(float), budget)
    if best.u is None:
        return None
    row = measured(job, posed.chosen_only(best.chosen), limit, best.u, greatest_readings(job))
    return Least(row.value, best.status == "optimal", row.met)


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
        low, high = high, _STEP * high
        found = tried(high)
    if found is None:
        return None
    while low == 0.0 and high > _NARROWEST and not over():
        lower = tried(high / _STEP)
        if lower is None:
            low = high / _STEP
        else:
            found, high = lower, high / _STEP
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


__all__ = ["costing", "left_words", "narrowest", "nearest_of", "nearest_plan"]
