"""Positions in a range: closed forms, dense grids, ends, and what is claimed."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vibopt.scene.read import from_dict
from vibopt.scene.scene import Design, Scene
from vibopt.solve import solve
from vibopt.study.freeze import frozen

XS, YS = np.array([0.9, 0.8, -1.0, -0.7]), np.array([0.4, -0.5, 0.45, -0.4])
MASS, WEIGHT, STIFFNESS = 600.0, 600.0 * 9.80665, 1.0e6


def machine(centre: float, goal: dict[str, Any], shift: dict[str, Any] | None = None, **more: Any) -> Scene:
    """Four equal feet under a machine whose centre of mass lies at x = centre."""
    mount = {
        "between": ["box", "ground"],
        "at": [[f"{x!r} m", f"{y!r} m", "0 m"] for x, y in zip(XS.tolist(), YS.tolist(), strict=True)],
        "stiffness": "1 MN/m",
        "shear_ratio": 0.5,
    }
    if shift is not None:
        mount["shift"] = shift
    body = {
        "mass": "600 kg",
        "centre": [f"{centre!r} m", "0 m", "0.3 m"],
        "inertia": ["60 kg m2", "90 kg m2", "99 kg m2"],
    }
    return from_dict({"bodies": {"box": body}, "mounts": {"foot": mount}, "goal": goal, **more}, name="box")


def span(low: float, high: float) -> dict[str, str]:
    return {"from": f"{low!r} m", "to": f"{high!r} m"}


def loads(shift: tuple[float, float], centre: float) -> Any:
    """Static load of each foot [N], by balance of forces and moments: own numpy, no vibopt."""
    x, y = XS + shift[0], YS + shift[1]
    shape = np.array([np.ones(4), x, y])
    sag = np.linalg.solve(STIFFNESS * shape @ shape.T, WEIGHT * np.array([1.0, centre, 0.0]))
    return STIFFNESS * shape.T @ sag


@cache
def _unmoved() -> Design:
    return solve(machine(0.1, LEAST_LOAD, {"x": span(-0.3, 0.3)}))


LEAST_TILT = {"minimise": "tilt", "of": "box", "axis": "y"}
LEAST_LOAD = {"minimise": "static_load", "of": "foot"}


@settings(max_examples=8, deadline=None)
@given(centre=st.floats(-0.1, 0.2))
def test_the_shift_that_levels_brings_the_feet_round_the_centre_of_mass(centre: float) -> None:
    """Level in both planes: the mean of equal feet lies under the centre of mass."""
    tilted = machine(centre, LEAST_TILT, {"x": span(-0.4, 0.4), "y": f"{-float(YS.mean())!r} m"})
    found = solve(tilted)
    assert found.status == "feasible"
    assert found.variables["mounts.foot.shift.x"].value.value == pytest.approx(centre - XS.mean(), abs=1e-7)


@settings(max_examples=6, deadline=None)
@given(centre=st.floats(-0.3, 0.3), low=st.floats(-0.3, -0.05), high=st.floats(0.05, 0.3))
def test_no_position_of_a_dense_grid_beats_the_answer(centre: float, low: float, high: float) -> None:
    found = solve(machine(centre, LEAST_LOAD, {"x": span(low, high)}))
    dense = min(loads((x, 0.0), centre).max() for x in np.linspace(low, high, 4001))
    assert found.goal is not None
    assert found.goal[1].value <= dense * (1.0 + 1e-6)
    at = found.variables["mounts.foot.shift.x"].value.value
    assert found.goal[1].value == pytest.approx(loads((at, 0.0), centre).max(), rel=1e-9)


@pytest.mark.slow
def test_no_pair_of_shifts_of_a_dense_grid_beats_the_answer() -> None:
    """The greatest load has kinks where one foot takes over from another."""
    found = solve(machine(0.12, LEAST_LOAD, {"x": span(-0.2, 0.3), "y": span(-0.1, 0.15)}))
    x, y = np.linspace(-0.2, 0.3, 121), np.linspace(-0.1, 0.15, 121)
    dense = min(loads((a, b), 0.12).max() for a in x for b in y)
    assert found.goal is not None
    assert found.goal[1].value <= dense * (1.0 + 1e-6)


def test_a_best_position_at_an_end_is_exactly_there() -> None:
    found = solve(machine(0.3, LEAST_TILT, {"x": span(-0.1, 0.13)}))
    chosen = found.variables["mounts.foot.shift.x"]
    assert (chosen.value.value, chosen.at_bound) == (0.13, "to")


def test_a_searched_position_is_never_claimed_proven() -> None:
    found = solve(machine(0.1, LEAST_TILT, {"x": span(-0.3, 0.3)}))
    many = found.details["positions"]["solved"]
    assert not found.proven
    assert found.claim == (
        f"the best of {many} positions that were solved; that no better position exists is not proven"
    )


def test_where_no_position_will_do_nothing_is_proven() -> None:
    limit = {"response": "static_deflection", "of": "box", "at_most": "0.1 mm"}
    found = solve(machine(0.1, LEAST_TILT, {"x": span(-0.3, 0.3)}, limits={"sag": limit}))
    assert found.status == "unproven"
    assert found.claim.endswith("positions that were solved keeps every limit; nothing is proven of the others")
    assert not found.variables


def test_a_narrow_window_of_good_positions_is_found_by_how_much_limits_are_missed() -> None:
    """The load of the worst foot is held within a thousandth of the least that any shift can give."""
    shifts = np.linspace(-0.4, 0.4, 80001)
    least = float(min(loads((x, 0.0), 0.1).max() for x in shifts))
    limit = {"response": "static_load", "of": "foot", "at_most": f"{1.0001 * least!r} N"}
    found = solve(machine(0.1, LEAST_TILT, {"x": span(-0.4, 0.4)}, limits={"load": limit}))
    assert found.status == "feasible"


def test_a_range_that_shrinks_to_a_point_gives_what_the_place_gives() -> None:
    goal = {"minimise": "tilt", "of": "box", "axis": "y"}
    narrow = solve(machine(0.1, goal, {"x": span(0.05, 0.05 + 1e-9)}))
    kept = solve(frozen(narrow.scene, narrow.x))
    assert narrow.goal is not None
    assert kept.measures["minimised"].value.value == pytest.approx(narrow.goal[1].value, rel=1e-12)
    x = np.array([np.ones(4), XS + 0.05, YS])
    tilt = np.linalg.solve(STIFFNESS * x @ x.T, WEIGHT * np.array([1.0, 0.1, 0.0]))[1]
    assert narrow.goal[1].value == pytest.approx(abs(tilt), rel=1e-6)


@settings(max_examples=4, deadline=None)
@given(moved=st.floats(-2.0, 2.0))
def test_moving_the_origin_changes_nothing(moved: float) -> None:
    """Feet, centre of mass and axes moved together leave the shift as it was."""
    here = _unmoved()
    document = dict(machine(0.1, LEAST_LOAD, {"x": span(-0.3, 0.3)}).document)
    feet = [[f"{x + moved!r} m", f"{y!r} m", "0 m"] for x, y in zip(XS.tolist(), YS.tolist(), strict=True)]
    document["mounts"] = {"foot": document["mounts"]["foot"] | {"at": feet}}
    document["bodies"] = {"box": document["bodies"]["box"] | {"centre": [f"{0.1 + moved!r} m", "0 m", "0.3 m"]}}
    there = solve(from_dict(document))
    assert here.goal is not None
    assert there.goal is not None
    assert there.goal[1].value == pytest.approx(here.goal[1].value, rel=1e-7)


@pytest.mark.slow
def test_listed_stiffnesses_are_chosen_together_with_the_position() -> None:
    """Of listed feet the softest that keeps a sag at some position: 2 % softer than this, none would at any."""
    limit = {"response": "static_deflection", "of": "box", "at_most": "2 mm"}

    def needed(shift: float) -> float:
        shape, under = np.array([np.ones(4), XS + shift, YS]), np.array([1.0, 0.2, 0.0])
        return float(under @ np.linalg.solve(shape @ shape.T, under)) * WEIGHT / 2e-3

    least = min(needed(float(x)) for x in np.linspace(-0.3, 0.3, 2001))
    document = dict(machine(0.2, LEAST_TILT, {"x": span(-0.3, 0.3)}, limits={"sag": limit}).document)
    listed = [f"{part * least!r} N/m" for part in (0.98, 1.0005)]
    document["mounts"] = {"foot": document["mounts"]["foot"] | {"stiffness": {"one_of": listed}}}
    document["goal"] = {"minimise": "stiffness", "of": "foot"}
    found = solve(from_dict(document))
    assert found.status == "feasible"
    assert found.variables["mounts.foot.stiffness"].value.value == pytest.approx(1.0005 * least, rel=1e-9)
    assert needed(found.variables["mounts.foot.shift.x"].value.value) <= 1.0005 * least
