"""Linear algebra of the machine as built: real where it can be, singular systems without end, poles with joints."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray

_ROUNDING = 1e-13
"""Part of what springs take from each other below which what is left of them is rounding."""
_NOTHING = 1e-14
"""Part of the greatest singular value up to which one is rounding."""


def pencil_poles(mass: FloatArray, damping: FloatArray, stiffness: ComplexArray) -> ComplexArray:
    """Frequencies of free motion [rad/s] of what has joints, by the finite values of a pencil.

    Joints that no damper reaches keep their balance of springs at every instant, which is a space of motions.
    """
    from scipy.linalg import eigvals, null_space

    quick = ~mass.any(axis=1) & ~damping.any(axis=1)
    size = np.sqrt(np.abs(np.diag(stiffness)) + np.diag(damping))
    size[size == 0.0] = 1.0
    balanced = null_space((stiffness / np.outer(size, size))[quick]) if quick.any() else np.eye(len(mass))
    space = balanced / size[:, None]
    m, c, k = (space.T @ matrix @ space for matrix in (mass, damping, stiffness))
    k = np.where(np.abs(k) > _ROUNDING * (np.abs(space.T) @ np.abs(stiffness) @ np.abs(space)), k, 0.0)
    n, heavy, most = len(m), int(mass.any(axis=1).sum()), float(np.abs(m).max())
    unit = float(np.sqrt(np.abs(k).max() / most)) or float(np.abs(c).max() / most) or 1.0
    left = np.block([[np.zeros((n, n)), np.eye(n)], [-k, -c * unit]])
    right = np.block([[np.eye(n), np.zeros((n, n))], [np.zeros((n, n)), m * unit**2]])
    above, below = eigvals(left, right, homogeneous_eigvals=True)
    finite = np.argsort(np.abs(below) / np.maximum(np.abs(above), 1e-300))[::-1][: n + heavy]
    return np.asarray(-1j * unit * above[finite] / below[finite], dtype=complex)


def inverted(mass: FloatArray) -> FloatArray:
    """Inverse of a mass matrix (n, n); of masses that stand alone to the last digit."""
    own = np.diag(mass)
    return np.diag(1.0 / own) if np.count_nonzero(mass) == len(own) else np.asarray(np.linalg.inv(mass))


def inverse_root(mass: FloatArray) -> FloatArray:
    """R (n, n) with R M R^T = 1."""
    own = np.diag(mass)
    if np.count_nonzero(mass) == len(own):
        return np.diag(1.0 / np.sqrt(own))
    return np.asarray(np.linalg.inv(np.linalg.cholesky(mass)))


def singular(columns: FloatArray) -> FloatArray:
    """Singular values, ascending; of those that are nothing but rounding beside the greatest zero."""
    return settled(np.asarray(np.linalg.svd(columns, compute_uv=False), dtype=float)[::-1])


def settled(sizes: FloatArray) -> FloatArray:
    """Singular values with zero for what is rounding beside the greatest."""
    return np.where(sizes > _NOTHING * sizes.max(initial=0.0), sizes, 0.0)


def nullity(*matrices: FloatArray) -> int:
    """Directions along which none of some positive matrices (n, n) does work."""
    scaled = []
    for matrix in matrices:
        size = np.sqrt(np.where(np.diag(matrix) > 0.0, np.diag(matrix), 1.0))
        scaled.append(matrix / size[:, None] / np.abs(matrix / size[:, None]).max(initial=1e-300))
    rank = int(np.linalg.matrix_rank(np.concatenate(scaled), tol=1e-12))
    return int(matrices[0].shape[0]) - rank


def at_rest(stiffness: FloatArray, load: FloatArray) -> FloatArray | None:
    """Displacements (n,) under a load that stays; None where nothing holds some of them."""
    size = np.sqrt(np.abs(np.diag(stiffness)))
    if not size.all() or np.linalg.cond(scaled := stiffness / np.outer(size, size)) > 1e14:
        return None
    return np.asarray(np.linalg.solve(scaled, load / size) / size)


def steady_solution(elastic: FloatArray, dash: FloatArray, load: ComplexArray) -> ComplexArray:
    """Solve (elastic + i dash) u = load for each frequency, (k, n, n) and (k, n); in real arithmetic where they are."""
    n = load.shape[1]
    if n == 2:
        return _solve_two(elastic + 1j * dash, load)
    if np.iscomplexobj(elastic):
        return np.asarray(np.linalg.solve(elastic + 1j * dash, load[..., None])[..., 0], dtype=complex)
    matrix = np.concatenate([np.concatenate([elastic, -dash], axis=2), np.concatenate([dash, elastic], axis=2)], axis=1)
    both = solved(matrix, np.concatenate([load.real, load.imag], axis=1))
    found: ComplexArray = both[:, :n] + 1j * both[:, n:]
    return found


def _solve_two(matrix: ComplexArray, load: ComplexArray) -> ComplexArray:
    """Solve each of two equations by determinants; a singular one gives inf."""
    (a, b), (c, d) = matrix.transpose(1, 2, 0)
    first, second = load.T
    with np.errstate(all="ignore"):
        found = np.stack([first * d - second * b, second * a - first * c], axis=1) / (a * d - b * c)[:, None]
    return np.where(np.isnan(found), np.inf, found)


def solved(matrix: FloatArray | ComplexArray, right: FloatArray | ComplexArray) -> Any:
    """Solve each system, rows scaled; a singular one gives inf."""
    scale = np.abs(matrix).max(axis=-1, keepdims=True)
    scale[scale == 0.0] = 1.0
    matrix, right = matrix / scale, right / scale[..., 0]
    try:
        return np.linalg.solve(matrix, right[..., None])[..., 0]
    except np.linalg.LinAlgError:
        found = np.full_like(right, np.inf)
        for i, (one, load) in enumerate(zip(matrix, right, strict=True)):
            with suppress(np.linalg.LinAlgError):
                found[i] = np.linalg.solve(one, load)
        return found
