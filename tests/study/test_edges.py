"""Where the answers of a sweep begin and end: found between the points, and nothing good is shaded."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from texts import STIFFEST, choice, floor, shaken_fan, table
from vibopt import jobs
from vibopt.scene.read import from_text, read, with_changes
from vibopt.solve import solve
from vibopt.study import edges
from vibopt.study.edges import CLOSE, stretches
from vibopt.study.seen import GOOD
from vibopt.study.sweep import sweep
from vibopt.study.sweep_series import change_words, strips
from vibopt.units import to_unit

PRESS = Path(__file__).parents[2] / "problems" / "isolation" / "rao_9_34.toml"
COUNTED = shaken_fan(
    {"stiffness": choice("10 kN/m", "1 MN/m"), "count": 4}, floor("20 N"),
    table("limits.stiff", response="stiffness", of="mount", at_least="400 kN/m"), STIFFEST,
)  # fmt: skip

RUBS = """
title = "Press on mounts that rub"
bodies.press = { mass = "300 kg" }
links.mount = { between = ["press", "ground"], stiffness = "300 kN/m", damping = "500 N s/m", friction_force = "900 N" }
excitations.press = { kind = "force", on = "press", amplitude = "2 kN", speed = "720 rpm" }
limits.floor = { response = "transmitted_force", into = "ground", at_most = "1.3 kN" }
"""


@pytest.mark.parametrize(("low_high", "points"), [("5 mm..30 mm", 4), ("0.2 mm..40 mm", 5)])
def test_nothing_feasible_is_shaded_and_nothing_infeasible_is_left_out(low_high: str, points: int) -> None:
    """Every place is solved anew, by the scene itself and not by the sweep."""
    scene = read(PRESS)
    found = sweep(scene, "limits.start_up.at_most", low_high, points)
    (one,) = stretches(found)
    beyond = one.high * (1.0 + CLOSE)
    inside = [one.low, one.high, *np.random.default_rng(3).uniform(one.low, one.high, 6)]

    def status(value: float) -> str:
        text = f"{to_unit(value, 'mm', 'length'):.17g} mm"
        return solve(with_changes(scene, {"limits.start_up.at_most": text}), explain=False).status

    assert {status(value) for value in inside} == {"infeasible"}
    assert status(beyond) in GOOD
    ((low, high, _),) = strips(found).shaded
    assert (low, high) == pytest.approx((1e3 * one.low, 1e3 * one.high), rel=1e-12)


def test_between_whole_numbers_only_the_points_themselves_are_shaded() -> None:
    found = sweep(from_text(COUNTED), "links.mount.count", "1..12", 12)
    bad = [round(point.value.value) for point in found.points if point.status not in GOOD]
    assert bad
    assert [(round(one.low), round(one.high)) for one in stretches(found)] == [(min(bad), max(bad))]


def test_what_changes_between_whole_numbers_is_said_to_lie_between_them() -> None:
    found = sweep(from_text(COUNTED), "links.mount.count", "1..12", 3)
    for one in found.boundaries:
        below, above = round(one.below.value), round(one.above.value)
        assert above == below + 1
        assert one.precise == f"between {below} and {above}"
    assert found.boundaries


def test_points_are_told_as_they_come() -> None:
    came: list[str] = []
    found = sweep(
        read(PRESS), "limits.start_up.at_most", "5 mm..30 mm", 5, answered=lambda fact, point: came.append(point.status)
    )
    assert came == [point.status for point in found.points]


ENGINE = """
[engine]
stroke = "90 mm"
rod = "150 mm"
speed = "4000 rpm"
reciprocating = "0.6 kg"
rotating = "0.5 kg"
counterweight_share = { from = 0, to = 1 }
[[cylinders]]
crank = "0 deg"
at = "0 mm"
[limits.sec]
response = "secondary_force"
at_most = "1.6 kN"
[limits.pri]
response = "primary_force"
at_most = "6 kN"
[goal]
minimise = "primary_force"
"""


def test_a_point_without_a_design_says_nothing_about_single_limits_and_one_event_is_told_once() -> None:
    found = sweep(jobs.from_text(ENGINE), "engine.rod", "50 mm..250 mm", 5)
    bad = [point for point in found.points if point.status == "infeasible"]
    assert len(bad) == 2
    assert all(not point.margins for point in bad)
    (edge,) = found.boundaries
    assert edge.of_feasibility
    # the second order of one piston, m r w^2 r / l, is at its bound
    exact = 0.6 * 0.045**2 * (4000.0 * np.pi / 30.0) ** 2 / 1600.0
    assert edge.at == pytest.approx(exact, rel=0.03)


def test_one_edge_is_told_where_a_limit_begins_to_hold_and_which_limit_it_is() -> None:
    """A spring that is a hundredth of all moves the frequency little: rounding is a wide part of it."""
    bounded = table("limits.note", response="natural_frequency", mode=1, at_least="5 Hz")
    held = table("links.stop", between=["fan", "ground"], stiffness="10 kN/m")
    scene = from_text(shaken_fan({"stiffness": "98 kN/m"}, held, bounded))
    found = sweep(scene, "links.stop.stiffness", "0.5 kN/m..20 kN/m", 3)
    (edge,) = found.boundaries
    assert (edge.before, edge.after) == (("violated", ("note",), ()), ("met", (), ()))
    assert edge.at == pytest.approx(100.0 * (10.0 * np.pi) ** 2 - 98e3, rel=2e-6)
    assert change_words(edge) == "holds; below, note broken"


def test_lines_of_a_figure_bend_where_the_answer_changes() -> None:
    """Beside each mark there are answers on both sides, and the line begins where designs do."""
    found = sweep(read(PRESS), "limits.floor_force.at_most", "2 kN..40 kN", 6)
    drawn = strips(found)
    assert len(drawn.marks) == 2
    for mark, _ in drawn.marks:
        assert sum(abs(drawn.x - mark) <= 1e-4) == 2
    ((_, end, _),) = drawn.shaded
    first = drawn.x[np.isfinite(drawn.strips[0].lines[0].y)].min()
    assert first == pytest.approx(end, rel=1e-5)


def test_where_a_measured_bound_is_met_few_answers_say(monkeypatch: pytest.MonkeyPatch) -> None:
    """What rubs is answered one by one: the place lies on a line through two margins, not in the middle."""
    asked: list[int] = []
    one_by_one = edges.answered

    def counted(job: Any, facts: Any, places: Any, **more: Any) -> Any:
        asked.append(len(places))
        return one_by_one(job, facts, places, **more)

    monkeypatch.setattr(edges, "answered", counted)
    found = sweep(from_text(RUBS), "links.mount.friction_force", "600 N..1900 N", 3)
    (edge,) = found.boundaries
    before, after = (side.margins["floor"] for side in edge.sides)
    assert (edge.before[0], edge.after[0], edge.wide) == ("met", "violated", False)
    assert before >= 0.0 > after
    assert sum(asked) <= 11  # halves took 20


def test_where_another_part_or_number_of_parts_takes_over_is_told_and_drawn_as_a_step() -> None:
    """Between two of the places the answer is one: solved again anywhere, it costs what the step shows."""
    scene = from_text(
        'bodies.fan = { mass = "850 kg" }\n'
        'links.mount = { between = ["fan", "ground"], damping_ratio = 0.05, '
        'stiffness = { one_of = ["100 kN/m", "150 kN/m", "240 kN/m"] }, count = { from = 4, to = 8, whole = true } }\n'
        'excitations.shaft = { kind = "unbalance", on = "fan", unbalance = "0.35 kg m", speed = "980 rpm" }\n'
        'limits.floor = { response = "transmitted_force", into = "ground", at_most = "900 N" }\n'
        'goal = { minimise = "static_deflection", of = "mount" }\n'
    )
    found = sweep(scene, "limits.floor.at_most", "400 N..1200 N", 3)
    steps = [one for one in found.boundaries if not one.of_feasibility]
    assert len(steps) >= 4
    assert all("mount." in change_words(one) and " -> " in change_words(one) for one in steps)
    cuts = [400.0, *(one.at for one in steps), 1200.0]
    for low, high, one in zip(cuts, cuts[1:], [*steps, None], strict=False):
        there = solve(with_changes(scene, {"limits.floor.at_most": f"{0.5 * (low + high)!r} N"}), explain=False)
        if one is not None:
            assert there.goal[1].value == pytest.approx(one.goals[0], rel=1e-9)


def test_a_choice_that_is_touched_where_it_takes_over_is_one_event_that_was_followed_to_its_end() -> None:
    """Where the next bar is just strong enough it is at its limit for a hair: two changes, both closed, are one."""
    scene = read(PRESS.parents[1] / "shafts" / "rao_9_16_bars.toml")
    found = sweep(scene, "limits.stress.at_most", "26 MPa..36 MPa", 3).boundaries
    assert [(one.after[2][0][1], one.wide) for one in found] == [("40 mm", False), ("15 mm", False)]
    for one, bar in zip(found, ("40 mm", "15 mm"), strict=True):
        measured = solve(jobs.with_changes(scene, {"links.shaft.beam.diameter": bar, "limits.stress.at_most": "1 GPa"}))
        assert one.at == pytest.approx(measured.limits["stress"].value.value, rel=2.0 * CLOSE)


def test_where_the_work_ends_a_boundary_stays_between_two_values(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(edges, "MOST_WORK", 1.0)
    (edge,) = sweep(from_text(RUBS), "links.mount.friction_force", "600 N..1900 N", 3).boundaries
    assert edge.wide
    assert edge.precise == "between 600 N and 1250 N"
