"""The greatest and the least of a response over bands of speeds, found by sampling, halving and closing in.

The second route's own search: it knows the response as a number at a speed, and the poles only as places near which to
look closely.  A stretch whose middle is not where its four nearest samples say is halved until it is; every top is
then held between two lower samples, and these are brought together.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise
from math import isfinite
from typing import Any

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray
from vibopt.records import dataclass
from vibopt.signals import Band

_APART = 0.5
"""Of two first samples, over the distance of the nearest pole."""
_SHARP = 1e-9
"""Distance of a pole from the axis below which it is looked at as if it were there, over the highest speed."""
_UNDAMPED = 4e-16
"""Part of the greatest pole by which one may lie off the axis without any damping: rounding."""
_FITS = 0.01
"""Part of the greatest, or for a least of its neighbourhood, by which a middle may be off what its neighbours say."""
_HALVINGS, _CLOSINGS, _MOST, _BLOCK = 40, 60, 200_000, 64
_HOPE = 0.9
"""Part of the greatest sample that a sample must have, squared, to be near the greatest of all."""
_EVEN, _FLAT = 1e-11, 1e-13
"""Part by which equals may differ; part of a top by which its neighbours may be lower when it is held well enough."""
_EDGE = 1e-4
"""Part of the first stretch, and of the last, by which a slope at an end is told."""
_BETWEEN = tuple((part / 24.0) ** 2 for part in range(1, 24))
"""Parts of a band at which nothing may be worse than where all turns are known."""

_BESIDE = 1.0 + 1e-7, 1.0 + 1e-6
"""Where a pole without damping is looked at, as parts of it."""

Shape = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True, slots=True)
class Reached:
    """Value of a response and the speed at which it is reached [rad/s]."""

    value: float
    speed: float


@dataclass(frozen=True, slots=True)
class Search:
    """Of the greatest value, or of the least.

    response
        Non-negative, at speeds (n,) [rad/s]; inf where it has no end.
    poles
        Complex speeds at which it is singular [rad/s].
    breaks
        Speeds at which it is not smooth [rad/s].
    least
        Whether the least is looked for.
    """

    response: Shape
    poles: ComplexArray
    breaks: FloatArray
    least: bool

    def over(self, bands: tuple[Band, ...], turning: FloatArray | None = None) -> Reached:
        """The extreme over all bands; of speeds at which it is the same the lowest.

        `turning` are the speeds at which it may be found, where they are known [rad/s]; they are tried, and not
        believed where a place between them is better.
        """
        ranges = [band for band in bands if not band.is_point]
        known = [speed for band in bands for speed in ((band.low,) if band.is_point else (band.low, band.high))]
        if not ranges:
            return self._best(known, self._values(known))
        turns = [] if turning is None else turning.tolist()
        known += [speed for band in ranges for speed in turns if band.low < speed < band.high]
        between = [band.low + (band.high - band.low) * part for band in ranges if turns for part in _BETWEEN]
        undamped = [] if self.least else self._undamped(ranges)
        values = self._values(known + between + [speed * off for speed in undamped for off in _BESIDE])
        near = iter(values[len(known) + len(between) :])
        endless = [speed for speed in undamped if _grows(next(near), next(near))]
        if endless:
            return Reached(np.inf, min(endless))
        values, beyond = values[: len(known)], values[len(known) : len(known) + len(between)]
        found = self._best(known, values)
        room = _EVEN * abs(found.value)
        if beyond and (found.value - min(beyond) if self.least else max(beyond) - found.value) <= room:
            return found
        inside = [speed for band in ranges for speed in self._inside(band)]
        found = self._best(known + inside, values + self._values(inside))
        hidden = [speed for speed in undamped if abs(found.speed - speed) <= 1e-7 * speed]
        if any(_grows(found.value, value) for value in self._values([speed * _BESIDE[1] for speed in hidden])):
            return Reached(np.inf, found.speed)  # hardly coupled: it was climbed, and is seen from near alone
        return found

    def _values(self, speeds: list[float]) -> list[float]:
        found: list[float] = self.response(np.array(speeds)).tolist() if speeds else []
        return found

    def _best(self, speeds: list[float], values: list[float]) -> Reached:
        """The best of some values, at the slowest of the speeds at which it is as good."""
        best = min(values) if self.least else max(values)
        room = _EVEN * abs(best) if isfinite(best) else 0.0
        at = min(
            (speed, value)
            for speed, value in zip(speeds, values, strict=True)
            if value == best or abs(value - best) <= room
        )
        return Reached(at[1], at[0])

    @property
    def _sign(self) -> float:
        return -1.0 if self.least else 1.0

    def _signed(self, speeds: FloatArray) -> FloatArray:
        """Square of the response, less than zero where the least is looked for."""
        found: FloatArray = self._sign * self.response(speeds) ** 2
        return found

    def _inside(self, band: Band) -> Iterator[float]:
        """Speeds inside a band at which it may be found, but for its ends."""
        between = self.breaks[(self.breaks > band.low) & (self.breaks < band.high)]
        yield from between.tolist()
        edges = [band.low, *sorted(between.tolist()), band.high]
        with np.errstate(all="ignore"):
            parts = [self._halved(self._begun(low, high)) for low, high in pairwise(edges)]
        best = max(float(values[np.isfinite(values)].max(initial=-np.inf)) for _, values in parts)
        with np.errstate(all="ignore"):
            for speeds, values in parts:
                yield from self._closed_in(*self._held(speeds, values, best))

    def _undamped(self, ranges: list[Band]) -> list[float]:
        """Poles without damping in some ranges [rad/s]."""
        poles = self.poles.tolist()
        room = _UNDAMPED * max(map(abs, poles), default=0.0)
        real = [pole.real for pole in poles if abs(pole.imag) <= room and pole.real > 0.0]
        return [min(max(one, band.low), band.high) for one in real for band in ranges if band.holds(one)]

    def _begun(self, low: float, high: float) -> FloatArray:
        """First samples of a stretch on which it is smooth, half as far apart as the nearest pole is away."""
        poles = np.abs(self.poles.real) + 1j * np.abs(self.poles.imag)
        outside = np.maximum(np.maximum(low - poles.real, poles.real - high), 0.0)
        poles = np.unique(poles[np.hypot(outside, poles.imag) <= high - low])  # others are further away than it is wide
        if not len(poles):
            return np.linspace(low, high, 33)
        sizes = np.maximum(poles.imag, _SHARP * np.maximum(np.abs(poles), high))[:, None]
        steps = np.arange(0.5, np.arcsinh((high + poles.real.max()) / sizes.min()) / _APART + 1.0)
        away = sizes * np.sinh(_APART * steps)
        found = poles.real[:, None, None] + np.stack([away, -away], axis=1)
        kept = (found > low) & (found < high)
        own = np.broadcast_to(np.hypot(away, poles.imag[:, None])[:, None, :], found.shape)[kept]
        speeds = found[kept]
        nearest = np.full(len(speeds), np.inf)
        for some in np.split(poles, range(_BLOCK, len(poles), _BLOCK)):
            nearest = np.minimum(nearest, np.abs(speeds[:, None] - some).min(axis=1))
        order = np.argsort(speeds)
        order = order[own[order] <= 1.3 * nearest[order]]
        inner, room = speeds[order], np.maximum(nearest[order], _SHARP * high)
        clear = (np.diff(inner, prepend=low) > 0.05 * room) & (high - inner > 1e-3 * np.minimum(room, high - low))
        return np.array([low, *inner[clear], high])

    def _halved(self, speeds: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Samples and their signed squares, halved where a middle is not as its neighbours say."""
        values = self._signed(speeds)
        unsure = np.ones(len(speeds) - 1, dtype=bool)
        for _ in range(_HALVINGS):
            unsure &= np.diff(speeds) > 8.0 * np.finfo(float).eps * speeds[1:]
            if not unsure.any() or len(speeds) > _MOST:
                break
            at = np.flatnonzero(unsure)
            middles = 0.5 * (speeds[at] + speeds[at + 1])
            between = self._signed(middles)
            told, around = _told(speeds, values, at, middles)
            size = around if self.least else np.abs(values[np.isfinite(values)]).max(initial=0.0)
            wrong = np.abs(between - told) > _FITS * size
            wrong &= np.isfinite(told) & np.isfinite(between)
            places = at + 1 + np.arange(len(at))
            speeds, values = np.insert(speeds, at + 1, middles), np.insert(values, at + 1, between)
            unsure = np.zeros(len(speeds) - 1, dtype=bool)
            unsure[places[wrong] - 1] = unsure[places[wrong]] = True
        return speeds, values

    def _held(self, speeds: FloatArray, values: FloatArray, best: float) -> tuple[FloatArray, FloatArray]:
        """Three speeds about each top that may be the best, and their values, (n, 3) each; also beside the ends."""
        low, high = speeds[0] + _EDGE * (speeds[1] - speeds[0]), speeds[-1] - _EDGE * (speeds[-1] - speeds[-2])
        edges = self._signed(np.array([low, high]))
        speeds = np.array([speeds[0], low, *speeds[1:-1], high, speeds[-1]])
        values = np.array([values[0], edges[0], *values[1:-1], edges[1], values[-1]])
        inner = values[1:-1]
        apart = np.diff(speeds) > 0.0
        top: BoolArray = (inner >= values[:-2]) & (inner >= values[2:]) & apart[1:] & apart[:-1]
        top &= (inner > values[:-2]) | (inner > values[2:])  # a plain has no top
        if not self.least:
            top &= inner >= _HOPE * best
        at = np.flatnonzero(top)[:, None] + np.arange(3)
        return speeds[at], values[at]

    def _closed_in(self, speeds: FloatArray, values: FloatArray) -> list[float]:
        """The top between each three speeds: the best of them after closing in by parabolas, and by halves."""
        tiny = 4.0 * np.finfo(float).eps
        open_ = np.arange(len(speeds))
        for _ in range(_CLOSINGS):
            s, v = speeds[open_], values[open_]
            wide = s[:, 2] - s[:, 0] > tiny * s[:, 2]
            steep = v[:, 1] - v.min(axis=1) > _FLAT * np.abs(v[:, 1])
            open_ = open_[wide & steep]
            if not len(open_):
                break
            s, v = speeds[open_], values[open_]
            tried = _nearer(s, v)
            found = self._signed(tried.ravel()).reshape(tried.shape)
            every, heights = np.hstack([s, tried]), np.hstack([v, np.where(np.isnan(found), -np.inf, found)])
            order, rows = np.argsort(every, axis=1, kind="stable"), np.arange(len(s))[:, None]
            every, heights = every[rows, order], heights[rows, order]
            middle = np.clip(heights.argmax(axis=1), 1, heights.shape[1] - 2)[:, None] + np.arange(-1, 2)
            speeds[open_], values[open_] = every[rows, middle], heights[rows, middle]
        return speeds[np.arange(len(speeds)), values.argmax(axis=1)].tolist() if len(speeds) else []


def _grows(near: float, far: float) -> bool:
    """Whether there is no end where a response has these values beside a pole, ten times nearer to it and far."""
    return near > 5.0 * far or not isfinite(near)


def _told(speeds: FloatArray, values: FloatArray, at: Any, middles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """What the four samples about the middle of a stretch say of it by a cubic, and the greatest of their sizes."""
    count = min(4, len(speeds))
    first = np.clip(at - 1, 0, len(speeds) - count)[:, None] + np.arange(count)
    s, v = speeds[first], values[first]
    told = np.zeros(len(at))
    for i in range(count):
        others = [j for j in range(count) if j != i]
        told += v[:, i] * np.prod((middles[:, None] - s[:, others]) / (s[:, [i]] - s[:, others]), axis=1)
    return told, np.abs(v).max(axis=1)


def _nearer(s: FloatArray, v: FloatArray) -> FloatArray:
    """Five speeds between three, (n, 5): the vertex of the parabola through them, both sides of it, both halves."""
    left, right = s[:, 1] - s[:, 0], s[:, 2] - s[:, 1]
    fall, rise = (v[:, 1] - v[:, 0]) / left, (v[:, 2] - v[:, 1]) / right
    bend = (rise - fall) / (left + right)
    slope = (fall * right + rise * left) / (left + right)
    vertex = s[:, 1] - np.where(bend < 0.0, 0.5 * slope / np.where(bend < 0.0, bend, 1.0), 0.0)
    near = 0.02 * (left + right)
    vertex = np.clip(np.where(np.isfinite(vertex), vertex, s[:, 1]), s[:, 0], s[:, 2])
    beside = 1e-3 * np.where(right > left, near, -near)  # a place of its own, so that the top stays between two others
    vertex = np.where(np.abs(vertex - s[:, 1]) < np.abs(beside), s[:, 1] + beside, vertex)
    sides = [np.clip(vertex + sign * near, s[:, 0], s[:, 2]) for sign in (-1.0, 1.0)]
    return np.column_stack([vertex, *sides, 0.5 * (s[:, 0] + s[:, 1]), 0.5 * (s[:, 1] + s[:, 2])])
