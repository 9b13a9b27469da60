"""One body on joints, as built: its motion is one division, without matrices."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from vibopt.forms import ComplexArray, FloatArray
from vibopt.mechanics.machine import Joint, Machine, Motion


class LoneMachine(Machine):
    """A machine with one body, along a line or about an axis.

    The force on the body is balanced by its inertia and its joints: (S - m w^2) x = F + sum s_j y_j, with the
    dynamic stiffness s of each joint, S their sum, and y the motion of a joint's other end.
    Numbers that are arrays, of mass and joints, are many machines at once.
    """

    def shake(self, omega: FloatArray, forces: dict[str, ComplexArray], bases: dict[str, ComplexArray]) -> Motion:
        """As in any machine, a complex `omega` too; stretches of joints keep their digits beside a common motion."""
        (body, mass), *_ = self.masses.items()
        inertia = mass * omega**2
        apart: dict[str, ComplexArray] = {}
        held: ComplexArray = np.zeros(omega.shape, dtype=complex)
        load: ComplexArray = held + forces.get(body, 0.0)
        for joint in self.joints:
            if body in joint.ends:
                stiff = joint.dynamic(omega)
                held = held + stiff
                other = bases.get(joint.ends[joint.ends[0] == body])
                load = load if other is None else load + stiff * other
        moved = load / (held - inertia)
        for joint in self.joints if bases else ():
            if body in joint.ends:
                sign = 1.0 if joint.ends[1] == body else -1.0
                apart[joint.name] = sign * self._beside(joint, omega, forces, bases) / (held - inertia)
        still = np.zeros(omega.shape, dtype=complex)
        points = {body: moved} | {base: bases.get(base, still) for base in self.bases}
        return Motion(points, forces, np.asarray(omega), apart)

    def _beside(
        self, joint: Joint, omega: FloatArray, forces: dict[str, ComplexArray], bases: dict[str, ComplexArray]
    ) -> ComplexArray:
        """What moves the body beside the other end of a joint: the force, its inertia, and ends that move otherwise."""
        (body, mass), *_ = self.masses.items()
        still = np.zeros(omega.shape, dtype=complex)
        y = bases.get(joint.ends[joint.ends[0] == body], still)
        load = mass * omega**2 * y + forces.get(body, 0.0)
        for one in self.joints:
            if body in one.ends:
                load = load + one.dynamic(omega) * (bases.get(one.ends[one.ends[0] == body], still) - y)
        return load

    def poles(self) -> ComplexArray:
        """Complex frequencies of free motion [rad/s], shape (2,): roots of m w^2 - i w c - k (1 + i eta)."""
        mass, damping, stiffness, hysteretic = (float(one[0, 0]) for one in self.matrices())
        half, product = 0.5j * damping / mass, (stiffness + 1j * hysteretic) / mass
        root = np.sqrt(half * half + product)
        first = half + root if (half.conjugate() * root).real >= 0.0 else half - root
        return np.array([first, -product / first if first else 0.0])

    @cached_property
    def loose(self) -> int:
        """Number of poles at zero."""
        _, damping, stiffness, _ = (float(one[0, 0]) for one in self.matrices())
        return int(stiffness == 0.0) + int(stiffness == 0.0 and damping == 0.0)
