"""Readings from a CSV file, as a spreadsheet exports it: semicolon or comma, decimal comma, byte-order mark.

One row a run.  Columns: run, speed [rpm], stayed; per plane "left" (text such as 10 g @ 270 deg) or the two columns
"left mass [g]" (or "left unbalance [g mm]") and "left angle [deg]"; per sensor "a" (text) or the two columns
"a amplitude [mil pp]" and "a angle [deg]".
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterable, Sequence
from pathlib import Path as FilePath
from typing import Any

from vibopt.balancing.csvrows import OWN, THOUSANDS, Cells, Column, CsvMistakes, run_of
from vibopt.errors import InputError, way_out
from vibopt.scene.mistakes import Mistakes
from vibopt.values.sheet import Sheet, heading_of, letter, sheet_of

_WHATS = ("mass", "weight", "unbalance", "amplitude", "angle", "phase")
"""Words behind the name of a plane or a sensor that say what a column holds of it."""
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
    own, names = list(planes), list(sensors) or _sensors_of(header)
    columns = _columns(header, header_row, own, names, mistakes)
    _check_parts(columns, header_row, own, mistakes)
    if mistakes.found:
        return [], mistakes
    said = Cells(columns, own, sheet, _parts_thousands(sheet))
    runs = [run_of(index, row, cells, said, mistakes) for index, (row, cells) in enumerate(body)]
    if not body:
        outer.add(("readings",), f"{file.name} has no run below its heading. Add one row a run.")
    return runs, mistakes


def _sensors_of(header: Sequence[str]) -> list[str]:
    """Sensors that the heading itself tells, by their "a amplitude [mil pp]"."""
    columns = [_column(heading, "") for heading in header]
    return [column.name for column in columns if column.what == "amplitude"]


def _columns(
    header: Sequence[str], row: int, planes: list[str], sensors: list[str], mistakes: CsvMistakes
) -> list[Column | None]:
    known, named = ["run", "speed [rpm]", "stayed", *planes, *sensors], {*planes, *sensors}
    columns = [_known_column(heading, letter(index), named) for index, heading in enumerate(header)]
    for index, (heading, column) in enumerate(zip(header, columns, strict=True)):
        if column is None and heading and any(columns) and not mistakes.full:  # of another file nothing is shown
            name = heading_of(heading)[0]
            mistakes.places[("header", index)] = (row, f", column {letter(index)}")
            mistakes.value(
                ("header", index), heading, f"names no plane and no sensor of this job.{way_out(name, known)}"
            )
    if not any(column is not None and column.name in sensors for column in columns):
        mistakes.places[("header",)] = (row, "")
        mistakes.add(
            ("header",), f'no column holds a sensor. Write for example "{(sensors or ["a"])[0]} amplitude [mil pp]".'
        )
    return columns


def _known_column(heading: str, letter: str, named: Container[str]) -> Column | None:
    """A column of the run itself, of a plane or of a sensor; None where the heading names none."""
    column = _column(heading, letter)
    own = column.name.lower()
    if own in (*OWN, "name"):
        return Column(heading, letter, own.replace("name", "run"), "", column.unit)
    return column if column.name in named else None


def _check_parts(columns: Sequence[Column | None], row: int, planes: Sequence[str], mistakes: CsvMistakes) -> None:
    """Each column holds something of its own, and no angle stands without its amount."""
    first: dict[tuple[str, str], Column] = {}
    mistakes.places[("header",)] = (row, "")
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
    cells = [cell for _, row in sheet.rows[1:] for cell in row]
    commas = any(_COMMA.search(cell) for cell in cells)
    points = any(_POINT.search(THOUSANDS.sub("", cell)) for cell in cells)
    return commas or not points, commas


def _column(heading: str, letter: str) -> Column:
    name, unit = heading_of(heading)
    front, last = name.rsplit(None, 1) if len(name.split(None, 1)) == 2 else (name, "")
    what = last.lower()
    if what not in _WHATS:
        return Column(heading, letter, name, "", unit)
    return Column(heading, letter, front, what.replace("phase", "angle"), unit)
