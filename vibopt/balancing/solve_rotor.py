"""Solving a measured rotor: identify, ask the optimiser, turn the answer into weights, and put them back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import tau

import numpy as np

from vibopt.answer.answer import Answer
from vibopt.answer.entry import Checked
from vibopt.answer.plan import DeferredMapping, DeferredRows, Fitting, RowAnswer
from vibopt.balancing.agreement import idle_words, without_insensitive
from vibopt.balancing.begin import answered, begun, goal_of, kept_or_broken, method_of, nothing
from vibopt.balancing.cautions import cancelling, last_one, remedies, unsure, warning, ways_out, with_bands
from vibopt.balancing.contradictions import Heard, beside, heard, held_bands, judged
from vibopt.balancing.conventions import show_angle
from vibopt.balancing.fitting import amplitude, fitting_of, plan_text
from vibopt.balancing.influence import Identified
from vibopt.balancing.limit_prices import limit_answers
from vibopt.balancing.nearest import left_words, nearest_plan
from vibopt.balancing.phaseless import solve_without_phase
from vibopt.balancing.plan_values import coefficients, quality_values, todo, trial_advice, trims
from vibopt.balancing.question import Solved
from vibopt.balancing.question_prices import Solver, solve_question
from vibopt.balancing.rotor_job import RotorJob
from vibopt.balancing.rotor_question import Posed, caps, pose
from vibopt.balancing.trust import Noise, conditioning
from vibopt.balancing.verification import simulated

AGREES = 1e-6
_ROUNDING = 1e-12


def solve_job(job: RotorJob, *, thorough: bool = False, solver: Solver = solve_question) -> Answer[RotorJob]:
    """The plan for a measured rotor; `thorough` computes every price, whatever the work, `solver` answers its question.

    Every answer has been put back into a simulated rotor by another route (`vibopt.balancing.verification`); one that
    the simulation refuses has the status "check_failed".
    """
    if not job.runs:
        return _quality_only(job)
    if job.is_advice:
        return _advice(job)
    return _with_phase(job, thorough, solver) if job.has_phase else solve_without_phase(job, thorough=thorough)


def asked_of(job: RotorJob) -> tuple[Heard, Identified, tuple[int, ...], Posed]:
    """The rotor by the runs that agree, the planes that no sensor feels, and the question."""
    of = heard(job)
    identified, idle = without_insensitive(of.job, of.identified, of.noise)
    return of, identified, idle, pose(of.job, identified, of.noise, idle)


def _with_phase(job: RotorJob, thorough: bool, solver: Solver) -> Answer[RotorJob]:
    of, identified, idle, posed = asked_of(job)
    job, noise = of.job, of.noise
    solved = answered(job, posed, solver)
    if solved.u is None:
        none = nothing(job, identified, posed, solved, thorough=thorough)
        if job.residual_limits:
            near = nearest_plan(job, identified, posed, solved, thorough=thorough)
            none = replace(none, nearest=near, notes=(*none.notes, *left_words(near)))
        return judged(of, _unless_felt(of, idle, none, solver))
    fitting = _fitting(of, identified, posed, solved)
    plan = _plan(job, identified, posed, solved, fitting, noise, thorough)
    plan = replace(plan, notes=(*plan.notes, *idle_words(job, idle)))
    plan = judged(of, plan.with_plan(beside=beside(of, solved.u)))
    return _certified(plan, identified) if plan.plan.fittings else plan


def _unless_felt(of: Heard, idle: tuple[int, ...], none: Answer[RotorJob], solver: Solver) -> Answer[RotorJob]:
    """No answer, or an open one: planes that are within the scatter get no weight, but may well act."""
    if none.status != "infeasible" or not idle:
        return none
    identified, still = without_insensitive(of.job, of.identified, None)  # what is rounding alone
    notes = (*none.notes, *idle_words(of.job, idle))
    if still == idle or answered(of.job, pose(of.job, identified, of.noise, still), solver).u is None:
        return replace(none, notes=notes)
    names = " and ".join(of.job.planes[one].name for one in idle if one not in still)
    claim = f"without weights in {names}, which act within the scatter of the readings, the limits cannot be kept"
    return replace(none, status="unproven", claim=claim, reason="", conflict=None, notes=notes)


def _fitting(of: Heard, identified: Identified, posed: Posed, solved: Solved) -> Fitting:
    u = solved.u
    assert u is not None
    return fitting_of(of.job, identified, u, posed.chosen_only(solved.chosen).options, held_bands(of, u))


def _plan(
    job: RotorJob, identified: Identified, posed: Posed, solved: Solved, fitting: Fitting, noise: Noise | None,
    thorough: bool,
) -> Answer[RotorJob]:  # fmt: skip
    u = solved.u
    assert u is not None
    nominal_only = not job.goal.robust and np.array_equal(posed.question.caps, caps(job))
    plain = posed if nominal_only else pose(replace(job, goal=replace(job.goal, robust="")), identified)
    nominal = plain.question
    goal = goal_of(job, posed.chosen_only(solved.chosen).question, u, len(job.readings))
    found = conditioning(nominal, job.free)
    said = warning(job, found) if job.choices else ""
    ways = remedies(job, plain, identified, noise, found, u) if found.near and job.choices else ()
    if refused := cancelling(job, nominal, identified, noise, found, u) if job.choices else "":
        return begun(
            job, status="unproven", claim=refused, words=ways_out(job, found), condition=found.number, remedies=ways,
            later=lambda: coefficients(job, identified), notes=(said, *_noise_notes(job, noise)),
            method=method_of(job, posed.question, identified), details=dict(solved.details),
        )  # fmt: skip
    priced = limit_answers(job, plain, solved, goal[1], posed, thorough=thorough)
    limits = with_bands(job, priced.limits, fitting)
    shown = DeferredMapping(replace(priced, limits=limits).with_words)
    status, claim = (solved.status, solved.claim) if job.choices else kept_or_broken(limits)
    return begun(
        job, status=status, claim=claim, goal=goal, fittings=(_priced(job, fitting, shown),),
        limits=shown,
        words=todo(job, fitting), gap=solved.gap, condition=found.number,
        remedies=ways,
        values={**quality_values(job, identified, u), **trims(job, fitting)},
        later=lambda: coefficients(job, identified),
        notes=(
            *((said, *last_one(ways)) if said else ()), *_reach_notes(job), *unsure(limits),
            *_noise_notes(job, noise), *priced.notes,
        ),
        prices=DeferredMapping(priced.caps),
        method=method_of(job, posed.question, identified), details=dict(solved.details),
    )  # fmt: skip


def _priced(job: RotorJob, fitting: Fitting, limits: Mapping[str, Checked]) -> Fitting:
    """Rows with the price of the limit that bounds them."""

    def rows() -> Sequence[RowAnswer]:
        own = [limits[one.name] for one in reversed(job.residual_limits)]
        prices = {one.place: one.price.words if one.price is not None else "" for one in own}
        found = [replace(row, price=prices.get(job.row_name(k), "")) for k, row in enumerate(fitting.rows)]
        return found if any(prices.values()) else fitting.rows

    return replace(fitting, rows=DeferredRows(len(fitting.rows), rows))


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


def _noise_notes(job: RotorJob, noise: Noise | None) -> tuple[str, ...]:
    if noise is None:
        return (
            'The scatter of the readings is not known, so the plan has no band. Add scatter = { amplitude = "5 %", '
            'angle = "2 deg" }.',
        )
    none = [job.show_speed(speed) for speed, spare in enumerate(noise.spare) if not spare > 0.0]
    said = f"Bands hold 95 % of what the scatter of the readings allows ({noise.source})."
    return (said, *((f"At {', '.join(none)} there is none: no run is spare there.",) if none else ()))


def _certified(plan: Answer[RotorJob], identified: Identified) -> Answer[RotorJob]:
    """The plan, if the simulated rotor shows what it says."""
    job, fitting = plan.job, plan.plan.fittings[0]
    shown = simulated(job, plan_text(job, fitting))
    said, u = np.abs(fitting.left), np.array([one.u for one in fitting.planes])
    scale = np.abs(identified.y0) + np.abs(identified.H) @ np.abs(u)
    off = float((np.abs(shown - said) / np.maximum(scale, 1e-300)).max())
    details = {**plan.details, "put_back": {"greatest_difference": off}}
    if off <= AGREES:
        return replace(
            plan,
            details=details,
            claim=f"{plan.claim}; put back into a simulated rotor, which shows the same {_within(off)}",
        )
    row = int(np.argmax(np.abs(shown - said)))
    text = (
        f"the simulated rotor shows {amplitude(job, row, float(shown[row])).short(6)} at {job.row_name(row)}, the "
        f"plan says {fitting.rows[row].residual.short(6)}"
    )
    return replace(plan, status="check_failed", claim=text, details=details)


def _within(off: float) -> str:
    """How well two routes agree; what rounding alone decides has no digits."""
    return f"to {off:.0e}" if off > _ROUNDING else "up to rounding"


def _advice(job: RotorJob) -> Answer[RotorJob]:
    """As found only: how large a first trial may be."""
    words = tuple(
        f"{name.split('.')[1]}: a first trial of at most {entry.shown}."
        for name, entry in trial_advice(job).items()
        if name.endswith(".trial")
    )
    return begun(
        job,
        status="unproven",
        claim="no trial run yet: what a weight does is not known",
        words=words,
        reason="Make one run a plane with a trial weight.",
    )


def _quality_only(job: RotorJob) -> Answer[RotorJob]:
    """A grade without a balancing job."""
    values = quality_values(job, None, None)
    word = values.get("quality.met")
    status = "met" if word is None or word.shown == "yes" else "violated"
    claim = (
        "permissible residual unbalance from the grade"
        if word is None
        else f"the grade asked for is {'' if status == 'met' else 'not '}earned"
    )
    return begun(job, status=status, claim=claim, values=values, method="lever rule")
