"""Greatest response of machines to a load of few segments, by their modes: waves in closed form, looked at together.

On each segment, and behind the last, a reading is a sum of waves c e^(rate t) and of a straight line.  All are laid on
one grid as a product of a coarse and a fine one; between its points no wave bends further than its own size allows,
and only the few cells that may hold the greatest value are looked into.  What this road cannot take (loose or massless
bodies, motions of the bases themselves, poles that meet, sums that cancel, what varies for ever) gives nothing: the
general one, by exponentials of matrices, is for those.

Machines stand in a row (b,), and with them all that is of one.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from vibopt.mechanics.peaks_in_time import Peaks
from vibopt.mechanics.ringing import HORIZON

if TYPE_CHECKING:
    from vibopt.mechanics.readout import Reading
    from vibopt.mechanics.transient import Transient
    from vibopt.signals import Segment

_SEGMENTS, _CELLS, _FEWEST = 6, 1 << 18, 64
"""Segments at most, cells of all grids together at most, and of one at least."""
_CELL, _BENT, _WITHIN, _STEPS = 0.5, 0.05, 3000, 8
"""Radians of the fastest motion in a cell, part of the greatest value by which it may bend, cells of a machine that are
looked into at most, and steps of Newton in each."""
_APART, _SLOW, _NOTHING, _ROUNDED = 1e-6, 1e-5, 1e-12, 4e3
"""Part of what springs do to each other in a mode from which on the rest of it keeps its digits; ratio of squares of
natural frequencies to the greatest below which they are told apart once more; part of the sizes in a sum that is
rounding; how far the waves in a sum may exceed its greatest value."""
_MEETS = 1e-6
"""Part of a decay by which two poles must be apart."""
_SEEN = 1e-4
"""Part of the greatest wave from which on a grid follows one; smaller ones are looked into where they may matter."""
_PLAIN = 1e6
"""Condition of the vectors of signals, above which they are none."""
_ALIKE, _RISE = 1e-13, 1e-15
"""Part of the greatest value by which an earlier one may be less and is as great; and that no step to it brings."""
_DOUBLINGS, _FADED = 6, 40.0
"""Of the first window behind the load, until nothing that is left can be greater; decay to rounding."""


class _Modes(NamedTuple):
    """s' = poles s + struck f under signals f; motion of the free coordinates from where slow bases hold them is
    Re(shapes s).

    poles (b, N), struck (b, N, n_signals), shapes (b, n_free, N).
    """

    poles: ComplexArray
    struck: ComplexArray
    shapes: FloatArray | ComplexArray


class _Pieces(NamedTuple):
    """A reading over pieces of time: Re(sum of waves e^(rates t)) + line[0] + line[1] t, t from the beginning of each.

    length (b, P) [s], rates and waves (b, P, K), line (b, P, 2).
    """

    length: FloatArray
    rates: ComplexArray
    waves: ComplexArray
    line: FloatArray

    @classmethod
    def none(cls, count: int, pieces: int, waves: int) -> _Pieces:
        """To be filled."""
        rates: ComplexArray = np.zeros((2, count, pieces, waves), dtype=complex)
        return cls(np.zeros((count, pieces)), rates[0], rates[1], np.zeros((count, pieces, 2)))

    def some(self, those: slice) -> _Pieces:
        """Those of some machines."""
        return _Pieces(self.length[those], self.rates[those], self.waves[those], self.line[those])


class _Top(NamedTuple):
    """Greatest sizes (b,), unknown where not a number; signs, pieces, and seconds from the beginning of these."""

    size: FloatArray
    sign: FloatArray
    piece: IntArray
    part: FloatArray

    @classmethod
    def none(cls, count: int) -> _Top:
        """All unknown."""
        signs, parts = np.zeros((2, count))
        return cls(np.full(count, np.nan), signs, np.zeros(count, dtype=int), parts)


def peaks_by_modes(machine: Transient, reading: Reading) -> tuple[Peaks, BoolArray] | None:
    """Greatest sizes of a reading of machines in a row, from rest on and for ever, and for which they are known.

    None where this road leads nowhere.
    """
    last = machine.segments[-1]
    if len(machine.segments) > _SEGMENTS or (last.endless and (last.rates @ last.start).any()):
        return None
    try:
        with np.errstate(all="ignore"):
            return _Road(machine, reading).peaks()
    except (_NoWayError, np.linalg.LinAlgError):
        return None


class _NoWayError(ArithmeticError):
    """Not by modes."""


class _Road:
    """Machines under their load, and a reading of them."""

    def __init__(self, machine: Transient, reading: Reading) -> None:
        n = machine.n_free
        mass, damping, stiffness = machine.mass[:, :n], machine.damping[:, :n], machine.stiffness[:, :n]
        self.count, self.segments, self.power = len(mass), machine.finite, reading.power
        self.last = machine.segments[-1]
        loads, moved = machine.loads[:n], machine.loads[n:]
        rows: FloatArray = np.empty((self.count, 3, mass.shape[-1]))
        rows[:, 0], rows[:, 1], rows[:, 2] = reading.row, reading.rates, reading.inertia
        squares, shapes = _undamped(mass[..., :n], stiffness[..., :n])
        sizes = np.abs(shapes)
        cancelled = (sizes * (np.abs(stiffness[..., :n]) @ sizes)).sum(axis=1)
        self.good: BoolArray = (squares > _APART * cancelled).all(axis=1)
        squares = np.where(self.good[:, None], squares, 1.0)
        self.led = np.zeros((self.count, 3, loads.shape[1]))
        if len(moved):
            ride = -(shapes / squares[:, None]) @ (shapes.mT @ stiffness[..., n:])
            dragged = np.abs(damping[..., n:] + damping[..., :n] @ ride).max(axis=(1, 2))
            self.good &= dragged <= _NOTHING * np.abs(damping).max(axis=(1, 2))
            loads = loads - (mass[..., n:] + mass[..., :n] @ ride) @ moved
            led = rows[..., :n] @ ride + rows[..., n:]
            sizes = np.abs(rows[..., :n]) @ np.abs(ride) + np.abs(rows[..., n:])
            self.led = np.where(np.abs(led) > _NOTHING * sizes, led, 0.0) @ moved
            # where a base is, and how fast, is no matter of waves
            self.good &= ~self.led[:, : 2 - min(self.power, 2)].any(axis=(1, 2))
        self.begun: ComplexArray | None = None
        released = machine.segments[0].released
        if released is not None:  # a velocity is the blow that brings it, a displacement follows one by 1 / s
            begun = machine.loads[:n] @ released
            blows = np.stack([mass[..., :n] @ begun[:, 1], -stiffness[..., :n] @ begun[:, 0]], axis=2)
            loads = np.concatenate([np.broadcast_to(loads, (self.count, *loads.shape[-2:])), blows], axis=2)
        modes = _modes(squares, shapes, shapes.mT @ damping[..., :n] @ shapes, shapes.mT @ loads)
        if released is not None:
            self.begun = modes.struck[..., -2] + modes.struck[..., -1] / modes.poles
            modes = modes._replace(struck=modes.struck[..., :-2])
        self.modes = modes
        self.read = rows[..., :n] @ self.modes.shapes
        first = self.modes.poles[:, None] ** self.power if self.power else np.ones_like(self.modes.poles[:, None])
        orders = np.concatenate([first, first * self.modes.poles[:, None], first * self.modes.poles[:, None] ** 2], 1)
        self.row = (self.read * orders).sum(axis=1)
        self.sizes = ((np.abs(rows[..., :n]) @ np.abs(self.modes.shapes)) * np.abs(orders)).sum(axis=1)
        own, more = self.modes.poles.shape[1], max((_waves(segment) for segment in self.segments), default=0)
        self.pieces = _Pieces.none(self.count, len(self.segments) + 1, own + more)
        self.pieces.rates[..., :own] = self.modes.poles[:, None]
        self.noise, self.open = np.zeros(self.count), np.zeros(self.count, dtype=bool)

    def peaks(self) -> tuple[Peaks, BoolArray]:
        """The greatest sizes, and whether they are known; the earliest where several are as great."""
        state = self.begun if self.begun is not None else np.zeros(self.modes.poles.shape, dtype=complex)
        for index, segment in enumerate(self.segments):
            state = self._through(index, segment, state)
        lengths, poles, slow = self.pieces.length, self.modes.poles, np.abs(self.modes.poles).min(axis=1)
        window = lengths[:, -1] = 2.0 * np.pi / slow
        if self.last.endless:
            state = self._held(state)
            window = lengths[:, -1] = np.where(poles.imag.any(axis=1), window, _FADED / slow)
        waves = self.row * state
        self.pieces.waves[:, -1, : waves.shape[1]] = waves
        found = _highest(self.pieces, np.zeros(self.count))
        self._later(found, waves, window)
        good = self.good & (self.noise > 0.0) & (self.noise <= _ROUNDED * found.size) & np.isfinite(found.size)
        begun = np.cumsum(lengths, axis=1) - lengths
        time = begun[np.arange(self.count), found.piece] + found.part
        return Peaks(found.sign * found.size, time, found.piece, found.part, self.open), good

    def _later(self, found: _Top, waves: ComplexArray, window: FloatArray) -> None:
        """Take up what is greater behind the first window behind the load, where anything may be."""
        poles, size, line = self.modes.poles, np.abs(waves), self.pieces.line[:, -1:]
        self.good &= np.isfinite(found.size)
        room = found.size * (1.0 + _ALIKE) - np.abs(line[:, 0, 0])
        if ((np.exp(poles.real * window[:, None]) * size).sum(axis=1) <= room).all():
            return
        longer = window[:, None] * np.append(0.0, 2.0 ** np.arange(_DOUBLINGS))
        faded = np.exp(poles.real[:, None] * (window[:, None] + longer)[..., None])
        known = (faded @ size[..., None])[..., 0] <= room[:, None]
        self.open = self.good & ~known.any(axis=1)
        longer[:, -1] = np.where(self.open, (HORIZON - 1.0) * window, longer[:, -1])
        known[:, -1] |= self.open
        far = np.flatnonzero(self.open)
        for again in (np.flatnonzero(self.good & ~self.open & ~known[:, 0]), *far[:, None]):
            if not again.size:
                continue
            length, rates = longer[again, known[again].argmax(axis=1)], poles[again]
            begun = waves[again] * np.exp(rates * window[again, None])
            pieces = _Pieces(length[:, None], rates[:, None], begun[:, None], line[again])
            more = _highest(pieces, found.size[again])
            better = ~(more.size <= found.size[again] * (1.0 + _ALIKE))
            those = again[better]
            found.size[those], found.sign[those] = more.size[better], more.sign[better]
            found.piece[those], found.part[those] = len(self.segments), more.part[better] + window[those]
        ends = (size * np.exp(poles.real * (HORIZON * window)[:, None])).sum(axis=1)
        self.open &= ends > found.size * (1.0 + _ALIKE) - np.abs(line[:, 0, 0])

    def _held(self, state: ComplexArray) -> ComplexArray:
        """Take up signals that stay as they are for ever, from states (b, N); what of these fades."""
        _, start, _, read, blows = _in_a_row(self.last)
        signal = read @ np.stack([start, 0.0 * start], axis=2)
        still = -(self.modes.struck @ signal)[..., 0] / self.modes.poles
        line = self.pieces.line[:, -1] = self._line(still, 0.0 * still, signal)
        free = state + (self.modes.struck @ blows[..., None])[..., 0] - still
        self.noise += (self.sizes * (np.abs(still) + np.abs(free))).sum(axis=1) + np.abs(line[:, 0])
        return np.asarray(free)

    def _through(self, index: int, segment: Segment, state: ComplexArray) -> ComplexArray:
        """Take up a segment from states at its beginning (b, N); the states at its end."""
        poles, struck, _ = self.modes
        length, start, turned, read, blows, pieces = *_in_a_row(segment), self.pieces
        pieces.length[:, index] = length
        if blows.any():
            state = state + (struck @ blows[..., None])[..., 0]
        if not _waves(segment):
            rise = (turned @ start[..., None])[..., 0] / length[:, None]
            signal = read @ np.stack(np.broadcast_arrays(start, rise), axis=2)
            pushed = struck @ signal  # s' = poles s + pushed[..., 0] + pushed[..., 1] t
            second = -pushed[..., 1] / poles
            first = (second - pushed[..., 0]) / poles
            along = first + second * length[:, None]
            line = pieces.line[:, index] = self._line(first, second, signal)
            size = np.abs(line[:, 0]) + np.abs(line[:, 1]) * length
        else:
            speeds, basis, shares = _turning(segment, turned, start)
            speeds = speeds / length[:, None]
            signal = (read @ basis) * shares[:, None]
            follows = (struck @ signal) / (speeds[:, None] - poles[..., None])  # (b, N, m)
            first, along = follows.sum(axis=2), (follows @ np.exp(speeds * length[:, None])[..., None])[..., 0]
            orders = np.arange(self.power, self.power + 3)[:, None]
            own = (self.read @ follows) * speeds[:, None] ** orders
            sizes = np.abs(self.read) @ np.abs(follows) * np.abs(speeds[:, None]) ** orders  # modes may cancel, too
            size = sizes.sum(axis=(1, 2))
            if self.led.any():  # what a body has of its base, and what it moves against it, may cancel
                led = (self.led @ signal) * speeds[:, None] ** np.maximum(orders - 2, 0)
                own, size = own + led, size + np.abs(led).sum(axis=(1, 2))
            waves, many = own.sum(axis=1), poles.shape[1]
            pieces.rates[:, index, many : many + waves.shape[1]] = speeds
            pieces.waves[:, index, many : many + waves.shape[1]] = waves
        free = state - first
        pieces.waves[:, index, : poles.shape[1]] = self.row * free
        self.noise += (self.sizes * (np.abs(first) + np.abs(free))).sum(axis=1) + size
        return np.asarray(free * np.exp(poles * length[:, None]) + along)

    def _line(self, first: ComplexArray, second: ComplexArray, signal: FloatArray) -> FloatArray:
        """What is read (b, 2) of a motion first + second t beside a signal (b, n_signals, 2) of the same kind."""
        found, both = np.zeros((self.count, 2)), np.stack([first, second], axis=2)
        for index, order in enumerate(range(self.power, self.power + 3)):
            if order < 2:
                found[:, : 2 - order] += (self.read[:, index, None] @ both[..., order:])[:, 0].real
            elif order < 4:
                found[:, : 4 - order] += (self.led[:, index, None] @ signal[..., order - 2 :])[:, 0]
        return found


def _in_a_row(segment: Segment) -> tuple[FloatArray, ...]:
    """Length, start, rates, reading and blows of a segment, of one machine of a row or of each."""
    if np.ndim(segment.length):
        return np.asarray(segment.length), *segment.states
    return np.array([segment.length]), *(state[None] for state in segment.states)


def _waves(segment: Segment) -> int:
    """Number of waves in a segment: none in a straight line."""
    return segment.rates.shape[-1] if (segment.rates @ segment.rates).any() else 0


def _turning(segment: Segment, turned: FloatArray, start: FloatArray) -> tuple[ComplexArray, ...]:
    """Rates of the waves of signals, their states, and the share of each in what a segment begins with."""
    alone = np.ndim(segment.length) == 0
    both: tuple[Any, Any] = _eigen(turned[0].tobytes(), turned.shape[1]) if alone else np.linalg.eig(turned)
    if not (np.linalg.cond(both[1]) < _PLAIN).all():  # a line beside waves has no vectors of its own
        raise _NoWayError
    return *both, np.linalg.solve(both[1], start[..., None].astype(complex))[..., 0]


@lru_cache(maxsize=64)
def _eigen(matrix: bytes, count: int) -> tuple[ComplexArray, ComplexArray]:
    """Values and vectors of one matrix, in a row; a pulse has the same again and again."""
    values, vectors = np.linalg.eig(np.frombuffer(matrix).reshape(1, count, count))
    return np.asarray(values), np.asarray(vectors)


def _undamped(mass: FloatArray, stiffness: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Squares of the natural frequencies (b, n), rising, and shapes of mass one (b, n, n)."""
    own = np.diagonal(mass, axis1=1, axis2=2)
    if not (own > 0.0).all():
        raise _NoWayError
    if own.shape[1] == 1:
        return stiffness[:, 0] / own, 1.0 / np.sqrt(mass)
    if np.count_nonzero(mass) == own.size:
        size = 1.0 / np.sqrt(own)
        squares, turned = _told_apart(size[:, :, None] * stiffness * size[:, None])
        return squares, size[:, :, None] * turned
    root = np.asarray(np.linalg.inv(np.linalg.cholesky(mass)).mT)
    squares, turned = _told_apart(root.mT @ stiffness @ root)
    return squares, np.asarray(root @ turned)


def _told_apart(stiffness: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Eigenvalues (b, n), rising, and vectors; those far below the greatest are told apart among themselves again.

    The first look mixes them by the rounding of the greatest; what it leaves of that in their own space it does not.
    """
    squares, turned = np.linalg.eigh(stiffness)
    count = int((squares < _SLOW * squares[:, -1:]).all(axis=0).sum())
    if 0 < count < squares.shape[1]:
        slow = turned[..., :count]
        squares[:, :count], again = _told_apart(slow.mT @ stiffness @ slow)
        turned[..., :count] = slow @ again
    return squares, turned


def _modes(squares: FloatArray, shapes: FloatArray, braked: FloatArray, pushed: FloatArray) -> _Modes:
    """Of modes of mass one without damping, from their squared frequencies, their shapes, damping and forces on them.

    Where damping couples none, each has two poles, of which one stands for both where all are conjugate.
    """
    n, own = squares.shape[1], np.diagonal(braked, axis1=1, axis2=2)
    if n == 1 or (np.abs(braked * (1.0 - np.eye(n))).max(axis=(1, 2)) <= _NOTHING * own.max(axis=1)).all():
        half = 0.5 * own
        root = np.sqrt((half * half - squares).astype(complex))
        fast = -half - root
        slow = squares / fast
        apart: ComplexArray = np.where(
            np.abs(root) > _MEETS * half, slow - fast, np.nan
        )  # else rounding is as great as what is found
        struck = pushed / apart[..., None]
        if not root.real.any():
            return _Modes(slow, 2.0 * struck, shapes)
        both = np.concatenate([struck, -struck], axis=1)
        return _Modes(np.concatenate([slow, fast], axis=1), both, np.tile(shapes, 2))
    a = np.zeros((len(squares), 2 * n, 2 * n))
    a[:, :n, n:] = np.eye(n)
    a[:, n:, :n], a[:, n:, n:] = -np.eye(n) * squares[:, None], -braked
    poles, vectors = np.linalg.eig(a)
    struck = np.linalg.solve(vectors, np.concatenate([np.zeros_like(pushed), pushed], axis=1).astype(complex))
    return _Modes(np.minimum(poles.real, 0.0) + 1j * poles.imag, struck, shapes @ vectors[:, :n])


def _highest(pieces: _Pieces, least: FloatArray) -> _Top:
    """The greatest of all pieces, `least` (b,) where none is as great; the earliest of those as great."""
    count = len(pieces.length)
    sizes = np.abs(pieces.waves)
    seen = np.where(sizes > _SEEN * sizes.max(axis=2, keepdims=True), np.abs(pieces.rates.imag), 0.0)
    turns = float((seen.max(axis=2) * pieces.length).max()) / _CELL
    if not turns * pieces.length.size <= _CELLS:
        if count == 1:
            return _Top.none(1)
        halves = (_highest(pieces.some(half), least[half]) for half in (slice(count // 2), slice(count // 2, count)))
        return _Top(*(np.concatenate(both) for both in zip(*halves, strict=True)))
    most, cells = _cells(pieces, int(np.ceil(np.sqrt(max(turns, _FEWEST)))), least)
    while len(cells.of) and (cells.rough(most) | (cells.bent() > _BENT * most[cells.of])).any():
        cells = cells.halved(most)
    top = _Top.none(count)
    top.size[:] = np.where(np.isnan(most), most, least)
    if not len(cells.of):
        return top
    when, value = cells.tops(most)
    sizes, of = np.abs(value), cells.of
    begins = _begins(of)
    top.size[of[begins]] = np.maximum.reduceat(sizes, begins)
    good = np.flatnonzero(sizes >= top.size[of] * (1.0 - _ALIKE))
    those = good[_begins(of[good])]
    of = of[those]
    top.size[of], top.sign[of], top.piece[of], top.part[of] = (
        sizes[those], np.sign(value[those]), cells.piece[those], cells.since[those] + when[those]
    )  # fmt: skip
    return top


def _begins(of: IntArray) -> IntArray:
    """Where each machine's begin, of numbers that rise."""
    return np.flatnonzero(np.concatenate([[True], of[1:] != of[:-1]]))


def _cells(pieces: _Pieces, many: int, least: FloatArray) -> tuple[FloatArray, _Cells]:
    """The greatest sizes on a grid (b,), and the cells between its points in which more may lie, piece by piece.

    No number where these are too many.
    """
    lengths, rates, waves, line = pieces
    coarse, width = lengths[..., None] * (np.arange(many) / many), lengths / many**2
    fine = width[..., None] * np.arange(many + 1)
    begun = waves[:, :, None] * np.exp(rates[:, :, None] * coarse[..., None])
    along = np.exp(rates[..., None] * fine[:, :, None])
    since, values = coarse[..., None] + fine[:, :, None], (begun @ along).real
    if line.any():
        values = values + line[..., :1, None] + line[..., 1:, None] * since
    sizes = np.abs(values)
    most: FloatArray = np.maximum(sizes.max(axis=(1, 2, 3)), least)
    bent = _bent(np.abs(begun), np.abs(rates)[:, :, None] * width[..., None, None])[..., None]
    high = np.maximum(sizes[..., :-1], sizes[..., 1:]) + bent >= (most * (1.0 - _ALIKE))[:, None, None, None]
    of, piece, row, column = (few := _few(most, *np.nonzero(high)))
    begins = since[few]
    offset, slope = line[of, piece].T
    return most, _Cells(
        of, piece, begins, width[of, piece], rates[of, piece], begun[of, piece, row] * along[of, piece, :, column],
        offset + slope * begins, slope,
    )  # fmt: skip


def _bent(sizes: FloatArray, turns: FloatArray) -> FloatArray:
    """By how much sums of waves (..., K) may rise above their values at both ends, turning so many radians between."""
    return np.asarray((sizes * np.minimum(0.125 * turns**2, 2.0)).sum(axis=-1))


def _few(most: FloatArray, of: IntArray, *others: IntArray) -> tuple[IntArray, ...]:
    """Those of machines that have not too many; of others nothing is known."""
    if len(of) <= _WITHIN:
        return of, *others
    many = np.bincount(of, minlength=len(most)) > _WITHIN
    most[many] = np.nan
    few = np.flatnonzero(~many[of])
    return of[few], *(one[few] for one in others)


class _Cells(NamedTuple):
    """Short pieces of time, (n,): Re(sum of waves e^(rates t)) + offset + slope t over widths [s]; waves (n, K).

    of, piece, since
        Of which machine, on which piece, and so many seconds behind its beginning.
    """

    of: IntArray
    piece: IntArray
    since: FloatArray
    width: FloatArray
    rates: ComplexArray
    waves: ComplexArray
    offset: FloatArray
    slope: FloatArray

    def bent(self, part: float = 1.0) -> FloatArray:
        """By how much a part of each may rise above its values at both ends, (n,)."""
        return _bent(np.abs(self.waves), np.abs(self.rates) * (part * self.width)[:, None])

    def rough(self, most: FloatArray) -> BoolArray:
        """Whether waves that are no rounding turn further in it than in a cell of their own, (n,)."""
        fast = np.abs(self.rates) * self.width[:, None] > 2.0 * _CELL
        return np.asarray((np.abs(self.waves) * fast).sum(axis=1) > _ALIKE * most[self.of])

    def halved(self, most: FloatArray) -> _Cells:
        """Halves that may hold more than is known of their machine: `most` (b,), which takes up what is seen."""
        sizes = np.abs([self.at(part * self.width, self.waves[None])[0] for part in (0.0, 0.5, 1.0)])
        np.maximum.at(most, self.of, sizes.max(axis=0))
        high = np.maximum(sizes[:-1], sizes[1:]) + self.bent(0.5) >= most[self.of] * (1.0 - _ALIKE)
        which, half = np.nonzero(high.T)
        _, half, which = _few(most, self.of[which], half, which)
        part, rates, slope = 0.5 * half * self.width[which], self.rates[which], self.slope[which]
        waves = self.waves[which] * np.exp(rates * part[:, None])
        return _Cells(
            self.of[which], self.piece[which], self.since[which] + part, 0.5 * self.width[which], rates, waves,
            self.offset[which] + slope * part, slope,
        )  # fmt: skip

    @property
    def orders(self) -> ComplexArray:
        """Waves of values, slopes and bends, (3, n, K)."""
        first = self.waves * self.rates
        return np.array([self.waves, first, first * self.rates])

    def at(self, when: FloatArray, orders: ComplexArray) -> FloatArray:
        """Values, slopes and bends, as many as `orders`, at a time since the beginning of each, (..., n)."""
        found: FloatArray = (orders * np.exp(self.rates * when[:, None])).sum(axis=2).real
        found[0] += self.offset + self.slope * when
        found[1:2] += self.slope
        return found

    def tops(self, most: FloatArray) -> tuple[FloatArray, FloatArray]:
        """When each is greatest inside, and its value there; by steps of Newton, for they hardly bend."""
        when, orders, least = 0.5 * self.width, self.orders, _RISE * most[self.of]
        for left in range(_STEPS, 0, -1):
            value, rising, bend = self.at(when, orders)
            step = np.where(bend * value < 0.0, -rising / bend, np.copysign(self.width, rising * value))
            moved = np.minimum(np.maximum(when + step, 0.0), self.width)
            if left == 1 or (np.abs(rising * (moved - when)) <= least).all():
                break
            when = moved
        return when, value
