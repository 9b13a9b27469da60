"""Numbers of a scene that may be off in the machine as built."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from vibopt.scene.places import devices
from vibopt.scene.scene import Scene
from vibopt.values import Table
from vibopt.values.fields import Choice, Fact


@dataclass(frozen=True, slots=True)
class Uncertain:
    """A number or a part of a device: built as its value times (1 + d), |d| <= `tolerance`."""

    path: str
    tolerance: float


def uncertain(scene: Scene) -> tuple[Uncertain, ...]:
    """Every number with a tolerance of its own, and those of tables with one; in the order of the file's families."""
    found: dict[str, float] = {}
    for family, name, table in devices(scene):
        base = f"{family}.{name}"
        own = dict(_own(base, table))
        found |= own
        wide = float(getattr(table, "tolerance", None) or 0.0)
        for part, key in table.parts().items() if wide else ():
            here = f"{base}.{key}"
            if not any(path == here or path.startswith(f"{here}.") for path in own):
                found[f"{base}.{part}"] = wide
    return tuple(Uncertain(path, tolerance) for path, tolerance in found.items())


def _own(path: str, table: Table) -> Iterator[tuple[str, float]]:
    for key in type(table).model_fields:
        value = getattr(table, key)
        if isinstance(value, Table):
            yield from _own(f"{path}.{key}", value)
        elif isinstance(value, (Fact, Choice)) and value.tolerance > 0.0:
            yield f"{path}.{key}", value.tolerance


__all__ = ["Uncertain", "uncertain"]
