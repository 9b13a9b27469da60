"""A trade-off: the goal against what it is weighed with, the knee and both ends marked."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.report.figures.paper import COLOURS, INK, STYLES, WIDTH, dress, label, laid_out, legend, place, scale, sheet
from vibopt.report.series import Front

_ROOM, _BETWEEN = 0.06, 9
"""Part of the span that is left free at both ends of an axis, and points on a stretch of a line that words avoid."""

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.text import Annotation


def tradeoff_figure(*fronts: Front) -> Figure:
    """A dot for each verified design; lines between neighbours, none over a jump; of several each with its name."""
    figure = sheet(WIDTH, 4.4)
    axes: Any = figure.subplots()
    dress(axes, fronts[0].title, fronts[0].x_label, fronts[0].y_label)
    dots = np.concatenate([np.column_stack([front.x, front.y]) for front in fronts])
    for which, values in zip("xy", dots.T, strict=True):
        low, high = float(values.min()), float(values.max())
        log = low > 0.0 and high > 30.0 * low
        room = (high / low) ** _ROOM if log else _ROOM * (high - low)
        scale(axes, which, log, low / room if log else low - room, high * room if log else high + room)
    marks, drawn = list[Any](), list[FloatArray]()
    for number, front in enumerate(fronts):
        colour, style = COLOURS[number % len(COLOURS)], STYLES[number % len(STYLES)]
        cuts = [0, *(jump + 1 for jump in front.jumps), len(front.x)]
        for begin, end in pairwise(cuts):
            axes.plot(front.x[begin:end], front.y[begin:end], linestyle=style, color=colour, lw=1.4, zorder=3)
            drawn.append(np.column_stack([front.x[begin:end], front.y[begin:end]]))
        shape = {"ms": 3.2, "color": colour, "zorder": 4, "linestyle": style if front.name else ""}
        axes.plot([], [], marker="o", label=front.name or "verified designs; none is better in both", **shape)
        axes.plot(front.x, front.y, "o", ms=3.2, color=colour, zorder=4)
        marks += _marks(axes, front)
    legend(figure, axes)
    laid_out(figure)
    place(marks, np.concatenate([_along(axes.transData.transform(one)) for one in drawn if len(one)]))
    return figure


def _along(corners: FloatArray) -> FloatArray:
    """Corners of a line with points between them, (n, 2)."""
    parts = np.linspace(0.0, 1.0, _BETWEEN)[1:, None, None]
    between = (1.0 - parts) * corners[:-1] + parts * corners[1:]
    return np.concatenate([corners, between.reshape(-1, 2)])


def _marks(axes: Any, front: Front) -> list[Annotation]:
    marks = []
    for index, words in front.marks:
        knee = words.startswith("knee")
        axes.plot(front.x[index], front.y[index], "*" if knee else "D", ms=13 if knee else 6, mfc="white", mec=INK,
                  mew=1.2, zorder=6)  # fmt: skip
        marks.append(label(axes, words, float(front.x[index]), float(front.y[index])))
    return marks
