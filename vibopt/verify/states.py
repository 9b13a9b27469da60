"""The machine as built in states: places of bodies and bases, then their rates, and how these change.

A joint without mass keeps its balance of forces at every instant: a damper there says its rate, springs alone say its
place.  Neither is a state of its own beyond that, and the slot of its rate, or of both, stays empty.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vibopt.arrays import BoolArray, FloatArray
from vibopt.mechanics.machine import Machine
from vibopt.records import cached_property, dataclass


@dataclass(frozen=True)
class States:
    """Rates of the states, and what is read of them; of a machine under forces on bodies, accelerations of bases.

    machine
        As built.
    acts
        Places on which each of the signals acts, by name, with the part of it.
    rides
        A base that alone carries everything and may go far: places are counted from it, and it has none.
    """

    machine: Machine
    acts: tuple[Mapping[str, complex], ...]
    rides: str = ""

    @cached_property
    def places(self) -> list[str]:
        """Coordinates of bodies, and those of bases behind them."""
        return list(self.machine.coordinate_names)

    @cached_property
    def pushed(self) -> FloatArray:
        """Forces on bodies and accelerations of bases by signals of one, (n, n_signals)."""
        return np.reshape([self.machine.pushes(one) for one in self.acts], (len(self.acts), len(self.places))).T

    @cached_property
    def matrices(self) -> tuple[FloatArray, FloatArray]:
        """Rates from states (2 n, 2 n), and from the signals (2 n, n_signals)."""
        moved, pushed, count = *self._forced, len(self.places)
        system, loads = np.eye(2 * count, k=count), np.zeros((2 * count, len(self.acts)))
        system[count:], loads[count:] = moved, pushed
        for one in np.flatnonzero(self._light):
            system[one], loads[one] = moved[one], pushed[one]
            system[count + one] = loads[count + one] = 0.0
        if self.rides:
            base = self.places.index(self.rides)
            heavy = np.flatnonzero(~self._light[: self.machine.n_free])
            loads[count + heavy] -= loads[count + base]
            system[:, [base, count + base]] = 0.0
        return system, loads

    def read(self, states: FloatArray, signals: FloatArray) -> FloatArray:
        """Displacements, velocities and accelerations (3, n, n_times) at states (2 n, n_times) under signals."""
        (system, loads), count = self.matrices, len(self.places)
        rates = system @ states + loads @ signals
        if not self._light.any():
            found = np.array([states[:count], states[count:], rates[count:]])
        else:
            fast = system[:count] @ rates
            fast[~self._light] = rates[count:][~self._light]
            found = np.array([self._seen @ one for one in (states[:count], rates[:count], fast)])
        if self.rides:
            base = self.places.index(self.rides)
            found[1:, base] = 0.0
            found[1:] += np.array([states[count + base], rates[count + base]])[:, None]
        return found

    @cached_property
    def _light(self) -> BoolArray:
        """Joints at each place, (n,)."""
        return ~self._parts[0].any(axis=1) & (np.arange(len(self.places)) < self.machine.n_free)

    @cached_property
    def _parts(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        return self.machine.parts_in_time()

    @cached_property
    def _seen(self) -> FloatArray:
        """Places from those that are states, (n, n): joints that only springs hold follow."""
        _, damping, stiffness = self._parts
        quick = self._light & (np.diag(damping) == 0.0)
        seen = np.diag(np.where(quick, 0.0, 1.0))
        if quick.any():
            seen[quick] = np.linalg.solve(stiffness[np.ix_(quick, quick)], -stiffness[quick] * ~quick)
        return seen

    @cached_property
    def _forced(self) -> tuple[FloatArray, FloatArray]:
        """Accelerations of what has mass and rates of joints, from states (n, 2 n) and signals (n, n_signals)."""
        mass, damping, stiffness = self._parts
        count, bodies, light = len(self.places), self.machine.n_free, self._light
        quick = light & (np.diag(damping) == 0.0)
        pushed = self.pushed.copy()
        free = np.arange(bodies)
        unknown = np.where(light, damping, mass)[:bodies, :bodies]  # what multiplies accelerations, rates of joints
        unknown[:, quick[:bodies]] = 0.0
        unknown[free[quick[:bodies]], free[quick[:bodies]]] = 1.0
        slow = damping * ~light  # rates that are states
        pulled = -np.hstack([stiffness @ self._seen if light.any() else stiffness, slow])[:bodies]
        pulled[quick[:bodies]] = 0.0
        forced = pushed[:bodies] - mass[:bodies, bodies:] @ pushed[bodies:]
        moved = np.zeros((count, 2 * count))
        moved[:bodies] = np.linalg.solve(unknown, pulled)
        pushed[:bodies] = np.linalg.solve(unknown, forced)
        return moved, pushed
