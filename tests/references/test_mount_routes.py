"""Recorded answers of the mount problems against their second routes, and against what vibopt says."""

import tomllib
from math import isclose
from pathlib import Path
from typing import Any

import pytest

from mount_routes import ROUTES

PROBLEMS = Path(__file__).parents[2] / "problems" / "mounts"


@pytest.mark.parametrize("stem", ROUTES)
def test_records_are_those_of_the_second_route(stem: str) -> None:
    with (PROBLEMS / f"{stem}.toml").open("rb") as file:
        records: list[dict[str, Any]] = tomllib.load(file)["expected"]
    answers = ROUTES[stem]()
    assert {one["path"] for one in records} == set(answers)
    for record in records:
        value, computed = record["value"], answers[record["path"]]
        if isinstance(computed, str):
            assert value == computed
        else:
            assert isclose(float(str(value).split()[0]), computed, rel_tol=1e-6), record["what"]
