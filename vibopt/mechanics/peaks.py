"""Exact extremes of a response over a band of speeds.

The response is analytic away from the poles, so the band is cut into intervals that are short
against the distance to the nearest pole; on each, a Chebyshev interpolant resolves every extreme,
and the best ones are polished on the response itself.  A pole on the real axis inside the band
means an infinite amplitude.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vibopt.forms import Band, ComplexArray, FloatArray

_DEGREE = 10
_NODES = np.cos(np.pi * (np.arange(_DEGREE + 1)) / _DEGREE)[::-1]
_TO_COEFFICIENTS = np.linalg.inv(np.polynomial.chebyshev.chebvander(_NODES, _DEGREE))
_FINE = np.linspace(-1.0, 1.0, 41)
_TO_FINE = np.polynomial.chebyshev.chebvander(_FINE, _DEGREE) @ _TO_COEFFICIENTS
_REACH = 0.35
_REAL = 4e-16
_CLOSE = 1e-5
_GOLD = (np.sqrt(5.0) - 1.0) / 2.0

Response = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True, slots=True)
class Extreme:
    """Value of a response and the speed [rad/s] at which it is reached."""

    value: float
    speed: float


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
    chosen = [one for one in found if one.value >= within * top]
    return sorted(chosen, key=lambda one: -one.value)


def _best(found: list[Extreme], *, least: bool) -> Extreme:
    return min(found, key=lambda one: one.value) if least else max(found, key=lambda one: one.value)


def _candidates(
    response: Response,
    bands: tuple[Band, ...],
    poles: ComplexArray,
    breaks: FloatArray,
    *,
    least: bool,
    keep: float = 1.0 - _CLOSE,
) -> list[Extreme]:
    points = np.array([band.low for band in bands] + [band.high for band in bands])
    found = [Extreme(float(v), float(s)) for v, s in zip(response(points), points, strict=True)]
    for band in bands:
        if not band.is_point:
            infinite = _infinite(response, band, poles)
            found += infinite
            if infinite and not least:
                continue
            found += _inside(response, band, poles, breaks, least=least, keep=keep)
    return found


def _infinite(response: Response, band: Band, poles: ComplexArray) -> list[Extreme]:
    """Poles on the real axis in the band whose response really grows without limit."""
    size = np.abs(poles).max(initial=0.0)
    real = poles[np.abs(poles.imag) <= _REAL * size].real
    real = real[(real >= band.low * (1 - 1e-12)) & (real <= band.high * (1 + 1e-12)) & (real > 0)]
    found = []
    for speed in real:
        near, far = response(speed * (1.0 + np.array([1e-7, 1e-6])))
        if near > 5.0 * far or not np.isfinite(near):
            found.append(Extreme(np.inf, float(speed)))
    return found


def _inside(
    response: Response, band: Band, poles: ComplexArray, breaks: FloatArray, *, least: bool, keep: float
) -> list[Extreme]:
    sign = -1.0 if least else 1.0
    low, high = _intervals(band, poles, breaks)
    for _ in range(12):
        centre, half = 0.5 * (low + high), 0.5 * (high - low)
        squares = response(centre[:, None] + half[:, None] * _NODES) ** 2
        sound = np.isfinite(squares).all(axis=1)
        low, high, centre, squares = low[sound], high[sound], centre[sound], squares[sound]
        rough = _unresolved(squares)
        if not rough.any():
            break
        middle = centre[rough]
        low, high = (
            np.concatenate([low[~rough], low[rough], middle]),
            np.concatenate([high[~rough], middle, high[rough]]),
        )
    if not len(low):
        return []
    centre, half = 0.5 * (low + high), 0.5 * (high - low)
    squares = response(centre[:, None] + half[:, None] * _NODES) ** 2
    fine = sign * (squares @ _TO_FINE.T)
    return _polish_all(response, centre, half, fine, sign, keep)


def _unresolved(squares: FloatArray) -> FloatArray:
    """Intervals whose last Chebyshev coefficients have not died away."""
    coefficients = np.abs(squares @ _TO_COEFFICIENTS.T)
    tail = coefficients[:, -2:].max(axis=1)
    rough: FloatArray = (tail > 1e-7 * coefficients.max(axis=1)) & (tail > 1e-9 * np.max(squares))
    return rough


def _polish_all(
    response: Response, centre: FloatArray, half: FloatArray, fine: FloatArray, sign: float, keep: float
) -> list[Extreme]:
    """Local extremes of the fine values that may be the best, refined on the response itself."""
    inner = np.zeros(fine.shape, dtype=bool)
    inner[:, 1:-1] = (fine[:, 1:-1] >= fine[:, :-2]) & (fine[:, 1:-1] >= fine[:, 2:])
    inner[:, 0] = fine[:, 0] >= fine[:, 1]
    inner[:, -1] = fine[:, -1] >= fine[:, -2]
    top = float(fine.max())
    room = _CLOSE * max(abs(top), 0.0)
    threshold = top * keep**2 - room if sign > 0 else top - room - 1e-6 * float(np.abs(fine).max())
    rows, columns = np.nonzero(inner & (fine >= threshold))
    step = _FINE[1] - _FINE[0]
    start = np.maximum(_FINE[columns] - step, -1.0)
    stop = np.minimum(_FINE[columns] + step, 1.0)
    low = centre[rows] + half[rows] * start
    high = centre[rows] + half[rows] * stop
    speeds = _golden(response, low, high, sign)
    return [Extreme(float(v), float(s)) for v, s in zip(response(speeds), speeds, strict=True)]


def _golden(response: Response, low: FloatArray, high: FloatArray, sign: float) -> FloatArray:
    """Golden section on many brackets at once, then one parabola; shape of `low`."""
    low, high = low.copy(), high.copy()
    for _ in range(34):
        span = high - low
        left, right = high - _GOLD * span, low + _GOLD * span
        better = sign * response(left) > sign * response(right)
        high = np.where(better, right, high)
        low = np.where(better, low, left)
        if np.all(high - low <= 1e-8 * high):
            break
    middle: FloatArray = 0.5 * (low + high)
    return middle


def _intervals(band: Band, poles: ComplexArray, breaks: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Cut the band so that each half-width is at most `_REACH` of the distance to the nearest pole."""
    inside = breaks[(breaks > band.low) & (breaks < band.high)]
    real = np.abs(poles.real)
    turning = real[(real > band.low) & (real < band.high)]
    edges = np.unique(np.concatenate([[band.low, band.high], inside, turning]))
    low, high = edges[:-1], edges[1:]
    done_low: list[FloatArray] = []
    done_high: list[FloatArray] = []
    smallest = 1e-14 * band.high
    for _ in range(200):
        centre, half = 0.5 * (low + high), 0.5 * (high - low)
        if len(poles):
            distance = np.abs(centre[:, None] - poles[None, :]).min(axis=1)
        else:
            distance = np.full(len(centre), np.inf)
        good = (half <= _REACH * distance) | (half <= smallest)
        done_low.append(low[good])
        done_high.append(high[good])
        if good.all():
            break
        left, right, middle = low[~good], high[~good], centre[~good]
        low, high = np.concatenate([left, middle]), np.concatenate([middle, right])
    return np.concatenate(done_low), np.concatenate(done_high)
