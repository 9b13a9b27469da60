"""What each limit of a measured rotor costs, by solving again; and the loosening that would make a job possible."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np

from vibopt.balancing.answers import LimitAnswer
from vibopt.balancing.job import CorrectionLimit, ResidualLimit, RotorJob
from vibopt.balancing.outcome import Entry
from vibopt.balancing.pose import Posed, caps, row_limits, rows_of, solve_question
from vibopt.balancing.question import Question
from vibopt.forms import ComplexArray
from vibopt.units import show

Limit = TypeVar("Limit")
STEP = 1.1
_ACTIVE = 1e-4
_MOST_PRICES = 12


def limit_answers(job: RotorJob, posed: Posed, u: ComplexArray, goal: Entry) -> dict[str, LimitAnswer]:
    """Every limit of the file at the correction u, with its price where it holds the answer back.

    `posed` is the nominal question, `goal` its value at u.  Discrete and robust answers have no prices here.
    """
    answers = {limit.name: _residual(job, posed, limit, u) for limit in job.residual_limits}
    answers.update({limit.name: _correction(job, posed, limit, u) for limit in job.correction_limits})
    if posed.question.is_discrete or job.goal.robust:
        return answers
    limits: tuple[ResidualLimit | CorrectionLimit, ...] = (*job.residual_limits, *job.correction_limits)
    for limit in [one for one in limits if answers[one.name].margin < _ACTIVE][:_MOST_PRICES]:
        price = _price(job, posed, limit, answers[limit.name], posed.question.value(u), goal)
        answers[limit.name] = replace(answers[limit.name], price=price)
    return answers


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


def _price(
    job: RotorJob, posed: Posed, limit: ResidualLimit | CorrectionLimit, answer: LimitAnswer, value: float, goal: Entry
) -> str:
    solved = solve_question(loosened(job, posed, limit, STEP))
    if solved.u is None or not np.isfinite(solved.value) or solved.value > value * (1.0 - 1e-7):
        return ""
    wider = show(limit.at_most * STEP, limit.unit, answer.limit.dimension)
    now = show(value, goal.unit, goal.dimension)
    then = show(solved.value, goal.unit, goal.dimension)
    return f"{show(limit.at_most, limit.unit, answer.limit.dimension)} -> {wider} buys {now} -> {then}"


def loosened(job: RotorJob, posed: Posed, limit: ResidualLimit | CorrectionLimit, factor: float) -> Question:
    """The question with one limit of the file wider, the others as they are; robust rows go with their own sensor."""
    if isinstance(limit, ResidualLimit):
        wider = replace(limit, at_most=limit.at_most * factor)
        rows = row_limits(replace(job, residual_limits=_exchanged(job.residual_limits, limit, wider)))
        times = -(-posed.question.n_readings // posed.n_rows)
        full = np.where(np.isfinite(posed.question.limits), np.tile(rows, times)[: posed.question.n_readings], np.inf)
        return replace(posed.question, limits=full)
    heavier = replace(limit, at_most=limit.at_most * factor)
    changed = replace(job, correction_limits=_exchanged(job.correction_limits, limit, heavier))
    total = min((one.at_most for one in changed.correction_limits if one.plane is None), default=np.inf)
    return replace(posed.question, caps=caps(changed), total_cap=total)


def _exchanged(limits: tuple[Limit, ...], old: Limit, new: Limit) -> tuple[Limit, ...]:
    return tuple(new if one is old else one for one in limits)


def loosenings(job: RotorJob, posed: Posed) -> list[tuple[str, str, str]]:
    """(limit, bound now, bound that makes the job possible) for limits on the residual that help alone."""
    found = []
    for limit in job.residual_limits:
        rows = rows_of(job, limit.sensor, limit.speed)
        free = loosened(job, posed, limit, 1e6)
        importance = np.zeros(free.n_readings)
        importance[np.isin(np.arange(free.n_readings) % posed.n_rows, rows)] = 1.0
        solved = solve_question(replace(free, importance=importance, goal="worst"))
        if solved.u is None or not solved.value > limit.at_most:
            continue
        dimension = job.sensors[job.readings[rows[0]][1]].dimension
        now, then = (show(one, limit.unit, dimension) for one in (limit.at_most, solved.value * 1.0005))
        found.append((limit.name, now, then))
    return found
