"""What a balancing file asks, in words and numbers, without solving it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vibopt.balancing.kinds import is_engine, is_known
from vibopt.units import show

if TYPE_CHECKING:
    from vibopt.balancing.engine.job import EngineJob
    from vibopt.balancing.job import RotorJob
    from vibopt.balancing.known.job import KnownJob

_COMBINED = {"rms": "least squares", "worst": "the worst one", "sum": "their sum", "huber": "Huber"}
_ROBUST = {"": "", "mean": ", mean over the scatter", "worst": ", worst over the scatter"}


def said_by(job: RotorJob | KnownJob | EngineJob) -> dict[str, Any]:
    """Title, counts of what there is, the question ("asked"), what may be chosen, and how values were read."""
    if is_engine(job):
        return _engine(job)
    return _known(job) if is_known(job) else _rotor(job)


def _rotor(job: RotorJob) -> dict[str, Any]:
    limits = len(job.residual_limits) + len(job.correction_limits)
    counts = {"planes": len(job.planes), "sensors": len(job.sensors), "runs": len(job.runs), "speeds": len(job.speeds)}
    notes = (*(job.conventions.sentences() if job.runs else ()), *job.notes)
    return {
        "title": job.title, **counts, "limits": limits, "expected": len(job.expected),
        "asked": _rotor_goal(job), "choices": {f"planes.{one.name}": _plane(one) for one in job.planes},
        "notes": list(notes),
    }  # fmt: skip


def _rotor_goal(job: RotorJob) -> str:
    if not job.runs:
        return "a quality grade, nothing to choose"
    if job.is_advice:
        return "the first trial weights"
    if job.goal.goal == "correction":
        return "goal: minimise correction under the limits"
    return f"goal: minimise residual ({_COMBINED[job.goal.goal]}{_ROBUST[job.goal.robust]})"


def _plane(plane: Any) -> str:
    """What may be done in a plane: "at 150 mm, up to 60 g, 24 holes, 3 weights on the shelf"."""
    if plane.keep:
        return "stays untouched"
    parts = ["material is taken away"] if plane.remove else []
    if plane.radii:
        parts.append("at " + " or ".join(show(one, plane.length_unit, "length") for one in plane.radii))
    if plane.cap < float("inf"):
        parts.append(f"up to {plane.show(plane.cap)}")
    if plane.holes:
        parts.append(f"{len(plane.holes)} holes")
    if plane.shelf:
        kinds = len(plane.shelf)
        counted = ", their number limited" if plane.stock else ""
        parts.append(
            f"{kinds} kind{'s' * (kinds != 1)} of weight on the shelf{counted}, {plane.most_weights} at most fitted"
        )
    if plane.split:
        parts.append("split between two holes")
    if plane.forbidden:
        parts.append(f"{len(plane.forbidden)} forbidden sector{'s' * (len(plane.forbidden) != 1)}")
    return ", ".join(parts) or "any weight, anywhere"


def _known(job: KnownJob) -> dict[str, Any]:
    goal = (
        "an analysis, nothing to choose"
        if job.goal is None
        else f"goal: minimise {job.goal.minimise.replace('_', ' ')}"
    )
    return {
        "title": job.title, "masses": len(job.masses), "planes": len(job.spots), "bearings": len(job.bearings),
        "limits": len(job.limits), "measures": len(job.measures), "expected": len(job.expected), "asked": goal,
        "choices": {f"planes.{one.plane.name}": _plane(one.plane) for one in job.spots}, "notes": list(job.notes),
    }  # fmt: skip


def _engine(job: EngineJob) -> dict[str, Any]:
    choices = {}
    if job.is_search:
        choices["cranks"] = f"chosen from {len(job.offered)} angles" if job.offered else "chosen"
    for share in job.shares:
        if share.is_free:
            choices[share.name] = " to ".join(show(one, "", "ratio") for one in (share.low, share.high))
    for one in job.weights:
        if one.fixed is None:
            cap = f"up to {show(one.cap, one.unit, 'unbalance')}" if one.cap < float("inf") else "any size"
            choices[f"{one.family}.{one.name}"] = f"{cap}, any angle"
    if job.goal is None:
        goal = "an analysis, nothing to choose"
    else:
        order = f" of order {job.goal.order}" if job.goal.order else ""
        goal = f"goal: minimise {job.goal.minimise.replace('_', ' ')}{order}"
    return {
        "title": job.title, "cylinders": len(job.cylinders), "weights": len(job.weights), "limits": len(job.limits),
        "measures": len(job.measures), "expected": len(job.expected), "asked": goal, "choices": choices, "notes": [],
    }  # fmt: skip
