"""Slips and holds far shorter than a turn: what begins with no push to spare, what all but stops and goes on."""

from __future__ import annotations

import numpy as np
import pytest

from vibopt.charts.friction_cases import Slip, truth
from vibopt.scene.read import from_text
from vibopt.solve.solve import solve
from vibopt.verify.going import Going

SLIPS = (
    Slip(0.49596559914952837, 0.010859993596357967, 0.15175369747280976),  # slips for a hundredth of a turn
    Slip(0.04519699345523883, 0.03125640846011336, 0.3016619208257362),  # holds for a two-thousandth of one in between
    Slip(0.3326957787705613, 0.04268444736728821, 0.5574218162363864),
)


@pytest.mark.parametrize("slip", SLIPS)
def test_brief_slips_and_holds_are_seen_by_both_routes(slip: Slip) -> None:
    answer = solve(from_text(slip.text, name="job"))
    assert answer.status == "met", answer.claim
    assert answer.measures["greatest"].value.value == pytest.approx(truth(slip), rel=1e-9)


@pytest.mark.parametrize(
    ("begin", "falls", "end"),
    [
        ((-1.0, 0.0), (0.0, 1.0, 0.0), np.pi),  # from rest until it stops again
        ((1.0, 0.0), (1.0, 0.0, 1.0 - 1e-9), np.arccos(-1.0 + 1e-9)),  # below for less than a ten-thousandth of a turn
        ((1.0, 0.0), (1.0, 0.0, 1.0 + 1e-9), 10.0),  # not quite below
        ((0.0, 1.0), (1.0, 0.0, -0.5), 5.0 * np.pi / 6.0),  # from below through zero, and down again
    ],
)
def test_free_vibration_goes_on_to_where_a_row_of_it_falls(
    begin: tuple[float, float], falls: tuple[float, float, float], end: float
) -> None:
    nothing, row = np.zeros(2), np.array([*falls[:2], 0.0, 0.0, falls[2]])
    run = Going(np.array([[0.0, 1.0], [-1.0, 0.0]]), nothing, nothing, 1.0, row).run((0.0, 10.0), np.array(begin))
    times = np.linspace(0.0, 10.0, 101)
    right = begin[0] * np.cos(times) + begin[1] * np.sin(times)
    assert (run.end, run.stopped) == (pytest.approx(end, abs=1e-10), end < 10.0)
    assert run.moved(times)[0] == pytest.approx(right, abs=1e-14)


def test_a_damper_far_faster_than_the_force_is_followed_to_what_it_and_friction_leave() -> None:
    slip, friction = Slip(0.05, 100.0, 0.3), 0.3
    answer = solve(from_text(slip.text, name="job"))
    assert answer.status == "met", answer.claim
    alone = (np.sqrt(1.0 - friction**2) - friction * np.arccos(friction)) / (2.0 * slip.ratio * slip.r)
    assert answer.measures["greatest"].value.value == pytest.approx(alone, rel=1e-2)  # without spring and mass
