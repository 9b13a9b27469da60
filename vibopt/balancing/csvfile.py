"""Readings from a CSV file, as a spreadsheet exports it: semicolon or comma, decimal comma, byte-order mark.

One row a run.  Columns: run, speed [rpm], stayed; per plane "left" (text such as 10 g @ 270 deg) or the two columns
"left mass [g]" (or "left unbalance [g mm]") and "left angle [deg]"; per sensor "a" (text) or the two columns
"a amplitude [mil pp]" and "a angle [deg]".
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Any

from vibopt.errors import InputError, way_out
from vibopt.scene.mistakes import Mistakes, Path, toml_text

LARGEST = 5_000_000
_HEADER = re.compile(
    r"(?P<name>.*?)(?:\s+(?P<what>mass|weight|unbalance|amplitude|angle|phase))?\s*(?:[\[(](?P<unit>[^\])]*)[\])])?",
    re.I,
)
_COMMA = re.compile(r"([+-]?\d*),(\d+)(?=\D|$)")
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
    """Rows that are not empty, with their number in the sheet."""
    text = _text(file)
    lines = text.splitlines()
    offset = 1 if lines and lines[0].lower().startswith("sep=") else 0
    sign = lines[0][4:5] if offset else _separator(lines[0] if lines else "")
    try:
        parsed = list(csv.reader(io.StringIO("\n".join(lines[offset:])), delimiter=sign or ";"))
    except csv.Error as error:
        raise InputError(f"{file.name} is no CSV file: {error}.") from None
    comma = sign != ","
    cells = [[_point(cell.strip()) if comma else cell.strip() for cell in row] for row in parsed]
    return [(number, row) for number, row in enumerate(cells, start=1 + offset) if any(row)]


def _text(file: FilePath) -> str:
    try:
        if file.stat().st_size > LARGEST:
            raise InputError(f"{file.name} is larger than {LARGEST / 1e6:.0f} MB.")
        raw = file.read_bytes()
    except FileNotFoundError:
        raise InputError(f"{file} is not there. Name the CSV file, relative to the problem file.") from None
    except OSError as error:
        raise InputError(f"{file} cannot be read: {error.strerror or error}.") from None
    if raw[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return raw.decode("utf-16", errors="replace")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode("cp1252", errors="replace")


def _separator(line: str) -> str:
    """The sign between columns, told by the heading: tab, semicolon or comma."""
    return max(("\t", ";", ","), key=line.count)


def _point(cell: str) -> str:
    """A cell with a decimal point for its decimal comma."""
    return _COMMA.sub(r"\1.\2", cell) if cell.count(",") == 1 or "@" in cell else cell


def _columns(
    header: list[str], row: int, planes: list[str], sensors: list[str], mistakes: CsvMistakes
) -> list[Column | None]:
    columns: list[Column | None] = []
    known = ["run", "speed [rpm]", "stayed", *planes, *sensors]
    for index, heading in enumerate(header):
        column = _column(heading, _letter(index))
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


def _letter(index: int) -> str:
    """Column letters as a spreadsheet has them: A, B, ..., Z, AA."""
    letters = ""
    index += 1
    while index:
        index, rest = divmod(index - 1, 26)
        letters = chr(65 + rest) + letters
    return letters
