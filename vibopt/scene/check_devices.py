"""Mistakes in what a scene is made of: names, ends of links, hosts of absorbers, lines mixed with axes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vibopt.document.mistakes import Mistakes, given_at
from vibopt.errors import way_out
from vibopt.mechanics.builder import GROUND
from vibopt.scene import places
from vibopt.scene.assemble import NoReferenceError, reference
from vibopt.scene.scene import Scene
from vibopt.scene.space import carrier

if TYPE_CHECKING:
    from vibopt.devices.absorber import AbsorberTable
    from vibopt.devices.device import Device, Ends

CARRIED = ("bodies", "structures", "rotors")
"""Families of what can move by itself: a machine has something of one of them."""


def check_names(scene: Scene, mistakes: Mistakes) -> bool:
    """Every point and every link has a name of its own; whether there is anything that can move."""
    seen: dict[str, str] = {}
    for family, kind, name, table in places.raw_devices(scene):
        own = (*kind.moving_in(name, table), *kind.supports_in(name, table), *kind.links_in(name, table))
        for fromkey in dict.fromkeys((name, *own)):
            _check_name(family, name, fromkey, seen, mistakes)
    if any(places.raw(scene, family) for family in CARRIED):
        return True
    mistakes.add((), 'there is no body. Add [bodies.NAME] with mass = "300 kg".')
    return False


def _check_name(family: str, name: str, one: str, seen: dict[str, str], mistakes: Mistakes) -> None:
    if not name.strip():
        mistakes.add((family, name), f"a table of {family} has no name. Give it one: [{family}.fan].")
        return
    takes = "takes" if one == name else f"has a point {one}, which takes"
    if one == GROUND:
        mistakes.add(
            (family, name), f'{family}.{name} {takes} the name "ground", which is the fixed ground. Choose another.'
        )
    elif one in seen:
        mistakes.add((family, name), f"{family}.{name} {takes} a name that {seen[one]} has already. Choose another.")
    else:
        seen[one] = f"{family}.{one}" if one == name else f"{family}.{name}"


def check_links(scene: Scene, mistakes: Mistakes) -> None:
    """Ends of what acts between two points, and what its ratios refer to."""
    points, moving = places.points(scene), places.moving(scene)
    bodies = list(places.raw(scene, "bodies"))
    heavy = [*bodies, *places.raw(scene, "absorbers")]
    for family, name, table in places.devices(scene):
        if not table.between_points:
            continue
        path, between = (family, name), table.joins(name)[name]
        for end in between:
            if end not in points:
                mistakes.value(
                    (*path, "between"),
                    list(between),
                    f'names "{end}", which is no body, base or ground.{way_out(end, points)}',
                )
        if all(end in points and end not in moving for end in between):
            mistakes.value(
                (*path, "between"), list(between), "joins two supports, so nothing can move. Put a body at one end."
            )
        relative = getattr(table, "relative_to", None)
        if relative is not None and relative not in heavy:
            mistakes.unknown_name((*path, "relative_to"), relative, "body", heavy)
        elif getattr(table, "damping_ratio", None) is not None:
            _relative(scene, name, relative, [*(end for end in between if end in bodies), *bodies], mistakes)
        elif getattr(table, "mass_ratio", None) is not None:
            _one_mass(scene, f"{family}.{name}.mass_ratio", (*path, "mass_ratio"), str(relative), mistakes)
        _one_kind(scene, path, table, between, mistakes)


def _relative(scene: Scene, name: str, relative: str | None, bodies: list[str], mistakes: Mistakes) -> None:
    """A damping ratio says to which mass it is; `bodies` are those at its ends first, then all."""
    if relative is None and len({*bodies}) != 1:
        example = f'relative_to = "{bodies[0]}"' if bodies else 'damping = "5 kN s/m" instead'
        mistakes.add(
            ("links", name),
            f"links.{name} gives a damping ratio, but several bodies move: relative to which mass? Add {example}.",
        )
        return
    _one_mass(scene, f"links.{name}.damping_ratio", ("links", name, "damping_ratio"), relative or bodies[0], mistakes)


def _one_mass(scene: Scene, said: str, path: tuple[str, ...], base: str, mistakes: Mistakes) -> None:
    """A ratio to the mass of a body that rolls needs that mass as a fact."""
    body = scene.bodies.get(base)
    if body is not None and body.rolling is not None and f"bodies.{base}.mass" in {v.path for v in scene.variables}:
        mistakes.add(
            path,
            f"{said} refers to {base}, which rolls and whose mass is to be chosen. Write the mass of {base} as a fact.",
        )


def _one_kind(scene: Scene, path: tuple[str, str], table: Device, between: Ends, mistakes: Mistakes) -> None:
    """A link joins what moves along a line, or what turns about an axis, and has values of that kind."""
    turning = places.turning(scene)
    if not turning and not table.says_axis:
        return
    around = [end for end in between if end in turning]
    along = [end for end in between if end not in turning and end in _lines(scene)]
    relative = getattr(table, "relative_to", None) if getattr(table, "mass_ratio", None) is not None else None
    if around and along:
        mistakes.value(
            (*path, "between"),
            list(between),
            f"joins {around[0]}, which turns, with {along[0]}, which moves along a line. Join two of one kind.",
        )
        return
    if relative is not None and (around or along) and (relative in turning) != bool(around):
        mistakes.value((*path, "relative_to"), relative, "moves in another way than what it joins: one of them turns.")
        return
    key = table.says_axis if along else table.says_line if around else ""
    if key:
        _wrong_key(path, table, key, (along or around)[0], bool(around), mistakes)


def _wrong_key(path: tuple[str, str], table: Device, key: str, place: str, turns: bool, mistakes: Mistakes) -> None:
    what = ("along a line", f"{place} turns") if turns else ("about an axis", f"{place} moves along a line")
    mistakes.add((*path, key), f"{'.'.join(path)}.{key} is {what[0]}, but {what[1]}. Write {table.other_way[key]}.")


@places.once
def _lines(scene: Scene) -> set[str]:
    """Points that move along a line for sure: those of tables that could be read."""
    known = {*scene.bodies, *scene.absorbers}
    broken = {*places.raw(scene, "bodies"), *places.raw(scene, "absorbers")} - known
    return set(places.moving(scene)) - broken - places.turning(scene)


def check_absorbers(scene: Scene, mistakes: Mistakes) -> None:
    """What absorbers sit on and refer to."""
    good = sum(not _host(scene, name, absorber, mistakes) for name, absorber in scene.absorbers.items()) == 0
    if not good or _ring(scene, mistakes):
        return
    for name, absorber in scene.absorbers.items():
        _heavy_enough(scene, name, absorber, mistakes)
        key = (
            absorber.says_line
            if absorber.host in places.turning(scene)
            else absorber.says_axis
            if absorber.host in _lines(scene)
            else ""
        )
        if key:
            turns = absorber.host in places.turning(scene)
            _wrong_key(("absorbers", name), absorber, key, absorber.host, turns, mistakes)
        elif absorber.tuning is not None and places.is_whole(scene):
            _tuned(scene, name, mistakes)


def _host(scene: Scene, name: str, table: AbsorberTable, mistakes: Mistakes) -> bool:
    """Whether an absorber sits on something that is there and gives way."""
    path = ("absorbers", name, "on")
    host, moving = table.host, places.moving(scene)
    if host == name:
        mistakes.value(path, host, "is the absorber itself. Name what it sits on.")
    elif host == GROUND or host in places.supports(scene):
        mistakes.value(path, host, "is a support that does not give way: an absorber on it does nothing. Name a body.")
    elif host not in moving:
        mistakes.value(
            path, host, f"names no body, absorber or point of a structure of this scene.{way_out(host, moving)}"
        )
    elif table.relative_to is not None:
        return _refers(scene, name, table.relative_to, mistakes)
    else:
        return True
    return False


def _refers(scene: Scene, name: str, relative: str, mistakes: Mistakes) -> bool:
    known = [*places.raw(scene, "bodies"), *places.raw(scene, "absorbers")]
    if relative in known and relative != name:
        return True
    known = [one for one in known if one != name]
    mistakes.unknown_name(("absorbers", name, "relative_to"), relative, "other body or absorber", known)
    return False


def _ring(scene: Scene, mistakes: Mistakes) -> bool:
    """Whether absorbers sit on, or refer to, each other in a ring."""
    for name in scene.absorbers:
        seen, todo = set(), [name]
        while todo:
            table = scene.absorbers.get(todo.pop())
            for under in (table.host, table.relative_to) if table is not None else ():
                if under == name:
                    ring = [absorber for absorber in scene.absorbers if absorber == name or absorber in seen]
                    mistakes.add(
                        ("absorbers", name, "on"),
                        f"absorbers.{name} sits on itself by way of {' and '.join(ring[1:]) or name}. Put one of them "
                        "on a body.",
                    )
                    return True
                if under is not None and under not in seen:
                    seen.add(under)
                    todo.append(under)
    return False


def _heavy_enough(scene: Scene, name: str, table: AbsorberTable, mistakes: Mistakes) -> None:
    """A mass ratio needs one mass that it refers to."""
    if table.mass_ratio is None:
        return
    base, path = table.relative_to or carrier(scene, name), ("absorbers", name, "mass_ratio")
    if base not in {*places.raw(scene, "bodies"), *places.raw(scene, "absorbers")}:
        mistakes.value(
            path,
            given_at(scene.document, path),
            f'refers to {base}, a point without a mass of its own. Add relative_to = "BODY", or give the mass.',
        )
    elif table.relative_to is not None and (base in places.turning(scene)) != (table.host in places.turning(scene)):
        mistakes.value(
            ("absorbers", name, "relative_to"),
            base,
            "moves in another way than what the absorber sits on: one of them turns.",
        )
    _one_mass(scene, f"absorbers.{name}.mass_ratio", path, base, mistakes)


def _tuned(scene: Scene, name: str, mistakes: Mistakes) -> None:
    path = ("absorbers", name, "tuning")
    try:
        reference(scene, name)
    except NoReferenceError as error:
        mistakes.value(
            path,
            given_at(scene.document, path),
            f'has no frequency to refer to: {error}. Write tuning_to = "25 Hz", or the frequency of the absorber.',
        )
