"""Greatest response of one machine to a load of few segments, by its modes: waves in closed form, looked at together.

On each segment, and behind the last, a reading is a sum of waves c e^(rate t) and of a straight line.  All are laid on
one grid as a product of a coarse and a fine one; between its points no wave bends further than its own size allows,
and only the few cells that may hold the greatest value are looked into.  What this road cannot take (loose or massless
bodies, motions of the bases themselves, poles that meet, sums that cancel, loads without end) gives nothing: the
general one, by exponentials of matrices, is for those.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.mechanics.ringing import Peak

if TYPE_CHECKING:
    from vibopt.mechanics.transient import Reading, Transient
    from vibopt.signals import Segment

_SEGMENTS, _CELLS, _FEWEST = 6, 1 << 16, 64
"""Segments at most, and cells of the grid on each, at most and at least."""
_CELL, _BENT, _WITHIN, _STEPS = 0.5, 0.05, 200, 8
"""Radians of the fastest motion in a cell, part of the greatest value by which it may bend, cells that are looked into
at most, and steps of Newton in each."""
_APART, _NOTHING, _ROUNDED = 1e-4, 1e-12, 4e3
"""Ratio of squares of natural frequencies, slowest to fastest, from which on both keep their digits; part of the
sizes in a sum that is rounding; how far the waves in a sum may exceed its greatest value."""
_ALIKE, _RISE = 1e-13, 1e-15
"""Part of the greatest value by which an earlier one may be less and is as great; and that no step to it brings."""
_DOUBLINGS = 6
"""Of the first window behind the load, until nothing that is left can be greater."""


class _Modes(NamedTuple):
    """s' = poles s + struck f under signals f; motion of the free coordinates from where slow bases hold them is
    Re(shapes s).

    poles (N,), struck (N, n_signals), shapes (n_free, N).
    """

    poles: ComplexArray
    struck: ComplexArray
    shapes: FloatArray | ComplexArray


class _Piece(NamedTuple):
    """A reading over one piece of time: Re(sum of waves e^(rates t)) + line[0] + line[1] t, t in seconds."""

    length: float
    rates: ComplexArray
    waves: ComplexArray
    line: tuple[float, float]


def peak_by_modes(machine: Transient, reading: Reading) -> Peak | None:
    """Greatest size of a reading of a row of one machine, from rest on and for ever; None where this road has none."""
    if len(machine.segments) > _SEGMENTS or machine.segments[-1].endless:
        return None
    try:
        with np.errstate(all="ignore"):
            return _Road(machine, reading).peak()
    except (_NoWayError, np.linalg.LinAlgError):
        return None


class _NoWayError(ArithmeticError):
    """Not by modes."""


class _Road:
    """A machine under its load, and a reading of it."""

    def __init__(self, machine: Transient, reading: Reading) -> None:
        n = machine.n_free
        mass, damping, stiffness = (one[0, :n] for one in (machine.mass, machine.damping, machine.stiffness))
        self.segments, self.power = tuple(one.lone for one in machine.segments), reading.power
        loads, moved = machine.loads[:n], machine.loads[n:]
        rows = np.array([one.ravel() for one in (reading.row, reading.rates, reading.inertia)])
        root = _root(mass[:, :n])
        squares, turned = np.linalg.eigh(root.T @ stiffness[:, :n] @ root)
        if not squares[0] > _APART * squares[-1]:
            raise _NoWayError
        shapes = root @ turned
        self.led = np.zeros((3, loads.shape[1]))
        if len(moved):
            ride = -(shapes / squares) @ (shapes.T @ stiffness[:, n:])
            dragged = damping[:, n:] + damping[:, :n] @ ride
            if not (np.abs(dragged) <= _NOTHING * np.abs(damping).max()).all():
                raise _NoWayError
            loads = loads - (mass[:, n:] + mass[:, :n] @ ride) @ moved
            led = rows[:, :n] @ ride + rows[:, n:]
            sizes = np.abs(rows[:, :n]) @ np.abs(ride) + np.abs(rows[:, n:])
            self.led = np.where(np.abs(led) > _NOTHING * sizes, led, 0.0) @ moved
            if self.led[: 2 - min(self.power, 2)].any():  # where a base is, and how fast, is no matter of waves
                raise _NoWayError
        self.modes = _modes(squares, shapes, shapes.T @ damping[:, :n] @ shapes, shapes.T @ loads)
        self.read = rows[:, :n] @ self.modes.shapes
        poles = self.modes.poles
        orders = poles ** np.arange(self.power, self.power + 3)[:, None]
        self.row = (self.read * orders).sum(axis=0)
        self.sizes = ((np.abs(rows[:, :n]) @ np.abs(self.modes.shapes)) * np.abs(orders)).sum(axis=0)
        self.pieces: list[_Piece] = []
        self.noise = 0.0

    def peak(self) -> Peak | None:
        """The greatest size; the earliest where several are as great."""
        state: ComplexArray = np.zeros(len(self.modes.poles), dtype=complex)
        for segment in self.segments:
            state = self._through(segment, state)
        poles, waves = self.modes.poles, self.row * state
        slowest = float(np.abs(poles).min())
        window = 2.0 * np.pi / slowest
        self.pieces.append(_Piece(window, poles, waves, (0.0, 0.0)))
        found = _highest(self.pieces)
        longer = window * 2.0 ** np.arange(_DOUBLINGS)
        left = np.abs(waves) @ np.exp(poles.real[:, None] * (window + np.array([0.0, *longer])))
        room = found[0] * (1.0 + _ALIKE)
        if left[0] > room:
            if not left[-1] <= room:
                raise _NoWayError
            longest = float(longer[int(np.argmax(left <= room)) - 1])
            more = _highest([_Piece(longest, poles, waves * np.exp(poles * window), (0.0, 0.0))])
            if more[0] > room:
                found = (more[0], more[1], len(self.pieces) - 1, more[3] + window)
        size, sign, within, part = found
        if not 0.0 < self.noise <= _ROUNDED * size < np.inf:
            raise _NoWayError
        begun = sum(one.length for one in self.segments[:within])
        return Peak(float(sign * size), float(begun + part), within, float(part))

    def _through(self, segment: Segment, state: ComplexArray) -> ComplexArray:
        """Take up a segment from a state at its beginning; the state at its end."""
        poles, struck, _ = self.modes
        length = float(segment.length)
        if segment.blows.any():
            state = state + struck @ segment.blows
        if not (segment.rates @ segment.rates).any():  # a straight line
            signal = segment.read @ np.array([segment.start, segment.rates @ segment.start / length]).T
            pushed = struck @ signal  # s' = poles s + pushed[0] + pushed[1] t
            second = -pushed[:, 1] / poles
            first = (second - pushed[:, 0]) / poles
            along = first + second * length
            line = self._line(first, second, signal)
            rates, waves, size = poles, np.zeros(0), abs(line[0]) + abs(line[1]) * length
        else:
            speeds, basis = np.linalg.eig(segment.rates / length)
            signal = (segment.read @ basis) * np.linalg.solve(basis, segment.start.astype(complex))
            follows = (struck @ signal) / (speeds - poles[:, None])  # (N, m)
            first, along = follows.sum(axis=1), follows @ np.exp(speeds * length)
            orders = np.arange(self.power, self.power + 3)[:, None]
            waves = (self.read @ follows) * speeds**orders + (self.led @ signal) * speeds ** np.maximum(orders - 2, 0)
            waves = waves.sum(axis=0)
            rates, line, size = np.concatenate([poles, speeds]), (0.0, 0.0), float(np.abs(waves).sum())
        own = state - first
        every: ComplexArray = np.concatenate([self.row * own, waves])
        self.pieces.append(_Piece(length, rates, every, line))
        self.noise += float(self.sizes @ (np.abs(first) + np.abs(own))) + size
        return np.asarray(own * np.exp(poles * length) + along)

    def _line(self, first: ComplexArray, second: ComplexArray, signal: FloatArray) -> tuple[float, float]:
        """What is read of a motion first + second t beside a signal (n_signals, 2) of the same kind."""
        found = np.zeros(2)
        for order, (row, led) in enumerate(zip(self.read, self.led, strict=True), self.power):
            if order < 2:
                found[: 2 - order] += (row @ np.array([first, second]).T[:, order:]).real
            elif order < 4:
                found[: 4 - order] += led @ signal[:, order - 2 :]
        return float(found[0]), float(found[1])


def _root(mass: FloatArray) -> FloatArray:
    """Free coordinates from those of mass one, (n, n)."""
    own = mass.diagonal()
    if np.count_nonzero(mass) == len(own):
        if not (own > 0.0).all():
            raise _NoWayError
        return np.diag(1.0 / np.sqrt(own))
    return np.asarray(np.linalg.inv(np.linalg.cholesky(mass)).T)


def _modes(squares: FloatArray, shapes: FloatArray, braked: FloatArray, pushed: FloatArray) -> _Modes:
    """Of modes of mass one without damping, from their squared frequencies, their shapes, damping and forces on them.

    Where damping couples none, each has two poles, of which one stands for both where they are conjugate.
    """
    n, own = len(squares), braked.diagonal()
    if not (np.abs(braked - np.diag(own)) > _NOTHING * own.max()).any():
        half = 0.5 * own
        root = np.sqrt((half * half - squares).astype(complex))
        fast = -half - root
        slow = squares / fast
        struck = pushed / (slow - fast)[:, None]
        if not root.real.any():
            return _Modes(slow, 2.0 * struck, shapes)
        return _Modes(np.concatenate([slow, fast]), np.concatenate([struck, -struck]), np.tile(shapes, 2))
    a = np.zeros((2 * n, 2 * n))
    a[:n, n:] = np.eye(n)
    a[n:, :n], a[n:, n:] = -np.diag(squares), -braked
    poles, vectors = np.linalg.eig(a)
    struck = np.linalg.solve(vectors, np.concatenate([np.zeros_like(pushed), pushed]).astype(complex))
    kept = poles.imag >= 0.0
    twice = np.where(poles.imag > 0.0, 2.0, 1.0)[kept]
    poles = np.minimum(poles.real, 0.0) + 1j * poles.imag
    return _Modes(poles[kept], struck[kept] * twice[:, None], shapes @ vectors[:n, kept])


def _highest(pieces: list[_Piece]) -> tuple[float, float, int, float]:
    """Greatest size of all, its sign, the piece and the seconds from its beginning; the earliest of those as great."""
    most, piece, since, cells = _cells(pieces)
    while len(since) and float(cells.bent.max()) > _BENT * most:
        which, part, most = cells.halved(most)
        since, piece, cells = since[which] + part, piece[which], cells.of(which, part)
    when, value = cells.tops(most)
    sizes = np.abs(value)
    if not len(sizes):
        raise _NoWayError
    best = np.flatnonzero(sizes >= sizes.max() * (1.0 - _ALIKE))
    at = best[np.lexsort(((since + when)[best], piece[best]))[0]]
    return float(sizes[at]), float(np.sign(value[at])), int(piece[at]), float(since[at] + when[at])


def _cells(pieces: list[_Piece]) -> tuple[float, IntArray, FloatArray, _Cells]:
    """The greatest size on a grid; where more may lie: piece, seconds from its beginning, and the cell."""
    count = max(len(one.rates) for one in pieces)
    rates, waves = np.zeros((2, len(pieces), count), dtype=complex)
    for i, one in enumerate(pieces):
        rates[i, : len(one.rates)], waves[i, : len(one.rates)] = one.rates, one.waves
    lengths = np.array([one.length for one in pieces])
    line = np.array([one.line for one in pieces])
    turns = float(np.abs(rates.imag).max() * lengths.max()) / _CELL
    if not turns <= _CELLS:
        raise _NoWayError
    many = int(np.ceil(np.sqrt(max(turns, _FEWEST))))
    coarse, width = lengths[:, None] * (np.arange(many) / many), lengths / many**2
    fine = width[:, None] * np.arange(many + 1)
    begun = waves[:, None] * np.exp(rates[:, None] * coarse[..., None])
    along = np.exp(rates[..., None] * fine[:, None])
    sizes = np.abs((begun @ along).real + line[:, :1, None] + line[:, 1:, None] * (coarse[..., None] + fine[:, None]))
    most = float(sizes.max())
    bent = (np.abs(begun) @ (np.abs(rates)[..., None] ** 2)) * (0.125 * width**2)[:, None, None]
    piece, row, column = np.nonzero(np.maximum(sizes[..., :-1], sizes[..., 1:]) + bent >= most * (1.0 - _ALIKE))
    since = coarse[piece, row] + fine[piece, column]
    offset, slope = line[piece].T
    return (
        most,
        piece,
        since,
        _Cells(width[piece], rates[piece], begun[piece, row] * along[piece, :, column], offset + slope * since, slope),
    )


class _Cells(NamedTuple):
    """Short pieces of time: Re(sum of waves e^(rates t)) + offset + slope t over widths [s], (n,); waves (n, K)."""

    width: FloatArray
    rates: ComplexArray
    waves: ComplexArray
    offset: FloatArray
    slope: FloatArray

    @property
    def bent(self) -> FloatArray:
        """By how much each may rise above its values at both ends, (n,)."""
        return np.asarray((np.abs(self.waves) * np.abs(self.rates) ** 2).sum(axis=1) * (0.125 * self.width**2))

    def halved(self, most: float) -> tuple[IntArray, FloatArray, float]:
        """Halves that may hold more than `most`: of which cell, and where each begins in it; the most that was seen."""
        ends = np.array([self.at(part * self.width, self.orders[:1])[0] for part in (0.0, 0.5, 1.0)])
        sizes = np.abs(ends)
        most = max(most, float(sizes.max()))
        half, which = np.nonzero(np.maximum(sizes[:-1], sizes[1:]) + 0.25 * self.bent >= most * (1.0 - _ALIKE))
        if len(which) > _WITHIN:
            raise _NoWayError
        return which, 0.5 * half * self.width[which], most

    def of(self, which: IntArray, part: FloatArray) -> _Cells:
        """Half as wide ones that begin in others."""
        rates, slope = self.rates[which], self.slope[which]
        waves = self.waves[which] * np.exp(rates * part[:, None])
        return _Cells(0.5 * self.width[which], rates, waves, self.offset[which] + slope * part, slope)

    @property
    def orders(self) -> ComplexArray:
        """What makes of waves those of values, slopes and bends, (3, n, K)."""
        return np.array([np.ones_like(self.rates), self.rates, self.rates**2])

    def at(self, when: FloatArray, orders: ComplexArray) -> FloatArray:
        """Values, slopes and bends, as many as `orders`, at a time since the beginning of each, (..., n)."""
        found: FloatArray = (self.waves * np.exp(self.rates * when[:, None]) * orders).real.sum(axis=2)
        found[0] += self.offset + self.slope * when
        found[1:2] += self.slope
        return found

    def tops(self, most: float) -> tuple[FloatArray, FloatArray]:
        """When each is greatest inside, and its value there; by steps of Newton, for they hardly bend."""
        if len(self.width) > _WITHIN:
            raise _NoWayError
        when, orders = 0.5 * self.width, self.orders
        for left in range(_STEPS, 0, -1):
            value, rising, bend = self.at(when, orders)
            step = np.where(bend * value < 0.0, -rising / bend, np.copysign(self.width, rising * value))
            moved = np.minimum(np.maximum(when + step, 0.0), self.width)
            if left == 1 or np.abs(rising * (moved - when)).max(initial=0.0) <= _RISE * most:
                break
            when = moved
        return when, value


__all__ = ["peak_by_modes"]
