"""Names of a scene: what moves, what supports, what joins; asked of every family of devices."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import wraps
from inspect import CO_VARARGS
from typing import TYPE_CHECKING, Any, TypeVar, cast

from vibopt.devices import FAMILIES, Device
from vibopt.mechanics.builder import GROUND
from vibopt.responses.response import PLACES, Response
from vibopt.scene.scene import Scene
from vibopt.values.directions import way_words

if TYPE_CHECKING:
    from vibopt.devices.part import Bound, Part

_Asked = TypeVar("_Asked", bound=Callable[..., Any])


def once(of: _Asked) -> _Asked:
    """What a scene says is gathered when it is first asked for: a scene does not change."""
    name = f"{of.__module__}.{of.__name__}"

    def alone(scene: Scene) -> Any:
        found = scene.__dict__.get(name, of)
        if found is of:
            found = scene.__dict__[name] = of(scene)
        return found

    def about(scene: Scene, *more: str) -> Any:
        key = "\0".join((name, *more))
        found = scene.__dict__.get(key, of)
        if found is of:
            found = scene.__dict__[key] = of(scene, *more)
        return found

    more_asked = of.__code__.co_argcount > 1 or of.__code__.co_flags & CO_VARARGS
    return cast("_Asked", wraps(of)(about if more_asked else alone))


@once
def raw(scene: Scene, family: str) -> dict[str, Mapping[str, Any]]:
    """Tables of a family as they stand in the document, those with mistakes included."""
    tables = scene.document.get(family, {})
    if not isinstance(tables, (dict, Mapping)):  # to ask for a dict first is sooner answered
        return {}
    return {name: table if isinstance(table, (dict, Mapping)) else {} for name, table in tables.items()}


@once
def devices(scene: Scene) -> list[tuple[str, str, Device]]:
    """Family, name and table of every device that could be read."""
    return [(family, name, table) for family in FAMILIES for name, table in getattr(scene, family).items()]


def bound_parts(scene: Scene) -> list[Bound]:
    """Parts of catalogues that are to be chosen."""
    return [bound for _, name, table in devices(scene) for bound in table.bound(name)]


def bought(scene: Scene) -> dict[str, Part]:
    """Parts from catalogues, chosen or fixed, by the path of what they are bought for: "links.feet"."""
    parts = {f"links.{name}": link.part for name, link in scene.links.items()}
    parts |= {f"mounts.{name}": mount.part for name, mount in scene.mounts.items()}
    return {path: part for path, part in parts.items() if part is not None}


@once
def raw_devices(scene: Scene) -> list[tuple[str, type[Device], str, Mapping[str, Any]]]:
    """Family, kind, name and table of every device as it stands in the document, those with mistakes included."""
    said = [(family, raw(scene, family)) for family in FAMILIES if family in scene.document]
    return [(family, FAMILIES[family], name, table) for family, tables in said for name, table in tables.items()]


@once
def moving(scene: Scene) -> list[str]:
    """Points that move freely: bodies, masses of absorbers, points of structures."""
    return [one for _, kind, name, table in raw_devices(scene) for one in kind.moving_in(name, table)]


@once
def carried(scene: Scene) -> set[str]:
    """Points of structures and rotors: what hangs there is held by the structure itself."""
    held = [table.names for table in scene.structures.values()] + [table.names for table in scene.rotors.values()]
    return {point for names in held for point in names}


@once
def supports(scene: Scene) -> list[str]:
    """Points that move as prescribed."""
    return [one for _, kind, name, table in raw_devices(scene) for one in kind.supports_in(name, table)]


@once
def points(scene: Scene) -> list[str]:
    """Everything a link may end at."""
    return [*moving(scene), *supports(scene), GROUND]


@once
def named(scene: Scene) -> dict[str, list[str]]:
    """Names that a response may speak of, by the word for what they are."""
    bodies, joining, absorbers = (list(raw(scene, one)) for one in ("bodies", "links", "absorbers"))
    return {
        "body": moving(scene),
        "link": links(scene),
        "link or rotor": [*links(scene), *raw(scene, "rotors")],
        "joining link": joining,
        "body or link": list(dict.fromkeys([*moving(scene), *links(scene)])),
        "point": points(scene),
        "absorber": absorbers,
        "geared body": [
            name for name, table in raw(scene, "bodies").items() if {*table} & {"geared_to", "speed_ratio"}
        ],
        "mass": [*bodies, *absorbers],
        "mount": [],
    }


@once
def shaken(scene: Scene, *names: str) -> set[str]:
    """Points that excitations move, by whatever leads there."""
    moved: set[str] = set()
    todo = [on for name in names for on in scene.excitations[name].everywhere]
    free, near = set(moving(scene)), neighbours(scene)
    while todo:
        here = todo.pop()
        if here not in moved:
            moved.add(here)
            todo += [one for one in near.get(here, ()) if one in free]
    return moved


@once
def links(scene: Scene) -> list[str]:
    """Everything that joins two points by a spring or a damper: links and absorbers."""
    return [one for _, kind, name, table in raw_devices(scene) for one in kind.links_in(name, table)]


@once
def freedoms(scene: Scene) -> int:
    """Number of free coordinates; a body without mass has one where an inerter or a beam with a mass ends."""
    carried = [name for name in empty(scene) if gear_root(scene, name) == name]
    own = sum(kind.freedoms_in(name, table) for _, kind, name, table in raw_devices(scene))
    return own + len(set(carried).difference(joints(scene)))


@once
def ends(scene: Scene) -> dict[str, tuple[str, str]]:
    """The two ends of every link that could be read."""
    return {link: two for _, name, table in devices(scene) for link, two in table.joins(name).items()}


@once
def springs(scene: Scene) -> set[str]:
    """Links that have a stiffness."""
    return {link for _, name, table in devices(scene) for link in table.springs(name)}


@once
def rubbing(scene: Scene) -> list[str]:
    """Links that have dry friction."""
    return [name for _, name, table in devices(scene) if table.rubs]


@once
def neighbours(scene: Scene) -> dict[str, set[str]]:
    """Per point those that it moves along: over a link, or within one structure."""
    found: dict[str, set[str]] = {}
    groups: list[tuple[str, ...]] = list(ends(scene).values())
    groups += [(name, point.on) for name, point in scene.points.items()]
    groups += [(name, body.geared_to) for name, body in scene.bodies.items() if body.geared_to is not None]
    groups += [one for _, kind, name, table in raw_devices(scene) if len(one := kind.moving_in(name, table)) > 1]
    for group in groups:
        for here in group:
            found.setdefault(here, set()).update(there for there in group if there != here)
    return found


@once
def is_whole(scene: Scene) -> bool:
    """Whether every table of a machine could be read and every name leads to something: then it can be built."""
    for family in (*FAMILIES, "excitations"):
        tables = scene.document.get(family, {})
        if not isinstance(tables, Mapping) or any(name not in getattr(scene, family) for name in tables):
            return False
    known, masses = points(scene), {*scene.bodies, *scene.absorbers, None}
    joined = [end for two in ends(scene).values() for end in two]
    joined += [on for excitation in scene.excitations.values() for on in excitation.everywhere]
    relative = [getattr(table, "relative_to", None) for _, _, table in devices(scene)]
    return (
        all(end in known for end in joined)
        and all((root := scene.bodies.get(gear_root(scene, name))) and root.geared_to is None for name in scene.bodies)
        and all(point.on in scene.bodies for point in scene.points.values())
        and all(name in masses for name in relative)
    )


@once
def gear_root(scene: Scene, name: str) -> str:
    """The body that turns freely of those that a body is geared to; of any other point itself."""
    for _ in scene.bodies:
        body = scene.bodies.get(name)
        name = name if body is None or body.geared_to is None else body.geared_to
    return name


@once
def empty(scene: Scene) -> dict[str, str]:
    """Points without mass, each with how a message calls it: "bodies.joint"."""
    return {name: f"{family}.{name}" for family, name, table in devices(scene) if table.massless}


@once
def joints(scene: Scene) -> list[str]:
    """Points without mass at which no inerter and no beam with a mass ends: what joins links, and nothing else.

    Of bodies that are geared to each other the one that turns freely, where none has a mass.
    """
    bring = [(name, table) for _, name, table in devices(scene) if table.passes > 1 or table.spreads_mass]
    heavy = {gear_root(scene, end) for name, table in bring for end in table.joins(name)[name]}
    heavy |= {gear_root(scene, name) for name, body in scene.bodies.items() if not body.massless}
    return [name for name in empty(scene) if gear_root(scene, name) == name and name not in heavy]


@once
def turning(scene: Scene) -> set[str]:
    """Points that turn about an axis: bodies with an inertia, and the absorbers on them."""
    found = {name for name, body in scene.bodies.items() if body.turns}
    for _ in scene.absorbers:
        found |= {name for name, absorber in scene.absorbers.items() if absorber.host in found}
    return found


def place_of(response: Response) -> str:
    """Where a response is read: "into ground", "of press"; "" where it speaks of the whole."""
    said = vars(response)
    place = next((f"{key} {said[key]}" for key in PLACES if said.get(key)), "")
    other = said.get("relative_to")
    return f"{place}{f' relative to {other}' if other else ''}{_way(response)}" or response.said_of


def _way(response: Response) -> str:
    """The direction or the axis that a question in space names: " along z", " about x"."""
    for key, preposition in (("direction", "along"), ("axis", "about")):
        way = vars(response).get(key)
        if way is not None and key in response.model_fields_set:
            return f" {preposition} {way_words(way)}"
    return ""
