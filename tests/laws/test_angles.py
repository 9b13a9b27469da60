"""Unbalances at angles to each other: complex sums put together here, the parallelogram of two runs, and the words."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import vibopt as vo
from refusals import refused
from vibopt.document.toml_writing import document_toml
from vibopt.jobs import answer, from_text
from vibopt.report.modelled_balancing import balancing_document

LINE: dict[str, Any] = {
    "title": "two wheels",
    "bodies": {"upper": {"mass": "40 kg"}, "lower": {"mass": "90 kg"}},
    "links": {
        "between": {"between": ["upper", "lower"], "stiffness": "300 kN/m", "damping": "500 N s/m"},
        "feet": {"between": ["lower", "ground"], "stiffness": "1 MN/m", "damping": "2 kN s/m"},
    },
    "excitations": {"wheels": {"kind": "unbalance", "on": "upper", "unbalance": "0.02 kg m", "speed": "10..40 Hz"}},
    "measures": {
        "upper": {"response": "displacement", "of": "upper", "at": "17 Hz"},
        "floor": {"response": "transmitted_force", "into": "ground", "at": "17 Hz"},
    },
}
SHAFT: dict[str, Any] = {
    "title": "rotor",
    "rotors": {
        "rotor": {
            "sections": [{"length": "1.2 m", "diameter": "60 mm"}],
            "discs": [
                {"name": "fan", "at": "0.4 m", "mass": "30 kg", "diametral": "0.3 kg m2", "polar": "0.6 kg m2"},
                {"name": "wheel", "at": "1.2 m", "mass": "12 kg", "diametral": "0.1 kg m2", "polar": "0.2 kg m2"},
            ],
            "stations": {"left": "0 m", "right": "0.9 m"},
            "modulus": "207 GPa",
            "density": "7850 kg/m3",
        }
    },
    "links": {
        name: {"between": [name[:-1], "ground"], "stiffness": "30 MN/m", "damping": "4 kN s/m"}
        for name in ("leftb", "rightb")
    },
    "excitations": {"both": {"kind": "unbalance", "on": "fan", "unbalance": "300 g mm", "speed": "2400 rpm"}},
    "measures": {"fan": {"response": "displacement", "of": "fan"}},
}


def measured(document: dict[str, Any], **more: Any) -> dict[str, float]:
    said = copy.deepcopy(document)
    next(iter(said["excitations"].values())).update(more)
    found = vo.solve(vo.from_dict(said))
    assert found.status == "met", found.claim
    return {name: row.value.value for name, row in found.measures.items()}


@given(st.integers(-180, 180), st.floats(1e-4, 0.2), st.sampled_from(["upper", "lower"]))
def test_forces_at_an_angle_are_added_as_complex_numbers(angle: float, size: float, on: str) -> None:
    omega, k, c = 34.0 * np.pi, (3e5, 1e6), (500.0, 2e3)
    first, second = (a + 1j * omega * b for a, b in zip(k, c, strict=True))
    dynamic = np.array([[first, -first], [-first, first + second]]) - omega**2 * np.diag([40.0, 90.0])
    force = np.array([0.02, 0.0], dtype=complex)
    force[int(on == "lower")] += size * np.exp(1j * np.radians(angle))
    moved = np.linalg.solve(dynamic, omega**2 * force)
    found = measured(LINE, also=[{"on": on, "unbalance": f"{size!r} kg m", "angle": f"{angle} deg"}])
    assert found["upper"] == pytest.approx(abs(moved[0]), rel=1e-9)
    assert found["floor"] == pytest.approx(abs(second * moved[1]), rel=1e-9)


def test_two_on_a_rotor_keep_the_parallelogram_and_what_opposes_it_stops_it() -> None:
    """|a + b|^2 + |a - b|^2 = 2 |a|^2 + 2 |b|^2, of whirls known alone; three at 120 degrees are none."""
    further = {"on": "wheel", "unbalance": "200 g mm"}
    with_it, against = (measured(SHAFT, also=[{**further, "angle": angle}])["fan"] for angle in ("0 deg", "180 deg"))
    alone = measured(SHAFT)["fan"], measured(SHAFT, on="wheel", unbalance="200 g mm")["fan"]
    assert with_it**2 + against**2 == pytest.approx(2.0 * (alone[0] ** 2 + alone[1] ** 2), rel=1e-9)
    assert abs(with_it - against) > 0.01 * alone[0]
    three = [{"on": "fan", "unbalance": "300 g mm", "angle": angle} for angle in ("120 deg", "240 deg")]
    assert measured(SHAFT, also=three)["fan"] < 1e-12 * alone[0]


def test_a_balancing_job_of_it_takes_back_both() -> None:
    document = copy.deepcopy(SHAFT)
    document["excitations"]["both"]["also"] = [{"on": "wheel", "unbalance": "200 g mm", "angle": "70 deg"}]
    document["measures"]["wheel"] = {"response": "displacement", "of": "wheel"}
    plan = answer(from_text(document_toml(balancing_document(vo.solve(vo.from_dict(document))))))
    for name, size, angle in (("fan", 3e-4, 180.0), ("wheel", 2e-4, 250.0)):
        fitted = plan.to_json()["planes"][name]
        assert fitted["unbalance"]["value"] == pytest.approx(size, rel=1e-6)
        assert np.degrees(fitted["angle"]["value"]) % 360.0 == pytest.approx(angle, abs=1e-4)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"also": [{"on": "uper", "unbalance": "1 g m"}]},
            'excitations.wheels.also = "uper" names no body of this scene. Did you mean "upper"?',
        ),
        (
            {
                "also": [{"on": "upper", "unbalance": "1 g m"}],
                "run_up": {"from": "0 rpm", "to": "9 Hz", "acceleration": "9 rpm/s"},
            },
            "excitations.wheels has further unbalances (also) beside run_up. They are of steady vibration along a line "
            "and of rotors: leave one of the two out.",
        ),
    ],
)
def test_further_unbalances_that_cannot_be_are_refused(changes: dict[str, Any], words: str) -> None:
    document = copy.deepcopy(LINE)
    document["excitations"]["wheels"].update(changes)
    assert f"wheels.toml: {words}" in refused(vo.from_dict, document, name="wheels.toml").messages


def test_a_ratio_to_several_forces_is_refused() -> None:
    document = copy.deepcopy(LINE)
    document["excitations"]["wheels"]["also"] = [{"on": "lower", "unbalance": "1 g m"}]
    document["measures"] = {"ratio": {"response": "transmissibility", "into": "ground"}}
    assert refused(vo.from_dict, document, name="wheels.toml").messages == (
        "wheels.toml: measures.ratio is a ratio to one force, but excitations.wheels has further unbalances (also). "
        "Limit the force or the motion itself.",
    )
