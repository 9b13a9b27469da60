"""The worked stories beside problem files: their commands print what stands there, their figures are drawn again."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from examples import agrees, run

PROBLEMS = Path(__file__).parents[2] / "problems"
STORIES = sorted(one for one in PROBLEMS.rglob("*.md") if one.name != "README.md")
SLOW = ("press_on_rubber", "machine_tool_three_speeds")
"""Of these the commands take seconds."""


def words_in(picture: Path) -> str:
    """All that a figure says: titles, axes, ticks, labels and legends."""
    return "\n".join(re.findall(r"<!-- (.*?) -->", picture.read_text(encoding="utf-8"), re.S))


def told(story: Path) -> list[str]:
    """What a story quotes in bold."""
    return [" ".join(one.split()) for one in re.findall(r"\*\*(.+?)\*\*", story.read_text(encoding="utf-8"), re.S)]


def test_each_of_the_three_uses_has_a_story() -> None:
    assert [one.stem for one in STORIES] == ["machine_tool_three_speeds", "press_on_rubber", "rao_9_34"]
    for story in STORIES:
        assert story.with_suffix(".toml").is_file()
        assert 60 <= len(story.read_text(encoding="utf-8").splitlines()) <= 120
        assert story.with_suffix(".svg").stat().st_size < 150_000


@pytest.mark.parametrize(
    "story", [pytest.param(one, id=one.stem, marks=[pytest.mark.slow] * (one.stem in SLOW)) for one in STORIES]
)
def test_a_story_prints_what_it_shows_and_quotes_what_is_printed(
    story: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copy(story.with_suffix(".toml"), tmp_path)
    monkeypatch.chdir(tmp_path)
    outputs = []
    for command, expected, said in run(story.read_text(encoding="utf-8"), tmp_path):
        assert agrees(expected, said), f"vibopt {command}\n{said}"
        outputs.append(said)
    picture = story.with_suffix(".svg")
    assert words_in(tmp_path / picture.name) == words_in(picture)
    shown = " ".join(" ".join([*outputs, words_in(picture)]).split())
    assert [one for one in told(story) if one not in shown] == []


@pytest.mark.parametrize("story", STORIES, ids=lambda one: one.stem)
def test_what_a_story_shows_of_its_file_stands_there(story: Path) -> None:
    file = story.with_suffix(".toml").read_text(encoding="utf-8")
    for block in re.findall(r"^```toml\n(.*?)^```$", story.read_text(encoding="utf-8"), re.M | re.S):
        for table in block.split("\n\n"):
            assert table.strip() in file
