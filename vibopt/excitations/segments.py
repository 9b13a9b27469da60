"""Signals in time as segments without joints: lines, sines, decaying sines; one after the other, or several at once."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.mechanics.panels import exponential
from vibopt.signals import Segment


def line(length: float, first: float, last: float) -> Segment:
    """From one value to another in a straight line over `length` [s]."""
    return _segment(length, [first, last - first], [[0.0, 1.0], [0.0, 0.0]])


def sine(length: float, size: float, phase: float, turned: float, decay: float = 0.0, offset: float = 0.0) -> Segment:
    """offset + size e^(-decay t / length) sin(phase + turned t / length), t from 0 to `length` [s]."""
    start = [size * np.sin(phase), size * np.cos(phase), offset]
    rates = [[-decay, turned, 0.0], [-turned, -decay, 0.0], [0.0, 0.0, 0.0]]
    return _segment(length, start, rates, [1.0, 0.0, 1.0])


def _segment(
    length: float, start: Sequence[float], rates: Sequence[Sequence[float]], read: Sequence[float] = ()
) -> Segment:
    own = np.array(start, dtype=float)
    reads = np.array([list(read) or [1.0, *np.zeros(len(own) - 1)]])
    return Segment(length, own, np.array(rates, dtype=float), reads, np.zeros(1))


def together(signals: Sequence[tuple[Segment, ...]]) -> tuple[Segment, ...]:
    """Several signals that begin at once, each of one row, as segments that read them all; cut at every joint."""
    if len(signals) == 1:
        return signals[0]
    begins = [np.concatenate([[0.0], np.cumsum([one.length for one in signal])]) for signal in signals]
    joints = np.unique(np.concatenate(begins))
    spans = np.diff(joints)
    joints = joints[np.concatenate([[True], spans > 1e-12 * joints[-1]])]
    return tuple(_cut(signals, begins, low, high) for low, high in pairwise(joints.tolist()))


def _cut(signals: Sequence[tuple[Segment, ...]], begins: list[FloatArray], low: float, high: float) -> Segment:
    """All signals between two times without a joint between them."""
    from scipy.linalg import block_diag

    starts, rates, reads, blows = [np.zeros(0)], [np.zeros((0, 0))], [], np.zeros(len(signals))
    room = 1e-12 * high
    for row, (signal, begin) in enumerate(zip(signals, begins, strict=True)):
        which = int(np.searchsorted(begin, low + room, side="right")) - 1
        if which >= len(signal):
            reads.append(np.zeros((1, 0)))
            continue
        own, part = signal[which], max(low - begin[which], 0.0) / signal[which].length
        starts.append(exponential(own.rates, part) @ own.start)
        rates.append(own.rates * ((high - low) / own.length))
        reads.append(own.read)
        blows[row] = own.blows[0] if part * own.length <= room else 0.0
    return Segment(
        high - low,
        np.concatenate(starts),
        block_diag(*rates[1:]) if len(rates) > 1 else rates[0],
        block_diag(*reads),
        blows,
    )
