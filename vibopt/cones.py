"""Cone programs from arrays, without a modelling layer: the one place where Clarabel is set up, and their builder."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from itertools import groupby
from types import SimpleNamespace
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.records import dataclass

LINEAR, CONE, EQUAL = "linear", "cone", "equal"
Kind = tuple[str, int]
"""LINEAR, CONE (its first row is the length of the others at least) or EQUAL, and how many rows."""
ITERATIONS = 200  # the solver takes some 10 to 40
TOLERANCE = 1e-11
_NONE = np.zeros(0, dtype=np.int64)
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

    if quadratic is None:
        P = _by_places(_NONE, _NONE, np.zeros(0), (len(linear), len(linear)))
    else:
        P = quadratic if isinstance(quadratic, SimpleNamespace) else compressed(np.triu(quadratic))
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
    return _by_places(rows, columns, dense[rows, columns], (dense.shape[0], dense.shape[1]))


def _by_places(rows: IntArray, columns: IntArray, data: FloatArray, shape: tuple[int, int]) -> SimpleNamespace:
    """A matrix of its entries, which go down one column after the other."""
    starts = np.zeros(shape[1] + 1, dtype=np.int64)
    np.cumsum(np.bincount(columns, minlength=shape[1]), out=starts[1:])
    return by_columns(data, rows, starts, shape)


def by_columns(data: FloatArray, rows: Any, starts: Any, shape: tuple[int, int]) -> SimpleNamespace:
    """What the solver reads of a matrix of scipy's that is compressed by columns."""
    return SimpleNamespace(
        data=data, indices=rows.astype(np.int64, copy=False), indptr=starts.astype(np.int64, copy=False), shape=shape,
        has_canonical_format=True, has_sorted_indices=True,
    )  # fmt: skip


def over_parts(M: ComplexArray) -> FloatArray:
    """Real, then imaginary parts of M x over those of x: M (n_rows, n), (2, n_rows, 2 n)."""
    rows, n = np.empty((2, len(M), 2 * M.shape[1])), M.shape[1]
    rows[0, :, :n] = rows[1, :, n:] = M.real
    rows[0, :, n:], rows[1, :, :n] = -M.imag, M.imag
    return rows


Slots = IntArray
Entries = tuple[Any, Any, Any]
"""Rows, helpers and values of entries of A."""


class Cones:
    """A program put together cone by cone: b - A (x, helpers) lies in them, A dense over x and sparse over helpers.

    Moduli are those of affine rows over a complex x (n_planes,), of which n = 2 n_planes parts are the variables.
    """

    def __init__(self, n_planes: int) -> None:
        self.n = 2 * n_planes
        self.dense: list[FloatArray] = []
        self.b: list[FloatArray] = []
        self.entries: list[Entries] = []
        self.kinds: list[Kind] = []
        self.n_rows = 0
        self.cost, self.square = np.zeros(0), np.zeros(0)

    def helpers(self, many: int, cost: float | FloatArray = 0.0, square: float = 0.0) -> Slots:
        """So many more helpers h, each with the cost cost h + square h² / 2."""
        slots = len(self.cost) + np.arange(many)
        self.cost = np.concatenate([self.cost, np.full(many, cost)])
        self.square = np.concatenate([self.square, np.full(many, square)])
        return slots

    def moduli(
        self, slope: ComplexArray, constant: ComplexArray, bound: float | FloatArray, slots: Sequence[Slots] = ()
    ) -> int:
        """|slope x + constant| <= bound + helpers of `slots`, one cone a row; the place of the first row."""
        count, start = len(constant), self.n_rows
        dense, b = np.zeros((count, 3, self.n)), np.empty((count, 3))
        dense[:, 1:] = -over_parts(slope).swapaxes(0, 1)
        b[:, 0], b[:, 1], b[:, 2] = bound, constant.real, constant.imag
        self._put(dense.reshape(-1, self.n), b.reshape(-1))
        heads = start + 3 * np.arange(count)
        for slot in slots:
            self.entries.append((heads, np.full(count, slot), np.full(count, -1.0)))
        self.kinds += [(CONE, 3)] * count
        return start

    def linear(self, dense: FloatArray, b: FloatArray, entries: Entries | None = None) -> None:
        """dense x + entries, whose rows count from here, <= b."""
        if entries is not None:
            self.entries.append((self.n_rows + entries[0], entries[1], entries[2]))
        self._put(dense, b)
        self.kinds.append((LINEAR, len(b)))

    def least(self, by: str, slope: ComplexArray, constant: ComplexArray, huber: float, rows: int = 0) -> int:
        """As cost |slope x + constant|: "worst", "sum", "rms" (of `rows`), "huber"; the place of the first row."""
        count = len(constant)
        if by == "rms":
            return self._norm(slope, constant, self.helpers(1, 1.0 / np.sqrt(rows or count)))
        if by == "worst":
            return self.moduli(slope, constant, 0.0, (self.helpers(1, 1.0),))
        if by == "sum":
            return self.moduli(slope, constant, 0.0, (self.helpers(count, 1.0),))
        inside, beyond = self.helpers(count, square=2.0), self.helpers(count, 2.0 * huber)
        start = self.moduli(slope, constant, 0.0, (inside, beyond))
        self.linear(np.zeros((count, self.n)), np.zeros(count), (np.arange(count), beyond, -np.ones(count)))
        return start

    def _norm(self, slope: ComplexArray, constant: ComplexArray, slot: Slots) -> int:
        """Norm of the whole vector slope x + constant <= one helper, one cone; the place of its first row."""
        start, one = self.n_rows, np.zeros(1)
        self._put(
            np.concatenate([np.zeros((1, self.n)), *-over_parts(slope)]),
            np.concatenate([one, constant.real, constant.imag]),
        )
        self.entries.append((np.array([start]), slot, np.array([-1.0])))
        self.kinds.append((CONE, 2 * len(constant) + 1))
        return start

    def _put(self, dense: FloatArray, b: FloatArray) -> None:
        self.dense.append(dense)
        self.b.append(b)
        self.n_rows += len(b)

    def rows(self) -> tuple[FloatArray, FloatArray]:
        """The dense part of A, and b."""
        return np.concatenate(self.dense), np.concatenate(self.b)

    def pulled(self, z: FloatArray) -> FloatArray:
        """A' z, for x and then the helpers."""
        helpers = np.zeros(len(self.cost))
        for rows, slots, values in self.entries:
            np.add.at(helpers, slots, values * z[rows])
        return np.concatenate([np.concatenate(self.dense).T @ z, helpers])

    def into_dual(self, z: FloatArray) -> FloatArray:
        """Multipliers brought into their cones, to which the solver keeps only to its tolerance."""
        inside, at = z.copy(), 0
        for (kind, many), alike in groupby(self.kinds):
            own = inside[at : at + many * len(list(alike))].reshape(-1, max(many, 1))  # a view: it is written to
            if kind == LINEAR:
                np.maximum(own, 0.0, out=own)
            else:
                own[:, 0] = np.maximum(own[:, 0], np.sqrt((own[:, 1:] ** 2).sum(axis=1)))
            at += own.size
        return inside

    def solve(
        self, cost: FloatArray | None = None, tolerance: float = TOLERANCE,
        along: tuple[FloatArray, FloatArray] | None = None,
    ) -> ConePoint:  # fmt: skip
        """The point (x, helpers); `cost` (n,) is that of x, and `along` (base, turn) asks for x = base + turn y."""
        n, more = self.n, len(self.cost)
        if not self.n_rows:
            return ConePoint(np.zeros(n + more), np.zeros(0), "Solved")
        dense, b = self.rows()
        if along is not None:
            base, turn = along
            dense, b, n = dense @ turn, b - dense @ base, turn.shape[1]
        bent = n + np.flatnonzero(self.square)
        P = _by_places(bent, bent, self.square[bent - n], (n + more, n + more))
        q = np.concatenate([np.zeros(n) if cost is None else cost, self.cost])
        cone_point = solve_cones(q, self._table(dense), b, self.kinds, quadratic=P, tolerance=tolerance)
        if along is None:
            return cone_point
        return ConePoint(
            np.concatenate([base + turn @ cone_point.x[:n], cone_point.x[n:]]), cone_point.z, cone_point.status
        )

    def _table(self, dense: FloatArray) -> SimpleNamespace:
        """A, compressed by columns."""
        columns, rows = np.nonzero(dense.T)
        parts = [(rows, columns, dense[rows, columns])]
        if self.entries:
            own, slots, values = map(np.concatenate, zip(*self.entries, strict=True))
            order = np.lexsort((own, slots))
            parts.append((own[order], dense.shape[1] + slots[order], values[order]))
        shape = (self.n_rows, dense.shape[1] + len(self.cost))
        rows, columns, data = map(np.concatenate, zip(*parts, strict=True))
        return _by_places(rows, columns, data, shape)
