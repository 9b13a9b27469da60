"""Slips and holds far shorter than a turn: what begins with no push to spare, what all but stops and goes on."""

from __future__ import annotations

import pytest

from vibopt.charts.friction_cases import Slip, truth
from vibopt.scene.read import from_text
from vibopt.solve.solve import solve

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
