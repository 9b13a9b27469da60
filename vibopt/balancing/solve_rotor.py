"""Solving a measured rotor: identify, ask the optimiser, turn the answer into weights, and put them back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from vibopt.balancing.fitting import amplitude, fitting_of, plan_text
from vibopt.balancing.influence import Identified, identify
from vibopt.balancing.job import RotorJob
from vibopt.balancing.limit_prices import limit_answers, loosenings
from vibopt.balancing.outcome import Entry
from vibopt.balancing.phaseless import MOST_ANSWERS, Answers, telling_weight, without_phase
from vibopt.balancing.plan import Fitting, Plan
from vibopt.balancing.pose import Posed, pose, solve_question
from vibopt.balancing.putback import put_back, put_back_without_phase
from vibopt.balancing.question import Question, Solved
from vibopt.balancing.remedies import remedies, warning
from vibopt.balancing.report_rotor import coefficients, quality_values, trial_advice
from vibopt.balancing.trust import Noise, bands, conditioning, noise_of
from vibopt.balancing.words import show_angle
from vibopt.forms import ComplexArray

AGREES = 1e-6
_OFF = "Take every trial weight off first: the plan is added to the rotor as found."


def solve_job(job: RotorJob) -> Plan:
    """The plan for a measured rotor.

    Every answer has been put back into a simulated rotor by another road (`vibopt.balancing.putback`); one that the
    simulation refuses has the status "check_failed".
    """
    if not job.runs:
        return _quality_only(job)
    if job.is_advice:
        return _advice(job)
    return _with_phase(job) if job.has_phase else _without_phase(job)


def _base(job: RotorJob, **more: Any) -> Plan:
    values = {**trial_advice(job), **more.pop("values", {})}
    notes = (*job.notes, *more.pop("notes", ()))
    return Plan(job=job, conventions=job.conventions.sentences(), values=values, notes=notes, **more)


def _with_phase(job: RotorJob) -> Plan:
    identified = identify(job)
    noise = noise_of(job, identified)
    posed = pose(job, identified, noise)
    solved = solve_question(posed.question)
    if solved.u is None:
        return _nothing(job, identified, posed, solved)
    fitting, solved = _fit(job, identified, posed, solved, noise)
    plan = _plan(job, identified, posed, solved, fitting, noise)
    return _certified(plan, identified)


def _fit(job: RotorJob, identified: Identified, posed: Posed, solved: Solved, noise: Noise | None) -> tuple[Fitting, Solved]:
    """The weights; where a split weight breaks its cap, again with the cap that any split keeps."""
    fitting = _fitting(job, identified, posed, solved.u, noise)
    over = [index for index, one in enumerate(fitting.planes) if sum(w.mass for w in one.weights) > _cap(posed, job, index) * (1 + 1e-9)]
    if not over:
        return fitting, solved
    caps = posed.question.caps.copy()
    for index in over:
        caps[index] *= _inner(job.planes[index].holes)
    again = solve_question(replace(posed.question, caps=caps))
    if again.u is None:
        return fitting, replace(solved, status="unproven", claim="the split weights are heavier than their cap, and no lighter answer was found")
    claim = f"{again.claim}; the cap is on both parts of a split weight together, so a slightly better answer may exist"
    return _fitting(job, identified, posed, again.u, noise), replace(again, status="feasible", claim=claim)


def _cap(posed: Posed, job: RotorJob, index: int) -> float:
    return float(posed.question.caps[index] / job.planes[index].radius) if job.planes[index].split else float("inf")


def _inner(holes: tuple[float, ...]) -> float:
    """Cosine of half the widest gap between holes: what any two parts of one mass can do at least."""
    around = np.sort(np.mod(holes, 2.0 * np.pi))
    gap = float(np.diff(np.append(around, around[0] + 2.0 * np.pi)).max())
    return max(float(np.cos(0.5 * gap)), 0.0)


def _fitting(job: RotorJob, identified: Identified, posed: Posed, u: ComplexArray | None, noise: Noise | None) -> Fitting:
    assert u is not None
    band = bands(job, identified, noise, u) if noise is not None and identified.learnt else None
    return fitting_of(job, identified, u, posed.options, band)


def _plan(job: RotorJob, identified: Identified, posed: Posed, solved: Solved, fitting: Fitting, noise: Noise | None) -> Plan:
    u = solved.u
    assert u is not None
    nominal = pose(replace(job, goal=replace(job.goal, robust="")), identified).question
    goal = goal_of(job, nominal, u)
    plain = Posed(nominal, posed.options, posed.n_rows)
    limits = limit_answers(job, plain, u, goal[1])
    found = conditioning(nominal, job.free)
    said = warning(job, found)
    idle = tuple(f"No sensor feels a weight in plane {job.planes[index].name}: it cannot be balanced there." for index in found.idle)
    return _base(
        job, status=solved.status, claim=solved.claim, goal=goal, fittings=(_priced(job, fitting, limits),), limits=limits,
        words=(_OFF, *(one.words for one in fitting.planes)), gap=solved.gap, condition=found.number,
        remedies=remedies(job, plain, identified, noise, found, u) if found.alike else (),
        values={**coefficients(job, identified), **quality_values(job, identified, u)},
        notes=(*identified.notes, *((said,) if said else ()), *idle, *_noise_notes(job, noise)),
        method=_method(job, posed.question, identified), details=dict(solved.details),
    )  # fmt: skip


def _priced(job: RotorJob, fitting: Fitting, limits: Mapping[str, Any]) -> Fitting:
    """Rows with the price of the limit that bounds them."""
    rows = []
    for (speed, sensor), row in zip(job.readings, fitting.rows, strict=True):
        own = [one for one in job.residual_limits if one.sensor in (None, sensor) and one.speed in (None, speed)]
        prices = [limits[one.name].price for one in own if limits[one.name].price and limits[one.name].place == job.row_name(job.readings.index((speed, sensor)))]
        rows.append(replace(row, price=prices[0]) if prices else row)
    return replace(fitting, rows=tuple(rows))


def goal_of(job: RotorJob, question: Question, u: ComplexArray) -> tuple[str, Entry]:
    """Name and value of the goal, as the sensors read."""
    value = question.value(u)
    if question.goal == "correction":
        return "correction", Entry(value, job.planes[job.free[0]].dimension, job.planes[job.free[0]].unit)
    names = {"rms": "root mean square of the residuals", "worst": "worst residual", "sum": "sum of the residuals", "huber": "residual (Huber)"}
    if question.goal == "huber":
        return names["huber"], Entry(value, "ratio")
    return names[question.goal], amplitude(job, 0, value)


def _noise_notes(job: RotorJob, noise: Noise | None) -> tuple[str, ...]:
    if noise is None:
        return ('The scatter of the readings is not known, so the plan has no band. Add scatter = { amplitude = "5 %", angle = "2 deg" }.',)
    return (f"Bands hold 95 % of what the scatter of the readings allows ({noise.source}).",)


def _method(job: RotorJob, question: Question, identified: Identified) -> str:
    spare = sum(max(one.spare, 0) for one in identified.learnt)
    fit = "influence coefficients" + (f", least squares over {spare} spare run{'s' if spare > 1 else ''}" if spare else "")
    kind = "holes and weights jointly" if question.is_discrete else "free weights"
    robust = {"worst": f", worst of {question.n_readings // max(len(job.readings), 1)} rotors within the scatter", "mean": ", mean over the scatter", "": ""}[job.goal.robust]
    return f"{fit}; {kind}{robust}"


def _nothing(job: RotorJob, identified: Identified, posed: Posed, solved: Solved) -> Plan:
    """No correction: which limits stand in the way."""
    steps = loosenings(job, posed) if solved.status == "infeasible" and not posed.question.is_discrete else []
    reason = ""
    if steps:
        reason = "Smallest loosening of one: " + ", or ".join(f"{name} {now} -> {then}" for name, now, then in steps) + "."
    return _base(
        job, status=solved.status, claim=solved.claim, reason=reason, notes=identified.notes, details=dict(solved.details),
        method=_method(job, posed.question, identified), values=coefficients(job, identified),
    )  # fmt: skip


def _certified(plan: Plan, identified: Identified) -> Plan:
    """The plan, if the simulated rotor shows what it says."""
    job, fitting = plan.job, plan.fittings[0]
    shown = put_back(job, plan_text(job, fitting))
    said = np.array([float(row.residual.value) for row in fitting.rows])
    u = np.array([one.u for one in fitting.planes])
    scale = np.abs(identified.y0) + np.abs(identified.H) @ np.abs(u)
    off = float((np.abs(shown - said) / np.maximum(scale, 1e-300)).max())
    details = {**plan.details, "put_back": {"greatest_difference": off}}
    if off <= AGREES:
        return replace(plan, details=details, claim=f"{plan.claim}; put back into a simulated rotor, which shows the same to {max(off, 1e-16):.0e}")
    row = int(np.argmax(np.abs(shown - said)))
    text = f"the simulated rotor shows {amplitude(job, row, float(shown[row])).shown} at {job.row_name(row)}, the plan says {fitting.rows[row].residual.shown}"
    return replace(plan, status="check_failed", claim=text, details=details)


def _without_phase(job: RotorJob) -> Plan:
    answers = without_phase(job)
    solved, fittings, posed_of = [], [], []
    for rotor in answers.rotors:
        posed = pose(job, rotor)
        one = solve_question(posed.question)
        if one.u is not None:
            solved.append(one)
            posed_of.append(posed)
            fittings.append(fitting_of(job, rotor, one.u, posed.options))
    if not solved:
        first = pose(job, answers.rotors[0])
        return _nothing(job, answers.rotors[0], first, solve_question(first.question))
    u = solved[0].u
    assert u is not None
    goal = goal_of(job, posed_of[0].question, u)
    limits = limit_answers(job, posed_of[0], u, goal[1])
    several = len(fittings) > 1
    status, claim = (_several(fittings) if several else _one(job, answers, fittings[0], solved[0]))
    words = _words_of(fittings)
    return _base(
        job, status=status, claim=claim, goal=goal, fittings=tuple(fittings), limits={} if several else limits, words=(_OFF, *words),
        gap=solved[0].gap, notes=(*_miss_notes(job, answers), *(_ask(job, answers) if several else ())),
        method="amplitudes only: circles of weights", values={}, details={"miss": answers.miss.tolist()},
    )  # fmt: skip


def _several(fittings: list[Fitting]) -> tuple[str, str]:
    many = "two" if len(fittings) == 2 else f"{len(fittings)}" if len(fittings) < MOST_ANSWERS else f"at least {MOST_ANSWERS}"
    return "unproven", f"the amplitudes leave {many} answers; one more trial run decides"


def _one(job: RotorJob, answers: Answers, fitting: Fitting, solved: Solved) -> tuple[str, str]:
    """Status of a single answer, checked through the squares of the amplitudes."""
    row = int(np.argmax(answers.miss / np.maximum(np.abs(answers.rotors[0].y0), 1e-300)))
    size = max(abs(run.readings[job.readings[row][1]]) for run in job.runs)
    miss = float(answers.miss[row])
    if miss > 0.1 * size:
        return "unproven", f"the circles do not meet: they miss by {amplitude(job, row, miss).shown} at {job.row_name(row)}; repeat the runs"
    if len(job.free) == 1 and miss < 1e-6 * size:
        plane = job.free[0]
        for index, one in enumerate(fitting.rows):
            again = put_back_without_phase(job, index, plane, fitting.planes[plane].u)
            if abs(again**2 - float(one.residual.value) ** 2) > 1e-6 * size**2:
                return "check_failed", f"the squares of the amplitudes give {amplitude(job, index, again).shown} at {job.row_name(index)}, the plan says {one.residual.shown}"
        return solved.status, f"{solved.claim}; the squares of the amplitudes give the same residual"
    return "feasible" if solved.status == "optimal" else solved.status, f"{solved.claim}, as far as the circles meet (miss {amplitude(job, row, miss).shown})"


def _words_of(fittings: list[Fitting]) -> tuple[str, ...]:
    if len(fittings) == 1:
        return tuple(one.words for one in fittings[0].planes)
    return tuple(f"Answer {number}: {one.words}" for number, fitting in enumerate(fittings, start=1) for one in fitting.planes)


def _miss_notes(job: RotorJob, answers: Answers) -> tuple[str, ...]:
    notes = []
    for row, miss in enumerate(answers.miss):
        size = max(abs(run.readings[job.readings[row][1]]) for run in job.runs_at(job.readings[row][0]))
        if miss > 1e-3 * size:
            notes.append(
                f"The circles of {job.row_name(row)} do not meet in one point: they miss by {amplitude(job, row, float(miss)).shown} "
                f"({100 * miss / size:.2g} % of the largest reading). Steady readings would meet."
            )
    return tuple(notes)


def _ask(job: RotorJob, answers: Answers) -> tuple[str, ...]:
    """The third run that decides, with what each answer predicts."""
    told = telling_weight(job, answers)
    if told is None:
        return ()
    index, weight, predicted = told
    plane = job.planes[index]
    row = int(np.argmax(np.abs(predicted[0] - predicted[1])))
    first, second = (amplitude(job, row, float(one[row])).shown for one in predicted)
    at = show_angle(job.conventions.weight_angle(weight))
    return (
        f"Make one more run with {plane.show(plane.amount(weight))} in {plane.name} at {at}: answer 1 predicts {first} "
        f"at {job.row_name(row)}, answer 2 predicts {second}. Add it to the file and solve again.",
    )


def _advice(job: RotorJob) -> Plan:
    """As found only: how large a first trial may be."""
    words = tuple(f"{name.split('.')[1]}: a first trial of at most {entry.shown}." for name, entry in trial_advice(job).items() if name.endswith(".trial"))
    return _base(job, status="unproven", claim="no trial run yet: what a weight does is not known", words=words, reason="Make one run a plane with a trial weight.")


def _quality_only(job: RotorJob) -> Plan:
    """A grade without a balancing job."""
    values = quality_values(job, None, None)
    word = values.get("quality.met")
    status = "met" if word is None or word.value == "yes" else "violated"
    claim = "permissible residual unbalance from the grade" if word is None else f"the grade asked for is {'' if status == 'met' else 'not '}earned"
    return _base(job, status=status, claim=claim, values=values, method="lever rule")
