"""Algebra of stacked matrices, those of many machines side by side: "..." stands for what is in front.

Numbers may be complex with an imaginary part that is a slope, so nothing here conjugates.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.mechanics.panels import Numbers, exponential, exponentials

_NOTHING = 1e-12
"""Part of the sizes in a sum below which what is left of it is rounding, of a state, a reading or a damping."""
_AT_ONCE = 256
"""Exponentials that are made at once."""


def wide(numbers: Any) -> Numbers:
    """Numbers (...) as factors of matrices, (..., 1, 1)."""
    return np.asarray(numbers)[..., None, None]


def trace(matrix: Numbers) -> FloatArray:
    """Real part of the sum of what stands across, (...)."""
    return np.asarray(np.trace(matrix, axis1=-2, axis2=-1).real)


def row_sum(matrix: FloatArray) -> FloatArray:
    """The greatest sum of sizes in a row, (...)."""
    return np.asarray(np.abs(matrix).sum(axis=-1).max(axis=-1))


def product(left: Numbers, right: Numbers) -> Numbers:
    """Product without what is left of sums that cancel; real, or complex with the imaginary part as a slope."""
    found = np.asarray(left @ right)
    kept = np.abs(found.real) > _NOTHING * (np.abs(left.real) @ np.abs(right.real))
    if not np.iscomplexobj(found):
        return np.where(kept, found, 0.0)
    size = np.abs(left.real) @ np.abs(right.imag) + np.abs(left.imag) @ np.abs(right.real)
    slopes = np.where(np.abs(found.imag) > _NOTHING * size, found.imag, 0.0)
    return np.asarray(np.where(kept, found.real, 0.0) + 1j * slopes)


def moved(row: Numbers, a: Numbers, start: Numbers) -> Numbers:
    """row . exp(a) start of each, (...)."""
    return np.asarray((row[..., None, :] @ exponential(a) @ start[..., None])[..., 0, 0])


def read_at(row: Numbers, a: Numbers, parts: FloatArray, starts: Numbers) -> FloatArray:
    """row . z at parts of a piece of time (n,), 0 to 1, each from its own start, (n, N) or (1, N)."""
    starts = np.broadcast_to(starts, (len(parts), len(a)))
    found = [
        np.einsum("i,nij,nj->n", row, exponentials(a, parts[k : k + _AT_ONCE]), starts[k : k + _AT_ONCE], optimize=True)
        for k in range(0, len(parts), _AT_ONCE)
    ]
    return np.concatenate([np.zeros(0), *found])


def stepped(step: Numbers, start: Numbers, count: int) -> Numbers:
    """States (..., count + 1, N): the start, and after each of so many like steps."""
    states = np.empty((*start.shape[:-1], count + 1, start.shape[-1]), dtype=np.result_type(step, start))
    states[..., 0, :] = start
    known, power = 1, step.mT
    while known <= count:
        more = min(known, count + 1 - known)
        states[..., known : known + more, :] = states[..., :more, :] @ power
        known, power = known + more, power @ power
    return states


def cholesky(matrix: Numbers) -> Numbers:
    """L with L L^T = matrix, without a conjugate, (..., n, n)."""
    if not np.iscomplexobj(matrix):
        return np.asarray(np.linalg.cholesky(matrix))
    lower = np.linalg.cholesky(matrix.real)
    inner = np.linalg.solve(lower, np.linalg.solve(lower, matrix.imag).mT)
    half = np.tril(inner, -1)
    own = np.arange(matrix.shape[-1])
    half[..., own, own] = 0.5 * inner[..., own, own]
    return np.asarray(lower + 1j * lower @ half)
