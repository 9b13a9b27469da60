"""What figures draw, as series: a response against speed, quantities against one fact."""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite

import numpy as np

from vibopt.arrays import BoolArray, FloatArray
from vibopt.records import dataclass
from vibopt.units.spelling import split_detector


@dataclass(frozen=True, slots=True)
class Zone:
    """Where a limit forbids the response: beyond `bound`, for x from `low` to `high` (one speed if equal).

    `above` tells on which side.
    """

    name: str
    words: str
    low: float
    high: float
    bound: float
    above: bool


@dataclass(frozen=True, slots=True)
class Mark:
    """The worst of a limit or measure; y is inf where the response is infinite."""

    name: str
    words: str
    x: float
    y: float


@dataclass(frozen=True, slots=True)
class Curve:
    """y against x; `known` is false where the file does not say how the excitation varies.

    `before` marks the machine without its absorbers, `worst` the worst one within the tolerances.
    """

    label: str
    x: FloatArray
    y: FloatArray
    known: BoolArray
    before: bool = False
    worst: bool = False


def known_curve(label: str, x: FloatArray, y: FloatArray, *, before: bool = False, worst: bool = False) -> Curve:
    """A curve that is known all along."""
    return Curve(label, x, y, np.ones(len(x), dtype=bool), before, worst)


@dataclass(frozen=True, slots=True)
class Panel:
    """One pair of axes.

    own
        Own speeds of the excitation: (low, high) each.
    good
        Intervals that `find_all` found.
    equal
        Peaks as high as the greatest within 0.1 %, where there are several.
    to_scale
        Whether both axes have one scale: a path in a plane.
    """

    title: str
    x_label: str
    y_label: str
    curves: tuple[Curve, ...]
    x_span: tuple[float, float]
    y_span: tuple[float, float]
    zones: tuple[Zone, ...] = ()
    marks: tuple[Mark, ...] = ()
    own: tuple[tuple[float, float], ...] = ()
    excitation: str = ""
    log_x: bool = False
    log_y: bool = False
    good: tuple[tuple[float, float], ...] = ()
    notes: tuple[str, ...] = ()
    equal: tuple[Mark, ...] = ()
    to_scale: bool = False


def heights(
    curves: Iterable[Curve], zones: Iterable[Zone], marks: Iterable[Mark], unit: str
) -> tuple[tuple[float, float], bool]:
    """Span of the y axis, and whether it is logarithmic."""
    values = np.concatenate([curve.y[np.isfinite(curve.y)] for curve in curves])
    named = [zone.bound for zone in zones] + [mark.y for mark in marks if isfinite(mark.y)]
    if split_detector(unit)[0] == "dB":
        low, high = float(np.percentile(values, 1)), float(np.percentile(values, 99))
        low, high = min([low, *named]), max([high, *named])
        room = 0.12 * max(high - low, 1.0)
        return (low - room, high + room), False
    positive = values[values > 0.0]
    top = float(values.max(initial=0.0))
    middle = float(np.median(positive)) if len(positive) else 1.0
    peak = min(top, max(30.0 * middle, 4.0 * max(named, default=0.0)))
    high = max([peak, *named])
    floor = min(
        [float(np.percentile(positive, 5)) if len(positive) else high, *(value for value in named if value > 0.0)]
    )
    if high > 30.0 * floor and floor > 0.0:
        return (max(floor / 2.0, high * 1e-6), 2.5 * high), True
    return (0.0, 1.25 * high if high > 0.0 else 1.0), False


@dataclass(frozen=True, slots=True)
class Line:
    """One quantity at each x; nan where there is no answer."""

    name: str
    y: FloatArray


@dataclass(frozen=True, slots=True)
class Strip:
    """One pair of axes: lines of one unit, and a level below which is bad (None for none), with what that is called."""

    label: str
    lines: tuple[Line, ...]
    log: bool = False
    bad_below: float | None = None
    unit: str = ""
    bad_word: str = "limit broken"


@dataclass(frozen=True, slots=True)
class Strips:
    """Axes under each other over the same x.

    shaded
        (low, high, words) of the parts without a good answer, in units of x.
    marks
        (x, words) where something else changes.
    joined
        Whether there is anything between two values of x: not between whole numbers.
    """

    title: str
    x_label: str
    x: FloatArray
    log_x: bool
    strips: tuple[Strip, ...]
    shaded: tuple[tuple[float, float, str], ...]
    marks: tuple[tuple[float, str], ...] = ()
    joined: bool = True


@dataclass(frozen=True, slots=True)
class Side:
    """A place on an edge of the grid at which the answer changes.

    across
        Whether the edge runs along x.
    ends
        Whether designs begin or end here.
    words
        What holds on either side, in alphabetical order.
    value
        Of the map on the side with a design; nan where it is not known.
    """

    x: float
    y: float
    across: bool
    ends: bool
    words: tuple[str, str]
    value: float


@dataclass(frozen=True, slots=True)
class Map:
    """A quantity over a grid: x (n_x,), y (n_y,), values and good (n_y, n_x); nan where there is no answer."""

    title: str
    x_label: str
    y_label: str
    x: FloatArray
    y: FloatArray
    log: tuple[bool, bool]
    label: str
    values: FloatArray
    good: BoolArray
    sides: tuple[Side, ...]
    bad_words: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Front:
    """A trade-off: y against x, indices behind which nothing lies between, and (index, words) of what is marked.

    name
        Of one curve among several.
    """

    title: str
    x_label: str
    y_label: str
    x: FloatArray
    y: FloatArray
    jumps: tuple[int, ...]
    marks: tuple[tuple[int, str], ...]
    name: str = ""
