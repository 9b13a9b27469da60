"""A machine as built of which bodies are geared to others: torques of shafts and teeth are found with the rotations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from functools import cached_property

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.mechanics.built import Motion
from vibopt.mechanics.built_algebra import solved
from vibopt.mechanics.machine import Machine
from vibopt.records import dataclass


@dataclass(frozen=True)
class GearedMachine(Machine):
    """A drive line with gears.

    gears
        Per geared body the one that it is geared to, and how many times as fast it turns.
    """

    gears: Mapping[str, tuple[str, float]] = field(default_factory=dict)

    def turning(self, read: object, power: float) -> None:
        """Not known beforehand."""

    def shake(self, omega: FloatArray, forces: dict[str, ComplexArray], bases: dict[str, ComplexArray]) -> Motion:
        """As `Machine.shake`, on bases at rest; unknown are the rotations and the torques of joints and pairs of gears.

        Each body balances its own; a joint hands on its stiffness times its twist, a damper at rest nothing; geared
        bodies keep their ratio.
        """
        flat, names = np.ravel(omega), list(self.masses)
        n, many = len(names), len(names) + len(self.joints)
        at = {name: i for i, name in enumerate(names)}
        stiff = np.array([one.dynamic(flat) for one in self.joints]).reshape(-1, flat.size)
        unit = float(np.abs(stiff).max(initial=1e-300))
        whole = np.zeros((flat.size, many + len(self.gears), many + len(self.gears)), dtype=complex)
        right = np.zeros(whole.shape[:2], dtype=complex)
        for name, i in at.items():
            whole[:, i, i] = -self.masses[name] * flat**2 / unit
            right[:, i] = np.ravel(forces.get(name, np.zeros(flat.size))) / unit
        for j, joint in enumerate(self.joints, start=n):
            for end, sign in zip(joint.ends, (-1.0, 1.0), strict=True):
                if end in at:
                    whole[:, at[end], j], whole[:, j, at[end]] = sign, sign * stiff[j - n] / unit
            whole[:, j, j] = -1.0
        for g, (name, (to, ratio)) in enumerate(self.gears.items(), start=many):
            for end, part in ((name, 1.0), (to, -ratio)):
                whole[:, at[end], g], whole[:, g, at[end]] = -part, part
        found = solved(whole, right)
        points = {name: found[:, i].reshape(omega.shape) for name, i in at.items()}
        points |= {base: np.zeros(omega.shape, dtype=complex) for base in self.bases}
        apart = {}
        for joint, torque, z in zip(self.joints, found[:, n:many].T, stiff, strict=True):
            first, second = (np.ravel(points.get(end, np.zeros(omega.shape))) for end in joint.ends)
            twist = np.divide(unit * torque, z, out=second - first.astype(complex), where=z != 0.0)
            apart[joint.name] = twist.reshape(omega.shape)
        return Motion(points, forces, omega, apart, unit * found[:, many:])

    def tooth_torque(self, body: str, motion: Motion) -> ComplexArray:
        """What the teeth of the body that it is geared to hand to a body, at its own speed [N m]."""
        assert motion.inner is not None
        torque: ComplexArray = motion.inner[:, [*self.gears].index(body)].reshape(motion.omega.shape)
        return torque

    @cached_property
    def _free(self) -> FloatArray:
        """Rotation of every body over those that are not geared to another, (n_bodies, n_free)."""
        names = list(self.masses)
        roots = [i for i, name in enumerate(names) if name not in self.gears]
        rows = np.eye(len(names))[roots].T
        for name in self.gears:
            here, ratio = name, 1.0
            while here in self.gears:
                here, ratio = self.gears[here][0], ratio * self.gears[here][1]
            rows[names.index(name)] = ratio * rows[names.index(here)]
        return rows

    def row(self, body: str) -> FloatArray:
        found: FloatArray = self._free[[*self.masses].index(body)]
        return found

    def matrices(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """M, C, K and hysteretic stiffness over the bodies that are not geared to another, each (n_free, n_free)."""
        mass, damping, stiffness, hysteretic = (self._free.T @ matrix @ self._free for matrix in super().matrices())
        return mass, damping, stiffness, hysteretic

    def spring_rows(self) -> FloatArray:
        return self._free.T @ super().spring_rows()

    def force_into(self, place: str, motion: Motion) -> ComplexArray:
        """Dynamic torque of all joints into a body, base or the ground, joint by joint [N m]."""
        ends = [(joint, 1.0 if joint.ends[1] == place else -1.0) for joint in self.joints if place in joint.ends]
        return sum((s * self.joint_force(j, motion) for j, s in ends), np.zeros(motion.omega.shape, dtype=complex))
