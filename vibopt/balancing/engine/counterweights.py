"""The program behind an engine's weights: lengths of affine complex rows, summed or the greatest of them.

Convex, solved as second-order cones by Clarabel; the gap is our own arithmetic on its dual point.
"""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.cones import CONE, LINEAR, solve_cones
from vibopt.records import dataclass
from vibopt.work import worked

PROVEN = 1e-7
REACH = 1e3
"""Choices without a cap are searched up to this many times the size that matters; the claim says so."""


@dataclass(frozen=True)
class Lengths:
    """|constant + slope x| row by row, added up, or the greatest of them (`worst`).

    constant
        Shape (n_rows,).
    slope
        Shape (n_rows, n_x).
    limit
        Greatest value; not used for the goal.
    """

    constant: ComplexArray
    slope: ComplexArray
    worst: bool = False
    limit: float = float("inf")

    def value(self, x: FloatArray) -> float:
        """Sum or greatest of the lengths at x."""
        sizes = np.abs(self.constant + self.slope @ x)
        return float(sizes.max() if self.worst else sizes.sum())


@dataclass(frozen=True)
class Box:
    """Bounds: first each of `shares` in [low, high], then pairs (re, im) no longer than `caps`."""

    shares: tuple[tuple[float, float], ...]
    caps: tuple[float, ...]

    @property
    def size(self) -> int:
        return len(self.shares) + 2 * len(self.caps)


@dataclass(frozen=True)
class Least:
    """The answer: x [SI] or None, its goal, a bound no allowed x can beat, and the status with its claim."""

    x: FloatArray | None
    value: float
    bound: float
    status: str
    claim: str


class _Cones:
    """Rows of A x + s = b in cones, collected."""

    def __init__(self) -> None:
        self.rows: list[FloatArray] = []
        self.ends: list[float] = []
        self.kinds: list[tuple[str, int]] = []

    def below(self, row: FloatArray, end: float) -> None:
        """row x <= end."""
        self.rows.append(row)
        self.ends.append(end)
        self.kinds.append((LINEAR, 1))

    def length(self, head: FloatArray, head_end: float, slope: ComplexArray, constant: complex) -> None:
        """|slope x + constant| <= head x + head_end."""
        self.rows += [-head, -slope.real, -slope.imag]
        self.ends += [head_end, constant.real, constant.imag]
        self.kinds.append((CONE, 3))


def least(goal: Lengths, limits: Sequence[Lengths], box: Box) -> Least:
    """The x with the least goal that keeps the limits and the box."""
    n, n_goal = box.size, 1 if goal.worst else len(goal.constant)
    scale = _scales([goal, *limits], box)
    size = float((np.abs(goal.constant) + np.abs(goal.slope) @ scale).max()) or 1.0
    n_all = n + n_goal + sum(0 if one.worst else len(one.constant) for one in limits)
    cones = _Cones()
    _add_box(cones, box, scale, n_all)
    _add_lengths(cones, goal, size, scale, n, n_all)
    at = n + n_goal
    for one in limits:
        own = one.limit or size
        if one.worst:
            for constant, slope in zip(one.constant, one.slope, strict=True):
                cones.length(np.zeros(n_all), one.limit / own, _wide(slope * scale / own, n_all), constant / own)
            continue
        _add_lengths(cones, one, own, scale, at, n_all)
        total = np.zeros(n_all)
        total[at : at + len(one.constant)] = 1.0
        cones.below(total, one.limit / own)
        at += len(one.constant)
    q = np.zeros(n_all)
    q[n : n + n_goal] = 1.0
    return _judge(goal, limits, box, _run(q, cones), q, size, scale)


def _add_lengths(cones: _Cones, one: Lengths, size: float, scale: FloatArray, at: int, n_all: int) -> None:
    """One helper variable per row, or one for all where the greatest counts."""
    for k, (constant, slope) in enumerate(zip(one.constant, one.slope, strict=True)):
        head = np.zeros(n_all)
        head[at if one.worst else at + k] = 1.0
        cones.length(head, 0.0, _wide(slope * scale / size, n_all), constant / size)


def _add_box(cones: _Cones, box: Box, scale: FloatArray, n_all: int) -> None:
    first = len(box.shares)
    for k, (low, high) in enumerate(box.shares):
        row = np.zeros(n_all)
        row[k] = scale[k]
        if np.isfinite(high):
            cones.below(row, high)
        cones.below(-row, -low)
    for k, cap in enumerate(box.caps):
        at = first + 2 * k
        slope = np.zeros(n_all, dtype=complex)
        slope[at], slope[at + 1] = 1.0, 1j
        cones.length(np.zeros(n_all), min(cap / scale[at], REACH), slope, 0j)


def _wide(slope: ComplexArray, n_all: int) -> ComplexArray:
    """A row over x as a row over x and the helpers."""
    row = np.zeros(n_all, dtype=complex)
    row[: len(slope)] = slope
    return row


def _scales(rows: Sequence[Lengths], box: Box) -> FloatArray:
    """Size of each x that matters: what cancels the constants and fills the limits of any row, no more than its cap."""
    scale = np.zeros(box.size)
    for one in rows:
        wanted = float(np.abs(one.constant).max(initial=0.0)) + (one.limit if np.isfinite(one.limit) else 0.0)
        slopes = np.abs(one.slope).max(axis=0, initial=0.0)
        scale = np.maximum(scale, np.divide(wanted, slopes, out=np.zeros(box.size), where=slopes > 0.0))
    first = len(box.shares)
    for k, cap in enumerate(box.caps):
        pair = slice(first + 2 * k, first + 2 * k + 2)
        scale[pair] = min(float(scale[pair].max()), cap)
    scale[scale == 0.0] = 1.0
    scale[:first] = 1.0
    return scale


def _run(q: FloatArray, cones: _Cones) -> Any:
    """The solver's point with its multipliers made feasible; `x`, `z`, `status`, and the rows `A`, `b` they are of."""
    order = sorted(range(len(cones.kinds)), key=lambda k: cones.kinds[k][0] == CONE)
    starts = np.concatenate([[0], np.cumsum([many for _, many in cones.kinds])])
    rows = np.concatenate([np.arange(starts[k], starts[k + 1]) for k in order])
    many = sum(1 for kind, _ in cones.kinds if kind == LINEAR)
    worked(0.5 + 0.003 * len(cones.rows) * len(q))
    A, b = np.array(cones.rows)[rows], np.array(cones.ends)[rows]
    found = solve_cones(q, A, b, [(LINEAR, many), *[(CONE, 3)] * (len(cones.kinds) - many)])
    z = found.z
    z[:many] = np.maximum(z[:many], 0.0)
    heads = z[many::3]
    heads[:] = np.maximum(heads, np.hypot(z[many + 1 :: 3], z[many + 2 :: 3]))
    return SimpleNamespace(x=found.x, z=z, status=found.status, A=A, b=b)


def _judge(
    goal: Lengths, limits: Sequence[Lengths], box: Box, run: Any, q: FloatArray, size: float, scale: FloatArray
) -> Least:
    """What Clarabel's points prove by our own arithmetic."""
    if "Infeasible" in run.status:
        with np.errstate(invalid="ignore", over="ignore"):  # a ray that is not finite proves nothing
            certificate, falls = run.A.T @ run.z, float(run.b @ run.z)
        reach = REACH * (1.0 + len(q))
        if falls < 0.0 and np.abs(certificate).max() * reach < -falls:
            return Least(None, np.nan, np.inf, "infeasible", "no weights keep the limits: certified by a dual ray")
        return Least(None, np.nan, -np.inf, "unproven", "no weights were found, and that there are none is not proven")
    if not (np.isfinite(run.x).all() and np.isfinite(run.z).all()):
        return Least(None, np.nan, -np.inf, "unproven", f"the solver stopped ({run.status}) without an answer")
    x = into_box(run.x[: box.size] * scale, box)
    value = goal.value(x)
    broken = [one for one in limits if one.value(x) > one.limit * (1.0 + 1e-6) + 1e-9 * size]
    if broken or not np.isfinite(value):
        return Least(None, np.nan, -np.inf, "unproven", f"the solver stopped ({run.status}) without keeping the limits")
    slack = run.A.T @ run.z + q
    room = np.maximum(np.abs(run.x) * 2.0, 1.0)
    room[: box.size] = np.minimum(REACH, 1.0 + _box_reach(box, scale))
    bound = size * (-float(run.b @ run.z) - float(np.abs(slack) @ room))
    gap = max(value - bound, 0.0) / max(value, 1e-6 * size)
    status = "optimal" if gap <= PROVEN * 10.0 or value - bound <= 1e-9 * size else "feasible"
    said = f"gap {gap:.1e}" if value > 1e-9 * size else "the goal is zero to rounding, gap 0"
    return Least(x, value, bound, status, f"convex program, {said} by our own dual bound")


def _box_reach(box: Box, scale: FloatArray) -> FloatArray:
    """Greatest scaled size of each x."""
    reach = np.repeat(np.minimum(np.array(box.caps), 1e300), 2)
    reach = np.concatenate([[high for _, high in box.shares], reach])
    return np.asarray(np.minimum(reach / scale, REACH))


def into_box(x: FloatArray, box: Box) -> FloatArray:
    """x pulled back onto its bounds, to which the solver keeps only to its tolerance."""
    first = len(box.shares)
    inside = x.copy()
    for k, (low, high) in enumerate(box.shares):
        inside[k] = min(max(inside[k], low), high)
    for k, cap in enumerate(box.caps):
        pair = slice(first + 2 * k, first + 2 * k + 2)
        long = float(np.hypot(*inside[pair]))
        if long > cap:
            inside[pair] *= cap / long
    return inside
