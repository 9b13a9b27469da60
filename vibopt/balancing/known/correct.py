"""The correction of a shaft with known masses: a vector sum where that is all, a program where it is not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import inf
from typing import cast

import numpy as np

from vibopt.answer.plan import PlaneAnswer
from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.balancing.conventions import WITH, Conventions
from vibopt.balancing.fitting import NOTHING, fitted_planes
from vibopt.balancing.known.known_job import KnownJob, KnownLimitTable
from vibopt.balancing.known.shaft_statics import (
    Aim,
    aim_of,
    balance_rows,
    bearing_rows,
    middle_and_arm,
    unbalances,
)
from vibopt.balancing.optimisers import Solver, solve_question
from vibopt.balancing.plane_options import Posed, caps_of, decided_of, posed
from vibopt.balancing.question import Goal, Options, Question, Solved, breaks
from vibopt.balancing.rates import Bounding, cap_of, own_caps, rates
from vibopt.records import dataclass

AS_WRITTEN = Conventions("", "", WITH, "pk", "")
"""Angles of known masses have one sense throughout, so none has to be turned round."""
_ROUNDING = 1e-12
_TRACE = 1e-7
_LEFT_OPEN = 1e-8
"""Part of the greatest unbalance that a program leaves open: less of a weight is none."""
"""Part of the greatest unbalance below which a search may mean none: gaps are closed to about so much."""


@dataclass(frozen=True)
class Correction:
    """What is added in each plane, u (n_planes,) [kg m], and how that is known.

    way
        "vector sum", "least mass", "program" or "none".
    rates
        What the goal falls by per unit of each limit and cap [SI], by name; None where it goes in steps.
    planes
        What is done in each plane.
    """

    u: ComplexArray
    status: str
    claim: str
    way: str
    rates: dict[str, float] | None
    planes: tuple[PlaneAnswer, ...] = ()


def correct(job: KnownJob, solver: Solver | None = None) -> Correction:
    """The best correction as weights, under the goal and the limits of the job; `solver` answers its question."""
    correction, options = _corrected(job, solver)
    tiny = (_LEFT_OPEN if correction.way == "program" else NOTHING) * _greatest(job, correction.u)
    return replace(correction, planes=fitted_planes(job.planes, AS_WRITTEN, correction.u, options, tiny))


def _greatest(job: KnownJob, u: ComplexArray) -> float:
    """The greatest unbalance there is, known or fitted [kg m]."""
    return float(np.abs(np.concatenate([unbalances(job), u])).max(initial=0.0))


def _corrected(job: KnownJob, solver: Solver | None) -> tuple[Correction, Sequence[Options | None]]:
    """The correction, and what its planes were chosen from.

    Complete balance is a set of linear equations.  Where it has one solution that breaks nothing, that is the answer;
    where it has many, the one with the least mass; where caps, lists or limits stand in the way, the program decides.
    """
    asked = pose(job)
    question, options, n = asked.question, asked.question.options, len(job.planes)
    if not n or job.goal is None:
        as_it_is = "nothing is corrected: the shaft as it is"
        return Correction(np.zeros(n, dtype=complex), "met", as_it_is, "none", None), (None,) * n
    if not job.choices:
        claim = "nothing is chosen: the shaft with the weights as they are given"
        return Correction(decided_of(options), "met", claim, "none", None), options
    if solver is None and job.goal.minimise != "reaction" and not question.is_search:
        exact = _exact(job, question)
        if exact is not None:
            return exact, options
    if solver is None and job.goal.minimise == "correction" and not np.isfinite(question.limits).any():
        return _no_balance(job, question), options
    solved = _without_traces(job, question) if solver is None else solver(complete(job, question))
    u = solved.u if solved.u is not None else np.zeros(n, dtype=complex)
    correction = Correction(np.asarray(u), solved.status, solved.claim, "program", _rates(job, question, solved))
    return correction, asked.question.chosen_only(solved.chosen).options if solved.u is not None else (None,) * n


def _without_traces(job: KnownJob, question: Question) -> Solved:
    """The answer of a search; planes in which it leaves a trace are left untouched where that is as good."""
    solved = solve_question(question)
    size = np.zeros(0) if solved.u is None else np.abs(solved.u) / max(_greatest(job, solved.u), 1e-300)
    traces = np.flatnonzero((size > 0.0) & (size < _TRACE))
    if solved.u is None or not len(traces):
        return solved
    fewer = solve_question(question.without(traces.tolist()))
    same = NOTHING * (question.densities.max() if question.goal == "correction" else 1.0) * _greatest(job, solved.u)
    if fewer.u is None or fewer.value > solved.value * (1.0 + NOTHING) + same:
        return solved
    return replace(solved, u=fewer.u, value=fewer.value, chosen=fewer.chosen)


def pose(job: KnownJob) -> Posed:
    """The rows and limits of the job as a question: balance rows first, then the bearings', then those of the goal."""
    rows = [balance_rows(job)] + ([bearing_rows(job)] if job.bearings else [])
    known, aim = unbalances(job), aim_of(job)
    rows += [aim.rows] if aim is not None else []
    importance = _importance(aim, [len(row.names) for row in rows])
    bounds = [
        (k, limit.bound)
        for limit in job.limits.values() if limit.response == "correction"
        for k, plane in enumerate(job.planes) if limit.of == plane.name
    ]  # fmt: skip
    return posed(
        job.planes,
        AS_WRITTEN,
        y0=np.concatenate([row.masses @ known for row in rows]),
        H=np.concatenate([row.planes for row in rows]).astype(complex),
        importance=importance,
        limits=_limits(job, len(importance)),
        caps=caps_of(job.planes, bounds),
        total_cap=min([t.bound for t in job.limits.values() if t.total] or [inf]),
        goal=cast(Goal, "correction" if job.aim == "correction" else aim.combine if aim is not None else "rms"),
    )


def complete(job: KnownJob, question: Question) -> Question:
    """The question with complete balance as limits, where the least correction is asked and no limit says how good."""
    if question.goal != "correction" or np.isfinite(question.limits).any():
        return question
    limits = question.limits.copy()
    limits[: len(balance_rows(job).names)] = 0.0
    return replace(question, limits=limits)


def _importance(aim: Aim | None, sizes: list[int]) -> FloatArray:
    """Only the rows of the goal count, such that the question's goal is that of the file [kg m]."""
    importance = np.zeros(sum(sizes))
    if aim is not None:
        full = np.sqrt(sum(sizes) / sizes[-1]) if aim.combine == "rms" else 1.0
        importance[-sizes[-1] :] = full
    return importance


def bounded_rows(job: KnownJob, table: KnownLimitTable) -> tuple[list[int], float]:
    """Rows of the question that a limit bounds, and what a row of one is [SI]; none where it bounds no row."""
    n_balance = len(balance_rows(job).names)
    if table.response == "static_unbalance":
        return [0], 1.0
    if table.response == "couple_unbalance":
        return ([1] if n_balance > 1 else []), middle_and_arm(job)[1]
    if table.response == "bearing_reaction" and job.speed:
        return [
            n_balance + k for k, bearing in enumerate(job.bearings) if table.of in (None, bearing.name)
        ], job.speed**2
    return [], 1.0


def _limits(job: KnownJob, n_rows: int) -> FloatArray:
    """Greatest amplitude per row [kg m]; with the goal "correction" and no limit, complete balance is meant."""
    limits = np.full(n_rows, inf)
    for table in job.limits.values():
        rows, size = bounded_rows(job, table)
        limits[rows] = np.minimum(limits[rows], table.bound / size)
    return limits


def _exact(job: KnownJob, question: Question) -> Correction | None:
    """Complete balance: the only one, or the lightest of many; None where there is none that keeps every limit."""
    goal = job.goal.minimise if job.goal is not None else ""
    if goal == "correction" and np.isfinite(question.limits).any():
        return None
    n_rows = len(balance_rows(job).names)
    free = np.flatnonzero(question.caps > 0.0)
    H, y0 = question.H[:n_rows, free].real, question.y0[:n_rows]
    if not len(free):
        return None
    left, sizes, right = np.linalg.svd(H)
    rank = int((sizes > _ROUNDING * sizes[0]).sum())
    part = right[:rank].T @ ((left[:, :rank].T @ -y0) / sizes[:rank])
    if np.abs(y0 + H @ part).max() > 1e-9 * max(np.abs(y0).max(), 1e-300):
        return None
    u = np.zeros(len(question.caps), dtype=complex)
    if rank == len(free):
        u[free] = part
        if breaks(question, u):
            return None
        said = "static and couple unbalance" if n_rows == 2 else "static unbalance"
        claim = f"vector sums: the only correction that leaves no {said}"
        return Correction(u, "optimal", claim, "vector sum", dict.fromkeys([*own_caps(job.planes), *job.limits], 0.0))
    lightest = _lightest(question, n_rows, free, right[rank:].T)
    if lightest is None:
        return None
    u = lightest
    claim = f"complete balance with the least mass of all {len(free)} planes together, a convex program"
    held = None if goal == "correction" else dict.fromkeys([*own_caps(job.planes), *job.limits], 0.0)
    return None if breaks(question, u) else Correction(u, "optimal", claim, "least mass", held)


def _no_balance(job: KnownJob, question: Question) -> Correction:
    """Complete balance was asked for and not found: whether that is proven, and the way out."""
    rows = balance_rows(job)
    free = np.flatnonzero(question.caps > 0.0)
    H, y0 = rows.planes[:, free], question.y0[: len(rows.names)]
    nothing = np.zeros(len(question.caps), dtype=complex)
    way = 'Write [limits.NAME] with response = "static_unbalance" and at_most, or minimise = "unbalance".'
    nearest = np.linalg.lstsq(H, -y0, rcond=None)[0] if len(free) else np.zeros(0)
    if np.abs(y0 + H @ nearest).max() > 1e-9 * max(np.abs(y0).max(), 1e-300):
        claim = f"no weights in these planes balance the shaft completely. {way}"
        return Correction(nothing, "infeasible", claim, "program", None)
    if len(free) == np.linalg.matrix_rank(H) and not question.is_discrete:
        claim = f"the only weights that balance the shaft completely break a cap or a forbidden sector. {way}"
        return Correction(nothing, "infeasible", claim, "program", None)
    if not question.is_discrete and _all_balanced(question, len(rows.names)).status == "infeasible":
        claim = (
            f"no weights within caps, total, holes and sectors balance the shaft completely, by a convex program. {way}"
        )
        return Correction(nothing, "infeasible", claim, "program", None)
    claim = f"no complete balance was found within caps, holes and sectors. {way}"
    return Correction(nothing, "unproven", claim, "program", None)


def _lightest(question: Question, n_rows: int, free: IntArray, null: FloatArray) -> ComplexArray | None:
    """Of all weights that leave nothing in the first rows, u + null w in the `free` planes, the lightest."""
    if any(question.sectors[k] for k in free if question.sectors):
        return None
    solved = _all_balanced(question, n_rows)
    if solved.u is None or solved.status != "optimal":
        return None
    found = solved.u.copy()
    found[free] = sharpened(found[free], null, question.densities[free])
    return solved.u if (np.abs(found) > question.caps).any() else found


def _all_balanced(question: Question, n_rows: int) -> Solved:
    """The lightest weights that leave nothing in the first rows, as a program finds them."""
    limits = np.where(np.arange(question.n_readings) < n_rows, 0.0, inf)
    return solve_question(replace(question, goal="correction", limits=limits))


def sharpened(near: ComplexArray, null: FloatArray, mass: FloatArray) -> ComplexArray:
    """near + null w where sum(mass |near + null w|) is least, to the last digits, by Newton's method.

    The sum is flat at its least value, so that a solver's gap of 1e-9 leaves a part in 1e5 of the weights open.
    Where a weight vanishes the sum has a kink, and what is near is kept.
    """
    turned = np.block([[null, 0.0 * null], [0.0 * null, null]])
    u, n = near, len(near)
    for _ in range(20):
        size = np.abs(u)
        if size.min() < 1e-9 * size.max():
            return near
        along = np.concatenate([u.real / size, u.imag / size])
        slope = turned.T @ (np.tile(mass, 2) * along)
        across = np.diag(1.0 - along**2)
        across[:n, n:] = across[n:, :n] = np.diag(-along[:n] * along[n:])
        bend = turned.T @ (np.tile(mass / size, 2)[:, None] * across) @ turned
        step = np.linalg.lstsq(bend, slope, rcond=None)[0].reshape(2, -1)
        u = u - null @ (step[0] + 1j * step[1])
    return u if mass @ np.abs(u) <= mass @ np.abs(near) * (1.0 + 1e-12) else near


def bounds_of(job: KnownJob) -> dict[str, Bounding]:
    """What bounds the question of the job, by the names of the file."""
    known = own_caps(job.planes)
    for name, table in job.limits.items():
        rows, size = bounded_rows(job, table)
        if rows:
            known[name] = Bounding(table.bound / size, size, rows)
        elif table.total:
            known[name] = Bounding(table.bound)
        elif table.response == "correction":
            k = next(i for i, plane in enumerate(job.planes) if plane.name == table.of)
            known[name] = cap_of(job.planes[k], k, table.bound)
    return known


def _rates(job: KnownJob, question: Question, solved: Solved) -> dict[str, float] | None:
    """What the goal falls by per unit of each limit and cap, by their names in the file [SI]."""
    aim, found = aim_of(job), rates(question, solved, bounds_of(job))
    return found if aim is None or found is None else {name: rate * aim.scale for name, rate in found.items()}
