"""Which of the layouts that open ends allow can be built: a joint may drift in one of them and be held in another."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from vibopt.document.mistakes import Mistakes
from vibopt.excitations.release import Release
from vibopt.records import dataclass
from vibopt.scene import places
from vibopt.scene.check_joints import idle_joints
from vibopt.scene.check_scene import check
from vibopt.scene.open_places import has_open_ends, open_places, settled
from vibopt.scene.scene import Scene


@dataclass(frozen=True, slots=True)
class Layouts:
    """What open places and ends allow.

    Attributes
    ----------
    built
        Places and ends by path, and the scene in which they are chosen.
    refused
        Those that are not answered, and the words why not.
    bare
        In place of layouts with joints that carry nothing: names of these and of what they join to one thing alone, and
        the scene without all of them.
    """

    built: list[tuple[Mapping[str, str], Scene]]
    refused: list[tuple[Mapping[str, str], str]]
    bare: list[tuple[tuple[str, ...], Scene]]


def layouts(scene: Scene) -> Layouts:
    """As `settled` gives them, without those seen before from their other end; joints that carry nothing are left out.

    Parameters
    ----------
    scene
        Read without mistakes.
    """
    seen: set[object] = set()
    found = Layouts([], [], [])
    sifts = has_open_ends(scene)
    for words, whole in settled(scene):
        names, one = _without_idle(whole) if sifts else ((), whole)
        if sifts:
            faults = _faults(one, Mistakes(scene.name), set()).found
            if faults and not names:  # of what is left out something else may be asked: then it has to carry
                found.refused.append((words, faults[0][1].removeprefix(f"{scene.name}: ")))
            if faults or (kind := (names, _network(one))) in seen:
                continue
            seen.add(kind)
        if names:
            found.bare.append((names, one))
        else:
            found.built.append((words, one))
    return found


def _without_idle(scene: Scene) -> tuple[tuple[str, ...], Scene]:
    """Names of joints that carry nothing and of what ends at them, and the scene without these."""
    gone: list[str] = []
    while idle := idle_joints(scene):
        more = {*idle, *(way for ways, _ in idle.values() for way in ways)}
        gone += sorted(more)

        def kept(tables: Mapping[str, Any], more: set[str] = more) -> dict[str, Any]:
            return {name: table for name, table in tables.items() if name not in more}

        scene = replace(
            scene,
            bodies=kept(scene.bodies),
            links=kept(scene.links),
            others={family: kept(tables) for family, tables in scene.others.items()},
            variables=tuple(one for one in scene.variables if one.path.split(".")[1] not in more),
            document={
                family: kept(table) if family in ("bodies", "links", *scene.others) else table
                for family, table in scene.document.items()
            },
        )
    return tuple(gone), scene


def _network(scene: Scene) -> frozenset[object]:
    """What a layout is, whichever of the parts in a row stands first.

    A joint without mass passes every force on, so that what stands on its two sides may change places, unless something
    looks at the joint itself, gears or the mass of a beam move with it, or a release begins with it in its place.
    """
    ends = {name: frozenset(two) for name, two in places.ends(scene).items()}
    looked = {on for one in scene.excitations.values() for on in one.everywhere}
    looked |= {place for one in scene.responses.values() for place, _ in one.places().values()}
    empty = {name for name, body in scene.bodies.items() if body.massless}
    geared = {
        one for name, body in scene.bodies.items() if body.geared_to is not None for one in (name, body.geared_to)
    }
    heavy = {end for _, name, table in places.devices(scene) if table.spreads_mass for end in table.joins(name)[name]}
    fixed = empty if any(isinstance(one, Release) for one in scene.excitations.values()) else looked | geared | heavy
    rows: set[object] = set()
    for joint in sorted(empty - fixed):
        here = {name for name, two in ends.items() if joint in two}
        sides = {
            other: frozenset(name for name in here if other in ends[name])
            for name in here
            for other in ends[name] - {joint}
        }
        if len(sides) == 2 and not sides.keys() & empty and not here & looked:
            rows.add((joint, frozenset(sides), frozenset(sides.values())))
            ends = {name: two for name, two in ends.items() if name not in here}
    return frozenset(rows | set(ends.items()))


def check_layouts(scene: Scene, mistakes: Mistakes, broken: set[str]) -> None:
    """Add what is wrong with a choice that is in no layout without mistakes; with all of them if there is none."""
    looked = [(words, _faults(one, Mistakes(mistakes.name, mistakes.locator), broken)) for words, one in settled(scene)]
    if all(tried.found for _, tried in looked):
        mistakes.found.extend(one for one in _shared([tried for _, tried in looked]) if one not in mistakes.found)
        return
    never: list[tuple[str, str, tuple[int, str]]] = []
    for path, names in open_places(scene).items():
        for name in names:
            such = [tried for words, tried in looked if words[path] == name]
            if all(tried.found for tried in such):
                never += [(path, name, fault) for fault in _shared(such)]
    themselves = [fault for path, _, fault in never if path in fault[1]]
    mistakes.found.extend(one for one in dict.fromkeys(themselves) if one not in mistakes.found)
    for path, name, (line, said) in never if not themselves else ():
        why = said.removeprefix(f"{mistakes.name} line {line}: ").removeprefix(f"{mistakes.name}: ")
        mistakes.add(tuple(path.split(".")), f'{path} as "{name}" is in no layout that can be answered: {why}')


def _shared(looked: list[Mistakes]) -> list[tuple[int, str]]:
    """What is wrong with all of some layouts; with the first where each has its own."""
    alike = [one for one in looked[0].found if all(one in tried.found for tried in looked)]
    return alike or looked[0].found


def _faults(scene: Scene, mistakes: Mistakes, broken: set[str]) -> Mistakes:
    check(scene, mistakes, broken)
    return mistakes
