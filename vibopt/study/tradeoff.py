"""What a better value of one quantity costs of another: the goal against the bound of a limit, from end to end."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.answer.entry import ACTIVE, Entry
from vibopt.answer.tabular import Tabular
from vibopt.errors import InputError
from vibopt.jobs import fact_at, is_open
from vibopt.records import dataclass
from vibopt.solve.method import Progress
from vibopt.study.against import bounded
from vibopt.study.moved_bound import MOST_WORK, SAME, MovedBound
from vibopt.study.pareto import FEWEST, Front
from vibopt.study.points import Heads, Point
from vibopt.study.seen import goal_word
from vibopt.units import si_unit
from vibopt.values.fact_at import FactAt

if TYPE_CHECKING:
    from vibopt.jobs import Job

MOST = 1000
KNEE = (
    "the point farthest from the straight line between both ends, each quantity counted from its best to its worst, by "
    "ratios where it spans more than a factor 100"
)
"""What is called the knee."""


@dataclass(frozen=True)
class Tradeoff(Tabular):
    """Designs of which none is better in both quantities, from the goal's own best to the least that can be reached.

    fact
        The bound that was moved.
    points
        In order of the measured quantity, the best first; `reached` has that quantity at each point.
    goal
        Name of the goal.
    knee
        Index of the point farthest before the line between both ends; None where none is.
    gap
        Greatest distance of neighbours: parts of both spans, added; 2 is all of it.
    free
        Whether the goal has a best value of its own, where the limit holds nothing back.
    jumps
        Indices of points behind which both quantities are not to be had between.
    asked
        Number of answers that it took.
    short
        Whether the work that is done unasked was too little for as many points, and for ends to 1e-6.
    """

    job: Job
    fact: FactAt
    points: tuple[Point, ...]
    reached: tuple[Entry, ...]
    goal: str
    knee: int | None
    gap: float
    free: bool
    jumps: tuple[int, ...]
    asked: int
    short: bool = False

    @property
    def name(self) -> str:
        """Name of the limit."""
        return self.fact.path.split(".")[1]

    def table(self) -> list[dict[str, Any]]:
        """A row for each point: what was reached, and the columns of a sweep over the bound."""
        heads = Heads((self.fact,), self.job, self.goal, self.points)
        unit = si_unit(self.fact.dimension)
        first = f"{self.name} [{unit}]" if unit else self.name
        rows = zip(heads.table(self.points), self.reached, strict=True)
        return [{first: at.value, "knee": index == self.knee, **row} for index, (row, at) in enumerate(rows)]

    def heading(self) -> tuple[str, ...]:
        """Title and what is weighed."""
        return self.job.title, f"{self.goal} against {self.fact.path}"

    def as_said(self) -> dict[str, Any]:
        """All points with what was reached, and the knee."""
        return {
            "path": self.fact.path, "goal": self.goal, "knee": self.knee, "knee_is": KNEE, "gap": self.gap,
            "free": self.free, "jumps": self.jumps, "answers": self.asked, "short": self.short,
            "points": [{"reached": at, **point.to_json()} for at, point in zip(self.reached, self.points, strict=True)],
        }  # fmt: skip


def tradeoff(
    job: Job, against: str, points: int = 50, *, thorough: bool = False, progress: Progress | None = None
) -> Tradeoff:
    """The goal against the bound of a limit, or against a second response.

    Parameters
    ----------
    job
        With a goal and something to choose.
    against
        A limit, "limits.start_up" (or one of its two sides, "limits.band.at_least"), a measure, "measures.sag", or a
        response in words, "displacement of press over 0..3000 rpm"; the last two are to be as small as can be, with
        "most " before them as great.
    points
        Neighbours are no further apart than the whole over so many steps, but where there is nothing between.
    thorough
        Whatever the work.
    progress
        Called now and then with a stage and the part that is done.

    Raises
    ------
    InputError
        No goal, no such limit, or no design at any bound.
    """
    refuse_analysis(job)
    if not FEWEST <= points <= MOST:
        raise InputError(f"--points {points} is not between {FEWEST} and {MOST}.")
    job, path = bounded(job, against)
    moved = MovedBound(job, fact_at(job, path), progress, np.inf if thorough else MOST_WORK)
    front = Front(moved, points)
    found = front.points
    if len(found) < 2:
        raise InputError(
            f"{job.name}: {path} and the goal are best in one and the same design: there is nothing to weigh."
        )
    away = 1.0 - front.parts(found).sum(axis=1)
    knee = int(away.argmax()) if away.max() > SAME else None
    entries = tuple(replace(point.value, value=moved.reached(point)) for point in found)
    return Tradeoff(
        job, moved.fact, tuple(found), entries, goal_word(job), knee, front.gap, front.free, front.jumps, moved.asked,
        moved.short,
    )  # fmt: skip


def refuse_analysis(job: Job) -> None:
    """InputError of a job that has no goal, or nothing to choose."""
    if not is_open(job) or not goal_word(job):
        raise InputError(f"{job.name}: tradeoff needs a goal and something to choose. Write a [goal], or use sweep.")


def weighs(point: Point) -> str:
    """Limits that hold a point back."""
    return ", ".join(name for name, margin in point.margins.items() if abs(margin) <= ACTIVE)
