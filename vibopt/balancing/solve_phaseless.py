"""Solving a rotor measured without phase: one answer or several, how far the circles meet, and the run that decides."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np

from vibopt.answer.answer import Answer
from vibopt.answer.plan import Fitting
from vibopt.balancing.begin import answered, begun, goal_of, kept_or_broken, nothing
from vibopt.balancing.cautions import cancelling, ways_out
from vibopt.balancing.fitting import amplitude, fitting_of
from vibopt.balancing.job import RotorJob
from vibopt.balancing.limit_prices import limit_answers
from vibopt.balancing.phaseless import MOST_ANSWERS, Answers, telling_weight, without_phase
from vibopt.balancing.pose import pose
from vibopt.balancing.prices import solve_question
from vibopt.balancing.question import Solved
from vibopt.balancing.remedies import last_one, remedies, warning
from vibopt.balancing.report_rotor import quality_values
from vibopt.balancing.trim import OFF, todo, trims
from vibopt.balancing.trust import conditioning
from vibopt.balancing.verification import runs_without_phase, simulated_without_phase
from vibopt.balancing.words import show_angle
from vibopt.forms import FloatArray

METHOD = "amplitudes only: circles of weights"
EXACT = 1e-6
"""Part of the largest reading below which circles meet, and two roads agree."""


def solve_without_phase(job: RotorJob, *, thorough: bool = False) -> Answer[RotorJob]:
    """The plan, or all of them, that the amplitudes allow."""
    answers = without_phase(job)
    solved, fittings, posed_of, kept = [], [], [], []
    for rotor in answers.rotors:
        posed = pose(job, rotor)
        one = answered(job, posed)
        if one.u is not None:
            solved.append(one)
            posed_of.append(posed)
            kept.append(rotor)
            fittings.append(fitting_of(job, rotor, one.u, posed.chosen_only(one.chosen).options))
    if not solved:
        first = pose(job, answers.rotors[0])
        plan = nothing(job, answers.rotors[0], first, solve_question(first.question), thorough=thorough)
        return replace(plan, method=METHOD)
    u = solved[0].u
    assert u is not None
    question, found = posed_of[0].question, conditioning(posed_of[0].question, job.free)
    if len(fittings) == 1 and job.choices and (refused := cancelling(job, question, answers.rotors[0], None, found, u)):
        return begun(
            job, status="unproven", claim=refused, words=ways_out(job, found), condition=found.number,
            remedies=remedies(job, posed_of[0], answers.rotors[0], None, found, u), notes=(warning(job, found),),
            method=METHOD, details={"miss": answers.miss.tolist()},
        )  # fmt: skip
    goal = goal_of(job, question.chosen_only(solved[0].chosen), u)
    several = len(fittings) > 1
    ways = remedies(job, posed_of[0], kept[0], None, found, u) if found.near and job.choices and not several else ()
    alike = (warning(job, found), *last_one(ways)) if ways else ()
    priced = limit_answers(job, posed_of[0], solved[0], goal[1], thorough=thorough)
    status, claim = _several(fittings) if several else _one(job, answers, fittings[0], solved[0])
    if status == "met":
        status, claim = kept_or_broken(priced.limits)[0], claim
    return begun(
        job, status=status, claim=claim, goal=goal, fittings=tuple(fittings),
        limits={} if several else priced.with_words(), prices={} if several else priced.caps(),
        words=(OFF, *_words_of(fittings)) if several else todo(job, fittings[0]),
        gap=solved[0].gap,
        notes=(*alike, *_miss_notes(job, answers), *(_ask(job, answers) if several else priced.notes)),
        method=METHOD, values={} if several else {**quality_values(job, kept[0], u), **trims(job, fittings[0])},
        remedies=ways, condition=found.number, details={"miss": answers.miss.tolist()},
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
    """Status of a single answer, checked through every run simulated and through the squares of the amplitudes."""
    rotor = answers.rotors[0]
    again = runs_without_phase(job, rotor.y0, rotor.H)
    off = np.maximum(answers.miss, again)
    row = int(np.argmax(off / np.maximum(np.abs(rotor.y0), 1e-300)))
    size = max(abs(run.readings[job.readings[row][1]]) for run in job.runs)
    miss = float(off[row])
    if miss > 0.1 * size:
        circles = (
            "the circles do not meet: they miss"
            if answers.miss[row] >= again[row] * (1.0 - 1e-6)
            else "the runs are missed"
        )
        shown = amplitude(job, row, miss).shown
        return "unproven", f"{circles} by {shown} at {job.row_name(row)}; repeat the runs"
    if miss < EXACT * size:
        return _by_squares(job, fitting, solved, size)
    return (
        "feasible" if solved.status == "optimal" else solved.status,
        f"{solved.claim}, as far as the circles meet (miss {amplitude(job, row, miss).shown})",
    )


def _by_squares(job: RotorJob, fitting: Fitting, solved: Solved, size: float) -> tuple[str, str]:
    """Status of an answer that explains every run, after the residuals were found again without circles."""
    u = np.array([one.u for one in fitting.planes], dtype=complex)
    shown = np.array([simulated_without_phase(job, row, u) for row in range(len(fitting.rows))])
    said = np.array([float(one.residual.value) for one in fitting.rows])
    checked = np.isfinite(shown)
    if (wrong := checked & (np.abs(shown**2 - said**2) > EXACT * size**2)).any():
        row = int(np.argmax(wrong))
        text = f"the squares of the amplitudes give {amplitude(job, row, float(shown[row])).short(6)}"
        return "check_failed", f"{text} at {job.row_name(row)}, the plan says {fitting.rows[row].residual.short(6)}"
    if checked.all():
        return solved.status, f"{solved.claim}; the squares of the amplitudes give the same residual"
    return solved.status, f"{solved.claim}; the rotor found, simulated, shows every run as it was read"


def _words_of(fittings: list[Fitting]) -> tuple[str, ...]:
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
    plane, rows = job.planes[index], _telling_rows(predicted)
    said = "; ".join(
        f"answer {number} predicts "
        + " and ".join(f"{amplitude(job, row, float(one[row])).short(6)} at {job.row_name(row)}" for row in rows)
        for number, one in enumerate(predicted, start=1)
    )
    at = show_angle(job.conventions.weight_angle(weight))
    return (
        f"Make one more run with {plane.show(plane.amount(weight))} in {plane.name} at {at}: {said}. Add it to the "
        f"file and solve again.",
    )


def _telling_rows(predicted: FloatArray) -> list[int]:
    """As few rows as tell every two answers apart as well as all rows do, or half as well: the widest spread first."""
    pairs = list(combinations(predicted, 2))
    gaps = np.array([np.abs(one - other) for one, other in pairs])
    enough = 0.5 * gaps.max(axis=1)
    rows: list[int] = []
    while (open_ := np.array([not (one[rows] >= least).any() for one, least in zip(gaps, enough, strict=True)])).any():
        rows.append(int(np.argmax(gaps[open_].sum(axis=0))))
    return sorted(rows)
