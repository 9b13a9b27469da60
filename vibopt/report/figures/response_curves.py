"""Responses against speed: curve, forbidden zones, worst points, own speeds."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from math import isfinite
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.report.figures.paper import (
    COLOURS,
    DASHES,
    FAINT,
    FREE,
    GREEN,
    HEIGHT,
    INK,
    RED,
    SIZE,
    STYLES,
    WIDTH,
    dress,
    forbidden,
    label,
    laid_out,
    legend,
    place,
    scale,
    sheet,
)
from vibopt.report.series import Curve, Mark, Panel, Zone

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.text import Annotation

MOST_LABELS = 5
CLOSE = 0.03
"""Part of the axes' size within which worst points share a label."""


class Below(Protocol):
    """What may stand under the panels: so many inches high, drawn into a part of the figure."""

    @property
    def height(self) -> float: ...

    def draw(self, part: Any) -> None: ...


def response_figure(panels: list[Panel], title: str = "", below: Sequence[Below] = ()) -> Figure:
    """Panels under each other in one figure, and under them what else is to be seen."""
    heights = [*(HEIGHT for _ in panels), *(one.height for one in below)]
    figure = sheet(WIDTH, (sum(heights) or HEIGHT) + (0.35 if title else 0.0))
    if title:
        figure.suptitle(title, fontsize=SIZE + 3, fontweight="bold", color=INK)
    parts: Any = [figure]
    if len(heights) > 1:
        parts = figure.subfigures(len(heights), 1, squeeze=False, height_ratios=heights)[:, 0]
    labels = [_draw(part, panel) for part, panel in zip(parts, panels, strict=False)]
    for part, one in zip(parts[len(panels) :], below, strict=False):
        one.draw(part)
    laid_out(figure)
    for some, panel in zip(labels, panels, strict=True):
        _spread(some, panel)
    return figure


def _draw(part: Any, panel: Panel) -> list[Annotation]:
    """One panel; its labels find their places later, when the layout is known."""
    axes = part.subplots()
    dress(axes, panel.title, panel.x_label, panel.y_label, "; ".join(panel.notes))
    scale(axes, "x", panel.log_x, *panel.x_span)
    scale(axes, "y", panel.log_y, *panel.y_span)
    if panel.to_scale:
        axes.set_xlim(auto=True)  # as wide as the other axis wants it
        axes.set_aspect("equal", adjustable="datalim")
    _zones(axes, panel)
    for index, curve in enumerate(panel.curves):
        _curve(axes, curve, index)
    _own(axes, panel)
    _good(axes, panel)
    labels = _marks(axes, panel)
    legend(part, axes)
    return labels


def _curve(axes: Any, curve: Curve, index: int) -> None:
    """Full where the file says how the excitation varies, thin and dashed elsewhere."""
    words = curve.label or None
    if curve.before:
        axes.plot(curve.x, curve.y, linestyle=(0, (1, 1.3)), color=INK, lw=1.2, label=words, zorder=3.5)
        return
    if curve.worst:
        axes.plot(curve.x, curve.y, linestyle=(0, (5, 1.2, 1, 1.2)), color=INK, lw=1.3, label=words, zorder=4.5)
        return
    style, colour = STYLES[index % len(STYLES)], COLOURS[index % len(COLOURS)]
    stretch = int(curve.known.sum()) > 1
    if stretch:
        known = np.where(curve.known, curve.y, np.nan)
        axes.plot(curve.x, known, linestyle=style, color=colour, lw=1.7, label=words, zorder=4)
    if not curve.known.all():
        guessed = np.where(curve.known, np.nan, curve.y) if stretch else curve.y
        dashes, words = DASHES[index % len(DASHES)], None if stretch else words
        axes.plot(curve.x, guessed, linestyle=dashes, color=colour, lw=1.1, label=words, zorder=4)


def _zones(axes: Any, panel: Panel) -> None:
    """Where limits forbid the response, hatched; the bound itself is a line."""
    for index, (_, group) in enumerate(groupby(panel.zones, key=lambda zone: (zone.name, zone.above))):
        for zone in group:
            low, high = _wide(zone, panel)
            floor, ceiling = panel.y_span
            bottom, top = (zone.bound, ceiling) if zone.above else (floor, zone.bound)
            over = 1.5 - 0.1 * index
            axes.fill_between([low, high], bottom, top, zorder=over, label=zone.words, **forbidden(index))
            axes.plot([low, high], [zone.bound, zone.bound], color=RED, lw=1.6, solid_capstyle="butt", zorder=3)


def _wide(zone: Zone, panel: Panel) -> tuple[float, float]:
    """Ends of a zone; one speed gets a width that can be seen."""
    if zone.high > zone.low:
        return zone.low, zone.high
    low, high = panel.x_span
    if panel.log_x:
        factor = (high / low) ** 0.012
        return zone.low / factor, zone.high * factor
    room = 0.012 * (high - low)
    return zone.low - room, zone.high + room


def _own(axes: Any, panel: Panel) -> None:
    """Own speeds: a line, or a bar along the axis for a range."""
    for first, (low, high) in enumerate(panel.own):
        words = f"own speed{'s' * (low < high)} of {panel.excitation}" if first == 0 else None
        if low == high:
            axes.axvline(low, color=FAINT, lw=1.0, linestyle=":", zorder=2, label=words)
        else:
            _bar(axes, low, high, INK, words)


def _good(axes: Any, panel: Panel) -> None:
    """Speeds that `find_all` found."""
    for low, high in panel.good:
        axes.axvspan(low, high, facecolor=FREE, zorder=0.5)
        _bar(axes, low, high, GREEN, "all limits hold")


def _bar(axes: Any, low: float, high: float, colour: str, words: str | None) -> None:
    """A thick line along the foot of the axes."""
    look = {"color": colour, "lw": 3.5, "solid_capstyle": "butt", "zorder": 5, "label": words}
    axes.plot([low, high], [0.013, 0.013], transform=axes.get_xaxis_transform(), **look)


def _marks(axes: Any, panel: Panel) -> list[Annotation]:
    """Worst points, one label for points that coincide; many points go without, the tables have their values."""
    groups: list[list[Mark]] = []
    for mark in panel.marks:
        near = [group for group in groups if np.hypot(*(_spot(axes, mark) - _spot(axes, group[0]))) < CLOSE]
        if near:
            near[0].append(mark)
        else:
            groups.append([mark])
    _equal(axes, panel)
    labels = _equal_labels(axes, panel)
    for marks in groups:
        x, y = marks[0].x, marks[0].y
        floor, ceiling = panel.y_span
        inside = isfinite(y) and floor <= y <= ceiling
        height = y if inside else ceiling if y > floor else floor
        sign = "o" if inside else "^" if y > floor else "v"
        axes.plot([x], [height], marker=sign, ms=6.5, mfc="white", mec=INK, mew=1.4, zorder=6, clip_on=False)
        if len(groups) <= MOST_LABELS:
            labels.append(label(axes, "\n".join(mark.words for mark in marks), x, height))
    return labels


def _equal(axes: Any, panel: Panel) -> None:
    """Equal peaks: full dots, under the ring of the worst."""
    if panel.equal:
        x, y = [mark.x for mark in panel.equal], [mark.y for mark in panel.equal]
        words = "equal peaks (within 0.1 %)"
        axes.plot(x, y, "D", ms=4.5, mfc=INK, mec="white", mew=0.6, zorder=7, clip_on=False, label=words)


def _equal_labels(axes: Any, panel: Panel) -> list[Annotation]:
    """Speed and value of the equal peaks that are not labelled as the worst of something."""
    worst = [_spot(axes, mark) for mark in panel.marks]
    plain = [mark for mark in panel.equal if all(np.hypot(*(_spot(axes, mark) - other)) >= CLOSE for other in worst)]
    return [label(axes, mark.words, mark.x, mark.y) for mark in plain[:MOST_LABELS]]


def _spot(axes: Any, mark: Mark) -> FloatArray:
    """Where a mark is in the axes, as parts of their size."""
    floor, ceiling = axes.get_ylim()
    inside: FloatArray = axes.transAxes.inverted().transform(
        axes.transData.transform((mark.x, min(max(mark.y, floor), ceiling)))
    )
    return inside


def _spread(labels: list[Annotation], panel: Panel) -> None:
    """Place the labels of a panel off its curves."""
    if labels:
        axes: Any = labels[0].axes
        curves = [np.column_stack([curve.x, curve.y])[np.isfinite(curve.y)] for curve in panel.curves]
        place(labels, axes.transData.transform(np.concatenate(curves)))
