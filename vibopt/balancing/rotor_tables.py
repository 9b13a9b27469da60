"""Tables of a measured rotor's file: which keys there are; values with words of their own are read next door."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from pydantic import model_validator

from vibopt.balancing.planes import MASS
from vibopt.document.mistakes import NO_TABLE, Mistakes, Path, dotted, named_tables, records_in, text_in, validated
from vibopt.errors import QuantityError, way_out
from vibopt.units import DIMENSIONS, read_quantity, si_unit
from vibopt.units.parsing import LARGEST
from vibopt.values import Fact, Table, number
from vibopt.values.fields import complaint, word
from vibopt.values.grade import grade_velocity
from vibopt.values.probability import ProbabilityOfRotors
from vibopt.values.soft import Soft

if TYPE_CHECKING:
    from typing import Self

TOP = [
    "title", "statement", "source", "conventions", "planes", "sensors", "runs", "readings", "influence", "speed",
    "scatter", "pairs", "limits", "goal", "rotor", "quality", "scenarios", "expected",
]  # fmt: skip

Kind = TypeVar("Kind", bound=Table)


class DrillTable(Table):
    """`drill` of a plane: what takes the mass away.

    Keys
    ----
    diameter: Of the drill.
    density: Of the material: `density = "7850 kg/m³"`.
    deepest: The deepest hole that is allowed.
    """

    diameter: Fact = number("length", choice=False, required=True)
    density: Fact = number("density", choice=False, required=True)
    deepest: Fact | None = number("length", choice=False)


class PlaneTable(Table):
    """[planes.NAME]: where weights may be set or mass removed.

    Keys
    ----
    radius: Where weights sit, one length or a list to choose from; without it a plane counts in mass alone: `radius
        = "150 mm"`.
    weight: The most that may be fitted, `weight = { from = "0 g", to = "60 g" }`; or weights that are fitted here
        and of which nothing is chosen, ["10 g in hole 7", "5 g @ 20 deg"].
    unbalance: Instead of `weight` the most mass times radius: `unbalance = { from = "0 g mm", to = "5000 g mm" }`.
    holes: A count, the first hole at 0 deg, or their angles: `holes = 24`. Needs a shelf, split weights or given
        weights.
    shelf: The weights there are, one a hole; { mass = "5 g", stock = 3 } for so many in all planes: `shelf = ["5
        g", "10 g", "20 g"]`.
    most_weights: How many weights may be fitted in this plane: `most_weights = 2`.
    split: The weight is cut in two for the neighbouring holes, instead of a shelf: `split = true`. Never across a
        gap of 180 deg or more.
    forbidden: Sectors without weights; "350..10 deg" goes through zero: `forbidden = ["80..110 deg"]`.
    remove: Material is taken away, on the other side: `remove = true`. Beside a shelf only in its masses.
    drill: Says the depth of what is removed: `drill = { diameter = "10 mm", density = "7850 kg/m³", deepest = "20
        mm" }`.
    keep: The plane stays untouched: `keep = true`.
    """

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
    bare: ClassVar[str] = MASS
    """What a plane without a radius counts in."""


class SensorTable(Table):
    """[sensors.NAME]: where vibration is read.

    Keys
    ----
    unit: Of readings that are written without one: `unit = "mil"`.
    runout: Subtracted from every reading: `runout = "0.4 mil pp @ 20 deg"`.
    importance: Factor of this sensor in the goal alone; tables show what it reads: `importance = 2`.
    added_to: Another sensor, to whose amplitude this one is added wherever it is limited, and in the worst: forward
        and backward whirl of a place add up to the greater half axis of its orbit: `added_to = "first_forward"`.
    """

    unit: str | None = None
    runout: Any = None
    importance: Fact | None = number("ratio", choice=False, sign="not negative")
    added_to: str | None = None


class RunTable(Table):
    """[[runs]]: readings at one speed, and the weights that were on.

    Keys
    ----
    name: Of the run: `name = "trial left"`.
    speed: Of the run, or once at the top of the file; within 1 % is the same speed: `speed = "1200 rpm"`.
    weights: What was fitted, by plane: `weights = { left = "10 g @ 270 deg" }`; also "10 g in hole 7", a radius, an
        unbalance or a list. The first run of each speed has none.
    stayed: The weights of the run before were still on: `stayed = true`.
    verification: These weights are the correction and stay on; the plan says the trim: `verification = true`.
    readings: By sensor, amplitude and angle: `readings = { a = "5.9 mil @ 123 deg" }`.
    """

    name: str | None = None
    speed: Fact | None = number("angular_rate", choice=False)
    weights: Any = None
    stayed: bool = False
    verification: bool = False
    readings: Any = None


class InfluenceTable(Table):
    """[[influence]]: an influence coefficient that is known already.

    Keys
    ----
    speed: At which it holds: `speed = "1200 rpm"`.
    sensor: That reads it: `sensor = "a"`.
    plane: Where the weight sits: `plane = "left"`.
    value: Reading for a weight: `value = "0.76 mil pp/g @ 290 deg"`.
    """

    speed: Fact | None = number("angular_rate", choice=False)
    sensor: str
    plane: str
    value: Any


class ScatterTable(Table):
    """[scatter]: one standard deviation of one reading, of its amplitude and of its angle.

    Keys
    ----
    amplitude: One standard deviation of one reading: `amplitude = "3 %"`, or a vibration.
    angle: One standard deviation of its angle: `angle = "2 deg"`.
    """

    amplitude: Any = None
    angle: Any = None


class PairTable(Table):
    """[pairs.NAME]: two planes with equal unbalances, at one angle or at opposite ones. One run of both is enough.

    Keys
    ----
    planes: The two planes: `planes = ["left", "right"]`. A plane is in one pair only.
    kind: "static": both weights on the same side; "couple": on opposite sides.
    """

    planes: Any
    kind: str


class ResidualLimit(Table):
    """[limits.NAME] on what will be left at the sensors.

    Keys
    ----
    response: What is limited: `response = "residual"`.
    at: One sensor; every one without it: `at = "a"`.
    speed: One speed; every one without it: `speed = "1200 rpm"`.
    at_most: The greatest vibration that may be left: `at_most = "2 mil pp"`.
    soft: How easily it may be loosened where not all limits can hold: with `soft = 2` a loosening by 20 % counts as
        one by 10 %. An answer keeps every limit, soft or not.
    with_probability: The share of all rotors that the scatter of the readings leaves possible which shall keep it:
        `with_probability = "99 %"`. Without it what is predicted does.
    """

    response: str
    at: str | None = None
    speed: Fact | None = number("angular_rate", choice=False)
    at_most: Any
    soft: Soft = None
    with_probability: ProbabilityOfRotors = None


class CorrectionLimit(Table):
    """[limits.NAME] on the weights themselves.

    Keys
    ----
    response: What is limited: `response = "correction"`.
    of: The plane: `of = "left"`. One of `of` and `total`.
    total: All planes together: `total = true`.
    at_most: The greatest mass: `at_most = "80 g"`.
    """

    response: str
    of: str | None = None
    total: bool = False
    at_most: Any


class MadeSmall(Table):
    """A goal of balancing: something is made small; `most_room` says what to write for room in the limits."""

    most_room: ClassVar[str] = "For the most room in the limits minimise what the nearest of them speaks of."

    @model_validator(mode="before")
    @classmethod
    def _small(cls, given: Any) -> Any:
        if isinstance(given, Mapping) and "maximise" in given:
            raise word(f"has maximise, but balancing makes something small. {cls.most_room}")
        return given


class GoalTable(MadeSmall):
    """[goal]: what is made small, and how it is combined.

    Keys
    ----
    minimise: What is left at the sensors, or the mass that keeps the limits: `minimise = "residual"`, or
        "correction".
    combine: Of all sensors and speeds: "rms" (least squares), "worst", "sum" or "huber": `combine = "worst"`.
    huber_at: Where huber turns from squares to sums: `huber_at = "1 mil pp"`. Only beside combine = "huber".
    robust: Over the scatter: the "worst" of it or the "mean": `robust = "worst"`. Needs scatter.
    """

    most_room: ClassVar[str] = (
        'For the most room in the limits on what is left write minimise = "residual" and combine = "worst", and '
        "importance in the sensors where their bounds differ; caps just hold."
    )
    minimise: str
    combine: str | None = None
    huber_at: Any = None
    robust: str | None = None


class RotorTable(Table):
    """[rotor]: mass and speed of the rotor.

    Keys
    ----
    mass: Of the rotor.
    speed: For the first trial weight.
    trial_force: Centrifugal force of the first trial weight over the weight on its plane: `trial_force = "10 %"`.
    """

    mass: Fact = number("mass", choice=False, required=True)
    speed: Fact | None = number("angular_rate", choice=False)
    trial_force: Fact | None = number("ratio", choice=False)


class QualityTable(Table):
    """[quality]: a balance quality grade, and what its tolerances depend on.

    Keys
    ----
    grade: The permissible velocity of the centre of mass, from your standard; no table is shipped: `grade = "6.3
        mm/s"`, which "G6.3" means too.
    mass: Of the rotor.
    speed: Its highest service speed.
    centre_of_mass: Its place along the shaft: `centre_of_mass = "450 mm"`.
    bearings: Places of the two: `bearings = { A = "0 mm", B = "900 mm" }`.
    planes: Places of the planes: `planes = { left = "150 mm", right = "750 mm" }`.
    measurement_error: Of the residual unbalance in each plane, one for all: `measurement_error = "20 g mm"`.
    residual: Unbalances that were measured on a balancing machine: `residual = { left = "300 g mm @ 20 deg", right
        = "200 g mm @ 100 deg" }`.
    least_share: Least part of the permissible unbalance that a bearing gets: `least_share = "30 %"`.
    most_share: Greatest part that a bearing gets: `most_share = "70 %"`.
    """

    grade: Fact = number("velocity", choice=False, required=True)
    mass: Fact | None = number("mass", choice=False)
    speed: Fact | None = number("angular_rate", choice=False)
    centre_of_mass: Fact = number("length", choice=False, sign="any", required=True)
    bearings: Any
    planes: Any = None
    measurement_error: Fact | None = number("unbalance", choice=False, sign="not negative")
    residual: Any = None
    least_share: Fact | None = number("ratio", choice=False, sign="not negative")
    most_share: Fact | None = number("ratio", choice=False)

    @model_validator(mode="before")
    @classmethod
    def _grade_by_its_name(cls, given: Any) -> Any:
        return {**given, "grade": grade_velocity(given["grade"])} if "grade" in given else given


def read_table(kind: type[Kind], table: object, path: Path, mistakes: Mistakes) -> Kind | None:
    """A table of the file with its keys checked; None, and the mistakes noted, where something is wrong."""
    if not isinstance(table, Mapping):
        mistakes.value(path, table, NO_TABLE.format(dotted(path)))
        return None
    return validated(kind, path, dict(table), mistakes)


def optional_table(kind: type[Kind], document: Mapping[str, Any], key: str, mistakes: Mistakes) -> Kind | None:
    """A table at the top of the file; None where there is none, or where something in it is wrong."""
    return read_table(kind, document[key], (key,), mistakes) if key in document else None


def read_value(path: Path, given: object, mistakes: Mistakes, read: Any, *more: Any) -> Any:
    """read(given, *more), or None with the complaint noted at `path`."""
    try:
        return read(given, *more)
    except QuantityError as error:
        mistakes.value(path, given, error.complaint)
        return None


def read_each(path: Path, given: object, mistakes: Mistakes, read: Any, *more: Any) -> list[Any]:
    """Every value of a list, or the only one, read; those that were complained about are left out."""
    every = [((*path, k), one) for k, one in enumerate(given)] if isinstance(given, list) else [(path, given)]
    return [found for at, one in every if (found := read_value(at, one, mistakes, read, *more)) is not None]


def positive(given: object, dimension: str) -> tuple[float, str]:
    """A value in SI that is greater than zero, and its unit."""
    quantity = read_quantity(given, dimension)
    if not quantity.value > 0.0:
        raise QuantityError(
            f'is not greater than zero. Write a positive value, for example "{DIMENSIONS[dimension].example}".'
        )
    return quantity.value, quantity.unit


def one_of(path: Path, given: object, known: Sequence[str], what: str, mistakes: Mistakes) -> bool:
    """Whether a word is one of those known; a mistake where it is not."""
    if given not in known:
        mistakes.value(path, given, f"is no {what}.{way_out(str(given), list(known))}")
    return given in known


def place_of(path: Path, name: str, what: str, known: Sequence[str], mistakes: Mistakes) -> int | None:
    """Index of a plane or a sensor by its name; None, and the mistake noted, where the job has none of that name."""
    if name in known:
        return list(known).index(name)
    mistakes.value(path, name, f"names no {what} of this job.{way_out(name, list(known))}")
    return None


def inner(given: object, dimension: str, read: Callable[..., float] | None = None) -> float:
    """A value inside a list or a table without a field of its own, in SI; `read` reads it where it is no quantity."""
    try:
        return read_quantity(given, dimension).value if read is None else read(given)
    except QuantityError as error:
        said = error.complaint
        raise complaint(f'holds "{given}", which {said}' if isinstance(given, str) else said) from None


class Bounded(Table):
    """A table with `at_most`, whose dimension is known."""

    at_most: Any = None
    soft: Soft = None
    unit: str = ""

    @property
    def dimension(self) -> str:
        raise NotImplementedError

    @property
    def bound(self) -> float:
        """at_most in SI; inf for a measure."""
        return inf if self.at_most is None else inner(self.at_most, self.dimension)

    def at(self, bound: float) -> Self:
        """The same with another bound [SI]; without one where it is beyond what any machine has."""
        text = f"{bound!r} {si_unit(self.dimension)}" if bound <= LARGEST else None
        return self.model_copy(update={"at_most": text})


def without_bounds(tables: Mapping[str, Bounded], mistakes: Mistakes) -> None:
    """Measures that have a bound, or say how easily it may be loosened."""
    for name, table in tables.items():
        if table.at_most is not None:
            way = f"but a measure has none. Move it to [limits.{name}]"
            mistakes.add(("measures", name, "at_most"), f"measures.{name} has a bound (at_most), {way}.")
        if table.soft is not None:
            way = "soft weighs the loosening of a limit. Remove soft"
            mistakes.add(("measures", name, "soft"), f"measures.{name} has soft, but no bound to loosen: {way}.")


def unbounded(tables: Mapping[str, Bounded], mistakes: Mistakes) -> None:
    """Limits that have no bound."""
    for name, table in tables.items():
        if table.at_most is None:
            way = f"Write at_most, or move it to [measures.{name}]."
            mistakes.add(("limits", name), f"limits.{name} has no bound. {way}")


def known_keys(document: Mapping[str, Any], known: Sequence[str], mistakes: Mistakes) -> None:
    """Mistakes of keys at the top that there are not."""
    for key in document:
        if key not in known:
            mistakes.unknown_key((key,), list(known))


def headed(document: Mapping[str, Any], mistakes: Mistakes) -> tuple[str, tuple[Mapping[str, Any], ...]]:
    """The title, or the name of the file, and its records; `statement` and `source` are for who reads the file."""
    title, *_ = (text_in(document, key, mistakes.name, mistakes) for key in ("title", "statement", "source"))
    return title, records_in(document, mistakes)


def read_tables(document: Mapping[str, Any], family: str, kind: type[Kind], mistakes: Mistakes) -> dict[str, Kind]:
    """All tables [family.NAME] by name."""
    given = named_tables(document, family, mistakes)
    found = {name: read_table(kind, table, (family, name), mistakes) for name, table in given.items()}
    return {name: table for name, table in found.items() if table is not None}


def listed_tables(document: Mapping[str, Any], family: str, mistakes: Mistakes) -> list[Any]:
    """The tables of a list of tables; a mistake where it is no list."""
    tables = document.get(family, [])
    if isinstance(tables, list):
        return tables
    mistakes.value((family,), tables, f"is not a list of tables. Write [[{family}]].")
    return []
