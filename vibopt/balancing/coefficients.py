"""Influence coefficients as a file of their own: saved by one job, read as `influence` by the next."""

from __future__ import annotations

from math import degrees
from typing import Any

from vibopt.balancing.contradictions import heard
from vibopt.balancing.conventions import CHOICES
from vibopt.balancing.planes import MASS
from vibopt.balancing.rotor_job import RotorJob
from vibopt.errors import InputError
from vibopt.units import to_unit


def coefficients_document(job: RotorJob) -> dict[str, Any]:
    """What a unit weight in each plane reads at each sensor and speed, with the conventions of the job.

    Raises
    ------
    InputError
        The job has no coefficients: readings without phase, or no run with weights.
    """
    if not job.has_phase:
        raise InputError(
            f"{job.name}: readings without phase tell no influence coefficient: its angle is not known. "
            "Leave --save-coefficients out."
        )
    if not job.runs or job.is_advice:
        raise InputError(f"{job.name}: no run has weights, so no influence coefficient is known. Add a trial run.")
    of = heard(job)
    speeds = [
        f"{to_unit(one, unit, 'angular_rate'):.15g} {unit}"
        for one, unit in zip(job.speeds, job.speed_units, strict=True)
    ]
    rows = [
        {
            "speed": speeds[speed],
            "sensor": job.sensors[sensor].name,
            "plane": plane.name,
            "value": _text(job, complex(of.identified.H[row, column]), sensor, column),
        }
        for row, (speed, sensor) in enumerate(job.readings)
        for column, plane in enumerate(job.planes)
        if not plane.keep or of.identified.H[row, column]
    ]
    said = {key: getattr(job.conventions, key) for key in (*CHOICES, "zero") if getattr(job.conventions, key)}
    return {"title": f"Influence coefficients of {job.title}", "conventions": said, "influence": rows}


def _text(job: RotorJob, H: complex, sensor: int, column: int) -> str:
    """A coefficient with all digits, per unbalance where the plane has a radius: so it holds at any radius."""
    plane, reads = job.planes[column], job.sensors[sensor]
    per = "g mm" if plane.radii or plane.kind != MASS else "g"
    size = abs(H) * (1.0 / to_unit(1.0, per, "unbalance" if per == "g mm" else "mass"))
    amount = to_unit(size, reads.shown_unit, reads.dimension)
    angle = degrees(job.conventions.reading_angle(H)) if H else 0.0
    return f"{amount:.15g} {reads.shown_unit}/({per}) @ {angle:.15g} deg"
