"""The table of a sweep as comma-separated values, whole or growing point by point."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import astuple
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibopt.answer.entry import Entry
from vibopt.errors import InputError
from vibopt.files.journal import Journal
from vibopt.files.reading import shown_name
from vibopt.files.writing import add_line, checked_target, is_stream, write_file
from vibopt.study.points import Heads

if TYPE_CHECKING:
    from vibopt.answer.tabular import Tabular
    from vibopt.jobs import Job
    from vibopt.study.points import Point
    from vibopt.study.sweep import Sweep
    from vibopt.values.fact_at import FactAt

TABLES, FORMATS = (".csv", ".txt"), (".svg", ".png", ".pdf")


class GrowingTable:
    """A file that holds every point of a sweep that is known so far, in the order in which they came.

    Parameters
    ----------
    target
        The file; it is written with the first point.
    job, goal
        As of `Heads`.
    journal
        Where every point is kept as it is too.
    points
        Those that are known from before.
    """

    def __init__(
        self, target: Path, job: Job, goal: str, journal: Journal[Point] | None, points: Sequence[Point]
    ) -> None:
        self.target, self.job, self.goal, self.journal = target, job, goal, journal
        self.points: list[Point] = [*points]
        self._columns: Heads | None = None

    def add(self, facts: Sequence[FactAt], point: Point) -> None:
        """One more point, on the disk when this returns."""
        self.points.append(point)
        if is_stream(self.target):
            return
        if self.journal is not None:
            self.journal.add(point)
        if self._columns is None or self._columns.lack(point):
            self._columns = Heads(facts, self.job, self.goal, self.points)
            write_file(self.target, _text(self._columns, self.points).encode())
        else:
            add_line(self.target, rows_text([self._columns.row(point)]))


def journal_of(table: Path, key: str) -> Journal[Point]:
    """The points of a sweep, as they are, in a file beside its table."""
    return Journal(
        table.with_name(f"{table.name}.points"), "sweep", key, others="another problem, other ranges", option="--csv",
        told=_told, made=_point_of,
    )  # fmt: skip


_ENTRIES, _PLAIN = ("varied", "variables", "results"), ("status", "margins", "parts")


def _told(point: Point) -> dict[str, Any]:
    """A point as plain data, exactly."""
    told = {key: {path: astuple(one) for path, one in getattr(point, key).items()} for key in _ENTRIES}
    goal = None if point.goal is None else astuple(point.goal)
    return {**told, "goal": goal, **{key: getattr(point, key) for key in _PLAIN}}


def _point_of(told: Mapping[str, Any]) -> Point:
    from vibopt.study.points import Point

    numbers: dict[str, Any] = {key: {path: Entry(*one) for path, one in told[key].items()} for key in _ENTRIES}
    goal = None if told["goal"] is None else Entry(*told["goal"])
    return Point(**numbers, goal=goal, **{key: told[key] for key in _PLAIN})


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


def table_text(study: Tabular) -> str:
    """The rows of a study under their heads, as comma-separated values."""
    rows = study.table()
    return rows_text([list(rows[0]), *(list(row.values()) for row in rows)])


def targets(csv_file: str | None, figure: str | None, *, force: tuple[bool, bool]) -> tuple[Path | None, Path | None]:
    """Where a table and a figure will be written, each over another's file only by `force`; InputError where in one."""
    table = checked_target(csv_file, TABLES, force=force[0]) if csv_file is not None else None
    picture = checked_target(figure, FORMATS, force=force[1]) if figure is not None else None
    if table is not None and picture is not None and table.resolve() == picture.resolve():
        raise InputError(f"--csv and --figure name one file, {shown_name(table)}. Name two.")
    return table, picture
