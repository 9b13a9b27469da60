"""Exact extremes of a response over a band of speeds.

The response is analytic away from the poles, so the band is cut into intervals that are short
against the distance to the nearest pole; on each, a Chebyshev interpolant resolves every extreme,
and the best ones are polished on the response itself.  A pole on the real axis inside the band
means an infinite amplitude.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import islice
from math import isfinite
from operator import itemgetter
from typing import Any

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray
from vibopt.mechanics.combine import Extreme, foremost
from vibopt.signals import Band

_DEGREE = 10
_NODES = np.cos(np.pi * (np.arange(_DEGREE + 1)) / _DEGREE)[::-1]


def _chebyshev(t: FloatArray) -> FloatArray:
    """Chebyshev polynomials at some places, shape (len(t), _DEGREE + 1)."""
    columns = [np.ones(len(t)), t]
    while len(columns) <= _DEGREE:
        columns.append(2.0 * t * columns[-1] - columns[-2])
    return np.stack(columns, axis=1)


_TO_NODES = _chebyshev(_NODES)
_TO_COEFFICIENTS = np.linalg.inv(_TO_NODES)
_FINE = np.linspace(-1.0, 1.0, 41)
_ENDS = np.array([[-((-1.0) ** n) * n**2, float(n**2)] for n in range(_DEGREE + 1)]).T @ _TO_COEFFICIENTS
"""Slopes at both ends of an interval from the values at its nodes."""
_TO_FINE = _chebyshev(_FINE) @ _TO_COEFFICIENTS
_REACH = 0.35
_FINEST = 1e-9
_REAL = 4e-16
_CLOSE = 1e-3
_EVEN, _TWICE, _NOISE = 0.2, 2, 10.0
"""Part of the last coefficients that both halves keep of rounding, how often in turn, and what of others it covers."""
_NO_SCALE = 1e-300
_LEVEL = 1e-6
_STEP = float(_FINE[1] - _FINE[0])
_FIVE = np.array([-1.0, -0.5, 0.0, 0.5, 1.0])
_SLOPE, _BEND = _FIVE / 2.5, (_FIVE**2 - 0.5) / 0.4375
"""Slope and bend, in steps, of the parabola that fits five values best."""

_OFFS = (1e-12, 1e-11, 1e-10, 1e-9, 1e-7, 1e-6)
"""Parts of a speed by which one looks beside a pole on the axis: what is hardly coupled is seen from near alone."""

Response = Callable[[FloatArray], FloatArray]
Place = tuple[float, float]
"""Value and speed, as an `Extreme` has them."""


def greatest(response: Response, bands: tuple[Band, ...], poles: ComplexArray, breaks: FloatArray) -> Extreme:
    """The greatest value over all bands, and where.

    Parameters
    ----------
    response
        Non-negative modulus at speeds of any shape [rad/s]; may be inf at a pole.
    bands
        Closed intervals or single speeds.
    poles
        Complex speeds at which the response is singular [rad/s].
    breaks
        Speeds at which the response is not smooth.
    """
    return _best(_candidates(response, bands, poles, breaks, least=False), least=False)


def least(response: Response, bands: tuple[Band, ...], poles: ComplexArray, breaks: FloatArray) -> Extreme:
    """The least value over all bands, and where; parameters as for `greatest`."""
    return _best(_candidates(response, bands, poles, breaks, least=True), least=True)


def peaks(
    response: Response, bands: tuple[Band, ...], poles: ComplexArray, breaks: FloatArray, *, within: float
) -> list[Extreme]:
    """Local maxima and band ends no lower than `within` times the greatest, highest first."""
    found = _candidates(response, bands, poles, breaks, least=False, keep=within)
    top = _best(found, least=False).value
    chosen = [Extreme(value, speed) for value, speed in found if value >= within * top]
    return sorted(chosen, key=lambda one: -one.value)


def _best(found: list[Place], *, least: bool) -> Extreme:
    """The extreme; of speeds at which it is the same the lowest."""
    ordered = sorted(found, key=itemgetter(1)) if len(found) > 1 else found
    return Extreme(*ordered[foremost([value for value, _ in ordered], least=least)])


def _candidates(
    response: Response,
    bands: tuple[Band, ...],
    poles: ComplexArray,
    breaks: FloatArray,
    *,
    least: bool,
    keep: float = 1.0 - _CLOSE,
) -> list[Place]:
    ranges = [band for band in bands if not band.is_point]
    points = [end for band in bands for end in ((band.low,) if band.is_point else (band.low, band.high))]
    real = [_undamped(band, poles) for band in ranges]
    beside = [speed * (1.0 + off) for own in real for speed in own for off in _OFFS]
    values = response(np.array(points + beside)).tolist()
    found: list[Place] = list(zip(values, points, strict=False))
    near = iter(values[len(points) :])
    for band, own in zip(ranges, real, strict=True):
        infinite = [(np.inf, speed) for speed in own if _endless(*islice(near, len(_OFFS)))]
        found += infinite
        if least or not infinite:
            found += _inside(response, band, poles, breaks, least=least, keep=keep)
    return found


def _undamped(band: Band, poles: ComplexArray) -> list[float]:
    """Poles on the real axis in the band."""
    known = poles.tolist()
    size = max((abs(one) for one in known), default=0.0)
    low, high = band.low * (1 - 1e-12), band.high * (1 + 1e-12)
    return [one.real for one in known if abs(one.imag) <= _REAL * size and low <= one.real <= high and one.real > 0]


def _endless(*beside: float) -> bool:
    """Whether a response grows without limit where it has these values at `_OFFS` beside a pole."""
    pairs = zip(beside[::2], beside[1::2], strict=True)
    return any(near > 5.0 * far or not isfinite(near) for near, far in pairs)


def _inside(
    response: Response, band: Band, poles: ComplexArray, breaks: FloatArray, *, least: bool, keep: float
) -> list[Place]:
    sign = -1.0 if least else 1.0
    low, high, squares = _resolved(response, *_intervals(band, poles, breaks), _NO_SCALE if least else 0.0)
    if not len(low):
        return []
    centre, half = 0.5 * (low + high), 0.5 * (high - low)
    fine = sign * (squares @ _TO_FINE.T)
    outward = sign * (squares @ _ENDS.T) * np.array([1.0, -1.0]) < -_LEVEL * np.abs(fine).max(axis=1, keepdims=True)
    known = outward & np.column_stack([low == band.low, high == band.high])
    top = -float(squares.min()) if least else float(fine.max())  # beside a pole the interpolant falls below zero
    return _polish_all(response, centre, half, fine, top, sign, keep, _smooth(band, breaks), known)


def _resolved(
    response: Response, low: FloatArray, high: FloatArray, scale: float = 0.0
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Halve intervals until the interpolant of each is good, and its squared values; drop those that end on a pole.

    `scale` is the squared value that matters; 0 takes the greatest one met, `_NO_SCALE` counts each by its own.  Where
    twice in turn both halves are as rough as the whole it is rounding, and the interpolant is left without it.
    """
    kept, top = list[tuple[FloatArray, FloatArray, FloatArray]](), 0.0
    before, evenly = np.full(len(low), np.inf), np.zeros(len(low), dtype=int)
    for rounds in range(13):
        centre, half = 0.5 * (low + high), 0.5 * (high - low)
        squares = response(centre[:, None] + half[:, None] * _NODES) ** 2
        rough = np.zeros(len(low), dtype=bool)
        if rounds < 12:
            sound: BoolArray = np.asarray(np.isfinite(squares).all(axis=1))
            top = max(top, float(squares[sound].max(initial=0.0)))
            coefficients = np.where(sound[:, None], squares, 0.0) @ _TO_COEFFICIENTS.T
            rough, tail = _unresolved(coefficients, scale or top)
            if rounds:  # the halves of each interval stand in two rows
                even = (tail.reshape(2, -1).min(axis=0) > _EVEN * before) & sound.reshape(2, -1).all(axis=0)
                evenly = np.tile(np.where(even, evenly + 1, 0), 2)
            noisy = rough & (evenly >= _TWICE)
            plain = np.where(np.abs(coefficients) > _NOISE * tail[:, None], coefficients, 0.0)
            squares[noisy] = plain[noisy] @ _TO_NODES.T
            rough &= sound & ~noisy & (high - low > _FINEST * high)
            kept.append((low[sound & ~rough], high[sound & ~rough], squares[sound & ~rough]))
        else:
            kept.append((low, high, squares))
        if not rough.any():
            break
        before, evenly = tail[rough], evenly[rough]
        low, high = np.concatenate([low[rough], centre[rough]]), np.concatenate([centre[rough], high[rough]])
    found: list[FloatArray] = [np.concatenate(each) for each in zip(*kept, strict=True)]
    return found[0], found[1], found[2]


def _unresolved(coefficients: FloatArray, scale: float) -> tuple[BoolArray, FloatArray]:
    """Intervals whose last Chebyshev coefficients have not died away, and how great these are."""
    sizes = np.abs(coefficients)
    tail = sizes[:, -2:].max(axis=1)
    rough: BoolArray = (tail > 1e-7 * sizes.max(axis=1)) & (tail > 1e-9 * scale)
    return rough, tail


def _polish_all(
    response: Response,
    centre: FloatArray,
    half: FloatArray,
    fine: FloatArray,
    top: float,
    sign: float,
    keep: float,
    edges: FloatArray,
    known: BoolArray,
) -> list[Place]:
    """Local extremes of the fine values that may be the best, refined on the response itself.

    A peak may lie across the end of its interval, so only `edges`, where the response is not smooth, bound it.
    `top` is the best square so far, times `sign`; `known` ends (n_intervals, 2) are those of the band from which the
    response falls: measured already.
    """
    inner = np.zeros(fine.shape, dtype=bool)
    inner[:, 1:-1] = (fine[:, 1:-1] >= fine[:, :-2]) & (fine[:, 1:-1] >= fine[:, 2:])
    inner[:, 0] = (fine[:, 0] >= fine[:, 1]) & ~known[:, 0]
    inner[:, -1] = (fine[:, -1] >= fine[:, -2]) & ~known[:, 1]
    room = _CLOSE * abs(top)
    threshold: Any = top * keep**2 - room
    if sign < 0:  # a zero between two fine places stands out of its interval by less
        threshold = 4.0 * top - _CLOSE * np.abs(fine).max(axis=1, keepdims=True)
    rows, columns = np.nonzero(inner & (fine >= threshold))
    if not len(rows):
        return []
    piece = np.clip(np.searchsorted(edges, centre[rows], side="right"), 1, len(edges) - 1)
    low, high = edges[piece - 1], edges[piece]
    speeds = _polish(response, centre[rows] + half[rows] * _FINE[columns], _STEP * half[rows], low, high, sign)
    return list(zip(response(speeds).tolist(), speeds.tolist(), strict=True))


def _smooth(band: Band, breaks: FloatArray) -> FloatArray:
    """Ends of the band and the breaks inside it, ascending."""
    inside = breaks[(breaks > band.low) & (breaks < band.high)]
    return _ascending(band.low, band.high, *inside.tolist())


def _ascending(*speeds: float) -> FloatArray:
    """Each speed once, in rising order."""
    return np.array(sorted(set(speeds)))


def _polish(
    response: Response, speeds: FloatArray, step: FloatArray, low: FloatArray, high: FloatArray, sign: float
) -> FloatArray:
    """Vertex of a parabola through five points around each speed, three times with smaller steps."""
    for _ in range(4):
        room = np.minimum(step, 0.5 * (high - low))
        speeds = np.clip(speeds, low + room, high - room)
        points = np.clip(speeds[:, None] + step[:, None] * _FIVE, low[:, None], high[:, None])
        squares = sign * response(points) ** 2
        best = squares.argmax(axis=1)
        rows = np.arange(len(speeds))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            first = squares @ _SLOPE
            second = squares @ _BEND
            vertex = speeds - step * np.where(second < 0.0, first / np.where(second < 0.0, second, 1.0), 0.0)
        regular = (
            (np.abs(vertex - speeds) <= 2.0 * step) & (points[:, 0] < points[:, 1]) & (points[:, 3] < points[:, 4])
        )
        good = regular & (second < 0.0)
        speeds = np.where(good, vertex, points[rows, best])
        step = np.where(good, step / 25.0, step / 2.0)
    return np.clip(speeds, low, high)


def _intervals(band: Band, poles: ComplexArray, breaks: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Cut the band so that each half-width is at most `_REACH` of the distance to the nearest pole."""
    inside = breaks[(breaks > band.low) & (breaks < band.high)]
    real = np.abs(poles.real)
    turning = real[(real > band.low) & (real < band.high)]
    edges = _ascending(band.low, band.high, *inside.tolist(), *turning.tolist())
    low, high = edges[:-1], edges[1:]
    done_low: list[FloatArray] = []
    done_high: list[FloatArray] = []
    smallest = 1e-14 * band.high
    for _ in range(200):
        centre, half = 0.5 * (low + high), 0.5 * (high - low)
        distance = np.abs(centre[:, None] - poles[None, :]).min(axis=1, initial=np.inf)
        good = (half <= _REACH * distance) | (half <= smallest)
        done_low.append(low[good])
        done_high.append(high[good])
        if good.all():
            break
        left, right, middle = low[~good], high[~good], centre[~good]
        low, high = np.concatenate([left, middle]), np.concatenate([middle, right])
    return np.concatenate(done_low), np.concatenate(done_high)


def crossings(response: Response, band: Band, poles: ComplexArray, breaks: FloatArray, level: float) -> list[float]:
    """Every speed in the band at which the response crosses `level`, ascending [rad/s]."""
    low, high = _near_level(response, *_intervals(band, poles, breaks), level)
    low, high, _ = _resolved(response, low, high, level**2)
    low, high = _near_level(response, low, high, level)
    centre, half = 0.5 * (low + high), 0.5 * (high - low)
    squares = response(centre[:, None] + half[:, None] * _NODES) ** 2 - level**2
    found = [
        middle + size * t
        for middle, size, row in zip(centre, half, squares, strict=True)
        if np.isfinite(row).all()
        for t in _sign_changes(row)
    ]
    return sorted({_secant(response, speed, band, level) for speed in found})


def _near_level(response: Response, low: FloatArray, high: FloatArray, level: float) -> tuple[FloatArray, FloatArray]:
    """Intervals on which the response comes near the level; between poles it cannot leap over a factor of four."""
    centre, half = 0.5 * (low + high), 0.5 * (high - low)
    squares = response(centre[:, None] + half[:, None] * _NODES) ** 2
    near = (squares.min(axis=1) <= 16.0 * level**2) & (squares.max(axis=1) >= level**2 / 16.0)
    return low[near], high[near]


def _sign_changes(values: FloatArray) -> list[float]:
    """Roots in [-1, 1] of the interpolant of values at the nodes, with a change of sign."""
    coefficients = _TO_COEFFICIENTS @ values
    size = np.abs(coefficients).max()
    if size == 0.0 or np.abs(coefficients[0]) > np.abs(coefficients[1:]).sum():
        return []
    trimmed = np.trim_zeros(np.where(np.abs(coefficients) > 1e-15 * size, coefficients, 0.0), "b")
    if len(trimmed) < 2:
        return []
    roots = np.polynomial.chebyshev.chebroots(trimmed)
    real = roots[np.abs(roots.imag) <= 1e-7].real
    return [float(t) for t in real if -1.0 - 1e-9 <= t <= 1.0 + 1e-9]


def _secant(response: Response, speed: float, band: Band, level: float) -> float:
    """A crossing refined on the response itself."""
    step = 1e-6 * max(speed, 1e-6 * band.high)
    for _ in range(8):
        a, b, c = response(np.clip(np.array([speed - step, speed, speed + step]), band.low, band.high)) ** 2 - level**2
        slope = (c - a) / (min(speed + step, band.high) - max(speed - step, band.low))
        if not np.isfinite(slope) or slope == 0.0:
            break
        move = float(np.clip(-b / slope, -1e-3 * band.high, 1e-3 * band.high))
        speed = min(max(speed + move, band.low), band.high)
        if abs(move) <= 1e-15 * band.high:
            break
        step = max(min(step, 10.0 * abs(move)), 1e-9 * max(speed, 1e-6 * band.high))
    return float(speed)
