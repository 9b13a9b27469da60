"""Figures of the charts: speed against accuracy, stability, fidelity.  Nothing is lost in grey."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.records import dataclass
from vibopt.report.figures.paper import BLUE, COLOURS, FAINT, GRID, INK, RED, SIZE, STYLES, WIDTH, dress, place, sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_TITLE = 44
"""Letters of a title that a panel has room for."""
FLOOR = 1e-15
"""True errors below this are drawn here: they are rounding."""


@dataclass(frozen=True, slots=True)
class Dot:
    """One method on one case: time over that of the default, true error, whether its claim is false.

    kernel
        Time of its optimiser alone over that of the default; nan where it is not drawn.
    line
        Dots of one rival at several settings, finer ones later, share a line.
    """

    name: str
    ratio: float
    error: float
    wrong: bool
    kernel: float = math.nan
    line: str = ""


@dataclass(frozen=True, slots=True)
class Scatter:
    """One case; `seconds` is the time of the default, `silent` lists methods without design, `measure` is the error."""

    title: str
    seconds: float
    dots: tuple[Dot, ...]
    silent: tuple[str, ...] = ()
    measure: str = "true error (part)"


@dataclass(frozen=True, slots=True)
class Bars:
    """One scene of the chart of fidelity; ratios are full model over reduced model."""

    title: str
    declared: int
    used: int
    measuring: float
    solving: float
    error: float


def accuracy_figure(cases: Sequence[Scatter], default: str, above: str = "") -> Figure:
    """A panel per case: true error over time, both logarithmic; false claims are hollow and red, `above` is a note."""
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
    figure.canvas.draw()
    for panel, (labels, dots) in drawn:
        place(labels, panel.transData.transform(dots) if len(dots) else np.zeros((0, 2)))
    figure.set_layout_engine("none")
    return figure


def headed(figure: Figure, words: str) -> None:
    """Under what it was measured, small, above everything else."""
    if words:
        wide = int(figure.get_figwidth() * 72.0 / (0.55 * (SIZE - 2.5)))
        figure.suptitle("\n".join(wrap(words, wide)), x=0.01, ha="left", fontsize=SIZE - 2.5, color=FAINT)


def _scatter(panel: Any, case: Scatter, default: str, span: tuple[float, float], top: float) -> tuple[list[Any], Any]:
    panel.set_xscale("log")
    panel.set_yscale("log")
    panel.set_xlim(*span)
    panel.set_ylim(FLOOR / 1e5, top)  # room for the note
    panel.set_yticks([10.0**e for e in range(-15, int(math.log10(top)) + 1, 3)])
    panel.minorticks_off()
    panel.axvline(1.0, color=FAINT, lw=0.8, zorder=1)
    panel.axhline(1e-6, color=FAINT, lw=0.8, ls=(0, (4, 3)), zorder=1)
    note = f"{default}: {_seconds(case.seconds)}"
    if case.silent:
        note += f"\nno design: {', '.join(case.silent)}"
    panel.text(
        0.99,
        0.015,
        note,
        transform=panel.transAxes,
        ha="right",
        va="bottom",
        fontsize=SIZE - 2.5,
        color=INK,
        zorder=8,
        bbox={"fc": "white", "ec": "none", "pad": 1.0, "alpha": 0.85},
    )
    for line in dict.fromkeys(dot.line for dot in case.dots if dot.line):
        places = [(dot.ratio, _height(dot, top)) for dot in case.dots if dot.line == line]
        panel.plot(*zip(*places, strict=True), color=FAINT, lw=0.8, zorder=3)
    labels = []
    for dot in sorted(case.dots, key=lambda one: (one.ratio, -one.error)):
        y = _height(dot, top)
        own = dot.name == default
        colour = INK if own else BLUE
        panel.plot(
            [dot.ratio], [y], ls="", marker="D" if own else "o", ms=9.5 if own else 5.5,
            mfc="none" if dot.wrong else colour, mec=RED if dot.wrong else colour, mew=1.6, zorder=5,
        )  # fmt: skip
        if math.isfinite(dot.kernel):
            panel.plot([dot.kernel, dot.ratio], [y, y], color=colour, lw=0.8, zorder=4)
            panel.plot([dot.kernel], [y], ls="", marker="|", ms=9.0, mec=colour, mew=1.6, zorder=5)
        labels.append(_label(panel, dot.name, dot.ratio, y))
    points = np.array([(dot.ratio, _height(dot, top)) for dot in case.dots]).reshape(-1, 2)
    return labels, points


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
        return Line2D([], [], ls="", marker=marker, mfc=face, mec=edge, mew=1.6, ms=6.5, label=words)

    return [
        mark("D", INK, INK, f"{default}, from the job to the checked answer (numbers: sampled speeds)"),
        mark("|", INK, INK, f"{default}, its optimiser alone"),
        mark("o", BLUE, BLUE, "claim holds"),
        mark("o", "none", RED, "claims success and is wrong"),
        Line2D([], [], color=FAINT, lw=0.8, label="one rival, from few sampled speeds to many"),
        Line2D([], [], color=FAINT, ls=(0, (4, 3)), lw=0.8, label="a limit counts as broken above"),
    ]


def stability_figure(
    families: Sequence[str],
    methods: Sequence[str],
    counts: Mapping[tuple[str, str], Mapping[str, int]],
    classes: Sequence[str],
    above: str = "",
) -> Figure:
    """Families by methods, a panel for those given to the same methods; `above` is a note.

    Each cell is filled by class, with the number of answers of the class written in it.
    """
    given = {family: tuple(method for method in methods if (family, method) in counts) for family in families}
    groups = list(dict.fromkeys(given.values()))
    sizes = [sum(one == group for one in given.values()) for group in groups]
    figure = sheet(WIDTH * 1.25, 1.0 + 0.9 * len(groups) + 0.42 * len(families))
    panels: Any = figure.subplots(len(groups), 1, squeeze=False, height_ratios=sizes)
    looks = dict(zip(classes, _LOOKS, strict=False))
    for axes, group in zip(panels.flat, groups, strict=True):
        rows = [family for family in families if given[family] == group]
        for row, family in enumerate(rows):
            for column, method in enumerate(group):
                _cell(axes, column, row, counts[family, method], classes, looks)
        _names(axes, rows, group)
    from matplotlib.patches import Patch

    handles = [Patch(fc=face, ec=INK, lw=0.6, hatch=hatch, label=name) for name, (face, hatch) in looks.items()]
    figure.legend(
        handles=handles, loc="outside lower center", ncols=len(handles), fontsize=SIZE - 1, frameon=False,
        handlelength=2.0, handleheight=1.2, title="share of a family's scenes", title_fontsize=SIZE - 1,
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


_LOOKS = (("#dfeee3", ""), ("#c9cfd6", "...."), ("#8d97a3", "////"), (RED, ""), ("white", ""))


def _cell(
    axes: Any,
    column: int,
    row: int,
    count: Mapping[str, int],
    classes: Sequence[str],
    looks: Mapping[str, tuple[str, str]],
) -> None:
    from matplotlib.patches import Rectangle

    total, left, wide, high = sum(count.get(name, 0) for name in classes), column - 0.45, 0.9, 0.72
    axes.add_patch(
        Rectangle(
            (left, row - high / 2), wide, high, fc="white", ec=INK if total else GRID, lw=0.6, zorder=4, fill=False
        )
    )
    if not total:
        axes.text(column, row, next(iter(count), "not asked"), ha="center", va="center", fontsize=SIZE - 3, color=FAINT)
        return
    for name in classes:
        part = count.get(name, 0) / total * wide
        face, hatch = looks[name]
        if part > 0:
            axes.add_patch(
                Rectangle((left, row - high / 2), part, high, fc=face, ec=INK, lw=0.4, hatch=hatch, zorder=3)
            )
            own = str(count[name]) if part > 0.06 else ""
            dark = face == RED
            box = None if dark or not hatch else {"fc": "white", "ec": "none", "pad": 0.6}
            axes.text(
                left + part / 2, row, own, ha="center", va="center", fontsize=SIZE - 2, zorder=5,
                bbox=box if own else None,
                color="white" if dark else INK, fontweight="bold" if dark else "normal",
            )  # fmt: skip
            left += part


def fidelity_figure(rows: Sequence[Bars], above: str = "") -> Figure:
    """Degrees of freedom declared and used, time saved, and the error made, scene by scene; `above` is a note."""
    figure = sheet(WIDTH * 1.25, 1.6 + 0.34 * len(rows))
    axes: Any = figure.subplots(1, 3, sharey=True, width_ratios=(1.2, 1.0, 1.0))
    at = np.arange(len(rows))
    dress(axes[0], "Model", "freedoms, planes, sensors, speeds", "")
    axes[0].barh(at, [row.declared for row in rows], 0.7, fc="white", ec=INK, lw=0.8, label="declared")
    axes[0].barh(at, [row.used for row in rows], 0.4, fc=BLUE, ec=BLUE, label="used")
    for y, row in zip(at, rows, strict=True):
        axes[0].annotate(
            f"{row.declared} → {row.used}",
            (row.declared, y),
            xytext=(3, 0),
            textcoords="offset points",
            va="center",
            fontsize=SIZE - 2,
        )
    axes[0].set_xlim(0, 1.35 * max((row.declared for row in rows), default=1))
    axes[0].set_yticks(at, [row.title for row in rows], fontsize=SIZE - 1)
    axes[0].invert_yaxis()
    dress(axes[1], "Time saved", "time on the full over the reduced model", "")
    axes[1].set_xscale("log")
    axes[1].axvline(1.0, color=FAINT, lw=0.8)
    axes[1].plot(
        [row.measuring for row in rows], at, ls="", marker="s", ms=6, mfc="white", mec=INK, label="measuring a design"
    )
    axes[1].plot([row.solving for row in rows], at, ls="", marker="o", ms=6, mfc=BLUE, mec=BLUE, label="solving")
    _plain_numbers(axes[1], [value for row in rows for value in (row.measuring, row.solving)])
    dress(axes[2], "Error of the values", "greatest difference (part)", "")
    axes[2].set_xscale("log")
    axes[2].plot(
        [max(row.error, 1e-17) for row in rows],
        at,
        ls="",
        marker="D",
        ms=5,
        mfc=INK,
        mec=INK,
        label="reduced against full",
    )
    top = max([1e-6, *(10.0 * row.error for row in rows if math.isfinite(row.error))])
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
    """Performance profiles: a row of two panels a family, exact answers and fair ones.

    Parameters
    ----------
    rows
        By family, for either panel the times of each method over the best time on that question, infinite where it
        has no answer, shape (count,).
    """
    figure = sheet(WIDTH * 1.25, 1.0 + 2.8 * len(rows))
    axes: Any = figure.subplots(len(rows), 2, squeeze=False, sharey=True)
    methods = list(dict.fromkeys(name for pair in rows.values() for one in pair for name in one))
    looks = {name: (COLOURS[i % len(COLOURS)], STYLES[(i + i // len(COLOURS)) % len(STYLES)])
             for i, name in enumerate(methods)}  # fmt: skip
    longest = max([10.0, *(float(t) for pair in rows.values() for one in pair for row in one.values()
                           for t in row if math.isfinite(t))])  # fmt: skip
    for panels, (family, pair) in zip(axes, rows.items(), strict=True):
        for panel, times, error in zip(panels, pair, ("1e-6", "1e-3"), strict=True):
            dress(panel, f"{family}, to {error}", "time over the best on the same question", "share answered")
            panel.set_xscale("log")
            panel.set_xlim(1.0, 2.0 * longest)
            panel.set_ylim(0.0, 1.04)
            for name, row in times.items():
                good = np.sort(row[np.isfinite(row)])
                share = np.arange(1, len(good) + 1) / count
                colour, style = looks[name]
                panel.step(
                    [1.0, *good, 2.0 * longest], [0.0, *share, share[-1]], where="post", color=colour, ls=style,
                    lw=2.6 if name == default else 1.4, zorder=6 if name == default else 5,
                )  # fmt: skip
    from matplotlib.lines import Line2D

    handles = [Line2D([], [], color=looks[name][0], ls=looks[name][1], lw=2.6 if name == default else 1.4, label=name)
               for name in methods]  # fmt: skip
    figure.legend(
        handles=handles, loc="outside lower center", ncols=4, fontsize=SIZE - 1, frameon=False, handlelength=3.5
    )
    headed(figure, above)
    return figure


def _plain_numbers(panel: Any, values: list[float]) -> None:
    good = [value for value in values if math.isfinite(value) and value > 0]
    low, high = min([0.5, *good]), max([2.0, *good])
    panel.set_xlim(low / 1.6, high * 1.6)
    ticks = [t for t in (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000) if low / 1.6 <= t <= high * 1.6]
    if len(ticks) > 5:
        ticks = [t for t in ticks if str(t).strip("0.") == "1"]
    panel.set_xticks(ticks, [f"{t:g}" for t in ticks])
    panel.minorticks_off()


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
