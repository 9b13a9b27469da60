"""Tables of a measured rotor's file: which keys there are; values with words of their own are read next door."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from pydantic import ValidationError

from vibopt.document.mistakes import Mistakes, Path, take
from vibopt.errors import QuantityError
from vibopt.values import Fact, Table, number

TOP = [
    "title", "statement", "source", "conventions", "planes", "sensors", "runs", "readings", "influence", "speed",
    "scatter", "pairs", "limits", "goal", "rotor", "quality", "expected",
]  # fmt: skip

Kind = TypeVar("Kind", bound=Table)


class DrillTable(Table):
    """`drill` of a plane: what takes the mass away."""

    diameter: Fact = number("length", choice=False, required=True)
    density: Any = None
    deepest: Fact | None = number("length", choice=False)


class PlaneTable(Table):
    """[planes.NAME]: where weights may be set or mass removed."""

    radius: Any = None
    weight: Any = None
    unbalance: Any = None
    holes: Any = None
    shelf: Any = None
    most_weights: Any = 1
    split: bool = False
    forbidden: Any = None
    remove: bool = False
    drill: Any = None
    keep: bool = False


class SensorTable(Table):
    """[sensors.NAME]: where vibration is read."""

    unit: str | None = None
    runout: Any = None
    importance: Fact | None = number("ratio", choice=False, sign="not negative")


class RunTable(Table):
    """[[runs]]: readings at one speed, and the weights that were on."""

    name: str | None = None
    speed: Fact | None = number("angular_rate", choice=False)
    weights: Any = None
    stayed: bool = False
    verification: bool = False
    readings: Any = None


class InfluenceTable(Table):
    """[[influence]]: an influence coefficient that is known already."""

    speed: Fact | None = number("angular_rate", choice=False)
    sensor: str
    plane: str
    value: Any


class ScatterTable(Table):
    """[scatter]: one standard deviation of one reading, of its amplitude and of its angle."""

    amplitude: Any = None
    angle: Any = None


class PairTable(Table):
    """[pairs.NAME]: two planes that get equal unbalances at the same or at opposite angles."""

    planes: Any
    kind: str


class ResidualLimit(Table):
    """[limits.NAME] on what will be left at the sensors."""

    response: str
    at: str | None = None
    speed: Fact | None = number("angular_rate", choice=False)
    at_most: Any


class CorrectionLimit(Table):
    """[limits.NAME] on the weights themselves."""

    response: str
    of: str | None = None
    total: bool = False
    at_most: Any


class GoalTable(Table):
    """[goal]: what is made small, and how it is combined."""

    minimise: str
    combine: str | None = None
    huber_at: Any = None
    robust: str | None = None


class RotorTable(Table):
    """[rotor]: mass and speed of the rotor."""

    mass: Fact = number("mass", choice=False, required=True)
    speed: Fact | None = number("angular_rate", choice=False)
    trial_force: Fact | None = number("ratio", choice=False)


class QualityTable(Table):
    """[quality]: a balance quality grade, and what its tolerances depend on."""

    grade: Fact = number("velocity", choice=False, required=True)
    mass: Fact | None = number("mass", choice=False)
    speed: Fact | None = number("angular_rate", choice=False)
    centre_of_mass: Fact = number("length", choice=False, sign="any", required=True)
    bearings: Any
    planes: Any = None
    measurement_error: Any = None
    residual: Any = None
    least_share: Fact | None = number("ratio", choice=False, sign="not negative")
    most_share: Fact | None = number("ratio", choice=False)


def read_table(kind: type[Kind], table: object, path: Path, mistakes: Mistakes) -> Kind | None:
    """A table of the file with its keys checked; None, and the mistakes noted, where something is wrong."""
    if not isinstance(table, Mapping):
        mistakes.value(path, table, "is not a table.")
        return None
    try:
        return kind.model_validate(dict(table))
    except ValidationError as error:
        take(error, path, table, mistakes, kind)
        return None


def read_value(path: Path, given: object, mistakes: Mistakes, read: Any, *more: Any) -> Any:
    """read(given, *more), or None with the complaint noted at `path`."""
    try:
        return read(given, *more)
    except QuantityError as error:
        mistakes.value(path, given, error.complaint)
        return None


def named_tables(document: Mapping[str, Any], family: str, mistakes: Mistakes) -> Mapping[str, Any]:
    """The tables of a family by name; a mistake where the family is none."""
    tables = document.get(family, {})
    if isinstance(tables, Mapping):
        return tables
    mistakes.value((family,), tables, f"is not a table. Write [{family}.NAME].")
    return {}


def listed_tables(document: Mapping[str, Any], family: str, mistakes: Mistakes) -> list[Any]:
    """The tables of a list of tables; a mistake where it is no list."""
    tables = document.get(family, [])
    if isinstance(tables, list):
        return tables
    mistakes.value((family,), tables, f"is not a list of tables. Write [[{family}]].")
    return []
