"""Readings from a CSV file, as a spreadsheet exports it: semicolon or comma, decimal comma, byte-order mark.

One row a run.  Columns: run, speed [rpm], stayed; per plane "left" (text such as 10 g @ 270 deg) or the two columns
"left mass [g]" (or "left unbalance [g mm]") and "left angle [deg]"; per sensor "a" (text) or the two columns
"a amplitude [mil pp]" and "a angle [deg]".
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import field
from itertools import compress, pairwise
from operator import itemgetter
from pathlib import Path as FilePath
from typing import Any

from vibopt.balancing.written import Written, columns
from vibopt.document.mistakes import Mistakes, Path, toml_text
from vibopt.errors import InputError, counted, way_out
from vibopt.records import dataclass
from vibopt.values.csv_tables import Sheet, bare, heading_of, letter, sheet_of

OWN = ("run", "speed", "stayed", "verification")
"""Columns of the run itself."""
_NAMES = {"name": "run", **{name: name for name in OWN}}
THOUSANDS = re.compile(r"(?<![\d.,])[1-9]\d{0,2}(?:\.\d{3})+(?![\d.,])")
"""A number whose point may part thousands."""
_YES = ("yes", "y", "true", "1", "x", "ja", "j", "wahr", "oui", "vrai", "sí", "si", "sì", "vero", "verdadero")
_NO = ("no", "n", "false", "0", "-", "nein", "falsch", "non", "faux", "falso")
_PAIR = re.compile(r"(?=[\d.]*[1-9])\d+(?:\.\d+)? @ [+-]?\d+(?:\.\d+)?")  # a size that is not zero, and its angle
_UNIT_BEHIND = re.compile(r"\d\s*(?![eE][+-]?\d)(?:[^\W\d_]|%)")
_WORDS = {
    "stayed": "the weights of the run before stayed on",
    "verification": "the weights are the correction, which stays on",
}
_AMOUNTS = {"mass", "weight", "unbalance", "amplitude"}
_NONE = "-–—"
"""Signs that stand for an empty cell."""


@dataclass(slots=True)
class Column:
    """One column: its heading and index, whose it is ("run", "speed", a plane, a sensor), what of it, and its unit."""

    heading: str
    index: int
    name: str
    what: str
    unit: str

    @property
    def part(self) -> str:
        """What its cells hold: "angle", else "amount"."""
        return "angle" if self.what == "angle" else "amount"

    @property
    def key(self) -> str:
        """Key of [[runs]] for a column of the run itself."""
        return "name" if self.name == "run" else self.name

    def is_at(self, path: Path) -> bool:
        """Whether its cells hold the value at the path within a run: ("speed",), ("readings", "a")."""
        return path[-1:] == (self.key,) if self.name in OWN else path[1:] == (self.name,)

    @property
    def place(self) -> str:
        """As in the messages: column C ("left mass [g]")."""
        quoted = f' ("{self.heading}")' if self.heading else ""
        return f"column {letter(self.index)}{quoted}"


Row = Sequence[str]
Cut = Callable[[Row], tuple[str, ...]]
"""Some cells of a row."""


@dataclass
class CsvMistakes(Mistakes):
    """Mistakes of a CSV file, said with row and column.

    columns
        Of the file, None where nothing is known of one.
    rows
        Of each run its number (from 1, as the spreadsheet counts) and cells.
    """

    columns: Sequence[Column | None] = ()
    rows: Sequence[tuple[int, Row]] = ()

    def place(self, path: Path) -> tuple[int, Column | None]:
        """Row and column of ("cell", row, index) and ("header", row), or of a value as [[runs]] would have it."""
        if path[0] == "header":
            return int(path[1]), Column("", int(path[2]), "", "", "") if len(path) > 2 else None
        if path[0] == "cell":
            return int(path[1]), self.columns[int(path[2])]
        if len(path) < 2 or int(path[1]) >= len(self.rows):
            return 0, None
        row, cells = self.rows[int(path[1])]
        there = (
            column
            for cell, column in zip(cells, self.columns, strict=False)
            if column is not None and cell.strip(_NONE)
        )
        return row, next((column for column in there if column.is_at(path[2:])), None)

    def at(self, path: Path) -> str:
        row, column = self.place(path)
        return f"{self.name} row {row}{f', {column.place}' if column else ''}" if row else self.name

    def add(self, path: Path, sentence: str) -> None:
        row = self.place(path)[0]
        message = f"{self.at(path)}: {sentence}"
        if not self.full and (row, message) not in self.found:
            self.found.append((row, message))

    def value(self, path: Path, given: object, text: str) -> None:
        self.add(path, f"{toml_text(given)} {text}")


@dataclass(frozen=True, slots=True)
class Plain:
    """Readings whose sizes and angles have columns of their own, with their units.

    others
        The other cells, whose `columns` are those of the run itself, `own` of them, and then of planes.
    named
        Whether the first of them are names of runs, 1 or 0.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    turns: tuple[str, ...]
    amounts: Cut
    angles: Cut
    others: Cut
    columns: tuple[Column | None, ...]
    own: int
    named: int


@dataclass(frozen=True, slots=True)
class Cells:
    """How the cells of a sheet are read: its columns, its planes, and where a point may part thousands.

    thousands
        In the speeds, in the other numbers.
    points
        Whether a point is the decimal sign, so that a comma parts thousands or is a slip.
    plain
        How rows of plain numbers are read in one piece; None where readings are texts.
    known, words
        Texts of weights by the cells of planes, and what else but a name is said of a run by those of its own, as they
        were read before: most stand in several rows.
    """

    columns: Sequence[Column | None]
    planes: Sequence[str]
    sheet: Sheet
    thousands: tuple[bool, bool]
    points: bool
    plain: Plain | None = None
    known: dict[tuple[str, ...], dict[str, str]] = field(default_factory=dict)
    words: dict[tuple[str, ...], dict[str, Any]] = field(default_factory=dict)

    def readings(self, rows: Sequence[Row]) -> Sequence[Written | None]:
        """Readings of all rows, where each is a plain number beside its angle; None each where cells are looked at."""
        plain, none = self.plain, [None] * len(rows)
        if plain is None or not {*map(len, rows)} <= {len(self.columns)}:
            return none
        amounts, angles = ([side(cells) for cells in rows] for side in (plain.amounts, plain.angles))
        if self.sheet.comma:
            joined = ["\n".join(one) for one in (*amounts, *angles)]
            asked = "," if self.points else ",$", *([THOUSANDS.pattern] if self.thousands[1] else [])
            if any(re.search("|".join(asked), one, re.MULTILINE) for one in joined):
                return none
            parted = [tuple(one.replace(",", ".").split("\n")) for one in joined]
            amounts, angles = parted[: len(rows)], parted[len(rows) :]
        return columns(plain.names, plain.units, plain.turns, amounts, angles) or none

    def read(self, raw: str, column: Column, path: Path, mistakes: Mistakes) -> str:
        """A cell of a sheet with decimal commas, with points; asks where a point may be something else."""
        number = column.name not in ("run", "stayed", "verification")
        if number and self.points and _COMMA.search(raw):
            mistakes.value(
                path, raw,
                f"has a comma where other cells have decimal points. Write {raw.replace(',', '')} or "
                f"{raw.replace(',', '.')}.",
            )  # fmt: skip
        if number and self.thousands[column.name != "speed"] and (match := THOUSANDS.search(raw)):
            whole, part = match[0].replace(".", ""), match[0].partition(".")[2]
            decimal = f" or {match[0].replace('.', ',')}" if "." not in part else ""
            mistakes.value(
                path, raw,
                f"may be {whole}{decimal.replace(',', '.')}: a point often parts thousands where the comma is the "
                f"decimal sign. Write {whole}{decimal}.",
            )  # fmt: skip
        return self.sheet.number(raw)


def run_of(
    index: int, row: int, cells: Row, readings: Written | None, said: Cells, mistakes: Mistakes
) -> dict[str, Any]:
    """One row as a [[runs]] table; `readings` where they are read already."""
    run: dict[str, Any] = {}
    parts: dict[str, dict[str, tuple[Column, str]]] = {}
    own, columns, plain = cells, said.columns, said.plain if readings is not None else None
    values = None
    if plain is not None:
        own, columns = plain.others(cells), plain.columns
        words, weights = own[plain.named : plain.own], own[plain.own :]
        values, told = said.known.get(weights), said.words.get(words)
        if values is not None and told is not None and (not plain.named or own[0].strip(_NONE)):
            run = {"name": said.sheet.number(own[0])} if plain.named else {}
            return {**run, **told, "weights": values, "readings": readings}
        own = own[: plain.own] if values is not None else own
    before = len(mistakes.found)
    for raw, column in compress(zip(own, columns, strict=False), own):  # most cells are empty
        if column is None or not raw.strip(_NONE):
            continue
        path = ("cell", row, column.index)
        cell = said.read(raw, column, path, mistakes) if said.sheet.comma else raw
        if column.name in OWN:
            run.update(_own(column, cell, path, mistakes))
        else:
            parts.setdefault(column.name, {})[column.part] = (column, cell)
    if values is None:
        values = {}
        for name, part in parts.items():
            values.update(_value(name, part, row, said, mistakes))
    if plain is not None and len(mistakes.found) == before:
        said.known[weights], said.words[words] = values, {key: one for key, one in run.items() if key != "name"}
    run["weights"] = values if readings is not None else {one: values[one] for one in values if one in said.planes}
    run["readings"] = (
        readings if readings is not None else {one: values[one] for one in values if one not in said.planes}
    )
    if len(cells) > len(said.columns) and any(cells[len(said.columns) :]):
        both = counted(len(cells), "cells"), counted(len(said.columns), "columns")
        mistakes.add(("runs", index), f"has {both[0]}, but the heading names {both[1]}.")
    return run


def _own(column: Column, cell: str, path: Path, mistakes: Mistakes) -> dict[str, Any]:
    """The name, the speed or the word of a run itself."""
    if column.name in _WORDS:
        known = {**dict.fromkeys(_YES, True), **dict.fromkeys(_NO, False)}.get(cell.lower())
        if known is None:
            mistakes.value(path, cell, f"is neither yes nor no. Write yes where {_WORDS[column.name]}.")
        return {column.name: bool(known)}
    if column.name == "speed":
        return {"speed": cell if _LETTER.search(cell) else f"{cell} {column.unit}".strip()}
    return {"name": cell}


def _value(
    name: str, part: Mapping[str, tuple[Column, str]], row: int, said: Cells, mistakes: Mistakes
) -> dict[str, str]:
    """Size and angle of a weight or a reading as one text by its name; nothing where it was complained about."""
    if "amount" not in part:
        column, cell = part["angle"]
        beside = next(one for one in said.columns if one is not None and (one.name, one.part) == (name, "amount"))
        what = "weight" if name in said.planes else "amplitude"
        mistakes.value(
            ("cell", row, column.index), cell,
            f"is an angle without its {what}. Write the {what} in {beside.place}"
            f"{', or empty this cell' if name in said.planes else ''}.",
        )  # fmt: skip
        return {} if name in said.planes else {name: f"0 {beside.unit} @ {cell} {column.unit}".strip()}
    column, cell = part["amount"]
    angle = part.get("angle")
    if column.unit and column.what in _AMOUNTS and angle and angle[0].unit and _PAIR.fullmatch(f"{cell} @ {angle[1]}"):
        return {name: f"{cell} {column.unit} @ {angle[1]} {angle[0].unit}"}
    cell = bare(cell, column.unit) if column.what in _AMOUNTS else cell
    amount = f"{cell} {column.unit}".strip() if column.what in _AMOUNTS else cell
    told = (column, cell if column.what in _AMOUNTS and "@" not in cell else ""), angle or (column, "")
    for one, text in told:
        if one.unit and _UNIT_BEHIND.search(bare(text, one.unit)):
            mistakes.value(
                ("cell", row, one.index), text, f'has a unit of its own. Write the number alone, in "{one.unit}".'
            )
            return {}
    place = ("cell", row, column.index)
    if name in said.planes and _is_zero(amount):
        cells = "this cell and that of its angle" if angle else "this cell"
        mistakes.value(place, amount, f"is a trial weight of zero. Where no weight is on, empty {cells}.")
        return {}
    if angle is None:
        return {name: amount}
    if "@" in amount:
        mistakes.value(place, amount, f"has an angle, and so has {angle[0].place}. Empty one of the two.")
        return {name: amount}
    return {name: f"{amount} @ {bare(angle[1], angle[0].unit)} {angle[0].unit}".strip()}


def _is_zero(amount: str) -> bool:
    """Whether an amount in front of any angle is zero."""
    number = re.match(r"\s*[+-]?[\d.]+(?:[eE][+-]?\d+)?", amount)
    try:
        return number is not None and float(number[0]) == 0.0
    except ValueError:
        return False


_WHATS = ("mass", "weight", "unbalance", "amplitude", "angle", "phase")
"""Words behind the name of a plane or a sensor that say what a column holds of it."""
_ANGLES = {"phase": "angle"}
_HEADING = re.compile(rf"([^\s\[\]()]+)(?: ({'|'.join(_WHATS)}))?(?: \[([^\s\[\]()]+(?: [^\s\[\]()]+)*)\])?")
"""Name, what and unit of most columns, the latter two where they are there."""
_PLAIN = re.compile(r"\s*[+-]?[\d.,]+\s*")
_USUAL = {"mass": "g", "weight": "g", "unbalance": "g mm", "amplitude": "mil pp", "angle": "deg"}
"""Units of examples, where no other column shows one."""
_LETTER = re.compile(r"(?<!\d)[A-Za-z]|[A-Za-z](?![+-]?\d)")
"""A letter of a unit, and none of a power of ten."""
_POINT = re.compile(r"\d\.\d")
_COMMA = re.compile(r"\d,\d")


def read_csv(
    file: FilePath, planes: Iterable[str], sensors: Mapping[str, object], outer: Mistakes
) -> tuple[list[dict[str, Any]], CsvMistakes]:
    """Rows as [[runs]] tables, with the places of their values; what is wrong with the file itself goes to `outer`.

    sensors
        Tables of those that the job names, which may tell the unit of a column.
    """
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
    mistakes.rows = body
    names = list(sensors) or [column.name for column in parts if column.what == "amplitude"]
    columns = mistakes.columns = _columns(parts, header_row, own, names, mistakes)
    _check_parts(columns, header_row, own, mistakes)
    told = {name for name, table in sensors.items() if isinstance(table, Mapping) and "unit" in table}
    _check_units([one for one in columns if one and one.what and one.name not in told], sheet, own, mistakes)
    if mistakes.found:
        return [], mistakes
    said = Cells(columns, own, sheet, *_signs(sheet), _plain(columns, names))
    readings = said.readings([cells for _, cells in body])
    runs = [
        run_of(index, row, cells, own, said, mistakes)
        for index, ((row, cells), own) in enumerate(zip(body, readings, strict=True))
    ]
    if not body:
        outer.add(("readings",), f"{file.name} has no run below its heading. Add one row a run.")
    return runs, mistakes


def _plain(columns: Sequence[Column | None], sensors: Sequence[str]) -> Plain | None:
    """How rows of numbers are read in one piece: every sensor has a column for its size and one for its angle."""
    at = {(one.name, one.what): one for one in columns if one is not None}
    read = [at[name, what] for what in ("amplitude", "angle") for name in sensors if (name, what) in at]
    if len(read) < 2 * len(sensors) or not sensors:
        return None
    places, units, n = [one.index for one in read], tuple([one.unit for one in read]), len(sensors)
    run = [at[name, ""].index for name in OWN if (name, "") in at]
    others = [*run, *sorted({*range(len(columns))}.difference(places, run))]
    return Plain(
        tuple(sensors), units[:n], units[n:], _cells_at(places[:n]), _cells_at(places[n:]), _cells_at(others),
        tuple([columns[index] for index in others]), len(run), int(("run", "") in at),
    )  # fmt: skip


def _cells_at(places: Sequence[int]) -> Cut:
    """The cells of a row at some places, in this order."""
    steps = {after - before for before, after in pairwise(places)} or {1}
    if len(steps) == 1 and min(steps) > 0:
        return itemgetter(slice(places[0], places[-1] + 1, *steps))
    return itemgetter(*places) if places else lambda row: ()


def _columns(
    parts: Sequence[Column], row: int, planes: list[str], sensors: list[str], mistakes: CsvMistakes
) -> list[Column | None]:
    known = ["run", "speed [rpm]", "stayed", "verification", *planes, *sensors]
    named = {name for name in known[len(OWN) :] if name.lower() not in _NAMES}
    columns = [part if part.name in named else _own_column(part) for part in parts]
    for index, part in enumerate(parts if not all(columns) else ()):
        if columns[index] is None and part.heading and any(columns) and not mistakes.full:  # else it is another file
            name = heading_of(part.heading)[0]
            mistakes.value(
                ("header", row, index), part.heading, f"names no plane and no sensor of this job.{way_out(name, known)}"
            )
    if not any(column is not None and column.name in sensors for column in columns):
        mistakes.add(
            ("header", row),
            f'no column holds a sensor. Write for example "{(sensors or ["a"])[0]} amplitude [mil pp]".',
        )
    return columns


def _own_column(column: Column) -> Column | None:
    """A column of the run itself; None where the heading names none."""
    own = _NAMES.get(column.name.lower())
    return None if own is None else Column(column.heading, column.index, own, "", column.unit)


def _check_parts(columns: Sequence[Column | None], row: int, planes: Sequence[str], mistakes: CsvMistakes) -> None:
    """Each column holds something of its own, and no angle stands without its amount."""
    there = [one for one in columns if one is not None]
    turned, sized = ({one.name for one in there if (one.what == "angle") is angle} for angle in (True, False))
    if turned <= sized and len(turned) + len(sized) == len(there):
        return
    first: dict[tuple[str, str], Column] = {}
    for column in there:
        other = first.setdefault((column.name, column.part), column)
        if other is not column:
            what = "the angle of " if column.part == "angle" else "" if column.name in OWN else "the size of "
            mistakes.add(
                ("header", row),
                f"{other.place} and {column.place} both hold {what}{column.name}. Keep one, or rename the other.",
            )
    for (name, part), column in first.items():
        if part == "angle" and (name, "amount") not in first:
            heading = f"{name} mass [g]" if name in planes else f"{name} amplitude [mil pp]"
            mistakes.add(("header", row), f'{column.place} has no column beside it for the size. Add one, "{heading}".')


def _check_units(columns: Sequence[Column], sheet: Sheet, planes: Sequence[str], mistakes: CsvMistakes) -> None:
    """A column of plain numbers has a unit in its heading: of each that has none it is said once, not in every row."""
    (row, _), *body = sheet.rows
    for column in columns:
        at = column.index
        if column.unit or not any(_PLAIN.fullmatch(cells[at]) for _, cells in body if at < len(cells)):
            continue
        beside = [one for one in columns if one.what == column.what and (one.name in planes) == (column.name in planes)]
        unit = next((one.unit for one in beside if one.unit), _USUAL[column.what])
        name = column.heading.strip()
        mistakes.add(("header", row), f'heading "{name}" has no unit. Write "{name} [{unit}]".')


def _signs(sheet: Sheet) -> tuple[tuple[bool, bool], bool]:
    """Whether a point in "1.200" may part thousands, in the speeds and in the other numbers; and whether it is decimal.

    Where commas part the columns a point is the decimal sign.  Elsewhere a decimal comma anywhere leaves it open, and a
    point that cannot part thousands ("8.6") settles it.  With neither, only a speed is asked about.  It is decimal
    where more cells have such a point than have a comma.
    """
    if not sheet.comma:
        return (False, False), False
    cells = "\n".join("\n".join(row) for _, row in sheet.rows[1:])
    commas, points = len(_COMMA.findall(cells)), len(_POINT.findall(THOUSANDS.sub("", cells)))
    return (commas > 0 or not points, commas > 0), points > commas


def _column(heading: str, index: int) -> Column:
    plain = _HEADING.fullmatch(heading)
    if plain is not None:
        name, what, unit = plain.groups("")
        return Column(heading, index, name, _ANGLES.get(what, what), unit)
    name, unit = heading_of(heading)
    front, last = name.rsplit(None, 1) if len(name.split(None, 1)) == 2 else (name, "")
    what = last.lower()
    if what not in _WHATS:
        return Column(heading, index, name, "", unit)
    return Column(heading, index, front, _ANGLES.get(what, what), unit)
