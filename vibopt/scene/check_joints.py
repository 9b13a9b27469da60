"""Whether joints without mass are held, and what is not asked of them."""

from __future__ import annotations

from collections.abc import Iterable

from vibopt.document.mistakes import Mistakes
from vibopt.mechanics.builder import GROUND
from vibopt.scene import places
from vibopt.scene.check_random import damped_links
from vibopt.scene.scene import Scene


def check_joints(scene: Scene, mistakes: Mistakes) -> None:
    """Add what is wrong with bodies of no mass: each is held by springs, and nothing refers to a mass of theirs."""
    empty = places.empty(scene)
    if not empty:
        return
    first = next(iter(empty.values()))
    light = places.joints(scene)
    others = [
        *places.raw(scene, "structures"),
        *places.raw(scene, "rotors"),
        *(name for name, body in scene.bodies.items() if body.freedoms),
    ]
    if others:
        mistakes.add(
            (*first.split("."), "mass"),
            f"{first} has no mass, beside {others[0]}. A joint without mass is answered among bodies "
            "along one line. Give it its mass, or leave the other out.",
        )
    if {*scene.bodies, *scene.absorbers} <= {*empty}:
        mistakes.add(
            tuple(first.split(".")), 'nothing has a mass, so that nothing vibrates. Give a body its mass: "300 kg".'
        )
    if len(places.devices(scene)) == len(places.raw_devices(scene)):  # else one that could not be read may end there
        _carrying(scene, _held(scene, light, mistakes), mistakes)
        _braked(scene, light, mistakes)
    _ratios(scene, [*empty], mistakes)
    wheels = [
        (name, ends)
        for _, name, table in places.devices(scene)
        if table.passes > 1
        for ends in table.joins(name).values()
    ]
    for name, ends in wheels:
        if set(ends) <= set(empty):
            mistakes.add(
                ("inerters", name, "between"),
                f"inerters.{name} joins {ends[0]} and {ends[1]}, which have no mass. Together they float: put one of "
                "its ends on a body with mass, on a base or on the ground.",
            )
    for name, excitation in scene.excitations.items():
        if excitation.on in empty and excitation.kind == "unbalance":
            mistakes.add(
                ("excitations", name, "on"),
                f"excitations.{name} is an unbalance on {excitation.on}, which has no mass. What turns there has one: "
                'give it, or write kind = "force".',
            )


def check_beams(scene: Scene, mistakes: Mistakes) -> None:
    """Add what is wrong with beams that have a mass: it is spread between the body that each carries and a support."""
    heavy = {name: link for name, link in scene.links.items() if link.spreads_mass}
    along = {name for name, body in scene.bodies.items() if not body.freedoms} if heavy else set()
    for name, link in heavy.items():
        first, second = link.between
        path, where = ("links", name, "between"), f"links.{name}"
        if first == GROUND:
            mistakes.add(
                path,
                f"{where} begins at the ground, but its beam has a mass, of which more moves with its load than with "
                f'its supports. Write what it carries first: between = ["{second}", "ground"].',
            )
        other = next((one for one in (first, second) if one != GROUND and one not in along), "")
        if other:
            mistakes.add(
                path,
                f"{where} ends at {other}, but its beam has a mass, which is spread between bodies along a line and "
                f"the ground. Put a body there on a link of its own, or leave the mass of the beam out.",
            )
        if link.rubs:
            mistakes.add(
                ("links", name, "friction_force"),
                f"{where} rubs, and its beam has a mass: where friction holds its load, the beam goes on vibrating by "
                "itself. Leave the mass of the beam out, or write damping instead of the friction.",
            )


def _reached(start: Iterable[str], joined: list[tuple[str, str]], among: set[str]) -> set[str]:
    """Of some points those to which a chain leads from others."""
    found = set(start)
    for _ in among:
        found |= {end for ends in joined if found & set(ends) for end in ends if end in among}
    return found


def _ends(scene: Scene) -> dict[str, tuple[str, str]]:
    """The two ends of every link, of a geared body the one that turns freely."""
    rooted = places.ends(scene).items()
    return {name: (places.gear_root(scene, one), places.gear_root(scene, other)) for name, (one, other) in rooted}


def _carrying(scene: Scene, loose: set[str], mistakes: Mistakes) -> None:
    """Each joint joins two things, or is shaken."""
    for name, (ways, others) in idle_joints(scene).items():
        if not others or name in loose:
            continue
        text = (
            f"only {ways[0]} ends at it, which so carries nothing. Join a second link to it, or leave both out."
            if len(ways) == 1
            else f"{', '.join(ways[:-1])} and {ways[-1]} join it to {others[0]} alone, so that they carry nothing. "
            "Join one of them to something else, or leave them out."
        )
        where = places.empty(scene)[name]
        mistakes.add(tuple(where.split(".")), f"{where} has no mass, and {text}")


def idle_joints(scene: Scene) -> dict[str, tuple[list[str], list[str]]]:
    """Joints that nothing shakes and that join fewer than two things: what ends at each, and the one thing it joins."""
    ends = _ends(scene)
    shaken = {
        places.gear_root(scene, one) for excitation in scene.excitations.values() for one in excitation.everywhere
    }
    heavy = {end for name, link in scene.links.items() if link.spreads_mass for end in ends.get(name, ())}
    found = {}
    heavy |= {places.gear_root(scene, name) for name, body in scene.bodies.items() if not body.massless}
    light = [name for name in places.empty(scene) if places.gear_root(scene, name) == name]
    for name in (name for name in light if name not in shaken | heavy):
        ways = [link for link, two in ends.items() if name in two]
        others = sorted({end for link in ways for end in ends[link]} - {name})
        if len(others) < 2:
            found[name] = ways, others
    return found


def _held(scene: Scene, light: list[str], mistakes: Mistakes) -> set[str]:
    """Joints to which no chain of springs leads from what has mass or is a support; each is a mistake."""
    ends = _ends(scene)
    springs = [ends[name] for name in places.springs(scene)]
    held = _reached(set(places.points(scene)) - set(light), springs, set(light))
    loose = set(light) - held
    for name in loose:
        if sum(name in two for two in ends.values()) > 1:
            text = (
                "no spring holds it, so that it drifts under any steady force. Of dampers in a row write one: 1/c = "
                "1/c1 + 1/c2."
            )
        else:
            text = "nothing holds it. Join links with stiffness and damping to it, or leave it out."
        where = places.empty(scene)[name]
        mistakes.add(tuple(where.split(".")), f"{where} has no mass, and {text}")
    return loose


def _braked(scene: Scene, light: list[str], mistakes: Mistakes) -> None:
    """Dampers between joints lead on to something that moves by itself."""
    ends = _ends(scene)
    dampers = [ends[name] for name in damped_links(scene)]
    reached = _reached(set(places.points(scene)) - set(light), dampers, set(light))
    for name in light:
        other = next((two[0] if two[1] == name else two[1] for two in dampers if name in two), None)
        if other is not None and name not in reached:
            where = places.empty(scene)[name]
            mistakes.add(
                tuple(where.split(".")),
                f"{where} has no mass, and a damper joins it to {other}, which has none either, with springs "
                "alone on both sides. Springs and a damper in a row act in any order: put the springs in a row, as "
                "1/k = 1/k1 + 1/k2, and leave one joint out.",
            )
            return


def _ratios(scene: Scene, empty: list[str], mistakes: Mistakes) -> None:
    """Ratios, absorbers and the sums that need a mass."""
    for family, name, table in places.devices(scene):
        base = getattr(table, "relative_to", None)
        if base in empty:
            mistakes.value(
                (family, name, "relative_to"), base, "has no mass to which a ratio could refer. Name another body."
            )
    for name, absorber in scene.absorbers.items():
        if absorber.host in empty:
            mistakes.value(
                ("absorbers", name, "on"),
                absorber.host,
                "has no mass: an absorber works against one. Name a body with mass, or write it as a body and a link.",
            )
