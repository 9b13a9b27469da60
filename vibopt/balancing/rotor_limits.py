"""Limits of a measured rotor at a correction; where none keeps them, what to loosen, and what is near."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from vibopt.answer.answer import Least, Nearest
from vibopt.answer.clashes import Conflict
from vibopt.answer.entry import Checked, Entry, at_most
from vibopt.answer.plan import DeferredMapping
from vibopt.arrays import BoolArray, ComplexArray, FloatArray
from vibopt.balancing.fitting import fitting_of, greatest_readings, put_back
from vibopt.balancing.impasses import LOOSER, Step, clash, narrowest
from vibopt.balancing.influence import Identified
from vibopt.balancing.optimisers import allowance, solve_question
from vibopt.balancing.plan_values import todo
from vibopt.balancing.plane_options import Posed
from vibopt.balancing.question import Question, Solved, first_greatest, left_over, together, worst_part
from vibopt.balancing.rates import Bounding, cap_of, own_caps, rates
from vibopt.balancing.rotor_job import CorrectionLimit, ResidualLimit, RotorJob
from vibopt.balancing.rotor_question import caps, row_limits, rows_of
from vibopt.records import replace
from vibopt.values.soft import softness, widened
from vibopt.work import Budget

Limit = ResidualLimit | CorrectionLimit
Told = Callable[[ComplexArray, Mapping[str, Checked]], Mapping[str, Checked]]
"""Rows at a correction with what a limit with a probability asks."""
_CLOSE = 1e-7
AGREES = 1e-6
"""Part of the readings by which a simulated rotor may differ from what is said of a plan."""
NONE: Mapping[str, float] = {}


def limits_at(job: RotorJob, posed: Posed, u: ComplexArray) -> dict[str, Checked]:
    """Every limit of the file at the correction u, by name."""
    greatest = greatest_readings(job) if job.residual_limits else NONE
    return {limit.name: measured(job, posed, limit, u, greatest) for limit in job.every_limit}


def bounds_of(job: RotorJob, posed: Posed) -> dict[str, Bounding]:
    """What bounds the question, by the names of the file; limits on what is left do in every rotor of it."""
    known, times = own_caps(job.planes), posed.question.n_readings // posed.n_rows if job.goal.robust == "worst" else 1
    for one in job.residual_limits:
        rows = np.array(rows_of(job, one.sensor, one.speed)) + posed.n_rows * np.arange(times)[:, None]
        known[one.name] = Bounding(one.at_most, 1.0, rows.ravel().tolist())
    for limit in job.correction_limits:
        k = limit.plane
        known[limit.name] = Bounding(limit.at_most) if k is None else cap_of(job.planes[k], k, limit.at_most)
    return known


def rates_of(job: RotorJob, posed: Posed, solved: Solved) -> Mapping[str, float] | None:
    """What the goal falls by per unit of each limit and cap, by their names in the file [SI]: when they are asked for.

    None of a search, of a robust goal, and where limits have a probability.
    """
    question = posed.question
    if job.goal.robust or job.asks_shares or question.is_search or solved.u is None:
        return None

    def made() -> dict[str, float]:
        found = rates(question, solved, bounds_of(job, posed)) or {}
        if question.goal != "huber" or not solved.value > 0.0:
            return found
        steep = 2.0 * question.n_readings * question.amount(solved.value)  # of its square, beside that of the amplitude
        return {name: rate / steep for name, rate in found.items()}

    capped = sum(plane.is_open and plane.cap < np.inf for plane in job.planes)
    return DeferredMapping({}, len(job.every_limit) + capped, made)


def measured(
    job: RotorJob, posed: Posed, limit: Limit, u: ComplexArray, greatest: Mapping[str, float] = NONE
) -> Checked:
    """A limit at the correction u; on what is left in the worst rotor of a robust question."""
    if isinstance(limit, ResidualLimit):
        return _residual(job, posed, limit, u, greatest)
    place = "all planes" if limit.plane is None else job.planes[limit.plane].name
    masses, dimension = posed.question.masses(u), job.planes[limit.plane or 0].dimension
    taken = float(masses.sum() if limit.plane is None else masses[limit.plane])
    value, bound = (Entry(one, dimension, limit.unit) for one in (taken, limit.at_most))
    return at_most(limit.name, "correction", place, value, bound)


def _residual(
    job: RotorJob, posed: Posed, limit: ResidualLimit, u: ComplexArray, greatest: Mapping[str, float]
) -> Checked:
    times = posed.question.n_readings // posed.n_rows if job.goal.robust == "worst" else 1
    left = np.abs(left_over(posed.question.y0, posed.question.H, u))
    left = together(left[: times * posed.n_rows].reshape(times, -1), job.sums).max(axis=0)
    rows = rows_of(job, limit.sensor, limit.speed)
    worst = rows[first_greatest(left[rows])]
    dimension = job.sensors[job.readings[worst][1]].dimension
    value, bound = (Entry(one, dimension, limit.unit) for one in (float(left[worst]), limit.at_most))
    place = job.row_name(worst) + (f" in the worst of {times} rotors within the scatter" if times > 1 else "")
    return at_most(limit.name, "residual", place, value, bound, greatest.get(dimension))


def with_limits(job: RotorJob, posed: Posed) -> Question:
    """The question with the limits of `job`, which has none that are new; robust rows go with their own sensor."""
    times = -(-posed.question.n_readings // posed.n_rows)
    rows = np.tile(row_limits(job), times)[: posed.question.n_readings]
    full = np.where(np.isfinite(posed.question.limits), rows, np.inf)
    return replace(posed.question, limits=full, caps=caps(job), total_cap=job.total_cap)


def impasse(job: RotorJob, posed: Posed, solved: Solved, *, thorough: bool = False) -> tuple[Conflict | None, str]:
    """Why there is no correction: the limits that cannot hold together, and the smallest loosening of one of them.

    What the proof took that there is none is expected of each further solution.
    """
    limits = job.every_limit

    def possible(kept: tuple[str, ...]) -> bool:
        return solve_question(with_limits(job.limited_to(kept), posed)).status != "infeasible"

    budget = allowance(thorough)
    return clash(
        [limit.name for limit in limits], possible, lambda names: loosenings(job, posed, names, allowance(thorough)),
        solved.claim, 1 + len(limits) + len(job.residual_limits), solved.work, budget,
        softness({limit.name: limit for limit in limits}),
    )  # fmt: skip


def loosenings(job: RotorJob, posed: Posed, names: Sequence[str], budget: Budget) -> list[Step]:
    """(limit, bound now, bound that makes the job possible) for the limits, by name, that help alone.

    Only what is proven to be the least, each within the work of `budget`.
    """
    found = []
    for limit in [one for one in job.every_limit if one.name in names]:
        least = _least_residual if isinstance(limit, ResidualLimit) else _least_cap
        value = least(job, posed, limit, replace(budget))
        if value is not None and value > limit.at_most:
            dimension = measured(job, posed, limit, np.zeros(len(job.planes), dtype=complex)).value.dimension
            now, then = (Entry(one, dimension, limit.unit) for one in (limit.at_most, value * LOOSER))
            found.append((limit.name, now, then))
    return found


def _least_residual(job: RotorJob, posed: Posed, limit: Limit, budget: Budget) -> float | None:
    """The least bound [SI peak] of a limit on what is left with which the others hold; None where it is not known."""
    assert isinstance(limit, ResidualLimit)
    free = with_limits(replace(job, residual_limits=tuple(x for x in job.residual_limits if x is not limit)), posed)
    solved = _least(free, _where(job, posed, limit), budget, free.limits)
    return solved.value if solved.u is not None and (solved.status == "optimal" or not free.is_search) else None


def _least_cap(job: RotorJob, posed: Posed, limit: Limit, budget: Budget) -> float | None:
    """The same of a limit on what is fitted [kg; kg m]."""

    def at(factor: float) -> Solved | None:
        solved = _within(with_limits(_widened(job, {limit.name: factor}), posed), budget)
        return solved if solved.u is not None else None

    best = narrowest(at, budget, lambda solved: _taken(job, posed, solved, (limit,)))
    return limit.at_most * best.factor if best is not None and best.proven else None


def _taken(job: RotorJob, posed: Posed, solved: Solved, limits: Sequence[Limit]) -> float:
    """The greatest factor by which bounds would have to be wider for an answer, by the weights of the limits."""
    assert solved.u is not None
    there = posed.chosen_only(solved.chosen)
    parts = [(-measured(job, there, limit, solved.u).margin, getattr(limit, "soft", None) or 1.0) for limit in limits]
    return max(1.0 + part / (soft if part > 0.0 else 1.0) for part, soft in parts)


def _widened(job: RotorJob, factors: Mapping[str, float]) -> RotorJob:
    """The same with bounds of limits, by name, multiplied."""
    residual = tuple(replace(one, at_most=one.at_most * factors.get(one.name, 1.0)) for one in job.residual_limits)
    fitted = tuple(replace(one, at_most=one.at_most * factors.get(one.name, 1.0)) for one in job.correction_limits)
    return replace(job, residual_limits=residual, correction_limits=fitted)


def nearest_plan(
    job: RotorJob, identified: Identified, posed: Posed, solved: Solved, told: Told | None, *, thorough: bool = False
) -> Nearest | None:
    """The plan that misses the limits least, on what is left and on what is fitted alike.

    What is left by its prediction is made least; `told` says of its rows what a limit with a probability asks.  None
    where there is no limit on a residual, where it would take more than the prices of an answer may, and where
    the simulated rotor does not show what the plan says.
    """
    budget = allowance(thorough)
    if not job.residual_limits or (1 + len(job.residual_limits)) * solved.work > budget.most:
        return None
    bound = posed.question.limits
    asked = np.isfinite(bound) & (bound > 0.0)
    if not asked.any():
        return None
    soft = softness({limit.name: limit for limit in job.residual_limits})
    best = _least_common(job, posed, asked, budget)
    if best is None or best.u is None:
        return None
    there = posed.chosen_only(best.chosen)
    fitting = fitting_of(job, identified, best.u, there.question.options)
    if not (put_back(job, identified, fitting)[1] <= AGREES).all():
        return None
    at_best = limits_at(job, there, best.u)
    rows = at_best if told is None else told(best.u, at_best)
    alone = with_limits(job.limited_to(()), posed)
    least = {}
    judged = [limit for limit in job.residual_limits if limit.share is None]  # a share has no least by its prediction
    for limit in judged:
        if (one := _alone(job, replace(posed, question=alone), limit, budget)) is not None:
            least[limit.name] = one
    left = tuple(one.name for one in judged if one.name not in least)
    return Nearest(words=todo(job, fitting), values=fitting.entries(), limits=rows, least=least, left=left, soft=soft)


def _least_common(job: RotorJob, posed: Posed, asked: BoolArray, budget: Budget) -> Solved | None:
    """The least of the worst of the rows `asked`, every limit widened by its weight; None where the work is done."""
    limits = [limit for limit in job.every_limit if limit.at_most > 0.0]

    def at(factor: float) -> Solved | None:
        wide = _widened(job, {one.name: widened(factor, getattr(one, "soft", None) or 1.0) for one in limits})
        question = with_limits(wide, posed)
        solved = _within(worst_part(question, np.where(asked, question.limits, np.inf)), budget)
        return solved if solved.u is not None and solved.value <= 1.0 + _CLOSE else None

    if not any(isinstance(limit, CorrectionLimit) or limit.soft for limit in limits):
        return _within(worst_part(posed.question, np.where(asked, posed.question.limits, np.inf)), budget)
    found = narrowest(at, budget, lambda solved: _taken(job, posed, solved, limits))
    return found.found if found is not None and found.proven else None


def _where(job: RotorJob, posed: Posed, limit: ResidualLimit) -> FloatArray:
    """One at each reading of a limit, nothing elsewhere (n_readings,)."""
    rows = np.arange(len(posed.question.limits)) % posed.n_rows
    return np.isin(rows, rows_of(job, limit.sensor, limit.speed)).astype(float)


def _least(question: Question, importance: FloatArray, budget: Budget, limits: FloatArray | None = None) -> Solved:
    """The least of the greatest amplitude times its importance under other limits on residuals, none of them if None.

    In what work is left.
    """
    free = np.full(len(question.limits), np.inf) if limits is None else limits
    return _within(replace(question, limits=free, importance=importance, goal="worst"), budget)


def _within(question: Question, budget: Budget) -> Solved:
    """The answer in what work is left."""
    endless = not question.is_search or budget.most > 1e9
    solved = solve_question(question, None if endless else max(float(budget.most - budget.spent), 1.0))
    budget.spend(int(np.ceil(solved.work)))
    return solved


def _alone(job: RotorJob, posed: Posed, limit: ResidualLimit, budget: Budget) -> Least | None:
    """What one limit could be, within the caps of the planes; None where the work is done."""
    if budget.over:
        return None
    best = _least(posed.question, _where(job, posed, limit), budget)
    if best.u is None:
        return None
    row = measured(job, posed.chosen_only(best.chosen), limit, best.u, greatest_readings(job))
    return Least(row.value, best.status == "optimal", row.met)
