"""Small convex quadratic programs by their working set: a handful of rows, a handful of unknowns.

Rows come in where they are most violated and leave where their price is negative.  That is no method for
every program, so the conditions of an optimum are checked at the end, and without them there is no answer.
"""

from __future__ import annotations

import numpy as np

from vibopt.arrays import FloatArray

_TURNS = 24
_EVEN = 1e-10
_FEASIBLE = 1e-11


def least_of(
    bend: FloatArray, linear: FloatArray, rows: FloatArray, right: FloatArray, working: list[int]
) -> tuple[FloatArray, FloatArray] | None:
    """Least z with 1/2 z bend z + linear z under rows z <= right: z (n,) and prices (n_rows,).

    Parameters
    ----------
    bend
        Shape (n, n), with no direction of negative bend.
    linear, rows, right
        Shapes (n,), (n_rows, n) and (n_rows,); rows of size about one.
    working
        Rows to begin with; together with `bend` they must hold z.

    Returns
    -------
    tuple[FloatArray, FloatArray] | None
        None where no optimum was found within a few turns.
    """
    n, seen = len(linear), set()
    working = list(working)
    for _ in range(_TURNS):
        key = frozenset(working)
        if key in seen or len(working) > n:
            return None
        seen.add(key)
        found = _held(bend, linear, rows[working], right[working])
        if found is None:
            return None
        z, prices = found
        if len(prices) and prices.min() < -_EVEN * max(float(np.abs(prices).max()), 1.0):
            working.pop(int(prices.argmin()))
            continue
        missed = rows @ z - right
        worst = int(missed.argmax())
        if missed[worst] <= _FEASIBLE or worst in working:
            every = np.zeros(len(right))
            every[working] = np.maximum(prices, 0.0)
            return (z, every) if missed[worst] <= 1e-9 else None
        working = _joined(bend, rows, working, worst, prices)
    return None


def _joined(bend: FloatArray, rows: FloatArray, working: list[int], fresh: int, prices: FloatArray) -> list[int]:
    """The working set with a row more; where it is full, the row goes that the new one drives to a price of nothing."""
    if len(working) < len(bend):
        return [*working, fresh]
    turn = np.linalg.lstsq(rows[working].T, rows[fresh], rcond=None)[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = np.where(turn > 1e-12, np.maximum(prices, 0.0) / turn, np.inf)
    out = int(reach.argmin())
    return [*working[:out], *working[out + 1 :], fresh]


def _held(
    bend: FloatArray, linear: FloatArray, rows: FloatArray, right: FloatArray
) -> tuple[FloatArray, FloatArray] | None:
    """Stationary point with these rows holding, and their prices."""
    n, m = len(linear), len(right)
    matrix = np.zeros((n + m, n + m))
    matrix[:n, :n], matrix[:n, n:], matrix[n:, :n] = bend, rows.T, rows
    try:
        solved = np.linalg.solve(matrix, np.concatenate([-linear, right]))
    except np.linalg.LinAlgError:
        return None
    return (solved[:n], solved[n:]) if np.isfinite(solved).all() and np.abs(solved[:n]).max() < 1e8 else None
