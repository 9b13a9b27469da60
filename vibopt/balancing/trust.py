"""How far a balancing answer can be trusted: scatter of readings, bands of what is left, planes that act alike."""

from __future__ import annotations

from functools import cache

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.influence import Identified, Learnt, with_readings
from vibopt.balancing.question import Question, tied
from vibopt.balancing.rotor_job import RotorJob, Scatter
from vibopt.bracketing import halved
from vibopt.errors import counted
from vibopt.records import dataclass

ALIKE = 30.0
"""Condition number from which planes are named as almost alike."""
NEAR = 10.0
"""Condition number from which it is said what the last plane buys."""
SCENARIOS = 200
TAIL = 0.025
"""What lies beyond each end of a band."""
_RINGS, _ANGLES, _CLOSE = 400, 48, 2e-5


@dataclass(frozen=True)
class Noise:
    """Standard deviations of single readings per speed, (n_runs, n_sensors) [SI peak].

    along, across
        In the direction of the reading and at a right angle to it.
    source
        In words, where they come from.
    spare
        Per speed, spare runs from which they were learnt; inf where they are given, 0 where nothing is known of them.
        Deviations learnt from few runs are not well known themselves, so errors follow Student's law in the plane:
        their squares, divided by twice the variance, that of F with 2 and 2 `spare` degrees of freedom.
    """

    along: tuple[FloatArray, ...]
    across: tuple[FloatArray, ...]
    source: str
    spare: tuple[float, ...]


def noise_of(job: RotorJob, identified: Identified) -> Noise | None:
    """Scatter as given, else from what repeated or spare runs show; None where nothing is known of it."""
    if job.scatter is not None:
        pairs = [_given(job.scatter, job, learnt) for learnt in identified.learnt]
        own = (np.inf,) * len(pairs)
        return Noise(tuple(one for one, _ in pairs), tuple(one for _, one in pairs), "scatter as given", own)
    return seen_noise(identified)


def seen_noise(identified: Identified) -> Noise | None:
    """Scatter from what repeated or spare runs show; None where there are none, or no scatter."""
    if not any(learnt.spare > 0 for learnt in identified.learnt):
        return None
    seen = tuple(_seen(learnt) for learnt in identified.learnt)
    if all(float(one.max()) == 0.0 for one in seen):
        return None
    spare = sum(max(learnt.spare, 0) for learnt in identified.learnt)
    source = f"scatter from {counted(spare, 'runs')} more than unknowns"
    return Noise(seen, seen, source, tuple(float(max(learnt.spare, 0)) for learnt in identified.learnt))


def _given(scatter: Scatter, job: RotorJob, learnt: Learnt) -> tuple[FloatArray, FloatArray]:
    size = np.abs(learnt.read)
    along = np.hypot(scatter.ratio * size, scatter.amplitude)
    return along, np.hypot(scatter.angle * size, 0.0 if scatter.angle else along)


def _seen(learnt: Learnt) -> FloatArray:
    """Standard deviation per direction from the misfit, the same for every run of a sensor."""
    if learnt.spare < 1:
        return np.zeros(learnt.readings.shape)
    variance = (np.abs(learnt.misfit) ** 2).sum(axis=0) / (2.0 * learnt.spare)
    sd: FloatArray = np.broadcast_to(np.sqrt(variance), learnt.readings.shape).copy()
    sd[:, np.sqrt(variance) < 1e-9 * np.abs(learnt.readings).max()] = 0.0
    return sd


def covariances(job: RotorJob, identified: Identified, noise: Noise, u: ComplexArray) -> FloatArray:
    """Covariance (real, imaginary) of what is left after u (..., n_planes), per row (..., n_rows, 2, 2) [SI²]."""
    found = []
    for learnt, along, across in zip(identified.learnt, noise.along, noise.across, strict=True):
        turn = learnt.weights_of(u)[..., None] * learnt.turn
        found.append(_covariance(turn * along) + _covariance(1j * turn * across))
    return np.concatenate(found, axis=-3)


def _covariance(steps: ComplexArray) -> FloatArray:
    """Of the sum of independent steps (..., n_runs, n_sensors), per sensor."""
    x, y = steps.real, steps.imag
    xy = (x * y).sum(axis=-2)
    return np.stack([np.stack([(x * x).sum(axis=-2), xy], -1), np.stack([xy, (y * y).sum(axis=-2)], -1)], -2)


def bands(job: RotorJob, identified: Identified, noise: Noise, u: ComplexArray) -> FloatArray:
    """Ends of the 95 % band of the amplitude left, per row (n_rows, 2) [SI peak]; nan where no scatter is known."""
    left = identified.residual(u)
    spare = np.repeat(noise.spare, [learnt.readings.shape[1] for learnt in identified.learnt])
    every = zip(left, covariances(job, identified, noise, u), spare, strict=True)
    return np.array([_band(z, cov, own) for z, cov, own in every])


def _band(z: complex, covariance: FloatArray, spare: float) -> tuple[float, float]:
    """Amplitudes that the true phasor may have when z was predicted, each end missed once in forty times.

    The upper end is the 97.5 % point of |z + error|.  The lower end is the least amplitude at which predictions as
    large as z are no rarer than 2.5 %, or the 2.5 % point of |z + error| where that is lower: where the optimiser has
    made z small itself, the errors alone are left; where it has not, a small amplitude is hidden by them.
    """
    if not spare > 0.0:
        return float("nan"), float("nan")
    values, axes = np.linalg.eigh(covariance)
    main = np.sqrt(np.maximum(values, 0.0))
    unit = _likely(spare)
    turned = axes @ (main[:, None] * np.stack([unit.real, unit.imag]))
    errors = turned[0] + 1j * turned[1]
    low, high = np.quantile(np.abs(z + errors), [TAIL, 1.0 - TAIL], method="hazen")
    return min(float(low), _least(z, errors)), float(high)


@cache
def _likely(spare: float) -> ComplexArray:
    """Equally likely errors of variance one estimated from `spare` runs, instead of dice."""
    beyond = 1.0 - (np.arange(_RINGS) + 0.5) / _RINGS
    squares = -np.log(beyond) if np.isinf(spare) else spare * (beyond ** (-1.0 / spare) - 1.0)
    angles = 2.0 * np.pi * (np.arange(_ANGLES) + 0.5) / _ANGLES
    return np.outer(np.sqrt(2.0 * squares), np.exp(1j * angles)).ravel()


def _least(z: complex, errors: ComplexArray) -> float:
    """Least true amplitude, in the direction of z, with which |z| or more is predicted in 2.5 % of all cases."""
    size = abs(z)
    way = z / size if size > 0.0 else 1.0

    def rare(true: float) -> bool:
        return float((np.abs(true * way + errors) >= size).mean()) < TAIL

    if not rare(0.0):
        return 0.0
    return halved(rare, 0.0, size, least=_CLOSE * size)[0]


def mean_rows(job: RotorJob, identified: Identified, noise: Noise) -> tuple[ComplexArray, ComplexArray, FloatArray]:
    """Rows whose squares add the mean square of the errors: y0, H and importance, to stand below the nominal ones."""
    y0, H, importance = [], [], []
    for learnt, along, across in zip(identified.learnt, noise.along, noise.across, strict=True):
        c0, C = learnt.affine(len(job.planes))
        for sensor, one in enumerate(job.sensors):
            sd = np.sqrt(along[:, sensor] ** 2 + across[:, sensor] ** 2)
            y0.append(sd * c0)
            H.append(sd[:, None] * C)
            importance.append(np.full(len(sd), one.importance))
    return np.concatenate(y0), np.concatenate(H), np.concatenate(importance)


def scenario_rows(identified: Identified, noise: Noise) -> tuple[ComplexArray, ComplexArray]:
    """y0 and H of SCENARIOS rotors that would have given the readings within their scatter, stacked.

    Always the same ones: the errors are drawn with a fixed seed.
    """
    dice = np.random.default_rng(0)
    y0, H = [], []
    for _ in range(SCENARIOS):
        errors = []
        for learnt, along, across in zip(identified.learnt, noise.along, noise.across, strict=True):
            drawn = dice.standard_normal((2, *along.shape))
            errors.append(learnt.turn * (along * drawn[0] + 1j * across * drawn[1]))
        one_y0, one_H = with_readings(identified, errors)
        y0.append(one_y0)
        H.append(one_H)
    return np.concatenate(y0), np.concatenate(H)


@dataclass(frozen=True)
class Conditioning:
    """How well the sensors tell the planes apart.

    number
        Condition number of H with its columns scaled to one length (planes without any effect are left out).
    alike
        Planes that act almost alike, by index; empty where all are told apart.
    near
        These, or planes that act nearly alike, which are compared with fewer planes.

    """

    number: float
    alike: tuple[int, ...] = ()
    near: tuple[int, ...] = ()


def conditioning(question: Question, free: tuple[int, ...]) -> Conditioning:
    """Condition number over the `free` planes, and which of them are to be confused; of a pair it is its first."""
    if question.pairs:
        both, many = tied(question.n_planes, question.pairs), question.n_readings
        first = np.argmax(both != 0.0, axis=0).tolist()
        alone = Question(
            question.y0, question.H @ both, question.importance, np.full(many, np.inf), np.full(len(first), np.inf)
        )
        found = conditioning(alone, tuple(k for k, plane in enumerate(first) if plane in free))
        return Conditioning(found.number, *(tuple(first[k] for k in some) for some in (found.alike, found.near)))
    size = np.sqrt(question.square.diagonal().real)
    least = 1e-12 * size[list(free)].max(initial=0.0)
    felt = [plane for plane in free if size[plane] > least]
    if len(felt) < 2:
        return Conditioning(1.0)
    level = question.square[felt][:, felt] / (size[felt, None] * size[felt])
    squares = 1.0 + np.array([-1.0, 1.0]) * abs(level[0, 1]) if len(felt) == 2 else np.linalg.eigvalsh(level)
    if squares[-1] < NEAR**2 * squares[0]:  # so small a number loses no digits by its square
        return Conditioning(float(np.sqrt(squares[-1] / squares[0])))
    A = question.triangle[:, felt]
    level = A / np.sqrt((A.real**2 + A.imag**2).sum(axis=0))
    values = np.linalg.svd(level, compute_uv=False)
    values = np.append(values, np.zeros(len(felt) - len(values)))
    number = float(values[0] / values[-1]) if values[-1] > 1e-16 * values[0] else float("inf")
    if number < NEAR:
        return Conditioning(number)
    weak = np.abs(np.linalg.svd(level)[2][-1])
    near = tuple(felt[column] for column in np.flatnonzero(weak > 0.3 * weak.max()))
    return Conditioning(number, near if number >= ALIKE else (), near)
