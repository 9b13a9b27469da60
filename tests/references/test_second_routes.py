"""Recorded answers of the isolation problems against their second routes."""

import tomllib
from math import isclose, pi, sqrt
from pathlib import Path
from typing import Any

import pytest

from second_routes import ROUTES, Answer

PROBLEMS = Path(__file__).parents[2] / "problems" / "isolation"
STEMS = sorted(path.stem for path in PROBLEMS.glob("rao_*.toml"))
WORDS = ("infinite", "met", "violated", "optimal", "infeasible")
PRINT_VERDICTS = ("right", "rounded", "wrong", "misprint", "incomplete")
DIGITS = 1e-7
"""A recorded answer carries at least seven digits, whatever tolerance its file grants a solver."""

SI = {
    "": 1.0,
    "%": 0.01,
    "kg": 1.0,
    "m": 1.0,
    "mm": 1e-3,
    "mm rms": 1e-3 * sqrt(2.0),
    "m/s^2": 1.0,
    "km/h": 1 / 3.6,
    "N": 1.0,
    "kN": 1e3,
    "N/m": 1.0,
    "kN/m": 1e3,
    "MN/m": 1e6,
    "N s/m": 1.0,
    "kN s/m": 1e3,
    "rad/s": 1.0,
    "rpm": pi / 30,
    "Hz": 2 * pi,
}


def records(stem: str) -> list[dict[str, Any]]:
    """The `[[expected]]` tables of one problem file."""
    with (PROBLEMS / f"{stem}.toml").open("rb") as file:
        return list(tomllib.load(file).get("expected", []))


def all_records() -> list[Any]:
    """Every record as a test case of its own."""
    return [pytest.param(stem, record, id=f"{stem}:{record['path']}") for stem in STEMS for record in records(stem)]


def in_si(value: float | str) -> float:
    """A recorded value in SI, amplitudes peak."""
    number, _, unit = str(value).partition(" ")
    return float(number) * SI[unit]


def agrees(value: Any, answer: Answer, tolerance: float) -> bool:
    """Whether a recorded value equals an answer: as a word, as intervals or as a number."""
    if isinstance(answer, str) or value in WORDS:
        return bool(value == answer)
    if isinstance(answer, list):
        recorded = [in_si(end) for pair in value for end in pair]
        computed = [float(end) for pair in answer for end in pair]
        return len(recorded) == len(computed) and all(
            isclose(r, c, rel_tol=tolerance) for r, c in zip(recorded, computed, strict=True)
        )
    return isclose(in_si(value), float(answer), rel_tol=tolerance)


@pytest.mark.parametrize(("stem", "record"), all_records())
def test_recorded_value_equals_second_route(stem: str, record: dict[str, Any]) -> None:
    answers = ROUTES[stem]() if stem in ROUTES else {}
    path = record["path"]
    assert path in answers, f"{stem}: {path} has no second route"
    tolerance = min(record.get("rel_tol", DIGITS), DIGITS)
    assert agrees(record["value"], answers[path], tolerance), f"second route: {answers[path]}"


@pytest.mark.parametrize(("stem", "record"), all_records())
def test_record_judges_the_print_and_says_why(stem: str, record: dict[str, Any]) -> None:
    assert ("printed" in record) == ("verdict" in record)
    if "verdict" in record:
        assert record["verdict"] in PRINT_VERDICTS
        assert "why" in record or record["verdict"] == "right"


@pytest.mark.parametrize("stem", STEMS)
def test_every_file_has_records_and_each_path_once(stem: str) -> None:
    paths = [record["path"] for record in records(stem)]
    assert paths
    assert len(paths) == len(set(paths))


def test_every_file_has_a_route_and_every_route_a_file() -> None:
    assert set(ROUTES) == set(STEMS)


@pytest.mark.parametrize("stem", sorted(ROUTES))
def test_every_answer_of_a_route_is_recorded(stem: str) -> None:
    assert set(ROUTES[stem]()) == {record["path"] for record in records(stem)}
