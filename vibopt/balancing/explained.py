"""What a balancing file asks, in words and numbers, without solving it; and why it has its model and its method."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING, Any

from vibopt.answer.answer import Answer
from vibopt.balancing import is_engine, is_known
from vibopt.errors import counted
from vibopt.units import plain, show

if TYPE_CHECKING:
    from vibopt.balancing.engine.engine_job import EngineJob
    from vibopt.balancing.known.known_job import KnownJob
    from vibopt.balancing.rotor_job import RotorJob

_COMBINED = {"rms": "least squares", "worst": "the worst one", "sum": "their sum", "huber": "Huber"}
_ROBUST = {"": "", "mean": ", mean over the scatter", "worst": ", worst over the scatter"}


def said_by(job: RotorJob | KnownJob | EngineJob) -> dict[str, Any]:
    """Title, counts of what there is, the question ("asked"), what may be chosen, and how values were read."""
    if is_engine(job):
        return _engine(job)
    return _known(job) if is_known(job) else _rotor(job)


def _rotor(job: RotorJob) -> dict[str, Any]:

    counts = {"planes": len(job.planes), "sensors": len(job.sensors), "runs": len(job.runs), "speeds": len(job.speeds)}
    notes = (*(job.conventions.sentences() if job.runs else ()), *job.notes)
    return {
        "title": job.title, **counts, "limits": len(job.every_limit), "expected": len(job.expected),
        "asked": _rotor_goal(job), "choices": {f"planes.{plane.name}": _plane(plane) for plane in job.planes},
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
        most = show(plane.cap * plane.radius, "g mm", "unbalance") if plane.moment else plane.show(plane.cap)
        parts.append(f"up to {most}")
    if plane.holes:
        parts.append(counted(len(plane.holes), "holes"))
    if plane.shelf:
        limited = ", their number limited" if plane.stock else ""
        parts.append(
            f"{counted(len(plane.shelf), 'kinds of weight')} on the shelf{limited}, {plane.most_weights} at most fitted"
        )
    if plane.split:
        parts.append("split between two holes")
    if plane.forbidden:
        parts.append(counted(len(plane.forbidden), "forbidden sectors"))
    return ", ".join(parts) or "any weight, anywhere"


def _known(job: KnownJob) -> dict[str, Any]:
    goal = "an analysis, nothing to choose" if job.goal is None else f"goal: minimise {job.aim.replace('_', ' ')}"
    return {
        "title": job.title, "masses": len(job.masses), "planes": len(job.planes), "bearings": len(job.bearings),
        "limits": len(job.limits), "measures": len(job.measures), "expected": len(job.expected), "asked": goal,
        "choices": {f"planes.{plane.name}": _plane(plane) for plane in job.planes}, "notes": list(job.notes),
    }  # fmt: skip


def _engine(job: EngineJob) -> dict[str, Any]:
    choices = {}
    if job.is_search:
        choices["cranks"] = f"chosen from {counted(len(job.offered), 'angles')}" if job.offered else "chosen"
    for share in job.shares:
        if share.is_free:
            choices[share.name] = " to ".join(show(value, "", "ratio") for value in (share.low, share.high))
    for weight in job.weights:
        if weight.fixed is None:
            cap = f"up to {show(weight.cap, weight.unit, 'unbalance')}" if weight.cap < float("inf") else "any size"
            choices[f"{weight.family}.{weight.name}"] = f"{cap}, any angle"
    order = f" of order {job.goal.order}" if job.goal is not None and job.goal.order else ""
    goal = f"goal: minimise {job.aim.replace('_', ' ')}{order}" if job.aim else "an analysis, nothing to choose"
    return {
        "title": job.title, "cylinders": len(job.cylinders), "weights": len(job.weights), "limits": len(job.limits),
        "measures": len(job.measures), "expected": len(job.expected), "asked": goal, "choices": choices, "notes": [],
    }  # fmt: skip


Model = tuple[tuple[str, str], ...]
Methods = tuple[tuple[str, bool, str], ...]
GIVEN, CIRCLES, CLOSED, CONE, TREE = (
    "measured", "circles of weights", "closed form", "convex program", "branch and bound",
)  # fmt: skip


def of_rotor(job: RotorJob, answer: Answer[Any]) -> tuple[Model, Methods]:
    """What is known of a measured rotor, and the methods in the order in which they are asked."""
    if not job.runs:
        return (("rotor", "rigid, by the lever rule"),), ((GIVEN, True, "a grade is looked up, nothing is fitted"),)
    rows, free = job.n_rows, [plane for plane in job.planes if plane.is_open]
    weighed = any(run.weights.any() for run in job.runs)
    source = (
        "from the runs" if not job.influence else f"ready{', refined by runs with weights in their planes' * weighed}"
    )
    model = [
        ("rotor", "linear at each speed by itself: what is left is what was read plus what each weight does"),
        ("readings", f"{rows}: " + _counts(sensors=len(job.sensors), speeds=len(job.speeds), runs=len(job.runs))),
        ("coefficients", f"{source}; condition number of the planes {plain(answer.plan.condition, 3)}"),
    ]
    if not job.choices:
        return tuple(model), ((GIVEN, True, "nothing to choose: the weights are as they are given"),)
    if not job.has_phase:
        return tuple(model), ((CIRCLES, True, "the readings have no angle: each run leaves a circle of weights"),)
    asked = []
    if why := _not_closed(job):
        asked.append((CLOSED, False, f"takes {why}"))
        listed = [plane.name for plane in free if plane.is_discrete]
        if listed:
            asked.append((CONE, False, f"weights go in steps in {', '.join(listed)}"))
            asked.append((TREE, True, "all fillings of all planes jointly, with bounds"))
        else:
            asked.append((CONE, True, "weights of any size and angle: convex, so its best is the best"))
    else:
        asked.append((CLOSED, True, "least squares of free weights without limits"))
    return tuple(model), tuple(asked)


def _not_closed(job: RotorJob) -> str:
    """What the closed form does not take; "" where it takes the job."""
    free = [plane for plane in job.planes if not plane.keep]
    limits = [limit.name for limit in job.every_limit]
    reasons = (
        (any(plane.is_discrete for plane in free), "no holes with weights of a shelf"),
        (any(plane.split for plane in free), "no holes"),
        (bool(limits), f"no limits ({', '.join(limits)})"),
        (any(isfinite(plane.cap) for plane in free), "caps only where they do not bind"),
        (any(plane.forbidden for plane in free), "no forbidden sectors"),
        (job.goal.goal != "rms" or bool(job.goal.robust), "least squares alone as the goal"),
    )
    return next((words for holds, words in reasons if holds), "")


def _counts(**many: int) -> str:
    return ", ".join(counted(count, what) for what, count in many.items())


def of_known(job: KnownJob, answer: Answer[Any]) -> tuple[Model, Methods]:
    """What is known of a shaft with known masses, and how its weights are found."""
    model = (
        ("shaft", "rigid: forces and couples of masses that turn, as vectors" + (" in one plane" if job.flat else "")),
        ("masses", f"{len(job.masses)} known, " + _counts(planes=len(job.planes), bearings=len(job.bearings))),
    )
    ways = {
        "none": (GIVEN, "nothing to choose: the shaft as it is given"),
        "vector sum": ("vector sums", "as many planes as it takes: one correction balances completely"),
        "least mass": ("least mass", "more planes than it takes: of all complete balances the lightest, convex"),
        "program": (CONE, "caps, lists, limits or the goal stand in the way of vector sums"),
    }
    name, why = ways[answer.method]
    before = (("vector sums", False, "caps, lists, limits or the goal stand in the way"),) if name == CONE else ()
    tree = any(plane.is_discrete and plane.is_open for plane in job.planes)
    last = (TREE, True, "all fillings of all planes jointly, with bounds") if tree else (name, True, why)
    return model, (*before, last)


def of_engine(job: EngineJob, answer: Answer[Any]) -> tuple[Model, Methods]:
    """What is known of an engine, and how what is free is found."""
    series = "two orders, as in textbooks" if job.truncated else f"exact slider-crank, {counted(job.orders, 'orders')}"
    model = (
        ("engine", f"{counted(len(job.cylinders), 'cylinders')}, {series}"),
        ("forces", "linear in shares and unbalances, order by order; the turn in time is the second route"),
    )
    ways = {
        "none": (GIVEN, "nothing to choose: the engine as it is"),
        "program": (CONE, "shares and weights of given cranks: convex, so its best is the best"),
        "phasing": (
            "every setting of the cranks",
            "cranks are chosen: every class that differs is looked at",
        ),
    }
    name, why = ways[answer.method]
    return model, ((name, True, why),)
