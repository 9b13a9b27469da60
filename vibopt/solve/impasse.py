"""Why there is no design, in words: the physical bound, the limits that clash, what loosening helps."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from vibopt.answer.clashes import Conflict
from vibopt.answer.entry import Entry
from vibopt.program.program import Limit, Program
from vibopt.responses import HarmonicResponse
from vibopt.scene.drives import names_for
from vibopt.scene.scene import Scene
from vibopt.solve.advice import Answer, confirmed_bound
from vibopt.solve.conflict import Key, Loosening, asked, conflicts, loosenings
from vibopt.solve.method import Found
from vibopt.solve.physical import Impossible, impossible
from vibopt.solve.ranges import closed
from vibopt.units import show
from vibopt.values.soft import softness
from vibopt.verify.checked import shown_value
from vibopt.work import late, metered

_OF_SETS = 0.2
"""Part of the work for a conflict that the sets behind the first may take."""


def physical_words(scene: Scene, clash: Impossible) -> str:
    """Why two limits of the balance of forces clash, with the mass that would do."""
    force, motion = clash.limits
    limit = scene.limits[motion]
    assert isinstance(limit, HarmonicResponse)
    excitation = scene.excitations[names_for(scene, limit)[0]]
    load, heavy = ("moment", "inertia") if limit.dimension == "angle" else ("force", "mass")
    at = show(excitation.from_rotation(clash.speed), excitation.speed.unit, excitation.speed.dimension)
    article = "a" if heavy == "mass" else "an"
    return (
        f"At {at} the machine is shaken by {show(clash.force, '', load)}. {force} lets at most "
        f"{show(clash.transmitted, '', load)} through, and {motion} lets inertia carry at most "
        f"{show(clash.inertia, '', load)}: no stiffness and no damping can do it with {article} "
        f"{heavy} below {show(_down(clash.needed), '', heavy)}; it is {show(clash.mass, '', heavy)}."
    )


def _down(value: float) -> float:
    """Rounded down to four digits, so that what is said of everything below it is true."""
    step = 10.0 ** (math.floor(math.log10(value)) - 3)
    return math.floor(value / step * (1.0 + 1e-12)) * step


def hopeless_words(scene: Scene, program: Program) -> str:
    """The limit that no spring and damper of the chosen link can meet, with its speed; "" where there is none."""
    from vibopt.solve.plane.invariant_points import hopeless

    invariant = hopeless(closed(program))
    if invariant is None:
        return ""
    response = scene.limits[invariant.limit.name]
    assert isinstance(response, HarmonicResponse)
    excitation = scene.excitations[names_for(scene, response)[0]]
    at = show(excitation.from_rotation(invariant.speed), excitation.speed.unit, excitation.speed.dimension)
    unit = getattr(response.at_most, "unit", "")
    value, bound = (
        shown_value(response, user_bound(invariant.limit, v), unit).shown
        for v in (invariant.value, invariant.limit.bound)
    )
    return (
        f"At {at} {invariant.limit.name} is {value}, whatever the spring and the damper; at most {bound} is asked. "
        "Only a "
        "wider limit, another mass, or a range of speeds without this one can help."
    )


def conflict_of(
    scene: Scene, program: Program, found: Found, answer: Answer, *, most: float, names_only: bool = False
) -> Conflict | None:
    """The limits that cannot hold together, and for each the smallest loosening that works for the whole job.

    Parameters
    ----------
    scene, program, found
        The job, its question, and the answer that there is no design.
    answer
        Solves a scene.
    most
        Work [nominal ms] after which the limits that are left are named as not loosened.
    names_only
        Looks for no loosening.
    """
    finite = closed(program)
    if (bound := impossible(finite)) is not None:  # what the balance of forces speaks of is left out last
        finite = replace(finite, limits=tuple(sorted(finite.limits, key=lambda one: one.name in bound.limits)))
    with metered() as meter:
        clashes = conflicts(
            finite, _ask, lambda: meter.done <= most * _OF_SETS and not late("the search for conflicts")
        )
    order = list(dict.fromkeys(limit.name for limit in program.limits))
    sets = tuple(dict.fromkeys(tuple(sorted({name for name, _ in one}, key=order.index)) for one in clashes.sets))
    if not sets:
        return None
    rows: list[tuple[str, Entry, Entry]] = []
    with metered() as meter:
        guesses, left = ({}, []) if names_only else _guesses(finite, clashes.sets, lambda: meter.done <= most)
        for (name, side), one in guesses.items():
            response = scene.limits.get(name)
            if response is None:  # what a part is rated for is not loosened
                continue
            if meter.done > most or late("the search for loosenings"):
                left.append(name)
                continue
            guess = user_bound(one.limit, one.bound)
            enough = confirmed_bound(scene, name, side, guess, answer, known=one.known, closely=True, near=one.near)
            if enough is not None:
                given = getattr(response, side)
                rows.append((name, shown_value(response, given.value, given.unit), enough))
    others = sets[1:]
    doubtful = tuple(dict.fromkeys(name for name, _ in clashes.doubtful))
    soft, open_ = softness(scene.limits), tuple(dict.fromkeys(left))
    return Conflict(sets[0], tuple(rows), found.claim, open_, others, clashes.complete, soft, doubtful)


def _ask(part: Program) -> Found:
    if part.aim is None and impossible(part) is not None:
        return Found("infeasible", None, "", "physical bound")
    return asked(part)


def _guesses(
    program: Program, sets: tuple[tuple[Key, ...], ...], may: Callable[[], bool]
) -> tuple[dict[tuple[str, str], Loosening], list[str]]:
    """By name and side the loosening that should be enough, of the limits that are in every set: no other helps.

    And the names of those that were not asked for.
    """
    shared = [key for key in sets[0] if all(key in other for other in sets[1:])]
    clash = tuple(limit for limit in program.limits if (limit.name, limit.user_side) in shared)
    loosened, left = loosenings(program, clash, _ask, may)
    found = {(one.limit.name, one.limit.user_side): one for one in loosened}
    return found, [limit.name for limit in left]


def user_bound(limit: Limit, value: float) -> float:
    """A bound of the form as the user counts it."""
    return 1.0 - value if limit.complement else value
