"""Facts of a scene by path: what they are, and how a value is written back into the document."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from vibopt.devices import FAMILIES
from vibopt.devices.part import Part
from vibopt.errors import InputError, way_out
from vibopt.excitations import Excitation
from vibopt.excitations.white_noise import WhiteNoise
from vibopt.responses import Response
from vibopt.scene.scene import Scene
from vibopt.units import Quantity, read_quantity, to_unit
from vibopt.values import Fact, SpeedRange, Table, rule_of


@dataclass(frozen=True, slots=True)
class FactAt:
    """A fact: its path, value [SI], the user's unit, its dimension, whether it is an amplitude."""

    path: str
    value: float
    unit: str
    dimension: str
    amplitude: bool = False

    def text(self, value: float) -> str | float:
        """A value [SI] as it would stand in the file, exact to the last digit."""
        shown = to_unit(value, self.unit, self.dimension) if self.unit else value
        return f"{shown:.17g} {self.unit}".strip() if self.unit else shown


def facts(scene: Scene) -> Iterator[FactAt]:
    """Every number of the scene that is a fact: properties, excitations, single speeds, bounds."""
    for family in (*FAMILIES, "excitations", "limits"):
        tables: dict[str, Table] = getattr(scene, family)
        for name, table in tables.items():
            yield from _facts(f"{family}.{name}", table)


def _facts(path: str, table: Table) -> Iterator[FactAt]:
    """Facts of a table, and of the tables in it."""
    brought = getattr(table, "brought", ())
    for key in type(table).model_fields:
        inner = getattr(table, key)
        if key in brought or isinstance(inner, Part):  # a part is taken as the catalogue has it
            continue
        if isinstance(inner, Table):
            yield from _facts(f"{path}.{key}", inner)
        found = _fact(f"{path}.{key}", table, key)
        if found is not None:
            yield found


def fact_at(scene: Scene, path: str) -> FactAt:
    """The fact at a path.

    Raises
    ------
    InputError
        There is no such number; the text lists near ones.
    """
    known = {one.path: one for one in facts(scene)}
    if path not in known:
        chosen = [variable.path for variable in scene.variables]
        if path in chosen:
            raise InputError(
                f"{path} is to be chosen by vibopt, so it is no fact. Name a fact, or write a value there first."
            )
        raise InputError(f"there is no fact called {path}.{way_out(path, list(known))}")
    return known[path]


def _fact(path: str, table: Table, key: str) -> FactAt | None:
    value = getattr(table, key)
    if isinstance(value, Fact) and isinstance(table, WhiteNoise):
        return FactAt(path, value.value, value.unit, table.quantity)
    if isinstance(value, Fact):
        rule = rule_of(type(table), key)
        path = f"{path}.value" if value.tolerance else path
        if rule is not None:
            return FactAt(path, value.value, value.unit, rule.dimension, rule.amplitude)
    if isinstance(value, Quantity) and isinstance(table, Response):
        return FactAt(path, value.value, value.unit, table.dimension, table.amplitude)
    if isinstance(value, SpeedRange) and isinstance(table, Excitation) and key == "speed" and value.is_one_speed:
        return FactAt(path, value.bands[0].low, value.unit, value.dimension)
    return None


def read_fact(at: FactAt, text: str) -> float:
    """A text as a value of that fact [SI]."""
    return read_quantity(text, at.dimension, amplitude=at.amplitude).value
