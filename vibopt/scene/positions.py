"""Coordinates of mounts that are ranges: what they are called, and the scene with values in their place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from vibopt.document.reading import changed
from vibopt.scene.scene import Scene, Variable
from vibopt.scene.settle import open_places
from vibopt.units import to_unit
from vibopt.values.fields import Choice
from vibopt.values.vectors import AXES, OpenVector, Span

if TYPE_CHECKING:
    from vibopt.devices.mount import MountTable


def open_positions(scene: Scene) -> dict[str, Variable]:
    """Coordinates and shifts to be chosen, by path: "mounts.front.at.1.x", "mounts.front.shift.x"."""
    found = {}
    for name, table in scene.mounts.items():
        for path, span in _spans(scene, name, table):
            found[path] = Variable(path, Choice(span.low, span.high, span.unit), "length")
    return found


def asked_positions(scene: Scene) -> dict[str, Variable]:
    """Those of the scene, or of the scene as it was asked where they have been chosen here."""
    here: Scene | None = scene
    while here is not None:
        found = open_positions(here)
        if found:
            return found
        here = here.asked
    return {}


def is_open(scene: Scene) -> bool:
    """Whether anything is to be chosen: values, places or positions."""
    return bool(scene.variables or open_places(scene) or open_positions(scene))


def _spans(scene: Scene, name: str, table: MountTable) -> list[tuple[str, Span]]:
    """Paths as `--set` takes them: a place of a list has a number, a lone place has none."""
    from vibopt.devices.sites import Sites

    found = []
    if not isinstance(table.at, Sites):
        for path, place in zip(_places(scene, name, table), table.at, strict=True):
            found += [(f"{path}.{axis}", one) for axis, one in zip(AXES, place, strict=True)]
    base = f"mounts.{name}.shift"
    found += [(f"{base}.{axis}", one) for axis, one in zip(AXES, table.shift or (), strict=False)]
    return [(path, one) for path, one in found if isinstance(one, Span)]


def _places(scene: Scene, name: str, table: MountTable) -> list[str]:
    given = scene.document["mounts"][name]["at"]
    listed = isinstance(given, list) and all(isinstance(one, list) for one in given)
    base = f"mounts.{name}.at"
    return [f"{base}.{index + 1}" for index in range(table.count)] if listed else [base]


def positioned(scene: Scene, values: Sequence[float]) -> Scene:
    """The scene with a value [m] for each open position, in the order of `open_positions`."""
    opened = open_positions(scene)
    chosen = dict(zip(opened, (float(one) for one in values), strict=True))
    mounts = {name: _with(scene, name, table, chosen) for name, table in scene.mounts.items()}
    said = {path: _said(value, opened[path].unit) for path, value in chosen.items()}
    return replace(scene, mounts=mounts, document=changed(scene.document, said), asked=scene)


def _with(scene: Scene, name: str, table: MountTable, chosen: dict[str, float]) -> MountTable:
    from vibopt.devices.sites import Sites

    def settled(path: str, place: OpenVector) -> OpenVector:
        x, y, z = (chosen.get(f"{path}.{axis}", one) for axis, one in zip(AXES, place, strict=True))
        return x, y, z

    new: dict[str, object] = {}
    if not isinstance(table.at, Sites):
        pairs = zip(_places(scene, name, table), table.at, strict=True)
        new["at"] = tuple(settled(path, place) for path, place in pairs)
    if table.shift is not None:
        new["shift"] = settled(f"mounts.{name}.shift", table.shift)
    return table.model_copy(update=new)


def _said(value: float, unit: str) -> str:
    """A length [m] as it stands in a file, exact to the last digit."""
    return f"{float(to_unit(value, unit or 'm', 'length'))!r} {unit or 'm'}"


__all__ = ["asked_positions", "is_open", "open_positions", "positioned"]
