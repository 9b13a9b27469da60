"""Answers in which nothing is fitted: the goal, the limits and the plan are none, of every kind and by every method."""

from __future__ import annotations

from typing import Any

import pytest

import vibopt as vo
from vibopt.cli.main import main

SHAFT = {
    "shaft": {"bearings": {"A": "0 mm", "B": "800 mm"}, "speed": "1500 rpm"},
    "masses": {"m": {"unbalance": "500 g mm", "angle": "40 deg", "at": "200 mm"}},
    "planes": {"p": {"radius": "60 mm", "at": "600 mm"}},
    "limits": {"l": {"response": "bearing_reaction", "at_most": "1 N"}},
    "goal": {"minimise": "reaction"},
}
ENGINE = {
    "engine": {"stroke": "80 mm", "rod": "150 mm", "speed": "6000 rpm", "reciprocating": "0.5 kg",
               "counterweight_share": {"from": 0, "to": 1}},
    "cylinders": [{"crank": "0 deg", "at": "0 mm"}],
    "limits": {"l": {"response": "secondary_force", "at_most": "1 N"}},
    "goal": {"minimise": "primary_force"},
}  # fmt: skip
ROTOR = {
    "conventions": {"phase": "lag", "readings": "phase", "angles": "with rotation", "detector": "pk", "zero": "tape"},
    "speed": "1500 rpm",
    "planes": {"p": {"radius": "60 mm"}},
    "runs": [
        {"readings": {"a": "40 um @ 10 deg", "b": "30 um @ 200 deg"}},
        {"weights": {"p": "5 g @ 0 deg"}, "readings": {"a": "30 um @ 40 deg", "b": "35 um @ 250 deg"}},
    ],
    "limits": {"l": {"response": "residual", "at_most": "1 um"}},
    "goal": {"minimise": "residual"},
}
of_each_kind = pytest.mark.parametrize("document", [SHAFT, ENGINE, ROTOR], ids=["known", "engine", "rotor"])


@of_each_kind
@pytest.mark.parametrize("method", ["", "cvxpy", "ipopt"])
def test_what_no_weights_keep_has_no_goal_and_no_plan(document: dict[str, Any], method: str) -> None:
    job = vo.from_dict(document)
    answer = vo.solve(job, method=method or None)
    assert answer.status == ("infeasible" if not method else answer.status)
    assert answer.status in ("infeasible", "unproven")
    assert (answer.goal, dict(answer.limits)) == (None, {})
    assert answer.nearest is not None
    text = answer.report()
    assert "The nearest" in text
    assert "What to" not in text
    assert "no weight." not in text


@of_each_kind
def test_nothing_is_drawn_of_it(document: dict[str, Any], tmp_path: Any, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "job.toml"
    vo.write(vo.from_dict(document), file)
    assert main(["plot", str(file), "--method", "ipopt", "-o", str(tmp_path / "x.svg")]) == 2
    assert capsys.readouterr().err == "job.toml: there is nothing to draw: there is no plan (unproven).\n"


@pytest.mark.parametrize("verb", ["explain", "whatif"])
def test_settings_of_cranks_that_all_break_a_limit_are_explained(
    verb: str, tmp_path: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    """Cranks alone are chosen, so that no weight stands nearest."""
    engine = {key: value for key, value in ENGINE["engine"].items() if key != "counterweight_share"}
    document = {
        **ENGINE, "engine": {**engine, "spacing": "90 mm", "cranks": ["0 deg", "90 deg", "200 deg"]},
        "cylinders": [{"crank": "choose"}] * 3,
    }  # fmt: skip
    file = tmp_path / "job.toml"
    vo.write(vo.from_dict(document), file)
    assert main([verb, str(file)]) == 3
    out, err = capsys.readouterr()
    assert ("Its cylinders" in out, err) == (True, "")
