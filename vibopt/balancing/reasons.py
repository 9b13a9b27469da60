"""Why a balancing job has its model and its method, in words."""

from __future__ import annotations

from math import isfinite
from typing import Any

from vibopt.answer.answer import Answer
from vibopt.balancing.engine.job import EngineJob
from vibopt.balancing.job import RotorJob
from vibopt.balancing.known.job import KnownJob
from vibopt.units import plain

Model = tuple[tuple[str, str], ...]
Methods = tuple[tuple[str, bool, str], ...]
GIVEN, CIRCLES, CLOSED, CONE, TREE = (
    "measured", "circles of weights", "closed form", "convex program", "branch and bound",
)  # fmt: skip


def of_rotor(job: RotorJob, found: Answer[Any]) -> tuple[Model, Methods]:
    """What is known of a measured rotor, and the methods in the order in which they are asked."""
    if not job.runs:
        return (("rotor", "rigid, by the lever rule"),), ((GIVEN, True, "a grade is looked up, nothing is fitted"),)
    rows, free = len(job.readings), [plane for plane in job.planes if plane.is_open]
    source = "from the runs" if not job.influence else "ready, refined by runs with weights in their planes"
    model = [
        ("rotor", "linear at each speed by itself: what is left is what was read plus what each weight does"),
        ("readings", f"{rows}: " + _counts(sensor=len(job.sensors), speed=len(job.speeds), run=len(job.runs))),
        ("coefficients", f"{source}; condition number of the planes {plain(found.plan.condition, 3)}"),
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
    limits = [*(one.name for one in job.residual_limits), *(one.name for one in job.correction_limits)]
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
    return ", ".join(f"{count} {what}{'s' * (count != 1)}" for what, count in many.items())


def of_known(job: KnownJob, found: Answer[Any]) -> tuple[Model, Methods]:
    """What is known of a shaft with known masses, and how its weights are found."""
    model = (
        ("shaft", "rigid: forces and couples of masses that turn, as vectors" + (" in one plane" if job.flat else "")),
        ("masses", f"{len(job.masses)} known, " + _counts(plane=len(job.spots), bearing=len(job.bearings))),
    )
    ways = {
        "none": (GIVEN, "nothing to choose: the shaft as it is given"),
        "vector sum": ("vector sums", "as many planes as it takes: one correction balances completely"),
        "least mass": ("least mass", "more planes than it takes: of all complete balances the lightest, convex"),
        "program": (CONE, "caps, lists, limits or the goal stand in the way of vector sums"),
    }
    name, why = ways[found.method]
    before = (("vector sums", False, "caps, lists, limits or the goal stand in the way"),) if name == CONE else ()
    tree = any(spot.plane.is_discrete and spot.plane.is_open for spot in job.spots)
    last = (TREE, True, "all fillings of all planes jointly, with bounds") if tree else (name, True, why)
    return model, (*before, last)


def of_engine(job: EngineJob, found: Answer[Any]) -> tuple[Model, Methods]:
    """What is known of an engine, and how what is free is found."""
    series = "two orders, as in textbooks" if job.truncated else f"exact slider-crank, {job.orders} orders"
    model = (
        ("engine", _counts(cylinder=len(job.cylinders)) + f", {series}"),
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
    name, why = ways[found.method]
    return model, ((name, True, why),)
