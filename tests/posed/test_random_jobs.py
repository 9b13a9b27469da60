"""Random rotors and random lone masses: the programs in the open against the exact methods."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

import vibopt as vo
from texts import ANY_DAMPING, ANY_STIFFNESS, STIFFEST, choice, floor, moves, one_mass, press, table
from vibopt.balancing.continuous import solve_continuous
from vibopt.balancing.question import Question
from vibopt.errors import InputError
from vibopt.posed import methods
from vibopt.posed.weights import Named

# isort: split
from lone_mass import LoneMass, lone_masses

law = settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
TIPS = ("sum", "correction")
"""Goals made of lengths, which have no slope where they vanish: IPOPT may stall there."""


@st.composite
def questions(draw: st.DrawFn) -> Question:
    """Coefficients with caps, limits, a total, a forbidden sector or a pair, each now and then."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n, p = draw(st.integers(1, 9)), draw(st.integers(1, 3))
    y0, H = (rng.normal(size=(n, k)) + 1j * rng.normal(size=(n, k)) for k in (1, p))
    middle, half = rng.uniform(0.0, 6.28), rng.uniform(0.1, 2.9)
    sectors = (((middle - half, middle + half),), *((),) * (p - 1)) if draw(st.booleans()) else ()
    return Question(
        y0=y0[:, 0], H=H, importance=rng.uniform(0.2, 3.0, n),
        limits=np.where(rng.random(n) < 0.3, rng.uniform(0.6, 3.0, n), np.inf),
        caps=rng.uniform(0.05, 1.0, p) if draw(st.booleans()) else np.full(p, np.inf),
        total_cap=float(rng.uniform(0.1, 2.0)) if draw(st.booleans()) else np.inf, sectors=sectors,
        goal=draw(st.sampled_from(("rms", "worst", "sum", "huber", "correction"))),
        huber=float(rng.uniform(0.2, 2.0)), mass_per_unbalance=rng.uniform(0.5, 2.0, p),
        pairs=((0, 1, float(rng.choice((-1.0, 1.0)))),) if p > 1 and rng.random() < 0.5 else (),
    )  # fmt: skip


@law
@given(questions())
def test_cvxpy_corrects_random_rotors_as_the_exact_method_does(question: Question) -> None:
    named = Named.plain(question)
    assume(not named.not_smooth() and not named.not_convex())
    ours, theirs = solve_continuous(question), methods._cvxpy(named)
    if ours.u is None:
        assert theirs.u is None
        assert theirs.least_factor == pytest.approx(ours.least_factor, rel=1e-6)
        return
    room = 1e-7 * max(ours.value, 1e-3 * named.size)
    assert abs(theirs.value - ours.value) <= room
    assert theirs.bound <= ours.value + room


@law
@given(questions(), st.floats(0.05, 3.0))
def test_cvxpy_proves_that_readings_added_up_cannot_be_kept(question: Question, bound: float) -> None:
    """As of the orders of an engine; by the same least factor as ours."""
    n = question.n_readings
    added = replace(
        question, sums=np.arange(n) // 2, limits=np.where(np.arange(n) // 2 == 0, bound, np.inf), goal="worst", pairs=()
    )
    named = Named.plain(added)
    assume(not named.not_smooth() and not named.not_convex())
    ours, theirs = solve_continuous(added), methods._cvxpy(named)
    assert ours.status != "infeasible" or theirs.status == "infeasible"
    if theirs.status == "infeasible":
        assert theirs.least_factor == pytest.approx(ours.least_factor, rel=1e-6)


@law
@given(questions(), st.integers(-9, 3))
def test_cvxpy_corrects_microns_as_it_does_metres(question: Question, power: int) -> None:
    """A part of every reading that is below 10 um is no rounding of the other part."""
    part = 10.0**power
    small = replace(
        question, y0=part * question.y0, H=part * question.H, limits=part * question.limits, huber=part * question.huber
    )
    named = Named.plain(small)
    assume(not named.not_smooth() and not named.not_convex())
    ours, theirs = solve_continuous(question), methods._cvxpy(named)
    if ours.u is None:
        assert theirs.u is None
        return
    size = part ** {"correction": 0, "huber": 2}.get(question.goal, 1)
    assert theirs.value / size == pytest.approx(ours.value, rel=1e-7, abs=1e-10 * named.size / size)


@law
@given(questions())
def test_ipopt_corrects_random_rotors_and_is_never_better_than_what_is_proven(question: Question) -> None:
    named = Named.plain(question)
    assume(not named.not_smooth())
    ours, theirs = solve_continuous(question), methods._ipopt(named)
    if ours.u is None or theirs.u is None:
        assert ours.status == "infeasible" or "stops" in theirs.claim or "without" in theirs.claim
        assert theirs.u is None
        return
    room = 1e-7 * max(ours.value, 1e-3 * named.size)
    assert theirs.value >= ours.value - room
    if question.goal not in TIPS and theirs.claim.startswith("a local optimum") and not question.sectors:
        assert theirs.value <= ours.value + 10.0 * room


@settings(law, max_examples=24)
@given(case=lone_masses())
def test_lone_masses_have_one_answer_by_every_program(case: LoneMass) -> None:
    scene = vo.from_dict(case.document, name="lone.toml")
    assume(scene.goal is not None)
    ours = vo.solve(scene, explain=False)
    assume(ours.status in ("optimal", "feasible") and ours.goal is not None)
    assert scene.goal is not None
    assert ours.goal is not None
    sense = -1.0 if scene.goal.sense == "maximise" else 1.0
    best = float(ours.goal[1].value)
    for method in ("cvxpy", "ipopt"):
        try:
            theirs = vo.solve(scene, method=method, explain=False)
        except InputError:
            continue
        if theirs.goal is None or theirs.status not in ("optimal", "feasible"):
            assert method == "ipopt"
            continue
        off = sense * (float(theirs.goal[1].value) - best) / max(abs(best), 1e-12)
        assert off >= -1e-6, f"{method} is better than what is called {ours.status}"
        if theirs.status == "optimal":
            assert off <= 1e-6


def test_one_of_several_machines_in_a_hall_is_stated_in_its_own_coordinate() -> None:
    """The model is reduced to one coordinate with a scale of its own; the answer is that of the machine alone."""
    asked = floor("10 kN"), moves("press", "20 mm", "start_up", "0..3000 rpm"), STIFFEST
    alone = press(ANY_STIFFNESS, ANY_DAMPING, *asked)
    other = """[bodies.other]
mass = "110 kg"
[links.feet]
between = ["other", "ground"]
stiffness = "2 MN/m"
damping = "1 kN s/m"
"""
    scenes = [
        vo.from_text(text, name="hall.toml")
        for text in (alone, alone.replace("[links.mount]", f"{other}[links.mount]"))
    ]
    for scene in scenes:
        design = vo.solve(scene, method="cvxpy")
        assert design.status == "optimal"
        assert design.goal is not None
        assert design.goal[1].value == pytest.approx(6956917.160715138961, rel=1e-8)


def test_one_answer_that_is_far_from_the_natural_size_is_scaled_anew() -> None:
    scene = vo.from_text(
        one_mass(
            "body", "300 kg", {"stiffness": "8 MN/m", "damping": choice("0.001 N s/m", "1 MN s/m")},
            {"amplitude": "300 N", "speed": "3000 rpm", "varies": "constant"},
            moves("body", "20 mm", "start_up", "0..3000 rpm"), table("goal", minimise="damping", of="mount"),
        ), name="light.toml",
    )  # fmt: skip
    best = vo.solve(scene).goal
    found = vo.solve(scene, method="cvxpy").goal
    assert best is not None
    assert found is not None
    assert found[1].value == pytest.approx(best[1].value, rel=1e-6)


@settings(law, max_examples=20)
@given(st.integers(0, 2**32 - 1), st.sampled_from(("rms", "worst", "sum", "huber")))
def test_what_can_be_cancelled_is_cancelled_by_every_method_to_rounding(seed: int, goal: str) -> None:
    """No tolerance of a solver is left over, of which a limit could seem to buy something."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 4))
    y0, H = (rng.normal(size=(n, k)) + 1j * rng.normal(size=(n, k)) for k in (1, n))
    u = np.linalg.solve(H, -y0[:, 0])
    question = Question(
        y0=y0[:, 0], H=H, importance=rng.uniform(0.2, 3.0, n), limits=np.full(n, np.inf), caps=2.0 * np.abs(u),
        total_cap=np.inf, sectors=(), goal=goal, huber=0.5, mass_per_unbalance=np.ones(n), pairs=(),
    )  # fmt: skip
    named = Named.plain(question)
    for found in (methods._cvxpy(named), *(() if goal in TIPS else (methods._ipopt(named),))):
        assert found.u is not None
        assert question.value(found.u) <= 1e-12 * named.size * max(np.linalg.cond(H), 10.0)
