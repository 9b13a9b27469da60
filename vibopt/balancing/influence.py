"""From runs to what each weight does: y = y0 + H w, by least squares where there are more runs than unknowns.

Per speed the readings of all runs are X theta with X = (1, weights of the run) and theta = (y0, H).  Ready coefficients
are refined by runs with weights in their planes: changed as little as reproduces the readings.  Whatever is
predicted for a correction u is c(u) times the readings, c(u) = (1, u) X⁺: the initial run enters every coefficient, and
with c(u) the errors of all of them are carried together, their correlation included.
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from contextlib import suppress

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.rotor_job import RotorJob, Run
from vibopt.records import cached_property, dataclass

EXACT = 1e-13
"""Part of the greatest difference of runs below which one is rounding."""
SAME = 0.05
"""The same where runs refine ready coefficients: what they differ in by less tells more of errors than of the rotor."""
SINGULAR = 1e-9
"""Trial weights whose directions differ by less than this part are the same ones."""
IntArray = np.ndarray[tuple[int, ...], np.dtype[np.int64]]


@dataclass(frozen=True)
class Ways:
    """How weights were fitted in planes that the runs do not tell apart, as a couple or on one side together.

    size
        The greatest unbalance of each plane (n_planes,) [kg m].
    rows
        What adds up to every set of weights over these, orthonormal (n_ways, n_planes).
    """

    size: FloatArray
    rows: ComplexArray

    @classmethod
    def of(cls, W: ComplexArray) -> Ways:
        """Those of the weights of runs (n_runs, n_planes)."""
        size = np.abs(W).max(axis=0, initial=0.0)
        size[size == 0.0] = size.max(initial=0.0) or 1.0  # where nothing was fitted any size will do
        _, singular, rows = np.linalg.svd(W / size, full_matrices=False)
        return cls(size, rows[singular > SINGULAR * singular.max(initial=0.0)])

    @property
    def shares(self) -> ComplexArray:
        """How much of each way weights are: u @ shares, (n_planes, n_ways)."""
        return np.asarray(self.rows.conj().T / self.size[:, None])

    def missed(self, u: ComplexArray) -> FloatArray:
        """The part of each set of weights u (n, n_planes) that is none of the ways, 0 to 1."""
        level = u / self.size
        left = level - level @ self.rows.conj().T @ self.rows
        return np.asarray(np.linalg.norm(left, axis=1) / np.maximum(np.linalg.norm(level, axis=1), 1e-300))


@dataclass(frozen=True)
class Learnt:
    """What the runs at one speed say.

    runs
        The runs used, initial ones included.
    planes
        Planes learnt from runs, by index; where all that have weights are ready, those that the runs refine.
    design, pseudo
        X = (1, weights of the planes learnt) per run, (n_runs, 1 + n_learnt), and X⁺: theta = pseudo @ readings.
    known
        Ready coefficients (n_sensors, n_planes), zero where learnt; what is learnt comes on top.
    readings
        Runout subtracted, ready coefficients taken out (n_runs, n_sensors).
    ways
        Where the runs do not tell these planes apart, in which ways weights were fitted in them: each is learnt as one
        thing; None where each plane is.
    """

    runs: tuple[Run, ...]
    planes: tuple[int, ...]
    design: ComplexArray
    pseudo: ComplexArray
    known: ComplexArray
    readings: ComplexArray
    ways: Ways | None = None

    @cached_property
    def alone(self) -> tuple[int, ...]:
        """Planes of which it is told what a weight there does by itself."""
        if self.ways is None:
            return self.planes
        missed = self.ways.missed(np.eye(len(self.planes), dtype=complex))
        return tuple(plane for plane, part in zip(self.planes, missed.tolist(), strict=True) if part <= SINGULAR)

    def by_planes(self, rows: ComplexArray) -> ComplexArray:
        """What is learnt (n_learnt, ...) as of planes: right for weights fitted in the ways of the runs."""
        return rows if self.ways is None else np.asarray(self.ways.shares @ rows)

    @cached_property
    def theta(self) -> ComplexArray:
        """What the runs say of (y0, H), (1 + n_learnt, n_sensors)."""
        theta: ComplexArray = self.pseudo @ self.readings
        return theta

    @cached_property
    def misfit(self) -> ComplexArray:
        """Readings less what the fit says (n_runs, n_sensors)."""
        return self.readings - self.design @ self.theta

    @cached_property
    def read(self) -> ComplexArray:
        """Readings as they were read, runout included (n_runs, n_sensors)."""
        return np.array([run.readings for run in self.runs])

    @property
    def turn(self) -> ComplexArray:
        """Directions of the readings as they were read, of length one (n_runs, n_sensors)."""
        turn: ComplexArray = np.exp(1j * np.angle(self.read))
        return turn

    @cached_property
    def spare(self) -> int:
        """Runs beyond the unknowns."""
        return len(self.runs) - int(self.pseudo.shape[0])

    def weights_of(self, u: ComplexArray) -> ComplexArray:
        """c(u): factors of the readings (..., n_runs) in the prediction for the correction u (..., n_planes)."""
        c: ComplexArray = self.pseudo[0] + u[..., list(self.planes)] @ self.by_planes(self.pseudo[1:])
        return c

    def affine(self, n_planes: int) -> tuple[ComplexArray, ComplexArray]:
        """c(u) = c0 + C u with c0 (n_runs,), C (n_runs, n_planes)."""
        C = np.zeros((len(self.runs), n_planes), dtype=complex)
        C[:, list(self.planes)] = self.by_planes(self.pseudo[1:]).T
        return self.pseudo[0], C


@dataclass(frozen=True)
class Identified:
    """The rotor as its runs show it.

    y0, H
        Rows are (speed, sensor) as in `RotorJob.readings`; y0 (n_rows,), H (n_rows, n_planes) [SI peak per kg m].
    learnt
        Per speed.
    """

    y0: ComplexArray
    H: ComplexArray
    learnt: tuple[Learnt, ...]

    @cached_property
    def alone(self) -> ComplexArray:
        """H with zeros where the runs tell of planes together, not of each."""
        alone, n = self.H.copy(), len(self.H) // max(len(self.learnt), 1)
        for speed, learnt in enumerate(self.learnt):
            if learnt.ways is not None:
                alone[speed * n : (speed + 1) * n, [k for k in learnt.planes if k not in learnt.alone]] = 0.0
        return alone

    def residual(self, u: ComplexArray) -> ComplexArray:
        """What is left at the readings (..., n_rows) after the correction u (..., n_planes)."""
        left: ComplexArray = self.y0 + u @ self.H.T
        return left


def identify(job: RotorJob) -> Identified:
    """y0 and H from the runs of a job with phase."""
    tried: Tried = {}
    learnt = tuple(_learn(job, speed, tried) for speed in range(len(job.speeds)))
    return Identified(*_stacked(learnt, [one.theta for one in learnt]), learnt)


def with_readings(identified: Identified, noise: Sequence[ComplexArray]) -> tuple[ComplexArray, ComplexArray]:
    """y0 and H had the readings at each speed been off by `noise` (n_runs, n_sensors)."""
    pairs = zip(identified.learnt, noise, strict=True)
    return _stacked(identified.learnt, [learnt.pseudo @ (learnt.readings + off) for learnt, off in pairs])


def _stacked(learnt: Sequence[Learnt], thetas: Sequence[ComplexArray]) -> tuple[ComplexArray, ComplexArray]:
    """y0 and H of all speeds."""
    every = [_spread(one, theta) for one, theta in zip(learnt, thetas, strict=True)]
    return np.concatenate([theta[0] for theta in thetas]), np.concatenate(every)


Tried = dict[tuple[bytes, int, frozenset[int]], tuple[tuple[int, ...], ComplexArray, ComplexArray, Ways | None]]
"""Planes learnt, X, X⁺ and ways by the weights of the runs; at most speeds the same are tried: few are worked out."""


def _told(W: ComplexArray, ready: Set[int]) -> tuple[tuple[int, ...], ComplexArray, ComplexArray, Ways | None]:
    """Planes learnt from weights W (n_runs, n_planes), X, X⁺ by columns at one size, and the ways of the weights."""
    weighed = np.logical_or.reduce(W).nonzero()[0].tolist()
    planes = tuple(index for index in weighed if index not in ready) or tuple(weighed)
    own, refined = W[:, planes], bool(ready & {*planes})
    ways = None if refined or tells_apart(own[own.any(axis=1)]) else Ways.of(own)
    learnt = own if ways is None else own @ ways.shares
    X = np.empty((len(W), 1 + learnt.shape[1]), dtype=complex)
    X[:, 0], X[:, 1:] = 1.0, learnt
    size = np.abs(X).max(axis=0)
    return planes, X, _inverse(X / size, SAME if refined else EXACT) / size[:, None], ways


def tells_apart(W: ComplexArray) -> bool:
    """Whether trial weights (n_trials, n_planes) are different enough to tell every plane."""
    if len(W) < W.shape[1]:
        return False
    if W.nonzero()[0].tolist() == [*range(len(W))]:  # one in each run
        return bool(W.any(axis=0).all())
    singular = np.linalg.svd(W / np.maximum(np.abs(W).max(axis=0), 1e-300), compute_uv=False)
    return not len(singular) or bool(singular[-1] > SINGULAR * singular[0])


def _inverse(X: ComplexArray, same: float) -> ComplexArray:
    """X⁺; singular values below `same` of the greatest are none."""
    if len(X) == X.shape[1]:  # hardly ever singular: then this is the same, and sooner
        with suppress(np.linalg.LinAlgError):
            found = np.asarray(np.linalg.inv(X), dtype=complex)
            if same * np.abs(found).max() * X.size < 1.0:
                return found
    return np.asarray(np.linalg.pinv(X, rcond=same), dtype=complex)


def _learn(job: RotorJob, speed: int, tried: Tried) -> Learnt:
    places = list(job.places[speed])
    known = np.zeros((len(job.sensors), len(job.planes)), dtype=complex)
    ready = set()
    for (at, sensor, plane), value in job.influence.items():
        if at == speed:
            known[sensor, plane] = value
            ready.add(plane)
    W, readings = job.weights[places], job.measured[places]
    key = W.tobytes(), len(W), frozenset(ready)
    tried[key] = tried.get(key) or _told(W, ready)
    planes, design, pseudo, ways = tried[key]
    readings = readings - W @ known.T if ready else readings
    return Learnt(job.runs_at(speed), planes, design, pseudo, known, readings, ways)


def _spread(learnt: Learnt, theta: ComplexArray) -> ComplexArray:
    H = learnt.known.copy()
    H[:, learnt.planes if len(learnt.planes) < H.shape[1] else slice(None)] += learnt.by_planes(theta[1:]).T
    return H


def leverage(learnt: Learnt) -> FloatArray:
    """How much each run decides its own fit, (n_runs,), 0 to 1."""
    own = np.real(np.einsum("kp,pk->k", learnt.design, learnt.pseudo))
    return np.asarray(np.clip(own, 0.0, 1.0), dtype=float)
