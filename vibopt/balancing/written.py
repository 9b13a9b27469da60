"""Readings of a run as they stand in the file, all sensors side by side, and their numbers as arrays."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from vibopt.forms import FloatArray
from vibopt.records import dataclass

_NUMBER = r"[^\S\n]*([-+]?[\d.]+(?:[eE][-+]?\d+)?)[^\S\n]*"
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


def numbers(texts: Sequence[Sequence[str]]) -> FloatArray | None:
    """Rows of decimal numbers as an array; None where one is none, or is beyond all floats."""
    try:
        found = np.array([list(map(float, row)) for row in texts])
    except ValueError:
        return None
    return found if np.isfinite(found).all() else None


def are_plain(texts: Sequence[str]) -> bool:
    """Whether texts consist of the signs of decimal numbers alone, none of them empty."""
    return "" not in texts and not "".join(texts).strip("0123456789+-.eE")
