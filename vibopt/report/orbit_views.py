"""Pictures of rotors in bearings that differ in both planes: half axes against the speed, and the worst orbit."""

from __future__ import annotations

from dataclasses import replace
from math import isfinite
from typing import cast

import numpy as np

from vibopt.answer.blocks import spoken
from vibopt.arrays import FloatArray
from vibopt.forms.orbit import Orbit
from vibopt.mechanics.model import Model
from vibopt.program.pose import form_of
from vibopt.report.series import Mark, Panel, Zone, known_curve
from vibopt.responses import HarmonicResponse
from vibopt.scene.check_bearings import table_ends
from vibopt.scene.drives import bands_for
from vibopt.scene.places import place_of
from vibopt.scene.scene import Design
from vibopt.scene.space import members
from vibopt.units import best_unit, show, to_unit
from vibopt.values.speeds import ROTATION

_SPEEDS, _TURNS, _ROOM = 400, 181, 1.25
"""Speeds of a curve, places on an orbit, and how much higher than what is drawn a panel is."""


def orbit_panels(design: Design, model: Model) -> list[Panel]:
    """Every response against the speed, each under it with its orbit where it is a displacement; none that grows."""
    rows = {f"{family}.{name}": row for family in ("limits", "measures") for name, row in vars(design)[family].items()}
    x, panels, seen = np.array(design.x), list[Panel](), set[tuple[str, str]]()
    for where, response in design.scene.responses.items():
        if not isinstance(response, HarmonicResponse) or (response.response, place_of(response)) in seen:
            continue
        if where in rows and rows[where].unsteady:
            continue
        seen.add((response.response, place_of(response)))
        forms = [cast("Orbit", form_of(design.scene, model, each)) for each in members(design.scene, response)]
        form = max(forms, key=lambda each: each.value(model, x))
        for drive in form.shaken:
            panels.append(_against_speed(design, model, x, where, response, replace(form, shaken=(drive,))))
            worst = form.worst(model, x)
            speed, turns = worst.speeds[drive.name], response.response == "displacement" and len(drive.lines) == 1
            if turns and isfinite(worst.value) and speed > 0.0:
                panels.append(_orbit(design, model, x, response, form, speed))
    return panels


def _against_speed(
    design: Design, model: Model, x: FloatArray, where: str, one: HarmonicResponse, form: Orbit
) -> Panel:  # fmt: skip
    scene, (drive,), ends = design.scene, form.shaken, table_ends(design.scene)
    bands, shaker = bands_for(scene, one, drive.name), scene.excitations[drive.name]
    low, high = 0.5 * min(band.low for band in bands), 1.1 * max(band.high for band in bands)
    if ends is not None:
        low, high = max(low, ends[1]), min(high, ends[2])
    worst = form.worst(model, x)
    speeds = np.union1d(np.linspace(max(low, 1e-3 * high), high, _SPEEDS), list(worst.speeds.values()))
    parts = np.abs(form.parts(model, x, drive, speeds)).sum(axis=0)
    value = worst.value if isfinite(worst.value) else float(np.median(parts.sum(axis=0)))
    unit = best_unit(value, one.dimension)
    factor, per = to_unit(1.0, unit, one.dimension), to_unit(1.0, shaker.speed.unit, ROTATION)
    bound = one.at_most
    limit = bound.value if bound is not None else 0.0
    top = factor * max(value, limit)
    said = "" if bound is None else show(bound.value, bound.unit, one.dimension, amplitude=one.amplitude)
    name = where.rpartition(".")[2]
    zones = [
        Zone(where, f"{name}: at most {said}", per * band.low, per * band.high, factor * limit, above=True)
        for band in (bands if bound is not None else ())
    ]
    curves = [known_curve("greater half axis", per * speeds, np.minimum(factor * parts.sum(axis=0), 1e3 * top))]
    for label, part in zip(("forward part", "backward part"), parts, strict=True):
        curves.append(known_curve(label, per * speeds, np.minimum(factor * part, 1e3 * top)))
    at = worst.speeds[drive.name]
    marks = (Mark(where, f"{name} {show(worst.value, '', one.dimension)}", per * at, factor * value),)
    return Panel(
        title=f"{spoken(one.response).capitalize()} {place_of(one)}",
        x_label=f"speed of {drive.name} [{shaker.speed.unit}]", y_label=f"{spoken(one.response)} [{unit} pk]",
        curves=tuple(curves), zones=tuple(zones), marks=marks, excitation=drive.name,
        x_span=(per * float(speeds[0]), per * float(speeds[-1])), y_span=(0.0, _ROOM * top),
    )  # fmt: skip


def _orbit(design: Design, model: Model, x: FloatArray, one: HarmonicResponse, form: Orbit, speed: float) -> Panel:
    """One turn at a speed [rad/s], y to the right and z up."""
    drive = form.shaken[0]
    forward, backward = form.parts(model, x, drive, np.array([speed])).sum(axis=0)[:, 0]
    turn = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, _TURNS))
    path = forward * turn + np.conj(backward * turn)
    axis = np.exp(0.5j * (np.angle(forward) - np.angle(backward))) * (abs(forward) + abs(backward))
    unit = best_unit(abs(axis), one.dimension)
    factor, shaker = to_unit(1.0, unit, one.dimension), design.scene.excitations[drive.name]
    shown = show(shaker.from_rotation(speed), shaker.speed.unit, ROTATION)
    way, span = "forward" if abs(forward) >= abs(backward) else "backward", _ROOM * factor * abs(axis)
    ends = factor * np.array([-axis, axis])
    curves = (
        known_curve(f"goes round {way}", factor * path.real, factor * path.imag),
        known_curve("major axis", ends.real, ends.imag, before=True),
    )
    return Panel(
        title=f"Orbit {place_of(one)} at {shown}", x_label=f"y, level [{unit}]", y_label=f"z, upward [{unit}]",
        curves=curves, excitation=drive.name, x_span=(-span, span), y_span=(-span, span), to_scale=True,
    )  # fmt: skip
