"""The design map: where in the plane of two variables every limit holds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.report.design_plane import Boundary, Plane
from vibopt.report.figures.paper import (
    COLOURS,
    FAINT,
    FREE,
    HATCHES,
    INK,
    SIZE,
    STYLES,
    WIDTH,
    dress,
    label,
    laid_out,
    legend,
    place,
    scale,
    sheet,
)
from vibopt.units import plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ROOM = 4.0
"""Least width and height of a line of equal goal that bears its number, in heights of letters."""


def plane_figure(plane: Plane) -> Figure:
    """Forbidden parts hatched limit by limit, boundaries named, the chosen design marked."""
    figure = sheet(WIDTH, 4.8)
    axes: Any = figure.subplots()
    dress(axes, plane.title, plane.x.label, plane.y.label)
    for which, side in (("x", plane.x), ("y", plane.y)):
        scale(axes, which, side.log, side.values[0], side.values[-1])
    x, y = plane.x.values, plane.y.values
    free = np.max([boundary.excess for boundary in plane.boundaries], axis=0, initial=-1.0)
    free = np.broadcast_to(free, (len(y), len(x)))
    axes.contourf(x, y, free, levels=[-1e3, 0.0], colors=[FREE], zorder=0.5)
    alone = plane.levels and plane.best is not None and int((free <= 1e-9).sum()) <= 4
    handles = (_patch(FREE, "#9fc9ab", "", f"all limits hold{' at the chosen design alone' if alone else ''}"),)
    handles += tuple(_boundary(axes, plane, boundary, index) for index, boundary in enumerate(plane.boundaries))
    taken = _goal(axes, plane)
    labels = []
    if plane.best is not None:
        axes.plot(*plane.best, "*", ms=15, mfc="white", mec=INK, mew=1.3, zorder=8, label="chosen design")
        labels.append(label(axes, plane.best_words, *plane.best))
    legend(figure, axes, first=handles)
    laid_out(figure)
    place(labels, np.concatenate([_near(axes, plane), axes.transData.transform(taken)]))
    return figure


def _patch(face: str, edge: Any, hatch: str, words: str) -> Any:
    from matplotlib.patches import Patch

    return Patch(facecolor=face, edgecolor=edge, hatch=hatch, label=words, lw=0.8)


def _boundary(axes: Any, plane: Plane, boundary: Boundary, index: int) -> Any:
    """The part that a limit forbids, hatched, with its name on the boundary; the handle for the legend."""
    if not (boundary.excess > 0.0).any():
        return _patch("white", "white", "", f"{boundary.name} holds everywhere here")
    colour, style, hatch = COLOURS[index % len(COLOURS)], STYLES[index % 4], HATCHES[index % len(HATCHES)]
    x, y = plane.x.values, plane.y.values
    filled = axes.contourf(
        x, y, boundary.excess, levels=[0.0, 1e3], colors="none", hatches=[hatch[: 1 if plane.levels else 2]], zorder=1.0
    )
    filled.set_edgecolor(_light(colour))
    filled.set_linewidth(0.0)
    if (boundary.excess < 0.0).any():
        look = {"colors": [colour], "linewidths": 1.7, "linestyles": [style], "zorder": 3}
        line = axes.contour(x, y, boundary.excess, levels=[0.0], **look)
        names = axes.clabel(line, fmt={0.0: boundary.name}, fontsize=SIZE - 1, inline=True, inline_spacing=4)
        for name in names or ():
            name.set_bbox({"boxstyle": "round,pad=0.15", "fc": "white", "ec": "none", "alpha": 0.9})
    return _patch("white", _light(colour), hatch, f"{boundary.name} is broken")


def _light(colour: str) -> tuple[float, float, float]:
    """The colour, half way to white."""
    from matplotlib.colors import to_rgb

    red, green, blue = (0.5 + 0.5 * part for part in to_rgb(colour))
    return red, green, blue


def _goal(axes: Any, plane: Plane) -> FloatArray:
    """Lines of equal goal, where the goal is not one of the axes; points that no label should hide, (n, 2)."""
    nowhere = np.zeros((0, 2))
    if plane.goal is None:
        return nowhere
    finite = plane.goal[np.isfinite(plane.goal)]
    if not len(finite) or np.ptp(finite) <= 0.0:
        return nowhere
    colour, width, style = (INK, 0.8, "-") if plane.levels else (FAINT, 0.7, ":")
    levels = _from_least(finite) if plane.levels else levels_of(finite)
    shape = {"colors": colour, "linewidths": width, "linestyles": style, "zorder": 2.5}
    lines = axes.contour(plane.x.values, plane.y.values, plane.goal, levels=levels, **shape)
    size = SIZE - (1.5 if plane.levels else 2.5)
    names = axes.clabel(lines, _roomy(axes, lines), fontsize=size, fmt=lambda value: plain(float(value), 3))
    for name in names or () if plane.levels else ():
        name.set_bbox({"boxstyle": "round,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.85})
    axes.plot([], [], color=colour, lw=width, linestyle=style, label=plane.goal_label)
    numbers = np.array([name.get_position() for name in names or ()]).reshape(-1, 2)
    along = [line for level in lines.allsegs for line in level] if plane.levels else []
    return np.concatenate([np.repeat(numbers, 40, axis=0), *along])


def _roomy(axes: Any, lines: Any) -> list[float]:
    """Levels whose lines are wide and high enough for a number: within smaller ones numbers lie over each other."""
    least = _ROOM * SIZE * axes.figure.dpi / 72.0
    spans = [[np.ptp(axes.transData.transform(one), axis=0) for one in level if len(one)] for level in lines.allsegs]
    return [
        float(level)
        for level, parts in zip(lines.levels, spans, strict=True)
        if max((float(part.min()) for part in parts), default=0.0) > least
    ]


def levels_of(finite: FloatArray) -> FloatArray:
    """Round levels."""
    from matplotlib.ticker import MaxNLocator

    low, high = float(np.percentile(finite, 2)), float(np.percentile(finite, 98))
    if low > 0.0 and high > 20.0 * low:
        exponents = np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1)
        return np.unique(np.outer(10.0**exponents, [1.0, 2.0, 5.0]))
    return np.unique(np.asarray(MaxNLocator(8).tick_values(low, high), dtype=float))


def _from_least(finite: FloatArray) -> FloatArray:
    """Levels that climb from the least value, wider apart the higher, each rounded."""
    least, most = float(finite.min()), float(np.percentile(finite, 98))
    parts = (1.05, 1.1, 1.2, 1.4, 1.7, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0, 100.0)
    rounded = {float(f"{least * part:.3g}") for part in parts if least * part <= most}
    return np.array(sorted(rounded) or [0.5 * (least + most)])


def _near(axes: Any, plane: Plane) -> FloatArray:
    """Grid points beside a boundary, in pixels."""
    x, y = np.meshgrid(plane.x.values, plane.y.values)
    close = np.zeros(x.shape, dtype=bool)
    for boundary in plane.boundaries:
        close |= np.abs(boundary.excess) < 0.05
    points: FloatArray = axes.transData.transform(np.column_stack([x[close], y[close]]).reshape(-1, 2))
    return points
