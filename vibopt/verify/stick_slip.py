"""Steady motion with dry friction of the machine as built, by a Runge-Kutta method from one event to the next.

The other road to it: the place of the body and of its base in time, friction as a force that turns with the slip, and
half cycles from rest until one ends where the next begins.  No closed form is asked, and speeds are searched afresh.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import cos, sin
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.excitations import Excitation
from vibopt.mechanics.built import Course, Joint
from vibopt.mechanics.machine import Machine
from vibopt.records import cached_property, dataclass
from vibopt.responses import HarmonicResponse
from vibopt.signals import Band
from vibopt.verify.over_bands import Reached

_FIRST, _MOST = 6, 600
"""Half cycles from rest before roots are looked for, and at most."""
_SLOWEST = 1e5
"""Times as fast as the force that a vibration may be of itself: a turn takes ten steps for each of its radians."""
_SAMPLES, _DENSE, _NEAR, _BETWEEN, _CLOSER = 120, 6.0, 0.98, 33, 3
"""Samples of a piece, at least and for each radian of its own vibration; part of the greatest from which tops count;
samples between those beside a top, and how often."""
_COARSE, _LOOKED, _KEPT, _SPEEDS, _FREED = 9, 2, 256, 400, (1.01, 1.1, 1.18, 1.25, 1.33, 1.45)
"""Speeds of a rough look at a range; best ones that are looked at more closely; motions that are kept; speeds among
which those are looked for at which what holds first slips, and parts of these."""


@dataclass(frozen=True, slots=True)
class _Stretch:
    """Part of a half cycle: its ends [s], place and speed of the body against time (2, n), the sense of its slip."""

    begin: float
    end: float
    moved: Callable[[FloatArray], FloatArray]
    side: float


@dataclass(frozen=True)
class Rubbed:
    """A body on joints to bases or the ground, of which one rubs, under a force on it or a moving base.

    force, base, omega
        Amplitude of the force [N] and of the base [m]; frequency [rad/s].
    moving
        Name of the base that moves.
    part
        Part of the motion by which an integration may be off.
    begin
        Place and speed at time zero from which it is followed, rest or those of a motion like it.
    """

    machine: Machine
    force: float
    base: float
    omega: float
    moving: str = ""
    part: float = 1e-11
    begin: tuple[float, float] = (0.0, 0.0)

    @cached_property
    def joint(self) -> Joint:
        """The one that rubs."""
        return self.machine.rubbing

    @cached_property
    def mass(self) -> float:
        return next(iter(self.machine.masses.values()))

    @cached_property
    def own(self) -> tuple[float, float]:
        """Stiffness [N/m] and damping [N s/m] of all joints."""
        return sum(joint.stiffness for joint in self.machine.joints), sum(
            joint.damping for joint in self.machine.joints
        )

    @cached_property
    def led(self) -> tuple[float, float]:
        """The same of those that end on what moves."""
        some = [joint for joint in self.machine.joints if self.moving in joint.ends]
        return sum(joint.stiffness for joint in some), sum(joint.damping for joint in some)

    @cached_property
    def carrier(self) -> float:
        """Amplitude of that on which the body rubs [m]."""
        return self.base if self.moving in self.joint.ends else 0.0

    @cached_property
    def push(self) -> float:
        """Amplitude of what friction alone would have to hold [N]."""
        (stiff, damped), (pull, drag) = self.own, self.led
        spring = (stiff - self.mass * self.omega**2) * self.carrier - pull * self.base
        return abs(self.force - spring - 1j * self.omega * (damped * self.carrier - drag * self.base))

    @cached_property
    def _scale(self) -> FloatArray:
        """Sizes of place and speed that are certainly not too great."""
        return np.array([1.0, self.omega]) * (self.push / (self.own[0] + self.mass * self.omega**2))

    def _ground(self, time: Any, size: float) -> Any:
        """Place, speed and acceleration of what moves by so much [m]."""
        turn = self.omega * np.asarray(time)
        moved = size * np.array([np.cos(turn), -np.sin(turn), -np.cos(turn)])
        return (moved.T * np.array([1.0, self.omega, self.omega**2])).T

    def _slip(self, time: float, state: FloatArray) -> float:
        return float(state[1]) + self.carrier * self.omega * sin(self.omega * time)

    def _carried(self, time: Any, apart: float) -> Any:
        """Force that friction must carry so that nothing slips [N], against a slip forward."""
        there, base = self._ground(time, self.carrier), self._ground(time, self.base)
        (stiff, damped), (pull, drag) = self.own, self.led
        pushed = self.force * np.cos(self.omega * np.asarray(time)) - stiff * apart
        pushed = pushed - (stiff * there[0] - pull * base[0]) - (damped * there[1] - drag * base[1])
        return pushed - self.mass * there[2]

    def _rates(self, side: float) -> Callable[[float, FloatArray], tuple[float, float]]:
        """Speed and acceleration of the body while it slips."""
        omega, friction = self.omega, side * self.joint.friction
        (stiff, damped), (pull, drag) = self.own, self.led

        def rates(time: float, now: FloatArray) -> tuple[float, float]:
            there, fast = self.base * cos(omega * time), -self.base * omega * sin(omega * time)
            pulled = pull * there + drag * fast - stiff * now[0] - damped * now[1]
            return now[1], (self.force * cos(omega * time) + pulled - friction) / self.mass

        return rates

    def half(self, start: FloatArray) -> list[_Stretch]:
        """From time zero on until the force has turned round."""
        from scipy.integrate import solve_ivp

        time, now, end = 0.0, np.array(start), np.pi / self.omega
        found: list[_Stretch] = []
        slip = self._slip(0.0, now)
        side = float(np.sign(slip)) if abs(slip) > 1e-13 * self._scale[1] else self._side(0.0, now)
        while time < end * (1.0 - 1e-13):
            if side == 0.0:
                until, moved = self._held(time, end, float(now[0] - self._ground(time, self.carrier)[0]))
                found.append(_Stretch(time, until, moved, 0.0))
                time, now = until, moved(np.array([until]))[:, 0]
                side = self._side(time, now, leaving=True)
                continue

            watch: Any = partial(self._slip)
            watch.terminal, watch.direction = True, -side
            run: Any = solve_ivp(
                self._rates(side), (time, end), now, method="DOP853", rtol=max(self.part, 3e-14),
                atol=0.01 * self.part * self._scale, dense_output=True, events=watch,
                max_step=0.5 / max(self.omega, _natural(self.machine)),
            )  # fmt: skip
            found.append(_Stretch(time, float(run.t[-1]), run.sol, side))
            time, now = float(run.t[-1]), run.y[:, -1].copy()
            if run.status == 1:
                now[1] = self._ground(time, self.carrier)[1]
                after = self._side(time, now)
                side = 0.0 if after == side else after
        return found

    def _side(self, time: float, now: FloatArray, *, leaving: bool = False) -> float:
        """The sense in which what is at rest begins to slip; 0 where friction holds it."""
        carried = float(self._carried(time, float(now[0] - self._ground(time, self.carrier)[0])))
        holds = abs(carried) <= self.joint.friction * (1.0 - (1e-12 if leaving else 0.0))
        return 0.0 if holds else float(np.sign(carried))

    def _held(self, time: float, end: float, apart: float) -> tuple[float, Callable[[FloatArray], FloatArray]]:
        """When friction can carry no more, or the end; and the motion with the base up to there."""
        from scipy.optimize import brentq

        def moved(at: FloatArray) -> FloatArray:
            here, speed, _ = self._ground(at, self.carrier)
            return np.array([here + apart, speed])

        def beyond(at: float) -> float:
            return float(abs(self._carried(at, apart)) - self.joint.friction)

        at = np.linspace(time, end, 400)
        over = np.abs(self._carried(at, apart)) > self.joint.friction
        rising = np.flatnonzero(over[1:] & ~over[:-1])
        if not len(rising):
            return end, moved
        low, high = at[rising[0]], at[rising[0] + 1]
        return (float(brentq(beyond, low, high, xtol=1e-15 * end)) if beyond(low) < 0.0 else high), moved

    def steady(self) -> list[_Stretch] | None:
        """A half cycle whose end is the negative of its beginning; None where none was found."""
        from scipy.optimize import root

        if self.push <= self.joint.friction:  # with what it rubs on, to the last digit
            return self.half(np.array([self.carrier, 0.0]))
        if _natural(self.machine) > _SLOWEST * self.omega:
            return None
        scale, state = self._scale, np.array(self.begin)

        def after(start: FloatArray) -> FloatArray:
            last = self.half(start)[-1]
            return -last.moved(np.array([last.end]))[:, 0]

        def missing(one: FloatArray) -> FloatArray:
            return one - after(one * scale) / scale

        for count in range(_MOST):
            following = after(state)
            left = float(np.abs((following - state) / scale).max()) / (1.0 + float(np.abs(state / scale).max()))
            state = following
            if left <= 10.0 * self.part:
                break
            if count % 50 == _FIRST - 4 * any(self.begin):
                found: Any = root(missing, state / scale, tol=10.0 * self.part)
                state = found.x * scale if np.isfinite(found.x).all() and np.abs(found.fun).max() < left else state
        return self.half(state) if left <= 1e3 * self.part else None

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
        joint, body = self.joint, next(iter(self.machine.masses))
        pushed, still = float(self._carried(0.0, 0.0)), np.zeros((3, 1))
        apart = float(np.sign(pushed)) * max(abs(pushed) - joint.friction, 0.0) / self.own[0]
        carried = np.array([pushed - self.own[0] * apart])
        points = {body: np.array([[apart + self.carrier], [0.0], [0.0]])}
        points |= dict.fromkeys(self.machine.bases, still)
        points |= {self.moving: np.array([[self.base], [0.0], [0.0]])} if self.moving else {}
        held = {joint.name: carried if joint.ends[1] == body else -carried}
        course = Course(points, {body: np.array([self.force])}, held)
        return float(np.abs(response.trace(self.machine, course)).max())

    @property
    def _key(self) -> tuple[float, ...]:
        return self.force, self.base, self.omega, self.part

    @property
    def started(self) -> tuple[float, float]:
        """Where the motion that was found is at time zero; at rest where none was."""
        found = vars(self.machine).get("rubbed", {}).get(self._key)
        if not found:
            return 0.0, 0.0
        place, speed = found[0].moved(np.array([0.0]))[:, 0]
        return float(place), float(speed)

    def _most(self, stretch: _Stretch, response: HarmonicResponse) -> float:
        def value(times: FloatArray) -> FloatArray:
            return np.abs(response.trace(self.machine, self.course(stretch, times))) * np.ones(len(times))

        count = max(_SAMPLES, int(_DENSE * _natural(self.machine) * (stretch.end - stretch.begin)))
        times = np.linspace(stretch.begin, stretch.end, count)
        values = value(times)
        best = float(values.max())
        beside = np.concatenate([[-np.inf], values, [-np.inf]])
        tops = np.flatnonzero((values >= beside[:-2]) & (values >= beside[2:]) & (values >= _NEAR * best))
        for i in tops.tolist():
            low, high = times[max(i - 1, 0)], times[min(i + 1, count - 1)]
            for _ in range(_CLOSER):
                some = np.linspace(low, high, _BETWEEN)
                sizes = value(some)
                k = int(sizes.argmax())
                best, low, high = max(best, float(sizes[k])), some[max(k - 1, 0)], some[min(k + 1, _BETWEEN - 1)]
        return best

    def course(self, stretch: _Stretch, at: FloatArray) -> Course:
        """Body and base in time, the force from outside, and what friction carries."""
        state, joint = stretch.moved(at), self.joint
        there, base = self._ground(at, self.carrier), self._ground(at, self.base)
        body, push = next(iter(self.machine.masses)), self.force * np.cos(self.omega * at)
        if stretch.side:
            carried = stretch.side * joint.friction * np.ones(len(at))
            pulled = np.dot(self.led, base[:2]) - np.dot(self.own, state)
            faster = (push + pulled - carried) / self.mass
        else:
            faster, carried = there[2], self._carried(at, state[0] - there[0])
        points = {name: np.zeros((3, len(at))) for name in self.machine.bases} | {body: np.array([*state, faster])}
        points |= {self.moving: base} if self.moving else {}
        return Course(points, {body: push}, {joint.name: carried if joint.ends[1] == body else -carried})


def rubbing(
    machine: Machine, response: HarmonicResponse, excitation: Excitation, bands: tuple[Band, ...], *, least: bool
) -> Reached:
    """Greatest value of a response over speeds [rad/s], or the least; and the speed of it."""
    [line] = excitation.lines(np.ones(1))
    last = [(0.0, 0.0)]

    def made(speed: float, part: float = 1e-11) -> Rubbed:
        amplitude = float(abs(line.vector[0] * line.amplitude.at(np.array([speed]))[0]))
        on_body = excitation.family == "bodies"
        force, base, moving = (amplitude, 0.0, "") if on_body else (0.0, amplitude, excitation.on)
        return Rubbed(machine, force, base, line.order * speed, moving, part, last[0])

    def at(speed: float, part: float = 1e-11) -> float:
        rubbed = made(speed, part)
        amplitude = rubbed.force + rubbed.base
        ratio = amplitude if response.normalised else 1.0
        if not 0.0 < amplitude < np.inf:
            return 1.0 if response.normalised else amplitude
        if not speed:
            return rubbed.at_rest(response) / ratio
        if _endless(rubbed):
            return float("inf")
        value = rubbed.greatest(response) / ratio
        last[0] = rubbed.started
        return value

    sign = -1.0 if least else 1.0
    found = [Reached(at(band.low), band.low) for band in bands if band.is_point]
    for band in bands:
        if not band.is_point:
            grid = np.geomspace(max(band.low, 1e-3 * band.high), band.high, _SPEEDS)
            slips = np.array([one.push > one.joint.friction for one in map(made, grid.tolist())])
            freed = grid[1:][slips[1:] & ~slips[:-1]]
            found += _over(at, band, _natural(machine) / line.order, freed, sign)
    return max(found, key=lambda one: sign * one.value if one.value == one.value else np.inf)


def _natural(machine: Machine) -> float:
    [mass] = machine.masses.values()
    return float(np.sqrt(sum(joint.stiffness for joint in machine.joints) / mass))


def _endless(rubbed: Rubbed) -> bool:
    """Whether the force gives more in a cycle than friction takes, at an undamped resonance."""
    tuned = abs(rubbed.omega - _natural(rubbed.machine)) <= 1e-14 * rubbed.omega
    return rubbed.own[1] == 0.0 and tuned and 4.0 * rubbed.joint.friction <= np.pi * rubbed.push


def _over(at: Callable[..., float], band: Band, natural: float, freed: FloatArray, sign: float) -> list[Reached]:
    """Both ends and the best inside a band, after a rough look at it, and closer behind where what holds is `freed`."""
    from scipy.optimize import minimize_scalar

    low = max(band.low, 5e-2 * min(natural, band.high))
    near = natural * np.array([0.6, 0.8, 0.9, 0.96, 1.0, 1.04, 1.1, 1.3])
    near = np.concatenate([near, np.outer(freed, _FREED).ravel()])
    speeds = np.unique(np.concatenate([np.geomspace(low, band.high, _COARSE), near[(near > low) & (near < band.high)]]))
    rough = sign * np.array([at(speed, 1e-6) for speed in speeds])
    rough = np.where(np.isnan(rough), -np.inf, rough)
    found = [Reached(at(value), value) for value in (low, band.high)]
    after = np.append(rough[1:], -np.inf)
    tops = (rough >= np.append(-np.inf, rough[:-1])) & (rough >= after + 1e-9 * np.abs(rough))  # not where all holds
    hopeful = np.flatnonzero(tops & (rough >= (1.0 - 0.2 * sign) * rough.max()))
    for i in hopeful[np.argsort(-rough[hopeful])][:_LOOKED]:
        ends = speeds[max(i - 1, 0)], speeds[min(i + 1, len(speeds) - 1)]
        if np.isinf(rough[i]):
            return [Reached(sign * float(rough[i]), float(speeds[i]))]
        room: Any = {"xatol": 1e-6 * ends[1]}
        top: Any = minimize_scalar(lambda one: -sign * at(one), bounds=ends, method="bounded", options=room)
        found.append(Reached(-sign * float(top.fun), float(top.x)))
    return found
