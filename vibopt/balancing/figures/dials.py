"""Dials: a disc with its zero mark and sense of angles, weights in their places, and phasors.

Words stand beside the circle, each tied to its place by a thin line: inside are only holes, spokes and marks.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, pi, sin, tau
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.records import dataclass
from vibopt.report.figures.canvas import Box, Canvas, spread
from vibopt.report.figures.paper import BLUE, FAINT, FORBIDDEN, FORBIDDEN_INK, GRID, INK, RED, SIZE
from vibopt.units import plain

SEAT, NUMBERS = 0.70, 0.885
"""Radius of the places for weights, and of the numbers of holes; the disc as drawn has radius 1."""
RING = 0.34
"""Inches around the circle for angles."""
LEAST, MOST = 0.46, 1.05
"""Radius of a circle [inches]."""
TITLE, TURNING = 0.24, 0.2
"""Inches for the title, and for each of the arrows that say which way angles and the rotor turn."""
SMALL = SIZE - 2.0
_LOOKS: dict[str, dict[str, Any]] = {
    "fit": {"marker": "o", "ms": 9, "mfc": BLUE, "mec": INK},
    "away": {"marker": "X", "ms": 9, "mfc": "white", "mec": RED, "mew": 1.6},
    "there": {"marker": "s", "ms": 6, "mfc": "white", "mec": INK},
    "pin": {"marker": "o", "ms": 9, "mfc": "white", "mec": INK, "mew": 1.4},
    "counter": {"marker": "D", "ms": 7, "mfc": FAINT, "mec": INK},
}
_SPOKES = {"fit": (BLUE, "-"), "away": (RED, "-"), "pin": (INK, "-"), "counter": (FAINT, (0, (3, 1.5)))}


@dataclass(frozen=True, slots=True)
class Spot:
    """A weight on a disc.

    angle
        As written [rad]; `words` stand beside it; `place` is its radius over the greatest one.
    look
        "fit", "away" (material is taken away), "there" (a known mass), "pin" (of a crank) or "counter" (weight).
    """

    angle: float
    words: str
    look: str = "fit"
    place: float = 1.0


@dataclass(frozen=True, slots=True)
class Phasor:
    """A reading before and after on a dial: angle as written [rad], size in the unit of the dial."""

    name: str
    before: tuple[float, float]
    after: tuple[float, float]
    limit: float | None = None
    band: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class Disc:
    """One correction plane as drawn; `sense` is +1 where its angles are counted with rotation (counter-clockwise)."""

    title: str
    sense: int
    spots: tuple[Spot, ...] = ()
    holes: tuple[float, ...] = ()
    forbidden: tuple[tuple[float, float], ...] = ()
    note: str = ""
    turns: bool = True

    @property
    def words(self) -> list[str]:
        return [spot.words for spot in self.spots]

    @property
    def room(self) -> tuple[float, float]:
        """Inches above and below the circle."""
        return RING + TURNING + TITLE, RING + TURNING * self.turns

    def draw(self, cell: Cell) -> None:
        """Holes, forbidden sectors, weights, zero mark and sense of angles."""
        for low, high in self.forbidden:
            cell.sector(low, high)
        cell.cross(middle=not self.note)
        _holes(cell, self.holes)
        cell.senses(self.turns)
        for spot in self.spots:
            _spot(cell, spot)
        cell.beside([(spot.words, spot.angle, SEAT * spot.place, spot.look != "there") for spot in self.spots])
        if self.note:
            look = {"boxstyle": "round,pad=0.3", "fc": "white", "ec": GRID}
            cell.axes.text(0.0, 0.0, self.note, ha="center", va="center", fontsize=SIZE, color=INK, bbox=look)


@dataclass(frozen=True, slots=True)
class Dial:
    """The readings of one sensor at all its speeds."""

    title: str
    sense: int
    phasors: tuple[Phasor, ...]

    @property
    def words(self) -> list[str]:
        return [phasor.name for phasor in self.phasors] if len(self.phasors) > 1 else []

    @property
    def room(self) -> tuple[float, float]:
        """Inches above and below the circle."""
        return RING + TITLE, RING

    def draw(self, cell: Cell) -> None:
        """Readings before and after, with limit circles and 95 % rings."""
        sizes = [phasor.before[0] for phasor in self.phasors] + [phasor.after[0] for phasor in self.phasors]
        # a limit far outside would hide the readings
        limits = [
            phasor.limit for phasor in self.phasors if phasor.limit is not None and phasor.limit < 3.0 * max(sizes)
        ]
        top = 1.12 * max([*sizes, *limits]) or 1.0
        cell.cross(middle=False)
        cell.rings(top, [angle for phasor in self.phasors for angle in (phasor.before[1], phasor.after[1])])
        for phasor in self.phasors:
            _phasor(cell, phasor, top)
        tips = [(phasor.name, phasor.before[1], phasor.before[0] / top, False) for phasor in self.phasors]
        cell.beside(tips if len(tips) > 1 else [])


class Cell:
    """A circle in the middle of a part of the paper, in inches from its centre, with room for words on both sides."""

    def __init__(self, axes: Any, shown: Shown, radius: float) -> None:
        self.axes, self.sense, self.radius = axes, shown.sense, radius
        axes.add_patch(_circle(radius, ec=FAINT, lw=0.9, fc="none", zorder=2))
        y = radius + shown.room[0] - 0.5 * TITLE
        axes.text(0.0, y, shown.title, ha="center", va="center", fontsize=SIZE + 0.5, fontweight="bold", color=INK)
        for k in range(8):
            x, y = self.at(k * pi / 4, 1.0 + 0.16 / radius)
            axes.text(x, y, f"{45 * k}°", fontsize=SMALL, color=INK, ha="center", va="center", bbox=_WHITE)

    def at(self, angle: float, part: float) -> tuple[float, float]:
        """Place [inches] of a written angle [rad], at a part of the radius."""
        turn = self.sense * angle + 0.5 * pi
        return self.radius * part * cos(turn), self.radius * part * sin(turn)

    def cross(self, *, middle: bool = True) -> None:
        """Diameters every 45 degrees, and a small cross in the middle."""
        for k in range(4):
            (x, y), (u, v) = self.at(k * pi / 4, 1.0), self.at(k * pi / 4 + pi, 1.0)
            self.axes.plot([x, u], [y, v], color=GRID, lw=0.6, zorder=1)
        if middle:
            self.axes.plot([0.0], [0.0], marker="+", ms=6, color=FAINT, zorder=3)

    def sector(self, low: float, high: float) -> None:
        """A sector where no weight may go."""
        around = [self.at(one, 1.0) for one in np.linspace(low, high if high >= low else high + tau, 90)]
        look = {"fc": FORBIDDEN, "ec": FORBIDDEN_INK, "hatch": "////", "lw": 0.6, "zorder": 1}
        self.axes.fill(*zip((0.0, 0.0), *around, strict=True), **look)

    def senses(self, turns: bool) -> None:
        """The zero mark, and curved arrows: the sense of the angles beside zero, the rotation on the other side."""
        r, out = self.radius, self.radius + 0.34
        self.axes.plot([0.0], [r - 0.035], marker="v", ms=7, color=INK, zorder=8)
        _arc(self.axes, out, self.sense * 9.0, self.sense * 24.0, INK)
        x = -self.sense * (out * 0.41 + 0.04)
        self.axes.text(x, 0.91 * out + 0.02, "angles", fontsize=SMALL, color=INK, va="center",
                       ha="right" if self.sense > 0 else "left")  # fmt: skip
        if turns:
            _arc(self.axes, r + 0.29, 160.0, 200.0, FAINT)
            self.axes.text(0.0, -r - 0.43, "rotation", fontsize=SMALL, color=INK, ha="center", va="center")

    def rings(self, top: float, angles: Sequence[float]) -> None:
        """Three round sizes, labelled where no reading is."""
        from matplotlib.ticker import MaxNLocator

        sizes = [float(value) for value in MaxNLocator(3).tick_values(0.0, top) if 0.0 < value < 0.97 * top]
        free = np.arange(16) * pi / 8 + pi / 16
        gaps = [min(min(abs(a - b) % tau, -abs(a - b) % tau) for b in angles) for a in free]
        angle = float(free[int(np.argmax(gaps))])
        for size in sizes:
            self.axes.add_patch(_circle(self.radius * size / top, ec=GRID, lw=0.7, fc="none", zorder=1))
            x, y = self.at(angle, size / top)
            self.axes.text(x, y, plain(size, 3), fontsize=SMALL - 0.5, color=FAINT, ha="center", va="center", zorder=2)

    def beside(self, words: Sequence[tuple[str, float, float, bool]]) -> None:
        """Words left and right of the circle, each tied to its place: (words, angle, part of the radius, bold)."""
        places = [self.at(angle, part) for _, angle, part, _ in words]
        for side, rows in enumerate(_sides(places, [_tall(said) for said, *_ in words])):
            tall = [_tall(words[k][0]) for k in rows]
            heights = spread([places[k][1] for k in rows], tall)
            for k, y in zip(rows, heights, strict=True):
                self._tied(words[k][0], places[k], (1.0 if side else -1.0) * (self.radius + RING), y, words[k][3])

    def _tied(self, said: str, end: tuple[float, float], x: float, y: float, bold: bool) -> None:
        near = x - 0.03 if x > 0.0 else x + 0.03
        self.axes.plot([near, end[0]], [y, end[1]], color=FAINT, lw=0.6, zorder=2.5)
        self.axes.text(x, y, said, ha="left" if x > 0.0 else "right", va="center", color=INK, linespacing=1.1,
                       fontsize=SIZE - 1.0 if bold else SMALL, fontweight="bold" if bold else "normal")  # fmt: skip


def _circle(radius: float, **look: Any) -> Any:
    from matplotlib.patches import Circle

    return Circle((0.0, 0.0), radius, **look)


def _tall(words: str) -> float:
    """Inches that words take in a column."""
    return (1.25 * len(words.split("\n")) + 0.35) * (SIZE - 1.0) / 72.0


def _sides(places: Sequence[tuple[float, float]], tall: Sequence[float]) -> tuple[list[int], list[int]]:
    """Which words stand left and which right, from the top down: near their places, and about as many on each."""
    order = sorted(range(len(places)), key=lambda k: places[k][0])
    left = [k for k in order if places[k][0] < -1e-9]
    right = [k for k in order if places[k][0] >= -1e-9]
    while sum(tall[k] for k in left) - sum(tall[k] for k in right) > 2.0 * max(tall, default=0.0):
        right.insert(0, left.pop())
    while sum(tall[k] for k in right) - sum(tall[k] for k in left) > 2.0 * max(tall, default=0.0):
        left.append(right.pop(0))
    return sorted(left, key=lambda k: -places[k][1]), sorted(right, key=lambda k: -places[k][1])


def _holes(cell: Cell, holes: Sequence[float]) -> None:
    """Small circles with their numbers, every so many where they are close."""
    size, apart = SMALL - 1.0, cell.radius * NUMBERS * tau / max(len(holes), 1)
    wide = 0.62 * size * len(str(len(holes))) / 72.0 + 0.03
    step = next((one for one in (1, 2, 3, 4, 5, 6, 8, 9, 10, 12) if one * apart >= wide), 15)
    if holes:
        x, y = zip(*(cell.at(angle, SEAT) for angle in holes), strict=True)
        cell.axes.plot(x, y, marker="o", ms=3.5, mfc="white", mec=FAINT, mew=0.8, zorder=3, ls="", gid="hole")
    for index, angle in list(enumerate(holes))[::step]:
        place = cell.at(angle, NUMBERS)
        cell.axes.text(*place, str(index + 1), fontsize=size, color=FAINT, ha="center", va="center")


def _spot(cell: Cell, spot: Spot) -> None:
    x, y = cell.at(spot.angle, SEAT * spot.place)
    if spot.look in _SPOKES:
        colour, style = _SPOKES[spot.look]
        cell.axes.plot([0.0, x], [0.0, y], color=colour, ls=style, lw=1.4, zorder=4, gid="spoke")
    look = _LOOKS[spot.look]
    small = min(1.0, (cell.radius + 0.15) / 1.0)
    cell.axes.plot([x], [y], zorder=7, ls="", **look | {"ms": small * look["ms"]})


def _phasor(cell: Cell, phasor: Phasor, top: float) -> None:
    around = np.linspace(0.0, tau, 181)

    def ring(size: float) -> tuple[FloatArray, FloatArray]:
        return cell.radius * size / top * np.cos(around), cell.radius * size / top * np.sin(around)

    if phasor.limit is not None and phasor.limit <= top:
        cell.axes.plot(*ring(phasor.limit), color=RED, lw=1.5, ls=(0, (6, 2)), zorder=3)
    if phasor.band is not None and phasor.band[1] <= top:
        inner, outer = ring(phasor.band[0]), ring(phasor.band[1])
        both = [np.concatenate([a, b[::-1]]) for a, b in zip(outer, inner, strict=True)]
        cell.axes.fill(*both, color="#9db7d8", alpha=0.35, lw=0, zorder=2)
        cell.axes.plot(*outer, color=BLUE, lw=0.7, ls=":", zorder=2)
    start, end = (cell.at(angle, size / top) for size, angle in (phasor.before, phasor.after))
    for (x, y), colour, style, look in (
        (start, FAINT, (0, (3, 1.5)), {"marker": "o", "ms": 5, "mfc": "white", "mec": INK}),
        (end, BLUE, "-", {"marker": "D", "ms": 4.5, "mfc": BLUE, "mec": INK}),
    ):
        cell.axes.plot([0.0, x], [0.0, y], color=colour, lw=1.6, ls=style, zorder=5, gid="spoke")
        cell.axes.plot([x], [y], zorder=6, mew=0.9, ls="", **look)
    arrow = {"arrowstyle": "->", "color": FAINT, "lw": 0.7, "shrinkA": 4, "shrinkB": 4}
    cell.axes.annotate("", end, xytext=start, zorder=4, arrowprops=arrow)


def _arc(axes: Any, radius: float, start: float, end: float, colour: str) -> None:
    """An arrow on a circle; angles in degrees counter-clockwise from the top as drawn."""
    turn = np.radians(np.linspace(start, end, 24)) + 0.5 * pi
    x, y = radius * np.cos(turn), radius * np.sin(turn)
    axes.plot(x[:-2], y[:-2], color=colour, lw=1.3)
    arrow = {"arrowstyle": "-|>", "color": colour, "lw": 1.3, "mutation_scale": 9, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (x[-1], y[-1]), xytext=(x[-4], y[-4]), arrowprops=arrow)


Shown = Disc | Dial
_WHITE = {"fc": "white", "ec": "none", "pad": 0.5}


@dataclass(frozen=True)
class Row:
    """Circles side by side, `columns` of them over the width, in the middle where they are fewer."""

    shown: Sequence[Shown]
    columns: int
    radius: float

    @property
    def height(self) -> float:
        """Inches for the circles, or for the words beside them."""
        return self._up + self._down

    @property
    def _up(self) -> float:
        """Inches above the middles of the circles."""
        return max(max(self.radius + one.room[0], _reach(one) + TITLE) for one in self.shown)

    @property
    def _down(self) -> float:
        return max(max(self.radius + one.room[1], _reach(one)) for one in self.shown)

    def draw(self, canvas: Canvas) -> None:
        self.within(canvas, 0.0, canvas.width)

    def within(self, canvas: Canvas, left: float, width: float) -> None:
        """Drawn into a part of the width."""
        wide, tall = width / self.columns, self.height
        left += 0.5 * (width - wide * len(self.shown))
        for k, one in enumerate(self.shown):
            axes = canvas.part(Box(left + k * wide, tall, wide), origin=(0.5 * wide, self._down))
            one.draw(Cell(axes, one, self.radius))


def _reach(one: Shown) -> float:
    """Inches that the words beside a circle may need above and below its middle."""
    tall = [_tall(words) for words in one.words]
    return 0.5 * sum(tall) + 0.6 * max(tall, default=0.0)


def rows_of(shown: Sequence[Shown], columns: int, width: float, most: float = MOST) -> list[Row]:
    """All of them in rows; their circles are as large as `most` and the words beside them allow."""
    lines = [len(line) for one in shown for words in one.words for line in words.split("\n")]
    column = 0.67 * max(lines, default=2) * (SIZE - 1.0) / 72.0 + 0.06
    while columns > 1 and 0.5 * width / columns < LEAST + RING + column:
        columns -= 1
    radius = max(min(0.5 * width / columns - RING - column, most), LEAST)
    return [Row(shown[k : k + columns], columns, radius) for k in range(0, len(shown), columns)]
