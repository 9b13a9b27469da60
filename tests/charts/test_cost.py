"""Cost against size: fitted exponents, the jump where a method changes, and ladders that answer what they say."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import t

from vibopt.charts import cost as made
from vibopt.charts.cost import LADDERS, Size, fits
from vibopt.charts.cost_views import draw_cost
from vibopt.cli.chart_command import chart


def row(size: int, seconds: float, method: str = "discs", cut: str = "") -> Size:
    return Size("bodies", size, seconds, 0, (seconds, seconds), 3, method, cut)


@given(st.floats(-1.0, 3.0), st.floats(1e-4, 10.0))
def test_a_power_of_the_size_is_found_with_an_interval_of_nothing(exponent: float, first: float) -> None:
    (line,) = fits(tuple(row(n, first * n**exponent) for n in (1, 2, 4, 8)))
    assert line.exponent == pytest.approx(exponent, abs=1e-9)
    assert line.half < 1e-6


def test_the_interval_is_that_of_the_normal_equations() -> None:
    sizes, seconds = np.array([1.0, 2.0, 4.0, 8.0]), np.array([1.0, 2.1, 3.7, 9.0])
    (line,) = fits(tuple(row(int(n), float(s)) for n, s in zip(sizes, seconds, strict=True)))
    table = np.column_stack([np.ones(4), np.log(sizes)])
    inverse = np.linalg.inv(table.T @ table)
    found = inverse @ table.T @ np.log(seconds)
    left = np.log(seconds) - table @ found
    half = t.ppf(0.975, 2) * np.sqrt(left @ left / 2 * inverse[1, 1])
    assert (line.exponent, line.half) == (pytest.approx(found[1]), pytest.approx(half))


def test_each_stretch_of_one_method_has_its_own_line_and_the_jump_is_drawn() -> None:
    sizes = (row(1, 1.0), row(2, 2.0), row(4, 400.0, "nlp"), row(8, 1600.0, "nlp"), row(16, 1.0, "grid"))
    lines = fits(sizes)
    assert [(one.method, one.sizes, round(one.exponent, 9)) for one in lines] == [
        ("discs", (1, 2), 1.0), ("nlp", (4, 8), 2.0),
    ]  # fmt: skip
    assert math.isnan(lines[0].half)
    panel = draw_cost(sizes).axes[0]
    jumps = [
        line.get_xdata()[0] for line in panel.lines if len(set(line.get_xdata())) == 1 and line.get_marker() == "None"
    ]
    assert {8.0**0.5, 128.0**0.5} <= set(jumps)


@pytest.mark.parametrize("ladder", LADDERS)
def test_the_first_job_of_a_ladder_is_answered(ladder: str) -> None:
    every, fewer, make = LADDERS[ladder]
    assert set(fewer) <= set(every)
    assert next(answered() for answered in make(every[0])) not in ("", "physical bound")


def test_cost_that_was_asked_less_ends_with_5(monkeypatch: pytest.MonkeyPatch) -> None:
    cut = "the time limit of 1 s ended it after 7 boxes"
    monkeypatch.setattr(made, "cost", lambda *_, **__: (row(2, 1.0), replace(row(4, 2.0), cut=cut)))
    told = CliRunner().invoke(chart, ["cost"], standalone_mode=False)
    assert told.return_value == 5
    assert f"Less was asked than this chart promises: bodies of 4, {cut}" in told.output
    assert "discs, 2 to 4: exponent 1.00" in told.output
    data = json.loads(CliRunner().invoke(chart, ["cost", "--json"], standalone_mode=False).output)
    assert [one["exponent"] for one in data["fits"]] == [pytest.approx(1.0)]
