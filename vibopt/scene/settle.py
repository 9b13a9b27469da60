"""Scenes with places left open: every combination of places, each a scene of its own."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import product

from vibopt.devices.absorber import Places
from vibopt.devices.sites import Sites
from vibopt.scene.document import changed
from vibopt.scene.scene import Scene

MOST = 64
"""Most combinations of places that are looked at one by one."""


def open_places(scene: Scene) -> dict[str, tuple[str, ...]]:
    """What may be chosen, by path: {"absorbers.tmd.on": ("floor1", "floor2")}."""
    found = {
        f"absorbers.{name}.on": one.on.names for name, one in scene.absorbers.items() if isinstance(one.on, Places)
    }
    for name, one in scene.mounts.items():
        if isinstance(one.at, Sites):
            found[f"mounts.{name}.at"] = one.at.names
    return found


def combinations(scene: Scene) -> int:
    """Number of scenes that `settled` gives."""
    return math.prod(len(names) for names in open_places(scene).values())


def settled(scene: Scene) -> Iterator[tuple[Mapping[str, str], Scene]]:
    """Each choice of places, by path, with the scene in which it has been made."""
    places = open_places(scene)
    for chosen in product(*places.values()):
        words = dict(zip(places, chosen, strict=True))
        absorbers = {
            name: one.model_copy(update={"on": words.get(f"absorbers.{name}.on", one.on)})
            for name, one in scene.absorbers.items()
        }
        mounts, said = {}, {}
        for name, table in scene.mounts.items():
            path = f"mounts.{name}.at"
            mounts[name] = table
            if isinstance(table.at, Sites):
                index = places[path].index(words[path])
                mounts[name] = table.model_copy(update={"at": table.at.options[index]})
                said[path] = table.at.given[index]
        document = changed(scene.document, {**words, **said})
        yield words, replace(scene, absorbers=absorbers, mounts=mounts, document=document, asked=scene)
