"""The machine as built of which one joint rubs: states while it slips and while friction holds it.

Balances of forces on every place, and what a hold forbids, say at once how what has mass accelerates, how fast what a
damper holds goes, where what springs alone hold is, and what friction carries.
"""

from __future__ import annotations

import numpy as np

from vibopt.arrays import BoolArray, FloatArray
from vibopt.mechanics.built import Joint
from vibopt.records import cached_property, dataclass
from vibopt.verify.states import States

_ROUND = 1e-12
"""Part of its terms below which a sum is rounding."""


@dataclass(frozen=True, slots=True)
class _Way:
    """What states, a force of friction and signals do, in a slip or a hold: rows over them, states first.

    whole
        Their rates, (2 n + 1 + n_signals, the same).
    places, rubs
        All places, (n, 2 n + 1 + n_signals), and what friction carries [N].
    """

    whole: FloatArray
    places: FloatArray
    rubs: FloatArray


@dataclass(frozen=True)
class RubbingStates(States):
    """As `States`, of which one joint rubs; none counted from a base.

    Of what springs alone hold no place is a state; that of the end that rubs says how far apart a hold keeps it.
    """

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
    def matrices(self) -> tuple[FloatArray, FloatArray]:
        """Rates from states (2 n, 2 n), and from the signals (2 n, n_signals), while it slips, without friction."""
        return self._rates(self._slips)

    @cached_property
    def holding(self) -> tuple[FloatArray, FloatArray]:
        """As `matrices`, while friction holds: it gives what a slip would gain."""
        return self._rates(self._holds)

    @property
    def given(self) -> FloatArray:
        """Rates of the states that a friction of one takes [1/N], (2 n,)."""
        count = 2 * len(self.places)
        return -self._slips.whole[:count, count]

    @property
    def yields(self) -> FloatArray:
        """Places by a force of one [N] against a slip that stays, (n_bodies,)."""
        bodies = len(self.machine.masses)
        return np.asarray(-np.linalg.solve(self.stiffness[:bodies, :bodies], self.apart[:bodies]))

    @property
    def stiffness(self) -> FloatArray:
        """Over all places, (n, n) [N/m]."""
        return self._parts[2]

    def _rates(self, way: _Way) -> tuple[FloatArray, FloatArray]:
        count = 2 * len(self.places)
        return way.whole[:count, :count], way.whole[:count, count + 1 :]

    @cached_property
    def _quick(self) -> BoolArray:
        """Joints that springs alone hold, at each place."""
        return np.asarray(self._light & (np.diag(self._parts[1]) == 0.0))

    @cached_property
    def _ends(self) -> BoolArray:
        """Of the ends of what rubs those that move most freely, at each place."""
        rubs = self.apart != 0.0
        return next(some for some in (rubs & self._quick, rubs & self._light, rubs) if some.any())

    @cached_property
    def light(self) -> bool:
        """Whether no mass resists a slip: it follows forces at once."""
        return bool((self._ends & self._light).any())

    @cached_property
    def _slips(self) -> _Way:
        return self._way(held=False)

    @cached_property
    def _holds(self) -> _Way:
        return self._way(held=True)

    def _way(self, *, held: bool) -> _Way:
        (mass, damping, stiffness), n, bodies = self._parts, len(self.places), len(self.machine.masses)
        light, quick, apart, ends = self._light, self._quick, self.apart, self._ends
        unit = np.eye(2 * n + 1 + len(self.acts))
        places, speeds, rubs, signals = unit[:n], unit[n : 2 * n], unit[2 * n], unit[2 * n + 1 :]
        places, speeds = np.where(quick[:, None], 0.0, places), np.where(light[:, None], 0.0, speeds)
        pushed = self.pushed @ signals
        moved = mass[:bodies, bodies:] @ pushed[bodies:]
        known = pushed[:bodies] - moved - stiffness[:bodies] @ places - damping[:bodies] @ speeds
        system = np.zeros((bodies + 1, bodies + 1))
        system[:bodies, :bodies] = np.where(quick, stiffness, np.where(light, damping, mass))[:bodies, :bodies]
        system[:bodies, bodies] = apart[:bodies]
        if not held:
            system[bodies, bodies], forbids = 1.0, rubs
        else:
            system[bodies, :bodies] = (apart * ends)[:bodies]
            if (ends & quick).any():
                forbids = unit[(ends & quick).argmax()] - apart @ places
            elif (ends & light).any():
                forbids = -apart @ speeds
            else:
                forbids = -apart[bodies:] @ pushed[bodies:]
        inverse, given = np.linalg.inv(system), np.vstack([known, forbids])
        by_itself = np.sqrt(np.diag(system)[:bodies])  # what is held on the ground no force moves
        normed = inverse[:bodies, :bodies] * np.outer(by_itself, by_itself)
        inverse[:bodies, :bodies][np.abs(normed) <= _ROUND] = 0.0
        found = inverse @ given
        found = np.where(np.abs(found) <= _ROUND * (np.abs(inverse) @ np.abs(given)), 0.0, found)
        free = np.vstack([found[:bodies], pushed[bodies:]])
        whole = np.zeros(unit.shape)
        whole[:n] = np.where(quick[:, None], 0.0, np.where(light[:, None], free, speeds))
        whole[n : 2 * n] = np.where(light[:, None], 0.0, free)
        return _Way(whole, np.where(quick[:, None], free, places), found[bodies])

    def read(  # type: ignore[override]
        self, states: FloatArray, signals: FloatArray, sides: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Displacements, velocities and accelerations (3, n, n_times), and what friction carries [N], (n_times,).

        At states (2 n, n_times) under signals, by the sense of the slip at each time, 0 of a hold.
        """
        every = self._with(states, signals, sides)
        found, rubs = np.zeros((3, len(self.places), every.shape[1])), np.zeros(every.shape[1])
        for way, those in ((self._slips, every[len(states)] != 0.0), (self._holds, every[len(states)] == 0.0)):
            some = every[:, those]
            found[:, :, those] = [way.places @ one for one in (some, way.whole @ some, way.whole @ way.whole @ some)]
            rubs[those] = way.rubs @ some
        return found, rubs

    def _with(self, states: FloatArray, signals: FloatArray, sides: FloatArray) -> FloatArray:
        """States (2 n, n_times), below them friction in the sense of the slip, and signals."""
        return np.vstack([states, sides * self.joint.friction * np.ones(states.shape[1]), signals])

    @cached_property
    def slips(self) -> FloatArray:
        """Row that tells how fast the joint that rubs slips, over states, friction, signals (2 n + 1 + n_signals,)."""
        return np.asarray(self.apart @ self._slips.places @ self._slips.whole)

    def slip(self, state: FloatArray, signals: FloatArray, side: float) -> float:
        """Rate at which the joint that rubs slips at a state (2 n,), in a sense."""
        return float(self.slips @ self._with(state[:, None], np.reshape(signals, (-1, 1)), np.array([side]))[:, 0])

    def begins(self, state: FloatArray, least: float) -> float:
        """Sense of a slip that goes on at a state (2 n,), faster than so much; 0 where what pushes decides."""
        rate = 0.0 if self.light else float(self.apart @ state[len(self.places) :])
        return float(np.sign(rate)) if abs(rate) > least else 0.0

    def stopped(self, state: FloatArray, signals: FloatArray, side: float) -> FloatArray:
        """A state (2 n,) at the end of a slip in a sense, without what is left of its rate."""
        n, found, quick = len(self.places), state.copy(), self._ends & self._quick
        if quick.any():
            places = self.read(state[:, None], np.reshape(signals, (-1, 1)), np.array([side]))[0][0, :, 0]
            found[quick.argmax()] = self.apart @ places
        elif not self.light:
            found[n:] -= self.given[n:] / (self.apart @ self.given[n:]) * float(self.apart @ state[n:])
        return found

    def carries(self, states: FloatArray, signals: FloatArray) -> FloatArray:
        """What friction must carry so that nothing slips more or less [N], against a slip forward, (n_times,)."""
        every = self._with(states, signals, np.zeros(states.shape[1]))
        return np.asarray(self._holds.rubs @ np.asfortranarray(every))
