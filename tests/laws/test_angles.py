"""Unbalances at angles to each other, known or not: sums put together here, the parallelogram of two runs, words."""

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


SWEPT: dict[str, Any] = {**SHAFT, "excitations": {"both": {**SHAFT["excitations"]["both"], "speed": "600..2400 rpm"}}}
WHEEL = {"on": "wheel", "unbalance": "200 g mm"}


def test_at_any_angles_the_worst_turn_is_told_at_its_speed() -> None:
    """No turn of the second is worse at any speed, and one is as bad."""
    document = copy.deepcopy(SWEPT)
    document["excitations"]["both"].update(also=[WHEEL], angles="any")
    row = vo.solve(vo.from_dict(document)).measures["fan"]
    most, spin = row.value.value, f"{row.worst_at['both'].value!r} rad/s"
    turns = np.arange(-180.0, 180.0, 7.5)
    there = [measured(SHAFT, also=[{**WHEEL, "angle": f"{turn} deg"}], speed=spin)["fan"] for turn in turns]
    assert (1.0 - np.cos(np.radians(3.75))) * most > most - max(there) >= -1e-9 * most
    swept = [measured(SWEPT, also=[{**WHEEL, "angle": f"{turn} deg"}])["fan"] for turn in turns[::6]]
    assert max(swept) <= most * (1.0 + 1e-9)
    alone = measured(SWEPT)["fan"] + measured(SWEPT, **WHEEL)["fan"]
    assert most < alone * (1.0 + 1e-9)


@given(st.floats(0.0, 1.0), st.integers(-180, 180))
def test_no_split_over_the_places_is_worse_than_all_of_it_at_one(part: float, turn: int) -> None:
    worst = measured(SWEPT, or_on=["wheel"])["fan"]
    one = {"on": "wheel", "unbalance": f"{300.0 * part + 1e-9!r} g mm", "angle": f"{turn} deg"}
    split = measured(SWEPT, unbalance=f"{300.0 * (1.0 - part) + 1e-9!r} g mm", also=[one])["fan"]
    assert split <= worst * (1.0 + 1e-9)
    assert worst == max(measured(SWEPT)["fan"], measured(SWEPT, on="wheel")["fan"])


def test_a_grade_is_the_mass_of_the_rotor_times_it_over_the_speed() -> None:
    heavy = np.pi / 4.0 * 0.06**2 * 1.2 * 7850.0 + 42.0
    size = f"{2.5e-3 * heavy / (314.0 * np.pi):.17g} kg m"
    document = copy.deepcopy(SWEPT)
    both = document["excitations"]["both"]
    del both["unbalance"]
    both.update(grade="G 2,5", service_speed="9420 rpm")
    scene = vo.from_dict(document)
    found = vo.solve(scene).measures["fan"].value.value
    assert found == pytest.approx(measured(SWEPT, unbalance=size)["fan"], rel=1e-12)
    assert scene.notes == ("excitations.both.grade: 173.9 g mm, of a rotor of 68.63 kg",)
    both["rotor_mass"] = f"{2.0 * heavy!r} kg"
    assert vo.solve(vo.from_dict(document)).measures["fan"].value.value == pytest.approx(2.0 * found, rel=1e-12)


def test_where_it_may_be_is_said_with_the_worst() -> None:
    document = copy.deepcopy(SWEPT)
    document["excitations"]["both"]["or_on"] = ["wheel"]
    design = vo.solve(vo.from_dict(document))
    assert "all of it on fan" in str(design)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"or_on": ["weel"]},
            'excitations.both.or_on = "weel" names no body of this scene. Did you mean "wheel"?',
        ),
        (
            {"or_on": ["fan"]},
            "excitations.both names fan twice among the places where it may be. Name each once.",
        ),
        (
            {"or_on": ["wheel"], "also": [WHEEL]},
            "excitations.both says where all of it may be (or_on) and what else there is (also). Keep one, or write "
            "two excitations.",
        ),
        (
            {"angles": "any"},
            'excitations.both says angles = "any", and has no further unbalances (also). Leave one of the two out.',
        ),
        (
            {"angles": "any", "also": [{**WHEEL, "angle": "20 deg"}]},
            'excitations.both says angles = "any", and gives angles of some of them. Leave one of the two out.',
        ),
        (
            {"rotor_mass": "20 kg"},
            "excitations.both gives rotor_mass, which only a grade counts. Leave it out, or write grade for the "
            "unbalance.",
        ),
        (
            {"unbalance": None, "grade": "G2.5", "speed": "600..2400 rpm"},
            "excitations.both gives a grade, and its speed is not one value: which speed does the grade count? Add "
            'service_speed = "12000 rpm", the highest in service.',
        ),
    ],
)
def test_places_angles_and_grades_that_cannot_be_are_refused(changes: dict[str, Any], words: str) -> None:
    document = copy.deepcopy(SHAFT)
    both = document["excitations"]["both"]
    both.update(changes)
    document["excitations"]["both"] = {key: one for key, one in both.items() if one is not None}
    assert f"fan.toml: {words}" in refused(vo.from_dict, document, name="fan.toml").messages


def test_what_is_no_rotor_has_neither_places_nor_grades() -> None:
    document = copy.deepcopy(LINE)
    document["excitations"]["wheels"]["or_on"] = ["lower"]
    assert refused(vo.from_dict, document, name="wheels.toml").messages == (
        "wheels.toml: excitations.wheels.or_on is of an unbalance on a rotor, and upper is no station and no disc of "
        "one. Name one, or leave it out.",
    )
    document["excitations"] = {"wheels": {"kind": "unbalance", "on": "upper", "grade": "G2.5", "speed": "20 Hz"}}
    assert refused(vo.from_dict, document, name="wheels.toml").messages == (
        "wheels.toml: excitations.wheels.grade counts the mass of a rotor, and upper is on no rotor. Add rotor_mass, "
        "or write the unbalance itself.",
    )
    document = copy.deepcopy(SHAFT)
    document["rotors"]["rotor"]["sections"][0]["diameter"] = {"from": "50 mm", "to": "70 mm"}
    document["excitations"]["both"] = {"kind": "unbalance", "on": "fan", "grade": "G2.5", "speed": "20 Hz"}
    document["goal"] = {"minimise": "total_mass"}
    assert refused(vo.from_dict, document, name="fan.toml").messages == (
        "fan.toml: excitations.both.grade counts the mass of a rotor, and sizes of rotors.rotor are to be chosen. Add "
        "rotor_mass, or write the unbalance itself.",
    )


def test_the_least_of_what_may_cancel_is_refused() -> None:
    document = copy.deepcopy(SWEPT)
    document["excitations"]["both"]["or_on"] = ["wheel"]
    least = {"fan": {**SHAFT["measures"]["fan"], "worst": "least"}}
    assert refused(vo.from_dict, {**document, "measures": least}, name="fan.toml").messages == (
        "fan.toml: measures.fan asks for the least that excitations.both does, whose parts may cancel: at worst "
        "nothing. Ask for the greatest.",
    )


def test_roots_of_squares_sharpness_and_balancing_want_one_rotor() -> None:
    document = copy.deepcopy(SWEPT)
    document["excitations"]["both"].update(also=[WHEEL], angles="any")
    asked = {**document, "measures": {"fan": {"response": "displacement", "of": "fan", "combine": "rss"}}}
    assert refused(vo.from_dict, asked, name="fan.toml").messages == (
        'fan.toml: measures.fan.combine = "rss" does not fit excitations.both, whose unbalances stand at any angles: '
        'the worst is their sum. Write combine = "sum".',
    )
    sharp = {"response": "amplification_factor", "of": "fan", "over": "600..2400 rpm"}
    assert refused(vo.from_dict, {**document, "measures": {"sharp": sharp}}, name="fan.toml").messages == (
        "fan.toml: measures.sharp asks for the amplification_factor, and excitations.both has unbalances at any "
        "angles, which no one rotor has at all speeds. Give their angles, or ask for the displacement.",
    )
    refusal = refused(balancing_document, vo.solve(vo.from_dict(document, name="fan.toml")))
    assert str(refusal) == (
        "fan.toml: excitations.both is an unbalance at places or angles that nobody knows, so nothing says what to "
        "take back. Leave or_on and angles out."
    )
    ratio = {"ratio": {"response": "transmissibility", "into": "ground"}}
    placed = {**SHAFT, "excitations": {"both": {**SHAFT["excitations"]["both"], "or_on": ["wheel"]}}, "measures": ratio}
    assert refused(vo.from_dict, placed, name="fan.toml").messages == (
        "fan.toml: measures.ratio is a ratio to one force, but excitations.both has further places (or_on). Limit the "
        "force or the motion itself.",
    )
