"""The speed of a run-up by torque on the machine as built, by a Runge-Kutta method, and what its vibration takes up.

The other road: no poles and no stretches of even acceleration, but the steady motion at each speed of the way.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.motor import Motor
from vibopt.records import cached_property, dataclass

_EVEN, _AROUND = 600, 200
"""Speeds looked at evenly, and around each resonance."""
_BARE = 1e-10
"""Damping ratio below which a resonance has none."""


@dataclass(frozen=True)
class ByTorque:
    """A built machine, and the motor that turns an unbalance `on` one of its bodies."""

    machine: Machine
    motor: Motor
    on: str

    def taken(self, speeds: FloatArray) -> FloatArray:
        """Mean torque that the steady vibration takes up [N m]: force times velocity over the speed, (n,)."""
        force = np.asarray(self.motor.unbalance * speeds**2, dtype=complex)
        with np.errstate(divide="ignore", invalid="ignore"):
            moved = self.machine.shake(speeds, {self.on: force}, {}).points[self.on]
            return np.asarray(np.nan_to_num(0.5 * np.real(force * np.conj(1j * moved)), nan=np.inf))

    @cached_property
    def speeds(self) -> FloatArray:
        """Speeds of the way, close together around each resonance, rising, (n,) [rad/s]."""
        low, high = sorted((self.motor.begins, self.motor.stays))
        poles = self.machine.poles()
        around = np.abs(poles.real)[:, None] + np.abs(poles.imag)[:, None] * np.linspace(-8.0, 8.0, _AROUND)
        speeds = np.unique(np.concatenate([np.linspace(low, high, _EVEN), np.clip(around.ravel(), low, high)]))
        return np.asarray(speeds[speeds > 0.0])

    @property
    def held_at(self) -> float:
        """The first speed on the way up at which load and vibration take all that the motor gives [rad/s]."""
        from scipy.optimize import brentq

        rates = self.rate(self.speeds)
        stuck = int(np.argmax(rates <= 0.0))
        if stuck == 0:
            return float(self.speeds[0] if rates[0] <= 0.0 else self.dearest[0])
        before = float(rates[stuck - 1])

        def left(speed: float) -> float:
            """As a part of what is left before; an undamped resonance takes without end."""
            return max(float(self.rate(np.array([speed]))[0]) / before, -1.0)

        return float(brentq(left, float(self.speeds[stuck - 1]), float(self.speeds[stuck])))

    @cached_property
    def _endless(self) -> float | None:
        """The first undamped resonance on the way that the unbalance excites [rad/s]; None without one."""
        low, high = sorted((self.motor.begins, self.motor.stays))
        poles = self.machine.poles()
        bare = np.sort(poles.real[(np.abs(poles.imag) <= _BARE * poles.real) & (poles.real > low)])
        for one in bare[bare < high]:
            force = np.ones(2, dtype=complex)
            near = self.machine.shake(one * (1.0 + np.array([1e-7, 1e-5])), {self.on: force}, {}).points[self.on]
            if abs(near[0]) > 50.0 * abs(near[1]):  # a hundred times nearer, a hundred times greater
                return float(one)
        return None

    @cached_property
    def dearest(self) -> tuple[float, float, float]:
        """Where the vibration takes up the greatest part of what is left: speed [rad/s], torque, and what is left."""
        from scipy.optimize import minimize_scalar

        if self._endless is not None and self._sense > 0.0:
            return self._endless, float("inf"), float(self.motor.left(np.array([self._endless]))[0])
        speeds = self.speeds

        def part(speed: Any) -> FloatArray:
            at = np.atleast_1d(speed)
            left = self.motor.left(at)
            return np.asarray(self.taken(at) / left if self._sense > 0.0 else -self.taken(at) / left)

        parts = part(speeds)
        best = int(parts.argmax())
        inside = (speeds[max(best - 1, 0)], speeds[min(best + 1, len(speeds) - 1)])
        at: Any = minimize_scalar(lambda speed: -float(part(speed)[0]), bounds=inside, method="bounded")
        speed = float(at.x) if -float(at.fun) > parts[best] else float(speeds[best])
        here = np.array([speed])
        return speed, float(self.taken(here)[0]), float(self.motor.left(here)[0])

    @property
    def sticks(self) -> bool:
        """Whether the steady vibration takes up all that is left at some speed on the way up; down it only brakes."""
        _, taken, left = self.dearest
        return self._sense > 0.0 and not taken < left

    @property
    def _sense(self) -> float:
        return float(np.sign(self.motor.stays - self.motor.begins))

    def rate(self, speeds: FloatArray) -> FloatArray:
        """Change of the speed [rad/s^2], (n,); on the way down without the vibration, which brakes less."""
        taken = self.taken(speeds) if self._sense > 0.0 else 0.0
        return np.asarray((self.motor.left(speeds) - taken) / self.motor.inertia)

    @cached_property
    def course(self) -> tuple[Any, float]:
        """Speed and angle against time, and how long it takes [s]; of a motor that does not stick."""
        from scipy.integrate import solve_ivp

        low, high = sorted((self.motor.begins, self.motor.stays))

        def rates(_: float, now: FloatArray) -> FloatArray:
            at = np.clip(now[:1], low, high)
            return np.array([self.rate(at)[0], now[0]])

        def there(_: float, now: FloatArray) -> float:
            return float(now[0] - self.motor.stays)

        there.terminal = True  # type: ignore[attr-defined]
        start = np.array([self.motor.begins, 0.0])
        grid = np.linspace(low, high, _EVEN)
        longest = 3.0 * float(np.abs(high - low) / np.abs(self.rate(grid)).min()) + 1.0
        first = 1e-3 * float((high - low) / np.abs(self.rate(np.array([self.motor.begins])))[0])
        run: Any = solve_ivp(
            rates, (0.0, 1e3 * longest), start, method="DOP853", rtol=1e-10, atol=1e-10, dense_output=True,
            events=there, first_step=first,
        )  # fmt: skip
        return run.sol, float(run.t[-1])
