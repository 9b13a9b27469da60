"""Lowest natural modes of a structure, and which of them nothing holds."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.mechanics.host.matrices import Matrices, Solved, factored, negative_count, solve
from vibopt.records import dataclass

_DENSE = 120
_LOW = 1e-12
"""Part of the square of the greatest frequency below which a mode may be one that nothing holds."""
_MOST_FREE = 60
_ASSEMBLED = 16.0
"""Roundings of an entry on its way through assembly into a file, as many times that of the sum alone."""
_GAP = 1e4
"""Least ratio of the next stiffness to what rounding may hide where a motion is taken to be free."""

_BESIDE = 1e-3
"""Part of the square of the first frequency of what is held that is as good as standstill."""


def lowest_modes(matrices: Matrices, count: int) -> tuple[FloatArray, FloatArray]:
    """Lowest undamped natural frequencies (k,) [rad/s] and shapes (n, k) of the structure alone."""
    from scipy.linalg import eigh
    from scipy.sparse.linalg import LinearOperator, eigsh

    size = matrices.size
    if count >= size - 1 or size <= _DENSE:
        squares, shapes = eigh(matrices.stiffness.toarray(), matrices.mass.toarray())
        return np.sqrt(np.maximum(squares[:count], 0.0)), shapes[:, :count]
    shift = (1e-6 * matrices.fastest) ** 2
    lu = factored(matrices.dynamic(-shift, 0.0))
    inverse = LinearOperator(shape=(size, size), matvec=lu.solve, dtype=float)
    start = np.sqrt(matrices.mass.diagonal())
    squares, shapes = eigsh(matrices.stiffness, count, matrices.mass, sigma=-shift, OPinv=inverse, v0=start)
    order = np.argsort(squares)
    return np.sqrt(np.maximum(squares[order], 0.0)), shapes[:, order]


def undamped(mass: Any, stiffness: Any) -> tuple[FloatArray, Any]:
    """Squares of the natural frequencies and mass-normalised shapes in long doubles.

    The first solution is in doubles; one step of first-order correction in long doubles gives the low
    modes the digits that the high ones cost them.
    """
    from scipy.linalg import eigh

    _, first = eigh(stiffness.astype(float), mass.astype(float))
    shapes = first.astype(np.longdouble)
    for _ in range(2):
        m, k = shapes.T @ mass @ shapes, shapes.T @ stiffness @ shapes
        squares = np.diag(k) / np.diag(m)
        gap = squares[None, :] - squares[:, None]
        near = np.abs(gap) <= 1e-6 * np.abs(squares).max() * 1e-6 + 1e-9 * np.abs(squares)[None, :]
        turn = np.where(near, -0.5 * m, (k - m * squares[None, :]) / np.where(near, 1.0, gap))
        np.fill_diagonal(turn, 0.5 * (1.0 - np.diag(m)))
        shapes = shapes + shapes @ turn
    k, m = ((shapes * (matrix @ shapes)).sum(axis=0) for matrix in (stiffness, mass))
    return (k / m).astype(float), shapes / np.sqrt(m)


@dataclass(frozen=True, eq=False)
class Free:
    """Motions of a structure that nothing holds.

    motions
        Orthonormal by mass, shape (n, k), those first that no damper brakes.
    coasting
        How many of them no damper brakes.
    hidden
        Square of the greatest natural frequency that rounding of the entries may hide there [(rad/s)^2].
    held
        Square of the least natural frequency that is not zero [(rad/s)^2].
    """

    motions: FloatArray
    coasting: int = 0
    hidden: float = 0.0
    held: float = 0.0

    @property
    def count(self) -> int:
        return int(self.motions.shape[1])


@lru_cache(maxsize=8)
def free_motions(matrices: Matrices) -> Free:
    """The motions that nothing holds: to the digits of the stiffness matrix, springs there are zero.

    Notes
    -----
    A motion r is free where |r.K r| <= 16 e |r|.|K| |r| with e = 2^-53, which rounding may leave of zero, and every
    other one is held 1e4 times as much.  What is neither counts as held, and shows in the digits that points lose.
    """
    from scipy.linalg import eigh

    low = _LOW * matrices.fastest**2
    below = negative_count(matrices.dynamic(low, 0.0))
    below = 6 if below < 0 else below
    if not 0 < below <= _MOST_FREE:
        return Free(np.zeros((matrices.size, 0)))
    mass, damping, stiffness = matrices.long
    rough = lowest_modes(matrices, min(below + 1, matrices.size))[1]
    near = solve(matrices, np.asarray(matrices.mass @ rough), 0.0, shift=low).motion
    near = near / np.sqrt(np.einsum("ij,ij->j", near, mass @ near))
    shapes = near @ eigh(*((near.T @ (one @ near)).astype(float) for one in (stiffness, mass)))[1]
    squares = np.einsum("ij,ij->j", shapes, stiffness @ shapes).astype(float)
    rounding = _rounding(stiffness, shapes)
    count = int((np.abs(squares) <= rounding).sum())
    hidden = float(rounding[:count].max(initial=0.0))
    if (np.abs(squares[:count]) > hidden).any() or (squares[count:] < _GAP * hidden).any():
        return Free(np.zeros((matrices.size, 0)))
    free = shapes[:, :count]
    braked, turn = np.linalg.eigh((free.T @ (damping @ free)).astype(float))
    free = free @ turn
    return Free(free.astype(float), int((braked <= _rounding(damping, free)).sum()), hidden, float(squares[count]))


def _rounding(matrix: Any, motions: Any) -> FloatArray:
    """What rounding may leave of r.A r = 0 for motions r (n, k), shape (k,)."""
    sizes = np.abs(motions).astype(float)
    return np.asarray(_ASSEMBLED * 2.0**-53 * np.einsum("ij,ij->j", sizes, abs(matrix).astype(float) @ sizes))


def still(matrices: Matrices, loads: FloatArray) -> Solved:
    """Static motion under loads (n, n_loads), and of what is free that beside its free motions."""
    known = free_motions(matrices)
    if not known.count:
        return solve(matrices, loads, 0.0)
    free = known.motions.astype(np.longdouble)
    weighed = matrices.long[0] @ free
    balanced = loads - (weighed @ (free.T @ loads)).astype(float)
    found = solve(matrices, balanced, 0.0, shift=_BESIDE * known.held)
    return replace(found, motion=found.motion - free @ (weighed.T @ found.motion))
