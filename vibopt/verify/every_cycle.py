"""Greatest response in a run-up of the machine as built, followed through every cycle by quadrature.

The other road: one matrix takes the machine from point to point, a part of a cycle each, and what the force does
between them is summed by Gauss's rule, its phase a function of time.  Two forces a quarter turn apart, as one complex
one, give the response for every angle at which the force may begin.  No pole, no closed form and no envelope: what
rings and what is driven are never told apart.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.excitations.excitation import Excitation
from vibopt.excitations.run_up import ends_of, motor_of, rate_of
from vibopt.mechanics.built import Course
from vibopt.mechanics.machine import Machine
from vibopt.records import cached_property, dataclass
from vibopt.responses import TransientResponse
from vibopt.signals import Line
from vibopt.verify.by_torque import ByTorque
from vibopt.verify.states import States
from vibopt.work import worked

_TURN, _SOFT = 0.5, 8.0
"""Radians of force and fastest motion in a step; how much faster may decay what does not swing."""
_POINTS, _CHUNK, _BEST, _INSIDE, _AROUND = 16, 4096, 60, 64, 4
"""Points of Gauss's rule in a step, steps at once, tops looked at closely, parts of two steps there, on either side."""
_FINE = 20_001
"""Times between which a rate that follows from torque is straight."""
_PERIODS, _HORIZON = 6.0, 1000.0
"""Periods of the slowest mode in a look behind, and in all."""
_MEET, _FADED, _EVEN, _NEAR = 3.0, 1e-11, 1e-12, 0.998
"""What modes that ring on may grow to as they meet; faded; even; parts of the highest sample that a top must have."""
_MET, _BESIDE, _ALIKE = 1e-9, 1e-5, 0.1
"""Parts: of a speed by which it misses a resonance, and beside which it is looked at; by which sides may differ."""
_WORK = 0.005
"""Work of a step [nominal ms]."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(_POINTS)


@dataclass(frozen=True, slots=True)
class _Top:
    """A top among samples: its height by a parabola, time and state of the sample before, whether the speed changes."""

    height: float
    time: float
    step: float
    state: ComplexArray
    rising: bool


@dataclass(frozen=True)
class Followed:
    """A built machine, and a force whose speed rises or falls and then stays."""

    machine: Machine
    excitation: Excitation

    def peak(self, response: TransientResponse) -> tuple[float, float]:
        """Greatest size of a response over every angle at which the force begins, and the speed then [rad/s]."""
        low, high = ends_of(self.excitation)
        if self._motor is not None and self._motor.sticks:
            return float("inf"), self._motor.dearest[0]
        for speed in (low, high):
            if not np.isfinite(self._vibrating(speed)).all():
                return float("inf"), speed
        tops: list[_Top] = []
        steady = float(
            np.abs(self._read(response, np.array([self._length]), self._settled(np.array([self._length])), False))[0]
        )
        best, rung, state = 0.0, 0.0, self._vibrating(low)
        for begin, end in self._spans:
            rising = begin < self._length
            for times, states in self._stepped(begin, end, state):
                values = self._read(response, times, states, rising)
                sizes, state = np.abs(values), states[:, -1]
                best = max(best, float(sizes.max()))
                tops = _kept(tops, times, states, sizes, rising)
                rung = float(np.abs(values - self._read(response, times, self._settled(times), rising)).max())
            grown = rung * (1.05 if self.machine.n_free == 1 else _MEET)
            if not rising and (steady + grown < best or rung <= _FADED * max(best, steady)):
                break
        high_ones = [top for top in tops if top.height >= _NEAR * tops[0].height]
        found = max((self._closely(response, top) for top in high_ones), default=(0.0, 0.0))
        value, time = (steady, np.inf) if steady > found[0] * (1.0 + _EVEN) else found
        return value, float(self._speed(np.array([min(time, self._length)]))[0])

    @cached_property
    def _motor(self) -> ByTorque | None:
        motor = motor_of(self.excitation)
        return None if motor is None else ByTorque(self.machine, motor, self.excitation.on)

    @cached_property
    def _length(self) -> float:
        """How long the speed changes [s]."""
        if self._motor is not None:
            return self._motor.course[1]
        low, high = ends_of(self.excitation)
        return (high - low) / rate_of(self.excitation)

    def _speed(self, times: FloatArray) -> FloatArray:
        """Speed at times while it changes [rad/s], shape of `times`."""
        if self._motor is not None:
            return np.asarray(self._motor.course[0](np.ravel(times))[0].reshape(np.shape(times)), dtype=float)
        return np.asarray(ends_of(self.excitation)[0] + rate_of(self.excitation) * times, dtype=float)

    def _rate(self, times: FloatArray) -> Any:
        """Change of the speed at times while it changes [rad/s^2]."""
        return rate_of(self.excitation) if self._motor is None else np.interp(times, *self._rates)

    @cached_property
    def _rates(self) -> tuple[FloatArray, FloatArray]:
        """Many times, and the change of the speed then [rad/s^2]."""
        assert self._motor is not None
        times = np.linspace(0.0, self._length, _FINE)
        return times, self._motor.rate(self._speed(times))

    @property
    def _spans(self) -> list[tuple[float, float]]:
        """Times between those at which the force changes its way, and looks behind, where the speed stays [s]."""
        bends = (
            []
            if self._motor is not None
            else [
                (value - ends_of(self.excitation)[0]) / rate_of(self.excitation)
                for value in self._line.amplitude.breaks()
            ]
        )
        joints = [0.0, *sorted(bend for bend in bends if 0.0 < bend < self._length), self._length]
        period, looks = 2.0 * np.pi / float(self.machine.natural_frequencies().min()), int(_HORIZON / _PERIODS)
        behind = [self._length + _HORIZON * period * number / looks for number in range(looks + 1)]
        return [*pairwise(joints), *pairwise(behind)]

    @cached_property
    def _line(self) -> Line:
        [line] = self.excitation.lines(np.ones(1))
        return line

    @cached_property
    def _states(self) -> States:
        return States(replace(self.machine, bases=()), (self.excitation.acts,))

    @cached_property
    def _system(self) -> tuple[FloatArray, FloatArray]:
        """Rates of positions and velocities (2 n, 2 n), and what a force of one adds (2 n,)."""
        system, loads = self._states.matrices
        return system, loads[:, 0]

    def _vibrating(self, speed: float) -> ComplexArray:
        """Steady vibration at one speed, (2 n,); infinite at an undamped resonance that the force excites.

        Of one that it does not excite the machine vibrates as on either side of it.
        """
        (system, push), poles = self._system, np.linalg.eigvals(self._system[0])
        size = self._line.amplitude.at(np.array([speed]))[0]
        empty = ~system.any(axis=1)  # rates of joints
        if not size:
            return np.zeros(len(push), dtype=complex)

        def driven(at: float) -> ComplexArray:
            return np.asarray(np.linalg.solve(np.diag(1j * at + empty) - system, push * size))

        if (np.abs(1j * speed - poles[np.abs(poles) > 0.0]) > _MET * speed).all():
            return driven(speed)
        below, above = driven(speed * (1.0 - _BESIDE)), driven(speed * (1.0 + _BESIDE))
        excited = np.abs(above - below).max() > _ALIKE * np.abs(above + below).max()
        return np.full(len(push), np.inf, dtype=complex) if excited else 0.5 * (below + above)

    def _settled(self, times: FloatArray) -> ComplexArray:
        """Steady vibration of the last speed at times, (2 n, n)."""
        return np.asarray(self._vibrating(ends_of(self.excitation)[1])[:, None] * np.exp(1j * self._phase(times)))

    def _phase(self, times: FloatArray) -> FloatArray:
        """Angle through which the force has turned [rad]."""
        low, high = ends_of(self.excitation)
        rising = np.minimum(times, self._length)
        if self._motor is not None:
            turned = self._motor.course[0](np.ravel(rising))[1].reshape(np.shape(times))
            return np.asarray(turned + high * (times - rising))
        return (low + 0.5 * rate_of(self.excitation) * rising) * rising + high * (times - rising)

    def _force(self, times: FloatArray, rising: bool) -> ComplexArray:
        """Force at times, shape of `times`, while the speed changes or behind."""
        high = ends_of(self.excitation)[1]
        rate = self._rate(times) if rising else 0.0
        size = self._line.amplitude.at(self._speed(times) if rising else np.full(times.shape, high))
        return np.asarray((size - 1j * rate * self.excitation.swung) * np.exp(1j * self._phase(times)))

    def _steps(self, begin: float, end: float) -> int:
        """How many steps a stretch of time takes."""
        poles = np.linalg.eigvals(self._system[0])
        fast = float(np.abs(poles.imag).max() + np.abs(poles.real).max() / _SOFT) + max(ends_of(self.excitation))
        return int(np.ceil(fast * (end - begin) / _TURN)) + 2

    def _stepped(self, begin: float, end: float, state: ComplexArray) -> Iterator[tuple[FloatArray, ComplexArray]]:
        """Times, the end of the chunk before first, and states (2 n, n) from chunk to chunk."""
        count = self._steps(begin, end)
        step = (end - begin) / count
        for first in range(0, count, _CHUNK):
            numbers = np.arange(first, min(first + _CHUNK, count) + 1)
            times: FloatArray = np.asarray(begin + step * numbers, dtype=float)
            states = self._taken(times[:-1], step, state, begin < self._length)
            yield times, states
            state = states[:, -1]

    def _taken(self, times: FloatArray, step: float, state: ComplexArray, rising: bool) -> ComplexArray:
        """States at times and one step behind the last, (2 n, n + 1), from the state at the first."""
        from scipy.linalg import expm

        worked(_WORK * len(times))
        system, push = self._system
        nodes = 0.5 + 0.5 * _NODES
        pushed = np.array([expm(system * (step * (1.0 - node))) @ push for node in nodes])
        inside = times[:, None] + step * nodes
        states = np.empty((len(times) + 1, len(push)), dtype=complex)
        states[0] = state
        states[1:] = self._force(inside, rising) @ (0.5 * step * _WEIGHTS[:, None] * pushed)
        reach, power = 1, expm(system * step).T
        while reach < len(states):  # each state takes up what came before it, over twice the distance every time
            states[reach:] += states[:-reach] @ power
            reach, power = 2 * reach, power @ power
        return np.asarray(states.T)

    def _read(self, response: TransientResponse, times: FloatArray, states: ComplexArray, rising: bool) -> ComplexArray:
        """The response as a complex number at each time."""
        force: Any = self._force(times, rising)
        seen: Any = self._states.read(states, force[None, :])  # type: ignore[arg-type]
        points: dict[str, Any] = self._states.machine.points_in_time(seen)
        bases = self.machine.coordinate_names[self.machine.n_free :]
        points |= {name: np.zeros((3, len(times))) for name in (*self.machine.bases, *bases)}
        forces: dict[str, Any] = dict.fromkeys(self.machine.masses, np.zeros(len(times)))
        forces |= {place: force * part for place, part in self.excitation.acts.items()}
        read: Any = response.trace(self.machine, Course(points, forces))
        return np.asarray(read * np.ones(len(times), dtype=complex))

    def _closely(self, response: TransientResponse, top: _Top) -> tuple[float, float]:
        """Greatest size between two steps, and when: a polynomial through fine samples."""
        fine = 2.0 * top.step / _INSIDE
        times: FloatArray = np.asarray(top.time + fine * np.arange(_INSIDE + 1), dtype=float)
        states = self._taken(times[:-1], fine, top.state, top.rising)
        sizes = np.abs(self._read(response, times, states, top.rising)) ** 2
        middle = int(np.clip(sizes.argmax(), _AROUND, _INSIDE - _AROUND))
        near = np.arange(-_AROUND, _AROUND + 1)
        through = np.polynomial.Polynomial.fit(near, sizes[middle + near], 2 * _AROUND)
        at = np.linspace(-_AROUND, _AROUND, 8001)
        values = through(at)
        best = int(values.argmax())
        return float(np.sqrt(values[best])), float(times[middle] + fine * at[best])


def _kept(tops: list[_Top], times: FloatArray, states: ComplexArray, sizes: FloatArray, rising: bool) -> list[_Top]:
    """The highest tops so far; ends of a chunk are tops that are looked at on their inner side."""
    left, middle, right = sizes[:-2], sizes[1:-1], sizes[2:]
    inner = np.flatnonzero((middle >= left) & (middle >= right))
    bent = np.maximum(2.0 * middle[inner] - left[inner] - right[inner], 1e-300)
    high = middle[inner] + np.minimum((right[inner] - left[inner]) ** 2 / (8.0 * bent), 0.5 * middle[inner])
    step = float(times[1] - times[0])
    found = [_Top(float(sizes[0]), float(times[0]), 0.5 * step, states[:, 0], rising)]
    found.append(_Top(float(sizes[-1]), float(times[-2]), 0.5 * step, states[:, -2], rising))
    for one, height in zip(inner, high, strict=True):
        if height > sizes.max() * 0.5:
            found.append(_Top(float(height), float(times[one]), step, states[:, one], rising))
    return sorted([*tops, *found], key=lambda top: -top.height)[:_BEST]
