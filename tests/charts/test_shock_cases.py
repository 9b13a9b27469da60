"""The truths of the charts of shock: each by a second and a third route."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest

from vibopt.charts import shock_cases
from vibopt.charts.shock_cases import METHODS, Load, hard, speed, truth
from vibopt.charts.trial import DEFAULT, Case
from vibopt.charts.verdicts import MISSING, REFUSES, RIGHT

QUICK = [(case, load) for case, load in speed(quick=True).cases if load.bodies < 20 or "triangle" in case.name]


@pytest.mark.parametrize(("case", "load"), QUICK, ids=lambda one: getattr(one, "name", ""))
def test_vibopt_and_the_integrator_agree_with_modes_in_closed_form(case: Case, load: Load) -> None:
    for method in (DEFAULT, "dop853 1e-11"):
        one = speed_trial(case, load, method)
        assert (one.verdict, one.error < 1e-9) == (RIGHT, True), (method, one.error)


def test_the_base_of_a_mass_that_nothing_damps_may_go_far() -> None:
    """A base at 1 m/s2 for a second: half a metre beside swings of 50 nanometres, whose digits are few."""
    load = Load(1, 1e3, 0.0, np.array([0.0, 1.0]), np.ones(2))
    said = METHODS[DEFAULT](load)
    assert (said.status, said.answer) == ("optimal", pytest.approx(2.0 / (2e3 * np.pi) ** 2, rel=1e-9, abs=0.0))


@pytest.mark.parametrize(("case", "load"), hard(quick=True).cases, ids=lambda one: getattr(one, "name", ""))
def test_formulas_of_hard_ground_are_those_of_the_modes_and_vibopt_is_right(case: Case, load: Load) -> None:
    assert speed_trial(case, load, DEFAULT).error < 1e-9
    if 0.0 < load.ratio < 1.0 or load.turns < 1.0:
        assert truth(load) == pytest.approx(case.goal, rel=1e-9, abs=0.0)


def speed_trial(case: Case, load: Load, method: str) -> Any:
    return hard(quick=True).tried(case, load, method, 1)


def test_a_rival_that_is_not_there_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shock_cases, "find_spec", lambda _: None)
    said = METHODS["solve_exp2 40"](QUICK[0][1])
    assert (said.status, said.claim) == (MISSING, "pip install pyyeti")


@pytest.mark.skipif(find_spec("pyyeti") is None, reason=shock_cases.HOW)
def test_equal_steps_are_counted_before_they_are_made() -> None:
    (short,) = [load for case, load in hard(quick=True).cases if case.name == "rectangle of 1e-06 periods"]
    said = METHODS["solve_exp2 40"](short)
    assert (said.status, said.claim) == (REFUSES, "4e+08 equal steps, more than 2e+06")
