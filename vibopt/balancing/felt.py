"""Planes of which the runs say nothing: what a trial changed is rounding, or the scatter of the readings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vibopt.balancing.influence import Identified, Learnt
from vibopt.balancing.job import RotorJob
from vibopt.balancing.trust import Noise

_ROUNDING = 1e-9
"""Part of the greatest reading below which a difference of readings is rounding."""
_SPREADS = 2.0
"""Standard deviations of a coefficient below which it is scatter."""


def felt_only(job: RotorJob, identified: Identified, noise: Noise | None) -> tuple[Identified, tuple[int, ...]]:
    """The rotor with zero for the effect of planes that no sensor feels at any speed, and those planes."""
    H = identified.H.copy()
    felt = np.zeros(len(job.planes), dtype=bool)
    row = 0
    for speed, learnt in enumerate(identified.learnt):
        rows = slice(row, row + learnt.readings.shape[1])
        felt[[plane for plane in range(len(job.planes)) if learnt.known[:, plane].any()]] = True
        for place, plane in enumerate(learnt.planes):
            known = np.abs(H[rows, plane]) > _floor(learnt, place, noise, speed)
            felt[plane] |= bool(known.any())
        row = rows.stop
    idle = tuple(int(plane) for plane in np.flatnonzero(~felt) if not job.planes[plane].keep)
    H[:, list(idle)] = 0.0
    return replace(identified, H=H), idle


def _floor(
    learnt: Learnt, place: int, noise: Noise | None, speed: int
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Size per sensor below which a coefficient is rounding, or scatter [SI peak per kg m], (n_sensors,)."""
    weight = max(abs(run.weights[learnt.planes[place]]) for run in learnt.runs)
    rounding = np.full(learnt.readings.shape[1], _ROUNDING * float(np.abs(learnt.readings).max()) / weight)
    if noise is None:
        return rounding
    own = np.abs(learnt.pseudo[1 + place])
    variance = (own[:, None] ** 2 * (noise.along[speed] ** 2 + noise.across[speed] ** 2)).sum(axis=0)
    return np.asarray(np.maximum(rounding, _SPREADS * np.sqrt(0.5 * variance)))


def idle_words(job: RotorJob, idle: tuple[int, ...]) -> tuple[str, ...]:
    """What is said of planes that no sensor feels."""
    return tuple(
        f"No sensor feels a weight in plane {job.planes[plane].name} beyond the scatter of its readings: it gets none. "
        "A heavier trial weight there may tell more."
        for plane in idle
    )
