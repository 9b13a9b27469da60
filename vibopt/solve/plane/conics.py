"""Sets of points (k, c) that satisfy rows  a k^2 + b c^2 + p k + q c + r <= 0  within a box.

A closed set that is not empty has a leftmost point, and that is a point where two boundaries meet, or
where one boundary turns back.  All such points are listed and tried, so an empty list is a proof, as
far as rounding goes: rows are believed to be met within `SLACK` of their own size.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from vibopt.arrays import BoolArray, FloatArray, IntArray
from vibopt.records import dataclass

SLACK = 1e-12
_SMALL = 1e-14
_AT_ONCE, _BEGUN = 3, 3
_HOLDS = 1e-4
"""Part of its size by which a row that is nearly broken may still hold."""


@dataclass(frozen=True)
class Conics:
    """Rows over a box.

    rows
        Coefficients of k^2, c^2, k, c and 1, shape (n, 5); <= 0 inside.
    low, high
        Box of (k, c), each (2,), finite.
    """

    rows: FloatArray
    low: FloatArray
    high: FloatArray

    def corners(self, near: FloatArray | None = None) -> FloatArray:
        """Corner points of the set that the rows leave, shape (m, 2); none where it is empty.

        Rows are taken in where they cut off what the others leave, so that few of many are ever paired; first those
        that hold a point `near` (2,) back.
        """
        found: FloatArray = self._outermost(0.0, near) * self._unit()
        return found

    def left_empty(self, near: FloatArray) -> bool:
        """Whether some sum of rows with weights no less than zero is above zero everywhere: then nothing is left.

        The weights are those whose slopes best cancel at `near` (2,), so False says nothing.
        """
        from scipy.optimize import nnls

        unit = self._unit()
        walls = _walls(self.low / unit, self.high / unit)
        rows = np.concatenate([self.rows * np.array([unit[0] ** 2, unit[1] ** 2, unit[0], unit[1], 1.0]), walls])
        rows = rows / np.maximum(np.abs(rows).max(axis=1), 1e-300)[:, None]
        k, c = near / unit
        at = rows @ monomials(np.array([[k, c]]))[:, 0]
        rows = rows[at >= -_HOLDS]
        slopes = np.stack([2.0 * rows[:, 0] * k + rows[:, 2], 2.0 * rows[:, 1] * c + rows[:, 3], np.ones(len(rows))])
        weights = nnls(slopes, np.array([0.0, 0.0, 1.0]))[0] if len(rows) else np.zeros(0)
        square, level, along, up, rest = weights @ rows
        if not (square > 0.0 and level > 0.0):
            return False
        least = rest - along**2 / (4.0 * square) - up**2 / (4.0 * level)
        size = np.abs(weights[:, None] * rows).sum(axis=0) @ [
            (0.5 * along / square) ** 2,
            (0.5 * up / level) ** 2,
            abs(0.5 * along / square),
            abs(0.5 * up / level),
            1.0,
        ]
        return bool(least > SLACK * size)

    def extreme(self, way: float, axis: int = 0) -> FloatArray:
        """Corner points with the greatest k (`way` 1) or the least (-1), of c with `axis` 1; none where it is empty."""
        if axis:
            return Conics(self.rows[:, [1, 0, 3, 2, 4]], self.low[::-1], self.high[::-1]).extreme(way)[:, ::-1]
        found: FloatArray = self._outermost(way) * self._unit()
        return found

    def _outermost(self, way: float, near: FloatArray | None = None) -> FloatArray:
        """Corner points, scaled, with the greatest `way` k; rows that cut off all of them are taken in."""
        unit = self._unit()
        scaled = self.rows * np.array([unit[0] ** 2, unit[1] ** 2, unit[0], unit[1], 1.0])
        size = np.abs(scaled).max(axis=1, initial=0.0)
        scaled = scaled[size > 0.0] / size[size > 0.0, None]
        low, high = self.low / unit, self.high / unit
        chosen: list[int] = []
        if near is not None:
            chosen = np.argsort(-(scaled @ monomials(near[None] / unit))[:, 0], kind="stable")[:_BEGUN].tolist()
        while True:
            points = _corners_of(scaled[chosen], low, high)
            if not len(points):
                return points
            points = points[way * points[:, 0] >= (way * points[:, 0]).max()]
            powers = monomials(points)
            missed = scaled @ powers - SLACK * (np.abs(scaled) @ powers)
            whole = (missed <= 0.0).all(axis=0)
            if whole.any():
                return np.asarray(points[whole])
            fresh = [int(row) for row in np.unique(missed.argmax(axis=0)) if row not in chosen]
            assert fresh, "a row that is missed by a corner of the others is none of them"
            chosen += sorted(fresh, key=lambda row: -float(missed[row].max()))[:_AT_ONCE]

    def _unit(self) -> FloatArray:
        """Sizes of k and c at which the rows turn, within the box."""
        made = np.array(self.high, dtype=float)
        for column in (0, 1):
            square, rest = np.abs(self.rows[:, column]), np.abs(self.rows[:, 4])
            good = (square > 0.0) & (rest > 0.0)
            if good.any():
                made[column] = min(float(np.exp(0.5 * np.log(rest[good] / square[good]).mean())), made[column])
        return np.where(made > 0.0, made, 1.0)


def _corners_of(rows: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Corner points of all rows together, shape (m, 2)."""
    points = np.array([[k, c] for k in (low[0], high[0]) for c in (low[1], high[1])])
    if len(rows):
        points = np.concatenate([_candidates(np.concatenate([rows, _walls(low, high)])), points])
    room = 1e-12 * high
    inside = ((points >= low - room) & (points <= high + room)).all(axis=1)
    points = np.clip(points[inside], low, high)
    met: FloatArray = points[_met(rows, points)]
    return met


def _walls(low: FloatArray, high: FloatArray) -> FloatArray:
    return np.array(
        [
            [0.0, 0.0, -1.0, 0.0, low[0]],
            [0.0, 0.0, 1.0, 0.0, -high[0]],
            [0.0, 0.0, 0.0, -1.0, low[1]],
            [0.0, 0.0, 0.0, 1.0, -high[1]],
        ]
    )


def monomials(points: FloatArray) -> FloatArray:
    """k^2, c^2, k, c, 1 at points (m, 2), shape (5, m)."""
    k, c = points.T
    return np.stack([k * k, c * c, k, c, np.ones_like(k)])


def _met(rows: FloatArray, points: FloatArray) -> BoolArray:
    powers = monomials(points)
    return np.asarray((rows @ powers <= SLACK * (np.abs(rows) @ powers)).all(axis=0), dtype=bool)


def _candidates(rows: FloatArray) -> FloatArray:
    """Every meeting point of two boundaries, and every turning point of one; some others too."""
    first, second = _pairs(len(rows))
    a, b = rows[first], rows[second]
    return np.concatenate([_meetings(a, b), _turning(rows)])


@lru_cache(maxsize=64)
def _pairs(count: int) -> tuple[IntArray, IntArray]:
    return np.triu_indices(count, 1)


def _turning(rows: FloatArray) -> FloatArray:
    """Where a boundary has a vertical tangent: 2 b c + q = 0, shape (m, 2)."""
    curved = rows[np.abs(rows[:, 1]) > _SMALL]
    c = -curved[:, 3] / (2.0 * curved[:, 1])
    roots = _quadratic(np.stack([curved[:, 0], curved[:, 2], curved[:, 4] - curved[:, 1] * c * c], axis=-1))
    return np.stack([roots, np.repeat(c[:, None], 2, axis=1)], axis=-1).reshape(-1, 2)


def _meetings(a: FloatArray, b: FloatArray) -> FloatArray:
    """Meeting points of pairs of boundaries (n, 5), polished, shape (m, 2)."""
    over = a[:, 1:2] * b[:, [0, 2, 4]] - b[:, 1:2] * a[:, [0, 2, 4]]
    cross = a[:, 1] * b[:, 3] - b[:, 1] * a[:, 3]
    under = a[:, 3:4] * b[:, [0, 2, 4]] - b[:, 3:4] * a[:, [0, 2, 4]]
    k4 = _quartic(_times(over) - np.concatenate([np.zeros((len(a), 2)), cross[:, None] * under], axis=1))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        level = -(over[:, :1] * k4**2 + over[:, 1:2] * k4 + over[:, 2:]) / cross[:, None]
    k = _quadratic(np.array([over, under]).transpose(1, 0, 2)).reshape(len(a), 4)
    c = _heights(np.array([a, b]), k)
    return _both_ways(np.concatenate([k4, np.tile(k, 4)], axis=1), np.concatenate([level, *c], axis=1), a, b)


def _both_ways(k: FloatArray, c: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    """Points of k and c (n, j), and the same moved onto both rows (n, 5); those that are finite, (m, 2)."""
    points = np.stack([k, c], axis=-1)
    pair, place = np.nonzero((np.abs(points) < 1e12).all(axis=-1))
    points = points[pair, place]
    return np.concatenate([points, _newton(points, a[pair], b[pair])])


def _heights(rows: FloatArray, k: FloatArray) -> FloatArray:
    """Both c at which boundaries (2, n, 5) pass k (n, j), (4, n, j)."""
    k = np.where(np.abs(k) < 1e12, k, np.nan)
    square, level, along, up, rest = (one[..., None] for one in np.moveaxis(rows, -1, 0))
    left = square * k**2 + along * k + rest
    both = _quadratic(np.stack(np.broadcast_arrays(level, up, left), axis=-1))
    return np.moveaxis(both, -1, 0).reshape(4, *k.shape)


def _newton(points: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    """Points (m, 2) moved onto both boundaries."""
    k, c = points.T
    for _ in range(3):
        one = a[:, 0] * k * k + a[:, 1] * c * c + a[:, 2] * k + a[:, 3] * c + a[:, 4]
        two = b[:, 0] * k * k + b[:, 1] * c * c + b[:, 2] * k + b[:, 3] * c + b[:, 4]
        one_k, one_c = 2.0 * a[:, 0] * k + a[:, 2], 2.0 * a[:, 1] * c + a[:, 3]
        two_k, two_c = 2.0 * b[:, 0] * k + b[:, 2], 2.0 * b[:, 1] * c + b[:, 3]
        det = one_k * two_c - one_c * two_k
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            steps = np.array([one * two_c - two * one_c, two * one_k - one * two_k]) / det
        k, c = np.array([k, c]) - np.where(np.isfinite(steps), steps, 0.0)
    moved = np.stack([k, c], axis=-1)
    kept: FloatArray = moved[np.isfinite(moved).all(axis=1)]
    return kept


def _times(over: FloatArray) -> FloatArray:
    """Squares of quadratics (n, 3), descending, shape (n, 5)."""
    a, b, c = over.T
    return np.stack([a * a, 2.0 * a * b, b * b + 2.0 * a * c, 2.0 * b * c, c * c], axis=-1)


def _quartic(rows: FloatArray) -> FloatArray:
    """Real parts of all four roots of quartics (n, 5), descending; shape (n, 4), nan for constants."""
    size = np.abs(rows).max(axis=1)
    good = size > 0.0
    rows = rows / np.where(good, size, 1.0)[:, None]
    lead = np.where(np.abs(rows[:, 0]) < _SMALL, _SMALL, rows[:, 0])
    companion = np.zeros((len(rows), 4, 4))
    companion[:, 1, 0] = companion[:, 2, 1] = companion[:, 3, 2] = 1.0
    companion[:, 0, :] = -rows[:, 1:] / lead[:, None]
    roots = np.asarray(np.linalg.eigvals(companion).real, dtype=float)
    roots[~good] = np.nan
    return roots


def _quadratic(rows: FloatArray) -> FloatArray:
    """Roots of quadratics (..., 3), descending, real parts where they are complex, (..., 2); nan or inf for none."""
    a, b, c = np.moveaxis(rows, -1, 0)
    square = b * b - 4.0 * a * c
    root = np.sqrt(np.maximum(square, 0.0))
    large = -0.5 * (b + np.copysign(root, b))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.stack([large / a, np.where(square > 0.0, c / large, large / a)], axis=-1)
