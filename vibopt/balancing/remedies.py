"""Planes that act almost alike: the ways round, solved side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vibopt.answer.entry import Entry
from vibopt.answer.plan import Remedy
from vibopt.balancing.fitting import amplitude, weight_text
from vibopt.balancing.influence import Identified
from vibopt.balancing.job import RotorJob
from vibopt.balancing.pose import Posed, without_plane
from vibopt.balancing.prices import solve_question
from vibopt.balancing.question import Question, first_greatest
from vibopt.balancing.trust import ALIKE, Conditioning, Noise, bands
from vibopt.forms import ComplexArray
from vibopt.units import show

LEFT_OUT = " left out"


def warning(job: RotorJob, found: Conditioning) -> str:
    """The sentence that names the planes; "" where all are told apart."""
    if not found.near:
        return ""
    names = _and([job.planes[index].name for index in found.near])
    if not found.alike:
        return (
            f"Planes {names} act nearly alike: condition number {found.number:.2g}; errors of the readings come out "
            f"as weights that partly cancel. Compare with one of them left out."
        )
    number = "infinite" if np.isinf(found.number) else f"{found.number:.1e}".replace("e+0", "e").replace("e+", "e")
    return f"Planes {names} act almost alike: condition number {number}; one can be left out, or the mass penalised."


def remedies(
    job: RotorJob, posed: Posed, identified: Identified, noise: Noise | None, found: Conditioning, u: ComplexArray
) -> tuple[Remedy, ...]:
    """As asked, each alike plane left out, the mass penalised, and caps from the plane left out."""
    question = posed.question
    tried: list[tuple[str, ComplexArray | None]] = [("as asked", u)]
    for plane in found.near:
        tried.append((f"{job.planes[plane].name}{LEFT_OUT}", solve_question(without_plane(question, [plane])).u))
    single = [one for _, one in tried[1:] if one is not None]
    if found.alike and not question.is_discrete and question.goal != "correction":
        tried.append(("mass penalised", solve_question(penalised(question, job.free)).u))
        if single:
            largest = min(float(np.abs(one).max()) for one in single)
            capped = replace(question, caps=np.minimum(question.caps, largest))
            tried.append((f"caps of {_cap_text(job, found.alike[0], largest)}", solve_question(capped).u))
    return tuple(remedy_of(job, name, one, identified, noise) for name, one in tried if one is not None)


def last_one(ways: Sequence[Remedy]) -> tuple[str, ...]:
    """What the last of the planes buys, in words: the best plan without one of them against the plan as asked."""
    fewer = [one for one in ways if one.name.endswith(LEFT_OUT)]
    if not fewer:
        return ()
    best = min(fewer, key=lambda one: float(one.worst.value))
    name = best.name.removesuffix(LEFT_OUT)
    now, then = (show(float(one.worst.value), one.worst.unit, one.worst.dimension) for one in (ways[0], best))
    if not float(best.worst.value) > float(ways[0].worst.value):
        return (f"Plane {name} buys nothing: without it the worst left is {then}.",)
    return (f"What plane {name} buys: {now} instead of {then} at the worst sensor ({', '.join(best.masses)}).",)


def penalised(question: Question, free: Sequence[int]) -> Question:
    """Least squares with the corrections as further rows, weighted so that the condition number comes down to ALIKE."""
    A = question.importance[:, None] * question.H[:, list(free)]
    weight = np.linalg.svd(A, compute_uv=False)[0] / ALIKE
    extra = np.zeros((len(free), question.n_planes), dtype=complex)
    extra[np.arange(len(free)), list(free)] = weight
    return replace(
        question,
        y0=np.concatenate([question.y0, np.zeros(len(free))]),
        H=np.concatenate([question.H, extra]),
        importance=np.concatenate([question.importance, np.ones(len(free))]),
        limits=np.concatenate([question.limits, np.full(len(free), np.inf)]),
        goal="rms",
    )


def remedy_of(job: RotorJob, name: str, u: ComplexArray, identified: Identified, noise: Noise | None) -> Remedy:
    """A plan beside the others: what it would leave by these runs."""
    left = np.abs(identified.residual(u))
    weight = np.ones(len(left)) if len({one.dimension for one in job.sensors}) == 1 else job.importance
    row = first_greatest(weight * left)
    masses = tuple(weight_text(job, plane, complex(one)) for plane, one in enumerate(u))
    band = ""
    if noise is not None and identified.learnt:
        ends = bands(job, identified, noise, u)
        worst = int(np.argmax(np.nan_to_num(weight * ends[:, 1], nan=-1.0)))
        band = (
            ""
            if np.isnan(ends[worst, 1])
            else (
                f"{amplitude(job, worst, float(ends[worst, 0])).shown} to "
                f"{amplitude(job, worst, float(ends[worst, 1])).shown} at {job.row_name(worst)}"
            )
        )
    rms = float(np.sqrt(np.mean((weight * left) ** 2)))
    return Remedy(name, amplitude(job, row, float(left[row])), _goal_entry(job, rms), masses, band)


def _goal_entry(job: RotorJob, value: float) -> Entry:
    return amplitude(job, 0, value)


def _cap_text(job: RotorJob, plane: int, u: float) -> str:
    return job.planes[plane].show(job.planes[plane].amount(u), 3)


def _and(names: Sequence[str]) -> str:
    return f"{', '.join(names[:-1])} and {names[-1]}"
