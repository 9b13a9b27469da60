"""Work ends a search and no clock; a user's time limit is the only one, and the claim says where it did."""

from __future__ import annotations

import itertools
import time
from functools import cache
from pathlib import Path

import pytest

import vibopt as vo
from vibopt.answer.jsonable import json_text
from vibopt.scene.scene import Design
from vibopt.work import Budget, answering, each_answer_within, late, metered, worked

PROBLEMS = Path(__file__).parents[2] / "problems"
SEARCHES = {
    "boxes": "absorbers/rao_9_53_tuned_freely",
    "slices": "absorbers/rao_9_62",
    "exact measurements": "mounts/generator_set",
    "steps": "mounts/genset_front_and_rear",
    "looks at worst machines": "isolation/press_on_rubber",
    "places": "absorbers/frame_three_storeys",
}
"""One file for each kind of search."""


@cache
def answered(file: str, seconds: float | None = None) -> Design:
    return vo.solve(vo.read(PROBLEMS / f"{file}.toml"), time_limit=seconds)


def plain(design: Design) -> str:
    return json_text({key: one for key, one in design.to_json().items() if key != "timings"})


@pytest.mark.parametrize("file", SEARCHES.values(), ids=SEARCHES)
def test_a_clock_that_runs_a_thousand_times_faster_changes_no_byte(file: str, monkeypatch: pytest.MonkeyPatch) -> None:
    before, began = plain(answered(file)), time.perf_counter()
    ticks = itertools.count()
    for name in ("perf_counter", "monotonic", "time", "process_time"):
        monkeypatch.setattr(time, name, lambda: began + 1e3 * next(ticks))
    assert plain(answered.__wrapped__(file)) == before


@pytest.mark.parametrize("file", SEARCHES.values(), ids=SEARCHES)
def test_a_time_limit_that_ended_a_search_is_in_the_claim_and_nothing_is_called_proven(file: str) -> None:
    whole, short = answered(file), answered(file, 1e-9)
    assert "; the time limit of 1e-09 s ended the search" in short.claim
    assert short.status in ("feasible", "unproven")
    assert not short.proven
    assert all(row.met for row in short.limits.values())
    if short.goal is not None and whole.goal is not None and whole.proven:
        assert whole.scene.goal is not None
        sense = 1.0 if whole.scene.goal.sense == "minimise" else -1.0
        assert sense * (short.goal[1].value - whole.goal[1].value) >= -1e-6 * abs(whole.goal[1].value)


@pytest.mark.parametrize("file", ["isolation/rao_9_34", "isolation/rao_9_29_damped", *SEARCHES.values()])
def test_a_time_limit_that_is_not_reached_changes_nothing(file: str) -> None:
    assert plain(answered(file, 3600.0)) == plain(answered(file))


def test_a_budget_is_over_when_it_is_spent_and_counts_for_the_answer() -> None:
    with metered() as outer:
        with metered() as inner:
            budget = Budget(3, "boxes", 2.0)
            budget.spend(2)
            assert not budget.over
            budget.spend()
            assert budget.over
            worked(1.0)
        assert inner.done == 7.0
        worked(1.0)
    assert outer.done == 8.0
    assert str(budget) == "3 boxes"


def test_only_the_outermost_answer_has_the_time_limit_and_the_first_search_it_ended_is_named() -> None:
    with each_answer_within(1e-9), answering() as limit:
        assert limit is not None
        with answering() as inner:
            assert inner is None
            assert Budget(10, "slices", spent=4).over
        assert late("6 boxes")
        assert limit.words == "; the time limit of 1e-09 s ended the search after 4 slices"
    assert not late()


def test_an_answer_inside_each_answer_within_none_keeps_the_limit_around_it() -> None:
    with each_answer_within(5.0), each_answer_within(None), answering() as limit:
        assert limit is not None
        assert limit.seconds == 5.0
        assert limit.words == ""
