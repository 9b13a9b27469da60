"""Readings from a CSV file, as a spreadsheet exports it: semicolon or comma, decimal comma, byte-order mark.

One row a run.  Columns: run, speed [rpm], stayed; per plane "left" (text such as 10 g @ 270 deg) or the two columns
"left mass [g]" (or "left unbalance [g mm]") and "left angle [deg]"; per sensor "a" (text) or the two columns
"a amplitude [mil pp]" and "a angle [deg]".
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Any

from vibopt.errors import InputError, way_out
from vibopt.scene.mistakes import Mistakes, Path, toml_text
from vibopt.values.sheet import letter, sheet_of

_HEADER = re.compile(
    r"(?P<name>.*?)(?:\s+(?P<what>mass|weight|unbalance|amplitude|angle|phase))?\s*(?:[\[(](?P<unit>[^\])]*)[\])])?",
    re.I,
)
_YES, _NO = ("yes", "true", "1", "x", "ja", "oui"), ("no", "false", "0", "-", "nein", "non")
_AMOUNTS = {"mass", "weight", "unbalance", "amplitude"}


@dataclass
class CsvMistakes(Mistakes):
    """Mistakes of a CSV file, said with row and column.

    places
        By path of a value as [[runs]] would have it: its row (from 1, as the spreadsheet counts) and column heading.
    """

    places: dict[Path, tuple[int, str]] = field(default_factory=dict)

    def place(self, path: Path) -> tuple[int, str]:
        """Row and words of the nearest place known."""
        for length in range(len(path), 0, -1):
            if path[:length] in self.places:
                return self.places[path[:length]]
        return 0, ""

    def at(self, path: Path) -> str:
        row, column = self.place(path)
        return f"{self.name} row {row}{column}" if row else self.name

    def add(self, path: Path, sentence: str) -> None:
        row = self.place(path)[0]
        message = f"{self.at(path)}: {sentence}"
        if (row, message) not in self.found:
            self.found.append((row, message))

    def value(self, path: Path, given: object, text: str) -> None:
        self.add(path, f"{toml_text(given)} {text}")


@dataclass(frozen=True, slots=True)
class Column:
    """One column: its heading and letter, whose it is ("run", "speed", a plane, a sensor), what of it, and its unit."""

    heading: str
    letter: str
    name: str
    what: str
    unit: str


def read_csv(
    file: FilePath, planes: Iterable[str], sensors: Iterable[str], outer: Mistakes
) -> tuple[list[dict[str, Any]], CsvMistakes]:
    """Rows as [[runs]] tables, with the places of their values; what is wrong with the file itself goes to `outer`."""
    mistakes = CsvMistakes(file.name)
    try:
        rows = _rows(file)
    except InputError as error:
        outer.add(("readings",), str(error))
        return [], mistakes
    if not rows:
        outer.add(("readings",), f"{file.name} is empty. Its first row names the columns: run, speed [rpm], ...")
        return [], mistakes
    (header_row, header), *body = rows
    columns = _columns(header, header_row, list(planes), list(sensors) or _sensors_of(header), mistakes)
    runs = [_run(index, row, cells, columns, mistakes) for index, (row, cells) in enumerate(body)]
    if not body:
        outer.add(("readings",), f"{file.name} has no run below its heading. Add one row a run.")
    return runs, mistakes


def _sensors_of(header: list[str]) -> list[str]:
    """Sensors that the heading itself tells, by their "a amplitude [mil pp]"."""
    columns = [_column(heading, "") for heading in header]
    return [column.name for column in columns if column.what == "amplitude"]


def _rows(file: FilePath) -> list[tuple[int, list[str]]]:
    """Rows that are not empty, with their number in the sheet; decimal commas are points."""
    sheet = sheet_of(file)
    return [(number, [sheet.number(cell) for cell in cells]) for number, cells in sheet.rows]


def _columns(
    header: list[str], row: int, planes: list[str], sensors: list[str], mistakes: CsvMistakes
) -> list[Column | None]:
    columns: list[Column | None] = []
    known = ["run", "speed [rpm]", "stayed", *planes, *sensors]
    for index, heading in enumerate(header):
        column = _column(heading, letter(index))
        name = column.name
        if name.lower() in ("run", "name", "speed", "stayed"):
            columns.append(Column(heading, column.letter, name.lower().replace("name", "run"), "", column.unit))
        elif name in planes or name in sensors:
            columns.append(column)
        else:
            columns.append(None)
            mistakes.places[("header", index)] = (row, f", column {column.letter}")
            if heading:
                mistakes.value(
                    ("header", index), heading, f"names no plane and no sensor of this job.{way_out(name, known)}"
                )
    if not any(column is not None and column.name in sensors for column in columns):
        mistakes.places[("header",)] = (row, "")
        mistakes.add(
            ("header",), f'no column holds a sensor. Write for example "{(sensors or ["a"])[0]} amplitude [mil pp]".'
        )
    return columns


def _column(heading: str, letter: str) -> Column:
    found = _HEADER.fullmatch(heading.strip())
    if not found:
        return Column(heading, letter, heading, "", "")
    what = (found["what"] or "").lower().replace("phase", "angle")
    return Column(heading, letter, found["name"].strip(), what, (found["unit"] or "").strip())


def _run(index: int, row: int, cells: list[str], columns: list[Column | None], mistakes: CsvMistakes) -> dict[str, Any]:
    """One row as a [[runs]] table."""
    run: dict[str, Any] = {}
    parts: dict[str, dict[str, str]] = {}
    mistakes.places[("runs", index)] = (row, "")
    for cell, column in zip(cells, columns, strict=False):
        if column is None or not cell.strip("-–—"):
            continue
        place = (row, f', column {column.letter} ("{column.heading}")')
        if column.name in ("run", "speed", "stayed"):
            key = "name" if column.name == "run" else column.name
            run[key] = _own(column, cell)
            mistakes.places[("runs", index, key)] = place
            continue
        part = "angle" if column.what == "angle" else "amount"
        bare = (part == "amount" and column.what in _AMOUNTS) or part == "angle"
        parts.setdefault(column.name, {})[part] = f"{cell} {column.unit}".strip() if bare else cell
        for family in ("weights", "readings"):
            mistakes.places.setdefault(("runs", index, family, column.name), place)
    run["_values"] = {name: _together(part) for name, part in parts.items()}
    if len(cells) > len(columns) and any(cells[len(columns) :]):
        mistakes.add(("runs", index), f"has {len(cells)} cells, but the heading names {len(columns)} columns.")
    return run


def _own(column: Column, cell: str) -> Any:
    if column.name == "stayed":
        return {**dict.fromkeys(_YES, True), **dict.fromkeys(_NO, False)}.get(cell.lower(), cell)
    if column.name == "speed":
        return cell if re.search("[A-Za-z]", cell) else f"{cell} {column.unit}".strip()
    return cell


def _together(part: dict[str, str]) -> str:
    """Amount and angle as one text."""
    amount = part.get("amount", "")
    return f"{amount} @ {part['angle']}" if "angle" in part and "@" not in amount else amount
