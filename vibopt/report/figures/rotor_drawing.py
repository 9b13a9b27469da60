"""A rotor from the side: sections with their bores, discs, and where bearings hold it; diameters are drawn larger."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from vibopt.records import dataclass
from vibopt.report.figures.paper import FAINT, GRID, INK, SIZE, WIDTH, sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True)
class Rotor:
    """What is drawn of one rotor [m].

    sections
        Left end, right end, diameter and bore of each.
    discs
        Words, place, diameter and width of each; nan where its sizes are not known.
    held
        Place of each station at which links end, and their words.
    """

    name: str
    sections: tuple[tuple[float, float, float, float], ...]
    discs: tuple[tuple[str, float, float, float], ...]
    held: tuple[tuple[float, str], ...]


def rotor_figure(rotors: Sequence[Rotor], title: str, notes: Sequence[str] = ()) -> Figure:
    """One panel a rotor; lengths are to scale, and so are diameters among each other."""
    figure = sheet(WIDTH, 0.6 + 2.6 * len(rotors) + 0.16 * len(notes))
    panels: Any = figure.subplots(len(rotors), 1, squeeze=False)
    for axes, rotor in zip(panels.flat, rotors, strict=True):
        _draw(axes, rotor)
        axes.set_title(title if len(rotors) == 1 else rotor.name, loc="left", fontsize=SIZE + 1.5, fontweight="bold")
    if notes:
        figure.supxlabel("\n".join(notes), x=0.01, ha="left", fontsize=SIZE - 1, color=INK)
    return figure


def _draw(axes: Any, rotor: Rotor) -> None:
    from matplotlib.patches import Polygon, Rectangle

    long = rotor.sections[-1][1]
    thick = max(wide for _, _, wide, _ in rotor.sections)
    known = [wide for _, _, wide, _ in rotor.discs if math.isfinite(wide)]
    tall = max([2.5 * thick, *known])
    for left, right, wide, bore in rotor.sections:
        axes.add_patch(Rectangle((left, -wide / 2), right - left, wide, fc=GRID, ec=INK, lw=1.0, zorder=3))
        if bore > 0.0:
            axes.add_patch(Rectangle((left, -bore / 2), right - left, bore, fc="white", ec=INK, lw=0.6, zorder=4))
    each = 1.24 * long / (0.9 * WIDTH) * 0.6 * (SIZE - 1) / 72.0  # of a letter [m]
    over = _levels([(at, words) for words, at, _, _ in rotor.discs], each)
    for (words, at, wide, width), level in zip(rotor.discs, over, strict=True):
        high, thin = (wide, width) if math.isfinite(wide) else (0.9 * tall, 0.02 * long)
        style = "-" if math.isfinite(wide) else "--"
        axes.add_patch(
            Rectangle((at - thin / 2, -high / 2), thin, high, fc="white", ec=INK, ls=style, lw=1.2, zorder=5)
        )
        axes.annotate(
            words,
            (at, high / 2),
            xytext=(0, 3 + 20 * level),
            textcoords="offset points",
            ha="center",
            fontsize=SIZE - 1,
        )
    under = _levels(rotor.held, each)
    for (at, words), level in zip(rotor.held, under, strict=True):
        half = 0.5 * next(wide for left, right, wide, _ in rotor.sections if at <= right)
        base = half + 0.22 * tall
        corners = [(at, -half), (at - 0.014 * long, -base), (at + 0.014 * long, -base)]
        axes.add_patch(Polygon(corners, closed=True, fc="white", ec=INK, lw=1.0, zorder=4))
        axes.plot([at, at], [-base, -0.55 * tall - 0.5 * thick], color=FAINT, lw=0.7, zorder=1)
        axes.annotate(words, (at, -0.55 * tall - 0.5 * thick), xytext=(0, -2 - 11 * level), textcoords="offset points",
                      ha="center", va="top", fontsize=SIZE - 1)  # fmt: skip
    axes.plot([-0.03 * long, 1.03 * long], [0.0, 0.0], color=FAINT, lw=0.7, ls=(0, (8, 2, 1, 2)), zorder=6)
    axes.set_xlim(-0.12 * long, 1.12 * long)
    axes.set_ylim(-0.5 * thick - (0.8 + 0.1 * max(under, default=0)) * tall, (0.72 + 0.2 * max(over, default=0)) * tall)
    axes.set_axis_off()


def _levels(words: Sequence[tuple[float, str]], letter: float) -> list[int]:
    """Row of each word at its place, 0 nearest the shaft, so that none lies over another; `letter` wide [m]."""
    ends: list[float] = []
    found = dict[int, int]()
    for k in sorted(range(len(words)), key=lambda k: words[k][0]):
        at, said = words[k]
        half = 0.5 * letter * max(map(len, said.split("\n")))
        level = next((row for row, end in enumerate(ends) if end <= at - half), len(ends))
        ends[level : level + 1] = [at + half]
        found[k] = level
    return [found[k] for k in range(len(words))]
