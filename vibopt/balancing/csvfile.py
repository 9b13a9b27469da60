"""Readings from a CSV file, as a spreadsheet exports it: semicolon or comma, decimal comma, byte-order mark.

One row a run.  Columns: run, speed [rpm], stayed; per plane "left" (text such as 10 g @ 270 deg) or the two columns
"left mass [g]" (or "left unbalance [g mm]") and "left angle [deg]"; per sensor "a" (text) or the two columns
"a amplitude [mil pp]" and "a angle [deg]".
"""

from __future__ import annotations

import re
from collections.abc import Callable, Container, Iterable, Sequence
from operator import itemgetter
from pathlib import Path as FilePath
from typing import Any

from vibopt.balancing.csvrows import OWN, THOUSANDS, Cells, Column, CsvMistakes, Plain, Row, run_of
from vibopt.document.mistakes import Mistakes
from vibopt.errors import InputError, way_out
from vibopt.values.csv_tables import Sheet, heading_of, sheet_of

_WHATS = ("mass", "weight", "unbalance", "amplitude", "angle", "phase")
"""Words behind the name of a plane or a sensor that say what a column holds of it."""
_ANGLES = {"phase": "angle"}
_HEADING = re.compile(rf"([^\s\[\]()]+) ({'|'.join(_WHATS)}) \[([^\s\[\]()]+(?: [^\s\[\]()]+)*)\]")
"""Name, what and unit of most columns."""
_POINT = re.compile(r"\d\.\d")
_COMMA = re.compile(r"\d,\d")


def read_csv(
    file: FilePath, planes: Iterable[str], sensors: Iterable[str], outer: Mistakes
) -> tuple[list[dict[str, Any]], CsvMistakes]:
    """Rows as [[runs]] tables, with the places of their values; what is wrong with the file itself goes to `outer`."""
    mistakes = CsvMistakes(file.name)
    try:
        sheet = sheet_of(file)
    except InputError as error:
        outer.add(("readings",), str(error))
        return [], mistakes
    if not sheet.rows:
        outer.add(("readings",), f"{file.name} is empty. Its first row names the columns: run, speed [rpm], ...")
        return [], mistakes
    (header_row, header), *body = sheet.rows
    own, parts = list(planes), [_column(heading, index) for index, heading in enumerate(header)]
    names = list(sensors) or [column.name for column in parts if column.what == "amplitude"]
    columns = _columns(parts, header_row, own, names, mistakes)
    _check_parts(columns, header_row, own, mistakes)
    if mistakes.found:
        return [], mistakes
    said = Cells(columns, own, sheet, _parts_thousands(sheet), _plain(columns, names, mistakes))
    readings = said.readings([cells for _, cells in body])
    runs = [
        run_of(index, row, cells, own, said, mistakes)
        for index, ((row, cells), own) in enumerate(zip(body, readings, strict=True))
    ]
    if not body:
        outer.add(("readings",), f"{file.name} has no run below its heading. Add one row a run.")
    return runs, mistakes


def _plain(columns: Sequence[Column | None], sensors: Sequence[str], mistakes: CsvMistakes) -> Plain | None:
    """How rows of numbers are read in one piece: every sensor has a column for its size and one for its angle."""
    at = {(one.name, one.what): index for index, one in enumerate(columns) if one is not None}
    sizes, angles = ([at.get((name, what), -1) for name in sensors] for what in ("amplitude", "angle"))
    if -1 in sizes or -1 in angles or not sensors:
        return None
    units, turns = (tuple(one.unit for one in map(columns.__getitem__, own) if one) for own in (sizes, angles))
    firsts = [columns[min(both)] for both in zip(sizes, angles, strict=True)]
    mistakes.columns.update((name, one) for name, one in zip(sensors, firsts, strict=True) if one is not None)
    taken = {*sizes, *angles}
    others = [index for index in range(len(columns)) if index not in taken]
    rest = tuple(columns[index] for index in others)
    return Plain(tuple(sensors), units, turns, _cells_at(sizes), _cells_at(angles), _cells_at(others), rest)


def _cells_at(places: Sequence[int]) -> Callable[[Row], tuple[str, ...]]:
    """The cells of a row at some places, in this order."""
    if len(places) < 2:
        return lambda row: tuple(row[place] for place in places)
    return itemgetter(*places)


def _columns(
    parts: Sequence[Column], row: int, planes: list[str], sensors: list[str], mistakes: CsvMistakes
) -> list[Column | None]:
    known, named = ["run", "speed [rpm]", "stayed", "verification", *planes, *sensors], {*planes, *sensors}
    columns = [_known_column(part, named) for part in parts]
    for index, (part, column) in enumerate(zip(parts, columns, strict=True)):
        if column is None and part.heading and any(columns) and not mistakes.full:  # of another file nothing is shown
            name = heading_of(part.heading)[0]
            mistakes.places[("header", index)] = (row, Column("", index, "", "", ""))
            mistakes.value(
                ("header", index), part.heading, f"names no plane and no sensor of this job.{way_out(name, known)}"
            )
    if not any(column is not None and column.name in sensors for column in columns):
        mistakes.places[("header",)] = (row, None)
        mistakes.add(
            ("header",), f'no column holds a sensor. Write for example "{(sensors or ["a"])[0]} amplitude [mil pp]".'
        )
    return columns


def _known_column(column: Column, named: Container[str]) -> Column | None:
    """A column of the run itself, of a plane or of a sensor; None where the heading names none."""
    own = column.name.lower()
    if own in (*OWN, "name"):
        return Column(column.heading, column.index, own.replace("name", "run"), "", column.unit)
    return column if column.name in named else None


def _check_parts(columns: Sequence[Column | None], row: int, planes: Sequence[str], mistakes: CsvMistakes) -> None:
    """Each column holds something of its own, and no angle stands without its amount."""
    first: dict[tuple[str, str], Column] = {}
    mistakes.places[("header",)] = (row, None)
    for column in columns:
        if column is None:
            continue
        other = first.setdefault((column.name, column.part), column)
        if other is not column:
            what = "the angle of " if column.part == "angle" else "" if column.name in OWN else "the size of "
            mistakes.add(
                ("header",),
                f"{other.place} and {column.place} both hold {what}{column.name}. Keep one, or rename the other.",
            )
    for (name, part), column in first.items():
        if part == "angle" and (name, "amount") not in first:
            heading = f"{name} mass [g]" if name in planes else f"{name} amplitude [mil pp]"
            mistakes.add(("header",), f'{column.place} has no column beside it for the size. Add one, "{heading}".')


def _parts_thousands(sheet: Sheet) -> tuple[bool, bool]:
    """Whether a point in "1.200" may part thousands: in the speeds, in the other numbers.

    Where commas part the columns a point is the decimal sign.  Elsewhere a decimal comma anywhere leaves it open, and a
    point that cannot part thousands ("8.6") settles it.  With neither, only a speed is asked about.
    """
    if not sheet.comma:
        return False, False
    cells = "\n".join("\n".join(row) for _, row in sheet.rows[1:])
    commas = _COMMA.search(cells) is not None
    points = _POINT.search(THOUSANDS.sub("", cells)) is not None
    return commas or not points, commas


def _column(heading: str, index: int) -> Column:
    plain = _HEADING.fullmatch(heading)
    if plain is not None:
        return Column(heading, index, plain[1], _ANGLES.get(plain[2], plain[2]), plain[3])
    name, unit = heading_of(heading)
    front, last = name.rsplit(None, 1) if len(name.split(None, 1)) == 2 else (name, "")
    what = last.lower()
    if what not in _WHATS:
        return Column(heading, index, name, "", unit)
    return Column(heading, index, front, _ANGLES.get(what, what), unit)
