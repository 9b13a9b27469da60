"""Parts of catalogues in the finished design: their names, and their static load against what they are rated for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from vibopt.answer.entry import Checked, Entry, Word
from vibopt.errors import counted
from vibopt.mechanics.built import Joint
from vibopt.mechanics.machine import Machine
from vibopt.scene.places import bound_parts
from vibopt.scene.scene import Scene
from vibopt.values.fields import Choice, Fact

if TYPE_CHECKING:
    from vibopt.devices.part import Part


def parts_of(scene: Scene, chosen: Mapping[str, float]) -> dict[str, Word]:
    """The part chosen of each catalogue, by path."""
    found = {}
    for part in bound_parts(scene):
        name = part.names[part.chosen(chosen)]
        found[part.path] = Word(name, part.names, f"{counted(len(part.names), 'parts')} of {part.catalogue.file}")
    return found


def load_of(machine: Machine, joint: Joint) -> float:
    """Static force of one mount of a group [N]; infinite where nothing holds the machine."""
    sag = machine.sag()
    if sag is None:
        return float("inf")
    squeezed = sag.get(joint.ends[1], 0.0) - sag.get(joint.ends[0], 0.0)
    return abs(squeezed) * joint.static_stiffness / joint.count


def rated_rows(scene: Scene, chosen: Mapping[str, float], machine: Machine) -> dict[str, Checked]:
    """The static load of one mount of each bought part, on the machine as built; of a group in space the worst."""
    rows: dict[str, Checked] = {}
    for name, link in scene.links.items():
        if link.part is not None:
            _add(rows, name, link.part, f"links.{name}", [load_of(machine, machine.joint(name))], chosen)
    for name, mount in scene.mounts.items():
        if mount.part is not None:
            loads = [_of_mount(machine, single) for single in mount.singles(name)]
            _add(rows, name, mount.part, f"mounts.{name}", loads, chosen)
    return rows


def _of_mount(machine: Machine, single: str) -> float:
    """What one mount carries along its own axis [N]; below zero it is lifted."""
    from vibopt.responses.space_responses import StaticLoadOfMount

    return StaticLoadOfMount(response="static_load", of=single).measure_static(machine)


def _add(
    rows: dict[str, Checked], name: str, part: Part, path: str, loads: list[float], chosen: Mapping[str, float]
) -> None:
    for side, rating, unit in _ratings(part, path, chosen):
        key = f"{name}: rated load"
        load = max(loads) if side == "at_most" else min(loads)
        margin = (rating - load) / rating if side == "at_most" else (load - rating) / rating
        margin = float(margin) if np.isfinite(load) else -np.inf
        rows[key if key not in rows else f"{key} ({side})"] = Checked(
            name=key,
            response="static_load",
            place=f"of {name}",
            side=side,
            value=Entry(load, "force", unit),
            limit=Entry(rating, "force", unit),
            margin=margin,
        )


def _ratings(part: Part, path: str, chosen: Mapping[str, float]) -> Iterator[tuple[str, float, str]]:
    """Side, rating [N] and unit of what a part is rated for."""
    for side, key in (("at_most", "rated_max"), ("at_least", "rated_min")):
        value: Fact | Choice | None = getattr(part, key)
        if value is None:
            continue
        rating = value.value if isinstance(value, Fact) else chosen[f"{path}.part.{key}"]
        if rating > 0.0:
            yield side, rating, value.unit
