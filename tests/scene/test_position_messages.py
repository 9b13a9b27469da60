"""Positions in a range: every message word for word, and the paths by which they are known."""

from __future__ import annotations

from typing import Any

import pytest

import vibopt as vo
from refusals import refused
from vibopt.scene.open_places import open_positions
from vibopt.scene.read import from_dict, with_changes

SPAN = {"from": "-0.2 m", "to": "0.2 m"}
FEET = [["1 m", "0.4 m", "0 m"], ["1 m", "-0.4 m", "0 m"], ["-1 m", "0.4 m", "0 m"], ["-1 m", "-0.4 m", "0 m"]]


def box(**foot: Any) -> dict[str, Any]:
    """A box on four feet that is to stand level."""
    mount = {"between": ["box", "ground"], "at": FEET, "stiffness": "1 MN/m", "shear_ratio": 0.5} | foot
    body = {"mass": "500 kg", "centre": ["0.1 m", "0 m", "0.3 m"], "inertia": ["40 kg m2", "90 kg m2", "100 kg m2"]}
    return {"bodies": {"box": body}, "mounts": {"foot": mount}, "goal": {"minimise": "tilt", "of": "box", "axis": "y"}}


ONE_OF = 'at = { one_of = [["0.6 m", "0.4 m", "0 m"], ["0.8 m", "0.4 m", "0 m"]] }.'
WRONG = [
    (
        {"at": [[{"one_of": ["1 m", "2 m"]}, "0 m", "0 m"]]},
        'mounts.foot.at = [[{ one_of = ["1 m", "2 m"] }, "0 m", "0 m"]] has a list of values for its x, but a '
        f"coordinate is one value or a range. Name whole places to choose from: {ONE_OF}",
    ),
    (
        {"at": [{"from": "1 m"}, "0 m", "0 m"]},
        'mounts.foot.at = [{ from = "1 m" }, "0 m", "0 m"] has an x without an end, but a place is somewhere. Write '
        'both: { from = "0.6 m", to = "1 m" }.',
    ),
    (
        {"shift": {"y": {"from": "0.2 m", "to": "-0.2 m"}}},
        'mounts.foot.shift = { y = { from = "0.2 m", to = "-0.2 m" } } has a reversed range for its y: from is greater '
        "than to. Exchange the two.",
    ),
    (
        {"shift": {"y": {"from": "0.2 m", "to": "200 mm"}}},
        'mounts.foot.shift = { y = { from = "0.2 m", to = "200 mm" } } has an empty range for its y: from equals to. '
        "Write the value alone.",
    ),
    (
        {"shift": {"y": {"from": "0.2 kg", "to": "1 m"}}},
        'mounts.foot.shift = { y = { from = "0.2 kg", to = "1 m" } } has a wrong from of its y: "0.2 kg" is a mass, '
        'but a length is needed here. Write a length, for example "20 mm".',
    ),
    (
        {"shift": {"y": SPAN | {"step": "1 mm"}}},
        'mounts.foot.shift = { y = { from = "-0.2 m", to = "0.2 m", step = "1 mm" } } has the unknown key "step" in '
        "its y. A range of places has from and to.",
    ),
    (
        {"shift": "0.1 m"},
        'mounts.foot.shift = "0.1 m" is no shift. Write how far along each axis, shift = { x = { from = "-0.2 m", to = '
        '"0.2 m" } }.',
    ),
    (
        {"at": {"one_of": [["1 m", "0 m", "0 m"], [SPAN, "0 m", "0 m"]]}},
        'mounts.foot.at = { one_of = [["1 m", "0 m", "0 m"], [{ from = "-0.2 m", to = "0.2 m" }, "0 m",... has a range '
        "in a place of one_of. Keep one of them: a list of places, or places with ranges.",
    ),
    (
        {"at": {"one_of": [FEET, FEET[::-1]]}, "shift": {"x": SPAN}},
        "mounts.foot has shift beside places to choose from. Keep one of them, or name the moved places in one_of.",
    ),
]


@pytest.mark.parametrize(("words", "message"), WRONG, ids=lambda one: str(one)[:40])
def test_a_wrong_range_of_places_says_the_way_out(words: dict[str, Any], message: str) -> None:
    assert str(refused(from_dict, box(**words), name="box.toml")) == f"box.toml: {message}"


def test_a_point_of_a_body_has_no_range() -> None:
    document = box(shift={"x": SPAN}) | {"points": {"top": {"on": "box", "at": [SPAN, "0 m", "1 m"]}}}
    assert str(refused(from_dict, document, name="box.toml")) == (
        'box.toml: points.top.at = [{ from = "-0.2 m", to = "0.2 m" }, "0 m", "1 m"] leaves its x open, but only '
        "mounts have places to choose. Write one length."
    )


def test_positions_without_a_goal_ask_for_one() -> None:
    document = box(shift={"x": SPAN})
    del document["goal"]
    error = refused(
        from_dict, document | {"measures": {"sag": {"response": "static_deflection", "of": "box"}}}, name="box.toml"
    )
    assert str(error) == (
        "box.toml: mounts.foot.shift.x is to be chosen, but there is no [goal] that says which place is best. Add "
        '[goal] with minimise = "displacement" and of = "BODY", for example.'
    )


def test_positions_have_the_paths_that_set_takes() -> None:
    feet = [[SPAN, "0.4 m", "0 m"], *FEET[1:]]
    scene = from_dict(box(at=feet, shift={"y": SPAN}))
    assert list(open_positions(scene)) == ["mounts.foot.at.1.x", "mounts.foot.shift.y"]
    fewer = with_changes(scene, {"mounts.foot.at.1.x": "0.9 m"})
    assert list(open_positions(fewer)) == ["mounts.foot.shift.y"]
    assert fewer.mounts["foot"].sites[0] == (0.9, 0.4, 0.0)


def test_python_says_what_the_file_says() -> None:
    machine = vo.Machine("Box")
    machine.body("box", mass="500 kg", centre=["0.1 m", "0 m", "0.3 m"], inertia=["40 kg m2", "90 kg m2", "100 kg m2"])
    machine.mount(
        "foot",
        between=["box", "ground"],
        at=FEET,
        shift={"x": vo.choose("-0.2 m", "0.2 m")},
        stiffness="1 MN/m",
        shear_ratio=0.5,
    )
    scene = machine.scene(goal=vo.minimise(machine.tilt(of="box", axis="y")))
    assert scene.mounts == from_dict(box(shift={"x": SPAN})).mounts
