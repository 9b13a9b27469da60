"""Figures of the charts: stability, profiles, fidelity.  Nothing is lost in grey."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import groupby
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.charts.verdicts import REFUSES, RIGHT, SAYS_SO, SILENT, UNPROVEN
from vibopt.report.figures.paper import BLUE, COLOURS, FAINT, GRID, INK, RED, SIZE, STYLES, WIDTH, dress, sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from vibopt.charts.fidelity import Fidelity

_LEFT = 0.7
"""Where the bars of models begin."""
LOOKS = {
    RIGHT: ("#cfe6d6", "", "o"), SAYS_SO: ("#c9cfd6", "---", "v"), UNPROVEN: ("#8d97a3", "////", "^"),
    SILENT: (RED, "", "X"), REFUSES: ("white", "", "s"),
}  # fmt: skip
"""Colour, hatching and mark of each class in every figure."""
_MORE = ("", "o", "s", "^")
"""Marks on the lines of those that have the dashes of another again: in grey a colour tells nothing."""


def headed(figure: Figure, words: str) -> None:
    """Under what it was measured, small, above everything else."""
    if words:
        wide = int(figure.get_figwidth() * 72.0 / (0.55 * (SIZE - 2.5)))
        figure.suptitle("\n".join(wrap(words, wide)), x=0.01, ha="left", fontsize=SIZE - 2.5, color=FAINT)


def stability_figure(
    families: Sequence[str],
    methods: Sequence[str],
    found: Mapping[tuple[str, str], Sequence[str]],
    above: str = "",
) -> Figure:
    """Families by methods, a panel for those given to the same methods; `above` is a note.

    found
        Class of each answer by family and method, from mild to severe; "not installed" of a rival that is not there.
    """
    given = {family: tuple(method for method in methods if (family, method) in found) for family in families}
    groups = list(dict.fromkeys(given.values()))
    sizes = [sum(one == group for one in given.values()) for group in groups]
    figure = sheet(WIDTH * 1.25, 1.0 + 0.9 * len(groups) + 0.42 * len(families))
    panels: Any = figure.subplots(len(groups), 1, squeeze=False, height_ratios=sizes)
    for axes, group in zip(panels.flat, groups, strict=True):
        rows = [family for family in families if given[family] == group]
        for row, family in enumerate(rows):
            for column, method in enumerate(group):
                _cell(axes, column, row, found[family, method])
        _names(axes, rows, group)
    from matplotlib.patches import Patch

    handles = [Patch(fc=face, ec=INK, lw=0.6, hatch=hatch, label=name) for name, (face, hatch, _) in LOOKS.items()]
    figure.legend(
        handles=handles, loc="outside lower center", ncols=len(handles), fontsize=SIZE - 1, frameon=False,
        handlelength=2.0, handleheight=1.2, title="cases of a family, from mild to severe", title_fontsize=SIZE - 1,
    )  # fmt: skip
    headed(figure, above)
    return figure


def _names(axes: Any, rows: Sequence[str], columns: Sequence[str]) -> None:
    axes.set_xlim(-0.5, len(columns) - 0.5)
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set_xticks(range(len(columns)), columns, fontsize=SIZE - 1, rotation=25, ha="left")
    axes.xaxis.tick_top()
    axes.set_yticks(range(len(rows)), rows, fontsize=SIZE - 1)
    axes.tick_params(length=0, colors=INK)
    for side in ("top", "right", "bottom", "left"):
        axes.spines[side].set_visible(False)


def _cell(axes: Any, column: int, row: int, found: Sequence[str]) -> None:
    """A slice a case in the order of severity; runs of one class say how many they are."""
    from matplotlib.patches import Rectangle

    left, wide, high = column - 0.45, 0.9, 0.72
    known = [name for name in found if name in LOOKS]
    edge = INK if known else GRID
    axes.add_patch(Rectangle((left, row - high / 2), wide, high, ec=edge, lw=0.6, zorder=4, fill=False))
    if not known:
        words = found[0] if found else "not asked"
        axes.text(column, row, words, ha="center", va="center", fontsize=SIZE - 3, color=FAINT)
        return
    for name, some in groupby(known):
        count = len(list(some))
        part = count / len(known) * wide
        face, hatch, _ = LOOKS[name]
        axes.add_patch(Rectangle((left, row - high / 2), part, high, fc=face, ec=INK, lw=0.4, hatch=hatch, zorder=3))
        dark = face == RED
        if part > 0.06:
            axes.text(
                left + part / 2, row, str(count), ha="center", va="center", fontsize=SIZE - 2, zorder=5,
                bbox=None if dark or not hatch else {"fc": "white", "ec": "none", "pad": 0.6},
                color="white" if dark else INK, fontweight="bold" if dark else "normal",
            )  # fmt: skip
        left += part


def fidelity_figure(rows: Sequence[Fidelity], above: str = "") -> Figure:
    """Degrees of freedom declared and used, time saved, and the error made, scene by scene; `above` is a note."""
    figure = sheet(WIDTH * 1.25, 1.6 + 0.34 * len(rows))
    axes: Any = figure.subplots(1, 3, sharey=True, width_ratios=(1.2, 1.0, 1.0))
    at = np.arange(len(rows))
    dress(axes[0], "Model", "freedoms, planes, sensors, speeds", "")
    counted = [number for number, row in enumerate(rows) if row.kinds is None]
    axes[0].barh(counted, [rows[i].declared for i in counted], 0.7, fc="white", ec=INK, lw=0.8, label="declared")
    axes[0].barh(counted, [rows[i].used for i in counted], 0.4, fc=BLUE, ec=BLUE, label="used")
    for y, row in zip(at, rows, strict=True):
        axes[0].annotate(
            " → ".join(row.counts),
            (row.declared or _LEFT, y),
            xytext=(3, 0),
            textcoords="offset points",
            va="center",
            fontsize=SIZE - 2,
        )
    axes[0].set_xscale("log")
    axes[0].set_xlim(_LEFT, 12.0 * max((rows[i].declared for i in counted), default=1))  # room for the words
    axes[0].set_yticks(at, [row.case for row in rows], fontsize=SIZE - 1)
    axes[0].invert_yaxis()
    dress(axes[1], "Time saved", "time on the full over the reduced model", "")
    axes[1].set_xscale("log")
    axes[1].axvline(1.0, color=FAINT, lw=0.8)
    known = [(float(y), row.noise) for y, row in zip(at, rows, strict=True) if math.isfinite(row.noise)]
    for place, noise in known:
        said = "the same against the same" if place == known[0][0] else ""
        axes[1].fill_betweenx(
            [place - 0.4, place + 0.4], 1.0 / noise, noise, color=GRID, lw=0, zorder=0, label=said
        )  # fmt: skip
    axes[1].plot(
        [row.saved[0] for row in rows], at, ls="", marker="s", ms=6, mfc="white", mec=INK, label="measuring a design"
    )
    axes[1].plot([row.saved[1] for row in rows], at, ls="", marker="o", ms=6, mfc=BLUE, mec=BLUE, label="solving")
    _plain_numbers(axes[1], [value for row in rows for value in row.saved])
    dress(axes[2], "Error of the values", "greatest difference (part)", "")
    axes[2].set_xscale("log")
    axes[2].plot(
        [max(row.value_error, 1e-17) for row in rows],
        at,
        ls="",
        marker="D",
        ms=5,
        mfc=INK,
        mec=INK,
        label="reduced against full",
    )
    top = max([1e-6, *(10.0 * row.value_error for row in rows if math.isfinite(row.value_error))])
    axes[2].set_xlim(3e-18, top)
    ticks = [10.0**e for e in ((-14, -11, -8) if top < 1e-4 else (-12, -7, -2))]
    axes[2].set_xticks([1e-17, *ticks], ["0", *(f"{tick:.0e}" for tick in ticks)])
    axes[2].minorticks_off()
    for panel in axes:
        panel.grid(False, axis="y")
    handles = [handle for panel in axes for handle in panel.get_legend_handles_labels()[0]]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), fontsize=SIZE - 1, frameon=False)
    headed(figure, above)
    return figure


def profiles_figure(
    rows: Mapping[str, Sequence[Mapping[str, FloatArray]]], count: int, default: str, above: str = ""
) -> Figure:
    """Performance profiles of exact answers and of fair ones, and a data profile of exact ones: a row a family.

    Parameters
    ----------
    rows
        By family, for each panel the times of each method, over the best time on that question or in seconds, infinite
        where it has no answer, shape (count,).
    """
    figure = sheet(WIDTH * 1.25, 1.0 + 2.8 * len(rows))
    axes: Any = figure.subplots(len(rows), 3, squeeze=False, sharey=True)
    methods = list(dict.fromkeys(name for pair in rows.values() for one in pair for name in one))
    looks = {
        name: {
            "color": COLOURS[i % len(COLOURS)], "ls": STYLES[i % len(STYLES)], "marker": _MORE[i // len(STYLES)],
            "lw": 2.6 if name == default else 1.4, "zorder": 6 if name == default else 5,
            "ms": 3.5, "markevery": (1, 3),
        }
        for i, name in enumerate(methods)
    }  # fmt: skip
    for panels, (family, triple) in zip(axes, rows.items(), strict=True):
        for place, (panel, times) in enumerate(zip(panels, triple, strict=True)):
            error, under = (("1e-6", "time over the best"), ("1e-3", "time over the best"), ("1e-6", "CPU seconds"))[
                place
            ]
            dress(panel, f"{family}, to {error}", under, "share answered" if place == 0 else "")
            _profile(panel, times, count, looks, 1.0 if place < 2 else 0.0)
    from matplotlib.lines import Line2D

    handles = [Line2D([0.0, 0.5, 1.0], [0.0] * 3, label=name, **looks[name]) for name in methods]
    figure.legend(
        handles=handles, loc="outside lower center", ncols=4, fontsize=SIZE - 1, frameon=False, handlelength=3.5
    )
    headed(figure, above)
    return figure


def _profile(
    panel: Any, times: Mapping[str, FloatArray], count: int, looks: Mapping[str, Mapping[str, Any]], first: float
) -> None:
    """Steps of every method; the axis begins at `first`, or below the least time where that is nothing."""
    known = [float(t) for row in times.values() for t in row if math.isfinite(t)]
    first, last = first or 0.7 * min([1.0, *known]), 2.0 * max([10.0 * first, *known])
    panel.set_xscale("log")
    panel.set_xlim(first, last)
    panel.set_ylim(0.0, 1.04)
    for name, row in times.items():
        good = np.sort(row[np.isfinite(row)])
        share = np.arange(1, len(good) + 1) / count
        panel.step([first, *good, last], [0.0, *share, share[-1]], where="post", **looks[name])


def _plain_numbers(panel: Any, values: list[float]) -> None:
    good = [value for value in values if math.isfinite(value) and value > 0]
    low, high = min([0.5, *good]), max([2.0, *good])
    panel.set_xlim(low / 1.6, high * 1.6)
    every = [part * 10.0**power for power in range(-1, 6) for part in (1, 2, 5)]
    ticks = [tick for tick in every if low / 1.6 <= tick <= high * 1.6]
    if len(ticks) > 5:
        ticks = [tick for tick in ticks if f"{tick:g}".strip("0.") == "1"]
    panel.set_xticks(ticks, [f"{t:g}" for t in ticks])
    panel.minorticks_off()
