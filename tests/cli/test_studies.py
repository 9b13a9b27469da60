"""What-if, sweep and verify on the command line."""

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

Run = Callable[..., Any]


def test_whatif_puts_both_answers_side_by_side(run: Run, press: str) -> None:
    done = run("whatif", press, "--set", "limits.start_up.at_most=25 mm")
    assert done.code == 0
    assert "limits.start_up.at_most  20 mm -> 25 mm\n" in done.out
    assert "  links.mount.stiffness  6957 kN/m" in done.out
    data = run("whatif", press, "--set", "limits.start_up.at_most=25 mm", "--json").data
    assert data["after"]["goal"]["value"] > data["before"]["goal"]["value"]
    assert (data["keep_design"], data["thresholds"]) == (False, [])


def test_whatif_with_the_design_kept_says_what_breaks(run: Run, press: str) -> None:
    done = run("whatif", press, "--set", "bodies.press.mass=280 kg", "--keep-design")
    assert done.code == 7
    assert 'The design kept breaks "floor_force".' in done.out
    assert "Fails below" in done.out


def test_whatif_that_has_no_answer_says_why(run: Run, press: str) -> None:
    done = run("whatif", press, "--set", "limits.start_up.at_most=8 mm")
    assert done.code == 3
    assert "after: these cannot hold together: floor_force, start_up." in done.out


def test_sweep_lists_writes_and_draws(run: Run, press: str, tmp_path: Path) -> None:
    table, picture = tmp_path / "s.csv", tmp_path / "s.svg"
    words = ("--vary", "limits.start_up.at_most=5 mm..30 mm", "--points", "6")
    done = run("sweep", press, *words, "--csv", str(table), "--figure", str(picture))
    assert done.code == 0
    assert "infeasible" in done.out
    assert f"Written: {table}\nWritten: {picture}\n" in done.out
    rows = list(csv.DictReader(table.read_text().splitlines()))
    assert len(rows) == 6
    assert rows[-1]["status"] == "optimal"
    assert float(rows[-1]["limits.start_up.at_most [m]"]) == pytest.approx(0.03)
    assert float(rows[-1]["stiffness [N/m]"]) == float(rows[-1]["links.mount.stiffness [N/m]"])
    assert rows[0]["stiffness [N/m]"] == ""
    assert picture.read_bytes().startswith(b"<?xml")


def test_sweep_in_json_and_with_the_design_kept(run: Run, press: str) -> None:
    words = ("--vary", "bodies.press.mass=250 kg..350 kg", "--points", "5", "--keep-design")
    data = run("sweep", press, *words, "--json").data
    assert [point["status"] for point in data["points"]][:2] == ["violated", "violated"]
    assert set(data["points"][0]["margins"]) == {"floor_force", "amplitude", "start_up"}


@pytest.mark.parametrize(
    ("vary", "text"),
    [
        ("limits.start_up.at_most", "is no PATH=LOW..HIGH."),
        ("limits.start_up.at_most=5 mm", "is no range"),
        ("limits.start_up.at_least=5..6 mm", "there is no fact called limits.start_up.at_least"),
        ("links.mount.damping=5..6 N s/m", "is to be chosen by vibopt"),
    ],
)
def test_a_wrong_range_is_an_input_error(run: Run, press: str, vary: str, text: str) -> None:
    done = run("sweep", press, "--vary", vary)
    assert done.code == 2
    assert text in done.err


def test_the_series_of_a_sweep_are_in_the_users_units(press: str) -> None:
    from vibopt.scene.read import read
    from vibopt.study.strips import strips
    from vibopt.study.sweep import sweep

    drawn = strips(sweep(read(press), "limits.start_up.at_most", "5 mm..30 mm", 6))
    assert drawn.x_label == "limits.start_up.at_most [mm pk]"
    assert [strip.label for strip in drawn.strips] == ["stiffness of mount\n[MN/m]", "links.mount.damping\n[kN s/m]"]
    assert list(drawn.x) == pytest.approx([5, 10, 15, 20, 25, 30])
    assert drawn.strips[0].lines[0].y[3] == pytest.approx(6.9569172)
    ((low, high, words),) = drawn.shaded
    assert (low, words) == (5.0, "no design meets all limits")
    assert high == pytest.approx(12.5)
