"""Points of a sweep, held as columns of numbers; each is put into words when it is looked at."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import field
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from vibopt.answer.entry import TOLERANCE, Entry, Word
from vibopt.answer.jsonable import number
from vibopt.arrays import FloatArray
from vibopt.jobs import is_scene
from vibopt.records import dataclass
from vibopt.study.freeze import shown_values
from vibopt.study.seen import GOOD, NOTHING, chosen, entries_of, goal_of, measured_goal, results, shown_value
from vibopt.study.varied import DECIBEL
from vibopt.units import to_unit
from vibopt.values.fact_at import FactAt
from vibopt.verify.checked import in_usual_unit

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer
    from vibopt.jobs import Job


@dataclass(frozen=True, slots=True)
class Point:
    """Answer at one value of each varied fact; `margins` by limit name, the rest by path.

    `parts` are words that were chosen; `results` is what a balancing job measures beside its limits, or a
    scene without any; of a scene that is judged the worst values of its limits, and `goal` what was made best.
    """

    varied: Mapping[str, Entry]
    status: str
    goal: Entry | None
    variables: Mapping[str, Entry]
    margins: Mapping[str, float]
    parts: Mapping[str, str] = field(default_factory=dict)
    results: Mapping[str, Entry] = field(default_factory=dict)

    @property
    def value(self) -> Entry:
        """Of the fact; of several, of the first."""
        return next(iter(self.varied.values()))

    @property
    def good(self) -> bool:
        """Whether there is a design, or the limits of what is there hold."""
        return self.status in GOOD

    @property
    def broken(self) -> tuple[str, ...]:
        """Limits that do not hold, or of which too few machines were drawn; none of a good answer."""
        return () if self.good else tuple(name for name, margin in self.margins.items() if margin < -TOLERANCE)

    def to_json(self) -> dict[str, Any]:
        """The value of one fact, or those of several by path, then the answer there."""
        keys = ("status", "goal", "variables", "margins", "parts", "results")
        where = {"value": self.value} if len(self.varied) == 1 else {"values": self.varied}
        return {**where, **{key: getattr(self, key) for key in keys}}


Words = Callable[[int], tuple[Entry | None, Mapping[str, Entry], Mapping[str, Entry]]]


@dataclass(frozen=True)
class Columns:
    """Answers found together; a status "" means that this one was not.

    x
        Designs in the order of the scene's variables, shape (n_vars, n_points) [SI]; nan where there is none.
    goal
        Value of the goal on the built machine, shape (n_points,); None without a goal.
    margins
        Per limit, shape (n_points,).
    words
        Goal, chosen numbers and results of a point by its index, where the job is no scene.
    held
        Limits and caps, these by path, that hold the goal back at a point by its index, where the job is no scene.
    """

    status: list[str]
    x: FloatArray
    goal: FloatArray | None
    margins: Mapping[str, FloatArray]
    words: Words | None = None
    held: Callable[[int], set[str]] | None = None


@dataclass(frozen=True)
class Points(Sequence[Point]):
    """A sequence of `Point`.

    values
        Of the facts [SI], shape (n_points, n_facts).
    single
        Points that were answered one by one, by index; they come before the columns.
    """

    job: Job
    facts: tuple[FactAt, ...]
    values: FloatArray
    columns: Columns
    single: dict[int, Point] = field(default_factory=dict)

    @property
    def statuses(self) -> list[str]:
        """Status of every point."""
        found = list(self.columns.status)
        for index, point in self.single.items():
            found[index] = point.status
        return found

    def __len__(self) -> int:
        return len(self.values)

    @overload
    def __getitem__(self, index: int) -> Point: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Point, ...]: ...
    def __getitem__(self, index: int | slice) -> Point | tuple[Point, ...]:
        if isinstance(index, slice):
            return tuple(self._point(one) for one in range(*index.indices(len(self))))
        if not -len(self) <= index < len(self):
            raise IndexError(index)
        return self._point(index % len(self))

    def __iter__(self) -> Iterator[Point]:
        return (self._point(index) for index in range(len(self)))

    def tolist(self) -> list[Point]:
        """All points."""
        return list(self)

    def _point(self, index: int) -> Point:
        if index in self.single:
            return self.single[index]
        columns, scene = self.columns, self.job
        found = columns.status[index] != "infeasible"
        margins = {name: float(margin[index]) for name, margin in columns.margins.items() if found}
        where, status = varied_at(self.facts, self.values[index]), columns.status[index]
        if columns.words is not None:
            best, chosen, left = columns.words(index) if found else (None, {}, {})
            return Point(where, status, best, chosen, margins, results=left)
        assert is_scene(scene)
        goal = None
        if found and columns.goal is not None and scene.goal is not None:
            goal = in_usual_unit(scene, scene.goal.response, float(columns.goal[index]))
        return Point(where, status, goal, shown_values(scene, columns.x[:, index]) if found else {}, margins)


def varied_at(facts: Sequence[FactAt], values: FloatArray) -> dict[str, Entry]:
    """Values (n_facts,) of the varied facts [SI], by path."""
    return {fact.path: shown_value(fact, float(value)) for fact, value in zip(facts, values, strict=True)}


def in_unit(values: FloatArray, unit: str, dimension: str) -> FloatArray:
    """Numbers of `unit` in values [SI] of any shape; nan where a ratio that is not positive has no dB."""
    if unit != DECIBEL:
        return values * to_unit(1.0, unit, dimension)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(values > 0.0, np.round(20.0 * np.log10(values), 12), np.nan)


def point_of(facts: Sequence[FactAt], values: FloatArray, job: Job, answer: Answer[Any]) -> Point:
    """The point that one answer makes."""
    entries = {} if is_scene(job) else entries_of(job, answer)
    taken = chosen(job, answer, entries)
    return Point(
        varied=varied_at(facts, values),
        status=answer.status,
        goal=_goal(job, answer),
        variables={path: one for path, one in taken.items() if isinstance(one, Entry)},
        margins={name: limit.margin for name, limit in answer.limits.items() if answer.status not in NOTHING},
        parts={path: one.value for path, one in taken.items() if isinstance(one, Word)},
        results=_worst(answer) if is_judged(job) else results(job, answer, entries),
    )


def is_judged(job: Job) -> bool:
    """Whether nothing of a scene is left to choose, and limits are measured."""
    return is_scene(job) and job.is_analysis and bool(job.limits)


def _goal(job: Job, answer: Answer[Any]) -> Entry | None:
    row = answer.measures.get(measured_goal(job))
    return goal_of(job, answer) if row is None else row.value


def _worst(answer: Answer[Any]) -> dict[str, Entry]:
    """The worst value of each limit."""
    return {f"limits.{name}": row.value for name, row in answer.limits.items()}


class Heads:
    """The columns that some points need: numbers in SI or dB, units in the head; margins as parts of the bound.

    Parameters
    ----------
    facts
        What is varied, in the units of their ranges.
    job, goal
        What is swept, and the name of its goal in the sweep, "" for none.
    points
        At least one.
    """

    def __init__(self, facts: Sequence[FactAt], job: Job, goal: str, points: Sequence[Point]) -> None:
        self.facts = facts
        self.units = {path: variable.si for point in points for path, variable in point.variables.items()}
        self.names = list(dict.fromkeys(name for point in points for name in point.margins))
        self.parts = list(dict.fromkeys(path for point in points for path in point.parts))
        self.goal = next((point.goal for point in points if point.goal is not None), None)
        asked = job.goal.response if is_scene(job) and job.goal is not None else None
        self.goal_unit = _unit((asked.unit if asked else "") or "", self.goal.si) if self.goal is not None else ""
        goals = [_head(goal or "goal", self.goal_unit)] if self.goal is not None else []
        where = [_head(fact.path, _unit(fact.unit, points[0].varied[fact.path].si)) for fact in facts]
        self.heads = [*where, "status", *goals, *self.parts]
        self.heads += [_head(path, unit) for path, unit in self.units.items()]
        self.heads += [f"margin of {name}" for name in self.names]
        self.results = {path: result.si for point in points for path, result in point.results.items()}
        self.heads += [_head(path, unit) for path, unit in self.results.items()]

    def row(self, point: Point) -> list[float | str | None]:
        """The cells of a point."""
        goals = [] if self.goal is None else ["" if point.goal is None else _number(point.goal, self.goal_unit)]
        chosen = ["" if path not in point.variables else number(point.variables[path].value) for path in self.units]
        margins = ["" if name not in point.margins else number(point.margins[name]) for name in self.names]
        bought = [point.parts.get(path, "") for path in self.parts]
        left = ["" if path not in point.results else number(point.results[path].value) for path in self.results]
        where = [_number(point.varied[fact.path], fact.unit) for fact in self.facts]
        return [*where, point.status, *goals, *bought, *chosen, *margins, *left]

    def table(self, points: Iterable[Point]) -> list[dict[str, Any]]:
        """A row by its heads for each point, None where there is nothing."""
        rows = (zip(self.heads, self.row(point), strict=True) for point in points)
        return [{head: None if one == "" else one for head, one in row} for row in rows]

    def lack(self, point: Point) -> bool:
        """Whether a point needs a column that is not there."""
        known = {*self.units, *self.names, *self.parts, *self.results}
        return not known >= {*point.variables, *point.margins, *point.parts, *point.results} or (
            self.goal is None and point.goal is not None
        )


def _unit(users: str, si: str) -> str:
    """Unit of a column: SI, but dB where the user counts in dB."""
    return users if users == "dB" else si


def _number(shown: Entry, unit: str) -> float | str | None:
    if unit != "dB":
        return number(shown.value)
    return number(round(to_unit(shown.value, unit, "ratio"), 12)) if shown.value > 0.0 else None


def _head(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name
