"""Sentences that say what a reader needs: where an end is exact, which machine a number is of, what shakes nothing."""

from __future__ import annotations

from pathlib import Path

import vibopt as vo
from refusals import refused
from vibopt.answer.answer_page import html
from vibopt.jobs import from_text
from vibopt.report.machine_words import goal_words
from vibopt.report.sheet import digests_of

SHAFT = """[bodies.disc]
mass = "35 kg"
[bodies.housing]
mass = "12 kg"
[links.shaft]
between = ["disc", "housing"]
beam.kind = "simply_supported"
beam.length = "0.8 m"
beam.diameter = { from = "15 mm", to = "110 mm" }
beam.modulus = "206 GPa"
beam.density = "7850 kg/m3"
damping_ratio = 0.02
relative_to = "disc"
[links.bearings]
between = ["housing", "ground"]
stiffness = "30 MN/m"
damping = "4 kN s/m"
[excitations.ecc]
kind = "unbalance"
on = "disc"
unbalance = "3500 g mm"
speed = "2950 rpm"
[limits.whirl]
response = "displacement"
of = "disc"
at_most = "0.25 mm"
[goal]
find_all = "links.shaft.beam.diameter"
"""
MOUNT = """[bodies.box]
mass = "850 kg"
[links.mount]
between = ["box", "ground"]
stiffness = { from = "50 kN/m", to = "10 MN/m", tolerance = "15 %" }
loss_factor = 0.12
[excitations.shaft]
kind = "unbalance"
on = "box"
unbalance = "0.35 kg m"
speed = "980 rpm"
[limits.floor]
response = "transmitted_force"
into = "ground"
at_most = "1200 N"
[limits.sag]
response = "static_deflection"
of = "mount"
at_most = "9 mm"
[goal]
maximise = "stiffness"
of = "mount"
"""
CRANK = """[shaft]
bearings = { A = "0 mm", B = "400 mm" }
speed = "1800 rpm"
[masses.one]
mass = "2.4 kg"
radius = "60 mm"
angle = "0 deg"
at = "90 mm"
[masses.two]
mass = "2.4 kg"
radius = "60 mm"
angle = "120 deg"
at = "200 mm"
[masses.three]
mass = "2.4 kg"
radius = "60 mm"
angle = "240 deg"
at = "310 mm"
[planes.front]
at = "40 mm"
radius = "70 mm"
weight = { from = "0 g", to = "1.5 kg" }
[planes.rear]
at = "360 mm"
radius = "70 mm"
weight = { from = "0 g", to = "1.5 kg" }
[limits.A]
response = "bearing_reaction"
of = "A"
at_most = "200 N"
"""
LEAST = '[goal]\nminimise = "correction"\n'
CLASH = '[goal]\nminimise = "reaction"\n[limits.total]\nresponse = "correction"\ntotal = true\nat_most = "500 g"\n'


def test_ends_are_exact_of_the_model_of_a_beam_with_mass_and_a_housing_is_no_floor() -> None:
    answer = vo.solve(from_text(SHAFT))
    assert answer.claim.endswith("each end is exact for beams in their static shape, the model in the note below")
    assert not [note for note in answer.notes if "stiffly" in note]
    (note,) = [note for note in answer.notes if "static shape" in note]
    assert answer.found is not None
    assert note.startswith("At ")
    assert note.partition(",")[0].removeprefix("At ") == answer.details["ends"][0][0].value.shown
    massless = vo.solve(from_text(SHAFT.replace('beam.density = "7850 kg/m3"', "")))
    assert massless.claim.endswith("each end is exact")


def test_a_goal_over_tolerances_is_said_to_be_that_of_the_worst_machine() -> None:
    answer = vo.solve(from_text(MOUNT))
    assert answer.goal is not None
    assert goal_words(answer) == f"greatest stiffness of mount is {answer.goal[1].shown} in the worst machine"
    assert answer.goal[1].value < 0.9 * answer.variables["links.mount.stiffness"].value.value
    exact = vo.solve(from_text(MOUNT.replace(', tolerance = "15 %"', "")))
    assert not goal_words(exact).endswith("machine")


def test_an_unbalance_that_stands_still_is_told() -> None:
    said = "excitations.shaft: it turns at 0 rpm, where its force is zero: it shakes nothing."
    assert said in vo.solve(from_text(MOUNT.replace('"980 rpm"', '"0 rpm"'))).notes
    assert said not in vo.solve(from_text(MOUNT)).notes


def test_one_misspelt_body_is_one_mistake() -> None:
    wrong = MOUNT.replace('["box", "ground"]', '["bax", "ground"]')
    assert refused(lambda: from_text(wrong, "box.toml")).messages == (
        'box.toml line 4: links.mount.between = ["bax", "ground"] names "bax", which is no body, base or ground. Did '
        'you mean "box"?',
    )


def test_a_bearing_that_a_correction_loads_more_is_told_where_no_limit_speaks_of_it() -> None:
    answer = vo.solve(from_text(CRANK + LEAST))
    said = [note for note in answer.notes if "loaded more" in note]
    assert said == [
        "Bearing B is loaded more than as found: 2.437 kN -> 2.686 kN. To forbid it, add a limit with response = "
        '"bearing_reaction" and of = "B".'
    ]
    both = CRANK + LEAST + '[limits.B]\nresponse = "bearing_reaction"\nof = "B"\nat_most = "3 kN"\n'
    assert not [note for note in vo.solve(from_text(both)).notes if "loaded more" in note]


def test_what_a_program_leaves_of_a_weight_is_no_weight() -> None:
    near = vo.solve(from_text(CRANK + CLASH)).nearest
    assert near is not None
    assert near.values["planes.rear.mass"].value == 0.0
    assert near.values["planes.front.mass"].value > 0.5


def test_the_sheet_of_known_masses_says_from_which_files_it_was_made(tmp_path: Path) -> None:
    file = tmp_path / "crank.toml"
    file.write_text(CRANK + LEAST)
    answer = vo.solve(from_text(CRANK + LEAST))
    digests = digests_of(file, answer.job)
    assert list(digests) == ["crank.toml"]
    first = digests["crank.toml"][:4]
    assert f"SHA-256 crank.toml {first} " in html(answer, digests=digests, sheet=True)
