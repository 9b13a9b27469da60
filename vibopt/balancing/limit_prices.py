"""What each limit of a measured rotor costs, by solving again; and the loosening that would make a job possible."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np

from vibopt.balancing.answers import LimitAnswer
from vibopt.balancing.conflict import Step, conflict_words, smallest_set
from vibopt.balancing.job import CorrectionLimit, ResidualLimit, RotorJob
from vibopt.balancing.outcome import Entry
from vibopt.balancing.pose import Posed, caps, row_limits, rows_of
from vibopt.balancing.prices import solve_question
from vibopt.balancing.question import Question, Solved
from vibopt.forms import ComplexArray
from vibopt.units import show

Known = ResidualLimit | CorrectionLimit
STEP = 1.1
PATIENCE = 2.0
"""Seconds for all prices together; what takes longer is said to have none."""
_ACTIVE = 1e-4
_MOST_PRICES = 12
_HALVINGS = 24


def limit_answers(
    job: RotorJob, posed: Posed, solved: Solved, goal: Entry, asked: Posed | None = None
) -> tuple[dict[str, LimitAnswer], tuple[str, ...]]:
    """Every limit of the file at an answer, with its price; and a sentence where none was computed.

    Parameters
    ----------
    posed
        The nominal question, on which limits are measured.
    goal
        Its value at u, for the units of the prices.
    asked
        The question that was answered, where it is another one (a robust goal).

    Notes
    -----
    A price is the question solved again with a wider limit.  Free weights: the limits that the answer touches, and
    the bound from which on nothing is gained.  Holes and robust goals: every limit, since there a limit holds the
    answer back without being touched; as far as the time goes.
    """
    asked = posed if asked is None else asked
    steps = asked.question.is_discrete or bool(job.goal.robust)
    limits: tuple[Known, ...] = (*job.residual_limits, *job.correction_limits)
    u = solved.u
    assert u is not None
    measured = posed.chosen_only(solved.chosen)
    answers = {limit.name: _answer(job, measured, limit, u) for limit in limits}
    limits = tuple(one for one in limits if steps or answers[one.name].margin < _ACTIVE)
    value = asked.question.chosen_only(solved.chosen).value(u)
    end, left = time.perf_counter() + PATIENCE, [one.name for one in limits[_MOST_PRICES:]]
    for limit in limits[:_MOST_PRICES]:
        price = _price(job, asked, limit, value, goal, end)
        answers[limit.name] = replace(answers[limit.name], price=price or "")
        left += [limit.name] if price is None else []
    return answers, ((f"No price was computed for {', '.join(left)}: it takes too long.",) if left else ())


def _answer(job: RotorJob, posed: Posed, limit: Known, u: ComplexArray) -> LimitAnswer:
    if isinstance(limit, ResidualLimit):
        return _residual(job, posed, limit, u)
    return _correction(job, posed, limit, u)


def _residual(job: RotorJob, posed: Posed, limit: ResidualLimit, u: ComplexArray) -> LimitAnswer:
    left = np.abs(posed.question.residual(u))
    worst = max(rows_of(job, limit.sensor, limit.speed), key=lambda row: float(left[row]))
    dimension = job.sensors[job.readings[worst][1]].dimension
    measured = Entry(float(left[worst]), dimension, limit.unit)
    return LimitAnswer("residual", job.row_name(worst), measured, Entry(limit.at_most, dimension, limit.unit))


def _correction(job: RotorJob, posed: Posed, limit: CorrectionLimit, u: ComplexArray) -> LimitAnswer:
    masses = posed.question.masses(u)
    amount = float(masses.sum() if limit.plane is None else masses[limit.plane])
    plane = job.planes[limit.plane or 0]
    place = "all planes" if limit.plane is None else plane.name
    value, bound = Entry(amount, plane.dimension, limit.unit), Entry(limit.at_most, plane.dimension, limit.unit)
    return LimitAnswer("correction", place, value, bound)


def _price(job: RotorJob, asked: Posed, limit: Known, value: float, goal: Entry, end: float) -> str | None:
    """What a wider limit buys, in words; "" where it buys nothing, None where it takes too long."""
    question, left = asked.question, end - time.perf_counter()
    solved = solve_question(loosened(job, asked, limit, STEP), left) if left > 0.0 else None
    if solved is None or (solved.status != "optimal" and question.is_discrete):
        return None
    if solved.u is None or not np.isfinite(solved.value) or solved.value > value * (1.0 - 1e-7):
        return ""
    dimension = _dimension(job, limit)
    bound, wider = (show(one, limit.unit, dimension) for one in (limit.at_most, limit.at_most * STEP))
    now, then = (show(question.amount(one), goal.unit, goal.dimension) for one in (value, solved.value))
    over = f" ({job.goal.robust} over the scatter)" if job.goal.robust else ""
    until = "" if question.is_discrete or job.goal.robust else _until(job, asked, limit, value, end)
    return f"{bound} -> {wider} buys {now} -> {then}{over}" + (
        f"; nothing more to gain beyond {until}" if until else ""
    )


def _until(job: RotorJob, asked: Posed, limit: Known, value: float, end: float) -> str:
    """The bound from which on the goal is as good as without the limit, by halving; "" where time or proof runs out."""
    free = solve_question(loosened(job, asked, limit, np.inf))
    if free.u is None or not free.value < value:
        return ""
    reached = _answer(job, asked, limit, free.u).value.value
    target = free.value + 1e-6 * value
    bad, good = 1.0, float(reached) / limit.at_most * (1.0 + 1e-9)
    if good <= bad:
        return ""
    for _ in range(_HALVINGS):
        if time.perf_counter() > end:
            return ""
        middle = float(np.sqrt(bad * good))
        solved = solve_question(loosened(job, asked, limit, middle))
        bad, good = (bad, middle) if solved.u is not None and solved.value <= target else (middle, good)
    return show(limit.at_most * good, limit.unit, _dimension(job, limit))


def _dimension(job: RotorJob, limit: Known) -> str:
    """What a limit is counted in."""
    if isinstance(limit, ResidualLimit):
        return job.sensors[job.readings[rows_of(job, limit.sensor, limit.speed)[0]][1]].dimension
    return job.planes[limit.plane or 0].dimension


def loosened(job: RotorJob, posed: Posed, limit: Known, factor: float) -> Question:
    """The question with one limit of the file wider, the others as they are."""
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
    total = min((one.at_most for one in job.correction_limits if one.plane is None), default=np.inf)
    return replace(posed.question, limits=full, caps=caps(job), total_cap=total)


def _exchanged(limits: tuple[Any, ...], old: Known, new: Known) -> tuple[Any, ...]:
    return tuple(new if one is old else one for one in limits)


def impasse(job: RotorJob, posed: Posed) -> str:
    """Why there is no correction: the limits that cannot hold together, and the smallest loosening of one of them."""
    limits: tuple[Known, ...] = (*job.residual_limits, *job.correction_limits)
    end = time.perf_counter() + PATIENCE

    def possible(kept: tuple[str, ...]) -> bool:
        residual = tuple(one for one in job.residual_limits if one.name in kept)
        correction = tuple(one for one in job.correction_limits if one.name in kept)
        question = with_limits(replace(job, residual_limits=residual, correction_limits=correction), posed)
        left = end - time.perf_counter()
        return left <= 0.0 or solve_question(question, left).status != "infeasible"

    names = smallest_set([one.name for one in limits], possible)
    steps = [] if posed.question.is_discrete else loosenings(job, posed)
    return conflict_words(names, [step for step in steps if step[0] in names])


def loosenings(job: RotorJob, posed: Posed) -> list[Step]:
    """(limit, bound now, bound that makes the job possible) for limits on the residual that help alone."""
    found = []
    for limit in job.residual_limits:
        rows = rows_of(job, limit.sensor, limit.speed)
        free = loosened(job, posed, limit, np.inf)
        importance = np.zeros(free.n_readings)
        importance[np.isin(np.arange(free.n_readings) % posed.n_rows, rows)] = 1.0
        solved = solve_question(replace(free, importance=importance, goal="worst"))
        if solved.u is None or not solved.value > limit.at_most:
            continue
        dimension = job.sensors[job.readings[rows[0]][1]].dimension
        now, then = (show(one, limit.unit, dimension) for one in (limit.at_most, solved.value * 1.0005))
        found.append((limit.name, now, then))
    return found
