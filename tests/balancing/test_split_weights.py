"""Split weights under caps: no pair of neighbouring holes does better, and each hole keeps its own cap."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear, minimize

from rotor_jobs import read_text
from vibopt.balancing.continuous import solve_continuous
from vibopt.balancing.discrete import solve_discrete
from vibopt.balancing.fan import Fan
from vibopt.balancing.fitting import not_permitted
from vibopt.balancing.optimisers import solve_question
from vibopt.balancing.question import Goal, Options, Question, breaks
from vibopt.balancing.solve_rotor import solve_job


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
    solved = solve_question(question)
    assert solved.status == "optimal"
    assert solved.u is not None
    assert (question.masses(solved.u) <= question.caps * (1 + 1e-7)).all()
    assert solved.value == pytest.approx(best_by_pairs(question, np.inf), rel=2e-5, abs=1e-7)


@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 10**6), each=st.floats(0.1, 0.6))
def test_a_cap_on_each_hole_is_kept_and_nothing_is_better(seed: int, each: float) -> None:
    question = asked(np.random.default_rng(seed), 1, each)
    solved = solve_question(question)
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
    solved = solve_question(question)
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
    found, free = solve_question(split), solve_continuous(replace(split, fans=()))
    assert (found.status, free.status) == ("optimal", "optimal")
    assert found.value == pytest.approx(free.value, rel=1e-6)
    assert found.u is not None
    assert abs(question.residual(found.u)[1]) <= size * (1.0 + 1e-6) + 1e-9


def beside_lists(rng: np.random.Generator, each: float, goal: Goal) -> Question:
    """One plane of cut weights beside one or two that choose from a list, with a total that may bind."""
    question = asked(rng, 1, each, goal)
    n_lists = int(rng.integers(1, 3))
    n = question.n_readings
    H = np.column_stack([question.H, rng.normal(size=(n, n_lists)) + 1j * rng.normal(size=(n, n_lists))])
    lists = [np.append(0.0, rng.uniform(0.2, 1.0) * np.exp(2j * np.pi * rng.uniform(size=3))) for _ in range(n_lists)]
    every = [Options(one, np.abs(one)) for one in lists]
    return replace(
        question, H=H, caps=np.append(question.caps, [np.inf] * n_lists), sectors=((),) * (1 + n_lists),
        fans=(*question.fans, *[None] * n_lists), options=(None, *every),
        total_cap=float(rng.choice([np.inf, 1.2])),
    )  # fmt: skip


def best_of_fillings(question: Question, each: float) -> float:
    """Least rms over every filling of the lists and every pair of neighbouring holes."""
    best = np.inf
    for filling in product(*(one.u for one in question.options if one is not None)):
        held = np.array(filling)
        room = question.total_cap - float(np.abs(held).sum())
        if room < 0.0:
            continue
        left = replace(
            question, y0=question.y0 + question.H[:, 1:] @ held, H=question.H[:, :1], options=(),
            caps=np.minimum(question.caps[:1], room), total_cap=np.inf, fans=question.fans[:1], sectors=((),),
        )  # fmt: skip
        best = min(best, best_by_pairs(left, each))
    return best


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6), each=st.sampled_from([0.2, 0.5, np.inf]))
def test_beside_lists_no_filling_with_any_pair_of_holes_is_better(seed: int, each: float) -> None:
    question = beside_lists(np.random.default_rng(seed), each, "rms")
    solved = solve_question(question)
    assert solved.status == "optimal"
    assert solved.u is not None
    assert not breaks(question.chosen_only(solved.chosen), solved.u, 2e-6)
    assert solved.value == pytest.approx(best_of_fillings(question, each), rel=2e-5, abs=1e-6)
    assert [options is None or options.u[place] == u for options, place, u in zip(
        question.options, solved.chosen, solved.u, strict=True)] == [True] * question.n_planes  # fmt: skip


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10**6), goal=st.sampled_from(["rms", "worst", "sum", "correction"]), lists=st.booleans())
def test_beside_lists_and_forbidden_sectors_no_random_plan_beats_the_answer(seed: int, goal: Goal, lists: bool) -> None:
    rng = np.random.default_rng(seed)
    question = beside_lists(rng, 0.5, goal) if lists else asked(rng, 2, 0.5, goal)
    free = np.append(rng.normal(size=question.n_readings), 0.0)[:-1] + 1j * rng.normal(size=question.n_readings)
    low = float(rng.uniform(0.0, 6.0))
    question = replace(
        question, H=np.column_stack([question.H, free]), caps=np.append(question.caps, 0.8),
        sectors=(*question.sectors, ((low, low + float(rng.uniform(0.5, 5.0))),)), fans=(*question.fans, None),
        options=(*question.options, None) if lists else (),
        limits=np.full(question.n_readings, 0.9 * float(np.abs(question.y0).max())),
    )  # fmt: skip
    solved = solve_question(question)
    if solved.u is not None:
        assert solved.status in ("optimal", "feasible")
        assert not breaks(question.chosen_only(solved.chosen), solved.u, 2e-6)
    for _ in range(400):
        u = np.zeros(question.n_planes, dtype=complex)
        chosen = [-1] * question.n_planes
        for plane, fan in enumerate(question.fans):
            options = question.options[plane] if lists else None
            if options is not None:
                chosen[plane] = int(rng.integers(len(options.u)))
                u[plane] = options.u[chosen[plane]]
            elif fan is not None and fan.gaps:
                pair = fan.gaps[int(rng.integers(len(fan.gaps)))]
                u[plane] = (rng.uniform(0.0, 0.5, 2) * fan.holes[list(pair)]).sum()
            else:
                u[plane] = rng.uniform(0.0, 0.8) * np.exp(1j * rng.uniform(0.0, 2.0 * np.pi))
        only = question.chosen_only(chosen)
        if not breaks(only, u, 0.0):
            assert solved.status != "infeasible"
            assert only.value(u) >= solved.bound * (1.0 - 1e-6) - 1e-9
            assert solved.status != "optimal" or only.value(u) >= solved.value * (1.0 - 2e-6)


HOLED = """
[planes.p]
holes = 3
split = true
radius = "100 mm"
{held}
[planes.q]
holes = 4
radius = "100 mm"
shelf = ["1 g"]
[[runs]]
name = "found"
speed = "1200 rpm"
readings = {{ a = "100 um pk @ 240 deg" }}
[[runs]]
name = "trial"
speed = "1200 rpm"
weights = {{ p = "5 g @ 0 deg" }}
readings = {{ a = "86.60254037844386 um pk @ 270 deg" }}
[[runs]]
name = "trial q"
speed = "1200 rpm"
weights = {{ q = "1 g @ 0 deg" }}
readings = {{ a = "100.00001 um pk @ 240 deg" }}
[conventions]
phase = "lag"
readings = "phase"
angles = "against rotation"
zero = "key"
detector = "pk"
{limits}
"""


@pytest.mark.parametrize(
    ("held", "limits", "left"),
    [
        ('weight = { from = "0 g", to = "10 g" }', "", 50e-6),
        ("", '[limits.t]\nresponse = "correction"\nof = "p"\nat_most = "12 g"', 40e-6),
        ('remove = true\ndrill = { diameter = "10 mm", density = "7850 kg/m3", deepest = "10 mm" }', "", 38.35e-6),
    ],
)
def test_caps_and_drills_of_cut_weights_are_kept_beside_a_shelf(held: str, limits: str, left: float) -> None:
    """In file words; the weights of the plan are added up, and the rotor of closed form is 10 um/g along p's zero."""
    answer = solve_job(read_text(HOLED.format(held=held, limits=limits)))
    assert answer.status == "optimal"
    assert answer.goal is not None
    assert answer.goal[1].value == pytest.approx(left, rel=3e-3)
    assert not not_permitted(answer.job.planes, answer.plan.fittings[0].planes)


def test_a_plan_that_is_heavier_than_its_cap_is_no_answer() -> None:
    """Whatever an optimiser says: here one that knows no caps."""
    job = read_text(HOLED.format(held='weight = { from = "0 g", to = "10 g" }', limits=""))
    answer = solve_job(job, solver=lambda one: solve_discrete(replace(one, caps=np.full(2, np.inf), fans=())))
    assert (answer.status, answer.claim) == ("check_failed", "what the weights do not keep: the cap of p")
