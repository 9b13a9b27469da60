"""From runs to what each weight does: y = y0 + H w, by least squares where there are more runs than unknowns.

Per speed the readings of all runs are X theta with X = (1, weights of the run) and theta = (y0, H).  Whatever is
predicted for a correction u is c(u) times the readings, c(u) = (1, u) X⁺: the initial run enters every coefficient, and
with c(u) the errors of all of them are carried together, their correlation included.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from vibopt.balancing.job import RotorJob, Run
from vibopt.forms import ComplexArray, FloatArray

IntArray = np.ndarray[tuple[int, ...], np.dtype[np.int64]]
_DISAGREES = 25.0
"""A run disagrees where its misfit is this many times the variance of the others."""


@dataclass(frozen=True)
class Learnt:
    """What the runs at one speed say.

    runs
        The runs used, initial ones included.
    planes
        Planes learnt from runs, by index.
    pseudo
        X⁺, shape (1 + n_learnt, n_runs): theta = pseudo @ readings.
    known
        Ready coefficients (n_sensors, n_planes), zero where learnt.
    readings
        Runout subtracted, ready coefficients taken out (n_runs, n_sensors).
    misfit
        Readings less what the fit says (n_runs, n_sensors).
    """

    runs: tuple[Run, ...]
    planes: tuple[int, ...]
    pseudo: ComplexArray
    known: ComplexArray
    readings: ComplexArray
    misfit: ComplexArray

    @property
    def spare(self) -> int:
        """Runs beyond the unknowns."""
        return len(self.runs) - int(self.pseudo.shape[0])

    def weights_of(self, u: ComplexArray) -> ComplexArray:
        """c(u): factors of the readings in the prediction for the correction u, (n_runs,)."""
        c: ComplexArray = np.concatenate([[1.0], u[list(self.planes)]]) @ self.pseudo
        return c

    def affine(self, n_planes: int) -> tuple[ComplexArray, ComplexArray]:
        """c(u) = c0 + C u with c0 (n_runs,), C (n_runs, n_planes)."""
        C = np.zeros((len(self.runs), n_planes), dtype=complex)
        C[:, list(self.planes)] = self.pseudo[1:].T
        return self.pseudo[0], C


@dataclass(frozen=True)
class Identified:
    """The rotor as its runs show it.

    y0, H
        Rows are (speed, sensor) as in `RotorJob.readings`; y0 (n_rows,), H (n_rows, n_planes) [SI peak per kg m].
    learnt
        Per speed.
    notes
        Runs that do not agree, in words.
    """

    y0: ComplexArray
    H: ComplexArray
    learnt: tuple[Learnt, ...]
    notes: tuple[str, ...] = ()

    def residual(self, u: ComplexArray) -> ComplexArray:
        left: ComplexArray = self.y0 + self.H @ u
        return left


def identify(job: RotorJob) -> Identified:
    """y0 and H from the runs of a job with phase."""
    learnt = tuple(_learn(job, speed) for speed in range(len(job.speeds)))
    y0, H = zip(*(_model(one, job) for one in learnt), strict=True)
    notes = tuple(note for speed, one in enumerate(learnt) for note in disagreements(job, speed, one))
    return Identified(np.concatenate(y0), np.concatenate(H), learnt, notes)


def with_readings(
    job: RotorJob, identified: Identified, noise: Mapping[int, ComplexArray]
) -> tuple[ComplexArray, ComplexArray]:
    """y0 and H had the readings at each speed been off by `noise` (n_runs, n_sensors)."""
    y0, H = [], []
    for speed, one in enumerate(identified.learnt):
        theta = one.pseudo @ (one.readings + noise[speed])
        y0.append(theta[0])
        H.append(_spread(one, theta, len(job.planes)))
    return np.concatenate(y0), np.concatenate(H)


def _learn(job: RotorJob, speed: int) -> Learnt:
    runs = job.runs_at(speed)
    n_sensors, n_planes = len(job.sensors), len(job.planes)
    known = np.zeros((n_sensors, n_planes), dtype=complex)
    ready = set()
    for (at, sensor, plane), value in job.influence.items():
        if at == speed:
            known[sensor, plane] = value
            ready.add(plane)
    W = np.array([run.weights for run in runs])
    planes = tuple(index for index in range(n_planes) if index not in ready and W[:, index].any())
    readings = np.array([run.readings for run in runs]) - job.runout - W @ known.T
    X = np.concatenate([np.ones((len(runs), 1)), W[:, list(planes)]], axis=1)
    size = np.abs(X).max(axis=0)
    pseudo = np.linalg.pinv(X / size, rcond=1e-13) / size[:, None]
    return Learnt(runs, planes, pseudo, known, readings, readings - X @ (pseudo @ readings))


def _model(learnt: Learnt, job: RotorJob) -> tuple[ComplexArray, ComplexArray]:
    theta = learnt.pseudo @ learnt.readings
    return theta[0], _spread(learnt, theta, len(job.planes))


def _spread(learnt: Learnt, theta: ComplexArray, n_planes: int) -> ComplexArray:
    H = learnt.known.copy()
    H[:, list(learnt.planes)] = theta[1:].T
    return H


def leverage(learnt: Learnt) -> FloatArray:
    """How much each run decides its own fit, (n_runs,), 0 to 1."""
    W = np.array([run.weights for run in learnt.runs])
    X = np.concatenate([np.ones((len(learnt.runs), 1)), W[:, list(learnt.planes)]], axis=1)
    own = np.real(np.einsum("kp,pk->k", X, learnt.pseudo))
    return np.asarray(np.clip(own, 0.0, 1.0), dtype=float)


def disagreements(job: RotorJob, speed: int, learnt: Learnt) -> list[str]:
    """The run that does not agree with the others, named, where enough of them are left to say so."""
    if learnt.spare < 1:
        return []
    size = float(np.abs(learnt.readings).max())
    worst = float(np.abs(learnt.misfit).max())
    if worst <= 1e-9 * size:
        return []
    if learnt.spare < 2:
        return _one_spare(job, speed, learnt, worst, size)
    free = np.maximum(1.0 - leverage(learnt), 1e-12)
    own = (np.abs(learnt.misfit) ** 2).sum(axis=1) / free
    total = float((np.abs(learnt.misfit) ** 2).sum())
    rest = np.maximum(total - own, 0.0) / (learnt.spare - 1)
    run = int(np.argmax(np.where(free > 1e-9, own, 0.0)))
    if own[run] <= _DISAGREES * rest[run]:
        return []
    sensor = int(np.argmax(np.abs(learnt.misfit[run])))
    off = float(np.abs(learnt.misfit[run, sensor]) / free[run])
    return [
        f'Run "{learnt.runs[run].name}" at {job.show_speed(speed)} does not agree with the others: without it they '
        f"would predict a "
        f"reading at {job.sensors[sensor].name} that is {job.sensors[sensor].show(off, 3)} away. Repeat it, or "
        f"leave it out."
    ]


def _one_spare(job: RotorJob, speed: int, learnt: Learnt, worst: float, size: float) -> list[str]:
    """With one spare run only the disagreement itself can be told, not whose it is."""
    if worst < 0.02 * size:
        return []
    run, sensor = np.unravel_index(int(np.argmax(np.abs(learnt.misfit))), learnt.misfit.shape)
    name = job.sensors[int(sensor)]
    return [
        f"The runs at {job.show_speed(speed)} do not agree: the fit misses by up to {name.show(worst, 3)} at "
        f"{name.name} "
        f'(in run "{learnt.runs[int(run)].name}"). With one run to spare nobody can tell which is wrong: repeat one '
        f"of them."
    ]
