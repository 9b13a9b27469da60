"""Runs that contradict each other, and planes of which the runs say nothing.

What readings Y of n runs have beyond the unknowns is N* Y, N the left null space of X = (1, weights): errors alone.
With the scatter given its square, measured by its covariance, follows chi-squared.  Learnt from the runs, a run that is
left out takes a part of the squares that follows the beta law, sensor by sensor.  Sets of runs that agree are those
whose squares are not too rare; the odd runs are known where one such set alone is left and all others are far rarer.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from math import comb

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.influence import Identified, Learnt, leverage
from vibopt.balancing.rotor_job import RotorJob
from vibopt.balancing.trust import Noise
from vibopt.records import dataclass, replace
from vibopt.work import Budget

ODD = 0.01
"""Runs that belong together contradict each other in one job of a hundred."""
CLEAR = 1e-4
"""With the scatter given, sets of runs are no longer suspected where what the others show is rarer than this: it
happens to the odd ones in one job of ten thousand.  Learnt scatter compares with the best set, where ODD is as far."""
DOUBT = 0.20
"""From here on the band holds what each run alone could have spoilt."""
UNCHECKED = 0.98
"""A run that decides its own fit by so much is checked by no other."""
WILD = 0.20
"""Part of the greatest reading of a sensor from which one spare run contradicts the others whatever the scatter."""
_ROUNDING = 1e-9
_MOST_ODD = 3
_MOST_SETS = 3000

Runs = tuple[int, ...]
"""Places among the runs at one speed."""


@dataclass(frozen=True)
class Agreement:
    """What the runs at one speed say of each other.

    chance
        That runs with nothing but their scatter differ as much, 0 to 1; 1 where nothing can be told.
    out
        Runs left out, by their index in the job.
    possible
        Sets of runs, by index, one of which may be the odd ones; empty where that is known or none is.
    told
        Whether it is known which runs are odd, or that none is.
    unchecked
        Runs that no other checks, by index.
    alone
        Where the scatter is learnt from one spare run: runs each of which may be all that is wrong, by index.
    """

    speed: int
    chance: float
    out: Runs = ()
    possible: tuple[Runs, ...] = ()
    told: bool = True
    unchecked: Runs = ()
    alone: tuple[Runs, ...] = ()


def agreements(job: RotorJob, identified: Identified, noise: Noise | None) -> tuple[Agreement, ...]:
    """What the runs say of each other, per speed; `noise` counts where the scatter is given."""
    given = noise if job.scatter is not None else None
    many = max(sum(one.spare > 0 for one in identified.learnt), 1)
    found = []
    for speed, learnt in enumerate(identified.learnt):
        scatter = None if given is None else (given.along[speed], given.across[speed])
        checked = learnt.spare > 0
        found.append(_at_speed(job, speed, _Runs(learnt, scatter), many) if checked else Agreement(speed, 1.0))
    return tuple(found)


def _at_speed(job: RotorJob, speed: int, runs: _Runs, many: int) -> Agreement:
    places, spare = np.array(job.places[speed]), runs.learnt.spare
    if runs.exact:
        return Agreement(speed, 1.0)
    unchecked = tuple(int(places[k]) for k in np.flatnonzero(leverage(runs.learnt) > UNCHECKED))
    if spare == 1 and runs.scatter is None:
        alone = tuple((int(places[k]),) for (k,) in runs.sets(1) if int(places[k]) not in unchecked)
        wild = runs.apart() > WILD
        possible = alone if wild else ()
        return Agreement(speed, 1.0, possible=possible, told=not wild, unchecked=unchecked, alone=alone)
    chance = min(many * runs.chance(), 1.0)
    if chance >= DOUBT:
        return Agreement(speed, chance, unchecked=unchecked)
    clear = chance < ODD
    cleared = CLEAR if clear and runs.scatter is not None else ODD
    budget = Budget(_MOST_SETS, "sets of runs")
    doubtful: list[Runs] = []
    for count in range(1, min(spare, _MOST_ODD) + 1 if clear else 2):
        if budget.spent + comb(runs.n, count) > budget.most:
            break
        budget.spend(comb(runs.n, count))
        chances = {tuple(int(places[k]) for k in one): p for one, p in runs.agreeing(count).items()}
        likely = [one for one, p in chances.items() if p >= ODD]
        doubtful += [one for one, p in chances.items() if p >= cleared]
        if likely == doubtful and len(likely) == 1 and clear and spare > count:
            return Agreement(speed, chance, out=likely[0], unchecked=unchecked)
        if likely:
            return Agreement(speed, chance, possible=tuple(doubtful), told=not clear, unchecked=unchecked)
    alone = tuple((int(places[k]),) for (k,) in runs.sets(1))
    return Agreement(speed, chance, possible=alone, told=not clear, unchecked=unchecked)


class _Runs:
    """The runs at one speed, and how likely sets of them are."""

    def __init__(self, learnt: Learnt, scatter: tuple[FloatArray, FloatArray] | None) -> None:
        self.learnt, self.scatter = learnt, scatter
        self.X, self.Y = learnt.design, learnt.readings
        self.X = self.X / np.maximum(np.abs(self.X).max(axis=0), 1e-300)
        self.n, self.unknown = self.X.shape
        self.size = float(np.abs(self.Y).max(initial=0.0))
        self.floor = (_ROUNDING * self.size) ** 2

    @property
    def exact(self) -> bool:
        """Whether nothing but rounding contradicts."""
        return float(np.abs(self.learnt.misfit).max(initial=0.0)) <= _ROUNDING * self.size

    def apart(self) -> float:
        """How far the run that is checked best would have to be off with one spare run, in greatest readings."""
        misfit, size = np.abs(self.learnt.misfit), np.abs(self.Y).max(axis=0)
        off = (misfit**2).sum(axis=0) / np.maximum(misfit.max(axis=0), 1e-300)
        return float((off / np.maximum(size, _ROUNDING * self.size)).max())

    def sets(self, count: int) -> list[Runs]:
        """Sets of so many runs without which the others still tell every unknown."""
        found = []
        for out in combinations(range(self.n), count):
            kept = np.setdiff1d(np.arange(self.n), out)
            values = np.linalg.svd(self.X[kept], compute_uv=False)
            if len(kept) >= self.unknown and values[-1] > 1e-6 * values[0]:
                found.append(out)
        return found

    def chance(self) -> float:
        """That runs which agree differ as much as these."""
        from scipy.special import chdtrc, gammaincc

        if self.scatter is not None:
            return float(chdtrc(2.0 * self.learnt.spare * self.Y.shape[1], self._squares(()).sum()))
        rarest = min((float(gammaincc(self.Y.shape[1], self._taken(one))) for one in self.sets(1)), default=1.0)
        return float(min(self.n * rarest, 1.0))

    def agreeing(self, count: int) -> dict[Runs, float]:
        """Sets of so many runs, and how rarely agreeing runs would differ as much as the others do."""
        spare, sensors = self.learnt.spare - count, self.Y.shape[1]
        sets = self.sets(count)
        if spare < 1:
            return dict.fromkeys(sets, 1.0) if self.scatter is not None else {}
        if self.scatter is not None:
            from scipy.special import chdtrc

            return {one: float(chdtrc(2.0 * spare * sensors, self._squares(one).sum())) for one in sets}
        return self._near_the_best(sets, spare)

    def _near_the_best(self, sets: Sequence[Runs], spare: int) -> dict[Runs, float]:
        """How rarely the rest of each set scatters so much more than the rest of the best one."""
        from scipy.special import fdtrc, gammaincc

        squares = np.array([self._squares(one) for one in sets]) + self.floor
        if not len(squares):
            return {}
        best = squares[int(np.argmin(np.log(squares).sum(axis=1)))]
        rare = np.maximum(fdtrc(2.0 * spare, 2.0 * spare, squares / best), 1e-300)
        total = -np.log(np.minimum(2.0 * rare, 1.0)).sum(axis=1)
        return {one: float(gammaincc(squares.shape[1], x)) for one, x in zip(sets, total, strict=True)}

    def _taken(self, out: Runs) -> float:
        """Minus the logarithms of the chances that a run left out takes away so much, added up over the sensors."""
        rest, whole = self._squares(out) + self.floor, self._squares(()) + self.floor
        return float(-(self.learnt.spare - 1) * np.log(np.minimum(rest / whole, 1.0)).sum())

    def _squares(self, out: Runs) -> FloatArray:
        """Squares of the errors of the other runs per sensor; in units of the scatter where it is given."""
        kept = np.setdiff1d(np.arange(self.n), out)
        left = np.linalg.svd(self.X[kept])[0][:, self.unknown :]
        errors = left.conj().T @ self.Y[kept]
        if self.scatter is None:
            return np.asarray((np.abs(errors) ** 2).sum(axis=0))
        turn = self.learnt.turn[kept]
        return np.array([
            _in_scatter(errors[:, s], left, turn[:, s], *(one[kept, s] for one in self.scatter))
            for s in range(self.Y.shape[1])
        ])  # fmt: skip


def _in_scatter(
    errors: ComplexArray, left: ComplexArray, turn: ComplexArray, along: FloatArray, across: FloatArray
) -> float:
    """errors' C⁻¹ errors, C the covariance of the real and imaginary parts that single readings give them."""
    steps = left.conj().T * turn
    both = np.concatenate([steps * along, 1j * steps * across], axis=1)
    flat = np.concatenate([both.real, both.imag])
    covariance = flat @ flat.T
    values, axes = np.linalg.eigh(covariance)
    part = axes.T @ np.concatenate([errors.real, errors.imag])
    return float((part**2 / np.maximum(values, 1e-12 * max(values.max(), 1e-300))).sum())


def without(job: RotorJob, out: Sequence[int]) -> RotorJob:
    """The job with these runs left out as well."""
    return replace(job, odd=tuple(sorted({*job.odd, *out})))


_UNFELT = 1e-9
"""Part of the greatest reading below which a difference of readings is rounding."""
_SPREADS = 2.0
"""Standard deviations of a coefficient below which it is scatter."""


def without_insensitive(
    job: RotorJob, identified: Identified, noise: Noise | None
) -> tuple[Identified, tuple[int, ...]]:
    """The rotor with zero for the effect of planes that no sensor feels at any speed, and those planes."""
    moves = np.zeros(len(job.planes), dtype=bool)
    row = 0
    for speed, learnt in enumerate(identified.learnt):
        rows, planes = slice(row, row + learnt.readings.shape[1]), list(learnt.planes)
        moves |= (learnt.known != 0.0).any(axis=0)
        effect = identified.H[rows, planes] if learnt.ways is None else learnt.theta[1:].T
        felt = (np.abs(effect) > _floor(learnt, noise, speed)).any(axis=0)
        moves[planes] |= felt if learnt.ways is None else (np.abs(learnt.ways.rows[felt]) > _UNFELT).any(axis=0)
        if moves.all():
            return identified, ()
        row = rows.stop
    idle = tuple(int(plane) for plane in np.flatnonzero(~moves) if not job.planes[plane].keep)
    if not idle:
        return identified, ()
    H = identified.H.copy()
    H[:, list(idle)] = 0.0
    return replace(identified, H=H), idle


def _floor(learnt: Learnt, noise: Noise | None, speed: int) -> FloatArray:
    """Size below which a coefficient is rounding or scatter [SI peak per kg m], (n_sensors or 1, n_learnt)."""
    weights = np.abs(learnt.design[:, 1:]).max(axis=0)
    rounding: FloatArray = (_UNFELT * float(np.abs(learnt.readings).max()) / weights)[None]
    if noise is None:
        return rounding
    variance = (noise.along[speed] ** 2 + noise.across[speed] ** 2).T @ np.abs(learnt.pseudo[1:].T) ** 2
    return np.asarray(np.maximum(rounding, _SPREADS * np.sqrt(0.5 * variance)))


def idle_words(job: RotorJob, idle: tuple[int, ...]) -> tuple[str, ...]:
    """What is said of planes that no sensor feels."""
    return tuple(
        f"No sensor feels a weight in plane {job.planes[plane].name} beyond the scatter of its readings: it gets none. "
        "A heavier trial weight there may tell more."
        for plane in idle
    )
