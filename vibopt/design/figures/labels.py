"""Labels that find a free place beside their point."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.design.figures.paper import FAINT, INK, SIZE
from vibopt.forms import FloatArray

if TYPE_CHECKING:
    from matplotlib.text import Annotation

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


def _moved(one: Annotation, dx: float, dy: float, renderer: Any) -> Any:
    """Set the label off by (dx, dy) points; its box in pixels."""
    from matplotlib.text import Text

    text: Any = one
    text.set_position((dx, dy))
    text.set_ha("left" if dx > 0 else "right" if dx < 0 else "center")
    text.set_va("bottom" if dy > 0 else "top" if dy < 0 else "center")
    text.update_positions(renderer)
    return Text.get_window_extent(one, renderer).padded(4.0)


def _cost(box: Any, frame: Any, dots: FloatArray, points: FloatArray, taken: list[Any]) -> float:
    """How bad a place is: out of the frame, over a curve, over a point, over another label."""
    gaps = (frame.x0 - box.x0, box.x1 - frame.x1, frame.y0 - box.y0, box.y1 - frame.y1)
    out = sum(max(gap, 0.0) for gap in gaps)
    over = sum(box.overlaps(other) for other in taken)
    return float(10.0 * out + 1000.0 * over + 0.6 * _count_in(box, dots) + 300.0 * _count_in(box, points))


def _count_in(box: Any, dots: FloatArray) -> int:
    inside = (dots[:, 0] > box.x0) & (dots[:, 0] < box.x1) & (dots[:, 1] > box.y0) & (dots[:, 1] < box.y1)
    return int(inside.sum())
