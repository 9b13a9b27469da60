"""Limits of a measured rotor at a correction; where none keeps them, what to loosen, and what is near."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from vibopt.answer.answer import Conflict, Least, Nearest
from vibopt.answer.entry import Checked, Entry, at_most
from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.fitting import fitting_of, greatest_readings, put_back
from vibopt.balancing.impasses import Step, clash, narrowest
from vibopt.balancing.influence import Identified
from vibopt.balancing.optimisers import allowance, solve_question
from vibopt.balancing.plan_values import todo
from vibopt.balancing.plane_options import Posed
from vibopt.balancing.question import Question, Solved, first_greatest
from vibopt.balancing.rates import Bounding, cap_of, own_caps, rates
from vibopt.balancing.rotor_job import CorrectionLimit, ResidualLimit, RotorJob
from vibopt.balancing.rotor_question import caps, row_limits, rows_of
from vibopt.values.soft import softness, widened
from vibopt.work import Budget

Limit = ResidualLimit | CorrectionLimit
_CLOSE, _ROUNDING = 1e-7, 1e-13
AGREES = 1e-6
"""Part of the readings by which a simulated rotor may differ from what is said of a plan."""
NONE: Mapping[str, float] = {}


def limits_at(job: RotorJob, posed: Posed, u: ComplexArray) -> dict[str, Checked]:
    """Every limit of the file at the correction u, by name."""
    greatest = greatest_readings(job)
    return {limit.name: measured(job, posed, limit, u, greatest) for limit in job.every_limit}


def rates_of(job: RotorJob, question: Question, solved: Solved) -> dict[str, float] | None:
    """What the goal falls by per unit of each limit and cap, by their names in the file [SI]."""
    known = own_caps(job.planes)
    known |= {one.name: Bounding(one.at_most, 1.0, rows_of(job, one.sensor, one.speed)) for one in job.residual_limits}
    for one in job.correction_limits:
        k = one.plane
        known[one.name] = Bounding(one.at_most) if k is None else cap_of(job.planes[k], k, one.at_most)
    found = None if job.goal.robust or job.asks_shares else rates(question, solved, known)
    if found is None or question.goal != "huber" or not solved.value > 0.0:
        return found
    steep = 2.0 * question.n_readings * question.amount(solved.value)  # of its square, beside that of the amplitude
    return {name: rate / steep for name, rate in found.items()}


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
    asked = posed.question
    scale = np.abs(asked.y0) + np.abs(asked.H) @ np.abs(u)
    left = np.abs(asked.residual(u))
    left = np.where(left > _ROUNDING * scale, left, 0.0)[: times * posed.n_rows].reshape(times, -1).max(axis=0)
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
    most = None if thorough or not posed.question.is_search else float(budget.most)
    return clash(
        [limit.name for limit in limits], possible, lambda names: loosenings(job, posed, names, most),
        solved.claim, 1 + len(limits) + len(job.residual_limits), solved.work, budget,
        softness({limit.name: limit for limit in limits}),
    )  # fmt: skip


def loosenings(job: RotorJob, posed: Posed, names: Sequence[str], most: float | None = None) -> list[Step]:
    """(limit, bound now, bound that makes the job possible) for limits on the residual, by name, that help alone.

    Of lists only what is proven to be the least, each within `most` work [nominal ms].
    """
    found = []
    for limit in [one for one in job.residual_limits if one.name in names]:
        rows = rows_of(job, limit.sensor, limit.speed)
        others = tuple(one for one in job.residual_limits if one is not limit)
        free = with_limits(replace(job, residual_limits=others), posed)
        importance = np.zeros(free.n_readings)
        importance[np.isin(np.arange(free.n_readings) % posed.n_rows, rows)] = 1.0
        solved = solve_question(replace(free, importance=importance, goal="worst"), most)
        proven = solved.status == "optimal" or not free.is_search
        if solved.u is None or not proven or not solved.value > limit.at_most:
            continue
        dimension = job.sensors[job.readings[rows[0]][1]].dimension
        now, then = (Entry(value, dimension, limit.unit) for value in (limit.at_most, solved.value * 1.0005))
        found.append((limit.name, now, then))
    return found


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
    importance = np.where(asked, 1.0 / np.where(asked, bound, 1.0), 0.0)
    soft = softness({limit.name: limit for limit in job.residual_limits})
    best = _least(posed.question, importance, budget) if not soft else _weighed(job, posed, importance, budget)
    if best is None or best.u is None:
        return None
    there = posed.chosen_only(best.chosen)
    fitting = fitting_of(job, identified, best.u, there.question.options)
    if not (put_back(job, identified, fitting)[1] <= AGREES).all():
        return None
    rows = limits_at(job, there, best.u)
    alone = with_limits(job.limited_to(()), posed)
    least = {}
    for limit in job.residual_limits:
        if (one := _alone(job, replace(posed, question=alone), limit, budget)) is not None:
            least[limit.name] = one
    left = tuple(one.name for one in job.residual_limits if one.name not in least)
    return Nearest(words=todo(job, fitting), values=fitting.entries(), limits=rows, least=least, left=left, soft=soft)


def _weighed(job: RotorJob, posed: Posed, importance: FloatArray, budget: Budget) -> Solved | None:
    """The least of the worst, the limits widened by their weights; None where the work is done before one is found."""
    rows = np.arange(len(importance)) % posed.n_rows

    def at(factor: float) -> Solved | None:
        wide = [
            replace(limit, at_most=limit.at_most * widened(factor, limit.soft or 1.0)) for limit in job.residual_limits
        ]
        bounds = row_limits(replace(job, residual_limits=tuple(wide)))[rows]
        solved = _least(posed.question, np.where(importance > 0.0, 1.0 / bounds, 0.0), budget)
        return solved if solved.u is not None and solved.value <= 1.0 + _CLOSE else None

    found = narrowest(at, budget)
    return None if found is None else found.found


def _least(question: Question, importance: object, budget: Budget) -> Solved:
    """Without limits on residuals, the least of the greatest amplitude times its importance, in what work is left."""
    free = np.full(len(question.limits), np.inf)
    asked = replace(question, limits=free, importance=np.asarray(importance, dtype=float), goal="worst")
    endless = not question.is_search or budget.most > 1e9
    solved = solve_question(asked, None if endless else max(float(budget.most - budget.spent), 1.0))
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
