"""Cone programs from arrays, without a modelling layer: the one place where Clarabel is set up."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.records import dataclass

LINEAR, CONE, EQUAL = "linear", "cone", "equal"
Kind = tuple[str, int]
"""LINEAR, CONE (its first row is the length of the others at least) or EQUAL, and how many rows."""
ITERATIONS = 200  # the solver takes some 10 to 40
TOLERANCE = 1e-11
SMALL = 200  # up to so many rows the plain factorisation is the faster one


@dataclass(frozen=True)
class ConePoint:
    """What the solver came to: x, multipliers z of the rows, and its own word for how it ended ("Solved")."""

    x: FloatArray
    z: FloatArray
    status: str

    @property
    def is_finite(self) -> bool:
        return bool(np.isfinite(self.x).all() and np.isfinite(self.z).all())


def solve_cones(
    linear: FloatArray,
    A: FloatArray | SimpleNamespace,
    b: FloatArray,
    kinds: Sequence[Kind],
    *,
    quadratic: FloatArray | SimpleNamespace | None = None,
    tolerance: float = TOLERANCE,
) -> ConePoint:
    """Least 1/2 x quadratic x + linear x with b - A x in the product of `kinds`.

    Parameters
    ----------
    linear, quadratic
        Cost, (n,) and (n, n) symmetric; None: no square terms.
    A, b
        Rows of all cones in the order of `kinds`, (n_rows, n) and (n_rows,); a matrix may be `compressed` already.
    tolerance
        Of gap and feasibility.

    Notes
    -----
    Its answer is a point, no proof: whoever asks works out a bound from the multipliers by arithmetic of his own.
    """
    import clarabel

    square = np.zeros((len(linear), len(linear))) if quadratic is None else quadratic
    P = square if isinstance(square, SimpleNamespace) else compressed(np.triu(square))
    table = A if isinstance(A, SimpleNamespace) else compressed(A)
    of_kind = {LINEAR: clarabel.NonnegativeConeT, CONE: clarabel.SecondOrderConeT, EQUAL: clarabel.ZeroConeT}
    cones = [of_kind[kind](size) for kind, size in kinds if size]
    found = clarabel.DefaultSolver(P, linear, table, b, cones, _settings(tolerance, len(b) < SMALL)).solve()
    return ConePoint(np.array(found.x), np.array(found.z), str(found.status))


@cache
def _settings(tolerance: float, small: bool) -> Any:
    import clarabel

    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.presolve_enable = False
    settings.max_iter = ITERATIONS
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tolerance
    if small:
        settings.direct_solve_method = "qdldl"
    return settings


def compressed(dense: FloatArray) -> SimpleNamespace:
    """A matrix compressed by columns."""
    columns, rows = np.nonzero(dense.T)
    starts = np.concatenate([[0], np.cumsum(np.bincount(columns, minlength=dense.shape[1]))])
    return by_columns(dense.T[columns, rows], rows, starts, (dense.shape[0], dense.shape[1]))


def by_columns(data: FloatArray, rows: Any, starts: Any, shape: tuple[int, int]) -> SimpleNamespace:
    """What the solver reads of a matrix of scipy's that is compressed by columns."""
    return SimpleNamespace(
        data=data, indices=rows.astype(np.int64), indptr=starts.astype(np.int64), shape=shape,
        has_canonical_format=True, has_sorted_indices=True,
    )  # fmt: skip


__all__ = ["CONE", "EQUAL", "LINEAR", "ConePoint", "Kind", "by_columns", "compressed", "solve_cones"]
