"""The finished plan in a simulated rotor: signals over the shaft angle, read again from the file's own numbers.

Another route than the optimiser's: no phasors, no H.  Each run is a cosine over the shaft angle since the reference
pulse, its peak where lag, lead or mark say.  A weight turned on in the sense of rotation by an angle makes its signal
come earlier by that angle.  The plan is a mixture of runs with their weights scaled and turned; the mixture of their
signals is sampled over one turn, and its first harmonic is what the instrument would show.
"""

from __future__ import annotations

import cmath
import re
from collections.abc import Sequence
from contextlib import suppress
from functools import cache
from itertools import chain
from math import pi
from typing import Any

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from vibopt.balancing.conventions import AGAINST, LAG, MARK, WITH
from vibopt.balancing.planes import Plane
from vibopt.balancing.rotor_job import RotorJob, Sensor
from vibopt.balancing.written import Written
from vibopt.errors import QuantityError
from vibopt.units import to_unit
from vibopt.units.spelling import split_detector

_ROUNDING = 1e-11
"""Part of the weights of runs below which what tells them apart is rounding."""
APART = 0.05
"""Part of the greatest difference of runs below which they refine no ready coefficient."""
SAMPLES = 4
"""Of one turn; a signal of one harmonic is known from three."""
_BATCH = 256
"""Rotors that are drawn at once."""
MOST_CELLS = 2_000_000
"""Samples of signals that are in memory at once."""
_TURN = 2.0 * pi * np.arange(SAMPLES) / SAMPLES
_COSINE, _SINE = 2.0 / SAMPLES * np.cos(_TURN), 2.0 / SAMPLES * np.sin(_TURN)
PlanText = tuple[tuple[int, str, bool], ...]
"""What is fitted: plane index, text such as "12.3 g @ 200 deg", whether it is taken away."""
_NUMBER = r"\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*"
_AMOUNT = re.compile(rf"{_NUMBER}(.*)")
_HOLE, _AT = re.compile(r"(.*?)\s+in\s+hole\s+(\d+)", re.IGNORECASE), re.compile(r"\s+at\s+", re.IGNORECASE)


def simulated(job: RotorJob, plan: PlanText) -> FloatArray:
    """Amplitudes that the simulated rotor shows with the plan fitted, per row [SI peak]; nan for strange texts."""
    target = np.zeros(len(job.planes), dtype=complex)
    for plane, text, taken in plan:
        target[plane] += _weight(job, plane, text) * (-1.0 if taken else 1.0)
    shown: FloatArray = _shown(job, target[None])[0]
    return shown


def shown_with(job: RotorJob, sizes: FloatArray, angles: FloatArray, taken: BoolArray) -> FloatArray:
    """Amplitudes that the simulated rotor shows with each of many plans (n_plans, n_rows) [SI peak].

    Parameters
    ----------
    sizes, angles
        Unbalance [kg m] and angle as written [rad] in each plane (n_plans, n_planes).
    taken
        Whether material is taken away there (n_planes,).
    """
    turned = -angles if job.conventions.angles == AGAINST else angles
    targets = np.where(taken, -sizes, sizes) * np.exp(1j * turned)
    block = max(MOST_CELLS // (len(job.runs) * len(job.sensors) * SAMPLES), 1)
    return np.concatenate([_shown(job, targets[at : at + block]) for at in range(0, len(targets), block)])


def _shown(job: RotorJob, targets: ComplexArray) -> FloatArray:
    """Amplitudes with the unbalances `targets` (n_plans, n_planes) added, (n_plans, n_rows) [SI peak]."""
    states = _states(job)
    sizes, peaks = _cosines(job, [run.written for run in job.runs], job.sensors)
    alike: dict[Any, list[int]] = {}
    for speed in range(len(job.speeds)):  # most have the same weights in their runs: all of these at once
        key = (states[list(job.places[speed])].tobytes(), *([-1, speed] if _ready(job, speed) else ()))
        alike.setdefault(key, []).append(speed)
    shown = np.empty((len(targets), len(job.speeds), len(job.sensors)))
    for speeds in alike.values():
        places = np.array([job.places[speed] for speed in speeds])
        signal = _signal(job, speeds[0], states[places[0]], sizes[places], peaks[places], targets)
        shown[:, speeds] = _amplitude(signal)
    return shown.reshape(len(targets), -1)


def kept_with(job: RotorJob, plan: PlanText, bounds: Sequence[tuple[IntArray, float]], count: int) -> list[int]:
    """Of so many rotors how many keep each bound on some rows with the plan fitted: their readings are drawn anew.

    bounds
        Rows and the greatest amplitude left there [SI peak].
    """
    dice, scatter = np.random.default_rng(20), job.scatter
    assert scatter is not None
    target = np.zeros((1, len(job.planes)), dtype=complex)
    for plane, text, taken in plan:
        target[0, plane] += _weight(job, plane, text) * (-1.0 if taken else 1.0)
    states = _states(job)
    shown = np.empty((count, len(job.speeds), len(job.sensors)))
    for speed, places in enumerate(map(list, job.places)):
        size, peak = _cosines(job, [job.runs[place].written for place in places], job.sensors)
        along = np.hypot(scatter.ratio * size, scatter.amplitude)
        across = np.hypot(scatter.angle * size, 0.0 if scatter.angle else along)
        for at in range(0, count, _BATCH):
            off = dice.standard_normal((2, min(_BATCH, count - at), *size.shape))
            x, y = size + along * off[0], across * off[1]
            signal = _signal(job, speed, states[places], np.hypot(x, y), peak + np.arctan2(y, x), target)
            shown[at : at + _BATCH, speed] = _amplitude(signal[0])
    every = shown.reshape(count, -1)
    return [int((every[:, rows] <= bound).all(axis=1).sum()) for rows, bound in bounds]


def _states(job: RotorJob) -> ComplexArray:
    """Everything fitted during each run, read again from its text (n_runs, n_planes) [kg m]."""
    states = np.zeros((len(job.runs), len(job.planes)), dtype=complex)
    known: dict[tuple[int, str], complex] = {}
    for index, run in enumerate(job.runs):
        if run.stayed and index:
            states[index] = states[index - 1]
        for one in run.fitted:
            if one not in known:
                known[one] = _weight(job, *one)
            states[index, one[0]] += known[one]
    return states


def _weight(job: RotorJob, plane: int, text: str) -> complex:
    """Unbalance of a weight as written [kg m], its angle where it sits on the shaft, in the sense of rotation."""
    amount, sign, angle = text.replace("−", "-").replace("\n", " ").partition("@")
    hole = None if sign else _HOLE.fullmatch(amount)
    if not sign and hole is None:
        return complex("nan")
    size = _unbalance(amount if hole is None else hole[1], job.planes[plane])
    turned = _value(angle, "angle") if hole is None else job.planes[plane].holes[int(hole[2]) - 1]
    return size * cmath.exp(1j * (-turned if job.conventions.angles == AGAINST else turned))


def _unbalance(text: str, plane: Plane) -> float:
    """Of an amount, which is a mass at its own radius or that of its plane, or an unbalance [kg m]."""
    amount, *radius = _AT.split(text, maxsplit=1)
    try:
        mass = _value(amount, "mass")
    except QuantityError:
        return _value(amount, "unbalance")
    return mass * (_value(radius[0], "length") if radius else max(plane.radii, default=1.0))


def _value(text: str, dimension: str) -> float:
    """SI value of a number with its unit."""
    match = _AMOUNT.fullmatch(text)
    if match is None:
        return float("nan")
    return float(match[1]) * _unit(match[2].strip(), dimension)


@cache
def _unit(unit: str, dimension: str) -> float:
    """SI value, for amplitudes peak, of one unit as answers are shown in it."""
    return 1.0 / to_unit(1.0, unit, dimension)


def _cosines(
    job: RotorJob, written: Sequence[Written | None], sensors: Sequence[Sensor]
) -> tuple[FloatArray, FloatArray]:
    """Sizes [SI peak] of readings and shaft angles of their peaks since the reference pulse (n_runs, n_sensors)."""
    size, angle = np.full((2, len(written), len(sensors)), np.nan)
    alike: dict[tuple[tuple[str, ...], tuple[str, ...]], dict[int, Written]] = {}
    for row, one in enumerate(written):
        if one is not None:
            alike.setdefault((one.units, one.turns), {})[row] = one
    for (units, turns), own in alike.items():
        scales = [_reading_unit(s.dimension, s.unit, s.detector, unit) for s, unit in zip(sensors, units, strict=True)]
        size[list(own)] = _numbers([one.amounts for one in own.values()]) * scales
        angle[list(own)] = _numbers([one.angles for one in own.values()]) * [
            _unit(turn, "angle") if turn else 1.0 for turn in turns
        ]
    return size, _sense(job) * angle


def _numbers(rows: Sequence[Sequence[str]]) -> FloatArray:
    """Rows of numbers as they stand in the file; zero where there is none."""
    count = sum(map(len, rows))
    try:
        found = np.fromiter(map(float, chain.from_iterable(rows)), float, count)
    except ValueError:
        found = np.array([float(text or "0") for text in chain.from_iterable(rows)])
    return found.reshape(len(rows), -1)


@cache
def _reading_unit(dimension: str, usual: str, other: str, unit: str) -> float:
    """SI value of one unit of a reading: its own, else the usual one of the sensor; the same for its detector."""
    own, detector, _ = split_detector(unit)
    return _unit(f"{own or split_detector(usual)[0]} {detector or other}", dimension)


def _sense(job: RotorJob) -> float:
    """Shaft angle at which a vibration peaks over the angle written."""
    conventions = job.conventions
    late = conventions.angles == WITH if conventions.readings == MARK else conventions.phase == LAG
    return 1.0 if late else -1.0


def _ready(job: RotorJob, speed: int) -> list[int]:
    return sorted({plane for at, _, plane in job.influence if at == speed})


def _mixture(ready: Sequence[int], states: ComplexArray, targets: ComplexArray) -> ComplexArray:
    """Smallest shares of the runs (n_plans, n_runs) that together carry each plan (and one rotor as found)."""
    weighed = np.logical_or.reduce(states).nonzero()[0].tolist()
    learnt = [plane for plane in weighed if plane not in ready] or weighed
    both = np.ones((1 + len(learnt), len(states) + len(targets)), dtype=complex)
    both[1:, : len(states)], both[1:, len(states) :] = states[:, learnt].T, targets[:, learnt].T
    rows, wanted = both[:, : len(states)], both[:, len(states) :]
    size = np.abs(rows).max(axis=1)[:, None]
    refined = bool(set(ready) & set(learnt))
    if not refined and len(rows) == len(states):  # as many runs as unknowns: no share is free
        with suppress(np.linalg.LinAlgError):
            alone = np.asarray(np.linalg.inv(rows / size))
            if np.abs(alone).max() < 1.0 / _ROUNDING:  # runs of both weights of a pair may be alike up to rounding
                return np.asarray((alone @ (wanted / size)).T)
    shares: ComplexArray = np.linalg.lstsq(rows / size, wanted / size, rcond=APART if refined else _ROUNDING)[0].T
    return shares


def _signal(
    job: RotorJob, speed: int, states: ComplexArray, sizes: FloatArray, peaks: FloatArray, targets: ComplexArray
) -> FloatArray:
    """What the sensors show over one turn with each plan (n_plans, n_speeds, n_sensors, SAMPLES) [SI peak].

    Sizes and peaks (n_speeds, n_runs, n_sensors) are those at speeds that have the same weights `states` in their
    runs (n_runs, n_planes), or at one speed where there are ready coefficients.
    """
    ready = _ready(job, speed)
    shares = _mixture(ready, states, targets)
    shifted = _TURN + np.arctan2(shares.imag, shares.real)[:, None, :, None]
    signals = sizes[..., None] * np.cos(shifted[..., None, :] - peaks[..., None])
    declared = job.document.get("sensors", {})
    for column in [place for place, sensor in enumerate(job.sensors) if declared and sensor.name in declared]:
        name = job.sensors[column].name
        own = Written.of([name], [str(declared[name].get("runout", ""))])
        if own is not None:
            size, peak = _cosines(job, [own], [job.sensors[column]])
            signals[..., column, :] -= size * np.cos(shifted - peak)
    for plane in ready:
        signals -= _unit_signals(job, speed, plane, states[:, plane], shifted)
    mixed = (np.abs(shares)[:, None, :, None, None] * signals).sum(axis=2)
    for plane in ready:
        mixed += _unit_signals(job, speed, plane, targets[:, plane], _TURN)[:, None]
    return np.asarray(mixed)


def _unit_signals(job: RotorJob, speed: int, plane: int, weights: ComplexArray, turns: FloatArray) -> FloatArray:
    """Signals of weights by ready coefficients (..., n_weights, n_sensors, SAMPLES): a unit weight at zero, turned."""
    H = [job.influence.get((speed, sensor, plane), 0.0) for sensor in range(len(job.sensors))]
    peaks = _sense(job) * np.array([job.conventions.reading_angle(complex(one)) for one in H])
    turned = turns + np.angle(weights)[:, None]
    cosines = np.cos(turned[..., None, :] - peaks[:, None])
    return np.asarray(np.abs(weights)[:, None, None] * np.abs(H)[:, None] * cosines)


def _amplitude(signal: FloatArray) -> FloatArray:
    """First harmonic of one turn (..., SAMPLES)."""
    return np.asarray(np.hypot(signal @ _COSINE, signal @ _SINE))


def runs_without_phase(job: RotorJob, y0: ComplexArray, H: ComplexArray) -> FloatArray:
    """Greatest difference per row between what a rotor y0, H shows over a turn in each run and what was read [SI peak].

    Runs with weights in several planes at once are among them, which no circle has seen; those with weights in a plane
    that is kept are not, as nothing is asked of what it does.
    """
    states, n, told = _states(job), len(job.sensors), np.any(H != 0.0, axis=0)
    worst = np.zeros(len(y0))
    for speed in range(len(job.speeds)):
        rows = slice(speed * n, speed * n + n)
        for place in [one for one in job.places[speed] if not states[one, ~told].any()]:
            parts = np.column_stack([y0[rows], H[rows] * states[place]])
            signal = (np.abs(parts)[:, :, None] * np.cos(_TURN + np.angle(parts)[:, :, None])).sum(axis=1)
            off = np.abs(_amplitude(signal) - np.abs(job.runs[place].readings))
            worst[rows] = np.maximum(worst[rows], off)
    return worst


def simulated_without_phase(job: RotorJob, row: int, u: ComplexArray) -> float:
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
