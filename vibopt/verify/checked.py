"""Rows of an answer: every limit and measure on the machine as built, with texts in the user's units."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import inf, isfinite

import numpy as np

from vibopt.answer.entry import ROUTES, TOLERANCE, Checked, Chosen, Entry
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import Model
from vibopt.records import cached_property, dataclass
from vibopt.responses import HarmonicResponse, Response
from vibopt.scene.assemble import model_of
from vibopt.scene.check_bearings import in_planes
from vibopt.scene.check_spin import turning
from vibopt.scene.drives import highest_asked, unit_lines
from vibopt.scene.places import place_of
from vibopt.scene.scene import MINIMISE, Goal, Scene, Variable
from vibopt.units import si_unit
from vibopt.units.spelling import split_detector
from vibopt.values import SpeedRange
from vibopt.verify.as_built import differing, machine_of
from vibopt.verify.beyond import beyond_shape, beyond_threshold
from vibopt.verify.certify import Measured, measure_on
from vibopt.verify.rated import rated_rows
from vibopt.verify.routes import LOADS, Modelled, rated_loads


def shown_value(response: Response, value: float, unit: str) -> Entry:
    """A response's value in the user's unit."""
    return Entry(value, response.dimension, unit, amplitude=response.amplitude)


Offs = Mapping[str, Sequence[Mapping[str, float]]]
"""Per row of an answer the machines on which it is measured: factors of the numbers that are off, by path."""


def limit_rows(scene: Scene) -> dict[str, tuple[str, str]]:
    """Name and side of every row of the limits, by its key; a limit with two bounds has two rows."""
    rows = {}
    for name, response in scene.limits.items():
        sides = [side for side in ("at_most", "at_least", "outside") if getattr(response, side, None) is not None]
        for side in sides:
            rows[name if side == sides[0] else f"{name} ({side})"] = name, side
    return rows


def checked_limits(
    scene: Scene, chosen: Mapping[str, float], offs: Offs | None = None, model: Model | None = None
) -> dict[str, Checked]:
    """Every limit on the built machine, or on the worst of several, compared with the model (that of the scene)."""
    return Built(scene, chosen, model).limits(offs or {})


def checked_measures(
    scene: Scene, chosen: Mapping[str, float], offs: Offs | None = None, model: Model | None = None
) -> dict[str, Checked]:
    """Every measure on the built machine, or on the worst of several, compared with the model (that of the scene)."""
    return Built(scene, chosen, model).measures(offs or {})


def measured_row(scene: Scene, machine: Machine, name: str, response: Response) -> Checked:
    """A measure on a machine that is built already; the model is not asked."""
    measured = measure_on(scene, machine, response, response.worst_side)
    return _checked(scene, measured, name, response, "")


def _load_compared(row: Checked, parts: Sequence[float]) -> Checked:
    """A row of a rated load beside what the model says of each mount, as parts of the rating."""
    assert row.limit is not None
    other = (max(parts) if row.side == "at_most" else min(parts)) * row.limit.value
    if row.value.value == other or abs(row.value.value - other) <= LOADS * abs(row.limit.value):
        return row
    words = f"{row.name} ({row.response} {row.place}) is {other:.9g} N in the model"
    return replace(row, doubt=f"{words}, {row.value.value:.9g} N on the machine as built")


@dataclass(frozen=True)
class Built:
    """A machine with its numbers off by `scene.off`, by both routes; without `given` the model is that of the scene."""

    scene: Scene
    chosen: Mapping[str, float]
    given: Model | None = None

    @cached_property
    def machine(self) -> Machine:
        return machine_of(self.scene, self.chosen)

    @cached_property
    def modelled(self) -> Modelled:
        """The same in the model."""
        x = np.array([self.chosen[variable.path] for variable in self.scene.variables])
        return Modelled(self.scene, self.given or model_of(self.scene), x)

    @cached_property
    def _others(self) -> dict[tuple[tuple[str, float], ...], Built]:
        return {}

    def other(self, off: Mapping[str, float]) -> Built:
        """The same, off by other factors: one for all rows, which keeps the motions that it was asked for."""
        return self._others.setdefault(tuple(sorted(off.items())), Built(replace(self.scene, off=off), self.chosen))

    def limits(self, offs: Offs) -> dict[str, Checked]:
        """Every limit, and what bought parts are rated for; each on the worst of several machines where there are."""
        limits = self.scene.limits
        rows = {
            key: _worst_of(self, offs.get(key, ()), name, limits[name], side)
            for key, (name, side) in limit_rows(self.scene).items()
        }
        return rows | self._rated(offs)

    def measures(self, offs: Offs) -> dict[str, Checked]:
        """Every measure, each on the worst of several machines where there are."""
        return {
            name: _worst_of(self, offs.get(name, ()), name, measure, "")
            for name, measure in self.scene.measures.items()
        }

    @property
    def goal(self) -> Checked | None:
        """The goal."""
        goal = self.scene.goal
        if goal is None:
            return None
        if goal.response.of_limits:
            return _least_margin(goal, self.limits({}))
        measured = measure_on(
            self.scene, self.machine, goal.response, "at_most" if goal.sense == MINIMISE else "at_least"
        )
        return self.compared(_checked(self.scene, measured, goal.name, goal.response, ""), measured)

    def _rated(self, offs: Offs) -> dict[str, Checked]:
        """Static loads of bought parts, each on the worst of several machines."""
        scene, chosen = self.scene, self.chosen
        rows = rated_rows(scene, chosen, self.machine)
        if rows:
            loads = rated_loads(self.modelled.full, self.modelled.x)
            rows = {key: _load_compared(row, loads[row.name, row.side]) for key, row in rows.items()}
        for key in rows:
            for off in offs.get(key, ()):
                other = replace(scene, off=off)
                row = rated_rows(other, chosen, machine_of(other, chosen))[key]
                if rows[key].margin - row.margin > TOLERANCE:
                    rows[key] = replace(row, off=differing(scene, off))
        return rows

    def row(self, name: str, response: Response, side: str) -> tuple[Checked, Measured]:
        response = response.asked_by(side)
        measured = measure_on(self.scene, self.machine, response, side or response.worst_side)
        row = _checked(self.scene, measured, name, response, side)
        if measured.value == inf:
            far = response.looked_to(self.machine)
            text = f"none up to {replace(row.value, value=far).shown}" if isfinite(far) else response.absent
            row = replace(row, value=replace(row.value, text=text)) if text else row
        return row, measured

    @cached_property
    def _may_grow(self) -> bool:
        return bool(turning(self.scene) or in_planes(self.scene))

    @cached_property
    def _has_beams(self) -> bool:
        return any(link.spreads_mass for link in self.scene.links.values())

    def _grown(self, measured: Measured) -> str:
        """Why there is no steady motion, as a whirl grows; "" where there is."""
        driven = measured.response.reading or measured.response
        if not isinstance(driven, HarmonicResponse):
            return ""
        return beyond_threshold(self.scene, self.machine, driven, self.threshold)

    def _beyond(self, row: Checked, measured: Measured) -> str:
        """Why a value is beyond what the model of a part is good for; "" where it is not."""
        known = {name: speed for name, speed in measured.speeds.items() if measured.response.sort == "steady"}
        lines = {name: unit_lines(self.scene, name) for name in known}
        highest = [speed * max(line.order for line in lines[name]) for name, speed in known.items()]
        return beyond_shape(self.machine, measured.response, row.limit, measured.value, max([0.0, *highest]))

    @cached_property
    def threshold(self) -> float:
        """The spin beyond which a whirl grows [rad/s]; where planes differ, up to the highest speed, by both routes."""
        if not in_planes(self.scene):
            return self.machine.threshold()
        from vibopt.forms import WhirlThreshold

        top = highest_asked(self.scene) * (1.0 + 1e-6)
        return min(self.machine.threshold(top), WhirlThreshold(top).value(self.modelled.full, self.modelled.x))

    def compared(self, row: Checked, measured: Measured) -> Checked:
        """The row, with what the model says of it where that is another number."""
        differs, own = self.modelled.differs(measured.response, measured), None
        if not differs and (own := self.modelled.elsewhere(measured.response, measured)) is None:
            if self._may_grow and (grown := self._grown(measured)):
                none = replace(row.value, value=-inf if measured.response.complement else inf, text="not known")
                return replace(row, unsteady=f"{row.name} {grown}", value=none, margin=-inf, worst_at={})
            row = self._as_kept(row, measured)
            beyond = self._beyond(row, measured) if self._has_beams else ""
            return replace(row, unknown=f"{row.name} {beyond}") if beyond else row
        value = self.modelled.at(measured.response, measured)[0] if own is None else own.value
        one, other = _told_apart(measured.response, value, measured.value)
        what = f"{row.name} ({row.response} {row.place}".rstrip() + ")"
        at = self._where(measured.response, measured.speeds)
        if own is None:
            lost = math.isnan(measured.value)
            if lost:
                row = replace(row, value=replace(row.value, text="not known"), margin=-inf, open=True)
            there = "and nothing was found" if lost else other
            words = f"{what} is {one} in the model, {there} on the machine as built"
            return replace(row, doubt=f"{words}, at {at}" if at else words)
        there = self._where(measured.response, own.speeds)
        words = f"{what} is {'least' if measured.least else 'greatest'} in the model with {one} at {there}"
        return replace(row, doubt=f"{words}, on the machine as built with {other} at {at}")

    def _as_kept(self, row: Checked, measured: Measured) -> Checked:
        """The row as met where the model keeps its limit, and both routes differ by the rest alone."""
        if row.met or row.margin < -ROUTES:
            return row
        value = self.modelled.at(measured.response, measured)[0]
        own = _checked(self.scene, replace(measured, value=value), row.name, measured.response, row.side)
        return replace(row, slack=-row.margin) if own.met else row

    def _where(self, response: Response, speeds: Mapping[str, float]) -> str:
        """Speeds of excitations in words."""
        each = {name: _speed(self.scene, name, speed, response) for name, speed in speeds.items()}
        return ", ".join(f"{entry.shown} of {name}" for name, entry in each.items())


def _told_apart(response: Response, *values: float) -> tuple[str, str]:
    """Two values in words, with the digits that they differ by."""
    digits = next((n for n in (6, 9, 12) if f"{values[0]:.{n}g}" != f"{values[1]:.{n}g}"), 17)
    one, other = (f"{value:.{digits}g} {si_unit(response.dimension)}".rstrip() for value in values)
    return one, other


def _least_margin(goal: Goal, rows: Mapping[str, Checked]) -> Checked:
    """What the limits that a goal is read off have left over at least, and where."""
    least = min((row for row in rows.values() if goal.response.speaks_for(row.name)), key=lambda row: row.margin)
    shown = shown_value(goal.response, least.margin, goal.response.unit or goal.response.unit_without)
    return Checked(goal.name, goal.name, goal.response.said_of, "", shown, worst_at=least.worst_at)


def _worst_of(built: Built, offs: Sequence[Mapping[str, float]], name: str, response: Response, side: str) -> Checked:
    """The row of the machine, among those that are off, on which it is worst; the first among equals."""
    if not offs:
        return built.compared(*built.row(name, response, side))
    sign = -1.0 if (side or response.worst_side) == "at_least" else 1.0
    rows = []
    for off in offs:
        machine = built.other(off)
        row, measured = machine.row(name, response, side)
        rows.append((replace(row, off=differing(built.scene, off)), measured, machine))
    worst = rows[0]
    for one in rows[1:]:
        better, row = worst[0], one[0]
        worse = better.margin - row.margin if side else sign * (row.value.value - better.value.value) / _size(better)
        worst = one if worse > TOLERANCE else worst
    return worst[2].compared(*worst[:2])


def _size(row: Checked) -> float:
    return abs(row.value.value) or 1.0


def _checked(scene: Scene, measured: Measured, name: str, response: Response, side: str) -> Checked:
    given = getattr(response, side) if side else None
    unit = response.unit or getattr(given, "unit", "") or usual_unit(scene, response)
    margin = 0.0
    limit = None
    if side == "outside":
        assert isinstance(given, SpeedRange)
        band = min(given.bands, key=lambda one: -min(measured.value - one.low, one.high - measured.value))
        depth = min(measured.value - band.low, band.high - measured.value)
        edge = band.low if measured.value - band.low <= band.high - measured.value else band.high
        margin = -depth / edge if edge else math.copysign(inf, -depth)  # at rest: of nothing there is no part
        ends = [shown_value(response, value, unit).shown for value in (band.low, band.high)]
        first, _, same = ends[0].rpartition(" ")
        text = f"{first}..{ends[1]}" if ends[1].endswith(f" {same}") else "..".join(ends)
        limit = replace(shown_value(response, edge, unit), text=text)
    elif given is not None:
        size = abs(1.0 - given.value if response.complement else given.value) or 1.0
        margin = (given.value - measured.value) / size if side == "at_most" else (measured.value - given.value) / size
        limit = shown_value(response, given.value, unit)
    return Checked(
        name=name,
        response=response.response,
        place=place_of(response),
        side=side,
        value=shown_value(response, measured.value, unit),
        limit=limit,
        margin=float(margin) if isfinite(margin) else float("-inf") if margin < 0 else float("inf"),
        worst_at={key: _speed(scene, key, speed, measured.response) for key, speed in measured.speeds.items()},
    )


def _speed(scene: Scene, name: str, omega: float, response: Response) -> Entry:
    excitation = scene.excitations[name]
    if excitation.once is not None and response.sort == "transient":
        return Entry(omega, "time", "")
    dimension = excitation.speed.dimension
    at = Entry(excitation.from_rotation(omega), dimension, excitation.speed.unit)
    place = response.placed.get(name)
    return at if place is None else replace(at, text=f"{at.shown}, all of it on {place}")


def goal_of(scene: Scene, chosen: Mapping[str, float]) -> tuple[str, Entry] | None:
    """The goal's name and its value on the built machine."""
    row = goal_row(scene, chosen)
    return None if row is None else (row.name, row.value)


def goal_row(scene: Scene, chosen: Mapping[str, float], model: Model | None = None) -> Checked | None:
    """The goal on the built machine, compared with the model (that of the scene)."""
    return Built(scene, chosen, model).goal


def chosen_of(variable: Variable, value: float) -> Chosen:
    """A chosen value with its text, and the end of its range on which it rests."""
    at = ""
    if variable.values is None:
        if value <= variable.low * (1 + 1e-9):
            at = "from"
        elif value >= variable.high * (1 - 1e-9):
            at = "to"
    return Chosen(Entry(value, variable.dimension, variable.unit), at)


def disagreement(*families: Mapping[str, Checked], besides: Sequence[str] = ()) -> str:
    """That the two routes to some number do not agree, or that one is not known, in words; "" where all are as said."""
    rows = [row for family in families for row in family.values()]
    doubts = [*(row.doubt for row in rows if row.doubt), *besides]
    if doubts:
        return f"the two routes to an answer do not agree: {'; '.join(dict.fromkeys(doubts))}"
    return "; ".join(filter(None, dict.fromkeys([*(row.unknown for row in rows), unsteady(*families)])))


def unsteady(*families: Mapping[str, Checked]) -> str:
    """That a whirl grows, where some number is one of a steady motion, in words, once; "" where none does."""
    names: dict[str, dict[str, str]] = {}
    for row in (row for family in families for row in family.values() if row.unsteady):
        said = names.setdefault(row.unsteady.removeprefix(row.name), {})
        said.setdefault(row.name, f"nor is {row.name}" if said else row.unsteady)
    return "; ".join(words for said in names.values() for words in said.values())


def in_usual_unit(scene: Scene, response: Response, value: float) -> Entry:
    """A value [SI] as answers show it: in the user's unit for it, or in the one in which the file speaks of it."""
    return shown_value(response, value, response.unit or usual_unit(scene, response))


def usual_unit(scene: Scene, response: Response) -> str:
    """The unit in which the file speaks of the same quantity, else that of its kind or "" (chosen by size).

    Without pp or rms where several harmonics add up in another way.
    """
    path = f".{getattr(response, 'of', None)}.{response.response}"
    if response.response == "price":
        bought = [*(link.part for link in scene.links.values()), *(mount.part for mount in scene.mounts.values())]
        return next((part.price.unit for part in bought if part is not None and part.price is not None), "")
    for variable in scene.variables:
        if variable.path.endswith(path):
            return variable.unit
    for limit in scene.limits.values():
        if limit.response == response.response:
            for given in (limit.at_most, limit.at_least, getattr(limit, "outside", None)):
                if given is not None:
                    unit, detector, _ = split_detector(given.unit)
                    combine = getattr(response, "combine", None)
                    fits = combine is None or {"pp": "sum", "rms": "rss"}.get(str(detector), combine) == combine
                    return str(given.unit) if fits else unit
    return response.unit_without
