"""How closely the page has to be set so that it is one: its height, estimated line by line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil
from typing import Any

SIZES = (9.4, 8.9, 8.4, 7.9, 7.4, 6.9, 6.4)
"""Size of the letters by density [pt]; the template sets the page in them."""
HEIGHTS, WHOLE, HALF = {"A4": 793.0, "letter": 743.0}, 520.0, 250.0
"""Text area of each paper within the margins of the template, and one of its two columns [pt]."""
ROOM = 0.98
"""Part of the height that an estimate may fill."""
LETTER = 0.47
"""Mean width of a letter, as a part of its size."""
SMALL, LINE, ROW, HEAD = 0.88, 1.28, 1.44, 2.15
"""Small print, a line, a row of a table, a heading; as parts of the size."""
FIGURE, TWO_FIGURES = 198.0, 285.0
"""Height of a figure with one and with two parts [pt]."""
WORDS = 0.88
"""Part of a narrow column that is filled where words are not divided."""


def density_of(said: Mapping[str, Any]) -> int:
    """The roomiest density at which everything that is said fits on one page; the closest where nothing does."""
    return next(
        (i for i, size in enumerate(SIZES) if height_of(said, size) <= ROOM * HEIGHTS[said["paper"]]), len(SIZES) - 1
    )


def height_of(said: Mapping[str, Any], size: float) -> float:
    """Estimated height of the page [pt] with letters of a size [pt]."""
    whole = _head(said, size) + _columns(said, size) + _limits(said, size)
    whole += max(_list(said["assumptions"], size), _list(said["proof"], size)) + HEAD * size
    sign = 2.0 * (23.0 + 1.1 * size) if said["verdict"].signable else 4.0 * size
    return whole + sign + 2.0 * size


def _lines(words: str, width: float, size: float) -> int:
    return max(1, ceil(len(words) * LETTER * size / max(width, 5.0 * size)))


def _head(said: Mapping[str, Any], size: float) -> float:
    small = SMALL * size
    digests = f"{said['file']} {said['date']} {' '.join(' '.join(one) for one in said['digests'])} SHA-256"
    lines = _lines(digests, WHOLE, small)
    if said["changes"]:
        lines += _lines(" ".join(said["changes"]), WHOLE, small) + 1
    verdict = sum(_lines(line, 0.96 * WHOLE, size) for line in said["verdict"].lines) + 4.0
    return 1.2 * 1.65 * size * _lines(said["title"], WHOLE, 1.65 * size) + LINE * (small * lines + size * verdict)


def _columns(said: Mapping[str, Any], size: float) -> float:
    """Facts and mounts on the left, the figure and the modes on the right."""
    tables = [said[key] for key in ("bodies", "build", "excitations") if said[key]]
    left = sum(HEAD * size + sum(_fact(one, size) for one in table) for table in tables)
    if said["mounts"]:
        left += (HEAD + ROW * (len(said["mounts"]) + 2)) * size
    figure = (TWO_FIGURES if said["two_figures"] else FIGURE) + HEAD * size if said["figure"] else 0.0
    width = HALF - 13.0 * size
    modes = sum(LINE * _lines(one["words"], width, size) + 0.2 for one in said["modes"])
    return float(max(left, figure + (modes + HEAD + 2 * ROW) * size))


def _fact(row: Sequence[str], size: float) -> float:
    lines = max(_lines(row[0], 0.22 * HALF, 1.1 * size), _lines(row[1], 0.74 * HALF, size))
    return (LINE * lines + 0.2) * size


def _limits(said: Mapping[str, Any], size: float) -> float:
    """Limits, whose numbers are never broken: names and places share what is left of the width."""
    rows, limits = 0.0, said["limits"]
    names = [f"{limit.name} {limit.what}" for limit in limits]
    whole = [
        max((len(getattr(limit, key)) for limit in limits), default=0)
        for key in ("allowed", "value", "margin", "state")
    ]
    left = WHOLE - (LETTER * sum(whole) + 0.6 * 6) * size
    wide, far = max(map(len, names), default=0), max((len(limit.at) for limit in limits), default=0)
    share = wide / max(wide + max(far, 5), 1)
    if (wide + max(far, 5)) * LETTER * size > left:
        left *= WORDS
    for name, limit in zip(names, limits, strict=True):
        lines = max(_lines(name, share * left, size), _lines(limit.at, (1.0 - share) * left, size))
        rows += LINE * lines + 0.2
    if rows:
        rows += HEAD + 2 * ROW
    if said["measures"]:
        rows += HEAD + sum(
            LINE * max(_lines(f"{one[0]} {one[1]}", 0.55 * WHOLE, size), _lines(one[2], 0.4 * WHOLE, size)) + 0.2
            for one in said["measures"]
        )
    return rows * size


def _list(lines: Sequence[str], size: float) -> float:
    small = SMALL * size
    return sum(LINE * _lines(line, HALF - size, small) + 0.1 for line in lines) * small
