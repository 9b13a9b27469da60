"""A reciprocating engine, read from its file into plain numbers."""

from __future__ import annotations

import cmath
from collections.abc import Mapping, Sequence
from dataclasses import field
from math import inf, tau
from typing import Any, ClassVar

from vibopt.balancing.engine.engine_tables import (
    BalanceShaftTable,
    CounterweightTable,
    CylinderTable,
    EngineGoalTable,
    EngineLimitTable,
    EngineTable,
)
from vibopt.balancing.engine.throws import check_firing, check_throws, throws_of
from vibopt.balancing.rotor_tables import (
    headed,
    known_keys,
    listed_tables,
    optional_table,
    read_table,
    read_tables,
    unbounded,
    without_bounds,
)
from vibopt.document.mistakes import Mistakes
from vibopt.errors import counted
from vibopt.records import dataclass
from vibopt.units.showing import show_angle
from vibopt.values import Choice, Fact

_HAIR = 1e-9
_TEXTBOOK = 2
"""Orders of truncated kinematics."""
RECIPROCATING, ROTATING = "counterweight_share", "rotating_share"
KEYS = (
    "title", "statement", "source", "engine", "cylinders", "counterweights", "balance_shafts", "limits", "measures",
    "goal", "scenarios", "expected",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Cylinder:
    """One cylinder.

    throw
        Index of its crank throw; cylinders on one throw share its angle.
    bank
        Direction of its axis from that of bank zero, in the sense of rotation [rad].
    at
        Place along the crankshaft, from the reference of the couples [m].
    reciprocating, rotating
        Mass times crank radius [kg m].
    """

    throw: int
    bank: float
    at: float
    reciprocating: float
    rotating: float


@dataclass(frozen=True, slots=True)
class Weight:
    """An unbalance that turns `order` times as fast as the crank, +1 with it or -1 against it.

    fixed
        Complex unbalance at crank angle zero [kg m]; None where it is chosen up to `cap`.
    """

    name: str
    family: str
    order: int
    sense: int
    at: float
    fixed: complex | None
    cap: float
    unit: str


@dataclass(frozen=True, slots=True)
class Share:
    """The share of one kind of mass that a counterweight opposite each crank carries, from `low` to `high`.

    name
        "counterweight_share" (of the reciprocating mass) or "rotating_share" (of the rotating mass).
    """

    name: str
    low: float
    high: float

    @property
    def is_free(self) -> bool:
        return self.low < self.high

    def of(self, cylinder: Cylinder) -> float:
        """The mass times crank radius that it is a share of [kg m]."""
        return cylinder.rotating if self.name == ROTATING else cylinder.reciprocating


@dataclass(frozen=True)
class EngineJob:
    """An engine, what may be chosen, and what is asked.

    cranks
        Crank angle per throw [rad]; None where it is chosen from `offered`.
    ratio
        Crank radius over rod length.
    reference
        Place of the reference of the couples as the file counts places [m].
    spaced
        Whether places come from a spacing, counted from cylinder 1.
    fires
        Firing order as given, cylinder numbers from 1; empty where none is given.
    shares
        Of the reciprocating and of the rotating mass, what a counterweight opposite each crank carries; empty: no such
        counterweights.
    notes
        How changes of it were read, for the answer.
    """

    kind: ClassVar[str] = "engine"
    name: str
    title: str
    speed: float
    ratio: float
    orders: int
    truncated: bool
    cylinders: tuple[Cylinder, ...]
    cranks: tuple[float | None, ...]
    offered: tuple[float, ...]
    shares: tuple[Share, ...]
    weights: tuple[Weight, ...]
    fires: tuple[int, ...]
    strokes: int
    even_firing: bool
    limits: Mapping[str, EngineLimitTable]
    measures: Mapping[str, EngineLimitTable]
    goal: EngineGoalTable | None
    expected: tuple[Mapping[str, Any], ...]
    reference: float = 0.0
    spaced: bool = False
    document: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    results: ClassVar[tuple[str, ...]] = ("orders.1.", "orders.2.", "all_orders.")

    @property
    def aim(self) -> str:
        """What is made least; "" for an analysis."""
        return self.goal.minimise if self.goal is not None else ""

    @property
    def decided_at(self) -> tuple[str, ...]:
        """Where the numbers stand that are chosen freely, once they are decided."""
        free = [f"{weight.family}.{weight.name}" for weight in self.weights if weight.fixed is None]
        shares = [f"engine.{share.name}" for share in self.shares if share.is_free]
        return (*shares, *(f"{one}.{word}" for one in free for word in ("unbalance", "angle")))

    @property
    def open_at(self) -> tuple[str, ...]:
        """Where all that is chosen stands once it is decided, the cranks too."""
        return (*(path for path in self.choices if path.startswith("cylinders.")), *self.decided_at)

    def beyond(self, decided: EngineJob) -> list[str]:
        """Shares and weights that are decided beyond what this job may choose, by path."""
        shares = zip(self.shares, decided.shares, strict=True)
        weights = zip(self.weights, decided.weights, strict=True)
        found = [f"engine.{mine.name}" for mine, its in shares if not mine.low - _HAIR <= its.low <= mine.high + _HAIR]
        return found + [
            f"{mine.family}.{mine.name}" for mine, its in weights
            if mine.fixed is None and abs(its.fixed or 0.0) > mine.cap * (1.0 + _HAIR)
        ]  # fmt: skip

    @property
    def choices(self) -> tuple[str, ...]:
        """Paths of the numbers that the answer chooses."""
        throws = [k for k, cylinder in enumerate(self.cylinders) if self.cranks[cylinder.throw] is None]
        free = [f"{weight.family}.{weight.name}" for weight in self.weights if weight.fixed is None]
        return (
            *(f"cylinders.{k + 1}.crank" for k in throws),
            *(share.name for share in self.shares if share.is_free),
            *(f"{one}.{word}" for one in free for word in ("unbalance", "angle")),
        )

    @property
    def is_search(self) -> bool:
        """Whether crank angles are chosen."""
        return any(crank is None for crank in self.cranks)

    def tops(self, cranks: Sequence[float]) -> list[float]:
        """Turn of the crankshaft at which each piston is on top [rad]; `cranks` per throw."""
        return [(cylinder.bank - cranks[cylinder.throw]) % tau for cylinder in self.cylinders]


def read_engine(document: Mapping[str, Any], mistakes: Mistakes) -> EngineJob:
    """An engine from a parsed problem file.

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
    heading = headed(document, mistakes)
    if "engine" not in document:
        mistakes.add(("cylinders",), "there are cylinders but no [engine]. Write [engine] with stroke, rod and speed.")
        mistakes.raise_any()
    engine = read_table(EngineTable, document["engine"], ("engine",), mistakes)
    listed = [
        read_table(CylinderTable, table, ("cylinders", k), mistakes)
        for k, table in enumerate(listed_tables(document, "cylinders", mistakes))
    ]
    cylinders = [cylinder_table for cylinder_table in listed if cylinder_table is not None]
    weights: dict[str, Weights] = {
        "counterweights": read_tables(document, "counterweights", CounterweightTable, mistakes),
        "balance_shafts": read_tables(document, "balance_shafts", BalanceShaftTable, mistakes),
    }
    limits = read_tables(document, "limits", EngineLimitTable, mistakes)
    measures = read_tables(document, "measures", EngineLimitTable, mistakes)
    without_bounds(measures, mistakes)
    goal = optional_table(EngineGoalTable, document, "goal", mistakes)
    mistakes.raise_any()
    assert engine is not None
    asked = limits, measures, goal
    _check(engine, cylinders, weights, asked, mistakes)
    mistakes.raise_any()
    job = _job(document, mistakes.name, heading, engine, cylinders, weights, asked)
    if not job.is_search:
        check_firing(engine, job.tops([0.0 if crank is None else crank for crank in job.cranks]), mistakes)
        mistakes.raise_any()
    return job


Tables = Mapping[str, EngineLimitTable]
Asked = tuple[Tables, Tables, EngineGoalTable | None]
"""Limits, measures and goal."""
Weights = Mapping[str, CounterweightTable]


def _job(
    document: Mapping[str, Any], name: str, heading: tuple[str, tuple[Mapping[str, Any], ...]], engine: EngineTable,
    cylinders: list[CylinderTable], weights: dict[str, Weights], asked: Asked,
) -> EngineJob:  # fmt: skip
    """The job in SI."""
    title, expected = heading
    throws, cranks = throws_of(engine, cylinders)
    spacing = engine.spacing.value if engine.spacing is not None else 0.0
    places = [cylinder.at.value if cylinder.at is not None else k * spacing for k, cylinder in enumerate(cylinders)]
    middle = engine.reference.value if engine.reference is not None else 0.5 * (min(places) + max(places))
    return EngineJob(
        name=name,
        title=title,
        speed=engine.speed.value,
        ratio=engine.radius / engine.rod.value,
        orders=max([engine.orders, *(one.of_order for one in _asked_of(asked).values())]),
        truncated=engine.kinematics == "truncated",
        cylinders=tuple(
            Cylinder(
                throw=throw,
                bank=cylinder.bank.value if cylinder.bank is not None else 0.0,
                at=at - middle,
                reciprocating=_mass(cylinder.reciprocating, engine.reciprocating) * engine.radius,
                rotating=_mass(cylinder.rotating, engine.rotating) * engine.radius,
            )
            for cylinder, throw, at in zip(cylinders, throws, places, strict=True)
        ),
        cranks=cranks,
        offered=tuple(engine.cranks),
        shares=_shares(engine),
        weights=tuple(
            _weight(own, family, one, middle) for family, tables in weights.items() for own, one in tables.items()
        ),
        fires=tuple(engine.firing_order),
        strokes=engine.strokes,
        even_firing=engine.even_firing,
        limits=asked[0],
        measures=asked[1],
        goal=asked[2],
        expected=expected,
        reference=middle,
        spaced=len(cylinders) > 1 and all(cylinder.at is None for cylinder in cylinders),
        document=document,
    )


def _asked_of(asked: Asked) -> dict[tuple[str, ...], EngineLimitTable]:
    """Every response that is asked for, by where."""
    limits, measures, goal = asked
    found: dict[tuple[str, ...], EngineLimitTable] = {("limits", name): one for name, one in limits.items()}
    found |= {("measures", name): one for name, one in measures.items()}
    return found if goal is None else {**found, ("goal",): EngineLimitTable(response=goal.minimise, order=goal.order)}


def _mass(own: Fact | None, common: Fact | None) -> float:
    fact = own if own is not None else common
    return fact.value if fact is not None else 0.0


def _shares(engine: EngineTable) -> tuple[Share, ...]:
    """Both shares where one is given: the other is all of the rotating mass, or none of the reciprocating."""
    if engine.counterweight_share is None and engine.rotating_share is None:
        return ()
    return _share(RECIPROCATING, engine.counterweight_share, 0.0), _share(ROTATING, engine.rotating_share, 1.0)


def _share(name: str, given: Fact | Choice | None, default: float) -> Share:
    if given is None:
        return Share(name, default, default)
    return Share(name, given.low, given.high) if isinstance(given, Choice) else Share(name, given.value, given.value)


def _weight(name: str, family: str, table: CounterweightTable, middle: float) -> Weight:
    given, place = table.unbalance, table.at.value - middle
    order, sense = table.turning
    if isinstance(given, Choice):
        return Weight(name, family, order, sense, place, None, given.high, given.unit)
    fixed = cmath.rect(given.value, table.angle.value if table.angle is not None else 0.0)
    return Weight(name, family, order, sense, place, fixed, inf, given.unit)


def _check(
    engine: EngineTable, cylinders: list[CylinderTable], weights: dict[str, Weights], asked: Asked, mistakes: Mistakes
) -> None:
    """What the tables say of each other."""
    limits, _, goal = asked
    if not cylinders:
        mistakes.add(("cylinders",), "there is no cylinder. Write [[cylinders]] once for each.")
        return
    for k, cylinder in enumerate(cylinders):
        if cylinder.reciprocating is None and engine.reciprocating is None:
            mistakes.add(("cylinders", k), f"cylinders[{k + 1}] has no reciprocating mass. Add it to [engine].")
        others = [one for one in cylinders if one.throw == cylinder.throw and cylinder.throw is not None]
        if not engine.firing_order and all(cylinder_table.crank is None for cylinder_table in (cylinder, *others)):
            example = 'crank = "90 deg", or crank = "choose"'
            mistakes.add(("cylinders", k), f"cylinders[{k + 1}] has no crank. Write {example}.")
    if len(cylinders) > 1 and engine.spacing is None and all(cylinder.at is None for cylinder in cylinders):
        mistakes.add(("engine",), 'the cylinders have no places. Write spacing = "100 mm" in [engine].')
    if engine.firing_order and sorted(engine.firing_order) != list(range(1, len(cylinders) + 1)):
        mistakes.value(("engine", "firing_order"), engine.firing_order, "does not name each cylinder once.")
    else:
        check_throws(engine, cylinders, mistakes)
    wanted = len({cylinder.throw or k for k, cylinder in enumerate(cylinders) if cylinder.crank == "choose"})
    if wanted and wanted != len(engine.cranks):
        mistakes.add(("engine", "cranks"), _unequal(engine, wanted))
    elif engine.cranks and not wanted:
        mistakes.add(
            ("engine", "cranks"),
            'engine.cranks offers angles, but no throw chooses one. Write crank = "choose" in [[cylinders]], or leave '
            "cranks out.",
        )
    if goal is not None and goal.then and not wanted:
        mistakes.add(
            ("goal", "then"),
            "goal has then, which decides between settings of the cranks, and these are given. Leave then out, or "
            "limit what it names.",
        )
    unbounded(limits, mistakes)
    for path, one in _asked_of(asked).items():
        if one.of_order > _TEXTBOOK and (one.kinematics or engine.kinematics) == "truncated":
            where = "engine" if one.kinematics is None else ".".join(path)
            mistakes.add(
                (*path, "order"),
                f"{'.'.join(path)}.order = {one.of_order}, but truncated kinematics ends at {_TEXTBOOK}. Write "
                f'kinematics = "exact" in [{where}].',
            )
    free = [one for own in weights.values() for one in own.values() if isinstance(one.unbalance, Choice)]
    shares = [engine.counterweight_share, engine.rotating_share]
    if isinstance(engine.rotating_share, Choice) and not any(
        _mass(cylinder.rotating, engine.rotating) > 0.0 for cylinder in cylinders
    ):
        way = "Add rotating to [engine], or leave rotating_share out."
        mistakes.add(("engine", "rotating_share"), f"rotating_share is chosen, but no mass rotates. {way}")
    if goal is not None and not free and not wanted and not any(isinstance(share, Choice) for share in shares):
        mistakes.add(("goal",), 'there is a goal but nothing to choose. Write crank = "choose", or leave [goal] out.')


def _unequal(engine: EngineTable, wanted: int) -> str:
    """That there are not as many crank angles as throws to take them, and the way out."""
    many, throws = len(engine.cranks), f"{counted(wanted, 'throws')} that choose{'s' * (wanted == 1)}"
    if not many:
        return f'engine has no cranks for {throws}. Write cranks = ["0 deg", "180 deg", ...], one angle each.'
    listed = ", ".join(show_angle(crank) for crank in engine.cranks)
    more = wanted - many
    way = (
        f"add {counted(more, 'angles')}"
        if more > 0
        else f"leave out {counted(-more, 'angles')} (those of throws that do not choose)"
    )
    return (
        f"engine.cranks offers {counted(many, 'angles')} ({listed}) for {throws}. Each throw takes one of them "
        f'and each is taken once: {way}, or change the number of cylinders with crank = "choose".'
    )
