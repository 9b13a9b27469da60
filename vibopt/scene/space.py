"""What of a scene moves in space, and for which single questions one of a scene stands."""

from __future__ import annotations

from vibopt.responses import HarmonicResponse, Response
from vibopt.scene.drives import names_for
from vibopt.scene.places import devices, once
from vibopt.scene.scene import Scene
from vibopt.values.directions import AXES, Vector


@once
def bodies_in_space(scene: Scene) -> tuple[str, ...]:
    """Bodies that move in space or in a plane."""
    return tuple(name for name, body in scene.bodies.items() if body.freedoms)


@once
def is_spatial(scene: Scene) -> bool:
    """Whether anything in the scene has a place in space."""
    placed = any(table.placed for _, _, table in devices(scene))
    return bool(placed or scene.points or bodies_in_space(scene) or spatial_bases(scene))


@once
def spatial_bases(scene: Scene) -> tuple[str, ...]:
    """Bases that carry mounts, or move in a direction."""
    if not scene.bases:
        return ()
    placed = [two for _, name, table in devices(scene) if table.placed for two in table.joins(name).values()]
    ends = {end for two in placed for end in two}
    told = {
        excitation.on for excitation in scene.excitations.values() if getattr(excitation, "direction", None) is not None
    }
    return tuple(name for name in scene.bases if name in ends | told)


def pins(scene: Scene) -> dict[str, tuple[str, Vector]]:
    """Places on bodies in space by name: points of the file, and where excitations act."""
    found = {name: (point.on, point.at) for name, point in scene.points.items()}
    for excitation in scene.excitations.values():
        at = getattr(excitation, "at", None)
        if at is not None:
            found[excitation.place] = (excitation.on, at)
    return found


def guides(scene: Scene) -> dict[str, tuple[str, Vector]]:
    """Per absorber in space what carries it, a body or another absorber, and where [m]."""
    return {name: (carrier(scene, name), _place(scene, name)) for name in sliders(scene)}


def _place(scene: Scene, name: str) -> Vector:
    """Where an absorber in space sits [m]; a function within one that calls itself would keep the scene alive."""
    host, at = scene.absorbers[name].host, scene.absorbers[name].at
    if host in scene.points:
        return scene.points[host].at
    return at or (_place(scene, host) if host in scene.absorbers else scene.bodies[host].place)


def carrier(scene: Scene, name: str) -> str:
    """The body or absorber that an absorber sits on: of a point its body."""
    host = scene.absorbers[name].host
    return scene.points[host].on if host in scene.points else host


@once
def sliders(scene: Scene) -> tuple[str, ...]:
    """Absorbers in space."""
    return tuple(name for name, absorber in scene.absorbers.items() if absorber.placed)


def place_in_space(scene: Scene, name: str) -> bool:
    """Whether a name is a body in space, a point on one, or an absorber in space."""
    return name in bodies_in_space(scene) or name in scene.points or name in sliders(scene)


def members(scene: Scene, response: Response) -> tuple[Response, ...]:
    """The questions that one stands for: one a mount, an axis, a place of a rotor or of an unbalance; else itself."""
    if _single(scene):
        return (response,)
    asked, driven = _places_of(scene, response), response.reading or response
    for name in names_for(scene, driven) if isinstance(driven, HarmonicResponse) else ():
        if every := scene.excitations[name].anywhere:
            asked = tuple(
                one.model_copy(update={"placed": {**one.placed, name: place}}) for one in asked for place in every
            )
    return asked


@once
def _single(scene: Scene) -> bool:
    """Whether every question is a single one."""
    return not (scene.rotors or scene.mounts or any(one.anywhere for one in scene.excitations.values()))


def _places_of(scene: Scene, response: Response) -> tuple[Response, ...]:
    """The same, whatever shakes."""
    if response.of_rotor and (rotor := scene.rotors.get(vars(response)["of"])) is not None:
        every = rotor.bent(vars(response)["of"])
        return tuple(response.model_copy(update={"of": one}) for one in every)
    for key in ("of", "through", "across") if scene.mounts else ():
        name = getattr(response, key, None)
        singles = _singles(scene, name)
        if not singles or response.of_mount == "group":
            continue
        if response.of_mount == "alike":
            return (response.model_copy(update={key: f"{singles[0]}.z"}),)
        if response.of_mount == "axes" and getattr(response, "direction", None) is None:
            return tuple(response.model_copy(update={key: f"{single}.{axis}"}) for single in singles for axis in AXES)
        if response.of_mount == "axis":
            return tuple(response.model_copy(update={key: f"{single}.z"}) for single in singles)
        return tuple(response.model_copy(update={key: single}) for single in singles)
    return (response,)


def _singles(scene: Scene, name: str | None) -> tuple[str, ...]:
    """Mounts that a name means: all of a group, or one."""
    for group, table in scene.mounts.items():
        if name == group:
            return table.singles(group)
        if name in table.singles(group):
            return (str(name),)
    return ()


def mount_of(scene: Scene, name: str | None) -> str:
    """The group that a name belongs to; "" for none."""
    return next((g for g, table in scene.mounts.items() if name == g or name in table.singles(g)), "")
