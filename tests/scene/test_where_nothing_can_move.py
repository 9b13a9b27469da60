"""Directions in which nothing moves, and places that have no direction, are refused and never answered by zero."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest

import vibopt as vo
from vibopt.scene.read import from_dict

PLANE: dict[str, Any] = {
    "bodies": {"box": {"motion": "plane", "mass": "300 kg", "inertia": "40 kg m2"}},
    "points": {"top": {"on": "box", "at": ["0.2 m", "0 m", "0.5 m"]}},
    "mounts": {
        "foot": {
            "between": ["box", "ground"],
            "at": [["0.5 m", "0 m", "0 m"], ["-0.5 m", "0 m", "0 m"]],
            "stiffness": "200 kN/m",
            "shear_ratio": 0.6,
            "loss_factor": 0.1,
        }
    },
    "excitations": {"e": {"kind": "force", "on": "box", "direction": "z", "amplitude": "10 N", "speed": "5 Hz"}},
    "measures": {"mode": {"response": "natural_frequency"}},
}
LINE: dict[str, Any] = {
    "bodies": {"m": {"mass": "100 kg"}},
    "links": {"l": {"between": ["m", "ground"], "stiffness": "100 kN/m", "damping": "300 N s/m"}},
    "excitations": {"e": {"kind": "force", "on": "m", "amplitude": "10 N", "speed": "5 Hz"}},
    "measures": {"mode": {"response": "natural_frequency"}},
}
TURNS: dict[str, Any] = {
    "bodies": {"d": {"inertia": "2 kg m2"}},
    "links": {"s": {"between": ["d", "ground"], "torsional_stiffness": "3 kN m/rad"}},
    "excitations": {"e": {"kind": "moment", "on": "d", "amplitude": "10 N m", "speed": "5 Hz"}},
    "measures": {"mode": {"response": "natural_frequency"}},
}
ALONG = 'but bodies.box moves in a plane: along x and z, and about y. Write direction = "x", or "z".'
ABOUT = 'but bodies.box moves in a plane: along x and z, and about y. Write axis = "y".'
ASKED: list[tuple[dict[str, Any], dict[str, Any], str]] = [
    (PLANE, {"response": "displacement", "of": "box", "direction": "y"}, f"asks for the displacement along y, {ALONG}"),
    (PLANE, {"response": "velocity", "of": "top", "direction": "y"}, f"asks for the velocity along y, {ALONG}"),
    (PLANE, {"response": "rotation", "of": "box", "axis": "x"}, f"asks for the rotation about x, {ABOUT}"),
    (PLANE, {"response": "tilt", "of": "box", "axis": "z"}, f"asks for the tilt about z, {ABOUT}"),
    (PLANE, {"response": "energy_share", "of": "box", "axis": "x"}, f"asks for the energy_share about x, {ABOUT}"),
    (
        PLANE,
        {"response": "static_deflection", "of": "foot", "direction": "x"},
        "has a direction, but foot sags along its own axis. Remove direction, or ask of a body.",
    ),
    (
        LINE,
        {"response": "static_deflection", "of": "l", "direction": "x"},
        "has a direction, but l knows one line only. Remove direction.",
    ),
    (
        LINE,
        {"response": "transmitted_force", "through": "l", "direction": "x"},
        "has a direction, but l knows one line only. Remove direction.",
    ),
    (TURNS, {"response": "rotation", "of": "d", "axis": "x"}, "has an axis, but d knows one axis only. Remove axis."),
    (
        TURNS,
        {"response": "total_mass"},
        "asks for the mass of all bodies, but there is none that moves along a line.",
    ),
]


@pytest.mark.parametrize(
    ("document", "asked", "text"), ASKED, ids=[" ".join(map(str, one[1].values())) for one in ASKED]
)
def test_a_question_about_a_motion_that_is_not_there_is_refused(
    document: dict[str, Any], asked: dict[str, Any], text: str
) -> None:
    with pytest.raises(vo.InputError) as caught:
        from_dict({**copy.deepcopy(document), "measures": {"x": asked}}, name="scene.toml")
    assert caught.value.messages == (f"scene.toml: measures.x {text}",)


@pytest.mark.parametrize("inertia", ["2 kg m2", {"value": "2 kg m2", "tolerance": "5 %"}])
def test_a_disc_has_one_mode_however_its_inertia_is_said(inertia: Any) -> None:
    document = copy.deepcopy(TURNS)
    document["bodies"]["d"]["inertia"] = inertia
    document["measures"] = {"second": {"response": "natural_frequency", "mode": 2}}
    with pytest.raises(vo.InputError) as caught:
        from_dict(document, name="scene.toml")
    assert caught.value.messages == ("scene.toml: measures.second.mode = 2 is more than the number of modes, 1.",)


ACTS = [
    ({"kind": "force", "direction": "y", "amplitude": "10 N"}, f"acts along y, {ALONG}"),
    ({"kind": "unbalance", "direction": "y", "unbalance": "1 kg mm"}, f"acts along y, {ALONG}"),
    ({"kind": "moment", "axis": "x", "amplitude": "10 N m"}, f"acts about x, {ABOUT}"),
    (
        {"kind": "moment_harmonics", "axis": "z", "harmonics": [{"order": 1, "amplitude": "1 N m"}]},
        f"acts about z, {ABOUT}",
    ),
]


@pytest.mark.parametrize(("acts", "text"), ACTS, ids=[one[0]["kind"] for one in ACTS])
def test_an_excitation_that_moves_nothing_is_refused(acts: dict[str, Any], text: str) -> None:
    document = {**copy.deepcopy(PLANE), "excitations": {"e": {"on": "box", "speed": "5 Hz", **acts}}}
    with pytest.raises(vo.InputError) as caught:
        from_dict(document, name="scene.toml")
    assert caught.value.messages == (f"scene.toml: excitations.e {text}",)


def test_what_moves_in_part_along_a_direction_is_answered() -> None:
    document = copy.deepcopy(PLANE)
    document["measures"] = {
        "x": {"response": "displacement", "of": "box", "direction": [0, 0.6, 0.8]},
        "z": {"response": "displacement", "of": "box", "direction": "z"},
        "loss": {"response": "loss_factor", "of": "foot"},
    }
    found = vo.solve(from_dict(document)).measures
    assert found["x"].value.value == pytest.approx(0.8 * found["z"].value.value, rel=1e-12)
    assert found["loss"].value.value == pytest.approx(0.1, rel=1e-12)


def test_a_joint_that_an_inerter_loads_has_a_mode_of_its_own() -> None:
    """m1 = 10 kg on k = 10 kN/m, and by another such spring on an inerter of 1 kg: det(K - w^2 M) = 0 by hand."""
    document = {
        "bodies": {"a": {"mass": "10 kg"}, "j": {"mass": "0 kg"}},
        "links": {
            "s": {"between": ["a", "ground"], "stiffness": "10 kN/m"},
            "h": {"between": ["a", "j"], "stiffness": "10 kN/m"},
        },
        "inerters": {"i": {"between": ["j", "ground"], "inertance": "1 kg"}},
        "excitations": {"e": {"kind": "force", "on": "a", "amplitude": "1 N", "speed": "5 Hz"}},
        "measures": {"second": {"response": "natural_frequency", "mode": 2, "unit": "rad/s"}},
    }
    second = np.sqrt(max(np.roots([10.0, -(20e3 + 10.0 * 10e3), 20e3 * 10e3 - 10e3 * 10e3])))
    found = vo.solve(from_dict(document)).measures["second"]
    assert found.value.value == pytest.approx(second, rel=1e-12)
    document["measures"]["second"]["mode"] = 3
    with pytest.raises(vo.InputError) as caught:
        from_dict(document, name="scene.toml")
    assert caught.value.messages == ("scene.toml: measures.second.mode = 3 is more than the number of modes, 2.",)


def test_without_a_body_nothing_else_is_said_of_the_machine() -> None:
    document = copy.deepcopy(PLANE)
    document["bodies"] = {}
    with pytest.raises(vo.InputError) as caught:
        from_dict(document, name="scene.toml")
    assert caught.value.messages == ('scene.toml: there is no body. Add [bodies.NAME] with mass = "300 kg".',)


def test_a_body_without_a_name_is_refused() -> None:
    document = copy.deepcopy(PLANE)
    document["bodies"][" "] = document["bodies"].pop("box")
    with pytest.raises(vo.InputError) as caught:
        from_dict(document, name="scene.toml")
    assert "scene.toml: a table of bodies has no name. Give it one: [bodies.fan]." in caught.value.messages
