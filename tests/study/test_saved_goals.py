"""What was made best is measured again from the saved design as it was meant: the least of what was made greatest."""

from __future__ import annotations

import copy
from typing import Any

import pytest

import vibopt as vo
from vibopt.responses import KINDS
from vibopt.scene.read import from_dict
from vibopt.study.freeze import frozen
from vibopt.verify.measured_goal import MEASURED

DOCUMENT: dict[str, Any] = {
    "bodies": {"m": {"mass": "100 kg"}, "f": {"mass": "300 kg"}},
    "links": {
        "l": {"between": ["m", "f"], "stiffness": {"from": "50 kN/m", "to": "200 kN/m"}, "damping": "500 N s/m"},
        "s": {"between": ["f", "ground"], "stiffness": "1 MN/m", "damping": "3 kN s/m"},
    },
    "excitations": {
        "e": {"kind": "force", "on": "m", "amplitude": "10 N", "speed": "4..9 Hz", "varies": "constant"},
        "u": {"kind": "force", "on": "f", "amplitude": "5 N", "speed": "6 Hz", "varies": "constant"},
    },
}
PLACES: dict[str, dict[str, str]] = {
    "displacement": {"of": "m"},
    "transmitted_force": {"into": "ground"},
    "relative_displacement": {"across": "l"},
    "isolation": {"into": "ground"},
    "insertion_loss": {"across": "l"},
}


@pytest.mark.parametrize("sense", MEASURED)
@pytest.mark.parametrize("response", PLACES)
@pytest.mark.parametrize(
    "loose", [False, pytest.param(True, marks=pytest.mark.slow)], ids=["exact", "with a tolerance"]
)
def test_the_measure_that_a_goal_becomes_has_its_value(sense: str, response: str, loose: bool) -> None:
    document = copy.deepcopy(DOCUMENT)
    document["goal"] = {sense: response, **PLACES[response], "due_to": ["e"]}
    if loose:
        document["links"]["s"]["stiffness"] = {"value": "1 MN/m", "tolerance": "10 %"}
    design = vo.solve(from_dict(document))
    assert design.goal is not None
    again = vo.solve(frozen(design.scene, design.x)).measures[MEASURED[sense]]
    assert again.value.value == pytest.approx(design.goal[1].value, rel=1e-7)


LOOSE = {
    "tuning": 'mass = "8 kg"\ntuning = { value = 0.9, tolerance = "5 %" }',
    "measured tuning": 'mass = "8 kg"\ntuning = { value = 0.9, tolerance = { data = ["-5 %", "1 %"] } }',
    "frequency": 'mass_ratio = { value = 0.08, tolerance = "5 %" }\nfrequency = { value = "6 Hz", tolerance = "5 %" }',
    "pendulum": 'mass = { value = "8 kg", tolerance = "5 %" }\nlength = "7 mm"\ntolerance = "3 %"',
    "length": 'mass = "8 kg"\nlength = { value = "7 mm", tolerance = "5 %" }',
    "whole": 'mass_ratio = 0.08\ntuning = 0.9\ntolerance = "3 %"',
    "shaft": 'disc = { mass = "8 kg", diameter = "2 m" }\nshaft = { length = "0.3 m", shear_modulus = "80 GPa", '
    'diameter = { value = "10 mm", tolerance = "5 %" } }',
}
HOST = """
[bodies.host]
{heavy}
[links.l]
between = ["host", "ground"]
{spring}
[absorbers.a]
on = "host"
{absorber}
damping_ratio = {{ from = 0.1, to = 0.3 }}
[excitations.e]
kind = "{kind}"
on = "host"
amplitude = "10 {unit}"
speed = "4..9 Hz"
[goal]
minimise = "{response}"
of = "host"
"""
ALONG = {"heavy": 'mass = "100 kg"', "spring": 'stiffness = "150 kN/m"', "kind": "force", "unit": "N",
         "response": "displacement"}  # fmt: skip
AROUND = {"heavy": 'inertia = "100 kg m2"', "spring": 'torsional_stiffness = "150 kN m/rad"', "kind": "moment",
          "unit": "N m", "response": "rotation"}  # fmt: skip


@pytest.mark.parametrize("said", LOOSE)
def test_an_absorber_is_off_in_a_saved_design_as_it_was_said_to_be(said: str) -> None:
    """A tuning that is 5 % off is a spring of -9.75 % to +10.25 %, and a pendulum that is heavier pulls harder."""
    text = HOST.format(absorber=LOOSE[said], **(AROUND if said == "shaft" else ALONG))
    design = vo.solve(vo.from_text(text, "scene"))
    assert design.goal is not None
    again = vo.solve(frozen(design.scene, design.x)).measures["minimised"]
    assert again.value.value == pytest.approx(design.goal[1].value, rel=1e-9)


PRESS = """
[bodies.press]
mass = "300 kg"
[links.mount]
between = ["press", "ground"]
stiffness = "2 MN/m"
{count}damping_ratio = {{ from = 0.05, to = 0.3, tolerance = "5 %" }}
[inerters.b]
between = ["press", "ground"]
mass_ratio = {{ from = 0.1, to = 0.2 }}
relative_to = "press"
[excitations.e]
kind = "force"
on = "press"
amplitude = "1 kN"
speed = "0..3000 rpm"
varies = "constant"
[limits.floor]
response = "transmitted_force"
into = "ground"
at_most = "5 kN"
[goal]
minimise = "displacement"
of = "press"
"""


@pytest.mark.parametrize("count", ["", "count = 4\n"])
def test_a_damper_and_an_inerter_that_are_bought_stay_what_they_are_on_another_mass(count: str) -> None:
    """Their ratios referred to the new mass: a heavier machine was measured with another damper."""
    job = vo.from_text(PRESS.format(count=count), "press.toml")
    design = vo.solve(job)
    found = {path.split(".")[1]: row.value.value for path, row in design.variables.items()}
    many = 4 if count else 1
    damper = 2.0 * found["mount"] * (many * 2e6 * 300.0) ** 0.5 / many
    kept = vo.whatif(job, {"bodies.press.mass": "360 kg"}, keep_design=True)
    built = PRESS.format(count=count).replace("300 kg", "360 kg").partition("[goal]")[0]
    built = built.replace('damping_ratio = { from = 0.05, to = 0.3, tolerance = "5 %" }',
                          f'damping = {{ value = "{damper!r} N s/m", tolerance = "5 %" }}')  # fmt: skip
    built = built.replace('mass_ratio = { from = 0.1, to = 0.2 }\nrelative_to = "press"',
                          f'inertance = "{found["b"] * 300.0!r} kg"')  # fmt: skip
    other = vo.solve(vo.from_text(built, "built.toml"))
    assert kept.after.limits["floor"].value.value == pytest.approx(other.limits["floor"].value.value, rel=1e-9)
    again = vo.solve(frozen(design.scene, design.x))
    assert again.limits["floor"].value.value == pytest.approx(design.limits["floor"].value.value, rel=1e-9)


def test_a_measure_shows_the_least_or_the_greatest_as_asked() -> None:
    document = copy.deepcopy(DOCUMENT)
    document["links"]["l"]["stiffness"] = "100 kN/m"
    asked = {"response": "displacement", "of": "m", "due_to": ["e"]}
    document["measures"] = {
        "usual": asked,
        "least": {**asked, "worst": "least"},
        "most": {**asked, "worst": "greatest"},
    }
    found = {name: one.value.value for name, one in vo.solve(from_dict(document)).measures.items()}
    assert found["usual"] == found["most"] > 2.0 * found["least"] > 0.0


WRONG = {
    ("measures", "worst"): (
        'scene: measures.x.worst = "worst" is neither "least" nor "greatest". Write which value of a measure is the '
        "worst."
    ),
    ("limits", "least"): "scene: limits.x has worst, but its bound says which value is the worst. Remove worst.",
    ("goal", "least"): ("scene: goal has worst, but minimise and maximise say which value is the worst. Remove worst."),
}


@pytest.mark.parametrize(("where", "worst"), WRONG)
def test_only_measures_say_which_value_is_the_worst(where: str, worst: str) -> None:
    document = copy.deepcopy(DOCUMENT)
    asked = {"of": "m", "due_to": ["e"], "worst": worst}
    document["goal"] = {
        "minimise": "displacement",
        **{k: v for k, v in asked.items() if k != "worst" or where == "goal"},
    }
    if where != "goal":
        bound = {"at_most": "1 m"} if where == "limits" else {}
        document[where] = {"x": {"response": "displacement", **asked, **bound}}
    with pytest.raises(vo.InputError) as caught:
        from_dict(document)
    assert caught.value.messages == (WRONG[where, worst],)


def test_every_response_says_which_side_is_the_worst() -> None:
    less = {"isolation", "insertion_loss", "logarithmic_decrement", "stability_threshold"}
    assert {name for name, one in KINDS.items() if one.less_is_worse} == less
