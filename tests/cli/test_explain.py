"""Reasons behind an answer."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

Run = Callable[..., Any]


def test_explain_gives_model_methods_and_the_cost_of_each_limit(run: Run, press: str) -> None:
    done = run("explain", press)
    assert done.code == 0
    for words in ("Model\n  scene", "1 degree of freedom declared, 1 needed", "answers: ", "cannot: "):
        assert words in done.out
    assert "floor_force  ACTIVE, 10 kN pk -> " in done.out
    assert "47.5 % to spare: does not hold the design back" in " ".join(done.out.split())


def test_explain_in_json_has_the_same_parts(run: Run, press: str) -> None:
    data = run("explain", press, "--json").data
    assert data["status"] == "optimal"
    assert [one["chosen"] for one in data["methods"]][-1] is True
    assert {one["name"] for one in data["limits"]} == set(data["design"]["limits"])


def test_an_analysis_and_a_search_for_speeds_have_reasons_too(run: Run, press: str) -> None:
    folder = Path(press).parent
    assert "nothing to choose" in run("explain", str(folder / "rao_9_34_printed_design.toml")).out
    assert "separates good speeds" in run("explain", str(folder / "rao_9_35.toml")).out


def test_the_work_done_is_told_in_counts(run: Run, press: str) -> None:
    words = run("explain", press).out
    assert "Work done\n  rounds  " in words
    assert "reach" not in words.partition("Work done")[2]
    assert "goal" not in words.partition("Work done")[2]


def test_each_method_is_considered_once(run: Run, press: str) -> None:
    words = run("explain", press, "--method", "closed_form_kc").out
    assert "asked for by --method closed_form_kc" in words
    names = [one["name"] for one in run("explain", press, "--json").data["methods"]]
    assert names == ["closed_form", "closed_form_kc"]
    chosen = ("--set", 'bodies.press.mass={ from = "290 kg", to = "310 kg" }')
    names = [one["name"] for one in run("explain", press, *chosen, "--json").data["methods"]]
    assert names == ["closed_form", "closed_form_kc", "discs"]


@pytest.mark.parametrize("name", ["feese_two_planes", "rao_9_14_b_capped", "engine_share_capped"])
def test_a_method_that_is_asked_for_is_the_one_that_explains(run: Run, press: str, name: str) -> None:
    file = Path(press).parents[1] / "balancing" / f"{name}.toml"
    methods = run("explain", str(file), "--method", "cvxpy", "--json").data["methods"]
    assert [(one["name"], one["why"]) for one in methods] == [("cvxpy", "asked for by --method cvxpy")]


def test_who_answered_is_said_where_another_takes_the_question_too(run: Run, tmp_path: Path) -> None:
    """Boxes of all variables prove that nothing holds, before the discs of each mass are asked."""
    file = tmp_path / "fan.toml"
    file.write_text(FAN)
    words = " ".join(run("explain", str(file)).out.split())
    assert "discs could: the answer is that of boxes. boxes answers: proven by boxes of all variables" in words
    assert run("solve", str(file), "--json").data["method"] == "boxes"


FAN = """
title = "Fan at two speeds"

[bodies.fan]
mass = "310 kg"

[links.feet]
between = ["fan", "ground"]
stiffness = "2.4 MN/m"
damping = "1 kN s/m"

[absorbers.tuned]
on = "fan"
mass = { from = "2 kg", to = "40 kg" }
frequency = { from = "5 Hz", to = "30 Hz" }
damping_ratio = { from = 0.005, to = 0.4 }

[excitations.wheel]
kind = "unbalance"
on = "fan"
unbalance = "40 kg mm"
speed = ["780..860 rpm", "960 rpm"]

[limits.shake]
response = "velocity"
of = "fan"
at_most = "4.5 mm/s rms"

[goal]
minimise = "mass"
of = "tuned"
"""
