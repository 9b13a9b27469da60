"""Blocks of words and tables of which balancing answers are made, for the terminal and for the printed page alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from vibopt.answer.entry import Entry, Value

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer

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


def cleaned(entry: Value, scale: Value | None) -> Value:
    """Zero where the value is nothing but rounding beside `scale`."""
    if not isinstance(entry, Entry) or not isinstance(scale, Entry) or abs(entry.value) >= 1e-9 * abs(scale.value):
        return entry
    return replace(entry, value=0.0)


def limit_blocks(answer: Answer[Any]) -> list[Block]:
    """Limits, what loosening them buys, and measures: one row each."""
    limits = [
        (name, f"{one.response.replace('_', ' ')} {one.place}".strip(), cleaned(one.value, one.limit).shown,
         one.limit.shown if one.limit is not None else "", one.margin_shown, one.state)
        for name, one in answer.limits.items()
    ]  # fmt: skip
    bought = {name: one.price for name, one in answer.limits.items() if one.price is not None} | dict(answer.prices)
    prices = [(name, one.words) for name, one in bought.items() if one.words]
    measures = [
        (name, f"{one.response.replace('_', ' ')} {one.place}".strip(), one.value.short(5))
        for name, one in answer.measures.items()
    ]
    return [
        table("Limits", ("Limit", "Of", "Worst", "At most", "Margin", ""), limits, whole=(2, 3, 4, 5)),
        table("What loosening a limit buys", ("", ""), prices, whole=(0,)),
        table("Measures", ("", "", ""), measures, whole=(2,)),
    ]
