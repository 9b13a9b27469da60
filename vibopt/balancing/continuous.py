"""Corrections of any size and angle: closed form where it holds, else convex programs with a gap checked by us."""

from __future__ import annotations

import numpy as np

from vibopt.balancing.arcs import solve_over_arcs
from vibopt.balancing.convex import Convex, solve_convex
from vibopt.balancing.free_planes import Free, free_planes
from vibopt.balancing.least_squares import closed_form
from vibopt.balancing.question import Prices, Question, Solved, relative_gap
from vibopt.balancing.scaled import Scaled, scaled
from vibopt.forms import FloatArray

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
    if not any(free.question.sectors):
        answer = solve_convex(scene)
        return _solved(question, free, scene, answer, answer.bound, answer.factor, answer.rounds)
    branched = solve_over_arcs(scene, free.question.sectors)
    return _solved(question, free, scene, branched.best, branched.bound, branched.factor, branched.programs)


def _solved(
    question: Question, free: Free, scene: Scaled, answer: Convex, bound: float, factor: float, programs: int
) -> Solved:
    """The answer in the asker's planes and units."""
    details = {"programs": programs}
    if answer.x is None:
        if factor > 1.0:
            claim = f"no correction keeps the limits: all of them would have to be at least {factor:.4g} times as wide"
            return Solved(None, "infeasible", claim, least_factor=factor, details=details)
        return Solved(
            None, "unproven", "no correction was found, and that there is none is not proven", details=details
        )
    u = free.spread @ (answer.x * scene.column)
    value = question.value(u)
    low = bound * scene.goal_size if np.isfinite(bound) else -np.inf
    gap = relative_gap(value, low, scene.goal_size)
    status = "optimal" if gap <= PROVEN else "feasible"
    claim = f"convex program, gap {gap:.1e} by our own dual bound"
    if any(free.question.sectors):
        claim = f"all arcs outside the forbidden sectors compared in {programs} convex programs, gap {gap:.1e}"
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
