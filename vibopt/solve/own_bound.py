"""A goal at the bound that a limit sets to the same response: nothing can be better, whatever was searched."""

from __future__ import annotations

from dataclasses import replace

from vibopt.program.program import Program
from vibopt.responses import Response
from vibopt.scene.open_places import numbers_of
from vibopt.scene.scene import Scene
from vibopt.solve.branch import Judge
from vibopt.solve.method import Found

_GAP = 1e-6
"""Part of the bound by which the goal may be away from it, as from any bound that is proven."""
_BOUNDS = ("at_most", "at_least", "outside", "unit")


def at_own_bound(scene: Scene, program: Program, found: Found) -> Found:
    """The answer, proven where its goal is a response that a limit keeps from being any better."""
    aim = program.aim
    if found.status != "feasible" or found.x is None or aim is None or scene.goal is None:
        return found
    asked, value = _without_bounds(scene.goal.response), aim.sense * Judge(program).goal(found.x).value
    side = "at_least" if aim.sense > 0 else "at_most"
    for limit in program.limits:
        response = scene.limits.get(limit.name)
        if response is None or limit.side != side or _without_bounds(response) != asked:
            continue
        if abs(value - limit.bound) <= _GAP * abs(limit.bound):
            claim = f"proven: the goal is at the bound that {limit.name} sets to it; {found.claim}"
            return replace(found, status="optimal", claim=claim, bound=aim.sense * limit.bound)
    return found


def _without_bounds(response: Response) -> tuple[object, ...]:
    """What is asked, and where."""
    return tuple(one for one in numbers_of(response) if one[0] not in _BOUNDS)


__all__ = ["at_own_bound"]
