"""Recorded answers of the balancing problems against their second routes."""

import tomllib
from math import isclose, pi, sqrt
from pathlib import Path
from typing import Any

import pytest

from balancing_routes import ROUTES, printed_weights_leave

PROBLEMS = Path(__file__).parents[2] / "problems" / "balancing"
STEMS = sorted(path.stem for path in PROBLEMS.glob("*.toml"))
PRINT_VERDICTS = ("right", "rounded", "wrong", "misprint", "incomplete")
DIGITS = 1e-6

SI = {
    "": 1.0,
    "deg": pi / 180.0,
    "kg": 1.0,
    "g": 1e-3,
    "oz": 0.028349523125,
    "g mm": 1e-6,
    "kg mm": 1e-3,
    "kg m": 1.0,
    "g mm²": 1e-9,
    "N": 1.0,
    "kN": 1e3,
    "N m": 1.0,
    "mm pk": 1e-3,
    "mm/s pk": 1e-3,
    "mm/s rms": 1e-3 * sqrt(2.0),
    "mil pp": 12.7e-6,
    "µm pp": 0.5e-6,
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


def agrees(path: str, recorded: float, answer: float, tolerance: float) -> bool:
    """Whether two answers are the same; of angles, whether they are the same direction."""
    if path.endswith("angle"):
        return abs((recorded - answer + pi) % (2.0 * pi) - pi) < tolerance
    return isclose(recorded, answer, rel_tol=tolerance)


@pytest.fixture(scope="module")
def routes() -> dict[str, dict[str, Any]]:
    """Answers of the second routes, each walked once."""
    return {stem: route() for stem, route in ROUTES.items()}


@pytest.mark.parametrize(("stem", "record"), all_records())
def test_recorded_value_equals_second_route(
    stem: str, record: dict[str, Any], routes: dict[str, dict[str, Any]]
) -> None:
    path = record["path"]
    assert path in routes[stem], f"{stem}: {path} has no second route"
    answer = float(routes[stem][path])
    assert agrees(path, in_si(record["value"]), answer, DIGITS), f"second route: {answer}"


@pytest.mark.parametrize(("stem", "record"), all_records())
def test_record_judges_the_print_and_says_why(stem: str, record: dict[str, Any]) -> None:
    assert ("printed" in record) == ("verdict" in record)
    if "verdict" in record:
        assert record["verdict"] in PRINT_VERDICTS
        assert ("why" in record) == (record["verdict"] != "right")


@pytest.mark.parametrize("stem", STEMS)
def test_every_file_has_records_and_each_path_once(stem: str) -> None:
    paths = [record["path"] for record in records(stem)]
    assert paths
    assert len(paths) == len(set(paths))


def test_every_file_has_a_route_and_every_route_a_file() -> None:
    assert set(ROUTES) == set(STEMS)


@pytest.mark.parametrize(
    ("stem", "left", "right"),
    [
        ("rao_9_13", (4.2315, 49.7058), (2.1217, 39.2682)),
        ("rao_9_68", (4.231537, 130.294244), (2.121730, 140.731862)),
        ("rao_9_69", (4.23153662, 130.29424410), (2.12172985, 140.73186247)),
        ("rao_9_70", (4.2315292, -49.705841), (2.1217260, -39.268173)),
    ],
)
def test_what_the_printed_weights_leave_is_said(
    stem: str, left: tuple[float, float], right: tuple[float, float]
) -> None:
    a, b = printed_weights_leave(left, right)
    said = [record["why"] for record in records(stem) if "fitted as printed" in record.get("why", "")]
    words = f"fitted as printed, both weights leave {a:.4g} mil at A and {b:.4g} mil at B, where 5 and 4 mil were found"
    assert [one.partition("; ")[2] for one in said] == [words]
