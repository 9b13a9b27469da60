"""What follows the last joint of a load: rigid motion, sines that last, and the rest with an energy that only falls."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.mechanics.combine import combined
from vibopt.mechanics.panels import Numbers, TooLongError, exponential, greatest
from vibopt.records import dataclass

if TYPE_CHECKING:
    from vibopt.mechanics.transient import Reading, Transient

_NOTHING = 1e-12
"""Part of its size below which a state, a reading or a damping is rounding."""
_SURE = 1e-13
_MET, _FADED = 1e-9, 1e-12
"""Part of a speed by which it must miss every pole; part of a reading to which what fades is no more."""
_STOPPED, _TOGETHER = 1e-9, 1e-10
"""Parts to which rounding brings the speed of a base that stops, and the difference of speeds that are one."""
_FIRST, _QUICK, HORIZON = 4.0, 16.0 * np.pi, 1000.0
"""Periods in the first window behind the load, of the slowest motion or of one in 1 / rate if that is shorter; each
further one is twice as long; periods of the slowest motion in all."""


@dataclass(frozen=True, slots=True)
class Peak:
    """Greatest size of a reading: `value` with its sign [SI] at `time` [s]; infinite where it grows without end.

    within, part
        Index of the segment in which it lies, one past the last in the free vibration behind, and seconds from its
        beginning.  Infinite, with `time`, where it is what lasting sines near again and again.
    open
        Whether something greater may come later: what is next to undamped is followed over `HORIZON` periods alone.
    """

    value: float
    time: float
    within: int = 0
    part: float = 0.0
    open: bool = False


def _drifts(stiff: FloatArray, damped: FloatArray, heavy: int) -> tuple[FloatArray, FloatArray]:
    """Motions that no spring calls back, and what reads them off a state: right and left vectors of A^2 = 0, (size, k).

    Bodies that are loose stay where they are or, where no damper holds them, go on; bases go on, and bodies with them.
    Forces per place and per rate are (n, half); the places of rates behind the first `heavy` are empty.
    """
    n, half = stiff.shape
    values, shapes = np.linalg.eigh(0.5 * (stiff[:, :n] + stiff[:, :n].T))
    held = values > _NOTHING * max(float(values.max(initial=0.0)), 1e-300)
    loose, back = shapes[:, ~held], (shapes[:, held] / values[held]) @ shapes[:, held].T
    dragged = loose.T @ damped[:, :n] @ loose
    drag, ways = np.linalg.eigh(0.5 * (dragged + dragged.T))
    braked = drag > _NOTHING * max(float(np.abs(damped).max(initial=0.0)), 1e-300)
    free = loose @ ways[:, ~braked]
    ride = -back @ stiff[:, n:]
    slip = -(ways[:, braked] / drag[braked]) @ ways[:, braked].T @ loose.T @ (damped[:, :n] @ ride + damped[:, n:])
    along = ride + loose @ slip
    lag = -back @ (damped[:, :n] @ along + damped[:, n:])
    unit = np.eye(half)[:, n:]

    def state(places: FloatArray, speeds: FloatArray) -> FloatArray:
        return np.vstack([places, np.where(moving, speeds, 0.0)])

    def whole(bodies: FloatArray, bases: FloatArray) -> FloatArray:
        return np.vstack([bodies, bases])

    nothing = np.zeros((half, half))
    moving = np.ones((half, 1), dtype=bool)
    moving[heavy:n] = False
    still = nothing[:, : loose.shape[1]]
    right = [
        state(whole(loose, still[n:]), still),
        state(nothing[:, : free.shape[1]], whole(free, nothing[n:, : free.shape[1]])),
        state(whole(ride, unit[n:]), nothing[:, n:]),
        state(whole(lag, 0.0 * unit[n:]), whole(along, unit[n:])),
    ]
    left = [
        state(damped.T @ loose, whole(loose, still[n:])),
        state(np.where(moving, whole(free, nothing[n:, : free.shape[1]]), 0.0), nothing[:, : free.shape[1]]),
        state(unit, nothing[:, n:]),
        state(nothing[:, n:], unit),
    ]
    empty = np.eye(2 * half)[:, half + heavy : half + n]
    return np.hstack([*right, empty]), np.hstack([*left, empty])


class _Lasting:
    """What signals that go on for ever leave of a reading: sines, beside which the machine vibrates freely.

    state
        (size,): what of the machine's state is their motion.
    sum, most
        Of the amplitudes, and the greatest of all of them together, which is as much where no period is common.
    """

    def __init__(self, machine: Transient, whole: Numbers, row: Numbers, start: Numbers) -> None:
        size, own = machine.size, machine.own
        rates = whole[size:, size:]
        self.state, self.sum, self.most = np.zeros(size), 0.0, 0.0
        if not len(rates):
            return
        values, vectors = np.linalg.eig(rates)
        turns = values.imag > 0.0
        speeds = values[turns].imag
        near = np.abs(np.linalg.eigvals(own)[:, None] - 1j * speeds).min(axis=0)
        if (near <= _MET * speeds).any():
            self.sum = self.most = float("inf")
            return
        signals = 2.0 * (vectors * np.linalg.solve(vectors, start[size:].astype(complex)))[:, turns]
        pairs = zip(speeds, (whole[:size, size:] @ signals).T, strict=True)
        follows = np.array([np.linalg.solve(1j * speed * np.eye(size) - own, pushed) for speed, pushed in pairs]).T
        self.state = follows.real.sum(axis=1)
        waves = row[:size] @ follows + row[size:] @ signals
        self.sum = float(np.abs(waves).sum())
        self.most = float(combined(waves, tuple(speeds / speeds.min()), "peak"))


class Ringing:
    """What follows the last joint: rigid motion, sines that last, and the rest with an energy that only falls."""

    def __init__(self, machine: Transient, reading: Reading, state: FloatArray) -> None:
        self.a, self.rate, self.elastic = machine.own, machine.rate, machine.elastic
        self.whole, self.start = machine.onward(state)
        self.reads = machine.row(reading, self.whole)
        self.row = self.reads[: machine.size]
        self.lasting = _Lasting(machine, self.whole, self.reads, self.start)
        free = self.start[: machine.size] - self.lasting.state
        right, left = _drifts(machine.elastic, machine.braked, machine.parts[4])
        self.basis = np.linalg.svd(left)[0][:, left.shape[1] :]
        self.drifts = right @ np.linalg.solve(left.T @ right, left.T)
        self.drifting = self.drifts @ free
        self.moving = free - self.drifting
        self.size = float(np.abs(self.row) @ np.abs(free))

    def peak(self, found: Peak, begun: int, ended: float, seen: FloatArray) -> Peak:
        """The greater of what was found and of what follows; sizes of the states that were `seen` before (size,)."""
        along = self.row @ self.a
        away, cancelled = float(along @ self.drifting), float(np.abs(along) @ np.abs(self.drifting))
        seen = np.maximum(seen, np.abs(self.start[: len(self.row)]))
        stopped = _STOPPED * float(np.abs(along @ self.drifts) @ seen)
        if abs(away) > max(_NOTHING * self.size, _TOGETHER * cancelled, stopped):
            return Peak(float(np.copysign(np.inf, away)), float("inf"), begun)
        if not np.isfinite(self.lasting.sum):
            return Peak(float("inf"), float("inf"), begun)
        still, state = float(self.row @ self.drifting), self.start
        found = found if abs(found.value) >= abs(still) else Peak(still, ended, begun)
        period, gone = 2.0 * np.pi / self._slowest, 0.0
        length = _FIRST * min(period, _QUICK)  # what fades at once is gone before the slow part is looked at
        while gone < HORIZON * period * (1.0 - _SURE):
            left = abs(still) + min(self._reach(self.moving))
            if left + self.lasting.sum <= abs(found.value) * (1.0 + _SURE):
                return found
            if left <= _FADED * max(abs(found.value), self.lasting.most):
                most = self.lasting.most
                return found if abs(found.value) >= most else Peak(most, float("inf"), begun, float("inf"))
            try:
                best = greatest(self.whole * length, self.reads, state[None, :], abs(found.value))
            except TooLongError:
                break
            if best is not None:
                part = (gone + best.at * length) / self.rate
                found = Peak(best.value, ended + part, begun, part)
            state, gone = exponential(self.whole * length) @ state, gone + length
            self.moving = exponential(self.a * length) @ self.moving
            length = min(2.0 * length, HORIZON * period - gone)
        return replace(found, open=True)

    @cached_property
    def _inner(self) -> FloatArray:
        """A on the motions that are not rigid."""
        return np.asarray(self.basis.T @ self.a @ self.basis)

    @cached_property
    def _modes(self) -> tuple[Numbers, Numbers]:
        values, vectors = np.linalg.eig(self._inner)
        return values, vectors

    @cached_property
    def _slowest(self) -> float:
        rates = np.abs(self._modes[0])
        moving = rates[rates > _NOTHING * rates.max(initial=0.0)]
        return float(moving.min()) if len(moving) else 1.0

    def _reach(self, moving: FloatArray) -> tuple[float, float]:
        """What the row may still reach: by the energy, and by all modes in phase."""
        if not self.basis.shape[1]:
            return 0.0, 0.0
        free, n = self.elastic.shape
        stored = np.zeros_like(self.a)
        stored[:free, :n] = self.elastic
        stored[n : 2 * n, n : 2 * n] = np.eye(n)
        stored = self.basis.T @ stored @ self.basis
        inner, row = self.basis.T @ moving, self.row @ self.basis
        energy = float(np.sqrt(max(inner @ stored @ inner, 0.0) * max(row @ np.linalg.solve(stored, row), 0.0)))
        shares = (row @ self._modes[1]) * np.linalg.solve(self._modes[1], inner.astype(complex))
        return energy, float(np.abs(shares).sum())


__all__ = ["HORIZON", "Peak", "Ringing"]
