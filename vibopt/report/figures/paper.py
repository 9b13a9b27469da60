"""What all figures share: paper, ink, axes, legend, and the file."""

from __future__ import annotations

from io import BytesIO
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.files.marks import FIGURES
from vibopt.units import plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.text import Annotation


WIDTH, HEIGHT = 7.4, 4.0
"""Inches; a panel fills the text width of an A4 page."""

SIZE = 9.0
"""Points of ordinary text."""

_LETTERS = 92
"""About as many stand beside each other in a legend."""

_NOTED, _BOLD = 120, 1.7
"""Faint letters that stand beside each other above a panel, and as many of them as one of its title takes."""

INK, FAINT, GRID = "#1a1a1a", "#767676", "#d9d9d9"
BLUE, RED, GREEN = "#1f4e8c", "#b3261e", "#1b6e3c"
FREE, FORBIDDEN, FORBIDDEN_INK = "#e3f1e7", "#fbe9e7", "#c98a84"
COLOURS = (BLUE, "#a0522d", "#000000", "#6a3d9a", "#00736b", "#7a7a7a")
STYLES: tuple[Any, ...] = ("-", "--", "-.", ":", (0, (6, 1, 1, 1, 1, 1)), (0, (1, 3)))
DASHES: tuple[Any, ...] = ((0, (4, 3)), (0, (1.5, 1.5)), (0, (7, 2, 1.5, 2)), (0, (7, 4)))
HATCHES = ("////", "\\\\\\\\", "xxxx", "....", "++++", "oo")


def forbidden(index: int = 0) -> dict[str, Any]:
    """How a part of a figure looks that a limit forbids; each limit has its own hatching."""
    hatch = HATCHES[index % len(HATCHES)]
    return {"facecolor": FORBIDDEN, "edgecolor": FORBIDDEN_INK, "hatch": hatch, "linewidth": 0.0}


END = 4
LAST_DRAWN = "\u0530"
"""The font of figures knows Latin, Greek and Cyrillic letters, all below this."""


def short(name: str, longest: int) -> str:
    """A name without its middle where it is longer than `longest` letters; the number at its end is kept."""
    if len(name) <= longest:
        return name
    return f"{name[: longest - END - 3]}...{name[-END:]}"


def drawn(name: str, longest: int) -> str:
    """A name for a figure: short, no formula, and "?" for letters that its font does not have."""
    known = "".join(letter if letter < LAST_DRAWN else "?" for letter in short(name, longest))
    return known.replace("$", r"\$")


def sheet(width: float, height: float) -> Figure:
    """An empty figure [inches] on white paper."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def laid_out(figure: Figure) -> None:
    """Everything has its place from here on: labels that find theirs later stay there, and saving lays out no more."""
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
    figure.set_layout_engine("none")


def saved(figure: Figure, form: str) -> bytes:
    """The figure as a file: "svg", "png" or "pdf"; the same figure gives the same bytes."""
    import matplotlib

    stream = BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "vibopt", "svg.fonttype": "path", "pdf.fonttype": 42}):
        figure.savefig(stream, format=form, dpi=160, metadata=FIGURES[form])
    return stream.getvalue()


def dress(axes: Any, title: str, x_label: str, y_label: str, notes: str = "") -> None:
    """Title, faint notes beside it, or below it where both are long, labels with units, a quiet grid, no frame."""
    below = _BOLD * len(title) + len(notes) > _NOTED
    axes.set_title(title, loc="left", pad=6.0 + below * SIZE, fontsize=SIZE + 1.5, color=INK, fontweight="bold")
    if notes:
        axes.text(1.0, 1.015, notes, transform=axes.transAxes, ha="right", va="bottom", fontsize=SIZE - 2, color=FAINT)
    axes.set_xlabel(x_label, fontsize=SIZE, color=INK)
    axes.set_ylabel(y_label, fontsize=SIZE, color=INK)
    axes.tick_params(labelsize=SIZE - 1, colors=INK)
    axes.grid(True, which="major", color=GRID, lw=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def scale(axes: Any, which: str, log: bool, low: float, high: float) -> None:
    """Span of the axis `which` ("x" or "y"); a logarithmic one has numbers as people write them: 0.1, 20, 1000."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    if log:
        getattr(axes, f"set_{which}scale")("log")
        axis = getattr(axes, f"{which}axis")
        subs = (1.0, 2.0, 5.0) if high < 400.0 * low else (1.0,)
        axis.set_major_locator(LogLocator(base=10.0, subs=subs, numticks=20))
        axis.set_major_formatter(FuncFormatter(lambda value, _: plain(float(value), 3)))
        axis.set_minor_formatter(NullFormatter())
    getattr(axes, f"set_{which}lim")(low, high)


def legend(part: Any, *axes: Any, first: tuple[Any, ...] = ()) -> None:
    """All labels of some axes below them, where they cover nothing; `first` are handles of their own."""
    found: dict[str, Any] = {str(one.get_label()): one for one in first}
    for some in axes:
        for handle, words in zip(*some.get_legend_handles_labels(), strict=True):
            found.setdefault(words, handle)
    if found:
        words = [fill(one, _LETTERS, subsequent_indent="  ") for one in found]
        beside = 2 * max(map(len, words)) <= _LETTERS
        part.legend(
            list(found.values()),
            words,
            loc="outside lower center",
            ncols=min(len(found), 2 if beside else 1),
            fontsize=SIZE - 1,
            frameon=False,
            handlelength=2.6,
            handleheight=1.2,
            markerscale=0.7,
        )


_AROUND = ((1, 1), (-1, 1), (1, -1), (-1, -1), (1, 0), (-1, 0), (0, 1), (0, -1))
_FAR = (10, 24, 42, 64, 90)


def label(axes: Any, words: str, x: float, y: float) -> Annotation:
    """A label tied to a point; `place` moves it."""
    made: Annotation = axes.annotate(
        words,
        (x, y),
        xytext=(8, 8),
        textcoords="offset points",
        fontsize=SIZE - 1,
        color=INK,
        zorder=9,
        bbox={"boxstyle": "round,pad=0.25", "fc": "white", "ec": "#bbbbbb", "lw": 0.5, "alpha": 0.92},
        arrowprops={"arrowstyle": "-", "color": FAINT, "lw": 0.7, "shrinkA": 0, "shrinkB": 4},
        annotation_clip=False,
    )
    made.set_in_layout(False)
    return made


def place(labels: list[Annotation], dots: FloatArray) -> None:
    """Move each label to the nearest free place: inside the axes, off `dots` (n, 2) [pixels] and off each other.

    The figure must have been laid out before.
    """
    if not labels:
        return
    axes: Any = labels[0].axes
    renderer = axes.get_figure(root=True).canvas.get_renderer()
    frame = axes.get_window_extent(renderer)
    points = np.array([axes.transData.transform(one.xy) for one in labels]).reshape(-1, 2)
    taken: list[Any] = []
    for one in labels:
        places = [(dx * far, dy * far) for far in _FAR for dx, dy in _AROUND]
        costs = []
        for dx, dy in places:
            box = _moved(one, dx, dy, renderer)
            costs.append(_cost(box, frame, dots, points, taken) + 0.1 * max(abs(dx), abs(dy)))
        taken.append(_moved(one, *places[int(np.argmin(costs))], renderer))


def _moved(annotation: Annotation, dx: float, dy: float, renderer: Any) -> Any:
    """Set the label off by (dx, dy) points; its box in pixels."""
    from matplotlib.text import Text

    text: Any = annotation
    text.set_position((dx, dy))
    text.set_ha("left" if dx > 0 else "right" if dx < 0 else "center")
    text.set_va("bottom" if dy > 0 else "top" if dy < 0 else "center")
    text.update_positions(renderer)
    return Text.get_window_extent(annotation, renderer).padded(4.0)


def _cost(box: Any, frame: Any, dots: FloatArray, points: FloatArray, taken: list[Any]) -> float:
    """How bad a place is: out of the frame, over a curve, over a point, over another label."""
    gaps = (frame.x0 - box.x0, box.x1 - frame.x1, frame.y0 - box.y0, box.y1 - frame.y1)
    out = sum(max(gap, 0.0) for gap in gaps)
    over = sum(box.overlaps(other) for other in taken)
    return float(10.0 * out + 1000.0 * over + 0.6 * _count_in(box, dots) + 300.0 * _count_in(box, points))


def _count_in(box: Any, dots: FloatArray) -> int:
    inside = (dots[:, 0] > box.x0) & (dots[:, 0] < box.x1) & (dots[:, 1] > box.y0) & (dots[:, 1] < box.y1)
    return int(inside.sum())
