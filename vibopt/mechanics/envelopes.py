"""Greatest modulus of a complex function of time that beats: Chebyshev polynomials on panels, those of promise first.

The function is driven, smooth but for resonances, and rings, with a bound that never rises.  A panel is left out where
what drives and the bound of what rings say that nothing on it is greater than what was found; it is halved until the
last coefficients of the whole, and its value at one more point, say that nothing is left over.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial import chebyshev

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.records import dataclass

_DEGREE, _FINE = 16, 65
_NODES = 0.5 - 0.5 * np.cos(np.pi * np.arange(_DEGREE + 1) / _DEGREE)
_ODD = 0.3717
"""One more point of a panel, to see what would hide between the nodes."""
_POINTS = np.append(_NODES, _ODD)
_GRID = np.linspace(-1.0, 1.0, _FINE)
_INTO = np.linalg.inv(chebyshev.chebvander(2.0 * _NODES - 1.0, _DEGREE)).T
_SEEN = chebyshev.chebvander(_GRID, _DEGREE).T
_AT_ODD = chebyshev.chebvander(np.array([2.0 * _ODD - 1.0]), _DEGREE)[0]
_RESOLVED, _SURE, _SHAPED = 1e-12, 1e-13, 1e-3
"""Part of the greatest value that may be left over on a panel; rounding; and left over where a bound is read."""
_NOISE = 2e-16
"""Rounding of a value, for each radian that it has turned."""
_APART = 2.0
"""How far a function turns on a panel at the beginning [rad]."""
_FIRST, _AT_FIRST, _AT_ONCE, _ALL_AT_ONCE, _MOST, _NEWTON = 32, 32, 128, 2048, 150_000, 5
"""Panels at the beginning at most, and looked at together at first, then at least and at most, and in all; steps of
Newton's method."""


@dataclass(frozen=True, slots=True)
class Found:
    """Greatest modulus, on which stretch and when; `open` where panels were left that may hold more."""

    value: float
    number: int
    at: float
    open: bool = False


@dataclass(frozen=True, slots=True)
class Envelope:
    """A complex function of time on stretches, each with its own time, the sum of two.

    driven, ringing
        On the stretches of these numbers, (n,), at times (n,) [s].
    bound, fading
        Of the modulus of the whole, and of what rings, on panels of a stretch from `low` to `high`, (n,) each.
    fast
        About the fastest rate at which it turns on each stretch, (n_stretches,) [rad/s].
    """

    driven: Callable[[IntArray, FloatArray], ComplexArray]
    ringing: Callable[[IntArray, FloatArray], ComplexArray]
    bound: Callable[[IntArray, FloatArray, FloatArray], FloatArray]
    fading: Callable[[IntArray, FloatArray, FloatArray], FloatArray]
    fast: FloatArray


def greatest(envelope: Envelope, low: FloatArray, high: FloatArray, least: float = 0.0) -> Found | None:
    """Greatest modulus from `low` to `high` on any stretch, (n_stretches,) each; None where it is not above `least`."""
    search, seen, noise = _Search(least), 0, _NOISE * np.maximum(1.0, envelope.fast * high)
    shares = np.clip(envelope.fast * (high - low) / _APART, 1.0, max(1, _FIRST // len(low))).astype(int)
    which = np.repeat(np.arange(len(low)), shares)
    within = np.arange(len(which)) - np.repeat(np.cumsum(shares) - shares, shares)
    part = (high - low)[which] / shares[which]
    begin = low[which] + within * part
    end = np.where(within + 1 == shares[which], high[which], begin + part)
    most = envelope.bound(which, begin, end)
    shortest = (high - low) * 2.0**-50
    while True:
        order = np.argsort(-most, kind="stable")
        order = order[: int((most > search.most * (1.0 + _SURE)).sum())]
        which, begin, end, most = which[order], begin[order], end[order], most[order]
        if not len(begin) or seen > _MOST:
            break
        count = min(max(_AT_ONCE, len(begin) // 2), _ALL_AT_ONCE) if seen else min(_AT_FIRST, len(begin))
        now, later = slice(0, count), slice(count, None)
        own, left, right, bound = _looked(envelope, search, (which[now], begin[now], end[now]), (shortest, noise))
        seen += count
        middle, own = 0.5 * (left + right), np.tile(own, 2)
        fresh = np.concatenate([left, middle]), np.concatenate([middle, right])
        bound = np.minimum(envelope.bound(own, *fresh), np.tile(bound, 2))
        which = np.concatenate([own, which[later]])
        begin, end = (np.concatenate([new, old[later]]) for new, old in zip(fresh, (begin, end), strict=True))
        most = np.concatenate([bound, most[later]])
    return Found(search.most, search.number, search.time, bool(len(begin))) if search.time >= 0.0 else None


def _looked(
    envelope: Envelope,
    search: _Search,
    panels: tuple[IntArray, FloatArray, FloatArray],
    least: tuple[FloatArray, FloatArray],
) -> tuple[IntArray, FloatArray, FloatArray, FloatArray]:
    """Panels that are to be halved after a look at them, with their bounds.

    `panels` are the stretch of each, its begin and its end.  `least` is for each stretch the shortest that is halved
    [s], and the part of a bound that rounding may be.
    """
    (which, begin, end), (shortest, noise) = panels, least
    times = begin[:, None] + (end - begin)[:, None] * _POINTS
    driven = envelope.driven(np.repeat(which, len(_POINTS)), times.ravel()).reshape(times.shape)
    coefficients = driven[:, :-1] @ _INTO
    shaped = _left_over(coefficients, driven) <= _SHAPED * search.most
    bound = np.full(len(begin), np.inf)
    tops = np.abs(coefficients[shaped] @ _SEEN).max(axis=1, initial=0.0)
    bound[shaped] = (
        tops * (1.0 + _SHAPED)
        + 20.0 * _SHAPED * search.most
        + envelope.fading(which[shaped], begin[shaped], end[shaped])
    )
    bound = np.minimum(bound, envelope.bound(which, begin, end))
    hope = bound > search.most * (1.0 + _SURE)
    which, begin, end, times, driven, bound = (one[hope] for one in (which, begin, end, times, driven, bound))
    values = driven + envelope.ringing(np.repeat(which, len(_POINTS)), times.ravel()).reshape(times.shape)
    search.nodes(values, times, which)
    coefficients = values[:, :-1] @ _INTO
    room = _RESOLVED * search.most + noise[which] * envelope.bound(which, begin, end)
    done = (_left_over(coefficients, values) <= room) | (end - begin <= shortest[which])
    search.panels(coefficients[done], which[done], begin[done], end[done])
    return which[~done], begin[~done], end[~done], bound[~done]


def _left_over(coefficients: ComplexArray, values: ComplexArray) -> FloatArray:
    """What polynomials (n, 17) leave over of values (n, 18)."""
    off = 0.25 * np.abs(coefficients @ _AT_ODD - values[:, -1])
    return np.asarray(np.maximum(np.abs(coefficients[:, -3:]).max(axis=1, initial=0.0), off))


class _Search:
    """The greatest modulus seen so far."""

    def __init__(self, least: float) -> None:
        self.most, self.number, self.time = least, 0, -1.0

    def nodes(self, values: ComplexArray, times: FloatArray, which: IntArray) -> None:
        """Values at times, both (n, 18), on stretches (n,)."""
        if values.size:
            at = np.unravel_index(int(np.abs(values).argmax()), values.shape)
            self._say(float(np.abs(values[at])), int(which[at[0]]), float(times[at]))

    def panels(self, coefficients: ComplexArray, which: IntArray, begin: FloatArray, end: FloatArray) -> None:
        """Polynomials on panels, (n, 17): tops between fine points, by Newton's method."""
        fine = np.abs(coefficients @ _SEEN)
        beside = np.pad(fine, ((0, 0), (1, 1)), constant_values=-1.0)
        tops = (fine >= beside[:, :-2]) & (fine >= beside[:, 2:]) & (fine >= 0.99 * self.most)
        panel, cell = np.nonzero(tops)
        if not len(panel):
            return
        own, at, step = coefficients[panel].T, _GRID[cell], _GRID[1] - _GRID[0]
        slope, bend = chebyshev.chebder(own), chebyshev.chebder(own, 2)
        low, high = np.maximum(at - step, -1.0), np.minimum(at + step, 1.0)
        for _ in range(_NEWTON):
            p, dp, ddp = (chebyshev.chebval(at, one, tensor=False) for one in (own, slope, bend))
            first, second = (p.conj() * dp).real, (dp.conj() * dp + p.conj() * ddp).real
            at = np.clip(at - np.where(second < 0.0, first / np.where(second < 0.0, second, 1.0), 0.0), low, high)
        values = np.abs(chebyshev.chebval(at, own, tensor=False))
        best = int(values.argmax())
        top = panel[best]
        time = begin[top] + 0.5 * (1.0 + at[best]) * (end[top] - begin[top])
        self._say(float(values[best]), int(which[top]), float(time))

    def _say(self, value: float, number: int, at: float) -> None:
        if value > self.most:
            self.most, self.number, self.time = value, number, at
