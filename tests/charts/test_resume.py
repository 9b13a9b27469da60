"""A chart that was stopped goes on where it was, and ends as if it had never been stopped."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import click
import pytest
from click.testing import CliRunner, Result

from vibopt.charts import cost as cost_chart
from vibopt.charts import isolation_cases, runner
from vibopt.charts.trial import DEFAULT, Table, Trial
from vibopt.cli.chart_command import chart
from vibopt.cli.output import kept_words, note_kept
from vibopt.errors import InputError
from vibopt.files.marks import is_ours

METHODS = (DEFAULT, "slsqp 50", "grid 5", "cvxpy 1e-08")
TIMED = ("seconds", "kernel", "quartiles", "ratio", "conditions")


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What is run: two small cases, four methods, without warming up."""
    monkeypatch.setattr(isolation_cases, "QUICK", isolation_cases.STOCK[:2])
    monkeypatch.setattr(isolation_cases, "QUICK_METHODS", METHODS)
    monkeypatch.setattr(isolation_cases, "QUICK_RUNS", 1)
    monkeypatch.setattr(isolation_cases, "WARM", ())
    found: list[str] = []
    whole = Table.tried

    def tried(table: Table, case: Any, given: Any, method: str, runs: int | None = None) -> Trial:
        if stop.at == len(found):
            stop.at = -1
            raise KeyboardInterrupt
        found.append(f"{case.name}: {method}")
        return whole(table, case, given, method, runs)

    stop.at = -1
    monkeypatch.setattr(Table, "tried", tried)
    return found


class stop:  # noqa: N801
    """Before which run the user stops the chart."""

    at = -1


def run(*words: str) -> Result:
    note_kept("")
    return CliRunner().invoke(
        chart, ["speed-accuracy", "--family", "isolation", "--quick", *words], standalone_mode=False
    )


def untimed(figure: Path) -> Any:
    def without(given: Any) -> Any:
        if isinstance(given, dict):
            return {key: without(one) for key, one in given.items() if key not in (*TIMED, "vibopt")}
        return [without(one) for one in given] if isinstance(given, list) else given

    return without(json.loads(figure.with_suffix(".json").read_text()))


@pytest.mark.parametrize("at", [1, pytest.param(5, marks=pytest.mark.slow)])
def test_a_chart_that_was_stopped_ends_as_one_that_was_not(asked: list[str], tmp_path: Path, at: int) -> None:
    whole, parted = tmp_path / "whole.svg", tmp_path / "parted.svg"
    assert run("--figure", str(whole)).return_value == 5
    every = [*asked]
    assert len(every) == 8
    asked.clear()
    stop.at = at
    stopped = run("--figure", str(parted))
    assert isinstance(stopped.exception, click.Abort)
    counted = f"{at} run{'s' * (at > 1)}"
    assert kept_words() == f"{parted}.runs holds {counted}; the same command with --resume goes on."
    assert (asked, parted.exists()) == (every[:at], False)
    lines = Path(f"{parted}.runs").read_text()
    Path(f"{parted}.runs").write_text(lines + '["cut by a kill')  # a last line that is not whole is run again
    asked.clear()
    assert run("--figure", str(parted), "--resume").return_value == 5
    assert asked == every[at:]
    assert untimed(parted) == untimed(whole)
    assert not Path(f"{parted}.runs").exists()
    kept = [json.loads(line) for line in lines.splitlines()[1:]]
    trials = json.loads(parted.with_suffix(".json").read_text())["trials"]
    again = {(one["case"], one["method"]): one["seconds"] for one in trials}
    assert [again[row["case"], row["method"]] for _, (row,) in kept] == [
        None if math.isnan(row["seconds"]) else row["seconds"] for _, (row,) in kept
    ]


def test_what_cannot_go_on_says_so(asked: list[str], tmp_path: Path) -> None:
    figure = tmp_path / "c.svg"
    journal = f"{figure}.runs"

    def said(*words: str) -> str:
        found = run(*words)
        assert isinstance(found.exception, InputError)
        return str(found.exception)

    assert said("--resume") == "--resume goes on with the runs beside a --figure FILE. Name it."
    begin = f"--resume: there is no {journal} to go on with. Leave --resume out to begin."
    assert said("--figure", str(figure), "--resume") == begin
    stop.at = 2
    run("--figure", str(figure))
    other = (
        f"--resume: {journal} is of another chart, other options, another machine or another version of vibopt. Leave "
        "--resume out to begin anew."
    )
    assert said("--figure", str(figure), "--resume", "--time-limit", "50") == other
    Path(journal).write_text("mine\n")
    foreign = f"{journal} cannot be written: it is there already, and vibopt did not write it. Name another --figure."
    assert said("--figure", str(figure)) == foreign
    stop.at = 0
    asked.clear()
    run()
    assert kept_words() == "No run was kept: with --figure FILE each is written as it comes."


def test_every_chart_that_is_quick_lists_what_it_leaves_out_and_ends_with_5(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(cost_chart, "LADDERS", {"limits": ((2, 4), (2,), cost_chart.LADDERS["limits"][2])})
    figure = tmp_path / "cost.svg"
    for _ in range(2):  # over its own files
        told = CliRunner().invoke(chart, ["cost", "--quick", "--figure", str(figure)], standalone_mode=False)
        assert told.return_value == 5
        assert "Asked without --quick only: limits of 4; 5 runs instead of 3." in told.output
    assert is_ours(figure.with_suffix(".csv").read_bytes())
    assert json.loads(figure.with_suffix(".json").read_text())["left"] == ["limits of 4", "5 runs instead of 3"]
    monkeypatch.setattr(runner, "fidelity", lambda *_, **__: ())
    told = CliRunner().invoke(chart, ["fidelity", "--family", "balancing", "--quick"], standalone_mode=False)
    assert told.return_value == 5
    left = (
        "Asked without --quick only: cases rotor, 8 planes, rotor, 8 sensors, rotor, 3 speeds, rotor, 96 speeds; "
        "further runs of each."
    )
    assert left in " ".join(told.output.split())
