"""Motion in time with dry friction of the machine as built, by small steps from one event to the next.

The other road to it: places of body and bases and their rates, friction as one more force that turns with the slip,
signals as functions of time, each step by Duhamel's integral and Taylor's series, events by a search within a step.
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.mechanics.built import Course, Joint
from vibopt.records import cached_property, dataclass
from vibopt.responses import TransientResponse
from vibopt.verify.motion_in_time import INSIDE, PLACES, WEIGHTS, carried
from vibopt.verify.rubbing_states import RubbingStates
from vibopt.verify.simulated import Simulated

_TURN, _BEGUN, _ROUND, _NEAR = 0.2, 1e-5, 1e-12, 0.05
"""How far what is fastest turns in a step; part of a step that is the beginning of a slip; rounding of a speed; and
part of the friction that is left in a step, within which less may be left for a moment."""
_LASTING, _REPEATS, _CREEPS, _EVEN = 400, 1e-10, 1e-4, 1e-9
"""Turns of a sine that lasts, at most; parts of the states by which one may differ from the next, and from the next of
what creeps, and of the greatest value by which an earlier one may be less."""


@dataclass(frozen=True)
class Stopping(Simulated):
    """The greatest in the motion of a machine of which one joint rubs, under what comes over it once."""

    looks: ClassVar[int] = 20

    @cached_property
    def joint(self) -> Joint:
        """The one that rubs."""
        return self._states.joint

    @cached_property
    def _states(self) -> RubbingStates:
        return RubbingStates(self.machine, tuple(excitation.acts for excitation in self.excitations))

    @cached_property
    def _quiet(self) -> dict[float, FloatArray]:
        """Rates of the states and of a one behind them, by the sense of the slip, where no load acts."""
        found, count = {}, len(self._places)
        for side in (-1.0, 0.0, 1.0):
            found[side] = np.zeros((2 * count + 1, 2 * count + 1))
            found[side][:-1, :-1] = self._states.matrices[0] if side else self._states.holding[0]
            found[side][:-1, -1] = -side * self.joint.friction * self._states.given
        return found

    def _read_at(self, time: FloatArray, span: tuple[float, float]) -> FloatArray:
        edge = INSIDE * (span[1] - span[0])
        return self._signals(np.clip(time, span[0] + edge, span[1] - edge))

    def _onward(
        self, states: FloatArray, begin: FloatArray, length: FloatArray, side: FloatArray, span: tuple[float, float]
    ) -> FloatArray:
        """States (2 n, n_times) so much later, each as it slips or is held."""
        found = np.empty(states.shape)
        if not self._lasting and span[0] >= self._spans[self._behind][0]:
            for sense, system in self._quiet.items():
                those = np.flatnonzero(side == sense)
                if len(those):
                    start = np.vstack([states[:, those], np.ones(len(those))])
                    found[:, those] = carried(system, start, length[those])[:-1]
            return found
        for held, (system, loads) in ((False, self._states.matrices), (True, self._states.holding)):
            those = np.flatnonzero((side == 0.0) == held)
            if not len(those):
                continue
            places, long = (0.5 + PLACES)[:, None], length[those]
            pushed = loads @ self._read_at((begin[those] + places * long).ravel(), span)
            pushed -= np.outer(self._states.given, np.tile(side[those] * self.joint.friction, len(PLACES)))
            left = np.concatenate([long, ((1.0 - places) * long).ravel()])
            pushed = pushed * (WEIGHTS[:, None] * long).ravel()
            every = carried(system, np.hstack([states[:, those], pushed]), left)
            found[:, those] = every.reshape(len(states), len(PLACES) + 1, len(those)).sum(axis=1)
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
        straight = all(excitation.straight for excitation in self.excitations)
        longest, time, steps = _TURN / (self._own_rate if straight else fastest), span[0], list[Any]()
        moves = self._states.begins(state, _ROUND * float(np.abs(state[len(self._places) :]).max()))
        side, fresh = moves or self._pushed(state, time, span), not moves
        for end in ends:
            while time < end:
                step = min(longest, end - time) if end - time > 1e-9 * longest else end - time
                steps.append((time, side, state))
                part, after = self._until(state, time, step, side, span, fresh=fresh)
                time = end if part == 1.0 and step == end - time else time + part * step
                was, fresh = side, part < 1.0
                state = after
                if fresh:
                    state = self._states.stopped(state, self._read_at(np.array([time]), span), was) if was else state
                    side = self._pushed(state, time, span, released=not was)
                    side = 0.0 if was and side == was else side
        times, sides, states = (np.array(one) for one in zip(*steps, strict=True))
        self._senses.append(np.array([times, sides]))

        def run(at: Any) -> FloatArray:
            some = np.atleast_1d(np.asarray(at, dtype=float))
            which = np.maximum(np.searchsorted(times, some, "right") - 1, 0)
            found = self._onward(states[which].T, times[which], some - times[which], sides[which], span)
            return found if np.ndim(at) else found[:, 0]

        return run

    @cached_property
    def _senses(self) -> list[FloatArray]:
        """Of each stretch so far when its steps began [s], and the senses of their slips, 0 where held: (2, n)."""
        return []

    def _pushed(self, state: FloatArray, time: float, span: tuple[float, float], *, released: bool = False) -> float:
        """Sense of the slip that begins at rest, 0 where friction holds, unless it is `released`."""
        push = float(self._states.carries(state[:, None], self._read_at(np.array([time]), span))[0])
        return float(np.sign(push)) if released or abs(push) > self.joint.friction else 0.0

    def _until(
        self, state: FloatArray, time: float, step: float, side: float, span: tuple[float, float], *, fresh: bool
    ) -> tuple[float, FloatArray]:
        """Part of a step up to the next event, all of it without one, and the states there.

        What holds may slip and hold again within a step, and what slips may hold and slip again.
        """
        from scipy.optimize import brentq, minimize_scalar

        def after(*parts: float) -> FloatArray:
            times = np.full(len(parts), time), np.array(parts) * step, np.full(len(parts), side)
            return self._onward(np.repeat(state[:, None], len(parts), axis=1), *times, span)

        def left(part: float, there: FloatArray | None = None) -> float:
            """What is left of the slip, or of the friction that holds."""
            there = after(part) if there is None else there
            signals = self._read_at(np.array([time + part * step]), span)
            if side:
                return side * self._states.slip(there[:, 0], signals, side)
            carries = self._states.carries(there, signals)
            return self.joint.friction - abs(float(carries[0]))

        both, last = after(0.5, 1.0), 1.0
        half, whole = both[:, :1], both[:, 1:]
        if (rest := left(1.0, whole)) > 0.0:
            begun, middle = left(0.0, state[:, None]) if side and not fresh else 0.0, left(0.5, half)
            near = _dips(begun, middle, rest) if side else min(rest, middle) < _NEAR * self.joint.friction
            found = (
                minimize_scalar(left, bounds=(0.0, 1.0), method="bounded", options={"xatol": 1e-9}) if near else None
            )
            if found is None or found.fun > 0.0:
                return 1.0, whole[:, 0]
            last = float(found.x)
        first = _BEGUN if fresh else 0.0
        part = float(brentq(left, first, last, xtol=1e-14, disp=False)) if left(first) > 0.0 else first or 1e-9
        return part, after(part)[:, 0]

    def _course(self, time: FloatArray, states: FloatArray) -> Course:
        begins, sides = np.hstack(self._senses)
        side, signals = sides[np.maximum(np.searchsorted(begins, time, side="right") - 1, 0)], self._signals(time)
        read, rubs = self._states.read(states, signals, side)
        points, forces = self.machine.points_in_time(read), self._forces(signals)
        return Course(points, forces, {self.joint.name: rubs})

    @cached_property
    def _own_rate(self) -> float:
        return max(super()._own_rate, float(np.abs(np.linalg.eigvals(self._states.holding[0])).max()))

    def _measured(self, number: int, response: TransientResponse, before: float) -> tuple[float, float]:
        """Forces and accelerations jump where the slip turns or ends: just before is looked at, too."""
        found, run, at = super()._measured(number, response, before), self._run(number), self._turned(number)
        values = np.abs(response.trace(self.machine, self._course(at, run(at)))) * np.ones(len(at))
        every = [found, *zip(values.tolist(), at.tolist(), strict=True)]
        most = max(every)[0]
        return most, min(time for value, time in every if value >= most * (1.0 - _EVEN))

    def _turned(self, number: int) -> FloatArray:
        (low, high), (begins, sides) = self._spans[number], np.hstack(self._senses)
        turned = np.nextafter(begins[1:][sides[1:] != sides[:-1]], low)
        return np.asarray(turned[(turned > low) & (turned < high)])

    @cached_property
    def _spans(self) -> list[tuple[float, float]]:
        if not self._lasting:
            return super()._spans
        turn = max(one.length for one in self._lasting)
        return [(i * turn, (i + 1) * turn) for i in range(_LASTING)]

    def peak(self, response: TransientResponse) -> tuple[float, float]:
        if not self._lasting:
            return self._over_once(response)
        best, before = (0.0, 0.0), np.zeros(0)
        for number, (_, end) in enumerate(self._spans):
            best = max(best, self._greatest(number, response), key=lambda one: one[0])
            state = np.asarray(self._run(number)(end))
            changed, size = np.abs(state - before).max() if number else np.inf, np.abs(state).max()
            if changed <= _REPEATS * size or (changed <= _CREEPS * size and self._creeps(number, before, state)):
                break
            before = state
        return best

    def _creeps(self, number: int, before: FloatArray, after: FloatArray) -> bool:
        """Whether it slips one way alone in a turn, back to where nothing is strained: each such turn by less."""
        senses, count = set(self._senses[number][1].tolist()) - {0.0}, len(self._places)
        strained = [abs(float(self._states.apart @ state[:count])) for state in (before, after)]
        return len(senses) == 1 and strained[1] < strained[0] and not any(one.holds for one in self.excitations)

    def _over_once(self, response: TransientResponse) -> tuple[float, float]:
        """As `peak`, under loads that end: behind them until friction holds, and what then rings."""
        best = 0.0, 0.0
        for number in range(len(self._spans)):
            found = self._greatest(number, response)
            best = found if found[0] > best[0] * (1.0 + _EVEN) else best
            if number < self._behind:
                continue
            if found[0] < 0.5 * best[0] or (number > self._behind and len(self.machine.masses) == 1):
                return best
            if not self._senses[number][1].any():
                return self._ringing(best, response, (number, number), self._states.holding[0])
        return best


def _dips(first: float, middle: float, last: float) -> bool:
    """Whether a parabola through three even values above zero falls to half of the lesser end between them.

    What has just begun grows from nothing and dips nowhere.
    """
    bend, slope = 2.0 * (first - 2.0 * middle + last), 4.0 * middle - 3.0 * first - last
    turns = slope < 0.0 < 2.0 * bend + slope
    return first > 0.0 and turns and first - 0.25 * slope**2 / bend < 0.5 * min(first, last)
