"""Points of a sweep, held as columns of numbers; each is put into words when it is looked at."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from vibopt.answer.entry import Entry, Word
from vibopt.arrays import FloatArray
from vibopt.jobs import is_scene
from vibopt.records import dataclass
from vibopt.study.seen import chosen, goal_of, results
from vibopt.units import to_unit
from vibopt.values.fact_at import FactAt

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer
    from vibopt.jobs import Job

DECIBEL = "dB"


@dataclass(frozen=True, slots=True)
class Point:
    """Answer at one value of the varied fact; `margins` by limit name, the rest by path.

    `parts` are words that were chosen; `results` is what a balancing job measures beside its limits.
    """

    value: Entry
    status: str
    goal: Entry | None
    variables: Mapping[str, Entry]
    margins: Mapping[str, float]
    parts: Mapping[str, str] = field(default_factory=dict)
    results: Mapping[str, Entry] = field(default_factory=dict)


@dataclass(frozen=True)
class Columns:
    """Answers found together; a status "" means that this one was not.

    x
        Designs in the order of the scene's variables, shape (n_vars, n_points) [SI]; nan where there is none.
    goal
        Value of the goal on the built machine, shape (n_points,); None without a goal.
    margins
        Per limit, shape (n_points,).
    """

    status: list[str]
    x: FloatArray
    goal: FloatArray | None
    margins: Mapping[str, FloatArray]


@dataclass(frozen=True)
class Points(Sequence[Point]):
    """A sequence of `Point`.

    values
        Of the fact [SI], shape (n_points,).
    single
        Points that were answered one by one, by index; they come before the columns.
    """

    job: Job
    fact: FactAt
    values: FloatArray
    columns: Columns
    single: Mapping[int, Point] = field(default_factory=dict)

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
        assert is_scene(scene)
        found = columns.status[index] != "infeasible"
        goal = None
        if found and columns.goal is not None and scene.goal is not None:
            response = scene.goal.response
            dimension = response.dimension
            goal = Entry(
                float(columns.goal[index]),
                dimension,
                response.unit or "",
                amplitude=response.amplitude,
            )
        variables = {
            one.path: Entry(float(x[index]), one.dimension, one.unit)
            for one, x in zip(scene.variables, columns.x, strict=True)
            if found
        }
        margins = {name: float(one[index]) for name, one in columns.margins.items() if found}
        return Point(shown_value(self.fact, float(self.values[index])), columns.status[index], goal, variables, margins)


def shown_value(fact: FactAt, value: float) -> Entry:
    """A value of the varied fact."""
    return Entry(value, fact.dimension, fact.unit, amplitude=fact.amplitude)


def in_unit(values: FloatArray, unit: str, dimension: str) -> FloatArray:
    """Numbers of `unit` in values [SI] of any shape; nan where a ratio that is not positive has no dB."""
    if unit != DECIBEL:
        return values * to_unit(1.0, unit, dimension)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(values > 0.0, np.round(20.0 * np.log10(values), 12), np.nan)


def point_of(fact: FactAt, value: float, job: Job, found: Answer[Any]) -> Point:
    """The point that one answer makes."""
    entries = {} if is_scene(job) else found.entries()
    taken = chosen(job, found, entries)
    return Point(
        value=shown_value(fact, value),
        status=found.status,
        goal=goal_of(job, found),
        variables={path: one for path, one in taken.items() if isinstance(one, Entry)},
        margins={name: one.margin for name, one in found.limits.items()},
        parts={path: one.value for path, one in taken.items() if isinstance(one, Word)},
        results=results(job, found, entries),
    )
