"""The two routes to every number compared: the optimiser's model, and the machine as built.

Both are asked at the same design and at the speed at which the machine as built is worst.  What they may differ by is
the rounding of their coefficients, carried through the equations to the response: the adjoint tells how far.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import hypot, isinf

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.forms import Modulus
from vibopt.forms.drive_response import DriveResponse, rigid_form
from vibopt.forms.form import Worst
from vibopt.mechanics.harmonic import carried, dynamic_stiffness, impedances, motion, mount_count, stretches
from vibopt.mechanics.model import Model
from vibopt.mechanics.modes import natural_frequencies
from vibopt.mechanics.onemass import reading
from vibopt.program.from_rest import from_rest, graded
from vibopt.program.pose import form_of, on_needed, ratings
from vibopt.records import cached_property, dataclass
from vibopt.responses import Response
from vibopt.scene.scene import Scene
from vibopt.signals import Band, Drive, Output
from vibopt.verify.certify import Measured, nearest

_SAME = 1e-9
"""Part of a value by which the routes may always differ."""
_EPS, _ROUNDINGS = float(np.finfo(float).eps), 1e4
"""Roundings of every coefficient that either route may add up."""
_LEFT = 1e-8
"""Part that is left of what cancels at a design that was looked for by squares: these keep half of the digits."""
LOADS = 1e-7
"""Part of its rating by which the static load of a mount may differ."""


def rated_loads(model: Model, x: FloatArray) -> dict[tuple[str, str], list[float]]:
    """Static loads of all mounts that are bought, as parts of what they are rated for, by limit and side."""
    found: dict[tuple[str, str], list[float]] = {}
    for limit in ratings(model, reduce=False):
        found.setdefault((limit.name, limit.side), []).append(limit.form.value(model, x))
    return found


def _within(value: float, other: float, room: float) -> bool:
    if isinf(other) or isinf(value):
        finite = value if isinf(other) else other
        return bool(value == other or room >= 1e-3 * abs(finite))
    return abs(value - other) <= max(_SAME * max(abs(value), abs(other)), room)


@dataclass(frozen=True)
class Modelled:
    """The model of a scene at one design: what it says of each response.

    scene, full
        What is there, and the full model of it in the design variables.
    x
        Shape (n_vars,).
    """

    scene: Scene
    full: Model
    x: FloatArray

    @cached_property
    def p(self) -> FloatArray:
        """Coefficients of the terms, (n_terms,)."""
        return self.full.values(self.x)

    def differs(self, response: Response, measured: Measured) -> bool:
        """Whether it gives another value than was found on the machine as built, beyond rounding.

        Parameters
        ----------
        response
            A single question, no group of mounts.
        found
            Its value on the machine as built, and the speeds of it.
        """
        value, room = self.at(response, measured)
        return not _within(value, measured.value, room)

    def elsewhere(self, response: Response, measured: Measured) -> Worst | None:
        """Its own worst over the speeds, where its search finds another value than that of the machine as built.

        That both agree at one speed does not say that it is the worst.  Of one mass both know their turns outright.
        """
        seen = response.seen_in(self.full)
        asked = form_of(self.scene, seen, response).harmonic
        if asked is None or (seen.n_free == 1 and asked.line is not None):
            return None
        model, form = on_needed(self.scene, seen, response, reduce=False)
        assert form.harmonic is not None
        if all(band.is_point for drive in form.drives for band in drive.bands):
            return None
        own = form.worst(model, self.x, least_wanted=measured.least)
        value = 1.0 - measured.value if response.complement else measured.value
        if _within(own.value, value, 0.0):
            return None
        room = max(self._rooms(model, form.harmonic, speeds) for speeds in (own.speeds, measured.speeds))
        room = max(room, _SAME * self._at_ends(model, form.harmonic))
        complement = replace(own, value=1.0 - own.value) if response.complement else own
        return None if _within(own.value, value, room) else complement

    def _rooms(self, model: Model, form: Modulus, speeds: Mapping[str, float]) -> float:
        """How far rounding of the coefficients moves the responses to all excitations, each at a speed."""
        rests = graded(model, form) is model  # held by springs, it has its room at standstill, too
        at = [(drive, speeds[drive.name] or drive.bands[0].low) for drive in form.drives]
        with np.errstate(all="ignore"):
            return sum(self._shaken_room(model, form, drive, speed) for drive, speed in at if speed or rests)

    def _at_ends(self, model: Model, form: Modulus) -> float:
        """The greatest of the responses at ends of their bands: a least beside it may be nothing."""
        ends = [
            (drive, np.array([end for band in drive.bands for end in (band.low, band.high)])) for drive in form.drives
        ]
        with np.errstate(all="ignore"):
            values = np.concatenate([DriveResponse(model, form, drive, self.x)(at) for drive, at in ends])
        return float(values[np.isfinite(values)].max(initial=0.0))

    def at(self, response: Response, measured: Measured) -> tuple[float, float]:
        """Its value where the other route found its own, and how far rounding may move it."""
        seen = response.seen_in(self.full)
        return (self if seen is self.full else replace(self, full=seen))._at(response, measured)

    def _at(self, response: Response, measured: Measured) -> tuple[float, float]:
        if response.complement:
            value, room = self._of_form(response, replace(measured, value=1.0 - measured.value))
            return 1.0 - value, max(room, self._rounding * abs(value))
        return self._of_form(response, measured)

    def _of_form(self, response: Response, measured: Measured) -> tuple[float, float]:
        """The same of the number that the form tells, and so of `found`: of an isolation, what comes through."""
        form = form_of(self.scene, self.full, response)
        if form.harmonic is not None:
            with np.errstate(all="ignore"):
                return self._harmonic(form.harmonic, response, measured, measured.value)
        if response.outside_bands and form.frequency is None:
            value = nearest(form.every(self.full, self.x), response.outside_bands)
        elif response.outside_bands:
            modes = natural_frequencies(self.full, self.p)
            value = float(modes[np.abs(modes - measured.value).argmin()])
        else:
            model, asked = self.full, form  # seen in the response's whirl already
            if form.swings is not None or form.random:  # of modes that meet one may be neither shaken nor seen
                model, asked = on_needed(self.scene, model, response, reduce=form.random)
            value = asked.worst(model, self.x, least_wanted=measured.least).value
            form = form if form.random else asked
        if abs(value - measured.value) <= _SAME * abs(measured.value):
            return value, 0.0
        return value, form.room(self.full, self.x, value, measured.value, self._rounding)

    def _outright(self, form: Modulus, measured: Measured) -> tuple[float, float]:
        """Its value and room where few coordinates and one harmonic tell them outright; nan elsewhere."""
        (drive, *others), model = form.drives, self.full
        if others or form.rigid_link or len(drive.lines) > 1:
            return float("nan"), 0.0
        line, speed = drive.lines[0], measured.speeds[drive.name]
        if model.n_free > 1:
            ranges = not all(band.is_point for band in drive.bands)  # where its worst is looked for by them, too
            return form.outright(model, self.x, speed) if ranges else float("nan"), 0.0
        size = abs(float(line.amplitude.at(np.array(speed)))) / mount_count(model, form.output, self.x)
        read, rest = reading(model, self.p, form.output, line, line.order * speed)
        value = size * abs(read)
        return value, self._rounding * value / rest if rest and not form.output.signs.any() else 0.0

    def _harmonic(self, form: Modulus, response: Response, measured: Measured, other: float) -> tuple[float, float]:
        model, (alone, close) = self.full, self._outright(form, measured)
        if _within(alone, other, close):
            return alone, close
        if 0.0 in measured.speeds.values():
            model = graded(self.full, form)
            asked = form_of(self.scene, model, response).harmonic
            assert asked is not None
            rest = replace(asked, drives=tuple(replace(one, bands=(Band(0.0, 0.0),)) for one in asked.drives))
            form = from_rest(model, rest, self.x)
        each, rooms = [], []
        for drive in form.drives:
            speed = measured.speeds[drive.name] or drive.bands[0].low
            endless = drive.name in form.endless and measured.speeds[drive.name] == 0.0
            here, above = DriveResponse(model, form, drive, self.x)(np.array([1.0, 10.0]) * speed).tolist()
            fades = speed != measured.speeds[drive.name] and here <= 0.2 * above
            each.append(np.inf if endless else 0.0 if fades else here)
            close = len(form.drives) == 1 and _within(each[0], measured.value, 0.0)
            rooms.append(0.0 if endless or close else self._shaken_room(model, form, drive, speed))
        total = hypot(*each) if form.combine == "rss" else sum(each)
        return total, sum(rooms)

    def _shaken_room(self, model: Model, form: Modulus, drive: Drive, speed: float) -> float:
        return shaken_room(model, form, drive, speed, self.x) * self._rounding

    @property
    def _rounding(self) -> float:
        return rounding(self.full)


def rounding(model: Model) -> float:
    """Part by which all coefficients of a model may be off, as either route adds them up."""
    return _ROUNDINGS * max(_EPS, model.precision)


def rounded(model: Model, p: FloatArray, u: ComplexArray, row: FloatArray, omega: float) -> float:
    """How far rounding of its coefficients may move what a row reads of a motion u (n_coords,) at a frequency."""
    z = impedances(model, p, np.array(omega))
    return rounding(model) * carried(model, z, dynamic_stiffness(model, z)[:, : model.n_free], row, u)


def cancels(model: Model, form: Modulus, x: FloatArray, worst: Worst) -> bool:
    """Whether a response at a design (n_vars,) is what is left of greater ones that cancel."""
    with np.errstate(all="ignore"):
        rooms = [shaken_room(model, form, drive, worst.speeds[drive.name], x) for drive in form.drives]
    return worst.value <= _LEFT * sum(rooms)


def shaken_room(model: Model, form: Modulus, drive: Drive, speed: float, x: FloatArray) -> float:
    """How far the response to one excitation at a speed moves, per part by which all coefficients are off."""
    room, size = _lines_room(model, form.output, drive, speed, x)
    room /= mount_count(model, form.output, x)
    if not form.rigid_link:
        return room
    rigid, output = rigid_form(model, form)
    lines = tuple(replace(line, vector=line.vector @ rigid.basis) for line in drive.lines)
    bolted, whole = _lines_room(rigid, output, replace(drive, lines=lines), speed, x)
    return bolted / size + whole * room / size**2 if size else np.inf


def _lines_room(model: Model, output: Output, drive: Drive, speed: float, x: FloatArray) -> tuple[float, float]:
    p, room, size = model.values(x), 0.0, 0.0
    for line in drive.lines:
        omega = np.array(line.order * speed)
        u = motion(model, p, line.vector, omega)
        z = impedances(model, p, omega)
        row = output.row + (output.signs * z) @ model.vectors
        n = model.n_free
        stiff = dynamic_stiffness(model, z)[:, :n]
        amplitude = abs(float(line.amplitude.at(np.array([speed]))[0])) * float(omega) ** output.power
        moved = carried(model, z, stiff, row, u)
        if output.signs.any():  # a balance of all forces may be what is left of great ones
            moved += float(np.abs(z) @ stretches(model, u) + np.abs(line.vector[:n]).sum())
        room += amplitude * moved
        size += amplitude * float(abs(row @ u))
    return (room if np.isfinite(room) else np.inf), size
