"""Jobs with known masses on a shaft: the tables of their files, and what is read from them as plain numbers."""

from __future__ import annotations

import cmath
from collections.abc import Mapping, Sequence
from dataclasses import field
from typing import Any, ClassVar, Literal

from pydantic import Field, field_validator, model_validator

from vibopt.balancing.parse_machine import read_planes
from vibopt.balancing.planes import UNBALANCE, Corrected, Plane
from vibopt.balancing.rotor_tables import (
    Bounded,
    MadeSmall,
    PlaneTable,
    headed,
    inner,
    known_keys,
    optional_table,
    read_table,
    read_tables,
    unbounded,
    without_bounds,
)
from vibopt.document.mistakes import Mistakes
from vibopt.errors import counted
from vibopt.records import dataclass
from vibopt.values import Fact, Table, number
from vibopt.values.fields import word

_BEARINGS = 'bearings = { A = "0 mm", B = "900 mm" }'
_DIMENSION_OF = {
    "static_unbalance": "unbalance",
    "couple_unbalance": "couple_unbalance",
    "bearing_reaction": "force",
    "correction": "mass",
}


class ShaftTable(Table):
    """[shaft]: bearings by name and place, and the speed of the reactions; all optional.

    Keys
    ----
    speed: At which the reactions of the bearings are taken: `speed = "1500 rpm"`.
    bearings: Two, by name and place along the shaft: `bearings = { A = "0 mm", B = "900 mm" }`.
    """

    speed: Fact | None = number("angular_rate", choice=False)
    bearings: dict[str, Any] = Field(default_factory=dict)

    @field_validator("bearings")
    @classmethod
    def _places(cls, given: dict[str, Any]) -> dict[str, float]:
        if given and len(given) != 2:
            raise word(f"names {counted(len(given), 'bearings')}, but two carry a shaft. Write {_BEARINGS}.")
        places = {name: inner(at, "length") for name, at in given.items()}
        if len(set(places.values())) < len(places):
            raise word(f"has both bearings at the same place. Write {_BEARINGS}.")
        return places


class MassTable(Table):
    """[masses.NAME]: a mass at a radius, or an unbalance, at an angle and an axial place.

    Keys
    ----
    mass: Of the piece, beside its `radius`; or `unbalance` alone.
    radius: Of its centre of mass from the axis.
    unbalance: Mass times radius: `unbalance = "50 kg mm"`.
    angle: Where it is: `angle = "90 deg"`.
    at: Place along the shaft; none anywhere: all in one plane.
    removed: It is a hole: `removed = true`.
    """

    mass: Fact | None = number("mass", choice=False)
    radius: Fact | None = number("length", choice=False)
    unbalance: Fact | None = number("unbalance", choice=False)
    angle: Fact = number("angle", choice=False, sign="any", required=True)
    at: Fact | None = number("length", choice=False, sign="any")
    removed: bool = False

    @model_validator(mode="after")
    def _size(self) -> MassTable:
        if (self.unbalance is None) == (self.mass is None and self.radius is None):
            raise word('needs mass and radius, or an unbalance alone. Write mass = "1 kg" and radius = "50 mm".')
        if self.unbalance is None and (self.mass is None or self.radius is None):
            absent = "radius" if self.radius is None else "mass"
            raise word(f'has no {absent}. Add it, or write unbalance = "50 kg mm" instead of both.')
        return self

    @property
    def phasor(self) -> complex:
        """Unbalance at its angle; material that was removed counts backwards [kg m]."""
        full = self.unbalance.value if self.unbalance is not None else 1.0
        for part in (self.mass, self.radius):
            full *= part.value if part is not None else 1.0
        return cmath.rect(-full if self.removed else full, self.angle.value)


class KnownPlaneTable(PlaneTable):
    """[planes.NAME]: where a correction may be fitted, and what there is to fit.

    Keys
    ----
    at: Place along the shaft.
    radius: Where weights sit, one length or a list to choose from; without it a plane counts in unbalance alone:
        `radius = "50 mm"`.
    weight: The most that may be fitted, `weight = { from = "0 g", to = "60 g" }`; or weights that are fitted, "10 g
        @ 270 deg".
    """

    at: Fact | None = number("length", choice=False, sign="any")
    bare: ClassVar[str] = UNBALANCE


class KnownLimitTable(Bounded):
    """[limits.NAME] or [measures.NAME]: what is left after the correction, or the correction itself.

    Keys
    ----
    response: What is limited or measured.
    of: The bearing of a reaction, or the plane of a correction: `of = "A"`.
    total: Mass of all planes together: `total = true`.
    at_most: The greatest value that is allowed; a measure has none: `at_most = "20 N"`.
    soft: Of a limit, how easily it may be loosened where not all can hold: with `soft = 2` a loosening by 20 % counts
        as one by 10 %. An answer keeps every limit, soft or not. Refused in a measure.
    unit: How the value is shown: `unit = "N"`.
    """

    response: Literal["static_unbalance", "couple_unbalance", "bearing_reaction", "correction"]
    of: str | None = None
    total: bool = False

    @model_validator(mode="after")
    def _bound(self) -> KnownLimitTable:
        if self.at_most is not None:
            inner(self.at_most, self.dimension)
        if self.response == "correction" and (self.of is None) != self.total:
            raise word('needs of = "PLANE" or total = true, one of the two.')
        if self.total and self.response != "correction":
            raise word(f"has total, but {self.response} is not of weights. Leave total out.")
        if self.of is not None and self.response in ("static_unbalance", "couple_unbalance"):
            raise word(f"has of, but {self.response} is of the whole shaft. Leave of out.")
        return self

    @property
    def dimension(self) -> str:
        """Dimension of the response."""
        return _DIMENSION_OF[self.response]


class KnownGoalTable(MadeSmall):
    """[goal] minimise = "unbalance" or "reaction" at the bearings, combined as rms, worst or sum; or one quantity.

    Keys
    ----
    minimise: What is made small; "unbalance" and "reaction" at both bearings.
    combine: Of both bearings: least squares, the greater one, or their sum. Refused beside what is one quantity.
    """

    minimise: Literal["unbalance", "static_unbalance", "couple_unbalance", "reaction", "correction"]
    combine: Literal["rms", "worst", "sum"] = "rms"

    @model_validator(mode="after")
    def _combines(self) -> KnownGoalTable:
        if "combine" in self.model_fields_set and self.minimise not in ("unbalance", "reaction"):
            raise word(f'has combine, but minimise = "{self.minimise}" is one quantity. Leave combine out.')
        return self


KEYS = (
    "title", "statement", "source", "conventions", "shaft", "masses", "planes", "limits", "measures", "goal",
    "scenarios", "expected",
)  # fmt: skip
CONVENTIONS = ("angles", "zero")


@dataclass(frozen=True, slots=True)
class Mass:
    """A known unbalance `u` (complex) [kg m] at the place `at` [m]; material that was removed has the opposite sign."""

    name: str
    u: complex
    at: float


@dataclass(frozen=True, slots=True)
class Bearing:
    """A bearing and its axial place [m]."""

    name: str
    at: float


@dataclass(frozen=True)
class KnownJob(Corrected):
    """Known masses on a shaft, where corrections may go, and what is asked of them.

    flat
        All masses and planes in one plane: there is no couple.
    speed
        For reactions [rad/s]; None where none are asked for.
    limits, measures
        By name; `bound` is in SI.
    goal
        None: an analysis of the shaft as it is.
    """

    kind: ClassVar[str] = "known"
    name: str
    title: str
    masses: tuple[Mass, ...]
    planes: tuple[Plane, ...]
    bearings: tuple[Bearing, ...]
    speed: float | None
    flat: bool
    limits: Mapping[str, KnownLimitTable]
    measures: Mapping[str, KnownLimitTable]
    goal: KnownGoalTable | None
    notes: tuple[str, ...]
    expected: tuple[Mapping[str, Any], ...]
    document: Mapping[str, Any] = field(default_factory=dict)

    @property
    def aim(self) -> str:
        """What is made least; "" for an analysis."""
        return self.goal.minimise if self.goal is not None else ""

    @property
    def results(self) -> tuple[str, ...]:
        """What the paths of that begin which the answer measures."""
        return ("residual." if self.planes else "as_found.",)


def read_known(document: Mapping[str, Any], mistakes: Mistakes) -> KnownJob:
    """A job with known masses from a parsed problem file.

    Parameters
    ----------
    document
        The file as `tomli` gives it.
    mistakes
        Collects what is wrong, with lines.

    Raises
    ------
    InputError
        All mistakes at once.
    """
    known_keys(document, KEYS, mistakes)
    title, expected = headed(document, mistakes)
    shaft = read_table(ShaftTable, document.get("shaft", {}), ("shaft",), mistakes)
    masses = read_tables(document, "masses", MassTable, mistakes)
    planes = read_planes(document, mistakes, KnownPlaneTable)
    limits = read_tables(document, "limits", KnownLimitTable, mistakes)
    measures = read_tables(document, "measures", KnownLimitTable, mistakes)
    goal = optional_table(KnownGoalTable, document, "goal", mistakes)
    notes = _conventions(document.get("conventions", {}), mistakes)
    mistakes.raise_any()
    assert shaft is not None
    assert planes is not None
    _check(shaft, masses, planes, limits, measures, goal, mistakes)
    mistakes.raise_any()
    if not planes:
        goal = None
    elif goal is None:
        goal = KnownGoalTable(minimise="unbalance")
    return KnownJob(
        name=mistakes.name,
        title=title,
        masses=tuple(
            Mass(name, mass.phasor, 0.0 if mass.at is None else mass.at.value) for name, mass in masses.items()
        ),
        planes=planes,
        bearings=tuple(Bearing(n, at) for n, at in shaft.bearings.items()),
        speed=None if shaft.speed is None else shaft.speed.value,
        flat=all(mass.at is None for mass in masses.values()) and all(plane.at is None for plane in planes),
        limits=limits,
        measures=measures,
        goal=goal,
        notes=notes,
        expected=expected,
        document=document,
    )


def _conventions(given: Any, mistakes: Mistakes) -> tuple[str, ...]:
    """What the file says of its angles, as notes for the answer."""
    if not isinstance(given, Mapping):
        mistakes.value(("conventions",), given, "is not a table. Write [conventions] and its keys below it.")
        return ()
    for key, said in given.items():
        if key not in CONVENTIONS:
            mistakes.unknown_key(("conventions", key), list(CONVENTIONS))
        elif not isinstance(said, str):
            mistakes.value(("conventions", key), said, "is not a text. Write it in quotation marks.")
    words = {"angles": "Angles are counted {}.", "zero": "Angle zero is at: {}."}
    return tuple(text.format(given[key]) for key, text in words.items() if isinstance(given.get(key), str))


def _check(
    shaft: ShaftTable,
    masses: Mapping[str, MassTable],
    planes: Sequence[Plane],
    limits: Mapping[str, KnownLimitTable],
    measures: Mapping[str, KnownLimitTable],
    goal: KnownGoalTable | None,
    mistakes: Mistakes,
) -> None:
    """What the tables say of each other."""
    if not masses:
        mistakes.add(("masses",), "there is no mass on the shaft. Write [masses.NAME] with mass, radius and angle.")
    placed: dict[tuple[str, str], MassTable | Plane] = {("masses", n): m for n, m in masses.items()}
    placed.update({("planes", plane.name): plane for plane in planes})
    if any(one.at is not None for one in placed.values()) or shaft.bearings:
        for path, one in placed.items():
            if one.at is None:
                example = 'at = "300 mm"'
                mistakes.add(path, f"{'.'.join(path)} has no axial place. Add it, for example {example}.")
    if goal is not None and goal.minimise == "reaction" and (not shaft.bearings or shaft.speed is None):
        mistakes.add(("goal",), "goal needs [shaft] with bearings and speed to minimise a reaction. Add them.")
    if goal is not None and goal.minimise == "couple_unbalance" and all(one.at is None for one in placed.values()):
        mistakes.add(
            ("goal", "minimise"),
            "goal minimises a couple, but all masses and planes lie in one plane. Write where each is with at, or "
            'minimise = "static_unbalance".',
        )
    unbounded(limits, mistakes)
    without_bounds(measures, mistakes)
    for family, tables in (("limits", limits), ("measures", measures)):
        for name, table in tables.items():
            _check_limit((family, name), table, shaft, planes, mistakes)


def _check_limit(
    path: tuple[str, str],
    table: KnownLimitTable,
    shaft: ShaftTable,
    planes: Sequence[Plane],
    mistakes: Mistakes,
) -> None:
    """Whether a limit speaks of something that is there."""
    if table.response == "bearing_reaction":
        if not shaft.bearings or shaft.speed is None:
            example = 'bearings = { A = "0 mm", B = "900 mm" } and speed = "1500 rpm"'
            mistakes.add(path, f"{'.'.join(path)} needs [shaft] with {example}.")
        elif table.of is not None and table.of not in shaft.bearings:
            mistakes.unknown_name((*path, "of"), table.of, "bearing", list(shaft.bearings))
    elif (
        table.response == "correction"
        and table.of is not None
        and table.of not in (names := [plane.name for plane in planes])
    ):
        mistakes.unknown_name((*path, "of"), table.of, "plane", names)
