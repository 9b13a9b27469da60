"""Many coordinates at many frequencies: the response through complex modes, once per design.

A direct solution costs n^3 per frequency; through the modes it costs n^2.  The decomposition is
tried on direct solutions before it is believed, because nearly defective modes lose digits.
"""

from __future__ import annotations

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.records import dataclass

WORTH = 6
"""Number of coordinates from which the modes are worth their cost."""
_TRUST = 1e-8


@dataclass(frozen=True, slots=True)
class Modal:
    """(-w^2 M + i w C + K)^-1 = shapes diag(1 / (i w - rates)) weights.

    rates (2n,), shapes (n, 2n), weights (2n, n).
    """

    rates: ComplexArray
    shapes: ComplexArray
    weights: ComplexArray

    @property
    def poles(self) -> ComplexArray:
        """Complex frequencies of free motion [rad/s], time factor e^{i w t}; shape (2n,)."""
        return -1j * self.rates

    def motion(self, load: ComplexArray, omega: FloatArray) -> ComplexArray:
        """Displacements (..., n) under loads (..., n) at omega (...) [rad/s]; inf at an undamped mode."""
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            amplitudes = (load @ self.weights.T) / (1j * omega[..., None] - self.rates)
            value: ComplexArray = amplitudes @ self.shapes.T
        return value


def decompose(mass: FloatArray, damping: FloatArray, stiffness: ComplexArray) -> Modal | None:
    """Complex modes of M, C, K (n, n), K complex with structural damping; None where they cannot be trusted."""
    n = len(mass)
    if not mass.any(axis=1).all():  # a joint without mass
        return None
    full, c = np.linalg.solve(mass, stiffness), np.linalg.solve(mass, damping)
    scale = float(np.sqrt(np.abs(full).max()) + np.abs(c).max()) or 1.0
    k = full if full.imag.any() else full.real
    state = np.zeros((2 * n, 2 * n), dtype=k.dtype)
    state[:n, n:] = np.eye(n)
    state[n:, :n] = -k / scale**2
    state[n:, n:] = -c / scale
    try:
        rates, vectors = np.linalg.eig(state)
        inverse = np.linalg.inv(vectors)
    except np.linalg.LinAlgError:
        return None
    weights = np.linalg.solve(mass.T, inverse[:, n:].T).T / scale
    found = Modal((rates * scale).astype(complex), vectors[:n].astype(complex), weights.astype(complex))
    return found if _trusted(found, mass, damping, stiffness) else None


def _trusted(modal: Modal, mass: FloatArray, damping: FloatArray, stiffness: ComplexArray) -> bool:
    """Compare with direct solutions between and beside the modes."""
    turning = np.sort(np.abs(modal.rates.imag))
    picks = turning[:: max(len(turning) // 6, 1)]
    omega = np.concatenate([0.97 * picks, 1.003 * picks, [0.5 * turning[-1]]])
    dynamic = stiffness - omega[:, None, None] ** 2 * mass + 1j * omega[:, None, None] * damping
    load = np.linspace(1.0, 2.0, len(mass)).astype(complex) * np.diag(mass)
    try:
        direct = np.linalg.solve(dynamic, np.broadcast_to(load[:, None], (len(omega), len(mass), 1)))[..., 0]
    except np.linalg.LinAlgError:  # rigid motion, or an undamped mode just there
        return False
    through = modal.motion(np.broadcast_to(load, direct.shape), omega)
    error = np.abs(through - direct).max(axis=1) / np.abs(direct).max(axis=1)
    return bool(np.all(error <= _TRUST))
