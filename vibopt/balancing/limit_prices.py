"""What each limit of a measured rotor costs, by solving again; without an answer what to loosen, and what is near."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from vibopt.answer.answer import Conflict, Least, Nearest
from vibopt.answer.entry import Checked, Entry, at_most
from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.fitting import fitting_of, greatest_readings, put_back
from vibopt.balancing.impasses import Step, clash, narrowest
from vibopt.balancing.influence import Identified
from vibopt.balancing.plan_values import todo
from vibopt.balancing.plane_options import OwnCap, own_caps
from vibopt.balancing.question import Question, Solved, first_greatest
from vibopt.balancing.question_prices import ACTIVE, Best, Bound, OpenError, Priced, Prices, allowance, solve_question
from vibopt.balancing.rotor_job import CorrectionLimit, ResidualLimit, RotorJob
from vibopt.balancing.rotor_question import Posed, caps, row_limits, rows_of
from vibopt.units import show
from vibopt.values.soft import softness, widened
from vibopt.work import Budget

Limit = ResidualLimit | CorrectionLimit
Known = Limit | OwnCap
AGREES = 1e-6
"""Part of the readings by which a simulated rotor may differ from what is said of a plan."""
_LOOKS = 24
_CLOSE = 1e-7
NONE: Mapping[str, float] = {}


def limit_answers(
    job: RotorJob, posed: Posed, solved: Solved, goal: Entry, asked: Posed | None = None, *, thorough: bool = False
) -> Priced:
    """Every limit of the file at an answer, with its price, and the prices of the planes' own caps.

    Parameters
    ----------
    posed
        The nominal question, on which limits are measured.
    goal
        Its value at u, for the units of the prices.
    asked
        The question that was answered, where it is another one (a robust goal).
    thorough
        Whatever the work.

    Notes
    -----
    A price is the question solved again with a wider limit.  Free weights: the limits that the answer touches, and
    the bound from which on nothing is gained.  Holes and robust goals: every limit, since there a limit holds the
    answer back without being touched; as far as the work goes.
    """
    asked = posed if asked is None else asked
    steps = asked.question.is_discrete or bool(job.goal.robust)
    u = solved.u
    assert u is not None
    there = posed.chosen_only(solved.chosen)
    limits: tuple[Limit, ...] = (*job.residual_limits, *job.correction_limits)
    greatest, masses = greatest_readings(job), there.question.masses(u)
    answers = {limit.name: measured(job, there, limit, u, greatest) for limit in limits}
    reached = {cap: cap.measured(there.question, u, masses) / cap.at_most for cap in own_caps(job)}
    value = asked.question.chosen_only(solved.chosen).value(u)
    priced: list[Known] = [one for one in limits if job.choices and (steps or answers[one.name].margin < ACTIVE)]
    priced += [one for one, part in reached.items() if job.choices and (steps or 1.0 - part < ACTIVE)]
    budget, over = allowance(thorough), f" ({job.goal.robust} over the scatter)" if job.goal.robust else ""
    bounds = [_bound(job, asked, one, (value, solved.work), budget, ranged=not steps) for one in priced]
    prices = Prices(
        bounds, value, lambda one: show(asked.question.amount(one), goal.unit, goal.dimension), solved.work, budget,
        searched=asked.question.is_search, behind=over,
    )  # fmt: skip
    return Priced(answers, prices.words, prices.notes)


def _bound(
    job: RotorJob, asked: Posed, limit: Known, now: tuple[float, float], budget: Budget, *, ranged: bool
) -> Bound:
    """A limit with what other bounds do; `now` is the goal of the answer and its work."""

    def best(bound: float) -> tuple[float, ComplexArray] | None:
        wider = loosened(job, asked, limit, bound / limit.at_most)
        solved = None if wider is None else solve_question(wider, _left(wider, budget, now[1]))
        if solved is not None and solved.status in ("feasible", "unproven") and asked.question.is_discrete:
            raise OpenError
        return None if solved is None or solved.u is None or not np.isfinite(solved.value) else (solved.value, solved.u)

    def until(free: tuple[float, ComplexArray], asked_for: Best) -> float | None:
        """By false position."""
        most = _amount(job, asked, limit, free[1]) / limit.at_most * (1.0 + 1e-9)

        def root(goal: float) -> float:  # the goal meets its free value as a parabola does, its root as a line
            return float(np.sqrt(max(goal - free[0], 0.0)) - np.sqrt(1e-6 * now[0]))

        def height(factor: float) -> float:
            there = asked_for(limit.at_most * factor)
            return np.inf if there is None else root(there[0])

        if most <= 1.0:
            return None
        return limit.at_most * _first_below(height, (1.0, root(now[0])), (most, root(free[0])))

    dimension = _dimension(job, limit)
    return Bound(limit.name, limit.at_most, limit.unit, dimension, best, until if ranged else None, _LOOKS + 2)


def _left(question: Question, budget: Budget, least: float = 1.0) -> float | None:
    """Work for one more solution: of a search what is left, and so much at least."""
    endless = not question.is_search or budget.most > 1e9
    return None if endless else max(float(budget.most - budget.spent), least, 1.0)


def _first_below(height: Callable[[float], float], bad: tuple[float, float], good: tuple[float, float]) -> float:
    """Where a falling function comes down to zero, from above, by false position (Illinois rule).

    `bad` and `good` are two places with its values there, above zero and not.
    """
    (low, above), (high, below), last = bad, good, 0
    for _ in range(_LOOKS):
        if high <= low * (1.0 + _CLOSE):
            break
        middle = low + (high - low) * float(np.clip(above / (above - below), 0.01, 0.99))
        here = height(middle)
        side = 1 if here <= 0.0 else -1
        fade = 0.5 if last == side else 1.0
        if side > 0:
            high, below, above = middle, min(here, 1e-3 * good[1]), above * fade
        else:
            low, above, below = middle, min(here, above), below * fade
        last = side
    return high


def measured(
    job: RotorJob, posed: Posed, limit: Limit, u: ComplexArray, greatest: Mapping[str, float] = NONE
) -> Checked:
    """A limit at the correction u."""
    if isinstance(limit, ResidualLimit):
        return _residual(job, posed, limit, u, greatest)
    place = "all planes" if limit.plane is None else job.planes[limit.plane].name
    value, bound = (Entry(one, _dimension(job, limit), limit.unit) for one in (
        _amount(job, posed, limit, u), limit.at_most))  # fmt: skip
    return at_most(limit.name, "correction", place, value, bound)


def _residual(
    job: RotorJob, posed: Posed, limit: ResidualLimit, u: ComplexArray, greatest: Mapping[str, float]
) -> Checked:
    left = np.abs(posed.question.residual(u))
    rows = rows_of(job, limit.sensor, limit.speed)
    worst = rows[first_greatest(left[rows])]
    dimension = job.sensors[job.readings[worst][1]].dimension
    value, bound = (Entry(one, dimension, limit.unit) for one in (float(left[worst]), limit.at_most))
    return at_most(limit.name, "residual", job.row_name(worst), value, bound, greatest.get(dimension))


def _amount(job: RotorJob, posed: Posed, limit: Known, u: ComplexArray) -> float:
    """What the correction u takes of a limit or a cap [SI]."""
    if isinstance(limit, ResidualLimit):
        return float(_residual(job, posed, limit, u, NONE).value.value)
    masses = posed.question.masses(u)
    if isinstance(limit, OwnCap):
        return limit.measured(posed.question, u, masses)
    return float(masses.sum() if limit.plane is None else masses[limit.plane])


def _dimension(job: RotorJob, limit: Known) -> str:
    """What a limit is counted in."""
    if isinstance(limit, ResidualLimit):
        return job.sensors[job.readings[rows_of(job, limit.sensor, limit.speed)[0]][1]].dimension
    return limit.dimension if isinstance(limit, OwnCap) else job.planes[limit.plane or 0].dimension


def loosened(job: RotorJob, posed: Posed, limit: Known, factor: float) -> Question | None:
    """The question with one limit of the file wider, the others as they are; None where that changes nothing."""
    if isinstance(limit, OwnCap):
        question = posed.again(limit.moved(job, limit.at_most * factor)).question
        return None if question.same_choices(posed.question) else question
    wider = replace(limit, at_most=limit.at_most * factor)
    return with_limits(
        replace(
            job,
            residual_limits=_exchanged(job.residual_limits, limit, wider),
            correction_limits=_exchanged(job.correction_limits, limit, wider),
        ),
        posed,
    )


def with_limits(job: RotorJob, posed: Posed) -> Question:
    """The question with the limits of `job`, which has none that are new; robust rows go with their own sensor."""
    times = -(-posed.question.n_readings // posed.n_rows)
    rows = np.tile(row_limits(job), times)[: posed.question.n_readings]
    full = np.where(np.isfinite(posed.question.limits), rows, np.inf)
    total = min((limit.at_most for limit in job.correction_limits if limit.plane is None), default=np.inf)
    return replace(posed.question, limits=full, caps=caps(job), total_cap=total)


def _exchanged(limits: tuple[Any, ...], old: Known, new: Known) -> tuple[Any, ...]:
    return tuple(new if limit is old else limit for limit in limits)


def impasse(job: RotorJob, posed: Posed, solved: Solved, *, thorough: bool = False) -> tuple[Conflict | None, str]:
    """Why there is no correction: the limits that cannot hold together, and the smallest loosening of one of them.

    What the proof took that there is none is expected of each further solution.
    """
    limits: tuple[Limit, ...] = (*job.residual_limits, *job.correction_limits)

    def possible(kept: tuple[str, ...]) -> bool:
        residual = tuple(limit for limit in job.residual_limits if limit.name in kept)
        correction = tuple(limit for limit in job.correction_limits if limit.name in kept)
        question = with_limits(replace(job, residual_limits=residual, correction_limits=correction), posed)
        return solve_question(question).status != "infeasible"

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
        free = loosened(job, posed, limit, np.inf)
        assert free is not None
        importance = np.zeros(free.n_readings)
        importance[np.isin(np.arange(free.n_readings) % posed.n_rows, rows)] = 1.0
        solved = solve_question(replace(free, importance=importance, goal="worst"), most)
        proven = solved.status == "optimal" or not free.is_search
        if solved.u is None or not proven or not solved.value > limit.at_most:
            continue
        now, then = (Entry(one, _dimension(job, limit), limit.unit) for one in (limit.at_most, solved.value * 1.0005))
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
    fitting = fitting_of(job, identified, best.u, there.options)
    if not (put_back(job, identified, fitting)[1] <= AGREES).all():
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
    return Nearest(words=todo(job, fitting), values=fitting.entries(), limits=rows, least=least, left=left, soft=soft)


def _weighed(job: RotorJob, posed: Posed, importance: FloatArray, budget: Budget) -> Solved | None:
    """The least of the worst, the limits widened by their weights; None where the work is done before one is found."""
    rows = np.arange(len(importance)) % posed.n_rows

    def at(factor: float) -> Solved | None:
        wide = [replace(one, at_most=one.at_most * widened(factor, one.soft or 1.0)) for one in job.residual_limits]
        bounds = row_limits(replace(job, residual_limits=tuple(wide)))[rows]
        solved = _least(posed.question, np.where(importance > 0.0, 1.0 / bounds, 0.0), budget)
        return solved if solved.u is not None and solved.value <= 1.0 + _CLOSE else None

    found = narrowest(at, budget)
    return None if found is None else found.found


def _least(question: Question, importance: object, budget: Budget) -> Solved:
    """Without limits on residuals, the least of the greatest amplitude times its importance."""
    free = np.full(len(question.limits), np.inf)
    asked = replace(question, limits=free, importance=np.asarray(importance, dtype=float), goal="worst")
    solved = solve_question(asked, _left(question, budget))
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
