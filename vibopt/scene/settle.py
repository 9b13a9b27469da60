"""Scenes with places left open: every combination of places, each a scene of its own."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import combinations_with_replacement, product
from typing import TYPE_CHECKING, Any

from vibopt.document.reading import changed
from vibopt.scene.alike import numbers_of
from vibopt.scene.scene import Scene

if TYPE_CHECKING:
    from vibopt.devices.sites import Sites

MOST = 64
"""Most combinations of places that are looked at one by one."""
_NOT_PHYSICAL = ("title", "statement", "source", "expected")
_UNNAMED = ("limits", "measures")


def open_places(scene: Scene) -> dict[str, tuple[str, ...]]:
    """What may be chosen, by path: {"absorbers.tmd.on": ("floor1", "floor2")}."""
    hosts = {f"absorbers.{name}.on": one.on for name, one in scene.absorbers.items()}
    found = {path: on.names for path, on in hosts.items() if not isinstance(on, str)}
    return found | {f"mounts.{name}.at": sites.names for name, sites in _open_sites(scene).items()}


def _open_sites(scene: Scene) -> dict[str, Sites]:
    """Mounts whose place is to be chosen."""
    if not scene.mounts:
        return {}
    from vibopt.devices.sites import Sites

    return {name: one.at for name, one in scene.mounts.items() if isinstance(one.at, Sites)}


def combinations(scene: Scene) -> int:
    """Number of scenes that `settled` gives."""
    places = open_places(scene)
    return math.prod(math.comb(len(places[one[0]]) + len(one) - 1, len(one)) for one in groups(scene))


def groups(scene: Scene) -> list[tuple[str, ...]]:
    """Paths of the places that are open, those of identical absorbers together: exchanged they are the same machine."""
    found: list[list[str]] = []
    for path in open_places(scene):
        home = next((one for one in found if _identical(scene, one[0], path)), None)
        if home is None:
            found.append([path])
        else:
            home.append(path)
    return [tuple(one) for one in found]


def _identical(scene: Scene, one: str, other: str) -> bool:
    """Whether the file says the same with the names of two absorbers exchanged, limits by whatever name."""
    family, first, _ = one.split(".")
    if family != "absorbers" or other.split(".")[0] != family:
        return False
    names = {first: other.split(".")[1], other.split(".")[1]: first}
    document = {key: table for key, table in scene.document.items() if key not in _NOT_PHYSICAL}
    document["absorbers"] = {name: repr(numbers_of(table)) for name, table in scene.absorbers.items()}
    return bool(_plain(document, {}) == _plain(document, names))


def _plain(given: Any, names: Mapping[str, str], family: str = "") -> Any:
    """A document with names exchanged; limits and measures as a list in an order of their own, without names."""
    if isinstance(given, Mapping):
        if family in _UNNAMED:
            return sorted(repr(_plain(one, names)) for one in given.values())
        said = {names.get(key, key) if family == "absorbers" else key: one for key, one in given.items()}
        inner = {key: _plain(one, names, key if not family else "-") for key, one in said.items()}
        return dict(sorted(inner.items()))
    if isinstance(given, list | tuple):
        return [_plain(one, names, "-") for one in given]
    return names.get(given, given) if isinstance(given, str) else given


def settled(scene: Scene) -> Iterator[tuple[Mapping[str, str], Scene]]:
    """Each choice of places, by path, with the scene in which it has been made.

    Of identical absorbers the first is on the place that is listed first; what exchanges them is left out.
    """
    places, alike = open_places(scene), groups(scene)
    for chosen in product(*(combinations_with_replacement(places[one[0]], len(one)) for one in alike)):
        put = {
            path: name for one, names in zip(alike, chosen, strict=True) for path, name in zip(one, names, strict=True)
        }
        words = {path: put[path] for path in places}
        absorbers = {
            name: one.model_copy(update={"on": words.get(f"absorbers.{name}.on", one.on)})
            for name, one in scene.absorbers.items()
        }
        mounts, said = dict(scene.mounts), {}
        for name, sites in _open_sites(scene).items():
            path = f"mounts.{name}.at"
            index = places[path].index(words[path])
            mounts[name] = mounts[name].model_copy(update={"at": sites.options[index]})
            said[path] = sites.given[index]
        document = changed(scene.document, {**words, **said})
        yield words, replace(scene, absorbers=absorbers, mounts=mounts, document=document, asked=scene)
