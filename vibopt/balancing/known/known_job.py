"""A job with known masses, read from its file into plain numbers."""

from __future__ import annotations

import cmath
from collections.abc import Mapping
from dataclasses import field, replace
from math import inf, pi
from typing import Any, ClassVar, TypeVar

from vibopt.balancing.fitted import with_fitted
from vibopt.balancing.known.known_tables import (
    KnownGoalTable,
    KnownLimitTable,
    KnownPlaneTable,
    MassTable,
    ShaftTable,
)
from vibopt.balancing.planes import MASS, UNBALANCE, Drill, Plane
from vibopt.balancing.rotor_tables import named_tables, read_table
from vibopt.document.mistakes import Mistakes
from vibopt.records import dataclass
from vibopt.values import Choice, Table

KEYS = (
    "title", "statement", "source", "conventions", "shaft", "masses", "planes", "limits", "measures", "goal",
    "expected",
)  # fmt: skip
CONVENTIONS = ("angles", "zero")
Kind = TypeVar("Kind", bound=Table)


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


@dataclass(frozen=True, slots=True)
class Spot:
    """A correction plane and its axial place [m]."""

    plane: Plane
    at: float


@dataclass(frozen=True)
class KnownJob:
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
    views: ClassVar[str] = "vibopt.balancing.plan_views"
    name: str
    title: str
    masses: tuple[Mass, ...]
    spots: tuple[Spot, ...]
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
    def choices(self) -> tuple[str, ...]:
        """Paths of the numbers that the answer chooses."""
        free = [one.plane for one in self.spots if one.plane.is_open]
        return tuple(f"planes.{one.name}.{word}" for one in free for word in one.chosen_words)

    @property
    def aim(self) -> str:
        """What is made least; "" for an analysis."""
        return self.goal.minimise if self.goal is not None else ""

    @property
    def decided_at(self) -> tuple[str, ...]:
        """Where the weights stand that are chosen freely, once they are decided."""
        free = [one.plane for one in self.spots if one.plane.is_open and not one.plane.shelf]
        return tuple(f"planes.{one.name}.{one.kind_word}." for one in free)

    def beyond(self, decided: KnownJob) -> list[str]:
        """Planes whose decided weights are not among those that this job may choose, by path."""
        pairs = [(mine.plane, its.plane) for mine, its in zip(self.spots, decided.spots, strict=True)]
        return [f"planes.{mine.name}" for mine, its in pairs if mine.is_open and not mine.allows(its.fitted or ())]

    @property
    def results(self) -> tuple[str, ...]:
        """What the paths of that begin which the answer measures."""
        return ("residual." if self.spots else "as_found.",)


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
    for key in document:
        if key not in KEYS:
            mistakes.unknown_key((key,), list(KEYS))
    shaft = read_table(ShaftTable, document.get("shaft", {}), ("shaft",), mistakes)
    masses = read_tables(document, "masses", MassTable, mistakes)
    planes = read_tables(document, "planes", KnownPlaneTable, mistakes)
    limits = read_tables(document, "limits", KnownLimitTable, mistakes)
    measures = read_tables(document, "measures", KnownLimitTable, mistakes)
    goal = read_table(KnownGoalTable, document["goal"], ("goal",), mistakes) if "goal" in document else None
    notes = _conventions(document.get("conventions", {}), mistakes)
    mistakes.raise_any()
    assert shaft is not None
    _check(shaft, masses, planes, limits, measures, goal, mistakes)
    mistakes.raise_any()
    given = document.get("planes", {})
    spots = tuple(
        Spot(with_fitted(("planes", name), plane_of(name, one), given[name], mistakes), _at(one))
        for name, one in planes.items()
    )
    mistakes.raise_any()
    if not planes:
        goal = None
    elif goal is None:
        goal = KnownGoalTable(minimise="unbalance")
    return KnownJob(
        name=mistakes.name,
        title=str(document.get("title", mistakes.name)),
        masses=tuple(Mass(n, cmath.rect(m.size, m.angle.value), _at(m)) for n, m in masses.items()),
        spots=spots,
        bearings=tuple(Bearing(n, at) for n, at in shaft.bearings.items()),
        speed=None if shaft.speed is None else shaft.speed.value,
        flat=all(m.at is None for m in masses.values()) and all(p.at is None for p in planes.values()),
        limits=limits,
        measures=measures,
        goal=goal,
        notes=notes,
        expected=tuple(document.get("expected", ())),
        document=document,
    )


def plane_of(name: str, table: KnownPlaneTable) -> Plane:
    """The plane in SI; a drill that must not go deeper caps its mass."""
    kind = MASS if table.radius is not None else UNBALANCE
    drill = table.drill and Drill(
        table.drill.diameter.value, table.drill.density.value, table.drill.deepest.value if table.drill.deepest else inf
    )
    cap = table.weight.high if isinstance(table.weight, Choice) else inf
    if isinstance(table.unbalance, Choice):
        cap = min(cap, table.unbalance.high / (table.radius.value if table.radius is not None else 1.0))
    if drill and drill.deepest < inf:
        cap = min(cap, drill.deepest * drill.density * 0.25 * pi * drill.diameter**2)
    unit = table.weight.unit if isinstance(table.weight, Choice) else ""
    plane = Plane(name, kind, unit=unit, cap=cap, remove=table.remove, keep=table.keep, drill=drill or None)
    return replace(
        plane,
        radii=(table.radius.value,) if table.radius is not None else (),
        length_unit=table.radius.unit if table.radius is not None else "mm",
        holes=tuple(table.holes or ()),
        shelf=table.weights,
        most_weights=table.most_weights,
        forbidden=tuple(table.forbidden),
    )


def read_tables(document: Mapping[str, Any], family: str, kind: type[Kind], mistakes: Mistakes) -> dict[str, Kind]:
    """All tables [family.NAME] by name."""
    given = named_tables(document, family, mistakes)
    found = {name: read_table(kind, table, (family, name), mistakes) for name, table in given.items()}
    return {name: table for name, table in found.items() if table is not None}


def _at(table: MassTable | KnownPlaneTable) -> float:
    return 0.0 if table.at is None else table.at.value


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
    planes: Mapping[str, KnownPlaneTable],
    limits: Mapping[str, KnownLimitTable],
    measures: Mapping[str, KnownLimitTable],
    goal: KnownGoalTable | None,
    mistakes: Mistakes,
) -> None:
    """What the tables say of each other."""
    if not masses:
        mistakes.add(("masses",), "there is no mass on the shaft. Write [masses.NAME] with mass, radius and angle.")
    placed: dict[tuple[str, str], MassTable | KnownPlaneTable] = {("masses", n): m for n, m in masses.items()}
    placed.update({("planes", n): p for n, p in planes.items()})
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
    for family, tables in (("limits", limits), ("measures", measures)):
        for name, table in tables.items():
            _check_limit((family, name), table, shaft, planes, mistakes)


def _check_limit(
    path: tuple[str, str],
    table: KnownLimitTable,
    shaft: ShaftTable,
    planes: Mapping[str, KnownPlaneTable],
    mistakes: Mistakes,
) -> None:
    """Whether a limit speaks of something that is there."""
    if path[0] == "limits" and table.at_most is None:
        mistakes.add(path, f"limits.{path[1]} has no bound. Write at_most, or move it to [measures.{path[1]}].")
    if table.response == "bearing_reaction":
        if not shaft.bearings or shaft.speed is None:
            example = 'bearings = { A = "0 mm", B = "900 mm" } and speed = "1500 rpm"'
            mistakes.add(path, f"{'.'.join(path)} needs [shaft] with {example}.")
        elif table.of is not None and table.of not in shaft.bearings:
            mistakes.unknown_name((*path, "of"), table.of, "bearing", list(shaft.bearings))
    elif table.response == "correction" and table.of is not None and table.of not in planes:
        mistakes.unknown_name((*path, "of"), table.of, "plane", list(planes))
