"""One fact varied over a range: goal and variables against it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from vibopt.design.design import Design, Shown
from vibopt.errors import InputError, QuantityError
from vibopt.scene.facts import FactAt, fact_at
from vibopt.scene.read import with_changes
from vibopt.scene.scene import Scene
from vibopt.solve import solve
from vibopt.solve.method import Progress
from vibopt.study.freeze import frozen
from vibopt.units import is_range, read_range, si_unit

MOST_POINTS = 100_000


@dataclass(frozen=True, slots=True)
class Point:
    """Answer at one value of the varied fact; `margins` by limit name."""

    value: Shown
    status: str
    goal: Shown | None
    variables: Mapping[str, Shown]
    margins: Mapping[str, float]


@dataclass(frozen=True)
class Sweep:
    """All points of a sweep, in rising order of the fact at `path`.

    goal
        Name of the goal, "" for a frozen design or an analysis.
    """

    scene: Scene
    path: str
    points: tuple[Point, ...]
    goal: str
    keep_design: bool = False

    @property
    def complete(self) -> bool:
        """Whether every point has a proven or checked answer."""
        return all(point.status not in ("unproven", "check_failed") for point in self.points)


def sweep(
    scene: Scene,
    vary: str,
    low_high: str,
    points: int = 50,
    *,
    keep_design: bool = False,
    progress: Progress | None = None,
) -> Sweep:
    """Answer the scene at evenly spaced values of one fact.

    Parameters
    ----------
    scene
        The scene as it is.
    vary
        Path of a fact, "limits.start_up.at_most".
    low_high
        Its range, "5 mm..30 mm"; spaced by equal ratios where it spans more than a factor 100.
    points
        How many values, both ends included.
    keep_design
        Keep the design of the scene as it is, and measure it.

    Raises
    ------
    InputError
        No such fact, a range that cannot be read, or no design to keep.
    """
    fact = fact_at(scene, vary)
    values = _values(fact, low_high, points)
    base = scene
    if keep_design and scene.variables:
        design = solve(scene)
        if not design.x:
            raise InputError(f"{scene.name}: there is no design to keep: {design.status}. Solve the scene first.")
        base = frozen(scene, design.x)
    rows = []
    for index, value in enumerate(values):
        if progress is not None:
            progress("sweep", index / len(values))
        answer = solve(with_changes(base, {vary: fact.text(value)}), explain=False)
        rows.append(_point(fact, value, answer))
    name = scene.goal.name if scene.goal is not None and not keep_design else ""
    return Sweep(scene, vary, tuple(rows), name, keep_design)


def _values(fact: FactAt, low_high: str, points: int) -> list[float]:
    if not 2 <= points <= MOST_POINTS:
        raise InputError(f"--points {points} is not between 2 and {MOST_POINTS}.")
    if not is_range(low_high):
        raise InputError(f'--vary {fact.path}="{low_high}" is no range. Write "5 mm..30 mm".')
    try:
        low, high = read_range(low_high, fact.dimension, amplitude=fact.amplitude)
    except QuantityError as error:
        raise InputError(f'--vary {fact.path}="{low_high}" {error}') from None
    if low.value > 0.0 and high.value > 100.0 * low.value:
        return [float(v) for v in np.geomspace(low.value, high.value, points)]
    return [float(v) for v in np.linspace(low.value, high.value, points)]


def _point(fact: FactAt, value: float, answer: Design) -> Point:
    shown = Shown.of(value, fact.dimension, si_unit(fact.dimension), fact.unit, amplitude=fact.amplitude)
    return Point(
        value=shown,
        status=answer.status,
        goal=answer.goal[1] if answer.goal is not None else None,
        variables={path: one.value for path, one in answer.variables.items()},
        margins={name: one.margin for name, one in answer.limits.items()},
    )
