"""Greatest value of a row over z' = A z on a piece of time: Chebyshev polynomials on panels that are halved.

Exponentials of A come by Taylor's series and squaring, for all nodes of a panel and for every halving at once.
A reading on a panel is the polynomial through its 17 nodes; the panel is halved until the last coefficients and
the value at one more point say that nothing is left.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from vibopt.arrays import FloatArray, IntArray
from vibopt.records import dataclass

Numbers = NDArray[Any]
"""Real, or complex with the imaginary part as a slope."""
_DEGREE, _FINE = 16, 65
NODES = 0.5 - 0.5 * np.cos(np.pi * np.arange(_DEGREE + 1) / _DEGREE)
_ODD_ONE = 0.3717
"""One more point of a panel, to see what would hide between the nodes."""
_POINTS = np.append(NODES, _ODD_ONE)
_MIDDLE, _END = _DEGREE // 2, _DEGREE
_TERMS = 20
"""Of Taylor's series, for a matrix of norm 1."""
_RESOLVED = 1e-13
"""Part of the greatest value that may be left over on a panel."""
_EPSILON = 2.0**-52
_MOST = 1 << 21
"""Panels of one piece of time at most."""
_NEWTON = 4
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
_SLOPES = np.vstack([chebyshev.chebder(np.eye(_DEGREE + 1)), np.zeros(_DEGREE + 1)])
"""Coefficients of the slope from those of a polynomial."""


class TooLongError(ArithmeticError):
    """More periods than can be followed."""


@dataclass(frozen=True, slots=True)
class Greatest:
    """A value with its sign, and where it lies: the start in `starts`, and the part of the piece of time, 0 to 1."""

    value: float
    start: int
    at: float


def exponential(a: Numbers, at: float = 1.0) -> Numbers:
    """exp(a at), shape of `a`."""
    return np.asarray(exponentials(a, np.array([at]))[0])


def exponentials(a: Numbers, at: FloatArray) -> Numbers:
    """exp(a t) for each t of `at` (n,), from 0 to 1, shape (n, N, N)."""
    halvings = _halvings(a)
    power = series(a / 2.0**halvings, at)
    for _ in range(halvings):
        power = power @ power
    return power


def greatest(a: FloatArray, row: FloatArray, starts: FloatArray, least: float = 0.0) -> Greatest | None:
    """Greatest size of row . z with z' = a z over time 0 to 1, from each of `starts` (n, N); None if below `least`."""
    search = _Search(least)
    steps = _propagators(a)
    z, which, begin = starts, np.arange(len(starts)), np.zeros(len(starts))
    for level, step in enumerate(steps):
        values = z @ (row @ step).T
        nodes, width = values[:, :-1], 0.5**level
        search.nodes(nodes, which, begin, width)
        coefficients = nodes @ COEFFICIENTS
        rounding = _EPSILON * 2.0 ** (len(steps) - level) * (np.abs(z) @ np.abs(row))  # each squaring doubles it
        room = np.maximum(_RESOLVED * search.most, rounding)
        off = np.maximum(np.abs(coefficients[:, -3:]).max(axis=1), 0.25 * np.abs(coefficients @ _ODD - values[:, -1]))
        left = off > room if level < len(steps) - 1 else np.zeros(len(z), dtype=bool)
        search.panels(coefficients[~left], which[~left], begin[~left], width)
        if not left.any():
            break
        if 2 * left.sum() > _MOST:
            raise TooLongError
        z, which, begin = z[left], which[left], begin[left]
        z = np.concatenate([z, z @ step[_MIDDLE].T])
        which, begin = np.tile(which, 2), np.concatenate([begin, begin + 0.5 * width])
    return search.best


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
    """The greatest value seen so far, and what may still be greater."""

    def __init__(self, least: float) -> None:
        self.most, self.best = least, None

    best: Greatest | None

    def nodes(self, values: FloatArray, which: IntArray, begin: FloatArray, width: float) -> None:
        """Values at the nodes of panels, (n, 17)."""
        at = np.unravel_index(int(np.abs(values).argmax()), values.shape)
        self._say(float(values[at]), int(which[at[0]]), float(begin[at[0]] + width * NODES[at[1]]))

    def panels(self, coefficients: FloatArray, which: IntArray, begin: FloatArray, width: float) -> None:
        """Polynomials on panels, (n, 17): only where their bounds leave room are they looked at."""
        hopeful = np.abs(coefficients).sum(axis=1) > self.most
        coefficients, which, begin = coefficients[hopeful], which[hopeful], begin[hopeful]
        if not len(which):
            return
        fine = coefficients @ _VALUES
        top = np.maximum(np.abs(fine[:, :-1]), np.abs(fine[:, 1:]))
        self.most = max(self.most, float(top.max()))
        bent = np.abs(coefficients) @ _BENDS
        panel, cell = np.nonzero(top + (bent * (_CELL**2 / 8.0))[:, None] >= self.most)
        if not len(panel):
            return
        at, values = _stationary(coefficients[panel].T, np.asarray(-1.0 + _CELL * cell, dtype=float))
        best = int(np.abs(values).argmax())
        self._say(
            float(values[best]), int(which[panel[best]]), float(begin[panel[best]] + width * 0.5 * (1.0 + at[best]))
        )

    def _say(self, value: float, start: int, at: float) -> None:
        if abs(value) > abs(self.best.value if self.best else 0.0) and abs(value) >= self.most * (1.0 - _RESOLVED):
            self.best = Greatest(value, start, at)
        self.most = max(self.most, abs(value))


def _stationary(coefficients: FloatArray, low: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where polynomials (17, n) are greatest in size on the cells from `low`, and their values there."""
    slope, bend = _SLOPES @ coefficients, _SLOPES @ (_SLOPES @ coefficients)
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


def _halvings(a: Numbers) -> int:
    size = float(np.abs(a).sum(axis=0).max(initial=0.0))
    return max(0, int(np.ceil(np.log2(size)))) if size > 0.0 else 0


def series(a: Numbers, at: FloatArray) -> Numbers:
    """exp(a at) for each of `at` (n,), shape (n, N, N); a of norm 1 or less."""
    powers = np.empty((_TERMS, *a.shape), dtype=a.dtype)
    powers[0] = np.eye(len(a))
    for k in range(1, _TERMS):
        powers[k] = powers[k - 1] @ a / k
    return np.asarray(np.tensordot(at[:, None] ** np.arange(_TERMS), powers, axes=1))


def _propagators(a: FloatArray) -> list[FloatArray]:
    """exp(a t 2^-level) at the points t of a panel, (n_points, N, N) for each level, the whole first."""
    halvings = _halvings(a)
    levels = [series(a / 2.0**halvings, _POINTS)]
    for _ in range(halvings):
        levels.append(levels[-1] @ levels[-1])
    return levels[::-1]
