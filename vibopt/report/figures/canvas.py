"""A page on which parts are placed in inches: what stands where is known before anything is drawn."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.records import dataclass
from vibopt.report.figures.paper import FAINT, INK, SIZE

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True)
class Box:
    """A part of the page [inches]: from its left edge, so high and so wide, at the top of what is free."""

    left: float
    height: float
    width: float


class Canvas:
    """A figure of a known size; parts are taken from the top down."""

    def __init__(self, width: float, height: float, title: str = "") -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self.width, self.height = width, height + (TITLE if title else 0.0)
        self.figure: Figure = Figure(figsize=(self.width, self.height), facecolor="white")
        FigureCanvasAgg(self.figure)
        self.used = 0.0
        if title:
            size = min(SIZE + 3, 72.0 * self.width / (LETTER * len(title)))
            y = 1.0 - 0.5 * TITLE / self.height
            self.figure.text(0.5, y, title, ha="center", va="center", fontsize=size, fontweight="bold", color=INK)
            self.down(TITLE)

    def part(self, box: Box, *, origin: tuple[float, float]) -> Any:
        """Axes without frame in inches, with their origin at a place of the box."""
        axes: Any = self._axes(box.left, box.height, box.width, box.height)
        axes.set_xlim(-origin[0], box.width - origin[0])
        axes.set_ylim(-origin[1], box.height - origin[1])
        axes.set_axis_off()
        return axes

    def plot(self, box: Box, *, left: float, below: float) -> Any:
        """Axes with room [inches] for their numbers, labels and title."""
        wide, tall = box.width - left - 0.12, box.height - below - 0.3
        return self._axes(box.left + left, box.height - below, wide, tall)

    def down(self, height: float) -> None:
        """What was placed has taken so much."""
        self.used += height

    def _axes(self, left: float, drop: float, width: float, height: float) -> Any:
        bottom = self.height - self.used - drop
        where = (left / self.width, bottom / self.height, width / self.width, height / self.height)
        return self.figure.add_axes(where)


TITLE = 0.38


def spread(wanted: Sequence[float], tall: Sequence[float]) -> list[float]:
    """Middles of boxes from the top down, as near as can be to where they are wanted without one covering another.

    Boxes that would touch are moved together, in the middle of where they are wanted (pool of adjacent violators).
    """
    pools: list[tuple[float, float, int]] = []  # sum of wanted tops less what stands above, weight, how many
    above = np.concatenate([[0.0], np.cumsum(tall)])
    for k, (y, h) in enumerate(zip(wanted, tall, strict=True)):
        pool = (y + 0.5 * h + above[k], 1.0, 1)
        while pools and pools[-1][0] / pools[-1][1] < pool[0] / pool[1]:
            last = pools.pop()
            pool = (last[0] + pool[0], last[1] + pool[1], last[2] + pool[2])
        pools.append(pool)
    tops = [total / weight for total, weight, count in pools for _ in range(count)]
    return [top - above[k] - 0.5 * tall[k] for k, top in enumerate(tops)]


LETTER, LINE = 0.66, 1.3
"""Widest mean letter and height of a line, as parts of the size of the letters."""


def wide(words: str, size: float) -> float:
    """Inches that words take at most, beside others."""
    return LETTER * size * max(map(len, words.split("\n"))) / 72.0 + 0.05


def captions(
    axes: Any, words: Sequence[tuple[float, str]], *, start: float, away: float, span: tuple[float, float], size: float
) -> None:
    """Words above (`away` 1) or below (-1) the height `start`, each tied to its x.

    Axes in inches; words stay within `span`, in several lines where they are many.
    """
    order = sorted(range(len(words)), key=lambda k: words[k][0])
    levels = captions_levels([words[k][1] for k in order], span[1] - span[0], size)
    tall = caption_height([one for _, one in words], 1, size)
    for level in range(levels):
        row = order[level::levels]
        y = start + away * (0.16 + level * tall)
        for k, x in zip(
            row, along([words[k][0] for k in row], [wide(words[k][1], size) for k in row], span), strict=True
        ):
            axes.plot([words[k][0], x], [start, y], color=FAINT, lw=0.5, zorder=2)
            axes.text(x, y, words[k][1], ha="center", va="bottom" if away > 0 else "top", fontsize=size, color=INK,
                      linespacing=1.1, zorder=5, bbox={"fc": "white", "ec": "none", "pad": 0.6})  # fmt: skip


def captions_levels(words: Sequence[str], room: float, size: float) -> int:
    """Lines that words beside each other need."""
    return max(1, -(-int(1000 * 1.1 * sum(wide(word, size) for word in words)) // int(1000 * room)))


def caption_height(words: Sequence[str], levels: int, size: float) -> float:
    """Inches that so many lines of words need."""
    lines = max((len(word.split("\n")) for word in words), default=0)
    return levels * (LINE * lines * size / 72.0 + 0.05)


def along(wanted: Sequence[float], widths: Sequence[float], span: tuple[float, float]) -> list[float]:
    """Middles from left to right near where they are wanted, apart and within the span."""
    found = [-value for value in spread([-x for x in wanted], widths)]
    high = span[1]
    for k in reversed(range(len(found))):
        found[k] = min(found[k], high - 0.5 * widths[k])
        high = found[k] - 0.5 * widths[k]
    low = span[0]
    for k in range(len(found)):
        found[k] = max(found[k], low + 0.5 * widths[k])
        low = found[k] + 0.5 * widths[k]
    return found


def fitted_rows(labels: Sequence[tuple[float, float]], width: float) -> list[tuple[int, float]]:
    """Line and left end of words (left end wanted, width): in the lowest line where they cover no others."""
    found: dict[int, tuple[int, float]] = {}
    ends: list[list[tuple[float, float]]] = []
    for k in sorted(range(len(labels)), key=lambda k: labels[k][0]):
        x, size = labels[k]
        x = max(min(x, width - size - 0.02), 0.02)
        row = next((i for i, some in enumerate(ends) if all(x > b or x + size < a for a, b in some)), len(ends))
        ends.extend([[]] if row == len(ends) else [])
        ends[row].append((x, x + size))
        found[k] = row, x
    return [found[k] for k in range(len(labels))]
