"""One convex program as cones for Clarabel, from arrays alone (no scipy, no modelling layer)."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibopt.balancing.scaled import Scaled
from vibopt.cones import CONE, LINEAR, Kind, by_columns, solve_cones
from vibopt.forms import ComplexArray, FloatArray
from vibopt.records import dataclass
from vibopt.work import worked

Rows = NDArray[np.intp]
INSIDE = 20.0  # limits are drawn in by so many tolerances (2e-9 at most), the solver's own slack stays inside them


@dataclass(frozen=True)
class ConeAnswer:
    """x (n_planes,), multipliers z of the goal rows and v of the limit rows (full length, zero where not used)."""

    x: ComplexArray
    z: ComplexArray
    v: ComplexArray
    status: str


class _Blocks:
    """Cones row by row: b - A x lies in them; A = [dense part over Re x, Im x | sparse part over the rest]."""

    def __init__(self, n_planes: int) -> None:
        self.n_planes = n_planes
        self.dense: list[FloatArray] = []
        self.b: list[FloatArray] = []
        self.entries: list[tuple[Any, Any, Any]] = []
        self.cones: list[Kind] = []
        self.n_rows = 0

    def moduli(self, M: ComplexArray, c: ComplexArray, bound: FloatArray, slots: Any) -> int:
        """|M x + c| <= bound + the extra variables of `slots`, one cone per row; the place of the first row."""
        count, start = len(c), self.n_rows
        dense = np.zeros((count, 3, 2 * self.n_planes))
        dense[:, 1, : self.n_planes], dense[:, 1, self.n_planes :] = -M.real, M.imag
        dense[:, 2, : self.n_planes], dense[:, 2, self.n_planes :] = -M.imag, -M.real
        b = np.stack([bound, c.real, c.imag], axis=1)
        self._put(dense.reshape(-1, 2 * self.n_planes), b.reshape(-1))
        heads = start + 3 * np.arange(count)
        for slot in slots:
            self.entries.append((heads, np.broadcast_to(slot, count), np.full(count, -1.0)))
        self.cones += [(CONE, 3)] * count
        return start

    def norm(self, M: ComplexArray, c: ComplexArray, slot: int) -> int:
        """Norm of the whole vector M x + c <= the extra variable `slot`, one cone; its first row's place."""
        start, count = self.n_rows, len(c)
        dense = np.zeros((2 * count + 1, 2 * self.n_planes))
        dense[1 : count + 1] = np.hstack([-M.real, M.imag])
        dense[count + 1 :] = np.hstack([-M.imag, -M.real])
        self._put(dense, np.concatenate([[0.0], c.real, c.imag]))
        self.entries.append((np.array([start]), np.array([slot]), np.array([-1.0])))
        self.cones.append((CONE, 2 * count + 1))
        return start

    def linear(self, dense: FloatArray, b: FloatArray, entries: tuple[Any, Any, Any] | None = None) -> None:
        """dense @ [Re x, Im x] + entries <= b."""
        if entries is not None:
            self.entries.append((self.n_rows + entries[0], entries[1], entries[2]))
        self._put(dense, b)
        self.cones.append((LINEAR, len(b)))

    def _put(self, dense: FloatArray, b: FloatArray) -> None:
        self.dense.append(dense)
        self.b.append(b)
        self.n_rows += len(b)

    def matrix(self, n_extra: int) -> SimpleNamespace:
        """A, compressed by columns."""
        dense = np.vstack(self.dense).T
        used = dense != 0
        rows = np.concatenate([entry[0] for entry in self.entries]) if self.entries else np.empty(0, int)
        slots = np.concatenate([entry[1] for entry in self.entries]) if self.entries else np.empty(0, int)
        values = np.concatenate([entry[2] for entry in self.entries]) if self.entries else np.empty(0)
        order = np.lexsort((rows, slots))
        counts = np.concatenate([used.sum(axis=1), np.bincount(slots, minlength=n_extra)])
        return by_columns(
            np.concatenate([dense[used], values[order]]),
            np.concatenate([np.nonzero(used)[1], rows[order]]),
            np.concatenate([[0], np.cumsum(counts)]),
            (self.n_rows, len(dense) + n_extra),
        )


def solve_cone(scene: Scaled, goal_rows: Rows, limit_rows: Rows, tolerance: float = 1e-11) -> ConeAnswer:
    """Solve with only these goal rows ("worst") and limit rows; all other goals take every goal row."""
    blocks = _Blocks(scene.n_planes)
    cost, square, heads = _goal(scene, blocks, goal_rows)
    first_limit = blocks.n_rows
    if len(limit_rows):
        blocks.moduli(
            scene.F[limit_rows], scene.f[limit_rows], np.full(len(limit_rows), 1.0 - min(INSIDE * tolerance, 2e-9)), ()
        )
    n_extra = _amounts(scene, blocks, len(cost))
    _arcs(scene, blocks)
    cost = np.concatenate([cost, scene.mass if scene.goal == "correction" else np.zeros(n_extra - len(cost))])
    worked(0.5 + 0.007 * (len(goal_rows) + len(limit_rows)) * scene.n_planes)
    x, dual, status = _solved(blocks, cost, square, tolerance)
    n = scene.n_planes
    z = np.zeros(len(scene.g), dtype=complex)
    z[goal_rows] = _multipliers(dual, heads, len(goal_rows), whole=scene.goal == "rms")
    v = np.zeros(len(scene.f), dtype=complex)
    v[limit_rows] = _multipliers(dual, first_limit, len(limit_rows), whole=False)
    return ConeAnswer(x[:n] + 1j * x[n : 2 * n], z, v, status)


def _multipliers(dual: FloatArray, first: int, count: int, whole: bool) -> ComplexArray:
    """Complex multipliers (the solver's with its sign turned) of `count` rows whose cones start at row `first`."""
    if whole:
        block = dual[first + 1 : first + 1 + 2 * count]
        return -(block[:count] + 1j * block[count:])
    triples = dual[first : first + 3 * count].reshape(-1, 3)
    return -(triples[:, 1] + 1j * triples[:, 2])


def _goal(scene: Scaled, blocks: _Blocks, rows: Rows) -> tuple[FloatArray, FloatArray, int]:
    """Linear and square cost of the extra variables, and the first row of the goal's cones."""
    none = np.zeros(0)
    G, g, zero = scene.G[rows], scene.g[rows], np.zeros(len(rows))
    if scene.goal == "correction":
        return none, none, 0
    if scene.goal == "rms":
        return np.array([1.0 / scene.divisor]), np.zeros(1), blocks.norm(G, g, 0)
    if scene.goal == "worst":
        return np.ones(1), np.zeros(1), blocks.moduli(G, g, zero, (0,))
    own = np.arange(len(rows))
    if scene.goal == "sum":
        return np.ones(len(rows)), np.zeros(len(rows)), blocks.moduli(G, g, zero, (own,))
    start = blocks.moduli(G, g, zero, (own, own + len(rows)))
    count = len(rows)
    blocks.linear(np.zeros((count, 2 * scene.n_planes)), zero, (own, own + count, -np.ones(count)))
    return np.repeat([0.0, 2.0 * scene.huber], count), np.repeat([2.0, 0.0], count), start


def _amounts(scene: Scaled, blocks: _Blocks, n_extra: int) -> int:
    """Caps, total and mass; where mass is counted each plane has |x| as an extra variable.  Number of extras."""
    planes = np.flatnonzero(np.isfinite(scene.caps))
    unit = np.eye(scene.n_planes, dtype=complex)
    nothing = np.zeros(scene.n_planes, dtype=complex)
    if scene.goal != "correction" and not np.isfinite(scene.total):
        if len(planes):
            blocks.moduli(unit[planes], nothing[planes], scene.caps[planes], ())
        return n_extra
    slots = n_extra + np.arange(scene.n_planes)
    blocks.moduli(unit, nothing, nothing.real, (slots,))
    flat = np.zeros((len(planes), 2 * scene.n_planes))
    if len(planes):
        blocks.linear(flat, scene.caps[planes], (np.arange(len(planes)), slots[planes], np.ones(len(planes))))
    if np.isfinite(scene.total):
        place = np.zeros(scene.n_planes, dtype=int)
        blocks.linear(np.zeros((1, 2 * scene.n_planes)), np.array([scene.total]), (place, slots, scene.mass))
    return n_extra + scene.n_planes


def _arcs(scene: Scaled, blocks: _Blocks) -> None:
    """Allowed arcs of half a turn at most: two half planes each."""
    n = scene.n_planes
    for plane, wedge in enumerate(scene.wedges):
        if wedge is None:
            continue
        middle, half = wedge
        edges = np.array([middle - half - 0.5 * np.pi, middle + half + 0.5 * np.pi])  # outward normals
        dense = np.zeros((2, 2 * n))
        dense[:, plane], dense[:, n + plane] = np.cos(edges), np.sin(edges)
        if half < 1e-12:  # a ray: forward along it as well
            dense = np.vstack([dense, np.zeros(2 * n)])
            dense[2, plane], dense[2, n + plane] = -np.cos(middle), -np.sin(middle)
        blocks.linear(dense, np.zeros(len(dense)))


def _solved(
    blocks: _Blocks, cost: FloatArray, square: FloatArray, tolerance: float
) -> tuple[FloatArray, FloatArray, str]:
    """Primal, dual and the solver's own word for how it ended."""
    n_extra, n = len(cost), 2 * blocks.n_planes
    if not blocks.n_rows:
        return np.zeros(n + n_extra), np.zeros(0), "Solved"
    diagonal = np.concatenate([np.zeros(n), square, np.zeros(n_extra - len(square))])
    places = np.flatnonzero(diagonal)
    starts = np.concatenate([[0], np.cumsum(diagonal != 0)])
    P = by_columns(diagonal[places], places, starts, (n + n_extra, n + n_extra))
    q, b = np.concatenate([np.zeros(n), cost]), np.concatenate(blocks.b)
    found = solve_cones(q, blocks.matrix(n_extra), b, blocks.cones, quadratic=P, tolerance=tolerance)
    return found.x, found.z, found.status
