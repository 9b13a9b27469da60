"""One fact varied over a range: goal and variables against it."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.answer.tabular import Tabular
from vibopt.arrays import FloatArray
from vibopt.document.toml_reading import inside
from vibopt.errors import InputError, QuantityError
from vibopt.jobs import answer, fact_at, is_open, is_scene, with_changes
from vibopt.records import dataclass
from vibopt.scene.open_places import open_positions
from vibopt.scene.scene import Scene
from vibopt.scene.uncertain import uncertain
from vibopt.solve.method import Progress
from vibopt.study.points import DECIBEL, Columns, Heads, Point, Points, point_of
from vibopt.study.seen import goal_word, kept
from vibopt.study.together import columns
from vibopt.units import Quantity, is_range, to_unit
from vibopt.values.fact_at import FactAt

if TYPE_CHECKING:
    from vibopt.jobs import Job

Answered = Callable[[FactAt, Point], None]
MOST_POINTS = 100_000
FEWEST_TOGETHER = 12
"""Fewer points than this are answered one by one."""
_SAME = 1e-9
_PART = re.compile(r"\s*([+-] ?\d+(?:\.\d+)?)\s*%\s*")


@dataclass(frozen=True)
class Sweep(Tabular):
    """All points of a sweep, in rising order of the fact.

    fact
        What is varied, in the unit of the range asked for.
    goal
        Name of the goal, "" for an analysis.
    held
        Whether it is a variable that is held at each value, and no fact.
    """

    job: Job
    fact: FactAt
    points: Sequence[Point]
    goal: str
    keep_design: bool = False
    held: bool = False

    @property
    def path(self) -> str:
        """Path of the fact that is varied."""
        return self.fact.path

    @property
    def by_ratios(self) -> bool:
        """Whether its values have equal ratios."""
        return _by_ratios(self.fact.unit, self.points[0].value.value, self.points[-1].value.value)

    def table(self) -> list[dict[str, Any]]:
        """A row for each point, with the columns of the CSV file: SI units in their heads, margins as parts."""
        points = list(self.points)
        heads = Heads(self.fact, self.job, self.goal, points)
        return [
            {head: None if one == "" else one for head, one in zip(heads.heads, heads.row(point), strict=True)}
            for point in points
        ]

    def heading(self) -> tuple[str, ...]:
        """Title and what is varied."""
        return self.job.title, f"{self.path} varied"

    @property
    def complete(self) -> bool:
        """Whether every point has a proven or checked answer."""
        points = self.points
        found = points.statuses if isinstance(points, Points) else [point.status for point in points]
        return not {"unproven", "check_failed"} & set(found)


def sweep(
    job: Job,
    vary: str,
    low_high: str,
    points: int = 50,
    *,
    keep_design: bool = False,
    progress: Progress | None = None,
    answered: Answered | None = None,
) -> Sweep:
    """Answer a job at evenly spaced values of one fact.

    Parameters
    ----------
    job
        A scene or a balancing job as it is.
    vary
        Path of a fact, "limits.start_up.at_most", or of a variable, which is then held at each value.
    low_high
        Its range, "5 mm..30 mm", or parts of what it is now, "-20 %..+20 %"; evenly spaced in its unit, in dB too; by
        equal ratios where it spans more than a factor 100 and is not in dB.
    points
        How many values, both ends included.
    keep_design
        Keep the design of the job as it is, and measure it.
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
    if is_scene(job) and job.find_all not in (None, vary):
        raise InputError(
            f"{job.name}: sweep needs a goal or limits to measure; find_all answers with {job.finds}: use whatif "
            "instead."
        )
    base = kept(job, answer(job, explain=False)) if keep_design and is_open(job) else None
    held = _is_variable(job, vary)
    if held and base is None:
        job = with_changes(job, {vary: low_high.rpartition("..")[2].strip()})
    fact = fact_at(job if base is None else base, vary) if held else fact_at(job, vary)
    low, high = _ends(fact, _absolute(fact, low_high), points)
    fact = replace(fact, unit=high.unit)
    values = np.array(_values(fact, low.value, high.value, points))
    base = job if base is None else base
    return Sweep(job, fact, _answered(base, fact, values, progress, answered), goal_word(base), keep_design, held)


def _is_variable(job: Job, path: str) -> bool:
    """Whether a number is chosen from a range of its own, so that it can be held at each value in turn."""
    chosen = next((one.choice for one in job.variables if one.path == path), None) if is_scene(job) else None
    return (
        chosen is not None
        and not (chosen.options or chosen.whole or chosen.tolerance)
        and (inside(job.document, path) is not None)
    )


def _absolute(fact: FactAt, low_high: str) -> str:
    """A range of parts of a number, "-20 %..+20 %", as the range of the number."""
    ends = [_PART.fullmatch(one) for one in low_high.split("..")]
    if len(ends) != 2 or fact.dimension in ("ratio", "level") or None in ends:
        return low_high
    return "..".join(fact.now(1.0 + float(one[1].replace(" ", "")) / 100.0) for one in ends if one is not None)


def answer_at(sweep: Sweep, value: float) -> Point:
    """The answer at one more value of the fact [SI], of a sweep that keeps no design."""
    return _one(sweep.job, sweep.fact, value)


def _answered(
    job: Job, fact: FactAt, values: FloatArray, progress: Progress | None, answered: Answered | None
) -> Points:
    """All points together where that is possible, and one by one where it is not."""

    def tell(part: float) -> None:
        if progress is not None:
            progress("sweep", part)

    together = None if len(values) < FEWEST_TOGETHER else _together(job, fact, values, tell)
    single: dict[int, Point] = {}

    def alone(index: int) -> None:
        single[index] = _one(job, fact, values[index])
        if answered is not None:
            answered(fact, single[index])

    if together is not None:
        alone(len(values) // 2)
        if not all(is_scene(job) and _agree(job, together, index, point) for index, point in single.items()):
            together = None
    if together is None:
        together = Columns([""] * len(values), np.full((0, len(values)), np.nan), None, {})
    rest = [index for index, status in enumerate(together.status) if not status and index not in single]
    points = Points(job, fact, values, together, single)
    if rest and answered is not None:
        for index, status in enumerate(together.status):
            if status and index not in single:
                answered(fact, points[index])
    for done, index in enumerate(rest):
        tell(done / len(rest))
        alone(index)
    return points


def _together(job: Job, fact: FactAt, values: FloatArray, tell: Callable[[float], None]) -> Columns | None:
    """All points in one batch; None where that is not possible."""
    if not is_scene(job) or uncertain(job) or open_positions(job):
        return None
    return columns(job, fact, values, tell)


def _one(job: Job, fact: FactAt, value: float) -> Point:
    here = with_changes(job, fact.changes(float(value)))
    return point_of(fact, float(value), here, answer(here, explain=False, brief=True))


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
        low, high = fact.ends(low_high)
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
        return [fact.read(f"{level:.12g} {DECIBEL}") for level in levels]
    spaced = np.geomspace if _by_ratios(fact.unit, low, high) else np.linspace
    return [float(v) for v in spaced(low, high, points)]


def _by_ratios(unit: str, low: float, high: float) -> bool:
    return unit != DECIBEL and low > 0.0 and high > 100.0 * low


__all__ = ["MOST_POINTS", "Point", "Points", "Sweep", "answer_at", "sweep"]
