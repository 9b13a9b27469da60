"""The finished plan put back into a simulated rotor: signals over the shaft angle, read again from the user's own text.

Another road than the optimiser's: no phasors, no H.  Each run is a cosine over the shaft angle since the reference
pulse, its peak where lag, lead or mark say.  A weight turned on in the sense of rotation by an angle makes its signal
come earlier by that angle.  The plan is a mixture of runs with their weights scaled and turned; the mixture of their
signals is sampled over one turn, and its first harmonic is what the instrument would show.
"""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np

from vibopt.balancing.job import RotorJob, Run, Sensor
from vibopt.balancing.planes import read_weight
from vibopt.balancing.words import AGAINST, LAG, MARK, WITH, read_amplitude, split_angle
from vibopt.forms import ComplexArray, FloatArray

SAMPLES = 360
PlanText = tuple[tuple[int, str, bool], ...]
"""What is fitted: plane index, text such as "12.3 g @ 200 deg", whether it is taken away."""


def put_back(job: RotorJob, plan: PlanText) -> FloatArray:
    """Amplitudes that the simulated rotor shows with the plan fitted, per row [SI peak]."""
    target = _correction(job, plan)
    shown = []
    for speed in range(len(job.speeds)):
        runs = job.runs_at(speed)
        states = np.array([_state(job, run) for run in runs])
        shares = _mixture(job, speed, states, target)
        for sensor in range(len(job.sensors)):
            shown.append(_amplitude(_signal(job, speed, sensor, runs, states, shares, target)))
    return np.array(shown)


def _correction(job: RotorJob, plan: PlanText) -> ComplexArray:
    total = np.zeros(len(job.planes), dtype=complex)
    for plane, text, taken in plan:
        total[plane] += _turned(job, plane, text) * (-1.0 if taken else 1.0)
    return total


def _turned(job: RotorJob, plane: int, text: str) -> complex:
    """Unbalance whose angle is where it sits on the shaft, counted in the sense of rotation."""
    as_written = replace(job.conventions, angles=WITH)
    weight = read_weight(text, job.planes[plane], as_written)
    return weight.conjugate() if job.conventions.angles == AGAINST else weight


def _state(job: RotorJob, run: Run) -> ComplexArray:
    """Everything fitted during a run, read again from its text."""
    total = np.zeros(len(job.planes), dtype=complex)
    index = job.runs.index(run)
    if run.stayed and index:
        total += _state(job, job.runs[index - 1])
    for plane, text in run.fitted:
        total[plane] += _turned(job, plane, text)
    return total


def _ready(job: RotorJob, speed: int) -> list[int]:
    return sorted({plane for at, _, plane in job.influence if at == speed})


def _mixture(job: RotorJob, speed: int, states: ComplexArray, target: ComplexArray) -> ComplexArray:
    """Smallest shares of the runs that together carry the plan (and one rotor as found)."""
    learnt = [plane for plane in range(len(job.planes)) if plane not in _ready(job, speed)]
    rows = np.concatenate([np.ones((1, len(states))), states[:, learnt].T])
    wanted = np.concatenate([[1.0], target[learnt]])
    used = np.abs(rows).max(axis=1) > 0.0
    size = np.abs(rows[used]).max(axis=1)
    shares: ComplexArray = np.linalg.lstsq(rows[used] / size[:, None], wanted[used] / size, rcond=None)[0]
    return shares


def _signal(
    job: RotorJob,
    speed: int,
    sensor: int,
    runs: tuple[Run, ...],
    states: ComplexArray,
    shares: ComplexArray,
    target: ComplexArray,
) -> FloatArray:
    """What the sensor shows over one turn of the shaft."""
    turn = 2.0 * pi * np.arange(SAMPLES) / SAMPLES
    signal = np.zeros(SAMPLES)
    ready = _ready(job, speed)
    for run, state, share in zip(runs, states, shares, strict=True):
        shifted = turn + np.angle(share)
        own = _cosine(job, job.sensors[sensor], run.texts[sensor], shifted) - _runout(job, sensor, shifted)
        for plane in ready:
            own -= _unit(job, speed, sensor, plane, state[plane], shifted)
        signal += abs(share) * own
    for plane in ready:
        signal += _unit(job, speed, sensor, plane, target[plane], turn)
    return signal


def _cosine(job: RotorJob, sensor: Sensor, text: str, turn: FloatArray) -> FloatArray:
    """Signal of a reading: its peak comes when the shaft has turned as far as the text says."""
    front, angle = split_angle(text, "")
    size = read_amplitude(front, job.conventions.detector, sensor.unit).value
    return np.asarray(size * np.cos(turn - _peak_at(job, angle or 0.0)))


def _peak_at(job: RotorJob, angle: float) -> float:
    """Shaft angle since the reference pulse at which the vibration peaks."""
    conventions = job.conventions
    if conventions.readings == MARK:
        return angle if conventions.angles == WITH else -angle
    return angle if conventions.phase == LAG else -angle


def _runout(job: RotorJob, sensor: int, turn: FloatArray) -> FloatArray:
    own = job.document.get("sensors", {}).get(job.sensors[sensor].name, {}).get("runout")
    return np.zeros(len(turn)) if own is None else _cosine(job, job.sensors[sensor], str(own), turn)


def _unit(job: RotorJob, speed: int, sensor: int, plane: int, weight: complex, turn: FloatArray) -> FloatArray:
    """Signal of a weight by its ready coefficient: a unit weight at zero, turned to where this one sits."""
    H = job.influence[speed, sensor, plane]
    peak = _peak_at(job, job.conventions.reading_angle(H))
    return np.asarray(abs(weight) * abs(H) * np.cos(turn + np.angle(weight) - peak))


def _amplitude(signal: FloatArray) -> float:
    """First harmonic of one turn."""
    turn = 2.0 * pi * np.arange(len(signal)) / len(signal)
    return float(2.0 / len(signal) * np.hypot(signal @ np.cos(turn), signal @ np.sin(turn)))


def runs_without_phase(job: RotorJob, row: int, y0: complex, H: ComplexArray) -> float:
    """Greatest difference between what a rotor y0, H shows over a turn in each run and what was read [SI peak].

    Runs with weights in several planes at once are among them, which no circle has seen.
    """
    speed, sensor = job.readings[row]
    turn = 2.0 * pi * np.arange(SAMPLES) / SAMPLES
    worst = 0.0
    for run in job.runs_at(speed):
        signal = abs(y0) * np.cos(turn + np.angle(y0))
        for plane, weight in enumerate(_state(job, run)):
            own = H[plane] * weight
            signal += abs(own) * np.cos(turn + np.angle(own))
        worst = max(worst, abs(_amplitude(signal) - abs(run.readings[sensor])))
    return worst


def put_back_without_phase(job: RotorJob, row: int, u: ComplexArray) -> float:
    """Amplitude after the correction u from the squares of the amplitudes measured, without any circle.

    With weights in plane p alone A² = c + 2 Re(b* w) + s |w|² is linear in c, b and s.  Planes together add
    2 Re(H_p u_p (H_q u_q)*), and y0* H_p is conj(b_p), so that term is 2 Re(b_p* u_p (b_q* u_q)*) / c.

    nan where the runs do not determine it (two trial positions in a plane that is used).
    """
    used = [plane for plane in range(len(job.planes)) if u[plane]]
    found = [_squares(job, row, plane, complex(u[plane])) for plane in used]
    speed, sensor = job.readings[row]
    as_found = [abs(run.readings[sensor]) ** 2 for run in job.runs_at(speed) if run.is_initial]
    if any(one is None for one in found):
        return float("nan")
    known = [one for one in found if one is not None]
    start = float(np.mean([one[0] for one in known])) if known else float(np.mean(as_found))
    square = start + sum(one[1] for one in known)
    for at, one in enumerate(known):
        for other in known[:at]:
            square += 2.0 * (one[2] * other[2].conjugate()).real / start if start > 0.0 else float("nan")
    return float(np.sqrt(max(square, 0.0)))


def _squares(job: RotorJob, row: int, plane: int, u: complex) -> tuple[float, float, complex] | None:
    """(square as found, what u adds to it, b* u) by least squares over the runs with weights in one plane alone."""
    speed, sensor = job.readings[row]
    runs = [
        run
        for run in job.runs_at(speed)
        if np.count_nonzero(run.weights) <= 1 and (run.is_initial or run.weights[plane])
    ]
    w = np.array([run.weights[plane] for run in runs])
    size = np.abs(w).max()
    F = _features(w / size)
    if np.linalg.matrix_rank(F, tol=1e-9) < 4:
        return None
    squares = np.array([abs(run.readings[sensor]) ** 2 for run in runs])
    theta = np.linalg.lstsq(F, squares, rcond=None)[0]
    added = float(_features(np.array([u / size]))[0, 1:] @ theta[1:])
    return float(theta[0]), added, complex(theta[1], -theta[2]) * u / (2.0 * size)


def _features(w: ComplexArray) -> FloatArray:
    return np.stack([np.ones(len(w)), w.real, w.imag, np.abs(w) ** 2], axis=1)
