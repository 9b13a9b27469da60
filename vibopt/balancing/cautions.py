"""What a plan must say about itself before anybody bolts it: weights that only cancel, limits that hold by luck."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from vibopt.answer.entry import Checked
from vibopt.answer.plan import Fitting
from vibopt.balancing.fitting import weight_text
from vibopt.balancing.influence import Identified
from vibopt.balancing.job import RotorJob
from vibopt.balancing.pose import rows_of
from vibopt.balancing.question import Question
from vibopt.balancing.trust import Conditioning, Noise, bands
from vibopt.forms import ComplexArray, FloatArray
from vibopt.units import plain

READING = 0.01
"""Part of an amplitude to which no reading in the field is better known; used where the scatter is not given."""


def cancelling(
    job: RotorJob, question: Question, identified: Identified, noise: Noise | None, found: Conditioning, u: ComplexArray
) -> str:
    """Why nobody should fit the correction u, in words; "" where nothing speaks against it.

    Planes that act almost alike leave one direction of u to the errors of the readings: weights that act against each
    other, as heavy as the readings happen to ask.  The correction is refused where those errors, carried by u, leave as
    much vibration as there is without any weight (root mean square over the readings): then balancing promises nothing.
    With the scatter given that is judged by the upper ends of the 95 % bands.  Without it an error of 1 % is taken
    in what each weight does, so it takes weights that together do a hundred times what is found; a condition number
    below 30 never counts.  Caps, a total, the least mass as the goal, lists and robust goals bound the masses
    themselves: such answers are as the user asked, and are shown with the warning only.
    """
    alike = list(found.alike)
    bounded = question.is_discrete or question.goal == "correction" or bool(job.goal.robust)
    capped = bool(np.isfinite(question.caps[alike]).any()) or bool(np.isfinite(question.total_cap))
    if not alike or bounded or capped:
        return ""
    left = _may_be_left(job, identified, noise, u)
    now, then = (float(np.linalg.norm(job.importance * one)) for one in (np.abs(identified.y0), left))
    if then < now or now == 0.0:
        return ""
    weights = " and ".join(weight_text(job, plane, complex(u[plane])) for plane in alike)
    error = "the scatter given" if job.scatter is not None else f"an error of {100 * READING:g} % in the readings"
    times = f"{plain(then / now, 2)} times" if then > 1.05 * now else "all of"
    return (
        f"the weights of the best fit cancel each other ({weights}), and {error} can leave {times} the vibration as "
        f"found: nothing of this is to be fitted"
    )


def _may_be_left(job: RotorJob, identified: Identified, noise: Noise | None, u: ComplexArray) -> FloatArray:
    """Amplitude that the errors of the readings allow after u, per row [SI peak]."""
    felt: FloatArray = READING * (np.abs(identified.H) @ np.abs(u))
    if noise is None or not identified.learnt:
        return felt
    ends = bands(job, identified, noise, u)[:, 1]
    return ends if job.scatter is not None else np.asarray(np.fmax(ends, felt))


def ways_out(job: RotorJob, found: Conditioning) -> tuple[str, ...]:
    """What to write in the file for each of the ways round."""
    names = [job.planes[plane].name for plane in found.alike]
    tables = " or ".join(f"[planes.{name}]" for name in names)
    return (
        "Fit no weight yet. Choose one of the ways round below, write it into the file and solve again:",
        f"leave a plane out: keep = true in {tables}, the one that is harder to reach;",
        f'or cap the weights: weight = {{ from = "0 g", to = ... }} in {tables};',
        'or penalise the mass: robust = "mean" in [goal], with scatter; '
        'or minimise = "correction" under limits on the residual.',
    )


def with_bands(job: RotorJob, limits: Mapping[str, Checked], fitting: Fitting) -> dict[str, Checked]:
    """Limits on the residual with the highest upper end of their bands."""
    found = dict(limits)
    for limit in job.residual_limits:
        rows = [fitting.rows[row] for row in rows_of(job, limit.sensor, limit.speed)]
        ends = [row.band for row in rows if row.band is not None]
        if ends and limit.name in found:
            low, high = (replace(one, unit=limit.unit) for one in max(ends, key=lambda band: band[1].value))
            found[limit.name] = replace(found[limit.name], band=(low, high))
    return found


def unsure(limits: Mapping[str, Checked]) -> tuple[str, ...]:
    """Limits that hold for the prediction only."""
    return tuple(
        f"Limit {name} holds for the prediction, not for the upper end of its 95 % band ({one.band[1].shown})."
        for name, one in limits.items()
        if one.met and one.met_by_band is False and one.band is not None
    )
