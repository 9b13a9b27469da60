"""What a chart promises: vibopt first and on every case, the same lists on every machine, and exit 5 for less."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import pytest
from click.testing import CliRunner, Result
from hypothesis import given
from hypothesis import strategies as st

from vibopt.charts import absorber_cases, isolation_cases, runner
from vibopt.charts.balancing_cases import hard as balancing_hard
from vibopt.charts.balancing_cases import speed as balancing_speed
from vibopt.charts.fidelity import Fidelity
from vibopt.charts.isolation_cases import STOCK, WARM
from vibopt.charts.mount_rivals import METHODS as MOUNT_METHODS
from vibopt.charts.runner import FAMILIES, Chart, charted
from vibopt.charts.trial import DEFAULT, Case, Said, Table, Trial, judged, timed, trial
from vibopt.charts.verdicts import FEASIBLE, REFUSES, RIGHT
from vibopt.cli.chart_command import chart

FAN = STOCK[0]


def answered(case: Case, method: str, cut: str = "") -> Trial:
    return judged(case, method, Said("optimal", "", seconds=1.0, kernel=0.5, cut=cut), 0.0, 0.0)


def run(*words: str) -> Result:
    return CliRunner().invoke(chart, list(words), standalone_mode=False)


@given(
    names=st.lists(st.text("abc", min_size=1), unique=True, max_size=5),
    methods=st.lists(st.sampled_from(["grid", DEFAULT, "nlp", "slsqp"]), unique=True, max_size=4),
)
def test_every_case_has_a_row_of_every_method_and_vibopt_is_asked_first(names: list[str], methods: list[str]) -> None:
    asked: list[tuple[str, str]] = []

    def by(method: str) -> Any:
        def said(name: str) -> Said:
            asked.append((name, method))
            return Said("optimal", "", seconds=1.0)

        return said

    def judge(case: Case, given: str, method: str, said: Said) -> Trial:
        return judged(case, method, said, 0.0, 0.0)

    cases = [(replace(FAN, name=name), name) for name in names]
    rows = charted(Table(cases, {method: by(method) for method in methods}, judge)).trials
    assert [(one.case, one.method) for one in rows] == [(name, method) for name in names for method in methods]
    own = len(names) if DEFAULT in methods else 0
    assert all(method == DEFAULT for _, method in asked[:own])
    assert all(method != DEFAULT for _, method in asked[own:])


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("chart_of", [runner.speed_accuracy, runner.stability])
def test_quick_charts_have_a_row_of_vibopt_for_every_case(
    monkeypatch: pytest.MonkeyPatch, family: str, chart_of: Any
) -> None:
    """The same list each time, and every rival on every case: which runs are done hangs on nothing but the list."""
    asked: list[tuple[str, str]] = []

    def tried(table: Table, case: Case, given: Any, method: str, runs: int | None = None) -> Trial:
        asked.append((case.name, method))
        return answered(case, method)

    monkeypatch.setattr(Table, "tried", tried)
    result = chart_of(family=family, quick=True)
    cases = [case.name for case in result.cases]
    assert [one.case for one in result.trials if one.method == DEFAULT] == cases
    assert len(result.trials) == len(cases) * len(result.methods)
    assert asked[-len(result.trials) :][: len(cases)] == [(name, DEFAULT) for name in cases]
    assert result.cut == ()


def test_rivals_of_every_family_are_the_strongest_by_hand() -> None:
    for quick in (True, False):
        methods = isolation_cases.QUICK_METHODS if quick else isolation_cases.METHODS
        assert "slsqp exchange 1e-11" in methods
        assert "slsqp peaks 8 starts 1e-09" in methods
        assert {"slsqp exchange 1e-11", "slsqp peaks 8 starts 1e-09", "equal_peaks"} <= set(
            absorber_cases.taking(methods)
        )
        for table in (balancing_speed, balancing_hard):
            assert "pruned" in table(quick=quick).methods
        assert "cheapest first" in FAMILIES["mounts"].speed(quick=True).methods
    assert "highs exchange" in MOUNT_METHODS


def test_a_run_that_the_time_limit_ends_is_shown_and_ends_the_chart_with_5(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(isolation_cases, "QUICK", (FAN,))
    monkeypatch.setattr(isolation_cases, "QUICK_METHODS", (DEFAULT, "grid"))
    told = run("speed-accuracy", "--family", "isolation", "--quick", "--time-limit", "1e-9")
    assert told.return_value == 5
    words = "Less was asked than this chart promises, in 1 of 2 runs:\n  grid on fan, k: the time limit of 1e-09 s"
    assert words in told.output
    assert [line.split()[0] for line in told.output.splitlines() if line.startswith("  vibopt ")] == [DEFAULT]
    data = json.loads(
        run("speed-accuracy", "--family", "isolation", "--quick", "--time-limit", "1e-9", "--json").output
    )
    assert [(one["method"], bool(one["cut"])) for one in data["trials"]] == [(DEFAULT, False), ("grid", True)]
    whole = run("speed-accuracy", "--family", "isolation", "--quick")
    assert whole.return_value == 5  # --quick leaves out
    assert "Less was asked" not in whole.output
    words = " ".join(whole.output.split())
    assert "Asked without --quick only: cases press, k and c, press with unbalance, k and c, 2 bodies" in words


def test_stability_that_was_asked_less_ends_with_5(monkeypatch: pytest.MonkeyPatch) -> None:
    cut = "the time limit of 1 s ended it after 7 boxes"
    case = replace(FAN, family="thin set")
    made = Chart((case,), (DEFAULT, "nlp"), (answered(case, DEFAULT), answered(case, "nlp", cut)))
    monkeypatch.setattr(runner, "stability", lambda **_: made)
    told = run("stability")
    assert told.return_value == 5
    assert f"Less was asked than this chart promises, in 1 of 2 runs:\n  nlp on fan, k: {cut}.\n" in told.output


def test_a_false_claim_of_vibopt_weighs_more_than_a_run_cut_short(monkeypatch: pytest.MonkeyPatch) -> None:
    wrong = judged(FAN, DEFAULT, Said("optimal", "", cut="short"), 1.0, 0.0)
    made = Chart((FAN,), (DEFAULT,), (wrong,))
    monkeypatch.setattr(runner, "stability", lambda **_: made)
    assert run("stability").return_value == 6


def test_fidelity_that_was_asked_less_ends_with_5(monkeypatch: pytest.MonkeyPatch) -> None:
    row = Fidelity("hall", 5, 1, "", 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, "full model: the time limit of 1 s ended it")
    monkeypatch.setattr(runner, "fidelity", lambda *_, **__: (row,))
    told = run("fidelity")
    assert told.return_value == 5
    assert "Less was asked than this chart promises: hall, full model: the time limit of 1 s ended it" in told.output


def test_the_kernel_is_a_part_of_the_time_and_the_answer_is_checked() -> None:
    one = trial(FAN, FAN.scene(), DEFAULT, 1)
    assert 0.0 < one.kernel < one.seconds
    assert "closed_form" in one.claim


def test_a_method_that_breaks_down_ends_its_own_trial_only() -> None:
    def breaks() -> Said:
        raise ArithmeticError("no digits left")

    said = timed(breaks, 3)
    assert (said.status, said.claim) == ("error", "ArithmeticError: no digits left")


@pytest.mark.parametrize("count", [1, pytest.param(5, marks=pytest.mark.slow)])
def test_newton_on_equal_peaks_is_exact_and_refuses_what_it_does_not_know(count: int) -> None:
    from vibopt.charts.absorber_cases import STOCK as ABSORBERS

    for case in ABSORBERS[:count]:
        one = trial(case, case.scene(), "equal_peaks", 1)
        assert (one.verdict, one.error < 1e-12) == (RIGHT, True)
    for case in (ABSORBERS[5], *WARM):
        one = trial(case, case.scene(), "equal_peaks", 1)
        assert one.status == REFUSES
        assert one.claim == (
            "equal_peaks takes absorbers on the one excited mass, for the least worst response, without limits."
        )


def test_exchange_is_as_exact_as_its_peaks_where_it_finds_the_best() -> None:
    from vibopt.charts.absorber_cases import STOCK as ABSORBERS

    for case in (*STOCK[:4], *ABSORBERS[:2]):
        one = trial(case, case.scene(), "slsqp exchange 1e-11", 1)
        assert (case.truth, one.status) == (FEASIBLE, "feasible")
        assert one.error < 1e-8


def test_pruned_enumeration_of_weights_finds_the_best_of_all() -> None:
    from vibopt.charts.balancing_questions import shelf

    table = balancing_speed(quick=True)
    for one in shelf():
        trial_of = table.tried(one.case, one, "pruned", 1)
        assert (trial_of.status, trial_of.error) == ("optimal", 0.0)
