"""A shaft seen from the side: what sits on it, and what holds or watches it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from vibopt.records import dataclass
from vibopt.report.figures.canvas import Box, Canvas, caption_height, captions, captions_levels
from vibopt.report.figures.paper import BLUE, FAINT, INK, SIZE

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
        canvas.down(self.height)

    @staticmethod
    def _tall(some: Sequence[Piece]) -> float:
        words = [one.words for one in some]
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
__all__ = ["Piece", "Shaft"]
