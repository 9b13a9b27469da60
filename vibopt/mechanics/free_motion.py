"""Free vibration of the machine as built: ratios in a mode, and motion some time after it is let go."""

from __future__ import annotations

import numpy as np

from vibopt.arrays import FloatArray

TOGETHER = 1e-6
"""Relative distance of natural frequencies below which modes count as one."""
_STILL = 1e-12
_TERMS = 24


def shape_ratio(omega: FloatArray, shapes: FloatArray, mode: int, of: FloatArray, to: FloatArray) -> float:
    """Motion over motion in one mode, with its sign.

    Parameters
    ----------
    omega, shapes
        Natural frequencies, ascending (n,) [rad/s], and mode shapes (n, n_modes).
    mode
        Counted from 1.
    of, to
        Rows that read both motions, (n,).

    Returns
    -------
    float
        Infinite where `to` stands still, or where another mode has the same frequency.
    """
    at = omega[mode - 1]
    alone = int((np.abs(omega - at) <= TOGETHER * max(float(at), 1e-300)).sum()) == 1
    shape = shapes[:, mode - 1]
    above, below = float(of @ shape), float(to @ shape)
    size = float(np.abs(shape).max() * np.abs(to).max())
    return above / below if alone and abs(below) > _STILL * size else float("inf")


def propagated(
    mass: FloatArray, damping: FloatArray, stiffness: FloatArray, start: FloatArray, after: float
) -> FloatArray:
    """Displacements (n,) [m] `after` a time [s] of M x'' + C x' + K x = 0.

    `start` (n, 2) holds displacements [m] and velocities [m/s].  Taylor's series over a short step, doubled.
    """
    n = len(mass)
    inverse = np.linalg.inv(mass)
    own, drag = inverse @ stiffness, inverse @ damping
    rate = float(np.sqrt(np.abs(own).max(initial=0.0)) + np.abs(drag).max(initial=0.0)) or 1.0 / max(after, 1e-30)
    system = np.block([[np.zeros((n, n)), np.eye(n)], [-own / rate**2, -drag / rate]]) * (rate * after)
    doublings = max(0, int(np.ceil(np.log2(max(float(np.abs(system).sum(axis=1).max()), 1e-300)))) + 1)
    step = system / 2.0**doublings
    term = whole = np.eye(2 * n)
    for power in range(1, _TERMS):
        term = term @ step / power
        whole = whole + term
    for _ in range(doublings):
        whole = whole @ whole
    moved: FloatArray = whole[:n] @ np.concatenate([start[:, 0], start[:, 1] / rate])
    return moved
