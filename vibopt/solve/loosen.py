"""What loosening a limit would do, found by making it the goal: of designs over tolerances and of bought parts."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import replace

from vibopt.answer.clashes import Clashes, Conflict
from vibopt.answer.entry import Entry
from vibopt.errors import InputError
from vibopt.program.pose import RATED
from vibopt.program.program import Limit, Program
from vibopt.report.machine_words import THOROUGH
from vibopt.scene.places import rubbing
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Design, Scene
from vibopt.solve.advice import confirmed_bound
from vibopt.solve.conflict import asked, conflicts
from vibopt.solve.method import Found
from vibopt.values.soft import softness
from vibopt.verify.checked import shown_value
from vibopt.work import late, metered

_BOUNDS = ("at_most", "at_least", "outside")
RUBBED = 60_000.0
"""Work beside an answer on a motion with dry friction, of which each takes much [nominal ms]."""
Row = tuple[str, Entry, Entry]


def clashes_of(program: Program, *, most: float) -> Clashes[str]:
    """Names of the limits of every set that cannot hold together on the machines that a program asks about.

    After `most` of work [nominal ms] no further limit is left out.
    """
    with metered() as meter:

        def in_time(part: Program) -> Found:
            if meter.done > most or late("the search for the limits that clash"):
                return Found("unproven", None, "", "")
            return asked(part)

        clashes = conflicts(program, in_time, lambda: meter.done <= 0.2 * most)
    spoken: dict[tuple[str, str], str] = {(limit.name, limit.user_side): spoken_name(limit) for limit in program.limits}
    sets = tuple(dict.fromkeys(tuple(dict.fromkeys(spoken[key] for key in one)) for one in clashes.sets))
    return Clashes(
        sets, clashes.complete, clashes.answers, tuple(dict.fromkeys(spoken[key] for key in clashes.doubtful))
    )


def spoken_name(limit: Limit) -> str:
    """Of what a part is rated for also which end; of a limit of the file its name."""
    return f"{limit.name} ({limit.side.replace('_', ' ')})" if limit.name.endswith(RATED) else limit.name


def conflict_over_tolerances(
    scene: Scene, clashes: Clashes[str], found: Found, answer: Callable[[Scene], Design], *, most: float
) -> Conflict | None:
    """Limits that cannot hold together, and the bound of each with which all would hold over the tolerances.

    answer
        Solves a scene over its tolerances.
    most
        Work [nominal ms] after which the limits that are left are named as not loosened.
    """
    rows: list[Row] = []
    left: list[str] = []
    names, *others = clashes.sets or ((),)
    with metered() as meter:
        for name in (one for one in names if one in scene.limits and all(one in other for other in others)):
            if meter.done > most or late("the search for loosenings"):
                left.append(name)
            elif (row := _loosened(scene, name, answer)) is not None:
                rows.append(row)
    soft = softness(scene.limits)
    known = clashes.complete, soft, clashes.doubtful
    said = Conflict(names, tuple(rows), found.claim, tuple(left), tuple(others), *known)
    return said if names else None


def _loosened(scene: Scene, name: str, answer: Callable[[Scene], Design]) -> Row | None:
    """The limit as the goal: the best that it can be while all others hold, its worst machine counted."""
    response = scene.limits[name]
    sides = [side for side in _BOUNDS if getattr(response, side, None) is not None]
    if len(sides) != 1 or sides[0] == "outside":
        return None
    try:
        best = answer(as_goal(scene, name, sides[0]))
    except InputError:
        return None
    if best.goal is None or best.status not in ("optimal", "feasible"):
        return None
    given = getattr(response, sides[0])
    enough = confirmed_bound(scene, name, sides[0], best.goal[1].value, answer, known=best.status == "optimal")
    return None if enough is None else (name, shown_value(response, given.value, given.unit), enough)


def as_goal(scene: Scene, name: str, side: str) -> Scene:
    """The scene whose goal is what a limit bounds at one side, "at_most" or "at_least", without that limit.

    Raises
    ------
    InputError
        No goal can be made of it.
    """
    document = copy.deepcopy(dict(scene.document))
    words = {key: one for key, one in document["limits"].pop(name).items() if key not in (*_BOUNDS, "response")}
    document["goal"] = {"minimise" if side == "at_most" else "maximise": scene.limits[name].response, **words}
    return from_dict(document, name=scene.name)


def beside(scene: Scene, most: float) -> float:
    """Work that may be done beside an answer where so much is wished [nominal ms]: of what rubs it has an end."""
    return min(most, RUBBED) if rubbing(scene) else most


def left_out(scene: Scene) -> str:
    """Why something beside an answer was not looked for, and who does, behind a colon."""
    if rubbing(scene):
        return f"each is an answer of its own, and where something rubs {THOROUGH} works out only the first few."
    return f"each is an answer of its own. {THOROUGH} does."


def with_conflict(design: Design, conflict: Conflict | None) -> Design:
    """The design with its conflict, and a sentence where a loosening was not looked for."""
    if conflict is None or not conflict.left:
        return replace(design, conflict=conflict)
    words = f"No loosening of {', '.join(conflict.left)} was looked for: {left_out(design.scene)}"
    return replace(design, conflict=conflict if conflict.limits else None, notes=(*design.notes, words))
