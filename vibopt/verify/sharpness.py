"""Amplification factors of the machine as built: peaks between even speeds and beside its poles, then their flanks."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.signals import Band

_EVEN, _WIDE, _SURE, _EDGE = 300, np.linspace(-3.0, 3.0, 49), 1e6, 1e-6
_FLANK, _MOST = np.unique(np.concatenate([np.geomspace(1e-7, 1.0, 125), np.linspace(1e-3, 1.0, 240)])), 0.5
"""Even speeds of a band; widths of a pole beside it; factor that stands for no damping at all; part of
a speed within which a peak beside an end of a band is at that end, or a pole at standstill; parts of a speed that are
looked at on either side, and the greatest that counts."""


def sharpest(
    size: Callable[[FloatArray], FloatArray], bands: tuple[Band, ...], poles: ComplexArray, known: tuple[float, float]
) -> tuple[float, float]:
    """Greatest factor of all peaks inside bands and its speed [rad/s]; 0 at the beginning of the first of none."""
    found = [(0.0, bands[0].low)]
    for band in bands:
        near = [pole for pole in poles if max(band.low, _EDGE * abs(pole)) < pole.real < band.high]
        inside = band.low * (1.0 + _EDGE), band.high * (1.0 - _EDGE)
        around = [one.real + max(abs(one.imag), 1e-9 * abs(one)) * _WIDE for one in near]
        speeds = np.unique(np.concatenate([np.linspace(band.low, band.high, _EVEN), inside, *around]))
        speeds = speeds[(speeds >= band.low) & (speeds <= band.high)]
        values = size(speeds)
        for k in np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] >= values[2:])) + 1:
            speed, top = _top(size, float(speeds[k - 1]), float(speeds[k + 1]))
            if inside[0] < speed < inside[1]:
                found.append((_sharpness(size, speed, top, known, poles.real), speed))
    return max(found)


def _top(size: Callable[[FloatArray], FloatArray], low: float, high: float) -> tuple[float, float]:
    """Where a response with one top between two speeds has it, and how high it is: by fifths, taken anew."""
    for _ in range(60):
        speeds = np.linspace(low, high, 9)
        values = size(speeds)
        k = int(np.clip(values.argmax(), 1, 7))
        low, high = float(speeds[k - 1]), float(speeds[k + 1])
        if high - low <= 1e-9 * high:
            break
    return 0.5 * (low + high), float(size(np.array([0.5 * (low + high)]))[0])


def _sharpness(
    size: Callable[[FloatArray], FloatArray], speed: float, top: float, known: tuple[float, float], poles: FloatArray
) -> float:
    """Speed over the width at 1/sqrt(2) of the top; of a flank that rises above it first the other one counts twice."""
    from scipy.optimize import brentq

    level, widths = top / np.sqrt(2.0), []
    for sense in (1.0, -1.0):
        parts = np.sort(np.concatenate([_FLANK, sense * (poles / speed - 1.0)]))
        at = speed * (1.0 + sense * parts[(parts >= _FLANK[0]) & (parts <= 1.0)])
        at = at[at > 0.0]  # nothing is driven at rest
        inside = (at >= known[0]) & (at <= known[1])
        values = size(at[inside])
        over, under = values > top * (1.0 + 1e-9), values <= level
        first = int(under.argmax()) if under.any() else len(values)
        if over[:first].any() or (not under.any() and not inside.all()):
            continue
        if not under.any():
            widths.append(_MOST * speed)
            continue
        ends = (speed if first == 0 else float(at[inside][first - 1])), float(at[inside][first])
        where = brentq(lambda one: float(size(np.array([one]))[0]) - level, *ends, xtol=1e-13 * speed, rtol=1e-14)
        widths.append(min(abs(float(where) - speed), _MOST * speed))
    if not widths:
        return 1.0
    factor = speed / (2.0 * float(np.mean(widths)))
    return factor if factor < _SURE else float("inf")
