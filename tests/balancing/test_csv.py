# ruff: noqa: E501
"""Readings from CSV as spreadsheets write it, and messages with row and column."""

from __future__ import annotations

from math import pi
from pathlib import Path

import pytest

from rotor_jobs import FAN, correction, messages, read_text, solve_text

HEAD = 'readings = "job.csv"\n' + FAN[: FAN.index("[[runs]]")]
PLAIN = """run,speed [rpm],left mass [g],left angle [deg],right,a amplitude [mil pp],a angle [deg],b amplitude [mil],b angle [deg]
as found,1200,,,,8.6,63,6.5,206
trial left,1200,10,270,,5.9,123,4.5,228
trial right,1200,,,12 g @ 180 deg,6.2,36,10.4,162
"""
GERMAN = """sep=;
run;speed [rpm];left mass [g];left angle [deg];right;a amplitude [mil pp];a angle [deg];b

as found;1200;;;;8,6;63,0;6,5 mil @ 206 deg
trial left;1200;10,0;270;;5,9;123;4,5 mil @ 228,0 deg
trial right;1200;-;;12 g @ 180 deg;6,2;36;10,4 mil @ 162 deg
"""


def wanted() -> list[complex]:
    plan = solve_text(FAN)
    return [correction(plan, name) for name in ("left", "right")]


@pytest.mark.parametrize(
    ("raw", "sensors"),
    [
        (PLAIN.encode(), ""),
        (PLAIN.replace("\n", "\r\n").encode("utf-8-sig"), ""),
        (GERMAN.encode("utf-8-sig"), "[sensors.a]\n[sensors.b]\n"),
        (GERMAN.replace(";", "\t").replace("sep=\t", "sep=\t").encode("utf-16"), "[sensors.a]\n[sensors.b]\n"),
        (GERMAN.replace("trial", "Prüf").encode("cp1252"), "[sensors.a]\n[sensors.b]\n"),
    ],
    ids=["comma", "windows", "semicolon and byte-order mark", "tab and utf-16", "cp1252"],
)
def test_every_spreadsheet_gives_the_plan_of_the_typed_file(tmp_path: Path, raw: bytes, sensors: str) -> None:
    (tmp_path / "job.csv").write_bytes(raw)
    plan = solve_text(HEAD + sensors, tmp_path)
    assert plan.status == "optimal"
    for name, expected in zip(("left", "right"), wanted(), strict=True):
        assert abs(correction(plan, name) - expected) < 1e-12 * abs(expected) + 1e-15


def test_weights_that_stayed_are_added_up(tmp_path: Path) -> None:
    sheet = PLAIN.replace("run,", "stayed,run,").replace("\nas", "\n,as").replace("\ntrial left", "\nno,trial left")
    (tmp_path / "job.csv").write_text(sheet.replace("\ntrial right", "\nyes,trial right"))
    last = read_text(HEAD, tmp_path).runs[2]
    assert abs(abs(last.weights[0]) - 0.01 * 0.15) < 1e-15
    assert abs(abs(last.weights[1]) - 0.012 * 0.15) < 1e-15


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("8.6", "-8.6", ['job.csv row 2, column F ("a amplitude [mil pp]"): "-8.6 mil pp @ 63 deg" is a negative amplitude. Write it positive and turn the angle by 180 deg.']),
        (",63,", ",463,", ['job.csv row 2, column F ("a amplitude [mil pp]"): "8.6 mil pp @ 463 deg" has an angle above 360 deg. Write "103 deg", or correct it.']),
        ("10,270", "0,270", ['job.csv row 3, column C ("left mass [g]"): "0 g" is a trial weight of zero. Where no weight is on, empty this cell and that of its angle.']),
        ("right,a", "ritgh,a", ['job.csv row 1, column E: "ritgh" names no plane and no sensor of this job. Did you mean "right"?']),
        ("speed [rpm]", "speed", ['job.csv row 2, column B ("speed"): "1200" has no unit. Write "1200 rpm".', 'job.csv row 3, column B ("speed"): "1200" has no unit. Write "1200 rpm".', 'job.csv row 4, column B ("speed"): "1200" has no unit. Write "1200 rpm".']),
        ("a amplitude [mil pp]", "a amplitude", ['job.csv row 1: heading "a amplitude" has no unit. Write "a amplitude [mil]".']),
        ("b amplitude [mil]", "b amplitude", ['job.csv row 1: heading "b amplitude" has no unit. Write "b amplitude [mil pp]".']),
        ("left mass [g]", "left mass", ['job.csv row 1: heading "left mass" has no unit. Write "left mass [g]".']),
        ("a angle [deg]", "a angle", ['job.csv row 1: heading "a angle" has no unit. Write "a angle [deg]".']),
        ("10.4,162", ",", ['job.csv row 4: run "trial right" has no reading of sensor b, which other runs or [sensors] have. Add it, or leave b out of every run.']),
        ("6.5,206", "6.5,206,7", ["job.csv row 2: has 10 cells, but the heading names 9 columns."]),
        (PLAIN, "", ["fan.toml line 1: job.csv is empty. Its first row names the columns: run, speed [rpm], ..."]),
        (PLAIN[PLAIN.index("as found") :], "", ["fan.toml line 1: job.csv has no run below its heading. Add one row a run."]),
    ],
)  # fmt: skip
def test_a_wrong_cell_is_named_by_row_and_column(tmp_path: Path, old: str, new: str, said: list[str]) -> None:
    assert old in PLAIN
    (tmp_path / "job.csv").write_text(PLAIN.replace(old, new, 1))
    assert messages(HEAD, tmp_path) == said


def test_a_file_that_is_not_there_is_said(tmp_path: Path) -> None:
    assert messages(HEAD, tmp_path) == [
        f"fan.toml line 1: {tmp_path / 'job.csv'} is not there. Name the CSV file, relative to the problem file."
    ]


def test_a_plane_and_a_sensor_of_one_name_are_refused(tmp_path: Path) -> None:
    assert messages(HEAD + "[sensors.left]\n", tmp_path) == [
        'fan.toml line 13: "left" is a plane and a sensor: the CSV file could mean either. Rename one.'
    ]


DOUBLE = PLAIN.replace("b amplitude [mil]", "a amplitude [mil]").replace("b angle", "a angle")
TEXTS = "run,speed [rpm],left,right,a,a angle [deg],b\n"


@pytest.mark.parametrize(
    ("sheet", "said"),
    [
        (DOUBLE, ['job.csv row 1: column F ("a amplitude [mil pp]") and column H ("a amplitude [mil]") both hold the size of a. Keep one, or rename the other.', 'job.csv row 1: column G ("a angle [deg]") and column I ("a angle [deg]") both hold the angle of a. Keep one, or rename the other.']),
        (PLAIN.replace("run,", "speed [rpm],"), ['job.csv row 1: column A ("speed [rpm]") and column B ("speed [rpm]") both hold speed. Keep one, or rename the other.']),
        (PLAIN.replace("left mass [g],", "b angle [rad],"), ['job.csv row 1: column C ("b angle [rad]") and column I ("b angle [deg]") both hold the angle of b. Keep one, or rename the other.', 'job.csv row 1: column D ("left angle [deg]") has no column beside it for the size. Add one, "left mass [g]".']),
        (PLAIN.replace("10,270", ",270"), ['job.csv row 3, column D ("left angle [deg]"): "270" is an angle without its weight. Write the weight in column C ("left mass [g]"), or empty this cell.']),
        (PLAIN.replace("5.9,123", ",123"), ['job.csv row 3, column G ("a angle [deg]"): "123" is an angle without its amplitude. Write the amplitude in column F ("a amplitude [mil pp]").']),
        (PLAIN.replace("12 g @ 180 deg", "0 g @ 180 deg"), ['job.csv row 4, column E ("right"): "0 g @ 180 deg" is a trial weight of zero. Where no weight is on, empty this cell.']),
        (PLAIN.replace("run,", "stayed,run,").replace("\nas", "\n,as").replace("\ntrial", "\nmaybe,trial", 1).replace("\ntrial right", "\nno,trial right"), ['job.csv row 3, column A ("stayed"): "maybe" is neither yes nor no. Write yes where the weights of the run before stayed on.']),
        (TEXTS + "as found,1200,,,8.6 mil pp @ 63 deg,63,6.5 mil pp @ 206 deg\n", ['job.csv row 2, column E ("a"): "8.6 mil pp @ 63 deg" has an angle, and so has column F ("a angle [deg]"). Empty one of the two.']),
    ],
    ids=["a sensor twice", "speed twice", "angle alone", "no mass", "no amplitude", "zero", "stayed", "two angles"],
)  # fmt: skip
def test_a_column_or_cell_that_would_be_lost_is_asked_about(tmp_path: Path, sheet: str, said: list[str]) -> None:
    (tmp_path / "job.csv").write_text(sheet)
    sensors = "[sensors.a]\n[sensors.b]\n" if sheet.startswith(TEXTS) else ""
    assert messages(HEAD + sensors, tmp_path) == said


@pytest.mark.parametrize(("yes", "no"), [("WAHR", "FALSCH"), ("Ja", "nein"), ("VRAI", "FAUX"), ("TRUE", "FALSE")])
def test_a_spreadsheet_says_yes_in_its_own_language(tmp_path: Path, yes: str, no: str) -> None:
    sheet = PLAIN.replace("run,", "stayed,run,").replace("\nas", f"\n{no},as").replace("\ntrial", f"\n{no},trial", 1)
    (tmp_path / "job.csv").write_text(sheet.replace("\ntrial right", f"\n{yes},trial right"))
    assert [run.stayed for run in read_text(HEAD, tmp_path).runs] == [False, False, True]


ASKED = "a point often parts thousands where the comma is the decimal sign. Write"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (";1200;", ";1.200;", [f'job.csv row {row}, column B ("speed [rpm]"): "1.200" may be 1200 or 1.200: {ASKED} 1200 or 1,200.' for row in (4, 5, 6)]),
        (";10,0;", ";10.125;", [f'job.csv row 5, column C ("left mass [g]"): "10.125" may be 10125 or 10.125: {ASKED} 10125 or 10,125.']),
    ],
)  # fmt: skip
def test_a_point_that_may_part_thousands_is_asked_about(tmp_path: Path, old: str, new: str, said: list[str]) -> None:
    assert old in GERMAN
    (tmp_path / "job.csv").write_text(GERMAN.replace(old, new))
    assert messages(HEAD + "[sensors.a]\n[sensors.b]\n", tmp_path) == said


def test_a_sheet_with_decimal_points_is_not_asked_about_them(tmp_path: Path) -> None:
    (tmp_path / "job.csv").write_text(PLAIN.replace(",", ";").replace("1200", "1200.125").replace("8.6", "8.625"))
    job = read_text(HEAD, tmp_path)
    assert job.runs[0].given_speed == pytest.approx(1200.125 * 2.0 * pi / 60.0)
    assert job.runs[0].written is not None
    assert job.runs[0].written["a"] == "8.625 mil pp @ 63 deg"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("8.6,63", "8.6%,63", '"8.6%" has a unit of its own. Write the number alone, in "mil pp".'),
        (",5.9,123", ",5.9,12 %", '"12 %" has a unit of its own. Write the number alone, in "deg".'),
        (",10,270", ",1 %,270", '"1 %" has a unit of its own. Write the number alone, in "g".'),
    ],
)
def test_a_percentage_is_no_size_of_a_hundredth_of_the_column(tmp_path: Path, old: str, new: str, said: str) -> None:
    (tmp_path / "job.csv").write_text(PLAIN.replace(old, new, 1))
    assert any(message.endswith(said) for message in messages(HEAD, tmp_path))


def test_a_comma_beside_decimal_points_is_asked_about(tmp_path: Path) -> None:
    sheet = PLAIN.replace(",", ";").replace("8.6;63", "1,200;63")
    (tmp_path / "job.csv").write_text(sheet)
    assert messages(HEAD, tmp_path)[0].endswith(
        '"1,200" has a comma where other cells have decimal points. Write 1200 or 1.200.'
    )


@pytest.mark.parametrize("speed", ["1.2e3", "1200.", "+1200", "12E2", ".12e4"])
def test_a_speed_is_read_in_every_way_a_number_is_written(tmp_path: Path, speed: str) -> None:
    (tmp_path / "job.csv").write_text(PLAIN.replace(",1200,", f",{speed},"))
    assert read_text(HEAD, tmp_path).runs[0].speed == read_text(FAN).runs[0].speed


@pytest.mark.parametrize("size", ["10", "10.5", "0.05", "1e1", "+10"])
@pytest.mark.parametrize("angle", ["0", "270", "-90", "+12.5"])
@pytest.mark.parametrize("brackets", ["[]", "()"])
def test_a_weight_in_two_columns_is_the_weight_in_one(tmp_path: Path, size: str, angle: str, brackets: str) -> None:
    two = PLAIN.replace("10,270", f"{size},{angle}").translate(str.maketrans("[]", brackets))
    one = (
        PLAIN.replace(" mass [g],left angle [deg]", "")
        .replace(",1200,,", ",1200,")
        .replace("10,270", f"{size} g @ {angle} deg")
    )
    runs = []
    for sheet in (two, one):
        (tmp_path / "job.csv").write_text(sheet)
        runs.append(read_text(HEAD, tmp_path).runs)
    for mine, its in zip(*runs, strict=True):
        assert (mine.weights == its.weights).all()
        assert (mine.readings == its.readings).all()
        assert mine.given_speed == its.given_speed
