"""The extreme point of many sets of rows over a box, by enumeration of every place where it can be."""

from __future__ import annotations

import numpy as np

from vibopt.forms import FloatArray
from vibopt.study.many.rows import BoolArray, IndexArray

_ROOM = 4e-15
_FLAT = 1e-15


def extreme(
    table: FloatArray, low: FloatArray, high: FloatArray, goal: tuple[int, float], near: FloatArray | None = None
) -> FloatArray:
    """The best point of each question: k, and c where there is one; nan where no point meets all rows.

    Parameters
    ----------
    table
        Rows a k^2 + b k + g + d q <= 0 with q = c^2, shape (4, n_rows, count).
    low, high
        Box, shape (1,) or (2,).
    goal
        Which of (k, c) is made greatest (+1) or least (-1).
    near
        Values of k that are a little worse than the best is expected to be, shape (count,), nan where nothing is
        expected; it saves work, and where nothing as good is found all places are looked at.
    """
    place, sense = goal
    if near is not None and place == 0:
        best = _extreme(table, low, high, goal, np.where(np.isnan(near), -np.inf, sense * near / high[0]))
        again = ~(sense * best[0] >= sense * near) & ~np.isnan(near)
        if again.any():
            best[:, again] = _extreme(table[:, :, again], low, high, goal, None)
        return best
    return _extreme(table, low, high, goal, None)


def _extreme(
    table: FloatArray, low: FloatArray, high: FloatArray, goal: tuple[int, float], least: FloatArray | None
) -> FloatArray:
    """As `extreme`, looking only where sense * k / high >= least."""
    place, sense = goal
    plane = len(low) == 2
    size = np.array([high[0] ** 2, high[0], 1.0, high[1] ** 2 if plane else 1.0])
    rows = table * size[:, None, None]
    if plane:
        box = np.array([[0.0, 0.0], [0.0, 0.0], [-1.0, (low[1] / high[1]) ** 2], [1.0, -1.0]])
        rows = np.concatenate([rows, np.broadcast_to(box[:, :, None], (4, 2, rows.shape[2]))], axis=1)
    largest = np.abs(rows).max(axis=0)
    rows = rows / np.where(largest == 0.0, 1.0, largest)
    cuts = _cuts(rows, float(low[0] / high[0]), plane, vertices=place == 1)
    if least is not None:
        cuts = cuts[(sense * cuts >= least).any(axis=1)]
        if not len(cuts):
            return np.full((len(low), rows.shape[2]), np.nan)
    if not plane:
        good = _inside(rows, cuts)
        k = _chosen(cuts, good, sense)[0]
        return np.asarray(np.clip(k * high[0], low[0], high[0])[None])
    good, bottom, top = _interval(rows, cuts)
    if place == 0:
        k, at = _chosen(cuts, good, sense)
        q = bottom[at, np.arange(len(k))]
    else:
        q, at = _chosen(top if sense > 0 else bottom, good, sense)
        k = np.where(np.isnan(q), np.nan, cuts[at, np.arange(len(q))])
    c = np.sqrt(np.maximum(q, 0.0)) * high[1]
    found = np.stack([np.clip(k * high[0], low[0], high[0]), np.clip(c, low[1], high[1])])
    found[:, np.isnan(k)] = np.nan
    return found


def _chosen(values: FloatArray, good: BoolArray, sense: float) -> tuple[FloatArray, IndexArray]:
    """Greatest or least good value of each column, nan where none is good, and its index."""
    ranked = np.where(good, values if sense > 0 else -values, -np.inf)
    at = ranked.argmax(axis=0)
    best = ranked[at, np.arange(values.shape[1])]
    return np.where(np.isneginf(best), np.nan, sense * best), at


def _cuts(rows: FloatArray, low: float, plane: bool, *, vertices: bool) -> FloatArray:
    """Every k at which the feasible set may open, close or turn; what lies outside the box becomes its end."""
    a, b, g, d = rows
    if plane:
        i, j = np.triu_indices(rows.shape[1] - 1, 1)
        last = rows.shape[1] - 1
        i, j = np.append(i, np.arange(last - 1)), np.append(j, np.full(last - 1, last))
        a, b, g = (one[i] * d[j] - one[j] * d[i] for one in (a, b, g))
    square = b * b - 4.0 * a * g
    near = square >= -1e-14 * (b * b + np.abs(4.0 * a * g))
    large = -0.5 * (b + np.copysign(np.sqrt(np.maximum(square, 0.0)), b))
    with np.errstate(all="ignore"):
        first, second = large / a, g / large
        turns = -rows[1] / (2.0 * rows[0]) if vertices else rows[0, :0]
    found = np.concatenate([np.where(near, first, low), np.where(near, second, low), turns])
    found[~((found >= low) & (found <= 1.0))] = low
    found = found[(found > low).any(axis=1)]
    return np.concatenate([found, np.full((1, rows.shape[2]), low), np.ones((1, rows.shape[2]))])


def _inside(rows: FloatArray, k: FloatArray) -> BoolArray:
    good = np.ones(k.shape, dtype=bool)
    for a, b, g in zip(rows[0], rows[1], rows[2], strict=True):
        size = (np.abs(a) * k + np.abs(b)) * k + np.abs(g)
        good &= (a * k + b) * k + g <= 1e-14 * size
    return good


def _interval(rows: FloatArray, k: FloatArray) -> tuple[BoolArray, FloatArray, FloatArray]:
    """Whether some q meets all rows at each k, rounding allowed for, and the ends of its interval."""
    good = np.ones(k.shape, dtype=bool)
    top, bottom = np.full(k.shape, np.inf), np.full(k.shape, -np.inf)
    wide_top, wide_bottom = top.copy(), bottom.copy()
    for a, b, g, d in zip(*rows, strict=True):
        flat = np.abs(d) <= _FLAT
        inverse = -1.0 / np.where(flat, 1.0, d)
        value = ((a * k + b) * k + g) * inverse
        room = _ROOM * (((np.abs(a) * k + np.abs(b)) * k + np.abs(g)) * np.abs(inverse))
        if flat.any():
            good &= ~flat | (-value <= room)
        up, down = (d > 0.0) & ~flat, (d < 0.0) & ~flat
        if up.any():
            over = value if up.all() else np.where(up, value, np.inf)
            top, wide_top = np.minimum(top, over), np.minimum(wide_top, over + room)
        if down.any():
            under = value if down.all() else np.where(down, value, -np.inf)
            bottom, wide_bottom = np.maximum(bottom, under), np.maximum(wide_bottom, under - room)
    good &= wide_top >= wide_bottom
    return good, bottom, np.maximum(top, bottom)
