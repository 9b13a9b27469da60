"""Recorded answers of the isolation, absorber and balancing problems against their second routes."""

from __future__ import annotations

import tomllib
from functools import cache
from math import isclose, pi, sqrt
from pathlib import Path
from typing import Any

import pytest

import balancing_routes
import second_routes
from absorber_cases import CASES
from absorber_records import ROUTES as ABSORBERS

PROBLEMS = Path(__file__).parents[2] / "problems"
ROUTES = {"isolation": second_routes.ROUTES, "absorbers": ABSORBERS, "balancing": balancing_routes.ROUTES}
OWN = {"isolation": ("rao_",), "absorbers": ("rao_", "assignment_", "cabinet_", *CASES), "balancing": ("",)}
"""How names of files begin that have a route; worked cases of other areas lie in the folders, too."""
DIGITS = {"isolation": 1e-7, "absorbers": 1e-7, "balancing": 1e-6}
"""A recorded answer carries as many digits, whatever tolerance its file grants a solver."""
STEMS = [(folder, stem) for folder, routes in ROUTES.items() for stem in sorted(routes)]
WORDS = ("infinite", "met", "violated", "optimal", "feasible", "infeasible")
PRINT_VERDICTS = ("right", "rounded", "wrong", "misprint", "incomplete")
SI = {
    "": 1.0, "%": 0.01, "rad": 1.0, "deg": pi / 180.0, "kg": 1.0, "g": 1e-3, "oz": 0.028349523125,
    "g mm": 1e-6, "kg mm": 1e-3, "kg m": 1.0, "g mm²": 1e-9, "kg m2": 1.0,
    "m": 1.0, "mm": 1e-3, "mm pk": 1e-3, "mm rms": 1e-3 * sqrt(2.0), "mil pp": 12.7e-6, "µm pp": 0.5e-6,
    "km/h": 1 / 3.6, "mm/s pk": 1e-3, "mm/s rms": 1e-3 * sqrt(2.0), "m/s2": 1.0, "m/s^2": 1.0,
    "N": 1.0, "kN": 1e3, "N m": 1.0, "N/m": 1.0, "kN/m": 1e3, "MN/m": 1e6, "N m/rad": 1.0, "kN m/rad": 1e3,
    "N s/m": 1.0, "kN s/m": 1e3, "1/s": 1.0, "rad/s": 1.0, "rpm": pi / 30, "Hz": 2 * pi,
}  # fmt: skip


@cache
def records(folder: str, stem: str) -> list[dict[str, Any]]:
    """The `[[expected]]` tables of one problem file."""
    return list(tomllib.loads((PROBLEMS / folder / f"{stem}.toml").read_text(encoding="utf-8")).get("expected", []))


@cache
def answers(folder: str, stem: str) -> dict[str, Any]:
    """Answers of the second route, which is walked once."""
    return dict(ROUTES[folder][stem]())


each_file = pytest.mark.parametrize(("folder", "stem"), STEMS)
each_record = pytest.mark.parametrize(
    ("folder", "stem", "record"),
    [pytest.param(*one, record, id=f"{one[1]}:{record['path']}") for one in STEMS for record in records(*one)],
)


def in_si(value: float | str) -> float:
    """A recorded value in SI, amplitudes peak."""
    number, _, unit = str(value).partition(" ")
    return float(number) * SI[unit]


def agrees(path: str, value: Any, answer: Any, tolerance: float) -> bool:
    """Whether a recorded value equals an answer: as a word, as intervals, as a direction or as a number."""
    if isinstance(answer, str) or value in WORDS:
        return bool(value == answer)
    if isinstance(answer, list):
        recorded, computed = ([end for pair in given for end in pair] for given in (value, answer))
        pairs = zip(recorded, computed, strict=True)
        return all(isclose(in_si(one), float(other), rel_tol=tolerance) for one, other in pairs)
    if path.endswith("angle"):
        return abs((in_si(value) - float(answer) + pi) % (2.0 * pi) - pi) < tolerance
    return isclose(in_si(value), float(answer), rel_tol=tolerance, abs_tol=1e-30)


@each_record
def test_recorded_value_equals_second_route(folder: str, stem: str, record: dict[str, Any]) -> None:
    path, found = record["path"], answers(folder, stem)
    assert path in found, f"{stem}: {path} has no second route"
    tolerance = min(record.get("rel_tol", 1.0), DIGITS[folder])
    assert agrees(path, record["value"], found[path], tolerance), f"second route: {found[path]}"


@each_record
def test_record_judges_the_print_and_says_why(folder: str, stem: str, record: dict[str, Any]) -> None:
    assert ("printed" in record) == ("verdict" in record)
    if "verdict" in record:
        assert record["verdict"] in PRINT_VERDICTS
        assert "why" in record or record["verdict"] == "right"
        assert folder != "balancing" or ("why" in record) == (record["verdict"] != "right")


@each_file
def test_every_answer_of_a_route_is_recorded_once(folder: str, stem: str) -> None:
    paths = [record["path"] for record in records(folder, stem)]
    assert paths
    assert len(paths) == len(set(paths))
    assert folder == "balancing" or set(paths) == set(answers(folder, stem))


@pytest.mark.parametrize("folder", ROUTES)
def test_every_problem_has_a_route_and_every_route_a_file(folder: str) -> None:
    files = {path.stem for path in (PROBLEMS / folder).glob("*.toml")}
    assert {stem for stem in files if stem.startswith(OWN[folder])} == set(ROUTES[folder])


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
    a, b = balancing_routes.printed_weights_leave(left, right)
    said = [record["why"] for record in records("balancing", stem) if "fitted as printed" in record.get("why", "")]
    words = f"fitted as printed, both weights leave {a:.4g} mil at A and {b:.4g} mil at B, where 5 and 4 mil were found"
    assert [one.partition("; ")[2] for one in said] == [words]
