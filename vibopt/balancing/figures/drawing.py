"""What figures of balancing jobs are made of beside dials: a page of parts, a shaft from the side, bars, the key."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from textwrap import wrap
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from vibopt.records import dataclass
from vibopt.report.figures.canvas import Box, Canvas, caption_height, captions, captions_levels
from vibopt.report.figures.paper import BLUE, FAINT, INK, RED, SIZE, WIDTH, dress

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Part(Protocol):
    """So many inches of a page, from the top of what is free."""

    @property
    def height(self) -> float: ...

    def draw(self, canvas: Canvas) -> None: ...


COMPACT = 9.4
"""Inches across where a page holds more: what is drawn is then printed smaller."""


def page(parts: Iterable[Part], title: str, width: float = WIDTH) -> Figure:
    """Parts under each other."""
    kept = list(parts)
    canvas = Canvas(width, sum(one.height for one in kept), title)
    for one in kept:
        begun = canvas.used
        one.draw(canvas)
        canvas.used = begun + one.height
    return canvas.figure


MOST = 40
BEFORE = {"color": "white", "edgecolor": FAINT, "hatch": "////", "lw": 0.8}
AFTER = {"color": BLUE, "edgecolor": INK, "lw": 0.8}


@dataclass(frozen=True, slots=True)
class Bar:
    """One pair of bars in the unit of its axes; `after` None: only what was found."""

    name: str
    before: float | None
    after: float | None
    limit: float | None = None
    band: tuple[float, float] | None = None


@dataclass(frozen=True)
class Bars:
    """Horizontal bars from the top down; of many the worst MOST."""

    title: str
    unit: str
    bars: Sequence[Bar]

    @property
    def height(self) -> float:
        lines = max((len(bar.name.split("\n")) for bar in self.bars), default=1)
        return 0.85 + (0.26 if lines == 1 else 0.30) * min(len(self.bars), MOST)

    def draw(self, canvas: Canvas) -> None:
        self.within(canvas, 0.0, canvas.width)

    def within(self, canvas: Canvas, left: float, width: float) -> None:
        """Drawn into a part of the width."""
        letters = max((len(line) for bar in self.bars for line in bar.name.split("\n")), default=1)
        names = 0.62 * letters * (SIZE - 1) / 72.0 + 0.22
        _draw(canvas.plot(Box(left, self.height, width), left=names, below=0.48), self)


def _draw(axes: Any, given: Bars) -> None:
    shown, title = list(given.bars), given.title
    if len(shown) > MOST:
        shown = sorted(shown, key=lambda one: one.after or 0.0, reverse=True)[:MOST]
        title = f"{title}: the worst {MOST} of {len(given.bars)}"
    dress(axes, title, given.unit, "")
    rows = np.arange(len(shown))
    for offset, look, values in (
        (-0.2, BEFORE, [one.before for one in shown]),
        (0.2, AFTER, [one.after for one in shown]),
    ):
        kept = [(row, value) for row, value in zip(rows, values, strict=True) if value is not None]
        if kept:
            axes.barh([row + offset for row, _ in kept], [value for _, value in kept], height=0.38, zorder=3, **look)
    for row, one in zip(rows, shown, strict=True):
        if one.band is not None:
            axes.plot(one.band, [row + 0.2, row + 0.2], color=INK, lw=1.4, marker="|", ms=7, zorder=5)
        if one.limit is not None:
            axes.plot([one.limit, one.limit], [row - 0.45, row + 0.45], color=RED, lw=2.4, zorder=6)
    axes.set_yticks(rows, [one.name for one in shown], fontsize=SIZE - 1)
    axes.set_ylim(len(shown) - 0.4, -0.6)
    axes.set_xlim(left=0.0)
    axes.grid(False, axis="y")


@dataclass(frozen=True)
class Key:
    """Caption and legend below everything, only with what is drawn; `whole` weights stand instead of what is on."""

    caption: str
    dials: bool
    limits: bool
    bands: bool = False
    fitted: bool = True
    removed: bool = False
    masses: bool = False
    circles: bool = False
    before: bool = True
    after: bool = True
    whole: bool = False

    @property
    def height(self) -> float:
        return 0.165 * len(self._lines) + 0.21 * -(-len(self._entries()) // COLUMNS) + 0.16

    @property
    def _lines(self) -> list[str]:
        return [line for part in self.caption.split("\n") for line in wrap(part, 112)]

    def draw(self, canvas: Canvas) -> None:
        found = self._entries()
        canvas.figure.legend(
            [one for one, _ in found],
            [words for _, words in found],
            loc="lower center",
            bbox_to_anchor=(0.5, 1.0 - (canvas.used + self.height) / canvas.height),
            borderaxespad=0.2,
            ncols=min(len(found), COLUMNS),
            fontsize=SIZE - 1,
            frameon=False,
            title="\n".join(self._lines),
            title_fontsize=SIZE - 0.5,
        )

    def _entries(self) -> list[tuple[Any, str]]:
        from matplotlib.lines import Line2D
        from matplotlib.patches import Patch

        line: Any = Line2D
        disc = [
            (self.masses, line([], [], ls="", marker="s", mfc="white", mec=INK), "known mass"),
            (
                self.dials and self.fitted,
                line([], [], ls="", ms=8, marker="o", mfc=BLUE, mec=INK),
                "whole weight" if self.whole else "fit here",
            ),
            (
                self.dials and self.removed,
                line([], [], ls="", ms=8, marker="X", mfc="white", mec=RED),
                "take away here",
            ),
            (self.dials, line([], [], ls="", marker="v", color=INK, ms=7), "zero mark"),
        ]
        open_, full = (" (on a dial: open circle)", " (on a dial: diamond)") if self.circles else ("", "")
        bars = [
            (self.before, Patch(facecolor="white", edgecolor=FAINT, hatch="////"), f"as found{open_}"),
            (self.after, Patch(facecolor=BLUE, edgecolor=INK), f"after{full}"),
            (self.limits, line([], [], color=RED, lw=2.0), "limit"),
            (self.bands, line([], [], color=INK, lw=1.2, marker="|"), "95 % band"),
        ]
        return [(handle, words) for wanted, handle, words in (*disc, *bars) if wanted]


COLUMNS = 4


SMALL = SIZE - 1.5
EDGE = 0.5
"""Inches beside the ends of the shaft."""


@dataclass(frozen=True, slots=True)
class Piece:
    """At a place along the shaft [m, or any other measure]: a "plane", "mass", "bearing" or "sensor" with its words."""

    at: float
    words: str
    kind: str


@dataclass(frozen=True, slots=True)
class Shaft:
    """Pieces named above and below the shaft, and a note where their places are not to scale."""

    above: tuple[Piece, ...]
    below: tuple[Piece, ...]
    note: str = ""

    @property
    def height(self) -> float:
        return 1.0 + self._tall(self.above) + self._tall(self.below) + (0.2 if self.note else 0.0)

    def draw(self, canvas: Canvas) -> None:
        """Places are to scale, from the first to the last."""
        low = self._tall(self.below) + 0.5 + (0.2 if self.note else 0.0)
        axes = canvas.part(Box(0.0, self.height, canvas.width), origin=(0.0, low))
        places = [one.at for one in (*self.above, *self.below)]
        first, length = min(places), max(places) - min(places)
        across = canvas.width - 4.0 * EDGE

        def x(at: float) -> float:
            return 2.0 * EDGE + across * ((at - first) / length if length > 0.0 else 0.5)

        axes.plot(
            [1.3 * EDGE, canvas.width - 1.3 * EDGE], [0.0, 0.0], color=INK, lw=3.0, solid_capstyle="butt", zorder=1
        )
        for one in (*self.above, *self.below):
            _KINDS[one.kind](axes, x(one.at))
        span = (0.05, canvas.width - 0.05)
        for some, start, away in ((self.above, 0.3, 1.0), (self.below, -0.24, -1.0)):
            captions(axes, [(x(one.at), one.words) for one in some], start=start, away=away, span=span, size=SMALL)
        if self.note:
            axes.text(0.5 * canvas.width, 0.04 - low, self.note, ha="center", va="bottom", fontsize=SMALL, color=FAINT)

    @staticmethod
    def _tall(some: Sequence[Piece]) -> float:
        words = [piece.words for piece in some]
        return caption_height(words, captions_levels(words, 7.3, SMALL), SMALL)


def _plane(axes: Any, x: float) -> None:
    """A disc, edge on."""
    axes.fill([x - 0.05, x + 0.05, x + 0.05, x - 0.05], [-0.3, -0.3, 0.3, 0.3], fc="white", ec=INK, lw=1.2, zorder=3)
    axes.plot([x - 0.05, x + 0.05], [0.0, 0.0], color=BLUE, lw=2.0, zorder=4)


def _mass(axes: Any, x: float) -> None:
    axes.plot([x, x], [0.0, 0.2], color=INK, lw=1.0, zorder=2)
    axes.plot([x], [0.22], marker="s", ms=6, mfc="white", mec=INK, ls="", zorder=3)


def _bearing(axes: Any, x: float) -> None:
    """A support on hatched ground."""
    axes.fill([x, x - 0.09, x + 0.09], [-0.02, -0.19, -0.19], fc="white", ec=INK, lw=1.0, zorder=3)
    for k in range(4):
        axes.plot([x - 0.1 + 0.06 * k, x - 0.14 + 0.06 * k], [-0.19, -0.25], color=FAINT, lw=0.8, zorder=2)


def _sensor(axes: Any, x: float) -> None:
    """What watches the shaft from below."""
    axes.fill([x, x - 0.05, x + 0.05], [-0.05, -0.15, -0.15], fc=INK, ec=INK, lw=0.6, zorder=3)
    axes.plot([x, x], [-0.15, -0.24], color=INK, lw=1.4, zorder=2)


_KINDS = {"plane": _plane, "mass": _mass, "bearing": _bearing, "sensor": _sensor}
