"""A scene at many values of one fact: columns of answers, each checked; nothing where the scene does not fit."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache

import numpy as np

from vibopt.errors import InputError
from vibopt.forms import FloatArray
from vibopt.program.pose import pose
from vibopt.scene.facts import FactAt
from vibopt.scene.read import with_changes
from vibopt.scene.scene import Scene
from vibopt.solve.box import closed
from vibopt.study.many.built import is_plain, machines, shaking
from vibopt.study.many.check import margins, plain
from vibopt.study.many.lower import Question, RefusedError, question
from vibopt.study.many.numbers import follow
from vibopt.study.many.outer import INFEASIBLE, OPTIMAL, Answers, answer
from vibopt.study.many.rows import BoolArray
from vibopt.study.points import Columns
from vibopt.verify.certify import TOLERANCE


def columns(
    scene: Scene, fact: FactAt, values: FloatArray, progress: Callable[[float], None] | None = None
) -> Columns | None:
    """Answers at all values of a fact [SI]; None where the scene is not one that is answered together.

    A point has the status "" where nothing was proven, or its check on the built machine failed.
    """
    if scene.find_all is not None or not is_plain(scene) or not values[0] < values[-1]:
        return None

    @cache
    def at(value: float) -> Scene:
        return with_changes(scene, {fact.path: fact.text(value)})

    try:
        shaken = follow(values, lambda value: shaking(at(value)))
        if scene.is_analysis:
            return _measured(scene, shaken, {fact.path: values}, len(values))
        first = _asked(at(float(values[0])))
        numbers = follow(values, lambda value: first.numbers if value == values[0] else _numbers(at(value), first))
        found = answer(first, numbers, len(values), progress)
        return _designs(scene, first, found, shaken, {fact.path: values})
    except (RefusedError, InputError):
        return None


def _asked(scene: Scene, like: Question | None = None) -> Question:
    return question(closed(pose(scene)), like)


def _numbers(scene: Scene, like: Question) -> Mapping[str, float]:
    here = _asked(scene, like)
    if here.structure != like.structure:
        raise RefusedError
    return here.numbers


def _measured(scene: Scene, shaken: Mapping[str, FloatArray], known: Mapping[str, FloatArray], count: int) -> Columns:
    left = margins(scene, machines(scene, known), shaken, count)
    good = _good(left, count)
    return Columns(["met" if one else "violated" for one in good], np.zeros((0, count)), None, left)


def _designs(
    scene: Scene,
    asked: Question,
    found: Answers,
    shaken: Mapping[str, FloatArray],
    known: Mapping[str, FloatArray],
) -> Columns:
    """Check every answer; what is not optimal or infeasible beyond doubt has no status."""
    count = len(found.status)
    x = np.full((len(scene.variables), count), np.nan)
    x[list(asked.order)] = found.x
    shown = np.where(np.isnan(x), np.array([one.high for one in scene.variables])[:, None], x)
    built = machines(scene, {**known, **{one.path: row for one, row in zip(scene.variables, shown, strict=True)}})
    left = margins(scene, built, shaken, count)
    goal = None if scene.goal is None else np.broadcast_to(plain(built, scene.goal.response), (count,))
    proven = (found.status == OPTIMAL) & _good(left, count)
    status = np.where(proven, "optimal", np.where(found.status == INFEASIBLE, "infeasible", ""))
    turns = np.flatnonzero(found.status[1:] != found.status[:-1])
    status[turns] = status[turns + 1] = ""
    return Columns(status.tolist(), x, goal, left)


def _good(left: Mapping[str, FloatArray], count: int) -> BoolArray:
    """Points at which every limit is met."""
    good = np.ones(count, dtype=bool)
    for one in left.values():
        good &= one >= -TOLERANCE
    return good
