"""Further numbers of a plan by path: coefficients for the next job, trial weights, quality grades, and the trim."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vibopt.answer.entry import Entry, Value, Word, direction
from vibopt.answer.plan import Fitting, PlaneAnswer
from vibopt.arrays import ComplexArray
from vibopt.balancing.fitting import NOTHING, sentence
from vibopt.balancing.grades import earned, permitted
from vibopt.balancing.influence import Identified
from vibopt.balancing.planes import MASS
from vibopt.balancing.rotor_job import RotorJob, Run
from vibopt.balancing.rotor_question import caps
from vibopt.mechanics.constants import GRAVITY
from vibopt.units import to_unit
from vibopt.units.showing import plain, show_angle


def coefficients(job: RotorJob, identified: Identified) -> dict[str, Value]:
    """What a unit weight at zero reads, as text to be pasted under [[influence]], and its angle."""
    found: dict[str, Value] = {}
    several = len(job.speeds) > 1
    for row, (speed, index) in enumerate(job.readings):
        sensor = job.sensors[index]
        for column, plane in enumerate(job.planes):
            H = complex(identified.alone[row, column])
            if H == 0.0:
                continue
            path = f"influence.{sensor.name}.{plane.name}" + (f".{job.show_speed(speed)}" if several else "")
            value = 1.0 / to_unit(1.0, plane.unit, plane.dimension)  # of the user's units [SI]
            size = to_unit(abs(H) * plane.radius * value, sensor.shown_unit, sensor.dimension)
            per = f"({plane.unit})" if " " in plane.unit else plane.unit
            angle = job.conventions.reading_angle(H)
            found[f"{path}.value"] = Word(f"{plain(size, 8)} {sensor.shown_unit}/{per} @ {show_angle(angle, 8)}")
            found[f"{path}.angle"] = direction(angle)
    return found


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
    for family, key, amounts in (
        ("bearings", "permissible", allowed.at_bearings),
        ("planes", "permissible", allowed.at_planes),
        ("planes", "may_show", allowed.to_measure),
    ):
        found |= {
            f"quality.{family}.{name}.{key}": Entry(amount, "unbalance", "g mm") for name, amount in amounts.items()
        }
    left = dict(quality.residual) or _remaining(job, identified, u)
    if left:
        result = earned(quality, left)
        found |= {
            f"quality.bearings.{name}.left": Entry(bearing, "unbalance", "g mm")
            for name, bearing in result.at_bearings.items()
        }
        found["quality.earned"] = Entry(result.grade, "velocity", "mm/s")
        found["quality.met"] = Word("yes" if result.met else "no")
        found["quality.worst_at"] = Word(result.worst_at)
    return found


def _remaining(job: RotorJob, identified: Identified | None, u: ComplexArray | None) -> dict[str, complex]:
    """Unbalance left in the planes; empty where they have no place or radius, or readings do not tell them apart."""
    if identified is None or u is None or job.quality is None:
        return {}
    names = [plane.name for plane in job.planes]
    if not all(plane.name in job.quality.places and (plane.radii or plane.kind != MASS) for plane in job.planes):
        return {}
    if np.linalg.matrix_rank(identified.H / np.linalg.norm(identified.H, axis=0).clip(1e-300), tol=_TOLD) < len(names):
        return {}
    left = np.linalg.lstsq(identified.H, identified.residual(u), rcond=1e-12)[0]
    return {name: complex(one) for name, one in zip(names, left, strict=True)}


_TOLD = 1e-3
"""Least singular value of the effects, each of length one, with which the unbalance left in each plane is known."""


OFF = "Take every trial weight off first: the plan is added to the rotor as found."
ANEW = "Or take every weight off and fit the whole anew, on the rotor as found:"


def todo(job: RotorJob, fitting: Fitting) -> tuple[str, ...]:
    """What to do, one sentence a line: the trim first where a verification run was made."""
    whole = tuple(plane.words for plane in fitting.planes)
    run = verification_run(job.runs)
    if run is None:
        return (OFF, *whole)
    stays = f'The weights of run "{run.name}" stay on. What changes them into the best ones:'
    return (stays, *(_trim(job, run, k, plane) for k, plane in enumerate(fitting.planes)), ANEW, *whole)


def trims(job: RotorJob, fitting: Fitting) -> dict[str, Entry]:
    """The trim of each plane by path, as one weight at its greatest radius."""
    run = verification_run(job.runs)
    if run is None:
        return {}
    found = {}
    for index, (plane, answer) in enumerate(zip(job.planes, fitting.planes, strict=True)):
        if not plane.keep:
            u = _change(run, index, answer)
            found[f"trim.{plane.name}.{plane.dimension}"] = Entry(plane.amount(u), plane.dimension, plane.unit)
            if u:
                angle = job.conventions.weight_angle(-u if plane.remove else u)
                found[f"trim.{plane.name}.angle"] = Entry(angle, "angle", "deg")
    return found


def shows_whole(job: RotorJob) -> bool:
    """Whether weights are on that the plan's whole weights stand instead of."""
    return verification_run(job.runs) is not None


def verification_run(runs: Sequence[Run]) -> Run | None:
    """A run that was made with the correction on; None where there is none."""
    return next((run for run in runs if run.verification), None)


def _change(run: Run, index: int, answer: PlaneAnswer) -> complex:
    """Unbalance to add to what is on [kg m]; zero where it is rounding."""
    on = complex(run.weights[index])
    change = complex(answer.u) - on
    return change if abs(change) > NOTHING * max(abs(on), abs(answer.u)) else 0j


def _trim(job: RotorJob, run: Run, index: int, answer: PlaneAnswer) -> str:
    plane, change = job.planes[index], _change(run, index, answer)
    if change == 0j or plane.keep:
        return f"{plane.name}: leave as it is."
    alone = plane.weight(plane.amount(change), job.conventions.weight_angle(-change if plane.remove else change))
    free = (plane.fitted is None or plane.remove) and not plane.holes and len(plane.radii) < 2
    if free and plane.breaks((alone,)) in ("", "the cap"):
        added = sentence(job, index, change).replace(": fit ", ": add ", 1)
        return f"{added}{_beyond(job, run, index, change)}"
    return f"{plane.name}: take off what is fitted; {answer.words.partition(': ')[2]}"


def _beyond(job: RotorJob, run: Run, index: int, change: complex) -> str:
    """That a trim beside what is on weighs more than the cap, which the whole alone keeps; "" where it does not."""
    plane, on = job.planes[index], complex(run.weights[index])
    cap = caps(job)[index] / plane.radius
    if not plane.amount(on) + plane.amount(change) > cap * (1.0 + NOTHING) or plane.remove:
        return ""
    return (
        f" With the {plane.show(plane.amount(on))} that are on these are more than the cap of {plane.show(cap)}, which "
        "holds for the whole as one weight: fit it anew where the sum counts."
    )
