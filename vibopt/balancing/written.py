"""Readings of a run as they stand in the file, all sensors side by side, and their numbers as arrays."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.records import dataclass

_NUMBER = r"[^\S\n]*([-+]?[\d.]+(?:[eE][-+]?\d+)?)[^\S\n]*"
_NO_SIGNS = str.maketrans("", "", "0123456789+-.eE")
_PHASOR = re.compile(rf"^{_NUMBER}([^@\n]*)(?:@{_NUMBER}([^\n]*))?$", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Written:
    """Numbers and units of amplitudes, and of their angles, as texts; one entry a sensor."""

    amounts: tuple[str, ...]
    units: tuple[str, ...]
    angles: tuple[str, ...]
    turns: tuple[str, ...]

    @staticmethod
    def of(texts: Sequence[str]) -> Written | None:
        """Parts of "8.6 mil pp @ 63 deg", no angle as ""; None where a text is none of this shape."""
        joined = "\0".join(texts).replace("\n", " ").replace("\0", "\n").replace("−", "-")
        found = _PHASOR.findall(joined)
        if len(found) != len(texts) or not texts:
            return None
        amounts, units, angles, turns = zip(*found, strict=True)
        return Written(amounts, tuple(map(str.strip, units)), angles, tuple(map(str.strip, turns)))

    def text(self, place: int) -> str:
        """One reading in one piece."""
        amount = f"{self.amounts[place]} {self.units[place]}".strip()
        return f"{amount} @ {self.angles[place]} {self.turns[place]}".strip()


class WrittenByName(Mapping[str, str]):
    """Readings of one run by the name of the sensor, put together where they are looked at.

    parsed
        Amounts and angles as written (2, n_sensors).
    """

    def __init__(self, names: tuple[str, ...], written: Written, parsed: FloatArray) -> None:
        self.names, self.written, self.parsed = names, written, parsed

    def __getitem__(self, name: str) -> str:
        if name not in self.names:
            raise KeyError(name)
        return self.written.text(self.names.index(name))

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)


def numbers(joined: str, shape: tuple[int, ...]) -> tuple[list[str], FloatArray] | None:
    """Plain decimal numbers in lines, and the same as an array; None where one is none, or is beyond all floats."""
    if joined.translate(_NO_SIGNS).strip("\n"):
        return None
    parts = joined.split("\n")
    try:
        found = np.array(parts, dtype=float)
    except ValueError:
        return None
    return (parts, found.reshape(shape)) if np.isfinite(found).all() else None


def phasors(names: tuple[str, ...], rows: Sequence[Sequence[str]]) -> list[WrittenByName] | None:
    """Rows of texts such as "8.6 mil pp @ 63 deg" that have the units of their first throughout; None for others."""
    texts = [text for row in rows for text in row]
    first = _PHASOR.fullmatch(texts[0]) if texts and set(map(type, texts)) == {str} else None
    if first is None or not first[3]:
        return None
    between, behind = texts[0][first.end(1) : first.start(3)], texts[0][first.end(3) :]
    pairs = f"{chr(10).join(texts)}\n".replace(between, "\t").replace(f"{behind}\n", "\n")
    if pairs.translate(_NO_SIGNS) != "\t\n" * len(texts):
        return None
    flat, n = pairs[:-1].replace("\t", "\n"), len(names)
    read = numbers(flat, (len(rows), n, 2))
    if read is None:
        return None
    parts, values = read
    return _by_name(
        names, parts[::2], parts[1::2], (first[2].strip(),) * n, (first[4].strip(),) * n, values.swapaxes(1, 2)
    )


def columns(
    names: tuple[str, ...], units: tuple[str, ...], turns: tuple[str, ...], rows: Sequence[str], n_rows: int
) -> list[WrittenByName] | None:
    """Rows of amounts, then of angles, as numbers in lines, with the units of their columns; None for others."""
    read = numbers("\n".join(rows), (2, n_rows, len(names)))
    if read is None:
        return None
    parts, values = read
    half = len(parts) // 2
    return _by_name(names, parts[:half], parts[half:], units, turns, values.swapaxes(0, 1))


def _by_name(
    names: tuple[str, ...], amounts: list[str], angles: list[str], units: tuple[str, ...], turns: tuple[str, ...],
    values: FloatArray,
) -> list[WrittenByName]:  # fmt: skip
    n = len(names)
    return [
        WrittenByName(names, Written(tuple(amounts[at : at + n]), units, tuple(angles[at : at + n]), turns), own)
        for at, own in zip(range(0, len(amounts), n), values, strict=True)
    ]
