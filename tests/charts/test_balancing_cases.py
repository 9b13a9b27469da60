"""Balancing in the charts: references by other roads, vibopt right everywhere, rivals judged by the same truth."""

from __future__ import annotations

import json
import os
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.continuous import solve_continuous
from vibopt.balancing.question import Question
from vibopt.charts import runner
from vibopt.charts.balancing_cases import fidelity, hard
from vibopt.charts.balancing_questions import (
    QUICK_SIZES,
    Asked,
    critical,
    families,
    least_squares,
    shelf,
    spoilt,
    stock,
    worst,
)  # fmt: skip
from vibopt.charts.balancing_rivals import METHODS, broken, judged_question
from vibopt.charts.chart_figures import stability_figure
from vibopt.charts.cutting_planes import least_worst
from vibopt.charts.runner import Chart, charted
from vibopt.charts.trial import DEFAULT, Trial, timed
from vibopt.charts.verdicts import MISSING, RIGHT, SAYS_SO, SILENT
from vibopt.cli.chart_command import chart
from vibopt.solve.rivals import hsbalance

STOCK, HARD = stock(quick=True), families(quick=True)


def tried(one: Asked, method: str, runs: int) -> Trial:
    return judged_question(one.case, one, method, timed(lambda: METHODS[method](one), runs))


def named(one: Asked) -> str:
    return one.case.name


@pytest.mark.parametrize("one", [one for one in STOCK if one.case.name != "least squares, 1000x20"], ids=named)
def test_vibopt_has_the_reference_of_every_stock_question(one: Asked) -> None:
    trial = tried(one, DEFAULT, 1)
    assert (trial.status, trial.verdict) == ("optimal", RIGHT)
    assert trial.error < 1e-8


@pytest.mark.parametrize("one", HARD, ids=named)
def test_vibopt_is_right_on_hard_ground(one: Asked) -> None:
    trial = tried(one, DEFAULT, 1)
    assert trial.verdict == RIGHT
    assert np.isnan(trial.error) or trial.error < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize("one", [*stock(quick=False), *families(quick=False)], ids=named)
def test_vibopt_is_right_in_the_full_charts(one: Asked) -> None:
    one_in_a_million_millions = ("condition number 1e12", "planes alike to 1e-12")
    allowed = (RIGHT, SAYS_SO) if one.case.name in one_in_a_million_millions else (RIGHT,)
    assert tried(one, DEFAULT, 1).verdict in allowed


@pytest.mark.parametrize(("n", "p"), [(8, 2), (60, 4)])
def test_what_is_built_round_its_answer_is_what_cutting_planes_find(n: int, p: int) -> None:
    """Two roads to a reference, neither of them that of vibopt."""
    bound, gap = least_worst(worst(n, p))
    assert gap < 2e-9
    assert bound == pytest.approx(1.0, abs=2e-9)


def test_no_small_step_betters_what_is_built_round_its_answer() -> None:
    """The correction that was built in has the goal that is claimed, and every way from it leads up."""
    rng = np.random.default_rng(11)
    for question, goal in (least_squares(8, 2), spoilt(2), (worst(8, 2), 1.0), (critical(10.0), 1.0)):
        u = correction(question, goal)
        for _ in range(200):
            near = u + 1e-4 * (rng.normal(size=2) + 1j * rng.normal(size=2))
            if broken(question, near) == 0.0:
                assert question.value(near) > goal * (1.0 - 1e-9)


def correction(question: Question, goal: float) -> ComplexArray:
    u = solve_continuous(question).u
    assert u is not None
    assert question.value(u) == pytest.approx(goal, rel=1e-8)
    return u


def test_rounding_each_plane_by_itself_misses_and_breaks_limits() -> None:
    least_worst_left, least_mass = (tried(one, "rounding", 1) for one in shelf())
    assert least_worst_left.fault.startswith("goal off by")
    assert least_mass.fault.startswith("limit broken by")


def test_a_weight_that_is_not_on_the_shelf_breaks_the_question() -> None:
    question = shelf()[0].question
    assert broken(question, np.array([0.1, 0.2j, -0.5])) == pytest.approx(0.0, abs=1e-15)
    assert broken(question, np.array([0.1, 0.2j, 0.55])) == pytest.approx(0.1)


def test_convex_rival_is_right_where_its_solver_is_not_asked_for_decades() -> None:
    asked = [one for one in HARD if one.case.family not in ("units", "condition number")]
    assert {tried(one, "cvxpy 1e-08", 1).verdict for one in asked} == {RIGHT}
    wide = next(one for one in HARD if one.case.name == "corrections times 1e6")
    assert tried(wide, "cvxpy 1e-08", 1).verdict in (SILENT, SAYS_SO)


def test_smaller_models_have_the_goal_of_the_full_ones() -> None:
    rows = {row.case: row for _, make in fidelity(quick=True) for row in make() if row.kinds is None}
    assert {case: (row.declared, row.used) for case, row in rows.items()} == {
        "rotor, 4 planes": (4, 2),
        "rotor, 24 sensors": (24, 5),
        "rotor, 12 speeds": (12, 4),
    }
    assert max(max(row.goal_error, row.value_error) for row in rows.values()) < 1e-8


def test_orders_of_a_crank_miss_what_its_kinematics_show() -> None:
    """Two pistons on one pin at right angles, their accelerations by differences of their own places."""
    rows = {name: make for name, make in fidelity(quick=True) if name.startswith("V twin")}
    turn = np.linspace(0.0, 2.0 * np.pi, 400_000, endpoint=False)
    speed, throw, rod, mass = 7000.0 * np.pi / 30.0, 0.036, 0.13, 0.4
    force = np.zeros((2, len(turn)))
    orders = {n: np.zeros((2, len(turn))) for n in (2, 4, 6)}
    textbook = np.zeros((2, len(turn)))
    for bank in (-np.pi / 4.0, np.pi / 4.0):
        along = np.array([np.cos(bank), np.sin(bank)])[:, None]
        crank = turn - bank
        place = throw * np.cos(crank) + np.sqrt(rod**2 - (throw * np.sin(crank)) ** 2)
        waves = np.fft.rfft(place) * -(np.arange(len(turn) // 2 + 1) ** 2)
        waves[60:] = 0.0  # rounding
        force -= mass * speed**2 * np.fft.irfft(waves, len(turn)) * along
        for n, total in orders.items():
            total -= mass * speed**2 * np.fft.irfft(waves * (np.arange(len(waves)) <= n), len(turn)) * along
        textbook += mass * speed**2 * throw * (np.cos(crank) + throw / rod * np.cos(2.0 * crank)) * along
    weight = 0.5 * 2.0 * mass * throw * speed**2 * np.array([np.cos(turn), np.sin(turn)])  # half of both, opposite
    true = np.hypot(*(force - weight)).max()
    for name, total in {"textbook": textbook, **{f"{n} orders": one for n, one in orders.items()}}.items():
        (row,) = rows[f"V twin, {name}"]()
        assert row.kinds == ("turn", "series")
        assert row.value_error == pytest.approx(abs(np.hypot(*(total - weight)).max() / true - 1.0), rel=1e-3, abs=1e-9)


def test_rival_that_is_not_installed_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vibopt.charts.balancing_rivals.hsbalance.installed", lambda: False)
    monkeypatch.setattr("vibopt.charts.balancing_cases.installed", lambda: False)
    trial = tried(STOCK[0], "hsbalance", 3)
    assert (trial.status, trial.claim, trial.verdict) == (MISSING, "pip install hsbalance==0.5.5", MISSING)
    result = charted(hard(quick=True))
    monkeypatch.setattr(runner, "stability", lambda **_: result)
    run = CliRunner().invoke(chart, ["stability", "--family", "balancing", "--quick"], standalone_mode=False)
    assert run.return_value == 5
    assert "hsbalance is not installed: pip install hsbalance==0.5.5" in run.output
    run = CliRunner().invoke(chart, ["stability", "--family", "balancing", "--quick", "--json"], standalone_mode=False)
    assert json.loads(run.output)["counts"]["units"]["hsbalance"] == {MISSING: 4}


def test_rival_that_returns_a_wrong_answer_is_silently_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    """A stand-in for hsbalance: its weights are taken as claimed, however they came about."""

    def nothing_fitted(y0: ComplexArray, H: ComplexArray, caps: FloatArray, *, clarabel: bool) -> SimpleNamespace:
        return SimpleNamespace(worst=lambda: np.zeros(H.shape[1], dtype=complex), least_squares=None, huber=None)

    monkeypatch.setattr(hsbalance, "installed", lambda: True)
    monkeypatch.setattr(hsbalance, "Model", nothing_fitted)
    trial = tried(STOCK[1], "hsbalance", 1)
    assert trial.verdict == SILENT
    assert trial.fault.startswith("goal off by")


@pytest.mark.skipif(not hsbalance.installed(), reason=hsbalance.HOW)
def test_hsbalance_is_right_on_small_questions_and_wrong_where_its_models_are() -> None:
    small = {one.case.name: one for one in (*STOCK, *HARD)}
    assert {tried(small[f"{name}, 8x2"], "hsbalance", 1).verdict for name in ("least squares", "worst with caps")} == {
        RIGHT
    }
    assert tried(small["critical sensors"], "hsbalance", 1).verdict == SILENT
    assert tried(small["critical sensors, caps of 10"], "hsbalance", 1).verdict == RIGHT
    assert tried(small["one of 8 readings spoilt"], "hsbalance (Clarabel)", 1).verdict == SILENT


def test_what_a_solver_prints_of_its_own_accord_does_not_reach_our_output(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """HiGHS writes a line behind Python's back, in front of the JSON of a chart."""

    def talks(*_: object, **__: object) -> SimpleNamespace:
        os.write(1, b"HighsMipSolverData\n")
        return SimpleNamespace(x=None, message="no end")

    monkeypatch.setattr("scipy.optimize.milp", talks)
    trial = tried(next(one for one in STOCK if one.question.is_discrete), "milp 8", 1)
    assert (trial.status, trial.claim) == ("unproven", "no end")
    print("ours")
    assert capfd.readouterr().out == "ours\n"


def test_families_given_to_other_methods_have_a_panel_of_their_own() -> None:
    found = {("thin set", "vibopt"): [RIGHT] * 2, ("thin set", "grid"): [SILENT] * 2}
    found |= {("units", "vibopt"): [RIGHT], ("units", "hsbalance"): [MISSING]}
    figure = stability_figure(["thin set", "units"], ["vibopt", "grid", "hsbalance"], found)
    texts = [[text.get_text() for text in axes.texts] for axes in figure.axes]
    assert texts == [["2", "2"], ["1", "not installed"]]


def test_stock_is_of_the_sizes_it_names_and_hard_ground_has_all_families() -> None:
    sizes = [one.question.H.shape for one in STOCK[: 2 * len(QUICK_SIZES) : 2]]
    assert sizes == list(QUICK_SIZES)
    assert len({one.case.name for one in HARD}) == len(HARD)
    table = hard(quick=True)
    assert Chart(tuple(case for case, _ in table.cases), (), ()).families == list(
        dict.fromkeys(one.case.family for one in HARD)
    )
