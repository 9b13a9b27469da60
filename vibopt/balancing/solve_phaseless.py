"""Solving a rotor measured without phase: one answer or several, how far the circles meet, and the run that decides."""

from __future__ import annotations

import numpy as np

from vibopt.balancing.answers import Fitting
from vibopt.balancing.begin import OFF, begun, goal_of, nothing
from vibopt.balancing.fitting import amplitude, fitting_of
from vibopt.balancing.job import RotorJob
from vibopt.balancing.limit_prices import limit_answers
from vibopt.balancing.phaseless import MOST_ANSWERS, Answers, telling_weight, without_phase
from vibopt.balancing.plan import Plan
from vibopt.balancing.pose import pose, solve_question
from vibopt.balancing.putback import put_back_without_phase
from vibopt.balancing.question import Solved
from vibopt.balancing.words import show_angle


def solve_without_phase(job: RotorJob) -> Plan:
    """The plan, or all of them, that the amplitudes allow."""
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
        return nothing(job, answers.rotors[0], first, solve_question(first.question))
    u = solved[0].u
    assert u is not None
    goal = goal_of(job, posed_of[0].question, u)
    limits = limit_answers(job, posed_of[0], u, goal[1])
    several = len(fittings) > 1
    status, claim = _several(fittings) if several else _one(job, answers, fittings[0], solved[0])
    words = _words_of(fittings)
    return begun(
        job, status=status, claim=claim, goal=goal, fittings=tuple(fittings),
        limits={} if several else limits, words=(OFF, *words),
        gap=solved[0].gap, notes=(*_miss_notes(job, answers), *(_ask(job, answers) if several else ())),
        method="amplitudes only: circles of weights", values={}, details={"miss": answers.miss.tolist()},
    )  # fmt: skip


def _several(fittings: list[Fitting]) -> tuple[str, str]:
    many = (
        "two"
        if len(fittings) == 2
        else f"{len(fittings)}"
        if len(fittings) < MOST_ANSWERS
        else f"at least {MOST_ANSWERS}"
    )
    return "unproven", f"the amplitudes leave {many} answers; one more trial run decides"


def _one(job: RotorJob, answers: Answers, fitting: Fitting, solved: Solved) -> tuple[str, str]:
    """Status of a single answer, checked through the squares of the amplitudes."""
    row = int(np.argmax(answers.miss / np.maximum(np.abs(answers.rotors[0].y0), 1e-300)))
    size = max(abs(run.readings[job.readings[row][1]]) for run in job.runs)
    miss = float(answers.miss[row])
    if miss > 0.1 * size:
        return (
            "unproven",
            f"the circles do not meet: they miss by {amplitude(job, row, miss).shown} at {job.row_name(row)}; "
            f"repeat the runs",
        )
    if len(job.free) == 1 and miss < 1e-6 * size:
        plane = job.free[0]
        for index, one in enumerate(fitting.rows):
            again = put_back_without_phase(job, index, plane, fitting.planes[plane].u)
            if abs(again**2 - float(one.residual.value) ** 2) > 1e-6 * size**2:
                return (
                    "check_failed",
                    f"the squares of the amplitudes give {amplitude(job, index, again).shown} at "
                    f"{job.row_name(index)}, the plan says {one.residual.shown}",
                )
        return solved.status, f"{solved.claim}; the squares of the amplitudes give the same residual"
    return (
        "feasible" if solved.status == "optimal" else solved.status,
        f"{solved.claim}, as far as the circles meet (miss {amplitude(job, row, miss).shown})",
    )


def _words_of(fittings: list[Fitting]) -> tuple[str, ...]:
    if len(fittings) == 1:
        return tuple(one.words for one in fittings[0].planes)
    return tuple(
        f"Answer {number}: {one.words}" for number, fitting in enumerate(fittings, start=1) for one in fitting.planes
    )


def _miss_notes(job: RotorJob, answers: Answers) -> tuple[str, ...]:
    notes = []
    for row, miss in enumerate(answers.miss):
        size = max(abs(run.readings[job.readings[row][1]]) for run in job.runs_at(job.readings[row][0]))
        if miss > 1e-3 * size:
            notes.append(
                f"The circles of {job.row_name(row)} do not meet in one point: they miss by "
                f"{amplitude(job, row, float(miss)).shown} "
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
