"""Mistakes of a goal that is read off the limits: the most room in them."""

from __future__ import annotations

from vibopt.document.mistakes import Mistakes
from vibopt.responses import Response
from vibopt.scene.scene import MINIMISE, Goal, Scene
from vibopt.scene.uncertain import uncertain


def check_room(scene: Scene, goal: Goal, mistakes: Mistakes) -> None:
    """It is one of one machine, and every limit that counts has a bound of which a part can be left over."""
    here, said = ("goal", goal.sense), f'goal.{goal.sense} = "{goal.name}"'
    unknown = [name for name in getattr(goal.response, "limits", None) or () if name not in scene.limits]
    for name in unknown:
        mistakes.unknown_name(("goal", "limits"), name, "limit", list(scene.limits))
    if goal.sense == MINIMISE:
        mistakes.add(here, f'{said} asks for the design that is next to breaking. Write maximise = "{goal.name}".')
    counted = [name for name in scene.limits if goal.response.speaks_for(name)]
    if not counted and not unknown:
        mistakes.add(here, f"{said} asks for room in the limits, and there are none. Add a [limits.NAME].")
    good = [name for name in counted if _has_part(scene.limits[name])]
    for name in counted:
        if name not in good:
            bands = getattr(scene.limits[name], "outside", None) is not None
            bound = "bands to keep out of" if bands else "a bound of zero"
            listed = ", ".join(f'"{one}"' for one in good)
            way = f"Count the others alone: limits = [{listed}]." if good else "Make something else best."
            mistakes.add(
                here,
                f"{said} counts which part of its bound each limit has left over, and {name} has {bound}. {way}",
            )
    doubts = uncertain(scene)
    if doubts:
        mistakes.add(
            here,
            f"{said} is asked of one machine, but {doubts[0].path} has a tolerance. Remove the tolerance, or make "
            "something else best: limits then hold for the worst machine.",
        )


def _has_part(response: Response) -> bool:
    bounds = [given.value for given in (response.at_most, response.at_least) if given is not None]
    free = [1.0 - value if response.complement else value for value in bounds]
    return getattr(response, "outside", None) is None and all(value > 0.0 for value in free)
