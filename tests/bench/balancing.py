"""Balancing against freshly built cvxpy and hsbalance 0.5.5: `python tests/bench/balancing.py`.

One BLAS thread for everybody, processor time of the best of several runs, ratios within one run.  hsbalance is optional
(`pip install hsbalance==0.5.5`); its published example is the one of its README (B&K 17-227, example 6).
"""

from __future__ import annotations

# ruff: noqa: E402, E501
import os

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

from dataclasses import replace
from functools import partial, partialmethod
from typing import Any
from unittest import mock

import numpy as np
from timing import timed

from vibopt.balancing.continuous import solve_continuous
from vibopt.balancing.conventions import WITH, Conventions
from vibopt.balancing.discrete import solve_discrete
from vibopt.balancing.plane_options import options_of
from vibopt.balancing.planes import Plane
from vibopt.balancing.question import Goal, Question

SIZES = ((8, 2), (1000, 100), (5000, 8))
REPEATS = {8: 40, 1000: 3, 5000: 5}


def random_question(n: int, p: int, goal: Goal, capped: bool, seed: int = 1) -> Question:
    """Normal coefficients; caps of 0.7 of the median free least-squares correction, so that many of them bind."""
    rng = np.random.default_rng(seed)
    y0 = rng.normal(size=n) + 1j * rng.normal(size=n)
    H = rng.normal(size=(n, p)) + 1j * rng.normal(size=(n, p))
    free = np.full(n, np.inf)
    plain = Question(y0, H, np.ones(n), free, np.full(p, np.inf), goal=goal)
    size = 0.7 * float(np.median(np.abs(np.linalg.lstsq(H, -y0, rcond=None)[0])))
    return replace(plain, caps=np.full(p, size)) if capped else plain


def fresh_cvxpy(question: Question) -> float:
    """The same program built and solved anew."""
    import cvxpy as cp

    u = cp.Variable(question.n_planes, complex=True)
    left = question.y0 + question.H @ u
    goal = cp.max(cp.abs(left)) if question.goal == "worst" else cp.norm(left) / np.sqrt(question.n_readings)
    caps = [cp.abs(u) <= question.caps] if np.isfinite(question.caps).all() else []
    problem = cp.Problem(cp.Minimize(goal), caps)
    problem.solve(solver="CLARABEL")
    return float(problem.value)


def against_cvxpy() -> None:
    """Least squares and smallest worst residual at three sizes."""
    print(
        f"{'size':>10} {'goal':>6} {'caps':>4} {'ours ms':>9} {'cvxpy ms':>9} {'ratio':>7} {'our gap':>8} {'difference':>10}"
    )
    for n, p in SIZES:
        goals: tuple[Goal, ...] = ("rms", "worst")
        for goal in goals:
            for capped in (False, True):
                question = random_question(n, p, goal, capped)
                ours, solved = timed(partial(solve_continuous, question), REPEATS[n])
                theirs, value = timed(partial(fresh_cvxpy, question), max(2, REPEATS[n] // 4))
                print(
                    f"{n:>6}x{p:<3} {goal:>6} {'yes' if capped else 'no':>4} {1e3 * ours:9.3f} {1e3 * theirs:9.1f}"
                    f" {theirs / ours:7.1f} {solved.plan.gap:8.1e} {(solved.value - value) / value:10.1e}"
                )


def discrete() -> None:
    """24 holes, five shelf weights, three planes, jointly, with proof."""
    plane = Plane(
        "", radii=(1.0,), holes=tuple((np.arange(24) * 2 * np.pi / 24).tolist()), shelf=(0.1, 0.2, 0.3, 0.4, 0.5)
    )
    options = options_of(plane, Conventions("", "", WITH, "pk", ""))
    goals: tuple[Goal, ...] = ("rms", "worst", "sum", "huber")
    for goal in goals:
        for n in (6, 12, 48):
            lists: dict[str, Any] = {"options": (options,) * 3, "huber": 1.0}
            question = replace(random_question(n, 3, goal, False), **lists)
            seconds, solved = timed(partial(solve_discrete, question), 2)
            print(
                f"24 holes x 5 weights x 3 planes, {n:>2} readings, {goal:>5}: {1e3 * seconds:6.0f} ms, {solved.status}"
            )


def against_hsbalance() -> None:
    """Its own published example and the sizes above, where it is installed."""
    try:
        import hsbalance as hs
    except ImportError:
        print("hsbalance is not installed here: its rows are left out (pip install hsbalance==0.5.5).")
        return
    A = hs.convert_math_cart([["170@112"], ["53@78"]])
    B = hs.convert_math_cart([["235@94", "185@115"], ["58@68", "77@104"]])
    alpha = hs.Alpha()
    alpha.add(A=A, B=B, U=hs.convert_math_cart(["1.15@0", "1.15@0"]))
    _row("README", hs, alpha, A, "rms", {})
    _row("README", hs, alpha, A, "worst", {})
    _row("README", hs, alpha, A, "worst", {0: 1.5, 1: 0.8})
    for n, p in SIZES:
        question = random_question(n, p, "worst", True)
        ready = hs.Alpha()
        ready.add(question.H)
        _row(f"{n}x{p}", hs, ready, question.y0[:, None], "rms", {})
        _row(f"{n}x{p}", hs, ready, question.y0[:, None], "worst", dict(enumerate(question.caps)))
    _wrong_answers(hs, alpha, A)


def _row(label: str, hs: Any, alpha: Any, A: Any, goal: Goal, caps: dict[int, float]) -> None:
    """One question asked of both."""
    n, p = alpha.value.shape
    limits = np.array([caps.get(k, np.inf) for k in range(p)])
    question = Question(A[:, 0], alpha.value, np.ones(n), np.full(n, np.inf), limits, goal=goal)

    def theirs() -> Any:
        if goal == "rms":
            return hs.LeastSquares(A=A, alpha=alpha).solve()
        return hs.Min_max(A=A, alpha=alpha, weight_const=caps).solve()

    try:
        slow, w = timed(theirs, 2)
    except Exception as error:
        print(
            f"hsbalance {label:>9} {goal:>5}: stops with {type(error).__name__}: {error}; Clarabel is forced on it instead"
        )
        with mock.patch("cvxpy.Problem.solve", partialmethod(hs.cp.Problem.solve, solver="CLARABEL")):
            slow, w = timed(theirs, 2)
    fast, solved = timed(lambda: solve_continuous(question), 10 if n < 1000 else 3)
    value = question.value(np.asarray(w)[:, 0])
    over = float((np.abs(np.asarray(w)[:, 0]) / limits).max()) - 1.0
    note = f", its caps exceeded by {over:.1e}" if over > 1e-9 else ""
    print(
        f"hsbalance {label:>9} {goal:>5}{' capped' if caps else '':7}: {slow / fast:7.1f} times faster,"
        f" goal {solved.value:.9g} against {value:.9g}{note}"
    )


def _wrong_answers(hs: Any, alpha: Any, A: Any) -> None:
    """Where hsbalance does not give what it says."""
    question = Question(
        A[:, 0], alpha.value, np.ones(2), np.full(2, np.inf), np.full(2, np.inf), goal="huber", huber=10.0
    )
    solved = solve_continuous(question)
    w = np.asarray(hs.LeastSquares(A=A, alpha=alpha).solve(solver="Huber"))[:, 0]
    left = np.abs(question.residual(w))
    print(
        f"hsbalance README, Huber: leaves {left.max():.4g} where {abs(np.abs(question.residual(solved.u)).max()):.1e} can be had"
    )
    try:
        w = np.asarray(hs.LMI(A=A, alpha=alpha, critical_planes={0}, V_max=60.0).solve())[:, 0]
    except Exception as error:
        print(f"hsbalance README, LMI without weight limits: {type(error).__name__}")
        return
    best = solve_continuous(
        replace(question, goal="worst", importance=np.array([1.0, 0.0]), limits=np.array([np.inf, 60.0]))
    )
    left = np.abs(question.residual(w))
    print(
        f"hsbalance README, LMI without weight limits: leaves {left[0]:.4g} at the critical sensor where {best.value:.1e} can be had"
    )


if __name__ == "__main__":
    against_cvxpy()
    discrete()
    against_hsbalance()
