"""A design in time beside what any isolator could reach: words, data, and acceleration against rattle space."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.answer.blocks import TEXT, Block, spoken
from vibopt.answer.entry import Entry
from vibopt.mechanics.built import GROUND
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import Model
from vibopt.program.pose import form_of
from vibopt.records import dataclass
from vibopt.report.what_to_build import machine_in
from vibopt.responses import TransientResponse
from vibopt.scene.assemble import model_of
from vibopt.scene.drives import names_for
from vibopt.scene.places import place_of
from vibopt.scene.scene import MINIMISE, Design
from vibopt.scene.uncertain import uncertain
from vibopt.units import best_unit, outward, plain, show, to_unit

if TYPE_CHECKING:
    from vibopt.mechanics.limiting import Between, Path
    from vibopt.report.series import Panel

TITLE = "Beside any isolator"
_SAME, _DIGITS = 1e-3, 4
"""Part by which a design that is as good as any may be above the least; digits of the least."""
_POINTS, _CLOSE, _SPAN = 24, 5e-3, (0.3, 2.2)
"""Points of the limiting curve, how near they are known, and its span in rooms of the design."""


@dataclass(frozen=True, slots=True)
class _Asked:
    """A response in time, of a limit, a measure or the goal, and its value on the design [SI]."""

    where: str
    response: TransientResponse
    value: float
    bound: float | None
    unit: str

    @property
    def what(self) -> str:
        return spoken(self.response.response, place_of(self.response))

    def shown(self, value: float) -> str:
        return show(value, self.unit, self.response.dimension)


@dataclass(frozen=True, slots=True)
class Limiting:
    """A peak and a room that belong together, and what any isolator could reach.

    peak, room
        Acceleration or force of the mass, and how far it moves from its support.
    per
        The peak for an acceleration of one [kg, or 1].
    judged
        Which of the two is compared; the other one is held at `given`.
    least
        Of the one that is compared [SI].
    """

    peak: _Asked
    room: _Asked
    path: Path
    per: float
    judged: _Asked
    given: float
    least: Between

    @property
    def words(self) -> str:
        """ "peak acceleration of instrument: 1.31 times the least that any isolator ... (4.02 to 4.03 m/s²)"."""
        asked, other = self.judged, self.room if self.judged is self.peak else self.peak
        times = asked.value / self.least.high
        much = "as little as" if times < 1.0 + _SAME else f"{plain(times, 3)} times the least that"
        within = f"in {other.shown(self.given)}" if other is self.room else f"with {other.shown(self.given)}"
        unit = asked.unit or best_unit(self.least.high, asked.response.dimension)
        low, high = (
            plain(outward(to_unit(value, unit, asked.response.dimension), side, _DIGITS))
            for value, side in ((self.least.low, "at_least"), (self.least.high, "at_most"))
        )
        return (
            f"{asked.what}: {much} any isolator, passive or active, could reach {within} "
            f"({low if low == high else f'{low} to {high}'} {unit}, proven)"
        )

    def to_json(self) -> dict[str, Any]:
        asked, other = self.judged, self.room if self.judged is self.peak else self.peak
        kind = asked.response.dimension
        return {
            "of": asked.where,
            "times": asked.value / self.least.high,
            "least": [Entry(end, kind, asked.unit).to_json() for end in (self.least.low, self.least.high)],
            "within": {"of": other.where, **Entry(self.given, other.response.dimension, other.unit).to_json()},
            "words": self.words,
        }


def limiting(design: Design) -> list[Limiting]:
    """What of a design can be compared so: a peak of one mass and a room in which it moves, under the same load.

    Nothing where a pulse may have any duration, where the speed runs up, where what begins goes on for ever, in space,
    and for forces of a machine of several masses or of a mass that may be off: no single history is the least there.
    """
    known = vars(design)
    if "limiting" not in known:
        known["limiting"] = list(_compared(design))
    found: list[Limiting] = known["limiting"]
    return found


def limiting_block(design: Design) -> Block:
    """One line for each."""
    return Block(TITLE, TEXT, tuple(one.words for one in limiting(design)))


def _compared(design: Design) -> Iterator[Limiting]:
    machine = machine_in(design)
    asked = list(_in_time(design)) if machine is not None and design.found is None else []
    rooms = [one for one in asked if one.response.response in ("peak_relative_displacement", "peak_displacement")]
    peaks = [one for one in asked if one.response.response in ("peak_acceleration", "peak_force")]
    if machine is None or machine.in_space or not rooms or not peaks:
        return
    model, told = model_of(design.scene), set[tuple[str, bytes]]()
    for peak in peaks:  # the force of a mass that only its base moves says what its acceleration said
        for room in sorted(rooms, key=lambda one: one.bound or np.inf):
            support = _support(design, model, machine, peak, room)
            path = _path(design, model, peak, room, support, machine) if support is not None else None
            if path is None or not 0.0 < room.value < np.inf or not 0.0 < peak.value < np.inf:
                continue
            key = room.where, path[0].mix.tobytes()
            found = _judged(peak, room, *path) if key not in told else None
            told.add(key)
            if found is not None:
                yield found
            break


def _judged(peak: _Asked, room: _Asked, path: Path, per: float) -> Limiting | None:
    """Where the room has a bound, the peak is compared in it, or in what it takes more; else the room for a peak."""
    from vibopt.mechanics.limiting import least_peak, least_room

    turned = room.bound is None and peak.bound is not None
    held = peak if turned else room
    given = held.value if held.bound is None else max(held.bound, held.value)
    least = least_room(path, given / per) if turned else _scaled(least_peak(path, given), per)
    if least is None or least.high <= 0.0:
        return None
    return Limiting(peak, room, path, per, room if turned else peak, given, least)


def _scaled(found: Between | None, per: float) -> Between | None:
    return None if found is None else replace(found, low=found.low * per, high=found.high * per)


def _in_time(design: Design) -> Iterator[_Asked]:
    """The goal, limits and measures in time, as far as each is one peak."""
    scene = design.scene
    if scene.goal is not None and design.goal is not None and scene.goal.sense == MINIMISE:
        response, value = scene.goal.response, design.goal[1]
        if isinstance(response, TransientResponse) and response.combine is None:
            yield _Asked("goal", response, value.value, None, value.unit)
    for family, given, rows in (
        ("limits", scene.limits, design.limits),
        ("measures", scene.measures, design.measures),
    ):
        for name, one in given.items():
            if isinstance(one, TransientResponse) and one.combine is None and name in rows:
                bound = one.at_most.value if one.at_most is not None else None
                yield _Asked(f"{family}.{name}", one, rows[name].value.value, bound, rows[name].value.unit)


def _support(design: Design, model: Model, machine: Machine, peak: _Asked, room: _Asked) -> tuple[str, str] | None:
    """The mass and what it moves away from, where peak and room speak of the same two."""
    fixed = {GROUND, *design.scene.bases}
    link = getattr(room.response, "across", None)
    ends = set(model.ends[link]) if link is not None else {room.response.of, GROUND}  # type: ignore[attr-defined]
    held = ends & fixed
    if len(ends) != 2 or len(held) != 1:
        return None
    [support], [body] = held, ends - held
    if peak.response.response == "peak_acceleration":
        return (body, support) if peak.response.of == body else None  # type: ignore[attr-defined]
    heavy = [name for name, mass in machine.masses.items() if mass > 0.0]
    between = all(not set(joint.ends) & fixed or set(joint.ends) & fixed == held for joint in machine.joints)
    doubtful = any(one.path.startswith("bodies.") for one in uncertain(design.scene))
    into, through = getattr(peak.response, "into", None), getattr(peak.response, "through", None)
    alone = into == support or (into == body and len(machine.masses) == 1)
    alone = (alone or (through is not None and len(machine.joints) == 1)) and not machine.on_structures
    return (body, support) if heavy == [body] and between and alone and not doubtful else None


def _path(
    design: Design, model: Model, peak: _Asked, room: _Asked, ends: tuple[str, str], machine: Machine
) -> tuple[Path, float] | None:
    """What pushes the mass away from its support, as a path; and the peak for an acceleration of one."""
    from vibopt.mechanics.limiting import Path

    names = [set(names_for(design.scene, asked.response)) for asked in (peak, room)]
    form = form_of(design.scene, model, peak.response).in_time
    if names[0] != names[1] or form is None or form.segments[-1].endless:
        return None
    body, support = ends
    n, forced, segments = model.n_free, peak.response.response == "peak_force", form.segments
    own, released = model.points[body][:n], segments[0].released
    moved = np.zeros(form.loads.shape[1]) if support == GROUND else model.points[support][n:] @ form.loads[n:]
    per = 1.0
    if forced:
        if (form.loads[:n][own == 0.0] != 0.0).any():
            return None
        per = machine.masses[body]
        moved = moved - own @ form.loads[:n] / per
        if getattr(peak.response, "through", None) is not None:
            per /= machine.joints[0].count
    if released is not None:
        if released[:, 0].any():  # a place to begin with is no motion of a support
            return None
        moved = np.where(released[:, 1] == 0.0, moved, -own @ form.loads[:n])
        segments = (replace(segments[0], blows=segments[0].blows + released[:, 1], released=None), *segments[1:])
    return (Path(moved, segments), per) if moved.any() else None


def limiting_panels(design: Design) -> list[Panel]:
    """The least peak that any isolator could reach against the room, and where the design is."""
    return [_panel(one) for one in limiting(design)]


def _panel(one: Limiting) -> Panel:
    from vibopt.mechanics.limiting import least_peak
    from vibopt.report.series import Mark, Panel, Zone, known_curve

    kinds = one.room.response.dimension, one.peak.response.dimension
    units = tuple(
        asked.unit or best_unit(asked.bound or asked.value, kind)
        for asked, kind in zip((one.room, one.peak), kinds, strict=True)
    )
    per_x, per_y = (to_unit(1.0, unit, kind) for unit, kind in zip(units, kinds, strict=True))
    middle = max(one.room.value, one.room.bound or 0.0)
    rooms = np.union1d(np.geomspace(_SPAN[0] * middle, _SPAN[1] * middle, _POINTS), [one.room.value])
    found = [_scaled(least_peak(one.path, float(room), _CLOSE), one.per) for room in rooms]
    least = np.array([np.nan if each is None else each.low for each in found])
    top = 1.25 * max(one.peak.value, one.peak.bound or 0.0, float(least[rooms >= 0.5 * middle].max(initial=0.0)))
    span, zones = (0.0, per_x * float(rooms[-1])), []
    if one.peak.bound is not None:
        words = f"{one.peak.where.partition('.')[2]}: at most {one.peak.shown(one.peak.bound)}"
        zones.append(Zone(one.peak.where, words, *span, per_y * one.peak.bound, True))
    if one.room.bound is not None:
        words = f"{one.room.where.partition('.')[2]}: at most {one.room.shown(one.room.bound)}"
        zones.append(Zone(one.room.where, words, per_x * one.room.bound, span[1], 0.0, True))
    said = f"design: {one.peak.shown(one.peak.value)} in {one.room.shown(one.room.value)}"
    names = [spoken(each.response.response).removeprefix("peak ") for each in (one.room, one.peak)]
    return Panel(
        title=f"{spoken(one.peak.response.response).capitalize()} against rattle space",
        x_label=f"greatest {names[0]} {place_of(one.room.response)} [{units[0]}]",
        y_label=f"greatest {names[1]} [{units[1]}]",
        curves=(known_curve("least that any isolator could reach", per_x * rooms, per_y * least),),
        zones=tuple(zones),
        marks=(Mark("design", said, per_x * one.room.value, per_y * one.peak.value),),
        x_span=span,
        y_span=(0.0, per_y * top) if isfinite(top) else (0.0, 1.0),
    )  # fmt: skip
