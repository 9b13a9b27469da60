"""Recorded answers of the absorber problems against their second routes."""

import tomllib
from math import isclose, pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from absorber_cases import BRIDGE, CASES, SKID, TOOL, Case, grid, refined, scaled
from absorber_records import ROUTES

PROBLEMS = Path(__file__).parents[2] / "problems" / "absorbers"
STEMS = sorted(ROUTES)
PRINT_VERDICTS = ("right", "rounded", "wrong", "misprint", "incomplete")
DIGITS = 1e-7
"""A recorded answer carries at least seven digits, whatever tolerance its file grants a solver."""

SI = {
    "": 1.0,
    "kg": 1.0,
    "m": 1.0,
    "mm": 1e-3,
    "N/m": 1.0,
    "kN/m": 1e3,
    "MN/m": 1e6,
    "N s/m": 1.0,
    "kN s/m": 1e3,
    "kg m2": 1.0,
    "N m/rad": 1.0,
    "kN m/rad": 1e3,
    "m/s2": 1.0,
    "1/s": 1.0,
    "rad": 1.0,
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
    """A recorded value in SI."""
    number, _, unit = str(value).partition(" ")
    return float(number) * SI[unit]


def agrees(value: Any, answer: Any, tolerance: float) -> bool:
    """Whether a recorded value equals an answer: as a word, as intervals or as a number."""
    if isinstance(answer, str):
        return bool(value == answer)
    if isinstance(answer, list):
        recorded = [in_si(end) for pair in value for end in pair]
        computed = [float(end) for pair in answer for end in pair]
        return len(recorded) == len(computed) and all(
            isclose(r, c, rel_tol=tolerance) for r, c in zip(recorded, computed, strict=True)
        )
    return isclose(in_si(value), float(answer), rel_tol=tolerance, abs_tol=1e-30)


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


@pytest.mark.parametrize("stem", sorted(ROUTES))
def test_every_answer_of_a_route_is_recorded_once(stem: str) -> None:
    paths = [record["path"] for record in records(stem)]
    assert len(paths) == len(set(paths))
    assert set(paths) == set(ROUTES[stem]())


def test_every_problem_has_a_route_and_every_route_a_file() -> None:
    """Worked cases of other areas lie in the folder too and are checked there."""
    files = {path.stem for path in PROBLEMS.glob("*.toml")}
    assert {stem for stem in files if stem.startswith(("rao_", "assignment_", "cabinet_"))} | set(CASES) == set(ROUTES)
    assert set(ROUTES) <= files


@pytest.mark.parametrize("case", [BRIDGE, TOOL], ids=["bridge", "tool"])
def test_the_region_found_does_not_depend_on_the_grid(case: Case) -> None:
    assert refined(case, grid(case, 16))[0] == pytest.approx(refined(case, grid(case))[0], rel=1e-7)


def test_no_lighter_pair_of_absorbers_lies_on_a_grid_of_the_skid() -> None:
    """Every design of a grid that holds the limits is heavier than the one found by evolution."""
    speeds, lightest = SKID.speeds(40), CASES["pump_skid_two_grids"]()["goal"]
    points = grid_of_six()
    found = scaled(SKID, points)
    light = found[:, found[0] + found[3] < lightest * (1 - 1e-6)]
    assert light.shape[1] > 10_000
    parts = (light[:, start : start + 2000] for start in range(0, light.shape[1], 2000))
    assert all(SKID.highest(part, speeds).min() > 1 for part in parts)


def grid_of_six() -> Any:
    """Numbers between 0 and 1 for both absorbers, the first with the lower frequency; little damping counts most."""

    mass, own, ratio = np.linspace(0, 1, 9), np.linspace(0, 0.8, 13), np.array([0.0, 0.15, 0.4])
    axes = np.meshgrid(mass, own, ratio, mass, own, ratio, indexing="ij")
    points = np.array([axis.ravel() for axis in axes])
    return points[:, points[1] < points[4]]
