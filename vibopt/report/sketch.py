"""A sketch of the machine: what stands on what, what shakes it, and where it is looked at.

Bodies are boxes in levels above the ground or what carries them; words of springs stand in lines of the gap between
two levels, so that none covers another.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.mechanics.built import GROUND
from vibopt.report.figures.canvas import LETTER, Box, Canvas, along, caption_height, fitted_rows, wide
from vibopt.report.figures.paper import BLUE, FAINT, INK, SIZE, WIDTH, drawn
from vibopt.report.machine_parts import Link, Sketch

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SMALL = SIZE - 1.5
BODY, SPRING = 0.36, 0.62
"""Inches: height of a box, and of a spring without words."""
GEAR = 0.09
"""Inches: radius of each of the two gears that stand for teeth."""
_TURN = np.linspace(0.0, 2.0 * np.pi, 49)
LINE = 0.145
MOST_SHAKES = 2
MOST = 40
"""More boxes than this are no picture any more."""


def sketch_figure(sketch: Sketch, width: float = WIDTH, title: str = "", *, looked_at: bool = True) -> Figure | None:
    """Boxes in levels, links between them, excitations; and where it is `looked_at`.  None of too many, or of none."""
    sketch = sketch if looked_at else replace(sketch, notes=(), sites=())
    if not sketch.boxes or len(sketch.boxes) > MOST:
        return None
    page = _Page(sketch, width)
    canvas = Canvas(width, page.height, title)
    page.draw(canvas)
    return canvas.figure


class _Page:
    """Where everything stands, in inches from the left and from the ground."""

    def __init__(self, sketch: Sketch, width: float) -> None:
        self.sketch, self.width = sketch, width
        self.level = levels(sketch)
        self.count = 1 + max(self.level.values())
        self.x = self._places()
        self.gaps: list[list[tuple[float, str]]] = [[] for _ in range(self.count + 1)]
        self.lane = {link.name: self._lane(link) for link in sketch.links}
        for link in sketch.links:
            self.gaps[self._gap(link)].append((self.lane[link.name] + 0.17, link.words))
        self.rows = [fitted_rows([(x, wide(words, SMALL)) for x, words in gap], width) for gap in self.gaps]
        self.bottom = self._bottoms()

    @property
    def height(self) -> float:
        return self.bottom[-1] + self._tall(self.count) + 0.18 + LINE * len(self._notes()) + 0.15

    def _notes(self) -> list[str]:
        notes = list(self.sketch.notes)
        far = [shake.words.replace("\n", " ") for shake in self.sketch.shakes if self._crowded(shake.on)]
        if far:
            notes.insert(0, f"Shaken by {'; '.join(far)}.")
        return [line for words in notes for line in wrap(words, int(self.width * 17))]

    def _shaken(self, name: str) -> str:
        """The excitations of a box in words, to stand beside it; "" where there is no room."""
        words = [shake.words for shake in self.sketch.shakes if shake.on == name]
        if len(words) <= 1:
            return "".join(words)
        more = [f"and {len(words) - MOST_SHAKES} more"] if len(words) > MOST_SHAKES else []
        return "\n".join([*(word.replace("\n", " ") for word in words[:MOST_SHAKES]), *more])

    def _crowded(self, name: str) -> bool:
        """Whether the boxes of a level with the words beside them are wider than the page."""
        if name not in self.level:
            return True
        row = [box.name for box in self.sketch.boxes if self.level[box.name] == self.level[name]]
        return sum(self._room(one) for one in row) > self.width - 0.1

    def _tall(self, gap: int) -> float:
        """Inches of a gap: its words in lines, and at least a spring."""
        words = [one for _, one in self.gaps[gap]]
        if not words:
            return 0.0 if gap in (0, self.count) else SPRING
        rows = 1 + max(row for row, _ in self.rows[gap])
        return max(SPRING if gap < self.count else 0.0, caption_height(words, rows, SMALL) + 0.14)

    def _bottoms(self) -> list[float]:
        """Lower edge of the boxes of each level; last the upper edge of the highest."""
        found = [0.16 + self._tall(0)]
        for k in range(1, self.count):
            found.append(found[-1] + BODY + self._tall(k))
        return [*found, found[-1] + BODY]

    def _places(self) -> dict[str, float]:
        """Middles of the boxes of a level: above what they stand on, beside each other where that is the same."""
        found: dict[str, float] = {}
        for k in range(self.count):
            row = [box.name for box in self.sketch.boxes if self.level[box.name] == k]
            below = {name: self._below(name, found) for name in row}
            row.sort(key=lambda name: below[name])
            room = [min(self._room(name), (self.width - 0.1) / len(row)) for name in row]
            places = along([below[name] for name in row], room, (0.05, self.width - 0.05))
            found |= dict(zip(row, places, strict=True))
        return found

    def _room(self, name: str) -> float:
        """Inches that a box takes with the words on both sides of its middle."""
        own = wide(next(box.words for box in self.sketch.boxes if box.name == name), SMALL)
        words = [link.words for link in self.sketch.links if name in link.ends and self._gap(link) == self.level[name]]
        right = max((wide(word, SMALL) + 0.2 for word in words), default=0.0)
        if self._shaken(name):
            right = max(right, 0.5 * own + 0.35 + wide(self._shaken(name), SMALL))
        return 2.0 * max(right, 0.5 * own + 0.2)

    def _below(self, name: str, placed: dict[str, float]) -> float:
        ends = [other for link in self.sketch.links for other in link.ends if name in link.ends and other in placed]
        return float(np.mean([placed[end] for end in ends])) if ends else 0.5 * self.width

    def _past_joints(self, name: str) -> list[Link]:
        """Links down from a box past a joint on which it stands, too."""
        down = [link for link in self.sketch.links if name in link.ends and self._gap_of(link)[1] == self.level[name]]
        on_joints = any(box.joint for box in self.sketch.boxes for link in down if box.name in link.ends)
        return [link for link in down if on_joints and self.level[name] - self._gap_of(link)[0] > 1]

    def _half(self, name: str) -> float:
        """Half the width of a box."""
        if self._past_joints(name):
            return self._own_half(name) + 0.5
        return self._own_half(name)

    def _own_half(self, name: str) -> float:
        if name == GROUND:
            row = sum(self.level[box.name] == 0 for box in self.sketch.boxes)
            return 0.46 * self.width / row
        [words] = [box.words for box in self.sketch.boxes if box.name == name]
        above = [link for link in self.sketch.links if name in link.ends and self.level[name] < self._gap(link)]
        below = [link for link in self.sketch.links if name in link.ends and link not in above]
        room = (self.width - 0.1) / sum(self.level[one] == self.level[name] for one in self.x)
        return min(max(0.5 * wide(words, SMALL) + 0.08, 0.2 * max(len(above), len(below)) + 0.1), 0.42 * room)

    def _gap(self, link: Link) -> int:
        """The gap below the upper end; of two ends side by side the one above them."""
        low, high = sorted(self.level[end] for end in link.ends)
        return high if low < high else high + 1

    def _lane(self, link: Link) -> float:
        """Where a spring stands: between what its ends have in common, beside those that do the same."""
        a, b = sorted(link.ends, key=lambda one: self.level[one])
        beside = [one.name for one in self.sketch.links if set(one.ends) == set(link.ends)]
        upper = [one for one in self.sketch.links if b in one.ends and self._gap_of(one) == self._gap_of(link)]
        shift = (beside.index(link.name) + 0.5) / len(beside) - 0.5
        if link in self._past_joints(b):
            return self.x[b] + self._half(b) - 0.12
        if self.level[a] == self.level[b]:
            return 0.5 * (self.x[a] + self.x[b])
        low = max(self.x[a] - self._half(a), self.x[b] - self._half(b)) + 0.1
        high = min(self.x[a] + self._half(a), self.x[b] + self._half(b)) - 0.1
        if low > high:  # no line straight down: from the middle of the upper one
            return self.x[b] + 0.5 * shift * self._half(b)
        if len(upper) > len(beside):  # others hang here too: each at its own place
            shift = (upper.index(link) + 0.5) / len(upper) - 0.5
        return min(max(self.x[b] + shift * 2.0 * self._half(b), low), high)

    def _gap_of(self, link: Link) -> tuple[int, int]:
        low, high = sorted(self.level[end] for end in link.ends)
        return (low, high)

    def draw(self, canvas: Canvas) -> None:
        notes = self._notes()
        axes = canvas.part(Box(0.0, self.height, self.width), origin=(0.0, LINE * len(notes) + 0.15))
        for link in self.sketch.links:
            self._link(axes, link)
        for box in self.sketch.boxes:
            self._box(axes, box.name, box.words, box.still)
        for name in self.x:
            self._shake(axes, name)
        for gap in range(self.count + 1):
            self._words(axes, gap)
        for k, line in enumerate(notes):
            axes.text(0.1, -0.05 - LINE * (k + 1), line, fontsize=SMALL, color=INK, va="bottom")
        canvas.down(self.height)

    def _floor(self, gap: int) -> float:
        """Lower edge of a gap: the upper edge of the boxes below it."""
        return 0.16 if gap == 0 else self.bottom[gap - 1] + BODY

    def _words(self, axes: Any, gap: int) -> None:
        tall = caption_height([one for _, one in self.gaps[gap]], 1, SMALL)
        for (row, x), (_, words) in zip(self.rows[gap], self.gaps[gap], strict=True):
            y = self._floor(gap) + 0.08 + row * tall
            axes.text(x, y, words, fontsize=SMALL, color=INK, va="bottom", linespacing=1.1, zorder=6,
                      bbox={"fc": "white", "ec": "none", "pad": 0.4, "alpha": 0.9})  # fmt: skip

    def _box(self, axes: Any, name: str, words: str, still: bool) -> None:
        y, x, half = self.bottom[self.level[name]], self.x[name], self._half(name)
        if name == GROUND:
            axes.plot([x - half, x + half], [y + BODY, y + BODY], color=INK, lw=1.6, zorder=3)
            for at in np.arange(x - half, x + half - 0.05, 0.12):
                axes.plot([at, at + 0.09], [y + BODY - 0.1, y + BODY], color=FAINT, lw=0.8, zorder=2)
            axes.text(x, y + 0.05, "ground", ha="center", va="bottom", fontsize=SMALL, color=INK)
            self._looked_at(axes, name, x - half, y + BODY)
            return
        ends = ([x - half, x + half, x + half, x - half], [y, y, y + BODY, y + BODY])
        axes.fill(*ends, fc="#e4e4e4" if still else "white", ec=INK, lw=1.2, zorder=4)
        if wide(words, SMALL) > 2.0 * half:  # in two lines, each as long as there is room
            most = int(2.0 * half * 72.0 / (LETTER * SMALL))
            words = "\n".join(drawn(one, max(most, 8)) for one in words.split(" ", 1))
        axes.text(
            x, y + 0.5 * BODY, words, ha="center", va="center", fontsize=SMALL, color=INK, zorder=5, linespacing=1.1
        )
        self._looked_at(axes, name, x - half, y + BODY)

    def _looked_at(self, axes: Any, name: str, x: float, y: float) -> None:
        """A circle where a limit or a measure looks."""
        if name in self.sketch.sites:
            axes.plot([x], [y], marker="o", ms=5, mfc="white", mec=INK, zorder=6, ls="")

    def _link(self, axes: Any, link: Link) -> None:
        a, b = sorted(link.ends, key=lambda one: self.level[one])
        x, top = self.lane[link.name], self.bottom[self.level[b]]
        if self.level[a] == self.level[b]:
            y = top + 0.5 * BODY
            left, right = sorted((self.x[a], self.x[b]))
            _symbols(axes, link, (left, y), (right, y))
            axes.plot([x, x + 0.1], [y, self._floor(self._gap(link)) + 0.1], color=FAINT, lw=0.5)
            return
        foot = self.bottom[self.level[a]] + BODY
        low = max(foot, self.bottom[self.level[b] - 1] + BODY)
        _symbols(axes, link, (x, low), (x, top))
        side = min(max(x, self.x[a] - self._half(a)), self.x[a] + self._half(a))
        axes.plot([x, x, side], [low, foot + 0.05 if side != x else foot, foot], color=INK, lw=0.9, zorder=1)

    def _shake(self, axes: Any, name: str) -> None:
        """What shakes a box beside it: forces from above, a motion to and fro."""
        shakes = [shake for shake in self.sketch.shakes if shake.on == name]
        if not shakes:
            return
        x, y = self.x[name] + self._half(name) + 0.08, self.bottom[self.level[name]]
        shape = "<|-|>" if any(shake.motion for shake in shakes) else "-|>"
        style = {"arrowstyle": shape, "color": BLUE, "lw": 1.5, "mutation_scale": 10, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", (x, y), xytext=(x, y + BODY), arrowprops=style, zorder=5)
        if not self._crowded(name):
            words = self._shaken(name)
            axes.text(x + 0.1, y + 0.5 * BODY, words, fontsize=SMALL, color=INK, va="center", linespacing=1.1)


def levels(sketch: Sketch) -> dict[str, int]:
    """How many links each box is above supports and structures; what hangs on none is counted from one end.

    A joint stands below the body that it holds, wherever it leads to what carries both.
    """
    light = {box.name for box in sketch.boxes if box.joint}
    level = {box.name: 0 for box in sketch.boxes if box.still}
    left = [link.ends for link in sketch.links]
    if not level and left:
        level[left[0][1]] = 0
    while left:
        ready = [two for two in left if two[0] in level or two[1] in level]
        near = next((two for two in ready if light & {*two}), ready[0] if ready else left[0])
        left.remove(near)
        a, b = near if near[0] in level else near[::-1]
        level.setdefault(a, 0)
        level.setdefault(b, level[a] + 1)
    return {box.name: level.get(box.name, 0) for box in sketch.boxes}


def _symbols(axes: Any, link: Link, start: tuple[float, float], stop: tuple[float, float]) -> None:
    """Spring, damper and inerter side by side from one place to the other."""
    kinds = list(_kinds(link))
    a, b = np.array(start), np.array(stop)
    across = np.array([-(b - a)[1], (b - a)[0]]) / (np.hypot(*(b - a)) or 1.0)
    if link.gear:
        middle, way = 0.5 * (a + b), (b - a) / (np.hypot(*(b - a)) or 1.0)
        axes.plot(*zip(start, stop, strict=True), color=INK, lw=1.0, zorder=1.5)
        for off in (-GEAR, GEAR):  # they touch in the middle
            around = middle + off * way + GEAR * np.column_stack([np.cos(_TURN), np.sin(_TURN)])
            axes.fill(around[:, 0], around[:, 1], fc="white", ec=INK, lw=1.0, zorder=2)
        return
    for k, kind in enumerate(kinds):
        shift = 0.11 * (k - 0.5 * (len(kinds) - 1)) * across
        for line in _SHAPES[kind]:
            points = np.array(line)
            drawn_ = a + shift + points[:, :1] * (b - a) + 0.045 * points[:, 1:] * across
            axes.plot(drawn_[:, 0], drawn_[:, 1], color=INK, lw=1.0, zorder=1.5)


def _kinds(link: Link) -> Iterator[str]:
    if link.spring:
        yield "spring"
    if link.damper:
        yield "damper"
    if link.inerter:
        yield "inerter"
    if not (link.spring or link.damper or link.inerter):
        yield "bar"


_POT = [(0.4, -1.0), (0.6, -1.0), (0.6, 1.0), (0.4, 1.0)]
_SHAPES: dict[str, list[list[tuple[float, float]]]] = {
    "spring": [[(0.0, 0.0), (0.22, 0.0), *((0.26 + 0.06 * k, (-1.0) ** k) for k in range(9)), (0.78, 0.0), (1.0, 0.0)]],
    "damper": [
        [(0.0, 0.0), (0.4, 0.0)],
        [_POT[1], _POT[0], _POT[3], _POT[2]],
        [(0.53, -0.7), (0.53, 0.7)],
        [(0.53, 0.0), (1.0, 0.0)],
    ],
    "inerter": [[(0.0, 0.0), (0.4, 0.0)], [*_POT, _POT[0]], [(0.5, -1.0), (0.5, 1.0)], [(0.6, 0.0), (1.0, 0.0)]],
    "bar": [[(0.0, 0.0), (1.0, 0.0)]],
}
