"""The table of a sweep as comma-separated values, whole or growing point by point."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING

from vibopt.files.writing import add_line, is_stream, write_file
from vibopt.jobs import is_scene

if TYPE_CHECKING:
    from vibopt.answer.entry import Entry
    from vibopt.jobs import Job
    from vibopt.study.sweep import Point, Sweep
    from vibopt.values.fact_at import FactAt


class Columns:
    """The columns that some points need: numbers in SI or dB, units in the head; margins as parts of the bound.

    Parameters
    ----------
    fact
        What is varied, in the unit of its range.
    job, goal
        What is swept, and the name of its goal in the sweep, "" for none.
    points
        At least one.
    """

    def __init__(self, fact: FactAt, job: Job, goal: str, points: Sequence[Point]) -> None:
        self.fact = fact
        self.units = {path: one.si for point in points for path, one in point.variables.items()}
        self.names = list(dict.fromkeys(name for point in points for name in point.margins))
        self.parts = list(dict.fromkeys(path for point in points for path in point.parts))
        self.goal = next((point.goal for point in points if point.goal is not None), None)
        asked = job.goal.response if is_scene(job) and job.goal is not None else None
        self.goal_unit = _unit((asked.unit if asked else "") or "", self.goal.si) if self.goal is not None else ""
        goals = [_head(goal or "goal", self.goal_unit)] if self.goal is not None else []
        self.heads = [_head(fact.path, _unit(fact.unit, points[0].value.si)), "status", *goals, *self.parts]
        self.heads += [_head(path, unit) for path, unit in self.units.items()]
        self.heads += [f"margin of {name}" for name in self.names]
        self.results = {path: one.si for point in points for path, one in point.results.items()}
        self.heads += [_head(path, unit) for path, unit in self.results.items()]

    def row(self, point: Point) -> list[float | str | None]:
        """The cells of a point."""
        from vibopt.answer.jsonable import number

        goals = [] if self.goal is None else ["" if point.goal is None else _number(point.goal, self.goal_unit)]
        chosen = ["" if path not in point.variables else number(point.variables[path].value) for path in self.units]
        margins = ["" if name not in point.margins else number(point.margins[name]) for name in self.names]
        bought = [point.parts.get(path, "") for path in self.parts]
        left = ["" if path not in point.results else number(point.results[path].value) for path in self.results]
        return [_number(point.value, self.fact.unit), point.status, *goals, *bought, *chosen, *margins, *left]

    def lack(self, point: Point) -> bool:
        """Whether a point needs a column that is not there."""
        known = {*self.units, *self.names, *self.parts, *self.results}
        return not known >= {*point.variables, *point.margins, *point.parts, *point.results} or (
            self.goal is None and point.goal is not None
        )


class GrowingTable:
    """A file that holds every point of a sweep that is known so far, in the order in which they came.

    Parameters
    ----------
    target
        The file; it is written with the first point.
    job, goal
        As of `Columns`.
    """

    def __init__(self, target: Path, job: Job, goal: str) -> None:
        self.target, self.job, self.goal = target, job, goal
        self.points: list[Point] = []
        self._columns: Columns | None = None

    def add(self, fact: FactAt, point: Point) -> None:
        """One more point, on the disk when this returns."""
        self.points.append(point)
        if is_stream(self.target):
            return
        if self._columns is None or self._columns.lack(point):
            self._columns = Columns(fact, self.job, self.goal, self.points)
            write_file(self.target, _text(self._columns, self.points).encode())
        else:
            add_line(self.target, _lines([self._columns.row(point)]))


def csv_text(result: Sweep) -> str:
    """All points of a sweep in rising order of the fact."""
    points = list(result.points)
    return _text(Columns(result.fact, result.job, result.goal, points), points)


def _text(columns: Columns, points: Sequence[Point]) -> str:
    return _lines([columns.heads, *(columns.row(point) for point in points)])


def _lines(rows: Iterable[Sequence[object]]) -> str:
    stream = StringIO()
    csv.writer(stream, lineterminator="\n").writerows(rows)
    return stream.getvalue()


def _unit(users: str, si: str) -> str:
    """Unit of a column: SI, but dB where the user counts in dB."""
    return users if users == "dB" else si


def _number(shown: Entry, unit: str) -> float | str | None:
    from vibopt.answer.jsonable import number
    from vibopt.units import to_unit

    if unit != "dB":
        return number(shown.value)
    return number(round(to_unit(shown.value, unit, "ratio"), 12)) if shown.value > 0.0 else None


def _head(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


__all__ = ["Columns", "GrowingTable", "csv_text"]
