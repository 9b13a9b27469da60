"""Facts of a scene by path."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from vibopt.devices import FAMILIES
from vibopt.errors import InputError
from vibopt.excitations import Excitation
from vibopt.responses import Response
from vibopt.scene.open_places import open_positions
from vibopt.scene.scene import Scene
from vibopt.units import Quantity, read_quantity, to_unit
from vibopt.values import Fact, SpeedRange, Table, rule_of
from vibopt.values.directions import AXES
from vibopt.values.fact_at import FactAt, fact_among
from vibopt.values.speeds import ROTATION
from vibopt.values.tolerance import Scatter, read_tolerance

_PLACES = ("centre", "at")
_SIDES = ("box",)


def facts(scene: Scene) -> Iterator[FactAt]:
    """Every number of the scene that is a fact: properties, places, excitations, speeds, ratings, bounds."""
    for family in (*FAMILIES, "excitations", "limits"):
        tables: dict[str, Table] = getattr(scene, family)
        for name, table in tables.items():
            yield from _facts(f"{family}.{name}", table, scene.document.get(family, {}).get(name))


def _facts(path: str, table: Table, given: Any) -> Iterator[FactAt]:
    """Facts of a table, of the tables in it and of lists of tables; `given` is how the file says it."""
    brought = getattr(table, "brought", ())
    for key in type(table).model_fields:
        inner, said = getattr(table, key), given.get(key) if isinstance(given, Mapping) else None
        if key in brought or (isinstance(inner, Table) and inner.printed_in_catalogue):
            continue
        here = f"{path}.{key}"
        if isinstance(inner, Table):
            yield from _facts(here, inner, said)
        if isinstance(inner, tuple) and inner and all(isinstance(one, Table) for one in inner):
            for index, one in enumerate(inner):
                yield from _facts(f"{here}.{index + 1}", one, _entry(said, index))
        if key == "shift" and inner is not None:
            given = said if isinstance(said, Mapping) else {}
            moved = _lengths(here, [given.get(axis, "0 m") for axis in AXES], signed=True)
            yield from (fact_at for fact_at in moved if fact_at.path.rpartition(".")[2] in given)
        if key in (*_PLACES, *_SIDES) and isinstance(inner, tuple):
            yield from _lengths(here, said, signed=key in _PLACES)
        found = _fact(here, table, key)
        if found is not None:
            yield found
        yield from _ends(here, table, key)
        wide = given.get(key) if key == "tolerance" and isinstance(given, Mapping) else None
        wide = said["tolerance"] if isinstance(said, Mapping) and "tolerance" in said else wide
        off = here if key == "tolerance" else f"{here}.tolerance"
        if isinstance(wide, Mapping):
            sized = read_tolerance(wide)
            assert isinstance(sized, Scatter)
            if sized.size:
                yield FactAt(f"{off}.{sized.kind}", sized.size, "%", "ratio")
        elif wide is not None:
            yield FactAt(off, read_tolerance(wide), "%", "ratio")


def _entry(given: Any, index: int) -> Any:
    return given[index] if isinstance(given, list) and index < len(given) else None


def _lengths(path: str, given: Any, *, signed: bool) -> Iterator[FactAt]:
    """Coordinates of a place or of each of a list of places, sides of a box."""
    if not isinstance(given, list):
        return
    if given and all(isinstance(one, list) for one in given):
        for index, one in enumerate(given):
            yield from _lengths(f"{path}.{index + 1}", one, signed=signed)
        return
    for axis, one in zip(AXES, given, strict=False):
        if isinstance(one, Mapping):  # to be chosen
            continue
        said = read_quantity(one if isinstance(one, str) else f"{one} m", "length")
        yield FactAt(f"{path}.{axis}", said.value, said.unit, "length", signed=signed)


def _ends(path: str, table: Table, key: str) -> Iterator[FactAt]:
    """The two ends of a rating, of a range of own speeds, and of one that natural frequencies keep out of."""
    value = getattr(table, key)
    rated = getattr(value, "rated", None)
    if rated is not None:
        ends, words, unit, dimension = rated, ("least", "most"), value.most.unit, "force"
    elif isinstance(value, SpeedRange) and _is_varied(table, key) and _is_band(value):
        band = value.bands[0]
        ends, words, unit, dimension = (band.low, band.high), ("lowest", "highest"), value.unit, value.dimension
    else:
        return
    texts = [f"{to_unit(one, unit, dimension):.15g} {unit}" for one in ends]
    arounds = ("{}.." + texts[1], texts[0] + "..{}")
    for word, end, around in zip(words, ends, arounds, strict=True):
        yield FactAt(f"{path}.{word}", end, unit, dimension, place=path, around=around)


def _is_varied(table: Table, key: str) -> bool:
    """Whether the ends of a range of speeds are facts: own speeds, and what natural frequencies keep out of."""
    return key == "speed" if isinstance(table, Excitation) else key == "outside" and isinstance(table, Response)


def _is_band(value: SpeedRange) -> bool:
    band = value.bands[0]
    return len(value.bands) == 1 and not band.is_point and not value.asked and band.high < float("inf")


def fact_at(scene: Scene, path: str) -> FactAt:
    """The fact at a path.

    Raises
    ------
    InputError
        There is no such number; the text lists near ones.
    """
    chosen = [variable.path for variable in scene.variables] + list(open_positions(scene))
    known = list(facts(scene))
    if path in chosen and path not in {one.path for one in known}:
        raise InputError(
            f"{path} is to be chosen by vibopt, so it is no fact. Name a fact, or a variable with a range of its own "
            "without tolerance."
        )
    return fact_among(known, path)


def _fact(path: str, table: Table, key: str) -> FactAt | None:
    value = getattr(table, key)
    if isinstance(value, Fact) and isinstance(table, Excitation) and table.quantity:
        return FactAt(path, value.value, value.unit, table.quantity)
    if isinstance(value, Fact):
        rule = rule_of(type(table), key)
        path = f"{path}.value" if value.tolerance else path
        if rule is not None:
            return FactAt(path, value.value, value.unit, rule.dimension, rule.amplitude)
    if isinstance(value, Quantity) and isinstance(table, Response):
        if key not in ("at_most", "at_least"):  # up to which speed whirls count
            return FactAt(path, value.value, value.unit, ROTATION)
        return FactAt(path, value.value, value.unit, table.dimension, table.amplitude)
    if isinstance(value, SpeedRange) and isinstance(table, Excitation) and key == "speed" and value.is_one_speed:
        return FactAt(path, value.bands[0].low, value.unit, value.dimension)
    return None


def read_fact(at: FactAt, text: str) -> float:
    """A text as a value of that fact [SI]."""
    return at.read(text)
