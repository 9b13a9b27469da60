"""A rotor of discs as a balancing job: what a weight on each disc does, by the model instead of trial runs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
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
from vibopt.responses.response import HarmonicResponse
from vibopt.scene.assemble import model_of
from vibopt.scene.check_bearings import in_planes
from vibopt.scene.drives import bands_for, names_for
from vibopt.scene.scene import Design, Scene
from vibopt.signals import Band

_PARTS, _SAME, _FINE, _APART = 8, 1e-8, 4001, 0.02
"""Speeds at which a range is looked at, beside its peaks; part by which two routes may differ; samples in which peaks
are looked for; part by which speeds differ, as runs of a meter at nearly one speed count as repeated."""
_RPM = 30.0 / np.pi
_SENSORS = 'no displacement is asked, and balancing reads one. Add a measure with response = "displacement".'
_PLANES = "no rotor has a disc that could take a weight. Add one to its discs."
_SPEEDS = "nothing says at which speeds to balance. Add an unbalance with its speed."
_ONE = "has several unbalances, and nothing says at which angles they stand. Write one, and the others in its also."
_CONVENTIONS = {
    "phase": "lead",
    "readings": "phase",
    "angles": "with rotation",
    "detector": "pk",
    "zero": "unbalances of the model",
}


def balancing_document(design: Design) -> dict[str, Any]:
    """Planes are the discs, sensors the points whose displacement is asked; as found are the unbalances of the file.

    Speeds are those at which a displacement is asked: of a range eight, and where one that was asked is greatest.

    Raises
    ------
    InputError
        There is no design, not one unbalance, no displacement asked, a limit that a balancing job does not have,
        bearings that differ in both planes, or a whirl without end.
    """
    scene, machine = design.scene, machine_in(design)
    if machine is None:
        raise InputError(f"{scene.name}: there is no design ({design.status}), so no rotor to balance.")
    if unlike := in_planes(scene):
        raise InputError(
            f"{scene.name}: bearings.{unlike[0]} is not alike in both planes, where an unbalance moves a place along "
            "an ellipse, and a balancing job reads circles. Leave --save-coefficients out."
        )
    sensors, planes = _sensors(scene), [disc.name for rotor in scene.rotors.values() for disc in rotor.discs]
    there = {_SENSORS: sensors, _PLANES: planes, _SPEEDS: scene.excitations}
    for lacks in (words for words, one in there.items() if not one):
        raise InputError(f"{scene.name}: {lacks}")
    (name, one), *_ = scene.excitations.items()
    if one.anywhere or len(one.loose) > 1:
        raise InputError(
            f"{scene.name}: excitations.{name} is an unbalance at places or angles that nobody knows, so nothing says "
            "what to take back. Leave or_on and angles out."
        )
    if len(scene.excitations) > 1:
        raise InputError(f"{scene.name}: {_ONE}")
    speeds = _speeds(scene, machine, sensors)
    effects = {plane: _effects(scene, design, machine, plane, list(sensors), speeds) for plane in planes}
    found = sum(
        excitation.swung * part * _effects(scene, design, machine, place, list(sensors), speeds)
        for excitation in scene.excitations.values()
        for place, part in excitation.acts.items()
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
    limits = {key: row for sensor in sensors.values() for limit in sensor for key, row in _limits(scene, limit, speeds)}
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
    for name, response in _asked(scene):
        limits = name in scene.limits
        if type(response) is Displacement and not (limits and response.at_most is None):
            found.setdefault(response.of, []).extend([name] if limits else [])
        elif limits and isinstance(response, HarmonicResponse):
            raise InputError(
                f"{scene.name}: limits.{name} asks for the {response.response}, and a balancing job limits "
                "displacements from above. Leave it out, or write the displacement that belongs to it."
            )
    return found


def _asked(scene: Scene) -> list[tuple[str, Response]]:
    goal = [] if scene.goal is None else [("", scene.goal.response)]
    return [*scene.limits.items(), *((f"measures.{key}", measure) for key, measure in scene.measures.items()), *goal]


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


def _speeds(scene: Scene, machine: Machine, sensors: Iterable[str]) -> FloatArray:
    """Where a plan is looked at [rad/s], ascending, no two of them nearly the same."""
    ((name, imbalance),) = scene.excitations.items()
    bands = set(imbalance.own_bands())
    for _, response in _asked(scene):
        if type(response) is Displacement:
            bands |= set(bands_for(scene, response, name))
    points, even = [band.low for band in bands if band.is_point], []
    for band in (one for one in bands if not one.is_point):
        points += _peaks(machine, imbalance.acts, sensors, band)
        even += np.linspace(band.low, band.high, _PARTS + 1)[::-1].tolist()
    kept: list[float] = []
    for speed in [*points, *even]:
        if speed > 0.0 and all(abs(speed - one) > _APART * one for one in kept):
            kept.append(speed)
    return np.sort(kept)


def _peaks(machine: Machine, acts: Mapping[str, complex], sensors: Iterable[str], band: Band) -> list[float]:
    """Speeds in a range at which what is asked is greatest [rad/s], the highest first."""
    from scipy.optimize import minimize_scalar

    def size(speeds: FloatArray, point: str) -> FloatArray:
        forces = {place: np.asarray(part * speeds**2, dtype=complex) for place, part in acts.items()}
        return np.asarray(np.abs(machine.shake(speeds, forces, {}).points[point]))

    critical = [one for one in machine.critical_speeds().tolist() if band.low < one < band.high]
    speeds = np.unique([*np.linspace(band.low, band.high, _FINE)[1:], *critical])
    found: list[tuple[float, float]] = []
    for point in sensors:
        values = size(speeds, point)
        for at in np.flatnonzero((values[1:-1] >= values[:-2]) & (values[1:-1] >= values[2:])) + 1:
            top = minimize_scalar(
                lambda one, point=point: -float(size(np.array([one]), point)[0]),
                bounds=(speeds[at - 1], speeds[at + 1]),
                method="bounded",
                options={"xatol": 1e-9 * speeds[at]},
            )
            found.append((float(top.fun), float(top.x)))
    return [speed for _, speed in sorted(found)]


def _effects(
    scene: Scene, design: Design, machine: Machine, place: str, points: list[str], speeds: FloatArray
) -> ComplexArray:
    """Displacement of points per unbalance at a place, (n_speeds, n_points) [m per kg m], agreed on by both routes."""
    model, chosen = model_of(scene), chosen_in(design)
    p = model.values(np.array([chosen[variable.path] for variable in scene.variables]))
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
