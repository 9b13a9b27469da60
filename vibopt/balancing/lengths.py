"""Programs over lengths of affine complex rows: their sum, the greatest, their root mean square, or Huber's sum.

What is chosen are real numbers within ends, and complex ones within discs: shares and counterweights of an engine, the
parts of weights cut in two for neighbouring holes.  Convex, solved as second-order cones by Clarabel; the gap is our
own arithmetic on its dual point.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.question import combined
from vibopt.cones import CONE, LINEAR, solve_cones
from vibopt.records import dataclass
from vibopt.work import worked

PROVEN = 1e-7
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
        "sum", "worst" (the greatest), "rms", or "huber" (squares up to `huber`, then linear).
    limit
        Greatest value, of "sum" or "worst"; not used for the goal.
    """

    constant: ComplexArray
    slope: ComplexArray
    by: Literal["sum", "worst", "rms", "huber"] = "sum"
    limit: float = float("inf")
    huber: float = float("inf")

    def value(self, x: FloatArray) -> float:
        """Of the lengths at x."""
        return float(combined(self.by, np.abs(self.constant + self.slope @ x), self.huber))


@dataclass(frozen=True)
class Box:
    """Bounds: first each of `shares` in [low, high], then pairs (re, im) no longer than `caps`.

    unit
        Size of the shares that matters.
    """

    shares: tuple[tuple[float, float], ...]
    caps: tuple[float, ...]
    unit: float = 1.0

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


class _Program:
    """Rows of A x + s = b in cones, and the cost of x and its helpers, collected."""

    def __init__(self, goal: Lengths, limits: Sequence[Lengths], box: Box, scale: FloatArray) -> None:
        self.box, self.scale, self.at = box, scale, box.size
        self.bent = {id(one): _bent(one, box) for one in (goal, *limits) if one.by == "sum"}
        own = {"sum": 0, "worst": 1, "rms": 1, "huber": 2 * len(goal.constant)}[goal.by]
        self.n = box.size + own + sum(int(one.sum()) for one in self.bent.values())
        self.flat: list[tuple[FloatArray, FloatArray]] = []
        self.cones: list[tuple[FloatArray, FloatArray]] = []
        self.sizes: list[int] = []
        self.q, self.square = np.zeros(self.n), np.zeros(self.n)
        self._box()

    def _within(self, heads: FloatArray, ends: FloatArray | float, slope: ComplexArray, constant: ComplexArray) -> None:
        """|slope x + constant| <= heads x + ends, row by row; `heads` of one row are those of all."""
        many = len(constant)
        rows, right = np.empty((many, 3, self.n)), np.empty((many, 3))
        rows[:, 0], rows[:, 1], rows[:, 2] = -heads, -slope.real, -slope.imag
        right[:, 0], right[:, 1], right[:, 2] = ends, constant.real, constant.imag
        self.cones.append((rows.reshape(-1, self.n), right.ravel()))
        self.sizes += [3] * many

    def _box(self) -> None:
        first = len(self.box.shares)
        unit = np.eye(first, self.n) * self.scale[:first, None]
        low, high = np.array(self.box.shares).reshape(-1, 2).T
        ends = np.stack([high, -low], axis=1).ravel()
        kept = np.isfinite(ends)
        self.flat.append((np.stack([unit, -unit], axis=1).reshape(-1, self.n)[kept], ends[kept]))
        at = first + 2 * np.arange(len(self.box.caps))
        slope = np.zeros((len(at), self.n), dtype=complex)
        slope[np.arange(len(at)), at], slope[np.arange(len(at)), at + 1] = 1.0, 1j
        ends = np.minimum(np.array(self.box.caps) / self.scale[at], REACH)
        self._within(np.zeros(self.n), ends, slope, np.zeros(len(at), dtype=complex))

    def _helpers(self, many: int) -> FloatArray:
        """Rows that pick the next helpers."""
        picks = np.zeros((many, self.n))
        picks[np.arange(many), self.at + np.arange(many)] = 1.0
        self.at += many
        return picks

    def _wide(self, one: Lengths, size: float) -> tuple[ComplexArray, ComplexArray]:
        """Rows over x and the helpers, and constants, over `size`."""
        slope = np.zeros((len(one.constant), self.n), dtype=complex)
        slope[:, : self.box.size] = one.slope * self.scale / size
        return slope, one.constant / size

    def goal(self, one: Lengths, size: float) -> None:
        slope, constant = self._wide(one, size)
        if one.by == "rms":
            head = self._helpers(1)
            self.cones.append((np.concatenate([-head, -slope.real, -slope.imag]),
                               np.concatenate([[0.0], constant.real, constant.imag])))  # fmt: skip
            self.sizes.append(1 + 2 * len(constant))
            self.q += head[0] / np.sqrt(len(constant))
        elif one.by == "sum":
            self.q += self._sum(one, slope, constant)
        else:
            heads = self._helpers(1 if one.by == "worst" else len(constant))
            over = self._helpers(len(constant)) if one.by == "huber" else np.zeros((1, self.n))
            self._within(heads + over, 0.0, slope, constant)
            if one.by == "worst":
                self.q += heads[0]
                return
            self.square += 2.0 * heads.sum(axis=0)
            self.q += 2.0 * one.huber / size * over.sum(axis=0)
            self.flat.append((-over, np.zeros(len(over))))

    def limit(self, one: Lengths, size: float) -> None:
        slope, constant = self._wide(one, size)
        if one.by == "worst":
            self._within(np.zeros(self.n), one.limit / size, slope, constant)
        else:
            self.flat.append((self._sum(one, slope, constant)[None], np.array([one.limit / size])))

    def _sum(self, one: Lengths, slope: ComplexArray, constant: ComplexArray) -> FloatArray:
        """Row of the sum of the lengths: those that are plain sums of shares, and helpers for the others."""
        bent = self.bent[id(one)]
        heads = self._helpers(int(bent.sum()))
        self._within(heads, 0.0, slope[bent], constant[bent])
        return np.asarray(slope[~bent].real.sum(axis=0) + heads.sum(axis=0))

    def run(self) -> _Point:
        """The solver's point, its multipliers brought into their cones, and the bound that they prove."""
        A, b = (np.concatenate(part) for part in zip(*self.flat, *self.cones, strict=True))
        flat = len(b) - sum(self.sizes)
        worked(0.5 + 0.003 * len(b) * self.n)
        kinds = [(LINEAR, flat), *((CONE, many) for many in self.sizes)]
        found = solve_cones(self.q, A, b, kinds, quadratic=np.diag(self.square) if self.square.any() else None)
        x, z, at = found.x, found.z, flat
        z[:flat] = np.maximum(z[:flat], 0.0)
        for many in self.sizes:
            z[at] = max(z[at], float(np.linalg.norm(z[at + 1 : at + many])))
            at += many
        with np.errstate(invalid="ignore", over="ignore"):  # a ray that is not finite proves nothing
            back, falls = A.T @ z, float(b @ z)
            room = np.maximum(np.abs(x) * 2.0, 1.0)
            room[: self.box.size] = np.minimum(REACH, 1.0 + _box_reach(self.box, self.scale))
            slack = self.square * x + self.q + back
            bound = -falls - 0.5 * float(self.square @ x**2) - float(np.abs(slack) @ room)
            ray = falls < 0.0 and bool(np.abs(back).max() * REACH * (1.0 + self.n) < -falls)
        return _Point(x, found.status, bound, ray, bool(np.isfinite(x).all() and np.isfinite(z).all()))


@dataclass(frozen=True)
class _Point:
    """Where the solver ended: scaled x, its word, the bound of the scaled goal, whether its dual is a ray, finite."""

    x: FloatArray
    status: str
    bound: float
    ray: bool
    finite: bool


def _bent(one: Lengths, box: Box) -> NDArray[np.bool_]:
    """Which rows are no sums of shares that are not negative, (n_rows,)."""
    plain = np.zeros(box.size, dtype=bool)
    plain[: len(box.shares)] = [low >= 0.0 for low, _ in box.shares]
    straight = (one.slope.imag == 0.0) & (one.slope.real >= 0.0) & (plain | (one.slope == 0.0))
    return np.asarray(~(straight.all(axis=1) & (one.constant == 0.0)))


def least(goal: Lengths, limits: Sequence[Lengths], box: Box) -> Least:
    """The x with the least goal that keeps the limits and the box."""
    scale = _scales([goal, *limits], box)
    size = float((np.abs(goal.constant) + np.abs(goal.slope) @ scale).max()) or 1.0
    program = _Program(goal, limits, box, scale)
    program.goal(goal, size)
    for one in limits:
        program.limit(one, one.limit or size)
    run, power = program.run(), 2 if goal.by == "huber" else 1
    if "Infeasible" in run.status:
        if run.ray:
            return Least(None, np.nan, np.inf, "infeasible", "no weights keep the limits: certified by a dual ray")
        return Least(None, np.nan, -np.inf, "unproven", "no weights were found, and that there are none is not proven")
    if not run.finite:
        return Least(None, np.nan, -np.inf, "unproven", f"the solver stopped ({run.status}) without an answer")
    x = into_box(run.x[: box.size] * scale, box)
    value = goal.value(x)
    broken = [one for one in limits if one.value(x) > one.limit * (1.0 + 1e-6) + 1e-9 * size]
    if broken or not np.isfinite(value):
        return Least(None, np.nan, -np.inf, "unproven", f"the solver stopped ({run.status}) without keeping the limits")
    bound, whole = size**power * run.bound, size**power
    gap = max(value - bound, 0.0) / max(value, 1e-6 * whole)
    status = "optimal" if gap <= PROVEN * 10.0 or value - bound <= 1e-9 * whole else "feasible"
    said = f"gap {gap:.1e}" if value > 1e-9 * whole else "the goal is zero to rounding, gap 0"
    return Least(x, value, bound, status, f"convex program, {said} by our own dual bound")


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
    scale[:first] = box.unit
    return scale


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
