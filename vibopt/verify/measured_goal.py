"""What becomes of a goal where nothing is left to choose: a measure."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from vibopt.responses import HarmonicResponse
from vibopt.scene.scene import MAXIMISE, MINIMISE, Goal, Scene
from vibopt.scene.space import members
from vibopt.scene.uncertain import uncertain
from vibopt.verify.checked import usual_unit

MEASURED = {MINIMISE: "minimised", MAXIMISE: "maximised"}
"""Name of the measure that a goal becomes, by its sense."""


def measure_goal(scene: Scene, document: dict[str, Any]) -> None:
    """What was made best is measured in a document from now on, in the unit in which it was shown, and no goal.

    What is read off the limits stays theirs.
    """
    goal = goal_as_shown(scene)
    if goal is None:
        return
    given = {key: one for key, one in document.pop("goal").items() if key != goal.sense}
    if goal.response.of_limits:
        return
    unit = {"unit": goal.response.unit} if goal.response.unit else {}
    measure = {"response": goal.name, **given, **unit, **_worst(scene, goal)}
    document["measures"] = dict(document.get("measures", {}))  # that of the scene stays
    document["measures"].setdefault(MEASURED[goal.sense], measure)


def _worst(scene: Scene, goal: Goal) -> dict[str, str]:
    """Which of several values a goal is, over speeds, mounts or tolerances, where a measure would show another."""
    response, least = goal.response, goal.sense == MAXIMISE
    several = isinstance(response, HarmonicResponse) or len(members(scene, response)) > 1 or bool(uncertain(scene))
    if not several or least == (response.worst_side == "at_least"):
        return {}
    return {"worst": "least" if least else "greatest"}


def goal_as_shown(scene: Scene) -> Goal | None:
    """The goal with the unit in which an answer shows it."""
    goal = scene.goal
    if goal is None:
        return None
    unit = goal.response.unit or usual_unit(scene, goal.response)
    return replace(goal, response=goal.response.model_copy(update={"unit": unit or None}))
