"""From the optimiser's numbers to weights: which mass, where, in which hole, and the sentence that says so."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from math import tau

import numpy as np

from vibopt.answer.entry import Entry
from vibopt.answer.plan import DeferredRows, Fitting, PlaneAnswer, RowAnswer, Weight
from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.conventions import Conventions
from vibopt.balancing.influence import Identified
from vibopt.balancing.plane_options import missing
from vibopt.balancing.planes import MASS, Plane, hole_name, text_of
from vibopt.balancing.question import Options, felt, left_over, together
from vibopt.balancing.rotor_job import RotorJob
from vibopt.balancing.rotor_question import row_limits
from vibopt.balancing.verification import simulated
from vibopt.units import show
from vibopt.units.showing import show_angle

_OWN = ("a", "an", "my", "our", "your", "its", "this", "that", "where", "zero")
_OVER = 1e-6
"""Part of a cap by which rounding of solver and digits may pass it."""
NOTHING = 1e-9
"""Corrections below this part of the greatest unbalance that matters are none."""


def fitting_of(
    job: RotorJob,
    identified: Identified,
    u: ComplexArray,
    options: Sequence[Options | None],
    band: FloatArray | None = None,
) -> Fitting:
    """The correction u as weights, and what is left with it."""
    tiny = NOTHING * max(felt(identified.y0, identified.H), float(np.abs(u).max(initial=0.0)))
    planes = fitted_planes(job.planes, job.conventions, u, options, tiny)
    left = left_over(identified.y0, identified.H, u)
    return Fitting(planes, DeferredRows(len(left), lambda: _rows(job, identified, left, band)), left)


def fitted_planes(
    planes: Sequence[Plane], spoken: Conventions, u: ComplexArray, options: Sequence[Options | None], tiny: float = 0.0
) -> tuple[PlaneAnswer, ...]:
    """What is done in each plane for the correction u (n_planes,); unbalances up to `tiny` [kg m] are none."""
    return tuple(_plane(p, spoken, complex(z), option, tiny) for p, z, option in zip(planes, u, options, strict=True))


def _plane(plane: Plane, spoken: Conventions, u: complex, options: Options | None, tiny: float) -> PlaneAnswer:
    weights = _weights(spoken, plane, u, options) if abs(u) > tiny else ()
    action = "keep" if plane.keep else "nothing" if not weights else "remove" if plane.remove else "add"
    if len(weights) == 1:
        amount, angle, radius = weights[0].mass, weights[0].angle % tau, weights[0].radius
    else:
        angle = spoken.weight_angle(-u if plane.remove else u) if weights else 0.0
        amount = sum((one.mass for one in weights), 0.0) if plane.kind == MASS else plane.amount(u) * bool(weights)
        radius = plane.radius if plane.kind == MASS and plane.radii else None
    return PlaneAnswer(
        plane.name, action, u if weights else 0.0, Entry(amount, plane.dimension, plane.unit),
        angle,
        None if radius is None else Entry(radius, "length", plane.length_unit), weights,
        partial(_words, spoken, plane, action, weights),
        Entry(plane.amount(u), "mass", plane.unit) if len(weights) > 1 and plane.kind == MASS else None,
    )  # fmt: skip


def not_permitted(planes: Sequence[Plane], fitted: Sequence[PlaneAnswer]) -> list[str]:
    """The rules of planes, and the stock, that weights break as they are told."""
    size = max((weight.mass for answer in fitted for weight in answer.weights), default=0.0)
    told = [(plane, plane.breaks(own.weights, _OVER, size)) for plane, own in zip(planes, fitted, strict=True)]
    short = missing(planes, [own.weights for own in fitted])
    return [*(f"{rule} of {plane.name}" for plane, rule in told if rule), *(f"the stock of {one}" for one in short)]


def weight_text(job: RotorJob, plane: int, u: complex) -> str:
    """A correction as one weight, briefly: "left 10.76 g @ 326.6 deg", "left no weight"."""
    own = job.planes[plane]
    if u == 0.0:
        return f"{own.name} no weight"
    angle = job.conventions.weight_angle(-u if own.remove else u)
    return f"{own.name} {own.show(own.amount(u))} @ {show_angle(angle)}"


def _weights(spoken: Conventions, plane: Plane, u: complex, options: Options | None) -> tuple[Weight, ...]:
    if plane.fitted is not None:
        return plane.fitted
    if options is not None:
        return tuple(plane.in_hole(*weight) for weight in options.weights(options.nearest(u)))
    size, angle = plane.amount(u), spoken.weight_angle(-u if plane.remove else u)
    return plane.cut(size, angle) if plane.split else (plane.weight(size, angle),)


def sentence(job: RotorJob, index: int, u: complex) -> str:
    """What to do for an unbalance u in a plane, whatever it is decided to hold, for the shop floor."""
    plane = replace(job.planes[index], fitted=None)
    action = "remove" if plane.remove else "add"
    return _words(job.conventions, plane, action, _weights(job.conventions, plane, u, None))


def _words(spoken: Conventions, plane: Plane, action: str, weights: Sequence[Weight]) -> str:
    """The sentence for the shop floor."""
    if action == "keep":
        return f"{plane.name}: leave untouched."
    if action == "nothing":
        return f"{plane.name}: no weight."
    verb = "take away" if plane.remove else "fit"
    parts = [_one(spoken, plane, weight) for weight in weights]
    counted = _counted(spoken)
    parts[:-1] = [part.replace(counted, "") for part in parts[:-1]]  # said once is enough
    return f"{plane.name}: {verb} {' and '.join(parts)}."


def _one(spoken: Conventions, plane: Plane, weight: Weight) -> str:
    said = plane.show(weight.mass)
    if weight.radius is not None:
        said += f" at radius {show(weight.radius, plane.length_unit, 'length')}"
    if weight.hole is not None:
        said += f" in {hole_name(plane, weight.hole)}{_counted(spoken)}"
    else:
        said += f", {show_angle(weight.angle)}{_counted(spoken)}"
    if weight.depth is not None and plane.drill is not None:
        wide, deep = show(plane.drill.diameter, "mm", "length"), show(weight.depth, "mm", "length", digits=3)
        said += f" (hole of {wide}, {deep} deep)"
    return said


def _counted(spoken: Conventions) -> str:
    """How angles are counted, behind one."""
    return f" {spoken.angles} from {_zero(spoken)}" if spoken.zero else " from zero"


def _zero(spoken: Conventions) -> str:
    """The zero mark behind "from": "the reflective tape", but "blade 1" and "my mark" as they are written."""
    zero = spoken.zero
    first, last = zero.split()[0].lower(), zero.split()[-1]
    if first == "the":
        return f"the {zero[4:].lstrip()}"
    named = any(one.isdigit() for one in last) or (len(last) == 1 and last.isupper())
    return zero if named or first in _OWN else f"the {zero}"


def _rows(job: RotorJob, identified: Identified, left: ComplexArray, band: FloatArray | None) -> list[RowAnswer]:
    limits, greatest = row_limits(job), greatest_readings(job)
    alone = together(np.ones(job.n_rows), job.sums) < 1.5  # what is added up has no limit of its own
    rows = []
    for row, (speed, index) in enumerate(job.readings):
        sensor = job.sensors[index]
        rows.append(
            RowAnswer(
                sensor=sensor.name,
                speed=Entry(job.speeds[speed], "angular_rate", job.speed_units[speed], digits=6),
                found=amplitude(job, row, float(abs(job.as_found[row]))),
                residual=amplitude(job, row, float(abs(left[row]))),
                found_phasor=sensor.show_phasor(complex(job.as_found[row]), job.conventions),
                fitted_phasor=_fitted(job, identified, row),
                residual_phasor=sensor.show_phasor(complex(left[row]), job.conventions),
                y0=complex(identified.y0[row]),
                left=complex(left[row]),
                band=None
                if band is None or np.isnan(band[row]).any()
                else (amplitude(job, row, float(band[row, 0])), amplitude(job, row, float(band[row, 1]))),
                limit=amplitude(job, row, float(limits[row])) if alone[row] and np.isfinite(limits[row]) else None,
                greatest=greatest[sensor.dimension],
            )
        )
    return rows


def _fitted(job: RotorJob, identified: Identified, row: int) -> str:
    """What the fit takes for the rotor as found; "" where that is what was read."""
    read, fit = complex(job.as_found[row]), complex(identified.y0[row])
    if abs(fit - read) <= 1e-9 * abs(read) or not job.has_phase:
        return ""
    return job.sensors[job.readings[row][1]].show_phasor(fit, job.conventions)


def greatest_readings(job: RotorJob) -> dict[str, float]:
    """Greatest amplitude of the rotor as found [SI peak], by what sensors measure."""
    read = np.abs(job.as_found)
    kinds = [sensor.dimension for sensor in job.sensors]
    of_sensor = read.reshape(-1, len(kinds)).max(axis=0).tolist()
    return {kind: max(one for one, own in zip(of_sensor, kinds, strict=True) if own == kind) for kind in set(kinds)}


def amplitude(job: RotorJob, row: int, value: float) -> Entry:
    """A peak amplitude of a row as its sensor's readings are written."""
    sensor = job.sensors[row % len(job.sensors)]
    return Entry(value, sensor.dimension, sensor.shown_unit)


def put_back(job: RotorJob, identified: Identified, fitting: Fitting) -> tuple[FloatArray, FloatArray]:
    """What a simulated rotor shows with the plan per row [SI peak], and how far off that is, over the readings."""
    shown = simulated(job, plan_text(job, fitting))
    scale = np.abs(identified.y0) + np.abs(identified.H) @ np.abs([plane.u for plane in fitting.planes])
    return shown, np.abs(shown - np.abs(fitting.left)) / np.maximum(scale, 1e-300)


def plan_text(job: RotorJob, fitting: Fitting) -> tuple[tuple[int, str, bool], ...]:
    """The plan as the user would write it down, with all digits."""
    pairs = enumerate(zip(job.planes, fitting.planes, strict=True))
    return tuple((k, text_of(one, plane), plane.remove) for k, (plane, answer) in pairs for one in answer.weights)
