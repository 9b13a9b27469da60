"""A schematic of what stands on what, for machines without places: bodies as boxes, links as springs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.mechanics.machine import GROUND
from vibopt.report.figures.paper import FAINT, INK, sheet
from vibopt.report.sheet.mount_plan import drawn
from vibopt.scene.places import carried, ends, supports
from vibopt.scene.scene import Scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 3.7, 2.9
MOST = 8
"""More boxes than this are no picture any more."""
SMALL, LONGEST = 7.0, 16
SIDE = 0.34
"""Distance of links between the same two boxes; boxes are one apart."""


def schematic_figure(scene: Scene) -> Figure | None:
    """Bodies above what carries them, links as springs between; None where there are none, or too many."""
    joints = ends(scene)
    still = {GROUND, *supports(scene)}
    below = still | carried(scene)
    boxes = list(dict.fromkeys(end for two in joints.values() for end in two))
    if not joints or len(boxes) > MOST:
        return None
    level = _levels(joints, below)
    at = _places(boxes, level)
    figure = sheet(WIDTH, HEIGHT)
    axes = figure.add_subplot()
    for name, two in joints.items():
        beside = [one for one in joints if set(joints[one]) == set(two)]
        shift = SIDE * (beside.index(name) - (len(beside) - 1) / 2.0)
        _spring(axes, at[two[0]], at[two[1]], name, shift)
    for name in boxes:
        _box(axes, name, at[name], name in still)
    axes.set_axis_off()
    width = max(x for x, _ in at.values())
    axes.set_xlim(-0.75, width + 0.75)
    axes.set_ylim(-0.5, max(y for _, y in at.values()) + 0.5)
    return figure


def _levels(joints: dict[str, tuple[str, str]], below: set[str]) -> dict[str, int]:
    """How many links each end is above supports and structures; what hangs on none is counted from one end."""
    level = {end: 0 for two in joints.values() for end in two if end in below}
    left = list(joints.values())
    if not level:
        level[left[0][1]] = 0
    while left:
        near = next((two for two in left if two[0] in level or two[1] in level), left[0])
        left.remove(near)
        a, b = near if near[0] in level else near[::-1]
        level.setdefault(a, 0)
        level.setdefault(b, level[a] + 1)
    return level


def _places(boxes: list[str], level: dict[str, int]) -> dict[str, tuple[float, float]]:
    """Boxes of a level side by side, in the middle of the widest."""
    rows: dict[int, list[str]] = {}
    for name in boxes:
        rows.setdefault(level[name], []).append(name)
    widest = max(map(len, rows.values()))
    return {
        name: (i + (widest - len(row)) / 2.0, float(height))
        for height, row in rows.items()
        for i, name in enumerate(row)
    }


def _spring(axes: Any, start: tuple[float, float], stop: tuple[float, float], name: str, shift: float) -> None:
    """A zigzag from one place to the other, beside those that do the same."""
    a, b = np.array(start), np.array(stop)
    along = b - a
    across = np.array([-along[1], along[0]]) / (np.hypot(*along) or 1.0)
    a = a + shift * across
    steps = np.array([0.0, 0.3, *np.linspace(0.34, 0.66, 8), 0.7, 1.0])
    swings = np.array([0.0, 0.0, *([0.05, -0.05] * 4), 0.0, 0.0])
    line = a + steps[:, None] * along + swings[:, None] * across
    axes.plot(line[:, 0], line[:, 1], color=INK, lw=0.9, zorder=1)
    middle = a + 0.5 * along
    axes.annotate(
        drawn(name, LONGEST),
        middle,
        xytext=(9, 0),
        textcoords="offset points",
        fontsize=SMALL,
        color=FAINT,
        ha="left",
        va="center",
    )


def _box(axes: Any, name: str, at: tuple[float, float], still: bool) -> None:
    style = {"boxstyle": "square,pad=0.5", "fc": "#e8e8e8" if still else "white", "ec": INK, "lw": 0.9}
    axes.text(*at, drawn(name, LONGEST), ha="center", va="center", fontsize=SMALL, color=INK, bbox=style, zorder=2)


__all__ = ["schematic_figure"]
