"""Where a response is read: places that are there, of the kind that it speaks of, with the property asked for."""

from __future__ import annotations

from collections.abc import Iterator

from vibopt.devices import Device
from vibopt.document.mistakes import Mistakes, Path, dotted
from vibopt.responses import Response
from vibopt.scene import places
from vibopt.scene.assemble import NoReferenceError, reference
from vibopt.scene.check_space import check_in_space
from vibopt.scene.scene import Scene

_DAMPERS = ("damping", "torsional_damping")


def check_places(scene: Scene, path: Path, response: Response, mistakes: Mistakes, broken: set[str]) -> None:
    """Add what is wrong with the places of a response."""
    bodies, links, absorbers = (list(places.raw(scene, one)) for one in ("bodies", "links", "absorbers"))
    moving, joints = places.moving(scene), places.links(scene)
    known = {
        "body": moving,
        "link": joints,
        "joining link": links,
        "body or link": list(dict.fromkeys([*moving, *joints])),
        "point": places.points(scene),
        "absorber": absorbers,
        "mass": [*bodies, *absorbers],
        "mount": [],
    }
    if check_in_space(scene, path, response, mistakes):
        _parameter(scene, path, response, mistakes, broken)
        return
    words = {"point": "body, base or ground", "joining link": "link", "mass": "body"}
    for key, (name, family) in response.places().items():
        if name not in known[family]:
            mistakes.unknown_name((*path, key), name, words.get(family, family), known[family])
            return
        _kind(scene, path, response, name, mistakes)
        link = scene.links.get(name) if family == "joining link" else None
        if link is not None and any(end not in scene.bodies for end in link.between):
            mistakes.value(
                (*path, key),
                name,
                "does not join two bodies. Insertion loss compares the motion of the body behind the link: model "
                "the floor as a body.",
            )
    _parameter(scene, path, response, mistakes, broken)


def _kind(scene: Scene, path: Path, response: Response, place: str, mistakes: Mistakes) -> None:
    """A response of motion along a line is not one of what turns, and the other way round."""
    if not response.moves:
        return
    turning, ends = places.turning(scene), places.ends(scene)
    moving = {*scene.bodies, *scene.absorbers, *places.moving(scene)}
    if place in moving:
        kinds = {place in turning}
    else:
        two = [ends[place]] if place in ends else [one for one in ends.values() if place in one]
        kinds = {end in turning for one in two for end in one if end in moving}
    around = response.moves == "axis"
    where = dotted(path)
    if len(kinds) > 1:
        mistakes.add(
            path,
            f"{where} looks at {place}, where links that turn and links that move along a line end. Ask for each "
            "with through.",
        )
    elif kinds and around not in kinds:
        way = f' Write response = "{response.twin}".' if response.twin else ""
        if path[0] == "goal":
            way = way.replace("response =", f"{scene.goal.sense if scene.goal else 'minimise'} =")
        does = "moves along a line" if around else "turns"
        mistakes.add(path, f"{where} asks for the {response.response} of {place}, which {does}.{way}")


def _parameter(scene: Scene, path: Path, response: Response, mistakes: Mistakes, broken: set[str]) -> None:
    """A property of a link or of an absorber that it does not have."""
    key, name = response.response, getattr(response, "of", None)
    where = dotted(path)
    missing = ""
    if name in scene.links:
        missing = _missing_of_link(scene, key, name)
    elif name in scene.absorbers:
        missing = _missing_of_absorber(scene, key, name)
    elif response.of_link and any(name in table.joins(one) and not table.has(key) for _, one, table in _others(scene)):
        missing = f"that has no {key}. Ask for something else."
    if missing:
        mistakes.add(path, f"{where} asks for the {key} of {name}, but {missing}")
    lossy = [
        f"{family}.{one}"
        for family in ("links", "absorbers", "structures", "mounts")
        for one, table in getattr(scene, family).items()
        if table.loss_factor is not None
    ]
    if key == "damping_ratio" and name is None and lossy:
        mistakes.add(
            path,
            f"{where} asks for the damping ratio of free vibration, but {lossy[0]} has a loss_factor, which speaks of "
            f"steady harmonic motion only. Give that {lossy[0].split('s.')[0]} damping or damping_ratio instead.",
        )
    if key == "absorber_mass" and not set(scene.absorbers) - places.turning(scene) and not broken:
        mistakes.add(path, f"{where} asks for the mass of all absorbers, but there is none that moves along a line.")
    if key == "total_mass" and not {*scene.bodies, *scene.absorbers} - places.turning(scene) and not broken:
        mistakes.add(path, f"{where} asks for the mass of all bodies, but there is none that moves along a line.")
    mode, many = getattr(response, "mode", 1), max(places.freedoms(scene), 1)
    if mode > many:
        mistakes.value((*path, "mode"), mode, f"is more than the number of modes, {many}.")


def _others(scene: Scene) -> Iterator[tuple[str, str, Device]]:
    """What acts between two points beside links."""
    return (one for one in places.devices(scene) if one[2].between_points)


def _missing_of_link(scene: Scene, key: str, name: str) -> str:
    link = scene.links[name]
    if key in ("stiffness", "torsional_stiffness"):
        there = link.has_spring
    elif key == "damping_ratio":
        viscous = any(getattr(link, one) is not None for one in _DAMPERS)
        there = link.damping_ratio is not None or (viscous and link.has_spring and len(scene.bodies) == 1)
    elif key in (*_DAMPERS, "loss_factor"):
        there = getattr(link, key) is not None
    else:
        return ""
    return "" if there else f"links.{name} has no {key}. Add it, or ask for something else."


def _missing_of_absorber(scene: Scene, key: str, name: str) -> str:
    one = scene.absorbers[name]
    viscous = any(getattr(one, word) is not None for word in _DAMPERS)
    no_spring = f"absorbers.{name} has no spring. Add one, or ask for something else."
    if key in ("stiffness", "torsional_stiffness", "own_frequency", "tuning") and not one.has_spring:
        return no_spring
    if key in _DAMPERS and not (viscous or one.damping_ratio is not None):
        return f"absorbers.{name} has no damping. Add it, or ask for something else."
    if key == "damping_ratio" and not (one.damping_ratio is not None or (viscous and one.has_spring)):
        return f"absorbers.{name} has no damping_ratio. Add it, or ask for something else."
    if key == "loss_factor" and one.loss_factor is None:
        return f"absorbers.{name} has no loss_factor. Add it, or ask for something else."
    if key == "mass_ratio" and (one.relative_to or one.host) not in {**scene.bodies, **scene.absorbers}:
        return f"{one.host} is a point without a mass of its own. Ask for the mass of the absorber."
    if key == "tuning" and one.tuning is None and places.is_whole(scene):
        try:
            reference(scene, name)
        except NoReferenceError as error:
            return f"it has no frequency to refer to: {error}. Ask for its own_frequency."
    return ""
