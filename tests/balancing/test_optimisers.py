"""Laws that hold for every question an optimiser is asked: symmetry, proof, and agreement with other roads."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Any

import cvxpy as cp
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.continuous import solve_continuous
from vibopt.balancing.conventions import WITH, Conventions
from vibopt.balancing.discrete import solve_discrete
from vibopt.balancing.optimisers import solve_question
from vibopt.balancing.plane_options import options_of
from vibopt.balancing.planes import Plane
from vibopt.balancing.question import Goal, Options, Question, Solved, breaks
from vibopt.errors import counted
from vibopt.work import Budget

GOALS: tuple[Goal, ...] = ("rms", "worst", "sum", "huber", "correction")
TURN = 2.0 * np.pi
law = settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))


@st.composite
def questions(draw: st.DrawFn, listed: bool = False, arcs: bool = True, goals: tuple[Goal, ...] = GOALS) -> Question:
    """Random coefficients with caps, limits, a total, sectors or a pair, each now and then."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n, p = draw(st.integers(1, 9)), draw(st.integers(1, 3))
    goal = draw(st.sampled_from(goals))
    y0, H = _normal(rng, n), _normal(rng, n, p)
    limits = np.where(rng.random(n) < 0.4, rng.uniform(0.4, 3.0, n), np.inf)
    caps = rng.uniform(0.05, 1.0, p) if draw(st.booleans()) else np.full(p, np.inf)
    total = float(rng.uniform(0.1, 2.0)) if draw(st.booleans()) else np.inf
    sectors = tuple(_arcs(rng) for _ in range(p)) if arcs and draw(st.booleans()) else ()
    question = Question(
        y0=y0, H=H, importance=rng.uniform(0.2, 3.0, n), limits=limits, caps=caps, total_cap=total, sectors=sectors,
        goal=goal, huber=float(rng.uniform(0.2, 2.0)), mass_per_unbalance=rng.uniform(0.5, 2.0, p),
    )  # fmt: skip
    return _with_lists(rng, question) if listed else question


def _normal(rng: np.random.Generator, *shape: int) -> ComplexArray:
    return rng.normal(size=shape) + 1j * rng.normal(size=shape)


def _arcs(rng: np.random.Generator) -> tuple[tuple[float, float], ...]:
    ends = np.sort(rng.uniform(0.0, TURN, 2 * int(rng.integers(0, 3)))).reshape(-1, 2)
    return tuple((float(low), float(high)) for low, high in ends)


def _options(holes: int, shelf: list[float], most_weights: int = 1, radius: float = 1.0) -> Options:
    """What a plane of evenly spaced holes offers."""
    angles = tuple(TURN * k / holes for k in range(holes))
    plane = Plane("", radii=(radius,), holes=angles, shelf=tuple(shelf), most_weights=most_weights)
    return options_of(plane, Conventions("", "", WITH, "pk", ""))


def _with_lists(rng: np.random.Generator, question: Question) -> Question:
    """Up to 46 options per plane, so that at most 1e5 joint choices are there."""
    lists = []
    for density in question.densities:
        holes, shelf = int(rng.integers(1, 10)), rng.uniform(0.05, 0.8, int(rng.integers(1, 5)))
        lists.append(_options(holes, shelf.tolist(), radius=1.0 / density))
    return replace(question, options=tuple(lists))


def by_brute_force(question: Question) -> float:
    """The least goal over every joint choice that keeps everything; inf where none does."""
    lists = [option.u for option in question.options if option is not None]
    masses = [option.masses for option in question.options if option is not None]
    best = np.inf
    for places in product(*(range(len(option)) for option in lists)):
        u = np.array([option[k] for option, k in zip(lists, places, strict=True)])
        mass = sum(float(own[k]) for own, k in zip(masses, places, strict=True))
        left = np.abs(question.residual(u))
        kept = np.all(left <= question.limits) and mass <= question.total_cap and np.all(np.abs(u) <= question.caps)
        if kept and not breaks(replace(question, limits=np.full(len(left), np.inf)), u):
            best = min(best, mass if question.goal == "correction" else float(question.measure(left)))
    return float(best)


def by_elimination(question: Question, rows: list[int]) -> float:
    """The least goal with nothing left at `rows` by cvxpy over the null space of their coefficients; inf: none."""
    import cvxpy as cp

    A, c = question.H[rows], question.y0[rows]
    base, rank = np.linalg.lstsq(A, -c, rcond=None)[0], min(A.shape)
    if np.abs(A @ base + c).max() > 1e-9:
        return np.inf
    null = np.linalg.svd(A)[2][rank:].conj().T
    u = base + null @ cp.Variable(null.shape[1], complex=True) if null.shape[1] else cp.Constant(base)
    t = cp.multiply(question.importance, cp.abs(question.y0 + question.H @ u))
    goal = {
        "rms": cp.norm(t) / np.sqrt(len(question.y0)), "worst": cp.max(t), "sum": cp.sum(t),
        "huber": cp.sum(cp.huber(t, question.huber)), "correction": cp.sum(cp.abs(u)),
    }[question.goal]  # fmt: skip
    kept = [cp.abs(u) <= question.caps] if np.isfinite(question.caps).all() else []
    least = cp.Problem(cp.Minimize(goal), kept).solve(solver="CLARABEL")
    return float("inf" if least is None else least)


@pytest.mark.sampled(3)
@pytest.mark.parametrize("size", [0.0, 1e-9, 1e-6, 1e-4])
@pytest.mark.parametrize("rows", [[2], [0, 3], [1, 2, 4], [0, 1, 2, 3]], ids=len)
@pytest.mark.parametrize("goal", GOALS)
def test_limits_next_to_nothing_are_equations(goal: Goal, rows: list[int], size: float) -> None:
    rng = np.random.default_rng(len(rows))
    y0, H = 1e-4 * _normal(rng, 7), 0.1 * _normal(rng, 7, 3)
    limits = np.full(7, np.inf)
    limits[rows] = 1e-4 * size
    for caps in (np.full(3, np.inf), np.full(3, 2e-3), np.full(3, 2e-4)):
        question = Question(y0, H, np.ones(7), limits, caps, goal=goal, huber=5e-5)
        solved = solve_question(question)
        order_one = replace(question, y0=1e4 * y0, H=10.0 * H, limits=1e4 * limits, caps=1e3 * caps, huber=0.5)
        best = by_elimination(order_one, rows) * {"correction": 1e-3, "huber": 1e-8}.get(goal, 1e-4)
        if not np.isfinite(best):
            assert solved.status == "infeasible"
            continue
        assert solved.status == "optimal"
        assert solved.u is not None
        assert not breaks(question, solved.u, 1e-8) or size == 0.0
        assert np.abs(question.residual(solved.u))[rows].max() <= 1e-4 * max(size, 1e-11)
        assert solved.value == pytest.approx(best, rel=max(1e-6, 50.0 * size))


def same_answer(first: Solved, second: Solved, factor: float = 1.0, size: float = 1.0) -> None:
    """The same verdict, and goals that differ by `factor` only."""
    assert first.status == second.status
    if first.u is not None:
        assert second.value == pytest.approx(factor * first.value, rel=3e-7, abs=3e-9 * factor * size)


def through_cvxpy(question: Question) -> tuple[float, str]:
    """The same question, written freshly in cvxpy."""
    import cvxpy as cp

    u = cp.Variable(question.n_planes, complex=True)
    left = question.y0 + question.H @ u
    t = cp.multiply(question.importance, cp.abs(left))
    mass = question.densities @ cp.abs(u)
    goals: dict[str, Any] = {
        "rms": lambda: cp.norm(t) / np.sqrt(question.n_readings),
        "worst": lambda: cp.max(t),
        "sum": lambda: cp.sum(t),
        "huber": lambda: cp.sum(cp.huber(t, question.huber)),
        "correction": lambda: mass,
    }
    limits = [cp.abs(left[k]) <= question.limits[k] for k in np.flatnonzero(np.isfinite(question.limits))]
    limits += [cp.abs(u[k]) <= question.caps[k] for k in np.flatnonzero(np.isfinite(question.caps))]
    limits += [mass <= question.total_cap] if np.isfinite(question.total_cap) else []
    problem = cp.Problem(cp.Minimize(goals[question.goal]()), limits)
    problem.solve(solver="CLARABEL")
    return float(problem.value), str(problem.status)


@given(question=questions())
@law
def test_an_answer_keeps_every_limit_and_lies_on_its_bound(question: Question) -> None:
    """What is called optimal is allowed, and its gap is closed by our own bound."""
    solved = solve_continuous(question)
    assert solved.status in {"optimal", "infeasible"}
    if solved.u is not None:
        assert not breaks(question, solved.u, 1e-8)
        assert solved.value == pytest.approx(question.value(solved.u), rel=1e-12)
        assert solved.gap <= 1e-7
        assert solved.bound <= solved.value * (1 + 1e-12) + 1e-12


@given(question=questions(arcs=False))
@law
def test_cvxpy_finds_the_same(question: Question) -> None:
    """Verdict and goal agree with a modelling layer that shares only the solver."""
    solved = solve_continuous(question)
    value, status = through_cvxpy(question)
    if solved.status == "infeasible":
        assert status.startswith("infeasible")
    else:
        assert solved.value == pytest.approx(value, rel=2e-6, abs=2e-6)


@given(question=questions(), seed=st.integers(0, 2**32 - 1))
@law
def test_no_random_correction_beats_the_bound(question: Question, seed: int) -> None:
    """Neither corrections from anywhere nor small changes of the answer come below the proven bound."""
    solved, rng = solve_continuous(question), np.random.default_rng(seed)
    p = question.n_planes
    start = solved.u if solved.u is not None else np.zeros(p, dtype=complex)
    for size in (1e-6, 1e-4, 1e-2, 0.1, 1.0):
        for _ in range(40):
            u = start + size * _normal(rng, p)
            if not breaks(question, u, 0.0):
                assert solved.status != "infeasible"
                assert question.value(u) >= solved.bound - 1e-12


@pytest.mark.parametrize("solve", [solve_continuous, solve_discrete], ids=["continuous", "discrete"])
@given(data=st.data(), angle=st.floats(0.0, TURN))
@law
def test_turning_the_zero_mark_changes_nothing(solve: Any, data: st.DataObject, angle: float) -> None:
    """All phases and all places turned alike: the same residuals, the weights turned."""
    question = data.draw(questions(listed=solve is solve_discrete))
    by = np.exp(1j * angle)
    turned = replace(
        question,
        y0=question.y0 * by,
        sectors=tuple(tuple((low + angle, high + angle) for low, high in arcs) for arcs in question.sectors),
        options=tuple(None if option is None else replace(option, u=option.u * by) for option in question.options),
    )
    same_answer(solve(question), solve(turned))


@pytest.mark.parametrize("solve", [solve_continuous, solve_discrete], ids=["continuous", "discrete"])
@given(data=st.data())
@law
def test_mirroring_the_sense_changes_nothing(solve: Any, data: st.DataObject) -> None:
    """Every phasor conjugated, every arc reversed: the mirror image of the answer."""
    question = data.draw(questions(listed=solve is solve_discrete))
    mirrored = replace(
        question,
        y0=question.y0.conj(),
        H=question.H.conj(),
        sectors=tuple(tuple((-high, -low) for low, high in arcs) for arcs in question.sectors),
        options=tuple(None if option is None else replace(option, u=option.u.conj()) for option in question.options),
    )
    same_answer(solve(question), solve(mirrored))


@pytest.mark.parametrize("solve", [solve_continuous, solve_discrete], ids=["continuous", "discrete"])
@given(data=st.data(), reading=st.integers(-9, 9), unbalance=st.integers(-9, 9))
@law
def test_units_change_nothing(solve: Any, data: st.DataObject, reading: int, unbalance: int) -> None:
    """Readings in other units by 1e-9 to 1e9, unbalances likewise."""
    question = data.draw(questions(listed=solve is solve_discrete))
    a, b = 10.0**reading, 10.0**unbalance
    other = replace(
        question,
        y0=question.y0 * a,
        H=question.H * (a / b),
        limits=question.limits * a,
        caps=question.caps * b,
        huber=question.huber * a,
        options=tuple(None if option is None else replace(option, u=option.u * b) for option in question.options),
        mass_per_unbalance=question.mass_per_unbalance / b,
    )
    factor = {"correction": 1.0, "huber": a * a}.get(question.goal, a)
    same_answer(solve(question), solve(other), factor)


@given(data=st.data())
@law
def test_least_squares_equals_numpy_in_complex(data: st.DataObject) -> None:
    """Free of limits, the answer is the weighted least-squares solution to 1e-12."""
    question = data.draw(questions(arcs=False, goals=("rms",)))
    n, p = question.H.shape
    free = replace(question, limits=np.full(n, np.inf), caps=np.full(p, np.inf), total_cap=np.inf)
    w = question.importance
    expected = np.linalg.lstsq(w[:, None] * question.H, -w * question.y0, rcond=None)[0]
    solved = solve_continuous(free)
    assert solved.status == "optimal"
    conditioned = float(np.linalg.cond(w[:, None] * question.H)) if n >= p else 1e3
    assert solved.u == pytest.approx(expected, rel=1e-13 * conditioned, abs=1e-13 * conditioned)
    assert solved.value == pytest.approx(free.value(expected), rel=1e-12, abs=1e-13)


@given(question=questions(listed=True))
@law
def test_brute_force_never_beats_a_proven_choice(question: Question) -> None:
    """Up to 1e5 joint choices, each tried."""
    solved = solve_discrete(question)
    best = by_brute_force(question)
    assert solved.status in {"optimal", "infeasible"}
    if solved.u is None:
        assert best == np.inf
    else:
        assert not breaks(question, solved.u, 1e-8)
        assert solved.value == pytest.approx(best, rel=1e-8, abs=1e-12)
        assert solved.u.tolist() == [
            one.u[k] for one, k in zip(question.options, solved.chosen, strict=True) if one is not None
        ]


@given(question=questions(listed=True, goals=("rms", "worst", "sum", "huber")))
@law
def test_a_plane_of_any_size_beside_lists_is_chosen_jointly(question: Question) -> None:
    """One plane without a list, with forbidden sectors now and then: the best over all choices of the others."""
    p = question.n_planes
    lists = question.options[: p - 1]
    caps = np.append(question.caps[: p - 1], min(question.caps[p - 1], 0.5))
    mixed = replace(question, options=(*lists, None), caps=caps)
    if p > 2:
        few = tuple(option.take(slice(4)) for option in lists if option is not None)
        mixed = replace(mixed, options=(*few, None))
    solved, best = solve_question(mixed), np.inf
    for fixed in product(*(option.u for option in mixed.options[:-1] if option is not None)):
        u = np.array([*fixed, 0.0], dtype=complex)
        mass = float(mixed.masses(u).sum())
        bare = replace(mixed, limits=np.full(mixed.n_readings, np.inf), options=())
        if np.all(np.abs(u) <= mixed.caps) and mass <= mixed.total_cap and not breaks(bare, u):
            inner = replace(mixed, y0=mixed.residual(u), H=mixed.H[:, -1:], caps=mixed.caps[-1:], options=(),
                            total_cap=mixed.total_cap - mass, sectors=mixed.sectors[-1:],
                            mass_per_unbalance=mixed.mass_per_unbalance[-1:])  # fmt: skip
            one = solve_continuous(inner)
            best = min(best, one.value if one.u is not None else np.inf)
    assert solved.u is None or not breaks(mixed, solved.u, 1e-8)
    assert (solved.value if solved.u is not None else np.inf) == pytest.approx(best, rel=1e-6, abs=1e-7)


@given(question=questions(arcs=False), ratio=st.sampled_from([1.0, -1.0, 0.5j]))
@law
def test_a_pair_is_the_same_as_one_plane_that_does_both(question: Question, ratio: complex) -> None:
    """Static pair, couple, or turned by a quarter: both planes act as one."""
    if question.n_planes < 2:
        return
    tied = replace(question, pairs=((0, 1, ratio),))
    size = abs(ratio)
    merged = replace(
        question,
        H=np.column_stack([question.H[:, 0] + ratio * question.H[:, 1], question.H[:, 2:]]),
        caps=np.append(min(question.caps[0], question.caps[1] / size), question.caps[2:]),
        mass_per_unbalance=np.append(question.densities[0] + size * question.densities[1], question.densities[2:]),
    )
    solved = solve_continuous(tied)
    same_answer(solve_continuous(merged), solved)
    if solved.u is not None:
        assert solved.u[1] == pytest.approx(ratio * solved.u[0], abs=1e-14)


@given(question=questions(arcs=False))
@law
def test_prices_are_confirmed_by_solving_again(question: Question) -> None:
    """The multiplier lies between what a wider limit saves and what a tighter one costs."""
    solved = solve_continuous(question)
    for which, place in _binding(question, solved)[:3]:
        assert solved.prices is not None
        found, limit = (
            np.ravel(getattr(solved.prices, _PRICED[which]))[place],
            np.ravel(getattr(question, which))[place],
        )
        wider, tighter = (_risen(question, solved, which, place, sign * 1e-3 * limit) for sign in (1.0, -1.0))
        price = float(found) * 1e-3 * float(limit)
        slack = 1e-7 * max(abs(wider), 1e-300) + 1e-4 * price + 1e-8 * abs(solved.value)
        assert -wider - slack <= price <= tighter + slack


_PRICED = {"limits": "readings", "caps": "caps", "total_cap": "total"}


def _binding(question: Question, solved: Solved) -> list[tuple[str, int]]:
    """The limits that the answer touches, within a millionth."""
    if solved.u is None:
        return []
    touched = (np.abs(solved.u) >= question.caps * (1 - 1e-6)) & (question.caps > 0)
    found = [
        ("limits", int(k)) for k in np.flatnonzero(np.abs(question.residual(solved.u)) >= question.limits * (1 - 1e-6))
    ]
    found += [("caps", int(p)) for p in np.flatnonzero(touched)]
    return found + [("total_cap", 0)] * bool(question.masses(solved.u).sum() >= question.total_cap * (1 - 1e-6))


def _risen(question: Question, solved: Solved, which: str, place: int, by: float) -> float:
    """How much the goal rises when one limit is moved; inf where nothing keeps the limits."""
    bounds = np.array(getattr(question, which), dtype=float)
    bounds.reshape(-1)[place] += by
    other = solve_continuous(replace(question, **{which: bounds if bounds.ndim else float(bounds)}))
    return np.inf if other.status == "infeasible" else other.value - solved.value


@given(question=questions(arcs=False, goals=("worst",)))
@law
def test_infeasible_says_how_much_wider_the_limits_must_be(question: Question) -> None:
    """With the factor it says, the limits can be kept; with a little less they cannot."""
    solved = solve_continuous(question)
    if solved.status != "infeasible":
        return
    factor = solved.least_factor
    assert solve_continuous(replace(question, limits=question.limits * factor * (1 + 1e-6))).u is not None
    assert solve_continuous(replace(question, limits=question.limits * factor * (1 - 1e-6))).status == "infeasible"
    capped = np.isfinite([*question.caps, question.total_cap]).any()
    which = "with the weights that are allowed, those on what is left" if capped else "all of them"
    assert solved.claim == (
        f"no correction keeps the limits: {which} would have to be at least {factor:.4g} times as wide"
    )


def _plain(n: int, p: int, goal: Goal, cap: float = np.inf, seed: int = 0) -> Question:
    rng = np.random.default_rng(seed)
    free = np.full(n, np.inf)
    return Question(_normal(rng, n), _normal(rng, n, p), np.ones(n), free, np.full(p, cap), goal=goal)


def test_planes_that_act_alike_get_the_smallest_correction_and_the_answer_says_so() -> None:
    """Two equal columns share the correction evenly."""
    question = _plain(6, 2, "rms")
    alike = replace(question, H=question.H[:, [0, 0]])
    solved = solve_continuous(alike)
    assert solved.u is not None
    assert solved.u[0] == pytest.approx(solved.u[1], rel=1e-12)
    assert solved.claim == (
        "least squares in closed form; only 1 of 2 planes can be told apart by what they do, so of all such "
        "corrections this is the smallest"
    )


def test_a_kept_plane_stays_untouched() -> None:
    question = replace(_plain(6, 3, "worst"), caps=np.array([np.inf, 0.0, 0.3]))
    solved = solve_continuous(question)
    assert solved.u is not None
    assert solved.u[1] == 0.0
    assert solved.status == "optimal"


def test_nothing_is_fitted_where_the_limits_are_kept_as_found() -> None:
    question = replace(_plain(6, 2, "correction"), limits=np.full(6, 10.0))
    solved = solve_continuous(question)
    assert solved.u == pytest.approx([0.0, 0.0])
    assert solved.claim == "the limits are kept as found: nothing has to be fitted"


def test_a_sector_moves_the_weight_to_its_edge() -> None:
    """One plane, one reading: the free answer is -y0/H; forbidden there, the nearest edge is best."""
    question = Question(
        np.array([1.0 + 0j]), np.array([[1.0 + 0j]]), np.ones(1), np.array([np.inf]), np.array([np.inf]),
        sectors=(((np.pi - 0.3, np.pi + 0.2),),),
    )  # fmt: skip
    solved = solve_continuous(question)
    assert solved.u is not None
    assert solved.u[0] == pytest.approx(np.cos(0.2) * np.exp(1j * (np.pi + 0.2)), abs=1e-7)
    assert solved.value == pytest.approx(np.sin(0.2), rel=1e-7)


@pytest.mark.parametrize("exponent", [0, 4, 8, 12, 14])
def test_nearly_identical_planes_still_get_a_proof(exponent: int) -> None:
    """Condition numbers to 1e14: the worst residual under caps is proven, however unsure the split between planes."""
    question = _plain(8, 2, "worst", 0.4)
    H = np.column_stack([question.H[:, 0], question.H[:, 0] + 10.0**-exponent * question.H[:, 1]])
    solved = solve_continuous(replace(question, H=H))
    assert solved.status == "optimal"
    assert solved.gap <= 1e-7


def test_a_dead_sensor_does_not_move_the_answer() -> None:
    """A reading of zero that no plane moves changes no goal but the mean."""
    question = _plain(6, 2, "worst", 0.3)
    dead = replace(
        question, y0=np.append(question.y0, 0.0), H=np.vstack([question.H, np.zeros((1, 2))]), importance=np.ones(7),
        limits=np.append(question.limits, np.inf),
    )  # fmt: skip
    assert solve_continuous(dead).value == pytest.approx(solve_continuous(question).value, rel=1e-8)


def test_many_sensors_show_the_solver_few_rows() -> None:
    """2000 readings, 4 planes: the proof holds over all of them."""
    question = _plain(2000, 4, "worst", 0.02)
    solved = solve_continuous(question)
    assert solved.status == "optimal"
    assert solved.u is not None
    assert solved.value == pytest.approx(float(np.abs(question.residual(solved.u)).max()), rel=1e-14)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("goal", GOALS)
def test_many_limits_are_all_kept(goal: Goal) -> None:
    """300 readings with a limit each: those the solver never saw are kept as well, and the bound holds."""
    question = _plain(300, 4, goal, 0.2, seed=7)
    limited = replace(question, limits=0.97 * np.abs(question.y0) + 0.15, huber=1.0)
    solved = solve_continuous(limited)
    assert solved.status == "optimal"
    assert solved.u is not None
    assert not breaks(limited, solved.u, 1e-8)
    assert solved.value == pytest.approx(through_cvxpy(limited)[0], rel=2e-6)


@pytest.mark.parametrize("goal", GOALS)
def test_three_planes_of_24_holes_and_five_weights_are_proven(goal: Goal) -> None:
    """1.77 million joint choices against all of them tried at once."""
    options = _options(24, [0.1, 0.2, 0.3, 0.4, 0.5])
    question = replace(_plain(6, 3, goal, seed=3), options=(options,) * 3, huber=1.0)
    if goal == "correction":
        question = replace(question, limits=np.full(6, 2.5))
    solved = solve_discrete(question)
    assert solved.status == "optimal"
    assert solved.value == pytest.approx(_every_choice(question, options.u, options.masses), rel=1e-8)


def _every_choice(question: Question, points: ComplexArray, masses: FloatArray) -> float:
    best, effects = np.inf, points[:, None, None] * question.H.T[None]  # (n_options, n_planes, n_readings)
    pair = effects[:, None, 1] + effects[None, :, 2]
    pair_mass = masses[:, None] + masses[None, :]
    for first, mass in zip(effects[:, 0], masses, strict=True):
        left = np.abs(question.y0 + first + pair)
        values = mass + pair_mass if question.goal == "correction" else question.measure(left)
        best = min(best, float(np.where(np.all(left <= question.limits, axis=-1), values, np.inf).min()))
    return best


def test_a_search_that_is_stopped_says_its_gap() -> None:
    options = _options(36, [0.01, 0.02, 0.03], 2)
    question = replace(_plain(12, 6, "worst", seed=5), options=(options,) * 6)
    solved = solve_discrete(question, Budget(0, "boxes"))
    assert solved.status == "feasible"
    assert solved.gap > 0
    assert solved.claim == (
        f"stopped after {counted(solved.details['boxes'], 'boxes')}; of the "
        f"{counted(float(len(options.masses)) ** 6, 'choices')} none is better by more than {100 * solved.gap:.3g} %"
    )


def test_a_list_that_sectors_leave_empty_is_infeasible_and_says_where() -> None:
    one = Options(np.array([1.0 + 0j]), np.ones(1))
    question = replace(_plain(4, 2, "rms"), options=(one, None), sectors=(((-1.0, 1.0),), ()))
    solved = solve_discrete(question)
    assert solved.status == "infeasible"
    assert solved.claim == "caps and forbidden sectors leave nothing of the list of plane 0"


def test_a_plane_lists_each_unbalance_once_with_its_lightest_weights() -> None:
    """Two equal weights in opposite holes make nothing, and the empty plane makes it lighter."""
    options = _options(2, [0.01], 2, radius=0.1)
    assert options.u.real == pytest.approx([0.0, 0.001, -0.001], abs=1e-15)
    assert options.masses == pytest.approx([0.0, 0.01, 0.01])
    assert options.weights(2) == ((1, 0.01, 0.1),)
    assert options.weights(0) == ()


def test_one_weight_per_hole() -> None:
    options = _options(3, [1.0, 2.0], 2)
    assert len(options.masses) == 1 + 6 + 3 * 4
    assert max(abs(options.u)) < 4.0


@given(angle=st.floats(0.0, TURN), size=st.floats(0.01, 10.0), holes=st.integers(3, 24))
@law
def test_a_split_between_two_holes_makes_the_same_unbalance(angle: float, size: float, holes: int) -> None:
    """The two neighbours of the wanted angle carry it together."""
    plane = Plane("", radii=(0.2,), holes=tuple(TURN * k / holes for k in range(holes)), split=True)
    found = plane.cut(size / 0.2, angle)
    made = sum(0.2 * one.mass * np.exp(1j * one.angle) for one in found)
    assert made == pytest.approx(size * np.exp(1j * angle), rel=1e-8)
    assert all(one.mass >= 0 for one in found)


def test_how_much_wider_limits_must_be_looks_at_forbidden_sectors() -> None:
    """Everywhere -5/3 leaves two thirds of both readings; where only what adds to them may sit, nothing is best."""
    question = Question(
        y0=np.array([1.0 + 0j, 1.0 + 0j]),
        H=np.array([[1.0 + 0j], [0.2 + 0j]]),
        importance=np.ones(2),
        limits=np.full(2, 0.5),
        caps=np.full(1, np.inf),
    )
    assert solve_continuous(question).least_factor == pytest.approx(4.0 / 3.0, rel=1e-7)
    held = solve_continuous(replace(question, sectors=(((0.3, 2.0 * np.pi - 0.3),),)))
    assert held.status == "infeasible"
    assert held.least_factor == pytest.approx(2.0, rel=1e-7)


@law
@given(seed=st.integers(0, 10**6), goal=st.sampled_from(["sum", "worst"]), tight=st.floats(0.02, 0.5))
def test_shares_under_limits_on_added_readings_agree_with_cvxpy(seed: int, goal: Any, tight: float) -> None:
    """Two weights and a share; two pairs of readings, each held together."""
    dice = np.random.default_rng(seed)
    H, y0 = (dice.normal(size=size) + 1j * dice.normal(size=size) for size in ((7, 3), 7))
    low, high = sorted(dice.uniform(0.0, 1.0, 2))
    question = Question(
        y0, H, importance=np.where(np.arange(7) < 3, 1.0, 0.0),
        limits=np.where(np.arange(7) < 3, np.inf, tight * np.abs(y0[3:]).sum()),
        caps=np.array([high, 0.6, np.inf]), mass_per_unbalance=np.array([0.0, 1.0, 1.0]), goal=goal,
        ends=((low, high), None, None), sums=np.array([0, 1, 2, 3, 3, 4, 4]),
    )  # fmt: skip
    share, u = cp.Variable(), cp.Variable(2, complex=True)
    left = y0 + H[:, 0] * share + H[:, 1:] @ u
    pairs = [cp.sum(cp.abs(left[rows])) for rows in ([3, 4], [5, 6])]
    held = [share >= low, share <= high, cp.abs(u[0]) <= 0.6]
    aim = cp.sum(cp.abs(left[:3])) if goal == "sum" else cp.max(cp.abs(left[:3]))
    theirs = cp.Problem(cp.Minimize(aim), [*held, *(pair <= question.limits[3] for pair in pairs)])
    theirs.solve(solver="CLARABEL")
    ours = solve_question(question)
    if ours.u is not None:
        assert ours.status == "optimal"
        assert not breaks(question, ours.u)
        assert ours.value == pytest.approx(float(theirs.value), rel=1e-6)
        return
    least = cp.Problem(cp.Minimize(cp.max(cp.hstack(pairs))), held)
    least.solve(solver="CLARABEL")
    assert ours.status == "infeasible"
    assert ours.least_factor > 1.0
    assert ours.least_factor * question.limits[3] == pytest.approx(float(least.value), rel=1e-6)


@pytest.mark.parametrize("seed", range(40))
def test_the_least_correction_of_what_is_nearly_kept_as_found_is_proven(seed: int) -> None:
    """One reading: the plane that does most for its mass gets all, (|y0| - limit) / |H|, however little that is."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 5))
    H = (rng.normal(size=n) + 1j * rng.normal(size=n)) * 10.0 ** rng.uniform(-2.0, 2.0, n)
    y0, part, own = rng.normal() + 1j * rng.normal(), 1.0 - 10.0 ** rng.uniform(-4.0, -1.0), rng.uniform(0.5, 2.0, n)
    found = solve_continuous(
        Question(
            y0=np.array([y0]), H=H[None, :], importance=np.ones(1), limits=np.array([part * abs(y0)]),
            caps=np.full(n, np.inf), goal="correction", mass_per_unbalance=own,
        )
    )  # fmt: skip
    assert found.status == "optimal"
    assert found.value == pytest.approx(((1.0 - part) * abs(y0) * own / np.abs(H)).min(), rel=1e-9)


def test_caps_far_beyond_the_answer_take_nothing_from_its_proof() -> None:
    """Two planes on what hardly damped modes of three do: what rounding leaves of a slope is no price of a cap."""
    rng = np.random.default_rng(1)
    modes, seen = rng.normal(size=(4, 3)), rng.normal(size=(3, 4))
    own, speeds = np.array([0.7, 1.3, 1.9, 4.0]), np.linspace(0.3, 2.2, 14)
    gains = [one**2 / (own**2 - one**2 + 0.006j * own * one) for one in speeds]
    rows = np.array([(row * gain) @ modes for gain in gains for row in seen])
    found = rows @ (rng.normal(size=3) + 1j * rng.normal(size=3))
    caps = np.full(2, 100.0)
    asked = Question(found, 1e3 * rows[:, :2], np.ones(42), np.full(42, np.inf), caps, goal="worst")
    solved = solve_continuous(asked)
    assert solved.status == "optimal"
    assert solved.gap < 1e-8
    assert solve_continuous(replace(asked, caps=1e3 * caps)).value == pytest.approx(solved.value, rel=1e-7)
