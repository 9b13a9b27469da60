"""Tables as a spreadsheet exports them: semicolon, tab or comma, decimal comma, byte-order mark, old code pages."""

from __future__ import annotations

import csv
import io
import re
from codecs import BOM_UTF8
from collections.abc import Callable, Iterator
from pathlib import Path as FilePath

from vibopt.errors import InputError
from vibopt.files.reading import FileFault, Kind, content_of, shown_name
from vibopt.records import dataclass

SHEET = Kind("a CSV file", 5_000_000, "Name the CSV file, relative to the problem file.", "Name a CSV file.")
MOST_COLUMNS = 10_000
_COMMA = re.compile(r",(?=\d)")
_WITH_COMMA, _WITH_POINT = (
    re.compile(r"[-+]?(\d+),(\d+)(?:[eE][-+]?\d+)?"),
    re.compile(r"[-+]?\d*\.\d+(?:[eE][-+]?\d+)?"),
)


@dataclass(frozen=True, slots=True)
class Sheet:
    """Cells of a file.

    rows
        Rows that are not empty, each with its number in the sheet (from 1) and its cells without blanks around them.
    comma
        Whether a comma in a number is the decimal sign: it does not part the columns, or stands in quotation marks and
        cannot part thousands.
    """

    rows: tuple[tuple[int, tuple[str, ...]], ...]
    comma: bool

    def number(self, cell: str) -> str:
        """A cell with a decimal point for its decimal comma."""
        return with_point(cell) if self.comma else cell


def sheet_of(file: FilePath, begins: Callable[[list[str]], int] | None = None) -> Sheet:
    """The cells of a CSV file; `begins` says how many of its lines stand above the heading and are no part of it.

    Raises
    ------
    InputError
        It is not there, too large, or no table.
    """
    text = text_of(file).rstrip()
    lines = text.splitlines()
    offset = 1 if lines and lines[0].lower().startswith("sep=") else 0
    above = offset + (begins(lines[offset:]) if begins is not None else 0)
    if text.count('"') % 2:
        row = next(number for number, line in enumerate(lines, start=1) if line.count('"') % 2)
        raise InputError(f"{file.name} row {row} has a quotation mark that is never closed. Close it, or remove it.")
    sign = (lines[0][4:5] if offset else separator(lines[above] if lines else "")) or ";"
    try:
        cells = [tuple(map(str.strip, row)) for row in _cells(lines[above:], sign, quoted='"' in text)]
    except csv.Error as error:
        raise InputError(f"{file.name} is no CSV file: {error}.") from None
    widest = max(map(len, cells), default=0)
    if widest > MOST_COLUMNS:
        raise InputError(f"{file.name} has {widest} columns, more than the {MOST_COLUMNS} that are read.")
    rows = tuple((number, row) for number, row in enumerate(cells, start=1 + above) if any(row))
    return Sheet(rows, sign != "," or ('"' in text and _quoted(cells)))


def _cells(lines: list[str], sign: str, *, quoted: bool) -> Iterator[list[str]]:
    """The cells of each line; without quotation marks they need no more than to be parted."""
    if quoted or max(map(len, lines), default=0) > csv.field_size_limit():
        return csv.reader(io.StringIO("\n".join(lines)), delimiter=sign)
    return (line.split(sign) for line in lines)


def _quoted(cells: list[tuple[str, ...]]) -> bool:
    """Whether commas in cells that commas part are decimal signs: no point is, and not all could part thousands."""
    every = [one for row in cells for one in row]
    numbers = [match for one in every if (match := _WITH_COMMA.fullmatch(one))]
    decimal = any(len(number[2]) != 3 or number[1] == "0" for number in numbers)
    return decimal and not any(_WITH_POINT.fullmatch(one) for one in every)


def text_of(file: FilePath) -> str:
    """The text of a file as spreadsheets write it: UTF-8 or UTF-16 with a mark, or Windows' own."""
    try:
        raw = content_of(file, SHEET)
    except FileFault as fault:
        raise InputError(f"{shown_name(file if fault.missing else file.name)} {fault.text}") from None
    if raw[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return raw.decode("utf-16", errors="replace")
    try:
        return raw.removeprefix(BOM_UTF8).decode()
    except UnicodeDecodeError:
        return raw.decode("cp1252", errors="replace")


def heading_of(text: str) -> tuple[str, str]:
    """Name and unit of a heading, "stiffness [N/mm]" or "stiffness (N/mm)"; the unit is "" where there is none."""
    whole = text.strip()
    if whole[-1:] not in ("]", ")"):
        return whole, ""
    inner = whole[:-1]
    begin = max(inner.rfind("]"), inner.rfind(")")) + 1
    opened = [place for place in (inner.find("[", begin), inner.find("(", begin)) if place >= 0]
    if not opened:
        return whole, ""
    return whole[: min(opened)].strip(), inner[min(opened) + 1 :].strip()


def separator(line: str) -> str:
    """The sign between columns, told by the heading: tab, semicolon or comma."""
    return max(("\t", ";", ","), key=line.count)


def with_point(cell: str) -> str:
    """A cell with a decimal point for its decimal comma."""
    return _COMMA.sub(".", cell) if cell.count(",") == 1 or "@" in cell else cell


def bare(cell: str, unit: str) -> str:
    """A cell without the unit that its heading has said already."""
    return cell[: -len(unit)].strip() if unit and cell.endswith(unit) and cell[: -len(unit)].strip() else cell


def letter(index: int) -> str:
    """Column letters as a spreadsheet has them, from index 0: A, B, ..., Z, AA."""
    letters = ""
    index += 1
    while index:
        index, rest = divmod(index - 1, 26)
        letters = chr(65 + rest) + letters
    return letters
