"""Scenes with places left open: every combination of places, each a scene of its own."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import product

from vibopt.devices.absorber import Places
from vibopt.scene.document import changed
from vibopt.scene.scene import Scene

MOST = 64
"""Most combinations of places that are looked at one by one."""


def open_places(scene: Scene) -> dict[str, tuple[str, ...]]:
    """What may be chosen, by path: {"absorbers.tmd.on": ("floor1", "floor2")}."""
    return {f"absorbers.{name}.on": one.on.names for name, one in scene.absorbers.items() if isinstance(one.on, Places)}


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
        document = changed(scene.document, words)
        yield words, replace(scene, absorbers=absorbers, document=document, asked=scene)
