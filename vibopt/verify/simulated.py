"""Greatest response in time of the machine as built, looked for in its motion.

Behind the load it goes on until the motion has faded, or over a thousand periods of what is next to undamped; under
sines that last until only these are left, which are then steady, and what nothing damps.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from vibopt.excitations.excitation import Excitation, Once
from vibopt.mechanics.built import Course, joined
from vibopt.mechanics.combine import whole_orders
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.rotating import RotatingMachine
from vibopt.records import cached_property, dataclass
from vibopt.responses import TransientResponse
from vibopt.scene.drives import names_for
from vibopt.scene.scene import Scene
from vibopt.verify.motion_in_time import GONE, INSIDE, MET, NONE, PERIODS, TOGETHER, MotionInTime, Steps
from vibopt.work import worked

_SAMPLES, _BEST, _NEAR = 24, 6, 0.9
"""Samples in the shortest period; greatest ones that are looked at more closely; part of the greatest from which an end
of a stretch, or what rings on, is looked at, too."""
_LEVEL, _LEVELS, _LOWER = 2e-4, 200, 1e-2
"""Part of the greatest top by which others may be lower and still be it, how many are looked at closely, and part by
which no top rises from its samples."""
_ZOOMS, _ACROSS, _MANY = 5, 33, (50_000, 500_000)
"""Closer looks at each of them, and points of one; most samples of a stretch, without and beside what lasts."""
_BETWEEN = np.linspace(0.0, 1.0, _ACROSS)
_HORIZON, _LONGEST = 1000.0, 4e5
"""Periods of the slowest mode that are followed in all, and turns of the fastest over which modes told apart are."""
_SOON = 1e-12
"""Part of the time in which anything changes, by which signals are read inside a stretch."""
_ALONE, _SAMPLE = 2.0, 0.004
"""Work of looking for a peak, and of each time that is looked at [nominal ms]."""
_SHORT, _FEWEST = 0.1, 1000
"""Part of a stretch in which all fades that is fast, and the fewest samples behind that."""
_EVEN = 1e-9
"""Part by which a later peak must be greater to be told."""
_SLOW, _AWAY, _BY_STEPS = 1e-8, 1e-6, (1e-3, 1e-4)
"""Rate at which a drift is looked for, per look; part of a reading by which it must grow in one to count; rates under a
value that stays."""
_FINE = 400
"""Samples of a turn of what is steady."""
_ROUNDING = 3e-14
"""Part of the fastest rate by which rounding may be off in one whose shapes are at right angles to all others."""
_NOTHING, _SEEN = 1e-13, 1e-6
"""Part of what motions as great could show that is their rounding, and that is none at the first look."""
_DEFECTIVE, _CHUNK, _FADED = 1e8, 20_000, 1e-3
"""Condition beyond which modes are no use; samples at once; part to which modes fade before nothing more is seen."""


@dataclass(frozen=True)
class Simulated(MotionInTime):
    """The greatest of a response in the motion of a built machine; not `closely`, by parabolas through its samples."""

    closely: bool = True

    def peak(self, response: TransientResponse) -> tuple[float, float]:
        """Greatest size of a response, and when [s]."""
        best, loaded, seen = (0.0, 0.0), self._behind, self._at_first(response) if self.closely else 0.0
        if seen is None:
            return 0.0, float("inf")
        ended = replace(self, excitations=self._over) if self._lasting else self
        if self._driven_at_resonance or ended._runs_away(response):
            return float("inf"), float("inf")
        for number in range(len(self._spans)):
            found, before = self._greatest(number, response, max(best[0], seen)), best
            best = found if found[0] > best[0] * (1.0 + _EVEN) else best
            if (
                not self._lasting
                and not self._held.any()
                and np.isfinite(self._slowest)
                and number >= loaded
                and (found[0] < 0.5 * before[0] or (number > loaded and self.machine.n_free == 1))
            ):
                return best  # of one body every later turn is no greater
        if self._lasting:
            best, steady = self._beating(best, response), self._steady(response)
            return (steady, float("inf")) if steady > best[0] * (1.0 + _EVEN) else best
        return self._ringing(best, response, (self._behind, len(self._spans) - 1), self._states.matrices[0])

    def _steady(self, response: TransientResponse) -> float:
        """Greatest of a response to what goes on for ever, when all else has faded."""
        speeds, waves = self._driven(response)
        for turns, wave in self._undamped(response):
            same = next((i for i, speed in enumerate(speeds) if abs(speed - turns) <= NONE * 10.0 * turns), None)
            if same is not None:
                waves[same] += wave
            else:
                waves, speeds = [*waves, wave], [*speeds, turns]
        sizes = np.abs(waves)
        felt = [i for i, size in enumerate(sizes) if size > MET * sizes.max()] or [0]
        waves, speeds = [waves[i] for i in felt], [speeds[i] for i in felt]
        orders = whole_orders(tuple(speed / min(speeds) for speed in speeds))
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
            acts = {place: size * part for place, part in one.acts.items()}
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
        waves = waves * np.exp(-1j * rates.imag * self._spans[self._behind][0])
        return [(float(rate.imag), complex(wave)) for rate, wave in zip(rates[rings], waves[rings], strict=True)]

    @staticmethod
    def _no_decay(rates: ComplexArray) -> FloatArray:
        return np.asarray(np.maximum(NONE * np.abs(rates), 1e-15 * np.abs(rates).max()))

    def _beating(self, best: tuple[float, float], response: TransientResponse) -> tuple[float, float]:
        """The greater of the best so far and of what fades slowly beside what lasts, turn by turn."""
        rates, free = self._free(response)
        falls = -rates.real[-rates.real > self._no_decay(rates)] if len(rates) else rates.real
        if not len(falls):
            return best
        speeds, driven = self._driven(response)
        low, lasts = self._spans[self._behind][0], 1j * np.array(speeds)
        every, waves = np.concatenate([lasts, rates]), np.concatenate([driven * np.exp(lasts * low), free])
        begin, step = self._spans[-1][1] - low, 2.0 * np.pi / (_SAMPLES * float(np.abs(every.imag).max()))
        end = min(begin - math.log(GONE) / float(falls.min()), _LONGEST * step * _SAMPLES)

        def value(times: FloatArray) -> FloatArray:
            return np.asarray(np.abs(np.imag(waves @ np.exp(every[:, None] * times))))

        while begin < end and float((np.abs(waves) * np.exp(every.real * begin)).sum()) > best[0] * (1.0 + _EVEN):
            times = np.asarray(begin + step * np.arange(_CHUNK), dtype=float)
            best = _risen(best, value, times, low)
            begin = float(times[-2])
        return best

    def _free(self, response: TransientResponse) -> tuple[ComplexArray, ComplexArray]:
        """Rates of free motions beside what lasts, one of each pair, and the wave of each at the first look.

        A place to which dampers alone let it creep is one, of a rate of zero.
        """
        from scipy.linalg import eig

        system, loads = self._states.matrices
        low = self._spans[self._behind][0]
        free = np.asarray(self._run(self._behind)(low), dtype=float)
        for excitation, load in zip(self.excitations, loads.T, strict=True):
            if excitation.endless:
                speed, size = (
                    2.0 * np.pi / excitation.length,
                    float(excitation.signal(np.array([0.25 * excitation.length]))[0]),
                )
                follows = np.linalg.solve(1j * speed * np.eye(len(system)) - system, load * size)
                free = free - np.imag(follows * np.exp(1j * speed * low))
        known: Any = eig(system, left=True, right=True)
        rates, left, shapes = known
        once = rates.imag >= 0.0
        if np.isfinite(self._slowest):
            once &= np.abs(rates) > NONE * np.abs(rates).max()
        rates, left, shapes = rates[once], left[:, once].conj().T, shapes[:, once]
        if not len(rates) or np.linalg.cond(left @ shapes) > _DEFECTIVE:
            return np.zeros(0, dtype=complex), np.zeros(0, dtype=complex)
        states = shapes * np.linalg.solve(left @ shapes, left @ free) * np.where(rates.imag > 0.0, 2.0, 1.0)
        return rates, 1j * self._read(response, states)[1]

    def _read(self, response: TransientResponse, states: ComplexArray) -> tuple[float, ComplexArray]:
        """What is read of a machine at rest, and beside that of waves of its states (2 n, n_waves), real parts."""
        every = np.hstack([np.zeros((len(states), 1)), states.real, states.imag])
        quiet = np.full(every.shape[1], 2.0 * self._spans[-1][1])
        still, *read = (response.trace(self.machine, self._course(quiet, every)) * np.ones(len(quiet))).tolist()
        real, imaginary = np.reshape(read, (2, -1)) - still
        return still, np.asarray(real + 1j * imaginary)

    @cached_property
    def _held(self) -> FloatArray:
        """What signals that stay for ever add to the rates of the states, (2 n,)."""
        sizes = [excitation.signal(np.ones(1))[0] if excitation.holds else 0.0 for excitation in self.excitations]
        return np.asarray(self._states.matrices[1] @ np.array(sizes, dtype=float))

    @property
    def _over(self) -> tuple[Once, ...]:
        """Excitations that end."""
        return tuple(excitation for excitation in self.excitations if not excitation.endless)

    @property
    def _driven_at_resonance(self) -> bool:
        """Whether what goes on for ever meets a vibration that nothing damps."""
        poles = self.machine.poles() if self._lasting else np.zeros(0)
        return any((np.abs(poles * one.length / (2.0 * np.pi) - 1.0) < MET).any() for one in self._lasting)

    def _runs_away(self, response: TransientResponse) -> bool:
        """Whether a reading grows without end behind the load: s^2 / (s - A) of the state is what drifts, as s -> 0.

        Under a value that stays, what is held falls with s, and what drifts does not.
        """
        if not self.excitations:
            return False
        if self._held.any():
            _, near = self._drifting(response, _BY_STEPS[0] / self._look)
            _, rate = self._drifting(response, _BY_STEPS[1] / self._look)
            if rate <= 0.5 * near:
                return False
        else:
            cancelled, rate = self._drifting(response, _SLOW / self._look)
            _, near = self._drifting(response, 10.0 * _SLOW / self._look)
            if rate <= _AWAY * cancelled or rate <= 0.5 * near:  # it creeps to an end
                return False
        most = max(self._greatest(number, response)[0] for number in range(self._behind + 1))
        return bool(rate * self._look > _AWAY * most)

    def _drifting(self, response: TransientResponse, s: float) -> tuple[float, float]:
        """What is read of the bodies' own drift at a rate s [1/s], and of all."""
        system, count = self._states.matrices[0], len(self._places)
        state = np.asarray(self._run(self._behind)(self._spans[self._behind][0]), dtype=float) + self._held / s
        drift = s**2 * np.linalg.solve(s * np.eye(2 * count) - system, state)
        if not self._held.any():  # else what is pushed goes faster and faster
            drift[count:] = 0.0
        alone = np.where(np.arange(2 * count) % count < self.machine.n_free, drift, 0.0)
        own, every = np.abs(self._read(response, np.array([alone, drift], dtype=complex).T)[1].real).tolist()
        return own, every

    @cached_property
    def _seen(self) -> dict[tuple[int, int], tuple[TransientResponse, tuple[float, float]]]:
        """What was greatest on stretches so far, by their numbers and that of the response, which stays."""
        return {}

    def _greatest(self, number: int, response: TransientResponse, before: float = 0.0) -> tuple[float, float]:
        """Greatest size on a stretch, and when; of one that stays below what was `before` that of its samples."""
        key = number, id(response)
        if key not in self._seen:
            self._seen[key] = response, self._measured(number, response, before)
        return self._seen[key][1]

    def _inside(self, number: int) -> tuple[float, float]:
        """The first and the last time at which a stretch is read: at its ends signals may jump."""
        low, high = self._spans[number]
        edge = max(min(INSIDE * (high - low), _SOON / self._fastest(number)), 8.0 * np.finfo(float).eps * high)
        return low + edge, high - edge

    def _sampled(self, number: int) -> tuple[FloatArray, Course]:
        """Times on a stretch, some in the shortest period, and the motion there; of few times it is kept."""
        if number in self._courses:
            return self._courses[number]
        low, high = self._spans[number]
        count = int(
            np.clip(
                _SAMPLES * self._fastest(number) * (high - low) / (2.0 * np.pi), _SAMPLES, _MANY[bool(self._lasting)]
            )
        )
        run, many = self._run(number), TOGETHER // len(self._places)
        if isinstance(run, Steps) and len(run.times) > _CHUNK:  # a step is no longer than what lies between samples
            told = self._telling(number, run.times)
            times = np.append(run.times[told], high)
            states = np.hstack([run.states[told].T, run(self._inside(number)[1:])])
            return times, self._course(np.clip(times, *self._inside(number)), states)
        bent = self._bent[np.searchsorted(self._bent, low, "right") : np.searchsorted(self._bent, high)]
        times = np.union1d(np.linspace(low, high, count), np.append(bent, self._turned(number)))
        at = np.clip(times, *self._inside(number))
        found = times, joined([self._course(one, run(one)) for one in np.split(at, range(many, len(at), many))])
        if len(times) <= _CHUNK:
            self._courses[number] = found
        return found

    def _telling(self, number: int, times: FloatArray) -> BoolArray:
        """Which of many even steps are looked at: behind the load few of them once what is fastest has faded."""
        low, high = self._spans[number]
        poles = self.machine.poles()
        fades = -math.log(GONE) / np.maximum(poles.imag, 1e-300)  # [s]
        brief = fades < _SHORT * (high - low)
        if not self._quiet_from(low) or not brief.any():
            return np.ones(len(times), dtype=bool)
        rate = max([float(np.abs(poles[~brief]).max(initial=0.0)), *(one.fastest for one in self._lasting)])
        apart = max(int(2.0 * np.pi * (len(times) - 1) / (_SAMPLES * rate * (high - low) + 1e-300)), 1)
        apart = min(apart, len(times) // _FEWEST)
        return np.asarray((np.arange(len(times)) % apart == 0) | (times - low < fades[brief].max()))

    def _turned(self, number: int) -> FloatArray:
        """Times on a stretch just before the motion turns into another one: none where nothing rubs."""
        return np.zeros(0)

    @cached_property
    def _courses(self) -> dict[int, tuple[FloatArray, Course]]:
        """Motion at the samples of stretches, by their numbers."""
        return {}

    def _at_first(self, response: TransientResponse) -> float | None:
        """A size that is reached; None where all is the rounding of motions that are not seen, as in what is symmetric.

        A reading is no greater than the norm of its row times that of the motion, both over roots of masses.
        """
        count, bodies = len(self._places), self.machine.n_free
        heavy = np.diag(self.machine.parts_in_time()[0])[:bodies]
        weights = np.sqrt(np.where(heavy > 0.0, heavy, 1.0))
        rows = np.abs(self._read(response, np.eye(2 * count, dtype=complex))[1].real)
        kinds = np.arange(bodies), count + np.arange(bodies)  # places and velocities are no sum
        most, best = np.zeros(2 * count), 0.0
        few = [np.linspace(*self._inside(number), _CHUNK // 100) for number in range(self._behind + 1)]
        for closely in (False, True):
            for number, at in enumerate(few):
                states = self._run(number)(at)
                course = self._sampled(number)[1] if closely else self._course(at, states)
                best = max(best, float(np.abs(response.trace(self.machine, course)).max()))
                most = np.maximum(most, np.abs(states).max(axis=1))
            every = sum(np.linalg.norm(rows[one] / weights) * np.linalg.norm(most[one] * weights) for one in kinds)
            if best > (_NOTHING if closely else _SEEN) * float(every):
                return best
            few = [one[:: 1 + len(one) // _CHUNK] for one in (self._sampled(k)[0] for k in range(len(few)))]
            few = [np.clip(one, *self._inside(number)) for number, one in enumerate(few)]
        return None

    def _measured(self, number: int, response: TransientResponse, before: float) -> tuple[float, float]:
        run, (times, course) = self._run(number), self._sampled(number)
        low, high = self._inside(number)

        def value(time: FloatArray) -> FloatArray:
            at = np.clip(time, low, high)
            return np.abs(response.trace(self.machine, self._course(at, run(at)))) * np.ones(len(at))

        worked(_ALONE + _SAMPLE * len(times))
        values, count = np.abs(response.trace(self.machine, course)) * np.ones(len(times)), len(times)
        there, heights = _heights(values)
        rough = _first(np.append(heights, values), np.append(times[there], times))
        if not self.closely or (rough[0] < before * (1.0 - _LOWER) and count <= _CHUNK):
            return rough
        tops = np.flatnonzero((values[1:-1] >= values[:-2]) & (values[1:-1] >= values[2:])) + 1
        ends = [0, *np.searchsorted(times, self._turned(number)), count - 1]  # a top may hide beside each of them
        edges = [i for i in ends if values[i] > _NEAR * values.max()]
        near = np.unique([*tops[np.argsort(-values[tops])[:_BEST]], *_even_tops(values), *edges]).astype(int)
        sizes, at = closer(value, times[np.maximum(near - 1, 0)], times[np.minimum(near + 1, count - 1)])
        seen = [0, int(values.argmax()), count - 1]
        return _first(np.append(sizes, values[seen]), np.append(at, times[seen]))

    def _ringing(
        self, best: tuple[float, float], response: TransientResponse, looks: tuple[int, int], system: FloatArray
    ) -> tuple[float, float]:
        """The greater of the best so far and of what rings on behind the last of some looks, by modes of a system.

        What swings does so about what stays: what has drifted and where a value that stays holds the machine.
        """
        low, begin = self._spans[looks[0]][0], self._spans[looks[1]][1] - self._spans[looks[0]][0]
        rates, left, shapes = _told_from_rest(system)
        if not len(rates) or np.linalg.cond(left @ shapes) > _DEFECTIVE:
            return best
        state: FloatArray = np.asarray(self._run(looks[0])(low), dtype=float)
        shares = np.linalg.solve(left @ shapes, left @ state + (left @ self._held) / rates)
        rest, quiet = (state - (shapes @ shares).real)[:, None], np.array([2.0 * self._spans[-1][1]])
        still = float(np.ravel(response.trace(self.machine, self._course(quiet, rest)))[0])
        once = rates.imag >= 0.0  # of each pair the real part twice
        waves = self._read(response, (shapes * shares * np.where(rates.imag > 0.0, 2.0, 1.0))[:, once])[1]
        rates = rates[once]
        if self._held.any() and abs(still) > best[0] * (1.0 + _EVEN):
            best = abs(still), math.inf
        seen, end = begin, self._look / PERIODS * _HORIZON
        step = 2.0 * np.pi / (_SAMPLES * max(float(np.abs(rates.imag).max()), 1e-300))

        def value(times: FloatArray) -> FloatArray:
            return np.asarray(np.abs(still + np.real(waves @ np.exp(rates[:, None] * times))))

        while begin < end and abs(still) + float(np.abs(waves) @ np.exp(rates.real * begin)) > best[0] * (1.0 + _EVEN):
            times = begin + step * np.arange(-1.0, min(_CHUNK, int((end - begin) / step) + 2))  # a top may lie across
            best = _risen(best, value, np.asarray(times[times >= 0.0]), low)
            begin = float(times[-1])
            faded = np.abs(np.exp(rates.real * begin)).max(where=np.abs(rates.imag) > 0.0, initial=0.0)
            if faded < _FADED * np.abs(np.exp(rates.real * seen)).max():
                break
        creeps = -rates.real[(rates.imag == 0.0) & (rates.real < 0.0)]
        long = -math.log(GONE) / float(creeps.min(initial=np.inf))
        return best if long <= seen else _risen(best, value, np.geomspace(seen, long, _CHUNK // 20), low)


def _told_from_rest(system: FloatArray) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Rates, left and right shapes of the modes of states (2 n, 2 n) whose rates rounding tells from none.

    Two rates of nothing, as of what drifts, are off by the root of rounding, and their shapes are nearly one.
    """
    from scipy.linalg import eig, eigvals

    fastest = float(np.abs(eigvals(system)).max(initial=0.0)) or 1.0
    scale = np.repeat([1.0, fastest], len(system) // 2)  # velocities as places
    known: Any = eig(system * scale / scale[:, None], left=True, right=True)
    rates, left, shapes = known
    apart = np.abs((left.conj() * shapes).sum(axis=0))
    told = np.abs(rates) * apart > _ROUNDING * fastest
    return rates[told], (left[:, told].conj() / scale[:, None]).T, shapes[:, told] * scale[:, None]


Values = Callable[[FloatArray], FloatArray]
"""Sizes at times [s], each (n,)."""


def closer(value: Values, left: FloatArray, right: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Greatest sizes between times (n,), and when: closer looks between the neighbours of the best that may rise."""
    sizes, times, rows = np.zeros(len(left)), left.copy(), np.arange(len(left))
    for _ in range(_ZOOMS if len(left) else 0):
        across = left[:, None] + (right - left)[:, None] * _BETWEEN
        seen = value(across.ravel()).reshape(across.shape)
        own, at = np.arange(len(rows)), seen.argmax(axis=1)
        high, better = seen[own, at], seen[own, at] > sizes[rows]
        sizes[rows[better]], times[rows[better]] = high[better], across[own, at][better]
        left, right = across[own, np.maximum(at - 1, 0)], across[own, np.minimum(at + 1, _ACROSS - 1)]
        hopeful = high >= (1.0 - _LOWER) * high.max()
        rows, left, right = rows[hopeful], left[hopeful], right[hopeful]
    return sizes, times


def _first(sizes: FloatArray, times: FloatArray) -> tuple[float, float]:
    """The greatest size, and the first time at which it is as great but for rounding."""
    most = float(sizes.max())
    return most, float(times[sizes >= most * (1.0 - _EVEN)].min())


def _risen(best: tuple[float, float], value: Values, times: FloatArray, low: float) -> tuple[float, float]:
    """The greater of the best so far and of what lies between even times behind `low` [s]."""
    at, high = _heights(value(times))
    hopeful = high > best[0] * (1.0 - _LEVEL)
    at = at[hopeful][np.argsort(-high[hopeful])[:_LEVELS]]
    if not len(at):
        return best
    size, time = _first(*closer(value, times[at - 1], times[at + 1]))
    return (size, low + time) if size > best[0] * (1.0 + _EVEN) else best


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


def peak_in_time(
    scene: Scene, machine: Machine, response: TransientResponse, followed: type[Simulated] = Simulated
) -> tuple[float, dict[str, float]]:
    """Greatest size of a response of the built machine [SI], and when [s] after the beginning of its excitation.

    In a run-up at which speed [rad/s].
    """
    names = names_for(scene, response)
    if scene.excitations[names[0]].ramp is not None:
        from vibopt.excitations.run_up import RATE, at_rate
        from vibopt.verify.every_cycle import Followed
        from vibopt.verify.spun_up import SpunUp

        excitation = at_rate(scene.excitations[names[0]], machine.rates.get(RATE.format(names[0])))
        risen: dict[tuple[str, ...], Followed | SpunUp] = vars(machine).setdefault("risen", {})
        if names not in risen:
            risen[names] = (
                SpunUp(machine, excitation) if isinstance(machine, RotatingMachine) else Followed(machine, excitation)
            )
        value, speed = risen[names].peak(response)
        return value, {names[0]: speed}
    known: dict[tuple[str, ...], Simulated] = vars(machine).setdefault("simulated", {})
    if names not in known:
        once = tuple(_once(scene.excitations[name]) for name in names)
        known[names] = followed(machine, once)
    value, time = known[names].peak(response)
    return value, {names[0]: time} if np.isfinite(time) else {}


def _once(excitation: Excitation) -> Once:
    assert excitation.once is not None
    return excitation.once
