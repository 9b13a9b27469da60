"""Entries and lines of a table of variants, and which entry of a line is the best."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import isfinite

from vibopt.records import dataclass

SAME = 1e-6
"""Part by which entries of a row may differ and be the same: what a search leaves open, what a file rounds."""
NOTHING = 1e-12
"""Entries that differ by less than this [SI] do not differ."""


@dataclass(frozen=True, slots=True)
class Cell:
    """One entry: its number [SI] where it has one, and its text; `best` among those of its row."""

    text: str
    value: float | None = None
    best: bool = False


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the table, an entry per variant; None where a variant has nothing there.

    kind
        "verdict", "goal", "chosen", "fact", "price", "limit", "measure", "frequency" or "reason".
    unit
        SI unit of the numbers.
    """

    kind: str
    name: str
    unit: str
    cells: tuple[Cell | None, ...]


def marked(
    cells: Sequence[Cell | None],
    sense: float,
    rivals: Sequence[bool],
    said: Sequence[str] | None = None,
    least: float = NOTHING,
) -> tuple[Cell | None, ...]:
    """The best of a row marked, where others are worse by more than rounding and read otherwise; one of `rivals`.

    said
        The compared numbers as they are read, where that is not the text.
    least
        What counts as no difference at all.
    """
    read = [one.text if one is not None else "" for one in cells] if said is None else said
    values = {i: sense * one.value for i, one in enumerate(cells) if one is not None and one.value is not None}
    racing = [i for i in values if rivals[i]]
    if not racing:
        return tuple(cells)
    first = max(racing, key=values.__getitem__)

    def alike(i: int) -> bool:
        return (bool(read[i]) and read[i] == read[first]) or _same(values[i], values[first], least)

    if all(alike(i) for i in values):
        return tuple(cells)
    return tuple(
        replace(one, best=True) if one is not None and i in racing and alike(i) else one for i, one in enumerate(cells)
    )


def _same(one: float, other: float, least: float) -> bool:
    if not (isfinite(one) and isfinite(other)):
        return one == other
    return abs(one - other) <= max(SAME * max(abs(one), abs(other)), least)


__all__ = ["SAME", "Cell", "Row", "marked"]
