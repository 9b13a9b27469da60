"""A sweep over two facts: lines of equal goal, and where designs end, drawn where they were found."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.report.figures.contours import levels_of
from vibopt.report.figures.paper import (
    BLUE,
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
from vibopt.report.series import Map, Side
from vibopt.units import plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Spot = tuple[float, float]


def map_figure(data: Map) -> Figure:
    """Values in lines with their numbers; parts without a design hatched; where other limits become active dashed."""
    figure = sheet(WIDTH, 5.2)
    axes: Any = figure.subplots()
    dress(axes, data.title, data.x_label, data.y_label)
    for which, log, values in (("x", data.log[0], data.x), ("y", data.log[1], data.y)):
        scale(axes, which, log, float(values[0]), float(values[-1]))
    _contours(axes, data)
    first = (_hatched(axes, data),) if not data.good.all() else ()
    for index, (words, lines) in enumerate(_edges(data).items()):
        ends = words is None
        look = {"color": RED if ends else INK, "lw": 1.8 if ends else 1.2}
        style = "-" if ends else STYLES[1 + index % (len(STYLES) - 1)]
        label = "where designs end" if words is None else f"{words[0]} | {words[1]}"
        for (x0, y0), (x1, y1) in lines:
            axes.plot([x0, x1], [y0, y1], linestyle=style, zorder=4, label=label, **look)
    legend(figure, axes, first=first)
    return figure


def _contours(axes: Any, data: Map) -> None:
    x, y = np.meshgrid(data.x, data.y)
    known = data.good & np.isfinite(data.values)
    sides = [side for side in data.sides if np.isfinite(side.value)]
    x = np.concatenate([x[known], [side.x for side in sides]])
    y = np.concatenate([y[known], [side.y for side in sides]])
    values = np.concatenate([data.values[known], [side.value for side in sides]])
    if len(values) > 3 and np.ptp(values) > 0.0 and np.ptp(x) > 0.0 and np.ptp(y) > 0.0:
        net, levels = _net(data, x, y), levels_of(values)
        axes.tricontourf(net, values, levels=levels, cmap="Blues", alpha=0.35, extend="both", zorder=0.5)
        lines = axes.tricontour(net, values, levels=levels, colors=BLUE, linewidths=0.9, zorder=0.8)
        for name in axes.clabel(lines, fontsize=SIZE - 1.5, fmt=lambda value: plain(float(value), 4)) or ():
            name.set_bbox({"boxstyle": "round,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.85})
    axes.plot([], [], color=BLUE, lw=0.9, label=data.label)


def _net(data: Map, x: FloatArray, y: FloatArray) -> Any:
    """Triangles between points as near as they look; those over parts without a design are covered."""
    from matplotlib.tri import Triangulation

    seen = []
    for log, values in zip(data.log, (x, y), strict=True):
        along = np.log(values) if log else values
        seen.append((along - along.min()) / np.ptp(along))
    return Triangulation(x, y, Triangulation(*seen).triangles)


def _hatched(axes: Any, data: Map) -> Any:
    """The parts without a design, cell by cell, each up to where designs end on its sides."""
    from matplotlib.collections import PolyCollection
    from matplotlib.patches import Patch

    polygons = [polygon for polygon in _polygons(data) if len(polygon) > 2]
    axes.add_collection(PolyCollection(polygons, zorder=1, **forbidden()))
    return Patch(label="; ".join(data.bad_words) or "no design", **forbidden())


def _on_sides(data: Map) -> dict[tuple[bool, int, int], list[Side]]:
    """Places on the edges of the grid, by direction and cell of the edge."""
    found: dict[tuple[bool, int, int], list[Side]] = defaultdict(list)
    for side in data.sides:
        i = _cell(data.x, side.x) if side.across else int(np.abs(data.x - side.x).argmin())
        j = int(np.abs(data.y - side.y).argmin()) if side.across else _cell(data.y, side.y)
        found[side.across, i, j].append(side)
    return found


def _cell(values: Any, place: float) -> int:
    return int(np.clip(np.searchsorted(values, place) - 1, 0, len(values) - 2))


def _polygons(data: Map) -> Iterator[list[Spot]]:
    sides = _on_sides(data)
    for i in range(len(data.x) - 1):
        for j in range(len(data.y) - 1):
            corners = ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))
            if all(data.good[b, a] for a, b in corners):
                continue
            edges = ((True, i, j), (False, i + 1, j), (True, i, j + 1), (False, i, j))
            polygon: list[Spot] = []
            for k, ((a, b), edge) in enumerate(zip(corners, edges, strict=True)):
                c, d = corners[(k + 1) % 4]
                if not data.good[b, a]:
                    polygon.append((float(data.x[a]), float(data.y[b])))
                if data.good[b, a] != data.good[d, c]:
                    ends = [side for side in sides[edge] if side.ends]
                    x = ends[0].x if ends else 0.5 * float(data.x[a] + data.x[c])
                    y = ends[0].y if ends else 0.5 * float(data.y[b] + data.y[d])
                    polygon.append((x, y))
            yield polygon


def _edges(data: Map) -> dict[tuple[str, str] | None, list[tuple[Spot, Spot]]]:
    """Pieces of line within each cell between places of one kind; None: where designs begin or end."""
    sides = _on_sides(data)
    found: dict[tuple[str, str] | None, list[tuple[Spot, Spot]]] = {}
    for i in range(len(data.x) - 1):
        for j in range(len(data.y) - 1):
            kinds: dict[tuple[str, str] | None, list[Spot]] = defaultdict(list)
            for edge in ((True, i, j), (False, i + 1, j), (True, i, j + 1), (False, i, j)):
                for side in sides.get(edge, ()):
                    kinds[None if side.ends else side.words].append((side.x, side.y))
            for kind, spots in kinds.items():
                pairs = list(zip(spots[::2], spots[1::2], strict=False))
                found.setdefault(kind, []).extend(pairs)
    return {kind: lines for kind, lines in found.items() if lines}
