"""Mistakes in what shakes the machine."""

from __future__ import annotations

from vibopt.document.mistakes import Mistakes, given_at
from vibopt.scene import places
from vibopt.scene.check_random import wrong_density
from vibopt.scene.check_space import check_acting
from vibopt.scene.scene import Scene
from vibopt.scene.space import bodies_in_space


def check_excitations(scene: Scene, mistakes: Mistakes) -> None:
    """Where excitations act, at which speeds, and how they grow."""
    moving, supports = places.moving(scene), places.supports(scene)
    for name, excitation in scene.excitations.items():
        path = ("excitations", name)
        known = moving if excitation.family == "bodies" else supports
        what = "body" if excitation.family == "bodies" else "base"
        if wrong_density(scene, name, mistakes):
            continue
        if what == "base" and excitation.on in moving:
            word = 'is a body, but the motion of a base is given. Write [bases.floor], links to it, and on = "floor".'
            mistakes.value((*path, "on"), excitation.on, word)
        elif what == "body" and excitation.on in scene.bases and moving:
            word = (
                f'is a base, but what is given acts on a body. Write on = "{moving[0]}", or how the base moves: '
                'kind = "base_motion", or the acceleration of a pulse or a record.'
            )
            mistakes.value((*path, "on"), excitation.on, word)
        elif excitation.on not in known:
            mistakes.unknown_name((*path, "on"), excitation.on, what, known)
        else:
            _kind(scene, name, mistakes)
            _further(scene, name, mistakes)
        if excitation.of_vehicle != (excitation.speed.dimension == "velocity"):
            word = (
                'is no vehicle speed. Write "60 km/h".'
                if excitation.of_vehicle
                else 'is a vehicle speed. Write a speed of rotation or a frequency, for example "3000 rpm".'
            )
            mistakes.value((*path, "speed"), given_at(scene.document, (*path, "speed")), word)
        if excitation.needs_reference:
            mistakes.add(
                (*path, "varies"),
                f"excitations.{name} varies with speed, but its speed is not one value: to which speed does the "
                'amplitude belong? Add amplitude_at = "2000 rpm".',
            )
        elif not excitation.grows and getattr(excitation, "amplitude_at", None) is not None:
            mistakes.add(
                (*path, "amplitude_at"),
                f"excitations.{name} has amplitude_at, but its amplitude does not grow with a power of the speed. "
                'Write varies = "speed^2", or leave amplitude_at out.',
            )
        elif excitation.ramp is not None:
            from vibopt.scene.check_run_up import check_run_up

            check_run_up(scene, name, mistakes)
        if getattr(excitation, "begins", None) is not None:
            _begins(scene, name, mistakes)
        if excitation.begins_at_rest:
            mistakes.add(
                path,
                f"excitations.{name} has an amplitude that grows with the speed, but gives it at standstill, where "
                'it is zero. Write amplitude_at = "2000 rpm".',
            )
        if excitation.speed.asked and scene.find_all != f"{name}.speed":
            mistakes.add(
                (*path, "speed"),
                f'excitations.{name}.speed is a range to choose from, which only find_all = "{name}.speed" can '
                'answer. Write one speed, or "a..b" for every speed in a range.',
            )


def _begins(scene: Scene, name: str, mistakes: Mistakes) -> None:
    """What begins suddenly has one speed, and something in time is asked, which alone shows it."""
    path, speed = ("excitations", name, "begins"), scene.excitations[name].speed
    asked = [*scene.limits.values(), *scene.measures.values(), *([scene.goal.response] if scene.goal else [])]
    if not (speed.is_one_speed and speed.highest > 0.0):
        mistakes.add(
            path, f'excitations.{name} begins suddenly, at which speed? Write one above zero: speed = "2000 rpm".'
        )
    elif asked and not any(response.sort == "transient" for response in asked):
        mistakes.add(
            path,
            f"excitations.{name} begins suddenly, but what is asked is steady, as if it had run for long. Ask for what "
            'is greatest in time, response = "peak_displacement" for example, or leave begins out.',
        )


def _further(scene: Scene, name: str, mistakes: Mistakes) -> None:
    """Further places on which it acts: of one kind with the first, and followed in steady linear vibration."""
    excitation = scene.excitations[name]
    others, known = excitation.everywhere[1:], places.moving(scene)
    path, said = ("excitations", name, "or_on" if excitation.anywhere else "also"), vars(excitation)
    only = next((key for key in ("or_on", "angles") if said.get(key)), "")
    if not others and not only:
        return
    spun = {point for table in scene.rotors.values() for point in table.names}
    off = next((on for on in excitation.everywhere if on in known and on not in spun), "")
    if only and off:
        mistakes.add(
            ("excitations", name, only),
            f"excitations.{name}.{only} is of an unbalance on a rotor, and {off} is no station and no disc of one. "
            "Name one, or leave it out.",
        )
        return
    odd = {*places.turning(scene), *bodies_in_space(scene), *scene.points}
    for on in others:
        if on not in known:
            mistakes.unknown_name(path, on, "body", known)
        elif on in odd or excitation.on in odd:
            mistakes.add(
                path,
                f"excitations.{name}.also has an unbalance on {on}, but {on if on in odd else excitation.on} turns or "
                "moves in space. Further unbalances are along a line and of rotors: write excitations of their own.",
            )
    if others and places.rubbing(scene):
        mistakes.add(
            path,
            f"excitations.{name} has further unbalances (also) beside the dry friction of "
            f"links.{places.rubbing(scene)[0]}, which is answered under one force. Keep one of them.",
        )


def _kind(scene: Scene, name: str, mistakes: Mistakes) -> None:
    """Forces act on what moves along a line, moments on what turns."""
    if check_acting(scene, name, mistakes):
        return
    excitation, turning, path = scene.excitations[name], places.turning(scene), ("excitations", name)
    on, kind = excitation.on, excitation.kind
    if excitation.family == "bases":
        around = sorted(places.neighbours(scene).get(on, set()) & turning)
        if around:
            mistakes.add(
                path,
                f"excitations.{name} moves {on} along a line, but {around[0]} on it turns. The twist of a base is not "
                f'supported: put kind = "moment" on {around[0]}.',
            )
    elif kind == "release" and on in places.carried(scene):
        mistakes.add(
            path,
            f"excitations.{name} lets {on} go, a point of a structure, and says nothing of how the rest of it is bent. "
            'Let a body go that stands there, or push it: kind = "pulse".',
        )
    elif on in turning and excitation.sort == "transient":
        mistakes.add(
            path,
            f'excitations.{name} is of kind "{kind}", but {on} turns. What comes once is answered for bodies on a line '
            "only, so far.",
        )
    elif on in turning and not excitation.moment:
        mistakes.add(
            path,
            f'excitations.{name} is of kind "{kind}", but {on} turns. Write kind = "moment" with amplitude = '
            '"300 N m".',
        )
    elif excitation.moment and on not in turning and on in {**scene.bodies, **scene.absorbers}:
        mistakes.add(
            path,
            f"excitations.{name} is a moment, but {on} moves along a line. Write kind = "
            f'"{excitation.moment}" with amplitude = "6 kN".',
        )
