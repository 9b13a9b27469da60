"""Rows of a CSV file as [[runs]] tables: what each cell says, and what is wrong with it."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from typing import Any

from vibopt.balancing.written import WrittenByName, columns
from vibopt.document.mistakes import Mistakes, Path, toml_text
from vibopt.records import dataclass
from vibopt.values.csv_tables import Sheet, letter

OWN = ("run", "speed", "stayed", "verification")
"""Columns of the run itself."""
THOUSANDS = re.compile(r"(?<![\d.,])[1-9]\d{0,2}(?:\.\d{3})+(?![\d.,])")
"""A number whose point may part thousands."""
_YES = ("yes", "y", "true", "1", "x", "ja", "j", "wahr", "oui", "vrai", "sí", "si", "sì", "vero", "verdadero")
_NO = ("no", "n", "false", "0", "-", "nein", "falsch", "non", "faux", "falso")
_WORDS = {
    "stayed": "the weights of the run before stayed on",
    "verification": "the weights are the correction, which stays on",
}
_AMOUNTS = {"mass", "weight", "unbalance", "amplitude"}


@dataclass(frozen=True, slots=True)
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

    @property
    def place(self) -> str:
        """As in the messages: column C ("left mass [g]")."""
        quoted = f' ("{self.heading}")' if self.heading else ""
        return f"column {letter(self.index)}{quoted}"


@dataclass
class CsvMistakes(Mistakes):
    """Mistakes of a CSV file, said with row and column.

    places
        By path of a value as [[runs]] would have it: its row (from 1, as the spreadsheet counts) and column.
    columns
        First column of each sensor, for rows that were read in one piece.
    """

    places: dict[Path, tuple[int, Column | None]] = field(default_factory=dict)
    columns: dict[str, Column] = field(default_factory=dict)

    def place(self, path: Path) -> tuple[int, Column | None]:
        """Row and column of the nearest place known."""
        if path not in self.places and len(path) == 4 and str(path[3]) in self.columns:
            return self.places[path[:2]][0], self.columns[str(path[3])]
        for length in range(len(path), 0, -1):
            if path[:length] in self.places:
                return self.places[path[:length]]
        return 0, None

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


Row = Sequence[str]


@dataclass(frozen=True, slots=True)
class Plain:
    """Readings whose sizes and angles have columns of their own, with their units; `others` are the other `columns`."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    turns: tuple[str, ...]
    amounts: Callable[[Row], tuple[str, ...]]
    angles: Callable[[Row], tuple[str, ...]]
    others: Callable[[Row], tuple[str, ...]]
    columns: tuple[Column | None, ...]


@dataclass(frozen=True, slots=True)
class Cells:
    """How the cells of a sheet are read: its columns, its planes, and where a point may part thousands.

    thousands
        In the speeds, in the other numbers.
    plain
        How rows of plain numbers are read in one piece; None where readings are texts.
    """

    columns: Sequence[Column | None]
    planes: Sequence[str]
    sheet: Sheet
    thousands: tuple[bool, bool]
    plain: Plain | None = None

    def readings(self, rows: Sequence[Row]) -> Sequence[WrittenByName | None]:
        """Readings of all rows, where each is a plain number beside its angle; None each where cells are looked at."""
        plain, none = self.plain, [None] * len(rows)
        if plain is None or any(len(cells) != len(self.columns) for cells in rows):
            return none
        joined = ["\n".join(side(cells)) for side in (plain.amounts, plain.angles) for cells in rows]
        if self.sheet.comma:
            if any(
                ",\n" in one or one.endswith(",") or (self.thousands[1] and THOUSANDS.search(one)) for one in joined
            ):
                return none
            joined = [one.replace(",", ".") for one in joined]
        return columns(plain.names, plain.units, plain.turns, joined, len(rows)) or none

    def read(self, raw: str, column: Column, path: Path, mistakes: Mistakes) -> str:
        """A cell with decimal points; asks where a point may be something else."""
        asked = self.thousands[column.name != "speed"] and column.name not in ("run", "stayed", "verification")
        found = THOUSANDS.search(raw) if asked else None
        if found:
            whole, part = found[0].replace(".", ""), found[0].partition(".")[2]
            decimal = f" or {found[0].replace('.', ',')}" if "." not in part else ""
            mistakes.value(
                path, raw,
                f"may be {whole}{decimal.replace(',', '.')}: a point often parts thousands where the comma is the "
                f"decimal sign. Write {whole}{decimal}.",
            )  # fmt: skip
        return self.sheet.number(raw)


def run_of(
    index: int, row: int, cells: Row, readings: WrittenByName | None, said: Cells, mistakes: CsvMistakes
) -> dict[str, Any]:
    """One row as a [[runs]] table; `readings` where they are read already."""
    run: dict[str, Any] = {}
    parts: dict[str, dict[str, tuple[Column, str]]] = {}
    mistakes.places[("runs", index)] = (row, None)
    if readings is not None and said.plain is not None:
        every = zip(said.plain.others(cells), said.plain.columns, strict=True)
    else:
        every = zip(cells, said.columns, strict=False)
    for raw, column in every:
        if not raw or column is None or not raw.strip("-–—"):
            continue
        place = (row, column)
        mistakes.places[("cell", index)] = place
        cell = said.read(raw, column, ("cell", index), mistakes)
        if column.name in OWN:
            mistakes.places[("runs", index, column.key)] = place
            run.update(_own(column, cell, ("cell", index), mistakes))
            continue
        parts.setdefault(column.name, {})[column.part] = (column, cell)
        for family in ("weights", "readings"):
            mistakes.places.setdefault(("runs", index, family, column.name), place)
    run["_values"], run["_readings"] = {}, readings
    for name, part in parts.items():
        run["_values"].update(_value(name, part, (index, row), said, mistakes))
    if len(cells) > len(said.columns) and any(cells[len(said.columns) :]):
        mistakes.add(("runs", index), f"has {len(cells)} cells, but the heading names {len(said.columns)} columns.")
    return run


def _own(column: Column, cell: str, path: Path, mistakes: Mistakes) -> dict[str, Any]:
    """The name, the speed or the word of a run itself."""
    if column.name in _WORDS:
        known = {**dict.fromkeys(_YES, True), **dict.fromkeys(_NO, False)}.get(cell.lower())
        if known is None:
            mistakes.value(path, cell, f"is neither yes nor no. Write yes where {_WORDS[column.name]}.")
        return {column.name: bool(known)}
    if column.name == "speed":
        return {"speed": cell if re.search("[A-Za-z]", cell) else f"{cell} {column.unit}".strip()}
    return {"name": cell}


def _value(
    name: str, part: Mapping[str, tuple[Column, str]], at: tuple[int, int], said: Cells, mistakes: CsvMistakes
) -> dict[str, str]:
    """Size and angle of a weight or a reading as one text by its name; nothing where it was complained about."""
    index, row = at
    if "amount" not in part:
        column, cell = part["angle"]
        beside = next(one for one in said.columns if one is not None and (one.name, one.part) == (name, "amount"))
        what = "weight" if name in said.planes else "amplitude"
        mistakes.places[("cell", index)] = (row, column)
        mistakes.value(
            ("cell", index), cell,
            f"is an angle without its {what}. Write the {what} in {beside.place}"
            f"{', or empty this cell' if name in said.planes else ''}.",
        )  # fmt: skip
        return {} if name in said.planes else {name: f"0 {beside.unit} @ {cell} {column.unit}".strip()}
    column, cell = part["amount"]
    amount = f"{cell} {column.unit}".strip() if column.what in _AMOUNTS else cell
    angle = part.get("angle")
    mistakes.places[("cell", index)] = (row, column)
    if name in said.planes and _is_zero(amount):
        cells = "this cell and that of its angle" if angle else "this cell"
        mistakes.value(
            ("cell", index), amount, f"is a trial weight of zero. Where no weight is on, empty {cells}."
        )  # fmt: skip
        return {}
    if angle is None:
        return {name: amount}
    if "@" in amount:
        mistakes.value(("cell", index), amount, f"has an angle, and so has {angle[0].place}. Empty one of the two.")
        return {name: amount}
    return {name: f"{amount} @ {angle[1]} {angle[0].unit}".strip()}


def _is_zero(amount: str) -> bool:
    """Whether an amount in front of any angle is zero."""
    number = re.match(r"\s*[+-]?[\d.]+(?:[eE][+-]?\d+)?", amount)
    try:
        return number is not None and float(number[0]) == 0.0
    except ValueError:
        return False
