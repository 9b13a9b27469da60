"""Answers that many tests look at; each is found once."""

from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from vibopt.scene.read import read
from vibopt.scene.scene import Design
from vibopt.solve import solve

PROBLEMS = Path(__file__).parents[2] / "problems" / "isolation"

Solved = Callable[[str], Design]


@cache
def _solved(name: str) -> Design:
    return solve(read(PROBLEMS / f"{name}.toml"))


@pytest.fixture
def solved() -> Solved:
    """The answer to a problem of the isolation folder, by its name."""
    return _solved
