"""From a measured rotor to the pure question of the optimisers, and the caps of its planes."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import cast

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.balancing.influence import Identified
from vibopt.balancing.plane_options import Posed, caps_of, posed
from vibopt.balancing.question import Goal, Question
from vibopt.balancing.rotor_job import RotorJob
from vibopt.balancing.trust import Noise, mean_rows, scenario_rows
from vibopt.records import replace


def pose(job: RotorJob, identified: Identified, noise: Noise | None = None, idle: Sequence[int] = ()) -> Posed:
    """The question of a job; rows for the scatter are added where the goal is robust, and `idle` planes get nothing."""
    asked = posed(
        job.planes,
        job.conventions,
        y0=identified.y0,
        H=identified.H,
        importance=job.importance,
        limits=row_limits(job),
        caps=caps(job),
        total_cap=job.total_cap,
        goal=cast(Goal, job.goal.goal),
        huber=job.goal.huber,
        pairs=tuple((first, second, complex(ratio)) for _, first, second, ratio in job.pairs),
        sums=job.sums,
    )
    question = asked.question.without(idle) if len(idle) else asked.question
    question = _robust(job, identified, noise, question)
    return asked if question is asked.question else replace(asked, question=question)


def _robust(job: RotorJob, identified: Identified, noise: Noise | None, question: Question) -> Question:
    if not job.goal.robust or noise is None or not identified.learnt:
        return question
    if job.goal.robust == "mean":
        y0, H, importance = mean_rows(job, identified, noise)
        return question.with_rows(y0, H, importance, np.full(len(y0), inf))
    y0, H = scenario_rows(identified, noise)
    times = len(y0) // question.n_readings
    many = question.with_rows(y0, H, np.tile(question.importance, times), np.tile(question.limits, times))
    return replace(many, goal="worst")


def row_limits(job: RotorJob) -> FloatArray:
    """Least limit on each row [SI peak], inf without one."""
    limits: FloatArray = limits_over(job, np.array([[limit.at_most for limit in job.residual_limits]]))[0]
    return limits


def limits_over(job: RotorJob, bounds: FloatArray) -> FloatArray:
    """The same for many bounds of the limits on what is left (n_values, n_limits), (n_values, n_rows)."""
    limits = np.full((len(bounds), job.n_rows), inf)
    for limit, bound in zip(job.residual_limits, bounds.T, strict=True):
        rows = rows_of(job, limit.sensor, limit.speed)
        limits[:, rows] = np.minimum(limits[:, rows], bound[:, None])
    return limits


def rows_of(job: RotorJob, sensor: int | None, speed: int | None) -> list[int]:
    """Rows at a sensor, with those that are added to it, and a speed, None: at all of them."""
    return [row for row, (v, s) in enumerate(job.readings) if sensor in (None, job.added[s]) and speed in (None, v)]


def caps(job: RotorJob) -> FloatArray:
    """Greatest unbalance of each plane [kg m]."""
    return caps_of(
        job.planes, [(limit.plane, limit.at_most) for limit in job.correction_limits if limit.plane is not None]
    )
