"""At what value of each fact a given machine first breaks a limit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vibopt.design.design import Shown
from vibopt.errors import InputError
from vibopt.program.pose import pose
from vibopt.scene.facts import FactAt, facts
from vibopt.scene.read import with_changes
from vibopt.scene.scene import Scene
from vibopt.solve.branch import Judge
from vibopt.units import si_unit

REACH = 10.0
_POINTS = 48


@dataclass(frozen=True, slots=True)
class Threshold:
    """One fact and the values at which the frozen design stops to meet its limits.

    below, above
        First failing value downward and upward; None where none is found within a factor `REACH`.
    limits
        Names of the limits that break there: (below, above).
    """

    path: str
    now: Shown
    below: Shown | None
    above: Shown | None
    limits: tuple[str, str]


def thresholds(scene: Scene, progress: Callable[[str, float], None] | None = None) -> list[Threshold]:
    """Threshold of every physical fact of an analysis whose limits all hold.

    The first crossing on a grid of 48 values per direction, refined until the margin changes sign
    between neighbouring numbers.
    """
    physical = [one for one in facts(scene) if not one.path.startswith("limits.") and one.value > 0.0]
    found = []
    for index, fact in enumerate(physical):
        if progress is not None:
            progress("thresholds", index / len(physical))
        found.append(_of(scene, fact))
    return found


def _of(scene: Scene, fact: FactAt) -> Threshold:
    down, first = _crossing(scene, fact, 1.0 / REACH)
    up, second = _crossing(scene, fact, REACH)
    return Threshold(fact.path, _shown(fact, fact.value), down, up, (first, second))


def _shown(fact: FactAt, value: float) -> Shown:
    return Shown.of(value, fact.dimension, si_unit(fact.dimension), fact.unit, amplitude=fact.amplitude)


def _crossing(scene: Scene, fact: FactAt, reach: float) -> tuple[Shown | None, str]:
    """The first failing value between the fact and `reach` times it, and the limit that breaks."""
    good = fact.value
    for value in _steps(fact, reach):
        missed, name = broken(scene, fact, value)
        if missed > 0.0:
            bad, name = (value, name) if fact.dimension == "count" else _between(scene, fact, good, value, name)
            return _shown(fact, bad), name
        good = value
    return None, ""


def _steps(fact: FactAt, reach: float) -> list[float]:
    """Values to try, from the fact outward; whole ones for a count."""
    if fact.dimension == "count":
        now, last = round(fact.value), round(fact.value * reach)
        steps = range(now + 1, last + 1) if reach > 1.0 else range(now - 1, 0, -1)
        return [float(n) for n in steps]
    return [float(fact.value * factor) for factor in np.geomspace(1.0, reach, _POINTS)[1:]]


def _between(scene: Scene, fact: FactAt, good: float, bad: float, worst: str) -> tuple[float, str]:
    """The first failing value between a good and a bad one, to the last digit, and whose limit it is."""
    for _ in range(60):
        middle = 0.5 * (good + bad)
        if middle in (good, bad):
            break
        missed, name = broken(scene, fact, middle)
        good, bad, worst = (good, middle, name) if missed > 0.0 else (middle, bad, worst)
    return bad, worst


def broken(scene: Scene, fact: FactAt, value: float) -> tuple[float, str]:
    """Greatest violation as a part of its bound with a fact changed, and whose it is."""
    try:
        changed = with_changes(scene, {fact.path: fact.text(value)})
    except InputError:
        return 0.0, ""
    program = pose(changed)
    judge = Judge(program)
    rows = [(judge.limit(limit, np.zeros(0))[0] - judge.tolerance, limit.name) for limit in program.limits]
    return max(rows, default=(0.0, ""))
