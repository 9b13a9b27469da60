"""The machine as built of which one joint rubs: states while it slips and while friction holds it."""

from __future__ import annotations

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.mechanics.built import Joint
from vibopt.records import cached_property, dataclass
from vibopt.verify.states import States

_ROUND = 1e-12
"""Part of its terms below which a sum is rounding."""


@dataclass(frozen=True)
class RubbingStates(States):
    """As `States`, of which one joint rubs; none counted from a base."""

    @cached_property
    def joint(self) -> Joint:
        """The one that rubs."""
        return self.machine.rubbing

    @cached_property
    def apart(self) -> FloatArray:
        """Row that tells how far the joint that rubs is apart, over the places."""
        first, second = ([float(name == end) for name in self.places] for end in self.joint.ends)
        return np.subtract(second, first)

    @cached_property
    def given(self) -> FloatArray:
        """Accelerations of the places by a friction of one [N], (n,)."""
        bodies = tuple(self.machine.masses)
        found = States(self.machine, bodies).matrices[1][len(self.places) :] @ self.apart[: len(bodies)]
        return np.asarray(found)

    @cached_property
    def holding(self) -> tuple[FloatArray, FloatArray]:
        """As `matrices`, while friction holds: it gives what a slip would gain."""
        bound = np.eye(len(self.places)) - np.outer(self.given, self.apart) / (self.apart @ self.given)
        twice = np.kron(np.eye(2), bound)
        found = [(twice @ matrix, _ROUND * (np.abs(twice) @ np.abs(matrix))) for matrix in self.matrices]
        system, loads = (np.where(np.abs(one) <= least, 0.0, one) for one, least in found)  # modes suffer from rounding
        return system, loads

    def slip(self, states: FloatArray) -> FloatArray:
        """Stretch of the joint that rubs and its rate, (2, ...), at states (2 n, ...)."""
        return np.tensordot(self.apart, states.reshape(2, len(self.places), *states.shape[1:]), axes=(0, 1))

    def stopped(self, state: FloatArray) -> FloatArray:
        """A state (2 n,) without what is left of the rate of a slip that ended."""
        left = self.given / (self.apart @ self.given) * float(self.slip(state)[1])
        return np.asarray(state - np.concatenate([0.0 * left, left]))

    def carries(self, states: FloatArray, signals: FloatArray) -> FloatArray:
        """What friction must carry so that nothing slips more or less [N], against a slip forward, (n_times,)."""
        return np.asarray(self.apart @ self.read(states, signals)[2] / (self.apart @ self.given))
