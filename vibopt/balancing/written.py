"""Readings of a run as they stand in the file, all sensors side by side, and their numbers as arrays."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from math import prod
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray, IntArray

_NUMBER = r"[^\S\n]*([-+]?[\d.]+(?:[eE][-+]?\d+)?)[^\S\n]*"
Texts = tuple[str, ...]
Words = np.ndarray[Any, np.dtype[np.unsignedinteger[Any]]]
_MANY = 2000
"""Numbers from which on they are read all at once."""
_NO_SIGNS = str.maketrans("", "", "0123456789+-.eE")
_PHASOR = re.compile(rf"^{_NUMBER}([^@\n]*)(?:@{_NUMBER}([^\n]*))?$", re.MULTILINE)


class Written(Mapping[str, str]):
    """Readings of one run by the name of the sensor: their numbers and units as texts, put together when looked at.

    parsed
        Amounts and angles as written (2, n_sensors); None where that is yet to be done.
    """

    __slots__ = ("amounts", "angles", "names", "parsed", "turns", "units")

    def __init__(
        self, names: Texts, amounts: Texts, units: Texts, angles: Texts, turns: Texts, parsed: FloatArray | None = None
    ) -> None:  # fmt: skip
        self.names, self.parsed = names, parsed
        self.amounts, self.units, self.angles, self.turns = amounts, units, angles, turns

    @staticmethod
    def of(names: Sequence[str], texts: Sequence[str]) -> Written | None:
        """Parts of "8.6 mil pp @ 63 deg", no angle as ""; None where a text is none of this shape."""
        joined = "\0".join(texts).replace("\n", " ").replace("\0", "\n").replace("−", "-")
        found = _PHASOR.findall(joined)
        if len(found) != len(texts) or not texts:
            return None
        amounts, units, angles, turns = zip(*found, strict=True)
        return Written(tuple(names), amounts, tuple(map(str.strip, units)), angles, tuple(map(str.strip, turns)))

    def __getitem__(self, name: str) -> str:
        if name not in self.names:
            raise KeyError(name)
        place = self.names.index(name)
        amount = f"{self.amounts[place]} {self.units[place]}".strip()
        return f"{amount} @ {self.angles[place]} {self.turns[place]}".strip()

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)


def numbers(texts: Sequence[str], shape: tuple[int, ...]) -> FloatArray | None:
    """Plain decimal numbers as an array; None where one is none, or is beyond all floats."""
    if len(texts) != prod(shape):
        return None
    short = short_numbers(texts) if len(texts) > _MANY else None
    if short is not None:
        return short.reshape(shape)
    if "".join(texts).translate(_NO_SIGNS):
        return None
    try:
        found = np.fromiter(map(float, texts), float, len(texts))
    except ValueError:
        return None
    return found.reshape(shape) if np.isfinite(found).all() else None


def short_numbers(texts: Sequence[str]) -> FloatArray | None:
    """Numbers of one to 15 digits without an exponent, to the bit as `float` reads them; None where one is another.

    All at once: eight digits are the bytes of one word, whose neighbours are joined to pairs, to fours, to eight
    (Lemire, Number parsing at a gigabyte per second, 2021); whole numbers below 2^53 over a power of ten round once.
    """
    raw = np.frombuffer(f"{' ' * 16}\n{chr(10).join(texts)}\n".encode("ascii", "replace"), dtype=np.uint8)
    points = np.flatnonzero(raw == ord("."))
    bare = np.delete(raw, points)
    cells, ends = np.flatnonzero(raw == ord("\n")), np.flatnonzero(bare == ord("\n"))
    minus = bare[ends[:-1] + 1] == ord("-")
    digits, pointed = np.diff(ends) - 1 - minus, np.diff(cells) - np.diff(ends)
    strange = np.count_nonzero(bare - np.uint8(ord("0")) > 9) - 16 - len(ends) - np.count_nonzero(minus)
    if strange or len(digits) != len(texts) or not 1 <= digits.min() <= digits.max() <= 15 or pointed.max() > 1:
        return None
    long = np.flatnonzero(digits > 8)
    whole = _eight(bare, ends[1:], np.minimum(digits, 8))
    whole[long] += 10**8 * _eight(bare, ends[1:][long] - 8, digits[long] - 8)
    behind = np.zeros(len(texts), dtype=int)
    behind[pointed == 1] = cells[1:][pointed == 1] - points - 1
    found: FloatArray = whole / (10.0 ** np.arange(16))[behind]
    return np.where(minus, -found, found)


def _eight(text: Words, ends: IntArray, digits: IntArray) -> Words:
    """Whole numbers of one to eight digits that end before `ends`."""
    gone = (64 - 8 * digits).astype(np.uint64)
    words: Words = np.ndarray(len(text) - 7, "<u8", text, strides=(1,))[ends - 8] >> gone << gone
    words &= 0x0F0F0F0F0F0F0F0F
    for ones, bits, kept in (10, 8, 0x00FF00FF00FF00FF), (100, 16, 0x0000FFFF0000FFFF), (10_000, 32, 0xFFFFFFFF):
        words *= (ones << bits) + 1
        words >>= bits
        words &= kept
    return words


def phasors(names: Texts, texts: list[Any]) -> list[Written] | None:
    """Rows of texts such as "8.6 mil pp @ 63 deg", each of all `names`, that have the units of the first throughout.

    None for others.
    """
    try:
        joined = "\n".join(texts)
    except TypeError:  # where one is no text
        return None
    first = _PHASOR.fullmatch(texts[0]) if texts else None
    if first is None or not first[3]:
        return None
    between, behind = texts[0][first.end(1) : first.start(3)], texts[0][first.end(3) :]
    pairs = f"{joined}\n".replace(between, "\t").replace(f"{behind}\n", "\n")
    if pairs.translate(_NO_SIGNS) != "\t\n" * len(texts):
        return None
    parts, n = tuple(pairs[:-1].replace("\t", "\n").split("\n")), len(names)
    values = numbers(parts, (len(texts) // n, n, 2))
    if values is None:
        return None
    units, turns = (first[2].strip(),) * n, (first[4].strip(),) * n
    return [
        Written(names, parts[at : at + 2 * n : 2], units, parts[at + 1 : at + 2 * n : 2], turns, own)
        for at, own in zip(range(0, len(parts), 2 * n), values.swapaxes(1, 2), strict=True)
    ]


def columns(
    names: tuple[str, ...], units: tuple[str, ...], turns: tuple[str, ...],
    amounts: Sequence[tuple[str, ...]], angles: Sequence[tuple[str, ...]],
) -> list[Written] | None:  # fmt: skip
    """Rows of plain numbers with the units of their columns; None for others."""
    values = numbers([*chain(*amounts), *chain(*angles)], (2, len(amounts), len(names)))
    if values is None:
        return None
    return [
        Written(names, sizes, units, turned, turns, own)
        for sizes, turned, own in zip(amounts, angles, values.swapaxes(0, 1), strict=True)
    ]
