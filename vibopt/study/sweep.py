"""One fact varied over a range: goal and variables against it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vibopt.errors import InputError, QuantityError
from vibopt.forms import FloatArray
from vibopt.scene.facts import FactAt, fact_at
from vibopt.scene.read import with_changes
from vibopt.scene.scene import Scene
from vibopt.solve import solve
from vibopt.solve.method import Progress
from vibopt.study.freeze import frozen
from vibopt.study.many.answers import columns
from vibopt.study.points import Columns, Point, Points, point_of
from vibopt.units import is_range, read_range

MOST_POINTS = 100_000
FEWEST_TOGETHER = 12
"""Fewer points than this are answered one by one."""
_SAME = 1e-9


@dataclass(frozen=True)
class Sweep:
    """All points of a sweep, in rising order of the fact at `path`.

    goal
        Name of the goal, "" for a frozen design or an analysis.
    """

    scene: Scene
    path: str
    points: Sequence[Point]
    goal: str
    keep_design: bool = False

    @property
    def complete(self) -> bool:
        """Whether every point has a proven or checked answer."""
        points = self.points
        found = points.statuses if isinstance(points, Points) else [point.status for point in points]
        return not {"unproven", "check_failed"} & set(found)


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
    progress
        Called now and then with a stage and the part that is done (0 to 1).

    Raises
    ------
    InputError
        No such fact, a range that cannot be read, or no design to keep.
    """
    fact = fact_at(scene, vary)
    values = np.array(_values(fact, low_high, points))
    base = scene
    if keep_design and scene.variables:
        design = solve(scene)
        if not design.x:
            raise InputError(f"{scene.name}: there is no design to keep: {design.status}. Solve the scene first.")
        base = frozen(scene, design.x)
    name = scene.goal.name if scene.goal is not None and not keep_design else ""
    return Sweep(scene, vary, _answered(base, fact, values, progress), name, keep_design)


def _answered(scene: Scene, fact: FactAt, values: FloatArray, progress: Progress | None) -> Points:
    """All points together where that is possible, and one by one where it is not."""

    def tell(part: float) -> None:
        if progress is not None:
            progress("sweep", part)

    together = columns(scene, fact, values, tell) if len(values) >= FEWEST_TOGETHER else None
    single: dict[int, Point] = {}
    if together is not None:
        for index in (0, len(values) // 2, len(values) - 1):
            single[index] = _one(scene, fact, values[index])
        if not all(_agree(scene, together, index, point) for index, point in single.items()):
            together = None
    if together is None:
        together = Columns([""] * len(values), np.full((len(scene.variables), len(values)), np.nan), None, {})
    rest = [index for index, status in enumerate(together.status) if not status and index not in single]
    for done, index in enumerate(rest):
        tell(done / len(rest))
        single[index] = _one(scene, fact, values[index])
    return Points(scene, fact, values, together, single)


def _one(scene: Scene, fact: FactAt, value: float) -> Point:
    return point_of(fact, float(value), solve(with_changes(scene, {fact.path: fact.text(float(value))}), explain=False))


def _agree(scene: Scene, together: Columns, index: int, point: Point) -> bool:
    """Whether a point answered alone has the same answer as among the others."""
    status = together.status[index]
    if status != point.status:
        return status == ""
    if status == "infeasible":
        return True
    designs = [(point.variables[one.path].value, x[index]) for one, x in zip(scene.variables, together.x, strict=True)]
    if not all(_near(alone, other, abs(alone)) for alone, other in designs):
        # where a peak is level with a limit, rounding leaves free what the goal does not fix
        goal = together.goal
        return point.goal is not None and goal is not None and _near(point.goal.value, goal[index], abs(goal[index]))
    return all(_near(point.margins[name], one[index], 1.0) for name, one in together.margins.items())


def _near(alone: float, other: float, size: float) -> bool:
    return alone == other or abs(alone - other) <= _SAME * max(size, abs(alone))


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


__all__ = ["MOST_POINTS", "Point", "Points", "Sweep", "sweep"]
