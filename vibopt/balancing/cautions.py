"""What a plan must say about itself before anybody bolts it: planes that act alike, weights that only cancel, luck."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from vibopt.answer.entry import Checked, Entry
from vibopt.answer.plan import Fitting, Remedy
from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.fitting import amplitude, greatest_readings, weight_text
from vibopt.balancing.influence import Identified
from vibopt.balancing.optimisers import solve_question
from vibopt.balancing.plane_options import Posed
from vibopt.balancing.question import Question, first_greatest
from vibopt.balancing.rotor_job import RotorJob
from vibopt.balancing.rotor_question import rows_of
from vibopt.balancing.trust import ALIKE, Conditioning, Noise, bands
from vibopt.units import plain, show

LEFT_OUT = " left out"
_LARGE = 1e4
"""Condition number from which it is told by its power of ten."""


def warning(job: RotorJob, conditioning: Conditioning) -> str:
    """The sentence that names the planes; "" where all are told apart."""
    if not conditioning.near:
        return ""
    *first, last = [job.planes[index].name for index in conditioning.near]
    names = f"{', '.join(first)} and {last}"
    if not conditioning.alike:
        return (
            f"Planes {names} act nearly alike: condition number {conditioning.number:.2g}; errors of the readings "
            "come out "
            f"as weights that partly cancel. Compare with one of them left out."
        )
    number = conditioning.number
    large = f"{number:.1e}".replace("e+0", "e").replace("e+", "e")
    said = "infinite" if np.isinf(number) else large if number > _LARGE else plain(number, 2)
    return f"Planes {names} act almost alike: condition number {said}; one can be left out, or the mass penalised."


def remedies(
    job: RotorJob,
    posed: Posed,
    identified: Identified,
    noise: Noise | None,
    conditioning: Conditioning,
    u: ComplexArray,
) -> tuple[Remedy, ...]:
    """As asked, each alike plane left out, the mass penalised, and caps from the plane left out."""
    question = posed.question
    tried: list[tuple[str, ComplexArray | None]] = [("as asked", u)]
    tried += [(f"{job.planes[k].name}{LEFT_OUT}", solve_question(question.without([k])).u) for k in conditioning.near]
    single = [one for _, one in tried[1:] if one is not None]
    if conditioning.alike and not question.is_discrete and question.goal != "correction":
        tried.append(("mass penalised", solve_question(penalised(question, job.free)).u))
        if single:
            largest = min(float(np.abs(one).max()) for one in single)
            capped = replace(question, caps=np.minimum(question.caps, largest))
            plane = job.planes[conditioning.alike[0]]
            tried.append((f"caps of {plane.show(plane.amount(largest), 3)}", solve_question(capped).u))
    return tuple(remedy_of(job, name, one, identified, noise) for name, one in tried if one is not None)


def last_one(ways: Sequence[Remedy]) -> tuple[str, ...]:
    """What the last of the planes buys, in words: the best plan without one of them against the plan as asked."""
    fewer = [way for way in ways if way.name.endswith(LEFT_OUT)]
    if not fewer:
        return ()
    best = min(fewer, key=lambda remedy: remedy.part)
    name = best.name.removesuffix(LEFT_OUT)
    now, then = (
        show(float(remedy.worst.value), remedy.worst.unit, remedy.worst.dimension) for remedy in (ways[0], best)
    )
    if not best.part > ways[0].part:
        return (f"Plane {name} buys nothing: without it the worst left is {then}.",)
    return (f"What plane {name} buys: {now} instead of {then} at the worst sensor ({', '.join(best.masses)}).",)


def penalised(question: Question, free: Sequence[int]) -> Question:
    """Least squares with the corrections as further rows, weighted so that the condition number comes down to ALIKE."""
    A = question.importance[:, None] * question.H[:, list(free)]
    weight = np.linalg.svd(A, compute_uv=False)[0] / ALIKE
    extra = np.zeros((len(free), question.n_planes), dtype=complex)
    extra[np.arange(len(free)), list(free)] = weight
    n = len(free)
    return replace(question.with_rows(np.zeros(n, dtype=complex), extra, np.ones(n), np.full(n, np.inf)), goal="rms")


def remedy_of(job: RotorJob, name: str, u: ComplexArray, identified: Identified, noise: Noise | None) -> Remedy:
    """A plan beside the others: what it would leave by these runs; several kinds are weighed by their readings."""
    left, greatest = np.abs(identified.residual(u)), greatest_readings(job)
    of_kind = np.array([greatest[job.sensors[sensor].dimension] for _, sensor in job.readings])
    mixed = len(greatest) > 1
    weight = 1.0 / np.where(of_kind > 0.0, of_kind, 1.0) if mixed else np.ones(len(left))
    row = first_greatest(weight * left)
    masses = tuple(weight_text(job, plane, complex(one)) for plane, one in enumerate(u))
    band = ""
    if noise is not None and identified.learnt:
        ends = bands(job, identified, noise, u)
        worst = int(np.argmax(np.nan_to_num(weight * ends[:, 1], nan=-1.0)))
        low, high = (amplitude(job, worst, float(end)).shown for end in ends[worst])
        band = "" if np.isnan(ends[worst, 1]) else f"{low} to {high} at {job.row_name(worst)}"
    rms = float(np.sqrt(np.mean((weight * left) ** 2)))
    shown = Entry(rms, "ratio", "%") if mixed else amplitude(job, 0, rms)
    part = float((weight * left).max())
    return Remedy(name, amplitude(job, row, float(left[row])), shown, masses, band, part)


READING = 0.01
"""Part of an amplitude to which no reading in the field is better known; used where the scatter is not given."""


def cancelling(
    job: RotorJob,
    question: Question,
    identified: Identified,
    noise: Noise | None,
    conditioning: Conditioning,
    u: ComplexArray,
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
    alike = list(conditioning.alike)
    if not alike:
        return ""
    bounded = question.is_discrete or question.goal == "correction" or bool(job.goal.robust)
    capped = bool(np.isfinite(question.caps[alike]).any()) or bool(np.isfinite(question.total_cap))
    if bounded or capped:
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


def ways_out(job: RotorJob, conditioning: Conditioning) -> tuple[str, ...]:
    """What to write in the file for each of the ways round."""
    names = [job.planes[plane].name for plane in conditioning.alike]
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
            low, high = (replace(entry, unit=limit.unit) for entry in max(ends, key=lambda band: band[1].value))
            found[limit.name] = replace(found[limit.name], band=(low, high))
    return found


def unsure(limits: Mapping[str, Checked]) -> tuple[str, ...]:
    """Limits that hold for the prediction only."""
    return tuple(
        f"Limit {name} holds for the prediction, not for the upper end of its 95 % band ({limit.band[1].shown})."
        for name, limit in limits.items()
        if limit.met and limit.met_by_band is False and limit.band is not None
    )
