"""The two routes to every number compared: the optimiser's model, and the machine as built.

Both are asked at the same design and at the speed at which the machine as built is worst.  What they may differ by is
the rounding of their coefficients, carried through the equations to the response: the adjoint tells how far.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import hypot

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.forms import (
    DecayRate,
    Form,
    FreeMotion,
    ModeDamping,
    ModeFrequency,
    ModeGap,
    ModeRatio,
    Modulus,
    Monomials,
    StaticForce,
    StaticRow,
)
from vibopt.forms.drive_response import DriveResponse, rigid_form
from vibopt.mechanics.harmonic import dynamic_stiffness, impedances, motion, mount_count
from vibopt.mechanics.model import STIFFNESS, Model
from vibopt.mechanics.modes import natural_frequencies, poles, sag
from vibopt.mechanics.onemass import reading
from vibopt.program.from_rest import from_rest, graded
from vibopt.program.pose import form_of, ratings
from vibopt.responses import Response
from vibopt.scene.scene import Scene
from vibopt.signals import Band, Drive, Output
from vibopt.verify.certify import Measured

Numbers = FloatArray | ComplexArray
_SAME = 1e-9
"""Part of a value by which the routes may always differ."""
_ROUNDINGS = 1e4
"""Roundings of every coefficient that either route may add up."""
LOADS = 1e-7
"""Part of its rating by which the static load of a mount may differ."""
_ROOTS = 1e-6
"""Part of the greatest pole, or of a root mean square, that near roots and integrals may lose."""


def differs(scene: Scene, model: Model, chosen: Mapping[str, float], response: Response, found: Measured) -> bool:
    """Whether the model gives another value than was found on the machine as built, beyond rounding.

    Parameters
    ----------
    scene, model
        What is there, and the full model of it in the design variables.
    chosen
        Value of each design variable by path [SI].
    response
        A single question, no group of mounts.
    found
        Its value on the machine as built, and the speeds of it.
    """
    value, room = _Modelled(scene, model, chosen, response).at(found)
    return not _within(value, found.value, room)


def modelled(scene: Scene, model: Model, chosen: Mapping[str, float], response: Response, found: Measured) -> float:
    """The value of a response in the model where the machine as built is worst; parameters as for `differs`."""
    return _Modelled(scene, model, chosen, response).at(found)[0]


def rated_loads(model: Model, x: FloatArray) -> dict[tuple[str, str], list[float]]:
    """Static loads of all mounts that are bought, as parts of what they are rated for, by limit and side."""
    found: dict[tuple[str, str], list[float]] = {}
    for limit in ratings(model, reduce=False):
        found.setdefault((limit.name, limit.side), []).append(limit.form.value(model, x))
    return found


def _within(value: float, other: float, room: float) -> bool:
    if np.isinf(other) or np.isinf(value):
        finite = value if np.isinf(other) else other
        return bool(value == other or room >= 1e-3 * abs(finite))
    return abs(value - other) <= max(_SAME * max(abs(value), abs(other)), room)


class _Modelled:
    """One response in the model at one design."""

    def __init__(self, scene: Scene, model: Model, chosen: Mapping[str, float], response: Response) -> None:
        self.scene, self.response, self.full = scene, response, model
        self.x = np.array([chosen[one.path] for one in scene.variables])
        self.form = form_of(scene, model, response)

    def at(self, found: Measured) -> tuple[float, float]:
        """Its value where the other route found its own, and how far rounding may move it."""
        if isinstance(self.form, Modulus):
            with np.errstate(all="ignore"):
                value, room = self._harmonic(self.form, found)
            return (1.0 - value if self.response.complement else value), room
        if self.response.outside_bands:
            modes = natural_frequencies(self.full, self.full.values(self.x))
            value = float(modes[np.abs(modes - found.value).argmin()])
        else:
            value = self.form.value(self.full, self.x)
        return value, self._room(self.form, value, found.value)

    def _of_one_mass(self, form: Modulus, found: Measured) -> float:
        """Its value where one coordinate and one harmonic tell it outright; nan elsewhere."""
        (drive, *others), model = form.drives, self.full
        if others or form.rigid_link or model.n_free > 1 or len(drive.lines) > 1:
            return float("nan")
        line, speed = drive.lines[0], found.speeds[drive.name]
        size = abs(float(line.amplitude.at(np.array(speed)))) / mount_count(model, form.output, self.x)
        return size * abs(reading(model, model.values(self.x), form.output, line, line.order * speed))

    def _harmonic(self, form: Modulus, found: Measured) -> tuple[float, float]:
        model, alone = self.full, self._of_one_mass(form, found)
        if _within(alone, 1.0 - found.value if self.response.complement else found.value, 0.0):
            return alone, 0.0
        if 0.0 in found.speeds.values():
            model = graded(self.full, form)
            asked = form_of(self.scene, model, self.response)
            assert isinstance(asked, Modulus)
            rest = replace(asked, drives=tuple(replace(one, bands=(Band(0.0, 0.0),)) for one in asked.drives))
            form = from_rest(model, rest, self.x)
        each, rooms = [], []
        for drive in form.drives:
            speed = found.speeds[drive.name] or drive.bands[0].low
            endless = drive.name in form.endless and found.speeds[drive.name] == 0.0
            each.append(np.inf if endless else float(DriveResponse(model, form, drive, self.x)(np.array([speed]))[0]))
            close = len(form.drives) == 1 and _within(each[0], found.value, 0.0)
            rooms.append(0.0 if endless or close else self._shaken_room(model, form, drive, speed))
        total = hypot(*each) if form.combine == "rss" else sum(each)
        return total, sum(rooms)

    def _shaken_room(self, model: Model, form: Modulus, drive: Drive, speed: float) -> float:
        """How far rounding of the coefficients moves the response to one excitation at a speed."""
        room, size = self._lines_room(model, form.output, drive, speed)
        room /= mount_count(model, form.output, self.x)
        if not form.rigid_link:
            return room
        rigid, output = rigid_form(model, form)
        lines = tuple(replace(line, vector=line.vector @ rigid.basis) for line in drive.lines)
        bolted, whole = self._lines_room(rigid, output, replace(drive, lines=lines), speed)
        return bolted / size + whole * room / size**2 if size else np.inf

    def _lines_room(self, model: Model, output: Output, drive: Drive, speed: float) -> tuple[float, float]:
        p, room, size = model.values(self.x), 0.0, 0.0
        for line in drive.lines:
            omega = np.array(line.order * speed)
            u = motion(model, p, line.vector, omega)
            z = impedances(model, p, omega)
            row = output.row + (output.signs * z) @ model.vectors
            n = model.n_free
            stiff = dynamic_stiffness(model, z)[:, :n]
            amplitude = abs(float(line.amplitude.at(np.array([speed]))[0])) * float(omega) ** output.power
            moved = _carried(model, z, stiff, row, u)
            if output.signs.any():  # a balance of all forces may be what is left of great ones
                moved += float(np.abs(z) @ _both(model, u) + np.abs(line.vector[:n]).sum())
            room += self._rounding * amplitude * moved
            size += amplitude * float(abs(row @ u))
        return (room if np.isfinite(room) else np.inf), size

    @property
    def _rounding(self) -> float:
        return _ROUNDINGS * max(float(np.finfo(float).eps), self.full.precision)

    def _room(self, form: Form, value: float, other: float) -> float:
        """How far rounding moves what knows no speeds."""
        x, model = self.x, self.full
        if isinstance(form, Monomials) or abs(value - other) <= _SAME * abs(other):
            return 0.0
        p = model.values(x)
        if isinstance(form, StaticRow | StaticForce):
            down, z = sag(model, x), np.where(model.kinds == STIFFNESS, model.values(x, static=True), 0.0)
            if down is None:
                return np.inf
            n, signs = model.n_free, form.signs if isinstance(form, StaticForce) else np.zeros(len(z))
            row = (signs * z) @ model.vectors if isinstance(form, StaticForce) else form.row
            moved = _carried(model, z, dynamic_stiffness(model, z.astype(complex))[:, :n], row, down)
            return self._rounding * (moved + float(np.abs(signs * z) @ _both(model, down)))
        if isinstance(form, ModeFrequency | ModeGap):
            modes = natural_frequencies(model, p)
            least = max(abs(other), np.sqrt(self._rounding) * modes[-1])
            return (
                float(self._rounding * modes[-1] ** 2 / least)
                if isinstance(form, ModeFrequency)
                else (float(_ROOTS * modes[-1]))
            )
        if isinstance(form, DecayRate):
            return _ROOTS * float(np.abs(poles(model, p)).max(initial=0.0))
        if isinstance(form, ModeRatio):
            return _ROOTS * (1.0 + abs(value * other))
        if isinstance(form, FreeMotion):
            begun = np.abs(form.displacements) + form.after * np.abs(form.velocities)
            return _ROOTS * float(np.abs(form.row[: model.n_free]) @ begun)
        sizes = [abs(one) for one in (value, other) if np.isfinite(one)]
        return _ROOTS * max([1.0 if isinstance(form, ModeDamping) else 0.0, *sizes])


def _both(model: Model, u: Numbers) -> FloatArray:
    """Stretch of each term with nothing cancelled, (n_terms,)."""
    stretches: FloatArray = np.abs(model.vectors) @ np.abs(u)
    return stretches


def _carried(model: Model, z: Numbers, stiff: ComplexArray, row: Numbers, u: Numbers) -> float:
    """Sum of |coefficient| times what the adjoint and the motion make of it, nothing cancelled."""
    try:
        back = np.linalg.solve(stiff.T, np.asarray(row, dtype=complex)[: model.n_free])
    except np.linalg.LinAlgError:
        return np.inf
    whole = np.concatenate([back, np.zeros(model.n_coords - model.n_free)])
    return float(np.abs(z) @ (_both(model, whole) * _both(model, u)) + np.abs(row) @ np.abs(u))


__all__ = ["LOADS", "differs", "modelled", "rated_loads"]
