"""What the README shows is what happens."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import pytest

import vibopt as vo

README = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
SCENES = [
    text
    for text in re.findall(r"```toml\n(.*?)```", README, re.S)
    if text.startswith('title = "') and "..." not in text
]


@pytest.mark.parametrize("text", SCENES, ids=[text.splitlines()[0][9:-1] for text in SCENES])
def test_every_whole_file_of_the_readme_is_solved(text: str, tmp_path: Path) -> None:
    file = tmp_path / "scene.toml"
    file.write_text(text, encoding="utf-8")
    (tmp_path / "job.csv").write_text(re.findall(r"```csv\n(.*?)```", README, re.S)[0], encoding="utf-8")
    assert vo.solve(vo.read(file)).status == "optimal"


def test_there_are_four_whole_files() -> None:
    assert len(SCENES) == 4


def test_the_first_scene_gives_the_numbers_that_the_readme_says() -> None:
    stiffness, damping = re.findall(r"(\d+) kN/m with (\d+) N s/m", README)[0]
    scene = vo.read(Path(__file__).parents[1] / "problems" / "isolation" / "rao_9_34.toml")
    chosen = vo.solve(scene).variables
    assert chosen["links.mount.stiffness"].value.shown == f"{stiffness} kN/m"
    assert chosen["links.mount.damping"].value.shown == f"{damping} N s/m"


def test_the_python_of_the_readme_runs() -> None:
    code = re.findall(r"```python\n(.*?)```", README, re.S)[0]
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        exec(compile(code, "README.md", "exec"), {})
    assert "greatest stiffness of mount is 6957 kN/m" in said.getvalue()


def test_the_programs_of_the_readme_are_solved_with_limits_of_ones_own() -> None:
    code = next(text for text in re.findall(r"```python\n(.*?)```", README, re.S) if "vo.posed" in text)
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        exec(compile(code, "README.md", "exec"), {})
    assert said.getvalue().split() == ["met", "met"]


def test_both_commands_are_marked_for_the_machine_that_runs_them() -> None:
    for mark in ("<!-- install command -->", "<!-- test command -->"):
        assert README.count(mark) == 1
