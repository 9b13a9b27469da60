"""A structure in modal-like coordinates: what a model needs of it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.mechanics.host.lowest import still
from vibopt.mechanics.host.matrices import Matrices
from vibopt.records import dataclass


@dataclass(frozen=True, eq=False)
class Coordinates:
    """Uncoupled coordinates of a structure, and how its points move with them.

    mass, stiffness
        Of each coordinate, shape (r,) [kg], [N/m].
    damping
        Shape (r, r) [N s/m]; diagonal for modes with damping ratios.
    loss_factor
        Structural damping of the whole stiffness.
    points
        Per named point the row over the coordinates, shape (r,).
    """

    mass: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    points: Mapping[str, FloatArray]
    loss_factor: float = 0.0

    @property
    def count(self) -> int:
        return len(self.mass)

    def dampers(self) -> list[tuple[FloatArray, float]]:
        """The damping as rank-one terms: vectors (r,) and their coefficients [N s/m]."""
        diagonal = np.diag(self.damping)
        if np.array_equal(self.damping, np.diag(diagonal)):
            return [(row, float(c)) for row, c in zip(np.eye(self.count), diagonal, strict=True) if c]
        values, vectors = np.linalg.eigh(self.damping)
        floor = 1e-15 * float(np.abs(values).max())
        return [(vectors[:, i], float(c)) for i, c in enumerate(values) if c > floor]

    def rows(self) -> FloatArray:
        """The rows of all points, in their order, shape (p, r)."""
        return np.array(list(self.points.values()))

    def receptances(self, omega: FloatArray, dash: float = 0.0) -> ComplexArray:
        """Displacement of every point per force on every point [m/N], shape (n_speeds, p, p).

        With a damper `dash` [N s/m] between every point and the ground, an undamped resonance stays finite.
        """
        rows = self.rows()
        w = np.asarray(omega)
        stiff = self.stiffness * (1.0 + 1j * self.loss_factor) - w[:, None] ** 2 * self.mass
        damping = self.damping + dash * (rows.T @ rows)
        diagonal = np.diag(damping)
        if np.array_equal(damping, np.diag(diagonal)):
            with np.errstate(divide="ignore", invalid="ignore"):
                found = (rows / (stiff + 1j * w[:, None] * diagonal)[:, None, :]) @ rows.T
            return np.asarray(found, dtype=complex)
        whole = 1j * w[:, None, None] * damping
        whole[:, np.arange(self.count), np.arange(self.count)] += stiff
        size = np.sqrt(np.abs(np.diagonal(whole, axis1=1, axis2=2)).astype(float))
        size[size == 0.0] = 1.0
        right = rows.T / size[:, :, None]
        moved = np.linalg.solve(whole / (size[:, :, None] * size[:, None, :]), right)
        coupled: ComplexArray = np.swapaxes(right, 1, 2) @ moved
        return coupled


def of_modes(
    frequencies: FloatArray, damping_ratios: FloatArray, masses: FloatArray, shapes: Mapping[str, FloatArray]
) -> Coordinates:
    """The coordinates of a list of modes: measured, or computed elsewhere.

    Parameters
    ----------
    frequencies
        Natural frequencies [rad/s], shape (r,).
    damping_ratios
        Shape (r,).
    masses
        Modal masses that belong to the shapes as given [kg], shape (r,).
    shapes
        Per point its value in every mode, shape (r,).
    """
    stiffness = masses * frequencies**2
    damping = 2.0 * damping_ratios * masses * frequencies
    return Coordinates(masses, stiffness, np.diag(damping), dict(shapes))


_HALF_DIGIT = 2.0**-53


@dataclass(frozen=True, slots=True)
class Lost:
    """Relative errors of the receptances of the points.

    rounding
        From rounding each entry of the stiffness matrix once, root of mean square: what the file cannot say.
    refined
        Of a sparse solution with residuals in long doubles.
    place
        The coordinate that it shows at.
    """

    rounding: float
    refined: float
    place: int

    @property
    def worst(self) -> float:
        return max(self.rounding, self.refined)


def digits_lost(matrices: Matrices, places: list[int]) -> Lost:
    """Digits lost at standstill; of what is free, those of its motion beside the free ones.

    Notes
    -----
    u solves K u = f.  A change dK of the matrix moves the receptance f.u by u.dK.u; with independent
    rounding of every entry that is a root of a sum of squares.  No norm is estimated, so a structure
    whose norm-wise condition is bad but whose points do not feel it passes.
    """
    loads = matrices.units(np.array(places, dtype=np.intp))
    try:
        found = still(matrices, loads)
    except RuntimeError:
        return Lost(np.inf, np.inf, places[0])
    motion = np.asarray(found.motion, dtype=float)
    moved = motion[places, np.arange(len(places))]
    squared = matrices.stiffness.copy()
    squared.data = squared.data**2
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        sums = np.einsum("ij,ij->j", motion**2, squared @ motion**2)
        rounding = _HALF_DIGIT / np.sqrt(3.0) * np.sqrt(np.abs(sums)) / np.abs(moved)
    rounding = np.nan_to_num(rounding, nan=np.inf)
    worst = int(rounding.argmax())
    return Lost(float(rounding[worst]), found.left, places[worst])
