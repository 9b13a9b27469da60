"""Lines for a terminal: wrapped texts, tables without lines, colour where it is wanted; laid out as rich lays them."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from unicodedata import category, east_asian_width

from vibopt.records import dataclass

_CODES = {"bold": "1", "dim": "2", "red": "31", "green": "32", "yellow": "33"}
_WORD = re.compile(r"\s*\S+\s*")
_NUMBER = re.compile(r"([-−+]?[\d.,]+(?:e[-+]?\d+)?) ([^\d@][^@]*)")
_WHOLE = re.compile(r"\[[^]\s]+ [^]\s]+]|\S+")
"""Words, and a unit of two in brackets as one."""
_STEP = re.compile(r"(?<=[^\W\d]\.)(?=[^\W\d])")
"""Behind a point of a path."""
_CONTROLS = dict.fromkeys((7, 8, 11, 12, 13))


@dataclass(frozen=True)
class Grid:
    """A table without lines; columns stand `gap` apart, those numbered in `whole` are never broken.

    `widths` are those of all columns, where they do not follow from the texts.  In a `series` each column is one
    quantity: where its rows are too long for a line, units stand in the headings.
    """

    rows: Sequence[Sequence[str]]
    heads: Sequence[str] = ()
    whole: Sequence[int] = ()
    widths: Sequence[int] = ()
    gap: int = 2
    series: bool = False


class Console:
    """Takes texts and tables, and holds the lines that they are.

    Parameters
    ----------
    width
        Columns to fill.
    colour
        Whether escape codes for colour may be written.
    """

    def __init__(self, width: int, *, colour: bool = False) -> None:
        self.width, self.colour = width, colour
        self.lines: list[str] = []

    def print(self, what: str | Grid = "", *, style: str = "", indent: int = 0) -> None:
        """A wrapped text or a table, indented; `style` is as "bold green"."""
        wide = max(self.width - indent, 1)
        lines = _grid(what, wide, self._styled) if isinstance(what, Grid) else wrapped(what, wide)
        self.lines += [" " * indent + (self._styled(line, style) if style else line) for line in lines]

    def _styled(self, text: str, style: str) -> str:
        if not self.colour or not text.strip():
            return text
        return f"\x1b[{';'.join(_CODES[one] for one in style.split())}m{text.rstrip()}\x1b[0m"

    @property
    def text(self) -> str:
        """What has been printed, without blanks at the ends of lines."""
        return "".join(f"{line.rstrip()}\n" for line in self.lines)


_MOST_WHOLE = 0.8
"""Part of a line that columns which are not broken may take together."""
_LEAST_ROOM = 10
"""Columns of a line that are left at most to each column of a table whose words may be broken."""


def wrapped(text: str, width: int, *, whole: bool = False) -> list[str]:
    """A text in lines of at most `width` columns: broken between words, in words only where one is longer than a line.

    A path is then broken behind its points.  With `whole` a line is cut off instead.
    """
    lines = []
    for line in text.translate(_CONTROLS).split("\n"):
        line = line.expandtabs()
        if whole:
            lines.append(_pieces(line, width)[0] if line else "")
            continue
        cuts = [0, *_breaks(line, width), len(line)]
        lines += [
            _pieces(one.rstrip(), width)[0] if one.strip() else ""
            for one in map(line.__getitem__, map(slice, cuts, cuts[1:]))
        ]
    return lines


def _breaks(line: str, width: int) -> list[int]:
    """Where a line is broken."""
    found: list[int] = []
    filled = 0
    for match in _WORD.finditer(line):
        start, word = match.start(), match.group()
        long = columns(word.rstrip())
        if filled + long <= width:
            filled += columns(word)
        elif long > width:
            for piece in _parts(word, width):
                if start:
                    found.append(start)
                start, filled = start + len(piece), columns(piece)
        else:
            if start:
                found.append(start)
            filled = columns(word)
    return found


def _parts(word: str, width: int) -> list[str]:
    """A word that is longer than a line, cut behind the points of a path if it can be, else every `width` columns."""
    parts = [""]
    for step in _STEP.split(word):
        if columns(parts[-1] + step.rstrip()) > width:
            parts += _pieces(step, width)
        else:
            parts[-1] += step
    return parts if parts[0] else parts[1:]


def _pieces(text: str, width: int) -> list[str]:
    """A text cut every `width` columns."""
    pieces, here, filled = [], "", 0
    for letter in text:
        wide = columns(letter)
        if filled + wide > width and here:
            pieces.append(here)
            here, filled = "", 0
        here, filled = here + letter, filled + wide
    return [*pieces, here]


def columns(text: str) -> int:
    """Columns that a text takes: two for a wide letter, none for what stands on another."""
    if text.isascii():
        return len(text)
    return sum(
        0 if category(one) in ("Mn", "Me", "Cf") else 2 if east_asian_width(one) in ("W", "F") else 1 for one in text
    )


def _grid(grid: Grid, width: int, styled: Callable[[str, str], str]) -> list[str]:
    """Lines of a table."""
    rows = [list(grid.heads), *grid.rows] if grid.heads else list(grid.rows)
    count = len(grid.heads) or len(grid.widths) or max((len(row) for row in rows), default=1)
    rows = [[*row, *[""] * (count - len(row))] for row in rows]
    gaps = [grid.gap] * (count - 1) + [0]
    natural = _natural(rows, count)
    if grid.series and sum(natural) + sum(gaps) > width:
        rows = [list(row) for row in zip(*map(_under_its_unit, zip(*rows, strict=True)), strict=True)]
        natural = _natural(rows, count)
    wide = [min((grid.widths[k] if grid.widths else natural[k]) + gaps[k], width) or 1 for k in range(count)]
    whole = set(grid.whole) if grid.widths else _kept_whole(grid.whole, wide, width)
    may = [not grid.widths and k not in whole for k in range(count)]
    words = [{word for row in rows for word in _WHOLE.findall(row[k])} for k in range(count)]
    longest = [max(map(columns, own), default=0) + gaps[k] for k, own in enumerate(words)]
    if sum(one if may[k] else wide[k] for k, one in enumerate(longest)) > width:  # paths are broken behind points
        steps = [{step for word in own for step in _STEP.split(word)} for own in words]
        longest = [max(map(columns, own), default=0) + gaps[k] for k, own in enumerate(steps)]
    wide = _by_words(wide, longest, may, width)
    lines = []
    for number, row in enumerate(rows):
        cells = [wrapped(row[k], max(wide[k] - gaps[k], 1), whole=k in whole) for k in range(count)]
        high = max(map(len, cells))
        head = bool(grid.heads) and not number  # headings stand on the rows below them
        for level in range(high):
            at = [level - (high - len(cell)) * head for cell in cells]
            parts = [cell[i] if 0 <= i < len(cell) else "" for cell, i in zip(cells, at, strict=True)]
            line = "".join(part + " " * (wide[k] - columns(part)) for k, part in enumerate(parts))
            lines.append(styled(line, "dim") if head else line)
    return lines


def _natural(rows: Sequence[Sequence[str]], count: int) -> list[int]:
    """Columns that the longest line of each cell takes."""
    return [max((columns(line) for row in rows for line in row[k].split("\n")), default=0) for k in range(count)]


def _under_its_unit(column: Sequence[str]) -> Sequence[str]:
    """A column whose numbers have one unit, with that in its heading."""
    head, *cells = column
    found = [_NUMBER.fullmatch(cell) for cell in cells if cell not in ("", "-")]
    units = {one[2] if one else "" for one in found}
    if len(units) != 1 or units == {""}:
        return column
    (unit,) = units
    return [f"{head}\n[{unit}]", *(cell.removesuffix(f" {unit}") for cell in cells)]


def _kept_whole(whole: Sequence[int], wide: Sequence[int], room: int) -> set[int]:
    """Columns that are not broken: the widest are where all together would leave the others no room."""
    kept = sorted((k for k in whole if k < len(wide)), key=lambda k: wide[k])
    while kept and sum(wide[k] for k in kept) > (_MOST_WHOLE * room if len(kept) < len(wide) else room):
        kept.pop()
    return set(kept)


def _by_words(widths: Sequence[int], longest: Sequence[int], may_shrink: Sequence[bool], room: int) -> list[int]:
    """Widths as `fitted`, but down to the longest word of a column alone, as far as that leaves the others room."""
    wide, may = list(widths), list(may_shrink)
    while True:
        found = fitted(wide, may, room)
        cut = [k for k, one in enumerate(may) if one and found[k] < longest[k]]
        k = min(cut, key=lambda k: longest[k], default=-1)
        kept = longest[k] + sum(one for one, shrinks in zip(wide, may, strict=True) if not shrinks)
        others = sum(min(_LEAST_ROOM, longest[j]) for j, shrinks in enumerate(may) if shrinks and j != k)
        if not cut or kept + others > room:
            return found
        wide[k], may[k] = longest[k], False


def fitted(widths: Sequence[int], may_shrink: Sequence[bool], room: int) -> list[int]:
    """Widths with a sum within the room: the widest of those that may shrink give way first, then all."""
    found = list(widths)
    while (excess := sum(found) - room) > 0 and any(may_shrink):
        most = max(one for one, may in zip(found, may_shrink, strict=True) if may)
        second = max(one if may and one != most else 0 for one, may in zip(found, may_shrink, strict=True))
        widest = [may and one == most for one, may in zip(found, may_shrink, strict=True)]
        if most == second:
            break
        found = _reduced(excess, widest, [min(excess, most - second)] * len(found), found)
    excess = sum(found) - room
    return _reduced(excess, [True] * len(found), found, found) if excess > 0 else found


def _reduced(total: int, which: Sequence[bool], most: Sequence[int], widths: Sequence[int]) -> list[int]:
    """Widths with a total taken off some of them in equal parts, of each no more than `most`."""
    shares = sum(may and bool(one) for may, one in zip(which, most, strict=True))
    found = []
    for may, limit, width in zip(which, most, widths, strict=True):
        if may and limit:
            taken = min(limit, round(total / shares))
            found.append(width - taken)
            total, shares = total - taken, shares - 1
        else:
            found.append(width)
    return found
