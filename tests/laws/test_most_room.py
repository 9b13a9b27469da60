"""The design with the most room in its limits: no grid of formulas has more, and limits tighter by a little have none.

The second route is a dense grid of formulas for one mass, and every choice of a list by itself.
"""

from __future__ import annotations

import math
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import test_nearest as nearest
import vibopt as vo
from refusals import refused
from vibopt.arrays import FloatArray
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Design
from vibopt.solve import solve
from vibopt.solve.most_room import GAP
from vibopt.study.sweep import sweep
from vibopt.values.soft import counted, widened

MASS = 300.0
STIFFNESS, DAMPING = np.geomspace(1e4, 1e9, 401), np.geomspace(10.0, 1e6, 301)
ROOM = {"maximise": "margin"}


def press(floor: str | None, start_up: str | None, sag: str | None = None, **more: Any) -> dict[str, Any]:
    """A press of which the floor and the run-up ask for contrary things, and the sag for stiffness."""
    limits = {
        "floor": {"response": "transmitted_force", "into": "ground", "at_most": floor},
        "run_up": {"response": "displacement", "of": "press", "over": "0..3000 rpm", "at_most": start_up},
        "own": {"response": "natural_frequency", "at_least": sag},
    }
    asked = {name: one for name, one in limits.items() if None not in one.values()}
    return nearest.press(0.0, 0.0, **{"limits": asked, "goal": ROOM, **more})


def left(k: FloatArray, c: FloatArray, floor: float, start_up: float, own: float) -> FloatArray:
    """Part of its bound that each of the three limits has left over, stacked."""
    force, moved = nearest.values(k, c)
    frequency = np.sqrt(k / MASS) / (2.0 * math.pi)
    return np.stack([1.0 - force / floor, 1.0 - moved / start_up, frequency / own - 1.0])


def solved(document: dict[str, Any], **more: Any) -> Design:
    return solve(from_dict(document, name="press.toml"), explain=False, **more)


def goal(design: Design) -> float:
    assert design.goal is not None
    return design.goal[1].value


@settings(max_examples=10)
@given(st.floats(5e3, 40e3), st.floats(5e-3, 60e-3), st.floats(1.0, 60.0))
def test_no_design_of_a_dense_grid_has_more_room(floor: float, start_up: float, own: float) -> None:
    """A limit that asks for at least has left over what a bound may be raised by; no design at all is infeasible."""
    k, c = np.meshgrid(STIFFNESS, DAMPING, indexing="ij")
    best = float(left(k, c, floor, start_up, own).min(axis=0).max())
    design = solved(press(f"{floor!r} N", f"{start_up!r} m", f"{own!r} Hz"))
    if design.status == "infeasible":
        assert best <= 1e-9
        return
    assert design.status == "optimal"
    assert max(best, 0.0) - GAP <= goal(design) <= best + 0.04  # the grid is a few percent wide
    mine = left(*np.array([[one] for one in design.x]), floor, start_up, own)
    assert goal(design) == pytest.approx(float(mine.min()), abs=1e-9)
    assert goal(design) == min(row.margin for row in design.limits.values())
    assert any(row.active for row in design.limits.values())


@settings(max_examples=6)
@given(st.floats(8e3, 40e3), st.floats(15e-3, 60e-3))
def test_bounds_tighter_by_the_margin_are_where_designs_end(floor: float, start_up: float) -> None:
    room = goal(solved(press(f"{floor!r} N", f"{start_up!r} m")))
    for beside, status in ((-1e-4, "optimal"), (1e-4, "infeasible")):
        part = 1.0 - room - beside
        assert solved(press(f"{floor * part!r} N", f"{start_up * part!r} m")).status == status


@settings(max_examples=6)
@given(st.floats(8e3, 40e3), st.floats(15e-3, 60e-3), st.floats(1.0, 10.0))
def test_units_do_not_matter_and_a_limit_more_never_helps(floor: float, start_up: float, own: float) -> None:
    one = solved(press(f"{floor!r} N", f"{start_up!r} m"))
    other = solved(press(f"{floor / 1e3!r} kN", f"{start_up * 1e3!r} mm"))
    assert goal(other) == pytest.approx(goal(one), rel=1e-9)
    more = solved(press(f"{floor!r} N", f"{start_up!r} m", f"{own!r} Hz"))
    assert more.status == "infeasible" or goal(more) <= goal(one) + GAP
    alone = solved(press(f"{floor!r} N", f"{start_up!r} m", goal={**ROOM, "limits": ["floor"]}))
    assert goal(alone) >= goal(one) - GAP
    assert goal(alone) == alone.limits["floor"].margin
    assert alone.limits["run_up"].met


def test_of_an_isolation_what_is_let_through_counts() -> None:
    """25 % may pass of the force: with m left over it is 25 % (1 - m), and the stroke 20 mm (1 - m)."""
    document = press(None, "20 mm")
    document["limits"]["quiet"] = {"response": "isolation", "into": "ground", "at_least": "75 %"}
    design = solved(document)
    same = solved(press("7.5 kN", "20 mm"))
    assert goal(design) == pytest.approx(goal(same), abs=GAP)
    assert design.x == pytest.approx(same.x, rel=1e-5)


def test_of_listed_values_none_has_more_room() -> None:
    document = press("10 kN", "20 mm", "8 Hz")
    stiffness, damping = [1e6, 2e6, 3e6, 4e6, 6e6], [8e3, 12e3, 16e3, 20e3, 24e3]
    document["links"]["mount"]["stiffness"] = {"one_of": [f"{one!r} N/m" for one in stiffness]}
    document["links"]["mount"]["damping"] = {"one_of": [f"{one!r} N s/m" for one in damping]}
    design = solved(document)
    rooms = {
        (k, c): float(left(np.array([k]), np.array([c]), 10e3, 20e-3, 8.0).min())
        for k, c in product(stiffness, damping)
    }
    assert design.status == "optimal"
    assert design.x == max(rooms, key=rooms.__getitem__)


def test_of_a_catalogue_no_part_has_more_room(tmp_path: Path) -> None:
    parts = [(1e6, 1.2e4), (2e6, 2.4e4), (3e6, 1.6e4), (3.5e6, 1.9e4), (4e6, 1.2e4), (6e6, 1.0e4)]
    rated = [3500.0, 3000.0, 3200.0, 3700.0, 9000.0, 9000.0]
    rows = [f"P{i},{load!r},{k!r},{c!r}" for i, (load, (k, c)) in enumerate(zip(rated, parts, strict=True))]
    heading = "part,rated load max [N],stiffness [N/m],damping [N s/m]"
    (tmp_path / "shelf.csv").write_text("\n".join([heading, *rows]), encoding="utf-8")
    document = press("10 kN", "20 mm")
    document["links"]["mount"] = {"between": ["press", "ground"], "part": {"catalogue": str(tmp_path / "shelf.csv")}}
    design = solved(document)
    rooms = left(*np.array(parts).T, 10e3, 20e-3, 1.0)[:2].min(axis=0)
    rooms = np.minimum(rooms, 1.0 - MASS * 9.80665 / np.array(rated))
    assert design.status == "optimal"
    assert design.places["links.mount.part"].value == f"P{rooms.argmax()}"
    assert goal(design) == pytest.approx(float(rooms.max()), abs=1e-9)
    assert "picks" not in design.details


def test_a_goal_at_the_end_of_its_range_leaves_the_rest_the_most_room() -> None:
    """Also where many points are answered together: the answer does not hang on how many there are."""
    document = press("10 kN", "20 mm", goal={"maximise": "stiffness", "of": "mount"})
    document["links"]["mount"]["stiffness"]["to"] = "5 MN/m"
    design = solved(document)
    assert design.x[0] == 5e6
    assert design.claim.endswith("; of the designs found with this goal it has the most room in its limits")
    dense = np.geomspace(5e3, 5e4, 20_001)
    rooms = left(5e6 + 0.0 * dense, dense, 10e3, 20e-3, 1.0)[:2].min(axis=0)
    least = min(row.margin for row in design.limits.values())
    assert rooms.max() - 1e-9 <= least <= rooms.max() + 1e-4  # steps of the grid
    many = sweep(from_dict(document, name="press.toml"), {"limits.run_up.at_most": "19 mm..21 mm"}, points=41)
    found = [one.value for one in many.points[20].variables.values()]
    assert found == pytest.approx(list(design.x), rel=1e-6)


@settings(max_examples=60)
@given(st.floats(-3.0, 3.0), st.floats(0.01, 100.0), st.booleans())
def test_what_is_missed_and_what_is_left_over_are_counted_alike(missed: float, soft: float, at_least: bool) -> None:
    """Widening a bound by what is counted just meets it, and the slopes are those of differences."""
    value, slope, bend = counted(missed, soft, at_least=at_least)
    if missed > 0.0 and not at_least:
        assert widened(math.exp(value), soft) == pytest.approx(math.exp(missed), rel=1e-9)
    if missed <= 0.0:
        part = math.expm1(-missed) if at_least else -math.expm1(missed)
        assert value == pytest.approx(-math.log1p(part / soft), abs=1e-12)
    step = 1e-5
    if abs(missed) > 10.0 * step:
        up, down = (counted(missed + turn, soft, at_least=at_least) for turn in (step, -step))
        assert slope == pytest.approx((up[0] - down[0]) / (2.0 * step), rel=1e-5, abs=1e-9)
        assert bend == pytest.approx((up[1] - down[1]) / (2.0 * step), rel=1e-4, abs=1e-8)


def told(document: dict[str, Any]) -> list[str]:
    return [one.partition(": ")[2] for one in refused(from_dict, document, name="press.toml").messages]


def test_what_has_no_room_is_refused_in_words() -> None:
    said = 'goal.maximise = "margin"'
    both = press("10 kN", "20 mm")
    assert told({**both, "goal": {"minimise": "margin"}}) == [
        'goal.minimise = "margin" asks for the design that is next to breaking. Write maximise = "margin".'
    ]
    assert told(press(None, None)) == [f"{said} asks for room in the limits, and there are none. Add a [limits.NAME]."]
    banded = press("10 kN", "20 mm")
    banded["limits"]["away"] = {"response": "natural_frequency", "outside": "20..30 Hz"}
    kept = 'Count the others alone: limits = ["floor", "run_up"].'
    assert told(banded) == [
        f"{said} counts which part of its bound each limit has left over, and away has bands to keep out of. {kept}"
    ]
    assert solved({**banded, "goal": {**ROOM, "limits": ["floor", "run_up"]}}).status == "optimal"
    zero = press("10 kN", "0 mm", goal={**ROOM, "limits": ["run_up"]})
    assert told(zero) == [
        f"{said} counts which part of its bound each limit has left over, and run_up has a bound of zero. Make "
        "something else best."
    ]
    assert told({**both, "goal": {**ROOM, "limits": ["flor"]}}) == [
        'goal.limits = "flor" names no limit of this scene. Did you mean "floor"?'
    ]
    rubber = press("10 kN", "20 mm")
    rubber["links"]["mount"]["tolerance"] = "20 %"
    assert told(rubber) == [
        f"{said} is asked of one machine, but links.mount.stiffness has a tolerance. Remove the tolerance, or make "
        "something else best: limits then hold for the worst machine."
    ]
    assert "row of programs, each with tighter ones. Let vibopt solve it" in str(
        refused(lambda: vo.posed(from_dict(both, name="press.toml")).cvxpy())
    )
