"""Motion in time of the machine as built, stretch by stretch, by Duhamel's integral over even steps.

The other road to a motion: bodies and joints with their positions and velocities, and the signals as functions of time;
no segment and no mode.  Steps end where a signal bends, as a record does at its samples; what would take too many of
them goes by an implicit Runge-Kutta method, and a load that is slow beside all that fades as polynomials.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from itertools import pairwise
from typing import Any, ClassVar, NamedTuple

import numpy as np

from vibopt.arrays import FloatArray, IntArray
from vibopt.excitations.excitation import Once
from vibopt.mechanics.built import Course
from vibopt.mechanics.machine import Machine
from vibopt.records import dataclass
from vibopt.verify.states import States

PERIODS, _LOOKS, _BESIDE = 3.0, 6, 200.0
"""Periods of the slowest mode in a look behind the load, how many looks there are, and periods in all beside what lasts
before modes are told apart."""
MET, NONE, GONE = 1e-9, 1e-12, 1e-12
"""Parts: of a speed by which it misses a pole, of a frequency that is no decay, and to which all fades."""
INSIDE = 1e-9
"""Part of a stretch by which signals are read inside: ends may be jumps."""
_IMPLICIT, _ABSOLUTE, _ROUGH = 1e-9, 1e-13, 1e-4
_STIFF, _FAR = 2e5, 1e3
"""Fastest rate times the time to go beyond which an implicit method is used, and beyond which places are counted from a
base that is gone so far that little is left of their digits."""
TURN, TAYLOR, _DEFECTIVE = 0.25, 14, 1e9
"""How far what is fastest turns in a step, terms of a series, and condition of modes that are one."""
PLACES, WEIGHTS = (0.5 * one for one in np.polynomial.legendre.leggauss(8))
_SHARES = np.array([1.0 / math.factorial(k) for k in range(TAYLOR)])[:, None, None]
_MOMENTS = np.array([WEIGHTS * (0.5 - PLACES) ** k / math.factorial(k) for k in range(TAYLOR)])
_KEPT, TOGETHER, _EVEN = 30_000_000, 1_000_000, 1e-12
"""Numbers of all states in all steps at most, and at once; part of a step by which even ones may differ."""
_PARTS = np.array([0.2, 0.43, 0.71])
"""Of a stretch, places at which no signal that acts on it is zero at once."""
_DEGREE, _RESOLVED, _AGAIN = 32, 1e-13, 40
"""Of polynomials through a slow load, what they may leave over, and how often its motion is made better at most."""


class Steps(NamedTuple):
    """A stretch that was gone through in steps: their times [s], the states then (n_steps, 2 n), and at any."""

    times: FloatArray
    states: FloatArray
    run: Callable[[Any], FloatArray]

    def __call__(self, at: Any) -> FloatArray:
        return self.run(at)


@dataclass(frozen=True)
class MotionInTime:
    """A built machine, and what comes over it once; simulated as far as it is asked for."""

    machine: Machine
    excitations: tuple[Once, ...]
    looks: ClassVar[int] = _LOOKS

    @cached_property
    def _lasting(self) -> tuple[Once, ...]:
        """Excitations that vibrate for ever."""
        return tuple(excitation for excitation in self.excitations if excitation.endless and not excitation.holds)

    @cached_property
    def _slowest(self) -> float:
        """Least natural frequency above zero [rad/s]; inf where there is no spring."""
        modes = self.machine.natural_frequencies()
        return float(modes[modes > 1e-9 * modes.max(initial=0.0)].min(initial=np.inf))

    @cached_property
    def _look(self) -> float:
        """How long a look behind the load is [s]: some periods of the slowest mode, or a part of all that fades."""
        slow, turn = self._slowest, max((one.length for one in self._lasting), default=0.0)
        poles = self.machine.poles()
        held = poles[np.argsort(np.abs(poles))[self.machine.loose :]]  # of rigid motion rounding is no decay
        fades = np.abs(held[np.abs(held.real) <= NONE * np.abs(held.imag)].imag)
        creeps = fades[fades > NONE * np.abs(poles).max(initial=0.0)]
        long = -math.log(GONE) / float(creeps.min(initial=np.inf))
        if not np.isfinite(slow):  # no spring: all creeps to where it stays
            if len(creeps):
                return (min(long, _BESIDE * turn) if turn else long) / _LOOKS + turn
            return max(excitation.length for excitation in self.excitations) or 1.0
        if self._lasting:
            decays = np.abs(poles.imag)
            moving, rings = decays[decays > NONE * slow], (decays <= NONE * slow) & (np.abs(poles) > MET * slow)
            faded = -np.log(GONE) / float(moving.min()) if len(moving) else PERIODS * 2.0 * np.pi / slow
            faded = faded if len(moving) + rings.sum() == len(decays) else np.inf
            return min(faded, _BESIDE * 2.0 * np.pi / slow) / _LOOKS + turn
        settles = long / _LOOKS if any(excitation.holds for excitation in self.excitations) else 0.0
        return max(PERIODS * 2.0 * np.pi / slow, settles)

    @cached_property
    def _spans(self) -> list[tuple[float, float]]:
        """Stretches of time without joints, those behind the load last [s]."""
        look, joints = self._look, sorted({*self._joints, *self._late})
        return [*pairwise(joints), *((joints[-1] + i * look, joints[-1] + (i + 1) * look) for i in range(self.looks))]

    @property
    def _behind(self) -> int:
        """Number of the first stretch behind the load."""
        return len(self._spans) - self.looks

    @cached_property
    def _runs(self) -> list[Any]:
        """Stretches simulated so far, each as a function of time."""
        return []

    @cached_property
    def _fades(self) -> float:
        """How long it takes until all that vibrates freely is rounding [s]."""
        return -math.log(GONE) / max(float(np.abs(self.machine.poles().imag).min(initial=np.inf)), 1e-300)

    @cached_property
    def _joints(self) -> list[float]:
        return sorted({joint for excitation in self.excitations for joint in excitation.joints})

    @cached_property
    def _bent(self) -> FloatArray:
        """Times at which signals jump or bend, ascending [s]."""
        return np.unique(np.concatenate([excitation.kinks for excitation in self.excitations]))

    @cached_property
    def _late(self) -> set[float]:
        """Times from which on a smooth load alone counts [s]: all fades early in stretches that are so long."""
        long = max(_STIFF / max(self._own_rate, 1e-300), 2.0 * self._fades)
        pairs = pairwise(self._joints) if self._step == np.inf else ()
        return {low + self._fades for low, high in pairs if high - low > long}

    @cached_property
    def _states(self) -> States:
        acts, bases = tuple(excitation.acts for excitation in self.excitations), self.machine.bases
        far = [
            excitation
            for excitation in self.excitations
            if excitation.on in bases and not excitation.returns and (excitation.holds or not excitation.endless)
        ]
        ends = {end for joint in self.machine.joints for end in joint.ends}
        alone = (
            len(bases) == 1
            and not self.machine.in_space
            and bool(far)
            and not self._lasting
            and ends <= {*self.machine.masses, *bases}
        )
        held = _LOOKS * self._look if any(excitation.holds for excitation in self.excitations) else 0.0
        long = max([held, *(excitation.length for excitation in self.excitations)]) * self._own_rate > _FAR
        return States(self.machine, acts, next(iter(bases)) if alone and long else "")

    @property
    def _places(self) -> list[str]:
        """Coordinates of bodies, and those of bases behind them."""
        return self._states.places

    def _fastest(self, number: int, *, unbent: bool = False) -> float:
        """Fastest rate on a stretch [1/s]: of the machine, and of the signals that are not over.

        `unbent` leaves out what goes straight from bend to bend, as a record does.  Between two pulses nothing acts.
        """
        begin, end = self._spans[number]
        inside = begin + (end - begin) * _PARTS
        acting = (
            one for one in self.excitations
            if one in self._lasting or (one.joints[-1] > begin and (one.straight or one.signal(inside).any()))
        )  # fmt: skip
        return max([self._own_rate, *(one.fastest for one in acting if not (unbent and one.straight))])

    @cached_property
    def _own_rate(self) -> float:
        return float(np.abs(self.machine.poles()).max(initial=0.0))

    def _loaded(self, number: int) -> bool:
        return number < self._behind

    def _signals(self, time: FloatArray) -> FloatArray:
        return np.array([excitation.signal(time) for excitation in self.excitations])

    def _start(self, number: int) -> FloatArray:
        """Positions and velocities of bodies and bases at the beginning of a stretch, as blows have left them."""
        time = self._spans[number][0]
        struck: FloatArray = self._states.matrices[1] @ np.array(
            [excitation.blows.get(time, 0.0) for excitation in self.excitations]
        )
        pushed = self._states.pushed.T
        if number == 0:
            begun = [_moved(self.machine.begins(one.acts), one.start) for one in self.excitations if any(one.start)]
            return np.asarray(np.sum([struck, *begun], axis=0))
        found: FloatArray = np.asarray(self._runs[-1](time), dtype=float) + struck
        if number == self._behind:  # back to the last digit, or rounding would carry it away
            bodies, count = self.machine.n_free, len(self._places)
            leaves = [not one.returns for one in self.excitations]
            back = np.tile((np.arange(count) >= bodies) & ~pushed[leaves].any(axis=0), 2)
            came = [_moved(row, one.course(time)) for row, one in zip(pushed, self.excitations, strict=True)]
            found[back] = np.sum(came, axis=0)[back]
        return found

    @property
    def _step(self) -> float:
        """Longest step while a load acts: not over a sample of a record [s]."""
        return min(excitation.step for excitation in self.excitations)

    def _unbent(self, low: float, high: float) -> FloatArray:
        """Beginning and end of a stretch, and between them where signals bend, as a record does at its samples [s]."""
        inside = slice(np.searchsorted(self._bent, low, "right"), np.searchsorted(self._bent, high))
        return np.concatenate([[low], self._bent[inside], [high]])

    def _rates(self, low: float, high: float) -> Callable[[float, FloatArray], FloatArray]:
        """Rates of the states on a stretch of time."""
        edge, (system, loads) = INSIDE * (high - low), self._states.matrices

        def rates(time: float, now: FloatArray) -> FloatArray:
            signals = self._signals(np.array([min(max(time, low + edge), high - edge)]))[:, 0]
            found: FloatArray = system @ now + loads @ signals
            return found

        return rates

    def _run(self, number: int) -> Any:
        """States against time on a stretch, (2 n, n_times)."""
        while len(self._runs) <= number:
            current = len(self._runs)
            low, high = self._spans[current]
            start = self._start(current)
            if low in self._late:
                settled = self._settled(low, high, start)
                if settled is not None:
                    self._runs.append(settled)
                    continue
            fastest, ends = self._fastest(current, unbent=True), self._unbent(low, high)
            turned, parts = fastest * (high - low), (fastest * np.diff(ends) / TURN).astype(int) + 1
            quiet, few = self._quiet_from(low), parts.sum() * len(start) <= _KEPT
            many = turned > _STIFF or not few
            stays = self._stays(low, start) if quiet and many else None
            if stays is not None:
                self._runs.append(stays)
                continue
            if few or turned <= _STIFF:
                self._runs.append(self._stepped(ends, parts, start))
                continue
            from scipy import integrate

            rates = self._rates(low, high)
            rough: Any = integrate.solve_ivp(
                rates,
                (low, high),
                start,
                method="Radau",
                rtol=_ROUGH,
                atol=_ROUGH**2 * (np.abs(start).max() or 1e-6),
            )
            size = np.abs(rough.y).reshape(2, -1).max(axis=1).repeat(len(start) // 2)
            exact: Any = integrate.solve_ivp(
                rates, (low, high), start, method="Radau", rtol=_IMPLICIT,
                atol=_ABSOLUTE * np.where(size > 0.0, size, 1.0), dense_output=True,
                max_step=self._step if self._loaded(current) else np.inf,
            )  # fmt: skip
            self._runs.append(exact.sol)
        return self._runs[number]

    def _stepped(self, ends: FloatArray, parts: IntArray, start: FloatArray) -> Any:
        """States against time on a long stretch, by Duhamel's integral in steps, each by Gauss's rule.

        From each of `ends` [s] to the next one goes straight on in as many even steps as `parts` says.
        """
        (system, loads), (low, high) = self._states.matrices, ends[[0, -1]]
        which, edge, places = np.repeat(np.arange(len(parts)), parts), INSIDE * (high - low), (0.5 + PLACES)[:, None]
        length = (np.diff(ends) / parts)[which]
        times = ends[which] + (np.arange(len(which)) - (np.cumsum(parts) - parts)[which]) * length
        acted = not self._quiet_from(low) or any(one.endless for one in self.excitations)

        def signals(begin: FloatArray, length: Any) -> FloatArray:
            """At the places of Gauss's rule in steps from times on, (n_signals, n_places, n_times)."""
            seen = np.clip(begin + places * length, low + edge, high - edge)
            return self._signals(seen.ravel()).reshape(loads.shape[1], *seen.shape)

        def onward(states: FloatArray, begin: FloatArray, length: FloatArray) -> FloatArray:
            """States (N, n) so much later than times, (n,) each: one series of what they and the signals come to."""
            terms = _SHARES * states
            if acted:
                terms = terms + loads @ (length * (_MOMENTS @ signals(begin, length)).swapaxes(0, 1))
            found: FloatArray = terms[-1]
            for term in terms[-2::-1]:
                found = system @ found
                found *= length
                found += term
            return found

        many = TOGETHER // (len(start) * len(places))
        pieces = [slice(k, k + many) for k in range(0, len(times), many)]
        if np.ptp(length) <= _EVEN * length[0]:
            step, count = float(length[0]), loads.shape[1]
            left = carried(system, np.repeat(loads, len(places), axis=1), np.tile(step * (0.5 - PLACES), count))
            pushes = left * np.tile(step * WEIGHTS, count)
            added = [pushes @ signals(times[one], step).reshape(len(places) * count, -1) for one in pieces]
            states = even_steps(carried(system, np.eye(len(start)), step), start, np.hstack(added).T)
        else:
            none = np.zeros((len(start), 1))
            added = [onward(none, times[one], length[one]) for one in pieces]
            states = _uneven_steps(system, length, start, np.hstack(added).T)

        def run(at: Any) -> FloatArray:
            one = np.atleast_1d(np.asarray(at, dtype=float))
            j = np.maximum(np.searchsorted(times, one, "right") - 1, 0)
            found = [onward(states[j[part]].T, times[j[part]], (one - times[j])[part])
                     for part in (slice(k, k + many) for k in range(0, len(one), many))]  # fmt: skip
            return np.hstack(found) if np.ndim(at) else found[0][:, 0]

        return Steps(times, states, run)

    def _quiet_from(self, time: float) -> bool:
        """Whether from a time on there is nothing but values that stay and sines that last."""
        return all(one.endless or one.joints[-1] <= time for one in self.excitations)

    def _stays(self, low: float, start: FloatArray) -> Any:
        """States against time under signals that stay and sines that last, mode by mode; None where two are one."""
        system, loads = self._states.matrices
        count, size, turning = len(self._places), len(start), self._lasting
        whole, bases = np.zeros((size + 2 * len(turning) + 1,) * 2), count - self.machine.n_free
        whole[:size, :size] = system
        held = np.array([one.signal(np.array([low + self._look]))[0] if one.holds else 0.0 for one in self.excitations])
        whole[:size, -1] = loads @ held
        waves = list[float]()
        for one in turning:  # a sine, and the sine a quarter of a turn later
            at, rate = size + len(waves), 2.0 * np.pi / one.length
            whole[:size, at] = loads[:, self.excitations.index(one)]
            whole[at, at + 1], whole[at + 1, at] = rate, -rate
            waves += one.signal(np.array([low, low + 0.25 * one.length])).tolist()
        rests = ~np.any([*loads[count:].T, start[count:]], axis=0)
        still = np.tile(rests & (np.arange(count) >= count - bases), 2)  # bases that nothing moves
        whole[:size][still] = 0.0
        known: Any = np.linalg.eig(whole)
        if np.linalg.cond(known[1]) > _DEFECTIVE:
            return None
        shares = known[1] * np.linalg.solve(known[1], np.concatenate([start, waves, [1.0]]))

        def run(at: Any) -> FloatArray:
            later = np.atleast_1d(np.asarray(at, dtype=float)) - low
            found = np.real(shares @ np.exp(known[0][:, None] * later))[:size]
            return np.asarray(found if np.ndim(at) else found[:, 0])

        return run

    def _settled(self, low: float, high: float, start: FloatArray) -> Any:
        """States against time where all has faded but what follows a slow load; None where the load is not slow.

        x' = A x + f has the solution x = A^-1 (x' - f) again and again, on polynomials of time.
        """
        from numpy.polynomial import chebyshev

        (system, loads), bodies, count = self._states.matrices, self.machine.n_free, len(self._places)
        half, edge = 0.5 * (high - low), INSIDE * (high - low)
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

    def _course(self, time: FloatArray, states: FloatArray) -> Course:
        signals = self._signals(time)
        return Course(self.machine.points_in_time(self._states.read(states, signals)), self._forces(signals))

    def _forces(self, signals: FloatArray) -> dict[str, FloatArray]:
        """From outside on each body, in space along each direction [N], (n_times,) each."""
        forces = dict.fromkeys(self.machine.masses, np.zeros(signals.shape[1]))
        for one, signal in zip(self.excitations, signals, strict=True):
            for place, part in one.acts.items() if one.family == "bodies" else ():
                forces[place] = forces.get(place, 0.0) + part.real * signal
        return forces


def _moved(row: FloatArray, course: tuple[float, float]) -> FloatArray:
    """States (2 n,) where coordinates have a displacement and a velocity along a row (n,)."""
    return np.concatenate([course[0] * row, course[1] * row])


def carried(system: FloatArray, states: FloatArray, time: Any) -> FloatArray:
    """States (N, n) after short times (n,) of free motion, by Taylor's series."""
    found: FloatArray = states + 0.0
    term = states
    for k in range(1, TAYLOR):
        term = system @ term
        term *= time / k
        found += term
    return found


def even_steps(free: FloatArray, start: FloatArray, added: FloatArray) -> FloatArray:
    """States (n_steps, N) at the beginning of even steps, from the first on: the next is free @ state + added.

    Rows of about a root of as many steps go side by side from rest, and are then begun where the row before ended.
    """
    count, size = added.shape
    wide = math.isqrt(count - 1) + 1
    rows = np.zeros((-(-count // wide), wide, size))
    rows.reshape(-1, size)[:count] = added
    powers, came = [np.eye(size)], np.zeros((len(rows), size))
    found = np.empty(rows.shape)
    for j in range(wide):
        found[:, j] = came
        came = came @ free.T + rows[:, j]
        powers.append(free @ powers[-1])
    begun = np.empty((len(rows), size))
    for row, end in enumerate(came):
        begun[row] = start
        start = powers[-1] @ start + end
    for j in range(wide):
        found[:, j] += begun @ powers[j].T
    return found.reshape(-1, size)[:count]


def _uneven_steps(system: FloatArray, length: FloatArray, start: FloatArray, added: FloatArray) -> FloatArray:
    """States (n_steps, N) at the beginning of steps of any length (n_steps,) [s], by Taylor's series in each."""
    n, terms = len(start), [np.eye(len(start))]
    for k in range(1, TAYLOR):
        terms.append(system @ terms[-1] / k)
    series, states = np.vstack(terms), np.empty(added.shape)
    for j, powers in enumerate(length[:, None] ** np.arange(TAYLOR)):
        states[j] = start
        start = powers @ (series @ start).reshape(TAYLOR, n) + added[j]
    return states
