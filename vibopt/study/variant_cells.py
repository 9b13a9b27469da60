"""Entries and lines of a table of variants, what their bought parts cost, and which entry of a line is the best."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import isfinite

from vibopt.answer.entry import Entry, Value
from vibopt.records import dataclass
from vibopt.report.machine_words import listed
from vibopt.responses.price import TotalPrice
from vibopt.scene.places import bought
from vibopt.scene.scene import Design
from vibopt.verify.certify import measure
from vibopt.verify.checked import in_usual_unit

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


def row_of(kind: str, name: str, values: Sequence[Value | None]) -> Row:
    """A line of numbers or words as an answer has them; the unit is that of the first number."""
    unit = next((value.si for value in values if isinstance(value, Entry)), "")
    numbers = [value.value if isinstance(value, Entry) else None for value in values]
    cells = [None if one is None else Cell(one.shown, number) for one, number in zip(values, numbers, strict=True)]
    return Row(kind, name, unit, tuple(cells))


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
    read = [cell.text if cell is not None else "" for cell in cells] if said is None else said
    values = {i: sense * cell.value for i, cell in enumerate(cells) if cell is not None and cell.value is not None}
    racing = [i for i in values if rivals[i]]
    if not racing:
        return tuple(cells)
    first = max(racing, key=values.__getitem__)

    def alike(i: int) -> bool:
        return (bool(read[i]) and read[i] == read[first]) or _same(values[i], values[first], least)

    if all(alike(i) for i in values):
        return tuple(cells)
    return tuple(
        replace(cell, best=True) if cell is not None and i in racing and alike(i) else cell
        for i, cell in enumerate(cells)
    )


def _same(value: float, other: float, least: float) -> bool:
    if not (isfinite(value) and isfinite(other)):
        return value == other
    return abs(value - other) <= max(SAME * max(abs(value), abs(other)), least)


def price_of(design: Design, chosen: Mapping[str, float]) -> Entry | None:
    """What all bought parts cost together; None where nothing is bought, or a catalogue has no prices."""
    parts = bought(design.scene)
    if not parts or any(part.price is None for part in parts.values()):
        return None
    response = TotalPrice(response="price")
    return in_usual_unit(design.scene, response, measure(design.scene, chosen, response).value)


def price_words(price: Entry, design: Design, designs: Sequence[Design]) -> str:
    """The price, and what of that which other variants buy it does not hold: "80 EUR without feet"."""
    missing = _not_bought(design, designs)
    return f"{price.shown} without {listed(missing)}" if missing else price.shown


def comparable(designs: Sequence[Design]) -> list[bool]:
    """Per variant whether its price is that of everything that any variant buys, all in one currency."""
    currencies = {part.price.unit for each in designs for part in bought(each.scene).values() if part.price is not None}
    return [
        len(currencies) == 1 and bool(bought(design.scene)) and not _not_bought(design, designs) for design in designs
    ]


def _not_bought(design: Design, designs: Sequence[Design]) -> list[str]:
    """Names of what is made to order here and bought in another variant."""
    scene, mine = design.scene, bought(design.scene)
    own = [f"links.{name}" for name in scene.links] + [f"mounts.{name}" for name in scene.mounts]
    others = dict.fromkeys(path for one in designs for path in bought(one.scene))
    return [path.split(".", 1)[1] for path in others if path in own and path not in mine]
