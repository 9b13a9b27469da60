"""Bars side by side: before and after, with limits and 95 % bands."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from vibopt.records import dataclass
from vibopt.report.figures.paper import BLUE, FAINT, INK, RED, SIZE, dress

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


def bars(axes: Any, title: str, unit: str, given: Sequence[Bar]) -> None:
    """Horizontal bars from the top down; of many the worst MOST."""
    shown = list(given)
    if len(shown) > MOST:
        shown = sorted(shown, key=lambda one: one.after or 0.0, reverse=True)[:MOST]
        title = f"{title}: the worst {MOST} of {len(given)}"
    dress(axes, title, unit, "")
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


def height(count: int) -> float:
    """Inches that `count` pairs of bars need."""
    return 0.75 + 0.26 * min(count, MOST)


def key(
    figure: Any,
    caption: str,
    *,
    dials: bool,
    limits: bool,
    bands: bool = False,
    fitted: bool = True,
    removed: bool = False,
    masses: bool = False,
    circles: bool = False,
    before: bool = True,
    after: bool = True,
    whole: bool = False,
) -> None:
    """Caption and legend below everything, only with what is drawn; `whole` weights stand instead of what is on."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    line: Any = Line2D
    found: list[tuple[Any, str]] = []
    if masses:
        found.append((line([], [], ls="", marker="s", mfc="white", mec=INK), "known mass"))
    if dials:
        if fitted:
            found.append(
                (line([], [], ls="", ms=8, marker="o", mfc=BLUE, mec=INK), "whole weight" if whole else "fit here")
            )
        if removed:
            found.append((line([], [], ls="", ms=8, marker="X", mfc="white", mec=RED), "take away here"))
        found.append((line([], [], ls="", marker="v", color=INK, ms=7), "zero mark"))
    open_, full = (" (on a dial: open circle)", " (on a dial: diamond)") if circles else ("", "")
    if before:
        found.append((Patch(facecolor="white", edgecolor=FAINT, hatch="////"), f"as found{open_}"))
    if after:
        found.append((Patch(facecolor=BLUE, edgecolor=INK), f"after{full}"))
    if limits:
        found.append((line([], [], color=RED, lw=2.0), "limit"))
    if bands:
        found.append((line([], [], color=INK, lw=1.2, marker="|"), "95 % band"))
    figure.legend(
        [one for one, _ in found],
        [words for _, words in found],
        loc="outside lower center",
        ncols=min(len(found), 4),
        fontsize=SIZE - 1,
        frameon=False,
        title=caption,
        title_fontsize=SIZE - 0.5,
    )


def pad_more(figure: Any) -> None:
    """Room between the parts and at the edge of the paper."""
    engine = figure.get_layout_engine()
    engine.set(w_pad=0.1, h_pad=0.08)
