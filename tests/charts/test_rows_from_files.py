"""Any row of a chart can be asked again from its data alone: the files of its question are whole jobs."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from vibopt.answer.jsonable import json_text
from vibopt.charts import random_cases, runner
from vibopt.charts.chart_views import accuracy_json, profiles_json, stability_json
from vibopt.charts.mount_cases import UNANSWERABLE
from vibopt.charts.profiles import Profiles
from vibopt.charts.runner import charted
from vibopt.charts.trial import JOB, Table
from vibopt.cli.main import main

KNOWN = ("balancing", "weights", "mounts", "shock", "run_up", "friction")
"""Families whose truth no method of a chart says."""


def written(case: dict[str, Any], folder: Path) -> Path:
    """The job of a case as its data have it."""
    for name, text in {JOB: case["text"], **case["beside"]}.items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder / JOB


def answered(case: dict[str, Any], folder: Path, capsys: pytest.CaptureFixture[str]) -> float:
    """The goal, or the one number that is measured, as `vibopt solve` says it."""
    assert main(["solve", str(written(case, folder)), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    return float((told["goal"] or told["measures"]["greatest"])["value"])


@pytest.mark.parametrize("family", random_cases.DRAWN)
def test_a_random_question_is_answered_from_the_data_of_its_chart(
    family: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = random_cases.table(family, random_cases.drawn(family, 77, 1), quick=True)
    made = charted(replace(table, methods={}, warm=()))
    (case,) = json.loads(json_text(profiles_json(Profiles(77, 1, {family: made}))))["cases"]
    if family in KNOWN:
        assert answered(case, tmp_path, capsys) == pytest.approx(case["goal"], rel=1e-9, abs=0.0)
    else:
        assert main(["check", str(written(case, tmp_path))]) == 0


@pytest.mark.parametrize("family", ["isolation", "absorbers", "balancing", "mounts"])
def test_every_case_of_a_chart_has_its_file(family: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Each reads without a mistake, but mounts whose mistake is what is asked."""

    def unasked(table: Table, *_: Any) -> Any:
        return charted(replace(table, methods={}, warm=()))

    monkeypatch.setattr(runner, "charted", unasked)
    data = [
        accuracy_json(runner.speed_accuracy(family=family, quick=True)),
        stability_json(runner.stability(family=family, quick=True)),
    ]
    for case in (one for part in data for one in json.loads(json_text(part))["cases"]):
        amiss = case["truth"] == UNANSWERABLE or case["family"] in ("no inertia", "uplift")
        large = len(case["text"]) > 1_000_000  # read elsewhere
        assert case["text"]
        assert amiss or large or main(["check", str(written(case, tmp_path))]) == 0, case["name"]
