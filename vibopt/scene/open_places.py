"""Places and positions that are left open: each scene that they may become, told apart by its numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from itertools import combinations_with_replacement, product
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel

from vibopt.document.toml_reading import changed
from vibopt.records import dataclass
from vibopt.scene.places import once
from vibopt.scene.scene import Scene, Variable
from vibopt.units import to_unit
from vibopt.values.directions import AXES, OpenVector, Span
from vibopt.values.fields import Choice

if TYPE_CHECKING:
    from vibopt.devices.mount import MountTable
    from vibopt.devices.sites import Sites


_WORDING = ("unit", "echo")
_DIGITS = 12


def numbers_of(given: Any) -> Any:
    """What a table says [SI], without the units and texts in which it says it; comparable."""
    from vibopt.devices.absorber import Places

    if isinstance(given, BaseModel):
        return tuple((name, numbers_of(getattr(given, name))) for name in type(given).model_fields)
    if isinstance(given, Places):
        return tuple(sorted(given.names))
    if is_dataclass(given) and not isinstance(given, type):
        return tuple(
            (field.name, numbers_of(getattr(given, field.name)))
            for field in fields(given)
            if field.name not in _WORDING
        )
    if isinstance(given, list | tuple):
        return tuple(numbers_of(one) for one in getattr(given, "options", given))
    if isinstance(given, float):
        return float(f"{given:.{_DIGITS}g}")
    return given if isinstance(given, str | int | bool | None) else repr(given)


MOST = 64
"""Most combinations of places that are looked at one by one."""
_NOT_PHYSICAL = ("title", "statement", "source", "scenarios", "expected")
_UNNAMED = ("limits", "measures")


@dataclass(frozen=True, slots=True)
class Option:
    """One of what may be chosen: `value` is what the table of the device then holds, `said` what its file says."""

    value: Any
    said: Any


@once
def open_places(scene: Scene) -> dict[str, tuple[str, ...]]:
    """What may be chosen, by path: {"absorbers.tmd.on": ("floor1", "floor2")}."""
    return {path: tuple(options) for path, options in _options(scene).items()}


def _options(scene: Scene) -> dict[str, dict[str, Option]]:
    """Options by the path of the key that is open, and by their names: hosts, ends and places of mounts."""
    found = {
        f"absorbers.{name}.on": {host: Option(host, host) for host in absorber.on.names}
        for name, absorber in scene.absorbers.items()
        if not isinstance(absorber.on, str)
    }
    for family in ("links", "inerters"):
        for name, table in getattr(scene, family).items():
            pairs = getattr(table.between, "options", ())
            if pairs:
                found[f"{family}.{name}.between"] = {_joined(pair): Option(pair, list(pair)) for pair in pairs}
    for name, sites in _open_sites(scene).items():
        every = zip(sites.names, sites.options, sites.given, strict=True)
        found[f"mounts.{name}.at"] = {word: Option(place, given) for word, place, given in every}
    return found


def _joined(pair: tuple[str, str]) -> str:
    """Two ends by one name, "joint to ground"."""
    return " to ".join(pair)


def has_open_ends(scene: Scene) -> bool:
    """Whether it is to be chosen between which points something acts, so that its layouts differ in kind."""
    return any(path.endswith(".between") for path in open_places(scene))


def _open_sites(scene: Scene) -> dict[str, Sites]:
    """Mounts whose place is to be chosen."""
    if not scene.mounts:
        return {}
    from vibopt.devices.sites import Sites

    return {name: mount.at for name, mount in scene.mounts.items() if isinstance(mount.at, Sites)}


def combinations(scene: Scene) -> int:
    """Number of scenes that `settled` gives."""
    places = open_places(scene)
    return math.prod(math.comb(len(places[group[0]]) + len(group) - 1, len(group)) for group in groups(scene))


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
    options, alike = _options(scene), groups(scene)
    for chosen in product(*(combinations_with_replacement(options[one[0]], len(one)) for one in alike)):
        put = {
            path: name for one, names in zip(alike, chosen, strict=True) for path, name in zip(one, names, strict=True)
        }
        words = {path: put[path] for path in options}
        made = {path: options[path][word] for path, word in words.items()}
        document = changed(scene.document, {path: option.said for path, option in made.items()})
        yield words, replace(_with_options(scene, made), document=document, asked=scene)


def _with_options(scene: Scene, made: Mapping[str, Option]) -> Scene:
    """The scene whose devices hold what was chosen; its document is still the old one."""
    families: dict[str, Any] = {}
    for path, option in made.items():
        family, name, key = path.split(".")
        tables = families.setdefault(family, dict(getattr(scene, family)))
        tables[name] = tables[name].model_copy(update={key: option.value})
    others = {family: families.pop(family, tables) for family, tables in scene.others.items()}
    return replace(scene, **families, others=others)


@once
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
    return [(path, span) for path, span in found if isinstance(span, Span)]


def _places(scene: Scene, name: str, table: MountTable) -> list[str]:
    given = scene.document["mounts"][name]["at"]
    listed = isinstance(given, list) and all(isinstance(one, list) for one in given)
    base = f"mounts.{name}.at"
    return [f"{base}.{index + 1}" for index in range(table.count)] if listed else [base]


def positioned(scene: Scene, values: Sequence[float]) -> Scene:
    """The scene with a value [m] for each open position, in the order of `open_positions`."""
    opened = open_positions(scene)
    chosen = dict(zip(opened, (float(value) for value in values), strict=True))
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
