"""The worked stories beside problem files: their commands print what stands there, their figures are drawn again."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from examples import agrees, run

PROBLEMS = Path(__file__).parents[2] / "problems"
STUDIES = sorted((PROBLEMS / "studies").glob("*.md"))
STORIES = sorted(one for one in PROBLEMS.rglob("*.md") if one.name != "README.md" and one not in STUDIES)
SLOW = ("press_on_rubber", "machine_tool_three_speeds", "price", "band")
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


def test_studies_are_of_machines_parts_rotors_and_engines() -> None:
    assert [one.stem for one in STUDIES] == ["band", "counterweight", "holes", "limits", "price"]
    for study in STUDIES:
        assert study.with_suffix(".svg").stat().st_size < 150_000
        for link in re.findall(r"\]\((.+?)\)", study.read_text(encoding="utf-8")):
            assert (study.parent / link).is_file()


@pytest.mark.parametrize(
    "study", [pytest.param(one, id=one.stem, marks=[pytest.mark.slow] * (one.stem in SLOW)) for one in STUDIES]
)
def test_a_study_prints_what_it_shows_and_draws_its_figure(
    study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = study.read_text(encoding="utf-8")
    here = tmp_path / "studies"
    here.mkdir()
    for folder in sorted(set(re.findall(r"\.\./(\w+)/\w+\.toml", text))):
        shutil.copytree(PROBLEMS / folder, tmp_path / folder)
    monkeypatch.chdir(here)
    outputs = []
    for command, expected, said in run(text, here):
        assert agrees(expected, said), f"vibopt {command}\n{said}"
        outputs.append(said)
    picture = study.with_suffix(".svg")
    assert words_in(here / picture.name) == words_in(picture)
    shown = " ".join(" ".join([*outputs, words_in(picture)]).split())
    assert [one for one in told(study) if one not in shown] == []
