"""Sensors that are added up, as forward and backward whirl of one place: free weights, lists, and what files say."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest

import vibopt as vo
from refusals import refused
from vibopt.balancing.continuous import solve_continuous
from vibopt.balancing.optimisers import solve_question
from vibopt.balancing.question import Options, Question
from vibopt.document.mistakes import Mistakes
from vibopt.jobs import answer, of_document, with_changes
from vibopt.study.fewest_planes import fewest_planes
from vibopt.study.one_plan import one_plan

GOALS = ("worst", "rms", "sum", "huber", "correction")


def drawn(rng: np.random.Generator, *shape: int) -> Any:
    return rng.normal(size=shape) + 1j * rng.normal(size=shape)


def asked(seed: int, goal: Any, pairs: int = 3, planes: int = 2) -> Question:
    rng = np.random.default_rng(seed)
    sums = rng.permutation(np.repeat(np.arange(pairs), 2))
    return Question(
        y0=drawn(rng, 2 * pairs), H=drawn(rng, 2 * pairs, planes), importance=rng.uniform(0.5, 2.0, pairs)[sums],
        limits=rng.uniform(2.0, 5.0, pairs)[sums], caps=np.full(planes, 2.0), goal=goal, huber=1.0, sums=sums,
    )  # fmt: skip


def by_hand(question: Question, u: Any) -> tuple[Any, Any]:
    """The goal of many corrections (n, n_planes), and the greatest part of a limit that each takes up."""
    left = np.abs(question.y0 + u @ question.H.T)
    pairs = [np.flatnonzero(question.sums == k) for k in np.unique(question.sums)]
    both = np.array([left[:, own].sum(axis=1) for own in pairs]).T
    first = [int(own[0]) for own in pairs]
    t = question.importance * left
    goals = {
        "worst": (question.importance[first] * both).max(axis=1),
        "rms": np.sqrt((t**2).mean(axis=1)),
        "sum": t.sum(axis=1),
        "huber": np.where(t < 1.0, t**2, 2.0 * t - 1.0).sum(axis=1),
        "correction": np.abs(u).sum(axis=1),
    }
    return goals[question.goal], (both / question.limits[first]).max(axis=1)


@pytest.mark.parametrize("goal", GOALS)
@pytest.mark.parametrize("seed", range(6))
def test_lists_are_enumerated_by_hand(goal: str, seed: int) -> None:
    question, rng = asked(seed, goal), np.random.default_rng(100 + seed)
    lists = [np.append(0.0, drawn(rng, 9)) for _ in range(2)]
    lists = [one[np.abs(one) <= 2.0] for one in lists]
    kinds = tuple(
        Options(one, np.abs(one), np.zeros((len(one), 0)), np.zeros((len(one), 0), dtype=np.int64), ()) for one in lists
    )
    solved = solve_question(replace(question, options=kinds))
    value, part = by_hand(question, np.array(list(product(*lists))))
    best = np.where(part <= 1.0 + 1e-9, value, np.inf).min()
    assert solved.status == ("optimal" if np.isfinite(best) else "infeasible")
    if solved.u is not None:
        assert solved.value == pytest.approx(best, rel=1e-8, abs=1e-12)
        assert by_hand(question, solved.u[None])[1] <= 1.0 + 1e-8


@pytest.mark.parametrize("goal", GOALS)
def test_free_weights_are_the_best_of_a_fine_search(goal: str) -> None:
    """No step in any direction from the answer keeps the limits and betters the goal by more than its gap."""
    for seed in range(8):
        question, rng = asked(seed, goal), np.random.default_rng(seed)
        solved = solve_continuous(question)
        if solved.u is None:
            near = solve_continuous(replace(question, limits=question.limits * solved.least_factor * 1.001))
            assert near.u is not None
            continue
        assert solved.status == "optimal"
        assert by_hand(question, solved.u[None])[1] <= 1.0 + 1e-8
        steps = drawn(rng, 4000, 2) * 10.0 ** rng.uniform(-5.0, 0.0, (4000, 1))
        there = solved.u + steps
        value, part = by_hand(question, there)
        kept = (part <= 1.0) & (np.abs(there) <= 2.0).all(axis=1)
        assert value[kept].min(initial=np.inf) >= solved.value * (1.0 - 1e-6)


def rotor(**changed: Any) -> dict[str, Any]:
    """A forward and a backward reading of 3 and 4 um, of which one plane alone could cancel either."""
    return {
        "title": "orbit",
        "conventions": {"phase": "lead", "readings": "phase", "angles": "with rotation", "detector": "pk",
                        "zero": "key"},
        "planes": {"left": {"radius": "100 mm"}, "right": {"radius": "100 mm"}},
        "sensors": {"ahead": {}, "back": {"added_to": "ahead"}},
        "runs": [{"speed": "3000 rpm", "readings": {"ahead": "3 um @ 0 deg", "back": "4 um @ 0 deg"}}],
        "influence": [{"sensor": sensor, "plane": plane, "value": value} for sensor, plane, value in (
            ("ahead", "left", "1 um/g @ 0 deg"), ("back", "left", "0.5 um/g @ 0 deg"),
            ("ahead", "right", "0.5 um/g @ 0 deg"), ("back", "right", "1 um/g @ 0 deg"))],
        "limits": {"axis": {"response": "residual", "at": "ahead", "at_most": "4 um"}},
        "goal": {"minimise": "correction"},
        **changed,
    }  # fmt: skip


def read(document: dict[str, Any]) -> Any:
    return of_document(document, Mistakes("orbit.toml", None))


def test_a_limit_of_a_file_is_on_the_sum() -> None:
    """1.5 um a gram from either plane: 7 um come down to 4 um with 2 g, told with both names; 8 um need none."""
    job = read(rotor())
    plan = answer(job)
    assert plan.goal[1].value == pytest.approx(2e-3, rel=1e-7)
    row = plan.limits["axis"]
    assert row.value.value == pytest.approx(4e-6, rel=1e-7)
    assert row.place == "ahead + back at 3000 rpm"
    assert all(one.limit is None for one in plan.plan.rows)
    assert fewest_planes(job).planes in (("left",), ("right",))
    wide = {"axis": {"response": "residual", "at_most": "8 um"}}
    assert "every limit" in str(refused(lambda: fewest_planes(read(rotor(limits=wide)))))
    with_worst = answer(read(rotor(goal={"minimise": "residual", "combine": "worst"}, planes={"left": {
        "radius": "100 mm", "weight": {"from": "0 g", "to": "1 g"}}}, influence=rotor()["influence"][:2])))  # fmt: skip
    assert with_worst.status == "infeasible"
    assert with_worst.nearest.limits["axis"].value.value == pytest.approx(5.5e-6, rel=1e-3)


@pytest.mark.parametrize("method", ["cvxpy", "ipopt"])
@pytest.mark.parametrize("goal", [{"minimise": "correction"}, {"minimise": "residual", "combine": "worst"}])
def test_programs_in_the_open_add_up_too(method: str, goal: dict[str, str]) -> None:
    planes = {name: {"radius": "100 mm", "weight": {"from": "0 g", "to": "1.2 g"}} for name in ("left", "right")}
    job = read(rotor(goal=goal, planes=planes))
    own, other = answer(job), vo.solve(job, method=method)
    assert own.goal[1].value == pytest.approx(2e-3 if goal["minimise"] == "correction" else 3.4e-6, rel=1e-7)
    assert other.goal[1].value == pytest.approx(own.goal[1].value, rel=1e-6)


def test_one_plan_for_all_scenarios_adds_up_in_each() -> None:
    job = read(rotor(goal={"minimise": "residual", "combine": "worst"}))
    worse = with_changes(job, {"runs.1.readings.back.amplitude": "6 um"})
    plan = one_plan(job, {"as it is": job, "worse": worse})
    assert plan.status == "optimal"
    assert plan.goal[1].value == pytest.approx(1e-6, rel=1e-6)  # 4 and 6 um backward, halved; nothing else left


FILES = {
    "a stranger": (
        {"sensors": {"ahead": {}, "back": {"added_to": "ahaed"}}},
        'orbit.toml: sensors.back.added_to = "ahaed" is no sensor. Did you mean "ahead"?',
    ),
    "itself": (
        {"sensors": {"ahead": {}, "back": {"added_to": "back"}}},
        'orbit.toml: sensors.back.added_to = "back" is the sensor itself. Name another one, or leave it out.',
    ),
    "in turn": (
        {"sensors": {"ahead": {"added_to": "back"}, "back": {"added_to": "ahead"}}},
        'orbit.toml: limits.axis.at = "ahead" is added to back. Write at = "back", which limits both together.\n'
        'orbit.toml: sensors.ahead.added_to = "back" is itself added to ahead. Name one that is added to none, or '
        'leave it out.\norbit.toml: sensors.back.added_to = "ahead" is itself added to back. Name one that is added to '
        "none, or leave it out.",
    ),
    "other importance": (
        {"sensors": {"ahead": {"importance": 2}, "back": {"added_to": "ahead"}}},
        'orbit.toml: sensors.back.added_to = "ahead" does not read the same kind with the same importance, so that '
        "nothing adds up. Write both alike.",
    ),
    "limited alone": (
        {"limits": {"axis": {"response": "residual", "at": "back", "at_most": "4 um"}}},
        'orbit.toml: limits.axis.at = "back" is added to ahead. Write at = "ahead", which limits both together.',
    ),
    "by chance": (
        {"scatter": {"amplitude": "3 %", "angle": "2 deg"}, "limits": {
            "axis": {"response": "residual", "at_most": "4 um", "with_probability": "99 %"}}},
        'orbit.toml: sensors.back.added_to = "ahead" goes neither with robust nor with with_probability. Leave it or '
        "them out.",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("changed", "said"), FILES.values(), ids=FILES)
def test_what_is_refused(changed: dict[str, Any], said: str) -> None:
    assert str(refused(lambda: read(rotor(**changed)))) == said
