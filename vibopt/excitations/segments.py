"""Signals in time as segments without joints: lines, sines, decaying sines; one after the other, or several at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.mechanics.panels import exponential
from vibopt.signals import Segment

AFTER = 1e-6
"""What is written out behind a blow [s]; nothing happens in it."""
_NOTHING = 1e-12
_STRAIGHT = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[1.0, 0.0]]), np.zeros(1)
"""Rates, what reads them, and no blow: of all lines, for a record has thousands."""


def line(length: float, first: float, last: float) -> Segment:
    """From one value to another in a straight line over `length` [s]."""
    return Segment(length, np.array([first, last - first], dtype=float), *_STRAIGHT)


def lasting(value: float) -> Segment:
    """One value for ever: a line that does not move, whose slope a longer piece of time would make much of."""
    return replace(_segment(AFTER, [value], [[0.0]]), endless=True)


def sine(length: float, size: float, phase: float, turned: float, decay: float = 0.0, offset: float = 0.0) -> Segment:
    """offset + size e^(-decay t / length) sin(phase + turned t / length), t from 0 to `length` [s]."""
    start = [size * np.sin(phase), size * np.cos(phase)]
    rates = [[-decay, turned], [-turned, -decay]]
    if not offset:
        return _segment(length, start, rates)
    still = [[*one, 0.0] for one in (*rates, [0.0, 0.0])]
    return _segment(length, [*start, offset], still, [1.0, 0.0, 1.0])


def _segment(
    length: float, start: Sequence[float], rates: Sequence[Sequence[float]], read: Sequence[float] = ()
) -> Segment:
    own = np.array(start, dtype=float)
    reads = np.array([list(read) or [1.0, *np.zeros(len(own) - 1)]])
    return Segment(length, own, np.array(rates, dtype=float), reads, np.zeros(1))


def moved(signal: tuple[Segment, ...]) -> tuple[Segment, ...]:
    """Accelerations of a base whose displacement is a signal without jumps; where its velocity jumps, it is struck."""
    found, speed, size = [], 0.0, 0.0
    for segment in signal:
        faster = segment.read @ segment.rates / segment.length
        first, last = (float((faster @ w)[0]) for w in (segment.start, exponential(segment.rates) @ segment.start))
        found.append(replace(segment, read=faster @ segment.rates / segment.length, blows=np.array([first - speed])))
        speed, size = last, max(size, float(np.abs(faster).max()) * float(np.abs(segment.start).max()))
    if abs(speed) > _NOTHING * size and not signal[-1].endless:
        found.append(replace(line(AFTER, 0.0, 0.0), blows=np.array([-speed])))
    return tuple(found)


def together(signals: Sequence[tuple[Segment, ...]]) -> tuple[Segment, ...]:
    """Several signals that begin at once, each of one row, as segments that read them all; cut at every joint."""
    if len(signals) == 1:
        return signals[0]
    lengths = [[segment.length for segment in signal if not segment.endless] for signal in signals]
    begins = [np.concatenate([[0.0], np.cumsum(length)]) for length in lengths]
    joints = np.unique(np.concatenate(begins))
    spans = np.diff(joints)
    joints = joints[np.concatenate([[True], spans > 1e-12 * joints[-1]])]
    found = tuple(_cut(signals, begins, low, high) for low, high in pairwise(joints.tolist()))
    endless = [signal[-1].length for signal in signals if signal[-1].endless]
    if endless:
        last = float(joints[-1])
        found += (replace(_cut(signals, begins, last, last + max(endless)), endless=True),)
    return found


def _cut(signals: Sequence[tuple[Segment, ...]], begins: list[FloatArray], low: float, high: float) -> Segment:
    """All signals between two times without a joint between them."""
    starts, rates, reads, blows = [np.zeros(0)], [np.zeros((0, 0))], [], np.zeros(len(signals))
    room = 1e-12 * high
    for row, (signal, begin) in enumerate(zip(signals, begins, strict=True)):
        which = int(np.searchsorted(begin, low + room, side="right")) - 1
        if which >= len(signal):
            reads.append(np.zeros((1, 0)))
            continue
        own, part = signal[which], max(low - begin[which], 0.0) / signal[which].length
        starts.append(_later(own, part))
        rates.append(own.rates * ((high - low) / own.length))
        reads.append(own.read)
        blows[row] = own.blows[0] if part * own.length <= room else 0.0
    return Segment(
        high - low,
        np.concatenate(starts),
        _blocks(rates),
        _blocks(reads),
        blows,
        released=_released(signals) if low == 0.0 else None,
    )


def _later(segment: Segment, part: float) -> FloatArray:
    """States of a signal behind a part of a segment."""
    rates, start = segment.rates, segment.start
    if part == 0.0:
        return start
    if len(start) == 2 and rates[0, 0] == rates[1, 1] and rates[0, 1] == -rates[1, 0]:  # they turn in a plane
        turned = complex(start[1], start[0]) * np.exp(part * complex(rates[0, 0], rates[0, 1]))
        return np.array([turned.imag, turned.real])
    return np.asarray(exponential(rates * part) @ start)


def _blocks(matrices: Sequence[FloatArray]) -> FloatArray:
    """Matrices along the diagonal of one."""
    found = np.zeros(np.sum([one.shape for one in matrices], axis=0))
    row = column = 0
    for one in matrices:
        found[row : row + one.shape[0], column : column + one.shape[1]] = one
        row, column = row + one.shape[0], column + one.shape[1]
    return found


def _released(signals: Sequence[tuple[Segment, ...]]) -> FloatArray | None:
    """With which displacement and velocity begins what each of some signals acts on, (n_signals, 2)."""
    every = [signal[0].released for signal in signals]
    if all(one is None for one in every):
        return None
    return np.concatenate([np.zeros((1, 2)) if one is None else one for one in every])
