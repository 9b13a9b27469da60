"""Blocks of words and tables of which answers are made, for the terminal and for the printed page alike."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from vibopt.answer.entry import Checked, Entry, Value, in_one_unit
from vibopt.records import dataclass

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer

LEAD, TODO, TABLE, TEXT, WORK, FOOT = "lead", "todo", "table", "text", "work", "foot"
"""Kinds of block: why there is no answer; what to do; a table; sentences; what only the next job needs; conventions,
model, method and notes."""

WARNING = "Warning"
SIDES = {"at_most": "at most", "at_least": "at least", "outside": "outside"}


@dataclass(frozen=True, slots=True)
class Block:
    """A title with sentences, or with a table; a cell of two lines holds a line feed.

    whole
        Columns that are never broken.
    measured
        Whether a page to sign has an empty column beside it for what is then measured.
    on_sheet
        Whether a page to sign has it.
    """

    title: str
    kind: str = TABLE
    lines: tuple[str, ...] = ()
    heads: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    whole: tuple[int, ...] = ()
    measured: bool = False
    on_sheet: bool = True


def table(
    title: str,
    heads: Sequence[str],
    given: Sequence[Sequence[str | Value]],
    kind: str = TABLE,
    whole: Sequence[int] | None = None,
) -> Block:
    """A table without the columns in which nothing stands; unless `whole` names some, none is ever broken.

    Numbers of a column that measure the same thing are shown in one unit where the user gave none.
    """
    rows = told(given)
    kept = [k for k in range(len(heads)) if any(row[k] for row in rows)]
    cells = tuple(tuple(row[k] for k in kept) for row in rows)
    unbroken = kept if whole is None else [k for k in kept if k in whole]
    named = tuple(heads[k] for k in kept)
    return Block(
        title, kind, heads=named if any(named) else (), rows=cells, whole=tuple(kept.index(k) for k in unbroken)
    )


def told(rows: Sequence[Sequence[str | Value]]) -> list[list[str]]:
    """Rows as texts, each column in one unit a dimension."""
    columns = [in_one_unit(column) for column in zip(*rows, strict=True)]
    return [[one if isinstance(one, str) else one.shown for one in row] for row in zip(*columns, strict=True)]


def pairs(title: str, rows: Sequence[tuple[str | Value, ...]], whole: Sequence[int] = ()) -> Block:
    """A table without heads."""
    return table(title, ("",) * max(map(len, rows), default=0), rows, whole=whole)


def cleaned(entry: Value, scale: Value | None) -> Value:
    """Zero where the value is nothing but rounding beside `scale`."""
    if not isinstance(entry, Entry) or not isinstance(scale, Entry) or abs(entry.value) >= 1e-9 * abs(scale.value):
        return entry
    return replace(entry, value=0.0)


def spoken(response: str, place: str = "") -> str:
    """A response with its place: "transmitted force into ground"."""
    return f"{response.replace('_', ' ')} {place}".rstrip()


def spoken_path(path: str) -> str:
    """A number by its path, as one says it: "mass of press", "limit start_up, at most"."""
    family, *steps = path.split(".")
    words = [step.replace("_", " ") for step in steps]
    if not words:
        return family.replace("_", " ")
    if len(words) == 1:
        return f"{words[0]} of {family.replace('_', ' ')}"
    rest = " ".join(words[1:])
    owner = f"{family.removesuffix('s')} {steps[0]}" if steps[0].isdigit() else steps[0]
    return f"limit {steps[0]}, {rest}" if family == "limits" else f"{rest} of {owner}"


def at_words(worst_at: Mapping[str, Entry]) -> str:
    """Where the worst is reached: "1437 rpm"; with several excitations each by name."""
    if len(worst_at) == 1:
        return next(iter(worst_at.values())).shown
    return ", ".join(f"{name} {entry.shown}" for name, entry in worst_at.items())


def value_at(row: Checked) -> str:
    """Value and place of the worst: "infinite at 954 rpm"."""
    at = at_words(row.worst_at)
    return f"{row.value.shown} at {at}" if at else row.value.shown


def limits_block(answer: Answer[Any], title: str = "Limits", *, states: bool = True) -> Block:
    """One row of two lines per limit: what and where, how far, what is allowed, what is left over."""
    rows = [
        (
            f"{limit.name}\n  {spoken(limit.response, limit.place)}",
            "\n".join(
                [cleaned(limit.value, limit.limit).shown, *(f"at {at}" for at in [at_words(limit.worst_at)] if at)]
            ),
            f"{SIDES.get(limit.side, '')}\n{limit.limit.shown if limit.limit is not None else ''}",
            f"{limit.margin_shown}\n{limit.state if states else ''}".strip("\n"),
        )
        for limit in answer.limits.values()
    ]
    return Block(title, heads=("Limit", "Worst", "Allowed", "Margin"), rows=tuple(rows))


def nearest_block(answer: Answer[Any], of_which: str = "") -> Block:
    """Each limit on the nearest design: what is allowed, how far it is missed, and what any design could do for it."""
    near = answer.nearest
    if near is None:
        return Block("")
    rows = []
    for key, limit in near.limits.items():
        least = near.least.get(key)
        at = at_words(limit.worst_at)
        rows.append(
            (
                f"{limit.name}\n  {spoken(limit.response, limit.place)}",
                f"{SIDES.get(limit.side, '')}\n{limit.limit.shown if limit.limit is not None else ''}",
                f"{cleaned(limit.value, limit.limit).shown}\n{f'at {at}' if at else ''}".rstrip(),
                limit.missed_by,
                f"{least.value.shown}\n{least.known}{'' if least.enough else ', not enough'}"
                if least is not None
                else "",
            )
        )
    heads = ("Limit", "Allowed", "Nearest", "Missed by", "Best alone")
    title = "How near it comes, and what each limit could be alone" if near.least else "How near it comes"
    return table(f"{title}{of_which}", heads, rows, whole=(1, 3))


def prices_block(answer: Answer[Any]) -> Block:
    """What a wider limit or cap buys."""
    bought = {name: limit.price for name, limit in answer.limits.items() if limit.price is not None} | dict(
        answer.prices
    )
    return pairs("What loosening a limit buys", [(name, price.words) for name, price in bought.items() if price.words])


def measures_block(answer: Answer[Any]) -> Block:
    """One row per measure."""
    values = in_one_unit(measure.value for measure in answer.measures.values())
    shown = [replace(measure, value=value) for measure, value in zip(answer.measures.values(), values, strict=True)]
    rows = [(checked.name, spoken(checked.response, checked.place), value_at(checked)) for checked in shown]
    return pairs("Measures", rows)


def rows_of(answer: Answer[Any]) -> list[Block]:
    """Limits, what loosening them buys, and measures."""
    return [limits_block(answer), prices_block(answer), measures_block(answer)]
