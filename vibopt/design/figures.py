"""Figures: responses against speed, the plane of two design variables, a sweep.

Drawn for paper as well as for the screen: forbidden zones are hatched and lines differ by style, so that
nothing is lost in grey.  No state of matplotlib's pyplot is touched.
"""

from __future__ import annotations

from io import BytesIO
from itertools import groupby
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.design.curves import Mark, Panel, Zone
from vibopt.design.plane import Plane, PlaneAxis
from vibopt.forms import FloatArray
from vibopt.units import plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure
    from matplotlib.text import Annotation

WIDTH, HEIGHT = 7.4, 4.0
"""Inches; a panel fills the text width of an A4 page."""

INK, FAINT, BLUE, RED, GREEN = "#1a1a1a", "#8a8a8a", "#1f4e8c", "#b3261e", "#1b6e3c"
COLOURS = (BLUE, "#a0522d", "#000000", "#6a3d9a", "#00736b", "#7a7a7a")
STYLES = ("-", "--", "-.", ":", (0, (6, 1, 1, 1, 1, 1)), (0, (1, 3)))
GUESSES = ((0, (4, 3)), (0, (1.5, 1.5)), (0, (7, 2, 1.5, 2)), (0, (7, 4)))
HATCHES = ("////", "\\\\\\\\", "xxxx", "....", "++++", "oo")
SIZE = 9.0
MOST_LABELS = 5


def response_figure(panels: list[Panel], title: str = "") -> Figure:
    """Panels under each other in one figure."""
    figure = _figure(WIDTH, HEIGHT * max(len(panels), 1) + (0.35 if title else 0.0))
    if title:
        figure.suptitle(title, fontsize=SIZE + 3, fontweight="bold", color=INK)
    parts: Any = figure.subfigures(len(panels), 1, squeeze=False)[:, 0] if len(panels) > 1 else [figure]
    drawn = [(draw_panel(part, panel), panel) for part, panel in zip(parts, panels, strict=True)]
    figure.draw_without_rendering()
    for (_, labels), panel in drawn:
        _spread(labels, panel)
    return figure


def saved(figure: Figure, form: str) -> bytes:
    """The figure as a file: "svg", "png" or "pdf"; the same figure gives the same bytes."""
    import matplotlib

    stream = BytesIO()
    metadata: dict[str, Any] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(form, {})
    with matplotlib.rc_context({"svg.hashsalt": "vibopt", "svg.fonttype": "path", "pdf.fonttype": 42}):
        figure.savefig(stream, format=form, dpi=160, metadata=metadata)
    return stream.getvalue()


def _figure(width: float, height: float) -> Figure:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def draw_panel(part: Figure | SubFigure, panel: Panel) -> tuple[Axes, list[Annotation]]:
    """One panel: curve, forbidden zones, worst points, own speeds; the labels find their places later."""
    axes = part.subplots()
    _dress(axes, panel.title, panel.x_label, panel.y_label)
    if panel.log_x:
        axes.set_xscale("log")
    if panel.log_y:
        axes.set_yscale("log")
    axes.set_xlim(*panel.x_span)
    axes.set_ylim(*panel.y_span)
    for axis, log, span in ((axes.xaxis, panel.log_x, panel.x_span), (axes.yaxis, panel.log_y, panel.y_span)):
        if log:
            _log_ticks(axis, span)
    _draw_zones(axes, panel)
    _draw_own(axes, panel)
    _draw_good(axes, panel)
    for index, curve in enumerate(panel.curves):
        style, colour = STYLES[index % len(STYLES)], COLOURS[index % len(COLOURS)]
        known = np.where(curve.known, curve.y, np.nan)
        words = curve.label or None
        if int(curve.known.sum()) > 1:
            axes.plot(curve.x, known, linestyle=style, color=colour, lw=1.7, label=words, zorder=4)
            words = None
        if not curve.known.all():
            guessed = curve.y if int(curve.known.sum()) <= 1 else np.where(curve.known, np.nan, curve.y)
            dashes = GUESSES[index % len(GUESSES)]
            axes.plot(curve.x, guessed, linestyle=dashes, color=colour, lw=1.1, label=words, zorder=4)
    labels = _draw_marks(axes, panel)
    if panel.notes:
        axes.text(1.0, 1.015, "; ".join(panel.notes), transform=axes.transAxes, ha="right", va="bottom", fontsize=SIZE - 2, color=FAINT)
    _legend(part, axes)
    return axes, labels


def plane_figure(plane: Plane) -> Figure:
    """The design map: forbidden parts hatched per limit, boundaries named, the best design marked."""
    figure = _figure(WIDTH, 4.8)
    axes: Any = figure.subplots()
    _dress(axes, plane.title, plane.x.label, plane.y.label)
    x, y = plane.x.values, plane.y.values
    for axis, side in (("x", plane.x), ("y", plane.y)):
        _scale_axis(axes, axis, side)
    handles = _draw_boundaries(axes, plane)
    if plane.goal is not None and np.isfinite(plane.goal).any() and np.ptp(plane.goal[np.isfinite(plane.goal)]) > 0:
        lines = axes.contour(x, y, plane.goal, levels=_levels(plane.goal), colors=FAINT, linewidths=0.7, linestyles=":")
        axes.clabel(lines, fontsize=SIZE - 2.5, fmt=lambda value: plain(float(value), 3))
        axes.plot([], [], color=FAINT, lw=0.7, linestyle=":", label=plane.goal_label)
    labels = []
    if plane.best is not None:
        axes.plot(*plane.best, marker="*", ms=15, mfc="white", mec=INK, mew=1.3, zorder=8, linestyle="none", label="chosen design")
        labels.append(_label(axes, plane.best_words, *plane.best))
    _legend(figure, axes, handles)
    figure.draw_without_rendering()
    _place(labels, _boundary_points(axes, plane))
    return figure


def _scale_axis(axes: Any, axis: str, side: PlaneAxis) -> None:
    getattr(axes, f"set_{axis}lim")(side.values[0], side.values[-1])
    if side.log:
        getattr(axes, f"set_{axis}scale")("log")
        _log_ticks(getattr(axes, f"{axis}axis"), (side.values[0], side.values[-1]))


def _draw_boundaries(axes: Any, plane: Plane) -> tuple[Any, ...]:
    """Each limit's forbidden part hatched in its own way, with its boundary as a line; handles for the legend."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    x, y = plane.x.values, plane.y.values
    worst = np.max([one.excess for one in plane.boundaries], axis=0) if plane.boundaries else np.zeros((len(y), len(x)))
    axes.contourf(x, y, worst, levels=[-1e3, 0.0], colors=["#e3f1e7"], zorder=0.5)
    handles: list[Any] = [Patch(facecolor="#e3f1e7", edgecolor="#9fc9ab", label="all limits hold")]
    for index, one in enumerate(plane.boundaries):
        if not (one.excess > 0.0).any():
            handles.append(Line2D([], [], linestyle="none", label=f"{one.name}: holds everywhere here"))
            continue
        colour, style = COLOURS[index % len(COLOURS)], STYLES[index % 4]
        hatch = HATCHES[index % len(HATCHES)][:2]
        filled = axes.contourf(x, y, one.excess, levels=[0.0, 1e3], colors="none", hatches=[hatch], zorder=1.0)
        filled.set_edgecolor(_light(colour))
        filled.set_linewidth(0.0)
        if (one.excess < 0.0).any():
            axes.contour(x, y, one.excess, levels=[0.0], colors=[colour], linewidths=1.7, linestyles=[style], zorder=3)
        handles.append(Patch(facecolor="white", edgecolor=_light(colour), hatch=hatch * 2, label=f"{one.name} is broken"))
    return tuple(handles)


def _light(colour: str) -> tuple[float, float, float]:
    """The colour, half way to white."""
    from matplotlib.colors import to_rgb

    red, green, blue = (0.5 + 0.5 * part for part in to_rgb(colour))
    return red, green, blue


def _levels(values: FloatArray) -> FloatArray:
    """Round levels of the goal."""
    finite = values[np.isfinite(values)]
    low, high = float(np.percentile(finite, 2)), float(np.percentile(finite, 98))
    if low > 0.0 and high > 20.0 * low:
        exponents = np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1)
        return np.unique(np.outer(10.0**exponents, [1.0, 2.0, 5.0]))
    from matplotlib.ticker import MaxNLocator

    return np.unique(MaxNLocator(8).tick_values(low, high))


def _boundary_points(axes: Any, plane: Plane) -> FloatArray:
    """Grid points beside a boundary, in pixels."""
    x, y = np.meshgrid(plane.x.values, plane.y.values)
    near = np.zeros(x.shape, dtype=bool)
    for one in plane.boundaries:
        near |= np.abs(one.excess) < 0.05
    points: FloatArray = axes.transData.transform(np.column_stack([x[near], y[near]]))
    return points


def _dress(axes: Axes, title: str, x_label: str, y_label: str) -> None:
    axes.set_title(title, loc="left", fontsize=SIZE + 1.5, color=INK, fontweight="bold")
    axes.set_xlabel(x_label, fontsize=SIZE, color=INK)
    axes.set_ylabel(y_label, fontsize=SIZE, color=INK)
    axes.tick_params(labelsize=SIZE - 1, colors=INK)
    axes.grid(True, which="major", color="#d9d9d9", lw=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def _log_ticks(axis: Any, span: tuple[float, float]) -> None:
    """Numbers as people write them: 0.1, 20, 1000."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    subs = (1.0, 2.0, 5.0) if np.log10(span[1] / span[0]) < 2.6 else (1.0,)
    axis.set_major_locator(LogLocator(base=10.0, subs=subs, numticks=20))
    axis.set_major_formatter(FuncFormatter(lambda value, _: plain(float(value), 3)))
    axis.set_minor_formatter(NullFormatter())


def _draw_zones(axes: Axes, panel: Panel) -> None:
    for index, (_, group) in enumerate(groupby(panel.zones, key=lambda zone: (zone.name, zone.above))):
        for first, zone in enumerate(group):
            low, high = _wide(zone, panel)
            floor, ceiling = panel.y_span
            bottom, top = (zone.bound, ceiling) if zone.above else (floor, zone.bound)
            axes.fill_between(
                [low, high],
                bottom,
                top,
                facecolor="#fbe9e7",
                edgecolor="#c98a84",
                hatch=HATCHES[index % len(HATCHES)],
                lw=0.0,
                zorder=1.5 - 0.1 * index,
                label=zone.words if first == 0 else None,
            )
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


def _draw_own(axes: Axes, panel: Panel) -> None:
    """Own speeds: a line, or a bar along the axis for a range."""
    from matplotlib.transforms import blended_transform_factory

    mixed = blended_transform_factory(axes.transData, axes.transAxes)
    for first, (low, high) in enumerate(panel.own):
        words = f"own speed{'s' * (low < high)} of {panel.excitation}" if first == 0 else None
        if low == high:
            axes.axvline(low, color=FAINT, lw=1.0, linestyle=":", zorder=2, label=words)
        else:
            axes.plot([low, high], [0.012, 0.012], transform=mixed, color=INK, lw=3.0, solid_capstyle="butt", zorder=5, label=words)


def _draw_good(axes: Axes, panel: Panel) -> None:
    from matplotlib.transforms import blended_transform_factory

    mixed = blended_transform_factory(axes.transData, axes.transAxes)
    for first, (low, high) in enumerate(panel.good):
        axes.axvspan(low, high, facecolor="#e3f1e7", zorder=0.5)
        axes.plot([low, high], [0.015, 0.015], transform=mixed, color=GREEN, lw=4.0, solid_capstyle="butt", zorder=5, label="all limits hold" if first == 0 else None)


def _draw_marks(axes: Axes, panel: Panel) -> list[Annotation]:
    """Worst points, one label for points that coincide; many points are left without, the tables have their values."""
    merged: dict[tuple[int, int], list[Mark]] = {}
    for mark in panel.marks:
        merged.setdefault(_spot(axes, mark), []).append(mark)
    labels: list[Annotation] = []
    for marks in merged.values():
        x, y = marks[0].x, marks[0].y
        inside = isfinite(y) and panel.y_span[0] <= y <= panel.y_span[1]
        height = y if inside else panel.y_span[1] if y > panel.y_span[0] else panel.y_span[0]
        axes.plot([x], [height], marker="o" if inside else "^", ms=6.5, mfc="white", mec=INK, mew=1.4, zorder=6, clip_on=False)
        if len(merged) <= MOST_LABELS:
            labels.append(_label(axes, "\n".join(mark.words for mark in marks), x, height))
    return labels


def _spot(axes: Axes, mark: Mark) -> tuple[int, int]:
    """The place of a mark in the axes, in fiftieths of their size; marks of one place share a label."""
    x, y = axes.transAxes.inverted().transform(axes.transData.transform((mark.x, mark.y if isfinite(mark.y) else 1e300)))
    return round(50.0 * x), round(min(max(50.0 * y, -50.0), 100.0))


def _label(axes: Axes, words: str, x: float, y: float) -> Annotation:
    label = axes.annotate(
        words,
        (x, y),
        xytext=(8, 8),
        textcoords="offset points",
        fontsize=SIZE - 1,
        color=INK,
        zorder=7,
        bbox={"boxstyle": "round,pad=0.25", "fc": "white", "ec": "#bbbbbb", "lw": 0.5, "alpha": 0.92},
        arrowprops={"arrowstyle": "-", "color": FAINT, "lw": 0.7, "shrinkA": 0, "shrinkB": 4},
        annotation_clip=False,
    )
    label.set_in_layout(False)
    return label


def _spread(labels: list[Annotation], panel: Panel) -> None:
    """Place the labels of a panel off its curves."""
    if labels:
        axes: Any = labels[0].axes
        curves = [np.column_stack([one.x, one.y])[np.isfinite(one.y)] for one in panel.curves]
        _place(labels, axes.transData.transform(np.concatenate(curves)))


def _place(labels: list[Annotation], dots: FloatArray) -> None:
    """Move each label to the free place nearest to its point: inside the axes, off `dots` [pixels] and off each other."""
    if not labels:
        return
    axes: Any = labels[0].axes
    figure: Any = axes.get_figure(root=True)
    renderer = figure.canvas.get_renderer()
    frame = axes.get_window_extent(renderer)
    points = np.array([axes.transData.transform(label.xy) for label in labels]).reshape(-1, 2)
    taken: list[Any] = []
    for label in labels:
        places = [(dx * far, dy * far) for far in (10, 24, 42, 64, 90) for dx, dy in _AROUND]
        costs = []
        for dx, dy in places:
            box = _moved(label, dx, dy, renderer)
            costs.append(_cost(box, frame, dots, points, taken) + 0.1 * max(abs(dx), abs(dy)))
        taken.append(_moved(label, *places[int(np.argmin(costs))], renderer))


_AROUND = ((1, 1), (-1, 1), (1, -1), (-1, -1), (1, 0), (-1, 0), (0, 1), (0, -1))


def _moved(label: Annotation, dx: float, dy: float, renderer: Any) -> Any:
    """Set the label off by (dx, dy) points, and its box in pixels."""
    from matplotlib.text import Text

    label.set_position((dx, dy))
    label.set_ha("left" if dx > 0 else "right" if dx < 0 else "center")
    label.set_va("bottom" if dy > 0 else "top" if dy < 0 else "center")
    label.update_positions(renderer)
    return Text.get_window_extent(label, renderer).padded(4.0)


def _cost(box: Any, frame: Any, dots: Any, points: Any, taken: list[Any]) -> float:
    """How bad a place is: out of the frame, over a curve, over a point, over another label."""
    out = max(frame.x0 - box.x0, 0) + max(box.x1 - frame.x1, 0) + max(frame.y0 - box.y0, 0) + max(box.y1 - frame.y1, 0)
    over = sum(box.overlaps(other) for other in taken)
    return 10.0 * out + 1000.0 * over + 0.6 * _count_in(box, dots) + 300.0 * _count_in(box, points)


def _count_in(box: Any, dots: Any) -> int:
    inside = (dots[:, 0] > box.x0) & (dots[:, 0] < box.x1) & (dots[:, 1] > box.y0) & (dots[:, 1] < box.y1)
    return int(inside.sum())


def _legend(part: Figure | SubFigure, axes: Axes, more: tuple[Any, ...] = ()) -> None:
    handles, labels = axes.get_legend_handles_labels()
    handles, labels = [*more, *handles], [*(one.get_label() for one in more), *labels]
    if handles:
        part.legend(
            handles,
            labels,
            loc="outside lower center",
            ncols=min(len(labels), 2),
            fontsize=SIZE - 1,
            frameon=False,
            handlelength=2.6,
            handleheight=1.2,
        )
