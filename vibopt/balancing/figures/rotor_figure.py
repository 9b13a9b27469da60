"""The plan of a measured rotor: discs with their weights, readings before and after, bars of what is left."""

from __future__ import annotations

from collections.abc import Sequence
from math import tau
from typing import TYPE_CHECKING

from vibopt.answer.answer import Answer
from vibopt.answer.entry import Entry
from vibopt.answer.plan import PlaneAnswer, RowAnswer, Weight
from vibopt.balancing.conventions import MARK, Conventions
from vibopt.balancing.figures.dials import Dial, Disc, Phasor, Row, Spot, rows_of
from vibopt.balancing.figures.drawing import COMPACT, Bar, Bars, Key, Part, Piece, Shaft, page
from vibopt.balancing.plan_values import shows_whole
from vibopt.balancing.planes import Plane
from vibopt.balancing.rotor_job import RotorJob
from vibopt.records import dataclass
from vibopt.report.figures.canvas import Canvas
from vibopt.report.figures.paper import WIDTH, drawn
from vibopt.units import to_unit
from vibopt.units.showing import show_angle

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_DIALS, MOST_BARS = 12, 8
CLOSE = 0.7
"""Radius of a circle where a page has to hold more [inches]."""
_NOTES = {"keep": "leave\nuntouched", "nothing": "no weight"}


def plan_figure(plan: Answer[RotorJob], *, compact: bool = False) -> Figure | None:
    """Discs of the planes (of every answer), dials of the sensors, bars of all readings (of the first answer).

    A compact one has no dials, and its bars beside the discs where there is room.
    """
    if not plan.plan.fittings:
        return None
    job = plan.job
    several = len(plan.plan.fittings) > 1
    discs = [
        disc(job.conventions, plane, answer, f", answer {number}" if several else "")
        for number, fitting in enumerate(plan.plan.fittings, start=1)
        for plane, answer in zip(job.planes, fitting.planes, strict=True)
    ]
    dials = _dials(job, plan.plan.rows) if job.has_phase and not compact else []
    dials = dials if len(dials) <= MOST_DIALS else []
    units = list(dict.fromkeys(row.residual.unit for row in plan.plan.rows))
    bars = [
        Bars(
            "" if k else "What will be left",
            unit,
            [_bar(row, job) for row in plan.plan.rows if row.residual.unit == unit],
        )
        for k, unit in enumerate(units)
    ]
    key = Key(
        _caption(job, bool(dials)),
        dials=True,
        limits=any(row.limit for row in plan.plan.rows),
        bands=any(row.band for row in plan.plan.rows),
        removed=any(plane.action == "remove" for plane in plan.plan.planes),
        fitted=any(plane.action == "add" for plane in plan.plan.planes),
        circles=bool(dials),
        whole=shows_whole(job),
    )
    parts = _compact(discs, bars) if compact else [*_shaft(job), *_circles(discs, dials), *bars]
    return page([*parts, key], *(("", COMPACT) if compact else (plan.title,)))


def _shaft(job: RotorJob) -> list[Shaft]:
    """Planes and sensors in their order: where they are is no part of a measurement."""
    if len(job.planes) + len(job.sensors) <= 2:
        return []
    planes, sensors = beside_each_other(len(job.planes), len(job.sensors))
    above = [Piece(at, titled("plane", plane.name), "plane") for at, plane in zip(planes, job.planes, strict=True)]
    below = [
        Piece(at, titled("sensor", sensor.name), "sensor") for at, sensor in zip(sensors, job.sensors, strict=True)
    ]
    note = "Planes (above) and sensors (below) in the order of the file; their places along the shaft are not to scale."
    return [Shaft(tuple(above), tuple(below), note)]


def beside_each_other(planes: int, sensors: int) -> tuple[list[float], list[float]]:
    """Places of planes and of sensors from 0 to 1, each evenly: where two would meet the sensor stands outside."""
    above = [(k + 0.5) / planes for k in range(planes)]
    gap = 0.25 / max(planes, sensors)
    below = []
    for at in ((k + 0.5) / sensors for k in range(sensors)):
        near = min(above, key=lambda value: abs(value - at))
        out = -1.0 if at < 0.5 else 1.0
        below.append(at if abs(near - at) >= gap else near + (gap if at > near or (at == near and out > 0) else -gap))
    return above, below


def _circles(discs: list[Disc], dials: list[Dial]) -> list[Row]:
    """Discs, then dials; all in a row where they are few."""
    if len(discs) + len(dials) <= 3:
        return rows_of([*discs, *dials], max(len(discs) + len(dials), 2), WIDTH)
    columns = 2 if max(len(discs), len(dials)) <= 4 else 3
    return rows_of(discs, columns, WIDTH) + rows_of(dials, columns, WIDTH)


@dataclass(frozen=True)
class _Beside:
    """A row of discs, and bars in what it leaves free."""

    row: Row
    bars: Bars
    discs: float

    @property
    def height(self) -> float:
        return max(self.row.height, self.bars.height)

    def draw(self, canvas: Canvas) -> None:
        self.row.within(canvas, 0.0, self.discs)
        self.bars.within(canvas, self.discs, canvas.width - self.discs)


def _compact(discs: list[Disc], bars: list[Bars]) -> list[Part]:
    """Discs closely; few bars beside them or below, many are in the table of the page."""
    few = sum(len(bar.bars) for bar in bars) <= MOST_BARS
    if few and len(bars) == 1 and len(discs) < 3:
        rows = rows_of(discs, len(discs), free := COMPACT * (0.4 if len(discs) == 1 else 0.7), CLOSE)
        if len(rows) == 1:
            return [_Beside(rows[0], bars[0], free)]
    return [*rows_of(discs, 3 if len(discs) <= 3 else 4, COMPACT, CLOSE), *(bars if few else ())]


def _caption(job: RotorJob, dials: bool) -> str:
    zero = job.conventions.zero
    words = (
        f"Drawn with the rotor turning counter-clockwise.  0° on the discs: {zero}; weights {job.conventions.angles}."
    )
    if shows_whole(job):
        words += "\nThe discs show whole weights, all others taken off: the trim stands in the plan."
    if not dials:
        return words
    if job.conventions.readings == MARK:
        return f"{words}\nReadings: positions of the stroboscope mark, counted {job.conventions.angles}."
    sense = "counter-clockwise" if job.conventions.reading_sense > 0 else "clockwise"
    return f"{words}\nReadings: phase {job.conventions.phase}, counted {sense}."


def disc(spoken: Conventions, plane: Plane, answer: PlaneAnswer, which: str = "") -> Disc:
    """A plane with what happens in it."""
    look = "away" if answer.action == "remove" else "fit"
    rim = max(plane.radii, default=0.0)
    spots = tuple(
        Spot(
            weight.angle % tau, _words(weight, answer.mass), look, weight.radius / rim if weight.radius and rim else 1.0
        )
        for weight in answer.weights
    )
    title = f"{titled('plane', answer.name)}{which}"
    return Disc(title, spoken.weight_sense, spots, plane.holes, plane.forbidden, _NOTES.get(answer.action, ""))


def _words(weight: Weight, mass: Entry) -> str:
    hole = "" if weight.hole is None else f"\nhole {weight.hole + 1}"
    angle = show_angle(weight.angle).replace(" deg", "°")
    return f"{Entry(weight.mass, mass.dimension, mass.unit).shown}{hole}\n{angle}"


def _dials(job: RotorJob, rows: Sequence[RowAnswer]) -> list[Dial]:
    """One dial a sensor, all its speeds on it."""
    mark = job.conventions.readings == MARK
    sense = job.conventions.weight_sense if mark else job.conventions.reading_sense
    return [
        Dial(
            f"{titled('sensor', sensor.name)} [{sensor.shown_unit}]",
            sense,
            tuple(_phasor(job, row) for row in rows if row.sensor == sensor.name),
        )
        for sensor in job.sensors
    ]


def _phasor(job: RotorJob, row_answer: RowAnswer) -> Phasor:
    angle = job.conventions.reading_angle
    before, after = (
        (number(row_answer.found) or 0.0, angle(row_answer.y0)),
        (number(row_answer.residual) or 0.0, angle(row_answer.left)),
    )
    return Phasor(row_answer.speed.shown, before, after, number(row_answer.limit), _band(row_answer))


def _band(row_answer: RowAnswer) -> tuple[float, float] | None:
    return None if row_answer.band is None else (number(row_answer.band[0]) or 0.0, number(row_answer.band[1]) or 0.0)


def _bar(row_answer: RowAnswer, job: RotorJob) -> Bar:
    name = f"{row_answer.sensor}\n{row_answer.speed.shown}" if len(job.speeds) > 1 else row_answer.sensor
    return Bar(name, number(row_answer.found), number(row_answer.residual), number(row_answer.limit), _band(row_answer))


def titled(noun: str, name: str) -> str:
    """A name with what it is, unless it says so itself: "Plane left", "plane_1"."""
    short = drawn(name, 24)
    return short if short.lower().startswith(noun) else f"{noun.capitalize()} {short}"


def number(entry: Entry | None) -> float | None:
    """In the user's unit; None without a value."""
    if entry is None or isinstance(entry.value, str):
        return None
    return to_unit(entry.value, entry.unit, entry.dimension)
