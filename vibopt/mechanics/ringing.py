"""What follows the last joint of a load: rigid motion, sines that last, and the rest with an energy that only falls."""

from __future__ import annotations

from typing import TYPE_CHECKING
from weakref import proxy

import numpy as np

from vibopt.arrays import BoolArray, FloatArray, IntArray
from vibopt.mechanics.beating import highest
from vibopt.mechanics.combine import combined
from vibopt.mechanics.joints import UnlikeError
from vibopt.mechanics.panels import Along, Numbers, TooLongError, exponential, greatest
from vibopt.mechanics.peaks_in_time import Peaks
from vibopt.records import cached_property

if TYPE_CHECKING:
    from vibopt.mechanics.readout import Reading
    from vibopt.mechanics.transient import Transient

_NOTHING = 1e-12
"""Part of its size below which a state, a reading or a damping is rounding."""
_SURE = 1e-13
MET, _FADED = 1e-9, 1e-12
"""Part of a speed by which it must miss every pole; part of a reading to which what fades is no more."""
_ROUNDING, _APART, _ALIKE, _FAINT = 1e-15, 1e10, 1e-11, 1e-9
"""Part of the fastest rate that is no decay; condition of modes up to which they are told apart; parts of a speed by
which two are one, and of the greatest wave one that is none."""
_STOPPED, _TOGETHER = 1e-9, 1e-10
"""Parts to which rounding brings the speed of a base that stops, and the difference of speeds that are one."""
_FIRST, _QUICK, HORIZON = 4.0, 16.0 * np.pi, 1000.0
"""Periods in the first window behind the load, of the slowest motion or of one in 1 / rate if that is shorter; each
further one is twice as long; periods of the slowest motion in all."""
_WINDOWS, _LONGEST = 4, 4e5
"""Windows after which beats with what lasts are told by their waves, and periods over which they are followed."""


def _drifts(stiff: FloatArray, damped: FloatArray, heavy: int) -> tuple[FloatArray, FloatArray]:
    """Motions that no spring calls back, and what reads them off a state: right and left vectors of A^2 = 0.

    Bodies that are loose stay where they are or, where no damper holds them, go on; bases go on, and bodies with them.
    Forces per place and per rate are (..., n, half), vectors (..., size, k); the places of rates behind the first
    `heavy` are empty.

    Raises
    ------
    UnlikeError
        Not all machines have as many of them.
    """
    n, half = stiff.shape[-2:]
    values, shapes = np.linalg.eigh(0.5 * (stiff[..., :n] + stiff[..., :n].mT))  # those without a spring come first
    k = _count(values <= _NOTHING * np.maximum(values.max(axis=-1, initial=0.0), 1e-300)[..., None])
    loose, held = shapes[..., :k], shapes[..., k:]
    back = (held / values[..., None, k:]) @ held.mT
    dragged = loose.mT @ damped[..., :n] @ loose
    drag, ways = np.linalg.eigh(0.5 * (dragged + dragged.mT))
    size = np.maximum(np.abs(damped).max(axis=(-2, -1), initial=0.0), 1e-300)
    free_ways = _count(drag <= _NOTHING * size[..., None])
    free, ways = loose @ ways[..., :free_ways], ways[..., free_ways:]
    ride = -back @ stiff[..., n:]
    slip = -(ways / drag[..., None, free_ways:]) @ ways.mT @ loose.mT @ (damped[..., :n] @ ride + damped[..., n:])
    along = ride + loose @ slip
    lag = -back @ (damped[..., :n] @ along + damped[..., n:])
    unit = np.broadcast_to(np.eye(half)[:, n:], (*stiff.shape[:-2], half, half - n))
    moving = np.ones((half, 1), dtype=bool)
    moving[heavy:n] = False

    def state(places: FloatArray, speeds: FloatArray) -> FloatArray:
        return np.concatenate([places, np.where(moving, speeds, 0.0)], axis=-2)

    def whole(bodies: FloatArray, bases: FloatArray | None = None) -> FloatArray:
        still = np.zeros((*bodies.shape[:-2], half - n, bodies.shape[-1]))
        return np.concatenate([bodies, still if bases is None else bases], axis=-2)

    own, none = unit[..., n:, :], np.zeros_like
    right = [
        state(whole(loose), none(whole(loose))),
        state(none(whole(free)), whole(free)),
        state(whole(ride, own), none(unit)),
        state(whole(lag), whole(along, own)),
    ]
    left = [
        state(damped.mT @ loose, whole(loose)),
        state(np.where(moving, whole(free), 0.0), none(whole(free))),
        state(unit, none(unit)),
        state(none(unit), unit),
    ]
    empty = np.eye(2 * half)[:, half + heavy : half + n]
    empty = np.broadcast_to(empty, (*stiff.shape[:-2], *empty.shape))
    return np.concatenate([*right, empty], axis=-1), np.concatenate([*left, empty], axis=-1)


def _count(marks: BoolArray) -> int:
    """How many are marked of each machine (..., n)."""
    counts = marks.sum(axis=-1)
    if (counts != counts.flat[0]).any():
        raise UnlikeError
    return int(counts.flat[0])


class _Lasting:
    """What signals that go on for ever leave of a reading: sines, beside which the machine vibrates freely.

    state
        (size,): what of the machine's state is their motion.
    speeds, waves
        Of each sine, and its amplitude; without end where one meets a vibration that nothing damps.
    """

    def __init__(self, own: FloatArray, whole: Numbers, row: Numbers, start: Numbers) -> None:
        size = len(own)
        rates = whole[size:, size:]
        values, vectors = np.linalg.eig(rates)
        turns = values.imag > 0.0
        speeds = values[turns].imag
        near = np.abs(np.linalg.eigvals(own)[:, None] - 1j * speeds).min(axis=0)
        self.state, self.speeds, self.waves = np.zeros(size), np.ones(1), np.array([np.inf + 0j])
        if (near <= MET * speeds).any():
            return
        signals = 2.0 * (vectors * np.linalg.solve(vectors, start[size:].astype(complex)))[:, turns]
        pairs = zip(speeds, (whole[:size, size:] @ signals).T, strict=True)
        follows = np.array([np.linalg.solve(1j * speed * np.eye(size) - own, pushed) for speed, pushed in pairs]).T
        self.state = follows.real.sum(axis=1)
        self.speeds, self.waves = speeds, row[:size] @ follows + row[size:] @ signals

    def undamped(self, behind: Behind, row: Numbers, moving: FloatArray) -> FloatArray:
        """Take up what of a motion (size,) rings on for ever because nothing damps it; what is left of the motion."""
        rates, shapes = behind.modes[0][0], behind.modes[1][0]
        faint = np.maximum(_NOTHING * np.abs(rates), _ROUNDING * np.abs(rates).max(initial=0.0))
        rings = (rates.imag > faint) & (np.abs(rates.real) <= faint)
        if not rings.any() or np.linalg.cond(shapes) > _APART:
            return moving
        basis = behind.basis[0]
        shares = 2.0 * np.linalg.solve(shapes, (basis.T @ moving).astype(complex))[rings]
        ringing = basis @ (shapes[:, rings] * shares)
        self.speeds = np.concatenate([self.speeds, rates.imag[rings]])
        self.waves = np.concatenate([self.waves, row @ ringing])
        return np.asarray(moving - ringing.real.sum(axis=1))

    @property
    def sum(self) -> float:
        """Of the amplitudes."""
        return float(np.abs(self.waves).sum())

    @property
    def most(self) -> float:
        """The greatest of all sines together, for ever: of those without a common period the sum, which they near."""
        order = np.argsort(self.speeds)
        speeds, waves = self.speeds[order], self.waves[order]
        which = np.cumsum(np.diff(speeds, prepend=speeds[:1]) > _ALIKE * speeds)
        together = np.zeros(which[-1] + 1, dtype=complex)
        np.add.at(together, which, waves)
        speeds = speeds[np.unique(which, return_index=True)[1]]
        felt = np.abs(together) > _FAINT * np.abs(together).max()
        felt[np.abs(together).argmax()] = True
        return float(combined(together[felt], tuple(speeds[felt] / speeds[felt].min()), "peak"))


class _Held:
    """What a value that stays for ever leaves of a reading: about where the machine vibrates.

    state, still
        (size,): the machine as the value holds it, and what is read of it.
    drift
        (size,): how what no spring calls back goes faster and faster.
    """

    def __init__(self, behind: Behind, row: Numbers, start: Numbers) -> None:
        size, basis = behind.size, behind.basis[0]
        pushed = behind.whole[0, :size, size:] @ start[size:]
        self.drift = behind.drifts[0] @ pushed
        swings = basis.T @ behind.a[0] @ basis
        self.state = -basis @ np.linalg.solve(swings, basis.T @ (pushed - self.drift))
        self.still = float(row[:size] @ self.state + row[size:] @ start[size:])

    def runs_away(self, row: FloatArray, along: FloatArray) -> bool:
        """Whether a reading (size,), or its rate, grows with what drifts."""
        size = np.abs(self.drift)
        return any(abs(one @ self.drift) > _TOGETHER * (np.abs(one) @ size) for one in (row, along))


class Behind:
    """What follows the last joint, of machines in a row: rigid motion, sines that last, and the rest.

    Raises
    ------
    UnlikeError
        Of several machines not all can follow side by side.
    """

    def __init__(self, machine: Transient) -> None:
        self.machine: Transient = proxy(machine)  # which keeps this: a circle would hold its matrices until it is found
        self.a, self.size = machine.own, machine.size
        self.whole, self.start = machine.onward(machine.left)
        self.lasts = self.whole.shape[-1] > self.size
        if self.lasts and len(self.whole) > 1:
            raise UnlikeError
        right, left = _drifts(machine.elastic, machine.braked, machine.parts[4])
        self.basis = np.linalg.svd(left)[0][..., left.shape[-1] :]
        self.drifts = right @ np.linalg.solve(left.mT @ right, left.mT)
        self.holds = self.lasts and not np.linalg.eigvals(self.whole[0, self.size :, self.size :]).imag.any()
        self.followed = self.whole
        if self.holds:  # what swings about what stays: what goes faster and faster would take all digits
            swings = self.basis.mT @ self.a @ self.basis
            self.followed = np.pad(swings, ((0, 0), (0, 1), (0, 1)))
        self._windows: list[tuple[FloatArray, Along]] = []

    @cached_property
    def period(self) -> FloatArray:
        """Of the slowest motion, (n,), in 1 / rate."""
        rates = np.abs(self.modes[0])
        moving = np.where(rates > _NOTHING * rates.max(axis=-1, initial=0.0)[..., None], rates, np.inf)
        slowest = moving.min(axis=-1, initial=np.inf)
        return np.asarray(2.0 * np.pi / np.where(np.isfinite(slowest), slowest, 1.0))

    @property
    def horizon(self) -> FloatArray:
        """How long what rings on is followed, (n,), in 1 / rate."""
        return HORIZON * self.period

    @cached_property
    def modes(self) -> tuple[Numbers, Numbers]:
        """Of the motions that are not rigid: rates and shapes."""
        values, vectors = np.linalg.eig(self.basis.mT @ self.a @ self.basis)
        return values, vectors

    @cached_property
    def stored(self) -> FloatArray:
        """Twice their energy."""
        half, n = self.size // 2, self.machine.elastic.shape[-2]
        stored = np.zeros(self.a.shape)
        stored[:, :n, :half] = self.machine.elastic
        stored[:, half:, half:] = np.eye(half)
        return np.asarray(self.basis.mT @ stored @ self.basis)

    def window(self, index: int) -> tuple[FloatArray, Along]:
        """How long each piece of time is that is looked at (n,), in 1 / rate, and exp(a t) along it."""
        while len(self._windows) <= index:
            if not self._windows:  # what fades at once is gone before the slow part is looked at
                length = _FIRST * np.minimum(self.period, _QUICK)
                along = Along(self.followed * length[:, None, None])
            else:
                before, last = self._windows[-1]
                gone = sum(one for one, _ in self._windows)
                length = np.minimum(2.0 * before, np.maximum(self.horizon - gone, _NOTHING * before))
                whole = (length == 2.0 * before).all()
                along = last.doubled() if whole else Along(self.followed * length[:, None, None])
            self._windows.append((length, along))
        return self._windows[index]

    def most(self, reading: Reading) -> FloatArray:
        """What a reading never exceeds behind a load that ends, (n,): what is left behind and all modes in phase."""
        count = len(self.a)
        followed = _Followed(self, reading, Peaks.none(count), 0, np.zeros(count))
        return np.asarray(np.abs(followed.still) + followed._reach(np.arange(count)))

    def follow(self, reading: Reading, peaks: Peaks, begun: int, ended: FloatArray, seen: FloatArray) -> None:
        """Take up what follows a load, where it is greater; sizes of the states that were `seen` before (n, size)."""
        _Followed(self, reading, peaks, begun, ended).through(seen)


class _Followed:
    """A reading of what follows."""

    def __init__(self, behind: Behind, reading: Reading, peaks: Peaks, begun: int, ended: FloatArray) -> None:
        machine, size = behind.machine, behind.size
        self.behind, self.found, self.begun, self.ended = behind, peaks, begun, ended
        self.reads = machine.row(reading, behind.whole)
        self.row = self.reads[:, :size]
        self.sum = self.most = 0.0
        self.lasting: _Lasting | None = None
        self.held: _Held | None = None
        free = behind.start[:, :size]
        if behind.holds:
            self.held = _Held(behind, self.reads[0], behind.start[0])
            free = free - self.held.state
        elif behind.lasts:
            self.lasting = lasting = _Lasting(machine.own[0], behind.whole[0], self.reads[0], behind.start[0])
            free = free - lasting.state
        self.drifting = (behind.drifts @ free[..., None])[..., 0]
        self.moving = free - self.drifting
        if self.lasting is not None:
            if np.isfinite(lasting.sum):
                self.moving = lasting.undamped(behind, self.row[0], self.moving[0])[None]
            self.sum, self.most = lasting.sum, lasting.most if np.isfinite(lasting.sum) else np.inf
        self.size = _dot(np.abs(self.row), np.abs(free))
        self.still = _dot(self.row, self.drifting) + (self.held.still if self.held is not None else 0.0)
        self.state = np.array(behind.start)
        if behind.holds:
            self.reads = np.append(self.row @ behind.basis[0], self.still[:, None], axis=1)
            self.state = np.append(self.moving @ behind.basis[0], [[1.0]], axis=1)

    def through(self, seen: FloatArray) -> None:
        """Window by window, until nothing greater can come."""
        peaks, behind = self.found, self.behind
        alive = self._stays(seen)
        gone, index, horizon = np.zeros(len(self.still)), 0, behind.horizon
        while len(alive):
            alive = alive[self._may_rise(alive)]
            over = gone[alive] >= horizon[alive] * (1.0 - _SURE)
            peaks.open[alive[over]] = True
            alive = alive[~over]
            if not len(alive) or (index == _WINDOWS and self._beats(gone)):
                return
            length, along = behind.window(index)
            if len(alive) < len(length):
                length, along = length[alive], along.some(alive)
            a = behind.followed[alive] * length[:, None, None]
            try:
                best = greatest(a, self.reads[alive], self.state[alive][:, None], np.abs(peaks.value[alive]), along)
            except TooLongError:
                if len(peaks.value) > 1:
                    raise
                peaks.open[:] = True
                return
            part = (gone[alive] + best.at * length) / behind.machine.rate[alive]
            peaks.take(best.value, self.ended[alive] + part, self.begun, part, alive)
            step = along.whole
            self.state[alive] = (step @ self.state[alive][..., None])[..., 0]
            if behind.holds:
                self.moving = self.state[:, :-1] @ behind.basis[0].T
            else:
                own = step[:, : behind.size, : behind.size]
                self.moving[alive] = (own @ self.moving[alive][..., None])[..., 0]
            gone[alive] += length
            index += 1

    def _beats(self, gone: FloatArray) -> bool:
        """Take up the greatest of all that fades beside what lasts, to the end; whether that could be done."""
        if self.lasting is None:  # and so perhaps many machines
            return False
        (rates,), (shapes,) = self.behind.modes
        if np.linalg.cond(shapes) > _APART:
            return False
        shares = np.linalg.solve(shapes, (self.behind.basis[0].T @ self.moving[0]).astype(complex)) * self._rows[0]
        once, lasts = rates.imag >= 0.0, 1j * self.lasting.speeds
        waves = np.concatenate([[self.still[0] + 0j], self.lasting.waves * np.exp(lasts * gone[0]),
                                np.where(rates.imag > 0.0, 2.0, 1.0)[once] * shares[once]])  # fmt: skip
        peaks, falls = self.found, -rates.real[np.abs(shares) > _FADED * self.sum]
        length = min(
            -np.log(_FADED) / max(float(falls.min(initial=np.inf)), 1e-300), _LONGEST * float(self.behind.period[0])
        )
        every = np.concatenate([[0.0], lasts, rates[once]])
        value, at, peaks.open[0] = highest(every, waves, length, abs(float(peaks.value[0])))
        if at >= 0.0:
            part = (gone + at) / self.behind.machine.rate
            signed = np.copysign(value, float((waves @ np.exp(every * at)).real))
            peaks.take(np.array([signed]), self.ended + part, self.begun, part)
        if self.most > abs(peaks.value[0]):
            forever = np.array([np.inf])
            peaks.take(np.array([self.most]), forever, self.begun, forever)
        return True

    def _stays(self, seen: FloatArray) -> IntArray:
        """Machines that do not go on without end; what is left behind is taken up."""
        behind, peaks = self.behind, self.found
        along = (self.row[:, None] @ behind.a)[:, 0]
        away, cancelled = _dot(along, self.drifting), _dot(np.abs(along), np.abs(self.drifting))
        seen = np.maximum(seen, np.abs(behind.start[:, : behind.size]))
        stopped = _STOPPED * _dot(np.abs((along[:, None] @ behind.drifts)[:, 0]), seen)
        goes = np.abs(away) > np.maximum(np.maximum(_NOTHING * self.size, _TOGETHER * cancelled), stopped)
        if self.held is not None:
            goes |= self.held.runs_away(self.row[0], along[0])
        endless = np.where(goes, np.copysign(np.inf, away), np.inf if not np.isfinite(self.sum) else 0.0)
        peaks.take(endless, np.full(len(goes), np.inf), self.begun, 0.0)
        left = np.where((endless == 0.0) & (np.abs(peaks.value) < np.abs(self.still)), self.still, 0.0)
        peaks.take(left, self.ended if self.held is None else np.full(len(left), np.inf), self.begun, 0.0)
        return np.flatnonzero(endless == 0.0)

    def _may_rise(self, alive: IntArray) -> BoolArray:
        """Whether what is left may lift the reading above what was found; what lasts alone is taken up."""
        found = np.abs(self.found.value[alive])
        left = np.abs(self.still[alive]) + self._reach(alive)
        rises: BoolArray = left + self.sum > found * (1.0 + _SURE)
        faded = rises & (left <= _FADED * np.maximum(found, self.most))
        lasts = np.where(faded & (found < self.most), self.most, 0.0)
        forever = np.full(len(alive), np.inf)
        self.found.take(lasts, forever, self.begun, forever, alive)
        return rises & ~faded

    def _reach(self, alive: IntArray) -> FloatArray:
        """What the row may still reach: by the energy, or by all modes in phase."""
        if not self.behind.basis.shape[-1]:
            return np.zeros(len(alive))
        inner = (self.behind.basis.mT[alive] @ self.moving[alive][..., None])[..., 0]
        row, stored = self._rows, self.behind.stored[alive]
        energy = _dot(inner, (stored @ inner[..., None])[..., 0])
        by_energy = np.sqrt(np.maximum(energy, 0.0) * self._compliance[alive])
        modes = np.linalg.solve(self.behind.modes[1][alive], inner[..., None].astype(complex))[..., 0]
        return np.asarray(np.minimum(by_energy, np.abs(row[alive] * modes).sum(axis=-1)))

    @cached_property
    def _compliance(self) -> FloatArray:
        """Square of the reading for an energy of a half, (n,)."""
        row = (self.row[:, None] @ self.behind.basis)[:, 0]
        return np.asarray(np.maximum(_dot(row, np.linalg.solve(self.behind.stored, row[..., None])[..., 0]), 0.0))

    @cached_property
    def _rows(self) -> Numbers:
        """What is read of each mode."""
        return np.asarray((self.row[:, None] @ self.behind.basis @ self.behind.modes[1])[:, 0])


def _dot(left: Numbers, right: Numbers) -> FloatArray:
    """Products of the rows of both, (..., n) to (...)."""
    return np.asarray((left * right).sum(axis=-1))


def rung(
    whole: tuple[FloatArray, float],
    free: IntArray,
    row: FloatArray,
    state: FloatArray,
    least: float,
    *,
    any_above: bool = False,
) -> tuple[float, float]:
    """Greatest size of row . z above `least` while friction holds from a state on, for ever, and when; else zeros.

    Infinite where it does not go on as it is.  `whole` are the rates while it is held and the period of the slowest
    motion [s], `free` numbers of the states that move; `any_above` is an early one.
    """
    held, period = whole
    a = held[np.ix_(free, free)]
    lasts = np.setdiff1d(np.arange(len(state)), free)
    led = held[np.ix_(free, lasts)]
    moves = held[np.ix_(lasts, lasts)] @ state[lasts]
    try:
        rates, shapes = np.linalg.eig(a)
        about = -np.linalg.solve(a, led @ state[lasts])
        waves = (row[free] @ shapes) * np.linalg.solve(shapes, (state[free] - about).astype(complex))
    except np.linalg.LinAlgError:
        return np.inf, 0.0
    if (led @ moves).any() or row[lasts] @ moves:
        return np.inf, 0.0
    still = abs(row[free] @ about + row[lasts] @ state[lasts])
    best, gone, length = (0.0, 0.0), 0.0, _FIRST * period
    while True:
        least = max(least, abs(best[0]))
        may = still + float(np.abs(waves) @ np.exp(rates.real * gone))
        if may <= least * (1.0 + _NOTHING) or gone >= HORIZON * period or (any_above and best[0]):
            return best
        found = greatest(held[None] * length, row[None], state[None, None], np.array([least]))
        best = (float(found.value[0]), gone + float(found.at[0]) * length) if found.value[0] else best
        state, gone, length = exponential(held * length) @ state, gone + length, 2.0 * length
