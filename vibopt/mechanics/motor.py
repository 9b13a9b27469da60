"""A run-up by torque: what motor and load leave over turns the rotor faster, less what the vibration takes up.

The vibration of an unbalance takes its power from the shaft.  Mean values over a turn of the steady vibration stand for
it: J w' = T(w) - L(w) - D(w), D = (m e w^2)^2 (-Im H(w)) / 2.  In a passage the vibration has not built up, so that it
takes less than that, passes faster, and is no greater.  On the way down it would brake, and so help: nothing of it is
counted there.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.records import dataclass
from vibopt.signals import Amplitude, Sweep

Drag = Callable[[FloatArray], FloatArray]
_CHANGE, _EVEN, _AROUND = 0.0075, 400, 60
"""Change of the acceleration on one stretch, as a part; speeds looked at evenly, and on either side of a resonance."""
_PASSING, _TURNED = 20.0, 1.25e-5
"""How near a pole is passed, in roots of the rate; by how much the angle may be off behind a stretch there [rad]."""
_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(8)

NO_SWEEP = Sweep((), (), (), (0.0, 0.0))
"""Of a motor that sticks on its way."""


@dataclass(frozen=True, slots=True)
class Motor:
    """A rotor whose speed follows from torque.

    begins, stays
        Speeds from which and to which it goes [rad/s].
    driving, load
        Torques against the speed [N m].
    inertia, unbalance
        Of all that turns [kg m^2], and mass times distance from the axis [kg m].
    """

    begins: float
    stays: float
    driving: Amplitude
    load: Amplitude
    inertia: float
    unbalance: float

    def left(self, speeds: FloatArray) -> FloatArray:
        """Torque that load and motor leave over [N m], shape of `speeds`."""
        return self.driving.at(speeds) - self.load.at(speeds)

    def drag(self, receptance: ComplexArray, speeds: FloatArray) -> FloatArray:
        """Mean torque of the steady vibration [N m], by the motion of the rotor under a force of one [m/N]."""
        return np.asarray(-0.5 * (self.unbalance * speeds**2) ** 2 * np.imag(receptance))

    def against(self, drag: Drag, poles: ComplexArray) -> Sweep | None:
        """The run-up in stretches of even acceleration, each as long as it takes; None where the motor sticks.

        `poles` [1/s] say where the drag changes quickly.
        """
        sense, grid = np.sign(self.stays - self.begins), self._looked_at(poles)
        rise = sense * self._over(grid, drag) / self.inertia
        if not (rise > 0.0).all():
            return None
        many = np.concatenate([[0.0], np.cumsum(self._stretches(grid, rise, poles))])
        count = 2 ** int(np.ceil(np.log2(max(many[-1], 1.0))))  # it leaps from one design to a near one, but seldom
        steps = np.linspace(0.0, many[-1], count + 1)
        ends = [self.begins, self.stays, *(joint for joint in self._joints if grid[0] < joint < grid[-1])]
        speeds = np.unique(np.concatenate([np.interp(steps, many, grid), ends]))
        middle, half = 0.5 * (speeds[1:] + speeds[:-1]), 0.5 * np.diff(speeds)
        inside = middle[:, None] + half[:, None] * _PLACES
        within = sense * self._over(inside, drag) / self.inertia
        if not (within > 0.0).all():
            return None
        times = sense * ((1.0 / within) @ _WEIGHTS * half)
        slope = (within @ (_WEIGHTS * _PLACES)) * 1.5 / half * sense
        speeds = speeds + _moved(np.diff(speeds) * slope * times / -12.0)
        rates = np.diff(speeds) / times
        powers = [np.array([-1j * self.unbalance * rate, 0.0, self.unbalance]) for rate in rates]
        if sense < 0.0:
            speeds, rates, powers = speeds[::-1], rates[::-1], powers[::-1]
        still = (self.unbalance * self.begins**2, self.unbalance * self.stays**2)
        return Sweep(tuple(speeds.tolist()), tuple(rates.tolist()), tuple(powers), still)

    def _over(self, speeds: FloatArray, drag: Drag) -> FloatArray:
        """Torque that turns the rotor faster [N m], shape of `speeds`."""
        left = self.left(speeds)
        return left - drag(speeds) if self.stays > self.begins else left

    @staticmethod
    def _stretches(grid: FloatArray, rise: FloatArray, poles: ComplexArray) -> FloatArray:
        """How many stretches each part between speeds needs, (n - 1,): for the rate and, near a pole, for the angle.

        An even rate for one that changes by b a second turns b T^3 / 12 too far in a time T.
        """
        wide, rate = np.diff(grid), np.sqrt(rise[1:] * rise[:-1])
        size = np.abs(np.diff(np.log(rise)))
        away = np.abs(0.5 * (grid[1:] + grid[:-1]) - np.abs(poles.imag)[:, None]).min(axis=0)
        passing = away < _PASSING * np.sqrt(rate)
        turned = wide * np.cbrt(size / (12.0 * _TURNED * wide * rate))
        return np.maximum(size / _CHANGE, np.where(passing, turned, 0.0))

    @property
    def _joints(self) -> tuple[float, ...]:
        return (*self.driving.breaks(), *self.load.breaks())

    def _looked_at(self, poles: ComplexArray) -> FloatArray:
        """Speeds at which the acceleration is looked at, rising, (n,) [rad/s]."""
        low, high = sorted((self.begins, self.stays))
        near = np.geomspace(0.02, 100.0, _AROUND)
        wide = np.maximum(np.abs(poles.real), 1e-9 * np.abs(poles))[:, None] * np.concatenate([-near, [0.0], near])
        around = (np.abs(poles.imag)[:, None] + wide).ravel()
        inside = around[(around > low) & (around < high)]
        return np.unique(np.concatenate([np.linspace(low, high, _EVEN), inside]))


def _moved(off: FloatArray) -> FloatArray:
    """By how much speeds between stretches (n + 1,) move [rad/s] where even rates turn each so much too fast (n,).

    Then what they turn in all, on which depends how what rings meets the force, is that of the motor.
    """
    before, after = off[:-1], off[1:]
    alike = np.where(before * after > 0.0, np.sign(before) * np.minimum(np.abs(before), np.abs(after)), 0.0)
    return np.concatenate([[0.0], alike, [0.0]])
