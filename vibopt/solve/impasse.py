"""Why there is no design, in words: the physical bound, the limits that clash, what loosening helps."""

from __future__ import annotations

from vibopt.design.checked import shown_value
from vibopt.design.design import Conflict, Shown
from vibopt.program.program import Limit, Program
from vibopt.responses import HarmonicResponse, Response
from vibopt.scene.drives import names_for
from vibopt.scene.scene import Scene
from vibopt.solve.box import closed
from vibopt.solve.choose import modest
from vibopt.solve.conflict import loosenings, outward, smallest_conflict
from vibopt.solve.method import Found
from vibopt.solve.physical import Impossible, impossible
from vibopt.units import read_quantity, show, to_unit


def physical_words(scene: Scene, clash: Impossible) -> str:
    """Why two limits of the balance of forces clash, with the mass that would do."""
    force, motion = clash.limits
    limit = scene.limits[motion]
    assert isinstance(limit, HarmonicResponse)
    excitation = scene.excitations[names_for(scene, limit)[0]]
    load, heavy = ("moment", "inertia") if limit.dimension == "angle" else ("force", "mass")
    at = show(excitation.from_rotation(clash.speed), excitation.speed.unit, excitation.speed.dimension)
    return (
        f"At {at} the machine is shaken by {show(clash.force, '', load)}. {force} lets at most "
        f"{show(clash.transmitted, '', load)} through, and {motion} lets inertia carry at most "
        f"{show(clash.inertia, '', load)}: no stiffness and no damping can do it. "
        f"{'An inertia' if heavy == 'inertia' else 'A mass'} of at least {show(clash.needed, '', heavy)} instead of "
        f"{show(clash.mass, '', heavy)} could."
    )


def hopeless_words(scene: Scene, program: Program) -> str:
    """The limit that no spring and damper of the chosen link can meet, with its speed; "" where there is none."""
    from vibopt.solve.plane.whatever import hopeless

    one = hopeless(closed(program))
    if one is None:
        return ""
    response = scene.limits[one.limit.name]
    assert isinstance(response, HarmonicResponse)
    excitation = scene.excitations[names_for(scene, response)[0]]
    at = show(excitation.from_rotation(one.speed), excitation.speed.unit, excitation.speed.dimension)
    unit = getattr(response.at_most, "unit", "")
    value, bound = (shown_value(response, user_bound(one.limit, v), unit).shown for v in (one.value, one.limit.bound))
    return (
        f"At {at} {one.limit.name} is {value}, whatever the spring and the damper; at most {bound} is asked. Only a "
        "wider limit, another mass, or a range of speeds without this one can help."
    )


def conflict_of(scene: Scene, program: Program, found: Found) -> Conflict | None:
    """The limits that cannot hold together, and for each the smallest loosening that works."""
    finite = closed(program)

    def ask(part: Program) -> Found:
        if part.aim is None and impossible(part) is not None:
            return Found("infeasible", None, "", "physical bound")
        return modest(part).solve(part)

    bound = impossible(finite)
    if bound is not None:
        clash = tuple(limit for limit in finite.limits if limit.name in bound.limits)
    else:
        clash = smallest_conflict(finite, ask)
    rows = []
    for one in loosenings(finite, clash, ask):
        response = scene.limits.get(one.limit.name)
        if response is None:  # what a part is rated for is not loosened
            continue
        now, new = user_bound(one.limit, one.limit.bound), user_bound(one.limit, one.bound)
        side = "at_most" if new > now else "at_least"
        given = response.at_most if side == "at_most" else response.at_least
        unit = getattr(given, "unit", "")
        shown = outward_shown(response, new, unit, side)
        rows.append((one.limit.name, shown_value(response, now, unit), shown))
    names = tuple(dict.fromkeys(limit.name for limit in clash))
    return Conflict(names, tuple(rows), found.claim) if names else None


def user_bound(limit: Limit, value: float) -> float:
    """A bound of the form as the user counts it."""
    return 1.0 - value if limit.complement else value


def outward_shown(response: Response, value: float, unit: str, side: str, digits: int = 3) -> Shown:
    """A bound rounded in the user's unit so that it still works [SI]."""
    text_unit = unit or Shown.of(value, response.dimension, "", "").shown.split(" ", 1)[-1]
    try:
        rounded = outward(to_unit(value, text_unit, response.dimension), side, digits)
        back = read_quantity(f"{rounded:.12g} {text_unit}".strip(), response.dimension, amplitude=response.amplitude)
    except ValueError:
        return shown_value(response, outward(value, side, digits), unit)
    return shown_value(response, back.value, unit)
