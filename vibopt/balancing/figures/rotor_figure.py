"""The plan of a measured rotor: discs with their weights, readings before and after, bars of what is left."""

from __future__ import annotations

from collections.abc import Sequence
from math import tau
from typing import TYPE_CHECKING, Any

from vibopt.answer.answer import Answer
from vibopt.answer.entry import Entry
from vibopt.answer.plan import PlaneAnswer, RowAnswer, Weight
from vibopt.balancing.conventions import MARK, Conventions
from vibopt.balancing.figures.drawing import (
    Bar,
    Dial,
    Disc,
    Phasor,
    Spot,
    bars,
    draw_dial,
    draw_disc,
    height,
    key,
    pad_more,
)
from vibopt.balancing.plan_values import shows_whole
from vibopt.balancing.planes import Plane
from vibopt.balancing.rotor_job import RotorJob
from vibopt.report.figures.paper import INK, SIZE, WIDTH, sheet
from vibopt.units import to_unit
from vibopt.units.showing import show_angle

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_DIALS, MOST_BARS = 12, 8
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
    units = list(dict.fromkeys(one.residual.unit for one in plan.plan.rows))
    groups = [[one for one in plan.plan.rows if one.residual.unit == unit] for unit in units]
    figure = _compact(discs, groups, job) if compact else _whole(discs, dials, groups, job)
    if not compact:
        figure.suptitle(plan.title, fontsize=SIZE + 3, color=INK, fontweight="bold")
    key(
        figure,
        _caption(job, bool(dials)),
        dials=True,
        limits=any(one.limit for one in plan.plan.rows),
        bands=any(one.band for one in plan.plan.rows),
        removed=any(one.action == "remove" for one in plan.plan.planes),
        fitted=any(one.action == "add" for one in plan.plan.planes),
        circles=bool(dials),
        whole=shows_whole(job),
    )
    return figure


def _whole(discs: list[Disc], dials: list[Dial], groups: list[list[RowAnswer]], job: RotorJob) -> Figure:
    columns = 2 if max(len(discs), len(dials)) <= 4 else 3
    first = -(-len(discs) // columns)
    count = first + -(-len(dials) // columns)
    tall = [height(len(one)) for one in groups]
    each = 0.94 * WIDTH / columns
    figure = sheet(WIDTH, each * count + sum(tall) + 0.9)
    pad_more(figure)
    grid = figure.add_gridspec(count + len(groups), columns, height_ratios=[each] * count + tall)
    for k, one in enumerate(discs):
        draw_disc(figure, grid[divmod(k, columns)], one, WIDTH / columns)
    for k, dial in enumerate(dials):
        row, column = divmod(k, columns)
        draw_dial(figure, grid[first + row, column], dial)
    for index, rows in enumerate(groups):
        _draw_bars(figure.add_subplot(grid[count + index, :]), index, rows, job)
    return figure


def _compact(discs: list[Disc], groups: list[list[RowAnswer]], job: RotorJob) -> Figure:
    columns = 3 if len(discs) <= 3 else 4
    count = -(-len(discs) // columns)
    beside = len(groups) == 1 and len(discs) % columns and len(groups[0]) <= MOST_BARS
    below = [] if beside or sum(map(len, groups)) > MOST_BARS else groups  # the page has them in its table
    tall = [height(len(one)) for one in below]
    each = 1.06 * WIDTH / columns
    figure = sheet(WIDTH, each * count + sum(tall) + 0.7)
    pad_more(figure)
    grid = figure.add_gridspec(count + len(below), columns, height_ratios=[each] * count + tall)
    for k, one in enumerate(discs):
        draw_disc(figure, grid[divmod(k, columns)], one, WIDTH / columns)
    if beside:
        _draw_bars(figure.add_subplot(grid[count - 1, len(discs) % columns :]), 0, groups[0], job)
    for index, rows in enumerate(below):
        _draw_bars(figure.add_subplot(grid[count + index, :]), index, rows, job)
    return figure


def _draw_bars(axes: Any, index: int, rows: list[RowAnswer], job: RotorJob) -> None:
    bars(axes, "" if index else "What will be left", rows[0].residual.unit, [_bar(one, job) for one in rows])


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
    spots = tuple(
        Spot(one.angle % tau, _words(one, answer.mass), look, _part(one.radius, plane)) for one in answer.weights
    )
    title = f"Plane {answer.name}{which}"
    return Disc(title, spoken.weight_sense, spots, plane.holes, plane.forbidden, _NOTES.get(answer.action, ""))


def _part(radius: float | None, plane: Plane) -> float:
    return radius / max(plane.radii) if radius is not None and plane.radii else 1.0


def _words(one: Weight, mass: Entry) -> str:
    hole = "" if one.hole is None else f", hole {one.hole + 1}"
    angle = show_angle(one.angle).replace(" deg", "°")
    return f"{Entry(one.mass, mass.dimension, mass.unit).shown}{hole}\n{angle}"


def _dials(job: RotorJob, rows: Sequence[RowAnswer]) -> list[Dial]:
    """One dial a sensor, all its speeds on it."""
    mark = job.conventions.readings == MARK
    sense = job.conventions.weight_sense if mark else job.conventions.reading_sense
    return [
        Dial(
            f"Sensor {sensor.name}",
            sensor.shown_unit,
            sense,
            tuple(_phasor(job, one) for one in rows if one.sensor == sensor.name),
        )
        for sensor in job.sensors
    ]


def _phasor(job: RotorJob, one: RowAnswer) -> Phasor:
    angle = job.conventions.reading_angle
    return Phasor(
        one.speed.shown,
        (number(one.found) or 0.0, angle(one.y0)),
        (number(one.residual) or 0.0, angle(one.left)),
        number(one.limit),
        None if one.band is None else (number(one.band[0]) or 0.0, number(one.band[1]) or 0.0),
    )


def _bar(one: RowAnswer, job: RotorJob) -> Bar:
    name = f"{one.sensor}\n{one.speed.shown}" if len(job.speeds) > 1 else one.sensor
    band = None if one.band is None else (number(one.band[0]) or 0.0, number(one.band[1]) or 0.0)
    return Bar(name, number(one.found), number(one.residual), number(one.limit), band)


def number(entry: Entry | None) -> float | None:
    """In the user's unit; None without a value."""
    if entry is None or isinstance(entry.value, str):
        return None
    return to_unit(entry.value, entry.unit, entry.dimension)
