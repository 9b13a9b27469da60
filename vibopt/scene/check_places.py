"""Where a response is read: places that are there, of the kind that it speaks of, with the property asked for."""

from __future__ import annotations

from vibopt.document.mistakes import Mistakes, Path, dotted
from vibopt.responses import Response
from vibopt.scene import places
from vibopt.scene.assemble import NoReferenceError, reference
from vibopt.scene.check_space import check_in_space
from vibopt.scene.scene import Scene
from vibopt.scene.space import carrier


def check_places(scene: Scene, path: Path, response: Response, mistakes: Mistakes, broken: set[str]) -> None:
    """Add what is wrong with the places of a response."""
    known = places.named(scene)
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
    around = response.moves == "axis"
    if not response.moves or not (around or places.turning(scene)):
        return
    kinds = _kinds_at(scene, place)
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


@places.once
def _kinds_at(scene: Scene, place: str) -> set[bool]:
    """Whether what moves at a place turns; of a link or a support whether what it ends at does.

    Of a body that could not be read nobody knows.
    """
    turning, ends = places.turning(scene), places.ends(scene)
    unread = {one for family in ("bodies", "absorbers") for one in places.raw(scene, family)}
    moving = {*places.moving(scene)} - unread | {*scene.bodies, *scene.absorbers}
    if place in unread - moving:
        return set()
    if place in moving:
        return {place in turning}
    two = [ends[place]] if place in ends else [one for one in ends.values() if place in one]
    return {end in turning for one in two for end in one if end in moving}


def _parameter(scene: Scene, path: Path, response: Response, mistakes: Mistakes, broken: set[str]) -> None:
    """A property of a link or of an absorber that it does not have."""
    said, key = vars(response), response.response
    name = said.get("of")
    missing, where = _missing(scene, response, name), dotted(path)
    if missing:
        mistakes.add(path, f"{where} asks for the {key} of {name}, but {missing}")
    if response.sums and not broken:
        every = {one for family in response.sums for one in getattr(scene, family)}
        if not every - places.turning(scene):
            what = f"the mass of all {response.sums[0]}"
            mistakes.add(path, f"{where} asks for {what}, but there is none that moves along a line.")
    mode = said.get("mode", 1)
    if mode > 1 and not broken and mode > (many := max(places.freedoms(scene), 1)):
        mistakes.value((*path, "mode"), mode, f"is more than the number of modes, {many}.")


def _missing(scene: Scene, response: Response, name: str | None) -> str:
    """Why a device has no such property; "" where it has, or where none is asked for."""
    if name is None or not (response.of_link or any(one == "absorber" for _, one in response.places().values())):
        return ""
    key, alone = response.response, len(scene.bodies) == 1
    for family, one, table in places.devices(scene):
        speaks = name in table.joins(one) and not (family == "mounts" and response.of_mount)
        if speaks and (several := table.several(key)):
            return f"{family}.{one} {several}"
        lacking = table.lacks(key, alone) if speaks else ""
        if lacking:
            may = lacking in type(table).model_fields or lacking != key
            way = f"Add {'it' if lacking in type(table).model_fields else 'one'}, or ask" if may else "Ask"
            return f"{family}.{one} has no {lacking}. {way} for something else."
    return _refers(scene, response.refers_to, name) if name in scene.absorbers else ""


def _refers(scene: Scene, what: str, name: str) -> str:
    """Why an absorber has nothing to which its ratio could refer."""
    absorber_table = scene.absorbers[name]
    if what == "mass" and (absorber_table.relative_to or carrier(scene, name)) not in {
        **scene.bodies,
        **scene.absorbers,
    }:
        return f"{absorber_table.host} is a point without a mass of its own. Ask for the mass of the absorber."
    if what == "frequency" and absorber_table.tuning is None and places.is_whole(scene):
        try:
            reference(scene, name)
        except NoReferenceError as error:
            return f"it has no frequency to refer to: {error}. Ask for its own_frequency."
    return ""
