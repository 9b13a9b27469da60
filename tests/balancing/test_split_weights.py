"""Split weights under caps: no pair of neighbouring holes does better, and each hole keeps its own cap."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear, minimize

from vibopt.balancing.continuous import solve_continuous
from vibopt.balancing.fan import Fan
from vibopt.balancing.question import Goal, Question
from vibopt.balancing.split_weights import solve_split, takes


def asked(rng: np.random.Generator, n_planes: int, each: float = float("inf"), goal: str = "rms") -> Question:
    """Random readings, holes anywhere, caps that bind."""
    n = int(rng.integers(1, 4)) + n_planes
    H = rng.normal(size=(n, n_planes)) + 1j * rng.normal(size=(n, n_planes))
    y0 = 3.0 * (rng.normal(size=n) + 1j * rng.normal(size=n))
    holes = [np.sort(rng.uniform(0.0, 2.0 * np.pi, int(rng.integers(3, 9)))) for _ in range(n_planes)]
    return Question(
        y0=y0, H=H, importance=np.ones(n), limits=np.full(n, np.inf), caps=rng.uniform(0.3, 1.5, n_planes),
        goal=goal, huber=2.0, fans=tuple(Fan.of(one.tolist(), each) for one in holes), sectors=((),) * n_planes,
    )  # fmt: skip


def best_by_pairs(question: Question, each: float) -> float:
    """Least rms over all pairs of neighbouring holes."""
    fans = [fan for fan in question.fans if fan is not None]
    choices = [[*fan.gaps, *[(k,) for k in range(len(fan.holes))]] for fan in fans]
    best = min(_of_pairs(question, each, pairs) for pairs in product(*choices))
    return best / float(np.sqrt(question.n_readings))


def _of_pairs(question: Question, each: float, pairs: tuple[tuple[int, ...], ...]) -> float:
    """Least norm for one choice of holes, by bounded least squares, or by scipy's SLSQP where a cap binds."""
    fans = [fan for fan in question.fans if fan is not None]
    phasors = [fan.holes[hole] for fan, pair in zip(fans, pairs, strict=True) for hole in pair]
    owner = np.array([plane for plane, pair in enumerate(pairs) for _ in pair])
    A = question.H[:, owner] * np.array(phasors)
    rows = np.concatenate([A.real, A.imag])
    right = -np.concatenate([question.y0.real, question.y0.imag])
    sums = np.array([owner == plane for plane in range(len(pairs))], dtype=float)
    most = min(each, 1e9)
    start = lsq_linear(rows, right, (0.0, most)).x
    if (sums @ start <= question.caps).all():
        return float(np.linalg.norm(rows @ start - right))
    found = minimize(
        lambda x: float(((rows @ x - right) ** 2).sum()), np.full(len(owner), 0.1 * float(question.caps.min())),
        jac=lambda x: 2.0 * rows.T @ (rows @ x - right), bounds=[(0.0, most)] * len(owner),
        constraints=[{"type": "ineq", "fun": lambda x: question.caps - sums @ x, "jac": lambda _: -sums}],
        method="SLSQP", options={"ftol": 1e-14, "maxiter": 300},
    )  # fmt: skip
    return float(np.sqrt(found.fun))


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10**6), n_planes=st.integers(1, 2))
def test_no_pair_of_neighbouring_holes_is_better(seed: int, n_planes: int) -> None:
    question = asked(np.random.default_rng(seed), n_planes)
    assert takes(question)
    solved = solve_split(question)
    assert solved.status == "optimal"
    assert solved.u is not None
    assert (question.masses(solved.u) <= question.caps * (1 + 1e-7)).all()
    assert solved.value == pytest.approx(best_by_pairs(question, np.inf), rel=2e-5, abs=1e-7)


@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 10**6), each=st.floats(0.1, 0.6))
def test_a_cap_on_each_hole_is_kept_and_nothing_is_better(seed: int, each: float) -> None:
    question = asked(np.random.default_rng(seed), 1, each)
    solved = solve_split(question)
    assert solved.u is not None
    fan = question.fans[0]
    assert fan is not None
    assert fan.excess(complex(solved.u[0])) <= 1e-6
    assert solved.value == pytest.approx(best_by_pairs(question, each), rel=2e-5, abs=1e-7)


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10**6), goal=st.sampled_from(["rms", "worst", "sum", "huber"]))
def test_no_random_split_beats_a_proven_answer(seed: int, goal: str) -> None:
    rng = np.random.default_rng(seed)
    question = asked(rng, 2, goal=goal)
    solved = solve_split(question)
    assert solved.status == "optimal"
    for _ in range(200):
        u = np.zeros(2, dtype=complex)
        for plane, fan in enumerate(question.fans):
            assert fan is not None
            parts = rng.dirichlet(np.ones(len(fan.holes))) * rng.uniform(0.0, question.caps[plane])
            u[plane] = (parts * fan.holes).sum()
        assert question.value(u) >= solved.bound - 1e-9
        assert question.value(u) >= solved.value * (1 - 1e-6)


@pytest.mark.parametrize("size", [1e-9, 1e-5])
@pytest.mark.parametrize("goal", ["rms", "worst", "sum", "huber"])
def test_holes_all_around_under_a_limit_next_to_nothing_are_as_good_as_free_weights(goal: Goal, size: float) -> None:
    question = asked(np.random.default_rng(5), 3, goal=goal)
    fan = Fan.of((2.0 * np.pi * np.arange(12) / 12).tolist(), np.inf)
    limits = np.where(np.arange(question.n_readings) == 1, size, np.inf)
    split = replace(question, limits=limits, caps=np.full(3, 50.0), fans=(fan,) * 3)
    found, free = solve_split(split), solve_continuous(replace(split, fans=()))
    assert (found.status, free.status) == ("optimal", "optimal")
    assert found.value == pytest.approx(free.value, rel=1e-6)
    assert found.u is not None
    assert abs(question.residual(found.u)[1]) <= size * (1.0 + 1e-6) + 1e-9
