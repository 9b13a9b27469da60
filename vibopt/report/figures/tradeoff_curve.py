"""A trade-off: the goal against what it is weighed with, the knee and both ends marked."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.report.figures.paper import COLOURS, INK, STYLES, WIDTH, dress, label, laid_out, legend, place, scale, sheet
from vibopt.report.series import Front

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
        log = bool(values.min() > 0.0 and values.max() > 30.0 * values.min())
        room = 1.12 if log else 0.06 * float(np.ptp(values))
        low, high = float(values.min()), float(values.max())
        scale(axes, which, log, low / room if log else low - room, high * room if log else high + room)
    marks = []
    for number, front in enumerate(fronts):
        colour, style = COLOURS[number % len(COLOURS)], STYLES[number % len(STYLES)]
        cuts = [0, *(jump + 1 for jump in front.jumps), len(front.x)]
        for begin, end in pairwise(cuts):
            axes.plot(front.x[begin:end], front.y[begin:end], linestyle=style, color=colour, lw=1.4, zorder=3)
        shape = {"ms": 3.2, "color": colour, "zorder": 4, "linestyle": style if front.name else ""}
        axes.plot([], [], marker="o", label=front.name or "verified designs; none is better in both", **shape)
        axes.plot(front.x, front.y, "o", ms=3.2, color=colour, zorder=4)
        marks += _marks(axes, front)
    legend(figure, axes)
    laid_out(figure)
    place(marks, axes.transData.transform(dots))
    return figure


def _marks(axes: Any, front: Front) -> list[Annotation]:
    marks = []
    for index, words in front.marks:
        knee = words.startswith("knee")
        axes.plot(front.x[index], front.y[index], "*" if knee else "D", ms=13 if knee else 6, mfc="white", mec=INK,
                  mew=1.2, zorder=6)  # fmt: skip
        marks.append(label(axes, words, float(front.x[index]), float(front.y[index])))
    return marks
