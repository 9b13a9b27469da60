"""What all figures share: paper, ink, axes, legend, and the file."""

from __future__ import annotations

from io import BytesIO
from typing import TYPE_CHECKING, Any

from vibopt.files.marks import FIGURES
from vibopt.units import plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 7.4, 4.0
"""Inches; a panel fills the text width of an A4 page."""

SIZE = 9.0
"""Points of ordinary text."""

INK, FAINT, GRID = "#1a1a1a", "#767676", "#d9d9d9"
BLUE, RED, GREEN = "#1f4e8c", "#b3261e", "#1b6e3c"
FREE, FORBIDDEN, FORBIDDEN_INK = "#e3f1e7", "#fbe9e7", "#c98a84"
COLOURS = (BLUE, "#a0522d", "#000000", "#6a3d9a", "#00736b", "#7a7a7a")
STYLES: tuple[Any, ...] = ("-", "--", "-.", ":", (0, (6, 1, 1, 1, 1, 1)), (0, (1, 3)))
DASHES: tuple[Any, ...] = ((0, (4, 3)), (0, (1.5, 1.5)), (0, (7, 2, 1.5, 2)), (0, (7, 4)))
HATCHES = ("////", "\\\\\\\\", "xxxx", "....", "++++", "oo")


def sheet(width: float, height: float) -> Figure:
    """An empty figure [inches] on white paper."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def saved(figure: Figure, form: str) -> bytes:
    """The figure as a file: "svg", "png" or "pdf"; the same figure gives the same bytes."""
    import matplotlib

    stream = BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "vibopt", "svg.fonttype": "path", "pdf.fonttype": 42}):
        figure.savefig(stream, format=form, dpi=160, metadata=FIGURES[form])
    return stream.getvalue()


def dress(axes: Any, title: str, x_label: str, y_label: str) -> None:
    """Title, labels with units, a quiet grid, no frame."""
    axes.set_title(title, loc="left", fontsize=SIZE + 1.5, color=INK, fontweight="bold")
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
        part.legend(
            list(found.values()),
            list(found),
            loc="outside lower center",
            ncols=min(len(found), 2),
            fontsize=SIZE - 1,
            frameon=False,
            handlelength=2.6,
            handleheight=1.2,
            markerscale=0.7,
        )
