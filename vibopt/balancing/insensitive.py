"""Planes of which the runs say nothing: what a trial changed is rounding, or the scatter of the readings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vibopt.balancing.influence import Identified, Learnt
from vibopt.balancing.job import RotorJob
from vibopt.balancing.trust import Noise
from vibopt.forms import FloatArray

_ROUNDING = 1e-9
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
        moves[planes] |= (np.abs(identified.H[rows, planes]) > _floor(learnt, noise, speed)).any(axis=0)
        row = rows.stop
    idle = tuple(int(plane) for plane in np.flatnonzero(~moves) if not job.planes[plane].keep)
    if not idle:
        return identified, ()
    H = identified.H.copy()
    H[:, list(idle)] = 0.0
    return replace(identified, H=H), idle


def _floor(learnt: Learnt, noise: Noise | None, speed: int) -> FloatArray:
    """Size below which a coefficient is rounding, or scatter [SI peak per kg m], (n_sensors, n_learnt)."""
    weights = np.abs(learnt.design[:, 1:]).max(axis=0)
    rounding = np.tile(_ROUNDING * float(np.abs(learnt.readings).max()) / weights, (learnt.readings.shape[1], 1))
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
