"""Three views of a machine in space, to one scale: from above, from the front and from the side."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.mechanics.rigid import SpaceMachine
from vibopt.records import dataclass
from vibopt.report.figures.canvas import Box, Canvas, spread, wide
from vibopt.report.figures.paper import BLUE, FAINT, INK, SIZE, WIDTH, drawn
from vibopt.report.figures.rotor_drawing import rotor_figure
from vibopt.report.machine_parts import notes_of, shake_words, sketch_of
from vibopt.report.mount_spots import Spot, markers_of, spots_of
from vibopt.report.rotor_parts import rotors_of
from vibopt.report.sketch import sketch_figure
from vibopt.report.what_to_build import machine_in
from vibopt.scene.scene import Design, Scene
from vibopt.scene.space import is_spatial

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SMALL = SIZE - 1.5
LINE = 0.145
EDGE, GAP, MOUNT = 0.36, 0.55, 0.07
"""Inches around what is drawn, between two views, and from the middle of a mount to what it stands on."""


@dataclass(frozen=True, slots=True)
class _Site:
    """Something with a place [m]: words, and the direction in which it pulls or slides, or the axis of its turn."""

    at: FloatArray
    words: str
    along: FloatArray | None = None
    about: bool = False
    slides: bool = False


def views_figure(machine: SpaceMachine, scene: Scene, title: str = "") -> Figure | None:
    """Mounts, centres of mass, lines of force and named points; None where nothing stands on mounts."""
    spots = spots_of(machine)
    if not spots:
        return None
    named = {name: machine.fixed[name][1] for name in scene.points if name in machine.fixed}
    slid = [_Site(one.at, drawn(name, 16), one.way, slides=True) for name, one in machine.guided.items()]
    sites = [*_shaken(machine, scene), *slid, *(_Site(np.asarray(at), drawn(name, 16)) for name, at in named.items())]
    centres = {name: np.asarray(rigid.centre) for name, rigid in machine.rigid.items()}
    places = np.array([[*spot.at] for spot in spots] + [site.at for site in sites] + list(centres.values()))
    low, high = places.min(axis=0), places.max(axis=0)
    size = np.maximum(high - low, 1e-3 * max(float((high - low).max()), 1e-3))
    words = [drawn(spot.name, 16) for spot in spots] + [site.words.split("\n")[0] for site in sites]
    column = max(wide(word, SMALL) for word in words) + 0.12
    notes = _notes(scene)
    room = WIDTH - 2.0 * column - GAP - 4.0 * EDGE
    scale = min(
        room / float(size[0] + size[1]), 2.2 / float(size[1]), 2.0 / float(size[2]), room * 0.62 / float(size[0])
    )
    wide_, deep, tall = (float(one) * scale for one in size)
    labels = 0.5 * (len(words) + 1) * 0.15
    top = max(deep + 2.0 * EDGE, labels + 0.2) + 0.35
    front = tall + 2.0 * EDGE + 0.35
    canvas = Canvas(WIDTH, top + front + LINE * len(notes) + 0.15, title)
    drawing = _Views(machine, scene, spots, sites, centres, low, high, scale)
    left = column + EDGE
    axes = canvas.part(Box(0.0, top, WIDTH), origin=(left, 0.5 * (top - 0.35 - deep)))
    drawing.view(axes, (0, 1), "from above: x to the right, y up", (0.5 * wide_, deep + 0.5 * (top - 0.35 - deep)))
    drawing.names(axes, words, (-EDGE + 0.02, wide_ + EDGE - 0.02), 0.5 * deep)
    canvas.down(top)
    axes = canvas.part(Box(0.0, front, WIDTH), origin=(left, EDGE))
    drawing.view(axes, (0, 2), "from the front: x, z up", (0.5 * wide_, tall + EDGE))
    start = max(left + wide_ + EDGE + GAP, 0.5 * WIDTH + 0.4)
    axes = canvas.part(Box(start, front, WIDTH - start), origin=(EDGE, EDGE))
    drawing.view(axes, (1, 2), "from the side: y, z up", (0.5 * deep, tall + EDGE))
    canvas.down(front)
    axes = canvas.part(Box(0.0, LINE * len(notes) + 0.15, WIDTH), origin=(0.0, 0.1))
    for k, line in enumerate(reversed(notes)):
        axes.text(0.1, LINE * k, line, fontsize=SMALL, color=INK, va="bottom")
    return canvas.figure


@dataclass(frozen=True)
class _Views:
    machine: SpaceMachine
    scene: Scene
    spots: Sequence[Spot]
    sites: Sequence[_Site]
    centres: dict[str, FloatArray]
    low: FloatArray
    high: FloatArray
    scale: float

    def _to(self, at: Any, pair: tuple[int, int]) -> tuple[float, float]:
        x, y = (self.scale * float(at[k] - self.low[k]) for k in pair)
        return x, y

    def view(self, axes: Any, pair: tuple[int, int], title: str, above: tuple[float, float]) -> None:
        """One view, its title over it."""
        for name in self.centres:
            self._outline(axes, name, pair)
        if pair[1] == 2:
            for spot in self.spots:
                self._ground(axes, spot, pair)
        for group, (shape, fill) in markers_of(self.machine).items():
            mine = [self._to(one.at, pair) for one in self.spots if one.group == group]
            axes.plot(*zip(*mine, strict=True), marker=shape, mfc=fill, mec=INK, ms=6.5, ls="", zorder=4)
        for at in self.centres.values():
            x, y = self._to(at, pair)
            axes.plot([x], [y], marker="o", mfc="white", mec=INK, ms=9, ls="", zorder=5)
            axes.plot([x], [y], marker="+", color=INK, ms=12, mew=1.0, ls="", zorder=5)
        for site in self.sites:
            _site(axes, self._to(site.at, pair), site, pair)
        axes.text(above[0], above[1] + 0.06, title, ha="center", va="bottom", fontsize=SMALL, color=INK)

    def _ground(self, axes: Any, spot: Spot, pair: tuple[int, int]) -> None:
        """What carries a mount and does not move with a body: a hatched line under it."""
        if spot.by in self.centres:
            return
        x, y = self._to(spot.at, pair)
        axes.plot([x - 0.16, x + 0.16], [y - MOUNT, y - MOUNT], color=INK, lw=1.2, zorder=3)
        for k in range(4):
            left = x - 0.16 + 0.08 * k
            axes.plot([left, left + 0.07], [y - MOUNT - 0.07, y - MOUNT], color=FAINT, lw=0.8, zorder=2)

    def _outline(self, axes: Any, name: str, pair: tuple[int, int]) -> None:
        """The rectangle that holds the centre and the points of a body: above its mounts, below those on it."""
        held = [self._to(self.centres[name], pair)]
        held += [self._to(at, pair) for body, at in self.machine.fixed.values() if body == name]
        held += [self._to(one.at, pair) for one in self.machine.guided.values() if one.host == name]
        lift = MOUNT + 0.07 if pair[1] == 2 else 0.0
        for spot in self.spots:
            if name in (spot.carried, spot.by):
                there = self._to(spot.at, pair)
                held.append((there[0], there[1] + (lift if name == spot.carried else -lift)))
        x, y = zip(*held, strict=True)
        left, right, low, high = min(x) - 0.07, max(x) + 0.07, min(y) - 0.07, max(y) + 0.07
        axes.fill([left, right, right, left], [low, low, high, high], fc="#f1f1f1", ec=FAINT, lw=0.8, zorder=1)

    def names(self, axes: Any, words: Sequence[str], sides: tuple[float, float], middle: float) -> None:
        """Names of mounts and sites left and right of the view, each tied to its place."""
        places = [
            self._to(one, (0, 1)) for one in [*(spot.at for spot in self.spots), *(site.at for site in self.sites)]
        ]
        order = sorted(range(len(words)), key=lambda k: places[k][0])
        half = len(order) // 2
        for rows, x, align in ((order[:half], sides[0], "right"), (order[half:], sides[1], "left")):
            rows = sorted(rows, key=lambda k: -places[k][1])
            heights = spread([places[k][1] for k in rows], [0.15] * len(rows))
            shift = middle - 0.5 * (heights[0] + heights[-1]) if len(rows) > 1 else 0.0
            for k, y in zip(rows, (height + shift for height in heights), strict=True):
                axes.plot([x, places[k][0]], [y, places[k][1]], color=FAINT, lw=0.5, zorder=2)
                axes.text(x, y, f" {words[k]} ", ha=align, va="center", fontsize=SMALL, color=INK)


def _site(axes: Any, at: tuple[float, float], site: _Site, pair: tuple[int, int]) -> None:
    """A named point as a cross; a force as an arrow, along the view as a dot in a ring; an axis as a dashed line."""
    x, y = at
    if site.along is None:
        axes.plot([x], [y], marker="x", color=INK, ms=5, ls="", zorder=5)
        return
    if site.slides:
        dx, dy = (0.16 * float(site.along[k]) for k in pair)
        axes.plot([x - dx, x + dx], [y - dy, y + dy], color=INK, lw=1.4, zorder=6)
        axes.plot([x], [y], marker="s", mfc="white", mec=INK, ms=6, ls="", zorder=7)
        return
    dx, dy = (0.42 * float(site.along[k]) for k in pair)
    if abs(dx) + abs(dy) < 0.05:
        axes.plot([x], [y], marker="o", mfc="none", mec=BLUE, ms=16, mew=1.6, ls="", zorder=6)
        axes.plot([x], [y], marker="o", color=BLUE, ms=4, ls="", zorder=7)
        return
    dx, dy = (1.9 * dx, 1.9 * dy) if not site.about else (1.4 * dx, 1.4 * dy)
    if site.about:
        axes.plot([x - dx, x + dx], [y - dy, y + dy], color=BLUE, lw=1.4, ls=(0, (6, 2, 1, 2)), zorder=6)
        return
    style = {"arrowstyle": "<|-|>", "color": BLUE, "lw": 1.8, "mutation_scale": 14, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (x + 0.5 * dx, y + 0.5 * dy), xytext=(x - 0.5 * dx, y - 0.5 * dy), arrowprops=style, zorder=6)


def _shaken(machine: SpaceMachine, scene: Scene) -> list[_Site]:
    """Every excitation of a body in space."""
    found = []
    for name, excitation in scene.excitations.items():
        place = getattr(excitation, "place", excitation.on)
        at = machine.fixed[place][1] if place in machine.fixed else None
        if at is None and place in machine.rigid:
            at = machine.rigid[place].mark
        way, axis = getattr(excitation, "direction", None), getattr(excitation, "axis", None)
        along = way if way is not None else axis
        if at is not None and along is not None:
            words = shake_words(scene, name)
            found.append(_Site(np.asarray(at), words, np.array(along, dtype=float), about=way is None))
    return found


def _notes(scene: Scene) -> list[str]:
    """What marks mean, what shakes, and where the machine is looked at."""
    said = [
        "Cross in a ring: centre of mass.  Hatched: what does not move.  Arrows: forces to and fro.  Dash and dot: "
        "axes of rotation or of moments.  Dot in a ring: such a force or axis along the view."
    ]
    said += ["Square with a line through it: an absorber, and the way it slides."] * any(
        one.placed for one in scene.absorbers.values()
    )
    shakes = "; ".join(shake_words(scene, name).replace("\n", ": ") for name in scene.excitations)
    said += [f"Shaken by {shakes}."] if shakes else []
    said += [one.replace(" (circles)", "") for one in notes_of(scene)]
    return [line for one in said for line in wrap(one, 118)]


def machine_figure(design: Design, title: str = "") -> Figure | None:
    """A machine with what was chosen of it: views in space, rotors from the side, else what stands on what.

    None of a machine in space without a design, whose places are not known, and of more boxes than a picture holds.
    """
    machine = machine_in(design)
    if isinstance(machine, SpaceMachine):
        figure = views_figure(machine, design.scene, title)
        if figure is not None:
            return figure
    if design.scene.rotors:
        notes = [
            f"Shaken by {shake_words(design.scene, excitation)}.".replace("\n", ": ")
            for excitation in design.scene.excitations
        ]
        notes += [one.replace(" (circles)", "") for one in notes_of(design.scene)]
        notes += [
            f"{name} is given by its matrices: the lines across are their nodes, and how thick it is they do not say."
            for name, table in design.scene.rotors.items()
            if table.matrices is not None
        ]
        return rotor_figure(rotors_of(design), title, [line for note in notes for line in wrap(note, 118)])
    return None if is_spatial(design.scene) else sketch_figure(sketch_of(design), title=title)
