"""Corrections of any size and angle: closed form where it holds, else convex programs with a gap checked by us."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.convex_rounds import Convex, solve_convex
from vibopt.balancing.free_planes import Free, free_planes, solve_over_arcs
from vibopt.balancing.question import Prices, Question, Solved, breaks, relative_gap
from vibopt.balancing.scaled import Scaled, scaled

RANK = 1e-13
NOTHING = 1e-13  # residual that counts as nothing, as a share of the goal as found


def least_squares(weighted: ComplexArray, constant: ComplexArray) -> tuple[ComplexArray, int]:
    """The x of least norm |weighted x + constant|, and the rank.

    Parameters
    ----------
    weighted
        Shape (n_readings, n_planes); columns are divided by their norms before the singular values are compared.
    constant
        Shape (n_readings,).

    Returns
    -------
    tuple
        x (n_planes,) and the rank; below full rank x is the solution of least Euclidean norm.
    """
    norms = np.sqrt(
        np.einsum("kp,kp->p", weighted.real, weighted.real) + np.einsum("kp,kp->p", weighted.imag, weighted.imag)
    )
    norms[norms == 0] = 1.0
    level = weighted / norms
    if len(constant) > 4 * weighted.shape[1]:  # the same problem in n_planes + 1 rows
        triangle: ComplexArray = np.asarray(np.linalg.qr(np.column_stack([level, constant]), mode="r"))
        level, constant = triangle[:, :-1], triangle[:, -1]
    solution, _, rank, _ = np.linalg.lstsq(level, -constant, rcond=RANK)
    x: ComplexArray = solution / norms
    if rank < weighted.shape[1]:
        _, _, right = np.linalg.svd(level, full_matrices=True)
        idle = right[rank:].conj().T / norms[:, None]
        x = x - idle @ np.linalg.lstsq(idle, x, rcond=None)[0]
    return x, int(rank)


def closed_form(question: Question) -> Solved | None:
    """The answer where no program is needed; None otherwise.

    That is so where the least-squares solution keeps every limit and is asked for (or leaves nothing, which no goal
    can better), and where least mass is asked for and nothing has to be fitted.
    """
    if question.goal == "correction":
        return _nothing_needed(question)
    if question.pairs or not np.all(question.caps > 0):
        return None
    if question.goal != "rms" and question.n_readings > question.n_planes and np.isfinite(question.caps).any():
        return None  # more readings than planes and caps: something will be left
    u, rank = least_squares(question.importance[:, None] * question.H, question.importance * question.y0)
    bare = not question.sectors and not np.isfinite(question.total_cap) and np.all(np.isinf(question.limits))
    if not np.all(np.abs(u) <= question.caps) or not (bare or not breaks(replace(question, options=()), u, 0.0)):
        return None
    value = question.value(u)
    if question.goal != "rms" and value > NOTHING * float(question.measure(np.abs(question.y0))):
        return None
    n = question.n_planes
    claim = "least squares in closed form"
    if rank < n:
        claim += f"; the readings tell only {rank} of {n} planes apart, so of all such corrections this is the smallest"
    return Solved(u, "optimal", claim, value, value, 0.0, details={"rank": rank})


def _nothing_needed(question: Question) -> Solved | None:
    """No correction, where the readings keep their limits as found."""
    none = np.zeros(question.n_planes, dtype=complex)
    if breaks(replace(question, options=()), none, 0.0):
        return None
    return Solved(none, "optimal", "the limits are kept as found: nothing has to be fitted", 0.0, 0.0, 0.0)


PROVEN = 1e-7


def solve_continuous(question: Question) -> Solved:
    """The best correction of any size and angle, with its proof.

    Parameters
    ----------
    question
        Lists of options are not looked at here (see `vibopt.balancing.discrete`).

    Returns
    -------
    Solved
        "optimal" with a gap below 1e-7 by our own dual bound; "infeasible" only with a bound above the limits, then
        `least_factor` says how much wider all of them would have to be; "feasible" or "unproven" otherwise.
    """
    plain = closed_form(question)
    if plain is not None:
        return plain
    free = free_planes(question)
    scene = scaled(free.question)
    sectors = free.question.sectors
    return _solved(question, free, scene, solve_over_arcs(scene, sectors) if any(sectors) else solve_convex(scene))


def _solved(question: Question, free: Free, scene: Scaled, answer: Convex) -> Solved:
    """The answer in the asker's planes and units."""
    details = {"programs": answer.rounds}
    if answer.x is None:
        if answer.factor > 1.0:
            wider = f"{answer.factor:.4g} times as wide"
            claim = f"no correction keeps the limits: all of them would have to be at least {wider}"
            return Solved(None, "infeasible", claim, least_factor=answer.factor, details=details)
        return Solved(
            None, "unproven", "no correction was found, and that there is none is not proven", details=details
        )
    u = free.spread @ (answer.x * scene.column)
    value = question.value(u)
    low = answer.bound * scene.goal_size if np.isfinite(answer.bound) else -np.inf
    gap = relative_gap(value, low, scene.goal_size)
    status = "optimal" if gap <= PROVEN else "feasible"
    claim = f"convex program, gap {gap:.1e} by our own dual bound"
    if any(free.question.sectors):
        claim = f"all arcs outside the forbidden sectors compared in {answer.rounds} convex programs, gap {gap:.1e}"
    return Solved(u, status, claim, value, low, gap, _prices(question, free, scene, answer), details=details)


def _prices(question: Question, free: Free, scene: Scaled, answer: Convex) -> Prices | None:
    """Prices of the asker's limits from the multipliers of the scaled ones."""
    if answer.dual is None:
        return None
    readings = np.zeros(question.n_readings)
    limits = np.maximum(question.limits[scene.limited], 1e-300)
    readings[scene.limited] = np.abs(answer.dual.v) * scene.goal_size / limits
    own = answer.dual.caps * scene.goal_size / scene.column
    total = answer.dual.total * scene.goal_size / scene.mass_size
    return Prices(readings, _cap_prices(question, free, own), float(total))


def _cap_prices(question: Question, free: Free, own: FloatArray) -> FloatArray:
    """The price of a merged plane belongs to the member whose cap it meets first."""
    if free.question is question:
        return own
    prices = np.zeros(question.n_planes)
    sizes = np.abs(free.spread)
    for column in range(sizes.shape[1]):
        members = np.flatnonzero(sizes[:, column])
        first = members[np.argmin(question.caps[members] / sizes[members, column])]
        prices[first] = own[column] / sizes[first, column]
    return prices
