"""Mistakes that only show when the tables of a scene are seen together."""

from __future__ import annotations

from collections.abc import Iterable

from vibopt.errors import way_out
from vibopt.mechanics.builder import GROUND
from vibopt.responses import HarmonicResponse, Response
from vibopt.responses.insertion_loss import InsertionLoss
from vibopt.responses.natural_frequency import NaturalFrequency
from vibopt.responses.static_deflection import StaticDeflection
from vibopt.scene.check_speeds import check_speeds
from vibopt.scene.mistakes import Mistakes, Path, given_at
from vibopt.scene.scene import Scene


def check(scene: Scene, mistakes: Mistakes, broken: set[str]) -> None:
    """Add every mistake of the whole to `mistakes`; `broken` tables have been reported already."""
    _names(scene, mistakes)
    _links(scene, mistakes)
    _excitations(scene, mistakes)
    for path, response in _responses(scene):
        _places(scene, path, response, mistakes)
        _bounds(path, response, mistakes)
        _moved(scene, path, response, mistakes, broken)
    _question(scene, mistakes, broken)


def _responses(scene: Scene) -> Iterable[tuple[Path, Response]]:
    for family in ("limits", "measures"):
        for name, response in getattr(scene, family).items():
            yield (family, name), response
    if scene.goal is not None:
        yield ("goal",), scene.goal.response


def _raw(scene: Scene, family: str) -> list[str]:
    """Names in the document, those of broken tables included."""
    tables = scene.document.get(family, {})
    return list(tables) if isinstance(tables, dict) else []


def _names(scene: Scene, mistakes: Mistakes) -> None:
    seen: dict[str, str] = {}
    for family in ("bodies", "bases", "links"):
        for name in _raw(scene, family):
            if name == GROUND:
                mistakes.add(
                    (family, name),
                    f'{family}.{name} takes the name "ground", which is the fixed ground. Choose another.',
                )
            elif name in seen:
                mistakes.add(
                    (family, name),
                    f"{family}.{name} takes a name that {seen[name]}.{name} has already. Choose another.",
                )
            else:
                seen[name] = family
    if not _raw(scene, "bodies"):
        mistakes.add((), 'there is no body. Add [bodies.NAME] with mass = "300 kg".')


def points_of(scene: Scene) -> list[str]:
    """Everything a link may end at."""
    return [*_raw(scene, "bodies"), *_raw(scene, "bases"), GROUND]


def _links(scene: Scene, mistakes: Mistakes) -> None:
    points, bodies = points_of(scene), _raw(scene, "bodies")
    for name, link in scene.links.items():
        path = ("links", name)
        for end in link.between:
            if end not in points:
                mistakes.value(
                    (*path, "between"),
                    list(link.between),
                    f'names "{end}", which is no body, base or ground.{way_out(end, points)}',
                )
        if all(end in points and end not in bodies for end in link.between):
            mistakes.value(
                (*path, "between"),
                list(link.between),
                "joins two supports, so nothing can move. Put a body at one end.",
            )
        if link.relative_to is not None and link.relative_to not in bodies:
            mistakes.unknown_name((*path, "relative_to"), link.relative_to, "body", bodies)
        if link.damping_ratio is not None and link.relative_to is None and len(bodies) > 1:
            mistakes.add(
                path,
                f"links.{name} gives a damping ratio, but several bodies move: relative to which mass? Add "
                f'relative_to = "{bodies[0]}".',
            )


def _excitations(scene: Scene, mistakes: Mistakes) -> None:
    for name, excitation in scene.excitations.items():
        path = ("excitations", name)
        known = _raw(scene, excitation.family)
        what = "body" if excitation.family == "bodies" else "base"
        if excitation.on not in known:
            mistakes.unknown_name((*path, "on"), excitation.on, what, known)
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


def _places(scene: Scene, path: Path, response: Response, mistakes: Mistakes) -> None:
    known = {
        "body": _raw(scene, "bodies"),
        "link": _raw(scene, "links"),
        "joining link": _raw(scene, "links"),
        "body or link": [*_raw(scene, "bodies"), *_raw(scene, "links")],
        "point": points_of(scene),
    }
    words = {"point": "body, base or ground", "joining link": "link"}
    for key, (name, family) in response.places().items():
        if name not in known[family]:
            mistakes.unknown_name((*path, key), name, words.get(family, family), known[family])
    if (
        isinstance(response, InsertionLoss)
        and response.across in scene.links
        and any(end not in scene.bodies for end in scene.links[response.across].between)
    ):
        mistakes.value(
            (*path, "across"),
            response.across,
            "does not join two bodies. Insertion loss compares the motion of the body behind the link: model "
            "the floor as a body.",
        )
    _parameter(scene, path, response, mistakes)


def _parameter(scene: Scene, path: Path, response: Response, mistakes: Mistakes) -> None:
    """A property of a link that this link does not have."""
    key = response.response
    name = getattr(response, "of", None)
    if key in ("stiffness", "damping", "loss_factor", "damping_ratio", "count") and name in scene.links:
        link = scene.links[name]
        if (
            key == "damping_ratio"
            and link.damping is not None
            and link.stiffness is not None
            and len(scene.bodies) == 1
        ):
            return
        if getattr(link, key) is None and key != "count":
            mistakes.add(
                path,
                f"{'.'.join(str(one) for one in path)} asks for the {key} of {name}, but links.{name} has no {key}. "
                "Add it, or ask for something else.",
            )
    lossy = [one for one, link in scene.links.items() if link.loss_factor is not None]
    if key == "damping_ratio" and name is None and lossy:
        mistakes.add(
            path,
            f"{'.'.join(str(one) for one in path)} asks for the damping ratio of free vibration, but "
            f"links.{lossy[0]} has a loss_factor, which speaks of steady harmonic motion only. Give that link "
            "damping or damping_ratio instead.",
        )
    mode = getattr(response, "mode", 1)
    if mode > max(len(_raw(scene, "bodies")), 1):
        mistakes.value((*path, "mode"), mode, f"is more than the number of modes, {len(_raw(scene, 'bodies'))}.")


def _bounds(path: Path, response: Response, mistakes: Mistakes) -> None:
    given = [key for key in ("at_most", "at_least", "outside") if getattr(response, key, None) is not None]
    name = ".".join(str(one) for one in path)
    if path[0] == "limits" and not given:
        extra = " (or outside)" if isinstance(response, NaturalFrequency) else ""
        mistakes.add(path, f"{name} has no bound. Add at_most or at_least{extra}, or move it to [measures.{path[1]}].")
    if path[0] == "measures" and given:
        mistakes.add(
            (*path, given[0]),
            f"{name} has a bound ({given[0]}), but a measure has none. Move it to [limits.{path[1]}].",
        )
    low, high = response.at_least, response.at_most
    if low is not None and high is not None and low.value > high.value:
        mistakes.add(path, f"{name} has an at_least above its at_most. Exchange the two.")


def _moved(scene: Scene, path: Path, response: Response, mistakes: Mistakes, broken: set[str]) -> None:
    name = ".".join(str(one) for one in path)
    if isinstance(response, StaticDeflection):
        place = response.of
        if place in scene.bodies and not _held(scene, place):
            mistakes.add(
                path,
                f"{name} asks for the static deflection of {place}, but no spring holds it. Add a link with a "
                f"stiffness from {place} towards the ground.",
            )
        if place in scene.links and all(
            not _held(scene, end) for end in scene.links[place].between if end in scene.bodies
        ):
            mistakes.add(
                path,
                f"{name} asks for the static deflection of {place}, but no spring holds what rests on it. Add a link "
                "with a stiffness towards the ground.",
            )
    if isinstance(response, HarmonicResponse):
        check_speeds(scene, path, response, mistakes, broken)


def _held(scene: Scene, body: str) -> bool:
    """Whether a chain of springs leads from the body to the ground or to a base."""
    seen, todo = {body}, [body]
    while todo:
        here = todo.pop()
        for link in scene.links.values():
            if here in link.between and link.stiffness is not None:
                there = link.between[0] if link.between[1] == here else link.between[1]
                if there not in scene.bodies:
                    return True
                if there not in seen:
                    seen.add(there)
                    todo.append(there)
    return False


def _question(scene: Scene, mistakes: Mistakes, broken: set[str]) -> None:
    """What is asked must fit what may be chosen."""
    if broken:
        return
    if scene.find_all is not None:
        _find_all(scene, mistakes)
    elif scene.variables and scene.goal is None:
        mistakes.add(
            (),
            f"{scene.variables[0].path} is to be chosen, but there is no [goal]. Add [goal] with maximise = "
            '"stiffness" and of = "mount", for example.',
        )
    elif scene.goal is not None and not scene.variables:
        mistakes.add(
            ("goal",),
            'goal asks for the best design, but no value may be chosen. Write one as { from = "...", to = "..." }, '
            "or move the response to [measures.NAME].",
        )
    elif scene.is_analysis and not scene.limits and not scene.measures:
        mistakes.add((), "nothing is asked. Add a [limits.NAME] or a [measures.NAME].")


def _find_all(scene: Scene, mistakes: Mistakes) -> None:
    known = [f"{name}.speed" for name in scene.excitations]
    if scene.find_all not in known:
        mistakes.unknown_name(("goal", "find_all"), str(scene.find_all), "speed", known)
        return
    if scene.variables:
        mistakes.add(
            ("goal", "find_all"),
            f"goal.find_all looks for speeds of a given machine, but {scene.variables[0].path} is to be chosen. "
            "Write it as a fact.",
        )
    if not scene.limits:
        mistakes.add(
            ("goal", "find_all"), "goal.find_all needs at least one [limits.NAME] that tells good speeds from bad ones."
        )
    name = str(scene.find_all).removesuffix(".speed")
    excitation = scene.excitations[name]
    if excitation.speed.highest == float("inf"):
        mistakes.add(
            ("excitations", name, "speed"), f'excitations.{name}.speed has no upper end. Add to = "20000 rpm".'
        )
    elif excitation.speed.is_one_speed:
        mistakes.add(
            ("excitations", name, "speed"),
            f'excitations.{name}.speed is one speed, but find_all looks for speeds in a range. Write {{ from = "0 '
            f'rpm", to = "20000 rpm" }}.',
        )
