"""Limits of engines: what each costs, where it stops to matter, and which of them cannot hold together."""

from __future__ import annotations

import re
from itertools import permutations
from typing import Any

import numpy as np
import pytest
from ranged import ranged

from test_engine import engine, job_of, number_at, solved
from vibopt.answer.text import blocks_of, text_of
from vibopt.balancing import optimisers
from vibopt.balancing.engine import EngineJob, solve_engine
from vibopt.balancing.engine.choose_weights import balance, settings
from vibopt.balancing.engine.shaking import Arms, arms, of_order
from vibopt.balancing.question import Solved
from vibopt.study.prices import priced
from vibopt.study.prices import prices as every_price
from vibopt.units import read_quantity


def four(**limits: str) -> dict[str, Any]:
    """A four-cylinder engine with two capped shafts off its middle."""
    document = engine(["0 deg", "180 deg", "180 deg", "0 deg"])
    shaft = {"order": 2, "at": "20 mm", "unbalance": {"from": "0 g mm", "to": "3 kg mm"}}
    document["balance_shafts"] = {
        "left": {**shaft, "turns": "with rotation"},
        "right": {**shaft, "turns": "against rotation"},
    }
    document["goal"] = {"minimise": "secondary_force"}
    document["limits"] = {name: {"response": name, "at_most": bound} for name, bound in limits.items()}
    return document


def search(bound: str) -> dict[str, Any]:
    """Five cylinders whose cranks are chosen."""
    document = engine(["choose"] * 5, cranks=[f"{72 * k} deg" for k in range(5)])
    document["goal"] = {"minimise": "primary_couple"}
    document["limits"] = {"rock": {"response": "secondary_couple", "at_most": bound}}
    return document


def numbers(text: str, dimension: str) -> list[float]:
    """Every quantity of a dimension in a sentence [SI]."""
    unit = {"force": "k?N", "moment": "k?N m"}[dimension]
    found = re.findall(rf"([\d.]+ {unit})(?= ->| buys|;|$|\.)", text)
    return [read_quantity(one, dimension).value for one in found]


def grid(job: EngineJob, here: Arms) -> tuple[np.ndarray, np.ndarray]:
    """(secondary force, secondary couple) of every pair of shaft weights along the line on which they act."""
    sizes = np.linspace(-3e-3, 3e-3, 801)
    x = np.array([(a, b) for a in sizes for b in sizes])
    both = np.array([here.constant[k, :, 2] + x @ here.slope[k, :, 2].T for k in (0, 1)])
    force, couple = np.abs(both).sum(axis=2)
    return force, couple


def test_a_limit_says_what_a_tenth_more_buys_and_from_where_nothing_is_gained() -> None:
    """Against all pairs of weights on a grid: the words are within its step."""
    document = four(secondary_couple="400 N m")
    answer = ranged(solved(document))
    price = answer.limits["secondary_couple"].price
    bound, wider, until = 400.0, price.loosened.value, price.until.value
    now, then = answer.goal[1].value, price.goal.value
    force, couple = grid(job_of(document), arms(job_of(document), (0.0, np.pi, np.pi, 0.0)))
    assert wider == pytest.approx(440.0)
    assert price.words.startswith("400 N m -> 440 N m: secondary force ")
    assert now == pytest.approx(force[couple <= bound].min(), rel=5e-3)
    assert then == pytest.approx(force[couple <= wider].min(), rel=5e-3)
    assert until == pytest.approx(couple[np.argmin(force)], rel=1e-3)
    assert force[couple <= until * 0.99].min() > force.min() * 1.02
    assert "What loosening a limit buys" in [one.title for one in blocks_of(answer)]
    assert answer.to_json()["limits"]["secondary_couple"]["price"]["words"] == price.words


def test_a_limit_that_is_not_touched_has_no_price() -> None:
    assert priced(solved(four(secondary_couple="2 kN m"))).limits["secondary_couple"].price is None


@pytest.mark.parametrize("bound", [1000.0, 1150.0])
def test_where_cranks_are_chosen_a_limit_costs_without_being_touched(bound: float) -> None:
    """Against all 120 settings."""
    document = search(f"{bound} N m")
    answer, job = priced(solved(document)), job_of(document)
    every = [arms(job, np.radians(one).tolist()).constant for one in permutations(range(0, 360, 72))]
    pairs = np.array([(of_order(one, True, 1), of_order(one, True, 2)) for one in every])

    def best(limit: float) -> float:
        return float(pairs[pairs[:, 1] <= limit * (1 + 1e-9), 0].min())

    price = answer.limits["rock"].price
    assert number_at(answer, "goal") == pytest.approx(best(bound))
    row = every_price(job, only=["limits.rock.at_most"]).rows[0]
    if best(bound * 1.1) < best(bound) * (1 - 1e-6):
        assert price.goal.value == pytest.approx(best(price.loosened.value), rel=5e-4)
    else:
        assert price is None
        assert row.ways[1].goal.value == pytest.approx(best(bound), rel=5e-4)
    end = row.ways[1].until.value
    assert best(end) == pytest.approx(best(bound), rel=1e-9)
    assert best(end * 1.001) < best(bound) * (1 - 1e-6)


def test_limits_that_cannot_hold_together_are_named_with_the_smallest_loosening() -> None:
    """The grid of all weights keeps neither pair, and keeps each loosened one only from where the words say."""
    document = four(secondary_couple="200 N m", secondary_force="5 kN", force="1 MN")
    answer = solved(document)
    assert (answer.status, answer.exit_code) == ("infeasible", 3)
    assert answer.reason.startswith("These cannot hold together: secondary_couple, secondary_force. ")
    assert answer.conflict is not None
    assert answer.conflict.limits == ("secondary_couple", "secondary_force")
    assert "Smallest loosening of one: secondary_force 5 kN -> " in answer.reason
    assert ", or secondary_couple 200 N m -> " in answer.reason
    assert answer.reason in " ".join(text_of(answer).split())
    assert answer.to_json()["reason"] == answer.reason
    couple_needed = numbers(answer.reason.replace(",", ";"), "moment")[-1]
    force_needed = numbers(answer.reason.replace(",", ";"), "force")[-1]
    force, couple = grid(job_of(document), arms(job_of(document), (0.0, np.pi, np.pi, 0.0)))
    assert couple_needed == pytest.approx(couple[force <= 5000.0].min(), rel=1e-2)
    assert force_needed == pytest.approx(force[couple <= 200.0].min(), rel=1e-2)
    for name, least in (("secondary_couple", f"{couple_needed} N m"), ("secondary_force", f"{force_needed} N")):
        bounds = {"secondary_couple": "200 N m", "secondary_force": "5 kN", name: least}
        assert solved(four(**bounds)).status == "optimal"


def test_one_limit_beyond_reach_is_named_alone() -> None:
    document = engine(["0 deg"], counterweight_share={"from": "0 %", "to": "100 %"})
    document["goal"] = {"minimise": "primary_force"}
    document["limits"] = {"floor": {"response": "primary_force", "at_most": "100 N"}}
    answer = solved(document)
    least = 0.5 * 0.5 * 0.045 * (6000 * np.pi / 30) ** 2  # half of the primary force is left at a share of one half
    assert answer.reason.startswith("This cannot hold: floor. Smallest loosening of one: floor 100 N -> ")
    assert numbers(answer.reason, "force")[-1] == pytest.approx(least, rel=2e-3)


def test_no_setting_of_the_cranks_is_said_with_the_loosening() -> None:
    answer = solved(search("100 N m"))
    assert answer.status == "infeasible"
    assert answer.reason.startswith("This cannot hold: rock. Smallest loosening of one: rock 100 N m -> ")
    job = job_of(search("100 N m"))
    least = min(of_order(arms(job, one).constant, True, 2) for one in settings(job))
    assert numbers(answer.reason, "moment")[-1] == pytest.approx(least, rel=1e-3)


def test_a_job_is_not_called_impossible_because_its_goal_starts_at_zero() -> None:
    """The couple of a symmetric engine is nothing as it stands, and shafts that take the force away make one."""
    document = four(secondary_force="5 kN")
    document["goal"] = {"minimise": "secondary_couple"}
    answer = solved(document)
    force, couple = grid(job_of(document), arms(job_of(document), (0.0, np.pi, np.pi, 0.0)))
    assert answer.status == "optimal"
    assert number_at(answer, "goal") == pytest.approx(couple[force <= 5000.0].min(), rel=1e-2)


def test_an_impasse_beyond_the_budget_is_said_with_what_computes_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(optimisers, "ALLOWANCE", 0)
    assert solved(four(secondary_couple="200 N m", secondary_force="5 kN")).reason == (
        "Which limits stand in the way was not computed: 7 more solutions would exceed the budget. "
        "`vibopt explain FILE --thorough` computes it."
    )
    job = job_of(four(secondary_couple="200 N m", secondary_force="5 kN"))
    assert solve_engine(job, thorough=True).reason.startswith("These cannot hold together: secondary_couple, ")


def test_a_class_of_cranks_without_a_proof_leaves_the_search_open(monkeypatch: pytest.MonkeyPatch) -> None:
    def nothing(job: EngineJob, found: Arms, *more: object) -> Solved:
        return Solved(None, "unproven", "the solver stopped")

    monkeypatch.setattr("vibopt.balancing.engine.choose_weights.weigh", nothing)
    assert balance(job_of(search("1 kN m"))).status == "unproven"


def test_a_difference_of_nothing_is_not_printed_as_a_percentage() -> None:
    document = engine(["0 deg", "120 deg", "240 deg"], rod="100 m")
    notes = " ".join(solved(document).notes)
    assert "exact kinematics the same." in notes
    assert "e-0" not in notes


def three(bound: str) -> dict[str, Any]:
    """Three cylinders with a counterweight at either end under a limited force."""
    document = engine(["0 deg", "120 deg", "240 deg"], rotating="0.4 kg")
    weight = {"unbalance": {"from": "0 g mm", "to": "20 kg mm"}}
    document["counterweights"] = {"front": {"at": "-40 mm", **weight}, "rear": {"at": "220 mm", **weight}}
    document["limits"] = {"force": {"response": "primary_force", "at_most": bound}}
    document["goal"] = {"minimise": "primary_couple"}
    return document


@pytest.mark.parametrize("bound", ["100 N", "1 N", "0.1 N", "1 mN", "1e-8 N", "0 N"])
def test_a_force_of_next_to_nothing_is_kept_to_its_own_digits(bound: str) -> None:
    """Two equal and opposite weights leave no force, and the least couple: half of that of the pistons."""
    found = solved(three(bound))
    row = found.limits["force"]
    assert found.status == "optimal"
    assert row.met
    assert row.value.value <= read_quantity(bound, "force").value * (1.0 + 1e-9)
    omega = 6000.0 * 2.0 * np.pi / 60.0
    least = np.sqrt(3.0) / 2.0 * 0.5 * 0.045 * omega**2 * 0.09
    assert found.goal is not None
    assert found.goal[1].value == pytest.approx(least, rel=1e-6)


def test_what_the_taken_of_equal_weights_touch_ends_no_range() -> None:
    """The goal is a line in the spacing, and bends where a cap leaves less than half of what may be pushed."""
    paths = ["engine.spacing", "counterweights.front.unbalance.to"]
    found = every_price(job_of(three("100 N")), only=paths)
    assert found.find(paths[0]).ways[0].until is None
    end = found.find(paths[1]).ways[0]
    omega = 6000.0 * 2.0 * np.pi / 60.0
    whole = (0.4 + 0.25) * 0.045 * np.sqrt(3.0) * 0.09 / 0.26
    assert end.until is not None
    assert end.until.value == pytest.approx(whole - 0.5 * 100.0 / omega**2, rel=1e-4)
    assert "force" in end.then


@pytest.mark.parametrize("cap", [1.0, 2.0])
def test_the_rate_of_a_limit_and_of_a_cap_is_what_solving_again_shows(cap: float) -> None:
    def document(most: float, couple: float) -> dict[str, Any]:
        found = four(secondary_couple=f"{couple} N m")
        found["balance_shafts"]["left"]["unbalance"] = {"from": "0 g mm", "to": f"{most} kg mm"}
        return found

    here, step = solved(document(cap, 400.0)), 1e-3
    path = "balance_shafts.left.unbalance"
    assert here.rates is not None
    for name, one, size in (
        (path, document(cap * (1.0 + step), 400.0), 1e-3 * cap),
        ("secondary_couple", document(cap, 400.0 * (1.0 + step)), 400.0),
    ):
        gained = number_at(here, "goal") - number_at(solved(one), "goal")
        assert here.rates[name] * size * step == pytest.approx(gained, rel=1e-2, abs=1e-3)
    assert max(here.rates.values()) > 0.0


@pytest.mark.parametrize(("bound", "status"), [(None, "optimal"), ("1 MN", "optimal"), ("1 N", "infeasible")])
def test_a_goal_that_is_nothing_but_rounding_as_found_decides_nothing(bound: str | None, status: str) -> None:
    """No couple is left by cylinders that lie symmetrically, and the limit hangs on weights that make none."""
    document = engine(["0 deg", "90 deg", "90 deg", "0 deg"])
    shaft = {"order": 2, "turns": "with rotation", "at": "20 mm", "unbalance": {"from": "0 g mm", "to": "3 kg mm"}}
    document["balance_shafts"] = {"one": shaft}
    document["counterweights"] = {"small": {"at": "0 mm", "unbalance": {"from": "0 g mm", "to": "10 g mm"}}}
    document["goal"] = {"minimise": "secondary_couple"}
    document["limits"] = {} if bound is None else {"force": {"response": "primary_force", "at_most": bound}}
    answer = solved(document)
    assert answer.status == status
    assert status == "infeasible" or number_at(answer, "goal") <= 1e-6


def test_tops_between_the_steps_of_the_turning_engine_refuse_nothing() -> None:
    """The couple of shafts has tops that no look at 4096 angles meets, and one cylinder has no couple of its own."""
    document = engine(
        ["240 deg"], rod="174 mm", speed="3000 rpm", orders=8, counterweight_share={"from": 0.1, "to": 1.0}
    )
    shaft = {"order": 2, "at": "164 mm", "unbalance": {"from": "0 g mm", "to": "50 kg mm"}}
    document["balance_shafts"] = {
        "a": {**shaft, "at": "234 mm", "turns": "with rotation", "unbalance": {"from": "0 g mm", "to": "500 g mm"}},
        "b": {**shaft, "turns": "against rotation"},
    }
    document["goal"] = {"minimise": "force"}
    assert solved(document).status == "optimal"


@pytest.mark.parametrize("cylinders", [3, 5, 6])
@pytest.mark.parametrize("force", [None, "primary_force", "force"])
def test_a_limit_that_only_rounding_comes_near_leaves_the_best_share(cylinders: int, force: str | None) -> None:
    """The forces of an even engine cancel, so that a share does nothing to a limit on them; its couples are in hand."""
    document = engine(
        [f"{k * 360.0 / cylinders} deg" for k in range(cylinders)], counterweight_share={"from": 0, "to": 1}
    )
    shaft = {"order": 1, "turns": "against rotation", "at": "0 mm", "unbalance": {"from": "0 g mm", "to": "2 kg mm"}}
    document |= {"balance_shafts": {"one": shaft}, "goal": {"minimise": "primary_couple"}}
    document["limits"] = {} if force is None else {"loose": {"response": force, "at_most": "100 kN"}}
    places = 0.09 * (np.arange(cylinders) - 0.5 * (cylinders - 1))
    couple = abs(np.sum(places * np.exp(2j * np.pi * np.arange(cylinders) / cylinders)))
    square = (6000.0 * np.pi / 30.0) ** 2
    least = 0.5 * 0.5 * 0.045 * square * couple - 0.002 * square * abs(places[0])  # what turns back, less the shaft's
    answer = solved(document)
    assert answer.status == "optimal"
    assert number_at(answer, "goal") == pytest.approx(least, rel=1e-7)
    assert number_at(answer, "counterweight_share") == pytest.approx(0.5, rel=1e-6)
