"""A shaft that bends and shears, its deflection and its tilt as polynomials on each section.

Timoshenko's beam: the tilt of a cross-section is a motion of its own.  Written in Legendre's polynomials each energy
of a section is a sum of squares, so that stiffness and inertia are terms of rank one whose coefficients are products of
powers of the section's own sizes.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.records import dataclass

_LEAST, _MOST = 3, 48
"""Degrees of the tilt; at the least any load on the nodes, and the weight of a section, bend it exactly."""
_MOVED = 1e-12
"""Part of the stiffness of a span by which one degree more may move it."""


@dataclass(frozen=True)
class Shapes:
    """Rows of one section of length one over its own coordinates, by degree in Legendre's polynomials.

    Its coordinates are deflection and tilt at the left and at the right end, then what is nothing at both ends.

    deflection, tilt
        Shapes (degree + 2, n) and (degree + 1, n).
    curvature, shear
        Slope of the tilt, (degree, n), and slope of the deflection less tilt, (degree + 1, n).
    """

    deflection: FloatArray
    tilt: FloatArray
    curvature: FloatArray
    shear: FloatArray


@lru_cache(maxsize=256)
def shapes(degree: int, length: float) -> Shapes:
    """Rows of a section of a length [m] whose tilt has a degree from 2 on, its deflection one more.

    The square of a field over the section is length times the sum of its rows squared, each over 2 k + 1.
    """
    high, count = degree + 1, 2 * degree + 3
    deflection, tilt = np.zeros((high + 1, count)), np.zeros((degree + 1, count))
    deflection[:, [0, 2]], tilt[:, [1, 3]] = _ends(high), _ends(degree)
    deflection[:, 4 : 3 + high] = _inner(high)
    tilt[:, 3 + high :] = _inner(degree)
    slope = 2.0 / length * _derivative(deflection)
    return Shapes(deflection, tilt, 2.0 / length * _derivative(tilt), slope - tilt)


def _ends(degree: int) -> FloatArray:
    """The two functions that fall and rise from end to end, as columns."""
    found = np.zeros((degree + 1, 2))
    found[0], found[1] = 0.5, [-0.5, 0.5]
    return found


def _inner(degree: int) -> FloatArray:
    """Integrals of the polynomials from degree one on, which are nothing at both ends, as columns."""
    found = np.zeros((degree + 1, degree - 1))
    for k in range(2, degree + 1):
        found[k, k - 2], found[k - 2, k - 2] = 1.0 / (2 * k - 1), -1.0 / (2 * k - 1)
    return found


def _derivative(rows: FloatArray) -> FloatArray:
    """Derivative over [-1, 1] of the polynomials whose coefficients stand in columns."""
    return np.asarray(np.polynomial.legendre.legder(rows, axis=0))


def shares(count: int, length: float) -> FloatArray:
    """What the square of each of so many rows counts [m]."""
    return np.asarray(length / (2.0 * np.arange(count) + 1.0), dtype=float)


@dataclass(frozen=True, slots=True)
class Span:
    """A piece of shaft between two nodes: length [m], E I [N m^2], kappa G A [N], rho A [kg/m], rho I [kg m]."""

    length: float
    bending: float
    shear: float
    mass: float
    rotary: float

    def phase(self, omega: float) -> float:
        """By which a wave that bends goes on along it at a frequency [rad]."""
        return float((self.mass * omega**2 / self.bending) ** 0.25 * self.length)

    def stiffness(self, degree: int, omega: float) -> FloatArray:
        """Dynamic stiffness of forward whirl at a spin [rad/s] over deflection and tilt of its ends, (4, 4)."""
        rows, square = shapes(degree, self.length), omega**2
        whole = np.zeros((2 * degree + 3, 2 * degree + 3))
        parts = ((rows.curvature, self.bending), (rows.shear, self.shear))
        for table, size in (*parts, (rows.deflection, -square * self.mass), (rows.tilt, square * self.rotary)):
            whole += (table.T * (size * shares(len(table), self.length))) @ table
        inner = np.linalg.solve(whole[4:, 4:], whole[4:, :4])
        return np.asarray(whole[:4, :4] - whole[:4, 4:] @ inner)

    def degree(self, omega: float) -> tuple[int, float]:
        """Degree of the tilt good up to a frequency [rad/s], and the part by which one degree more moves stiffness."""
        size = np.array([1.0, self.length, 1.0, self.length])
        before, moved = self.stiffness(_LEAST, omega), np.inf
        for degree in range(_LEAST, _MOST + 1):
            after = self.stiffness(degree + 1, omega)
            still = np.abs(after * np.outer(1.0 / size, 1.0 / size)).max()
            moved = float((np.abs(after - before) * np.outer(1.0 / size, 1.0 / size)).max() / still)
            if moved <= _MOVED:
                break
            before = after
        return degree, moved


@dataclass(frozen=True)
class Beam:
    """Spans from left to right, each with polynomials of a degree of its own.

    Coordinates are deflection and tilt of each node in turn, then what is nothing at both ends of each span.
    """

    lengths: tuple[float, ...]
    degrees: tuple[int, ...]

    @property
    def count(self) -> int:
        """Number of coordinates."""
        return 2 * len(self.lengths) + 2 + sum(2 * degree - 1 for degree in self.degrees)

    def coordinates(self, k: int) -> list[int]:
        """Numbers of the coordinates of span k, in the order of its shapes."""
        begin = 2 * len(self.lengths) + 2 + sum(2 * degree - 1 for degree in self.degrees[:k])
        return [*range(2 * k, 2 * k + 4), *range(begin, begin + 2 * self.degrees[k] - 1)]
