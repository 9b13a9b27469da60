"""Tops in time of a reading of one machine beside its greatest, so that what makes that one less sees the next."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial import polynomial

from vibopt.arrays import BoolArray, FloatArray, IntArray
from vibopt.mechanics.panels import exponentials
from vibopt.mechanics.peaks_in_time import Peak
from vibopt.mechanics.stacked import wide

if TYPE_CHECKING:
    from vibopt.mechanics.panels import Numbers
    from vibopt.mechanics.readout import Reading
    from vibopt.mechanics.transient import Transient

_MOST, _STEPS, _TERMS, _CLOSE, _SMOOTH = 4, 6, 12, 1e-9, 1e-9
"""Tops beside the greatest, steps of Newton to each, terms of a series of motion around it; parts: of a step that is
none, and of a value that is no jump."""


def other_tops(machine: Transient, reading: Reading, greatest: Peak, behind: float, within: float) -> list[Peak]:
    """The highest of them that are so great a part of the greatest at least.

    Looked for up to the time of the greatest, and so long behind the load [s].
    """
    begins = np.cumsum([0.0, *(one.length for one in machine.finite)])
    value, segment, part, step = _seen(machine, reading, max(behind, float(greatest.time - begins[-1])))
    high = _above_both(np.abs(value), part) & (np.abs(value) >= within * abs(greatest.value))
    high &= (np.abs(begins[segment] + part - greatest.time) > step) | (value * greatest.value < 0.0)
    those = np.flatnonzero(high)
    those = those[np.argsort(-np.abs(value[those]), kind="stable")[:_MOST]]
    segment, step = segment[those], step[those]
    part, value = _climbed(machine, reading, segment, part[those], step)
    columns = (value, begins[segment] + part, segment, part)
    every = [Peak(*row) for row in zip(*(column.tolist() for column in columns), strict=True)]
    found = [greatest]
    for top, near in sorted(zip(every, step.tolist(), strict=True), key=lambda one: -abs(one[0].value)):
        apart = all(abs(top.time - one.time) > near or top.value * one.value < 0.0 for one in found)
        found += [top] if apart and abs(top.value) >= within * abs(greatest.value) else []
    return found[1:]


def _above_both(size: FloatArray, part: FloatArray) -> BoolArray:
    """Which sizes are no less than those beside them; a joint stands twice, and counts once where nothing jumps.

    Behind the last they may go on rising.
    """
    wide = np.concatenate([[-np.inf, -np.inf], size, [np.inf, np.inf]])
    joint = np.concatenate([[False, False], part == 0.0, [False, False]])
    with np.errstate(invalid="ignore"):
        once = joint[1:] & (np.abs(np.diff(wide)) <= _SMOOTH * wide[1:])  # from the one before
    before = np.where(once[1:-2], wide[:-4], wide[1:-3])
    behind = np.where(once[2:-1], wide[4:], wide[3:-1])
    return np.asarray((size >= before) & (size > behind))


def _seen(machine: Transient, reading: Reading, behind: float) -> tuple[FloatArray, IntArray, FloatArray, FloatArray]:
    """At many times in turn: values, segments, seconds from their beginnings, and seconds between."""
    found, begun = [], 0
    for times, (values,) in machine.samples([reading], np.asarray(behind)):
        times = np.broadcast_to(times, values.shape)
        part = times - times[:, :1]
        numbers = np.broadcast_to(begun + np.arange(len(times))[:, None], values.shape)
        found.append((values, numbers, part, np.broadcast_to(part[:, 1:2], values.shape)))
        begun += len(times)
    value, segment, part, step = (
        np.concatenate([one.ravel() for one in column]) for column in zip(*found, strict=True)
    )
    return value, segment, part, step


def _climbed(
    machine: Transient, reading: Reading, segment: IntArray, part: FloatArray, step: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Seconds and values of the tops next to where some were seen, each in its segment, (n,)."""
    found, value, begun = part.copy(), np.zeros(len(part)), 0
    for stretch in machine.stretches:
        some = np.flatnonzero((segment >= begun) & (segment < begun + stretch.count))
        which = segment[some] - begun
        length = np.broadcast_to(stretch.length, stretch.count)[which]
        each = zip(some, which, length, strict=True)
        for i, own, long in each if stretch.uneven else ():
            row = machine.row(reading, stretch.a[own] / (machine.rate * long))
            found[i : i + 1], value[i : i + 1] = _top(
                row, stretch.a[own] / long, stretch.starts[own : own + 1], part[i : i + 1], step[i : i + 1], long
            )
        if len(some) and not stretch.uneven:
            a = stretch.a / wide(stretch.length)
            row = machine.row(reading, a / wide(machine.rate))
            found[some], value[some] = _top(row, a, stretch.starts[which], part[some], step[some], length)
        begun += stretch.count
    a, left = machine.onward(machine.left)
    some = np.flatnonzero(segment >= begun)
    if len(some):
        start, row = np.broadcast_to(left, (len(some), len(left))), machine.row(reading, a)
        found[some], value[some] = _top(row, a * machine.rate, start, part[some], step[some], np.inf)
    return found, value


def _top(
    row: Numbers, a: Numbers, starts: Numbers, part: FloatArray, step: FloatArray, length: FloatArray | float
) -> tuple[FloatArray, FloatArray]:
    """Where |row . z|, z' = a z from starts (n, N), is greatest within a step of so many seconds, and its value."""
    longest = float(part.max(initial=0.0)) or 1.0
    term = (exponentials(a * longest, part / longest) @ starts[..., None])[..., 0]
    series = np.empty((_TERMS, len(part)))
    for k in range(_TERMS):
        series[k] = term @ row
        term = term @ a.T * step[:, None] / (k + 1)
    slopes, bends = (polynomial.polyder(series, m) for m in (1, 2))
    off, low, high = np.zeros(len(part)), np.maximum(-part / step, -1.0), np.minimum((length - part) / step, 1.0)
    for _ in range(_STEPS):
        value, rising, bend = (polynomial.polyval(off, one, tensor=False) for one in (series, slopes, bends))
        with np.errstate(divide="ignore", invalid="ignore"):
            newton = np.where(bend * value < 0.0, -rising / bend, np.sign(rising * value))
        before, off = off, np.clip(off + np.clip(newton, -1.0, 1.0), low, high)
        if (np.abs(off - before) <= _CLOSE).all():
            break
    return part + step * off, np.asarray(polynomial.polyval(off, series, tensor=False))
