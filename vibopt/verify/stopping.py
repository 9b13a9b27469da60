"""Motion in time with dry friction of the machine as built, by small steps from one event to the next.

The other road to it: places of body and bases and their rates, friction as one more force that turns with the slip,
signals as functions of time, each step by Duhamel's integral and Taylor's series, events by a search within a step.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.mechanics.built import Course, Joint
from vibopt.records import cached_property, dataclass
from vibopt.responses import TransientResponse
from vibopt.verify.motion_in_time import INSIDE, PLACES, WEIGHTS, carried
from vibopt.verify.simulated import Simulated
from vibopt.verify.states import States

_TURN, _BEGUN, _ROUND = 0.2, 1e-5, 1e-12
"""How far what is fastest turns in a step; part of a step that is the beginning of a slip; rounding of a speed."""
_LASTING, _REPEATS, _EVEN = 400, 1e-10, 1e-9
"""Turns of a sine that lasts, at most; parts of the states by which one may differ from the next, and of the greatest
value by which an earlier one may be less."""


@dataclass(frozen=True)
class Stopping(Simulated):
    """The greatest in the motion of one body on joints of which one rubs, under what comes over it once."""

    @cached_property
    def joint(self) -> Joint:
        """The one that rubs."""
        return next(one for one in self.machine.joints if one.friction)

    @cached_property
    def _states(self) -> States:
        return States(self.machine, tuple(one.on for one in self.excitations))  # none counted from a base

    @cached_property
    def _apart(self) -> FloatArray:
        """Row that tells how far the body is from what it rubs on, over the places."""
        row = np.array([float(name in self.machine.masses) for name in self._places])
        return row - [float(name in self.joint.ends and name in self.machine.bases) for name in self._places]

    def _slip(self, states: FloatArray) -> FloatArray:
        """Place and speed of the body on what it rubs on, (2, ...), at states (2 n, ...)."""
        return np.tensordot(self._apart, states.reshape(2, len(self._places), *states.shape[1:]), axes=(0, 1))

    def _read_at(self, time: FloatArray, span: tuple[float, float]) -> FloatArray:
        edge = INSIDE * (span[1] - span[0])
        return self._signals(np.clip(time, span[0] + edge, span[1] - edge))

    def _carries(self, states: FloatArray, signals: FloatArray) -> FloatArray:
        """What friction must carry so that nothing slips more or less [N], against a slip forward, (n_times,)."""
        faster = self._apart @ self._states.read(states, signals)[2]
        return np.asarray(next(iter(self.machine.masses.values())) * faster)

    def _onward(
        self, states: FloatArray, begin: FloatArray, length: FloatArray, side: FloatArray, span: tuple[float, float]
    ) -> FloatArray:
        """States (2 n, n_times) so much later; where friction holds the body it goes with what it rubs on."""
        (system, loads), count = self._states.matrices, len(self._places)
        places = (0.5 + PLACES)[:, None]
        pushed = loads @ self._read_at((begin + places * length).ravel(), span)
        pushed[count] -= np.tile(side * self.joint.friction / next(iter(self.machine.masses.values())), len(PLACES))
        left = np.concatenate([length, ((1.0 - places) * length).ravel()])
        pushed = pushed * (WEIGHTS[:, None] * length).ravel()
        every = carried(system, np.hstack([states, pushed]), left)
        found: FloatArray = every.reshape(len(states), len(PLACES) + 1, len(begin)).sum(axis=1)
        held, off = side == 0.0, self._slip(found) - [self._slip(states)[0], np.zeros(len(begin))]
        found[[0, count]] -= np.where(held, off, 0.0)
        return found

    def _run(self, number: int) -> Any:
        while len(self._runs) <= number:
            span = self._spans[len(self._runs)]
            self._runs.append(self._followed(span, self._start(len(self._runs)), self._fastest(len(self._runs))))
        return self._runs[number]

    def _followed(self, span: tuple[float, float], state: FloatArray, fastest: float) -> Any:
        """States against time on a stretch without joints."""
        inside = slice(np.searchsorted(self._bent, span[0], "right"), np.searchsorted(self._bent, span[1]))
        ends = [*self._bent[inside].tolist(), span[1]]
        straight = all(one.straight for one in self.excitations)
        longest, time, steps = _TURN / (self._own_rate if straight else fastest), span[0], list[Any]()
        speed, size = float(self._slip(state)[1]), float(np.abs(state[len(self._places) :]).max())
        moves = abs(speed) > _ROUND * size
        side, fresh = float(np.sign(speed)) if moves else self._pushed(state, time, span), not moves
        for end in ends:
            while time < end:
                step = min(longest, end - time) if end - time > 1e-9 * longest else end - time
                steps.append((time, side, state))
                part, after = self._until(state, time, step, side, span, fresh=fresh)
                time = end if part == 1.0 and step == end - time else time + part * step
                was, fresh = side, part < 1.0
                state = after
                if fresh:
                    state[[0, len(self._places)]] -= [0.0, float(self._slip(state)[1])]
                    side = self._pushed(state, time, span, released=not was)
                    side = 0.0 if was and side == was else side
        times, sides, states = (np.array(one) for one in zip(*steps, strict=True))
        self._senses.extend(zip(times.tolist(), sides.tolist(), strict=True))

        def run(at: Any) -> FloatArray:
            some = np.atleast_1d(np.asarray(at, dtype=float))
            which = np.maximum(np.searchsorted(times, some, "right") - 1, 0)
            found = self._onward(states[which].T, times[which], some - times[which], sides[which], span)
            return found if np.ndim(at) else found[:, 0]

        return run

    @cached_property
    def _senses(self) -> list[tuple[float, float]]:
        """When each step so far began [s], and the sense of its slip, 0 where it was held."""
        return []

    def _pushed(self, state: FloatArray, time: float, span: tuple[float, float], *, released: bool = False) -> float:
        """Sense of the slip that begins at rest, 0 where friction holds, unless it is `released`."""
        push = float(self._carries(state[:, None], self._read_at(np.array([time]), span))[0])
        return float(np.sign(push)) if released or abs(push) > self.joint.friction else 0.0

    def _until(
        self, state: FloatArray, time: float, step: float, side: float, span: tuple[float, float], *, fresh: bool
    ) -> tuple[float, FloatArray]:
        """Part of a step up to the next event, all of it without one, and the states there."""
        from scipy.optimize import brentq

        def after(part: float) -> FloatArray:
            return self._onward(state[:, None], np.array([time]), np.array([part * step]), np.array([side]), span)

        def left(part: float) -> float:
            """What is left of the slip, or of the friction that holds."""
            there = after(part)
            if side:
                return side * float(self._slip(there)[1, 0])
            carries = self._carries(there, self._read_at(np.array([time + part * step]), span))
            return self.joint.friction - abs(float(carries[0]))

        if left(1.0) > 0.0:
            return 1.0, after(1.0)[:, 0]
        first = _BEGUN if fresh else 0.0
        part = float(brentq(left, first, 1.0, xtol=1e-14)) if left(first) > 0.0 else first or 1e-9
        return part, after(part)[:, 0]

    def _course(self, time: FloatArray, states: FloatArray) -> Course:
        course, body = super()._course(time, states), next(iter(self.machine.masses))
        begins, sides = np.array(self._senses).T
        side = sides[np.maximum(np.searchsorted(begins, time, side="right") - 1, 0)]
        rubs = np.where(side == 0.0, self._carries(states, self._signals(time)), side * self.joint.friction)
        points, under = dict(course.points), next((one for one in self.machine.bases if one in self.joint.ends), "")
        faster = points[body][2] - rubs / self.machine.masses[body]
        points[body] = np.array([*points[body][:2], np.where(side == 0.0, points[under][2] if under else 0.0, faster)])
        turned = 1.0 if self.joint.ends[1] == body else -1.0
        return Course(points, course.forces, {self.joint.name: turned * rubs})

    def _measured(self, number: int, response: TransientResponse) -> tuple[float, float]:
        """Forces and accelerations jump where the slip turns or ends: just before is looked at, too."""
        found, run, (low, high) = super()._measured(number, response), self._run(number), self._spans[number]
        begins, sides = np.array(self._senses).T
        turned = np.nextafter(begins[1:][sides[1:] != sides[:-1]], low)
        at = turned[(turned > low) & (turned < high)]
        values = np.abs(response.trace(self.machine, self._course(at, run(at)))) * np.ones(len(at))
        every = [found, *zip(values.tolist(), at.tolist(), strict=True)]
        most = max(every)[0]
        return most, min(time for value, time in every if value >= most * (1.0 - _EVEN))

    def _runs_away(self, response: TransientResponse) -> bool:
        return False

    @cached_property
    def _spans(self) -> list[tuple[float, float]]:
        if not self._lasting:
            return super()._spans
        turn = max(one.length for one in self._lasting)
        return [(i * turn, (i + 1) * turn) for i in range(_LASTING)]

    def peak(self, response: TransientResponse) -> tuple[float, float]:
        if not self._lasting:
            return super().peak(response)
        best, before = (0.0, 0.0), np.zeros(0)
        for number, (_, end) in enumerate(self._spans):
            best = max(best, self._greatest(number, response), key=lambda one: one[0])
            state = np.asarray(self._run(number)(end))
            if number and np.abs(state - before).max() <= _REPEATS * np.abs(state).max():
                break
            before = state
        return best


__all__ = ["Stopping"]
