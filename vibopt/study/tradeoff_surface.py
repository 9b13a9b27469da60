"""What better values of two quantities cost of a third: for each bound of one limit the curve against another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.answer.entry import Entry
from vibopt.answer.tabular import Tabular
from vibopt.errors import InputError
from vibopt.jobs import fact_at, with_changes
from vibopt.records import dataclass
from vibopt.solve.method import Progress
from vibopt.study.against import bounded
from vibopt.study.moved_bound import CLOSE, FAR, MOST_WORK, MovedBound
from vibopt.study.pareto import RATIO, Front
from vibopt.study.points import Heads, Point, varied_at
from vibopt.study.seen import goal_word
from vibopt.study.tradeoff import refuse_analysis
from vibopt.units import si_unit
from vibopt.values.fact_at import FactAt

if TYPE_CHECKING:
    from vibopt.jobs import Job

FEWEST, MOST = 3, 60
USUAL = 7
"""Bounds of the first limit, and steps of each curve."""


@dataclass(frozen=True)
class Surface(Tabular):
    """Designs of which none is better in all three quantities.

    facts
        Both bounds that were moved; the first has a value on each curve.
    points
        Curve by curve; on each in order of the second quantity, the best first.
    reached
        Both quantities of each point.
    gap
        Greatest distance of neighbours on a curve: parts of both spans, added; 2 is all of it.
    asked
        Number of answers that it took.
    short
        As of a trade-off against one.
    """

    job: Job
    facts: tuple[FactAt, FactAt]
    points: tuple[Point, ...]
    reached: tuple[tuple[Entry, Entry], ...]
    goal: str
    gap: float
    asked: int
    short: bool = False

    @property
    def names(self) -> tuple[str, str]:
        """Names of both limits."""
        first, second = (fact.path.split(".")[1] for fact in self.facts)
        return first, second

    @property
    def curves(self) -> dict[float, list[int]]:
        """Points of each curve by index, by the bound of the first limit [SI]."""
        found: dict[float, list[int]] = {}
        for index, point in enumerate(self.points):
            found.setdefault(point.value.value, []).append(index)
        return found

    def table(self) -> list[dict[str, Any]]:
        """A row for each point: what was reached of both, and the columns of a sweep over the bounds."""
        units = [si_unit(fact.dimension) for fact in self.facts]
        heads = [f"{name} [{unit}]" if unit else name for name, unit in zip(self.names, units, strict=True)]
        rows = Heads(self.facts, self.job, self.goal, self.points).table(self.points)
        both = [[one.value for one in pair] for pair in self.reached]
        return [dict(zip(heads, pair, strict=True)) | row for pair, row in zip(both, rows, strict=True)]

    def heading(self) -> tuple[str, ...]:
        """Title and what is weighed."""
        return self.job.title, f"{self.goal} against {self.facts[0].path} and {self.facts[1].path}"

    def as_said(self) -> dict[str, Any]:
        """All points with what was reached."""
        points = [{"reached": both, **point.to_json()} for both, point in zip(self.reached, self.points, strict=True)]
        paths = [fact.path for fact in self.facts]
        return {
            "paths": paths, "goal": self.goal, "gap": self.gap, "answers": self.asked, "short": self.short,
            "points": points,
        }  # fmt: skip


def tradeoff_surface(
    job: Job,
    against: Sequence[str],
    points: int = USUAL,
    *,
    thorough: bool = False,
    progress: Progress | None = None,
) -> Surface:
    """The goal against the bounds of two limits, or against two more responses.

    Parameters
    ----------
    job
        With a goal and something to choose.
    against
        Two, each as that of `tradeoff`.
    points
        Bounds of the first, and steps of the curve at each: neighbours are no further apart than such a step.
    thorough
        Whatever the work.
    progress
        Called now and then with a stage and the part that is done.

    Notes
    -----
    The first bound goes from the tightest at which a design exists, the second loosened, to the loosest at which it
    still holds the goal back, the second loosened or at its own tightest.

    Raises
    ------
    InputError
        Not two, no goal, no such limit, or no design at any bound.
    """
    refuse_analysis(job)
    if len(against) != 2:
        raise InputError(f"{job.name}: --against is given {len(against)} times. A trade-off has one or two of them.")
    if not FEWEST <= points <= MOST:
        raise InputError(f"--points {points} is not between {FEWEST} and {MOST} for a trade-off of three quantities.")
    job, first = bounded(job, against[0])
    job, second = bounded(job, against[1])
    if first == second:
        raise InputError(f"{job.name}: --against {against[0]} is given twice. Name another limit, or leave one out.")
    facts = fact_at(job, first), fact_at(job, second)
    made, asked, gaps, short = [], 0, [0.0], False
    most = np.inf if thorough else MOST_WORK / (points + 3)  # three pairs of ends, then the curves
    values, spent = _values(job, facts, points, most, progress)
    for value in values:
        moved = MovedBound(_with(job, facts[0], value), facts[1], progress, most)
        curve = Front(moved, points)
        first_at = varied_at(facts[:1], np.array([value]))
        made += [replace(point, varied={**first_at, **point.varied}) for point in curve.points]
        gaps.append(curve.gap)
        asked += moved.asked
        short = short or moved.short
    sides = [MovedBound(job, fact) for fact in facts]
    kept = _undominated(sides, made)
    reached = tuple((_as(sides[0], point), _as(sides[1], point)) for point in kept)
    return Surface(job, facts, tuple(kept), reached, goal_word(job), max(gaps), asked + spent, short)


def _with(job: Job, fact: FactAt, value: float) -> Job:
    return with_changes(job, dict(fact.changes(value)))


def _values(
    job: Job, facts: tuple[FactAt, FactAt], count: int, most: float, progress: Progress | None
) -> tuple[list[float], int]:
    """Bounds of the first limit [SI], the tightest first, by ratios over more than a factor 100; answers it took."""
    asked = 0

    def ends(moved: FactAt, held: FactAt, at: float) -> tuple[float, float]:
        nonlocal asked
        bound = MovedBound(_with(job, held, at), moved, progress, most)
        tight, loose, _ = bound.ends()
        asked += bound.asked
        return bound.value(tight), bound.value(loose)

    def loosened(fact: FactAt) -> float:
        return fact.value / FAR if fact.path.endswith(".at_least") else fact.value * FAR

    first, second = facts
    tight, loose = ends(first, second, loosened(second))
    tightest, _ = ends(second, first, loosened(first))
    _, looser = ends(first, second, tightest)
    loose = min(loose, looser) if first.path.endswith(".at_least") else max(loose, looser)
    if tight == loose:
        raise InputError(f"{job.name}: {first.path} and the goal are best in one and the same design: leave it out.")
    spaced = np.geomspace if max(tight, loose) > RATIO * min(tight, loose) else np.linspace
    return [tight, *map(float, spaced(tight, loose, count)[1:-1]), loose], asked


def _undominated(sides: Sequence[MovedBound], points: Sequence[Point]) -> list[Point]:
    """Those that no other betters in all three quantities, in their order; of what is one to 1e-6 the first."""
    losses = np.array([[*(side.loss(point) for side in sides), sides[0].cost(point)] for point in points])
    room, kept = CLOSE * np.abs(losses), list[int]()
    for k in sorted(range(len(points)), key=lambda k: tuple(losses[k])):
        if not any((losses[j] <= losses[k] + room[k]).all() for j in kept):
            kept.append(k)
    return [points[k] for k in sorted(kept)]


def _as(side: MovedBound, point: Point) -> Entry:
    return replace(point.varied[side.fact.path], value=side.reached(point))
