"""What-if, sweep and verify on the command line."""

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vibopt as vo
from rotor_jobs import FAN as MEASURED
from texts import LEFT, MIDDLE, best, floor, permitted, plane, reaction, shaft
from vibopt.study.prices import prices

Run = Callable[..., Any]
ROOT = Path(__file__).parents[2] / "problems"


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
        ("links.mount.damping=5..6 kN", "is a force, but a damping coefficient is needed here"),
    ],
)
def test_a_wrong_range_is_an_input_error(run: Run, press: str, vary: str, text: str) -> None:
    done = run("sweep", press, "--vary", vary)
    assert done.code == 2
    assert text in done.err


def test_the_series_of_a_sweep_are_in_the_users_units(press: str) -> None:
    from vibopt.scene.read import read
    from vibopt.study.sweep import sweep
    from vibopt.study.sweep_series import strips

    drawn = strips(sweep(read(press), "limits.start_up.at_most", "5 mm..30 mm", 6))
    assert drawn.x_label == "limit start_up, at most [mm pk]"
    assert [strip.label for strip in drawn.strips] == ["stiffness of mount\n[kN/m]", "damping of mount\n[N s/m]"]
    end = 10.86664  # drawn where it is: no design on its one side, one on its other
    assert list(drawn.x) == pytest.approx([5, 10, end, end, 15, 20, 25, 30], rel=2e-6)
    stiffness = drawn.strips[0].lines[0].y
    assert list(np.isfinite(stiffness)) == [False] * 3 + [True] * 5
    assert stiffness[5] == pytest.approx(6956.9172)
    ((low, high, words),) = drawn.shaded
    assert (low, words) == (5.0, "no design meets all limits")
    assert high == pytest.approx(10.86664, rel=2e-6)


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("bodies.press.mass", "mass of press"),
        ("links.mount.damping_ratio", "damping ratio of mount"),
        ("limits.start_up.at_most", "limit start_up, at most"),
        ("mounts.foot.at.1.x", "at 1 x of foot"),
        ("orders.2.force", "force of order 2"),
        ("all_orders.couple", "couple of all orders"),
        ("counterweight_share", "counterweight share"),
        ("planes.left.unbalance", "unbalance of left"),
    ],
)
def test_a_path_is_spoken_on_an_axis(path: str, words: str) -> None:
    from vibopt.answer.blocks import spoken_path

    assert spoken_path(path) == words


FAN = permitted(floor("250 N"), damping="800 N s/m")


def test_whatif_of_permitted_speeds_shows_them_before_and_after(run: Run, file: Callable[[str], str]) -> None:
    path = file(FAN)
    done = run("whatif", path, "--set", "limits.move.at_most=1 mm")
    assert done.code == 0
    assert "  fan.speed  0 rpm to 500 rpm           0 rpm to 623.5 rpm\n" in done.out
    assert "             1650 rpm to 6000 rpm       746.6 rpm to 6000 rpm\n" in done.out
    assert "BROKEN" not in done.out
    none = run(
        "whatif",
        path,
        "--set",
        "limits.floor.at_most=1e-9 N",
        "--set",
        'excitations.fan.speed={ from = "600 rpm", to = "700 rpm" }',
    )
    assert "1650 rpm to 6000 rpm       none" in none.out or "0 rpm to 500 rpm           none" in none.out


def test_what_needs_a_design_refuses_a_search_for_speeds(run: Run, file: Callable[[str], str]) -> None:
    path = file(FAN)
    kept = run("whatif", path, "--set", "limits.move.at_most=1 mm", "--keep-design")
    assert kept.code == 2
    assert kept.err.strip() == (
        "mine.toml: find_all answers with speeds, so there is no design to keep: "
        "use whatif without --keep-design instead."
    )
    swept = run("sweep", path, "--vary", "limits.move.at_most=1 mm..3 mm")
    assert swept.code == 2
    assert swept.err.strip() == (
        "mine.toml: sweep needs a goal or limits to measure; find_all answers with speeds: use whatif instead."
    )


def test_the_columns_of_a_table_say_decibels_where_the_user_does(
    run: Run, file: Callable[[str], str], tmp_path: Path
) -> None:
    table = tmp_path / "s.csv"
    path = file(
        FAN.replace('stiffness = "600 kN/m"', 'stiffness = { from = "1 kN/m", to = "10 MN/m" }')
        .replace('{ from = "0 rpm", to = "6000 rpm" }', '"1000..1500 rpm"')
        .replace('response = "transmitted_force"', 'response = "transmissibility"')
        .replace('into = "ground"\nat_most = "250 N"', 'into = "ground"\nat_most = "-6 dB"')
        .replace('find_all = "fan.speed"', 'maximise = "stiffness"\nof = "mount"')
    )
    run("sweep", path, "--vary", "limits.floor.at_most=-30 dB..-5 dB", "--points", "6", "--csv", str(table))
    rows = list(csv.DictReader(table.read_text().splitlines()))
    assert [float(row["limits.floor.at_most [dB]"]) for row in rows] == [-30, -25, -20, -15, -10, -5]


def test_a_range_that_is_replaced_is_said_by_its_ends(run: Run, press: str) -> None:
    done = run("whatif", press, "--set", "links.mount.stiffness=7 MN/m")
    assert "links.mount.stiffness  10 kN/m to 1 GN/m -> 7 MN/m" in done.out


def test_long_names_leave_room_for_the_numbers_beside_them(run: Run, press: str, tmp_path: Path) -> None:
    """In what-if, thresholds included: every value stands in one piece."""
    name = "the_rubber_mount_under_the_drive_side_of_the_press"
    text = Path(press).read_text(encoding="utf-8").partition("[[expected]]")[0]
    text = text.replace("[links.mount]", f"[links.{name}]").replace('of = "mount"', f'of = "{name}"')
    file = tmp_path / "long.toml"
    file.write_text(text, encoding="utf-8")
    done = run("whatif", str(file), "--set", "bodies.press.mass=301 kg", "--keep-design")
    for words in ("6957 kN/m   at once", "9909 N s/m  at once", "excitations.press.speed", "300 kg "):
        assert words in done.out


def test_whatif_without_a_change_ranks_what_to_argue_about(run: Run, press: str) -> None:
    said = run("whatif", press).out
    lines = said.splitlines()
    assert lines[1].startswith("Argue about floor_force first: 10 kN pk -> 11 kN pk buys 9 % (stiffness")
    assert "What to argue about: stiffness is 6957 kN/m\n  Number " in said
    assert "How far that goes on, and what takes over\n" in said
    assert "from 6.351 kN pk (no design beyond) to 30 kN pk (links.mount.damping at its highest takes over and" in (
        " ".join(said.split())
    )
    assert "\nNotes" not in said  # nothing was left out
    data = run("whatif", press, "--json").data
    assert data["status"] == "optimal"
    assert data["measure"] == "stiffness"
    assert {one["sort"] for one in data["rows"]} == {"limit", "fact"}
    assert all(len(one["ways"]) == 2 for one in data["rows"])


def test_what_does_not_go_with_a_table_of_prices_is_refused(run: Run, press: str) -> None:
    kept = run("whatif", press, "--keep-design")
    assert kept.code == 2
    assert "--keep-design and --round go with --set. Name a change: --set PATH=VALUE." in kept.err
    both = run("whatif", press, "--thorough", "--set", "bodies.press.mass=310 kg")
    assert both.code == 2
    assert "--thorough goes without --set: two answers are all there is. Leave one of them out." in both.err
    more = run("whatif", press, "--workers", "2", "--set", "bodies.press.mass=310 kg")
    assert "--workers goes without --set: two answers are all there is. Leave one of them out." in more.err


@pytest.mark.parametrize("name", ["engine_v_twin", "rao_9_3"])
def test_numbers_without_a_step_are_listed_with_the_reason(run: Run, name: str) -> None:
    done = run("whatif", str(Path(__file__).parents[2] / "problems" / "balancing" / f"{name}.toml"))
    assert done.code == 0
    assert "it is zero, and nothing says how large a step is" in " ".join(done.out.split())


SHAFT = shaft(
    LEFT, MIDDLE, plane("drive", "100 mm"), plane("free", "800 mm"), reaction("A", "200 N"), reaction("B", "200 N"),
    best(minimise="correction"),
)  # fmt: skip


def test_bearings_are_moved_by_the_step_of_every_other_place(tmp_path: Path) -> None:
    file = tmp_path / "shaft.toml"
    file.write_text(SHAFT.replace("200 N", "300 N"))
    places = {"shaft.bearings.A": 0.0, "shaft.bearings.B": 0.9, "masses.left.at": 0.2}
    rows = {one.path: one for one in prices(vo.read(file), only=[*places]).rows}
    for path, now in places.items():
        assert [way.value.value for way in rows[path].ways] == pytest.approx([now - 0.007, now + 0.007])


def test_weights_of_a_trade_off_that_are_rounding_are_zero(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "shaft.toml"
    file.write_text(SHAFT)
    done = run("tradeoff", str(file), "--against", "limits.A", "--points", "6")
    assert done.code == 0
    assert "e-" not in done.out
    assert "of the whole curve, in parts of both spans." in " ".join(done.out.split())


def test_what_a_program_leaves_of_a_goal_that_is_reached_is_zero_and_no_price(tmp_path: Path) -> None:
    file = tmp_path / "shaft.toml"
    file.write_text(
        SHAFT.replace('minimise = "correction"', 'minimise = "reaction"')
        .replace("200 N", "3 kN")
        .replace("500 g", "5 kg")
    )
    found = prices(vo.read(file))
    assert found.now is not None
    assert found.now.value == 0.0
    assert found.first == "No sensible step of any number that was looked at improves the reaction."


def test_the_weights_of_a_plan_that_is_kept_may_be_swept(run: Run, tmp_path: Path) -> None:
    """Each reading is then off by what the weight is, as far as it acts."""
    file = tmp_path / "fan.toml"
    text = MEASURED.replace('radius = "150 mm"', 'radius = "150 mm"\nweight = { from = "0 g", to = "20 g" }')
    file.write_text(text + best(minimise="residual"))
    words = ("--keep-design", "--vary", "planes.left.weight.mass=-10 %, +10 %", "--json")
    low, high = run("sweep", str(file), *words).data["points"]
    plan = vo.solve(vo.read(file))
    kept = next(one for one in plan.plan.planes if one.name == "left")
    ends = [one["value"]["value"] for one in (low, high)]
    assert ends == pytest.approx([0.9 * kept.weights[0].mass, 1.1 * kept.weights[0].mass])
    for sensor in ("a", "b"):  # nothing is left with the plan itself
        left = [one["results"][f"sensors.{sensor}.residual"]["value"] for one in (low, high)]
        assert left[0] == pytest.approx(left[1], rel=1e-9)


def test_a_trade_off_shows_which_parts_and_at_which_angles(run: Run) -> None:
    bought = str(ROOT / "mounts" / "compressor_on_bought_mounts.toml")
    done = run("tradeoff", bought, "--against", "limits.floor_force", "--points", "3")
    assert "feet.part  feet.count" in done.out
    assert "S60-55" in done.out
    assert "feet.stiffness" not in done.out


COMPRESSOR = """
title = "Compressor on four mounts"
bodies.compressor.mass = "850 kg"
[links.mount]
between = ["compressor", "ground"]
stiffness = { from = "50 kN/m", to = "10 MN/m" }
loss_factor = 0.12
count = 4
[excitations.shaft]
kind = "unbalance"
on = "compressor"
unbalance = "0.35 kg m"
speed = "980 rpm"
[limits.floor]
response = "transmitted_force"
into = "ground"
at_most = "1200 N"
[limits.start]
response = "displacement"
of = "compressor"
over = "start-up"
at_most = "6 mm"
[limits.sag]
response = "static_deflection"
of = "mount"
at_most = "9 mm"
[goal]
maximise = "stiffness"
of = "mount"
"""


def test_a_trade_off_names_where_it_leaps_and_has_no_knee_behind_its_chord(run: Run, tmp_path: Path) -> None:
    """Stiff mounts far above resonance pass the force of the shaft on; none between both costs less of either."""
    file = tmp_path / "compressor.toml"
    file.write_text(COMPRESSOR)
    words = " ".join(run("tradeoff", str(file), "--against", "limits.floor", "--points", "5").out.split())
    assert (
        "; nothing lies between 1260 kN/m at 4727 N pk and 10000 kN/m at 4727 N pk. There is no knee: no point lies "
        "before the straight line between both ends."
    ) in words


def test_a_trade_off_shows_its_goal_in_the_unit_of_the_file(run: Run, press: str) -> None:
    """Points that were answered together and those that were answered alone; the size alone would choose MN/m."""
    done = run("tradeoff", press, "--against", "limits.start_up", "--points", "12")
    rows = [row for row in done.out.splitlines() if row.count("  ") > 2 and "N/m" in row]
    assert len(rows) == 15
    assert all(" kN/m " in row for row in rows)


@pytest.mark.slow
def test_two_processes_say_what_one_says(run: Run, press: str) -> None:
    assert run("whatif", press, "--workers", "2", "--json").out == run("whatif", press, "--json").out


def test_compare_tells_a_limit_from_a_measure_of_one_name(run: Run, press: str, file: Callable[[str], str]) -> None:
    text = Path(press).read_text(encoding="utf-8").partition("[[expected]]")[0]
    path = file(f'{text}[measures.start_up]\nresponse = "acceleration"\nof = "press"\n')
    rows = [line.split("  ")[0] for line in run("compare", path, press).out.splitlines()]
    assert {"floor_force", "limit start_up", "measure start_up"} <= set(rows)
    assert "start_up" not in rows


ONE_IS_ENOUGH = """
[shaft]
bearings = { A = "0 mm", B = "900 mm" }
speed = "1500 rpm"
[masses.m]
mass = "1 kg"
radius = "50 mm"
angle = "90 deg"
at = "200 mm"
[planes.L]
at = "200 mm"
radius = "50 mm"
[planes.R]
at = "800 mm"
radius = "50 mm"
[goal]
minimise = "unbalance"
"""
BOXER = """
[engine]
stroke = "80 mm"
rod = "150 mm"
speed = "6000 rpm"
reciprocating = "0.5 kg"
rotating = "0.4 kg"
[[cylinders]]
crank = "0 deg"
bank = "-90 deg"
at = "0 mm"
[[cylinders]]
crank = "180 deg"
bank = "90 deg"
at = "0 mm"
[counterweights.R]
at = "0 mm"
unbalance = { from = "0 g mm", to = "5 kg mm" }
[goal]
minimise = "primary_force"
"""
ALIKE = """
[conventions]
phase = "lag"
readings = "phase"
angles = "against rotation"
detector = "pp"
zero = "tape"
[planes.L]
radius = "150 mm"
weight = { from = "0 g", to = "60 g" }
[planes.R]
radius = "150 mm"
weight = { from = "0 g", to = "60 g" }
[[influence]]
sensor = "a"
plane = "L"
value = "1 mil pp/g @ 20 deg"
[[influence]]
sensor = "a"
plane = "R"
value = "0.5 mil pp/g @ 20 deg"
[[runs]]
name = "as found"
speed = "1200 rpm"
readings = { a = "8 mil @ 30 deg" }
[limits.r]
response = "residual"
at_most = "1 mil pp"
[goal]
minimise = "correction"
"""


@pytest.mark.parametrize(
    ("text", "path"),
    [(ONE_IS_ENOUGH, "planes.R"), (ALIKE, "planes.R"), (BOXER, "counterweights.R")],
    ids=["known", "rotor", "engine"],
)
def test_a_weight_of_zero_has_no_angle(
    run: Run, file: Callable[[str], str], tmp_path: Path, text: str, path: str
) -> None:
    """It was told as 0 deg, as if there were something to fit there."""
    saved, name = str(tmp_path / "saved.toml"), file(text)
    assert run("solve", name, "--save", saved).code == 0
    assert run("plot", name, "-o", str(tmp_path / "x.svg"), "--fresh").code == 0
    both = run("compare", name, saved, "--json").data["rows"]
    rows = {row["name"]: row["cells"] for row in both}
    assert rows[f"{path}.angle"][0] is None
    family, _, one = path.partition(".")
    assert not run("solve", name, "--json").data[family][one].get("angle")


def test_a_weight_that_was_none_has_its_angle_beside_it(run: Run, file: Callable[[str], str]) -> None:
    lines = run("whatif", file(ALIKE), "--set", "planes.L.weight.to=4 g").out.splitlines()
    rows = [line.split() for line in lines if line.startswith("  planes.R")]
    assert rows == [["planes.R.mass", "0", "g", "6", "g"], ["planes.R.angle", "-", "190", "deg"]]


def test_whatif_tells_apart_what_has_one_name(run: Run, file: Callable[[str], str]) -> None:
    """The goal, a limit and a measure that are all called "couple"."""
    path = file(
        '[engine]\nstroke = "90 mm"\nrod = "150 mm"\nspeed = "6000 rpm"\nreciprocating = "0.5 kg"\nspacing = "90 mm"\n'
        'counterweight_share = { from = 0, to = 1 }\n[[cylinders]]\ncrank = "0 deg"\n[[cylinders]]\ncrank = "90 deg"\n'
        '[limits.couple]\nresponse = "secondary_couple"\nat_most = "1 kN m"\n'
        '[measures.couple]\nresponse = "primary_couple"\n[goal]\nminimise = "couple"\n'
    )
    lines = run("whatif", path, "--set", "engine.speed=5000 rpm").out.splitlines()
    rows = {line.split()[0]: line for line in lines if line.startswith("  ") and line.split()}
    assert {"goal.couple", "limits.couple", "measures.couple", "counterweight_share"} <= rows.keys()
    assert len(set(rows["goal.couple"].split("N m")[:2])) == 2
