"""What the README shows is what happens, and what it names is there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from examples import agrees, blocks_of, run
from vibopt.answer.answer import EXIT_CODES
from vibopt.cli.help_command import whole_book
from vibopt.cli.main import VERBS
from vibopt.cli.main import vibopt as verbs
from vibopt.solve.by_name import METHODS

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
MOST_LINES = 250


def test_it_is_short_and_ends_with_the_changelog() -> None:
    assert len(README.splitlines()) <= MOST_LINES
    assert re.findall(r"^## (.+)$", README, re.M)[-1] == "Changelog"


def test_its_file_gives_the_answer_that_it_shows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    shown = list(run(README, tmp_path))
    assert [command for command, _, _ in shown] == ["solve press.toml"]
    for command, expected, said in shown:
        assert agrees(expected, said), f"vibopt {command}\n{said}"


def test_its_file_is_the_first_one_of_the_manual() -> None:
    start = (ROOT / "vibopt" / "manual" / "guides" / "start.md").read_text(encoding="utf-8")
    first, same = ([one.text for one in blocks_of(text) if one.is_whole] for text in (README, start))
    assert first == same


def test_its_pictures_are_those_that_the_guides_draw() -> None:
    pictures = re.findall(r'<img src="(.+?)"', README)
    drawn, charts = [one for one in pictures if "/guides/" in one], [one for one in pictures if "/guides/" not in one]
    assert len(drawn) == 3
    assert charts == [
        f"problems/figures/{name}.svg" for name in ("profiles", "speed_accuracy", "stability", "cost", "fidelity")
    ]
    assert all((ROOT / chart).exists() for chart in charts)
    guides = "".join(file.read_text(encoding="utf-8") for file in (ROOT / "vibopt" / "manual" / "guides").glob("*.md"))
    for picture in drawn:
        assert (ROOT / picture).exists()
        assert f"]({Path(picture).name})" in guides


def test_methods_statuses_and_topics_that_it_names_are_there() -> None:
    methods = re.search(r"\| question \| method.*?\n\n", README, re.S)
    assert methods is not None
    assert set(re.findall(r"`(\w+)`", methods[0])) <= set(METHODS)
    listed = re.findall(r"^\| (`.+?`) \| .+? \| ([\d, ]+) \|$", README, re.M)
    codes = {
        name: int(code)
        for names, numbers in listed
        for name, code in zip(re.findall(r"`(\w+)`", names), numbers.split(", "), strict=True)
    }
    assert {**EXIT_CODES, **codes} == EXIT_CODES
    assert set(codes) == set(EXIT_CODES)
    named = re.findall(r"^\| `vibopt help (\w+)`((?:, `\w+`)*) \|", README, re.M)
    topics = {one for first, more in named for one in (first, *re.findall(r"`(\w+)`", more))}
    assert topics <= set(whole_book(verbs).topics)
    assert "questions" in topics


def test_every_verb_has_its_line() -> None:
    table = re.search(r"\| command \| what it does.*?\n\n", README, re.S)
    assert table is not None
    cells = [line.split("|")[1] for line in table[0].splitlines() if line]
    assert set(re.findall(r"`(\w+)[^`]*`", "".join(cells))) == set(VERBS)


def test_both_commands_are_marked_for_the_machine_that_runs_them() -> None:
    for mark in ("<!-- install command -->", "<!-- test command -->"):
        assert README.count(mark) == 1
