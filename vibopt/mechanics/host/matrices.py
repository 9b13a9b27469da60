"""Sparse mass, damping and stiffness of a structure, and solutions that keep their digits.

Finite elements that are much finer than the motion make entries of K that cancel to a tiny rest.
Residuals are therefore formed in long doubles and every solution is refined with them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.records import cached_property, dataclass

if TYPE_CHECKING:
    from scipy.sparse import csc_array

    Sparse = csc_array[Any]
else:
    Sparse = Any

_ROUNDS = 6
_CONVERGED = 1e-13


@dataclass(frozen=True, eq=False)
class Matrices:
    """M [kg], C [N s/m], K [N/m] of a structure, symmetric, each (n, n); K (1 + i loss_factor) in all.

    Two of them are equal only when they are the same object, so that results can be kept by it.
    """

    mass: Sparse
    damping: Sparse
    stiffness: Sparse
    loss_factor: float = 0.0

    @property
    def size(self) -> int:
        return int(self.mass.shape[0])

    @cached_property
    def is_damped(self) -> bool:
        return bool(self.damping.nnz) or self.loss_factor > 0.0

    @cached_property
    def long(self) -> tuple[Any, Any, Any]:
        """M, C, K in long doubles, by rows."""
        return tuple(csc_array.tocsr().astype(np.longdouble) for csc_array in (self.mass, self.damping, self.stiffness))  # type: ignore[return-value]

    @cached_property
    def fastest(self) -> float:
        """Rough greatest natural frequency [rad/s]: the greatest root of K_ii / M_ii."""
        ratio = self.stiffness.diagonal() / self.mass.diagonal()
        return float(np.sqrt(max(float(ratio.max()), 0.0)))

    def dynamic(self, square: float, omega: float) -> Any:
        """K (1 + i loss) - square M + i omega C, sparse by columns; real where nothing is damped."""
        stiff = self.stiffness - square * self.mass
        if self.is_damped and omega != 0.0:
            stiff = stiff + 1j * (self.loss_factor * self.stiffness + omega * self.damping)
        return stiff.tocsc()

    def units(self, places: IntArray) -> FloatArray:
        """Unit loads at coordinates, shape (n, n_places)."""
        loads = np.zeros((self.size, len(places)))
        loads[places, np.arange(len(places))] = 1.0
        return loads


def factored(matrix: Any) -> Any:
    """Sparse LU of a symmetric matrix, ordered for symmetric fill."""
    from scipy.sparse.linalg import splu

    return splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.1, options={"SymmetricMode": True})


@dataclass(frozen=True)
class Solved:
    """Motion under unit loads, refined, and the part of it that the last round still changed.

    motion (n, n_loads) in long doubles.
    """

    motion: Any
    left: float


def solve(matrices: Matrices, loads: FloatArray, omega: float, shift: float = 0.0) -> Solved:
    """Motion of the structure alone under loads (n, n_loads) at omega [rad/s].

    Parameters
    ----------
    matrices
        The structure.
    loads
        Real forces [N], shape (n, n_loads).
    omega
        Frequency [rad/s].
    shift
        Solves K + shift M instead of the static K, for structures that nothing holds [1/s^2].
    """
    square = omega**2 - shift
    lu = factored(matrices.dynamic(square, omega))
    mass, damping, stiffness = matrices.long
    kind = complex if matrices.is_damped and omega != 0.0 else float
    first = lu.solve(loads.astype(kind))
    motion = first.astype(np.clongdouble if kind is complex else np.longdouble)
    left = 0.0
    for turn in range(_ROUNDS):
        rest = loads - (stiffness @ motion - np.longdouble(square) * (mass @ motion))
        if kind is complex:
            rest = rest - 1j * (matrices.loss_factor * (stiffness @ motion) + np.longdouble(omega) * (damping @ motion))
        change = lu.solve(np.ascontiguousarray(rest, dtype=kind))
        before, left = left, _part(change, motion)
        motion = motion + change
        if left < _CONVERGED or (turn and left > 0.3 * before):
            break
    return Solved(motion, left)


def _part(change: Any, motion: Any) -> float:
    size = np.abs(motion).max(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        part = np.abs(change).max(axis=0) / size
    return float(np.nan_to_num(part, nan=np.inf).max())


def negative_count(matrix: Any) -> int:
    """Number of negative eigenvalues of a symmetric sparse matrix, from the signs of its pivots.

    Returns -1 where the pivots cannot tell (a pivot was exchanged or is zero).
    """
    from scipy.sparse.linalg import splu

    try:
        lu = splu(matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:
        return -1
    if not np.array_equal(lu.perm_r, lu.perm_c):
        return -1
    return int((lu.U.diagonal() < 0.0).sum())


@dataclass(frozen=True, eq=False)
class Dashed:
    """A structure with a damper `dash` [N s/m] between each of its places and the ground.

    With it nothing is infinite at a resonance; who uses it takes the dampers away again.
    """

    matrices: Matrices
    places: IntArray
    dash: float

    @cached_property
    def _whole(self) -> Matrices:
        from scipy.sparse import csc_array

        ends = (self.places, self.places)
        damper = csc_array((np.full(len(self.places), self.dash), ends), shape=self.matrices.mass.shape)
        of = self.matrices
        return Matrices(of.mass, (of.damping + damper).tocsc(), of.stiffness, of.loss_factor)

    def receptances(self, omega: FloatArray) -> ComplexArray:
        """Displacement at each place per force at each place [m/N] at omega (n_speeds,) [rad/s], (n_speeds, p, p)."""
        whole = self._whole if self.dash else self.matrices
        loads = whole.units(self.places)
        found = np.empty((len(omega), len(self.places), len(self.places)), dtype=complex)
        for i, w in enumerate(np.asarray(omega, dtype=float).tolist()):
            found[i] = solve(whole, loads, w).motion[self.places]
        return found
