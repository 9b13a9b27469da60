"""Greatest response in time of the machine as built, by a Runge-Kutta method of eighth order.

The other road to a peak in time: bodies and joints with their positions and velocities, and the signals as functions
of time; no exponential of a matrix, and no segment.  Behind the load it goes on until the motion has faded, or over
a thousand periods of what is next to undamped; under sines that last until only these are left, which are then steady,
and what nothing damps.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.excitations.excitation import Excitation, Once
from vibopt.mechanics.built import Course
from vibopt.mechanics.combine import whole_orders
from vibopt.mechanics.machine import Machine
from vibopt.records import dataclass
from vibopt.responses import TransientResponse
from vibopt.scene.drives import names_for
from vibopt.scene.scene import Scene
from vibopt.verify.states import States

_RELATIVE, _IMPLICIT, _ABSOLUTE, _ROUGH = 1e-12, 1e-9, 1e-13, 1e-4
_STIFF = 2e5
"""Fastest rate times the time to go beyond which an implicit method is used."""
_LONG, _TURN, _TAYLOR = 60.0, 0.25, 14
"""Fastest rate times the time from which on steps are even, how far it turns in one of them, and terms of a series."""
_PLACES, _WEIGHTS = (0.5 * one for one in np.polynomial.legendre.leggauss(8))
_SAMPLES, _BEST, _POINTS, _NEAR = 24, 6, 100, 0.9
"""Samples in the shortest period; greatest ones that are looked at more closely; points of a record in a period; part
of the greatest from which an end of a stretch is looked at, too."""
_LEVEL, _LEVELS = 1e-4, 200
"""Part of the greatest top by which others may be lower and still be it, and how many of them are looked at closely."""
_ZOOMS, _ACROSS, _MANY = 5, 33, (50_000, 500_000)
"""Closer looks at each of them, and points of one; most samples of a stretch, without and beside what lasts."""
_PERIODS, _LOOKS, _HORIZON, _BESIDE, _LONGEST = 3.0, 6, 1000.0, 200.0, 4e5
"""Periods of the slowest mode in a look behind the load, how many looks there are, periods in all, beside what lasts
before modes are told apart, and turns of the fastest over which they are then followed."""
_INSIDE, _SOON = 1e-9, 1e-12
"""Part of a stretch, and of the time in which anything changes, by which signals are read inside: ends may be jumps."""
_EVEN = 1e-9
"""Part by which a later peak must be greater to be told."""
_SLOW, _AWAY = 1e-8, 1e-6
"""Rate at which a drift is looked for, per look; part of a reading by which it must grow in one to count."""
_MET, _NONE, _GONE, _FINE = 1e-9, 1e-12, 1e-12, 400
"""Parts: of a speed by which it misses a pole, of a frequency that is no decay, to which all fades; samples a turn."""
_DEGREE, _RESOLVED, _AGAIN = 32, 1e-13, 40
"""Of polynomials through a slow load, what they may leave over, and how often its motion is made better at most."""
_DEFECTIVE, _CHUNK, _FADED = 1e8, 20_000, 1e-3
"""Condition beyond which modes are no use; samples at once; part to which modes fade before nothing more is seen."""


@dataclass(frozen=True)
class Simulated:
    """A built machine, and what comes over it once; simulated as far as it is asked for, `loose`: to a few digits."""

    machine: Machine
    excitations: tuple[Once, ...]
    loose: bool = False

    def peak(self, response: TransientResponse) -> tuple[float, float]:
        """Greatest size of a response, and when [s]."""
        best, loaded = (0.0, 0.0), len(self._spans) - _LOOKS
        ended = replace(self, excitations=self._over) if self._lasting else self
        if self._driven_at_resonance or ended._runs_away(response):
            return float("inf"), float("inf")
        for number in range(len(self._spans)):
            found = self._greatest(number, response)
            if (
                not self._lasting
                and number >= loaded
                and (found[0] < 0.5 * best[0] or (number > loaded and len(self.machine.masses) == 1))
            ):
                return best if best[0] >= found[0] else found  # of one body every later turn is no greater
            best = found if found[0] > best[0] * (1.0 + _EVEN) else best
        if self._lasting:
            best, steady = self._beating(best, response), self._steady(response)
            return (steady, float("inf")) if steady > best[0] * (1.0 + _EVEN) else best
        return self._ringing(best, response)

    @cached_property
    def _lasting(self) -> tuple[Once, ...]:
        """Excitations that go on for ever."""
        return tuple(one for one in self.excitations if one.endless)

    def _steady(self, response: TransientResponse) -> float:
        """Greatest of a response to what goes on for ever, when all else has faded."""
        speeds, waves = self._driven(response)
        for turns, wave in self._undamped(response):
            same = next((i for i, one in enumerate(speeds) if abs(one - turns) <= _NONE * 10.0 * turns), None)
            if same is not None:
                waves[same] += wave
            else:
                waves, speeds = [*waves, wave], [*speeds, turns]
        sizes = np.abs(waves)
        felt = [i for i, size in enumerate(sizes) if size > _MET * sizes.max()] or [0]
        waves, speeds = [waves[i] for i in felt], [speeds[i] for i in felt]
        orders = whole_orders(tuple(one / min(speeds) for one in speeds))
        if orders is None:
            return float(np.abs(waves).sum())
        angles = np.linspace(0.0, 2.0 * np.pi, int(_FINE * orders.max()) + 1)
        values = np.abs(np.imag(np.array(waves) @ np.exp(1j * orders[:, None] * angles)))
        return max(_top(values, at) for at in _tops(np.concatenate([values[-2:-1], values, values[1:2]])))

    def _driven(self, response: TransientResponse) -> tuple[list[float], list[complex]]:
        """Speed and wave of each response to what goes on for ever."""
        waves: list[complex] = []
        speeds: list[float] = []
        for one in self._lasting:
            speed, own = np.array([2.0 * np.pi / one.length]), one.blows.get(0.0, 0.0) * one.length / (2.0 * np.pi)
            size = np.array([own or float(one.signal(np.array([0.25 * one.length]))[0])], dtype=complex)
            acts = {one.on: size}
            motion = self.machine.shake(speed, *((acts, {}) if one.family == "bodies" else ({}, acts)))
            waves.append(complex(response.steady.measure(self.machine, motion)[0]))
            speeds.append(float(speed[0]))
        return speeds, waves

    def _undamped(self, response: TransientResponse) -> list[tuple[float, complex]]:
        """Speed and wave of each vibration that was left and that nothing damps."""
        rates, waves = self._free(response)
        if not len(rates):
            return []
        rings = (rates.imag > 0.0) & (np.abs(rates.real) <= self._no_decay(rates))
        waves = waves * np.exp(-1j * rates.imag * self._spans[-_LOOKS][0])
        return [(float(rate.imag), complex(wave)) for rate, wave in zip(rates[rings], waves[rings], strict=True)]

    @staticmethod
    def _no_decay(rates: ComplexArray) -> FloatArray:
        return np.asarray(np.maximum(_NONE * np.abs(rates), 1e-15 * np.abs(rates).max()))

    def _beating(self, best: tuple[float, float], response: TransientResponse) -> tuple[float, float]:
        """The greater of the best so far and of what fades slowly beside what lasts, turn by turn."""
        rates, free = self._free(response)
        falls = -rates.real[-rates.real > self._no_decay(rates)] if len(rates) else rates.real
        if not len(falls):
            return best
        speeds, driven = self._driven(response)
        low, lasts = self._spans[-_LOOKS][0], 1j * np.array(speeds)
        every, waves = np.concatenate([lasts, rates]), np.concatenate([driven * np.exp(lasts * low), free])
        begin, step = self._spans[-1][1] - low, 2.0 * np.pi / (_SAMPLES * float(np.abs(every.imag).max()))
        end = min(begin - math.log(_GONE) / float(falls.min()), _LONGEST * step * _SAMPLES)

        def value(times: FloatArray) -> FloatArray:
            return np.asarray(np.abs(np.imag(waves @ np.exp(every[:, None] * times))))

        while begin < end and float((np.abs(waves) * np.exp(every.real * begin)).sum()) > best[0] * (1.0 + _EVEN):
            times = np.asarray(begin + step * np.arange(_CHUNK), dtype=float)
            for at in _tops(value(times)):
                fine = np.asarray(times[at] + step * np.linspace(-1.0, 1.0, 2001), dtype=float)
                top = value(fine)
                best = max(best, (float(top.max()), low + float(fine[top.argmax()])))
            begin = float(times[-2])
        return best

    def _free(self, response: TransientResponse) -> tuple[ComplexArray, ComplexArray]:
        """Rates of free vibrations beside what lasts, one of each pair, and the wave of each at the first look."""
        from scipy.linalg import eig

        system, loads = self._states.matrices
        low = self._spans[-_LOOKS][0]
        free = np.asarray(self._run(len(self._spans) - _LOOKS)(low), dtype=float)
        for one, load in zip(self.excitations, loads.T, strict=True):
            if one.endless:
                speed, size = 2.0 * np.pi / one.length, float(one.signal(np.array([0.25 * one.length]))[0])
                follows = np.linalg.solve(1j * speed * np.eye(len(system)) - system, load * size)
                free = free - np.imag(follows * np.exp(1j * speed * low))
        known: Any = eig(system, left=True, right=True)
        rates, left, shapes = known
        once = (rates.imag >= 0.0) & (np.abs(rates) > _NONE * np.abs(rates).max())
        rates, left, shapes = rates[once], left[:, once].conj().T, shapes[:, once]
        if not len(rates) or np.linalg.cond(left @ shapes) > _DEFECTIVE:
            return np.zeros(0, dtype=complex), np.zeros(0, dtype=complex)
        states = shapes * np.linalg.solve(left @ shapes, left @ free) * np.where(rates.imag > 0.0, 2.0, 1.0)
        every = np.hstack([np.zeros((len(system), 1)), states.real, states.imag])
        quiet = np.full(every.shape[1], 2.0 * self._spans[-1][1])
        still, *read = (response.trace(self.machine, self._course(quiet, every)) * np.ones(len(quiet))).tolist()
        count = len(rates)
        waves = [1j * (read[i] - still + 1j * (read[count + i] - still)) for i in range(count)]
        return rates, np.array(waves, dtype=complex)

    @property
    def _over(self) -> tuple[Once, ...]:
        """Excitations that end."""
        return tuple(one for one in self.excitations if not one.endless)

    @property
    def _driven_at_resonance(self) -> bool:
        """Whether what goes on for ever meets a vibration that nothing damps."""
        poles = self.machine.poles() if self._lasting else np.zeros(0)
        return any((np.abs(poles * one.length / (2.0 * np.pi) - 1.0) < _MET).any() for one in self._lasting)

    def _runs_away(self, response: TransientResponse) -> bool:
        """Whether a reading grows without end behind the load: s^2 / (s - A) of the state is what drifts, as s -> 0."""
        if not self.excitations:
            return False
        system, low = self._states.matrices[0], self._spans[-_LOOKS][0]
        count = len(self._places)
        s = _SLOW / self._look
        state = self._run(len(self._spans) - _LOOKS)(low)
        drift = s**2 * np.linalg.solve(s * np.eye(2 * count) - system, state)
        drift[count:] = 0.0
        quiet = np.array([self._spans[-1][1] * 2.0])
        alone = np.where(np.arange(2 * count) < len(self.machine.masses), drift, 0.0)
        rate, cancelled = (
            float(np.abs(response.trace(self.machine, self._course(quiet, one[:, None]))).max())
            for one in (drift, alone)
        )
        if rate <= _AWAY * cancelled:
            return False
        most = max(self._greatest(number, response)[0] for number in range(len(self._spans) - _LOOKS + 1))
        return rate * self._look > _AWAY * most

    @cached_property
    def _look(self) -> float:
        """How long a look behind the load is [s]: some periods of the slowest mode, or a part of all that fades."""
        modes = self.machine.natural_frequencies()
        slow = float(modes[modes > 1e-9 * modes.max(initial=0.0)].min(initial=np.inf))
        if self._lasting:
            poles = self.machine.poles()
            decays = np.abs(poles.imag)
            moving, rings = decays[decays > _NONE * slow], (decays <= _NONE * slow) & (np.abs(poles) > _MET * slow)
            faded = -np.log(_GONE) / float(moving.min()) if len(moving) else _PERIODS * 2.0 * np.pi / slow
            faded = faded if len(moving) + rings.sum() == len(decays) else np.inf
            return min(faded, _BESIDE * 2.0 * np.pi / slow) / _LOOKS + max(one.length for one in self._lasting)
        return _PERIODS * 2.0 * np.pi / slow if np.isfinite(slow) else max(one.length for one in self.excitations)

    @cached_property
    def _spans(self) -> list[tuple[float, float]]:
        """Stretches of time without joints, those behind the load last [s]."""
        look, joints = self._look, sorted({*self._joints, *self._late})
        return [*pairwise(joints), *((joints[-1] + i * look, joints[-1] + (i + 1) * look) for i in range(_LOOKS))]

    @cached_property
    def _runs(self) -> list[Any]:
        """Stretches simulated so far, each as a function of time."""
        return []

    @cached_property
    def _fades(self) -> float:
        """How long it takes until all that vibrates freely is rounding [s]."""
        return -math.log(_GONE) / max(float(np.abs(self.machine.poles().imag).min(initial=np.inf)), 1e-300)

    @cached_property
    def _joints(self) -> list[float]:
        return sorted({joint for one in self.excitations for joint in one.joints})

    @cached_property
    def _late(self) -> set[float]:
        """Times from which on a smooth load alone counts [s]: all fades early in stretches that are so long."""
        long = max(_STIFF / max(self._own_rate, 1e-300), 2.0 * self._fades)
        pairs = pairwise(self._joints) if self._step == np.inf else ()
        return {low + self._fades for low, high in pairs if high - low > long}

    @cached_property
    def _states(self) -> States:
        acts, bases = tuple(one.on for one in self.excitations), self.machine.bases
        far = [one for one in self.excitations if one.on in bases and not one.returns and not one.endless]
        ends = {end for joint in self.machine.joints for end in joint.ends}
        alone = len(bases) == 1 and bool(far) and not self._lasting and ends <= {*self.machine.masses, *bases}
        long = max(one.length for one in self.excitations) * self._own_rate > _STIFF if alone else False
        return States(self.machine, acts, next(iter(bases)) if long else "")

    @property
    def _places(self) -> list[str]:
        """Bodies, and bases behind them."""
        return self._states.places

    def _fastest(self, number: int) -> float:
        """Fastest rate on a stretch [1/s]: of the machine, and of the signals while they last."""
        acting = self.excitations if self._loaded(number) else self._lasting
        return max([self._own_rate, *(one.fastest for one in acting)])

    @cached_property
    def _own_rate(self) -> float:
        return float(np.abs(self.machine.poles()).max(initial=0.0))

    def _loaded(self, number: int) -> bool:
        return number < len(self._spans) - _LOOKS

    def _signals(self, time: FloatArray) -> FloatArray:
        return np.array([one.signal(time) for one in self.excitations])

    def _start(self, number: int) -> FloatArray:
        """Positions and velocities of bodies and bases at the beginning of a stretch, as blows have left them."""
        time = self._spans[number][0]
        struck: FloatArray = self._states.matrices[1] @ np.array([one.blows.get(time, 0.0) for one in self.excitations])
        if number == 0:
            return struck
        found: FloatArray = np.asarray(self._runs[-1](time), dtype=float) + struck
        if number == len(self._spans) - _LOOKS:
            for base in self.machine.bases:
                every = [one for one in self.excitations if one.on == base]
                if all(one.returns for one in every):  # back to the last digit, or rounding would carry it away
                    at, came = self._places.index(base), [(0.0, 0.0), *(one.course(time) for one in every)]
                    found[[at, at + len(self._places)]] = np.sum(came, axis=0)
        return found

    @property
    def _step(self) -> float:
        """Longest step while a load acts: not over a sample of a record [s]."""
        return min(one.step for one in self.excitations)

    def _rates(self, low: float, high: float) -> Callable[[float, FloatArray], FloatArray]:
        """Rates of the states on a stretch of time."""
        edge, (system, loads) = _INSIDE * (high - low), self._states.matrices

        def rates(time: float, now: FloatArray) -> FloatArray:
            signals = self._signals(np.array([min(max(time, low + edge), high - edge)]))[:, 0]
            found: FloatArray = system @ now + loads @ signals
            return found

        return rates

    def _run(self, number: int) -> Any:
        """States against time on a stretch, (2 n, n_times)."""
        from scipy import integrate

        while len(self._runs) <= number:
            current = len(self._runs)
            low, high = self._spans[current]
            start = self._start(current)
            if len(self.excitations) == 1 and self.excitations[0].even and not self._runs:
                self._runs.append(self._sampled(high, start))
                continue
            if low in self._late:
                settled = self._settled(low, high, start)
                if settled is not None:
                    self._runs.append(settled)
                    continue
            turned = self._fastest(current) * (high - low)
            smooth = self._step == np.inf or not self._loaded(current)
            if smooth and _LONG < turned <= _STIFF:
                self._runs.append(self._stepped(low, high, start, int(turned / _TURN) + 1))
                continue
            rates = self._rates(low, high)
            way: Any = "Radau" if self._fastest(current) * (high - low) > _STIFF else "DOP853"
            rough: Any = integrate.solve_ivp(
                rates,
                (low, high),
                start,
                method=way,
                rtol=_ROUGH,
                atol=_ROUGH**2 * (np.abs(start).max() or 1e-6),
                dense_output=self.loose,
            )
            if self.loose:
                self._runs.append(rough.sol)
                continue
            size = np.abs(rough.y).reshape(2, -1).max(axis=1).repeat(len(start) // 2)
            exact: Any = integrate.solve_ivp(
                rates, (low, high), start, method=way, rtol=_RELATIVE if way == "DOP853" else _IMPLICIT,
                atol=_ABSOLUTE * np.where(size > 0.0, size, 1.0), dense_output=True,
                max_step=self._step if self._loaded(current) else np.inf,
            )  # fmt: skip
            self._runs.append(exact.sol)
        return self._runs[number]

    def _stepped(self, low: float, high: float, start: FloatArray, count: int) -> Any:
        """States against time on a long stretch, by Duhamel's integral in so many steps, each by Gauss's rule."""
        from scipy.linalg import expm

        (system, loads), places = self._states.matrices, len(self._places)
        step, edge = (high - low) / count, _INSIDE * (high - low)
        times: FloatArray = low + step * np.arange(count, dtype=float)

        def forced(begin: FloatArray, length: Any) -> list[tuple[FloatArray, Any]]:
            """What is added at the places of Gauss's rule, and how long before the end."""
            found: list[tuple[FloatArray, Any]] = []
            for place, weight in zip(0.5 + _PLACES, _WEIGHTS, strict=True):
                signals = self._signals(np.clip(begin + place * length, low + edge, high - edge))
                found.append((weight * length * (loads @ signals), (1.0 - place) * length))
            return found

        added = np.sum([expm(system * left) @ one for one, left in forced(times, step)], axis=0).T
        states, onward = np.empty((count, 2 * places)), expm(system * step)
        states[0] = start
        for j in range(count - 1):
            states[j + 1] = onward @ states[j] + added[j]

        def run(at: Any) -> FloatArray:
            at = np.atleast_1d(np.asarray(at, dtype=float))
            which = np.clip(((at - low) / step).astype(int), 0, count - 1)
            length = at - times[which]
            found = _carried(system, states[which].T, length)
            for one, left in forced(times[which], length):
                found = found + _carried(system, one, left)
            return found

        return lambda at: run(at) if np.ndim(at) else run(at)[:, 0]

    def _settled(self, low: float, high: float, start: FloatArray) -> Any:
        """States against time where all has faded but what follows a slow load; None where the load is not slow.

        x' = A x + f has the solution x = A^-1 (x' - f) again and again, on polynomials of time.
        """
        from numpy.polynomial import chebyshev

        (system, loads), bodies, count = self._states.matrices, len(self.machine.masses), len(self._places)
        half, edge = 0.5 * (high - low), _INSIDE * (high - low)
        nodes = np.cos(np.pi * (np.arange(_DEGREE + 1.0) + 0.5) / (_DEGREE + 1.0))
        seen = self._signals(np.clip(low + half * (1.0 + nodes), low + edge, high - edge))
        signals = chebyshev.chebfit(nodes, seen.T, _DEGREE)
        if (np.abs(signals[-3:]) > _RESOLVED * np.abs(signals).max(axis=0)).any():
            return None
        states = np.zeros((_DEGREE + 3, 2 * count))
        pushed = signals @ loads.T
        for base in range(bodies, count):
            speed, place = count + base, system[base, count + base]
            states[:-1, speed] = chebyshev.chebint(pushed[:, speed], k=start[speed], lbnd=-1.0, scl=half)
            states[:, base] = chebyshev.chebint(place * states[:-1, speed], k=start[base], lbnd=-1.0, scl=half)
        own = np.r_[:bodies, count : count + bodies]
        own = own[system[own].any(axis=1)]
        pulled = states @ system[own].T
        pulled[: _DEGREE + 1] += pushed[:, own]
        moved, before = np.zeros(pulled.shape), np.inf
        for _ in range(_AGAIN):
            rates = np.vstack([chebyshev.chebder(moved) / half, np.zeros(len(own))])
            fresh = np.linalg.solve(system[np.ix_(own, own)], (rates - pulled).T).T
            change, moved = float(np.abs(fresh - moved).max()), fresh
            if change <= _RESOLVED**2 * np.abs(moved).max() or not change < before:
                break
            before = change
        states[:, own] = moved
        return lambda at: chebyshev.chebval((np.asarray(at) - low) / half - 1.0, states)

    def _sampled(self, high: float, start: FloatArray) -> Any:
        """States against time through a record: exact at many points from sample to sample, cubic between them."""
        from scipy.interpolate import CubicHermiteSpline
        from scipy.signal import lsim

        system, loads = self._states.matrices
        count, step = len(self._places), self.excitations[0].step
        fine = int(np.ceil(_POINTS * self._fastest(0) * step / (2.0 * np.pi)))
        times = np.linspace(0.0, high, round(high / step) * fine + 1)
        signals = self._signals(times).T
        matrices = (system, loads, np.eye(2 * count), np.zeros((2 * count, loads.shape[1])))
        states = np.atleast_2d(lsim(matrices, signals, times, X0=start)[1].reshape(len(times), -1))
        spline: Any = CubicHermiteSpline(times, states, states @ system.T + signals @ loads.T)
        return lambda at: spline(at).T

    def _greatest(self, number: int, response: TransientResponse) -> tuple[float, float]:
        """Greatest size on a stretch, and when."""
        (low, high), run = self._spans[number], self._run(number)
        edge = max(min(_INSIDE * (high - low), _SOON / self._fastest(number)), 8.0 * np.finfo(float).eps * high)

        def value(time: Any) -> FloatArray:
            at = np.clip(np.atleast_1d(time), low + edge, high - edge)
            return np.abs(response.trace(self.machine, self._course(at, run(at)))) * np.ones(len(at))

        count = int(
            np.clip(
                _SAMPLES * self._fastest(number) * (high - low) / (2.0 * np.pi), _SAMPLES, _MANY[bool(self._lasting)]
            )
        )
        bent = np.concatenate([one.kinks for one in self.excitations])
        times = np.union1d(np.linspace(low, high, count), bent[(bent > low) & (bent < high)])
        values, count = value(times), len(times)
        tops = np.flatnonzero((values[1:-1] >= values[:-2]) & (values[1:-1] >= values[2:])) + 1
        found = max((float(values[i]), float(times[i])) for i in (0, int(values.argmax()), count - 1))
        edges = [i for i in (0, count - 1) if values[i] > _NEAR * values.max()]  # a top may hide beside an end
        near = np.unique([*tops[np.argsort(-values[tops])[:_BEST]], *_even_tops(values), *edges]).astype(int)
        left, right = times[np.maximum(near - 1, 0)], times[np.minimum(near + 1, count - 1)]
        for _ in range(_ZOOMS if len(near) else 0):  # all tops at once, each time between the neighbours of its best
            closer = np.linspace(left, right, _ACROSS, axis=1)
            sizes, rows = value(closer.ravel()).reshape(closer.shape), np.arange(len(near))
            at = sizes.argmax(axis=1)
            found = max(found, *zip(sizes[rows, at].tolist(), closer[rows, at].tolist(), strict=True))
            left, right = closer[rows, np.maximum(at - 1, 0)], closer[rows, np.minimum(at + 1, _ACROSS - 1)]
        return found

    def _course(self, time: FloatArray, states: FloatArray) -> Course:
        signals = self._signals(time)
        points = dict(zip(self._places, self._states.read(states, signals).transpose(1, 0, 2), strict=True))
        forces = dict.fromkeys(self.machine.masses, np.zeros(len(time)))
        for one, signal in zip(self.excitations, signals, strict=True):
            if one.on in forces:
                forces[one.on] = forces[one.on] + signal
        return Course(points, forces)

    def _ringing(self, best: tuple[float, float], response: TransientResponse) -> tuple[float, float]:
        """The greater of the best so far and of what rings on behind the last look, by modes."""
        low = self._spans[-_LOOKS][0]
        rates, shapes = np.linalg.eig(self._states.matrices[0])
        waves = None
        if np.linalg.cond(shapes) > _DEFECTIVE:  # with what drifts, which is not read: what swings alone
            rates, waves = self._free(response)
            if not len(rates):
                return best
        else:
            state = self._run(len(self._spans) - _LOOKS)(low)
            shares = shapes * np.linalg.solve(shapes, state.astype(complex))
        begin, end = self._spans[-1][1] - low, self._look / _PERIODS * _HORIZON
        step = 2.0 * np.pi / (_SAMPLES * max(float(np.abs(rates.imag).max()), 1e-300))
        quiet = self._spans[-1][1] * 2.0

        def value(times: FloatArray) -> FloatArray:
            turned = np.exp(rates[:, None] * times)
            if waves is not None:
                return np.asarray(np.abs(np.imag(waves @ turned)))
            course = self._course(np.full(len(times), quiet), np.real(shares @ turned))
            return np.abs(response.trace(self.machine, course)) * np.ones(len(times))

        while begin < end:
            times = np.asarray(begin + step * np.arange(min(_CHUNK, int((end - begin) / step) + 2)), dtype=float)
            values = value(times)
            for at in _tops(values):
                fine = np.asarray(times[at] + step * np.linspace(-1.0, 1.0, 2001), dtype=float)
                top = value(fine)
                if top.max() > best[0] * (1.0 + _EVEN):
                    best = float(top.max()), low + float(fine[top.argmax()])
            begin = float(times[-1])
            faded = np.abs(np.exp(rates.real * begin)).max(where=np.abs(rates.imag) > 0.0, initial=0.0)
            if faded < _FADED * np.abs(np.exp(rates.real * (self._spans[-1][1] - low))).max():
                break
        return best


def _carried(system: FloatArray, states: FloatArray, time: Any) -> FloatArray:
    """States (N, n) after short times (n,) of free motion, by Taylor's series."""
    found, term = states, states
    for k in range(1, _TAYLOR):
        term = system @ term * (time / k)
        found = found + term
    return found


def _heights(values: FloatArray) -> tuple[IntArray, FloatArray]:
    """Where samples have tops, and how high parabolas through three of them are there."""
    left, middle, right = values[:-2], values[1:-1], values[2:]
    inner = np.flatnonzero((middle >= left) & (middle >= right))
    bent = np.maximum(2.0 * middle[inner] - left[inner] - right[inner], 1e-300)
    return inner + 1, middle[inner] + (right[inner] - left[inner]) ** 2 / (8.0 * bent)


def _tops(values: FloatArray) -> list[int]:
    """Where parabolas through three samples are greatest, a few of them."""
    at, high = _heights(values)
    return [int(one) for one in at[np.argsort(-high)[:_BEST]]]


def _even_tops(values: FloatArray) -> list[int]:
    """Where samples have tops that may be the greatest; of many, some all along."""
    at, high = _heights(values)
    good = at[high >= (1.0 - _LEVEL) * high.max(initial=0.0)]
    return [int(one) for one in good[:: max(1, len(good) // _LEVELS)]]


def _top(values: FloatArray, at: int) -> float:
    """Height of the parabola through three samples of one turn, its ends the same."""
    left, middle, right = (float(values[(at - 1 + step) % (len(values) - 1)]) for step in (-1, 0, 1))
    return middle + (right - left) ** 2 / (8.0 * max(2.0 * middle - left - right, 1e-300))


def peak_in_time(scene: Scene, machine: Machine, response: TransientResponse) -> tuple[float, dict[str, float]]:
    """Greatest size of a response of the built machine [SI], and when [s] after the beginning of its excitation.

    In a run-up at which speed [rad/s].
    """
    names = names_for(scene, response)
    if scene.excitations[names[0]].ramp is not None:
        from vibopt.excitations.run_up import RATE, at_rate
        from vibopt.verify.every_cycle import Followed

        excitation = at_rate(scene.excitations[names[0]], machine.rates.get(RATE.format(names[0])))
        value, speed = Followed(machine, excitation).peak(response)
        return value, {names[0]: speed}
    known: dict[tuple[str, ...], Simulated] = vars(machine).setdefault("simulated", {})
    if names not in known:
        known[names] = Simulated(machine, tuple(_once(scene.excitations[name]) for name in names))
    value, time = known[names].peak(response)
    return value, {names[0]: time} if len(names) == 1 and np.isfinite(time) else {}


def _once(excitation: Excitation) -> Once:
    assert excitation.once is not None
    return excitation.once


__all__ = ["Simulated", "peak_in_time"]
