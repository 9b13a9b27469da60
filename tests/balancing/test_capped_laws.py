"""What holds for measured rotors whose weights are capped: scale, order and zero mark decide nothing, cvxpy agrees."""

from __future__ import annotations

import cmath
from dataclasses import replace
from math import radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rotor_jobs import correction, solve_text
from test_rotor_laws import PLANES, SENSORS, Truth, best, job, truths
from vibopt.answer.answer import Answer
from vibopt.balancing.continuous import closed_form
from vibopt.balancing.convex_rounds import within_discs
from vibopt.balancing.question import Question
from vibopt.balancing.rotor_job import RotorJob

RADIUS = 'radius = "100 mm"'
GOALS = st.sampled_from(["rms", "worst"])


def capped(truth: Truth, part: float, goal: str, turn: float = 0.0, more: str = "") -> str:
    """The rotor with caps of a part of the greatest weight that the free plan would fit."""
    cap = part * float(np.abs(best(truth)).max())
    text = job(truth, turn, more=f'{more}[goal]\nminimise = "residual"\ncombine = "{goal}"\n')
    return text.replace(RADIUS, f'{RADIUS}\nweight = {{ from = "0 kg", to = "{cap!r} kg" }}')


def plan_of(answer: Answer[RotorJob]) -> tuple[np.ndarray, np.ndarray]:
    """Corrections and what is left, in the order of names."""
    left = {row.sensor: float(row.residual.value) for row in answer.plan.rows}
    return np.array([correction(answer, name) for name in PLANES]), np.array([left[name] for name in SENSORS])


def goal_of(answer: Answer[RotorJob]) -> float:
    assert answer.goal is not None
    return float(answer.goal[1].value)


@settings(max_examples=30)
@given(truth=truths(), part=st.floats(0.1, 0.9), goal=GOALS, scale=st.sampled_from([1e-3, 1e3]))
def test_readings_of_another_size_have_the_same_plan(truth: Truth, part: float, goal: str, scale: float) -> None:
    plain = solve_text(capped(truth, part, goal))
    larger = solve_text(capped(replace(truth, y0=truth.y0 * scale, H=truth.H * scale), part, goal))
    assert goal_of(larger) == pytest.approx(scale * goal_of(plain), rel=1e-6)
    heavier = Truth(truth.y0, truth.H / scale, tuple(one * scale for one in truth.trials))
    assert goal_of(solve_text(capped(heavier, part, goal))) == pytest.approx(goal_of(plain), rel=1e-6)


@settings(max_examples=30)
@given(truth=truths(), part=st.floats(0.1, 0.9), goal=GOALS)
def test_the_order_of_sensors_and_planes_decides_nothing(truth: Truth, part: float, goal: str) -> None:
    text = capped(truth, part, goal)
    first, second = (text.index(f"[planes.{name}]") for name in PLANES)
    end = text.index("[[runs]]")
    sensors = "".join(f"[sensors.{name}]\n" for name in reversed(SENSORS))
    turned = text[:first] + text[second:end] + text[first:second] + sensors + text[end:]
    plain, other = solve_text(text), solve_text(turned)
    assert [one.name for one in other.job.planes] == list(reversed(PLANES))
    assert [one.name for one in other.job.sensors] == list(reversed(SENSORS))
    assert goal_of(other) == pytest.approx(goal_of(plain), rel=1e-7)
    if goal == "rms":  # the least worst reading may have several plans
        np.testing.assert_allclose(plan_of(other)[0], plan_of(plain)[0], atol=1e-4 * np.abs(best(truth)).max())


@settings(max_examples=30)
@given(truth=truths(), part=st.floats(0.1, 0.9), goal=GOALS, turn=st.floats(0.0, 360.0))
def test_the_zero_mark_decides_nothing(truth: Truth, part: float, goal: str, turn: float) -> None:
    plain, turned = solve_text(capped(truth, part, goal)), solve_text(capped(truth, part, goal, turn))
    assert goal_of(turned) == pytest.approx(goal_of(plain), rel=1e-7)
    if goal == "rms":
        back = plan_of(turned)[0] * cmath.exp(-1j * radians(turn))
        np.testing.assert_allclose(back, plan_of(plain)[0], atol=1e-4 * np.abs(best(truth)).max())


@settings(max_examples=20)
@given(truth=truths(), part=st.floats(0.1, 1.2), goal=GOALS)
def test_the_capped_plan_is_that_of_cvxpy_and_does_what_it_says(truth: Truth, part: float, goal: str) -> None:
    import cvxpy as cp

    answer = solve_text(capped(truth, part, goal))
    assert answer.status == "optimal"
    cap = part * float(np.abs(best(truth)).max())
    u = cp.Variable(len(PLANES), complex=True)
    size = float(np.abs(truth.y0).max())
    left = truth.y0 / size + (truth.H * cap / size) @ u
    least = cp.max(cp.abs(left)) if goal == "worst" else cp.norm(left) / np.sqrt(len(SENSORS))
    found = cp.Problem(cp.Minimize(least), [cp.abs(u) <= 1.0])
    found.solve(solver="CLARABEL")
    assert goal_of(answer) == pytest.approx(float(found.value) * size, rel=1e-6, abs=1e-9 * size)
    weights, shown = plan_of(answer)
    assert np.abs(weights).max() <= cap * (1.0 + 1e-9)
    np.testing.assert_allclose(shown, np.abs(truth.y0 + truth.H @ weights.conj()), rtol=1e-6, atol=1e-9 * size)


def test_nearly_all_capped_least_squares_settle() -> None:
    dice = np.random.default_rng(1)
    settled = []
    for n in dice.integers(1, 9, 200):
        A = dice.normal(size=(14, n)) + 1j * dice.normal(size=(14, n))
        found = within_discs(A.conj().T @ A, A.conj().T @ dice.normal(size=14), dice.uniform(0.01, 0.3, n))
        settled.append(found is not None)
    assert np.mean(settled) >= 0.95


@settings(max_examples=50)
@given(seed=st.integers(0, 10**6), n_planes=st.integers(1, 9), spare=st.integers(1, 12), free=st.booleans())
def test_capped_least_squares_are_stationary(seed: int, n_planes: int, spare: int, free: bool) -> None:
    dice = np.random.default_rng(seed)
    A = dice.normal(size=(n_planes + spare, n_planes)) + 1j * dice.normal(size=(n_planes + spare, n_planes))
    b = dice.normal(size=n_planes + spare) + 1j * dice.normal(size=n_planes + spare)
    caps = dice.uniform(0.05, 1.5, n_planes) * float(np.median(np.abs(np.linalg.lstsq(A, -b, rcond=None)[0])))
    caps[0] = np.inf if free else caps[0]
    x = within_discs(A.conj().T @ A, A.conj().T @ b, caps)
    if x is None:  # it did not settle, and says so
        return
    pull = -(A.conj().T @ (A @ x + b))  # where the goal falls
    size = float(np.abs(A.conj().T @ b).max())
    at = np.abs(x) >= caps * (1.0 - 1e-12)
    assert (np.abs(x) <= caps * (1.0 + 1e-12)).all()
    assert np.abs(pull[~at]).max(initial=0.0) <= 1e-10 * size
    outward = pull[at] * np.exp(-1j * np.angle(x[at]))
    assert np.abs(outward.imag).max(initial=0.0) <= 1e-10 * size
    assert outward.real.min(initial=0.0) >= -1e-10 * size


@settings(max_examples=60)
@given(seed=st.integers(0, 10**6), n=st.integers(1, 6), rank=st.integers(1, 6), scale=st.floats(0.05, 3.0))
def test_least_squares_answer_alone_where_no_cap_holds_them_back(seed: int, n: int, rank: int, scale: float) -> None:
    """Planes that act alike, and planes without a cap that do nothing, among them."""
    dice = np.random.default_rng(seed)
    A = dice.normal(size=(9, min(rank, n))) + 1j * dice.normal(size=(9, min(rank, n)))
    H = A @ dice.normal(size=(min(rank, n), n))
    y0 = dice.normal(size=9) + 1j * dice.normal(size=9)
    best = np.linalg.lstsq(H, -y0, rcond=1e-12)[0]
    caps = scale * dice.uniform(0.5, 1.5, n) * float(np.abs(best).max())
    if n > 1 and dice.random() < 0.3:
        H[:, 0], best[0], caps[0] = 0.0, 0.0, np.inf
        best[1:] = np.linalg.lstsq(H[:, 1:], -y0, rcond=1e-12)[0]
    found = closed_form(Question(y0, H, np.ones(9), np.full(9, np.inf), caps))
    if (np.abs(best) > caps * (1.0 + 1e-5)).any():
        assert found is None or rank < n  # of planes that act alike other weights may do as well
    elif (np.abs(best) < caps * (1.0 - 1e-5)).all() and rank >= n:
        assert found is not None
        np.testing.assert_allclose(found.u, best, rtol=1e-9, atol=1e-9 * np.abs(best).max())
    if found is not None:
        assert found.u is not None
        assert (np.abs(found.u) <= caps).all()
        assert np.abs(H.conj().T @ (y0 + H @ found.u)).max() <= 1e-9 * np.abs(H.conj().T @ y0).max()
