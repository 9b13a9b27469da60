"""The figure of speed against accuracy: a panel a case, a line a rival, the same marks as in every chart."""

from __future__ import annotations

import math
from collections.abc import Sequence
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.charts.chart_figures import LOOKS, headed
from vibopt.charts.verdicts import BROKEN, RIGHT, SILENT, UNPROVEN
from vibopt.records import dataclass
from vibopt.report.figures.paper import FAINT, INK, SIZE, STYLES, WIDTH, dress, laid_out, place, sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_TITLE = 44
"""Letters of a title that a panel has room for."""
FLOOR = 1e-15
"""True errors below this are drawn here: they are rounding."""


@dataclass(frozen=True, slots=True)
class Dot:
    """One method on one case: time over that of the default, true error, class of its claim.

    kernel
        Time of its optimiser alone over that of the default; nan where it is not drawn.
    line
        Dots of one rival at several settings, finer ones later, share a line.
    middle
        Between what the middle half of its times lies, over the time of the default.
    """

    name: str
    ratio: float
    error: float
    verdict: str
    kernel: float = math.nan
    line: str = ""
    middle: tuple[float, float] = (math.nan, math.nan)


@dataclass(frozen=True, slots=True)
class Scatter:
    """One case; `seconds` is the time of the default, `silent` lists methods without design, `measure` is the error."""

    title: str
    seconds: float
    dots: tuple[Dot, ...]
    silent: tuple[str, ...] = ()
    measure: str = "true error (part)"


def accuracy_figure(cases: Sequence[Scatter], default: str, above: str = "") -> Figure:
    """A panel per case: true error over time, both logarithmic; the mark says the class, `above` is a note."""
    columns = min(2, max(len(cases), 1))
    rows = max(-(-len(cases) // columns), 1)
    figure = sheet(WIDTH * (1.25 if columns == 2 else 1.0), 1.0 + 2.9 * rows)
    axes: Any = figure.subplots(rows, columns, squeeze=False)
    span = _span([ratio for case in cases for dot in case.dots for ratio in (dot.ratio, dot.kernel)])
    top = _top([dot.error for case in cases for dot in case.dots])
    drawn = []
    for index, case in enumerate(cases):
        panel = axes.flat[index]
        last = index + columns >= len(cases)
        under = f"time over that of {default}" if last else ""
        dress(panel, "\n".join(wrap(case.title, _TITLE)), under, case.measure if index % columns == 0 else "")
        drawn.append((panel, _scatter(panel, case, default, span, top)))
    for panel in axes.flat[len(cases) :]:
        panel.set_axis_off()
    figure.legend(handles=_marks(default), loc="outside lower center", ncols=2, fontsize=SIZE - 1, frameon=False)
    headed(figure, above)
    laid_out(figure)
    for panel, (labels, dots) in drawn:
        place(labels, panel.transData.transform(dots) if len(dots) else np.zeros((0, 2)))
    return figure


def _scatter(panel: Any, case: Scatter, default: str, span: tuple[float, float], top: float) -> tuple[list[Any], Any]:
    panel.set_xscale("log")
    panel.set_yscale("log")
    panel.set_xlim(*span)
    panel.set_ylim(FLOOR / 1e5, top)  # room for the note
    panel.set_yticks([10.0**e for e in range(-15, int(math.log10(top)) + 1, 3)])
    panel.minorticks_off()
    panel.axvline(1.0, color=FAINT, lw=0.8, zorder=1)
    panel.axhline(BROKEN, color=FAINT, lw=0.8, ls=(0, (4, 3)), zorder=1)
    _note(panel, case, default)
    lines = list(dict.fromkeys(dot.line for dot in case.dots if dot.line))
    for index, line in enumerate(lines):
        places = [(dot.ratio, _height(dot, top)) for dot in case.dots if dot.line == line]
        panel.plot(*zip(*places, strict=True), color=FAINT, lw=0.9, ls=STYLES[index % len(STYLES)], zorder=3)
    ends = {line: next(dot for dot in reversed(case.dots) if dot.line == line) for line in lines}
    labels = []
    for dot in sorted(case.dots, key=lambda one: (one.ratio, -one.error)):
        y = _height(dot, top)
        own = dot.name == default
        face, _, mark = LOOKS[dot.verdict]
        edge = INK if dot.verdict != SILENT else face
        if own and dot.verdict == RIGHT:
            face, mark = INK, "D"
        panel.plot(
            [dot.ratio], [y], ls="", marker=mark, ms=9.0 if own else 6.0, mfc=face, mec=edge, mew=0.9, zorder=5 + own
        )  # fmt: skip
        if all(map(math.isfinite, dot.middle)):
            panel.plot(dot.middle, [y, y], color=INK, lw=1.6, alpha=0.6, zorder=4)
        if math.isfinite(dot.kernel):
            panel.plot([dot.kernel, dot.ratio], [y, y], color=INK, lw=0.8, zorder=4)
            panel.plot([dot.kernel], [y], ls="", marker="|", ms=9.0, mec=INK, mew=1.6, zorder=5)
        if dot.line not in ends or ends[dot.line] is dot:
            labels.append(_label(panel, dot.line or dot.name, dot.ratio, y))
    points = np.array([(dot.ratio, _height(dot, top)) for dot in case.dots]).reshape(-1, 2)
    return labels, points


def _note(panel: Any, case: Scatter, default: str) -> None:
    note = f"{default}: {_seconds(case.seconds)}"
    if case.silent:
        note += "\n" + "\n".join(wrap(f"no design: {', '.join(case.silent)}", 60))
    panel.text(
        0.99, 0.015, note, transform=panel.transAxes, ha="right", va="bottom", fontsize=SIZE - 2.5, color=INK, zorder=8,
        bbox={"fc": "white", "ec": "none", "pad": 1.0, "alpha": 0.85},
    )  # fmt: skip


def _height(dot: Dot, top: float) -> float:
    """Where its error is drawn."""
    return min(max(dot.error, FLOOR), top / 3.0)


def _label(panel: Any, words: str, x: float, y: float) -> Any:
    made = panel.annotate(
        words, (x, y), xytext=(6, 6), textcoords="offset points", fontsize=SIZE - 2.5, color=INK, zorder=9,
        annotation_clip=False,
        arrowprops={"arrowstyle": "-", "color": FAINT, "lw": 0.5, "shrinkA": 0, "shrinkB": 3},
    )  # fmt: skip
    made.set_in_layout(False)
    return made


def _marks(default: str) -> list[Any]:
    from matplotlib.lines import Line2D

    def mark(marker: str, face: str, edge: str, words: str) -> Line2D:
        return Line2D([], [], ls="", marker=marker, mfc=face, mec=edge, mew=0.9, ms=6.5, label=words)

    words = {
        RIGHT: "right: the claim holds", UNPROVEN: "unproven, and off by so much",
        SILENT: "silently wrong: claims success or proof, and is not",
    }  # fmt: skip
    return [
        mark("D", INK, INK, f"{default}, from the job to the checked answer"),
        mark("|", INK, INK, f"{default}, its optimiser alone"),
        *(mark(LOOKS[name][2], LOOKS[name][0], INK if name != SILENT else LOOKS[name][0], say)
          for name, say in words.items()),
        Line2D([], [], color=FAINT, lw=0.9, label="one rival, coarse to fine; its name stands at the finest"),
        Line2D([], [], color=FAINT, ls=(0, (4, 3)), lw=0.8, label="a limit counts as broken above"),
    ]  # fmt: skip


def _span(ratios: list[float]) -> tuple[float, float]:
    good = [ratio for ratio in ratios if math.isfinite(ratio) and ratio > 0]
    return min([0.3, *good]) / 2.0, max([3.0, *good]) * 3.0


def _top(errors: list[float]) -> float:
    good = [error for error in errors if math.isfinite(error)]
    return float(10.0 ** math.ceil(math.log10(max([1.0, *good])) + 1.0))


def _seconds(value: float) -> str:
    if not math.isfinite(value):
        return "no answer"
    return f"{value * 1e3:.3g} ms" if value < 1.0 else f"{value:.3g} s"
