"""Mounts of a catalogue in the charts: truths by other roads, vibopt right or outspoken, rivals judged by the same."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from hypothesis import given, settings
from hypothesis import strategies as st

from refusals import refused
from vibopt.charts import runner
from vibopt.charts.accuracy_figure import Scatter, accuracy_figure
from vibopt.charts.chart_figures import fidelity_figure
from vibopt.charts.fidelity import Fidelity
from vibopt.charts.mount_cases import UNANSWERABLE, Asked, asked, families, machine_on
from vibopt.charts.mount_fidelity import AUTOMATIC, fidelity
from vibopt.charts.mount_machine import GRAVITY, LINE, SPACE, Machine, alike, drawn
from vibopt.charts.mount_milp import cheapest
from vibopt.charts.mount_rivals import HARD_METHODS, METHODS, judged_parts, shares
from vibopt.charts.mount_truth import broken, least_price, loads, natural, peaks, prices
from vibopt.charts.runner import fidelity as charted_fidelity
from vibopt.charts.runner import speed_accuracy
from vibopt.charts.trial import DEFAULT, Trial, timed
from vibopt.charts.verdicts import FEASIBLE, INFEASIBLE, REFUSES, RIGHT, SAYS_SO, SILENT, UNPROVEN
from vibopt.cli.chart_command import chart
from vibopt.program.pose import pose
from vibopt.scene.read import read
from vibopt.scene.scene import Scene
from vibopt.scene.uncertain import uncertain
from vibopt.solve.branch import Judge

CASES = {"line": (LINE, 12, 2, 1, False), "steel": (LINE, 12, 2, 6, True), "space": (SPACE, 12, 2, 3, False)}
SMALL = {name: asked(*machine_on(*size)) for name, size in CASES.items()}
HARD = families(quick=True)
REFUSED_INERTIA = ("inertia about x of 0", "no inertia, every mode below 50 Hz")
MASS, K, LOSS = 1000.0, 1e6, 0.05
FEET = ((0.8, 0.5, 0.0), (0.8, -0.5, 0.0), (-0.8, 0.5, 0.0), (-0.8, -0.5, 0.0))
PLAIN = Machine("plain", MASS, (0.0, 0.0, 0.3), (300.0, 640.0, 700.0), (FEET,), 2000.0, (0.0, 0.0, 0.3), sway=1.0)


def named(one: Asked) -> str:
    return one.case.name


def hard(name: str) -> Asked:
    return next(one for one in HARD if one.case.name == name)


def by(one: Asked, method: str, folder: Path) -> Trial:
    by = HARD_METHODS[method] if method in HARD_METHODS else METHODS[method]
    return judged_parts(one.case, one, method, timed(lambda: by(one), 1))


def run(*words: str) -> Result:
    return CliRunner().invoke(chart, list(words), standalone_mode=False)


def test_peak_of_one_mass_is_its_closed_form() -> None:
    """w^2/w0^2 F / |k (1 + i eta) - w^2 m| is greatest where w^2 = (1 + eta^2) k/m."""
    machine, shelf = replace(PLAIN, motion=LINE), alike(1, k=K, loss=LOSS)
    mass, dynamic, _ = machine.matrices(shelf, np.array([[0]]))
    slope = machine.force / machine.omega**2
    wanted = slope * math.sqrt(1.0 + LOSS**2) / (MASS * LOSS)
    assert peaks(machine, mass, dynamic)[0] == pytest.approx(wanted, rel=1e-12)


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 1000))
def test_no_sampled_speed_is_above_the_peak(seed: int) -> None:
    machine, shelf = machine_on(SPACE, 10, 2, seed, steel=True)
    chosen = np.random.default_rng(seed).integers(0, 10, (3, 2))
    mass, dynamic, _ = machine.matrices(shelf, chosen)
    top = peaks(machine, mass, dynamic)
    for stiff, most in zip(dynamic, top, strict=True):
        own = natural(mass, stiff[None])[0]
        near = (own[:, None] * np.linspace(0.98, 1.02, 4001)).ravel()
        speeds = np.concatenate([np.linspace(0.0, machine.omega, 2001), near[near <= machine.omega]])
        force = machine.push()[None] * (speeds[:, None] / machine.omega) ** 2
        u = np.linalg.solve(stiff - speeds[:, None, None] ** 2 * mass, force[..., None].astype(complex))[..., 0]
        sampled = np.abs(u @ machine.reads()).max()
        assert sampled <= most * (1.0 + 1e-9)
        assert sampled > most * (1.0 - 1e-3)


def test_loads_are_those_of_the_lever() -> None:
    """Weight 0.3 m off the middle of mounts 1.6 m apart."""
    machine, shelf = replace(PLAIN, centre=(0.3, 0.0, 0.3)), alike(1, most=1.0)
    chosen = np.array([[0]])
    over = loads(machine, shelf, chosen, machine.matrices(shelf, chosen)[2])[0]
    wanted = MASS * GRAVITY / 4.0 * (1.0 + 0.3 / 0.8)
    assert over + 1.0 == pytest.approx(wanted, rel=1e-12)
    two = replace(machine, groups=(FEET[:2], FEET[2:]))
    assert shares(two) == pytest.approx([wanted, MASS * GRAVITY / 2.0 - wanted], rel=1e-12)


@pytest.mark.parametrize("name", CASES)
def test_plain_numpy_and_vibopt_measure_the_same(name: str, tmp_path: Path) -> None:
    """Every violation of forty random choices by two roads that share no code."""
    one = SMALL[name]
    program = pose(one.machine.scene(tmp_path, one.shelf))
    judge = Judge(program)
    chosen = np.random.default_rng(0).integers(0, len(one.shelf), (40, 2))
    for parts, mine in zip(chosen, broken(one.machine, one.shelf, chosen), strict=True):
        x = np.zeros(len(program.axes))
        for tie, part in zip(program.ties, parts, strict=True):
            x[list(tie.axes)] = tie.table[part]
        theirs = max(judge.limit(limit, x)[0] for limit in program.limits)
        assert theirs == pytest.approx(mine, rel=1e-10, abs=1e-10)


def test_shelves_are_drawn_alike_each_time_and_harder_rubber_loses_more() -> None:
    one, other = (drawn(3, 200, 400.0, 9000.0) for _ in range(2))
    assert np.array_equal(one.k, other.k)
    assert np.corrcoef(one.k / one.most, one.loss)[0, 1] > 0.5
    assert (one.k >= one.static).all()
    assert np.polyfit(np.log(one.most), np.log(one.price), 1)[0] == pytest.approx(0.5, abs=0.1)


@pytest.mark.parametrize("name", CASES)
def test_vibopt_has_the_least_price_of_all_choices(name: str, tmp_path: Path) -> None:
    trial = by(SMALL[name], DEFAULT, tmp_path)
    assert (trial.status, trial.verdict, trial.error) == ("optimal", RIGHT, 0.0)


def test_sampled_speeds_buy_steel_springs_that_break_the_limit(tmp_path: Path) -> None:
    one = asked(*machine_on(LINE, 60, 2, 6, steel=True))
    trial = by(one, "sampled 50", tmp_path)
    assert trial.fault.startswith("limit broken by")
    assert trial.off < 0.0
    assert trial.error == trial.missed > 0.1


def test_dearer_choice_that_is_not_called_the_best_is_no_false_claim(tmp_path: Path) -> None:
    one = asked(*machine_on(LINE, 60, 2, 1, steel=False))
    trial = by(one, "at random", tmp_path)
    assert (trial.status, trial.verdict, trial.missed) == ("feasible", UNPROVEN, 0.0)
    assert trial.error == trial.off > 0.01


@pytest.mark.parametrize("one", HARD, ids=named)
def test_vibopt_is_right_or_says_so_on_hard_ground(one: Asked, tmp_path: Path) -> None:
    trial = by(one, DEFAULT, tmp_path)
    assert trial.verdict == (SAYS_SO if one.case.name in REFUSED_INERTIA else RIGHT)


def test_hard_ground_has_every_kind_of_truth() -> None:
    assert {one.case.truth for one in HARD} == {FEASIBLE, INFEASIBLE, UNANSWERABLE}
    assert {one.case.truth for one in HARD if one.case.family == "no damping"} == {FEASIBLE, INFEASIBLE}


def test_undamped_resonances_lie_where_the_closed_form_has_them() -> None:
    one = hard("one part above the range")
    own = np.sqrt(4.0 * one.shelf.k / one.machine.mass)
    below = own < one.machine.omega
    assert below.tolist() == [True] * 7 + [False]
    assert one.case.goal == 4.0 * one.shelf.price[-1]


def test_bounce_and_pitch_of_the_closed_form_are_the_same() -> None:
    """By the inertia m (a^2 + h^2) up to the part in a million that it is more."""
    one = hard("modes 1e-06 apart")
    mass, dynamic, _ = one.machine.matrices(one.shelf, np.array([[5]]))
    own = natural(mass, dynamic)[0]
    bounce = math.sqrt(4.0 * one.shelf.k[5] / one.machine.mass)
    near = own[np.abs(own / bounce - 1.0) < 1e-3]
    assert len(near) == 2
    assert 1e-8 < near[1] / near[0] - 1.0 < 1e-6
    assert one.case.goal == 4.0 * one.shelf.price[5]


def test_rods_without_inertia_are_refused_by_name(tmp_path: Path) -> None:
    trial = by(hard("inertia about x of 0"), DEFAULT, tmp_path)
    assert (
        "is zero about the axis x, but a body in space turns there as well. Write its real inertia, or" in trial.claim
    )


def test_scripts_buy_parts_for_machines_that_cannot_stand(tmp_path: Path) -> None:
    one = hard("mounts in a line along x")
    assert np.isinf(broken(one.machine, one.shelf, np.array([[0]]))[0])
    assert by(one, "by hand", tmp_path).verdict == SILENT
    assert by(hard("no stiffness sideways"), "sampled 50", tmp_path).verdict == SAYS_SO


def test_refusal_without_the_reason_is_not_right(tmp_path: Path) -> None:
    one = hard("mounts in a line along x")
    assert by(replace(one, named="no such words"), DEFAULT, tmp_path).verdict == SAYS_SO


def test_no_choice_has_an_infinite_price() -> None:
    assert least_price(PLAIN, alike(0)) == (math.inf, None)
    assert least_price(PLAIN, alike(3, most=1.0)) == (math.inf, None)


def test_vibopt_chooses_the_coordinates_that_the_limits_need() -> None:
    rows = {row.case: row for _, make in fidelity(quick=True) for row in make()}
    own = {case: row for case, row in rows.items() if case.endswith(AUTOMATIC)}
    assert [row.used for row in own.values()] == [1, 3, 6]
    assert max(row.value_error for row in own.values()) < 1e-12
    assert {row.goal_error for row in own.values()} == {0.0}
    assert rows["symmetric, one coordinate"].value_error < 1e-12
    assert rows["offset, three coordinates"].value_error < 1e-12
    for case in ("offset, one coordinate", "skew, one coordinate", "skew, three coordinates"):
        assert rows[case].value_error > 0.1


def bought(folder: Path, *, more: str = "") -> Scene:
    """A press of 900 kg on four to six mounts of two parts; it moves 2 N / |k - 900 kg w^2| at most."""
    (folder / "p.csv").write_text(
        "part;rated load max [N];stiffness [N/mm];loss factor;price [EUR]\nA;9000;200;0.1;10\nB;9000;300;0.1;9\n"
    )
    (folder / "press.toml").write_text(
        '[bodies.press]\nmass = "900 kg"\n[links.feet]\nbetween = ["press", "ground"]\n'
        'part = { catalogue = "p.csv" }\ncount = { from = 4, to = 6, whole = true }\n'
        '[excitations.e]\nkind = "force"\non = "press"\namplitude = "2 kN"\nspeed = "1500 rpm"\n'
        '[limits.floor]\nresponse = "transmitted_force"\ninto = "ground"\nat_most = "90 N"\n'
        f'[goal]\nminimise = "price"\n{more}'
    )
    return read(folder / "press.toml")


def test_users_file_is_measured_choice_by_choice(tmp_path: Path) -> None:
    """Four of A pass on 75 N, five of A 94 N and four of B 114 N: 2 kN |k (1 + 0.1 i)| / |k (1 + 0.1 i) - m w^2|."""
    passed = {}
    for name, k in (("4A", 0.8e6), ("5A", 1.0e6), ("4B", 1.2e6)):
        stiff = k * (1.0 + 0.1j)
        passed[name] = abs(2000.0 * stiff / (stiff - 900.0 * (50.0 * math.pi) ** 2))
    assert passed["4A"] < 90.0 < passed["5A"] < passed["4B"]
    result = speed_accuracy([bought(tmp_path)], quick=True)
    (case,) = result.cases
    assert (case.name, case.goal, case.known_by) == ("press", 40.0, "every choice measured")
    assert [(one.method, one.verdict) for one in result.trials] == [(name, RIGHT) for name in result.methods]
    assert result.methods == (DEFAULT, "every choice", "at random")
    assert result.trials[0].error == 0.0


def test_users_file_with_too_many_choices_says_what_the_truth_rests_on(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("vibopt.charts.own_scenes.QUICK_MOST", 5)
    result = speed_accuracy([bought(tmp_path)], quick=True)
    assert result.cases[0].known_by == "vibopt itself: proven: none of 6 combinations of parts is better"
    assert [one.status for one in result.trials] == ["optimal", "unproven", "feasible"]
    words = "6 choices are more than the 5 that are measured one by one"
    assert [(one.method, one.cut) for one in result.cut] == [("every choice", words)]


def test_users_file_that_no_part_can_answer_is_infeasible_by_every_road(tmp_path: Path) -> None:
    tight = '[limits.sag]\nresponse = "static_deflection"\nof = "press"\nat_most = "1 mm"\n'
    result = speed_accuracy([bought(tmp_path, more=tight)], quick=True)
    assert result.cases[0].truth == INFEASIBLE
    assert [one.status for one in result.trials] == ["infeasible", "infeasible", "unproven"]


def test_tolerances_of_bought_parts_are_left_out_and_that_is_said(tmp_path: Path) -> None:
    bought(tmp_path)
    table = tmp_path / "p.csv"
    heads, *rows = table.read_text().splitlines()
    table.write_text("\n".join([f"{heads};tolerance [%]", *(f"{row};15" for row in rows)]))
    scene = read(tmp_path / "press.toml")
    assert uncertain(scene)
    assert speed_accuracy([scene], quick=True).cases[0].known_by == "every choice measured, without tolerances"


def test_open_places_and_tolerances_are_refused_in_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "wide.toml").write_text(
        '[bodies.m]\nmass = "300 kg"\nmotion = "space"\ninertia = ["9 kg m2", "9 kg m2", "9 kg m2"]\n'
        '[mounts.foot]\nbetween = ["m", "ground"]\nshear_ratio = 0.5\nloss_factor = 0.1\n'
        'at = { one_of = [[["1 m", "1 m", "0 m"], ["-1 m", "0 m", "0 m"], ["1 m", "-1 m", "0 m"]], '
        '[["1 m", "1 m", "0 m"], ["-1 m", "0 m", "0 m"], ["1 m", "-2 m", "0 m"]]] }\n'
        'stiffness = { from = "10 kN/m", to = "1 MN/m" }\n[goal]\nmaximise = "natural_frequency"\n'
    )
    wide = read(tmp_path / "wide.toml")
    words = (
        "wide.toml: mounts.foot.at leaves several places open, and the chart compares one machine at a time. "
        "Name one place."
    )
    for make in (speed_accuracy, charted_fidelity):
        assert str(refused(make, [wide])) == words
    (tmp_path / "off.toml").write_text(
        '[bodies.m]\nmass = "300 kg"\n[links.mount]\nbetween = ["m", "ground"]\n'
        'stiffness = { from = "10 kN/m", to = "1 MN/m", tolerance = "20 %" }\ndamping = "1 kN s/m"\n'
        '[excitations.e]\nkind = "force"\non = "m"\namplitude = "1 kN"\nspeed = "1500 rpm"\n'
        '[limits.f]\nresponse = "transmitted_force"\ninto = "ground"\nat_most = "500 N"\n'
        '[goal]\nmaximise = "stiffness"\nof = "mount"\n'
    )
    assert str(refused(lambda: speed_accuracy([read(tmp_path / "off.toml")]))) == (
        "off.toml: links.mount.stiffness has a tolerance, and the other methods of the chart know none. Remove it."
    )


def test_chart_of_stability_is_told_as_table_data_and_picture(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    result = runner.stability(family="mounts", quick=True)
    monkeypatch.setattr(runner, "stability", lambda **_: result)
    picture = tmp_path / "stability.svg"
    told = run("stability", "--family", "mounts", "--quick", "--figure", str(picture))
    assert told.return_value == 5  # --quick leaves out
    assert "modes alike" in told.output
    assert "Silently wrong" in told.output
    assert picture.read_text().count("slsqp, rounded") == 1
    data = json.loads(run("stability", "--family", "mounts", "--quick", "--json").output)
    assert data["counts"]["mounts in a line"][DEFAULT] == {RIGHT: 2}
    assert all(SILENT not in counts[DEFAULT] for counts in data["counts"].values())


def test_errors_of_mounts_are_called_a_price_in_the_figure() -> None:
    figure = accuracy_figure([Scatter("a", 1.0, (), (), "excess price or broken limit (part)")], DEFAULT)
    assert figure.axes[0].get_ylabel() == "excess price or broken limit (part)"


@pytest.mark.parametrize(
    ("error", "ticks"), [(1e-15, ["0", "1e-14", "1e-11", "1e-08"]), (3.0, ["0", "1e-12", "1e-07", "1e-02"])]
)
def test_great_errors_have_their_place_on_the_axis(error: float, ticks: list[str]) -> None:
    panel = fidelity_figure([Fidelity("a", 6, 1, "", 1.0, 2.0, 1.0, 2.0, error, 0.0)]).axes[2]
    assert [one.get_text() for one in panel.get_xticklabels()] == ticks
    assert panel.get_xlim()[1] > error


@pytest.mark.slow
@pytest.mark.parametrize("one", families(quick=False), ids=named)
def test_vibopt_is_right_or_says_so_in_the_full_chart(one: Asked, tmp_path: Path) -> None:
    assert by(one, DEFAULT, tmp_path).verdict in (RIGHT, SAYS_SO)


@settings(max_examples=12)
@given(seed=st.integers(0, 10**6), parts=st.integers(4, 9), steel=st.booleans())
def test_highs_with_exchange_proves_what_every_choice_measured_says(seed: int, parts: int, steel: bool) -> None:
    try:
        machine, shelf = machine_on(LINE, parts, 2, seed, steel)
    except ValueError:  # no choice carries the machine
        return
    best, _ = least_price(machine, shelf)
    status, chosen = cheapest(machine, shelf)
    assert status == ("optimal" if np.isfinite(best) else "infeasible")
    assert chosen is None or prices(machine, shelf, chosen[None, :])[0] == pytest.approx(best, rel=1e-12)


def test_highs_refuses_what_its_program_cannot_say() -> None:
    said = METHODS["highs exchange"](SMALL["space"])
    words = "takes machines on a line: in space nothing bounds the motions that parts are multiplied by"
    assert (said.status, said.claim) == (REFUSES, words)
    free = replace(SMALL["line"], machine=replace(SMALL["line"].machine, sway=None))
    assert METHODS["highs exchange"](free).claim == "takes a limit on the sway"
