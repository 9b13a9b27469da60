"""Permissible residual unbalance from the user's G, and the grade earned."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rotor_jobs import FAN, solve_text
from vibopt.answer.text import blocks_of
from vibopt.balancing.grades import Quality, earned, levers, permitted, shares

OMEGA = 3000.0 * 2.0 * np.pi / 60.0


def quality(centre: float = 0.4, **more: Any) -> Quality:
    base: dict[str, Any] = {
        "grade": 6.3e-3,
        "mass": 200.0,
        "speed": OMEGA,
        "bearings": (("A", 0.0), ("B", 1.0)),
        "centre_of_mass": centre,
    }
    return Quality(**{**base, **more})


def test_the_whole_is_mass_times_grade_over_speed() -> None:
    found = permitted(quality())
    assert found.whole == pytest.approx(200.0 * 6.3e-3 / OMEGA, rel=1e-14)
    assert found.eccentricity == pytest.approx(20.0535e-6, rel=1e-5)


def test_inboard_bearings_share_as_the_loads() -> None:
    found = permitted(quality())
    assert found.at_bearings["A"] == pytest.approx(0.6 * found.whole)
    assert found.at_bearings["B"] == pytest.approx(0.4 * found.whole)
    assert not found.outboard


def test_outboard_the_nearer_bearing_carries_more_than_the_whole() -> None:
    found = permitted(quality(1.25))
    assert found.outboard
    assert found.at_bearings["A"] == pytest.approx(0.25 * found.whole)
    assert found.at_bearings["B"] == pytest.approx(1.25 * found.whole)
    np.testing.assert_allclose(shares(quality(1.25, least_share=0.3, most_share=1.2)), [0.3, 1.2])


@pytest.mark.parametrize("places", [(0.2, 0.8), (-0.3, 1.4), (0.5, 0.6), (1.2, 1.5)])
def test_planes_at_their_limit_keep_both_bearings_at_any_angles(places: tuple[float, float]) -> None:
    asked = quality(planes={"p": places[0], "q": places[1]})
    found = permitted(asked)
    K = levers(*asked.ends, np.array(places))
    turns = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 361))
    worst = np.abs(K[:, :1] * found.at_planes["p"] + K[:, 1:] * found.at_planes["q"] * turns).max(axis=1)
    allowed = np.array(list(found.at_bearings.values()))
    assert (worst <= allowed * (1.0 + 1e-9)).all()
    assert np.isclose(worst, allowed).any()


def test_the_measurement_error_is_taken_off() -> None:
    asked = quality(planes={"p": 0.2, "q": 0.8}, measurement_error=5e-5)
    found = permitted(asked)
    assert found.to_measure["p"] == pytest.approx(found.at_planes["p"] - 5e-5)


def test_a_rotor_at_its_limit_earns_its_grade() -> None:
    asked = quality()
    allowed = permitted(asked)
    found = earned(asked, {"A": allowed.at_bearings["A"], "B": 0.5j * allowed.at_bearings["B"]})
    assert found.grade == pytest.approx(asked.grade)
    assert found.met
    assert found.worst_at == "A"
    assert not earned(asked, {"A": 1.01 * allowed.at_bearings["A"]}).met


GRADE = """title = "grade"
[quality]
grade = "6.3 mm/s"
mass = "200 kg"
speed = "3000 rpm"
centre_of_mass = "400 mm"
bearings = { A = "0 mm", B = "1 m" }
"""


def test_a_file_may_ask_for_the_grade_alone() -> None:
    plan = solve_text(GRADE)
    assert (plan.status, plan.exit_code) == ("met", 0)
    assert plan.find("quality.bearings.A.permissible").shown == "2406 g mm"
    plan = solve_text(GRADE + 'residual = { A = "3000 g mm @ 0 deg" }\n')
    assert (plan.status, plan.exit_code) == ("violated", 7)
    assert plan.find("quality.earned").shown == "7.854 mm/s"


def test_the_plan_says_the_grade_it_earns() -> None:
    text = (
        FAN
        + GRADE.split("\n", 1)[1]
        + 'planes = { left = "0 mm", right = "1000 mm" }\nmeasurement_error = "100 g mm"\n'
    )
    plan = solve_text(text)
    allowed = float(plan.find("quality.bearings.B.permissible").value)
    assert float(plan.find("quality.earned").value) == pytest.approx(6.3e-3 * 1e-4 / allowed)
    assert plan.find("quality.met").value == "yes"


ASKED = (
    FAN
    + """[quality]
grade = "6.3 mm/s"
mass = "80 kg"
centre_of_mass = "450 mm"
bearings = { A = "0 mm", B = "900 mm" }
planes = { left = "150 mm", right = "750 mm" }
"""
)


def test_an_error_of_measurement_that_leaves_nothing_is_said() -> None:
    plan = solve_text(ASKED + 'measurement_error = "5000 g mm"\n')
    assert (
        "The measurement error of 5000 g mm is no less than what planes left and right may keep (2005 g mm): no "
        "measurement can show that the grade is met. Measure more exactly, or ask for a coarser grade."
    ) in plan.notes
    rows = next(one for one in blocks_of(plan) if one.title == "Permissible residual unbalance").rows
    assert [row[2] for row in rows if row[0].startswith("plane")] == ["nothing", "nothing"]
    assert not [note for note in solve_text(ASKED + 'measurement_error = "500 g mm"\n').notes if "grade" in note]


def test_a_grade_alone_repeats_no_convention_that_nobody_wrote() -> None:
    alone = ASKED[ASKED.index("[quality]") :] + 'speed = "1200 rpm"\n'
    assert solve_text(alone).plan.conventions == ()
    said = '[conventions]\nangles = "with rotation"\ndetector = "pp"\nzero = "tape"\n'
    left = 'residual = { left = "300 g mm @ 20 deg", right = "200 g mm @ 200 deg" }\n'
    plan = solve_text(said + alone + left)
    assert plan.plan.conventions == ("Angles of weights are counted with rotation from zero, which is at: tape.",)
    assert plan.find("quality.earned").value == pytest.approx(solve_text(alone + left).find("quality.earned").value)
