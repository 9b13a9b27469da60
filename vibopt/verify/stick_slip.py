"""Steady motion with dry friction of the machine as built, by Taylor's series in even steps from one event to the next.

The other road to it: places of bodies and bases in time, friction as a force that turns with the slip, and half
cycles from rest until one ends where the next begins.  No closed form is asked.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray, crossing
from vibopt.mechanics.built import Course, Joint
from vibopt.mechanics.machine import Machine
from vibopt.records import cached_property, dataclass
from vibopt.responses import HarmonicResponse
from vibopt.verify.going import Going, Run
from vibopt.verify.repeating import Repeating
from vibopt.verify.rubbing_states import RubbingStates
from vibopt.verify.simulated import closer
from vibopt.work import worked

_LONGEST, _MANY, _LEAST = 3e4, 2e6, 1e-8
"""Radians of the fastest vibration, and steps of all that also fades, that are followed between two events; part of the
slowest vibration that the force is at least."""
_FADED, _SLOW, _ROUNDING = 37.0, 30.0, 1e-3
"""Exponent behind which a vibration is gone; times as fast as the force from which on it begins where springs are in
balance; part of its speed, of the same size, that rounding hides."""
_STILL, _HELD, _NEARLY = 1e-13, 400, 0.01
"""Part of the greatest below which nothing moves; instants at least among which the end of a hold is looked for; part
of friction that is left where it may end between two of them, and that what slips by hardly anything is beyond it."""
_SAMPLES, _DENSE, _NEAR = 120, 6.0, 0.98
"""Samples of a piece, at least and for each radian of its own vibration; part of the greatest from which tops count."""
_KEPT, _WORK = 256, 5.0
"""Motions that are kept; work of half a cycle [nominal ms]."""
_Law = tuple[FloatArray, FloatArray]


@dataclass(frozen=True, slots=True)
class _Stretch:
    """Part of a half cycle: its ends [s], states against time (2 n, m), the sense of its slip, when it has settled."""

    begin: float
    end: float
    moved: Callable[[FloatArray], FloatArray]
    side: float
    settled: float = float("inf")

    def instants(self, least: int, rate: float) -> FloatArray:
        """Times [s] all along it: at least so many before it has settled, and so many of each second, and behind."""
        lively = min(self.end, self.settled)
        many = max(least, int(rate * (lively - self.begin)))
        behind = np.linspace(lively, self.end, least if lively < self.end else 1)
        return np.union1d(np.linspace(self.begin, lively, many), behind)


@dataclass(frozen=True)
class Rubbed:
    """Bodies on joints to each other, to bases or the ground, of which one rubs, under a force or a moving base.

    force, base, omega
        Amplitude of the force [N] and of the base [m]; frequency [rad/s].
    acts
        On what the force acts, or the base that moves.
    part
        Part of the motion by which an integration may be off.
    begin
        Places and rates of the bodies at time zero from which it is followed, rest or those of a motion like it.
    """

    machine: Machine
    force: float
    base: float
    omega: float
    acts: str
    part: float = 1e-11
    begin: tuple[float, ...] = (0.0,)

    @cached_property
    def states(self) -> RubbingStates:
        return RubbingStates(self.machine, ({self.acts: 1.0},))

    @property
    def joint(self) -> Joint:
        """The one that rubs."""
        return self.states.joint

    @cached_property
    def naturals(self) -> FloatArray:
        """Natural frequencies while it slips, and while friction holds it, ascending [rad/s]."""
        count, bodies = len(self.states.places), len(self.machine.masses)
        pulled = [one[count : count + bodies, :bodies] for one, _ in (self.states.matrices, self.states.holding)]
        squares = np.concatenate([np.linalg.eigvals(-one).real for one in pulled])
        found = np.unique(np.sqrt(squares[squares > _STILL * squares.max()]))
        return np.union1d(found, self.machine.natural_frequencies()) if self.machine.jointed.any() else found

    @cached_property
    def _fastest(self) -> float:
        """Of the load and all vibration [rad/s]."""
        fades = max(float(np.abs(np.diag(one)[: len(self.states.places)]).max()) for one, _ in self._laws)
        return max(self.omega, float(self.naturals[-1]), fades)

    @property
    def _laws(self) -> tuple[_Law, _Law]:
        """While friction holds, and while it slips."""
        return self.states.holding, self.states.matrices

    @cached_property
    def _own(self) -> IntArray:
        """Numbers of the states of bodies."""
        bodies = np.arange(len(self.machine.masses))
        return np.concatenate([bodies, len(self.states.places) + bodies])

    @cached_property
    def _signal(self) -> float:
        """Amplitude of the force [N], or of the acceleration of the base [m/s^2]."""
        return self.force - self.omega**2 * self.base

    def _signals(self, time: Any) -> FloatArray:
        return self._signal * np.cos(self.omega * np.atleast_1d(time))[None, :]

    @cached_property
    def _bound(self) -> ComplexArray:
        """States (2 n,) of a motion that never slips."""
        return self._wave(self.states.holding)

    @cached_property
    def push(self) -> float:
        """Amplitude of what friction alone would have to hold [N]."""
        both, signals = np.array([self._bound.real, self._bound.imag]).T, np.array([[self._signal, 0.0]])
        return float(np.linalg.norm(self.states.carries(both, signals)))

    @cached_property
    def _sizes(self) -> FloatArray:
        """Of a place and of a rate, that are likely."""
        count, states = len(self.states.places), self.states
        pushed = self.push * float(states.given[count:] @ states.apart)
        slipped = pushed / max(self.omega, float(self.naturals[0])) ** 2
        if states.light:
            slipped = -self.push * float(states.yields @ states.apart[: len(states.yields)])
        bound = np.abs(self._bound[: len(self.states.places)]).max()
        sizes = np.array([1.0, max(self.omega, _ROUNDING * float(self.naturals[-1]))])
        return np.asarray((slipped + float(bound)) * sizes)

    @property
    def _scale(self) -> FloatArray:
        return np.repeat(self._sizes, len(self._own) // 2)

    def half(self, start: FloatArray) -> list[_Stretch]:
        """From places and rates of the bodies at time zero on until the force has turned round."""
        worked(_WORK)
        states, end = self.states, np.pi / self.omega
        time, now = 0.0, np.zeros(2 * len(states.places))
        now[self._own] = start
        if self.base:
            now[states.places.index(self.acts)] = self.base
        found: list[_Stretch] = []
        side, vain = states.begins(now, _STILL * self._sizes[1]) or self._sense(0.0, now), False
        while time < end * (1.0 - _STILL):
            found.append(self._slips(time, end, now, side) if side else self._holds(time, end, now, vain=vain))
            vain = side != 0.0 and found[-1].end - time <= _STILL * end
            time, was = found[-1].end, side
            now = found[-1].moved(np.array([time]))[:, 0]
            now = states.stopped(now, self._signals(time), side) if side else now
            side = self._sense(time, now, released=not was)
            side = 0.0 if was and side == was else side
        return found

    def _slips(self, time: float, end: float, now: FloatArray, side: float) -> _Stretch:
        """Up to where the slip stops, or the end."""
        run, moved, settled = self._moved(side, (time, end), now)
        if settled >= end or (run is not None and run.stopped):
            return _Stretch(time, end if run is None else run.end, moved, side)
        apart = self.states.apart @ self._wave(self.states.matrices)[: len(self.states.places)]
        turn = np.angle(1j * side * apart) + self.omega * settled
        stop = settled + (0.5 * np.pi - turn) % (2.0 * np.pi) / self.omega  # where its cosine falls through zero
        return _Stretch(time, min(float(stop), end), moved, side, settled)

    def _holds(self, time: float, end: float, now: FloatArray, *, vain: bool) -> _Stretch:
        """Up to where friction can carry no more, or the end; what slipped in `vain` was pushed by rounding alone."""
        _, moved, settled = self._moved(0.0, (time, end), now)
        whole = _Stretch(time, end, moved, 0.0, settled)

        def beyond(at: FloatArray) -> FloatArray:
            return np.asarray(np.abs(self.states.carries(moved(at), self._signals(at))) - self.joint.friction)

        at = whole.instants(_HELD, _DENSE * float(self.naturals[-1]))
        values = beyond(at)
        friction, before, after = self.joint.friction, np.append(-np.inf, values[:-1]), np.append(values[1:], -np.inf)
        near = (values >= before) & (values >= after) & (values <= 0.0) & (values > -_NEARLY * friction)
        if near.any():  # between instants it may be beyond
            tops, last = np.flatnonzero(near), len(at) - 1
            ends = at[np.maximum(tops - 1, 0)], at[np.minimum(tops + 1, last)]
            at = np.union1d(at, closer(lambda one: beyond(one) + friction, *ends)[1])
            values = beyond(at)
        over = values > 0.0
        rising = np.flatnonzero(over[1:] & ~over[:-1])
        rising = rising[rising > 0] if vain else rising
        if not len(rising):
            return whole
        low, high = at[rising[0] : rising[0] + 2].tolist()
        return replace(whole, end=crossing(lambda one: float(beyond(np.array([one]))[0]), low, high))

    @cached_property
    def _settles(self) -> tuple[float, float]:
        """Seconds in which what swings by itself has faded, in a hold and in a slip; endless where it never has."""
        if self.machine.jointed.any():
            return float("inf"), float("inf")
        held, slips = (law[0][np.ix_(self._own, self._own)] for law in self._laws)
        _, size, ways = np.linalg.svd(self.states.apart[None, : len(self.machine.masses)])
        free = np.kron(np.eye(2), ways[np.count_nonzero(size) :].T)  # beside the slip, which is held
        rates = (np.linalg.eigvals(own).real.max(initial=-np.inf) for own in (free.T @ held @ free, slips))
        held_for, slips_for = (float(_FADED / -rate) if rate < 0.0 else float("inf") for rate in rates)
        return held_for, slips_for

    def _wave(self, law: _Law) -> ComplexArray:
        """States (2 n,) that follow the load for ever, against e^(i omega t)."""
        system, loads = law
        return np.asarray(np.linalg.solve(1j * self.omega * np.eye(len(system)) - system, loads[:, 0] * self._signal))

    def _moved(
        self, side: float, span: tuple[float, float], now: FloatArray
    ) -> tuple[Run | None, Callable[[FloatArray], FloatArray], float]:
        """A run while anything swings by itself; states against time, behind it by the wave; when that is [s]."""
        law, settled = self._laws[abs(int(side))], span[0] + self._settles[abs(int(side))]
        run = None if settled == span[0] else self._going(side).run((span[0], min(settled, span[1])), now)
        if run is not None and (settled >= span[1] or run.stopped):
            return run, run.moved, settled
        wave = self._wave(law)[:, None]

        def waves(at: FloatArray) -> FloatArray:
            return np.asarray((wave * np.exp(1j * self.omega * at)).real)

        stays = (now[:, None] if run is None else run.moved(np.array([run.end]))) - waves(np.array([settled]))
        stays[len(stays) // 2 :] = 0.0

        def moved(at: FloatArray) -> FloatArray:
            behind = stays + waves(at)
            return behind if run is None else np.where(at < settled, run.moved(np.minimum(at, settled)), behind)

        return run, moved, settled

    def _going(self, side: float) -> Going:
        """Motion in a slip in a sense, until it stops, or in a hold."""
        if side not in self._ways:
            (system, loads), friction, falls = self._laws[abs(int(side))], side * self.joint.friction, None
            if side:
                row, size = side * self.states.slips, len(system)
                falls = np.array([*row[:size], row[-1] * self._signal, 0.0, row[size] * friction])
            pushed = loads[:, 0] * self._signal
            self._ways[side] = Going(system, pushed, -friction * self.states.given, self.omega, falls)
        return self._ways[side]

    @cached_property
    def _ways(self) -> dict[float, Going]:
        """Motions so far, by the sense of their slip."""
        return {}

    def _sense(self, time: float, state: FloatArray, *, released: bool = False) -> float:
        """Of the slip that begins at rest, 0 where friction holds, unless it is `released`."""
        carried = float(self.states.carries(state[:, None], self._signals(time))[0])
        return float(np.sign(carried)) if released or abs(carried) > self.joint.friction else 0.0

    def held(self) -> list[_Stretch]:
        """A half cycle in which nothing slips."""

        def moved(at: FloatArray) -> FloatArray:
            return np.asarray((self._bound[:, None] * np.exp(1j * self.omega * at)).real)

        return [_Stretch(0.0, np.pi / self.omega, moved, 0.0)]

    def seen(self, stretch: _Stretch, time: float) -> FloatArray:
        """Places and rates of the bodies, at a time [s]."""
        return np.asarray(stretch.moved(np.array([time]))[self._own, 0])

    def steady(self) -> list[_Stretch] | None:
        """A half cycle whose end is the negative of its beginning; None where none was found."""
        if self.push <= self.joint.friction:  # with what it rubs on, to the last digit
            return self.held()
        lasts = min(max(self._settles), np.pi / self.omega)
        many = lasts / min(self._going(side).step for side in (0.0, 1.0))
        if self.naturals[-1] * lasts > _LONGEST or many > _MANY or self.omega < _LEAST * self.naturals[0]:
            return None
        state = np.resize(self.begin, len(self._scale))
        if not any(self.begin) and self.naturals[0] > _SLOW * self.omega and not self.machine.jointed.any():
            state = self._still

        state, left = self._repeated(state)
        return self.half(state) if left <= 1e3 * self.part else None

    def _repeated(self, state: FloatArray) -> tuple[FloatArray, float]:
        """From a state of the bodies on to one whose negative ends its half cycle, and what is left between them."""

        def after(start: FloatArray) -> FloatArray:
            last = self.half(start)[-1]
            return -self.seen(last, last.end)

        free, brief = not self.machine.jointed.any(), self.push < (1.0 + _NEARLY) * self.joint.friction
        return Repeating(after, self._scale, self.part, free, known=any(self.begin), brief=brief).found(state)

    @property
    def _still(self) -> FloatArray:
        """Places and rates of the bodies where springs would carry what friction leaves of the load at its greatest."""
        states, count = self.states, len(self._own) // 2
        rubbed = self._sense(0.0, self._led) * self.joint.friction
        return np.append(self._loaded + rubbed * states.yields, np.zeros(count))

    @property
    def _led(self) -> FloatArray:
        """States (2 n,) with bodies at rest and a base where it is farthest."""
        found = np.zeros(2 * len(self.states.places))
        if self.base:
            found[self.states.places.index(self.acts)] = self.base
        return found

    @property
    def _loaded(self) -> FloatArray:
        """Places of the bodies (n,) where springs carry the load at its greatest, without friction."""
        bodies, stiff = len(self.machine.masses), self.states.stiffness
        pushed = self.force * np.array([float(name == self.acts) for name in self.machine.masses])
        led = stiff[:bodies, bodies:] @ self._led[bodies : len(stiff)]
        return np.asarray(np.linalg.solve(stiff[:bodies, :bodies], pushed - led))

    def greatest(self, response: HarmonicResponse) -> float:
        """Greatest size of a response in a cycle; nan where no steady motion was found."""
        known: dict[tuple[float, ...], list[_Stretch] | None] = vars(self.machine).setdefault("rubbed", {})
        key = self._key
        if key not in known:  # many rows of an answer ask for the same motion
            if len(known) >= _KEPT:
                known.pop(next(iter(known)))
            known[key] = self.steady()
        stretches = known[key]
        return float("nan") if stretches is None else max(self._most(stretch, response) for stretch in stretches)

    def at_rest(self, response: HarmonicResponse) -> float:
        """Size of a response to a force or a place that never changes."""
        states, bodies = self.states, len(self.machine.masses)
        place, free, per = self._led[: len(states.places)], self._loaded, states.yields
        apart = states.apart[:bodies]
        without = apart @ free + states.apart[bodies:] @ place[bodies:]
        rubs = np.clip(-without / (apart @ per), -self.joint.friction, self.joint.friction)
        place[:bodies] = free + rubs * per
        points = {name: np.array([[at], [0.0], [0.0]]) for name, at in zip(states.places, place.tolist(), strict=True)}
        course = Course(points, self._forces(np.array([self.force])), {self.joint.name: np.array([rubs])})
        return float(np.abs(response.trace(self.machine, course)).max())

    def _forces(self, signal: FloatArray) -> dict[str, FloatArray]:
        """From outside on each body."""
        return {name: signal if name == self.acts else 0.0 * signal for name in self.machine.masses}

    @property
    def _key(self) -> tuple[float, ...]:
        return self.force, self.base, self.omega, self.part

    @property
    def started(self) -> tuple[float, ...]:
        """Where the motion that was found is at time zero; at rest where none was."""
        found = vars(self.machine).get("rubbed", {}).get(self._key)
        if not found:
            return (0.0,)
        return tuple(self.seen(found[0], 0.0).tolist())

    def _most(self, stretch: _Stretch, response: HarmonicResponse) -> float:
        def value(times: FloatArray) -> FloatArray:
            return np.abs(response.trace(self.machine, self.course(stretch, times))) * np.ones(len(times))

        times = stretch.instants(_SAMPLES, _DENSE * float(self.naturals[-1]))
        values = value(times)
        before, after = np.append(-np.inf, values[:-1]), np.append(values[1:], -np.inf)
        tops = np.flatnonzero((values > before) & (values >= after) & (values >= _NEAR * values.max()))
        ends = times[np.maximum(tops - 1, 0)], times[np.minimum(tops + 1, len(times) - 1)]
        return max(float(values.max()), float(closer(value, *ends)[0].max()))

    def course(self, stretch: _Stretch, at: FloatArray) -> Course:
        """Bodies and bases in time, the force from outside, and what friction carries."""
        signals, now = self._signals(at), stretch.moved(at)
        read, rubs = self.states.read(now, signals, np.full(len(at), stretch.side))
        points = dict(zip(self.states.places, read.transpose(1, 0, 2), strict=True))
        return Course(points, self._forces(signals[0]), {self.joint.name: rubs})
