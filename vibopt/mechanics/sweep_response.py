"""Run-up and run-down through resonances, exactly: a force whose speed changes evenly, in closed form.

Each pole answers a phasor P(W) e^(i phase), where phase' = W and W' = a, by a quasi-steady motion that the Faddeeva
function of (i / 2 a)^(1/2) (W + i pole) holds, and by free vibrations: those of the beginning, and one of every pole
that was passed.  No step is made, so that no cycle costs anything.  In the frame that turns with the force all this
is smooth; its modulus is the greatest response over every angle at which the force may begin.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.mechanics.envelopes import Envelope, greatest
from vibopt.mechanics.joints import condensed, first_order
from vibopt.mechanics.panels import Numbers
from vibopt.mechanics.peaks_in_time import Peak
from vibopt.mechanics.readout import Reading
from vibopt.mechanics.ringing import HORIZON, MET
from vibopt.records import cached_property, dataclass
from vibopt.signals import Sweep

_FAR, _TERMS = 36.0, 20
"""Square of the argument of the Faddeeva function from which its asymptotic series is used, and its terms at most."""
_TOP = 1.33234, 0.7488717463481
"""Where |x w(x)| is greatest on the real axis, and how great."""
_LOOSE = 2.0
"""On what is beyond the first term of that series, where a bound is asked for."""
_ALIKE, _CIRCLE, _AROUND = 50.0, 16, 0.05
"""Condition of modes beyond which the damping goes round its value on a circle; points, and radius as a part."""
_UNMOVED, _FAINT = 1e-12, 1e-9
"""Parts of what a pole might add, and of the most that one adds, below both of which it adds rounding alone."""
_SAMPLES, _ABOVE = 129, 1.05
"""Of a rough look, and how much more than it saw may be in it."""
_FIRST, _SURE, _ROUNDING = 4.0, 1e-12, 1e-17
"""Periods of the slowest mode in the first window behind; rounding of a value, and of a phase."""


@dataclass(frozen=True)
class RunUp:
    """A linear machine in its steady vibration, and a force on it that then changes its speed, and stays at the last.

    mass, damping, stiffness
        Of all coordinates, those of the bases last, which are at rest, (n_coords, n_coords); real or complex.
    n_free
        Number of free coordinates.
    load
        (n_coords,): what the force acts on.
    """

    mass: Numbers
    damping: Numbers
    stiffness: Numbers
    n_free: int
    load: FloatArray
    sweep: Sweep

    def at_most(self, reading: Reading) -> float:
        """No less than the greatest size of a reading, and hardly more, in less work."""
        times = np.linspace(0.0, self.sweep.times[-1], _SAMPLES)
        return self.peak(reading, _ABOVE * float(self.history(reading, times).max())).value

    def peak(self, reading: Reading, least: float = 0.0) -> Peak:
        """Greatest size of a reading over every angle at which it begins, from the beginning on, for ever.

        Where it is not above `least`, that.
        """
        machine = self.modal(reading)
        for time, speed, size in zip((0.0, np.inf), self._ends, self.sweep.still, strict=True):
            if size and machine.met(speed):
                return Peak(np.inf, time, len(self.sweep.rates) if time else 0)
        turning, stays = self.stretches(machine)
        found = greatest(turning.envelope(turning.length), np.zeros(len(turning.length)), turning.length, least)
        best, begun = Peak(least, 0.0), self.sweep.times
        if found is not None:
            best = Peak(found.value, float(begun[found.number]) + found.at, found.number, found.at, found.open)
        return stays.peak(best, float(begun[-1]), len(turning.length))

    @property
    def _ends(self) -> tuple[float, float]:
        return self.sweep.speeds[0], self.sweep.speeds[-1]

    def history(self, reading: Reading, times: FloatArray) -> FloatArray:
        """Greatest size of a reading over every angle at which it begins, at times [s], (n,)."""
        return np.asarray(np.abs(self.turning(self.modal(reading), times)))

    def steady(self, reading: Reading, speeds: FloatArray) -> FloatArray:
        """Size of the steady vibration at speeds of the run-up [rad/s], (n,)."""
        machine, sweep = self.modal(reading), self.sweep
        sense, joints = np.sign(sweep.rates[0]), np.array(sweep.speeds[1:-1])
        which = np.searchsorted(sense * joints, sense * speeds)
        size = np.array([_polynomial(sweep.powers[one], speed) for one, speed in zip(which, speeds, strict=True)]).real
        with np.errstate(divide="ignore", invalid="ignore"):
            driven = machine.parts @ (1.0 / (1j * speeds - machine.poles[:, None]))
        return np.asarray(np.abs((driven + machine.through) * size))

    def turning(self, machine: Modal, times: FloatArray) -> ComplexArray:
        """A reading in the frame that turns with the force, at times [s], (n,); without end the steady vibration."""
        begun, now = self.sweep.times, times < self.sweep.times[-1]
        turning, stays = self.stretches(machine)
        which = np.searchsorted(begun, times[now], side="right") - 1
        found = np.empty(len(times), dtype=complex)
        found[now] = turning.value(which, times[now] - begun[which])
        found[~now] = stays.value(np.zeros(np.count_nonzero(~now), dtype=int), times[~now] - begun[-1])
        return found

    def stretches(self, machine: Modal) -> tuple[Stretches, Stretches]:
        """Parts of the run-up without a joint; and the speed at which it stays behind."""
        sweep = self.sweep
        begins = sweep.still[0] and 1.0 / (1j * sweep.speeds[0] - machine.poles)  # at rest nothing meets a pole
        state = np.zeros(len(machine.poles), dtype=complex) + sweep.still[0] * begins
        powers = np.zeros((len(sweep.powers), max(map(len, sweep.powers))), dtype=complex)
        for row, power in zip(powers, sweep.powers, strict=True):
            row[: len(power)] = power
        speeds, rates = np.array(sweep.speeds), np.array(sweep.rates)
        turning = Stretches(machine, state, speeds[:-1], rates, np.diff(speeds) / rates, powers)
        stays = np.array([[sweep.still[1]]], dtype=complex)
        return turning, Stretches(machine, turning.last, speeds[-1:], np.zeros(1), np.full(1, np.inf), stays)

    def modal(self, reading: Reading) -> Modal:
        """The machine by its poles; where modes are next to alike, the mean of those around it."""
        system = _System(self, reading, self.damping)
        if not system.alike:
            return system.modal
        turns = np.exp(2j * np.pi * np.arange(_CIRCLE) / _CIRCLE)
        all_round = [_System(self, reading, self.damping * (1.0 + _AROUND * turn)).modal for turn in turns]
        return mean(all_round, np.full(_CIRCLE, 1.0 / _CIRCLE))


@dataclass(frozen=True, slots=True)
class Modal:
    """A reading of a machine by its poles [1/s]: what each adds to it, and what the force adds by itself.

    A pole that the force does not excite, or that is not read, is not among them.
    """

    poles: ComplexArray
    parts: ComplexArray
    through: complex

    @classmethod
    def of(cls, poles: Numbers, row: Numbers, shapes: Numbers, load: Numbers, through: complex) -> Modal:
        """By what is read of states (N,), shapes of the poles (N, N), and what the force adds to states (N,)."""
        back = np.linalg.inv(shapes)
        parts = (row @ shapes) * (back @ load)
        sizes = np.linalg.norm(row) * np.linalg.norm(shapes, axis=0) * np.linalg.norm(back, axis=1)
        felt = np.abs(parts) > _UNMOVED * sizes * np.linalg.norm(load)
        felt |= np.abs(parts) > _FAINT * np.abs(parts).max(initial=0.0)
        return cls(np.asarray(poles[felt], dtype=complex), parts[felt], through)

    def met(self, speed: float) -> bool:
        """Whether a speed [rad/s] is that of a pole that nothing damps."""
        return bool((np.abs(1j * speed - self.poles) <= MET * abs(speed)).any())


def mean(several: list[Modal], weights: ComplexArray | FloatArray) -> Modal:
    """Sum of readings, each with a weight, as one."""
    return Modal(
        np.concatenate([one.poles for one in several]),
        np.concatenate([weight * one.parts for weight, one in zip(weights, several, strict=True)]),
        sum(weight * one.through for weight, one in zip(weights, several, strict=True)),
    )


class _System:
    """A machine at one damping as one system of first order, with its poles."""

    def __init__(self, machine: RunUp, reading: Reading, damping: Numbers) -> None:
        n = machine.n_free
        if not machine.mass[:n].any(axis=1).all():
            self._with_joints(machine, reading, damping)
            return
        unit = 1.0 / np.sqrt(np.diag(machine.mass[:n, :n]).real)
        mass, damper, elastic = ((one[:n, :n].T * unit).T * unit for one in (machine.mass, damping, machine.stiffness))
        damper, stiff, pushed = (np.linalg.solve(mass, one) for one in (damper, elastic, machine.load[:n] * unit))
        fast = float(np.sqrt(np.abs(stiff).max()))
        system = np.block([[np.zeros((n, n)), np.eye(n)], [-stiff / fast**2, -damper / fast]])
        values, vectors = np.linalg.eig(system)
        if not np.iscomplexobj(system):
            values = np.minimum(values.real, 0.0) + 1j * values.imag
        rows = [np.zeros(n)] * reading.power + [one[:n] * unit for one in (reading.row, reading.rates, reading.inertia)]
        row = np.concatenate([rows[0] - rows[2] @ stiff, (rows[1] - rows[2] @ damper) * fast])
        load = np.concatenate([np.zeros(n), pushed / fast])
        self.modal = Modal.of(fast * values, row, vectors, load, complex(rows[2] @ pushed))
        self._energies = (elastic, vectors[:n]), (mass, vectors[n:] * fast)

    def _with_joints(self, machine: RunUp, reading: Reading, damping: Numbers) -> None:
        """As of any machine; what has no mass has no rate among the states."""
        n = machine.n_free
        mass, damper, elastic = (one[:n, :n] for one in (machine.mass, damping, machine.stiffness))
        one, kept = first_order(mass, damper, elastic, n), condensed(mass, damper, elastic, n)
        poles, vectors = np.linalg.eig(one.rates)
        if not np.iscomplexobj(one.rates):
            poles = np.minimum(poles.real, 0.0) + 1j * poles.imag
        row, through = np.zeros(len(poles), dtype=complex), 0j
        for order, read in enumerate((reading.row, reading.rates, reading.inertia), start=reading.power):
            along = read[:n] @ one.places
            if order:
                before = along @ np.linalg.matrix_power(one.rates, order - 1)
                through, along = through + complex(before @ one.struck @ machine.load[:n]), before @ one.rates
            row = row + along
        self.modal = Modal.of(poles, row, vectors, one.struck @ machine.load[:n], through)
        self._energies = (kept.stiffness, vectors[: kept.n]), (kept.mass[: kept.heavy, : kept.heavy], vectors[kept.n :])

    @property
    def alike(self) -> bool:
        """Whether two modes are next to alike, measured by their energy."""
        energy = np.concatenate([np.linalg.cholesky(one.real).T @ shapes for one, shapes in self._energies])
        return float(np.linalg.cond(energy / np.sqrt((np.abs(energy) ** 2).sum(axis=0)))) > _ALIKE


class Stretches:
    """Stretches one behind the other, on each the force is one polynomial of the speed; or one, of one speed for ever.

    Of what is asked of them at `which` (n,) of them, times (n,) are from the beginning of each [s].

    state
        Of each pole at the beginning, in the frame that turns with the force; `last` is that at the end.
    low, rate, length
        Speed at the beginning [rad/s], its change [rad/s^2], 0 where it stays, and how long it takes [s], (m,) each.
    powers
        Phasor of the force by powers of the speed, (m, n_powers); and its derivatives, powers first.
    """

    def __init__(
        self,
        machine: Modal,
        state: ComplexArray,
        low: FloatArray,
        rate: FloatArray,
        length: FloatArray,
        powers: ComplexArray,
    ) -> None:
        self.poles, self.parts, self.through = machine.poles[:, None], machine.parts, machine.through
        self.low, self.rate, self.length, self.turns = low, rate, length, bool(rate.all())
        self.powers = [np.polynomial.polynomial.polyder(powers.T, k) for k in range(powers.shape[1])]
        which = np.arange(len(low))
        self.free, self.last = state[:, None] - self._driven(which, low), state
        if not self.turns:
            return
        behind, left = self._driven(which, low + rate * length), self._left(which, length)
        kept = np.exp(self._turned(which, length))
        for k in which.tolist():
            self.free[:, k] += self.last - state
            self.last = behind[:, k] + left[:, k] + self.free[:, k] * kept[:, k]

    def envelope(self, length: FloatArray) -> Envelope:
        """As a function of time up to `length` (m,) [s], for the search."""
        fast = np.abs(self.poles).max(initial=0.0) + np.maximum(self.low, self.low + self.rate * length)
        return Envelope(self._pushed, self._ringing, self.bound, self.fading, fast)

    def value(self, which: IntArray, times: FloatArray) -> ComplexArray:
        """The reading in the frame that turns with the force, (n,); without end the steady vibration."""
        ends = np.isinf(times)
        times = np.where(ends, 0.0, times)
        return self._pushed(which, times) + np.where(ends, 0.0, self._ringing(which, times))

    def _pushed(self, which: IntArray, times: FloatArray) -> ComplexArray:
        """The reading without free vibrations, (n,)."""
        speed = self.low[which] + self.rate[which] * times
        through = self.through * _polynomial(self.powers[0][:, which], speed)
        return np.asarray(self.parts @ self._driven(which, speed) + through)

    def _ringing(self, which: IntArray, times: FloatArray) -> ComplexArray:
        """Free vibrations in the reading, (n,)."""
        found = self.free[:, which] * np.exp(self._turned(which, times))
        return np.asarray(self.parts @ (found + self._left(which, times) if self.turns else found))

    def _turned(self, which: IntArray, times: FloatArray) -> ComplexArray:
        """By which power of e each pole's free vibration changes in the frame of the force, (n_poles, n)."""
        return np.asarray(self.poles * times - 1j * (self.low[which] + 0.5 * self.rate[which] * times) * times)

    def _left(self, which: IntArray, times: FloatArray) -> ComplexArray:
        """Free vibrations that poles passed on the stretch have left, (n_poles, n)."""
        left, when, since = (one[:, which] for one in self._passed)
        return np.asarray(left * np.exp(np.where(times >= when, self._turned(which, times) - since, -np.inf)))

    def fading(self, which: IntArray, low: FloatArray, high: FloatArray) -> FloatArray:
        """Bound of free vibrations in the reading between times, (n,) each."""
        free = np.abs(self.free[:, which]) * np.exp(self.poles.real * low)
        if self.turns:
            left, when, since = (one[:, which] for one in self._passed)
            begins = np.minimum(np.maximum(low, when), high)
            free += np.abs(left) * np.exp(np.where(when <= high, self.poles.real * begins - since.real, -np.inf))
        return np.asarray(np.abs(self.parts) @ free)

    def bound(self, which: IntArray, low: FloatArray, high: FloatArray) -> FloatArray:
        """Of the modulus of the reading between times, (n,) each."""
        if not self.turns:
            return self.fading(which, low, high) + self._steady
        rate = np.abs(self.rate[which])
        ends = self.low[which] + self.rate[which] * np.array([low, high])
        fast = ends.max(axis=0)
        near = np.clip(self.poles.imag, ends.min(axis=0), fast)
        away = np.hypot(near - self.poles.imag, self.poles.real)
        size, *more = (_polynomial(np.abs(power[:, which]), fast) for power in self.powers)
        with np.errstate(divide="ignore", invalid="ignore"):
            short = rate / away
            later = sum((short**k * one for k, one in enumerate(more, start=1)), short / away * size)
            driven = (size + _LOOSE * later) / away
        q, rest = (np.abs(one[..., which]) for one in self._rest)
        among = _polynomial(q, fast)
        among = among + rest * np.sqrt(0.5 * np.pi / rate) * faddeeva_at_most(np.abs(self._turn[which]) * away)
        driven = np.where(away**2 < 2.0 * _FAR * rate, among, np.minimum(driven, among))
        return np.asarray(np.abs(self.parts) @ driven + abs(self.through) * size + self.fading(which, low, high))

    @property
    def _steady(self) -> float:
        """Size of the steady vibration, where the speed stays."""
        driven = self._driven(np.zeros(1, dtype=int), self.low)[:, 0]
        return float(abs(self.parts @ driven + self.through * self.powers[0][0, 0]))

    @cached_property
    def _turn(self) -> ComplexArray:
        """Argument of the Faddeeva function per W + i pole, (m,)."""
        return np.asarray(np.exp(0.25j * np.pi * np.sign(self.rate)) / np.sqrt(2.0 * np.abs(self.rate)))

    @cached_property
    def _rest(self) -> tuple[ComplexArray, ComplexArray]:
        """P = (i W - pole) Q + rate Q' + rest: coefficients of Q, (degree + 1, n_poles, m), and rest, (n_poles, m)."""
        p = self.powers[0]
        q = np.zeros((len(p) + 1, len(self.poles), len(self.low)), dtype=complex)
        for j in range(len(p) - 1, 0, -1):
            q[j - 1] = (p[j] + self.poles * q[j] - self.rate * (j + 1) * q[j + 1]) / 1j
        return q, p[0] + self.poles * q[0] - self.rate * q[1]

    @cached_property
    def _passed(self) -> tuple[ComplexArray, FloatArray, ComplexArray]:
        """Free vibration that a passed pole leaves: its amplitude, from when on [s], and its logarithm's beginning.

        Each (n_poles, m).
        """
        argument = -self._turn * (self.low + 1j * self.poles)
        at = self.poles.imag - np.sign(self.rate) * self.poles.real
        when = np.where(argument.imag >= 0.0, (at - self.low) / self.rate, np.inf)
        left = -2.0 * np.sqrt(np.pi) / (2j * self._turn * self.rate) * self._rest[1]
        return left, when, argument**2

    def _driven(self, which: IntArray, speed: FloatArray) -> ComplexArray:
        """Quasi-steady motion of each pole at speeds of stretches, (n_poles, n)."""
        away = 1j * speed - self.poles
        if not self.turns:
            with np.errstate(divide="ignore", invalid="ignore"):
                return np.asarray(self.powers[0][0, 0] / away)
        rate = self.rate[which]
        near = np.abs(away) ** 2 < 2.0 * _FAR * np.abs(rate)
        found = np.empty(away.shape, dtype=complex)
        found[~near] = self._series(np.nonzero(~near)[1], which, speed, away[~near])
        if near.any():
            from scipy.special import wofz

            pole, when = np.nonzero(near)
            own = which[when]
            argument = self._turn[own] * (speed[when] + 1j * self.poles[pole, 0])
            side = np.where(argument.imag >= 0.0, 1.0, -1.0)
            q, rest = (one[..., pole, own] for one in self._rest)
            size = side * np.sqrt(np.pi) / (2j * self._turn[own] * rate[when])
            found[near] = _polynomial(q, speed[when]) + rest * size * wofz(side * argument)
        return found

    def _series(self, when: IntArray, which: IntArray, speed: FloatArray, away: ComplexArray) -> ComplexArray:
        """As `_driven`, far from a pole, of some of the speeds; with i W - pole, (n,)."""
        rate, numbers = self.rate[which][when], np.arange(len(when))
        small = rate / away**2
        terms = np.array([_polynomial(power[:, which], speed)[when] for power in self.powers], dtype=complex)
        whole, step, order = terms[0].copy(), rate / away, 1j * np.arange(len(terms))[:, None]
        for m in range(_TERMS):
            higher = step * terms[1:]
            terms *= -small * (order - 1j * (2 * m + 1))
            terms[:-1] -= higher
            whole[numbers] += terms[0]
            more = np.abs(terms[0]) > _ROUNDING * np.abs(whole[numbers])
            left = int(np.count_nonzero(more))
            if not left:
                break
            if 2 * left < len(more):
                numbers, small, step, terms = numbers[more], small[more], step[more], terms[:, more]
        return np.asarray(whole / away)

    def peak(self, best: Peak, begun: float, number: int) -> Peak:
        """The greater of what was found before and of what follows, where the speed stays, for ever."""
        steady, only = self._steady, np.zeros(1, dtype=int)
        if steady > best.value * (1.0 + _SURE):
            best = Peak(steady, np.inf, number, open=best.open)
        rates = np.abs(self.poles)
        if not rates.any():
            return best
        period, gone = 2.0 * np.pi / float(rates[rates > 0.0].min()), 0.0  # a creep that rounds to none is no motion
        length = _FIRST * period
        while gone < HORIZON * period * (1.0 - _SURE):
            now, then = np.array([gone]), np.array([gone + length])
            if float(self.bound(only, now, now)[0]) <= best.value * (1.0 + _SURE):
                return best
            found = greatest(self.envelope(then), now, then, best.value)
            if found is not None:
                best = Peak(found.value, begun + found.at, number, found.at, best.open or found.open)
            gone, length = gone + length, min(2.0 * length, HORIZON * period - gone - length)
        return replace(best, open=True)


def faddeeva_at_most(size: FloatArray) -> FloatArray:
    """No |w(z)| of the upper half plane is greater where |z| is `size` or more, shape of `size`.

    |z w(z)| stays bounded there, so that it is greatest on the real axis: it rises to 0.7489 at 1.332, then falls.
    """
    from scipy.special import wofz

    with np.errstate(divide="ignore"):
        return np.asarray(np.where(size > _TOP[0], np.abs(wofz(size)), np.minimum(_TOP[1] / size, 1.0)))


def _polynomial(powers: Numbers, speed: FloatArray) -> Numbers:
    """A polynomial at speeds, shape of `speed`; coefficients by their power, one each or one for each speed."""
    found = np.zeros(np.shape(speed)) + powers[-1]
    for power in powers[-2::-1]:
        found = found * speed + power
    return np.asarray(found)
