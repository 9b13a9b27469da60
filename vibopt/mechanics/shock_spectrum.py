"""Shock spectra: greatest response of many lone masses on mounts, during a load that comes once and after it.

A mass that moves by x from its support, x'' + 2 z w x' + w^2 x = -g, is followed in y = w^2 x and q = w x', which keep
their digits from the softest mount to the hardest.  Segments are cut so finely that what happens on one is a polynomial
of degree 16 to rounding; where it can be greater than what was seen at the cuts, its greatest value is looked for.
What follows the load has a closed form.  Hundreds of mounts go through a record at once.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.mechanics.panels import COEFFICIENTS, NODES, exponentials, peaks_of
from vibopt.records import cached_property, dataclass
from vibopt.signals import Segment

_WIDE, _TERMS, _PARTS = 3.0, 32, 4
"""Norm of what happens on a cut, terms of Taylor's series for it, and parts of a cut that are looked at."""
_AT_ONCE, _PANELS = 500_000, 5_000
"""States of masses, and polynomials, that are held at once."""
_CRITICAL = 1e-8


@dataclass(frozen=True, slots=True)
class Spectrum:
    """Greatest sizes by mount, each (n_mounts,) or of the shape that was asked for.

    pseudo, pseudo_after
        w^2 |x| [m/s^2] during the load and after it; over w^2 the greatest relative displacement.
    absolute, absolute_after
        Acceleration of the mass, of a moved support; force on the support over the mass, of a pushed mass [m/s^2].
    """

    pseudo: FloatArray
    pseudo_after: FloatArray
    absolute: FloatArray
    absolute_after: FloatArray


def spectra(mix: FloatArray, segments: tuple[Segment, ...], rates: FloatArray, ratios: FloatArray) -> Spectrum:
    """Spectra of a load.

    Parameters
    ----------
    mix
        (n_signals,): acceleration of the support [m/s^2], less force over mass, for signals of one.
    segments
        The signals; one that goes on for ever stays at its value, and all of it is during the load.
    rates, ratios
        Natural frequencies [rad/s], above zero, and damping ratios, arrays that fit together.
    """
    w, z = (array.ravel() for array in np.broadcast_arrays(np.asarray(rates, float), np.asarray(ratios, float)))
    shape = np.broadcast_shapes(np.shape(rates), np.shape(ratios))
    state, during = np.zeros((len(w), 2)), np.zeros((2, len(w)))
    held = float((mix @ segments[-1].read) @ segments[-1].start) if segments[-1].endless else 0.0
    for run in _runs(mix, segments[: len(segments) - segments[-1].endless]):
        size = np.maximum(w * run.length * (1.0 + 2.0 * z), np.abs(run.rates).sum(axis=0).max(initial=0.0))
        cuts = 2 ** np.ceil(np.log2(np.maximum(size / _WIDE, 1.0))).astype(int)
        for count in np.unique(cuts).tolist():
            cut, alike = run.cut(count), np.flatnonzero(cuts == count)
            most = max(1, _AT_ONCE // (len(cut.starts) + 1))
            for k in range(0, len(alike), most):
                some = alike[k : k + most]
                state[some], found = _Masses(cut, w[some], z[some]).through(state[some])
                during[:, some] = np.maximum(during[:, some], found)
    rows = ((np.ones(len(z)), np.zeros(len(z))), (-np.ones(len(z)), -2.0 * z))
    after = [_after(state + np.array([held, 0.0]), z, *row, -held * row[0]) for row in rows]
    if segments[-1].endless:
        during, after = np.maximum(during, after), list(np.zeros(during.shape))
    return Spectrum(*(one.reshape(shape) for one in (during[0], after[0], during[1], after[1])))


@dataclass(frozen=True, slots=True)
class _Run:
    """Segments of one length and one kind behind each other: read . v with v' = rates v, time 0 to 1 on each.

    starts, blows
        (n, m) and (n + 1,): changes of the support's velocity at each beginning and behind the last [m/s].
    """

    length: float
    rates: FloatArray
    read: FloatArray
    starts: FloatArray
    blows: FloatArray

    def cut(self, count: int) -> _Run:
        """Each segment in so many parts."""
        if count == 1:
            return self
        parts = exponentials(self.rates, np.arange(count) / count)
        starts = np.einsum("pij,nj->npi", parts, self.starts).reshape(-1, self.starts.shape[1])
        blows = np.zeros((len(self.starts), count))
        blows[:, 0] = self.blows[:-1]
        return _Run(
            self.length / count, self.rates / count, self.read, starts, np.append(blows.ravel(), self.blows[-1])
        )


def _runs(mix: FloatArray, segments: tuple[Segment, ...]) -> Iterator[_Run]:
    """The load; what is quiet at its end is no part of it, but a blow there is."""
    load = list(segments)
    last = 0.0
    while load and not (load[-1].start != 0.0).any():
        last += float(load[-1].blows @ mix)
        load.pop()
        if last:
            break
    groups = [
        list(iterator)
        for _, iterator in groupby(
            load, lambda segment: (segment.length, segment.rates.tobytes(), segment.read.tobytes())
        )
    ]
    for i, run in enumerate(groups):
        blows = [float(segment.blows @ mix) for segment in run] + [last if i == len(groups) - 1 else 0.0]
        starts = np.array([segment.start for segment in run])
        yield _Run(run[0].length, run[0].rates, mix @ run[0].read, starts, np.array(blows))
    if not groups:
        yield _Run(1e-300, np.zeros((1, 1)), np.zeros(1), np.zeros((1, 1)), np.array([last, 0.0]))


class _Masses:
    """Some masses through a run that is cut finely enough."""

    def __init__(self, run: _Run, w: FloatArray, z: FloatArray) -> None:
        self.run, self.w = run, w
        m, turned = len(run.rates), w * run.length
        self.a = np.zeros((len(w), 2 + m, 2 + m))
        self.a[:, 0, 1] = turned
        self.a[:, 1, 0] = -turned
        self.a[:, 1, 1] = -2.0 * z * turned
        self.a[:, 1, 2:] = -turned[:, None] * run.read
        self.a[:, 2:, 2:] = run.rates
        self.rows = np.zeros((2, len(w), 2 + m))
        self.rows[0, :, 0] = 1.0
        self.rows[1, :, 0], self.rows[1, :, 1] = -1.0, -2.0 * z

    def through(self, begin: FloatArray) -> tuple[FloatArray, FloatArray]:
        """States behind the run (n, 2) from those before it, and the greatest of both readings (2, n)."""
        run, b = self.run, len(self.w)
        step = self._power(np.broadcast_to(np.eye(self.a.shape[1]), self.a.shape), np.ones(1))[:, 0]
        pushed = (run.starts @ step[:, :2, 2:].transpose(2, 1, 0).reshape(-1, 2 * b)).reshape(-1, 2, b)
        struck = -run.blows[:, None] * self.w
        pushed[:, 1] += struck[1:]
        states = _states(step[:, :2, :2], pushed, begin.T + np.array([np.zeros(b), struck[0]]))
        ends = states[1:].copy()
        ends[:, 1] -= struck[1:]
        reach = self._reach(states[:-1])
        found = np.array([self._greatest(row, states[:-1], ends, reach) for row in self.rows])
        return states[-1].T, found

    def _power(self, rows: FloatArray, at: FloatArray) -> FloatArray:
        """rows . exp(a t) for each mass, (b, i, N) to (b, t, i, N)."""
        found = np.zeros((len(self.a), len(at), *rows.shape[1:]))
        term = np.array(rows)
        for k in range(_TERMS):
            found += (at**k)[:, None, None] * term[:, None]
            term = term @ self.a / (k + 1)
        return found

    def _greatest(self, row: FloatArray, states: FloatArray, ends: FloatArray, reach: FloatArray) -> FloatArray:
        """Of a reading (b, N) over cuts from `states` to `ends`, (n, 2, b) each, all cuts together, (b,)."""
        first, second = row[:, 0], row[:, 1]
        seen = np.abs(first * states[:, 0] + second * states[:, 1])
        np.maximum(seen, np.abs(first * ends[:, 0] + second * ends[:, 1]), out=seen)
        best: FloatArray = seen.max(axis=0)
        room = self._bulges(row, reach)
        cut, mass = np.nonzero(seen + room > best)
        for points in (np.linspace(0.0, 1.0, _PARTS + 1)[1:-1], NODES):
            rows, kept = self._power(row[:, None, :], points)[:, :, 0], np.ones(len(mass), dtype=bool)
            for k in range(0, len(mass), _PANELS):
                those, there = mass[k : k + _PANELS], cut[k : k + _PANELS]
                every = np.concatenate([states[there, :, those], self.run.starts[there]], axis=1)
                values = (rows[those] @ every[:, :, None])[..., 0]
                if points is NODES:
                    np.maximum.at(best, those, peaks_of(values @ COEFFICIENTS, best[those]))
                    continue
                top = np.maximum(np.abs(values).max(axis=1), seen[there, those])
                np.maximum.at(best, those, top)
                kept[k : k + _PANELS] = top + room[there, those] / _PARTS**2 > best[those]
            mass, cut = mass[kept], cut[kept]
        return best

    def _reach(self, states: FloatArray) -> FloatArray:
        """What the root of y^2 + q^2 may be on each cut, (n, b): it rises by the load alone."""
        loaded = self._signals @ np.abs(self.run.read)
        found = np.hypot(states[:, 0], states[:, 1])
        found += loaded[:, None] * (self.w * self.run.length)
        return np.asarray(found)

    @cached_property
    def _signals(self) -> FloatArray:
        """What the signals do not exceed on each cut, (n, m)."""
        grows = np.exp(np.abs(self.run.rates).sum(axis=0).max(initial=0.0))
        return np.asarray(grows * np.abs(self.run.starts))

    def _bulges(self, row: FloatArray, reach: FloatArray) -> FloatArray:
        """By how much a reading may rise above its values at both ends of a cut, (n, b): an eighth of its bend."""
        bent = 0.125 * np.einsum("bn,bnm,bmk->bk", row, self.a, self.a)
        found = reach * np.hypot(bent[:, 0], bent[:, 1])
        found += self._signals @ np.abs(bent[:, 2:]).T
        return np.asarray(found)


def _states(step: FloatArray, pushed: FloatArray, begin: FloatArray) -> FloatArray:
    """s' = step s + pushed, (b, 2, 2) and (n, 2, b), from (2, b): (n + 1, 2, b); root n stretches go side by side."""
    n, _, b = pushed.shape
    long = int(np.ceil(np.sqrt(n)))
    many = -(-n // long)
    own = np.zeros((many, long + 1, 2, b))
    padded = np.zeros((many * long, 2, b))
    padded[:n] = pushed
    padded = padded.reshape(many, long, 2, b)
    one = step.transpose(1, 2, 0)
    powers = np.empty((long + 1, 2, 2, b))
    powers[0] = np.eye(2)[:, :, None]
    for k in range(long):
        own[:, k + 1] = _times(one, own[:, k]) + padded[:, k]
        powers[k + 1] = _times(one, powers[k].transpose(1, 0, 2)).transpose(1, 0, 2)
    starts, now = np.empty((many, 2, b)), begin
    for j in range(many):
        starts[j] = now
        now = _times(powers[long], now[None])[0] + own[j, long]
    for k in range(long + 1):
        own[:, k] += _times(powers[k], starts)
    return np.concatenate([own[:, :-1].reshape(-1, 2, b), own[-1:, -1]])[: n + 1]


def _times(matrix: FloatArray, states: FloatArray) -> FloatArray:
    """(2, 2, b) on (n, 2, b)."""
    return np.stack([matrix[i, 0] * states[:, 0] + matrix[i, 1] * states[:, 1] for i in (0, 1)], axis=1)


def _after(
    state: FloatArray, z: FloatArray, first: FloatArray, second: FloatArray, still: FloatArray | float = 0.0
) -> FloatArray:
    """Greatest size of first y + second q in the free vibration about `still` from a state (b, 2) on, (b,).

    At once, at the first turn or the next, or in the end.  In turns of w any reading r answers r'' + 2 z r' + r = 0.
    """
    y, q = state.T
    r, slope = first * y + second * q, first * q - second * (y + 2.0 * z * q)
    d = np.maximum(np.sqrt(np.abs(1.0 - z * z)), _CRITICAL)
    under, other = z < 1.0, r + z * slope
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        angle = np.where(under, np.arctan2(slope * d, other) % np.pi, np.arctanh(slope * d / other))
        at = np.where(np.isfinite(angle) & (angle > 0.0), angle, 0.0) / d
        cosine, sine = (np.where(under, f(d * at), g(d * at)) for f, g in ((np.cos, np.cosh), (np.sin, np.sinh)))
        turned = np.nan_to_num(np.exp(-z * at) * (r * cosine + (slope + z * r) / d * sine))
        again = np.where(under, -turned * np.exp(-z * np.pi / d), 0.0)
    return np.asarray(np.abs(still + np.array([r, turned, again, np.zeros(len(r))])).max(axis=0))
