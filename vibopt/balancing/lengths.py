"""Programs over lengths of affine complex rows: their sum, or the greatest.

What is chosen are real numbers within ends, and complex ones within discs: shares and counterweights of an engine.
Convex, solved as second-order cones by Clarabel; the gap is our own arithmetic on its dual point.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from vibopt.balancing.question import combined
from vibopt.cones import Cones
from vibopt.records import dataclass
from vibopt.work import worked

PROVEN = 1e-7
_TIGHT = 0.01
_PULLS, _INSIDE, _ALIKE = 12, 1e-9, 1e-3
_NOISE = 1e-6
"""Part of the goal that all of a bound would have to be worth for it to count."""
REACH = 1e3
"""Choices without a cap are searched up to this many times the size that matters; the claim says so."""


@dataclass(frozen=True)
class Lengths:
    """|constant + slope x| row by row, taken together.

    constant
        Shape (n_rows,).
    slope
        Shape (n_rows, n_x).
    by
        "sum", or "worst" (the greatest).
    limit
        Greatest value; not used for the goal.
    """

    constant: ComplexArray
    slope: ComplexArray
    by: Literal["sum", "worst"] = "sum"
    limit: float = float("inf")

    def value(self, x: FloatArray) -> float:
        """Of the lengths at x."""
        return float(combined(self.by, np.abs(self.constant + self.slope @ x)))


@dataclass(frozen=True)
class Box:
    """Bounds: first each of `shares` in [low, high], then pairs (re, im) no longer than `caps`."""

    shares: tuple[tuple[float, float], ...]
    caps: tuple[float, ...]

    @property
    def size(self) -> int:
        return len(self.shares) + 2 * len(self.caps)


@dataclass(frozen=True)
class Pulls:
    """What the goal falls by where a bound is wider, per unit of it: ends of shares, caps, and limits."""

    shares: FloatArray
    caps: FloatArray
    limits: FloatArray


@dataclass(frozen=True)
class Least:
    """The answer: x [SI] or None, its goal, a bound no allowed x can beat, the status, its claim, and what pulls."""

    x: FloatArray | None
    value: float
    bound: float
    status: str
    claim: str
    pulls: Pulls | None = None


def _posed(goal: Lengths, limits: Sequence[Lengths], box: Box, scale: FloatArray, size: float) -> _Posed:
    """The goal over `size`, within limits and box, over x / scale."""
    cones, cost = Cones(box.size), np.zeros(box.size)
    first, low, high = len(box.shares), *np.array(box.shares).reshape(-1, 2).T
    rows, ends = np.eye(first, box.size) * scale[:first, None], np.concatenate([high, -low])
    kept = np.isfinite(ends)
    cones.linear(np.concatenate([rows, -rows])[kept], ends[kept])
    at = first + 2 * np.arange(len(box.caps))
    slope = np.zeros((len(at), box.size), dtype=complex)
    slope[np.arange(len(at)), at], slope[np.arange(len(at)), at + 1] = 1.0, 1j
    heads = cones.moduli(slope, np.zeros(len(at), dtype=complex), np.minimum(np.array(box.caps) / scale[at], REACH))
    uppers = np.where(kept[:first], np.cumsum(kept[:first]) - 1, -1)
    places = [uppers, heads + 3 * np.arange(len(at))]
    units = [np.where(kept[:first], size, 0.0), size / scale[at]]
    if goal.by == "sum":
        cost, _ = _sum(cones, goal, box, scale / size, size, 1.0)
    else:
        cones.least("worst", goal.slope * scale / size, goal.constant / size, 0.0)
    for limit in limits:
        reached = float((np.abs(limit.constant) + np.abs(limit.slope) @ scale).max()) or size
        own = limit.limit if limit.limit > _TIGHT * reached else reached  # far below rows are met in their size
        units.append(np.array([size / own]))
        if limit.by == "worst":
            start = cones.moduli(limit.slope * scale / own, limit.constant / own, limit.limit / own)
            places.append(start + 3 * np.arange(len(limit.constant)))
            continue
        row, tops = _sum(cones, limit, box, scale / own, own, 0.0)
        places.append(np.array([cones.n_rows]))
        cones.linear(row[None], np.array([limit.limit / own]), (0 * tops, tops, np.ones(len(tops))))
    return _Posed(cones, cost, places, units)


def _sum(
    cones: Cones, lengths: Lengths, box: Box, scale: FloatArray, size: float, cost: float
) -> tuple[FloatArray, IntArray]:
    """The sum of the lengths over `size`: a row of those that are plain sums of shares, and helpers for the others."""
    bent = _bent(lengths, box)
    heads = cones.helpers(int(bent.sum()), cost)
    cones.moduli(lengths.slope[bent] * scale, lengths.constant[bent] / size, 0.0, (heads,))
    return np.asarray((lengths.slope[~bent] * scale).real.sum(axis=0)), heads


@dataclass(frozen=True)
class _Posed:
    """A program, what x itself costs in it, and the rows of its ends, caps and limits with the unit of each."""

    cones: Cones
    cost: FloatArray
    places: list[IntArray]
    units: list[FloatArray]

    def run(self, box: Box, scale: FloatArray) -> _Point:
        """The solver's point, its multipliers brought into their cones, and the bound that they prove."""
        cones, n = self.cones, self.cones.n + len(self.cones.cost)
        worked(0.5 + 0.003 * cones.n_rows * n)
        cone_point = cones.solve(self.cost)
        x, z = cone_point.x, cones.into_dual(cone_point.z)
        with np.errstate(invalid="ignore", over="ignore"):  # a ray that is not finite proves nothing
            back, falls = cones.pulled(z), float(cones.rows()[1] @ z)
            room = np.maximum(np.abs(x) * 2.0, 1.0)
            most = np.concatenate([[high for _, high in box.shares], np.repeat(box.caps, 2)])
            room[: box.size] = np.minimum(REACH, 1.0 + most / scale)
            slack = np.concatenate([self.cost, cones.cost]) + back
            bound = -falls - float(np.abs(slack) @ room)
            ray = falls < 0.0 and bool(np.abs(back).max() * REACH * (1.0 + n) < -falls)
        ends, caps, *limits = (z[at] * unit for at, unit in zip(self.places, self.units, strict=True))
        pulls = Pulls(ends, caps, np.array([limit.sum() for limit in limits]))
        return _Point(x, cone_point.status, bound, ray, bool(np.isfinite(x).all() and np.isfinite(z).all()), pulls)


@dataclass(frozen=True)
class _Point:
    """Where the solver ended: scaled x, its word, a bound of the goal, whether its dual is a ray, finite, and pulls."""

    x: FloatArray
    status: str
    bound: float
    ray: bool
    finite: bool
    pulls: Pulls


def _bent(lengths: Lengths, box: Box) -> BoolArray:
    """Which rows are no sums of shares that are not negative, (n_rows,)."""
    plain = np.zeros(box.size, dtype=bool)
    plain[: len(box.shares)] = [low >= 0.0 for low, _ in box.shares]
    straight = (lengths.slope.imag == 0.0) & (lengths.slope.real >= 0.0) & (plain | (lengths.slope == 0.0))
    return np.asarray(~(straight.all(axis=1) & (lengths.constant == 0.0)))


def least(goal: Lengths, limits: Sequence[Lengths], box: Box) -> Least:
    """The x with the least goal that keeps the limits and the box."""
    scale = _scales([goal, *limits], box)
    size = float((np.abs(goal.constant) + np.abs(goal.slope) @ scale).max()) or 1.0
    run = _posed(goal, limits, box, scale, size).run(box, scale)
    if "Infeasible" in run.status:
        if run.ray:
            return Least(None, np.nan, np.inf, "infeasible", "no weights keep the limits: certified by a dual ray")
        return Least(None, np.nan, -np.inf, "unproven", "no weights were found, and that there are none is not proven")
    if not run.finite:
        return Least(None, np.nan, -np.inf, "unproven", f"the solver stopped ({run.status}) without an answer")
    x = _kept(into_box(run.x[: box.size] * scale, box), limits, box, scale)
    value = goal.value(x)
    broken = [limit for limit in limits if limit.value(x) > limit.limit * (1.0 + 1e-6) + 1e-9 * size]
    if broken or not np.isfinite(value):
        return Least(None, np.nan, -np.inf, "unproven", f"the solver stopped ({run.status}) without keeping the limits")
    bound = size * run.bound
    gap = max(value - bound, 0.0) / max(value, 1e-6 * size)
    status = "optimal" if gap <= PROVEN * 10.0 or value - bound <= 1e-9 * size else "feasible"
    said = f"gap {gap:.1e}" if value > 1e-9 * size else "the goal is zero to rounding, gap 0"
    claim = f"convex program, {said} by our own dual bound"
    return Least(x, value, bound, status, claim, _told(run.pulls, value, size, limits, box))


def _told(pulls: Pulls, value: float, size: float, limits: Sequence[Lengths], box: Box) -> Pulls:
    """What pulls by more than multipliers are known to; a goal of zero is held back by nothing."""
    bounds = [
        np.array([high for _, high in box.shares]),
        np.array(box.caps),
        np.array([limit.limit for limit in limits]),
    ]
    least = _NOISE * max(value, 1e-3 * size) if value > 1e-9 * size else np.inf
    parts = (pulls.shares, pulls.caps, pulls.limits)
    with np.errstate(invalid="ignore"):
        return Pulls(*(np.where(p * b > least, p, 0.0) for p, b in zip(parts, bounds, strict=True)))


def _kept(x: FloatArray, limits: Sequence[Lengths], box: Box, scale: FloatArray) -> FloatArray:
    """The nearest x that keeps the limits to their own last digits: the solver keeps them to those of their rows.

    As it is where pulling one limit in breaks another.
    """
    best, least_excess = x, excess(x, limits)
    for _ in range(_PULLS):
        broken = [limit for limit in limits if limit.limit < limit.value(x) * (1.0 - _INSIDE)]
        if least_excess <= _INSIDE or not broken:
            break
        rows, moves = [], []
        for lengths in broken:
            now, bound = lengths.constant + lengths.slope @ x, lengths.limit * (1.0 - 2.0 * _INSIDE)
            if lengths.by == "worst":  # each that is too long or nearly so, along itself
                far = np.abs(now) > lengths.limit * (1.0 - _INSIDE)
                rows.append((lengths.slope[far] * scale * (now[far].conj() / np.abs(now[far]))[:, None]).real)
                moves.append(bound - np.abs(now[far]))
                continue
            step = now * (bound / np.abs(now).sum() - 1.0)
            rows += [(lengths.slope * scale).real, (lengths.slope * scale).imag]
            moves += [step.real, step.imag]
        A, b = np.concatenate(rows), np.concatenate(moves)
        x = into_box(x + scale * np.linalg.lstsq(A, b, rcond=_ALIKE)[0], box)
        left = excess(x, limits)
        if left < least_excess:
            best, least_excess = x, left
    return best


def excess(x: FloatArray, limits: Sequence[Lengths]) -> float:
    """Greatest part by which a limit is broken; limits of nothing are told by their rows alone."""
    return max((limit.value(x) / limit.limit - 1.0 for limit in limits if limit.limit > 0.0), default=0.0)


def _scales(rows: Sequence[Lengths], box: Box) -> FloatArray:
    """Size of each x that matters: what cancels the constants and fills the limits of any row, no more than its cap."""
    scale = np.zeros(box.size)
    for row in rows:
        wanted = float(np.abs(row.constant).max(initial=0.0)) + (row.limit if np.isfinite(row.limit) else 0.0)
        slopes = np.abs(row.slope).max(axis=0, initial=0.0)
        scale = np.maximum(scale, np.divide(wanted, slopes, out=np.zeros(box.size), where=slopes > 0.0))
    first = len(box.shares)
    for k, cap in enumerate(box.caps):
        pair = slice(first + 2 * k, first + 2 * k + 2)
        scale[pair] = min(float(scale[pair].max()), cap)
    scale[scale == 0.0] = 1.0
    scale[:first] = 1.0
    return scale


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
