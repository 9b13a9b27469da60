"""Where designs end along one number of a machine: the design that misses its worst limit least is followed there."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.bracketing import crossing
from vibopt.errors import InputError
from vibopt.jobs import is_scene, with_changes
from vibopt.program.pose import pose
from vibopt.scene.open_places import open_places, open_positions
from vibopt.scene.uncertain import uncertain
from vibopt.solve.ranges import closed

if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import TypeGuard

    from vibopt.jobs import Job
    from vibopt.scene.scene import Scene
    from vibopt.values.fact_at import FactAt

_CLOSE = 1e-7


def follows(job: Job) -> TypeGuard[Scene]:
    """Whether the variables of a job are numbers from ranges, of one machine: slopes lead from design to design."""
    return (
        is_scene(job)
        and bool(job.variables and job.limits)
        and all(variable.values is None for variable in job.variables)
        and not (open_places(job) or open_positions(job) or uncertain(job))
    )


def brink(
    job: Scene, fact: FactAt, value: Callable[[float], float], ends: tuple[float, float], x: Sequence[float]
) -> tuple[float, FloatArray]:
    """Where designs end between two places t, the first with the design `x` (n_vars,), the second without one.

    Parameters
    ----------
    job, fact, value
        What is asked, the number that moves, and its value [SI] at a place t.

    Returns
    -------
    float, FloatArray
        The place at which the least by which the worst limit is missed goes through zero, and the last design before
        it; nan where slopes do not lead there.  A guess: what is on either side is to be answered.
    """
    design = np.array(x, dtype=float)

    @cache
    def missed(t: float) -> float:
        nonlocal design
        program = closed(pose(with_changes(job, fact.changes(value(t)))))
        if program.ties or len(program.axes) != len(design):
            return math.nan
        from vibopt.solve.least_missed import slid

        there, least = slid(replace(program, aim=None), design)
        design = there if least <= 0.0 else design
        return least

    try:
        if missed(ends[0]) < 0.0 < missed(ends[1]):
            return crossing(missed, *ends, least=_CLOSE)[0], design
    except InputError:
        pass
    return math.nan, design
