"""Readings of a run as they stand in the file, all sensors side by side, and their numbers as arrays."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from math import prod

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


def numbers(texts: list[str], shape: tuple[int, ...]) -> FloatArray | None:
    """Plain decimal numbers as an array; None where one is none, or is beyond all floats."""
    if len(texts) != prod(shape) or "".join(texts).translate(_NO_SIGNS):
        return None
    try:
        found = np.array(texts, dtype=float)
    except ValueError:
        return None
    return found.reshape(shape) if np.isfinite(found).all() else None


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
    parts, n = pairs[:-1].replace("\t", "\n").split("\n"), len(names)
    amounts, angles = ([tuple(parts[at : at + 2 * n : 2]) for at in range(side, len(parts), 2 * n)] for side in (0, 1))
    return columns(names, (first[2].strip(),) * n, (first[4].strip(),) * n, amounts, angles)


def columns(
    names: tuple[str, ...], units: tuple[str, ...], turns: tuple[str, ...],
    amounts: Sequence[tuple[str, ...]], angles: Sequence[tuple[str, ...]],
) -> list[WrittenByName] | None:  # fmt: skip
    """Rows of plain numbers with the units of their columns; None for others."""
    values = numbers([*chain(*amounts), *chain(*angles)], (2, len(amounts), len(names)))
    if values is None:
        return None
    return [
        WrittenByName(names, Written(sizes, units, turned, turns), own)
        for sizes, turned, own in zip(amounts, angles, values.swapaxes(0, 1), strict=True)
    ]
