"""A rotor of discs as a balancing job: what a weight on each disc does, by the model instead of trial runs."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.errors import InputError
from vibopt.mechanics.harmonic import motion
from vibopt.mechanics.machine import Machine
from vibopt.report.absorber_parts import chosen_in
from vibopt.report.what_to_build import machine_in
from vibopt.responses import Response
from vibopt.responses.motion import Displacement
from vibopt.scene.assemble import model_of
from vibopt.scene.drives import bands_for, names_for
from vibopt.scene.scene import Design, Scene

_PARTS, _SAME = 8, 1e-8
"""Speeds at which a range is looked at, beside its critical speeds; part by which two routes may differ."""
_RPM = 30.0 / np.pi
_SENSORS = 'no displacement is asked, and balancing reads one. Add a measure with response = "displacement".'
_PLANES = "no rotor has a disc that could take a weight. Add one to its discs."
_SPEEDS = "nothing says at which speeds to balance. Add an unbalance with its speed."
_CONVENTIONS = {
    "phase": "lead",
    "readings": "phase",
    "angles": "with rotation",
    "detector": "pk",
    "zero": "unbalances of the model",
}


def balancing_document(design: Design) -> dict[str, Any]:
    """Planes are the discs, sensors the points whose displacement is asked; as found are the unbalances of the file.

    Speeds are those of the unbalances: of a range eight, and every critical speed in it.

    Raises
    ------
    InputError
        There is no design, nothing is out of balance, no displacement is asked, or a whirl has no end.
    """
    scene, machine = design.scene, machine_in(design)
    if machine is None:
        raise InputError(f"{scene.name}: there is no design ({design.status}), so no rotor to balance.")
    sensors, planes = _sensors(scene), [disc.name for one in scene.rotors.values() for disc in one.discs]
    there = {_SENSORS: sensors, _PLANES: planes, _SPEEDS: scene.excitations}
    for lacks in (words for words, one in there.items() if not one):
        raise InputError(f"{scene.name}: {lacks}")
    speeds = _speeds(scene, machine)
    effects = {plane: _effects(scene, design, machine, plane, list(sensors), speeds) for plane in planes}
    found = sum(
        one.swung * part * _effects(scene, design, machine, place, list(sensors), speeds)
        for one in scene.excitations.values()
        for place, part in one.acts.items()
    )
    written = [f"{speed * _RPM:.15g} rpm" for speed in speeds]
    runs = [
        {
            "name": f"as modelled, {speed * _RPM:.5g} rpm",
            "speed": text,
            "readings": {point: _phasor(one, 1e3, "mm") for point, one in zip(sensors, row, strict=True)},
        }
        for speed, text, row in zip(speeds, written, np.asarray(found), strict=True)
    ]
    influence = [
        {"speed": text, "sensor": point, "plane": plane, "value": _phasor(effects[plane][i, j], 1e-3, "mm/(g mm)")}
        for i, text in enumerate(written)
        for j, point in enumerate(sensors)
        for plane in planes
    ]
    limits = {key: row for one in sensors.values() for limit in one for key, row in _limits(scene, limit, speeds)}
    return {
        "title": f"Balancing of {scene.title}, modelled",
        "conventions": _CONVENTIONS,
        "planes": {plane: {"unbalance": {"from": "0 g mm", "to": "1 kg m"}} for plane in planes},
        "runs": runs,
        "influence": influence,
        **({"limits": limits} if limits else {}),
        "goal": {"minimise": "residual", "combine": "worst"},
    }


def _sensors(scene: Scene) -> dict[str, list[str]]:
    """Points whose displacement is asked, each with the names of its limits."""
    found: dict[str, list[str]] = {}
    asked: list[tuple[str, Response]] = [*scene.limits.items(), *scene.measures.items()]
    if scene.goal is not None:
        asked.append(("", scene.goal.response))
    for name, response in asked:
        if isinstance(response, Displacement):
            found.setdefault(response.of, []).extend([name] if response.at_most is not None else [])
    return found


def _limits(scene: Scene, name: str, speeds: FloatArray) -> Iterator[tuple[str, dict[str, str]]]:
    """A limit on what is left at a sensor; at each of its speeds where it does not speak of all."""
    response = scene.limits[name]
    assert isinstance(response, Displacement)
    assert response.at_most is not None
    bands = [band for one in names_for(scene, response) for band in bands_for(scene, response, one)]
    asked = [one for one in speeds.tolist() if any(band.low <= one <= band.high for band in bands)]
    row = {"response": "residual", "at": response.of, "at_most": f"{response.at_most.value * 1e3:.15g} mm pk"}
    if len(asked) == len(speeds):
        yield name, row
        return
    for one in asked:
        yield f"{name}_at_{one * _RPM:.5g}".replace(".", "_"), {**row, "speed": f"{one * _RPM:.15g} rpm"}


def _speeds(scene: Scene, machine: Machine) -> FloatArray:
    """Where a plan is looked at [rad/s], ascending."""
    found: set[float] = set()
    for band in (band for one in scene.excitations.values() for band in one.own_bands()):
        if band.is_point:
            found.add(band.low)
            continue
        found |= set(np.linspace(band.low, band.high, _PARTS + 1)[1:].tolist())
        found |= {one for one in machine.critical_speeds().tolist() if band.low < one < band.high}
    return np.sort([one for one in found if one > 0.0])


def _effects(
    scene: Scene, design: Design, machine: Machine, place: str, points: list[str], speeds: FloatArray
) -> ComplexArray:
    """Displacement of points per unbalance at a place, (n_speeds, n_points) [m per kg m], agreed on by both routes."""
    model, chosen = model_of(scene), chosen_in(design)
    p = model.values(np.array([chosen[one.path] for one in scene.variables]))
    moved = motion(model, p, model.points[place].astype(complex), speeds)
    one = np.array([moved @ model.points[point] for point in points]).T * speeds[:, None] ** 2
    shaken = machine.shake(speeds, {place: (speeds**2).astype(complex)}, {})
    other = np.array([shaken.points[point] for point in points]).T
    if not np.all(np.isfinite(other)) or np.abs(one - other).max() > _SAME * np.abs(other).max():
        raise InputError(
            f"{scene.name}: what an unbalance on {place} does is not known: at a critical speed without damping a "
            "whirl has no end. Give the bearings a damping, or look at other speeds."
        )
    return other


def _phasor(value: complex, times: float, unit: str) -> str:
    """With all digits, its angle counted ahead in the sense of rotation."""
    return f"{abs(value) * times:.15g} {unit} @ {degrees(np.angle(value)):.15g} deg"


__all__ = ["balancing_document"]
