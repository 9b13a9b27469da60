"""Which of the layouts that open ends allow can be built: a joint may drift in one of them and be held in another."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from vibopt.document.mistakes import Mistakes
from vibopt.scene import places
from vibopt.scene.check_scene import check
from vibopt.scene.open_places import has_open_ends, open_places, settled
from vibopt.scene.scene import Scene


def buildable(scene: Scene) -> Iterator[tuple[Mapping[str, str], Scene]]:
    """As `settled` gives them, without layouts that nobody could build, or that are one before seen from its other end.

    Parameters
    ----------
    scene
        Read without mistakes.
    """
    seen: set[object] = set()
    sifts = has_open_ends(scene)
    for words, one in settled(scene):
        if sifts:
            if _faults(one, Mistakes(scene.name), set()).found or (kind := _network(one)) in seen:
                continue
            seen.add(kind)
        yield words, one


def _network(scene: Scene) -> frozenset[object]:
    """What a layout is, whichever of the parts in a row stands first.

    A joint without mass passes every force on, so that what stands on its two sides may change places, unless something
    looks at the joint itself.
    """
    ends = {name: frozenset(two) for name, two in places.ends(scene).items()}
    looked = {on for one in scene.excitations.values() for on in one.everywhere}
    looked |= {place for one in scene.responses.values() for place, _ in one.places().values()}
    empty = {name for name, body in scene.bodies.items() if body.massless}
    rows: set[object] = set()
    for joint in sorted(empty - looked):
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
        _tell([tried for _, tried in looked], mistakes)
        return
    for path, names in open_places(scene).items():
        for name in names:
            such = [tried for words, tried in looked if words[path] == name]
            if all(tried.found for tried in such):
                _tell(such, mistakes)


def _tell(looked: list[Mistakes], mistakes: Mistakes) -> None:
    """What is wrong with all of some layouts; with the first where each has its own."""
    alike = [one for one in looked[0].found if all(one in tried.found for tried in looked)]
    mistakes.found.extend(one for one in alike or looked[0].found if one not in mistakes.found)


def _faults(scene: Scene, mistakes: Mistakes, broken: set[str]) -> Mistakes:
    check(scene, mistakes, broken)
    return mistakes
