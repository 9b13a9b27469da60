"""Blocks of words and tables of which balancing answers are made, for the terminal and for the printed page alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite

from vibopt.balancing.outcome import Entry
from vibopt.units import plain, show

TODO, TABLE, TEXT, WORK, FOOT = "todo", "table", "text", "work", "foot"
"""Kinds of block: what to do; a table; sentences; what only the next job needs; conventions, notes, method."""

WARNING = "Warning"


@dataclass(frozen=True, slots=True)
class Block:
    """A title with sentences, or with a table; a cell of two lines holds a line feed.

    whole
        Columns that are never broken.
    """

    title: str
    kind: str = TABLE
    lines: tuple[str, ...] = ()
    heads: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    whole: tuple[int, ...] = ()


def table(
    title: str,
    heads: Sequence[str],
    rows: Sequence[Sequence[str]],
    kind: str = TABLE,
    whole: Sequence[int] | None = None,
) -> Block:
    """A table without the columns in which nothing stands."""
    kept = [k for k in range(len(heads)) if any(row[k] for row in rows)]
    cells = tuple(tuple(row[k] for k in kept) for row in rows)
    unbroken = kept if whole is None else [k for k in kept if k in whole]
    named = tuple(heads[k] for k in kept)
    return Block(
        title, kind, heads=named if any(named) else (), rows=cells, whole=tuple(kept.index(k) for k in unbroken)
    )


def brief(entry: Entry, digits: int = 4) -> str:
    """A number as people copy it: four digits, angles to a tenth of a degree."""
    if isinstance(entry.value, str):
        return entry.value
    if entry.dimension == "angle":
        from vibopt.balancing.words import show_angle

        return show_angle(entry.value)
    return show(entry.value, entry.unit, entry.dimension, digits=digits, amplitude=entry.amplitude)


def cleaned(entry: Entry, scale: Entry | None) -> Entry:
    """Zero where the value is nothing but rounding beside `scale`."""
    if scale is None or isinstance(scale.value, str) or isinstance(entry.value, str):
        return entry
    small = abs(entry.value) < 1e-9 * abs(scale.value)
    return Entry(0.0, entry.dimension, entry.unit, entry.amplitude) if small else entry


def share(part: float) -> str:
    """What is left of a limit in percent; "" without a limit."""
    if not isfinite(part):
        return ""
    percent = 100.0 * part
    return f"{plain(0.0 if abs(percent) < 1e-4 else percent, 2 if abs(percent) < 10 else 3)} %"


def state(margin: float, met: bool) -> str:
    """BROKEN, ACTIVE or nothing."""
    return "BROKEN" if not met else "ACTIVE" if margin < 1e-6 else ""
