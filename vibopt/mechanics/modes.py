"""Free vibration: poles of det D(w) = 0, natural frequencies, damping ratios."""

from __future__ import annotations

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.model import DAMPING, HYSTERETIC, INERTIA, STIFFNESS, Model


def free_matrices(model: Model, p: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """M, C, K, H on the free coordinates, each (n_free, n_free)."""
    n = model.n_free
    kinds = (INERTIA, DAMPING, STIFFNESS, HYSTERETIC)
    mass, damping, stiffness, hysteretic = (model.matrix(kind, p)[:n, :n] for kind in kinds)
    return mass, damping, stiffness, hysteretic


def poles(model: Model, p: FloatArray) -> ComplexArray:
    """Complex frequencies w with det D(w) = 0 [rad/s], shape (2 n_free,), time factor e^{i w t}.

    Im w > 0 for decaying motion.
    """
    mass, damping, stiffness, hysteretic = free_matrices(model, p)
    n = model.n_free
    if n == 1:
        return _poles_of_one(mass[0, 0], damping[0, 0], stiffness[0, 0] + 1j * hysteretic[0, 0])
    root = np.linalg.cholesky(mass)
    inverse = np.linalg.inv(root)
    k = inverse @ (stiffness + 1j * hysteretic) @ inverse.T
    c = inverse @ damping @ inverse.T
    if not c.any():
        squares = np.linalg.eigvals(k) if hysteretic.any() else np.linalg.eigvalsh(k.real).astype(complex)
        half = np.sqrt(squares)
        return np.concatenate([half, -half])
    scale = np.sqrt(max(np.abs(k).max(), np.abs(c).max() ** 2))
    first = np.block([[np.zeros((n, n)), np.eye(n)], [k / scale**2, 1j * c / scale]])
    result: ComplexArray = np.linalg.eigvals(first) * scale
    return result


def _poles_of_one(mass: float, damping: float, stiffness: complex) -> ComplexArray:
    """Roots of m w^2 - i c w - k = 0, the small root without cancellation."""
    half = 0.5j * damping / mass
    root = np.sqrt(complex(stiffness / mass) + half * half)
    large = half + root if (half * np.conj(root)).real >= 0 else half - root
    small = -(stiffness / mass) / large if large != 0 else 0.0
    return np.array([large, small], dtype=complex)


def natural_frequencies(model: Model, p: FloatArray) -> FloatArray:
    """Undamped natural frequencies in ascending order [rad/s], shape (n_free,)."""
    mass, _, stiffness, _ = free_matrices(model, p)
    if model.n_free == 1:
        only: FloatArray = np.sqrt(stiffness[0] / mass[0, 0])
        return only
    root = np.linalg.inv(np.linalg.cholesky(mass))
    squares = np.linalg.eigvalsh(root @ stiffness @ root.T)
    found: FloatArray = np.sqrt(np.maximum(squares, 0.0))
    return found


def mode_shapes(model: Model, p: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Natural frequencies (n_free,) [rad/s] and mass-normalised shapes (n_free, n_modes)."""
    mass, _, stiffness, _ = free_matrices(model, p)
    root = np.linalg.inv(np.linalg.cholesky(mass))
    squares, vectors = np.linalg.eigh(root @ stiffness @ root.T)
    return np.sqrt(np.maximum(squares, 0.0)), root.T @ vectors


def damping_ratios(model: Model, p: FloatArray) -> FloatArray:
    """Damping ratio of every oscillating or overdamped mode, ascending, shape (n_modes,).

    Viscous: Im w / |w| of each pole with Re w >= 0; two real decay rates count as one mode
    with the ratio (a + b) / (2 sqrt(a b)).  A rigid-body pole at zero has none and is left out.
    """
    w = poles(model, p)
    size = np.abs(w)
    largest = float(size.max(initial=0.0))
    w = w[size > 1e-9 * largest]
    turning = w[w.real > 1e-9 * np.abs(w)]
    still = np.sort(w[np.abs(w.real) <= 1e-9 * np.abs(w)].imag)
    pairs = [
        (a + b) / (2.0 * np.sqrt(a * b))
        for a, b in zip(still[: len(still) // 2], still[::-1][: len(still) // 2], strict=True)
        if a * b > 0
    ]
    return np.sort(np.concatenate([turning.imag / np.abs(turning), np.array(pairs)]))


def decay_rates(model: Model, p: FloatArray) -> FloatArray:
    """Decay rate of every pole [1/s], Im w, ascending; poles of rigid motion, which are at zero, are left out."""
    w = poles(model, p)
    kept = np.argsort(np.abs(w))[rigid_count(model, p) :]
    return np.sort(np.maximum(w[kept].imag, 0.0))


def rigid_count(model: Model, p: FloatArray) -> int:
    """Number of poles at zero: one per motion that no spring holds, a second one where no damper does either."""
    n = model.n_free
    loose = 0
    for kinds in ((STIFFNESS, HYSTERETIC), (STIFFNESS, HYSTERETIC, DAMPING)):
        rows = model.vectors[np.isin(model.kinds, kinds) & (p > 0.0), :n]
        sizes = np.linalg.norm(rows, axis=1, keepdims=True)
        rows = rows[sizes[:, 0] > 0.0] / sizes[sizes[:, 0] > 0.0]
        loose += n - (int(np.linalg.matrix_rank(rows, tol=1e-10)) if len(rows) else 0)
    return loose


def sag(model: Model, x: FloatArray) -> FloatArray | None:
    """Displacement under all weights [m], shape (n_coords,); None where nothing holds the machine."""
    n = model.n_free
    p = model.values(x, static=True)
    stiff = model.matrix(STIFFNESS, p)[:n, :n]
    load = model.weights(p)[:n] * GRAVITY
    root = np.sqrt(np.abs(np.diag(stiff)))
    if not np.all(root > 0.0):
        return None
    scaled = stiff / np.outer(root, root)
    if np.linalg.cond(scaled) > 1e14:
        return None
    down = np.zeros(model.n_coords)
    down[:n] = np.linalg.solve(scaled, load / root) / root
    return down
