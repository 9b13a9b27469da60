"""How the design of a machine is rounded."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.answer.entry import Entry
from vibopt.errors import InputError
from vibopt.scene.read import with_changes
from vibopt.scene.scene import MINIMISE, Design, Goal, Scene
from vibopt.scene.uncertain import uncertain
from vibopt.solve import solve
from vibopt.study.freeze import frozen
from vibopt.study.grids import Number, numbers, x_of
from vibopt.study.margins import most_missed
from vibopt.study.nearby import Near, Rounded, Rounding, Value
from vibopt.verify.checked import chosen_of, goal_of
from vibopt.verify.measured_goal import goal_as_shown

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer


def rounded(design: Design, asked: Sequence[str]) -> Rounded:
    """Round the chosen values of a design, and measure it anew.

    Parameters
    ----------
    design
        An answer with values.
    asked
        Significant digits for all ("3"), or steps of single values ("links.mount.stiffness=50 kN/m"), or both.

    Raises
    ------
    InputError
        What is asked cannot be read, there is no design, or nothing in it can be rounded.
    """
    scene = design.scene
    if not any(variable.values is None for variable in scene.variables):
        why = (
            "what is chosen are parts, places and listed values"
            if scene.variables or design.places
            else ("nothing is chosen")
        )
        raise InputError(f"{scene.name}: there is nothing to round: {why}.")
    if not design.x or design.status in ("check_failed", "unbounded"):
        raise InputError(f"{scene.name}: there is no design to round: {design.status}.")
    return _OfScene(scene, design).rounded(asked)


class _OfScene(Rounding):
    """Of a machine."""

    reaches = (1, 2, 4)

    def __init__(self, job: Scene, found: Design) -> None:
        super().__init__(job, found)
        self.sense = 1.0 if job.goal is None or job.goal.sense == MINIMISE else -1.0

    def kept(self, answer: Answer[Any]) -> Scene:
        return frozen(self.job, answer.x)

    def numbers(self, kept: Scene) -> list[Number]:
        return numbers(self.job, kept)

    def measured(self, kept: Scene, texts: Mapping[str, str]) -> Near | None:
        scene = with_changes(kept, texts)
        x = x_of(self.found, scene)
        if x is None:
            return None
        answer = solve(scene, explain=False)
        broken = {name: checked.margin for name, checked in answer.limits.items() if not checked.met}
        worst = min(broken, key=lambda name: broken[name], default="")
        return Near(texts, scene, answer, worst, -broken.get(worst, 0.0), x=x)

    def cost(self, kept: Scene, texts: Mapping[str, str]) -> float | None:
        scene, goal = with_changes(kept, texts), self.job.goal
        if x_of(self.found, scene) is None:
            return None
        value = goal_on(scene, goal) if goal is not None else None
        return 0.0 if value is None else self.sense * value.value

    def missed(self, kept: Scene, texts: Mapping[str, str]) -> float:
        return most_missed(with_changes(kept, texts))[0]

    def again(self, changes: Mapping[str, str | float]) -> Answer[Any] | None:
        answer = solve(with_changes(self.job, changes), explain=False, near=self.found.x)
        pairs = zip(self.job.variables, answer.x, self.found.x, strict=False)
        return answer if answer.x and all(a == b for v, a, b in pairs if v.values is not None) else None

    def goal(self, best: Near) -> Entry | None:
        goal = goal_as_shown(self.job)
        return None if goal is None else goal_on(best.kept, goal)

    def design(self, best: Near, values: Mapping[str, Value]) -> Answer[Any]:
        design, measured = self.found, best.answer.tolerances
        pairs = zip(self.job.variables, best.x, strict=True)
        chosen = {variable.path: chosen_of(variable, v) for variable, v in pairs}
        chosen |= {path: replace(chosen[path], value=value.rounded) for path, value in values.items() if path in chosen}
        tolerances = design.tolerances
        if tolerances is not None and measured is not None:
            tolerances = replace(tolerances, open=measured.open)
        return replace(
            design, variables=chosen, x=best.x, limits=best.answer.limits, tolerances=tolerances,
            measures={name: best.answer.measures[name] for name in design.measures},
        )  # fmt: skip


def goal_on(scene: Any, goal: Goal) -> Entry | None:
    """A goal on a machine without choices; the worst over its tolerances."""
    asked = replace(scene, goal=goal)
    if uncertain(scene):
        from vibopt.program.worst_case import around
        from vibopt.solve.deviations import goal_machine
        from vibopt.solve.proof import searched

        asked = replace(asked, off=goal_machine(asked, searched(around(asked, np.zeros(0)))))
    found = goal_of(asked, {})
    return None if found is None else found[1]
