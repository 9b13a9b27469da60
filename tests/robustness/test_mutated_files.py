"""Problem files with random nodes changed: an answer or sentences about the mistakes, and nothing else."""

from __future__ import annotations

import json
from collections.abc import Iterable
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import pytest

from mutants import FILES, written
from vibopt.answer.answer import EXIT_CODES
from vibopt.cli.main import main

CODES = {**EXIT_CODES, "ok": 0, "input_error": 2}
CHECKED, MANY, SOLVED, BLOCK = 400, 3000, 80, 50
SLOW = (
    "foiles", "shaft_holes", "shaft_three", "genset_front", "generator_set", "compressor", "chiller", "focalised",
    "engine_phasing", "feese", "fan_16", "footbridge_marching", "machine_tool", "pump_skid", "gallery", "frame_three",
    "cabinet", "inertia_base", "pump_flange", "bk_17", "rao_9_58", "rao_9_71", "rao_9_66",
)  # fmt: skip
"""Beginnings of the names of files whose answers take long."""
LONG = (40, 45)
"""Mutants of which the answer takes seconds."""
QUICK = [file for file in FILES if not file.name.startswith(SLOW)]


def _blocks(count: int) -> Any:
    ids = [f"{first}..{first + BLOCK - 1}" for first in range(0, count, BLOCK)]
    return pytest.mark.parametrize("first", range(0, count, BLOCK), ids=ids)


def _run(verb: str, file: Path, *more: str) -> tuple[int, dict[str, Any]]:
    """Exit code and JSON of a command."""
    out = StringIO()
    with redirect_stdout(out), redirect_stderr(StringIO()):
        code = main([verb, str(file), *more, "--json"])
    return code, json.loads(out.getvalue(), parse_constant=pytest.fail)


def _checked(file: Path) -> int:
    code, said = _run("check", file)
    assert code == CODES[said["status"]], said
    assert all(one.strip() for one in said["messages"])
    assert bool(said["messages"]) == (code == 2)
    return code


@pytest.fixture(autouse=True)
def where_it_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fault inside shows its place instead of a sentence."""
    monkeypatch.setenv("VIBOPT_DEBUG", "1")


@_blocks(CHECKED)
def test_a_mutated_file_is_accepted_or_its_mistakes_are_named(first: int, tmp_path: Path) -> None:
    for seed in range(first, first + BLOCK):
        _checked(written(seed, tmp_path))


@pytest.mark.slow
@_blocks(MANY)
def test_many_mutated_files_are_accepted_or_their_mistakes_are_named(first: int, tmp_path: Path) -> None:
    for seed in range(first, first + BLOCK):
        _checked(written(seed, tmp_path))


def _solved(seeds: Iterable[int], folder: Path) -> None:
    for seed in seeds:
        file = written(seed, folder, QUICK, mild=True)
        accepted = _checked(file)
        code, said = _run("solve", file, "--no-prices")
        assert code == CODES[said["status"]], said
        followed = "than is followed" not in "".join(said.get("messages", []))  # how long, only an answer finds out
        assert (code == 2) == (accepted == 2 or not followed), said.get("messages")


@pytest.mark.sampled(2)
@pytest.mark.parametrize("first", range(0, SOLVED, 20))
def test_what_check_accepts_of_a_mutated_file_is_answered(first: int, tmp_path: Path) -> None:
    _solved((seed for seed in range(first, first + 20) if seed not in LONG), tmp_path)


@pytest.mark.slow
def test_mutated_files_that_take_long_are_answered(tmp_path: Path) -> None:
    _solved(LONG, tmp_path)


@pytest.mark.slow
@_blocks(MANY)
def test_what_check_accepts_of_many_mutated_files_is_answered(first: int, tmp_path: Path) -> None:
    _solved(range(first, first + BLOCK), tmp_path)
