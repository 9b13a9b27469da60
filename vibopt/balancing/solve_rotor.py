"""Solving a measured rotor: identify, ask the optimiser, turn the answer into weights, and put them back."""

from __future__ import annotations

import numpy as np

from vibopt.answer.answer import Answer
from vibopt.balancing.agreement import idle_words, without_insensitive
from vibopt.balancing.begin import answered, as_told, begun, nothing, plan_of
from vibopt.balancing.chance_plan import planned
from vibopt.balancing.chances import Rotors
from vibopt.balancing.contradictions import Heard, beside, heard, held_bands, judged
from vibopt.balancing.fitting import amplitude, fitting_of, put_back
from vibopt.balancing.impasses import with_nearest
from vibopt.balancing.influence import Identified
from vibopt.balancing.optimisers import Solver, solve_question
from vibopt.balancing.phaseless import solve_without_phase
from vibopt.balancing.plan_values import quality_values, trial_advice
from vibopt.balancing.plane_options import Posed
from vibopt.balancing.rotor_job import RotorJob
from vibopt.balancing.rotor_limits import AGREES, nearest_plan
from vibopt.balancing.rotor_question import pose
from vibopt.balancing.trust import Noise
from vibopt.records import replace

_ROUNDING = 1e-12


def solve_job(job: RotorJob, *, thorough: bool = False, solver: Solver = solve_question) -> Answer[RotorJob]:
    """The plan for a measured rotor; `thorough` says what clashes whatever the work, `solver` answers its question.

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
    solved = first = answered(job, posed, solver)
    rotors = Rotors(job, identified, noise) if noise is not None and job.asks_shares else None
    if rotors is not None and job.choices and first.u is not None:
        solved = planned(rotors, posed.question, first, solver)
    if solved.u is None:
        none = nothing(job, identified, posed, solved, thorough=thorough)
        if job.residual_limits:
            told = rotors.rows_told if rotors is not None else None
            none = with_nearest(none, nearest_plan(job, identified, posed, solved, told, thorough=thorough))
        return judged(of, _unless_felt(of, idle, none, solver))
    options, bands = posed.question.chosen_only(solved.chosen).options, held_bands(of, solved.u)
    fitting = fitting_of(job, identified, solved.u, options, bands)
    notes = (*_noise_notes(job, noise), *idle_words(job, idle), *_together_notes(job, identified))
    plan = plan_of(job, identified, posed, solved, fitting, noise, notes, idle)
    if rotors is not None and plan.plan.fittings:
        plan = rotors.with_odds(plan, posed.question, first)
    others = beside(of, solved.u)
    plan = judged(of, plan.with_plan(beside=others) if others else plan)
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


def _noise_notes(job: RotorJob, noise: Noise | None) -> tuple[str, ...]:
    if noise is None:
        return (
            'The scatter of the readings is not known, so the plan has no band. Add scatter = { amplitude = "5 %", '
            'angle = "2 deg" }.',
        )
    none = [job.show_speed(speed) for speed, spare in enumerate(noise.spare) if not spare > 0.0]
    said = f"Bands hold 95 % of what the scatter of the readings allows ({noise.source})."
    return (said, *((f"At {', '.join(none)} there is none: no run is spare there.",) if none else ()))


def _together_notes(job: RotorJob, identified: Identified) -> tuple[str, ...]:
    """Planes of which no coefficient is told, because no run tells what a weight there does alone."""
    lost = (identified.alone != identified.H).any(axis=0).tolist()
    names = " and ".join(plane.name for plane, one in zip(job.planes, lost, strict=True) if one)
    return (f"What weights in {names} do is known as they were fitted together, not of each alone.",) if names else ()


def _certified(plan: Answer[RotorJob], identified: Identified) -> Answer[RotorJob]:
    """The plan, if it keeps what it must, and the simulated rotor shows what it says."""
    plan = as_told(plan)
    if plan.status == "check_failed":
        return plan
    job, fitting = plan.job, plan.plan.fittings[0]
    shown, apart = put_back(job, identified, fitting)
    off = float(apart.max())
    details = {**plan.details, "put_back": {"greatest_difference": off}}
    within = f"to {off:.0e}" if off > _ROUNDING else "up to rounding"
    if off <= AGREES:
        claim = f"{plan.claim}; put back into a simulated rotor, which shows the same {within}"
        return replace(plan, details=details, claim=claim)
    row = int(np.argmax(np.abs(shown - np.abs(fitting.left))))
    text = (
        f"the simulated rotor shows {amplitude(job, row, float(shown[row])).short(6)} at {job.row_name(row)}, the "
        f"plan says {fitting.rows[row].residual.short(6)}"
    )
    return replace(plan, status="check_failed", claim=text, details=details)


def _advice(job: RotorJob) -> Answer[RotorJob]:
    """As found only: how large a first trial may be."""
    words = tuple(
        f"{name.split('.')[1]}: a first trial of at most {entry.shown}."
        for name, entry in trial_advice(job).items()
        if name.endswith(".trial")
    )
    claim, reason = "no trial run yet: what a weight does is not known", "Make one run a plane with a trial weight."
    return begun(job, status="unproven", claim=claim, words=words, reason=reason)


def _quality_only(job: RotorJob) -> Answer[RotorJob]:
    """A grade without a balancing job."""
    values = quality_values(job, None, None)
    word = values.get("quality.met")
    status = "met" if word is None or word.shown == "yes" else "violated"
    earned = f"the grade asked for is {'' if status == 'met' else 'not '}earned"
    claim = "permissible residual unbalance from the grade" if word is None else earned
    return begun(job, status=status, claim=claim, values=values, method="lever rule")
