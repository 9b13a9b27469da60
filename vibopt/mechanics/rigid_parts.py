"""What a machine in space is made of, as built: bodies, mounts, and the masses of absorbers that slide."""

from __future__ import annotations

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.mechanics.built import Joint
from vibopt.records import cached_property, dataclass

LETTERS = "xyz"
"""Axes in space."""


@dataclass(frozen=True, eq=False)
class Rigid:
    """A body in space.

    mass, centre, tensor
        [kg], (3,) [m], (3, 3) [kg m^2] about the centre.
    freedoms
        Words of its coordinates, of x, y, z, rx, ry, rz.
    mark
        Place that the name of the body means (3,) [m]: its centre as said, which may be off.
    """

    mass: float
    centre: FloatArray
    tensor: FloatArray
    freedoms: tuple[str, ...]
    mark: FloatArray

    @cached_property
    def moves(self) -> list[tuple[FloatArray, FloatArray, float]]:
        """Per coordinate the velocity of the centre, the angular velocity (3,), and what resists it."""
        found = []
        for k in range(3):
            if LETTERS[k] in self.freedoms:
                found.append((np.eye(3)[k], np.zeros(3), self.mass))
        turns = [k for k in range(3) if f"r{LETTERS[k]}" in self.freedoms]
        values, axes = np.linalg.eigh(self.tensor[np.ix_(turns, turns)])
        for value, axis in zip(values, axes.T, strict=True):
            spin = np.zeros(3)
            spin[turns] = axis
            found.append((np.zeros(3), spin, float(value)))
        return found


@dataclass(frozen=True, eq=False)
class Spring3:
    """Forces between two places, of one mount: own axes as rows (d, 3), and along them (d,) stiffness and static
    stiffness [N/m], damping [N s/m] and inertance [kg].

    `price` is what one costs.
    """

    name: str
    ends: tuple[str, str]
    at: FloatArray
    axes: FloatArray
    stiffness: FloatArray
    static_stiffness: FloatArray
    damping: FloatArray
    loss_factor: float = 0.0
    price: float = 0.0
    inertance: FloatArray | float = 0.0

    def dynamic(self, omega: FloatArray) -> ComplexArray:
        """Force per relative motion along its axes at frequencies [rad/s], shape (..., d) [N/m]."""
        w = np.asarray(omega)[..., None]
        spring = self.stiffness * (1.0 + 1j * self.loss_factor)
        return np.asarray(spring + 1j * w * self.damping - w**2 * self.inertance, dtype=complex)

    @property
    def hysteretic(self) -> FloatArray:
        """Imaginary stiffness along its axes (d,) [N/m]."""
        return self.stiffness * self.loss_factor


@dataclass(frozen=True, eq=False)
class Guided:
    """The mass of an absorber in space: free along one direction of what carries it, and taken along across it.

    host, at, way
        What carries it, where (3,) [m], and which way it is free (3,).
    mass
        [kg], whose own coordinate is how far it is along `way`, counted in space and not from its host.
    joint
        Its spring and damper.
    """

    host: str
    at: FloatArray
    way: FloatArray
    mass: float
    joint: Joint
