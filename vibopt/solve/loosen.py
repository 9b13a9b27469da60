"""What loosening a limit would do, found by making it the goal: of designs over tolerances and of bought parts."""

from __future__ import annotations

import copy
import time
from collections.abc import Callable
from dataclasses import replace

from vibopt.design.checked import shown_value
from vibopt.design.design import Conflict, Design, Shown
from vibopt.errors import InputError
from vibopt.program.program import Program
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Scene
from vibopt.solve.choose import choose
from vibopt.solve.conflict import smallest_conflict
from vibopt.solve.global_search import BranchAndBound
from vibopt.solve.impasse import outward_shown
from vibopt.solve.method import Found

_GAP, _SECONDS, _ALL_SECONDS = 1e-4, 3.0, 10.0
_BOUNDS = ("at_most", "at_least", "outside")
Row = tuple[str, Shown, Shown]


def clash_of(program: Program) -> tuple[str, ...]:
    """Names of limits that cannot hold together on the machines that a program asks about."""
    return tuple(dict.fromkeys(one.name for one in smallest_conflict(program, _ask)))


def conflict_of_parts(scene: Scene, found: Found, answer: Callable[[Scene], Design]) -> Conflict | None:
    """Limits without any one of which some choice of parts would do, and the bound of each that is enough."""
    whole = conflict_over_tolerances(scene, tuple(scene.limits), found, answer)
    if whole is None or not whole.loosenings:
        return None
    return replace(whole, limits=tuple(name for name, _, _ in whole.loosenings))


def conflict_over_tolerances(
    scene: Scene, names: tuple[str, ...], found: Found, answer: Callable[[Scene], Design]
) -> Conflict | None:
    """Limits that cannot hold together, and the bound of each with which all would hold over the tolerances.

    answer
        Solves a scene over its tolerances.
    """
    rows: list[Row] = []
    until = time.perf_counter() + _ALL_SECONDS
    for name in names:
        row = _loosened(scene, name, answer) if name in scene.limits and time.perf_counter() < until else None
        rows += [row] if row is not None else []
    return Conflict(names, tuple(rows), found.claim) if names else None


def _ask(part: Program) -> Found:
    method = choose(part, None)
    return (BranchAndBound(_GAP, _SECONDS) if isinstance(method, BranchAndBound) else method).solve(part)


def _loosened(scene: Scene, name: str, answer: Callable[[Scene], Design]) -> Row | None:
    """The limit as the goal: the best that it can be while all others hold, its worst machine counted."""
    response, document = scene.limits[name], copy.deepcopy(dict(scene.document))
    sides = [side for side in _BOUNDS if getattr(response, side, None) is not None]
    if len(sides) != 1 or sides[0] == "outside":
        return None
    words = {key: one for key, one in document["limits"].pop(name).items() if key not in (*_BOUNDS, "response")}
    document["goal"] = {"minimise" if sides[0] == "at_most" else "maximise": response.response, **words}
    try:
        best = answer(from_dict(document, name=scene.name))
    except InputError:
        return None
    if best.goal is None or best.status not in ("optimal", "feasible"):
        return None
    given = getattr(response, sides[0])
    shown = outward_shown(response, best.goal[1].value, given.unit, sides[0])
    return name, shown_value(response, given.value, given.unit), shown


__all__ = ["clash_of", "conflict_of_parts", "conflict_over_tolerances"]
