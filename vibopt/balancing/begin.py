"""What all plans of a measured rotor have in common: frame, goal, limits and prices; or that nothing can be fitted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import tau
from typing import Any

import numpy as np

from vibopt.answer.answer import Answer
from vibopt.answer.entry import Checked, Entry, Value
from vibopt.answer.plan import DeferredMapping, DeferredRows, Fitting, Plan
from vibopt.arrays import ComplexArray
from vibopt.balancing.cautions import cancelling, last_one, remedies, unsure, warning, ways_out, with_bands
from vibopt.balancing.fitting import amplitude, not_permitted
from vibopt.balancing.grades import permitted
from vibopt.balancing.influence import Identified
from vibopt.balancing.optimisers import Solver, solve_question
from vibopt.balancing.plan_values import coefficients, quality_values, todo, trial_advice, trims
from vibopt.balancing.plane_options import Posed, decided_of
from vibopt.balancing.question import Question, Solved
from vibopt.balancing.rotor_job import RotorJob
from vibopt.balancing.rotor_limits import impasse, limits_at, rates_of
from vibopt.balancing.rotor_question import pose
from vibopt.balancing.trust import Noise, conditioning
from vibopt.errors import counted
from vibopt.records import replace
from vibopt.units import show
from vibopt.units.showing import show_angle

UNJUDGED = (
    "Whether the grade is met is not known: that needs one plan, a place of every plane under [quality], a radius of "
    "each, and sensors that tell the planes apart."
)

_MEAN = "root mean square of the residuals"
_GOALS = {"rms": _MEAN, "worst": "worst residual", "sum": "sum of the residuals", "huber": f"{_MEAN} by Huber's rule"}
GIVEN = "nothing is chosen: the weights are as they are given"
_ROUNDING = 1e-12
"""Part of the greatest reading below which a goal is zero."""


def begun(job: RotorJob, *, identified: Identified | None = None, **more: Any) -> Answer[RotorJob]:
    """A plan with what every plan of the job says; coefficients of an `identified` rotor are written when looked at."""
    values: Mapping[str, Value] = {**trial_advice(job), **quality_values(job, None, None), **more.pop("values", {})}
    unjudged = job.quality is not None and bool(more.get("fittings")) and "quality.earned" not in values
    notes = (*job.notes, *_swallowed(job), *((UNJUDGED,) if unjudged else ()), *more.pop("notes", ()))
    if identified is not None and job.has_phase:
        rotor = identified
        values = DeferredMapping(values, 2 * int(np.count_nonzero(rotor.alone)), lambda: coefficients(job, rotor))
    own = {name: more.pop(name) for name in Plan.__match_args__ if name in more}
    plan = Plan(conventions=job.conventions.sentences(bool(job.runs)), **own)
    return Answer(job=job, values=values, notes=notes, plan=plan, **more)


def _swallowed(job: RotorJob) -> tuple[str, ...]:
    """That a measurement error leaves nothing to measure, and the way out."""
    found = permitted(job.quality) if job.quality is not None else None
    if found is None or job.quality is None or not found.swallowed:
        return ()
    error, least = (show(value, "g mm", "unbalance") for value in (
        job.quality.measurement_error, min(found.at_planes[name] for name in found.swallowed)))  # fmt: skip
    planes = f"plane{'s' * (len(found.swallowed) > 1)} {' and '.join(found.swallowed)} may keep"
    return (
        f"The measurement error of {error} is no less than what {planes} ({least}): no measurement can show that the "
        f"grade is met. Measure more exactly, or ask for a coarser grade.",
    )


def goal_of(job: RotorJob, question: Question, u: ComplexArray, n_rows: int = 0) -> tuple[str, Entry]:
    """Name and value of the goal, as the sensors read; of a robust one over the scatter.

    n_rows
        Readings of the nominal rotor, where the question has rows for the scatter behind them.
    """
    value = question.value(u)
    robust = job.goal.robust if n_rows and question.n_readings > n_rows else ""
    if question.goal == "correction":
        return "correction", Entry(value, job.planes[job.free[0]].dimension, job.planes[job.free[0]].unit)
    weighed = " times importance" if (job.importance != 1.0).any() else ""
    if robust == "mean":
        value *= float(np.sqrt(question.n_readings / n_rows))
    rotors = question.n_readings // max(n_rows, 1)
    over = {"mean": ", over the scatter", "worst": f" of {counted(rotors, 'rotors')} within the scatter", "": ""}[
        robust
    ]
    if value < _ROUNDING * float((question.importance * np.abs(question.y0)).max(initial=0.0)):
        value = 0.0
    return _GOALS[question.goal] + weighed + over, amplitude(job, 0, question.amount(value))


def answered(job: RotorJob, posed: Posed, solver: Solver = solve_question) -> Solved:
    """The correction that is best, or the one that is decided in every plane."""
    if job.choices:
        return solver(posed.question)
    chosen = tuple(-1 if option is None else 0 for option in posed.question.options)
    return Solved(decided_of(posed.question.options), "met", GIVEN, chosen=chosen)


def kept_or_broken(limits: Mapping[str, Checked]) -> tuple[str, str]:
    """Status and claim of weights that are decided."""
    broken = [name for name, limit in limits.items() if not limit.met]
    return ("violated", f"limits that do not hold: {', '.join(broken)}") if broken else ("met", GIVEN)


def method_of(job: RotorJob, question: Question, identified: Identified) -> str:
    """How the plan came about, in words."""
    spare = sum(max(learnt.spare, 0) for learnt in identified.learnt)
    fit = "influence coefficients" + (f", least squares over {counted(spare, 'spare runs')}" if spare else "")
    kind = "holes and weights jointly" if question.is_discrete else "free weights"
    kind = kind if job.choices else "weights as given"
    rotors = question.n_readings // max(job.n_rows, 1)
    robust = {
        "worst": f", worst of {counted(rotors, 'rotors')} within the scatter",
        "mean": ", mean over the scatter",
        "": "",
    }
    return f"{fit}; {kind}{robust[job.goal.robust]}"


def nothing(
    job: RotorJob, identified: Identified, posed: Posed, solved: Solved, *, thorough: bool = False
) -> Answer[RotorJob]:
    """No correction: which limits stand in the way."""
    infeasible = solved.status == "infeasible"
    conflict, reason = impasse(job, posed, solved, thorough=thorough) if infeasible else (None, "")
    return begun(
        job, status=solved.status, claim=solved.claim, reason=reason, conflict=conflict,
        details=dict(solved.details),
        method=method_of(job, posed.question, identified),
        identified=identified,
    )  # fmt: skip


def plan_of(
    job: RotorJob, identified: Identified, posed: Posed, solved: Solved, fitting: Fitting, noise: Noise | None,
    notes: tuple[str, ...], idle: Sequence[int] = (),
) -> Answer[RotorJob]:  # fmt: skip
    """The plan of one answer with its limits and prices, or why its weights are not to be fitted."""
    u = solved.u
    assert u is not None
    nominal_only = not (job.goal.robust or idle)
    plain = posed if nominal_only else pose(replace(job, goal=replace(job.goal, robust="")), identified)
    nominal = plain.question
    goal = goal_of(job, posed.chosen_only(solved.chosen).question, u, job.n_rows)
    found = conditioning(nominal, job.free)
    said = warning(job, found) if job.choices else ""
    ways = remedies(job, plain, identified, noise, found, u) if found.near and job.choices else ()
    if refused := cancelling(job, nominal, identified, noise, found, u) if job.choices else "":
        return begun(
            job, status="unproven", claim=refused, words=ways_out(job, found), condition=found.number, remedies=ways,
            identified=identified, notes=(said, *notes),
            method=method_of(job, posed.question, identified), details=dict(solved.details),
        )  # fmt: skip
    limits = with_bands(job, limits_at(job, plain.chosen_only(solved.chosen), u), fitting)
    status, claim = (solved.status, solved.claim) if job.choices else kept_or_broken(limits)
    return begun(
        job, status=status, claim=claim, goal=goal, fittings=(fitting,), limits=limits,
        rates=rates_of(job, posed, solved),
        words=DeferredRows(None, lambda: todo(job, fitting)), gap=solved.gap, condition=found.number,
        remedies=ways,
        values={**quality_values(job, identified, u), **trims(job, fitting)},
        identified=identified,
        notes=(
            *((said, *last_one(ways)) if said else ()), *_reach_notes(job), *unsure(limits),
            *notes,
        ),
        method=method_of(job, posed.question, identified), details=dict(solved.details),
    )  # fmt: skip


def as_told(plan: Answer[RotorJob]) -> Answer[RotorJob]:
    """The plan, if its weights as they are told keep every limit and every rule of their planes."""
    over = [name for name, limit in plan.limits.items() if not limit.met]
    over += not_permitted(plan.job.planes, plan.plan.fittings[0].planes)
    if not over or plan.status not in ("optimal", "feasible"):
        return plan
    return replace(plan, status="check_failed", claim=f"what the weights do not keep: {', '.join(over)}")


def _reach_notes(job: RotorJob) -> tuple[str, ...]:
    """Planes whose holes leave directions in which no split weight acts."""
    return tuple(
        f"Plane {plane.name} has no holes from {show_angle(low)} to {show_angle(high % tau)}, half a turn or more: no "
        f"two weights together act in between. The plan is the best that its holes allow; a hole in this gap would let "
        f"it go there."
        for plane in job.planes
        if not plane.keep
        for low, high in plane.out_of_reach
    )
