"""Counterweights and balance shafts of an engine: lengths of affine complex rows, added up or the greatest of them.

Shares are plain numbers, weights are complex unbalances [kg m] at crank angle zero.  All orders together are looked at
every degree of a turn.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.balancing.engine.choose_weights import box_of, goal_table, lengths
from vibopt.balancing.engine.engine_job import EngineJob
from vibopt.balancing.engine.shaking import arms, free_shares, free_weights
from vibopt.balancing.lengths import Box, Least, Lengths, into_box
from vibopt.balancing.question import relative_gap
from vibopt.posed import conic
from vibopt.posed.nonlinear import Collected, NonlinearProgram

PROVEN = 1e-6
Limits = Sequence[tuple[str, Lengths]]


def asked(job: EngineJob) -> tuple[Lengths, Limits, Box, tuple[str, ...]]:
    """Goal, limits by path, bounds and the path of each share and weight, of an engine whose cranks are given."""
    here = arms(job, tuple(crank or 0.0 for crank in job.cranks))
    limits = [(f"limits.{name}", lengths(limit, here, limit.bound)) for name, limit in job.limits.items()]
    paths = [f"engine.{share.name}" for share in free_shares(job)]
    paths += [f"{job.weights[k].family}.{job.weights[k].name}" for k in free_weights(job)]
    return lengths(goal_table(job), here), limits, box_of(job), tuple(paths)


def plain_names(box: Box) -> tuple[str, ...]:
    """Numbers for names."""
    return tuple([f"share {k}" for k in range(len(box.shares))] + [f"weight {k}" for k in range(len(box.caps))])


def size_of(goal: Lengths) -> float:
    """What a goal of one is: the goal with nothing fitted, or with one unit where that is zero [SI]."""
    value = goal.value(np.zeros(goal.slope.shape[1]))
    return value or float(np.abs(goal.slope).max(initial=0.0)) or 1.0


def convex(goal: Lengths, limits: Limits, box: Box, paths: Sequence[str], *, margin: float = 0.0) -> Any:
    """The `cvxpy.Problem`; every bound is drawn in by the part `margin`."""
    import cvxpy as cp

    first = len(box.shares)
    shares = [cp.Variable(name=path) for path in paths[:first]]
    weights = [cp.Variable(complex=True, name=path) for path in paths[first:]]
    columns = [*shares, *(part(weight) for weight in weights for part in (cp.real, cp.imag))]

    def measure(lengths: Lengths, size: float) -> Any:
        rows = [column * (lengths.slope[:, k] / size) for k, column in enumerate(columns)]
        sizes = cp.abs(lengths.constant / size + sum(rows[1:], rows[0]))
        return cp.max(sizes) if lengths.by == "worst" else cp.sum(sizes)

    held = [conic.named(measure(lengths, lengths.limit or size_of(goal)) <= (1.0 - margin) * bool(lengths.limit), path)
            for path, lengths in limits]  # fmt: skip
    for variable, (low, high), path in zip(shares, box.shares, paths, strict=False):
        held += [conic.named(variable >= low, f"{path}.from")]
        held += [conic.named(variable <= high, f"{path}.to")] if np.isfinite(high) else []
    for variable, cap, path in zip(weights, box.caps, paths[first:], strict=True):
        held += [conic.named(cp.abs(variable) / cap <= 1.0, f"{path}.unbalance")] if np.isfinite(cap) else []
    return cp.Problem(cp.Minimize(measure(goal, size_of(goal))), held)


def choices(problem: Any, box: Box, paths: Sequence[str]) -> FloatArray:
    """The values of the solved problem as shares and (re, im) of each weight."""
    found = [problem.var_dict[path].value if path in problem.var_dict else 0.0 for path in paths]
    first = len(box.shares)
    return np.array([*map(float, found[:first]), *(part for z in found[first:] for part in (z.real, z.imag))])


def least(goal: Lengths, limits: Sequence[Lengths], box: Box) -> Least:
    """The best choices by cvxpy, with our own bound, in the place of `vibopt.balancing.lengths.least`."""
    paths, size = plain_names(box), size_of(goal)
    named = [(f"limit {k}", limit) for k, limit in enumerate(limits)]
    bound = -np.inf
    for margin in (0.0, 2e-9, 2e-8):
        problem = convex(goal, named, box, paths, margin=margin)
        run = conic.solved(problem)
        bound = max(bound, run.bound * size) if not margin else bound
        if not run.claims:
            claim = f"cvxpy finds no weights that keep the limits (Clarabel: {run.status}), which is not proven here"
            return Least(None, np.nan, -np.inf, "unproven", claim)
        x = into_box(choices(problem, box, paths), box)
        if all(limit.value(x) <= limit.limit * (1.0 + 1e-9) for limit in limits):
            break
    value = goal.value(x)
    gap = relative_gap(value, bound, size)
    status = "optimal" if gap <= PROVEN else "feasible"
    return Least(x, value, bound, status, f"the convex program in cvxpy, gap {gap:.1e} by our own dual bound")


def smooth(goal: Lengths, limits: Limits, box: Box, paths: Sequence[str]) -> NonlinearProgram:
    """The same in CasADi: amplitudes are unknowns above the lengths, by their squares."""
    import casadi

    made = _Smooth(goal, box, paths)
    objective = made.measure("goal", goal, size_of(goal), None)
    for path, asked in limits:
        made.measure(path, asked, asked.limit or size_of(goal), float(bool(asked.limit)))
    for k, cap in enumerate(box.caps):
        if np.isfinite(cap):
            path = paths[len(box.shares) + k]
            made.below(f"{path}.unbalance", casadi.sumsqr(made.variables[path]) / cap**2 - 1.0)
    return made.program(objective)


class _Smooth(Collected):
    """Of an engine: shares, and balancing weights as two numbers each."""

    def __init__(self, goal: Lengths, box: Box, paths: Sequence[str]) -> None:
        import casadi

        super().__init__()
        first = len(box.shares)
        shares = [self.unknown(path, low, high, low) for path, (low, high) in zip(paths, box.shares, strict=False)]
        self.variables = dict(zip(paths, shares, strict=False))
        for k, path in enumerate(paths[first:]):
            column = np.abs(goal.slope[:, first + 2 * k]).max(initial=0.0)
            scale = size_of(goal) / column if column else box.caps[k] if np.isfinite(box.caps[k]) else 1.0
            parts = [scale * self.unknown(f"{part} {path}", -np.inf, np.inf, 0.1) for part in ("Re", "Im")]
            self.variables[path] = casadi.vertcat(*parts)
        self.x = casadi.vertcat(*self.variables.values())

    def measure(self, path: str, lengths: Lengths, size: float, bound: float | None) -> Any:
        """Sum or greatest of the lengths over `size`, held below `bound` where there is one."""
        import casadi

        real, imag = (
            casadi.SX(casadi.DM(np.ascontiguousarray(c))) + casadi.mtimes(casadi.DM(np.ascontiguousarray(s)), self.x)
            for c, s in ((lengths.constant.real / size, lengths.slope.real / size),
                         (lengths.constant.imag / size, lengths.slope.imag / size))
        )  # fmt: skip
        squares = casadi.vertsplit(real**2 + imag**2)
        if lengths.by == "worst" and bound is not None:
            self.below(path, *(row - bound**2 for row in squares))
            return None
        heads = [
            self.unknown("amplitude", 0.0, np.inf, 1.0) for _ in (squares[:1] if lengths.by == "worst" else squares)
        ]
        above = heads * len(squares) if lengths.by == "worst" else heads
        self.below(path, *(row - head**2 for row, head in zip(squares, above, strict=True)))
        total = sum(heads[1:], heads[0])
        if bound is not None:
            self.below(path, total - bound)
        return total
