"""The charts: references by mpmath, fair verdicts, and a default that is never silently wrong."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from click.testing import CliRunner

from vibopt.charts.accuracy_figure import Dot, Scatter, accuracy_figure
from vibopt.charts.chart_figures import LOOKS, fidelity_figure, stability_figure
from vibopt.charts.fidelity import Fidelity, on_both_models
from vibopt.charts.isolation_cases import METHODS as CHARTED
from vibopt.charts.isolation_cases import STOCK, ends_of, families, hidden_peak, on_the_edge, slivers
from vibopt.charts.machines import fan, hall, press, star
from vibopt.charts.own_scenes import referenced
from vibopt.charts.random_cases import drawn
from vibopt.charts.scene_rivals import RIVALS
from vibopt.charts.trial import DEFAULT, Case, Said, judged, trial
from vibopt.charts.verdicts import FEASIBLE, INFEASIBLE, MISSING, REFUSES, RIGHT, SAYS_SO, SILENT, UNPROVEN
from vibopt.cli.answer_cache import Asked
from vibopt.cli.options import read_job
from vibopt.cli.solve_command import solve as solve_command
from vibopt.program.pose import pose
from vibopt.report.figures import saved
from vibopt.solve.by_name import METHODS, OWN
from vibopt.solve.rivals import population
from vibopt.solve.rivals.grid import Grid

DIGITS = 40


def stack(count: int, k: Any, c: Any, w: Any) -> tuple[Any, Any]:
    """Motion of the machine and force on the floor per newton, of `chain(count)`, in many digits."""
    masses = [mp.mpf(100)] + [mp.mpf(60)] * (count - 1)
    links = [(mp.mpf(10 * count) * 10**6, mp.mpf(2000))] * (count - 1) + [(k, c)]
    return _solved(masses, links, w)


def _solved(masses: list[Any], links: list[tuple[Any, Any]], w: Any) -> tuple[Any, Any]:
    """From the lowest mass up: what each wants for a motion of one, and what of it comes from the mass above."""
    below, share = 0, mp.mpf(1)
    for mass, (k, c) in zip(masses[::-1], links[::-1], strict=True):
        z = k + 1j * w * c
        under = z if below == 0 else z * below / (z + below)
        share *= 1 if below == 0 else z / (z + below)
        below = under - mass * w * w
    return 1 / below, share * (links[-1][0] + 1j * w * links[-1][1]) / below


def corner(
    respond: Callable[[Any, Any, Any], tuple[Any, Any]],
    force: float,
    floor: float,
    motion: str,
    speed: Any,
    near: tuple[float, ...],
) -> Any:
    """Stiffness where the floor gets `floor` at `speed` and the highest peak on the way up is `motion`."""

    def misses(log_k: Any, log_c: Any, log_w: Any) -> list[Any]:
        k, c = mp.exp(log_k), mp.exp(log_c)

        def peak(log: Any) -> Any:
            return mp.log(abs(respond(k, c, mp.exp(log))[0]) * force / mp.mpf(motion))

        return [mp.log(abs(respond(k, c, speed)[1]) * force / floor), peak(log_w), mp.diff(peak, log_w)]

    return mp.exp(mp.findroot(misses, [mp.log(one) for one in near], tol=1e-50)[0])


def reference(name: str) -> float:
    return next(case.goal for case in STOCK if case.name == name)


def test_reference_of_the_fan_is_its_closed_form() -> None:
    with mp.workdps(DIGITS):
        best = 90 * (50 * mp.pi) ** 2 * mp.mpf("0.2") / mp.mpf("1.2")
    assert reference("fan, k") == pytest.approx(float(best), rel=1e-15)


def test_reference_of_the_press_solves_the_equations_of_its_corner() -> None:
    with mp.workdps(DIGITS):

        def respond(k: Any, c: Any, w: Any) -> tuple[Any, Any]:
            return _solved([mp.mpf(300)], [(k, c)], w)

        best = corner(respond, 30000, 10000, "0.02", 100 * mp.pi, (6956917, 9908, 150.4))
    assert reference("press, k and c") == pytest.approx(float(best), rel=1e-15)


def test_reference_of_the_unbalanced_press_is_its_closed_form() -> None:
    with mp.workdps(DIGITS):
        m, force, floor, w = mp.mpf(300), mp.mpf(30000), mp.mpf(10000), 100 * mp.pi
        ratio = force / (m * w**2 * mp.mpf("0.02"))
        q_over_k = 2 * m * (1 - mp.sqrt(1 - ratio**2))
        a = force**2 - floor**2
        b = a * w**2 * q_over_k + 2 * floor**2 * m * w**2
        best = (-b + mp.sqrt(b * b + 4 * a * floor**2 * m**2 * w**4)) / (2 * a)
    assert reference("press with unbalance, k and c") == pytest.approx(float(best), rel=1e-15)


@pytest.mark.parametrize(
    ("count", "floor", "motion", "near"),
    [
        (2, 400, "0.01", (1102942.84, 1303.02, 81.95)),
        (5, 300, "0.004", (1727991.4, 4189.4, 69.16)),
        (20, 300, "0.002", (4883895.29, 13428.32, 58.0)),
    ],
)
def test_references_of_the_chains_solve_the_equations_of_their_corners(
    count: int, floor: int, motion: str, near: tuple[float, ...]
) -> None:
    with mp.workdps(DIGITS):
        best = corner(lambda k, c, w: stack(count, k, c, w), 1000, floor, motion, 50 * mp.pi, near)
    assert reference(f"{count} bodies, k and c") == pytest.approx(float(best), rel=1e-15)


def test_reference_of_the_block_has_the_floor_at_its_limit() -> None:
    with mp.workdps(DIGITS):
        w = 100 * mp.pi

        def floor(k: Any) -> Any:
            links = [(mp.mpf(10) ** 7, mp.mpf(10) ** 5), (k, mp.mpf(500))]
            return abs(_solved([mp.mpf(100), mp.mpf(400)], links, w)[1]) * 1000 - 200

        k = mp.findroot(floor, 7920505.5, tol=1e-50)
        best = mp.mpf("9.80665") * (100 / mp.mpf(10) ** 7 + 500 / k)
    assert reference("2 bodies, 3 unknowns") == pytest.approx(float(best), rel=1e-15)


@pytest.mark.parametrize("case", STOCK, ids=lambda case: case.name)
def test_default_has_the_reference_of_every_stock_scene(case: Case) -> None:
    one = trial(case, case.scene(), DEFAULT, 1)
    assert one.verdict == RIGHT
    assert one.error < 1e-8


@pytest.mark.parametrize("case", ends_of(families()), ids=lambda case: case.name)
def test_default_is_never_silently_wrong_on_hard_ground(case: Case) -> None:
    one = trial(case, case.scene(), DEFAULT, 1)
    assert one.verdict in (RIGHT, SAYS_SO)


@pytest.mark.slow
@pytest.mark.parametrize("case", families(), ids=lambda case: case.name)
def test_own_methods_are_never_silently_wrong_on_hard_ground(case: Case) -> None:
    scene = case.scene()
    for method in (DEFAULT, *OWN):
        assert trial(case, scene, method, 1).verdict != SILENT


HEAVY = pytest.mark.slow
"""Ten unknowns: the general method is what the default takes there anyway."""


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    "case",
    [pytest.param(case, marks=HEAVY if "10 unknowns" in case.name else ()) for case in ends_of(families())],
    ids=[case.name for case in ends_of(families())],
)
def test_general_method_is_never_silently_wrong_on_hard_ground(case: Case) -> None:
    assert trial(case, case.scene(), "nlp", 1).verdict in (RIGHT, SAYS_SO)


@pytest.mark.parametrize(
    ("status", "goal", "truth", "verdict"),
    [
        ("optimal", 1.0, FEASIBLE, RIGHT),
        ("optimal", 0.9, FEASIBLE, SILENT),
        ("optimal", 1.0 - 1e-4, FEASIBLE, SILENT),
        ("feasible", 0.9, FEASIBLE, UNPROVEN),
        ("feasible", 1.0 - 1e-4, FEASIBLE, RIGHT),
        ("feasible", 1.1, FEASIBLE, SILENT),
        ("feasible", 1.1, INFEASIBLE, SILENT),
        ("infeasible", None, FEASIBLE, SILENT),
        ("infeasible", None, INFEASIBLE, RIGHT),
        ("unproven", None, FEASIBLE, SAYS_SO),
        ("check_failed", 1.1, FEASIBLE, SAYS_SO),
    ],
)
def test_verdict_is_by_what_is_claimed_and_what_is_true(
    monkeypatch: pytest.MonkeyPatch, status: str, goal: float | None, truth: str, verdict: str
) -> None:
    """The fan's stiffness as a part of the best: less is a worse goal, more breaks the limit."""
    best = reference("fan, k")
    x = None if goal is None else np.array([best * goal])
    monkeypatch.setattr("vibopt.charts.trial.said_of", lambda *_: Said(status, "", x))
    case = Case("fan", fan(), truth, best, "closed form")
    assert trial(case, case.scene(), "grid", 1).verdict == verdict


@pytest.mark.parametrize(
    ("said", "missed", "off", "verdict"),
    [
        (Said("feasible", "", within=1e-4), 1e-5, 0.0, UNPROVEN),
        (Said("feasible", "", within=1e-6), 1e-5, 0.0, SILENT),
        (Said("optimal", "", within=1e-3), 0.0, 1e-4, UNPROVEN),
        (Said("optimal", "", past=1e-3), 0.0, 0.0, SILENT),
        (Said("optimal", "", past=1e-7), 0.0, 0.0, RIGHT),
    ],
)
def test_what_an_answer_says_of_its_own_digits_and_bound_is_judged(
    said: Said, missed: float, off: float, verdict: str
) -> None:
    assert judged(STOCK[0], "x", said, missed, off).verdict == verdict


def test_a_bound_beyond_the_best_is_silently_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    """The fan's stiffness is maximised: minus the goal is bounded from below."""
    case = STOCK[0]
    for part, verdict in ((1.0 - 1e-3, SILENT), (1.0 + 1e-3, RIGHT)):
        said = Said("optimal", "", np.array([case.goal]), bound=-case.goal * part)
        monkeypatch.setattr("vibopt.charts.trial.said_of", lambda *_, said=said: said)
        assert trial(case, case.scene(), "grid", 1).verdict == verdict


@pytest.mark.parametrize(
    "name",
    [
        "evolution 1000",
        pytest.param("cma-es 1000", marks=pytest.mark.skipif(not population.installed(), reason=population.HOW)),
    ],
)
def test_methods_that_only_compare_come_near_the_best_without_breaking_a_limit(name: str) -> None:
    one = trial(STOCK[1], STOCK[1].scene(), name, 1)
    assert (one.status, one.missed <= 1e-9, one.off < 2e-3) == ("feasible", True, True)


def test_a_rival_whose_package_is_not_there_is_shown_as_absent(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vibopt.charts.scene_rivals.population.installed", lambda: False)
    one = trial(STOCK[0], STOCK[0].scene(), "cma-es 100", 1)
    assert (one.status, one.verdict, one.claim) == (MISSING, MISSING, "pip install cma")


def test_every_charted_method_is_registered_and_says_what_it_is() -> None:
    assert set(CHARTED) - {DEFAULT} <= {*METHODS, *RIVALS}
    for name, make in (*METHODS.items(), *RIVALS.items()):
        method = make()
        assert method.name == name
        assert method.summary


def test_sampled_speeds_step_over_a_sharp_peak_and_claim_success() -> None:
    case = hidden_peak()[-1]
    scene = case.scene()
    assert trial(case, scene, "slsqp 200", 1).fault == "limit broken without end"
    assert trial(case, scene, "nlp", 1).verdict == RIGHT


def test_rivals_get_within_their_sampling_of_the_press() -> None:
    """They are set up well: what is left of their error is the grid of speeds."""
    case = STOCK[1]
    scene = case.scene()
    names = (
        "slsqp 200",
        "slsqp 500",
        "slsqp 1000",
        "slsqp exchange 1e-11",
        "slsqp peaks 1e-11",
        "ipopt 200",
        "cvxpy 1e-08",
    )
    trials = {name: trial(case, scene, name, 1) for name in names}
    errors = {name: one.error for name, one in trials.items()}
    assert max(errors["slsqp exchange 1e-11"], errors["slsqp peaks 1e-11"]) < 1e-8
    assert max(errors["slsqp 200"], errors["ipopt 200"]) < 1e-3
    fine = [one for name in ("slsqp 500", "slsqp 1000") if math.isfinite(one := errors[name])]
    assert fine, "SLSQP may give up one of them by rounding, and says so, but not both"
    assert max(fine) < 1e-4
    assert errors["cvxpy 1e-08"] < 1e-6


def test_convex_rival_refuses_what_is_not_convex_in_a_sentence() -> None:
    refusal = METHODS["cvxpy_sampled"]().refuses(pose(STOCK[3].scene()))
    assert refusal == (
        "cvxpy_sampled takes one mass on one mount where it is convex: this is more than one mass on one mount."
    )
    one = trial(STOCK[3], STOCK[3].scene(), "cvxpy 1e-08", 1)
    assert (one.status, one.verdict) == (REFUSES, REFUSES)


def test_slivers_have_both_truths_in_equal_number() -> None:
    truths = [case.truth for case in (*slivers(), *on_the_edge())]
    assert truths.count(FEASIBLE) == truths.count(INFEASIBLE)


def test_users_scene_gets_a_proven_reference() -> None:
    from vibopt.scene.read import from_text

    case = referenced(from_text(press(), name="mine.toml"))
    assert case.name == "mine"
    assert case.goal == pytest.approx(reference("press, k and c"), rel=1e-8)
    assert case.known_by.startswith("branch and bound, proven to")


def test_smaller_models_are_exact() -> None:
    from vibopt.scene.read import from_text

    scenes = [from_text(star(4), name="star"), from_text(hall(5), name="hall")]
    rows = [row for _, make in on_both_models(scenes, quick=True) for row in make()]
    assert [(row.declared, row.used) for row in rows] == [(5, 2), (5, 1)]
    assert max(row.value_error for row in rows) < 1e-10
    assert max(row.goal_error for row in rows) < 1e-6


def test_the_whole_model_is_answered_where_it_is_asked_for(tmp_path: Path) -> None:
    """The same stiffness, and no freedom left out; an answer that is kept is not that of the other model."""
    file = tmp_path / "hall.toml"
    file.write_text(hall(5))
    found = []
    for words in ((), ("--fidelity", "full")):
        told = CliRunner().invoke(solve_command, [str(file), "--no-prices", "--json", *words], standalone_mode=False)
        found.append(json.loads(told.output))
    assert [one["model"]["used_dof"] for one in found] == [1, 5]
    assert found[1]["model"]["why"] == "no freedom was to be left out"
    assert found[0]["goal"]["value"] == pytest.approx(found[1]["goal"]["value"], rel=1e-9)
    asked = [Asked(str(file), read_job(str(file), ()), whole=whole).key("answer") for whole in (False, True)]
    assert asked[0] != asked[1]


def test_a_rotor_has_no_freedoms_to_leave_out() -> None:
    file = "problems/balancing/assignment_1.toml"
    told = CliRunner().invoke(solve_command, [file, "--fidelity", "full"])
    assert str(told.exception) == (
        f"{file}: --fidelity full is of machines, whose models leave freedoms out that nothing needs; a measured "
        "rotor has none. Leave it out."
    )


def test_each_class_has_its_mark_and_a_rival_its_name_at_its_finest_setting() -> None:
    dots = (
        Dot("vibopt", 1.0, 1e-15, RIGHT, 0.25, middle=(0.9, 1.2)), Dot("slsqp 50", 3.0, 1e-3, SILENT, line="slsqp"),
        Dot("slsqp 200", 4.0, 1e-2, UNPROVEN, line="slsqp"),
    )  # fmt: skip
    figure = accuracy_figure([Scatter("press", 0.01, dots, ("grid",))], "vibopt")
    marks = [line for line in figure.axes[0].lines if line.get_marker() in "oD^X"]
    assert [mark.get_marker() for mark in marks] == ["D", "X", "^"]
    assert [mark.get_markerfacecolor() for mark in marks[1:]] == [LOOKS[SILENT][0], LOOKS[UNPROVEN][0]]
    assert {text.get_text() for text in figure.axes[0].texts} == {
        "vibopt: 10 ms\nno design: grid", "vibopt", "slsqp",
    }  # fmt: skip
    assert [float(mark.get_xdata()[0]) for mark in marks] == [1.0, 3.0, 4.0]
    kernels = [line for line in figure.axes[0].lines if line.get_marker() == "|"]
    assert [float(mark.get_xdata()[0]) for mark in kernels] == [0.25]
    assert saved(figure, "svg").startswith(b"<?xml")


def test_figures_of_stability_and_fidelity_are_drawn() -> None:
    found = {("thin set", "vibopt"): [RIGHT, RIGHT, SILENT, RIGHT], ("thin set", "grid"): []}
    figure = stability_figure(["thin set"], ["vibopt", "grid"], found)
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert texts == ["2", "1", "1", "not asked"]
    hall = Fidelity("hall", 5, 1, "", 1.0, 20.0, 1.0, math.nan, 0.0, math.nan)
    passage = Fidelity("passage", 0, 0, "", 1.0, 300.0, 1.0, math.nan, 0.4, math.nan, kinds=("passage", "steady"))
    for rows in ([hall, passage], [passage]):
        figure = fidelity_figure(rows)
        assert [text.get_text() for text in figure.axes[0].texts] == ["5 → 1", "passage → steady"][-len(rows) :]
        assert saved(figure, "svg").startswith(b"<?xml")


def test_a_grid_refuses_what_takes_minutes() -> None:
    """40 values of each of four numbers: two and a half million points."""
    scene = drawn("absorbers", 2, 1)[0].scene()
    assert len(scene.variables) == 4
    assert Grid(per_axis=40).refuses(pose(scene)) == (
        "grid takes at most 100000 points, and 40 of each number are 2560000."
    )
