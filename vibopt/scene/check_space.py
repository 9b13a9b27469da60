"""Mistakes of machines in space: names, missing directions, motions that nothing holds, mounts that are lifted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.document.mistakes import Mistakes, Path, dotted
from vibopt.mechanics.model import STIFFNESS, Model
from vibopt.mechanics.modes import sag
from vibopt.responses import Response
from vibopt.scene import places
from vibopt.scene.assemble import model_of
from vibopt.scene.scene import Scene
from vibopt.scene.space import bodies_in_space, carrier, guides, is_spatial, mount_of, place_in_space, sliders
from vibopt.units import show
from vibopt.values.directions import AXES, Vector, axis_words

if TYPE_CHECKING:
    from vibopt.devices.device import Device
    from vibopt.devices.mount import MountTable

_RANK = 1e-9
_OF_SPACE = {"direction", "axis"}
"""Words of a response that ask about space."""
_OF_LINKS = {"absorber", "link", "link or rotor", "body or link"}
"""What is asked of an absorber as of its spring and damper, along the direction in which it slides."""


def check_space(scene: Scene, mistakes: Mistakes) -> None:
    """Points, mounts, and what else ends at a body in space."""
    if not is_spatial(scene):
        return
    before = 0 if scene.absorbers else len(mistakes.found)  # a model needs to know what absorbers are tuned to
    known, space = places.points(scene), bodies_in_space(scene)
    for name, point in scene.points.items():
        if point.on not in space and not _unread(scene, point.on):
            mistakes.unknown_name(("points", name, "on"), point.on, "body in space", list(space))
    for family, name, table in places.devices(scene):
        ends = next(iter(table.joins(name).values()), ())
        if name in sliders(scene):
            _slides(scene, name, mistakes)
            continue
        if family != "absorbers" and any(end in sliders(scene) for end in ends):
            end = next(end for end in ends if end in sliders(scene))
            mistakes.add(
                (family, name, "between"),
                f"{family}.{name} ends at {end}, an absorber in space, on which only another absorber may sit. End it "
                f"at {scene.absorbers[end].host}.",
            )
            continue
        if table.placed:
            _ends(scene, (family, name), table, ends, known, mistakes)
            continue
        for end in ends if table.in_space else ():
            if place_in_space(scene, end):
                mistakes.add(
                    (family, name, "between" if table.between_points else "on"),
                    f"{family}.{name} ends at {end}, which moves in space, but it works along one line only. "
                    f"{table.in_space}",
                )
    if scene.structures and (space or scene.mounts):
        name = next(iter(scene.structures))
        mistakes.add(
            ("structures", name),
            f"structures.{name} and a body in space cannot be in one scene yet. Model the floor as a body of its own, "
            "with its mass on a link of its stiffness.",
        )
    if places.is_whole(scene) and len(mistakes.found) == before and not scene.structures and _held(scene, mistakes):
        _outside(scene, mistakes)


def _slides(scene: Scene, name: str, mistakes: Mistakes) -> None:
    """What an absorber with a direction sits on: something that moves in space."""
    table, host = scene.absorbers[name], scene.absorbers[name].host
    if host not in places.moving(scene) or _unread(scene, host):
        return  # said where absorbers are checked
    if not place_in_space(scene, host):
        knows = "axis" if host in places.turning(scene) else "line"
        mistakes.add(
            ("absorbers", name, "direction"),
            f"absorbers.{name} has a direction, but {host} knows one {knows} only. Remove direction.",
        )
    elif table.at is not None and host in scene.points:
        mistakes.add(
            ("absorbers", name, "at"),
            f"absorbers.{name} has at, but {host} is a place already. Remove at, or name the body.",
        )
    elif kept := _kept(scene, host, table.direction, turn=False):
        mistakes.add(("absorbers", name, "direction"), f"absorbers.{name} slides {kept}")


def _guides(scene: Scene, path: Path, response: Response, into: str, mistakes: Mistakes) -> bool:
    """Whether a force is asked for into an absorber in space, or into what guides one across its direction."""
    where, key = dotted(path), response.response
    if into in sliders(scene):
        mistakes.add(path, f'{where} asks for the {key} into {into}, an absorber. Write through = "{into}".')
        return True
    held = next((name for name in sliders(scene) if carrier(scene, name) == into), "")
    if held:
        mistakes.add(
            path,
            f"{where} asks for the {key} into {into}, on which absorbers.{held} slides: its guide pushes beside the "
            'springs. Ask into what carries it, for example into = "ground", or through a mount.',
        )
    return bool(held)


def _ends(
    scene: Scene, path: tuple[str, str], table: Device, ends: Sequence[str], known: list[str], mistakes: Mistakes
) -> None:
    where = ".".join(path)
    for end in ends:
        if end in scene.points or (end not in known and not table.between_points):
            good = [one for one in known if one not in scene.points]
            mistakes.unknown_name((*path, "between"), end, "body, base or ground", good)
            return
    if not any(end in places.moving(scene) for end in ends):
        if not table.between_points:
            mistakes.add((*path, "between"), f"{where} joins two supports, so nothing can move. Put a body at one end.")
    elif table.between_points and not any(place_in_space(scene, end) or _unread(scene, end) for end in ends):
        mistakes.add((*path, "at"), f"{where} has at, but neither of its ends moves in space. Remove at and direction.")


def _held(scene: Scene, mistakes: Mistakes) -> bool:
    """Whether springs hold every body in space against every motion; what is free is named."""
    model = model_of(scene)
    rows = np.array([term.vector[: model.n_free] for term in model.terms if term.kind == STIFFNESS])
    sizes = _sizes(scene, model)
    rows = rows.reshape(-1, model.n_free) * sizes
    _, values, vectors = np.linalg.svd(rows, full_matrices=True)
    rank = int((values > _RANK * values.max(initial=1e-300)).sum())
    seen = set()
    for free in vectors[rank:] * sizes:
        for name in bodies_in_space(scene):
            words = _motion(model, name, free)
            if words and name not in seen:
                seen.add(name)
                mistakes.add(
                    ("bodies", name),
                    f"nothing holds bodies.{name} against {words}{_why(scene, name)}. Place a mount "
                    'beside, or write motion = "plane" or "line" where it cannot move that way.',
                )
    return not seen


def _sizes(scene: Scene, model: Model) -> FloatArray:
    """A length for the turns, so that they compare with displacements, (n_free,)."""
    reach = [float(np.abs(np.array(at)).max()) for table in scene.mounts.values() for at in table.sites] or [1.0]
    turns = np.zeros(model.n_free, dtype=bool)
    for name in bodies_in_space(scene):
        for axis in AXES:
            turns |= model.points[f"{name}.r{axis}"][: model.n_free] != 0.0
    return np.where(turns, 1.0 / (max(reach) or 1.0), 1.0)


def _motion(model: Model, name: str, free: FloatArray) -> str:
    """How a body moves, in words; "" where it does not."""
    n = model.n_free
    slide = np.array([model.points[f"{name}.{axis}"][:n] @ free for axis in AXES])
    turn = np.array([model.points[f"{name}.r{axis}"][:n] @ free for axis in AXES])
    whole = float(np.linalg.norm(free))
    if np.linalg.norm(turn) > 1e-6 * whole:
        return f"turning about {axis_words(turn)}"
    return f"moving along {axis_words(slide)}" if np.linalg.norm(slide) > 1e-6 * whole else ""


def _why(scene: Scene, name: str) -> str:
    """What its mounts are like, where they leave it free."""
    many = sum(table.count for table in scene.mounts.values() if name in table.between)
    return (": it has no mount", ": it has one mount only", ": its mounts stand in one line")[min(many, 2)]


def _outside(scene: Scene, mistakes: Mistakes) -> None:
    """A centre of mass beyond the feet of its mounts, where no question looks at the loads."""
    if any(response.response == "static_load" for response in scene.responses.values()):
        return
    for name in bodies_in_space(scene):
        held = {m: t for m, t in scene.mounts.items() if name in t.between}
        if any(e in scene.bodies for t in held.values() for e in t.between if e != name):
            continue
        if scene.bodies[name].moves != "space" or any(
            abs(abs(f[2, 2]) - 1.0) > 0.3 for t in held.values() for f in t.frames
        ):
            continue
        feet = np.array([at[:2] for table in held.values() for at in table.sites])
        if not _beyond(feet, _weighed(scene, name)):
            continue
        what = f"bodies.{name}{' with its absorbers' if name in {root for root, _ in guides(scene).values()} else ''}"
        single, load = _lifted(scene, name, held)
        mistakes.add(
            ("bodies", name),
            f"the centre of mass of {what} lies outside its mounts: {single} is lifted with "
            f"{show(-load, '', 'force')}. Place a mount beyond it; or, for a mount that may pull, ask for response = "
            f'"static_load" of {mount_of(scene, single)}.',
        )


def _weighed(scene: Scene, name: str) -> FloatArray:
    """Where a body and the absorbers on it have their centre of mass, seen from above (2,) [m]."""
    centre = np.array(scene.bodies[name].place[:2])
    if not sliders(scene):
        return centre
    model = model_of(scene)
    weights = model.weights(model.values(_middle(scene), static=True))
    z, rx, ry = (float(weights @ model.points[f"{name}.{way}"]) for way in ("z", "rx", "ry"))
    return np.asarray(centre + np.array([-ry, rx]) / z)


def _middle(scene: Scene) -> FloatArray:
    """The middle of what may be chosen, (n_vars,)."""
    ends = [(v.low, min(v.high, 1e3 * max(v.low, 1e-3))) for v in scene.variables]
    return np.array([np.sqrt(low * high) for low, high in ends]) if ends else np.zeros(0)


def _beyond(feet: FloatArray, centre: FloatArray) -> bool:
    """Whether a point lies outside the hull of others in a plane, by half planes through pairs of them."""
    arms = feet - centre
    angles = np.sort(np.arctan2(arms[:, 1], arms[:, 0]))
    gaps = np.diff(np.concatenate([angles, [angles[0] + 2.0 * np.pi]]))
    return bool(np.linalg.norm(arms, axis=1).min() > 0.0 and gaps.max() > np.pi * (1.0 + 1e-9))


def _lifted(scene: Scene, body: str, held: Mapping[str, MountTable]) -> tuple[str, float]:
    """The mount that carries least, and what it carries [N], at the middle of what may be chosen."""
    model, x = model_of(scene), _middle(scene)
    down = sag(model, x)
    p = model.values(x, static=True)
    loads: dict[str, float] = {}
    for term, value in zip(model.terms, p, strict=True):
        single = term.owner.rpartition(".")[0]
        if down is not None and term.kind == STIFFNESS and mount_of(scene, single) in held:
            sign = 1.0 if model.ends[term.owner][0] == body else -1.0
            pull = -sign * value * float(term.vector @ down) * float(model.axes[term.owner][2])
            loads[single] = loads.get(single, 0.0) + pull
    least = min(loads, key=lambda one: loads[one])
    return least, loads[least]


def check_acting(scene: Scene, name: str, mistakes: Mistakes) -> bool:
    """Whether an excitation acts in space, where its direction is checked here."""
    excitation = scene.excitations[name]
    path, on = ("excitations", name), excitation.on
    if _half_read(scene) and on in (*places.moving(scene), *places.raw(scene, "points")):
        return True
    way, axis = getattr(excitation, "direction", None), getattr(excitation, "axis", None)
    inside = place_in_space(scene, on)
    if on in sliders(scene):
        mistakes.add(
            (*path, "on"),
            f"excitations.{name} acts on {on}, an absorber in space, which only its host moves. Act on "
            f"{scene.absorbers[on].host}.",
        )
        return True
    if inside and _unanswered(scene, name, mistakes):
        return True
    if excitation.family == "bases":
        return _moves_base(scene, name, mistakes)
    if not inside:
        said = [key for key in ("direction", "axis", "at") if getattr(excitation, key, None) is not None]
        if said and on in places.moving(scene) and not _unread(scene, on):
            mistakes.add(
                (*path, said[0]),
                f"excitations.{name} has {said[0]}, but {on} knows one line or axis only. Remove {said[0]}.",
            )
        return False
    if excitation.moment:
        if on not in bodies_in_space(scene):
            body = scene.points[on].on
            mistakes.add(
                (*path, "on"),
                f'excitations.{name} is a moment, which acts on a body and not at a place. Write on = "{body}".',
            )
        elif axis is None:
            mistakes.add(path, f'excitations.{name} is a moment about no axis. Add axis = "x", or "y" or "z".')
        elif kept := _kept(scene, on, axis, turn=True):
            mistakes.add(path, f"excitations.{name} acts {kept}")
    elif way is None and axis is None:
        more = ', or axis = "x" where it rotates about it' if excitation.kind == "unbalance" else ""
        mistakes.add(
            path,
            f'excitations.{name} acts on {on}, which moves in space, but in no direction. Add direction = "z"{more}.',
        )
    elif kept := _kept(scene, on, way, turn=False):
        mistakes.add(path, f"excitations.{name} acts {kept}")
    if getattr(excitation, "at", None) is not None and on not in bodies_in_space(scene):
        mistakes.add(
            (*path, "at"), f"excitations.{name} has at, but {on} is a place already. Remove at, or name the body."
        )
    return True


def _unanswered(scene: Scene, name: str, mistakes: Mistakes) -> bool:
    """Whether an excitation on a body in space runs up, or lets it go, in a way that has no answer; adds it."""
    excitation, path = scene.excitations[name], ("excitations", name)
    on, axis, ramp = excitation.on, getattr(excitation, "axis", None), excitation.ramp
    if ramp is not None and (axis is not None or ramp.torque is not None):
        what = "goes round an axis and runs up" if axis is not None else "runs up by torque"
        way = 'direction = "z" instead of axis' if axis is not None else 'acceleration = "50 rpm/s" instead of torque'
        mistakes.add(
            (*path, "run_up"),
            f"excitations.{name} {what}, but in space a run-up is answered of a force along one direction, at a known "
            f"rate. Write {way}.",
        )
        return True
    if excitation.once is None or not any(excitation.once.start):
        return False
    if on in scene.points:
        text = f'releases a place. Release the body: on = "{scene.points[on].on}".'
        mistakes.add((*path, "on"), f"excitations.{name} {text}")
        return True
    rides = next((one for one in sliders(scene) if _under(scene, one) == on), "")
    if rides:
        mistakes.add(
            (*path, "on"),
            f"excitations.{name} releases {on}, on which absorbers.{rides} slides: nobody says where that begins. "
            'Strike the body instead: kind = "pulse" with a short duration.',
        )
    return bool(rides)


def _moves_base(scene: Scene, name: str, mistakes: Mistakes) -> bool:
    """Whether a base that an excitation moves carries mounts, where its direction is checked here."""
    excitation, path = scene.excitations[name], ("excitations", name)
    on, way = excitation.on, getattr(excitation, "direction", None)
    if on in scene.bases and getattr(excitation, "at", None) is not None:
        mistakes.add((*path, "at"), f"excitations.{name} has at, but {on} is a base and moves as one. Remove at.")
    carries = any(on in table.between for table in scene.mounts.values())
    if carries and way is None and "direction" in type(excitation).model_fields:
        mistakes.add(path, f'excitations.{name} moves {on} in no direction. Add direction = "z", or "x" or "y".')
    placed = (two for _, one, table in places.devices(scene) if table.placed for two in table.joins(one).values())
    if way is not None and on in scene.bases and not _half_read(scene) and not any(on in two for two in placed):
        alone = not bodies_in_space(scene)
        if alone or any(way[:2]):
            rest = "Remove direction." if alone else 'Write direction = "z".'
            mistakes.add(
                (*path, "direction"),
                f"excitations.{name} has a direction, but what stands on {on} moves along one line only. {rest}",
            )
    return carries


def _under(scene: Scene, name: str) -> str:
    """The body in space that an absorber in space sits on, or that others carry which it sits on."""
    host = carrier(scene, name)
    return _under(scene, host) if host in sliders(scene) else host


@places.once
def _half_read(scene: Scene) -> bool:
    """Whether a table of a machine in space has a mistake: then nobody knows what moves where."""
    if not (is_spatial(scene) or places.raw(scene, "mounts") or places.raw(scene, "points")):
        return False
    return any(
        name not in getattr(scene, one) for one in ("bodies", "mounts", "points") for name in places.raw(scene, one)
    )


def _unread(scene: Scene, name: str) -> bool:
    """Whether a name is that of a table with a mistake: nobody knows how it moves."""
    return any(name in places.raw(scene, one) and name not in getattr(scene, one) for one in ("bodies", "points"))


def check_in_space(scene: Scene, path: Path, response: Response, mistakes: Mistakes) -> bool:
    """Whether a response asks about something in space, where its place and direction are checked here."""
    if _half_read(scene):
        return True
    flat = not (scene.mounts or is_spatial(scene) or response.in_space == "whole")
    if flat and not _OF_SPACE & response.model_fields_set and all(k != "mount" for _, k in response.places().values()):
        return False
    where, key, said = dotted(path), response.response, vars(response)
    name, into = said.get("of") or said.get("through") or said.get("across"), said.get("into")
    group, inside = mount_of(scene, name), name is not None and place_in_space(scene, name)
    ends = {end for table in scene.mounts.values() for end in table.between}
    way = said.get("direction") or said.get("axis")
    whole = response.in_space == "whole"
    if whole and name in places.moving(scene) and name not in bodies_in_space(scene):
        what = "is an absorber" if name in sliders(scene) else "does not move in space"
        mistakes.add(path, f"{where} asks for the {key} of {name}, which {what}. Name a body in space.")
        return True
    if into in places.moving(scene) and _guides(scene, path, response, str(into), mistakes):
        return True
    if name in sliders(scene) and _OF_LINKS & {family for one, family in response.places().values() if one == name}:
        turned = bool(_OF_SPACE & response.model_fields_set)
        if turned:
            mistakes.add(
                (*path, "direction"), f"{where} has a direction, but {name} slides along its own. Remove direction."
            )
        return turned
    if "mount" in (family for _, family in response.places().values()) and not group:
        known = [fromkey for g, table in scene.mounts.items() for fromkey in dict.fromkeys((g, *table.singles(g)))]
        mistakes.unknown_name((*path, "of"), str(name), "mount", known)
        return True
    if group:
        _of_mount(scene, path, response, str(name), group, mistakes)
        return True
    for link in ("through", "across"):
        if inside and said.get(link) == name:
            mistakes.unknown_name((*path, link), str(name), "link or mount", places.links(scene))
            return True
    if inside:
        _of_body(scene, path, response, str(name), mistakes)
        return True
    if into is not None and into in ends:
        if getattr(response, "normalised", False):
            mistakes.add(
                path, f'{where}: {key} has no direction. Write response = "transmitted_force" with a direction.'
            )
        elif into in scene.points or into not in places.points(scene):
            mistakes.unknown_name((*path, "into"), into, "body, base or ground", places.points(scene))
        elif way is None:
            mistakes.add(
                path, f'{where} asks for the {key} into {into} in no direction. Add direction = "z", or "x" or "y".'
            )
        return True
    there = name in (*places.moving(scene), *places.ends(scene)) or into in places.points(scene)
    for word, article, only in (("direction", "a", "line"), ("axis", "an", "axis")):
        if word in response.model_fields_set and there and not _unread(scene, str(name)):
            mistakes.add(
                (*path, word),
                f"{where} has {article} {word}, but {name or into} knows one {only} only. Remove {word}.",
            )
    return False


def _of_mount(scene: Scene, path: Path, response: Response, name: str, group: str, mistakes: Mistakes) -> None:
    where, key = dotted(path), response.response
    way = getattr(response, "direction", None)
    if key.endswith("relative_displacement"):
        travel = key.replace("relative_displacement", "travel")
        mistakes.add(path, f'{where} asks for the {key} across {name}. Write response = "{travel}" with of = "{name}".')
    elif "through" in response.places():
        if way is None:
            mistakes.add(
                path, f'{where} asks for the force through {name} in no direction. Add direction = "z", or "x" or "y".'
            )
    elif key == "static_deflection" and "direction" in response.model_fields_set:
        mistakes.add(
            (*path, "direction"),
            f"{where} has a direction, but {name} sags along its own axis. Remove direction, or ask of a body.",
        )
    elif not response.of_mount:
        mistakes.add(path, f"{where} asks for the {key} of {name}, which is a mount. Ask for something else.")
    elif key in ("damping", "loss_factor") and getattr(scene.mounts[group], key) is None:
        mistakes.add(path, f"{where} asks for the {key} of {name}, but mounts.{group} has no {key}. Add it.")
    if response.of_mount in ("alike", "group") and name != group:
        mistakes.add(
            path, f'{where} asks for the {key} of one mount, but all of a group are alike. Write of = "{group}".'
        )


def _of_body(scene: Scene, path: Path, response: Response, name: str, mistakes: Mistakes) -> None:
    where, key, asks = dotted(path), response.response, response.in_space
    axis, way = getattr(response, "axis", None), getattr(response, "direction", None)
    if asks == "direction" and way is None:
        mistakes.add(path, f'{where} asks for the {key} of {name} in no direction. Add direction = "z", or "x" or "y".')
    elif asks == "axis" and axis is None:
        mistakes.add(path, f'{where} asks for the {key} of {name} about no axis. Add axis = "x", or "y" or "z".')
    elif not asks or (asks == "body" and name in scene.points):
        mistakes.add(path, f"{where} asks for the {key} of {name}, which moves in space. Ask for something else.")
    elif asks == "whole" and name in scene.points:
        mistakes.add(path, f'{where} asks for the {key} of a place. Write of = "{scene.points[name].on}".')
    else:
        kept = _kept(scene, name, axis or way, turn=axis is not None)
        if kept:
            mistakes.add(path, f"{where} asks for the {key} {kept}")


def _kept(scene: Scene, name: str, way: Vector | None, *, turn: bool) -> str:
    """That a body in a plane does not move along a direction, or turn about an axis; "" where it does."""
    body = scene.points[name].on if name in scene.points else name
    free = scene.bodies[body].freedoms if body in scene.bodies else ()
    if (
        way is None
        or not free
        or any(f"{'r' * turn}{axis}" in free for axis, part in zip(AXES, way, strict=True) if part)
    ):
        return ""
    what = ("about", 'axis = "y"') if turn else ("along", 'direction = "x", or "z"')
    return (
        f"{what[0]} {axis_words(way)}, but bodies.{body} moves in a plane: along x and z, and about y. Write {what[1]}."
    )
