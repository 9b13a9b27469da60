"""A cvxpy problem solved by Clarabel, with a lower bound by our own arithmetic on the dual point.

    minimise c x + x P x / 2  with  A x + s = b,  s in K:   for every z in the dual of K and every point v

    goal >= -b z - v P v / 2 + least of (c + A' z + P v) x over the x that are looked at.

Any z gives a bound; a bad one makes it weak, never wrong.  The x looked at lie within `REACH` times the answer or the
natural size of their column; convexity carries the rest: a better point beyond would have better ones within.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.records import dataclass
from vibopt.work import worked

REACH = 10.0
TOLERANCE = 1e-10
"""What Clarabel is asked for, in gap and in feasibility; it stops at 1e-8 at the latest with "optimal_inaccurate"."""
ITERATIONS = 200
_PER_ENTRY = 0.003
"""Nominal work per entry of A [ms]."""


@dataclass(frozen=True, slots=True)
class Conic:
    """How Clarabel ended, in cvxpy's words, and the bound of the objective; -inf where there is none."""

    status: str
    bound: float

    @property
    def claims(self) -> bool:
        """Whether there is a point to look at."""
        return self.status in ("optimal", "optimal_inaccurate")


def named(constraint: Any, name: str) -> Any:
    """A constraint with its name, as `constraint.label` and in the printed problem."""
    return constraint.set_label(name)


def solved(problem: Any) -> Conic:
    """Solve a `cvxpy.Problem` in place; its variables have their values afterwards."""
    import cvxpy

    options = dict.fromkeys(("tol_gap_abs", "tol_gap_rel", "tol_feas"), TOLERANCE) | {"max_iter": ITERATIONS}
    with warnings.catch_warnings():  # what it warns of is in its status
        warnings.simplefilter("ignore")
        data, chain, inverse = problem.get_problem_data(cvxpy.CLARABEL, solver_opts=options)
        worked(0.5 + _PER_ENTRY * data["A"].nnz)
        raw = chain.solve_via_data(problem, data, solver_opts=options)
        try:
            problem.unpack_results(raw, chain, inverse)
        except cvxpy.SolverError:
            return Conic("solver error", -np.inf)
    status = str(problem.status)
    if status not in ("optimal", "optimal_inaccurate"):
        return Conic(status, -np.inf)
    offset = data["param_prob"].apply_parameters(quad_obj="P" in data)[-3]
    return Conic(status, _bound(data, np.asarray(raw.x), np.asarray(raw.z)) + float(offset))


def least_missed(problem: Any) -> float:
    """A lower bound of the least amount by which some row of a problem is missed, whatever the point; -inf unknown."""
    import cvxpy as cp

    missed = cp.Variable(nonneg=True, name="missed")
    rows = [
        one.args[0] + missed * np.eye(one.args[0].shape[0]) >> 0.0
        if isinstance(one, cp.constraints.PSD)
        else one.args[0] - one.args[1] <= missed
        for one in problem.constraints
    ]
    return solved(cp.Problem(cp.Minimize(missed), rows)).bound


def _bound(data: Any, x: FloatArray, z: FloatArray) -> float:
    dims = data["dims"]
    if dims.exp or len(dims.p3d) or len(getattr(dims, "pnd", ())):
        return -np.inf
    z = _into_dual(z, dims.zero, dims.nonneg, dims.soc, dims.psd)
    bent = data["P"] @ x if "P" in data else np.zeros(len(x))
    slope = data["c"] + data["A"].T @ z + bent
    columns = np.maximum(abs(data["A"]).max(axis=0).toarray().ravel(), 1e-300)
    room = REACH * np.maximum(np.abs(x), 1.0 / columns)
    return float(-data["b"] @ z - 0.5 * x @ bent + slope @ x - np.abs(slope) @ room)


def _into_dual(z: FloatArray, zero: int, nonneg: int, cones: Sequence[int], matrices: Sequence[int]) -> FloatArray:
    """The nearest multipliers of the right signs: free, not negative, in the cone, and positive semidefinite."""
    inside = z.copy()
    at = zero + nonneg
    inside[zero:at] = np.maximum(inside[zero:at], 0.0)
    for size in cones:
        inside[at] = max(inside[at], float(np.linalg.norm(inside[at + 1 : at + size])))
        at += size
    for order in matrices:
        size = order * (order + 1) // 2
        inside[at : at + size] = _positive(inside[at : at + size], order)
        at += size
    return inside


def _positive(vector: FloatArray, order: int) -> FloatArray:
    """A symmetric matrix, upper triangle by columns with its off-diagonals times sqrt(2), lifted to semidefinite."""
    columns, rows = np.tril_indices(order)
    scale = np.where(rows == columns, 1.0, np.sqrt(0.5))
    matrix = np.zeros((order, order))
    matrix[rows, columns] = matrix[columns, rows] = vector * scale
    least = float(np.linalg.eigvalsh(matrix)[0])
    matrix += max(-least, 0.0) * np.eye(order)
    return np.asarray(matrix[rows, columns] / scale)
