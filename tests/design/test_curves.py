"""What figures draw, by their series."""

from collections.abc import Callable
from math import inf

import numpy as np
import pytest

from vibopt.report.curves import panels
from vibopt.report.design_plane import plane
from vibopt.scene.read import read, with_changes
from vibopt.scene.scene import Design
from vibopt.solve import solve

Solved = Callable[[str], Design]

ALL = [
    "rao_9_1", "rao_9_2", "rao_9_27", "rao_9_28", "rao_9_34", "rao_9_34_printed_design", "rao_9_35", "rao_9_36",
    "rao_9_38", "rao_9_39", "rao_9_40", "rao_9_65",
]  # fmt: skip


@pytest.mark.parametrize("name", ALL)
def test_every_marked_worst_point_lies_on_a_curve(solved: Solved, name: str) -> None:
    for panel in panels(solved(name)):
        for mark in panel.marks:
            if np.isfinite(mark.y):
                gaps = [abs(np.interp(mark.x, one.x, one.y) - mark.y) / (abs(mark.y) or 1.0) for one in panel.curves]
                assert min(gaps) < 1e-3


@pytest.mark.parametrize("name", ALL)
def test_axes_span_all_bounds_and_finite_worst_points(solved: Solved, name: str) -> None:
    for panel in panels(solved(name)):
        low, high = panel.y_span
        heights = [zone.bound for zone in panel.zones] + [mark.y for mark in panel.marks if np.isfinite(mark.y)]
        assert all(low <= height <= high for height in heights)
        assert panel.x_span[0] < panel.x_span[1]


def test_limits_on_one_response_share_a_panel_in_the_users_units(solved: Solved) -> None:
    force, motion = panels(solved("rao_9_34"))
    assert (force.title, force.y_label) == ("Transmitted force into ground", "transmitted force [kN pk]")
    assert (motion.title, motion.x_label) == ("Displacement of press", "speed of press [rpm]")
    assert [(one.name, one.above) for one in motion.zones] == [("amplitude", True), ("start_up", True)]
    numbers = [number for one in motion.zones for number in (one.low, one.high, one.bound)]
    assert numbers == pytest.approx([3000.0, 3000.0, 2.5, 0.0, 3000.0, 20.0])
    assert list(motion.own[0]) == pytest.approx([3000.0, 3000.0])


def test_isolation_is_drawn_as_transmissibility_with_its_bound_turned_round(solved: Solved) -> None:
    panel = panels(solved("rao_9_27"))[0]
    assert panel.y_label == "transmissibility"
    assert [(zone.words, zone.above) for zone in panel.zones] == [("isolated: isolation at least 80 %", True)]
    assert panel.zones[0].bound == pytest.approx(0.2)


def test_an_unknown_amplitude_is_drawn_as_unknown(solved: Solved) -> None:
    panel = panels(solved("rao_9_39"))[0]
    assert int(panel.curves[0].known.sum()) == 1
    assert panel.notes == ("dashed: as if the excitation kept its amplitude",)


def test_five_blocks_are_five_curves_and_an_infinite_peak_is_marked(solved: Solved) -> None:
    (panel,) = panels(solved("rao_9_65"))
    assert [curve.label for curve in panel.curves] == [f"of block_{n}" for n in (0, 25, 50, 75, 100)]
    assert [mark.y for mark in panel.marks if mark.name == "peak_0"] == [inf]


def test_a_vehicle_has_its_own_speed_axis(solved: Solved) -> None:
    (panel,) = panels(solved("rao_9_40"))
    assert panel.x_label == "vehicle speed [km/h]"
    assert panel.zones[0].low == pytest.approx(65.0)


def test_found_speeds_are_drawn_where_the_curve_is_below_the_bound(solved: Solved) -> None:
    (panel,) = panels(solved("rao_9_35"))
    curve, bound = panel.curves[0], panel.zones[0].bound
    good = np.any([(curve.x >= low) & (curve.x <= high) for low, high in panel.good], axis=0)
    asked = curve.x <= 20000.0
    np.testing.assert_array_equal(good[asked], (curve.y <= bound * (1.0 + 1e-9))[asked])


def test_several_excitations_each_get_a_panel_with_the_others_at_their_worst(tmp_path: pytest.TempPathFactory) -> None:
    text = """
title = "two fans"
[bodies.frame]
mass = "100 kg"
[links.mount]
between = ["frame", "ground"]
stiffness = "1 MN/m"
damping = "500 N s/m"
[excitations.one]
kind = "unbalance"
on = "frame"
unbalance = "1 kg mm"
speed = "1500 rpm"
[excitations.two]
kind = "unbalance"
on = "frame"
unbalance = "2 kg mm"
speed = "900..1200 rpm"
[limits.motion]
response = "displacement"
of = "frame"
combine = "rss"
at_most = "1 mm"
"""
    from vibopt.scene.read import from_text

    design = solve(from_text(text))
    drawn = panels(design)
    assert [panel.excitation for panel in drawn] == ["one", "two"]
    total = design.limits["motion"].value.value * 1e3
    for panel in drawn:
        assert panel.marks[0].y == pytest.approx(total)
        assert np.interp(panel.marks[0].x, panel.curves[0].x, panel.curves[0].y) == pytest.approx(total, rel=1e-4)


def test_the_map_agrees_with_the_exact_answer(solved: Solved) -> None:
    design = solved("rao_9_34")
    drawn = plane(design)
    assert drawn is not None
    assert drawn.x.label == "stiffness of mount [MN/m], more is better →"
    assert drawn.y.label == "damping of mount [kN s/m]"
    assert drawn.best is not None
    assert list(drawn.best) == pytest.approx([6.9569172, 9.9086017])
    middle = len(drawn.x.values) // 2
    assert drawn.x.values[middle] == pytest.approx(6.9569172)
    excess = {one.name: one.excess[middle, middle] for one in drawn.boundaries}
    assert excess["floor_force"] == pytest.approx(0.0, abs=1e-6)
    assert excess["start_up"] == pytest.approx(0.0, abs=1e-3)
    assert excess["amplitude"] == pytest.approx(np.log(1.3120613 / 2.5), abs=1e-3)


def test_the_map_measures_what_the_checker_measures(solved: Solved) -> None:
    """At corners and edges of the plane, against the built machine."""
    from vibopt.verify.certify import measure

    design = solved("rao_9_28")
    drawn = plane(design)
    assert drawn is not None
    limit = design.scene.limits["start_up"]
    for i, j in ((0, 0), (60, 0), (0, 60), (60, 60), (20, 45)):
        chosen = {"links.mount.stiffness": drawn.x.values[j] * 1e3, "links.mount.damping": drawn.y.values[i]}
        value = measure(design.scene, chosen, limit).value
        assert drawn.boundaries[1].name == "start_up"
        assert drawn.boundaries[1].excess[i, j] == pytest.approx(np.log(value / 2.5), abs=5e-3)


def test_no_map_for_one_variable_or_whole_numbers(solved: Solved) -> None:
    assert plane(solved("rao_9_36")) is None
    assert plane(solved("rao_9_38")) is None


def test_nothing_is_drawn_where_there_is_no_design() -> None:
    from pathlib import Path

    file = Path(__file__).parents[2] / "problems" / "isolation" / "rao_9_34.toml"
    scene = with_changes(read(file), {"limits.start_up.at_most": "8 mm"})
    design = solve(scene, explain=False)
    assert design.status == "infeasible"
    assert panels(design) == []
    drawn = plane(design)
    assert drawn is not None
    assert drawn.best is None
    assert not np.any(np.max([one.excess for one in drawn.boundaries], axis=0) < 0.0)
