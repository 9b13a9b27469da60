"""Figures of engines: the crankshaft from its end and from the side, and what shakes over a turn and by order."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, pi, sin, tau
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.answer.answer import Answer
from vibopt.answer.entry import Entry
from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.engine.engine_job import EngineJob
from vibopt.balancing.engine.shaking import arms, free_shares, free_weights, of_order, over_turn, size_of
from vibopt.balancing.figures.dials import MOST, Cell, Disc, Row, Spot, rows_of
from vibopt.balancing.figures.drawing import AFTER, BEFORE, COMPACT, page
from vibopt.errors import counted
from vibopt.records import dataclass
from vibopt.report.figures.canvas import Box, Canvas, captions
from vibopt.report.figures.paper import BLUE, FAINT, INK, SIZE, WIDTH, drawn, dress
from vibopt.units import best_unit, to_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

VISIBLE, _ROUNDING = 1e-3, 1e-9
_KINDS = ((False, "force", "force"), (True, "couple", "moment"))
SMALL = SIZE - 1.5


def engine_figure(outcome: Answer[EngineJob], *, compact: bool) -> Figure | None:
    """The crankshaft; force and couple over one turn and by order; a couple that is nil is left out.

    A compact one has the crankshaft alone: what still shakes stands in a table beside it.
    """
    job = outcome.job
    if outcome.status in ("infeasible", "unbounded", "unproven"):
        return None
    after, before = shaken(outcome, job)
    kinds = [kind for kind in _KINDS if np.abs(after[int(kind[0])]).max() > _ROUNDING * size_of(job, kind[0])]
    rows = [_Shaking(after, before, *kind) for kind in kinds or _KINDS[:1]]
    key = [_BeforeAfter()] if before is not None else []
    crank = _crank(outcome, job, [row.word for row in rows], 0.6 if compact else MOST)
    return page([crank], "", COMPACT) if compact else page([crank, *rows, *key], job.title)


def shaken(outcome: Answer[EngineJob], job: EngineJob) -> tuple[ComplexArray, ComplexArray | None]:
    """Arms of all orders as balanced, and without what was chosen (None where no weight was)."""
    cranks = [0.0] * len(job.cranks)
    for k, cylinder in enumerate(job.cylinders, start=1):
        cranks[cylinder.throw] = _number(outcome, f"cylinders.{k}.crank")
    weights = [job.weights[k] for k in free_weights(job)]
    x: list[complex] = [_number(outcome, share.name) for share in free_shares(job)]
    x += [_unbalance(outcome, f"{weight.family}.{weight.name}") for weight in weights]
    found = arms(job, cranks)
    return found.at(np.array(x, dtype=complex)), found.at(np.zeros(len(x), dtype=complex)) if x else None


def _number(outcome: Answer[EngineJob], path: str) -> float:
    found = outcome.values.get(path)
    return found.value if isinstance(found, Entry) else 0.0


def _unbalance(outcome: Answer[EngineJob], path: str) -> complex:
    size, angle = _number(outcome, f"{path}.unbalance"), _number(outcome, f"{path}.angle")
    return complex(size * cos(angle), size * sin(angle))


@dataclass(frozen=True, slots=True)
class _Turning:
    """A weight that turns: its name, place [m], unbalance at crank angle zero, and how many times as fast, in words."""

    name: str
    at: float
    u: complex
    pace: str
    shown: str


@dataclass(frozen=True)
class _Crank:
    """The crankshaft from its end beside the words, and from the side.

    throws
        (place [m], crank angle [rad], name) of each cylinder; `carried`: whether weights opposite the cranks carry a
        share; `turning` weights on the shaft and on shafts beside it.
    """

    star: Disc
    banks: tuple[float, ...]
    throws: tuple[tuple[float, float, str], ...]
    carried: bool
    on_shaft: tuple[_Turning, ...]
    beside: tuple[_Turning, ...]
    lines: tuple[str, ...]
    radius: float

    @property
    def _row(self) -> Row:
        return rows_of([self.star], 2, WIDTH, self.radius)[0]

    @property
    def _side(self) -> float:
        return 1.75 + 0.55 * len(self.beside) if self._long else 0.0

    @property
    def _long(self) -> bool:
        return len({value for value, *_ in self.throws}) > 1 or bool(self.on_shaft or self.beside)

    @property
    def height(self) -> float:
        return self._row.height + self._side

    def draw(self, canvas: Canvas) -> None:
        row = self._row
        axes = canvas.part(
            Box(0.0, row.height, 0.5 * canvas.width), origin=(0.25 * canvas.width, row.radius + self.star.room[1])
        )
        cell = Cell(axes, self.star, row.radius)
        for bank in self.banks:
            (x, y), (u, v) = cell.at(bank, 0.0), cell.at(bank, 1.0)
            axes.plot([x, u], [y, v], color=FAINT, lw=1.0, ls=(0, (6, 2, 1, 2)), zorder=2)
        if self.carried:
            for angle in dict.fromkeys(round(value, 9) for _, value, _ in self.throws):
                _opposite(cell, angle)
        self.star.draw(cell)
        words = canvas.part(Box(0.5 * canvas.width, row.height, 0.5 * canvas.width), origin=(0.0, 0.5 * row.height))
        words.text(0.1, 0.0, "\n".join(self.lines), va="center", fontsize=SIZE, color=INK, linespacing=1.5)
        canvas.down(row.height)
        if self._long:
            self._draw_side(canvas)

    def _draw_side(self, canvas: Canvas) -> None:
        """Throws as seen from the side at crank angle zero, the shaft to scale along its length."""
        deep = 0.72 + 0.55 * len(self.beside)
        axes = canvas.part(Box(0.0, self._side, canvas.width), origin=(0.0, deep))
        places = [value for value, *_ in self.throws] + [one.at for one in (*self.on_shaft, *self.beside)]
        first, length = min(places), max(places) - min(places)

        def x(at: float) -> float:
            return 1.35 + (canvas.width - 2.1) * ((at - first) / length if length > 0.0 else 0.5)

        axes.text(0.05, 0.62, "From the side,\ncrank angle 0°", fontsize=SMALL, color=INK, va="center")
        ends = (1.05, canvas.width - 0.45)
        axes.plot(ends, [0.0, 0.0], color=INK, lw=2.5, zorder=2)
        for at, angle, _ in self.throws:
            _throw(axes, x(at), cos(angle), self.carried)
        names: dict[float, list[str]] = {}
        for at, _, name in self.throws:
            names.setdefault(x(at), []).append(name)
        labels = [(place, ", ".join(some)) for place, some in names.items()]
        captions(axes, labels, start=0.42, away=1.0, span=(1.0, canvas.width - 0.05), size=SMALL)
        for one in self.on_shaft:
            _weight(axes, x(one.at), 0.0, one.u)
        hung = [(x(one.at), one.name) for one in self.on_shaft]
        captions(axes, hung, start=-0.36, away=-1.0, span=(1.0, canvas.width - 0.05), size=SMALL)
        for k, one in enumerate(self.beside):
            y = -0.82 - 0.55 * k
            axes.plot(ends, [y, y], color=FAINT, lw=1.8, zorder=2)
            _weight(axes, x(one.at), y, one.u)
            axes.text(0.05, y, f"{one.name}\n{one.pace}", fontsize=SMALL - 0.5, color=INK, va="center")


def _opposite(cell: Cell, angle: float) -> None:
    """A counterweight opposite a crank: a sector."""
    around = [cell.at(one, 0.42) for one in np.linspace(angle + 0.72 * pi, angle + 1.28 * pi, 40)]
    cell.axes.fill(*zip((0.0, 0.0), *around, strict=True), fc="#d0d0d0", ec=INK, hatch="....", lw=0.8, zorder=2.2)


def _throw(axes: Any, x: float, up: float, carried: bool) -> None:
    """Two webs and a pin as high as the crank stands, and its counterweight on the other side."""
    y = 0.34 * up
    for web in (x - 0.11, x + 0.11):
        axes.plot([web, web], [0.0, y], color=INK, lw=2.0, zorder=3)
        if carried:
            axes.plot([web, web], [0.0, -0.7 * y], color=FAINT, lw=5.0, zorder=2.5, solid_capstyle="butt")
    axes.plot([x - 0.11, x + 0.11], [y, y], color=BLUE, lw=4.0, zorder=4, solid_capstyle="butt")


def _weight(axes: Any, x: float, y: float, u: complex) -> None:
    """An unbalance on a shaft, on the side where it stands; none where there is no weight."""
    if not u:
        return
    up = u.real / abs(u)
    axes.plot([x, x], [y, y + 0.2 * up], color=INK, lw=1.4, zorder=3)
    axes.plot([x], [y + 0.2 * up], marker="D", ms=7, mfc=FAINT, mec=INK, ls="", zorder=4)


def _crank(outcome: Answer[EngineJob], job: EngineJob, told: Sequence[str], radius: float) -> _Crank:
    throws = tuple(
        (cylinder.at, _number(outcome, f"cylinders.{k}.crank"), str(k))
        for k, cylinder in enumerate(job.cylinders, start=1)
    )
    weights = [_turning(outcome, job, k) for k in range(len(job.weights))]
    on_shaft = [k for k, weight in enumerate(job.weights) if weight.order == 1 and weight.sense == 1]
    own = [weights[k] for k in on_shaft]
    carried = any(
        (_number(outcome, share.name) if share.name in outcome.values else share.high) > 0.0 for share in job.shares
    )
    return _Crank(
        star=_star(throws, own),
        banks=tuple(dict.fromkeys(cylinder.bank for cylinder in job.cylinders)),
        throws=throws,
        carried=carried,
        on_shaft=tuple(own),
        beside=tuple(weight for k, weight in enumerate(weights) if k not in on_shaft),
        lines=tuple(_lines(outcome, job, weights, told)),
        radius=radius,
    )


def _turning(outcome: Answer[EngineJob], job: EngineJob, index: int) -> _Turning:
    weight = job.weights[index]
    path = f"{weight.family}.{weight.name}"
    chosen = f"{path}.unbalance" in outcome.values
    u = _unbalance(outcome, path) if chosen else weight.fixed or 0j
    shown = ""
    if chosen:
        said = (outcome.values[f"{path}.{key}"].shown for key in ("unbalance", "angle")) if u else ()
        shown = " at ".join(said).replace(" deg", "°") or "no weight"
    pace = "" if weight.order == 1 else f"{weight.order} times as fast"
    way = "against rotation" if weight.sense < 0 else ""
    return _Turning(drawn(weight.name, 14), weight.at, u, "\n".join(filter(None, (pace, way))), shown)


def _star(throws: Sequence[tuple[float, float, str]], weights: Sequence[_Turning]) -> Disc:
    """Cranks seen from the end, cylinders on one angle together, and the weights on the shaft."""
    at: dict[float, list[str]] = {}
    for _, angle, name in throws:
        at.setdefault(round(angle % tau, 9), []).append(name)
    spots = [Spot(angle, ", ".join(names), "pin") for angle, names in at.items()]
    spots += [Spot(float(np.angle(weight.u)), weight.name, "counter", 0.72) for weight in weights if weight.u]
    return Disc("Cranks from the end, by cylinder", 1, tuple(spots))


def _lines(outcome: Answer[EngineJob], job: EngineJob, weights: Sequence[_Turning], told: Sequence[str]) -> list[str]:
    """What the pictures do not show, in words."""
    count = len(job.cylinders)
    lines = [f"{counted(count, 'cylinders')}, crank 1 at the top\nwhen the angle is 0°"]
    if "firing.order" in outcome.values:
        even = "even" if outcome.values["firing.even"].value == "yes" else "not even"
        lines.append(f"firing order {outcome.values['firing.order'].shown} ({even})")
    if "counterweight_share" in outcome.values:
        lines.append(
            f"counterweights (dotted) carry {outcome.values['counterweight_share'].shown}\nof the reciprocating mass"
        )
    lines += [f"{weight.name}: {weight.shown}" for weight in weights if weight.shown]
    return lines + [f"no {word} is left" for _, word, _ in _KINDS if word not in told]


@dataclass(frozen=True)
class _Shaking:
    """Force or couple over a turn, and by order, side by side."""

    after: ComplexArray
    before: ComplexArray | None
    couple: bool
    word: str
    dimension: str
    height = 2.7

    def draw(self, canvas: Canvas) -> None:
        half = 0.5 * canvas.width
        self._over_turn(canvas.plot(Box(0.0, self.height, half), left=0.68, below=0.5))
        self._by_order(canvas.plot(Box(half, self.height, half), left=0.68, below=0.5))

    def _over_turn(self, axes: Any) -> None:
        turn: FloatArray = np.linspace(0.0, 2.0 * np.pi, 361)
        values = [np.abs(over_turn(one, self.couple, turn)) for one in (self.after, self.before) if one is not None]
        unit = best_unit(float(max(value.max() for value in values)), self.dimension)
        dress(axes, f"Size of the {self.word} over a turn", "crank angle [deg]", f"{self.word} [{unit}]")
        looks = ({"color": BLUE, "ls": "-", "lw": 1.8}, {"color": FAINT, "ls": "--", "lw": 1.4})
        for sizes, look in zip(values, looks, strict=False):
            axes.plot(np.degrees(turn), [to_unit(float(size), unit, self.dimension) for size in sizes], **look)
        axes.set_xticks(np.arange(0, 361, 60))
        axes.set_xlim(0.0, 360.0)
        axes.set_ylim(bottom=0.0)

    def _by_order(self, axes: Any) -> None:
        """Greatest of each order; orders too small to be seen are left out."""
        found = [one for one in (self.before, self.after) if one is not None]
        orders = [1, *range(2, self.after.shape[2], 2)]
        sizes = [[of_order(one, self.couple, order) for order in orders] for one in found]
        top = max(max(size) for size in sizes)
        kept = [k for k in range(len(orders)) if max(size[k] for size in sizes) > VISIBLE * top] or [0]
        unit = best_unit(top, self.dimension)
        dress(axes, "By order, greatest over a turn", "order (times crank speed)", f"{self.word} [{unit}]")
        place = np.arange(len(kept))
        for index, size in enumerate(sizes):
            look = AFTER if index == len(sizes) - 1 else BEFORE
            shift = 0.0 if len(sizes) == 1 else 0.4 * index - 0.2
            axes.bar(place + shift, [to_unit(size[k], unit, self.dimension) for k in kept], 0.38, zorder=3, **look)
        axes.set_xticks(place, [str(orders[k]) for k in kept])
        axes.set_xlim(-0.7, max(len(kept) - 0.3, 2.3))
        axes.grid(False, axis="x")


class _BeforeAfter:
    """The key below curves and bars."""

    height = 0.5

    def draw(self, canvas: Canvas) -> None:
        from matplotlib.lines import Line2D
        from matplotlib.patches import Patch

        handles = [
            (Line2D([], [], color=BLUE, lw=1.8), Patch(facecolor=BLUE, edgecolor=INK)),
            (Line2D([], [], color=FAINT, lw=1.4, ls="--"), Patch(facecolor="white", edgecolor=FAINT, hatch="////")),
        ]
        flat: list[Any] = [one for pair in handles for one in pair]
        words = ["as balanced", "as balanced", "without what was chosen", "without what was chosen"]
        y = 1.0 - (canvas.used + self.height) / canvas.height
        canvas.figure.legend(
            flat, words, loc="lower center", bbox_to_anchor=(0.5, y), ncols=2, fontsize=SIZE - 1, frameon=False
        )
