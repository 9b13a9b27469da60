"""Further numbers of a plan by path: influence coefficients for the next job, trial weights, quality grades."""

from __future__ import annotations

import numpy as np

from vibopt.answer.entry import Entry, Value, Word, direction
from vibopt.balancing.grades import earned, permitted
from vibopt.balancing.influence import Identified
from vibopt.balancing.job import RotorJob
from vibopt.balancing.planes import MASS
from vibopt.balancing.words import show_angle
from vibopt.forms import ComplexArray
from vibopt.mechanics.constants import GRAVITY
from vibopt.units import to_unit
from vibopt.units.showing import plain


def coefficients(job: RotorJob, identified: Identified) -> dict[str, Value]:
    """What a unit weight at zero reads, as text to be pasted under [[influence]], and its angle."""
    found: dict[str, Value] = {}
    several = len(job.speeds) > 1
    for row, (speed, index) in enumerate(job.readings):
        sensor = job.sensors[index]
        for column, plane in enumerate(job.planes):
            H = complex(identified.H[row, column])
            if H == 0.0:
                continue
            path = f"influence.{sensor.name}.{plane.name}" + (f".{job.show_speed(speed)}" if several else "")
            size = to_unit(
                abs(H) * plane.radius * _per(plane.unit, plane.dimension), sensor.shown_unit, sensor.dimension
            )
            per = f"({plane.unit})" if " " in plane.unit else plane.unit
            angle = job.conventions.reading_angle(H)
            found[f"{path}.value"] = Word(f"{plain(size, 8)} {sensor.shown_unit}/{per} @ {show_angle(angle, 8)}")
            found[f"{path}.angle"] = direction(angle)
    return found


def _per(unit: str, dimension: str) -> float:
    """SI value of one of the user's units."""
    return 1.0 / to_unit(1.0, unit, dimension)


def trial_advice(job: RotorJob) -> dict[str, Value]:
    """Greatest first trial per plane: its force at the highest speed is `trial_force` of its share of the weight."""
    if job.rotor_mass is None or not job.speeds:
        return {}
    u = job.trial_force * job.rotor_mass * GRAVITY / max(job.speeds) ** 2 / max(len(job.free), 1)
    found: dict[str, Value] = {}
    for index in job.free:
        plane = job.planes[index]
        if plane.kind == MASS and plane.radii:
            found[f"planes_first.{plane.name}.trial"] = Entry(u / plane.radius, "mass", plane.unit)
        else:
            found[f"planes_first.{plane.name}.trial"] = Entry(u, "unbalance", "g mm")
    return found


def quality_values(job: RotorJob, identified: Identified | None, u: ComplexArray | None) -> dict[str, Value]:
    """Permissible residual unbalances, what is left, and the grade it earns."""
    quality = job.quality
    if quality is None:
        return {}
    allowed = permitted(quality)
    found: dict[str, Value] = {
        "quality.permissible": Entry(allowed.whole, "unbalance", "g mm"),
        "quality.eccentricity": Entry(allowed.eccentricity, "length", "µm"),
        "quality.kind": Word("outboard" if allowed.outboard else "inboard"),
    }
    found.update(
        {
            f"quality.bearings.{name}.permissible": Entry(one, "unbalance", "g mm")
            for name, one in allowed.at_bearings.items()
        }
    )
    found.update(
        {
            f"quality.planes.{name}.permissible": Entry(one, "unbalance", "g mm")
            for name, one in allowed.at_planes.items()
        }
    )
    found.update(
        {f"quality.planes.{name}.may_show": Entry(one, "unbalance", "g mm") for name, one in allowed.to_measure.items()}
    )
    left = dict(quality.residual) or _remaining(job, identified, u)
    if left:
        result = earned(quality, left)
        found.update(
            {
                f"quality.bearings.{name}.left": Entry(one, "unbalance", "g mm")
                for name, one in result.at_bearings.items()
            }
        )
        found["quality.earned"] = Entry(result.grade, "velocity", "mm/s")
        found["quality.met"] = Word("yes" if result.met else "no")
        found["quality.worst_at"] = Word(result.worst_at)
    return found


def _remaining(job: RotorJob, identified: Identified | None, u: ComplexArray | None) -> dict[str, complex]:
    """Unbalance left in the planes; empty where they have no place or radius, or readings do not tell them apart."""
    if identified is None or u is None or job.quality is None:
        return {}
    places = dict(job.quality.planes) or dict(job.quality.bearings)
    names = [plane.name for plane in job.planes]
    if not all(plane.name in places and (plane.radii or plane.kind != MASS) for plane in job.planes):
        return {}
    if np.linalg.matrix_rank(identified.H / np.linalg.norm(identified.H, axis=0).clip(1e-300), tol=_TOLD) < len(names):
        return {}
    left = np.linalg.lstsq(identified.H, identified.residual(u), rcond=1e-12)[0]
    return {name: complex(one) for name, one in zip(names, left, strict=True)}


_TOLD = 1e-3
"""Least singular value of the effects, each of length one, with which the unbalance left in each plane is known."""

__all__ = ["coefficients", "quality_values", "trial_advice"]
