"""Cost against size as a table, as plain data and as a figure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.answer.text import grid, section
from vibopt.charts.chart_figures import headed
from vibopt.charts.chart_views import spread, time_of
from vibopt.charts.conditions import conditions
from vibopt.charts.cost import Fit, Size, fits
from vibopt.report.figures.paper import COLOURS, FAINT, INK, SIZE, WIDTH, dress, sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from vibopt.answer.console import Console

_MARKS = ("o", "s", "^", "D")


def cost_json(sizes: tuple[Size, ...]) -> dict[str, Any]:
    """Every size and every fitted exponent, as plain data."""
    return {"chart": "cost", "conditions": conditions(), "fits": fits(sizes), "scenes": list(sizes)}


def cost_table(sizes: tuple[Size, ...], console: Console) -> None:
    """A table a ladder: CPU time and memory by size, and the exponents."""
    console.print("Cost against size", style="bold")
    console.print(
        "Time: CPU seconds of a whole answer, median; ± is half the distance between the quartiles. Exponent: of the "
        "size, with the half of its interval of 95 %, for each method that answers."
    )
    console.print(conditions().words)
    lines = fits(sizes)
    for ladder in dict.fromkeys(size.ladder for size in sizes):
        rows = [
            (str(size.size), time_of(size.seconds) + spread(size), f"{size.memory / 2**20:.3g} MB", size.method)
            for size in sizes if size.ladder == ladder
        ]  # fmt: skip
        section(console, ladder, grid(rows, ("Size", "Time", "Memory", "Method"), whole=(0, 1, 2)))
        for line in lines:
            if line.ladder == ladder:
                half = f" ± {line.half:.2f}" if math.isfinite(line.half) else ""
                console.print(
                    f"  {line.method}, {line.sizes[0]} to {line.sizes[-1]}: exponent {line.exponent:.2f}{half}"
                )
    for size in sizes:
        if size.cut:
            console.print(f"Less was asked than this chart promises: {size.ladder} of {size.size}, {size.cut}")


def draw_cost(sizes: tuple[Size, ...]) -> Figure:
    """CPU time over size, a panel a ladder."""
    lines = fits(sizes)
    panels = {
        name: ([size for size in sizes if size.ladder == name], [line for line in lines if line.ladder == name])
        for name in dict.fromkeys(size.ladder for size in sizes)
    }
    runs = " or ".join(str(count) for count in sorted({size.runs for size in sizes}))
    return cost_figure(panels, f"CPU seconds, median of {runs} runs, bars over the middle half. {conditions().words}")


def cost_figure(panels: Mapping[str, tuple[Sequence[Size], Sequence[Fit]]], above: str = "") -> Figure:
    """CPU seconds over size, both logarithmic, a panel a ladder: a mark a method, the straight line that fits each."""
    columns, rows = 3, -(-len(panels) // 3)
    figure = sheet(WIDTH * 1.25, 0.6 + 2.3 * rows)
    axes: Any = figure.subplots(rows, columns, squeeze=False)
    for panel, (ladder, (sizes, lines)) in zip(axes.flat, panels.items(), strict=False):
        _ladder(panel, ladder, sizes, lines, first=panel in axes[:, 0])
    for panel in axes.flat[len(panels) :]:
        panel.set_axis_off()
    headed(figure, above)
    return figure


def _ladder(panel: Any, ladder: str, sizes: Sequence[Size], lines: Sequence[Fit], *, first: bool) -> None:
    dress(panel, "", ladder, "CPU seconds" if first else "")
    panel.set_xscale("log")
    panel.set_yscale("log")
    methods = list(dict.fromkeys(size.method for size in sizes))
    for index, method in enumerate(methods):
        some = [size for size in sizes if size.method == method]
        marker, colour = _MARKS[index % len(_MARKS)], COLOURS[index % len(COLOURS)]
        panel.plot([size.size for size in some], [size.seconds for size in some], ls="", marker=marker, ms=5.5,
                   mfc=colour, mec=INK, mew=0.6, zorder=5)  # fmt: skip
        first_place = some[0].size, some[0].seconds
        panel.annotate(
            method.split(";")[0], first_place, xytext=(5, -10), textcoords="offset points", fontsize=SIZE - 3,
            color=INK, bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5}, zorder=5,
        )  # fmt: skip
        for one in some:
            panel.plot([one.size] * 2, one.quartiles, color=INK, lw=1.2, zorder=4)
    for line in lines:
        place = [size for size in sizes if size.size in line.sizes]
        logs = [math.log(size.seconds) - line.exponent * math.log(size.size) for size in place]
        middle = math.exp(sum(logs) / len(logs))
        ends = np.array([line.sizes[0], line.sizes[-1]], dtype=float)
        panel.plot(ends, middle * ends**line.exponent, color=FAINT, lw=1.0, zorder=3)
    for before, behind in pairwise(sizes):
        if before.method != behind.method:
            panel.axvline(math.sqrt(before.size * behind.size), color=FAINT, lw=0.8, ls=(0, (4, 3)), zorder=1)
    words = [_words(line) for line in lines]
    panel.set_title("\n".join(words) or " ", fontsize=SIZE - 2.5, color=INK, loc="left")
    ticks = [size.size for size in sizes]
    panel.set_xticks(ticks, [f"{tick:g}" for tick in ticks], fontsize=SIZE - 2)
    panel.minorticks_off()
    low, high = (end([size.seconds for size in sizes]) for end in (min, max))
    panel.set_ylim(low / 3.0, high * 3.0)


def _words(line: Fit) -> str:
    half = f" ± {line.half:.2f}" if math.isfinite(line.half) else ""
    return f"{line.sizes[0]} to {line.sizes[-1]}: n^{line.exponent:.2f}{half}"
