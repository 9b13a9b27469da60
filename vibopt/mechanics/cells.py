"""Cells of the frequency axis that are short against the distance to the nearest pole."""

from __future__ import annotations

from itertools import pairwise
from math import asinh, ceil, inf, sinh

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray

REACH = 0.3
"""Half-width of a cell as a part of the distance from its middle to the nearest pole."""
_STEP = 2.0 * asinh(REACH)
_NO_DAMPING = 1e-8
_BESIDE = 1e3
_SLIVER = 1e-6
_MOST = 20_000

Stretches = tuple[tuple[float, float], ...]


def cells(poles: ComplexArray, stretches: Stretches) -> tuple[FloatArray, FloatArray, IntArray] | None:
    """Middles and half-widths of cells that cover the stretches, and the stretch of each; all shape (n,).

    None where a pole lies on a stretch, up to rounding.
    """
    near = nearest(poles)
    near.append((inf, 0.0, 0.0))
    found: list[float] = []
    counts: list[int] = []
    for low, high in stretches:
        edges = _edges(near, low, high)
        if edges is None or len(found) > _MOST:
            return None
        found += edges
        counts.append(len(edges))
    made = np.array(found)
    half = 0.5 * (made[1:] - made[:-1])
    middle, which = made[:-1] + half, np.arange(len(counts)).repeat(counts)[:-1]
    if len(counts) == 1:
        return middle, half, which
    inside = np.ones(len(half), dtype=bool)
    inside[np.cumsum(counts)[:-1] - 1] = False
    return middle[inside], half[inside], which[inside]


def _edges(near: list[tuple[float, float, float]], low: float, high: float) -> list[float] | None:
    """Edges of the cells of one stretch, ascending.

    Around a pole at a + i b they are a + b sinh(u) at even steps of u, so that their distance grows as that to the
    pole does; a itself is the middle of a cell, where a peak is concave.
    """
    edges: list[float] = []
    for (start, a, b), (stop, _, _) in pairwise(near):
        left, right = max(low, start), min(high, stop)
        if left >= right:
            continue
        beside = max(left - a, a - right)
        if b <= _NO_DAMPING * abs(a) and beside <= _BESIDE * _NO_DAMPING * abs(a):
            return None
        b = max(b, 1e-3 * beside)
        begin = ceil(asinh((left - a) / b) / _STEP + (0.5 + _SLIVER))
        end = ceil(asinh((right - a) / b) / _STEP + (0.5 - _SLIVER))
        edges.append(left)
        edges += [a + b * sinh(_STEP * (i - 0.5)) for i in range(begin, end)]
    edges.append(high)
    return edges


def nearest(poles: ComplexArray) -> list[tuple[float, float, float]]:
    """The poles that are nearest to some part of the axis, by that part: (where it begins, a, |b|), ascending.

    |w - p|^2 - w^2 = |p|^2 - 2 a w is a straight line for each pole; these are the lines of their lower envelope.
    Of two poles at +- a + i b only one can be nearest where w is not negative; with dashpots and structural damping
    together poles do not come in such pairs, and some lie below the axis.
    """
    found: list[tuple[float, float, float]] = []
    both = [(one.real, one.imag) for one in poles.tolist()]
    for a, b in sorted((a, abs(b)) for a, b in both if b < 0.0 or a >= -b):
        start = -inf
        while found:
            before, c, d = found[-1]
            at_once = inf if b >= d else -inf
            start = 0.5 * (a + c) + 0.5 * (b - d) * (b + d) / (a - c) if a > c else at_once
            if start > before:
                break
            found.pop()
            start = -inf
        if start < inf:
            found.append((start, a, b))
    return found
