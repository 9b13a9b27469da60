"""Every smallest set of limits that cannot hold together: none is missing, none too large, few answers are asked."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from texts import STIFFEST, choice, floor, moves, sags, shaken_fan
from vibopt.answer.clashes import Conflict, every_clash
from vibopt.jobs import answer, from_text, open_job, with_changes
from vibopt.study.seen import reason

PROBLEMS = Path(__file__).parent.parent.parent / "problems"
few = settings(derandomize=True, database=None, deadline=None, max_examples=60)


def smallest_of(n: int, sets: Any) -> set[tuple[int, ...]]:
    """Of some sets those that hold no other."""
    every = [frozenset(one) for one in sets if one]
    return {tuple(sorted(one)) for one in every if not any(other < one for other in every) and max(one) < n}


@given(
    n=st.integers(2, 10),
    sets=st.lists(st.frozensets(st.integers(0, 9), min_size=1, max_size=4), min_size=1, max_size=4),
)
@few
def test_all_smallest_sets_are_found_in_few_answers(n: int, sets: list[frozenset[int]]) -> None:
    truth = smallest_of(n, [frozenset(k % n for k in one) for one in sets])
    asked: list[tuple[int, ...]] = []

    def clashes(some: tuple[int, ...]) -> bool:
        asked.append(some)
        return any(set(one) <= set(some) for one in truth)

    found = every_clash(range(n), clashes)
    assert set(found.sets) == truth
    assert found.complete
    assert found.answers == len(asked) == len(set(asked))
    assert found.answers < 50


def test_what_is_not_proven_counts_as_no_clash_and_is_said() -> None:
    found = every_clash("abc", lambda some: True if set(some) >= {"a", "b"} else None if "c" in some else False)
    assert found.sets == (("a", "b"),)
    assert not found.complete
    assert found.doubtful == ()


def test_a_limit_whose_leaving_out_was_not_decided_is_told() -> None:
    found = every_clash("abc", lambda some: {"abc": True, "ac": False}.get("".join(some)))
    assert found.sets == (("a", "b", "c"),)
    assert found.doubtful == ("a", "c")
    said = Conflict(found.sets[0], (), "", complete=found.complete, doubtful=found.doubtful).others_said('"')
    assert said == (
        'Fewer may clash already: without "a" or "c" neither a design nor a proof was found.',
        "There may be further sets: not all were looked at.",
    )


def test_one_limit_that_cannot_hold_alone_is_said_to_be_one() -> None:
    found: Any = SimpleNamespace(exit_code=3, reason="", conflict=Conflict(("shake",), (), ""))
    assert reason(found) == "this cannot hold: shake."
    found.conflict = Conflict(("floor", "shake"), (), "")
    assert reason(found) == "these cannot hold together: floor, shake."


def test_where_not_even_no_limit_helps_it_is_not_the_limits() -> None:
    assert every_clash("ab", lambda some: True).sets == ()


def test_more_limits_than_are_mapped_have_a_first_smallest_set_and_say_so() -> None:
    found = every_clash(range(20), lambda some: {3, 7} <= set(some))
    assert found.sets == ((3, 7),)
    assert not found.complete


MACHINE = shaken_fan(
    {"stiffness": choice("1 kN/m", "10 MN/m"), "damping": choice("10 N s/m", "20 kN s/m")},
    floor("150 N"), sags("mount", "2 mm"), moves("fan", "0.8 mm", "swing"), moves("fan", "1.2 mm", "start", "start-up"),
    STIFFEST, amplitude="1 kN", speed="100 rad/s", varies="constant",
)  # fmt: skip


UNITS = {"force": "N", "length": "m", "mass": "kg", "unbalance": "kg m", "couple_unbalance": "kg m2"}


def _job(which: str) -> Any:
    if which == "machine":
        return from_text(MACHINE)
    job = open_job(PROBLEMS / "balancing/rao_9_11_capped.toml")
    tight = {
        "left": {"response": "correction", "of": "B", "at_most": "20 g"},
        "right": {"response": "correction", "of": "C", "at_most": "20 g"},
        "static": {"response": "static_unbalance", "at_most": "100 g mm"},
        "couple": {"response": "couple_unbalance", "at_most": "1 kg mm2"},
    }
    return with_changes(job, {"limits": tight})


@pytest.mark.parametrize("which", ["machine", "shaft"])
def test_the_conflicts_of_a_job_are_those_that_brute_force_finds(which: str) -> None:
    job = _job(which)
    design = answer(job)
    assert design.status == "infeasible", design.claim
    conflict = design.conflict
    assert conflict is not None
    names = tuple(job.document["limits"])
    impossible = [one for size in range(1, len(names) + 1) for one in combinations(names, size) if _clash(job, one)]
    smallest = {one for one in impossible if not any(set(other) < set(one) for other in impossible)}
    found = {tuple(sorted(one)) for one in (conflict.limits, *conflict.others)}
    assert found == {tuple(sorted(one)) for one in smallest}
    assert conflict.complete
    for name, _, then in conflict.loosenings:
        assert all(name in one for one in smallest)
        wider = with_changes(job, {f"limits.{name}.at_most": f"{then.value!r} {UNITS[then.dimension]}"})
        assert answer(wider, explain=False).status in ("optimal", "feasible")


def _clash(job: Any, names: tuple[str, ...]) -> bool:
    only = {name: job.document["limits"][name] for name in names}
    found = answer(with_changes(job, {"limits": only}), explain=False)
    assert found.status in ("optimal", "feasible", "infeasible"), found.claim
    return found.status == "infeasible"
