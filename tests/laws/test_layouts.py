"""Ends left open: the best layout of spring, damper and inerter, against every layout by its own formula."""

from __future__ import annotations

import copy
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import vibopt as vo
from refusals import refused
from vibopt.report.machine_parts import sketch_of
from vibopt.report.sketch import levels
from vibopt.scene.read import from_dict
from vibopt.solve import solve

MOTION = {"motion": {"response": "displacement", "of": "machine"}}
UPPER, LOWER = ["machine", "joint"], ["joint", "ground"]
EITHER = {"one_of": [UPPER, LOWER]}
MACHINE: dict[str, Any] = {
    "title": "machine beside a network of three parts",
    "bodies": {"machine": {"mass": "100 kg"}, "joint": {"mass": "0 kg"}},
    "links": {
        "mount": {"between": ["machine", "ground"], "stiffness": "100 kN/m", "damping": "20 N s/m"},
        "spring": {"between": EITHER, "stiffness": "8 kN/m"},
        "damper": {"between": EITHER, "damping": "100 N s/m"},
    },
    "inerters": {"flywheel": {"between": EITHER, "inertance": "10 kg"}},
    "excitations": {
        "shaking": {"kind": "force", "on": "machine", "amplitude": "100 N", "speed": "5 Hz", "varies": "constant"}
    },
    "goal": {"minimise": "displacement", "of": "machine"},
}
PARTS = ("links.spring.between", "links.damper.between", "inerters.flywheel.between")


def moved(omega: float, parts: list[complex], above: tuple[bool, ...]) -> float:
    """Amplitude [m] of the machine: parts [N/m] above the joint in a row with those below it."""
    upper = sum(part for part, one in zip(parts, above, strict=True) if one)
    lower = sum(part for part, one in zip(parts, above, strict=True) if not one)
    row = upper * lower / (upper + lower) if upper and lower else 0.0
    return float(abs(100.0 / (1e5 + 20j * omega - 100.0 * omega**2 + row)))


@given(
    k=st.floats(1e3, 3e4), c=st.floats(10.0, 1e3), b=st.floats(2.0, 40.0), speed=st.floats(2.0, 12.0)
)  # fmt: skip
def test_no_layout_is_better_than_the_one_that_is_chosen(k: float, c: float, b: float, speed: float) -> None:
    document = copy.deepcopy(MACHINE)
    document["links"]["spring"]["stiffness"] = f"{k!r} N/m"
    document["links"]["damper"]["damping"] = f"{c!r} N s/m"
    document["inerters"]["flywheel"]["inertance"] = f"{b!r} kg"
    document["excitations"]["shaking"]["speed"] = f"{speed!r} Hz"
    design = solve(from_dict(document))
    omega = 2.0 * np.pi * speed
    parts = [k, 1j * omega * c, -(omega**2) * b]
    every = {one: moved(omega, parts, one) for one in product((True, False), repeat=3) if len(set(one)) == 2}
    alone = float(abs(100.0 / (1e5 + 20j * omega - 100.0 * omega**2)))
    assert design.status == ("optimal" if alone > min(every.values()) else "feasible"), design.claim
    assert design.claim.endswith("better" if alone > min(every.values()) else "which is better: leave them out")
    assert design.goal is not None
    assert design.goal[1].value == pytest.approx(min(every.values()), rel=1e-9)
    chosen = tuple(design.places[path].value == "machine to joint" for path in PARTS)
    assert every[chosen] == pytest.approx(min(every.values()), rel=1e-9)
    assert len(design.details["places"]) == 3
    assert design.claim.startswith("the best of 3 layouts, each of them proven; ")


def test_rows_in_another_order_are_told_apart_where_something_looks_at_the_joint() -> None:
    document = {**MACHINE, "measures": {"joint": {"response": "displacement", "of": "joint"}}}
    assert len(solve(from_dict(document)).details["places"]) == 6


def _row(kind: str) -> tuple[dict[str, Any], list[list[str]]]:
    """A spring and a damper whose order counts, and the pairs that each may join."""
    document = copy.deepcopy(MACHINE)
    del document["inerters"]
    document["links"]["spring"]["stiffness"] = "80 kN/m"
    document["links"]["damper"]["damping"] = "4 kN s/m"
    if kind == "release":
        document["excitations"] = {"go": {"kind": "release", "on": "machine", "displacement": "10 mm"}}
        document["goal"] = {"minimise": "peak_force", "into": "ground"}
    if kind == "heavy beam":
        bar = {"kind": "cantilever", "length": "1 m", "modulus": "200 GPa", "diameter": "40 mm"}
        document["links"]["spring"] = {"beam": {**bar, "density": "7850 kg/m3"}}
        document["goal"] = {"maximise": "displacement", "of": "machine"}
    if kind == "gears":
        inertias = {"machine": {"inertia": "9 kg m2"}, "hub": {"inertia": "3 kg m2"}, "far": {"inertia": "25 kg m2"}}
        joint = {"inertia": "0 kg m2", "geared_to": "hub", "speed_ratio": -0.25}
        document["bodies"] = {**inertias, "joint": joint}
        document["links"] = {
            "mount": {"between": ["machine", "hub"], "torsional_stiffness": "20 kN m/rad"},
            "spring": {"torsional_stiffness": "40 kN m/rad"},
            "damper": {"torsional_damping": "500 N m s/rad"},
        }
        document["excitations"]["shaking"] |= {"kind": "moment", "amplitude": "100 N m"}
        document["goal"] = {"maximise": "rotation", "of": "machine"}
    return document, [["far" if kind == "gears" else "machine", "joint"], LOWER]


@pytest.mark.parametrize("kind", ["release", "heavy beam", "gears"])
def test_both_orders_of_a_row_are_tried_where_they_differ(kind: str) -> None:
    """Against each layout that is written out, without a choice."""
    document, pairs = _row(kind)
    goal = document.pop("goal")
    response = {
        "response": goal.get("minimise") or goal["maximise"],
        **{k: goal[k] for k in ("of", "into") if k in goal},
    }
    values = []
    for spring, damper in product(pairs, repeat=2):
        one = copy.deepcopy(document) | {"measures": {"asked": response}}
        one["links"]["spring"]["between"], one["links"]["damper"]["between"] = spring, damper
        if spring != damper or kind != "release":  # else nothing is carried
            values.append(solve(from_dict(one)).measures["asked"].value.value)
    document["goal"] = goal
    document["links"]["spring"]["between"] = document["links"]["damper"]["between"] = {"one_of": pairs}
    design = solve(from_dict(document))
    best = min(values) if "minimise" in goal else max(values)
    assert design.goal is not None
    assert design.goal[1].value == pytest.approx(best, rel=1e-9)


def test_a_layout_that_is_not_answered_is_named_and_nothing_is_called_proven() -> None:
    """Two dampers in a row brake, but hold their joint nowhere: it is better than the others, and refused."""
    document = copy.deepcopy(MACHINE)
    del document["inerters"]
    document["links"] = {
        "mount": {"between": ["machine", "ground"], "stiffness": "100 kN/m"},
        "spring": {"between": {"one_of": [["machine", "ground"], UPPER]}, "stiffness": "80 kN/m"},
        "other": {"between": {"one_of": [["machine", "ground"], LOWER]}, "stiffness": "50 kN/m"},
        "upper": {"between": UPPER, "damping": "4 kN s/m"},
        "lower": {"between": LOWER, "damping": "4 kN s/m"},
    }
    said = (
        "; 1 more layout not answered (spring machine to ground, other machine to ground): bodies.joint has no mass, "
        "and no spring holds it, so that it drifts under any steady force. Of dampers in a row write one: 1/c = "
        "1/c1 + 1/c2"
    )
    design = solve(from_dict(document))
    assert design.status == "feasible"
    assert design.claim.endswith(said)
    document["limits"] = {"still": {"response": "displacement", "of": "machine", "at_most": "1 um"}}
    design = solve(from_dict(document))
    assert design.status == "unproven"
    assert design.claim.endswith(said)


def test_values_and_layout_are_chosen_together_and_saved() -> None:
    """The best of three programs, each with the ends written out."""
    document = copy.deepcopy(MACHINE)
    del document["links"]["mount"]["damping"]
    document["links"]["spring"]["stiffness"] = {"from": "100 N/m", "to": "20 kN/m"}
    document["links"]["damper"]["damping"] = {"from": "1 N s/m", "to": "10 kN s/m"}
    document["excitations"]["shaking"]["speed"] = "0..20 Hz"
    design = vo.solve(from_dict(document))
    values = []
    for ends in ((UPPER, UPPER, LOWER), (UPPER, LOWER, LOWER), (UPPER, LOWER, UPPER)):
        said = copy.deepcopy(document)
        tables = (said["links"]["spring"], said["links"]["damper"], said["inerters"]["flywheel"])
        for table, pair in zip(tables, ends, strict=True):
            table["between"] = pair
        alone = vo.solve(from_dict(said))
        assert alone.status == "optimal"
        assert alone.goal is not None
        values.append(alone.goal[1].value)
    assert design.goal is not None
    assert design.status == "optimal"
    assert design.goal[1].value == pytest.approx(min(values), rel=1e-9)
    assert design.scene.document["links"]["damper"]["between"] == LOWER


def test_a_layout_in_python_is_that_of_the_file() -> None:
    machine = vo.Machine("machine")
    machine.body("machine", mass="100 kg")
    machine.body("joint", mass="0 kg")
    machine.link("mount", between=("machine", "ground"), stiffness="100 kN/m", damping="20 N s/m")
    machine.link("spring", between=vo.one_of(UPPER, LOWER), stiffness="8 kN/m")
    machine.link("damper", between=vo.one_of(UPPER, LOWER), damping="100 N s/m")
    machine.inerter("flywheel", between=vo.one_of(UPPER, LOWER), inertance="10 kg")
    machine.force("shaking", on="machine", amplitude="100 N", speed="5 Hz", varies="constant")
    design = vo.solve(machine.scene(goal=vo.minimise(machine.displacement(of="machine"))))
    other = vo.solve(from_dict(MACHINE))
    assert design.goal == other.goal
    assert design.places == other.places


WRONG = {
    "a name that is not there": (
        {"one_of": [UPPER, ["joint", "grond"]]},
        'links.spring.between = ["joint", "grond"] names "grond", which is no body, base or ground. Did you '
        'mean "ground"?',
    ),
    "no pairs": (
        {"one_of": []},
        'links.spring.between = { one_of = [] } is a choice without pairs. Write between = { one_of = [["machine", '
        '"joint"], ["joint", "ground"]] }.',
    ),
    "one end alone": (
        {"one_of": [UPPER, ["joint"]]},
        'links.spring.between = { one_of = [["machine", "joint"], ["joint"]] } is not a pair of names. Write between = '
        '["machine", "ground"].',
    ),
    "another choice": (
        {"any_of": [UPPER, LOWER]},
        'links.spring.between = { any_of = [["machine", "joint"], ["joint", "ground"]] } is a choice without pairs. '
        'Write between = { one_of = [["machine", "joint"], ["joint", "ground"]] }.',
    ),
    "a name alone": (
        "joint",
        'links.spring.between = "joint" is not a pair of names. Write between = ["machine", "ground"].',
    ),
    "twice": (
        {"one_of": [UPPER, UPPER[::-1]]},
        'links.spring.between = { one_of = [["machine", "joint"], ["joint", "machine"]] } names a pair twice. Name '
        "each once.",
    ),
    "another word": (
        {"one_of": [UPPER, LOWER], "from": "joint"},
        'links.spring.between = { one_of = [["machine", "joint"], ["joint", "ground"]], from = "joint" } is a choice '
        'without pairs. Write between = { one_of = [["machine", "joint"], ["joint", "ground"]] }.',
    ),
}


@pytest.mark.parametrize("given_as", WRONG)
def test_wrong_ends_are_said(given_as: str) -> None:
    between, said = WRONG[given_as]
    document = copy.deepcopy(MACHINE)
    document["links"]["spring"]["between"] = between
    del document["inerters"]  # without the spring, which is not read, nothing is said of what else the joint lacks
    assert refused(from_dict, document, name="net").messages == (f"net: {said}",)


def test_ends_that_no_layout_can_have_are_said() -> None:
    document = copy.deepcopy(MACHINE)
    document["links"]["damper"]["between"] = document["inerters"]["flywheel"]["between"] = UPPER
    document["links"]["spring"]["between"] = {"one_of": [UPPER, ["machine", "ground"], LOWER]}
    assert refused(from_dict, document, name="net").messages == (
        'net: links.spring.between as "machine to joint" is in no layout that can be answered: bodies.joint has no '
        "mass, and spring, damper and flywheel join it to machine alone, so that they carry nothing. Join one of them "
        "to something else, or leave them out.",
        'net: links.spring.between as "machine to ground" is in no layout that can be answered: bodies.joint has no '
        "mass, and damper and flywheel join it to machine alone, so that they carry nothing. Join one of them to "
        "something else, or leave them out.",
    )


def test_a_layout_without_a_goal_is_refused() -> None:
    document = {key: table for key, table in MACHINE.items() if key != "goal"}
    said = refused(from_dict, document, name="net").messages
    assert said[0].startswith("net: links.spring.between is to be chosen, but there is no [goal] that says which")


def test_a_joint_at_which_an_inerter_ends_is_drawn_below_the_machine() -> None:
    document = copy.deepcopy(MACHINE)
    for table, pair in ((document["links"]["spring"], UPPER), (document["links"]["damper"], LOWER)):
        table["between"] = pair
    document["inerters"]["flywheel"]["between"] = LOWER
    design = solve(from_dict({key: one for key, one in document.items() if key != "goal"} | {"measures": MOTION}))
    assert levels(sketch_of(design)) == {"machine": 2, "joint": 1, "ground": 0}


def test_a_choice_that_leaves_the_other_part_alone_is_named() -> None:
    document = copy.deepcopy(MACHINE)
    del document["inerters"]
    document["links"]["spring"]["between"] = {"one_of": [UPPER, LOWER, ["machine", "ground"]]}
    assert refused(from_dict, document, name="net").messages == (
        'net: links.spring.between as "machine to ground" is in no layout that can be answered: bodies.joint has no '
        "mass, and nothing holds it. Join links with stiffness and damping to it, or leave it out.",
    )


def test_where_the_machine_is_better_without_what_carries_nothing_no_layout_is_called_proven() -> None:
    """Above its resonance a spring in a row with a damper brings the machine nearer to it."""
    document = copy.deepcopy(MACHINE)
    del document["inerters"]
    document["links"]["spring"]["stiffness"], document["links"]["damper"]["damping"] = "30 kN/m", "1 kN s/m"
    document["excitations"]["shaking"]["speed"] = "8 Hz"
    omega = 16.0 * np.pi
    alone = 100.0 / abs(1e5 + 20j * omega - 100.0 * omega**2)
    best = moved(omega, [3e4, 1000j * omega], (True, False))
    assert best > 1.01 * alone
    design = solve(from_dict(document))
    assert design.status == "feasible"
    assert design.goal is not None
    assert design.goal[1].value == pytest.approx(best, rel=1e-9)
    assert design.claim.endswith(
        f"; without damper, joint, spring the goal is {1e3 * alone:.4g} mm pk, which is better: leave them out"
    )
    bound = {"response": "displacement", "of": "machine", "at_most": f"{0.5 * (alone + best)!r} m"}
    design = solve(from_dict({**document, "limits": {"small": bound}}))
    assert design.status == "unproven"
    assert design.claim.endswith("which is better: leave them out")


def test_what_is_asked_about_is_not_left_out() -> None:
    document = copy.deepcopy(MACHINE)
    document["links"]["spring"]["stiffness"] = {"from": "1 kN/m", "to": "20 kN/m"}
    document["goal"] = {"minimise": "stiffness", "of": "spring"}
    document["limits"] = {"small": {"response": "displacement", "of": "machine", "at_most": "1 m"}}
    design = solve(from_dict(document))
    assert (design.status, design.variables["links.spring.stiffness"].value.value) == ("optimal", pytest.approx(1e3))
    assert "without" not in design.claim
