"""Motion in time of the machine as built, stretch by stretch, by Duhamel's integral over even steps.

The other road to a motion: bodies and joints with their positions and velocities, and the signals as functions of time;
no segment and no mode.  Records go from sample to sample, what else bends by a Runge-Kutta method of eighth order, what
is stiff by an implicit one, and a load that is slow beside all that fades as polynomials.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np

from vibopt.arrays import FloatArray
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
_RELATIVE, _IMPLICIT, _ABSOLUTE, _ROUGH = 1e-12, 1e-9, 1e-13, 1e-4
_STIFF, _FAR = 2e5, 1e3
"""Fastest rate times the time to go beyond which an implicit method is used, and beyond which places are counted from a
base that is gone so far that little is left of their digits."""
_TURN, _TAYLOR, _DEFECTIVE = 0.25, 14, 1e9
"""How far what is fastest turns in an even step, terms of a series, and condition of modes that are one."""
PLACES, WEIGHTS = (0.5 * one for one in np.polynomial.legendre.leggauss(8))
_KEPT, TOGETHER, _AT_ONCE = 30_000_000, 1_000_000, 2000
"""Numbers of all states in all steps at most, and at once; steps of a record that are looked at together."""
_DEGREE, _RESOLVED, _AGAIN = 32, 1e-13, 40
"""Of polynomials through a slow load, what they may leave over, and how often its motion is made better at most."""


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

    def _fastest(self, number: int) -> float:
        """Fastest rate on a stretch [1/s]: of the machine, and of the signals that are not over."""
        begin = self._spans[number][0]
        acting = (
            excitation
            for excitation in self.excitations
            if excitation in self._lasting or excitation.joints[-1] > begin
        )
        return max([self._own_rate, *(one.fastest for one in acting)])

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

    def _bends(self, low: float, high: float) -> bool:
        """Whether a signal bends inside a stretch, as a record does at its samples."""
        return bool(np.searchsorted(self._bent, high) > np.searchsorted(self._bent, low, "right"))

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
            if self._loaded(current) and all(excitation.straight for excitation in self.excitations):
                straight = self._straight(low, high, start)
                if straight is not None:
                    self._runs.append(straight)
                    continue
            if low in self._late:
                settled = self._settled(low, high, start)
                if settled is not None:
                    self._runs.append(settled)
                    continue
            turned = self._fastest(current) * (high - low)
            smooth = self._step == np.inf or not self._loaded(current) or not self._bends(low, high)
            steps, quiet = int(turned / _TURN) + 1, not self._loaded(current) and not self._lasting
            many = turned > _STIFF or steps * len(start) > _KEPT
            stays = self._stays(low, start) if quiet and many else None
            if stays is not None:
                self._runs.append(stays)
                continue
            if smooth and turned <= _STIFF:
                self._runs.append(self._stepped(low, high, start, steps))
                continue
            from scipy import integrate

            rates = self._rates(low, high)
            way: Any = "Radau" if self._fastest(current) * (high - low) > _STIFF else "DOP853"
            rough: Any = integrate.solve_ivp(
                rates,
                (low, high),
                start,
                method=way,
                rtol=_ROUGH,
                atol=_ROUGH**2 * (np.abs(start).max() or 1e-6),
            )
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
        (system, loads), step, edge = self._states.matrices, (high - low) / count, INSIDE * (high - low)
        times: FloatArray = low + step * np.arange(count, dtype=float)

        def onward(states: FloatArray, begin: FloatArray, length: FloatArray) -> FloatArray:
            """States (N, n) so much later than times, (n,) each: what they come to, and the signals by Gauss's rule."""
            places = (0.5 + PLACES)[:, None]
            seen = np.clip(begin + places * length, low + edge, high - edge)
            pushed = loads @ self._signals(seen.ravel()) * (WEIGHTS[:, None] * length).ravel()
            if not pushed.any():
                return carried(system, states, length)
            left = np.concatenate([length, ((1.0 - places) * length).ravel()])
            every = carried(system, np.hstack([states, pushed]), left)
            return np.asarray(every.reshape(len(states), -1, len(begin)).sum(axis=1))

        many, still = TOGETHER // len(start), np.zeros((len(start), count))
        pieces = (slice(k, k + many) for k in range(0, count, many))
        added = np.hstack([onward(still[:, one], times[one], np.full(len(times[one]), step)) for one in pieces]).T
        states, free = np.empty((count, len(start))), carried(system, np.eye(len(start)), step)
        states[0] = start
        for j in range(count - 1):
            states[j + 1] = free @ states[j] + added[j]

        def run(at: Any) -> FloatArray:
            at = np.atleast_1d(np.asarray(at, dtype=float))
            which = np.clip(((at - low) / step).astype(int), 0, count - 1)
            return onward(states[which].T, times[which], at - times[which])

        return lambda at: run(at) if np.ndim(at) else run(at)[:, 0]

    def _stays(self, low: float, start: FloatArray) -> Any:
        """States against time behind the load, under signals that stay, mode by mode; None where two are one."""
        system, loads = self._states.matrices
        whole = np.column_stack([system, loads @ self._signals(np.array([low + self._look]))[:, 0]])
        count, bases = len(self._places), len(self._places) - self.machine.n_free
        rests = ~np.any([*loads[count:].T, start[count:]], axis=0)
        still = np.tile(rests & (np.arange(count) >= count - bases), 2)  # bases that nothing moves
        whole = np.vstack([np.where(still[:, None], 0.0, whole), np.zeros(len(start) + 1)])
        known: Any = np.linalg.eig(whole)
        if np.linalg.cond(known[1]) > _DEFECTIVE:
            return None
        shares = known[1] * np.linalg.solve(known[1], np.append(start, 1.0))

        def run(at: Any) -> FloatArray:
            later = np.atleast_1d(np.asarray(at, dtype=float)) - low
            found = np.real(shares @ np.exp(known[0][:, None] * later))[:-1]
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

    def _straight(self, low: float, high: float, start: FloatArray) -> Any:
        """States against time under signals that go straight from kink to kink; None where that takes too many steps.

        Machine and signals together follow one linear system, from step to step by Taylor's series.
        """
        (system, loads), (n, m) = self._states.matrices, self._states.matrices[1].shape
        whole = np.zeros((n + 2 * m, n + 2 * m))
        whole[:n, :n], whole[:n, n : n + m], whole[n : n + m, n + m :] = system, loads, np.eye(m)
        inside = slice(np.searchsorted(self._bent, low, "right"), np.searchsorted(self._bent, high))
        ends = np.concatenate([[low], self._bent[inside], [high]])
        long = np.diff(ends)
        parts = np.maximum(np.ceil(self._own_rate * long / _TURN), 1.0)
        if parts.sum() * n > _KEPT:
            return None
        early, late = (self._signals(ends[:-1] + part * long) for part in (0.25, 0.75))  # ends may be jumps
        which = np.repeat(np.arange(len(long)), parts.astype(int))
        length, slopes = (long / parts)[which], (late - early)[:, which] / (0.5 * long[which])
        begun = (np.arange(len(which)) - (np.cumsum(parts) - parts)[which]) * length
        times, signals = ends[which] + begun, (1.5 * early - 0.5 * late)[:, which] + slopes * begun
        states = np.vstack([np.zeros((n, len(which))), signals, slopes])
        added = np.hstack([carried(whole, states[:, k : k + _AT_ONCE], length[k : k + _AT_ONCE])[:n]
                           for k in range(0, len(which), _AT_ONCE)]).T  # fmt: skip
        terms = [np.eye(n)]
        for k in range(1, _TAYLOR):
            terms.append(system @ terms[-1] / k)
        series, now = np.vstack(terms), start
        for j, powers in enumerate(length[:, None] ** np.arange(_TAYLOR)):
            states[:n, j] = now
            now = powers @ (series @ now).reshape(_TAYLOR, n) + added[j]

        def run(at: Any) -> FloatArray:
            one = np.atleast_1d(np.asarray(at, dtype=float))
            j = np.maximum(np.searchsorted(times, one, "right") - 1, 0)
            found = carried(whole, states[:, j], one - times[j])[:n]
            return found if np.ndim(at) else found[:, 0]

        return run

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
    found, term = states, states
    for k in range(1, _TAYLOR):
        term = system @ term * (time / k)
        found = found + term
    return found
