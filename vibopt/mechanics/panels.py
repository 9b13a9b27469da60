"""Greatest value of a row over z' = A z on a piece of time: Chebyshev polynomials on panels that are halved.

Exponentials of A come by Taylor's series and squaring, for all nodes of a panel and for every halving at once.
A reading on a panel is the polynomial through its 17 nodes; the panel is halved until the last coefficients and
the value at one more point say that nothing is left.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev

from vibopt.arrays import FloatArray, IntArray
from vibopt.records import dataclass

Numbers = np.ndarray[Any, np.dtype[Any]]
"""Real, or complex with the imaginary part as a slope."""
_DEGREE, _FINE = 16, 65
NODES = 0.5 - 0.5 * np.cos(np.pi * np.arange(_DEGREE + 1) / _DEGREE)
_ODD_ONE = 0.3717
"""One more point of a panel, to see what would hide between the nodes."""
_POINTS = np.append(NODES, _ODD_ONE)
_MIDDLE, _END = _DEGREE // 2, _DEGREE
_TERMS, _BLOCK = 20, 4
"""Of Taylor's series, for a matrix of norm 1, and of them those that are summed before a product with the next.

Only slopes are summed so: a sum of all powers keeps more digits of what comes back to nothing, as a short pulse does.
"""
_FACTORS = 1.0 / np.cumprod(np.maximum(np.arange(_TERMS), 1.0))
_RESOLVED = 1e-13
"""Part of the greatest value that may be left over on a panel."""
_OFTEN, _SELDOM = 10, 4
"""Halvings of a matrix from which on fast states are told apart from slow ones, and halvings of these."""
_STEPS, _FAR = 60, 1e12
"""Steps in which it is told apart, and how far a signal of one may hold what is fast."""
_EPSILON = 2.0**-52
_MOST, _MOST_TOGETHER = 1 << 21, 1 << 16
"""Panels of one piece of time at most, of one machine and of several at once."""
_NEWTON, _DEEPEST = 4, 1000
_TO_ROOT, _CLOSE = 60, 1e-12
"""Steps to a root of a series, and how near it is."""
_CELL = 2.0 / (_FINE - 1)


def _tables() -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Coefficients from values at nodes; values at fine points, and at the odd one, from coefficients; bends."""
    coefficients = np.asarray(np.linalg.inv(chebyshev.chebvander(2.0 * NODES - 1.0, _DEGREE)), dtype=float)
    fine: FloatArray = np.asarray(chebyshev.chebvander(np.linspace(-1.0, 1.0, _FINE), _DEGREE), dtype=float)
    odd: FloatArray = chebyshev.chebvander(np.array([2.0 * _ODD_ONE - 1.0]), _DEGREE)[0]
    k = np.arange(_DEGREE + 1.0)
    return coefficients.T, fine.T, odd, k * k * (k * k - 1.0) / 3.0


COEFFICIENTS, _VALUES, _ODD, _BENDS = _tables()


_ORDERS = np.arange(_DEGREE + 1.0)[:, None]
SLOPES = np.vstack([chebyshev.chebder(np.eye(_DEGREE + 1)), np.zeros(_DEGREE + 1)])
"""Coefficients of the slope from those of a polynomial."""


class TooLongError(ArithmeticError):
    """More periods than can be followed, or than can be of several machines at once."""


@dataclass(frozen=True, slots=True)
class Greatest:
    """Of each machine (n,): a value with its sign, zero where none is as great as was asked for, and where it lies.

    start, at
        Which of its starts, and the part of the piece of time, 0 to 1.
    """

    value: FloatArray
    start: IntArray
    at: FloatArray


def exponential(a: Numbers, at: float = 1.0) -> Numbers:
    """exp(a at), shape of `a` (..., N, N)."""
    return np.asarray(exponentials(a, np.array([at]))[..., 0, :, :])


def exponentials(a: Numbers, at: FloatArray) -> Numbers:
    """exp(a t) for each t of `at` (n,), from 0 to 1, shape (..., n, N, N) for `a` (..., N, N)."""
    halvings = halvings_of(a)
    grown = _grown(a / 2.0 ** halvings[..., None, None], at)
    for done in range(int(halvings.max(initial=0))):
        if (more := halvings > done).all():
            grown = _twice(grown)
        else:
            grown[more] = _twice(grown[more])
    return grown + np.eye(a.shape[-1])


def _twice(grown: Numbers) -> Numbers:
    """exp(2 a) - 1 from exp(a) - 1: squares of exp(a) would double the rounding of what hardly changes every time."""
    return np.asarray(2.0 * grown + grown @ grown)


def _slow(a: Numbers, halvings: IntArray) -> int:
    """From where on the last states are by themselves and slow, of matrices halved often; 0 where none are."""
    if halvings.max(initial=0) <= _OFTEN:
        return 0
    linked = (a != 0.0).reshape(-1, *a.shape[-2:]).any(axis=0)
    alone = [k for k in range(1, a.shape[-1]) if not linked[k:, :k].any()]
    return next((k for k in alone if halvings_of(a[..., k:, k:]).max(initial=0) <= _SELDOM), 0)


def greatest(
    a: FloatArray, row: FloatArray, starts: FloatArray, least: FloatArray | float = 0.0, along: Along | None = None
) -> Greatest:
    """Greatest size of row . z with z' = a z over time 0 to 1, from each of the starts of each machine.

    Parameters
    ----------
    a, row, starts
        (n, N, N), (n, N) and (n, n_starts, N).
    least
        (n,): what is below is not looked for.
    along
        What is known of `a` already.
    """
    along = Along(a) if along is None else along
    if along.depth > _OFTEN and (apart := _apart(a, row, starts, along.whole)) is not None:
        a, row, starts = apart
        along = Along(a)
    count, each, size = starts.shape
    search = _Search(np.array(np.broadcast_to(least, count), dtype=float))
    z, of = starts.reshape(-1, size), np.repeat(np.arange(count), each)
    which, begin = np.tile(np.arange(each), count), np.zeros(len(z))
    for level in range(along.depth + 1):
        step = along.step(level)
        rows = (row[:, None, None] @ step)[:, :, 0].mT
        values = (starts @ rows).reshape(-1, len(_POINTS)) if level == 0 else _each(z, rows, of)
        nodes, width = values[:, :-1], 0.5**level
        search.nodes(nodes, of, which, begin, width)
        coefficients = nodes @ COEFFICIENTS
        sizes = _each(np.abs(z), np.abs(row)[:, :, None], of)[:, 0]
        rounding = _EPSILON * 2.0 ** (along.halvings[of] + 1 - level) * sizes  # each squaring doubles it
        room = np.maximum(_RESOLVED * search.most[of], rounding)
        off = np.maximum(np.abs(coefficients[:, -3:]).max(axis=1), 0.25 * np.abs(coefficients @ _ODD - values[:, -1]))
        left = (off > room) & (level < along.halvings[of])
        if along.depth > _OFTEN:  # what fades soon behind a beginning hides between nodes that are far apart
            left |= (begin == 0.0) & (level < along.halvings[of] - _SELDOM)
        done = ~left
        search.panels(coefficients[done], of[done], which[done], begin[done], width)
        if not left.any():
            break
        if 2 * left.sum() > (_MOST if count == 1 else _MOST_TOGETHER):
            raise TooLongError
        z, of, which, begin = z[left], of[left], which[left], begin[left]
        z = np.concatenate([z, _each(z, step[:, _MIDDLE].mT, of)])
        of, which, begin = np.tile(of, 2), np.tile(which, 2), np.concatenate([begin, begin + 0.5 * width])
    return search.best


def _apart(
    a: FloatArray, row: FloatArray, starts: FloatArray, whole: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """The same with fast states counted from where slow ones hold them; None where they cannot be told apart.

    What a slow signal holds in balance would cancel to rounding in all that is small beside it.  M X - X S = -C, for
    what is fast (M), slow (S) and between them (C), by steps that converge where S is slow.  Where what is with the
    fast ones creeps, signals would hold it far beyond where it gets to: machines of which more would cancel so, at
    starts or behind `whole` = exp(a), are left as they are.
    """
    own, linked = _slow(a, halvings_of(a)), (a != 0.0).any(axis=0)
    if not own:
        return None
    slow = np.arange(a.shape[-1]) >= own
    for _ in range(own):
        slow |= ~linked[:, ~slow].any(axis=1)
    fast, rows = np.flatnonzero(~slow), np.flatnonzero(slow)
    m, between, s = (a[:, one[:, None], other] for one, other in ((fast, fast), (fast, rows), (rows, rows)))
    held: FloatArray = np.zeros(between.shape)
    for _ in range(_STEPS):
        before = held
        try:
            held = np.asarray(np.linalg.solve(m, held @ s - between))
        except np.linalg.LinAlgError:  # what is loose
            return None
        if not np.abs(held).max() < _FAR:
            return None
        if (np.abs(held - before) <= _EPSILON * np.abs(held).max(axis=(-2, -1), keepdims=True)).all():
            break
    else:
        return None
    every, held_row = np.concatenate([starts, starts @ whole.mT], axis=1), row.copy()
    held_row[:, rows] += (row[:, None, fast] @ held)[:, 0]
    counted = every.copy()
    counted[..., fast] -= every[..., rows] @ held.mT
    pays = _mixed(held_row, counted, fast, rows) < _mixed(row, every, fast, rows)
    if not pays.any():
        return None
    a = a.copy()
    a[np.ix_(pays, fast, rows)] = 0.0
    row = np.where(pays[:, None], held_row, row)
    return a, row, np.where(pays[:, None, None], counted[:, : starts.shape[1]], starts)


def _mixed(row: FloatArray, z: FloatArray, fast: IntArray, slow: IntArray) -> FloatArray:
    """What rounding counts from in row . z of each machine (n, N) at its states (n, k, N), (n,): fast ones mix."""
    most = np.abs(z).max(axis=1)
    beside = (np.abs(row) * most)[:, slow].sum(axis=1)
    return np.asarray(np.abs(row[:, fast]).sum(axis=1) * most[:, fast].max(axis=1) + beside)


def _each(z: FloatArray, matrices: FloatArray, of: IntArray) -> FloatArray:
    """Each z (m, N) times the matrix of its machine, (n, N, k): (m, k)."""
    if len(matrices) == 1:
        return np.asarray(z @ matrices[0])
    return np.asarray((z[:, None] @ matrices[of])[:, 0])


def peaks_of(coefficients: FloatArray, least: FloatArray) -> FloatArray:
    """Greatest size of each polynomial on a panel, (n, 17) to (n,), or a lesser one where it is below `least` (n,)."""
    fine = coefficients @ _VALUES
    top = np.maximum(np.abs(fine[:, :-1]), np.abs(fine[:, 1:]))
    found: FloatArray = np.maximum(top.max(axis=1), least)
    bent = np.abs(coefficients) @ _BENDS
    panel, cell = np.nonzero(top + (bent * (_CELL**2 / 8.0))[:, None] >= found[:, None])
    if len(panel):
        values = _stationary(coefficients[panel].T, np.asarray(-1.0 + _CELL * cell, dtype=float))[1]
        np.maximum.at(found, panel, np.abs(values))
    return found


class _Search:
    """The greatest value of each machine seen so far, and what may still be greater."""

    def __init__(self, least: FloatArray) -> None:
        self.most = least
        self.best = Greatest(np.zeros(len(least)), np.zeros(len(least), dtype=int), np.zeros(len(least)))

    def nodes(self, values: FloatArray, of: IntArray, which: IntArray, begin: FloatArray, width: float) -> None:
        """Values at the nodes of panels, (m, 17)."""
        sizes = np.abs(values)
        at = sizes.argmax(axis=1)
        tops = values[np.arange(len(at)), at]
        self._say(tops, of, which, begin + width * NODES[at])

    def panels(self, coefficients: FloatArray, of: IntArray, which: IntArray, begin: FloatArray, width: float) -> None:
        """Polynomials on panels, (m, 17): only where their bounds leave room are they looked at."""
        sizes = np.abs(coefficients)
        hopeful = np.flatnonzero(sizes.sum(axis=1) > self.most[of])
        if not len(hopeful):
            return
        coefficients, of, which, begin = coefficients[hopeful], of[hopeful], which[hopeful], begin[hopeful]
        fine = np.abs(coefficients @ _VALUES)
        top = np.maximum(fine[:, :-1], fine[:, 1:])
        np.maximum.at(self.most, of, top.max(axis=1))
        bent = sizes[hopeful] @ _BENDS
        panel, cell = np.nonzero(top + (bent * (_CELL**2 / 8.0))[:, None] >= self.most[of][:, None])
        if len(panel):
            at, values = _stationary(coefficients[panel].T, np.asarray(-1.0 + _CELL * cell, dtype=float))
            self._say(values, of[panel], which[panel], begin[panel] + width * 0.5 * (1.0 + at))

    def _say(self, values: FloatArray, of: IntArray, which: IntArray, at: FloatArray) -> None:
        sizes = np.abs(values)
        if len(self.most) == 1:
            tops = np.array([sizes.argmax()])
        else:
            order = np.lexsort((-sizes, of))
            tops = order[np.unique(of[order], return_index=True)[1]]
        those, best = of[tops], self.best
        better = (sizes[tops] > np.abs(best.value[those])) & (sizes[tops] >= self.most[those] * (1.0 - _RESOLVED))
        tops, those = tops[better], those[better]
        best.value[those], best.start[those], best.at[those] = values[tops], which[tops], at[tops]
        self.most[those] = np.maximum(self.most[those], sizes[tops])


def _stationary(coefficients: FloatArray, low: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where polynomials (17, n) are greatest in size on the cells from `low`, and their values there."""
    slope, bend = SLOPES @ coefficients, SLOPES @ (SLOPES @ coefficients)
    at = low + 0.5 * _CELL
    for _ in range(_NEWTON):
        terms = np.cos(_ORDERS * np.arccos(at))
        with np.errstate(divide="ignore", invalid="ignore"):
            step = (slope * terms).sum(axis=0) / (bend * terms).sum(axis=0)
        at = np.clip(at - np.where(np.isfinite(step), step, 0.0), low, np.minimum(low + _CELL, 1.0))
    places = np.array([low, at, low + _CELL])
    values = chebyshev.chebval(places, coefficients, tensor=False)
    best = np.abs(values).argmax(axis=0)
    which = np.arange(len(low))
    return places[best, which], values[best, which]


def halvings_of(a: Numbers) -> IntArray:
    """How often matrices (..., N, N) are to be halved so that their norm is 1 or less, (...)."""
    size = np.abs(a).sum(axis=-2).max(axis=-1, initial=0.0)
    with np.errstate(divide="ignore"):
        return np.asarray(np.clip(np.ceil(np.log2(size)), 0.0, _DEEPEST), dtype=int)


def series(a: Numbers, at: FloatArray) -> Numbers:
    """exp(a at) for each of `at` (n,), shape (..., n, N, N), for `a` (..., N, N); a of norm 1 or less."""
    return _grown(a, at) + np.eye(a.shape[-1])


def _grown(a: Numbers, at: FloatArray) -> Numbers:
    """exp(a at) - 1, as `series`."""
    factors = _FACTORS * at[:, None] ** np.arange(_TERMS)
    factors[:, 0] = 0.0
    if len(at) > 1 or not np.iscomplexobj(a):
        return np.moveaxis(_weighed(factors, _powers(a, _TERMS)), 0, -3)
    powers = _powers(a, _BLOCK + 1)
    *blocks, found = _weighed(factors.reshape(-1, _BLOCK), powers[:_BLOCK])
    for block in reversed(blocks):
        found = found @ powers[_BLOCK] + block
    return np.asarray(found[..., None, :, :])


def _powers(a: Numbers, count: int) -> Numbers:
    """The first powers of matrices (..., N, N), from 1 on, (count, ..., N, N)."""
    powers = np.empty((count, *a.shape), dtype=a.dtype)
    powers[0] = np.eye(a.shape[-1])
    for before, power in pairwise(powers):
        np.matmul(before, a, out=power)
    return powers


def _weighed(factors: FloatArray, powers: Numbers) -> Numbers:
    """Sums of matrices (k, ..., N, N) by factors (n, k), (n, ..., N, N): factors are real where matrices are not."""
    sums = factors @ powers.reshape(len(powers), -1).view(float)
    return np.asarray(sums.view(powers.dtype).reshape(len(factors), *powers.shape[1:]))


class Along:
    """exp(a t 2^-level) at the points t of a panel, for each level of halving, of machines a (n, N, N)."""

    def __init__(self, a: FloatArray) -> None:
        self.halvings = halvings_of(a)
        self._grown = [_grown(a / 2.0 ** self.halvings[:, None, None], _POINTS)]
        """Less 1; from the last level to the whole; of machines that are resolved before, as at their last."""

    @property
    def depth(self) -> int:
        """The last level."""
        return int(self.halvings.max(initial=0))

    def step(self, level: int) -> FloatArray:
        """At one level, (n, n_points, N, N)."""
        while len(self._grown) <= self.depth:
            last, more = self._grown[-1], self.halvings > self.depth - len(self._grown)
            self._grown.append(_twice(last) if more.all() else np.where(more[:, None, None, None], _twice(last), last))
        grown = self._grown[self.depth - level]
        return grown + np.eye(grown.shape[-1])

    @property
    def whole(self) -> FloatArray:
        """exp(a), (n, N, N)."""
        return np.asarray(self.step(0)[:, _END])

    def doubled(self) -> Along:
        """Of machines 2 a."""
        self.step(0)
        found = Along.__new__(Along)
        found.halvings, found._grown = self.halvings + 1, list(self._grown)
        return found

    def some(self, which: IntArray) -> Along:
        """Of some of the machines."""
        self.step(0)
        found = Along.__new__(Along)
        found.halvings = self.halvings[which]
        found._grown = [grown[which] for grown in self._grown[self.depth - found.depth :]]
        return found


def basis(part: FloatArray | float) -> FloatArray:
    """Chebyshev's polynomials at parts of a panel, (17, n)."""
    return np.asarray(
        np.cos(np.multiply.outer(_ORDERS[:, 0], np.arccos(np.minimum(np.maximum(2.0 * part - 1.0, -1.0), 1.0))))
    )


def crossing(series: FloatArray, low: float, high: float) -> float:
    """The root of a series between places where its signs differ: Newton's steps, halves where they leave."""
    both, at = np.array([series, 2.0 * (SLOPES @ series)]), 0.5 * (low + high)
    rises = float(series @ basis(high)) > 0.0
    for _ in range(_TO_ROOT):
        value, rate = (both @ basis(at)).tolist()
        low, high = (low, at) if (value > 0.0) == rises else (at, high)
        step = at - value / rate if rate else low
        last, at = at, step if low <= step <= high else 0.5 * (low + high)
        if abs(at - last) <= _CLOSE:
            break
    return at


def roots_of(series: FloatArray, begin: float, end: float) -> FloatArray:
    """Real roots of a series on 0 to 1, from `begin` to `end`, ascending, made better by Newton's method."""
    last = int(np.flatnonzero(np.abs(series) > 1e-17 * np.abs(series).max())[-1])
    roots = chebyshev.chebroots(series[: last + 1]) if last else np.zeros(0)
    found = 0.5 + 0.5 * np.sort(roots.real[np.abs(roots.imag) < 1e-8])
    found = found[(found >= begin - 1e-9) & (found <= end + 1e-9)]
    for _ in range(2):
        each = basis(found)
        rate = SLOPES @ series @ each
        step = 0.5 * (series @ each) / np.where(rate == 0.0, np.inf, rate)
        found = found - np.where(np.abs(step) < 1e-3, step, 0.0)
    return np.asarray(found[(found >= begin) & (found <= end * (1.0 + _CLOSE))])
