"""Balancing without phase: amplitudes of three or four runs, and the circles they draw in the plane of weights.

With a weight w in one plane a sensor reads A = a |w0 + w|, where w0 is the unbalance as this sensor sees it.  So
A² = p + 2 Re(conj(w) q) + s |w|² is linear in p = a²|w0|², q = a² w0, s = a², and |q|² = p s.  As found and three trial
positions make it unique, and one too many: the circles |w0 + w| = A / a need not meet, and their miss is said.
Two trial positions leave two answers.  Several planes: each is found by runs with weights in it alone, and runs with
weights in several planes choose among the answers.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, product

import numpy as np

from vibopt.balancing.influence import Identified
from vibopt.balancing.job import RotorJob, Run
from vibopt.forms import ComplexArray, FloatArray
from vibopt.records import dataclass

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
    combined: list[tuple[float, ComplexArray, ComplexArray]] = []
    per_row = [_agreeing(job, row, choices) for row, choices in enumerate(rows)]
    for chosen in list(product(*per_row))[:MOST_ANSWERS]:
        y0 = np.array([one[1] for one in chosen])
        H = np.array([one[2] for one in chosen])
        combined.append((sum(one[0] for one in chosen), y0, H))
    combined.sort(key=lambda one: one[0])
    miss = np.array([max(circle.miss for circle in choices[0]) for choices in rows])
    return Answers(tuple(Identified(y0, H, ()) for _, y0, H in combined), miss)


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
    mixed = [run for run in runs if np.count_nonzero(run.weights) > 1]
    scored = []
    for choice in choices:
        H = np.zeros(len(job.planes), dtype=complex)
        for plane, circle in zip(job.free, choice, strict=True):
            H[plane] = circle.gain * np.exp(-1j * np.angle(circle.w0))
        y0 = choice[0].gain * abs(choice[0].w0) if len(choice) == 1 else initial
        scored.append((_misfit(mixed, sensor, y0, H), y0, H))
    best = min(one[0] for one in scored)
    slack = 0.05 * max(initial, max(abs(run.readings[sensor]) for run in runs))
    return [one for one in scored if one[0] <= best + slack] if mixed else scored


def _misfit(runs: Sequence[Run], sensor: int, y0: float, H: ComplexArray) -> float:
    return max((abs(abs(y0 + H @ run.weights) - abs(run.readings[sensor])) for run in runs), default=0.0)


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
        shown = np.abs([one.y0[:, None] + np.outer(one.H[:, plane], candidates) for one in answers.rotors])
        pairs = [np.abs(one - other).max(axis=0) for one, other in combinations(shown, 2)]
        gaps: FloatArray = np.min(pairs, axis=0)
        index = int(np.argmax(gaps))
        if gaps[index] > best[0]:
            best = (float(gaps[index]), plane, complex(candidates[index]))
    _, plane, weight = best
    predicted = np.abs(np.stack([one.y0 + one.H[:, plane] * weight for one in answers.rotors]))
    return plane, weight, predicted


def _candidates(job: RotorJob, plane: int, size: float) -> ComplexArray:
    """Weights of one size in the holes there are, else every 5 degrees."""
    angles = job.planes[plane].holes or tuple(np.deg2rad(np.arange(0.0, 360.0, 5.0)))
    return np.array([job.conventions.weight(size, angle) for angle in angles])
