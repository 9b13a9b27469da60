"""Time per point of a sweep of a measured rotor, 8 readings x 2 planes, over a bound.

    python tests/bench/rotor_sweep.py

The rivals get the coefficients ready: cvxpy with the bound as a parameter, and Clarabel built anew for each point by
hand.  They check nothing.  One BLAS thread, processor time, ratios within one run.
"""

from __future__ import annotations

# ruff: noqa: E402
import os

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from rotor_files import RADIUS, rotor_files
from timing import timed

sys.path.insert(0, str(Path(__file__).parents[2]))

import vibopt as vo
from vibopt.balancing.solve_rotor import asked_of
from vibopt.study.sweep import sweep

CASES = (
    ("rms", "planes.p0.weight.to", "5 g..60 g"),
    ("worst", "planes.p0.weight.to", "5 g..60 g"),
    ("rms", "limits.all.at_most", "0.06 mm pk..0.25 mm pk"),
)
POINTS = (1_000, 10_000)
RIVAL_POINTS = 100
Numbers = np.ndarray[Any, np.dtype[Any]]


def job_of(folder: Path, goal: str, path: str) -> Any:
    """The rotor of the case, with one limit on all readings where that is varied."""
    file = rotor_files(folder, 4, 2, 2, goal)[0]
    if path.startswith("limits."):
        text = file.read_text() + '[limits.all]\nresponse = "residual"\nat_most = "0.2 mm pk"\n'
        file.write_text(text)
    return vo.read(file)


def with_cvxpy(y0: Numbers, H: Numbers, caps: Numbers, goal: str, path: str) -> Callable[[float], float]:
    """The least goal [m] at a bound [SI], the bound a parameter."""
    import cvxpy as cp

    unit, size = float(np.abs(y0).max()), float(caps.max())
    u, bound = cp.Variable(2, complex=True), cp.Parameter(nonneg=True)
    left = y0 / unit + (H / unit * size) @ u
    least = cp.max(cp.abs(left)) if goal == "worst" else cp.norm(left) / np.sqrt(len(y0))
    if path.startswith("limits."):
        kept = [cp.abs(u) <= caps / size, cp.abs(left) <= bound]
    else:
        kept = [cp.abs(u[0]) <= bound, cp.abs(u[1]) <= caps[1] / size]
    problem = cp.Problem(cp.Minimize(least), kept)

    def solved(value: float) -> float:
        bound.value = value / (unit if path.startswith("limits.") else size)
        problem.solve(solver="CLARABEL", ignore_dpp=False)
        return float(problem.value) * unit

    return solved


def with_clarabel(y0: Numbers, H: Numbers, caps: Numbers, goal: str, path: str) -> Callable[[float], float]:
    """The same by a cone program that is built anew for each bound."""
    import clarabel
    from scipy import sparse

    unit, size = float(np.abs(y0).max()), float(caps.max())
    G, g = H / unit * size, y0 / unit
    settings = clarabel.DefaultSettings()
    settings.verbose = False

    def modulus(row: Numbers, constant: complex, head: Numbers) -> tuple[Numbers, Numbers]:
        block = np.zeros((3, 5))
        block[0] = head
        block[1, :4], block[2, :4] = np.r_[-row.real, row.imag], np.r_[-row.imag, -row.real]
        return block, np.array([0.0, constant.real, constant.imag])

    def solved(value: float) -> float:
        at = caps / size
        bound = np.inf
        if path.startswith("limits."):
            bound = value / unit
        else:
            at = np.array([value, caps[1]]) / size
        blocks, b, cones = [], [], []
        slack = np.array([0.0, 0.0, 0.0, 0.0, -1.0])
        if goal == "worst":
            for k in range(len(g)):
                block, constant = modulus(G[k], g[k], slack)
                blocks.append(block), b.append(constant), cones.append(clarabel.SecondOrderConeT(3))
        else:
            n = len(g)
            block = np.zeros((2 * n + 1, 5))
            block[0] = slack
            block[1 : n + 1, :4], block[n + 1 :, :4] = np.c_[-G.real, G.imag], np.c_[-G.imag, -G.real]
            (
                blocks.append(block),
                b.append(np.r_[0.0, g.real, g.imag]),
                cones.append(clarabel.SecondOrderConeT(2 * n + 1)),
            )
        if np.isfinite(bound):
            for k in range(len(g)):
                block, constant = modulus(G[k], g[k], np.zeros(5))
                constant[0] = bound
                blocks.append(block), b.append(constant), cones.append(clarabel.SecondOrderConeT(3))
        for plane in range(2):
            block, constant = modulus(np.eye(2)[plane], 0.0, np.zeros(5))
            constant[0] = at[plane]
            blocks.append(block), b.append(constant), cones.append(clarabel.SecondOrderConeT(3))
        A = sparse.csc_matrix(np.vstack(blocks))
        P = sparse.csc_matrix((5, 5))
        q = np.array([0.0, 0.0, 0.0, 0.0, 1.0])
        found = clarabel.DefaultSolver(P, q, A, np.concatenate(b), cones, settings).solve()
        scale = 1.0 if goal == "worst" else np.sqrt(len(g))
        return float(found.x[4]) * unit / scale if str(found.status) == "Solved" else np.inf

    return solved


def compared(folder: Path, goal: str, path: str, span: str) -> None:
    """Microseconds a point, ratios, and how far the goals are apart."""
    job = job_of(folder, goal, path)
    question = asked_of(job)[3].question
    rivals = [make(question.y0, question.H, question.caps, goal, path) for make in (with_cvxpy, with_clarabel)]
    sweep(job, path, span, POINTS[0])
    to_si = 1.0 if path.startswith("limits.") else RADIUS  # the rivals count unbalances
    for points in POINTS:
        ours, found = timed(partial(sweep, job, path, span, points))
        picked = [found.points[k] for k in range(0, points, points // RIVAL_POINTS)]
        goals = np.array([np.inf if one.goal is None else one.goal.value for one in picked])
        bounds = [to_si * one.value.value for one in picked]
        line = f"{goal:>5} {path:>20} {points:>5} points: {1e6 * ours / points:5.1f} us a point"
        for label, rival in zip(("cvxpy", "clarabel"), rivals, strict=True):
            taken, values = timed(lambda r=rival, b=bounds: np.array([r(one) for one in b]))
            both = np.isfinite(goals) & np.isfinite(values)
            apart, each = np.abs(goals[both] / values[both] - 1.0).max(), taken / len(picked)
            line += f", {label} {1e6 * each:5.0f} us, ratio {each / ours * points:4.0f} (apart {apart:.0e})"
        print(line, f"{'complete' if found.complete else 'not complete'}, {np.isinf(goals).sum()} without a plan")


def main() -> None:
    """All cases."""
    with tempfile.TemporaryDirectory() as folder:
        for case in CASES:
            compared(Path(folder), *case)


if __name__ == "__main__":
    main()
