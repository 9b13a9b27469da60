"""Absorbers on the command line: maps by name, and what explain says."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from texts import DAMPING_RATIO, absorber, best, choice, swayed

Run = Callable[..., Any]

FAN = swayed(
    "fan", "1..25 Hz", absorber("tmd", "fan", "5 kg", frequency=choice("12 Hz", "18 Hz"), damping_ratio=DAMPING_RATIO),
    absorber("other", "fan", "1 kg", frequency="30 Hz"), best(minimise="displacement", of="fan"), title="Fan",
)  # fmt: skip


@pytest.fixture
def fan(tmp_path: Path) -> str:
    path = tmp_path / "fan.toml"
    path.write_text(FAN, encoding="utf-8")
    return str(path)


@pytest.mark.parametrize("asked", [("--map",), ("--map", "absorbers.tmd"), ("--map=absorbers.tmd",)])
def test_a_map_may_name_its_absorber(run: Run, fan: str, tmp_path: Path, asked: tuple[str, ...]) -> None:
    target = tmp_path / "map.svg"
    assert run("plot", *asked, fan, "-o", str(target)).code == 0
    assert target.read_bytes().startswith(b"<?xml")


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("tdm", "fan.toml: there is no absorber called tdm. Did you mean tmd?"),
        ("other", "fan.toml: a map has two axes. Write --map absorbers.tmd."),
    ],
)
def test_a_map_that_cannot_be_says_which_can(run: Run, fan: str, tmp_path: Path, name: str, text: str) -> None:
    done = run("plot", fan, "--map", f"absorbers.{name}", "-o", str(tmp_path / "map.svg"))
    assert done.code == 2
    assert done.err.replace('"', "").strip() == text


def test_explain_in_json_has_parts_range_and_consequences(run: Run, fan: str) -> None:
    data = run("explain", fan, "--json").data["absorbers"]
    assert [one["name"] for one in data["parts"]] == ["tmd", "other"]
    assert data["parts"][0]["numbers"]["mass"]["shown"] == "5 kg"
    assert data["adjusting"][0]["low"]["because"] == "the goal"
    lost = next(one for one in data["consequences"] if (one["absorber"], one["what"]) == ("other", "lost"))
    assert lost["goal"]["unit"] == "m"
    assert "displacement of fan" in lost["words"]


def test_the_page_says_what_happens(run: Run, fan: str, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    assert run("report", fan, "-o", str(page)).code == 0
    text = page.read_text(encoding="utf-8")
    for words in ("What to build", "How far each spring may be off", "tmd without its damper", "other lost"):
        assert words in text
