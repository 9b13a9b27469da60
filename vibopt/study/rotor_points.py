"""A measured rotor at many values of a bound: its plans as columns of a sweep."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from vibopt.answer.entry import Entry, direction
from vibopt.arrays import FloatArray
from vibopt.balancing import is_rotor
from vibopt.balancing.fitting import amplitude
from vibopt.balancing.over_bounds import Plans, plans_over
from vibopt.balancing.rotor_job import RotorJob
from vibopt.errors import InputError
from vibopt.solve.closed_program import NotClosedError
from vibopt.study.points import Columns, Words
from vibopt.study.together import law, places

if TYPE_CHECKING:
    from vibopt.jobs import Job


def columns(job: RotorJob, at: Callable[[FloatArray], Job], values: FloatArray) -> Columns | None:
    """Plans at all values (n_points, n_facts) [SI]; None where they are not answered together.

    `at` gives the job with its facts at some values (n_facts,).
    """
    if np.any(np.ptp(values, axis=0) <= 0.0):
        return None
    where = places(values)

    def followed(numbers: Sequence[float]) -> FloatArray | None:
        try:
            return np.broadcast_to(law(where, list(numbers))[0](values), (len(values),))
        except NotClosedError:
            return None

    try:
        jobs = [at(one) for one in where]
    except InputError:
        return None
    plans = plans_over([one for one in jobs if is_rotor(one)], followed)
    if plans is None:
        return None
    names = [*(f"planes.{plane.name}.{plane.kind_word}" for plane in job.planes), *plans.margins]

    def held(index: int) -> set[str]:
        return {names[k] for k in np.flatnonzero(plans.pulls[index])}

    return Columns(plans.status, np.zeros((0, len(values))), plans.goal, plans.margins, _words(job, plans), held)


def _words(job: RotorJob, plans: Plans) -> Words:
    """The goal, the weights and what is left at each sensor, in the user's units."""

    def words(index: int) -> tuple[Entry, dict[str, Entry], dict[str, Entry]]:
        chosen: dict[str, Entry] = {}
        for k, plane in enumerate(job.planes):
            mass = Entry(float(plans.masses[index, k]), plane.dimension, plane.unit)
            chosen[f"planes.{plane.name}.{plane.dimension}"] = mass
            if mass.value:
                chosen[f"planes.{plane.name}.angle"] = direction(float(plans.angles[index, k]))
        left = {
            f"sensors.{sensor.name}.residual": amplitude(job, column, float(plans.left[index, column]))
            for column, sensor in enumerate(job.sensors)
        }
        return amplitude(job, 0, float(plans.goal[index])), chosen, left

    return words
