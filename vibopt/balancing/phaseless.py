"""Balancing without phase: amplitudes of three or four runs, and the circles they draw in the plane of weights.

With a weight w in one plane a sensor reads A = a |w0 + w|, where w0 is the unbalance as this sensor sees it.  So
A² = p + 2 Re(conj(w) q) + s |w|² is linear in p = a²|w0|², q = a² w0, s = a², and |q|² = p s.  As found and three trial
positions make it unique, and one too many: the circles |w0 + w| = A / a need not meet, and their miss is said.
Two trial positions leave two answers.  Several planes: each is found by runs with weights in it alone, and runs with
weights in several planes choose among the answers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations, product

import numpy as np

from vibopt.answer.answer import Answer
from vibopt.answer.plan import Fitting
from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.begin import answered, as_told, begun, goal_of, kept_or_broken, nothing, plan_of
from vibopt.balancing.fitting import amplitude, fitting_of
from vibopt.balancing.influence import Identified
from vibopt.balancing.optimisers import solve_question
from vibopt.balancing.plan_values import OFF
from vibopt.balancing.plane_options import Posed
from vibopt.balancing.planes import open_arcs
from vibopt.balancing.question import Solved
from vibopt.balancing.rotor_job import RotorJob
from vibopt.balancing.rotor_question import pose
from vibopt.balancing.trust import conditioning
from vibopt.balancing.verification import runs_without_phase, simulated_without_phase
from vibopt.records import dataclass
from vibopt.units.showing import show_angle

MOST_ANSWERS = 16
_STEPS = 100


@dataclass(frozen=True, slots=True)
class Circle:
    """One way to explain the amplitudes of one sensor by weights in one plane.

    w0
        Unbalance as this sensor sees it [kg m].
    gain
        |H| [SI per kg m].
    miss
        Greatest distance of an amplitude from the explained one [SI peak].
    """

    w0: complex
    gain: float
    miss: float


@dataclass(frozen=True)
class Answers:
    """All rotors that the amplitudes allow, the best first; `miss` of the circles per row [SI peak]."""

    rotors: tuple[Identified, ...]
    miss: FloatArray


def without_phase(job: RotorJob) -> Answers:
    """Every rotor that would have shown these amplitudes, up to a common turn of each sensor's readings.

    Only as many as MOST_ANSWERS are kept.
    """
    rows = [_row(job, speed, sensor) for speed, sensor in job.readings]
    per_row = [_agreeing(job, row, choices) for row, choices in enumerate(rows)]
    combined = sorted(list(product(*per_row))[:MOST_ANSWERS], key=lambda chosen: sum(one[0] for one in chosen))
    parts = [[np.array(part) for part in zip(*chosen, strict=True)] for chosen in combined]
    miss = np.array([max(circle.miss for circle in choices[0]) for choices in rows])
    return Answers(tuple(Identified(y0, H, ()) for _, y0, H in parts), miss)


def _row(job: RotorJob, speed: int, sensor: int) -> list[tuple[Circle, ...]]:
    """Choices of one circle a free plane."""
    runs = job.runs_at(speed)
    found = []
    for plane in job.free:
        own = [run for run in runs if run.is_initial or (run.weights[plane] and np.count_nonzero(run.weights) == 1)]
        weights = np.array([run.weights[plane] for run in own])
        found.append(circles(weights, np.array([abs(run.readings[sensor]) for run in own])))
    return list(product(*found))


Choice = tuple[float, float, ComplexArray]


def _agreeing(job: RotorJob, row: int, choices: Sequence[tuple[Circle, ...]]) -> list[Choice]:
    """(misfit in runs with several weights, y0, H) of the choices that such runs do not speak against."""
    speed, sensor = job.readings[row]
    runs = job.runs_at(speed)
    initial = float(np.mean([abs(run.readings[sensor]) for run in runs if run.is_initial]))
    kept = [plane for plane in range(len(job.planes)) if plane not in job.free]
    mixed = [run for run in runs if np.count_nonzero(run.weights) > 1 and not run.weights[kept].any()]
    scored = []
    for choice in choices:
        H = np.zeros(len(job.planes), dtype=complex)
        for plane, circle in zip(job.free, choice, strict=True):
            H[plane] = circle.gain * np.exp(-1j * np.angle(circle.w0))
        y0 = choice[0].gain * abs(choice[0].w0) if len(choice) == 1 else initial
        misfits = (abs(abs(y0 + H @ run.weights) - abs(run.readings[sensor])) for run in mixed)
        scored.append((max(misfits, default=0.0), y0, H))
    best = min(one[0] for one in scored)
    slack = 0.05 * max(initial, max(abs(run.readings[sensor]) for run in runs))
    return [one for one in scored if one[0] <= best + slack] if mixed else scored


def circles(weights: ComplexArray, amplitudes: FloatArray) -> tuple[Circle, ...]:
    """The one or two circles that explain the amplitudes of runs with these weights [kg m; 0 as found], best first."""
    size, height = float(np.abs(weights).max()), float(amplitudes.max())
    w, A = weights / size, amplitudes / height
    F = np.stack([np.ones(len(w)), 2.0 * w.real, 2.0 * w.imag, np.abs(w) ** 2], axis=1)
    starts = _starts(F, A * A)
    refined = [_refined(w, A, *start) for start in starts]
    unique: list[tuple[complex, float, float]] = []
    for w0, gain, miss in sorted(refined, key=lambda one: one[2]):
        if not any(abs(w0 - other[0]) < 1e-6 * max(1.0, abs(w0)) for other in unique):
            unique.append((w0, gain, miss))
    if len(starts) == 2 and len(unique) == 2 and len(w) > 3 and unique[1][2] > 3.0 * unique[0][2] + 0.01:
        unique = unique[:1]
    return tuple(Circle(w0 * size, gain * height / size, miss * height) for w0, gain, miss in unique)


def _starts(F: FloatArray, squares: FloatArray) -> list[tuple[complex, float]]:
    """(w0, gain) from the equations linear in (p, q, s)."""
    _, values, rows = np.linalg.svd(F)
    rank = int((values > 1e-9 * values[0]).sum())
    theta: FloatArray = np.asarray(np.linalg.lstsq(F, squares, rcond=1e-9)[0], dtype=float)
    if rank >= 4:
        return [_unpack(theta)]
    n = rows[-1]
    a = n[1] ** 2 + n[2] ** 2 - n[0] * n[3]
    b = 2.0 * (theta[1] * n[1] + theta[2] * n[2]) - theta[0] * n[3] - theta[3] * n[0]
    c = theta[1] ** 2 + theta[2] ** 2 - theta[0] * theta[3]
    root = np.sqrt(max(b * b - 4.0 * a * c, 0.0))
    steps = [(-b + root) / (2.0 * a), (-b - root) / (2.0 * a)] if abs(a) > 1e-14 else [-c / b]
    found = [theta + step * n for step in steps]
    good = [one for one in found if one[3] > 0.0]
    return [_unpack(one) for one in good or found]


def _unpack(theta: FloatArray) -> tuple[complex, float]:
    s = max(float(theta[3]), 1e-6)
    return complex(theta[1], theta[2]) / s, float(np.sqrt(s))


def _refined(w: ComplexArray, A: FloatArray, w0: complex, gain: float) -> tuple[complex, float, float]:
    """Least squares in the amplitudes themselves, by damped Gauss-Newton steps: (w0, gain, greatest miss)."""
    damping = 1e-6
    misfit = gain * np.abs(w0 + w) - A
    for _ in range(_STEPS):
        reach = np.maximum(np.abs(w0 + w), 1e-12)
        J = np.stack([gain * (w0 + w).real / reach, gain * (w0 + w).imag / reach, reach], axis=1)
        step = np.linalg.solve(J.T @ J + damping * np.eye(3), -J.T @ misfit)
        trial, trial_gain = w0 + complex(step[0], step[1]), gain + float(step[2])
        new = trial_gain * np.abs(trial + w) - A
        if trial_gain > 0.0 and new @ new <= misfit @ misfit:
            done = float(np.abs(step).max()) < 1e-14 * max(1.0, abs(w0))
            w0, gain, misfit, damping = trial, trial_gain, new, max(damping * 0.1, 1e-15)
            if done:
                break
        else:
            damping = max(damping, 1e-12) * 10.0
            if damping > 1e8:
                break
    return w0, gain, float(np.abs(misfit).max())


def telling_weight(job: RotorJob, answers: Answers) -> tuple[int, complex, FloatArray] | None:
    """The trial (plane, internal weight) that best tells all answers apart; what each predicts (n_answers, n_rows)."""
    if len(answers.rotors) < 2:
        return None
    best: tuple[float, int, complex] = (0.0, job.free[0], 0.0)
    for plane in job.free:
        sizes = [abs(run.weights[plane]) for run in job.runs if run.weights[plane]]
        candidates = _candidates(job, plane, sizes[0])
        shown = np.abs([rotor.y0[:, None] + np.outer(rotor.H[:, plane], candidates) for rotor in answers.rotors])
        pairs = [np.abs(one - other).max(axis=0) for one, other in combinations(shown, 2)]
        gaps: FloatArray = np.min(pairs, axis=0)
        index = int(np.argmax(gaps))
        if gaps[index] > best[0]:
            best = (float(gaps[index]), plane, complex(candidates[index]))
    _, plane, weight = best
    predicted = np.abs(np.stack([rotor.y0 + rotor.H[:, plane] * weight for rotor in answers.rotors]))
    return plane, weight, predicted


def _candidates(job: RotorJob, plane: int, size: float) -> ComplexArray:
    """Weights of one size in the holes there are, else every 5 degrees, where one may sit."""
    own = job.planes[plane]
    angles = own.holes or (
        *np.deg2rad(np.arange(0.0, 360.0, 5.0)),
        *(0.5 * sum(arc) for arc in open_arcs(own.forbidden)),
    )
    return np.array([job.conventions.weight(size, angle) for angle in angles if own.may_sit_at(angle)])


METHOD = "amplitudes only: circles of weights"
EXACT = 1e-6
"""Part of the largest reading below which circles meet, and two roads agree."""


def solve_without_phase(job: RotorJob, *, thorough: bool = False) -> Answer[RotorJob]:
    """The plan, or all of them, that the amplitudes allow."""
    answers = without_phase(job)
    found = []
    for rotor in answers.rotors:
        posed = pose(job, rotor)
        one = answered(job, posed)
        if one.u is not None:
            options = posed.question.chosen_only(one.chosen).options
            found.append((rotor, posed, one, fitting_of(job, rotor, one.u, options)))
    if not found:
        first = pose(job, answers.rotors[0])
        plan = nothing(job, answers.rotors[0], first, solve_question(first.question), thorough=thorough)
        return replace(plan, method=METHOD)
    rotor, posed, solved, fitting = found[0]
    if len(found) > 1:
        return _open(job, answers, posed, solved, [one[-1] for one in found])
    plan = plan_of(job, rotor, posed, solved, fitting, None, _miss_notes(job, answers))
    plan = replace(plan, method=METHOD, details={"miss": answers.miss.tolist()})
    if not plan.plan.fittings:
        return plan
    status, claim = _one(job, answers, fitting, solved)
    return as_told(replace(plan, status=kept_or_broken(plan.limits)[0] if status == "met" else status, claim=claim))


def _open(job: RotorJob, answers: Answers, posed: Posed, solved: Solved, fittings: list[Fitting]) -> Answer[RotorJob]:
    """Several plans, and the run that decides between them."""
    u = solved.u
    assert u is not None
    many = {2: "two", MOST_ANSWERS: f"at least {MOST_ANSWERS}"}.get(len(fittings), f"{len(fittings)}")
    words = [f"Answer {k}: {plane.words}" for k, fitting in enumerate(fittings, start=1) for plane in fitting.planes]
    return begun(
        job, status="unproven", claim=f"the amplitudes leave {many} answers; one more trial run decides",
        goal=goal_of(job, posed.question.chosen_only(solved.chosen), u),
        fittings=tuple(fittings), words=(OFF, *words), gap=solved.gap,
        notes=(*_miss_notes(job, answers), *_ask(job, answers)), method=METHOD,
        condition=conditioning(posed.question, job.free).number, details={"miss": answers.miss.tolist()},
    )  # fmt: skip


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
    u = np.array([plane.u for plane in fitting.planes], dtype=complex)
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
    while (open_ := np.array([not (gap[rows] >= least).any() for gap, least in zip(gaps, enough, strict=True)])).any():
        rows.append(int(np.argmax(gaps[open_].sum(axis=0))))
    return sorted(rows)
