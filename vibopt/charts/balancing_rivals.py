"""Methods of balancing in the charts: vibopt, cvxpy, numpy, pruned enumeration, rounding, hsbalance; with their claims.

vibopt is given the job as read and gives the plan that was put back into a simulated rotor; the others are given
arrays, and give arrays.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.balancing.continuous import solve_continuous
from vibopt.balancing.optimisers import solve_question
from vibopt.balancing.question import Question
from vibopt.balancing.solve_rotor import solve_job
from vibopt.charts.balancing_questions import Asked
from vibopt.charts.rotor_file import HOLES, WEIGHTS
from vibopt.charts.scene_rivals import CONES
from vibopt.charts.stopwatch import spent
from vibopt.charts.trial import DEFAULT, Case, Said, Trial, judged
from vibopt.charts.verdicts import MISSING, REFUSES
from vibopt.solve.rivals import hsbalance
from vibopt.solve.rivals.balance import balanced
from vibopt.solve.rivals.milp import chosen_weights


def judged_question(case: Case, asked: Asked, method: str, said: Said) -> Trial:
    """A correction judged against the truth."""
    missed = off = np.nan
    if said.answer is not None:
        missed = broken(asked.question, said.answer)
        off = 0.0 if np.isnan(case.goal) else abs(asked.question.value(said.answer) - case.goal) / (case.goal or 1.0)
    return judged(case, method, said, missed, off)


def broken(question: Question, u: ComplexArray) -> float:
    """Greatest violation of a limit or a cap, and distance from a list of weights, as a part of it."""
    over = [np.abs(question.residual(u)) / question.limits - 1.0, np.abs(u) / question.caps - 1.0]
    over += [
        np.atleast_1d(np.abs(option.u - own).min() / np.abs(option.u).max())
        for option, own in zip(question.options, u, strict=False)
        if option is not None
    ]
    return max(0.0, float(np.concatenate(over).max()))


def _vibopt(asked: Asked) -> Said:
    """The plan for the job; the optimiser alone is timed beside it."""
    job = asked.job
    begin = spent()
    plan = solve_job(job)
    whole = spent() - begin
    begin = spent()
    solve_question(asked.question)
    kernel = spent() - begin
    u = np.array([plane.u for plane in plan.plan.fittings[0].planes]) if plan.plan.fittings else None
    return Said(plan.status, plan.claim, u, kernel, whole)


def _given(method: Callable[[Question], Said]) -> Callable[[Asked], Said]:
    """A method that is given the arrays."""
    return lambda asked: method(asked.question)


def _cvxpy(tolerance: float) -> Callable[[Question], Said]:
    """Built and solved anew."""

    def method(question: Question) -> Said:
        if question.is_discrete:
            return Said(REFUSES, "no mixed-integer cone solver comes with it")
        said, u = balanced(
            question.y0, question.H, question.importance, question.limits, question.caps,
            goal=question.goal, threshold=question.huber, tolerance=tolerance,
        )  # fmt: skip
        return Said(said if said in ("optimal", "infeasible") else "unproven", said, u, within=10.0 * tolerance)

    return method


def _milp(sides: int) -> Callable[[Question], Said]:
    """HiGHS, with amplitudes between the sides of a polygon; its optimum is that of the polygon."""

    def method(question: Question) -> Said:
        if not question.is_discrete or question.goal not in ("worst", "correction"):
            return Said(REFUSES, "takes lists in every plane, for the worst residual or the least mass")
        word, u = chosen_weights(
            question.y0, question.H, question.limits, [option.u for option in question.options if option is not None],
            [option.masses for option in question.options if option is not None],
            by_mass=question.goal == "correction", sides=sides, nodes=_NODES,
        )  # fmt: skip
        if u is None:
            return Said("unproven", word)
        return Said("feasible", f"{word}, amplitudes to {1.0 / np.cos(np.pi / sides) - 1.0:.0e}", u)

    return method


def _least_squares_only(solve: Callable[[Question], ComplexArray]) -> Callable[[Question], Said]:
    def method(question: Question) -> Said:
        bounds = np.isfinite(question.limits).any() or np.isfinite(question.caps).any()
        if question.is_discrete or bounds or question.goal != "rms":
            return Said(REFUSES, "takes least squares without limits only")
        return Said("optimal", "least squares", solve(question))

    return method


def _lstsq(question: Question) -> ComplexArray:
    u: ComplexArray = np.linalg.lstsq(question.H, -question.y0, rcond=None)[0].astype(complex)
    return u


def _normal(question: Question) -> ComplexArray:
    adjoint = question.H.conj().T
    u: ComplexArray = np.linalg.solve(adjoint @ question.H, -adjoint @ question.y0).astype(complex)
    return u


def _pruned(question: Question) -> Said:
    """Every choice of the lists, those that cannot win left out."""
    if not question.is_discrete or question.n_planes != 3 or question.goal not in ("worst", "correction"):
        return Said(REFUSES, "takes lists in three planes, for the worst residual or the least mass")
    u = best_choice(question)
    return Said("infeasible", "no choice is left") if u is None else Said("optimal", "no choice left is better", u)


def _rounding(question: Question) -> Said:
    """The continuous answer, each plane moved to the nearest hole and weight by itself."""
    lists = [option.u for option in question.options if option is not None]
    if not lists:
        return Said(REFUSES, "nothing to round")
    caps = np.array([np.abs(option).max() for option in lists])
    solved = solve_continuous(replace(question, caps=caps, options=()))
    if solved.u is None:
        return Said("error", solved.claim)
    u = np.array([option[np.argmin(np.abs(option - own))] for option, own in zip(lists, solved.u, strict=True)])
    return Said("feasible", "nearest hole and weight", u)


def _hsbalance(*, clarabel: bool = False) -> Callable[[Question], Said]:
    """It returns weights without a word on how its solver ended; that is a claim to have answered the question."""

    def method(question: Question) -> Said:
        if not hsbalance.installed():
            return Said(MISSING, hsbalance.HOW)
        limited = np.isfinite(question.limits)
        capped = np.isfinite(question.caps).any()
        model = hsbalance.Model(question.y0, question.H, question.caps, clarabel=clarabel)
        if question.goal == "worst" and limited.any():
            u = model.critical([int(k) for k in np.flatnonzero(~limited)], float(question.limits.min()))
        elif limited.any() or question.goal == "correction" or (capped and question.goal != "worst"):
            return Said(REFUSES, "has no model with this goal and these limits")
        elif question.is_discrete:
            u = model.split([360.0 / HOLES * hole for hole in range(HOLES)], WEIGHTS)
        else:
            u = {"worst": model.worst, "rms": model.least_squares, "huber": model.huber}[question.goal]()
        return Said("optimal", "returned as the solution", u)

    return method


SIDES, _NODES = (8, 16, 32, 64, 128), 20_000
"""Sides of the polygons of HiGHS, and most of its nodes."""
GIVEN_CLARABEL = "hsbalance (Clarabel)"
METHODS: dict[str, Callable[[Asked], Said]] = {
    DEFAULT: _vibopt,
    **{f"cvxpy {tolerance:g}": _given(_cvxpy(tolerance)) for tolerance in CONES},
    "lstsq": _given(_least_squares_only(_lstsq)),
    "normal eq.": _given(_least_squares_only(_normal)),
    "pruned": _given(_pruned),
    **{f"milp {sides}": _given(_milp(sides)) for sides in SIDES},
    "rounding": _given(_rounding),
    "hsbalance": _given(_hsbalance()),
    GIVEN_CLARABEL: _given(_hsbalance(clarabel=True)),
}
"""hsbalance stands twice: with the solver cvxpy finds for it, which may have a licence that ends at 200 rows, and with
that of the other rivals."""

_PAIRS = 256
"""Pairs whose third planes are looked at together."""


def best_choice(question: Question) -> ComplexArray | None:
    """The correction with the smallest worst residual, or of the least mass that keeps the limits; None without one.

    Parameters
    ----------
    question
        A list in each of three planes, equal importance; goal "worst" or "correction".

    Notes
    -----
    A pair of the first two planes leaves at each reading no less than what it leaves there without the third plane,
    less the most that the third can do: with the pairs in the order of that bound (of their mass), the search ends at
    the first that cannot win any more.
    """
    options = [option.u for option in question.options if option is not None]
    masses = [option.masses for option in question.options if option is not None]
    effects = [np.outer(option, column) for option, column in zip(options, question.H.T, strict=True)]
    reach = np.abs(effects[2]).max(axis=0)
    left = question.y0 + effects[0][:, None, :] + effects[1][None, :, :]
    least = np.maximum(np.abs(left) - reach, 0.0)
    weights = masses[0][:, None] + masses[1][None, :]
    by_mass = question.goal == "correction"
    bound = weights + masses[2].min() if by_mass else least.max(axis=-1)
    sound = (least <= question.limits).all(axis=-1)
    best, chosen = np.inf, None
    for pairs in _blocks(bound, sound):
        if bound[tuple(pairs[0])] >= best:
            break
        remaining = np.abs(left[pairs[:, 0], pairs[:, 1], None, :] + effects[2])
        value = weights[pairs[:, 0], pairs[:, 1], None] + masses[2] if by_mass else remaining.max(axis=-1)
        value = np.where((remaining <= question.limits).all(axis=-1), value, np.inf)
        row, third = np.unravel_index(int(value.argmin()), value.shape)
        if value[row, third] < best:
            best, chosen = float(value[row, third]), (*pairs[row].tolist(), int(third))
    return None if chosen is None else np.array([option[k] for option, k in zip(options, chosen, strict=True)])


def _blocks(bound: FloatArray, sound: FloatArray) -> list[IntArray]:
    """Sound pairs in the order of their bound, in blocks (n_pairs, 2)."""
    pairs = np.argwhere(sound)
    pairs = pairs[np.argsort(bound[sound], kind="stable")]
    return [pairs[begin : begin + _PAIRS] for begin in range(0, len(pairs), _PAIRS)]
