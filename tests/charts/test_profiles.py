"""Random questions of the charts, the profiles over them, and the data beside a figure."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from vibopt.charts import profiles as made
from vibopt.charts import random_cases
from vibopt.charts.balancing_questions import Asked
from vibopt.charts.balancing_rivals import broken
from vibopt.charts.profiles import profiles, times
from vibopt.charts.runner import Chart
from vibopt.charts.trial import DEFAULT, Case, Said, Table, judged
from vibopt.charts.verdicts import FEASIBLE, RIGHT
from vibopt.cli.chart_command import chart
from vibopt.files.marks import is_ours


@pytest.mark.parametrize("family", random_cases.DRAWN)
def test_a_question_depends_on_its_seed_and_number_alone(family: str) -> None:
    few, many = random_cases.drawn(family, 7, 1), random_cases.drawn(family, 7, 2)
    other = random_cases.drawn(family, 8, 1)
    for one, same, different in zip(few, many, other, strict=False):
        assert shown(one) == shown(same) != shown(different)


def shown(one: Any) -> str:
    given = one.question.H.tolist() if isinstance(one, Asked) else one
    return repr(given).replace(" 7.", " ").replace(" 8.", " ")  # but for the seed in the name


STRONGEST = {
    **dict.fromkeys(("isolation", "absorbers", "several"), "slsqp exchange 1e-11"),
    "shafts": "slsqp extrapolated",
}
"""The rival by hand of each family whose best is not known by another road."""


@pytest.mark.parametrize("count", [1, pytest.param(20, marks=pytest.mark.slow)])
@pytest.mark.parametrize("family", random_cases.DRAWN)
def test_no_answer_of_vibopt_to_random_questions_is_wrong(
    monkeypatch: pytest.MonkeyPatch, family: str, count: int
) -> None:
    """Against the truth, or the strongest rival by hand, on questions that stand nowhere else."""

    def fewer(family: str, questions: Any, *, quick: bool) -> Table:
        whole = random_cases.table(family, questions, quick=quick)
        few = {name: whole.methods[name] for name in (DEFAULT, STRONGEST.get(family, DEFAULT))}
        return replace(whole, methods=few, warm=())

    monkeypatch.setattr(made, "table", fewer)
    (seen,) = profiles(family, seed=2026, count=count).charts.values()
    own = [one for one in seen.trials if one.method == DEFAULT]
    assert [(one.verdict, one.status == "infeasible" or one.error < 1e-6) for one in own] == [(RIGHT, True)] * count


@given(st.integers(0, 10**6))
def test_a_question_of_a_rotor_is_answered_by_the_correction_that_it_was_built_round(seed: int) -> None:
    """Least squares: no correction beside it leaves less."""
    one = random_cases.rotor(np.random.default_rng(seed), "")
    if one.question.goal == "rms":
        u = np.linalg.lstsq(one.question.H, -one.question.y0, rcond=None)[0]
        assert broken(one.question, u) == 0.0
        assert one.question.value(u) == pytest.approx(one.case.goal, rel=1e-9)


def test_a_profile_counts_an_answer_only_where_it_is_right() -> None:
    cases = tuple(Case(name, "", FEASIBLE, 1.0, "") for name in "ab")
    errors = {("a", "x"): 0.0, ("a", "y"): 1e-8, ("b", "x"): 1e-4, ("b", "y"): 1e-7}
    seconds = {("a", "x"): 2.0, ("a", "y"): 1.0, ("b", "x"): 1.0, ("b", "y"): 3.0}
    trials = [
        judged(case, method, Said("feasible", "", seconds=seconds[case.name, method]), 0.0, errors[case.name, method])
        for case in cases
        for method in "xy"
    ]
    seen = Chart(cases, ("x", "y"), tuple(trials))
    assert {method: row.tolist() for method, row in times(seen, 1e-6).items()} == {"x": [2.0, np.inf], "y": [1.0, 1.0]}
    assert {method: row.tolist() for method, row in times(seen, 1e-3).items()} == {"x": [2.0, 1.0], "y": [1.0, 3.0]}


def answered(verdict_of: dict[str, float]) -> made.Profiles:
    case = Case("isolation 1.0", "the text", FEASIBLE, 1.0, "", "isolation")
    trials = [judged(case, name, Said("optimal", "", seconds=1.0), missed, 0.0) for name, missed in verdict_of.items()]
    return made.Profiles(1, 1, {"isolation": Chart((case,), tuple(verdict_of), tuple(trials))})


def test_profiles_write_their_data_beside_the_figure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(made, "profiles", lambda *_, **__: answered({DEFAULT: 0.0, "slsqp": 1.0}))
    figure = tmp_path / "p.svg"
    told = CliRunner().invoke(chart, ["profiles", "--figure", str(figure)], standalone_mode=False)
    assert told.return_value == 0
    written = f"Written: {figure}, {figure.with_suffix('.json')}, {figure.with_suffix('.csv')}"
    assert written in told.output.replace("\n", " ").replace("  ", " ")
    data = json.loads(figure.with_suffix(".json").read_text())
    assert (data["chart"], data["seed"], data["cases"][0]["text"]) == ("profiles", 1, "the text")
    assert set(data["conditions"]) >= {"processor", "cores", "versions", "date"}
    rows = list(csv.DictReader(figure.with_suffix(".csv").read_text().splitlines()))
    assert [(one["chart"], one["method"], one["verdict"]) for one in rows] == [
        ("profiles", DEFAULT, "right"), ("profiles", "slsqp", "silently wrong"),
    ]  # fmt: skip
    assert all(is_ours(figure.with_suffix(ending).read_bytes()) for ending in (".svg", ".json", ".csv"))
    figure.with_suffix(".csv").write_text("mine\n")
    again = CliRunner().invoke(chart, ["profiles", "--figure", str(figure)])
    assert "vibopt did not write it" in str(again.exception)


def test_a_wrong_answer_of_vibopt_ends_profiles_with_6(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(made, "profiles", lambda *_, **__: answered({DEFAULT: 1.0}))
    assert CliRunner().invoke(chart, ["profiles"], standalone_mode=False).return_value == 6
