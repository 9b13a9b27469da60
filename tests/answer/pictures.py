"""What a figure shows, as boxes on its paper: for laws about words that cover each other."""

from collections.abc import Iterator
from typing import Any

import numpy as np

ROOM = 0.5
"""Pixels by which boxes may touch."""


def drawn_texts(figure: Any) -> list[tuple[str, Any]]:
    """All words that are drawn, with their boxes in pixels."""
    from matplotlib.text import Text

    figure.draw_without_rendering()
    renderer = figure.canvas.get_renderer()
    return [
        (one.get_text(), Text.get_window_extent(one, renderer))
        for one in _texts(figure)
        if one.get_text().strip() and one.get_visible()
    ]


def _texts(part: Any) -> Iterator[Any]:
    yield from part.texts
    if part._suptitle is not None and part._suptitle not in part.texts:
        yield part._suptitle
    for legend in part.legends:
        yield from legend.get_texts()
        yield legend.get_title()
    for sub in part.subfigs:
        yield from _texts(sub)
    for axes in part._localaxes:
        yield from axes.texts
        if not axes.axison:
            continue
        yield from (axes.title, axes._left_title, axes._right_title)
        for axis in (axes.xaxis, axes.yaxis):
            yield axis.label
            yield from (tick.label1 for tick in axis._update_ticks() if tick.label1.get_visible())


def covered(figure: Any) -> list[tuple[str, str]]:
    """Pairs of words that cover each other, and words that leave the paper."""
    found = drawn_texts(figure)
    pairs = []
    for k, (words, box) in enumerate(found):
        paper = figure.bbox
        if min(box.x0, box.y0, paper.width - box.x1, paper.height - box.y1) < -1.0:
            pairs.append((words, "the edge of the paper"))
        pairs += [(words, other) for other, beside in found[:k] if _overlap(box, beside)]
    return pairs


def _overlap(box: Any, other: Any) -> bool:
    wide = min(box.x1, other.x1) - max(box.x0, other.x0)
    tall = min(box.y1, other.y1) - max(box.y0, other.y0)
    return bool(wide > ROOM and tall > ROOM)


def struck(figure: Any, gid: str) -> list[str]:
    """Words on a hole or a spoke: lines drawn with that name, of which a point lies in a box of words."""
    found = []
    for axes in figure.axes:
        texts = [(one.get_text(), one.get_window_extent()) for one in axes.texts if one.get_text().strip()]
        for line in axes.lines:
            if line.get_gid() == gid:
                x, y = line.get_data()
                if line.get_linestyle() != "None":  # a spoke: all along it
                    ends = np.linspace(0.0, 1.0, 50)
                    x, y = (np.interp(ends, [0.0, 1.0], [one[0], one[-1]]) for one in (x, y))
                points = axes.transData.transform(np.column_stack([x, y]))
                found += [words for words, box in texts if any(box.contains(*point) for point in points)]
    return found
