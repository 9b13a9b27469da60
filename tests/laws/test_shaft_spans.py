"""Lengths of sections that are chosen or off as built: the rotor of that length, by both routes, and what is "
"refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from refusals import refused
from test_rotors import asked
from vibopt.forms.whirling import WhirlThreshold
from vibopt.report.rotor_parts import rotors_of
from vibopt.scene.assemble import model_of
from vibopt.scene.read import from_dict
from vibopt.solve import solve
from vibopt.verify.as_built import machine_of

MEASURES: dict[str, dict[str, Any]] = {
    "whirl": {"response": "displacement", "of": "fan"},
    "stress": {"response": "bending_stress", "of": "shaft"},
    "weight": {"response": "static_bending_stress", "of": "shaft"},
    "forward": {"response": "critical_speed", "mode": 2},
    "backward": {"response": "critical_speed", "whirl": "backward"},
    "sag": {"response": "static_deflection", "of": "fan"},
}


FREE = {"from": "300 mm", "to": "1200 mm"}


def fan(*lengths: object, **over: Any) -> dict[str, Any]:
    """An overhung fan, its sections of these lengths."""
    wide = ("50 mm", "60 mm", "45 mm")
    rotor = {
        "sections": [{"length": long, "diameter": d} for long, d in zip(lengths, wide, strict=True)],
        "stations": {"left": "end of section 1", "right": "end of section 2"},
        "discs": [
            {"name": "fan", "at": "end of section 3", "mass": "60 kg", "diametral": "2.2 kg m2", "polar": "4 kg m2"}
        ],
        "modulus": "207 GPa",
        "density": "7850 kg/m3",
    }
    springs = {"stiffness": "80 MN/m", "damping": "2 kN s/m"}
    return {
        "title": "fan",
        "rotors": {"shaft": {**rotor, **over}},
        "links": {f"{one}_bearing": {"between": [one, "ground"], **springs} for one in ("left", "right")},
        "excitations": {"imbalance": {"kind": "unbalance", "on": "fan", "unbalance": "600 g mm", "speed": "700 rpm"}},
    }


@settings(max_examples=12, deadline=None)
@given(
    lengths=st.tuples(st.integers(60, 900), st.integers(200, 900), st.integers(60, 400)),
    which=st.integers(0, 2),
    factor=st.sampled_from([1.02, 1.7, 6.0]),
)
def test_a_length_that_is_chosen_is_that_length(lengths: tuple[int, int, int], which: int, factor: float) -> None:
    """The lightest shaft is as short as may be, of which every number is known by a shaft of facts."""
    said = [f"{one} mm" for one in lengths]
    facts = asked(fan(*said), **MEASURES)
    free: list[object] = [*said]
    free[which] = {"from": f"{lengths[which]} mm", "to": f"{factor * lengths[which]} mm"}
    slow = {"slow": {"response": "critical_speed", "at_least": "1 rpm"}}
    design = solve(from_dict({**fan(*free), "limits": slow, "measures": MEASURES, "goal": {"minimise": "total_mass"}}))
    assert design.status in ("optimal", "feasible"), design.claim
    found = {key: one.value.value for key, one in design.measures.items()}
    assert found == pytest.approx({key: facts[key] for key in found}, rel=1e-8)


@pytest.mark.parametrize("long", [0.35, 1.1])
def test_a_threshold_is_that_of_the_length(long: float) -> None:
    """Of the shaft's own damping: of the model at a length, and of a shaft of facts by its waves."""
    lags = {"material_damping": "0.02 ms"}
    goal = {
        "limits": {"stable": {"response": "stability_threshold", "at_least": "700 rpm"}},
        "goal": {"minimise": "total_mass"},
    }
    free = model_of(from_dict({**fan("100 mm", FREE, "250 mm", **lags), **goal}))
    facts = machine_of(from_dict({**fan("100 mm", f"{long!r} m", "250 mm", **lags), "limits": goal["limits"]}), {})
    assert WhirlThreshold().value(free, np.array([long])) == pytest.approx(facts.threshold(), rel=1e-8)


def test_every_span_is_told_with_exact_ends() -> None:
    """Where the whirl takes its limit the rotor of that length takes it, too."""
    one = fan("100 mm", FREE, "250 mm")
    limits = {"fan": {**MEASURES["whirl"], "at_most": "0.85 um"}, "sag": {**MEASURES["sag"], "at_most": "0.2 mm"}}
    design = solve(from_dict({**one, "limits": limits, "goal": {"find_all": "rotors.shaft.sections.2.length"}}))
    assert design.status == "met"
    ends = [end.value for pair in design.found or () for end in pair if 0.3 < end.value < 1.2]
    assert ends
    for end in ends:
        facts = asked(fan("100 mm", f"{end!r} m", "250 mm"), whirl=MEASURES["whirl"], sag=MEASURES["sag"])
        assert min(abs(facts["whirl"] / 0.85e-6 - 1.0), abs(facts["sag"] / 2e-4 - 1.0)) <= 1e-8


def test_a_length_that_is_off_is_answered_at_its_worst() -> None:
    one = fan("100 mm", {"value": "800 mm", "tolerance": "2 %"}, "250 mm")
    limits = {"slow": {"response": "critical_speed", "at_least": "100 rpm"}}
    worst = solve(from_dict({**one, "limits": limits})).limits["slow"].value.value
    ends = [asked(fan("100 mm", f"{long} mm", "250 mm"), c={"response": "critical_speed"})["c"] for long in (784, 816)]
    assert worst == pytest.approx(min(ends), rel=1e-7)


def test_a_drawing_has_the_lengths_that_were_chosen() -> None:
    one = fan("100 mm", {"from": "300 mm", "to": "1200 mm"}, "250 mm")
    design = solve(from_dict({**one, "limits": {"slow": {"response": "critical_speed", "at_least": "900 rpm"}},
                              "goal": {"maximise": "total_mass"}}))  # fmt: skip
    (rotor,) = rotors_of(design)
    (long,) = (chosen.value.value for chosen in design.variables.values())
    assert [right for _, right, _, _ in rotor.sections] == pytest.approx([0.1, 0.1 + long, 0.35 + long])
    assert rotor.discs[0][1] == pytest.approx(0.35 + long)
    assert [at for at, _ in rotor.held] == pytest.approx([0.1, 0.1 + long])


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "no such section": (
        {"stations": {"left": "end of section 4", "right": "end of section 2"}},
        "scene: rotors.shaft has left at the end of section 4, and 3 sections. Count them from 1.",
    ),
    "no such section behind a place": (
        {"stations": {"left": "50 mm", "right": "end of section 4"}},
        "scene: rotors.shaft has right at the end of section 4, and 3 sections. Count them from 1.",
    ),
    "section nought": (
        {"stations": {"left": "end of section 0", "right": "end of section 2"}},
        "scene: rotors.shaft has left at the end of section 0, and 3 sections. Count them from 1.",
    ),
    "open diameter": (
        {"sections": [{"length": "300 mm", "diameter": {"from": "50 mm"}}]},
        "scene: rotors.shaft.sections[1] leaves an end of its diameter open. Write both: "
        'diameter = { from = "40 mm", to = "120 mm" }.',
    ),
    "behind what is not fixed": (
        {"stations": {"left": "100 mm", "right": "500 mm"}},
        "scene: rotors.shaft has right at 0.5 m, behind the begin of section 2, whose length is not fixed. Say where "
        "it "
        'stands by sections: "end of section 2".',
    ),
    "open": (
        {"sections": [{"length": {"from": "300 mm"}, "diameter": "50 mm"}]},
        "scene: rotors.shaft.sections[1] leaves an end of its length open. Write both: "
        'length = { from = "300 mm", to = "600 mm" }.',
    ),
}  # fmt: skip


@pytest.mark.parametrize(("over", "sentence"), WRONG.values(), ids=WRONG)
def test_places_that_no_length_gives_are_refused(over: dict[str, Any], sentence: str) -> None:
    document = {**fan("100 mm", FREE, "250 mm", **over), "measures": {"m": {"response": "total_mass"}}}
    document["goal"] = {"minimise": "total_mass"}
    assert sentence in refused(from_dict, document).messages


def test_a_shaft_whose_length_is_chosen_must_be_held_all_the_same() -> None:
    document = fan("100 mm", FREE, "250 mm")
    del document["links"]["left_bearing"]
    caught = refused(from_dict, {**document, "goal": {"minimise": "total_mass"}})
    assert "is not held: springs at its stations leave it free to move or to tilt" in str(caught)
