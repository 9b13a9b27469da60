"""Quantities against one fact: what the figure of a sweep draws."""

from __future__ import annotations

from vibopt.forms import FloatArray
from vibopt.records import dataclass


@dataclass(frozen=True, slots=True)
class Line:
    """One quantity at each x; nan where there is no answer."""

    name: str
    y: FloatArray


@dataclass(frozen=True, slots=True)
class Strip:
    """One pair of axes: lines of one unit, and a level below which is bad (None for none)."""

    label: str
    lines: tuple[Line, ...]
    log: bool = False
    bad_below: float | None = None


@dataclass(frozen=True, slots=True)
class Strips:
    """Axes under each other over the same x.

    shaded
        (low, high, words) of the parts without a good answer, in units of x.
    """

    title: str
    x_label: str
    x: FloatArray
    log_x: bool
    strips: tuple[Strip, ...]
    shaded: tuple[tuple[float, float, str], ...]
