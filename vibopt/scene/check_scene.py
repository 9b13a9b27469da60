"""Mistakes that only show when the tables of a scene are seen together."""

from __future__ import annotations

from collections.abc import Mapping

from vibopt.document.mistakes import Mistakes, Path, dotted
from vibopt.errors import way_out
from vibopt.responses import HarmonicResponse, Response, TransientResponse
from vibopt.scene import places
from vibopt.scene.check_bearings import check_bearings
from vibopt.scene.check_devices import check_absorbers, check_links, check_names
from vibopt.scene.check_excitations import check_excitations
from vibopt.scene.check_places import check_places
from vibopt.scene.check_probability import check_probabilities
from vibopt.scene.check_random import check_lossy, check_random
from vibopt.scene.check_space import check_space
from vibopt.scene.check_speeds import check_speeds
from vibopt.scene.check_spin import THRESHOLD, check_spin, check_stable, spins_in, turning
from vibopt.scene.check_whole import check_price, check_tolerances
from vibopt.scene.drives import loose_in, names_for
from vibopt.scene.open_places import asked_positions, open_places
from vibopt.scene.scene import Scene, Variable
from vibopt.scene.uncertain import uncertain


def check(scene: Scene, mistakes: Mistakes, broken: set[str]) -> None:
    """Add every mistake of the whole to `mistakes`; `broken` tables have been reported already."""
    if not check_names(scene, mistakes):
        return
    check_links(scene, mistakes)
    check_absorbers(scene, mistakes)
    check_tolerances(scene, mistakes)
    check_space(scene, mistakes)
    check_excitations(scene, mistakes)
    if places.rubbing(scene):
        from vibopt.scene.check_friction import check_friction

        check_friction(scene, mistakes)
    check_bearings(scene, mistakes)
    if scene.rotors:
        from vibopt.scene.check_rotors import check_rotors

        check_rotors(scene, mistakes)
    if any(body.geared_to is not None for body in scene.bodies.values()):
        from vibopt.scene.check_gears import check_gears

        check_gears(scene, mistakes)
    if places.empty(scene) or any(link.spreads_mass for link in scene.links.values()):
        from vibopt.scene.check_joints import check_beams, check_joints

        check_joints(scene, mistakes)
        check_beams(scene, mistakes)
    check_spin(scene, mistakes)
    asked = [(tuple(where.split(".", 1)), response) for where, response in scene.responses.items()]
    for path, response in asked:
        check_response(scene, path, response, mistakes, broken)
    if not broken:
        check_probabilities(scene, asked, mistakes)
    if _is_joined(scene, broken):
        _rated(scene, mistakes)
    _question(scene, mistakes, broken)
    if not mistakes.found and not broken:
        check_stable(scene, mistakes)
    if not mistakes.found and not broken and any(isinstance(one, TransientResponse) for _, one in asked):
        from vibopt.scene.check_whole import check_turns

        check_turns(scene, mistakes)


def check_response(scene: Scene, path: Path, response: Response, mistakes: Mistakes, broken: set[str]) -> None:
    """Add every mistake of one limit, measure or goal, of a machine that is checked beside it."""
    if response.of_rotors and not scene.rotors and not places.raw(scene, "rotors"):
        mistakes.add(
            path,
            f"{dotted(path)} asks for the {response.response} of a rotor, and there is none. Ask for something else, "
            "or write [rotors.NAME].",
        )
        return
    asked = response.reading or response
    one = scene, path, asked, mistakes
    if _is_odd(scene) or asked.whirls or asked.spins or asked.response == THRESHOLD:
        from vibopt.scene.check_friction import rubs_in
        from vibopt.scene.check_gears import gear_fault
        from vibopt.scene.check_rotors import whirl_fault

        if rubs_in(*one) or spins_in(*one) or whirl_fault(*one) or gear_fault(*one):
            return
    if response.reading is not None and (loose := loose_in(scene, response.reading)):
        mistakes.add(
            path,
            f"{dotted(path)} asks for the {response.response}, and excitations.{loose} has unbalances at any angles, "
            "which no one rotor has at all speeds. Give their angles, or ask for the displacement.",
        )
        return
    if response.signed and not _free(scene, path, response, mistakes):
        return
    if response.free_vibration:
        check_lossy(scene, path, response.free_vibration, mistakes)
    check_places(scene, path, response, mistakes, broken)
    if response.priced:
        check_price(scene, path, response, mistakes)
    _bounds(scene, path, response, mistakes, broken)
    _moved(scene, path, asked, mistakes, broken)


@places.once
def _is_odd(scene: Scene) -> bool:
    """Whether something rubs, spins or is geared, which not everything may be asked of."""
    geared = any(body.geared_to is not None for body in scene.bodies.values())
    return bool(geared or scene.rotors or places.rubbing(scene) or turning(scene))


def _free(scene: Scene, path: Path, response: Response, mistakes: Mistakes) -> bool:
    from vibopt.scene.check_whole import check_free

    return check_free(scene, path, response, mistakes)


def _bounds(scene: Scene, path: Path, response: Response, mistakes: Mistakes, broken: set[str]) -> None:
    table = vars(response)
    given = [key for key in ("at_most", "at_least", "outside") if table.get(key) is not None]
    name = dotted(path)
    if path[0] == "limits" and not given:
        extra = response.other_bound
        mistakes.add(path, f"{name} has no bound. Add at_most or at_least{extra}, or move it to [measures.{path[1]}].")
    if path[0] == "measures" and given:
        mistakes.add(
            (*path, given[0]),
            f"{name} has a bound ({given[0]}), but a measure has none. Move it to [limits.{path[1]}].",
        )
    if path[0] != "limits" and response.soft is not None:
        way = "soft weighs the loosening of a limit. Remove soft"
        mistakes.add((*path, "soft"), f"{name} has soft, but no bound to loosen: {way}.")
    if path[0] != "measures" and response.worst is not None:
        why = "its bound says" if path[0] == "limits" else "minimise and maximise say"
        mistakes.add((*path, "worst"), f"{name} has worst, but {why} which value is the worst. Remove worst.")
    shaker = response.orders_of
    if shaker and path[0] == "limits" and not broken & {"excitations", f"excitations.{shaker}"}:
        known = [name for name, excitation in scene.excitations.items() if excitation.sort == "steady"]
        said = f'"{shaker}", which is no excitation with a speed.{way_out(shaker, known)}'
        mistakes.add((*path, "outside"), f"{name}.outside speaks of orders of {said}")
    low, high = response.at_least, response.at_most
    if low is not None and high is not None and low.value > high.value:
        mistakes.add(path, f"{name} has an at_least above its at_most. Exchange the two.")


def _moved(scene: Scene, path: Path, response: Response, mistakes: Mistakes, broken: set[str]) -> None:
    if response.sags and _is_joined(scene, broken):
        _sags(scene, path, dotted(path), next(place for place, _ in response.places().values()), mistakes)
    fits = check_random(scene, path, response, mistakes, broken)
    if fits and isinstance(response, HarmonicResponse):
        check_speeds(scene, path, response, mistakes, broken)


def _is_joined(scene: Scene, broken: set[str]) -> bool:
    """Whether all that joins could be read and ends at something."""
    unread = any(one.startswith(("links", "mounts", "absorbers", "structures", "rotors")) for one in broken)
    return not unread and set().union(*places.ends(scene).values()) <= set(places.points(scene))


def _sags(scene: Scene, path: Path, name: str, place: str, mistakes: Mistakes) -> None:
    """Whether springs carry all weights, so that there is a static deflection."""
    place = scene.points[place].on if place in scene.points else place
    for one, absorber in scene.absorbers.items():
        if absorber.length is not None:
            why = "is a pendulum, which swings across its weight"
        elif not absorber.has_spring and one not in _held(scene):
            why = "has no spring that carries its weight"
        else:
            continue
        mistakes.add(
            path,
            f"{name} asks for a static deflection, but absorbers.{one} {why}. Leave the static deflection out, or "
            f"give {one} a stiffness.",
        )
        return
    if loose := _loose(scene, place):
        mistakes.add(path, f"{name} asks for the static deflection of {place}, but {loose}.")


def _rated(scene: Scene, mistakes: Mistakes) -> None:
    """Whether springs carry all weights, so that bought parts have a static load."""
    for path in places.bought(scene):
        if loose := _loose(scene, path.partition(".")[2]):
            way = "or write stiffness and damping in place of the part"
            mistakes.add((*path.split("."), "part"), f"{path}.part has a rated load, but {loose}, {way}.")


def _loose(scene: Scene, place: str) -> str:
    """What no spring holds, a place, what rests on a link or else something, and how it would be; empty if all is."""
    loose, add = [one for one in places.moving(scene) if one not in _held(scene)], "Add a link with a stiffness"
    if {*places.ends(scene).get(place, ())} & {*loose}:
        return f"no spring holds what rests on it. {add} towards the ground"
    if loose:
        free = place if place in loose else loose[0]
        return f"no spring holds {'it' if free == place else free}. {add} from {free} towards the ground"
    free = next((name for name, table in scene.structures.items() if table.loose), "")
    return f"nothing holds structures.{free}, and how its weight rests is not known. Let it have supports" * bool(free)


@places.once
def _held(scene: Scene) -> set[str]:
    """What a chain of springs leads from to the ground, to a base or to a structure, with these."""
    held = {*places.points(scene)} - {*places.moving(scene)} | places.carried(scene)
    joined = [{*places.ends(scene)[name]} for name in places.springs(scene)]
    joined += [{name, point.on} for name, point in scene.points.items()]
    while more := set[str]().union(*(two for two in joined if two & held)) - held:
        held |= more
    return held


def _first_choice(scene: Scene) -> tuple[str, str]:
    """The first value or part to be chosen, and a goal for it."""
    path = scene.variables[0].path
    bought = next((part for part in places.bound_parts(scene) if path in part.paths), None)
    if bought is not None and any(one.endswith(".price") for one in bought.paths):
        return bought.path, 'minimise = "price"'
    family, name = path.split(".")[:2]
    held = name if family in ("links", "mounts") else next(iter({**scene.links, **scene.mounts}), "mount")
    return bought.path if bought is not None else path, f'maximise = "stiffness" and of = "{held}"'


def _question(scene: Scene, mistakes: Mistakes, broken: set[str]) -> None:
    """What is asked must fit what may be chosen."""
    if broken:
        return
    if scene.asked is not None and scene.goal is None:
        path = next(iter({**open_places(scene.asked), **asked_positions(scene)}))
        mistakes.add(
            tuple(path.split(".")),
            f"{path} is to be chosen, but there is no [goal] that says which place is best. Add [goal] with minimise = "
            '"displacement" and of = "BODY", for example.',
        )
    elif scene.find_all is not None:
        _find_all(scene, mistakes)
    elif scene.variables and scene.goal is None:
        path, example = _first_choice(scene)
        mistakes.add((), f"{path} is to be chosen, but there is no [goal]. Add [goal] with {example}, for example.")
    elif scene.goal is not None and not scene.variables and scene.asked is None:
        mistakes.add(
            ("goal",),
            'goal asks for the best design, but no value may be chosen. Write one as { from = "...", to = "..." }, '
            "or move the response to [measures.NAME].",
        )
    elif scene.is_analysis and scene.goal is None and not scene.limits and not scene.measures:
        mistakes.add((), "nothing is asked. Add a [limits.NAME] or a [measures.NAME].")
    if scene.goal is not None and scene.goal.response.of_limits:
        from vibopt.scene.check_room import check_room

        check_room(scene, scene.goal, mistakes)


def _find_all(scene: Scene, mistakes: Mistakes) -> None:
    speeds = [f"{name}.speed" for name, excitation in scene.excitations.items() if excitation.sort == "steady"]
    asked = next((variable for variable in scene.variables if variable.path == scene.find_all), None)
    if scene.find_all not in speeds and asked is None:
        values = [variable.path for variable in scene.variables]
        what = "speed and no value to be chosen" if values else "speed"
        mistakes.unknown_name(("goal", "find_all"), str(scene.find_all), what, [*values, *speeds])
        return
    here, looks = ("goal", "find_all"), "speeds" if asked is None else f"values of {asked.path}"
    others = [variable.path for variable in scene.variables if variable is not asked]
    if others:
        mistakes.add(
            here,
            f"goal.find_all looks for {looks} of a given machine, but {others[0]} is to be chosen. Write it as a fact.",
        )
    doubts = uncertain(scene)
    if doubts:
        way = "ask with limits over a range of speeds" if asked is None else "ask for the best within it"
        mistakes.add(
            here,
            f"goal.find_all looks for {looks} of a given machine, but {doubts[0].path} has a tolerance. Remove it, or "
            f"{way}.",
        )
    if not scene.limits:
        good = "speeds" if asked is None else "values"
        mistakes.add(here, f"goal.find_all needs at least one [limits.NAME] that tells good {good} from bad ones.")
    if asked is None:
        _range_of_speeds(scene, str(scene.find_all).removesuffix(".speed"), mistakes)
    else:
        _range_of_values(asked, mistakes)


def _range_of_speeds(scene: Scene, name: str, mistakes: Mistakes) -> None:
    speed = scene.excitations[name].speed
    for key, limit in scene.limits.items():
        outside = places.raw(scene, "limits")[key].get("outside")
        orders = isinstance(outside, Mapping) and outside.get("of") == name
        runs = isinstance(limit, TransientResponse) and name in names_for(scene, limit) and scene.excitations[name].ramp
        if orders or runs:
            what = "orders" if orders else "run-ups"
            mistakes.add(
                ("goal", "find_all"),
                f"goal.find_all looks for speeds of {name}, but limits.{key} looks at {what} of each by itself. Leave "
                "the goal out, and look at one speed after the other: vibopt sweep FILE --vary "
                f'excitations.{name}.speed="1000..2000 rpm".',
            )
    if speed.highest == float("inf"):
        mistakes.add(
            ("excitations", name, "speed"), f'excitations.{name}.speed has no upper end. Add to = "20000 rpm".'
        )
    elif speed.is_one_speed:
        mistakes.add(
            ("excitations", name, "speed"),
            f'excitations.{name}.speed is one speed, but find_all looks for speeds in a range. Write {{ from = "0 '
            f'rpm", to = "20000 rpm" }}.',
        )


def _range_of_values(asked: Variable, mistakes: Mistakes) -> None:
    where = tuple(asked.path.split("."))
    if asked.values is not None:
        mistakes.add(
            where, f"{asked.path} is a list, but find_all looks for intervals. `vibopt sweep` answers each value of it."
        )
    elif asked.high == float("inf") or asked.choice.open_low:
        end, key = ("upper", "to") if asked.high == float("inf") else ("lower", "from")
        mistakes.add(where, f"{asked.path} has no {end} end. Add {key}: find_all looks through a range.")
