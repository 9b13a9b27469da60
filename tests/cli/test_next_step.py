"""The last line of an answer is a command that can be typed as it stands, and does what it says."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from vibopt.cli.main import main

PROBLEMS = Path(__file__).parents[2] / "problems"
PRESS = [
    "--set", 'limits.floor_force.at_most="2 kN"', "--set", 'limits.start_up.at_most="4 mm"',
]  # fmt: skip
CASES = {
    "isolation/rao_9_34": ([], 0, "--round 3"),
    "isolation/rao_9_38_two_isolators": ([], 7, "-o rao_9_38_two_isolators.html"),
    "isolation/rao_9_1": ([], 0, "--sheet -o rao_9_1.html"),
    "balancing/rao_9_23": ([], 0, "--sheet -o rao_9_23.html"),
    "balancing/rao_9_7_holes": ([], 0, "--sheet -o rao_9_7_holes.html"),
    "balancing/rao_9_14_b_capped": ([], 0, "--sheet -o rao_9_14_b_capped.html"),
}


def last_command(said: str) -> str:
    """The command behind "Next", its lines joined as a shell does."""
    after = said.rpartition("\nNext")[2].partition("\n")[2]
    return " ".join(after.replace("\\\n", " ").split())


@pytest.mark.parametrize("name", CASES)
def test_the_next_step_runs_as_it_stands(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    changes, code, ending = CASES[name]
    monkeypatch.chdir(tmp_path)
    file = str(PROBLEMS / f"{name}.toml")
    assert main(["solve", file, *changes]) == code
    command = last_command(capsys.readouterr().out)
    assert command.endswith(ending)
    verb, *words = shlex.split(command)
    assert verb == "vibopt"
    assert file in words
    assert main(words) == code


def test_changes_go_with_it_and_a_loosening_that_is_named_helps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    file = str(PROBLEMS / "isolation" / "rao_9_34.toml")
    changes = ["--set", 'limits.amplitude.at_most="1 mm"', "--set", 'limits.start_up.at_most="2 mm"']
    assert main(["solve", file, *changes]) == 3
    verb, *words = shlex.split(last_command(capsys.readouterr().out))
    assert verb == "vibopt"
    assert words.count("--set") == 2 or words[-2] == "--set"
    assert re.match(r"limits\.\w+\.at_most=", words[-1])
    assert main(words) == 0


@pytest.mark.parametrize(
    ("narrow", "wider"),
    [
        ('links.mount.stiffness.to="5 MN/m"', 'links.mount.stiffness.to="10000 kN/m"'),
        ('links.mount.damping.from="12 kN s/m"', 'links.mount.damping.from="6 kN s/m"'),
    ],
)
def test_where_a_number_rests_at_the_end_of_its_range_a_wider_one_is_proposed(
    narrow: str, wider: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    file = str(PROBLEMS / "isolation" / "rao_9_34.toml")
    assert main(["solve", file, "--set", narrow]) == 0
    before = capsys.readouterr().out
    verb, *words = shlex.split(last_command(before))
    assert verb == "vibopt"
    assert words[-1] == wider.replace('"', "")
    assert main(words) == 0
    found = [float(re.search(r"mount is ([\d.]+) kN/m", one)[1]) for one in (before, capsys.readouterr().out)]
    assert found[1] > found[0]
