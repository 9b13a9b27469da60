"""What a machine as built is made of, and how it moves: joints, beams, motion at a speed and in time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.records import dataclass

GROUND = "ground"


@dataclass(frozen=True, slots=True)
class Borne:
    """A beam as built that carries at its first end and rests on supports at its second.

    stiffness, mass
        Force over deflection where it carries [N/m], and its own mass [kg].
    means
        Of its shape, one where it carries, and of the square of it, over its mass.
    frequency
        The lowest of its own while load and supports are still [rad/s].
    stress, left, right
        Greatest stress, and force on either support: over the deflection u (of the forces over the force that bends
        it so), over the acceleration of the supports and over that of u, which act against their directions.
    """

    stiffness: float
    mass: float
    means: tuple[float, float]
    frequency: float
    stress: tuple[float, float, float]
    left: tuple[float, float, float]
    right: tuple[float, float, float]

    @property
    def carried(self) -> tuple[float, float]:
        """Of its mass, what moves with its load and what with its supports [kg]; a third part is its inertance."""
        return self.mass * self.means[0], self.mass * (1.0 - self.means[0])

    @property
    def inertance(self) -> float:
        """Between its ends, below zero where it lies between load and supports [kg]."""
        return self.mass * (self.means[1] - self.means[0])


@dataclass(frozen=True, slots=True)
class Joint:
    """Forces between two points as built, from how far and how fast these move apart; of a group the whole.

    stiffness, damping, loss_factor, inertance
        [N/m], [N s/m], of the stiffness, and [kg]: force per relative acceleration.
    static_stiffness
        Under weights alone [N/m].
    count, damping_ratio, price
        Number of mounts; of critical; of all of them.
    friction
        Dry friction against any slip [N].
    stress
        Greatest stress of what bends or twists over its stretch [Pa/m] or twist [Pa/rad]; 0 of all else.
    borne
        One of the beams that it is; None of all else.
    rotating
        Damping that turns with a shaft, which steady whirl does not feel [N s/m].
    """

    name: str
    ends: tuple[str, str]
    stiffness: float
    damping: float
    loss_factor: float
    static_stiffness: float
    count: float
    damping_ratio: float = 0.0
    price: float = 0.0
    inertance: float = 0.0
    friction: float = 0.0
    stress: float = 0.0
    borne: Borne | None = None
    rotating: float = 0.0

    def dynamic(self, omega: FloatArray) -> ComplexArray:
        """Force per relative motion at frequencies [rad/s], shape of `omega` [N/m]."""
        spring = self.stiffness * (1.0 + 1j * self.loss_factor)
        return np.asarray(spring + omega * (1j * self.damping - omega * self.inertance), dtype=complex)

    @property
    def four(self) -> tuple[float, float, float, float]:
        """What it adds to M, C, K and the hysteretic stiffness along its own stretch."""
        return self.inertance, self.damping, self.stiffness, self.stiffness * self.loss_factor

    @property
    def carried(self) -> tuple[float, float]:
        """Mass of beams that moves with its first end and with its second [kg]."""
        if self.borne is None or not self.borne.mass:
            return 0.0, 0.0
        first, second = self.borne.carried
        return self.count * first, self.count * second


@dataclass(frozen=True, slots=True)
class PlaneBearing:
    """Forces across a shaft in both planes, y and z, between two points as built.

    speeds
        Spins [rad/s], (m,), of which one alone says that nothing changes with it.
    stiffness, damping
        Force along each plane per displacement [N/m] and velocity [N s/m] along each, (m, 2, 2).
    """

    ends: tuple[str, str]
    speeds: FloatArray
    stiffness: FloatArray
    damping: FloatArray

    def at(self, spin: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Stiffness and damping at spins (k,) [rad/s], each (k, 2, 2)."""
        both = np.stack([self.stiffness, self.damping]).reshape(2, len(self.speeds), 4)
        found = np.array([[np.interp(spin, self.speeds, each) for each in one.T] for one in both])
        stiff, damp = np.moveaxis(found, 1, -1).reshape(2, len(spin), 2, 2)
        return stiff, damp


@dataclass(frozen=True, slots=True)
class Motion:
    """Steady motion at each speed.

    points
        Complex peak displacement per point, shape of `omega` [m].
    forces
        Complex external force per body [N].
    omega
        Frequency [rad/s].
    stretches
        Second end less first per joint [m], where it is known better than from the points.
    inner
        Motion of coordinates that are no points (n, n_coords), flat over `omega`, where a machine keeps it.
    """

    points: dict[str, ComplexArray]
    forces: dict[str, ComplexArray]
    omega: FloatArray
    stretches: Mapping[str, ComplexArray] = field(default_factory=dict)
    inner: ComplexArray | None = None


@dataclass(frozen=True, slots=True)
class Course:
    """Motion in time.

    points
        Displacement, velocity and acceleration of bodies and bases at each time, (3, n_times) [m, m/s, m/s^2].
    forces
        External force per body [N], (n_times,).
    rubbing
        Dry friction per joint that has some, against a slip of its second end forward [N], (n_times,).
    spins
        Speed of what turns [rad/s], (n_times,), where that counts.
    """

    points: Mapping[str, FloatArray]
    forces: Mapping[str, FloatArray]
    rubbing: Mapping[str, FloatArray] = field(default_factory=dict)
    spins: FloatArray = field(default_factory=lambda: np.zeros(1))


def joined(parts: Sequence[Course]) -> Course:
    """One course of several, of which each goes on where the one before ends."""
    if len(parts) == 1:
        return parts[0]

    def whole(some: Sequence[Mapping[str, FloatArray]]) -> dict[str, FloatArray]:
        return {name: np.concatenate([one[name] for one in some], axis=-1) for name in some[0]}

    points, forces, rubbing = zip(*((one.points, one.forces, one.rubbing) for one in parts), strict=True)
    return Course(whole(points), whole(forces), whole(rubbing))


@dataclass(frozen=True, slots=True)
class Tuned:
    """What an absorber is compared with: a mass [kg] or [kg m^2], and a frequency [rad/s], 0 where there is none."""

    mass: float
    frequency: float
