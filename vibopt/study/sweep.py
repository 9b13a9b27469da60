"""One fact varied over a range: goal and variables against it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vibopt.errors import InputError, QuantityError
from vibopt.forms import FloatArray
from vibopt.scene.facts import FactAt, fact_at, read_fact
from vibopt.scene.positions import is_open, open_positions
from vibopt.scene.read import with_changes
from vibopt.scene.scene import Scene
from vibopt.scene.uncertain import uncertain
from vibopt.solve import solve
from vibopt.solve.method import Progress
from vibopt.study.freeze import frozen
from vibopt.study.many.answers import columns
from vibopt.study.points import DECIBEL, Columns, Point, Points, point_of
from vibopt.units import Quantity, is_range, read_range, to_unit

Answered = Callable[[FactAt, Point], None]
MOST_POINTS = 100_000
FEWEST_TOGETHER = 12
"""Fewer points than this are answered one by one."""
_SAME = 1e-9


@dataclass(frozen=True)
class Sweep:
    """All points of a sweep, in rising order of the fact.

    fact
        What is varied, in the unit of the range asked for.
    goal
        Name of the goal, "" for a frozen design or an analysis.
    """

    scene: Scene
    fact: FactAt
    points: Sequence[Point]
    goal: str
    keep_design: bool = False

    @property
    def path(self) -> str:
        """Path of the fact that is varied."""
        return self.fact.path

    @property
    def by_ratios(self) -> bool:
        """Whether its values have equal ratios."""
        return _by_ratios(self.fact.unit, self.points[0].value.value, self.points[-1].value.value)

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
    answered: Answered | None = None,
) -> Sweep:
    """Answer the scene at evenly spaced values of one fact.

    Parameters
    ----------
    scene
        The scene as it is.
    vary
        Path of a fact, "limits.start_up.at_most".
    low_high
        Its range, "5 mm..30 mm"; evenly spaced in its unit, in dB too; by equal ratios where it spans more than a
        factor 100 and is not in dB.
    points
        How many values, both ends included.
    keep_design
        Keep the design of the scene as it is, and measure it.
    progress
        Called now and then with a stage and the part that is done (0 to 1).
    answered
        Called with the fact, in the unit of the range, and each point as soon as it is known, in any order; not where
        all are found together.

    Raises
    ------
    InputError
        No such fact, a range that cannot be read, no design to keep, or a scene that asks for speeds.
    """
    if scene.find_all is not None:
        raise InputError(
            f"{scene.name}: sweep needs a goal or limits to measure; find_all answers with speeds: use whatif instead."
        )
    fact = fact_at(scene, vary)
    low, high = _ends(fact, low_high, points)
    fact = replace(fact, unit=high.unit)
    values = np.array(_values(fact, low.value, high.value, points))
    base = scene
    if keep_design and is_open(scene):
        design = solve(scene)
        if not (design.variables or design.places):
            raise InputError(f"{scene.name}: there is no design to keep: {design.status}. Solve the scene first.")
        base = frozen(design.scene, design.x)
    name = scene.goal.name if scene.goal is not None and not keep_design else ""
    return Sweep(scene, fact, _answered(base, fact, values, progress, answered), name, keep_design)


def answer_at(sweep: Sweep, value: float) -> Point:
    """The answer at one more value of the fact [SI], of a sweep that keeps no design."""
    return _one(sweep.scene, sweep.fact, value)


def _answered(
    scene: Scene, fact: FactAt, values: FloatArray, progress: Progress | None, answered: Answered | None
) -> Points:
    """All points together where that is possible, and one by one where it is not."""

    def tell(part: float) -> None:
        if progress is not None:
            progress("sweep", part)

    apart = len(values) < FEWEST_TOGETHER or bool(uncertain(scene)) or bool(open_positions(scene))
    together = None if apart else columns(scene, fact, values, tell)
    single: dict[int, Point] = {}

    def alone(index: int) -> None:
        single[index] = _one(scene, fact, values[index])
        if answered is not None:
            answered(fact, single[index])

    if together is not None:
        for index in (len(values) // 2, len(values) - 1):
            alone(index)
        if not all(_agree(scene, together, index, point) for index, point in single.items()):
            together = None
    if together is None:
        together = Columns([""] * len(values), np.full((len(scene.variables), len(values)), np.nan), None, {})
    rest = [index for index, status in enumerate(together.status) if not status and index not in single]
    points = Points(scene, fact, values, together, single)
    if rest and answered is not None:
        for index, status in enumerate(together.status):
            if status and index not in single:
                answered(fact, points[index])
    for done, index in enumerate(rest):
        tell(done / len(rest))
        alone(index)
    return points


def _one(scene: Scene, fact: FactAt, value: float) -> Point:
    design = solve(with_changes(scene, fact.changes(float(value))), explain=False, brief=True)
    return point_of(fact, float(value), design)


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


def _ends(fact: FactAt, low_high: str, points: int) -> tuple[Quantity, Quantity]:
    if not 2 <= points <= MOST_POINTS:
        raise InputError(f"--points {points} is not between 2 and {MOST_POINTS}.")
    if not is_range(low_high):
        raise InputError(f'--vary {fact.path}="{low_high}" is no range. Write "5 mm..30 mm".')
    try:
        low, high = read_range(low_high, fact.dimension, amplitude=fact.amplitude)
    except QuantityError as error:
        raise InputError(f'--vary {fact.path}="{low_high}" {error}') from None
    if high.unit == DECIBEL and low.value <= 0.0:
        raise InputError(f'--vary {fact.path}="{low_high}" begins at a ratio that has no dB. Write "5 dB..30 dB".')
    return low, high


def _values(fact: FactAt, low: float, high: float, points: int) -> list[float]:
    """Values [SI] from end to end; those in dB as the text says that will stand in the file."""
    if fact.unit == DECIBEL:
        ends = [to_unit(end, DECIBEL, fact.dimension) for end in (low, high)]
        levels = np.linspace(ends[0], ends[1], points)
        return [read_fact(fact, f"{level:.12g} {DECIBEL}") for level in levels]
    spaced = np.geomspace if _by_ratios(fact.unit, low, high) else np.linspace
    return [float(v) for v in spaced(low, high, points)]


def _by_ratios(unit: str, low: float, high: float) -> bool:
    return unit != DECIBEL and low > 0.0 and high > 100.0 * low


__all__ = ["MOST_POINTS", "Point", "Points", "Sweep", "answer_at", "sweep"]
