"""A catalogue of parts: one row a part, one column a property, units in the headings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from functools import lru_cache
from pathlib import Path as FilePath

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.errors import InputError, QuantityError, counted, way_out
from vibopt.files.reading import FileFault, Stamp, shown_name, stamp_of
from vibopt.records import dataclass
from vibopt.units.parsing import LARGEST
from vibopt.units.scales import Scale, scale_of
from vibopt.values.csv_tables import SHEET, Sheet, bare, heading_of, letter, sheet_of
from vibopt.values.fields import LEAST

MOST_PARTS = 5000
MOST_SAID = 12
"""Most mistakes of one file that are said at once."""
_TEXTS = {"part": ("part", "name", "part name", "part number", "type"), "": ("note", "comment", "maker", "supplier")}


@dataclass(frozen=True, slots=True)
class Kind:
    """A column that may stand in a catalogue: its key, dimension, whether 0 is allowed, and its headings."""

    key: str
    dimension: str
    zero: bool
    headings: tuple[str, ...]


_KINDS = (
    Kind("rated_min", "force", True, ("rated load min", "rated min", "least load")),
    Kind("rated_max", "force", False, ("rated load max", "rated max", "rated load", "greatest load")),
    Kind("stiffness", "stiffness", False, ("stiffness", "stiffness z", "dynamic stiffness", "axial stiffness")),
    Kind("stiffness_x", "stiffness", False, ("stiffness x",)),
    Kind("stiffness_y", "stiffness", False, ("stiffness y",)),
    Kind("shear", "stiffness", False, ("shear stiffness",)),
    Kind("static_stiffness", "stiffness", False, ("static stiffness", "static stiffness z")),
    Kind("dynamic_to_static", "ratio", False, ("dynamic to static",)),
    Kind("damping", "damping", True, ("damping", "damping z")),
    Kind("damping_x", "damping", True, ("damping x",)),
    Kind("damping_y", "damping", True, ("damping y",)),
    Kind("shear_damping", "damping", True, ("shear damping",)),
    Kind("loss_factor", "ratio", True, ("loss factor",)),
    Kind("damping_ratio", "ratio", True, ("damping ratio",)),
    Kind("tolerance", "ratio", True, ("tolerance",)),
    Kind("price", "price", True, ("price",)),
)
_BY_HEADING = {heading: kind for kind in _KINDS for heading in kind.headings}
_KNOWN = {*_BY_HEADING, *(name for names in _TEXTS.values() for name in names)}
_DAMPERS = ("damping", "loss_factor", "damping_ratio")
_CLASHES = (_DAMPERS, ("static_stiffness", "dynamic_to_static"))
_OPTIONAL = ("rated_min", "tolerance")
"""Columns whose cells may stay empty, which means none."""
_PLAIN = Scale(1.0)
_USUAL = {"force": "N", "stiffness": "N/mm", "damping": "N s/m", "price": "EUR"}


@dataclass(frozen=True, slots=True)
class Catalogue:
    """The parts of one file.

    file
        Its name, for messages.
    names
        Name of each part.
    sheet_rows
        Row of each part in the sheet, from 1.
    columns
        Per property the values of all parts [SI], each (n_parts,).
    units
        Per property the unit of its heading.
    """

    file: str
    names: tuple[str, ...]
    sheet_rows: tuple[int, ...]
    columns: Mapping[str, FloatArray]
    units: Mapping[str, str]

    def __len__(self) -> int:
        return len(self.names)

    def only(self, names: tuple[str, ...]) -> Catalogue:
        """The parts of these names, in the order of the file."""
        kept = [i for i, name in enumerate(self.names) if name in names]
        return Catalogue(
            self.file,
            tuple(self.names[i] for i in kept),
            tuple(self.sheet_rows[i] for i in kept),
            {key: column[kept] for key, column in self.columns.items()},
            self.units,
        )


@dataclass
class _Said:
    """Mistakes of one file, each with its row and column."""

    file: str
    found: list[str] = field(default_factory=list)

    def add(self, row: int, column: Column | None, text: str) -> None:
        place = f", column {column.letter} ({_quoted(column.heading)})" if column is not None else ""
        self.found.append(f"{self.file} row {row}{place}: {text}")

    def raise_any(self) -> None:
        if len(self.found) > MOST_SAID:
            rest = len(self.found) - MOST_SAID
            self.found[MOST_SAID:] = [f"{self.file}: and {counted(rest, 'more mistakes')} of these kinds."]
        if self.found:
            raise InputError(self.found)


@dataclass(frozen=True, slots=True)
class Column:
    """One column of the sheet: heading, letter, what it holds (None for a text), its unit."""

    heading: str
    letter: str
    kind: Kind | None
    key: str
    unit: str = ""
    scale: Scale = _PLAIN


Renamed = tuple[tuple[str, tuple[str, ...]], ...]
"""By the name of a column here, the headings that the file has for it."""


def catalogue_of(file: FilePath, renamed: Renamed = ()) -> Catalogue:
    """The catalogue of a CSV file, with other headings if need be; read once as long as the file does not change.

    Raises
    ------
    InputError
        It is not there, empty, or has mistakes; the texts say row and column.
    """
    try:
        found = _once(file, stamp_of(file, SHEET), renamed)
    except FileFault as fault:
        raise InputError(f"{shown_name(file if fault.missing else file.name)} {fault.text}") from None
    if isinstance(found, Catalogue):
        return found
    raise InputError(found)


@lru_cache(maxsize=32)
def _once(file: FilePath, stamp: Stamp, renamed: Renamed) -> Catalogue | tuple[str, ...]:
    """The catalogue of a file as it is now, or its mistakes."""
    try:
        return _read(file, renamed)
    except InputError as error:
        return error.messages


def _read(file: FilePath, renamed: Renamed) -> Catalogue:
    sheet, said = sheet_of(file), _Said(file.name)
    if not sheet.rows:
        raise InputError(
            f"{file.name} is empty. Its first row names the columns: part, rated load max [N], stiffness [N/mm], ..."
        )
    (head_row, heads), *body = sheet.rows
    heads = _with_our_names(heads, renamed, head_row, said)
    said.raise_any()
    columns = _columns(heads, head_row, said)
    if not body:
        said.add(head_row, None, "there is no part below the heading. Add one row a part.")
    if len(body) > MOST_PARTS:
        said.add(head_row, None, f"there are {len(body)} parts, more than the {MOST_PARTS} that are read.")
    said.raise_any()
    return _parts(file.name, sheet, columns, body, said)


def _with_our_names(heads: tuple[str, ...], renamed: Renamed, row: int, said: _Said) -> tuple[str, ...]:
    """Headings by the names they have here, each with the unit of the file or, without any, of the problem file."""
    new = list(heads)
    for ours, theirs in renamed:
        if _plain_name(ours) not in _KNOWN:
            said.add(row, None, f'columns names "{ours}", which is no column of a catalogue.{_near(_plain_name(ours))}')
            continue
        for their in theirs:
            name, unit = heading_of(their)
            places = [
                k
                for k, head in enumerate(heads)
                if head in (their, name) or (not unit and heading_of(head)[0] == their)
            ]
            if len(places) != 1:
                listed = ", ".join(_quoted(head) for head in heads if head)
                said.add(
                    row, None, f'has {"no column" if not places else "several columns"} "{their}". It has {listed}.'
                )
                continue
            unit = heading_of(heads[places[0]])[1] or unit
            new[places[0]] = f"{ours} [{unit}]" if unit and _plain_name(ours) in _BY_HEADING else ours
    return tuple(new)


def _quoted(text: str) -> str:
    return f'"{text}"'


def _columns(heads: tuple[str, ...], row: int, said: _Said) -> list[Column | None]:
    if not any(_plain_name(heading) in _KNOWN for heading in heads):  # another file, of which nothing is shown
        said.add(
            row, None, "names no column of a catalogue. Name them: part, rated load max [N], stiffness [N/mm], ..."
        )
        return []
    columns = [_column(heading, index, row, said) for index, heading in enumerate(heads)]
    seen: dict[str, Column] = {}
    for column in columns:
        if column is None or not column.key:
            continue
        if column.key in seen:
            said.add(row, column, f"says the same as column {seen[column.key].letter}. Keep one of them.")
        seen[column.key] = column
    for keys in _CLASHES:
        both = [seen[key] for key in keys if key in seen]
        if len(both) > 1:
            said.add(
                row, both[1], f"cannot stand beside column {both[0].letter} ({_quoted(both[0].heading)}). Keep one."
            )
    wanted = (("part", "part"), ("rated_max", "rated load max [N]"), ("stiffness", "stiffness [N/mm]"))
    for key, heading in wanted:
        if key not in seen and not said.found:
            said.add(row, None, f"no column holds the {key.replace('_max', ' load')}. Add a column {_quoted(heading)}.")
    return columns


def _column(heading: str, index: int, row: int, said: _Said) -> Column | None:
    """One heading; None, said, where it cannot be used."""
    place = Column(heading, letter(index), None, "")
    if not heading:
        return None
    name, unit = _plain_name(heading), heading_of(heading)[1]
    for key, names in _TEXTS.items():
        if name in names:
            return Column(heading, place.letter, None, key)
    kind = _BY_HEADING.get(name)
    if kind is None:
        said.add(row, place, f"is no column that vibopt knows.{_near(name) if len(said.found) < MOST_SAID else ''}")
        return None
    if not unit and kind.dimension != "ratio":
        said.add(row, place, f"has no unit. Write {_quoted(f'{name} [{_USUAL[kind.dimension]}]')}.")
        return None
    try:
        if unit == "dB":
            raise QuantityError("is in dB, but this column holds plain ratios. Write % or no unit.")
        scale = scale_of(unit, kind.dimension)
    except QuantityError as error:
        said.add(row, place, str(error))
        return None
    return Column(heading, place.letter, kind, kind.key, unit, scale)


def _plain_name(heading: str) -> str:
    """The name in a heading, "Loss_Factor [%]" as "loss factor"."""
    return " ".join(heading_of(heading)[0].lower().replace("_", " ").replace("-", " ").split())


def _near(name: str) -> str:
    return way_out(name, [kind.headings[0] for kind in _KINDS] + ["part", "note"])


def _parts(
    file: str, sheet: Sheet, columns: list[Column | None], body: list[tuple[int, tuple[str, ...]]], said: _Said
) -> Catalogue:
    """Every cell read, every mistake said."""
    names: dict[str, int] = {}
    values: dict[str, list[float]] = {one.key: [] for one in columns if one is not None and one.kind is not None}
    for row, cells in body:
        if any(cells[len(columns) :]):
            sizes = counted(len(cells), "cells"), counted(len(columns), "columns")
            said.add(row, None, f"has {sizes[0]}, but the heading names {sizes[1]}.")
        for column, cell in zip(columns, (*cells, *[""] * len(columns)), strict=False):
            if column is None:
                continue
            if column.kind is not None:
                values[column.key].append(_number(sheet, row, column, cell, said))
            elif column.key == "part":
                _name(row, column, cell, names, said)
    _ratings(columns, values, body, said)
    said.raise_any()
    units = {one.key: one.unit for one in columns if one is not None and one.kind is not None}
    arrays = {key: np.array(column) for key, column in values.items()}
    for both, own in (("shear", "stiffness"), ("shear_damping", "damping")):
        if both in arrays:
            across, unit = arrays.pop(both), units.pop(both)
            arrays |= {f"{own}_x": across, f"{own}_y": across}
            units |= {f"{own}_x": unit, f"{own}_y": unit}
    return Catalogue(file, tuple(names), tuple(names.values()), arrays, units)


def _name(row: int, column: Column, cell: str, names: dict[str, int], said: _Said) -> None:
    if not cell:
        said.add(row, column, "is empty. Every part needs a name.")
    elif cell in names:
        said.add(row, column, f"{_quoted(cell)} is the name of the part in row {names[cell]} too. Give each its own.")
    else:
        names[cell] = row


def _number(sheet: Sheet, row: int, column: Column, cell: str, said: _Said) -> float:
    assert column.kind is not None
    if not cell:
        if column.key not in _OPTIONAL:
            said.add(row, column, "is empty. Write a number, or leave the part out.")
        return 0.0
    try:
        value = column.scale.to_si(float(sheet.number(bare(cell, column.unit)).replace("−", "-")))
    except ValueError:
        said.add(row, column, f"{_quoted(cell)} is no number. Write one in the unit of the heading, without it.")
        return 0.0
    if not np.isfinite(value):
        said.add(row, column, f"{_quoted(cell)} is no finite number.")
    elif value < 0.0:
        said.add(row, column, f"{cell} is negative. Write its size.")
    elif value == 0.0 and not column.kind.zero:
        said.add(row, column, f"{cell} is not greater than zero.")
    elif 0.0 < value < LEAST or value > LARGEST:
        said.add(row, column, f"{cell} is beyond what any part has.")
    elif column.key == "tolerance" and value >= 1.0:
        said.add(row, column, f"{cell} may leave nothing of the part. Write less than 100 %.")
    return value


def _ratings(
    columns: list[Column | None], values: dict[str, list[float]], body: list[tuple[int, tuple[str, ...]]], said: _Said
) -> None:
    if "rated_min" not in values:
        return
    place = next(column for column in columns if column is not None and column.key == "rated_min")
    for (row, cells), low, high in zip(body, values["rated_min"], values["rated_max"], strict=True):
        if low > high > 0.0:
            cell = cells[columns.index(place)]
            said.add(row, place, f"{cell} is a least load above the greatest. Exchange the two.")
