"""The plan view: x to the right, y up, to scale; mounts with names and loads, centre of mass."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import TYPE_CHECKING, Any

from vibopt.mechanics.rigid import SpaceMachine
from vibopt.report.figures.paper import FAINT, GRID, INK, drawn, sheet
from vibopt.report.mount_spots import Spot, markers_of, spots_of
from vibopt.units import show

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def said(value: object) -> str:
    """A value of the file in its own words; of a list of plain ones in brackets, of a single one without."""
    if isinstance(value, Mapping):
        return " ".join(f"{key} {said(one)}" for key, one in value.items())
    if isinstance(value, (list, tuple)):
        flat = len(value) > 1 and all(not isinstance(one, (Mapping, list, tuple)) for one in value)
        listed = ", ".join(said(one) for one in value)
        return f"({listed})" if flat else listed
    return str(value)


WIDTH, HEIGHT = 3.7, 2.85
"""Inches, of one plan."""
MOST_PLANS = 2
LONGEST = 14
SMALL = 6.5


def plan_figure(machine: SpaceMachine, unit: str, points: Sequence[str] = ()) -> Figure | None:
    """Plan views of the bodies that stand on mounts, one above the other; None where there are no mounts.

    Parameters
    ----------
    machine
        As built.
    unit
        Unit of the loads.
    points
        Names of places to mark.
    """
    spots = spots_of(machine)
    carried = list(dict.fromkeys(spot.carried for spot in spots))[:MOST_PLANS]
    if not carried:
        return None
    figure = sheet(WIDTH, HEIGHT if len(carried) == 1 else 1.45 * HEIGHT)
    for i, name in enumerate(carried):
        axes = figure.add_subplot(len(carried), 1, i + 1)
        _plan(axes, machine, [spot for spot in spots if spot.carried == name], unit)
        _points(axes, machine, name, points)
        _dress(axes)
        if len(carried) > 1:
            axes.set_title(drawn(name, 24), fontsize=SMALL + 1.0, loc="left", color=INK)
    return figure


def _plan(axes: Any, machine: SpaceMachine, spots: Sequence[Spot], unit: str) -> None:
    """Mounts of one body, each with its name and its load, within the rectangle that they span."""
    xs, ys = [spot.at[0] for spot in spots], [spot.at[1] for spot in spots]
    left, right, low, high = min(xs), max(xs), min(ys), max(ys)
    axes.plot([left, right, right, left, left], [low, low, high, high, low], color=GRID, lw=0.8)
    for group, (shape, fill) in markers_of(machine).items():
        mine = [spot.at for spot in spots if spot.group == group]
        x, y = [at[0] for at in mine], [at[1] for at in mine]
        axes.plot(x, y, marker=shape, mfc=fill, mec=INK, ms=6.5, ls="", gid=f"group-{group}")
    for place, words in _labels(spots, unit).items():
        _text(axes, words, place, 6.0 if place[1] >= (low + high) / 2.0 else -6.0, INK)


def _points(axes: Any, machine: SpaceMachine, name: str, points: Sequence[str]) -> None:
    """Centre of mass of a body, the places on it that the file names, and the absorbers on it as squares."""
    for slider, one in machine.guided.items():
        if one.host == name:
            axes.plot([one.at[0]], [one.at[1]], marker="s", mfc="white", mec=INK, ms=6, ls="")
            _text(axes, drawn(slider, LONGEST), (one.at[0], one.at[1]), 6, INK)
    for point in points:
        body, at = machine.fixed[point]
        if body == name:
            axes.plot([at[0]], [at[1]], marker="x", color=FAINT, ms=5, ls="")
            _text(axes, drawn(point, LONGEST), (at[0], at[1]), -4, FAINT)
    if name in machine.rigid:
        centre = machine.rigid[name].centre
        axes.plot([centre[0]], [centre[1]], marker="o", mfc="white", mec=INK, ms=9, ls="")
        axes.plot([centre[0]], [centre[1]], marker="+", color=INK, ms=12, mew=1.0, ls="")
        _text(axes, "centre of mass", (centre[0], centre[1]), 7, INK)


def _labels(spots: Sequence[Spot], unit: str) -> dict[tuple[float, float], str]:
    """Names and loads at each place; of mounts above each other all."""
    found: dict[tuple[float, float], str] = {}
    for spot in spots:
        load = show(spot.load, unit, "force") if isfinite(spot.load) else "not held"
        words = f"{drawn(spot.name, LONGEST)}\n{load}"
        place = spot.at[0], spot.at[1]
        found[place] = f"{found[place]}\n{words}" if place in found else words
    return found


def _text(axes: Any, words: str, at: tuple[float, float], away: float, colour: str) -> None:
    """Words above a place, or below it where `away` [points] is negative."""
    axes.annotate(
        words,
        at,
        xytext=(0, away),
        textcoords="offset points",
        ha="center",
        va="bottom" if away > 0 else "top",
        fontsize=SMALL,
        color=colour,
        linespacing=1.05,
    )


def _dress(axes: Any) -> None:
    box = axes.dataLim
    pad = 0.22 * max(box.width, box.height, 1e-3)
    axes.update_datalim([(box.x0 - pad, box.y0 - pad), (box.x1 + pad, box.y1 + pad)])
    axes.margins(0.0)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x [m]", fontsize=SMALL, color=INK, labelpad=1)
    axes.set_ylabel("y [m]", fontsize=SMALL, color=INK, labelpad=1)
    axes.tick_params(labelsize=SMALL - 0.5, colors=FAINT, length=2, pad=1.5)
    axes.grid(True, color=GRID, lw=0.3)
    axes.set_axisbelow(True)
    for spine in axes.spines.values():
        spine.set_color(GRID)
