"""Scenes drawn over the whole schema: what `check`, `solve` and an analysis of the saved design say agrees."""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from judging import judged
from machines import Drawn
from scenes import scene
from vibopt.devices import FAMILIES
from vibopt.excitations import KINDS as EXCITATIONS
from vibopt.responses import KINDS as RESPONSES

QUICK, ALL, BLOCK = 108, 1000, 10
LONG = (52, 53, 61, 105, 106, 107)
"""Scenes that take many seconds each, left to the slow suite."""
RARE = (123, 158)
"""Further scenes of what the first ones do not draw: a record, speeds by excitation."""
BLOCKS = [range(first, first + BLOCK) for first in range(0, ALL, BLOCK)]
MOTIONS = ("space", "plane", "line")


def _ids(block: Sequence[int]) -> str:
    return f"{block[0]}..{block[-1]}"


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    "block",
    [
        *(pytest.param(one, marks=[pytest.mark.slow] * (n % 2)) for n, one in enumerate(BLOCKS[: -(-QUICK // BLOCK)])),
        RARE,
    ],
    ids=_ids,
)
def test_what_is_said_of_a_drawn_scene_agrees(
    block: Sequence[int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _all_agree(block, tmp_path, monkeypatch, small=True)


@pytest.mark.slow
@pytest.mark.parametrize("block", BLOCKS, ids=_ids)
def test_what_is_said_of_many_drawn_scenes_agrees(
    block: range, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _all_agree(block, tmp_path, monkeypatch, small=False)


def _all_agree(block: Sequence[int], folder: Path, monkeypatch: pytest.MonkeyPatch, *, small: bool) -> None:
    monkeypatch.setenv("VIBOPT_DEBUG", "1")  # a fault inside shows where
    for seed in block:
        if small and (seed in LONG or (seed >= QUICK and seed not in RARE)):
            continue
        own = folder / str(seed)
        own.mkdir()
        judged(scene(seed, own, small=small), seed, 4 if small else 10)


@cache
def drawn() -> tuple[Drawn, ...]:
    """The scenes of the default suite."""
    return tuple(scene(seed, Path(tempfile.mkdtemp()), small=True) for seed in (*range(QUICK), *RARE))


def _tables(family: str) -> Iterator[dict[str, Any]]:
    for one in drawn():
        yield from one.document.get(family, {}).values()


def _asked() -> Iterator[tuple[str, dict[str, Any]]]:
    """Every response that is asked for, with its table; of a goal too."""
    for family in ("limits", "measures"):
        yield from ((table["response"], table) for table in _tables(family))
    for one in drawn():
        goal = one.document.get("goal", {})
        yield from ((goal[sense], goal) for sense in ("maximise", "minimise") if sense in goal)


def test_every_kind_of_every_registry_is_drawn() -> None:
    families = {family for one in drawn() for family in one.document}
    kinds = {table["kind"] for table in _tables("excitations")}
    responses = {response for response, _ in _asked()}
    for registry, seen in ((FAMILIES, families), (EXCITATIONS, kinds), (RESPONSES, responses)):
        missing = sorted(set(registry) - seen)
        assert not missing, f"the generator draws no {', '.join(missing)}: teach tests/generator to"


def test_every_way_to_ask_is_drawn() -> None:
    asked = list(_asked())
    keys = Counter(key for _, table in asked for key in table)
    wanted = "at over due_to combine at_most at_least outside of into through across direction axis mode unit"
    assert not [key for key in wanted.split() if not keys[key]]
    goals = {key for one in drawn() for key in one.document.get("goal", {})}
    assert {"maximise", "minimise", "find_all"} <= goals
    overs = {
        "start-up" if table["over"] == "start-up" else type(table["over"]) for _, table in asked if "over" in table
    }
    assert overs == {"start-up", str, dict}


def test_every_sort_of_variable_is_drawn() -> None:
    seen: Counter[str] = Counter()
    for one in drawn():
        for value in _nodes(one.document):
            if isinstance(value, dict):
                ends = [key for key in ("from", "to") if key in value]
                seen["whole" if "whole" in value else "ends" * len(ends)] += bool(ends)
                seen.update(key for key in ("one_of", "tolerance", "catalogue") if key in value)
    assert not [sort for sort in ("ends", "endsends", "whole", "one_of", "tolerance", "catalogue") if not seen[sort]]


def _nodes(value: Any) -> Iterator[Any]:
    yield value
    if isinstance(value, (dict, list)):
        for one in value.values() if isinstance(value, dict) else value:
            yield from _nodes(one)


def test_the_same_seed_draws_the_same_scene(tmp_path: Path) -> None:
    assert all(scene(seed, tmp_path, small=True).document == drawn()[seed].document for seed in range(0, QUICK, 9))
