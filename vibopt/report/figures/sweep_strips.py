"""A sweep: goal, variables or margins against one fact."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vibopt.report.figures.paper import (
    COLOURS,
    FAINT,
    INK,
    RED,
    SIZE,
    STYLES,
    WIDTH,
    dress,
    forbidden,
    legend,
    scale,
    sheet,
)
from vibopt.report.series import Strip, Strips

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def strips_figure(strips: Strips) -> Figure:
    """Axes under each other; parts without a good answer are hatched in all of them."""
    count = max(len(strips.strips), 1)
    figure = sheet(WIDTH, 0.9 + 1.9 * count + (0.8 if count == 1 else 0.0))
    rows: Any = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
    for index, (axes, strip) in enumerate(zip(rows, strips.strips, strict=False)):
        last = index == count - 1
        dress(axes, strips.title if index == 0 else "", strips.x_label if last else "", strip.label)
        _draw(axes, strip, strips)
    scale(rows[-1], "x", strips.log_x, strips.x[0], strips.x[-1])
    legend(figure, *rows)
    _name(rows[0], strips)
    return figure


def _name(axes: Any, strips: Strips) -> None:
    """What changes at each mark, beside its line, each name lower than the one before where they would touch."""
    for index, (x, words) in enumerate(strips.marks):
        right = axes.transAxes.inverted().transform(axes.transData.transform((x, 1.0)))[0] > 0.5
        axes.annotate(
            words, (x, 1.0), xycoords=("data", "axes fraction"), xytext=(-4 if right else 4, -10 - 11 * (index % 4)),
            textcoords="offset points", ha="right" if right else "left", fontsize=SIZE - 1.5, color=INK, zorder=6,
            bbox={"fc": "white", "ec": "none", "pad": 0.8, "alpha": 0.9},
        )  # fmt: skip


def _draw(axes: Any, strip: Strip, strips: Strips) -> None:
    dots = "o" if len(strips.x) <= 30 or not strips.joined else ""
    named = len(strip.lines) > 1
    for index, line in enumerate(strip.lines):
        axes.plot(
            strips.x,
            line.y,
            linestyle=STYLES[index % len(STYLES)] if strips.joined else "",
            color=COLOURS[index % len(COLOURS)],
            marker=dots,
            ms=3.0,
            lw=1.6,
            zorder=4,
            label=line.name if named else None,
            clip_on=False,
        )
    if strip.log:
        axes.set_yscale("log")  # before the span is asked for: a linear one would begin below zero
        scale(axes, "y", True, *axes.get_ylim())
    if strip.bad_below is not None:
        axes.axhline(strip.bad_below, color=RED, lw=1.4, zorder=3)
        floor, ceiling = axes.get_ylim()
        low = min(floor, strip.bad_below)
        axes.axhspan(low, strip.bad_below, label=strip.bad_word, zorder=1, **forbidden())
        axes.set_ylim(floor, ceiling)
    for x, _ in strips.marks:
        axes.axvline(x, color=FAINT, lw=0.9, linestyle=(0, (2, 2)), zorder=2)
    kinds = list(dict.fromkeys(words for _, _, words in strips.shaded))
    for low, high, words in strips.shaded:
        axes.axvspan(low, high, zorder=1, label=words, **forbidden(kinds.index(words)))
