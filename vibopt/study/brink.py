"""Where designs end along one number of a machine: the design that misses its worst limit least is followed there."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray
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

_LOOKS = 14
_CLOSE = 1e-8


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
        The place at which the least by which the worst limit is missed goes through zero, by false position, and the
        last design before it; nan where slopes do not lead there.  A guess: what is on either side is to be answered.
    """
    from vibopt.study.nearest import slid  # with what proves over tolerances, for few

    design = np.array(x, dtype=float)

    def missed(t: float) -> float:
        nonlocal design
        program = closed(pose(with_changes(job, fact.changes(value(t)))))
        if program.ties or len(program.axes) != len(design):
            return math.nan
        there, least = slid(replace(program, aim=None), design)
        design = there if least <= 0.0 else design
        return least

    try:
        return _zero(missed, *ends), design
    except InputError:
        return math.nan, design


def _zero(height: Callable[[float], float], good: float, bad: float) -> float:
    """Where a function comes up through zero between two places (Illinois rule); nan where it does not."""
    below, above, side = height(good), height(bad), 0
    if not below < 0.0 < above:
        return math.nan
    for _ in range(_LOOKS):
        t = good - below * (bad - good) / (above - below)
        here = height(t)
        if not math.isfinite(here):
            return math.nan
        if abs(here) <= _CLOSE or abs(bad - good) <= _CLOSE:
            return t
        if here < 0.0:
            above *= 0.5 if side < 0 else 1.0
            good, below, side = t, here, -1
        else:
            below *= 0.5 if side > 0 else 1.0
            bad, above, side = t, here, 1
    return t
