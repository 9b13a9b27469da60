"""Strokes against their limits, and natural frequencies against the speeds of the excitations."""

from __future__ import annotations

from itertools import groupby
from math import isfinite
from typing import Any

from vibopt.records import dataclass
from vibopt.report.absorber_parts import Modes, Strokes, modes, strokes
from vibopt.report.figures.paper import COLOURS, FAINT, INK, RED, SIZE, dress, forbidden, legend
from vibopt.scene.scene import Design
from vibopt.units import plain

_FILLS = ("#5b7fb0", "#d8dde6", "#93a9c7", "#3a4a5f")
_BANDS = ("#cfd8e6", "#eadfd2", "#dcdcdc", "#d5e6dc")
_MARKS = ("////", "\\\\\\\\", "....", "xxxx")
_CLOSE = 0.075
"""Part of the axis within which the numbers of two modes stand in two rows."""


@dataclass(frozen=True, slots=True)
class StrokesBelow:
    """Bars, one for each absorber and excitation."""

    strokes: Strokes
    title: str = "Stroke of each absorber"

    @property
    def height(self) -> float:
        return 1.5 + 0.36 * len(self.strokes.bars)

    def draw(self, part: Any) -> None:
        """Length is the stroke, the red line its limit, hatched beyond."""
        shown = self.strokes
        axes = part.subplots()
        dress(axes, self.title, shown.label, "")
        finite = [one for one in (*shown.values, *(one for one in shown.limits if one)) if isfinite(one)]
        end, names = 1.3 * max(finite, default=1.0), list(dict.fromkeys(bar.absorber for bar in shown.bars))
        for row, (bar, value, limit) in enumerate(zip(shown.bars, shown.values, shown.limits, strict=True)):
            fill = _FILLS[names.index(bar.absorber) % len(_FILLS)]
            axes.barh(row, min(value, end), height=0.55, color=fill, edgecolor=INK, lw=0.7, zorder=3)
            if limit is not None:
                _limit(axes, row, limit, end)
            look = {"va": "center", "fontsize": SIZE - 1, "color": INK, "zorder": 6, "bbox": _BOX}
            beside = {"xytext": (7, 0), "textcoords": "offset points"}
            axes.annotate(shown.words[row], (min(value, 0.5 * end), row), **beside, **look)
        axes.set_yticks(
            range(len(shown.bars)), [f"{stroke_bar.absorber}\n{stroke_bar.excitation}" for stroke_bar in shown.bars]
        )
        axes.set_ylim(len(shown.bars) - 0.5, -0.5)
        axes.set_xlim(0.0, end)
        axes.grid(False, axis="y")
        legend(part, axes)


def below(design: Design) -> list[StrokesBelow | ModesBelow]:
    """What stands under the responses of a design with absorbers."""
    bars, marks = strokes(design), modes(design)
    found: list[StrokesBelow | ModesBelow] = []
    if bars is not None:
        found.append(StrokesBelow(bars))
    if marks is not None:
        found.append(ModesBelow(marks))
    return found


_BOX = {"boxstyle": "round,pad=0.12", "fc": "white", "ec": "none", "alpha": 0.9}


def _limit(axes: Any, row: int, limit: float, end: float) -> None:
    axes.fill_betweenx([row - 0.45, row + 0.45], limit, end, label="beyond the limit", zorder=1.0, **forbidden())
    axes.plot([limit, limit], [row - 0.45, row + 0.45], color=RED, lw=1.8, zorder=4, solid_capstyle="butt")


@dataclass(frozen=True, slots=True)
class ModesBelow:
    """A mark per mode, without absorbers and with them."""

    modes: Modes
    title: str = "Natural frequencies against the speeds of the excitations"

    @property
    def height(self) -> float:
        return 2.7

    def draw(self, part: Any) -> None:
        """Bands of the excitations shaded, modes as marks with their numbers."""
        shown = self.modes
        axes = part.subplots()
        dress(axes, self.title, shown.label, "")
        axes.set_xlim(*shown.span)
        for index, (_, group) in enumerate(groupby(shown.bands, key=lambda speed_band: speed_band.excitation)):
            for band in group:
                _shade(axes, band.low, band.high, band.words, index)
        for row, (values, sign) in enumerate(((shown.before, "o"), (shown.after, "D"))):
            axes.axhline(row, color=FAINT, lw=0.7, zorder=1.5)
            inside = [value for value in values if shown.span[0] <= value <= shown.span[1]]
            axes.plot(inside, [row] * len(inside), sign, ms=7, mfc="white", mec=COLOURS[0], mew=1.6, zorder=5)
            _numbers(axes, inside, row, shown.span)
        axes.set_yticks([0, 1], ["without\nabsorbers", "with\nabsorbers"])
        axes.set_ylim(1.75, -0.75)
        axes.grid(False, axis="y")
        legend(part, axes)


def _shade(axes: Any, low: float, high: float, words: str, index: int) -> None:
    if low == high:
        axes.axvline(low, color=COLOURS[(index + 1) % len(COLOURS)], lw=1.4, linestyle=":", zorder=2, label=words)
        return
    look = {"fc": _BANDS[index % len(_BANDS)], "ec": "#9a9a9a", "hatch": _MARKS[index % len(_MARKS)], "lw": 0.0}
    axes.axvspan(low, high, zorder=1.0, label=words, **look)


def _numbers(axes: Any, values: list[float], row: int, span: tuple[float, float]) -> None:
    """Numbers above their marks; below, where the one before is near."""
    last, above = -1e300, True
    for value in values:
        near = value - last < _CLOSE * (span[1] - span[0])
        above = not above if near else True
        axes.annotate(
            plain(value, 4),
            (value, row),
            xytext=(0, 8 if above else -8),
            textcoords="offset points",
            ha="center",
            va="bottom" if above else "top",
            fontsize=SIZE - 1,
            color=INK,
            zorder=6,
            bbox=_BOX,
        )
        last = value
