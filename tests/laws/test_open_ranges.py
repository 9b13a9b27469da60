"""A range without an end gives the answer of a generous one."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import vibopt as vo
from vibopt.scene.read import from_dict

SIZES = st.floats(0.3, 3.0)


def press(stiffness: Any, damping: Any, size: float, floor: float, *, block: bool = False) -> dict[str, Any]:
    """A machine, alone or on a block, on a mount to be as stiff as the floor and the way up allow."""
    bodies: dict[str, Any] = {"press": {"mass": f"{300 * size} kg"}}
    mount = {"between": ["press", "ground"], "stiffness": stiffness, "damping": damping}
    links: dict[str, Any] = {"mount": mount}
    if block:
        bodies["block"] = {"mass": f"{500 * size} kg"}
        mount["between"] = ["press", "block"]
        links["feet"] = {"between": ["block", "ground"], "stiffness": "20 MN/m", "damping": "20 kN s/m"}
    return {
        "bodies": bodies,
        "links": links,
        "excitations": {
            "shake": {"kind": "force", "on": "press", "amplitude": "30 kN", "speed": "3000 rpm", "varies": "constant"}
        },
        "limits": {
            "floor": {"response": "transmitted_force", "into": "ground", "at_most": f"{10 * floor} kN"},
            "way_up": {"response": "displacement", "of": "press", "over": "0..3000 rpm", "at_most": "20 mm"},
        },
        "goal": {"maximise": "stiffness", "of": "mount"},
    }


def the_same(open_one: dict[str, Any], closed_one: dict[str, Any]) -> None:
    first, second = vo.solve(from_dict(open_one)), vo.solve(from_dict(closed_one))
    if second.status == "infeasible":
        assert first.status in ("infeasible", "unproven")
        return
    assert second.goal is not None
    if second.goal[1].value > 0.999e9:
        assert first.status == "unbounded"
        return
    assert first.status == second.status == "optimal", (first.claim, second.claim)
    assert first.goal is not None
    assert first.goal[1].value == pytest.approx(second.goal[1].value, rel=1e-6)


@settings(max_examples=25, deadline=None)
@given(size=SIZES, floor=SIZES, which=st.sampled_from(["stiffness", "damping", "both"]))
def test_stiffness_and_damping_of_one_mass(size: float, floor: float, which: str) -> None:
    stiffness, damping = {"from": "10 kN/m", "to": "1 GN/m"}, {"from": "10 N s/m", "to": "1 MN s/m"}
    ends = {"stiffness": [stiffness], "damping": [damping], "both": [stiffness, damping]}[which]
    opened = [{"from": one["from"]} if one in ends else one for one in (stiffness, damping)]
    the_same(press(opened[0], opened[1], size, floor), press(stiffness, damping, size, floor))


@settings(max_examples=15, deadline=None)
@given(size=SIZES, floor=SIZES, block=st.booleans())
def test_stiffness_alone(size: float, floor: float, block: bool) -> None:
    some = [{"from": "10 kN/m"}, {"from": "10 kN/m", "to": "1 GN/m"}]
    the_same(*(press(one, "12 kN s/m", size, floor, block=block) for one in some))


@settings(max_examples=8, deadline=None)
@given(size=SIZES, floor=SIZES)
def test_stiffness_and_damping_on_a_block(size: float, floor: float) -> None:
    damping = {"from": "10 N s/m", "to": "1 MN s/m"}
    some = [{"from": "10 kN/m"}, {"from": "10 kN/m", "to": "1 GN/m"}]
    the_same(*(press(one, damping, size, floor, block=True) for one in some))


@pytest.mark.parametrize("key", ["damping_ratio", "loss_factor"])
def test_a_range_without_an_end_stops_at_the_most_that_the_key_may_be(key: str) -> None:
    """The best damper of a machine that must not move is the strongest: what is chosen can stand in a file."""
    document = press("1 MN/m", "10 N s/m", 1.0, 1.0)
    mount = {"between": ["press", "ground"], "stiffness": "1 MN/m", key: {"from": 0.01}}
    document |= {"links": {"mount": mount}, "goal": {"minimise": "displacement", "of": "press"}, "limits": {}}
    design = vo.solve(from_dict(document))
    assert design.status == "optimal"
    assert design.variables[f"links.mount.{key}"].value.value == pytest.approx(10.0, rel=1e-6)
    assert design.variables[f"links.mount.{key}"].at_bound == "to"
