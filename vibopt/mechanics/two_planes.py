"""A rotor as built in both planes at once, in real numbers: how fast its free motion grows, and from which spin on."""

from __future__ import annotations

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.bracketing import crossing

_NEUTRAL = 1e-12
"""Part of the greatest rate below which one is rounding of zero, where some motion has no damping."""


def threshold_in_planes(mass: FloatArray, damping: FloatArray, rotating: FloatArray, stiffness: FloatArray) -> float:
    """Least spin [rad/s] beyond which free motion grows; matrices (n, n), `damping` all of it.

    Forces on x and y under the damping and a rotating C_i that feels the spin W: K x + W C_i y, K y - W C_i x.
    Bisected between rest and a spin at which something grows.
    """
    from scipy.linalg import block_diag, eigvals

    if not rotating.any():
        return float("inf")
    rate = float(np.sqrt(np.abs(stiffness).max() / np.abs(mass).max())) or 1.0

    n, unit = len(mass), np.eye(2)
    drag, spring = np.kron(unit, damping / rate), np.kron(unit, stiffness / rate**2)
    cross = np.kron(np.array([[0.0, 1.0], [-1.0, 0.0]]), rotating / rate)
    heavy = block_diag(np.eye(2 * n), np.kron(unit, mass))

    def parts(spin: float) -> FloatArray:
        """Of all rates, the greatest first; what has no mass has none."""
        state = np.block([[np.zeros((2 * n, 2 * n)), np.eye(2 * n)], [-spring - spin / rate * cross, -drag]])
        if mass.any(axis=1).all():
            return np.sort(np.linalg.eigvals(np.linalg.solve(heavy, state)).real)[::-1]
        above, below = eigvals(state, heavy, homogeneous_eigvals=True)
        finite = np.abs(below) > 1e-9 * np.abs(above)
        return np.sort((above[finite] / below[finite]).real)[::-1]

    at_rest = parts(1e-3 * rate)
    undamped = int((np.abs(at_rest) <= _NEUTRAL * float(np.linalg.norm(spring) / np.abs(mass).max()) ** 0.5).sum())

    def growth(spin: float) -> float:
        """Greatest part of a rate that is not that of a motion without damping."""
        every = parts(spin)
        return float(every[0] if not undamped or every[0] > _NEUTRAL else every[undamped])

    low, high = 0.0, rate
    for _ in range(200):
        if growth(high) > 0.0:
            break
        low, high = high, 1.3 * high
    else:
        return float("inf")
    while low == 0.0 and growth(0.5 * high) > 0.0:
        high *= 0.5
        if high < 1e-6 * rate:
            return 0.0
    return crossing(growth, low or 0.5 * high, high, 1e-14)[1]
