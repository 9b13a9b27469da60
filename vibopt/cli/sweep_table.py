"""The table of a sweep as comma-separated values, whole or growing point by point."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import astuple
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibopt.answer.entry import Entry
from vibopt.errors import InputError
from vibopt.files.reading import shown_name
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
    journal
        Where every point is kept as it is too.
    points
        Those that are known from before.
    """

    def __init__(self, target: Path, job: Job, goal: str, journal: Journal | None, points: Sequence[Point]) -> None:
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


class Journal:
    """Points of a sweep, as they are, in a file beside its table: with them a sweep that was stopped goes on.

    Parameters
    ----------
    table
        The file of the table.
    key
        What tells this sweep, of this content, by this program, from every other one.
    """

    def __init__(self, table: Path, key: str) -> None:
        self.target, self._head = table.with_name(f"{table.name}.points"), f"{_JOURNAL}{key}"
        self._points: list[Point] = []
        self._begun = False

    def take_up(self) -> list[Point]:
        """The points that are there; InputError where there are none, or they are those of another sweep."""
        shown = shown_name(self.target)
        lines = self._lines()
        if lines is None:
            raise InputError(f"--resume: there is no {shown} to go on with. Leave --resume out to begin.")
        if lines[0] != self._head:
            raise InputError(
                f"--resume: {shown} is of another problem, other ranges or another version of vibopt. Leave --resume "
                "out to begin anew."
            )
        try:
            self._points = [_point_of(json.loads(line)) for line in lines[1:]]
        except (ValueError, TypeError, KeyError, AttributeError):
            raise InputError(f"--resume: {shown} is damaged. Leave --resume out to begin anew.") from None
        return [*self._points]

    def check(self) -> None:
        """InputError where a file of somebody else has the name."""
        lines = self._lines()
        if lines is not None and not lines[0].startswith(_JOURNAL):
            raise InputError(
                f"{shown_name(self.target)} cannot be written: it is there already, and vibopt did not write it. Name "
                "another --csv."
            )

    def _lines(self) -> list[str] | None:
        """Whole lines; what a power cut has left of a last one is none.  None without a file."""
        try:
            text = self.target.read_text(encoding="utf-8")
        except FileNotFoundError:
            return None
        except (OSError, UnicodeDecodeError):
            return [""]
        return [*text.split("\n")[:-1]] or [""]

    def add(self, point: Point) -> None:
        """One more point, on the disk when this returns."""
        self._points.append(point)
        if self._begun:
            add_line(self.target, f"{json.dumps(_told(point))}\n")
        else:
            lines = [self._head, *(json.dumps(_told(one)) for one in self._points)]
            write_file(self.target, "".join(f"{line}\n" for line in lines).encode())
            self._begun = True

    def end(self) -> None:
        """The table is whole: away with it."""
        if self._points:
            self.target.unlink(missing_ok=True)


_JOURNAL = "vibopt sweep "
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


__all__ = ["GrowingTable", "Journal", "csv_text", "rows_text"]
