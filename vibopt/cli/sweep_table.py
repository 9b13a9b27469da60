"""The table of a sweep as comma-separated values, whole or growing point by point."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING

from vibopt.files.writing import add_line, is_stream, write_file
from vibopt.study.points import Heads

if TYPE_CHECKING:
    from vibopt.jobs import Job
    from vibopt.study.sweep import Point, Sweep
    from vibopt.values.fact_at import FactAt


class GrowingTable:
    """A file that holds every point of a sweep that is known so far, in the order in which they came.

    Parameters
    ----------
    target
        The file; it is written with the first point.
    job, goal
        As of `Heads`.
    """

    def __init__(self, target: Path, job: Job, goal: str) -> None:
        self.target, self.job, self.goal = target, job, goal
        self.points: list[Point] = []
        self._columns: Heads | None = None

    def add(self, facts: Sequence[FactAt], point: Point) -> None:
        """One more point, on the disk when this returns."""
        self.points.append(point)
        if is_stream(self.target):
            return
        if self._columns is None or self._columns.lack(point):
            self._columns = Heads(facts, self.job, self.goal, self.points)
            write_file(self.target, _text(self._columns, self.points).encode())
        else:
            add_line(self.target, rows_text([self._columns.row(point)]))


def csv_text(result: Sweep) -> str:
    """All points of a sweep, those of a grid in rising order of the facts, the first slowest."""
    points = list(result.points)
    return _text(Heads(result.facts, result.job, result.goal, points), points)


def _text(columns: Heads, points: Sequence[Point]) -> str:
    return rows_text([columns.heads, *(columns.row(point) for point in points)])


def rows_text(rows: Iterable[Sequence[object]]) -> str:
    """Rows as comma-separated values."""
    stream = StringIO()
    csv.writer(stream, lineterminator="\n").writerows(rows)
    return stream.getvalue()


__all__ = ["GrowingTable", "csv_text", "rows_text"]
