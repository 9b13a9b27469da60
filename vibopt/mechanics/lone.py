"""One body on joints, as built: its motion is one division, without matrices."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, some
from vibopt.mechanics.built import Joint, Motion
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.turning import turning_points
from vibopt.records import cached_property


class LoneMachine(Machine):
    """A machine with one body, along a line or about an axis.

    The force on the body is balanced by its inertia and its joints: (S - m w^2) x = F + sum s_j y_j, with the
    dynamic stiffness s of each joint, S their sum, and y the motion of a joint's other end.
    Numbers that are arrays, of mass and joints, are many machines at once.
    """

    def shake(self, omega: FloatArray, forces: dict[str, ComplexArray], bases: dict[str, ComplexArray]) -> Motion:
        """As in any machine, a complex `omega` too."""
        (body, mass), *_ = self.masses.items()
        load: Any = forces.get(body, 0.0)
        held: Any = 0j
        for joint in self.joints:
            if body in joint.ends:
                stiff = joint.dynamic(omega)
                held = held + stiff
                other = bases.get(joint.ends[joint.ends[0] == body])
                load = load if other is None else load + stiff * other
        points = {body: load / (held - mass * omega**2)}
        for base in self.bases:
            points[base] = bases[base] if base in bases else np.zeros(omega.shape, dtype=complex)
        return Motion(points, forces, np.asarray(omega))

    def stretch_of(self, joint: Joint, motion: Motion) -> ComplexArray:
        """As of any machine; where a base moves it keeps its digits beside the common motion.

        What moves the body beside the other end: the force, its inertia, and ends that move otherwise.
        """
        (body, mass), *_ = self.masses.items()
        other = joint.ends[joint.ends[0] == body]
        if body not in joint.ends or not any(motion.points[base].any() for base in self.bases):
            return super().stretch_of(joint, motion)
        y = self.position(other, motion)
        inertia = mass * motion.omega**2
        load: Any = inertia * y + motion.forces.get(body, 0.0)
        held: Any = 0j
        for one in self.joints:
            if body in one.ends:
                stiff = one.dynamic(motion.omega)
                held = held + stiff
                load = load + stiff * (self.position(one.ends[one.ends[0] == body], motion) - y)
        sign = 1.0 if joint.ends[1] == body else -1.0
        return np.asarray(sign * load / (held - inertia))

    def turning(self, read: Callable[[FloatArray], FloatArray], power: float) -> FloatArray | None:
        """As in any machine.  Shape (n, ...), where ... is that of the machines' numbers; 0 where none is real.

        Viscous and structural damping together are none such.
        """
        mass, damping, stiffness, hysteretic = self._sums
        if some(stiffness <= 0.0) or some(damping * hysteretic > 0.0):
            return None
        natural = stiffness / mass + 0.0 * (damping + hysteretic)  # of the shape of all
        bottom = (1.0 + (hysteretic / stiffness) ** 2, damping**2 / (mass * stiffness) - 2.0, 1.0)
        found = turning_points(read, bottom, natural, power)
        if found is None:
            return None
        resonance = np.sqrt(natural) + np.zeros((1, *found.shape[1:]))
        return np.concatenate([resonance, np.where(np.isfinite(found), found, 0.0)])

    @cached_property
    def _sums(self) -> tuple[Any, Any, Any, Any]:
        """Mass, damping, stiffness and hysteretic stiffness on the body."""
        (body, mass), *_ = self.masses.items()
        fours = [joint.four for joint in self.joints if body in joint.ends]
        inertance, damping, stiffness, hysteretic = map(sum, zip(*fours, strict=True)) if fours else (0.0,) * 4
        return mass + inertance, damping, stiffness, hysteretic

    def natural_frequencies(self) -> FloatArray:
        """The one natural frequency [rad/s], shape (1, ...)."""
        mass, _, stiffness, _ = self._sums
        return np.asarray(np.sqrt(np.asarray(stiffness / mass)))[None]

    @property
    def damping_ratio(self) -> FloatArray:
        """Of critical, viscous, of a machine that springs hold."""
        mass, damping, stiffness, _ = self._sums
        return np.asarray(damping / (2.0 * np.sqrt(stiffness * mass)))

    def sag(self) -> dict[str, Any] | None:
        """As of any machine."""
        (body, weight), *_ = self.weights.items()
        held = sum(joint.static_stiffness for joint in self.joints if body in joint.ends)
        return {body: weight * GRAVITY / held} if not some(held <= 0.0) else None

    def poles(self) -> ComplexArray:
        """Complex frequencies of free motion [rad/s], shape (2,): roots of m w^2 - i w c - k (1 + i eta)."""
        mass, damping, stiffness, hysteretic = self._sums
        half, product = 0.5j * damping / mass, (stiffness + 1j * hysteretic) / mass
        root = np.sqrt(half * half + product)
        first = half + root if (half.conjugate() * root).real >= 0.0 else half - root
        return np.array([first, -product / first if first else 0.0])

    @cached_property
    def loose(self) -> int:
        """Number of poles at zero."""
        _, damping, stiffness, _ = self._sums
        return int(some(stiffness == 0.0)) + int(some((stiffness == 0.0) & (damping == 0.0)))
