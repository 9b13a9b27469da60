"""The user's time limit, and what an answer leaves out for its work."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import vibopt as vo
from texts import best, choice, floor, shaken_fan
from vibopt.study import absorbers, prices
from vibopt.study.prices import priced
from vibopt.work import each_answer_within

Run = Callable[..., Any]
PROBLEMS = Path(__file__).parents[2] / "problems"
GIRDER = str(PROBLEMS / "absorbers" / "rao_9_62.toml")
MOUNTS = str(PROBLEMS / "mounts" / "generator_set.toml")


@pytest.mark.parametrize("words", [("solve",), ("solve", "--json"), ("explain",)], ids=" ".join)
def test_the_claim_says_which_search_a_time_limit_ended(run: Run, words: tuple[str, ...]) -> None:
    done = run(words[0], MOUNTS, *words[1:], "--time-limit", "1e-9")
    assert re.search(r"the time limit of 1e-09 s ended the search after \d+ \w+", " ".join(done.out.split()))


def test_a_search_that_was_ended_is_not_proven(run: Run) -> None:
    assert run("solve", GIRDER).code == 0
    assert run("solve", GIRDER, "--time-limit", "1e-9", "--require-proof").code == 5


def test_a_time_limit_is_seen_between_the_first_pieces_of_a_range_once_there_is_a_design() -> None:
    turning = {"kind": "unbalance", "unbalance": "6 kg mm", "speed": "1450 rpm"}
    mount = {"stiffness": "60 kN/m", "damping": choice("100 N s/m", "1 kN s/m")}
    goal = best(minimise="displacement", of="fan", over="start-up")
    with each_answer_within(1e-9):
        answer = vo.solve(vo.from_text(shaken_fan(mount, floor("40 N"), goal, **turning)))
    assert (answer.status, answer.method) == ("feasible", "one_range")
    assert "but 1 piece did not settle it" in answer.claim
    assert answer.limits["floor"].met


@pytest.mark.parametrize("given", ["0", "-3", "soon"])
def test_a_time_limit_is_a_positive_number(run: Run, given: str) -> None:
    done = run("solve", GIRDER, "--time-limit", given)
    assert done.code == 2
    assert "--time-limit" in done.err
    assert "Traceback" not in done.err


def test_without_a_time_limit_no_claim_speaks_of_one(run: Run) -> None:
    assert "time limit" not in run("solve", GIRDER, "--json").out


def test_a_price_that_is_left_out_for_its_work_is_named_with_the_option_that_computes_it(
    monkeypatch: pytest.MonkeyPatch, run: Run, press: str
) -> None:
    design = vo.solve(vo.read(press))
    assert all(row.price is not None for row in priced(design).limits.values() if row.active)
    monkeypatch.setattr(prices, "PATIENCE", 0.0)
    assert (
        "No price was computed for floor_force, start_up: each is an answer of its own. "
        "`vibopt explain FILE --thorough` computes it."
    ) in priced(design).notes
    assert "buys" not in run("solve", press).out.partition("What loosening a limit buys")[2]
    assert "floor_force  ACTIVE, 10 kN pk -> " in run("explain", press, "--thorough").out


def test_where_a_limit_stops_to_matter_is_left_out_in_words_and_computed_when_asked(
    monkeypatch: pytest.MonkeyPatch, run: Run, press: str
) -> None:
    few = 80.0  # nominal ms: the steps, and no range
    monkeypatch.setattr(prices, "OF_LIMITS", few)
    left = "was not looked for: some thirty answers each. `vibopt whatif FILE --thorough` computes all."
    said = " ".join(run("explain", press).out.split())
    assert "How far the prices of limits." in said
    assert left in said
    said = " ".join(run("explain", press, "--thorough").out.split())
    assert left not in said
    assert "nothing more to gain beyond" in said


def test_absorbers_are_designed_anew_only_where_that_is_little_work_or_asked_for(
    monkeypatch: pytest.MonkeyPatch, run: Run
) -> None:
    monkeypatch.setattr(absorbers, "PATIENCE", 0.0)
    left = "designed anew without its damper not computed: much work. `vibopt explain FILE --thorough` does."
    assert left in " ".join(run("explain", GIRDER).out.split())
    said = " ".join(run("explain", GIRDER, "--thorough").out.split())
    assert "designed anew without its damper" in said
    assert "not computed: much work" not in said


@pytest.mark.parametrize("given", ["nan", "inf"])
def test_a_time_limit_that_is_no_number_of_seconds_is_refused(run: Run, given: str) -> None:
    done = run("solve", GIRDER, "--time-limit", given)
    assert done.code == 2
    assert f"{given} is no number of seconds. Write --time-limit 5, or leave it out." in done.err


def test_a_complete_proof_says_nothing_of_a_time_limit(run: Run, press: str) -> None:
    done = run("solve", press, "--time-limit", "1e-9", "--json")
    assert done.data["status"] == "optimal"
    assert "time limit" not in done.data["claim"]


def test_a_goal_at_the_bound_of_a_limit_to_the_same_response_is_proven(file: Callable[[str], str]) -> None:
    text = (
        'title = "Two springs"\n[bodies.a]\nmass = "100 kg"\n[links.p]\nbetween = ["a", "ground"]\n'
        'stiffness = { from = "10 kN/m", to = "1 MN/m" }\n[links.q]\nbetween = ["a", "ground"]\n'
        'stiffness = { from = "20 kN/m", to = "1 MN/m" }\n[limits.low]\nresponse = "natural_frequency"\nmode = 1\n'
        'at_most = "10 Hz"\n[goal]\nmaximise = "natural_frequency"\nmode = 1\n'
    )
    found = vo.solve(vo.read(file(text)))
    assert found.status == "optimal"
    assert found.goal is not None
    assert abs(found.goal[1].value - 62.83185307179586) <= 1e-6 * 62.9
