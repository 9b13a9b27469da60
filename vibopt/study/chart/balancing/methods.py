"""Methods of balancing in the charts: vibopt, cvxpy, numpy, rounding, hsbalance; each with what it claims."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace
from statistics import median

import numpy as np

from vibopt.balancing.continuous import solve_continuous
from vibopt.balancing.discrete import solve_discrete
from vibopt.balancing.question import Question
from vibopt.forms import ComplexArray
from vibopt.solve.rivals import hsbalance
from vibopt.solve.rivals.balance import balanced
from vibopt.study.chart.balancing.built import Asked
from vibopt.study.chart.balancing.cases import HOLES, WEIGHTS
from vibopt.study.chart.trial import DEFAULT, MISSING, REFUSES, Trial, judged

Answer = tuple[str, str, ComplexArray | None]
"""Status, claim and correction."""
_MOST_RUNS, _ENOUGH, _LONG = 20, 0.2, 2.0


def tried(one: Asked, method: str, runs: int) -> Trial:
    """Median time of at least `runs` runs, and the last answer judged against the truth."""
    times: list[float] = []
    answer: Answer = ("error", "", None)
    try:
        while len(times) < runs or (runs > 1 and len(times) < _MOST_RUNS and sum(times) < _ENOUGH):
            begin = time.perf_counter()
            answer = METHODS[method](one.question)
            times.append(time.perf_counter() - begin)
            if answer[0] in (REFUSES, MISSING):
                times[-1] = math.nan
            if answer[0] in (REFUSES, MISSING) or times[-1] > _LONG:
                break
    except Exception as error:  # a method that breaks down ends its own trial only
        times.append(math.nan)
        answer = ("error", f"{type(error).__name__}: {error}", None)
    status, claim, u = answer
    missed = off = math.nan
    if u is not None:
        missed = broken(one.question, u)
        off = 0.0 if math.isnan(one.case.goal) else abs(one.question.value(u) - one.case.goal) / one.case.goal
    return judged(one.case, method, float(median(times)), status, claim, missed, off)


def broken(question: Question, u: ComplexArray) -> float:
    """Greatest violation of a limit or a cap, and distance from a list of weights, as a part of it."""
    over = [np.abs(question.residual(u)) / question.limits - 1.0, np.abs(u) / question.caps - 1.0]
    over += [
        np.atleast_1d(np.abs(option - own).min() / np.abs(option).max())
        for option, own in zip(question.options, u, strict=False)
        if option is not None
    ]
    return max(0.0, float(np.concatenate(over).max()))


def _vibopt(question: Question) -> Answer:
    solved = solve_discrete(question) if question.is_discrete else solve_continuous(question)
    return solved.status, solved.claim, solved.u


def _cvxpy(question: Question) -> Answer:
    if question.is_discrete:
        return REFUSES, "no mixed-integer cone solver comes with it", None
    said, u = balanced(
        question.y0, question.H, question.importance, question.limits, question.caps,
        goal=question.goal, threshold=question.huber,
    )  # fmt: skip
    return said if said in ("optimal", "infeasible") else "unproven", said, u


def _least_squares_only(solve: Callable[[Question], ComplexArray]) -> Callable[[Question], Answer]:
    def method(question: Question) -> Answer:
        bounds = np.isfinite(question.limits).any() or np.isfinite(question.caps).any()
        if question.is_discrete or bounds or question.goal != "rms":
            return REFUSES, "takes least squares without limits only", None
        return "optimal", "least squares", solve(question)

    return method


def _lstsq(question: Question) -> ComplexArray:
    u: ComplexArray = np.linalg.lstsq(question.H, -question.y0, rcond=None)[0].astype(complex)
    return u


def _normal(question: Question) -> ComplexArray:
    adjoint = question.H.conj().T
    u: ComplexArray = np.linalg.solve(adjoint @ question.H, -adjoint @ question.y0).astype(complex)
    return u


def _rounding(question: Question) -> Answer:
    """The continuous answer, each plane moved to the nearest hole and weight by itself."""
    lists = [option for option in question.options if option is not None]
    if not lists:
        return REFUSES, "nothing to round", None
    caps = np.array([np.abs(option).max() for option in lists])
    solved = solve_continuous(replace(question, caps=caps, options=(), option_masses=()))
    if solved.u is None:
        return "error", solved.claim, None
    u = np.array([option[np.argmin(np.abs(option - own))] for option, own in zip(lists, solved.u, strict=True)])
    return "feasible", "nearest hole and weight", u


def _hsbalance(*, clarabel: bool = False) -> Callable[[Question], Answer]:
    """It returns weights without a word on how its solver ended; that is a claim to have answered the question."""

    def method(question: Question) -> Answer:
        if not hsbalance.installed():
            return MISSING, hsbalance.HOW, None
        limited = np.isfinite(question.limits)
        capped = np.isfinite(question.caps).any()
        model = hsbalance.Model(question.y0, question.H, question.caps, clarabel=clarabel)
        if question.goal == "worst" and limited.any():
            u = model.critical([int(k) for k in np.flatnonzero(~limited)], float(question.limits.min()))
        elif limited.any() or question.goal == "correction" or (capped and question.goal != "worst"):
            return REFUSES, "has no model with this goal and these limits", None
        elif question.is_discrete:
            u = model.split([360.0 / HOLES * hole for hole in range(HOLES)], WEIGHTS)
        else:
            u = {"worst": model.worst, "rms": model.least_squares, "huber": model.huber}[question.goal]()
        return "optimal", "returned as the solution", u

    return method


GIVEN_CLARABEL = "hsbalance (Clarabel)"
METHODS: dict[str, Callable[[Question], Answer]] = {
    DEFAULT: _vibopt,
    "cvxpy": _cvxpy,
    "lstsq": _least_squares_only(_lstsq),
    "normal eq.": _least_squares_only(_normal),
    "rounding": _rounding,
    "hsbalance": _hsbalance(),
    GIVEN_CLARABEL: _hsbalance(clarabel=True),
}
"""hsbalance stands twice: with the solver cvxpy finds for it, which may have a licence that ends at 200 rows, and with
that of the other rivals."""
