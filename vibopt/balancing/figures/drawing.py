"""Dials: a disc with its zero mark and sense of angles, weights in their places, and phasors."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, degrees, pi, sin, tau
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.records import dataclass
from vibopt.report.figures.paper import BLUE, FAINT, FORBIDDEN, FORBIDDEN_INK, GRID, INK, RED, SIZE, dress
from vibopt.units import plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RIM, SEAT = 1.0, 0.72
"""Radius of the disc as drawn, and of the places for weights."""

SMALL = SIZE - 2.0


@dataclass(frozen=True, slots=True)
class Spot:
    """A weight on a disc.

    angle
        As written [rad]; `words` stand beside it; `place` is its radius over the greatest one.
    look
        "fit", "away" (material is taken away) or "there" (a known mass).
    """

    angle: float
    words: str
    look: str = "fit"
    place: float = 1.0


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


@dataclass(frozen=True, slots=True)
class Phasor:
    """A reading before and after on a dial: angle as written [rad], size in the unit of the dial."""

    name: str
    before: tuple[float, float]
    after: tuple[float, float]
    limit: float | None = None
    band: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class Dial:
    """The readings of one sensor at all its speeds."""

    title: str
    unit: str
    sense: int
    phasors: tuple[Phasor, ...]


def polar(figure: Figure, place: Any, title: str, sense: int) -> Any:
    """Polar axes with zero on top and angles growing in their sense."""
    axes: Any = figure.add_subplot(place, projection="polar")
    axes.set_theta_zero_location("N")
    axes.set_theta_direction(sense)
    axes.set_title(title, fontsize=SIZE + 0.5, color=INK, fontweight="bold", pad=12)
    axes.set_xticks(np.arange(8) * pi / 4, [f"{45 * k}°" for k in range(8)], fontsize=SMALL, color=INK)
    axes.tick_params(pad=-1)
    axes.grid(True, color=GRID, lw=0.6)
    axes.set_axisbelow(True)
    axes.spines["polar"].set_color(FAINT)
    return axes


def draw_disc(figure: Figure, place: Any, disc: Disc, inches: float) -> None:
    """A plane with its holes, forbidden sectors, weights, zero mark and sense of angles; its cell is `inches` wide."""
    axes = polar(figure, place, disc.title, disc.sense)
    axes.set_ylim(0.0, RIM)
    axes.set_yticks([])
    for low, high in disc.forbidden:
        axes.bar(
            0.5 * (low + high), RIM, width=high - low, color=FORBIDDEN, edgecolor=FORBIDDEN_INK, hatch="////", lw=0.6
        )
    _holes(axes, disc.holes)
    axes.plot([0.0], [RIM], marker="v", ms=9, color=INK, clip_on=False, zorder=8)
    axes.plot(0.0, 0.0, marker="+", ms=6, color=FAINT)
    _senses(axes, disc)
    for spot in disc.spots:
        _spot(axes, spot)
    _labels(axes, disc, 0.66 * inches)
    if disc.note:
        axes.text(0.5, 0.5, disc.note, transform=axes.transAxes, ha="center", va="center", fontsize=SIZE, color=INK,
                  bbox={"boxstyle": "round,pad=0.3", "fc": "white", "ec": GRID})  # fmt: skip


def _holes(axes: Any, holes: Sequence[float]) -> None:
    """Small circles with their numbers, every other one where they are many."""
    step = 1 if len(holes) <= 16 else 2 if len(holes) <= 36 else 6
    for index, angle in enumerate(holes):
        axes.plot([angle], [SEAT], marker="o", ms=4, mfc="white", mec=FAINT, mew=0.8, zorder=3)
        if index % step == 0:
            axes.text(angle, SEAT + 0.14, str(index + 1), fontsize=SMALL - 1, color=FAINT, ha="center", va="center")


def _spot(axes: Any, spot: Spot) -> None:
    looks: dict[str, dict[str, Any]] = {
        "fit": {"marker": "o", "ms": 11, "mfc": BLUE, "mec": INK},
        "away": {"marker": "X", "ms": 11, "mfc": "white", "mec": RED, "mew": 1.6},
        "there": {"marker": "s", "ms": 7, "mfc": "white", "mec": INK},
    }
    radius = SEAT * spot.place
    if spot.look != "there":
        axes.plot([spot.angle, spot.angle], [0.0, radius], color=BLUE if spot.look == "fit" else RED, lw=1.4, zorder=4)
    axes.plot([spot.angle], [radius], zorder=7, **looks[spot.look])


def _labels(axes: Any, disc: Disc, across: float) -> None:
    """The words of each weight, at the nearest place of the disc where they cover nothing; `across` in inches."""
    points = np.array([_xy(one.angle, SEAT * one.place, disc.sense) for one in disc.spots]).reshape(-1, 2)
    radii, turns = np.linspace(0.0, 0.86, 12), np.arange(36) * tau / 36
    places = np.array([(r * cos(t), r * sin(t)) for r in radii for t in turns])
    taken: list[tuple[Any, Any]] = []
    for spot, point in zip(disc.spots, points, strict=True):
        bold = spot.look != "there"
        size = SIZE - 0.5 if bold else SMALL
        lines = spot.words.split("\n")
        box = np.array([0.60 * max(map(len, lines)) + 1.0, 1.35 * len(lines) + 0.6]) * size / 72.0 / across
        costs = np.hypot(*(places - point).T)
        for other, wide in [(one, np.full(2, 0.1)) for one in points] + taken:
            costs += 50.0 * (np.abs(places - other) < box + wide).all(axis=1)
        costs += 50.0 * np.maximum(np.hypot(*(np.abs(places) + box).T) - 1.08, 0.0)
        place = places[int(np.argmin(costs))]
        taken.append((place, box))
        _label(axes, spot.words, place, point, size, bold, disc.sense)


def _label(axes: Any, words: str, place: Any, point: Any, size: float, bold: bool, sense: int) -> None:
    (angle, radius), (end, far) = (_polar(x, y, sense) for x, y in (place, point))
    axes.annotate(
        words, (end, far), xytext=(angle, radius), fontsize=size, fontweight="bold" if bold else "normal", color=INK,
        ha="center", va="center", zorder=9, bbox={"boxstyle": "round,pad=0.2", "fc": "white", "ec": GRID, "lw": 0.6},
        arrowprops={"arrowstyle": "-", "color": INK, "lw": 0.7, "shrinkB": 5},
    )  # fmt: skip


def _xy(angle: float, radius: float, sense: int) -> tuple[float, float]:
    """Place on the paper of a written angle, the disc's radius as unit."""
    turn = sense * angle + 0.5 * pi
    return radius * cos(turn), radius * sin(turn)


def _polar(x: float, y: float, sense: int) -> tuple[float, float]:
    """Written angle and radius of a place on the paper."""
    return sense * (float(np.arctan2(y, x)) - 0.5 * pi), float(np.hypot(x, y))


def _senses(axes: Any, disc: Disc) -> None:
    """Curved arrows outside the rim: the sense of the angles beside zero, and the rotation on the other side."""
    _arc(axes, disc.sense * 10.0, disc.sense * 35.0, 1.24, INK)
    _words(axes, disc.sense * 40.0, 1.5, "angles")
    if disc.turns:
        _arc(axes, 155.0, 205.0, 1.24, FAINT)
        _words(axes, 180.0, 1.4, "rotation")


def _arc(axes: Any, start: float, end: float, radius: float, colour: str) -> None:
    """An arrow on a circle; angles in degrees counter-clockwise from the top as drawn."""
    from matplotlib.patches import FancyArrowPatch

    turn = np.radians(np.linspace(start, end, 24)) + 0.5 * pi
    points = np.stack([0.5 + 0.5 * radius * np.cos(turn), 0.5 + 0.5 * radius * np.sin(turn)], axis=1)
    axes.plot(points[:-1, 0], points[:-1, 1], transform=axes.transAxes, color=colour, lw=1.3, clip_on=False)
    axes.add_patch(
        FancyArrowPatch(
            tuple(points[-3]), tuple(points[-1]), transform=axes.transAxes, arrowstyle="-|>", mutation_scale=9,
            color=colour, lw=1.3, clip_on=False,
        )
    )  # fmt: skip


def _words(axes: Any, angle: float, radius: float, words: str) -> None:
    turn = angle * pi / 180.0 + 0.5 * pi
    x, y = 0.5 + 0.5 * radius * cos(turn), 0.5 + 0.5 * radius * sin(turn)
    axes.text(x, y, words, transform=axes.transAxes, fontsize=SMALL, color=INK, ha="center", va="center")


def draw_dial(figure: Figure, place: Any, dial: Dial) -> None:
    """The readings of a sensor before and after, with limit circles and 95 % rings."""
    axes = polar(figure, place, f"{dial.title} [{dial.unit}]", dial.sense)
    sizes = [one.before[0] for one in dial.phasors] + [one.after[0] for one in dial.phasors]
    # a limit far outside would hide the readings
    limits = [one.limit for one in dial.phasors if one.limit is not None and one.limit < 3.0 * max(sizes)]
    top = 1.12 * max([*sizes, *limits]) or 1.0
    axes.set_ylim(0.0, top)
    _ticks(axes, top, [one.before[1] for one in dial.phasors])
    for index, one in enumerate(dial.phasors):
        _phasor(axes, one, index, len(dial.phasors) > 1)


def _ticks(axes: Any, top: float, angles: Sequence[float]) -> None:
    """Three round radii, labelled where no reading is."""
    from matplotlib.ticker import MaxNLocator

    ticks = [one for one in MaxNLocator(3).tick_values(0.0, top) if 0.0 < one < top]
    axes.set_yticks(ticks, [plain(float(one), 3) for one in ticks], fontsize=SMALL - 0.5, color=FAINT)
    gaps = [min(min(abs((a - b) % tau), abs((b - a) % tau)) for b in angles) for a in np.arange(16) * pi / 8 + pi / 16]
    axes.set_rlabel_position(float(degrees(np.arange(16)[int(np.argmax(gaps))] * pi / 8 + pi / 16)))


def _phasor(axes: Any, one: Phasor, index: int, named: bool) -> None:
    around = np.linspace(0.0, tau, 181)
    if one.limit is not None:
        axes.plot(around, np.full(181, one.limit), color=RED, lw=1.5, ls=(0, (6, 2)), zorder=3)
    if one.band is not None:
        low, high = one.band
        axes.fill_between(around, low, high, color="#9db7d8", alpha=0.35, lw=0, zorder=2)
        axes.plot(around, np.full(181, high), color=BLUE, lw=0.7, ls=":", zorder=2)
    for (size, angle), colour, style, look in (
        (one.before, FAINT, (0, (3, 1.5)), {"marker": "o", "ms": 5, "mfc": "white", "mec": INK}),
        (one.after, BLUE, "-", {"marker": "D", "ms": 4.5, "mfc": BLUE, "mec": INK}),
    ):
        axes.plot([angle, angle], [0.0, size], color=colour, lw=1.6, ls=style, zorder=5)
        axes.plot([angle], [size], zorder=6, mew=0.9, ls="", clip_on=False, **look)
    (far, start), (near, end) = one.before, one.after
    axes.annotate(
        "", (end, near), xytext=(start, far), zorder=4,
        arrowprops={"arrowstyle": "->", "color": FAINT, "lw": 0.7, "shrinkA": 4, "shrinkB": 4},
    )  # fmt: skip
    if named:
        axes.annotate(
            one.name, (one.before[1], one.before[0]), xytext=(4, 4), textcoords="offset points", fontsize=SMALL - 0.5,
            color=INK, zorder=7,
        )  # fmt: skip


MOST = 40
BEFORE = {"color": "white", "edgecolor": FAINT, "hatch": "////", "lw": 0.8}
AFTER = {"color": BLUE, "edgecolor": INK, "lw": 0.8}


@dataclass(frozen=True, slots=True)
class Bar:
    """One pair of bars in the unit of its axes; `after` None: only what was found."""

    name: str
    before: float | None
    after: float | None
    limit: float | None = None
    band: tuple[float, float] | None = None


def bars(axes: Any, title: str, unit: str, given: Sequence[Bar]) -> None:
    """Horizontal bars from the top down; of many the worst MOST."""
    shown = list(given)
    if len(shown) > MOST:
        shown = sorted(shown, key=lambda one: one.after or 0.0, reverse=True)[:MOST]
        title = f"{title}: the worst {MOST} of {len(given)}"
    dress(axes, title, unit, "")
    rows = np.arange(len(shown))
    for offset, look, values in (
        (-0.2, BEFORE, [one.before for one in shown]),
        (0.2, AFTER, [one.after for one in shown]),
    ):
        kept = [(row, value) for row, value in zip(rows, values, strict=True) if value is not None]
        if kept:
            axes.barh([row + offset for row, _ in kept], [value for _, value in kept], height=0.38, zorder=3, **look)
    for row, one in zip(rows, shown, strict=True):
        if one.band is not None:
            axes.plot(one.band, [row + 0.2, row + 0.2], color=INK, lw=1.4, marker="|", ms=7, zorder=5)
        if one.limit is not None:
            axes.plot([one.limit, one.limit], [row - 0.45, row + 0.45], color=RED, lw=2.4, zorder=6)
    axes.set_yticks(rows, [one.name for one in shown], fontsize=SIZE - 1)
    axes.set_ylim(len(shown) - 0.4, -0.6)
    axes.set_xlim(left=0.0)
    axes.grid(False, axis="y")


def height(count: int) -> float:
    """Inches that `count` pairs of bars need."""
    return 0.75 + 0.26 * min(count, MOST)


def key(
    figure: Any,
    caption: str,
    *,
    dials: bool,
    limits: bool,
    bands: bool = False,
    fitted: bool = True,
    removed: bool = False,
    masses: bool = False,
    circles: bool = False,
    before: bool = True,
    after: bool = True,
    whole: bool = False,
) -> None:
    """Caption and legend below everything, only with what is drawn; `whole` weights stand instead of what is on."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    line: Any = Line2D
    found: list[tuple[Any, str]] = []
    if masses:
        found.append((line([], [], ls="", marker="s", mfc="white", mec=INK), "known mass"))
    if dials:
        if fitted:
            found.append(
                (line([], [], ls="", ms=8, marker="o", mfc=BLUE, mec=INK), "whole weight" if whole else "fit here")
            )
        if removed:
            found.append((line([], [], ls="", ms=8, marker="X", mfc="white", mec=RED), "take away here"))
        found.append((line([], [], ls="", marker="v", color=INK, ms=7), "zero mark"))
    open_, full = (" (on a dial: open circle)", " (on a dial: diamond)") if circles else ("", "")
    if before:
        found.append((Patch(facecolor="white", edgecolor=FAINT, hatch="////"), f"as found{open_}"))
    if after:
        found.append((Patch(facecolor=BLUE, edgecolor=INK), f"after{full}"))
    if limits:
        found.append((line([], [], color=RED, lw=2.0), "limit"))
    if bands:
        found.append((line([], [], color=INK, lw=1.2, marker="|"), "95 % band"))
    figure.legend(
        [one for one, _ in found],
        [words for _, words in found],
        loc="outside lower center",
        ncols=min(len(found), 4),
        fontsize=SIZE - 1,
        frameon=False,
        title=caption,
        title_fontsize=SIZE - 0.5,
    )


def pad_more(figure: Any) -> None:
    """Room between the parts and at the edge of the paper."""
    engine = figure.get_layout_engine()
    engine.set(w_pad=0.1, h_pad=0.08)
