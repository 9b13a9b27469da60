"""Rounded values near a design that keep every limit."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from vibopt.answer.entry import Entry
from vibopt.errors import InputError
from vibopt.records import dataclass
from vibopt.scene.facts import facts
from vibopt.scene.read import with_changes
from vibopt.scene.scene import MINIMISE, Design, Goal, Scene
from vibopt.scene.uncertain import uncertain
from vibopt.solve import solve
from vibopt.study.freeze import frozen
from vibopt.study.grids import Grid, grids, numbers, x_of
from vibopt.study.margins import most_missed
from vibopt.verify.checked import goal_of

MOST_FREE = 8
"""Numbers that are moved; of more, those that lie nearest to the middle between two steps."""
REACHES = (1, 2, 4)
"""Steps below and above that are looked at, one reach after another."""
ROOMS = (0.001, 0.003, 0.01, 0.03, 0.1)
"""Parts by which bounds are tightened for a design with room to be rounded, where none near the best holds."""
MOST_TRIED = 512
"""Most combinations of one reach; of a wider one none are looked at."""


@dataclass(frozen=True, slots=True)
class Near:
    """One rounding: texts by path, the scene, its measurement, and whether it keeps every limit."""

    texts: Mapping[str, str]
    kept: Scene
    answer: Design
    x: tuple[float, ...]
    tried: int = 1

    @property
    def good(self) -> bool:
        return all(limit.met for limit in self.answer.limits.values())

    @property
    def worst(self) -> tuple[str, float]:
        """The limit with the least margin, and that margin."""
        return min(((name, limit.margin) for name, limit in self.answer.limits.items()), key=lambda one: one[1])


def search(design: Design, kept: Scene, steps: Sequence[Grid], reaches: Sequence[int]) -> Near:
    """The nearest rounding if it holds, else the best that does, else the one that misses least."""
    nearest = {step.path: step.nearest for step in steps}
    tried = {tuple(nearest.values())}
    found = [one] if (one := _measured(design, kept, nearest)) is not None else []
    if found and found[0].good:
        return found[0]
    missing: tuple[float, Mapping[str, str]] | None = None
    for reach in reaches:
        for texts in _by_goal(design, kept, _combinations(steps, reach)):
            if tuple(texts.values()) in tried:
                continue
            tried.add(tuple(texts.values()))
            missed = most_missed(with_changes(kept, texts))[0]
            one = _measured(design, kept, texts) if missed <= 0.0 else None
            if one is not None and one.good:
                return replace(one, tried=len(tried))
            if missing is None or missed < missing[0]:
                missing = missed, texts
    if missing is not None and (one := _measured(design, kept, missing[1])) is not None:
        found.append(one)
    if not found:
        raise InputError(f"{design.scene.name}: no rounded value lies within the range that was given. Round finer.")
    return replace(max(found, key=lambda one: one.worst[1]), tried=len(tried))


def _combinations(steps: Sequence[Grid], reach: int) -> Iterator[dict[str, str]]:
    """Every number so many steps down and up; of more than eight the rest to the nearest."""
    free = sorted(steps, key=lambda one: one.doubt, reverse=True)[:MOST_FREE]
    ways = [step.around(reach) if step in free else (step.nearest,) for step in steps]
    if reach > 1 and math.prod(map(len, ways)) > MOST_TRIED:
        return
    for texts in product(*ways):
        yield {step.path: text for step, text in zip(steps, texts, strict=True)}


def _by_goal(design: Design, kept: Scene, given: Iterator[dict[str, str]]) -> list[dict[str, str]]:
    """Those within the ranges, best goal first."""
    goal = design.scene.goal
    ranked: list[tuple[float, int, dict[str, str]]] = []
    for texts in given:
        scene = with_changes(kept, texts)
        if x_of(design, scene) is None:
            continue
        value = goal_on(scene, goal) if goal is not None else None
        size = 0.0 if value is None else value.value * (1.0 if goal is not None and goal.sense == MINIMISE else -1.0)
        ranked.append((size, len(ranked), texts))
    return [texts for *_, texts in sorted(ranked, key=lambda one: one[:2])]


def _measured(design: Design, kept: Scene, texts: Mapping[str, str]) -> Near | None:
    """A rounding measured; None where it leaves the ranges of the file."""
    scene = with_changes(kept, texts)
    x = x_of(design, scene)
    return None if x is None else Near(texts, scene, solve(scene, explain=False), x)


def goal_on(scene: Scene, goal: Goal) -> Entry | None:
    """A goal on a machine without choices; the worst over its tolerances."""
    asked = replace(scene, goal=goal)
    if uncertain(scene):
        from vibopt.solve.deviations import goal_machine
        from vibopt.solve.robust import judged

        asked = replace(asked, off=goal_machine(asked, judged(asked, np.zeros(0)).hits))
    found = goal_of(asked, {})
    return None if found is None else found[1]


def roomy_designs(design: Design) -> Iterator[tuple[float, ...]]:
    """Designs that are best for tighter bounds."""
    scene = design.scene
    bounds = [fact for fact in facts(scene) if fact.path.startswith("limits.") and fact.value > 0.0]
    for part in ROOMS:
        signs = [(bound, -1.0 if bound.path.endswith(".at_most") else 1.0) for bound in bounds]
        changes: dict[str, str | float] = {}
        for one, sign in signs:
            changes |= one.changes(one.value * (1.0 + sign * part))
        try:
            found = solve(with_changes(scene, changes), explain=False, near=design.x)
        except InputError:
            return
        alike = all(a == b for v, a, b in zip(scene.variables, found.x, design.x, strict=False) if v.values is not None)
        if not found.x or not alike:
            return
        yield found.x


def roomiest(design: Design, roomy: Sequence[tuple[float, ...]], asked: Sequence[str]) -> Near | None:
    """A rounding near one of them that keeps the bounds as they are, the first with the best goal."""
    for x in roomy:
        kept = frozen(design.scene, x)
        steps = grids(numbers(design.scene, kept), asked)
        found = search(design, kept, steps, (1,)) if len(steps) <= MOST_FREE else None
        if found is not None and found.good:
            return found
    return None


__all__ = ["MOST_FREE", "REACHES", "Near", "goal_on", "roomiest", "roomy_designs", "search"]
