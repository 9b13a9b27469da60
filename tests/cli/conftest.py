"""Runs the command line in this process."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from vibopt.cli.main import main

ROOT = Path(__file__).parents[2]
PRESS = str(ROOT / "problems" / "isolation" / "rao_9_34.toml")


@dataclass(frozen=True)
class Ran:
    """Exit code and both outputs."""

    code: int
    out: str
    err: str

    @property
    def data(self) -> Any:
        """Standard output as strict JSON."""
        return json.loads(self.out, parse_constant=lambda token: pytest.fail(f"{token} is not JSON"))


Run = Callable[..., Ran]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    """`run("check", FILE)` as if typed."""

    def ran(*words: str) -> Ran:
        code = main(words)
        out, err = capsys.readouterr()
        return Ran(code, out, err)

    return ran


@pytest.fixture
def press() -> str:
    """Path of the printing press."""
    return PRESS


@pytest.fixture
def file(tmp_path: Path) -> Callable[[str], str]:
    """Writes a problem file and gives its path."""

    def write(text: str, name: str = "mine.toml") -> str:
        target = tmp_path / name
        target.write_text(text, encoding="utf-8")
        return str(target)

    return write
