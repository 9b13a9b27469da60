"""Whether a run-up can be gone through, and what is asked of it."""

from __future__ import annotations

import math

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.document.mistakes import Mistakes, Path, dotted
from vibopt.excitations.excitation import Excitation
from vibopt.excitations.run_up import band_of, ends_of, motor_of, rate_of
from vibopt.mechanics.builder import GROUND
from vibopt.mechanics.model import DAMPING
from vibopt.mechanics.modes import natural_frequencies
from vibopt.mechanics.motor import Motor
from vibopt.scene import places
from vibopt.scene.assemble import model_of
from vibopt.scene.check_bearings import beyond_tables
from vibopt.scene.scene import Scene
from vibopt.units import show

_ROOM, _TURNS, _AT_REST = 1e-9, 3e5, 1e-7
"""Rounding; turns that are followed one by one to confirm an answer; part of the highest natural frequency that is
none."""


def check_run_up(scene: Scene, name: str, mistakes: Mistakes) -> None:
    """Add what is wrong with the speeds of a run-up."""
    excitation = scene.excitations[name]
    path, where, unit = ("excitations", name, "run_up"), f"excitations.{name}", excitation.speed.unit
    begins, stays = ends_of(excitation)
    own, band = max(each.high for each in excitation.own_bands()), band_of(excitation)

    def shown(speed: float) -> str:
        return show(speed, unit, "angular_rate")

    if begins == stays:
        mistakes.add(path, f"{where}.run_up begins at {shown(begins)} and stays there. Write another from or to.")
    elif own > band.high * (1.0 + _ROOM):
        mistakes.add(
            path,
            f"{where}.run_up goes up to {shown(band.high)}, but speed = {shown(own)} is beyond it: which of the two "
            f'does the machine reach? Write to = "{shown(own)}", or a lower speed.',
        )
    elif (motor := motor_of(excitation)) is not None and not _covers(motor):
        mistakes.add(
            path,
            f"{where}.run_up goes from {shown(begins)} to {shown(stays)}, and its torque is not known at all of these "
            "speeds. Extend its rows.",
        )
    elif motor is not None and (weak := _weak(motor)) is not None:
        speed, way = weak, "up" if stays > begins else "down"
        left = show(float(motor.left(np.array([speed]))[0]), "N m", "moment")
        mistakes.add(
            path,
            f"{where}.run_up never gets from {shown(begins)} to {shown(stays)}: at {shown(speed)} torque less load is "
            f"{left}, which turns it no further {way}. Write a {'greater' if stays > begins else 'smaller'} torque, or "
            "another end.",
        )
    elif _turned(excitation) > _TURNS * 2.0 * math.pi:
        mistakes.add(
            path,
            f"{where}.run_up takes more than {_TURNS:.0f} turns, so slowly that it is steady at every speed. Ask for "
            f'steady responses over the range instead: over = "{shown(band.low)}..{shown(band.high)}".',
        )
    elif not any(each.holds(band.low) and each.holds(band.high) for each in excitation.known_bands):
        mistakes.add(
            path,
            f"{where}.run_up goes from {shown(begins)} to {shown(stays)}, and its amplitude is not known at all of "
            f'these speeds. Add varies = "constant" or varies = "speed^2" to {where}, or extend its table.',
        )


def _covers(motor: Motor) -> bool:
    """Whether torque and load are known on the whole way."""
    low, high = sorted((motor.begins, motor.stays))
    curves = (motor.driving.pieces, motor.load.pieces)
    return all(curve[0].band.low <= low and high <= curve[-1].band.high * (1.0 + _ROOM) for curve in curves)


def _known(motor: Motor) -> FloatArray:
    """Speeds at which torques are looked at: ends, joints of their curves, and some between."""
    low, high = sorted((motor.begins, motor.stays))
    joints = [value for value in (*motor.driving.breaks(), *motor.load.breaks()) if low < value < high]
    return np.sort(np.concatenate([np.linspace(low, high, 201), joints]))


def _weak(motor: Motor) -> float | None:
    """The first speed on its way at which torque and load leave nothing over [rad/s]; None without one."""
    sense, speeds = math.copysign(1.0, motor.stays - motor.begins), _known(motor)
    stuck = speeds[sense * motor.left(speeds) <= 0.0]
    return float(stuck[0] if sense > 0.0 else stuck[-1]) if len(stuck) else None


def _turned(excitation: Excitation) -> float:
    """Angle through which it turns on its way [rad]."""
    motor, (begins, stays) = motor_of(excitation), ends_of(excitation)
    if motor is None:
        return abs(stays**2 - begins**2) / abs(2.0 * rate_of(excitation))
    speeds = _known(motor)
    return float(abs(np.trapezoid(speeds * motor.inertia / motor.left(speeds), speeds)))


def contradicts(scene: Scene, path: Path, names: tuple[str, ...], mistakes: Mistakes, *, together: bool) -> bool:
    """Whether a response in time counts a run-up that it cannot answer for, alone or `together`; adds the mistake."""
    rising = [name for name in names if scene.excitations[name].ramp is not None]
    if not rising:
        return False
    if len(names) > 1 and together:
        other = next(name for name in names if name != rising[0])
        mistakes.add(
            path,
            f"{dotted(path)} counts the run-up of excitations.{rising[0]} and excitations.{other}, which have no known "
            f'angle or time between them. Name one: due_to = ["{rising[0]}"].',
        )
        return True
    if scene.rotors:
        if not mistakes.found and _undamped(scene):
            mistakes.add(
                path,
                f"{dotted(path)} asks for the run-up of rotors.{next(iter(scene.rotors))}, whose whirl nothing damps: "
                "what a critical speed leaves rings on for ever. Write damping of a link or of a bearing.",
            )
            return True
        return beyond_tables(scene, path, band_of(scene.excitations[rising[0]]), mistakes)
    loose = _loose(scene, scene.excitations[rising[0]].on)
    if loose:
        mistakes.add(
            path,
            f"{dotted(path)} asks for the run-up of a machine of which {loose} is held by no spring: it is pushed away "
            "as the force begins. Hold it by a link with stiffness to a support.",
        )
    return bool(loose)


def _undamped(scene: Scene) -> bool:
    """Whether neither a link nor a bearing has any damping."""
    model = model_of(scene)
    films = [one.table[:, 4:] if len(one.speeds) else [each.scale for each in one.powers[4:]] for one in model.bearings]
    return not model.scales[model.kinds == DAMPING].any() and not any(np.any(film) for film in films)


def _loose(scene: Scene, on: str) -> str:
    """A body among those that it shakes which no springs hold; "" where all are held."""
    if scene.structures:  # what is free to turn as a whole may be held at each of its points
        model = model_of(scene)
        found = natural_frequencies(model, model.values(np.array([one.low for one in scene.variables])))
        return on if found.min() <= _AT_REST * found.max() else ""
    moving = set(places.moving(scene))
    springs = [ends for name, ends in places.ends(scene).items() if name in places.springs(scene)]
    springs += [(name, point.on) for name, point in scene.points.items()]
    held = {end for ends in springs for end in ends if end not in moving} | {GROUND}
    for _ in moving:
        held |= {end for ends in springs if held & set(ends) for end in ends}
    reached, near = {on}, places.neighbours(scene)
    for _ in moving:
        reached |= {one for here in reached & moving for one in near.get(here, ()) if one in moving}
    return min(reached - held, default="")
