"""A record: the acceleration of a base or a force on a body as it was measured, from a CSV file."""

import math
import re
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import BeforeValidator, PrivateAttr, ValidationInfo, WithJsonSchema, model_validator

from vibopt.arrays import FloatArray, IntArray
from vibopt.errors import InputError, QuantityError, counted
from vibopt.excitations.directed import Directed
from vibopt.excitations.excitation import Transient
from vibopt.excitations.segments import line
from vibopt.files.reading import FileFault, file_of, stamp_of
from vibopt.signals import Segment
from vibopt.units import best_unit, read_quantity, reads, show
from vibopt.values import Fact, number, word
from vibopt.values.csv_tables import SHEET, Sheet, bare, heading_of, sheet_of, text_of
from vibopt.values.fields import complaint

_MOST, _PREAMBLE = 200_000, 100
_EVEN, _DIGITS, _ROUNDED = 1e-6, 9, 0.51
_OTHERS = {
    "time": "a time is no motion. Name another column",
    "length": "a displacement is not what a record says. Write the acceleration that belongs to it",
    "velocity": "a velocity is not what a record says. Write the acceleration that belongs to it",
}
_GROUND_UNIT = re.compile(r"\bunits?\s*(?:of|:|=)\s*([^\s,;]+(?:\s*/\s*[^\s,;]+)*)", re.IGNORECASE)
_GAP, _GAPS, _ALIKE, _REST = 20.0, 1.5, 0.01, 0.75
"""Times the usual step beyond which a record is none, and from which samples are missing where the rest is even; part
by which even steps may differ, and part of all that is the rest."""


def _file(given: object, info: ValidationInfo) -> Path:
    if isinstance(given, Path):
        return given
    if not isinstance(given, str):
        raise complaint('is no file name. Write it in quotation marks: "record.csv".')
    try:
        stamp_of(file := file_of(given), SHEET)
    except FileFault as fault:
        raise complaint(fault.text) from None
    return file


RecordFile = Annotated[
    Path, BeforeValidator(_file), WithJsonSchema({"type": "string", "description": "a CSV file: time and value"})
]


class Record(Transient, Directed):
    """`kind = "record"`: acceleration of a base or force on a body from a CSV file, straight between its samples.

    Keys
    ----
    file: With a heading that says the unit, "acceleration [m/s²]" or "force [N]": `file = "record.csv"`. Times stand
        in a column "time [s]", or the samples are one `interval` apart. A ground record `.at2` of the PEER databases
        says all itself, in the unit of its heading (G, CM/S/S, ...). Lines of a logger above the heading are left out.
    column: The heading of the column to take, where there are several: `column = "acceleration"`.
    interval: Time from sample to sample, where the file has no column of times: `interval = "5 ms"`.
    factor: By which the record is multiplied: `factor = 1.5`.
    """

    file: RecordFile
    column: str | None = None
    interval: Fact | None = number("time", choice=False)
    factor: Fact | None = number("ratio", choice=False, sign="any")
    _samples: "_Samples" = PrivateAttr()

    @model_validator(mode="after")
    def _read(self) -> "Record":
        try:
            self._samples = _samples_of(self.file, self.column, self.interval.value if self.interval else None)
        except InputError as error:
            raise word(error.messages[0]) from None
        return self

    @property
    def family(self) -> str:  # type: ignore[override]  # only the unit tells force from motion
        """Where it acts: a force on bodies, an acceleration of bases."""
        return "bodies" if self._samples.kind == "force" else "bases"

    @property
    def remark(self) -> str:
        if not self.values.any():
            nothing = "its factor is" if self._samples.values.any() else "all of its samples are"
            return f"{nothing} zero: it shakes nothing."
        return self._samples.gaps

    @property
    def times(self) -> FloatArray:
        """Of the samples [s], (n,), the first zero."""
        return self._samples.times

    @cached_property
    def values(self) -> FloatArray:
        """Samples [N] or [m/s^2], (n,)."""
        return self._samples.values * (self.factor.value if self.factor is not None else 1.0)

    @property
    def length(self) -> float:
        return float(self.times[-1])

    @property
    def joints(self) -> tuple[float, ...]:
        return 0.0, self.length

    @property
    def kinks(self) -> FloatArray:
        return self.times

    @property
    def step(self) -> float:
        return float(np.diff(self.times).mean()) if self.even else float(np.diff(self.times).min())

    @property
    def straight(self) -> bool:
        return True

    def segments(self) -> tuple[Segment, ...]:
        return self._lines

    @cached_property
    def _lines(self) -> tuple[Segment, ...]:
        steps, values = np.diff(self.times), self.values.tolist()
        if self.even:  # one length, which is stepped over at once
            steps = np.full(len(steps), self.length / len(steps))
        lengths = steps.tolist()
        return tuple(
            line(length, first, last) for length, first, last in zip(lengths, values, values[1:], strict=False)
        )

    @cached_property
    def even(self) -> bool:
        """Whether its samples are evenly spaced, up to the digits of a file."""
        steps = np.diff(self.times)
        return bool(np.ptp(steps) <= _EVEN * steps.mean())

    def signal(self, time: FloatArray) -> FloatArray:
        value: FloatArray = np.asarray(np.interp(time, self.times, self.values, left=0.0, right=0.0), dtype=float)
        return value


class _Samples(NamedTuple):
    """Times from zero [s], values [SI], what they are, and what is said of samples that are missing."""

    times: FloatArray
    values: FloatArray
    kind: str
    gaps: str = ""


def _samples_of(file: Path, column: str | None, interval: float | None) -> _Samples:
    """Samples left out of an even record are filled in."""
    if file.suffix.lower() == ".at2":
        return _ground_record(file, column, interval)
    found = _columns_of(file, column, interval)
    times, step = found.times, float(np.diff(found.times).min())
    places = np.round(times / step)
    if places[-1] + 1 == len(times) or np.abs(times - places * step).max() > _EVEN * step:
        return found
    even = np.linspace(0.0, times[-1], int(places[-1]) + 1)
    return found._replace(times=even, values=np.interp(even, times, found.values))


def _ground_record(file: Path, column: str | None, interval: float | None) -> _Samples:
    """A ground record of the PEER databases: four lines of heading with the unit, NPTS and DT, then accelerations."""
    for key, given in (("column", column), ("interval", interval)):
        if given is not None:
            raise InputError(f"{file.name} is a ground record, whose heading says all. Remove {key}.")
    lines = text_of(file).splitlines()
    heading = " ".join(lines[:6])
    found = [re.search(rf"{key}\s*=\s*([\d.eE+-]+)", heading, re.IGNORECASE) for key in ("NPTS", "DT")]
    begin = next((i for i, one in enumerate(lines[:6], start=1) if re.search(r"NPTS", one, re.IGNORECASE)), 0)
    try:
        count, step = (float(match[1]) for match in found if match is not None)
        values = np.array(" ".join(lines[begin:]).split(), dtype=float)
    except ValueError:
        raise InputError(
            f'{file.name} is no ground record: its heading has no "NPTS= 4000, DT= .0100 SEC", or what follows is no '
            "numbers. Write it as a CSV file with time [s] and acceleration [g]."
        ) from None
    if len(values) != count or len(values) < 2 or not step > 0.0 or not np.isfinite(values).all():
        raise InputError(
            f"{file.name} has {counted(len(values), 'samples')} {step:g} s apart, and its heading says {count:g}. "
            "Mend the file."
        )
    if re.search(r"DT\s*=\s*[\d.eE+-]+\s*[mµu]", heading, re.IGNORECASE):
        raise InputError(f'{file.name} has a DT that is not in seconds. Write "DT= .0100 SEC" into its heading.')
    scale, kind = _ground_unit(file.name, lines[:begin])
    return _Samples(np.linspace(0.0, (len(values) - 1) * step, len(values)), values * scale, kind)


def _ground_unit(file: str, heading: list[str]) -> tuple[float, str]:
    """SI value of one, and what it is, from "ACCELERATION TIME SERIES IN UNITS OF CM/S/S" in a heading."""
    said = next((match for line in heading if (match := _GROUND_UNIT.search(line))), None)
    if said is None:
        raise InputError(
            f'{file} says no unit. Write it into its heading: "ACCELERATION TIME SERIES IN UNITS OF G", or CM/S/S.'
        )
    line = said.string.strip()
    for name, other in (("velocity", "velocity"), ("displacement", "length")):
        if name in line.lower():
            raise InputError(f'{file} says "{line}", and {_OTHERS[other]}.')
    unit = re.sub(r"\s", "", said[1].rstrip(".").lower()).replace("sec", "s").replace("gal", "Gal")
    return _unit(f'{file}, "{line}",', unit, 'ACCELERATION TIME SERIES IN UNITS OF G", or CM/S/S')


def _columns_of(file: Path, column: str | None, interval: float | None) -> _Samples:
    """Those of a table."""
    sheet = sheet_of(file, _above_heading)
    if len(sheet.rows) < 3:
        samples = max(len(sheet.rows) - 1, 0)
        raise InputError(
            f"{file.name} has {counted(samples, 'rows')} below its first, and a record needs two. Write a "
            "heading with units, and a row a sample."
        )
    if len(sheet.rows) > _MOST:
        raise InputError(f"{file.name} has {len(sheet.rows)} rows, more than the {_MOST} that are read.")
    headings = [heading_of(one) for one in sheet.rows[0][1]]
    if all(_is_number(one) for one, _ in headings):
        raise InputError(
            f'{file.name} begins with numbers. Write a heading with units into its first row: "time [s],acceleration '
            '[m/s²]".'
        )
    long = next((row for row, cells in sheet.rows if len(cells) > len(headings)), None)
    if long is not None:
        raise InputError(
            f"{file.name} row {long} has more cells than its heading. Part columns by semicolons where numbers have "
            "decimal commas, or remove what has no heading."
        )
    at_time = _time_column(headings)
    told = [
        i for i, one in enumerate(headings) if any(one) or any(cells[i : i + 1] != ("",) for _, cells in sheet.rows)
    ]
    if at_time is None and interval is None and column is None and len(told) > 1:
        named = ", ".join(f'"{sheet.rows[0][1][i]}"' for i in told)
        raise InputError(
            f'{file.name} has columns {named}, and none of them is the time. Write units in brackets: "time [s]", '
            '"acceleration [m/s²]"; or interval = "5 ms", and the column.'
        )
    where = _column(file.name, headings, [i for i in told if i != at_time], column)
    name, unit = headings[where]
    scale, kind = _unit(f'{file.name}, column "{name}",', unit, f'{name} [m/s²]", or [g] for gravity, or [N]')
    values = _numbers(file.name, sheet, where, headings[where][1]) * scale
    if at_time is not None and interval is not None:
        raise InputError(f"{file.name} has a column of times, beside interval in the problem file. Remove interval.")
    if at_time is None and interval is None:
        raise InputError(
            f'{file.name} has no column "time [s]", and nothing says how far apart its samples are. Write interval = '
            '"5 ms" where they are evenly spaced.'
        )
    if at_time is None:
        return _Samples(np.linspace(0.0, (len(values) - 1) * float(interval or 0.0), len(values)), values, kind)
    return _timed(file.name, sheet, at_time, headings[at_time][1], _Samples(values, values, kind))


def _above_heading(lines: list[str]) -> int:
    """Lines above the first that says the unit of an acceleration or a force, as loggers write them; 0 without one."""
    for above, text in enumerate(lines[:_PREAMBLE]):
        for cell in re.split(r"[,;\t]", text):
            with suppress(QuantityError, InputError):
                _unit("", heading_of(cell.strip().strip('"'))[1], "")
                return above
    return 0


def _time_column(headings: list[tuple[str, str]]) -> int | None:
    """The column named so, or the only one that has a unit of time."""
    named = next((i for i, (name, _) in enumerate(headings) if name.lower() in ("time", "t")), None)
    timed = [i for i, (_, unit) in enumerate(headings) if reads(f"1 {unit}", "time")] if named is None else []
    return timed[0] if len(timed) == 1 else named


def _column(file: str, headings: list[tuple[str, str]], others: list[int], column: str | None) -> int:
    if column is None and len(others) == 1:
        return others[0]
    names = {i: headings[i][0].lower() for i in others}
    if column is not None:
        asked = {column.lower(), heading_of(column)[0].lower()}
        found = next((i for i in others if names[i] in asked), None)
        if found is not None:
            return found
    if column is None and len({*names.values()}) < len(others):
        raise InputError(f"{file} has two columns of one name. Give each its own in the heading.")
    known = ", ".join(f'"{headings[i][0]}"' for i in others)
    said = f'has no column "{column}"' if column is not None else "has several columns"
    raise InputError(f"{file} {said}. Write column = one of {known}.")


def _unit(where: str, unit: str, way: str) -> tuple[float, str]:
    """SI value of one, and what it is; `way` is what a heading may say instead."""
    for kind in ("acceleration", "force"):
        try:
            return read_quantity(f"1 {unit}", kind).value, kind
        except QuantityError:
            continue
    said = f'has the unit "{unit}", of neither an acceleration nor a force' if unit else "says no unit"
    for other, what in _OTHERS.items():
        with suppress(QuantityError):
            read_quantity(f"1 {unit}", other)
            raise InputError(f'{where} has the unit "{unit}", and {what}.')
    raise InputError(f'{where} {said}. Write it into the heading: "{way}.')


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _numbers(file: str, sheet: Sheet, where: int, unit: str) -> FloatArray:
    found = np.empty(len(sheet.rows) - 1)
    for i, (row, cells) in enumerate(sheet.rows[1:]):
        cell = cells[where] if where < len(cells) else ""
        try:
            value = float(sheet.number(bare(cell, unit)))
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            said = f'"{cell[:30]}" is no number' if cell else "there is no number"
            raise InputError(f"{file} row {row}: {said}. Every sample needs its value; remove the row or mend it.")
        found[i] = value
    return found


def _timed(file: str, sheet: Sheet, where: int, unit: str, samples: _Samples) -> _Samples:
    """Samples with their times from a column; one that is written twice counts once."""
    try:
        scale = read_quantity(f"1 {unit}", "time").value
    except QuantityError:
        raise InputError(f'{file}, column "time", needs a unit of time. Write the heading "time [s]".') from None
    times = _numbers(file, sheet, where, unit) * scale
    steps: Any = np.diff(times)
    rows = np.array([row for row, _ in sheet.rows[1:]])
    wrong = (
        (steps < 0.0, "the time falls from the row before. Sort the rows"),
        ((steps == 0.0) & (np.diff(samples.values) != 0.0), "the time of the row before, with another value. Keep one "
         "of both, or write times with more digits"),
    )  # fmt: skip
    for found, said in wrong:
        if found.any():
            raise InputError(f"{file} row {rows[1 + int(np.argmax(found))]}: {said}.")
    kept = np.append(True, steps > 0.0)
    times, rows, steps = times[kept], rows[kept], steps[steps > 0.0]
    if len(times) < 2:
        raise InputError(f"{file} has one time in all of its rows, and a record needs two.")
    wide = steps > _GAP * np.median(steps)
    if wide.any():
        row = rows[1 + int(np.argmax(wide))]
        raise InputError(
            f"{file} row {row}: more than {_GAP:g} samples are missing before it. Fill the gap, or cut the record."
        )
    gaps = _gaps(file, steps, rows)
    return _Samples(_evened(times - times[0], scale), samples.values[kept], samples.kind, gaps)


def _gaps(file: str, steps: FloatArray, rows: IntArray) -> str:
    """Where samples are missing in a record that is even otherwise."""
    usual = float(np.median(steps))
    wide = int((steps > _GAPS * usual).sum())
    if not wide or (np.abs(steps - usual) <= _ALIKE * usual).mean() < _REST:
        return ""
    widest, unit = int(steps.argmax()), best_unit(usual, "time")
    much, rest = (show(value, unit, "time") for value in (float(steps[widest]), usual))
    several = f"at {wide} places, the widest" if wide > 1 else "once,"
    return (
        f"samples are missing in {file} {several} before row {rows[widest + 1]} ({much} where the rest is {rest} "
        "apart). What lies there is taken as straight; fill it in where it is not."
    )


def _evened(times: FloatArray, scale: float) -> FloatArray:
    """Times that are evenly spaced but for the digits that a file writes, evenly spaced."""
    even = np.linspace(0.0, times[-1], len(times))
    for digits in range(_DIGITS):
        step = scale * 10.0**-digits
        if np.abs(times - step * np.round(times / step)).max() <= _EVEN * step:
            return even if np.abs(times - even).max() <= _ROUNDED * step else times
    return times
