"""Where designs end along a number, and answers that begin at a neighbour: both are what solving from nothing shows."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import vibopt as vo
from texts import skid as text_of_skid
from vibopt.jobs import fact_at, facts, with_changes
from vibopt.scene.scene import Scene
from vibopt.solve import solve
from vibopt.study.brink import brink
from vibopt.study.prices import Prices, prices

PROBLEMS = Path(__file__).parents[2] / "problems"
GOALS = (
    'maximise = "stiffness"\nof = "mount"',
    'minimise = "displacement"\nof = "skid"',
    'minimise = "damping"\nof = "mount"',
)


def skid(motor: float = 180.0, pads: float = 3.0, goal: str = GOALS[0]) -> Scene:
    return vo.from_text(text_of_skid(motor, pads, goal))


@settings(max_examples=16)
@given(
    motor=st.floats(150.0, 220.0), pads=st.floats(2.5, 4.0), part=st.floats(-0.3, 0.4),
    path=st.sampled_from(["limits.floor.at_most", "excitations.motor.unbalance", "bodies.skid.mass"]),
    goal=st.sampled_from(GOALS),
)  # fmt: skip
def test_an_answer_begun_at_a_neighbour_is_that_from_nothing(
    motor: float, pads: float, part: float, path: str, goal: str
) -> None:
    job = skid(motor, pads, goal)
    here = solve(job, explain=False)
    fact = fact_at(job, path)
    changed = with_changes(job, fact.changes(fact.value * (1.0 + part)))
    alone, begun = solve(changed, explain=False), solve(changed, explain=False, near=here.x or None)
    assert begun.status == alone.status
    if alone.goal is not None:
        assert begun.goal is not None
        assert begun.goal[1].value == pytest.approx(alone.goal[1].value, rel=2e-6)


@settings(max_examples=8)
@given(
    motor=st.floats(150.0, 220.0), pads=st.floats(2.5, 4.0),
    path=st.sampled_from(["limits.floor.at_most", "excitations.motor.unbalance"]),
)  # fmt: skip
def test_designs_end_where_the_verdict_changes(motor: float, pads: float, path: str) -> None:
    job = skid(motor, pads)
    fact, far = fact_at(job, path), 0.1 if path.startswith("limits") else 10.0
    here = solve(job, explain=False)
    t, x = brink(job, fact, lambda t: fact.value * far**t, (0.0, 1.0), here.x)
    steps = (-1e-5, 1e-5) if math.isfinite(t) else (1.0,)
    t = t if math.isfinite(t) else 0.0
    verdicts = [_verdict(job, fact.changes(fact.value * far ** (t + step))) for step in steps]
    assert verdicts == ([True, False] if t else [True])
    assert len(x) == 2


def _verdict(job: Scene, changes: Any) -> bool:
    status = solve(with_changes(job, changes), explain=False).status
    assert status in ("optimal", "feasible", "infeasible")
    return status != "infeasible"


@pytest.fixture(scope="module")
def some() -> Prices:
    return prices(skid(), only=["limits.floor.at_most", "excitations.motor.speed.lowest"])


@pytest.mark.slow
def test_every_number_of_a_design_of_two_variables_has_a_price_with_both_ranges() -> None:
    job = skid()
    found = prices(job)
    assert {one.path for one in found.rows} == {one.path for one in facts(job)}
    assert all(one.ranged for one in found.rows)
    assert not found.notes


@pytest.mark.slow
def test_the_ranges_of_what_holds_the_answer_back_are_told() -> None:
    """Where the work does not do for all, those of active limits come first."""
    found = prices(vo.read(PROBLEMS / "absorbers" / "rao_9_51_tuned_freely.toml"))
    active = [name for name, one in found.found.limits.items() if one.active]
    assert active == ["low", "high"]
    assert all(row.ranged for row in found.rows if row.name in active)


def test_a_loosened_limit_ends_where_its_loosest_answer_is(some: Prices) -> None:
    tight, loose = some.find("limits.floor.at_most").ways
    assert (tight.beyond, loose.beyond) == ("no design", "nothing more to gain")
    assert tight.ends is not None
    assert loose.ends is not None
    free = solve(with_changes(skid(), {"limits.floor.at_most": "1 MN"}), explain=False)
    assert loose.ends.value == pytest.approx(free.limits["floor"].value.value, rel=1e-4)
    assert some.find("limits.floor.at_most").ranged


def test_a_number_that_the_file_cannot_have_is_no_missing_design(some: Prices) -> None:
    up = some.find("excitations.motor.speed.lowest").ways[1]
    assert up.ends is not None
    assert up.ends.shown == "1500 rpm"
    assert up.beyond == "the file cannot have more"
