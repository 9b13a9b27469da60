"""Steady motion with dry friction of the machine as built, by a Runge-Kutta method from one event to the next.

The other road to it: the place of the body and of its base in time, friction as a force that turns with the slip, and
half cycles from rest until one ends where the next begins.  No closed form is asked, and speeds are searched afresh.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from math import cos, sin, sqrt
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.excitations import Excitation
from vibopt.mechanics.built import Course, Joint
from vibopt.mechanics.machine import Machine
from vibopt.records import dataclass
from vibopt.responses import HarmonicResponse
from vibopt.signals import Band
from vibopt.verify.over_bands import Reached

_FIRST, _MOST = 6, 600
"""Half cycles from rest before roots are looked for, and at most."""
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
    """A body on one joint that rubs, under a force on it or on a moving base.

    force, base, omega
        Amplitude of the force [N] and of the base [m]; frequency [rad/s].
    part
        Part of the motion by which an integration may be off.
    begin
        Place and speed at time zero from which it is followed, rest or those of a motion like it.
    """

    machine: Machine
    force: float
    base: float
    omega: float
    part: float = 1e-11
    begin: tuple[float, float] = (0.0, 0.0)

    @property
    def joint(self) -> Joint:
        return self.machine.joints[0]

    @property
    def mass(self) -> float:
        return next(iter(self.machine.masses.values()))

    @property
    def _scale(self) -> FloatArray:
        """Sizes of place and speed that are certainly not too great."""
        push = self.force + self.mass * self.omega**2 * self.base
        return np.array([1.0, self.omega]) * (push / (self.joint.stiffness + self.mass * self.omega**2))

    def _ground(self, time: Any) -> Any:
        """Place, speed and acceleration of the base."""
        turn = self.omega * np.asarray(time)
        moved = self.base * np.array([np.cos(turn), -np.sin(turn), -np.cos(turn)])
        return (moved.T * np.array([1.0, self.omega, self.omega**2])).T

    def _slip(self, time: float, state: FloatArray) -> float:
        return float(state[1]) + self.base * self.omega * sin(self.omega * time)

    def _carried(self, time: float, apart: float) -> float:
        """Force that friction must carry so that nothing slips [N], against a slip forward."""
        held: float = self.force * np.cos(self.omega * time) - self.joint.stiffness * apart
        return float(held - self.mass * self._ground(time)[2])

    def _rates(self, side: float) -> Callable[[float, FloatArray], tuple[float, float]]:
        """Speed and acceleration of the body while it slips."""
        joint, mass, omega = self.joint, self.mass, self.omega
        stiffness, damping, friction = joint.stiffness, joint.damping, side * joint.friction

        def rates(time: float, now: FloatArray) -> tuple[float, float]:
            turn = omega * time
            ahead, slip = now[0] - self.base * cos(turn), now[1] + self.base * omega * sin(turn)
            return now[1], (self.force * cos(turn) - stiffness * ahead - damping * slip - friction) / mass

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
                until, moved = self._held(time, end, float(now[0] - self._ground(time)[0]))
                found.append(_Stretch(time, until, moved, 0.0))
                time, now = until, moved(np.array([until]))[:, 0]
                side = self._side(time, now, leaving=True)
                continue

            watch: Any = partial(self._slip)
            watch.terminal, watch.direction = True, -side
            run: Any = solve_ivp(
                self._rates(side), (time, end), now, method="DOP853", rtol=max(self.part, 3e-14),
                atol=0.01 * self.part * self._scale, dense_output=True, events=watch,
                max_step=0.5 / max(self.omega, sqrt(self.joint.stiffness / self.mass)),
            )  # fmt: skip
            found.append(_Stretch(time, float(run.t[-1]), run.sol, side))
            time, now = float(run.t[-1]), run.y[:, -1].copy()
            if run.status == 1:
                now[1] = self._ground(time)[1]
                after = self._side(time, now)
                side = 0.0 if after == side else after
        return found

    def _side(self, time: float, now: FloatArray, *, leaving: bool = False) -> float:
        """The sense in which what is at rest begins to slip; 0 where friction holds it."""
        carried = self._carried(time, float(now[0] - self._ground(time)[0]))
        holds = abs(carried) <= self.joint.friction * (1.0 - (1e-12 if leaving else 0.0))
        return 0.0 if holds else float(np.sign(carried))

    def _held(self, time: float, end: float, apart: float) -> tuple[float, Callable[[FloatArray], FloatArray]]:
        """When friction can carry no more, or the end; and the motion with the base up to there."""
        from scipy.optimize import brentq

        def moved(at: FloatArray) -> FloatArray:
            here, speed, _ = self._ground(at)
            return np.array([here + apart, speed])

        def beyond(at: float) -> float:
            return abs(self._carried(at, apart)) - self.joint.friction

        at = np.linspace(time, end, 400)
        over = np.array([beyond(one) for one in at]) > 0.0
        rising = np.flatnonzero(over[1:] & ~over[:-1])
        if not len(rising):
            return end, moved
        low, high = at[rising[0]], at[rising[0] + 1]
        return (float(brentq(beyond, low, high, xtol=1e-15 * end)) if beyond(low) < 0.0 else high), moved

    def steady(self) -> list[_Stretch] | None:
        """A half cycle whose end is the negative of its beginning; None where none was found."""
        from scipy.optimize import root

        if (
            self.force + self.mass * self.omega**2 * self.base <= self.joint.friction
        ):  # with its base, to the last digit
            return self.half(np.array([self.base, 0.0]))
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
        apart = max(self.force - joint.friction, 0.0) / joint.stiffness
        carried = np.array([self.force - joint.stiffness * apart])
        points = {body: np.array([[apart + self.base], [0.0], [0.0]])}
        points |= dict.fromkeys(self.machine.bases, np.array([[self.base], [0.0], [0.0]]))
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

    def _most(self, one: _Stretch, response: HarmonicResponse) -> float:
        def value(times: FloatArray) -> FloatArray:
            return np.abs(response.trace(self.machine, self._course(one, times))) * np.ones(len(times))

        count = max(_SAMPLES, int(_DENSE * _natural(self.machine) * (one.end - one.begin)))
        times = np.linspace(one.begin, one.end, count)
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

    def _course(self, one: _Stretch, at: FloatArray) -> Course:
        """Body and base in time, the force from outside, and what friction carries."""
        state, ground, joint = one.moved(at), self._ground(at), self.joint
        body, push = next(iter(self.machine.masses)), self.force * np.cos(self.omega * at)
        if one.side:
            ahead, slip = state - ground[:2]
            carried = one.side * joint.friction * np.ones(len(at))
            faster = (push - joint.stiffness * ahead - joint.damping * slip - carried) / self.mass
        else:
            faster = ground[2]
            carried = push - joint.stiffness * (state[0] - ground[0]) - self.mass * ground[2]
        points = {body: np.array([*state, faster])} | dict.fromkeys(self.machine.bases, ground)
        return Course(points, {body: push}, {joint.name: carried if joint.ends[1] == body else -carried})


def rubbing(
    machine: Machine, response: HarmonicResponse, excitation: Excitation, bands: tuple[Band, ...], *, least: bool
) -> Reached:
    """Greatest value of a response over speeds [rad/s], or the least; and the speed of it."""
    [line] = excitation.lines(np.ones(1))
    last = [(0.0, 0.0)]

    def at(speed: float, part: float = 1e-11) -> float:
        amplitude = float(abs(line.vector[0] * line.amplitude.at(np.array([speed]))[0]))
        ratio = amplitude if response.normalised else 1.0
        if not 0.0 < amplitude < np.inf:
            return 1.0 if response.normalised else amplitude
        on_body = excitation.family == "bodies"
        sizes: Mapping[str, float] = {"force": amplitude * on_body, "base": amplitude * (not on_body)}
        rubbed = Rubbed(machine, **sizes, omega=line.order * speed, part=part, begin=last[0])
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
            push = np.abs(line.vector[0] * line.amplitude.at(grid))
            if excitation.family != "bodies":
                push = next(iter(machine.masses.values())) * (line.order * grid) ** 2 * push
            slips = push > machine.joints[0].friction
            freed = grid[1:][slips[1:] & ~slips[:-1]]
            found += _over(at, band, _natural(machine) / line.order, freed, sign)
    return max(found, key=lambda one: sign * one.value if one.value == one.value else np.inf)


def _natural(machine: Machine) -> float:
    [mass] = machine.masses.values()
    return float(np.sqrt(machine.joints[0].stiffness / mass))


def _endless(rubbed: Rubbed) -> bool:
    """Whether the force gives more in a cycle than friction takes, at an undamped resonance."""
    push = rubbed.force + rubbed.mass * rubbed.omega**2 * rubbed.base
    tuned = abs(rubbed.omega - _natural(rubbed.machine)) <= 1e-14 * rubbed.omega
    return rubbed.joint.damping == 0.0 and tuned and 4.0 * rubbed.joint.friction <= np.pi * push


def _over(at: Callable[..., float], band: Band, natural: float, freed: FloatArray, sign: float) -> list[Reached]:
    """Both ends and the best inside a band, after a rough look at it, and closer behind where what holds is `freed`."""
    from scipy.optimize import minimize_scalar

    low = max(band.low, 5e-2 * min(natural, band.high))
    near = natural * np.array([0.6, 0.8, 0.9, 0.96, 1.0, 1.04, 1.1, 1.3])
    near = np.concatenate([near, np.outer(freed, _FREED).ravel()])
    speeds = np.unique(np.concatenate([np.geomspace(low, band.high, _COARSE), near[(near > low) & (near < band.high)]]))
    rough = sign * np.array([at(speed, 1e-6) for speed in speeds])
    rough = np.where(np.isnan(rough), -np.inf, rough)
    found = [Reached(at(one), one) for one in (low, band.high)]
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


__all__ = ["Rubbed", "rubbing"]
