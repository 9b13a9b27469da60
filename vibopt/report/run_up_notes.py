"""What is said of a run-up: how far from steady it is, and what it never reaches."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite

from vibopt.excitations.run_up import band_of, ends_of, motor_of
from vibopt.mechanics.machine import Machine
from vibopt.responses import TransientResponse
from vibopt.scene.drives import names_for
from vibopt.scene.scene import Scene
from vibopt.scene.uncertain import uncertain
from vibopt.units import best_unit, plain, show
from vibopt.values import SpeedRange
from vibopt.values.speeds import ROTATION
from vibopt.verify.as_built import machine_of
from vibopt.verify.by_torque import ByTorque
from vibopt.verify.certify import measure_on

_SAME = 5e-3
"""Part by which two values must differ to be told apart in words."""


def run_up_notes(scene: Scene, chosen: Mapping[str, float]) -> list[str]:
    """Each response in a run-up beside the steady vibration at the same speeds; run-ups that nothing asks of."""
    once = {where: response for where, response in scene.responses.items() if isinstance(response, TransientResponse)}
    machine, rising = (
        machine_of(scene, chosen),
        [n for n, excitation in scene.excitations.items() if excitation.ramp is not None],
    )
    notes, told = [], set[str]()
    for where, one in once.items():
        [name, *_] = names = names_for(scene, one)
        if one.combine is not None:
            told.update(names)
        elif name in rising:
            notes += [*_never(scene, machine, name), *_torque(scene, machine, name)] if name not in told else []
            told.add(name)
            notes.append(_beside(scene, machine, where, name, one))
    notes += [
        f"excitations.{name}: nothing asks of its run-up. Add a response in time, as peak_displacement."
        for name in rising
        if name not in told
    ]
    if told & set(rising):
        notes.append("A peak in a run-up is the greatest over every angle at which the force may begin.")
    return notes


def _beside(scene: Scene, machine: Machine, where: str, name: str, response: TransientResponse) -> str:
    """How much less or more it is than the greatest steady vibration on the way, and how much later."""
    unit, band = scene.excitations[name].speed.unit, band_of(scene.excitations[name])
    measured = measure_on(scene, machine, response, "at_most")
    over = {"over": {name: SpeedRange((band,), ROTATION, unit)}, "due_to": (name,)}
    steady = measure_on(scene, machine, response.steady.model_copy(update=over), "at_most")
    if scene.rotors and not isfinite(measured.value):
        ends = ends_of(scene.excitations[name])[1]
        last, least = (show(one, unit, ROTATION) for one in (ends, machine.threshold(ends)))
        return (
            f"{where}: a whirl grows without end at {last}, where the {_run(scene, name)} ends; the stability "
            f"threshold is {least}."
        )
    if isfinite(steady.value) and not isfinite(measured.value):  # the motor sticks, as is said
        most = show(steady.value, best_unit(steady.value, response.dimension), response.dimension)
        return f"{where}: steady, it is at most {most} on the way, at {show(steady.speeds[name], unit, ROTATION)}."
    if not isfinite(steady.value):
        return (
            f"{where}: run slowly it is infinite, at {show(steady.speeds[name], unit, ROTATION)}; in the run-up "
            f"{'too' if not isfinite(measured.value) else 'it is not'}."
        )
    if not steady.value:
        return f"{where}: nothing of it is felt there, run slowly neither."
    size = show(steady.value, best_unit(steady.value, response.dimension), response.dimension)
    part, begins = measured.value / steady.value - 1.0, steady.speeds[name]
    shift = measured.speeds[name] / begins - 1.0 if begins > 0.0 else measured.speeds[name]
    much = "as much" if abs(part) < _SAME else f"{plain(100.0 * abs(part), 2)} % {'more' if part > 0.0 else 'less'}"
    when = f"at a speed {plain(100.0 * abs(shift), 2)} % {'above' if shift > 0.0 else 'below'}"
    when = "there" if abs(shift) < _SAME else when if begins > 0.0 else f"at {show(shift, unit, ROTATION)}"
    built = "as said, without tolerances, steady" if uncertain(scene) else "steady"
    return (
        f"{where}: {built}, it is at most {size} on the way, at {show(steady.speeds[name], unit, ROTATION)}; in the "
        f"{_run(scene, name)} it is {much}, {when}."
    )


def _never(scene: Scene, machine: Machine, name: str) -> list[str]:
    """That a run-up passes no natural frequency."""
    unit, band = scene.excitations[name].speed.unit, band_of(scene.excitations[name])
    modes = [float(frequency) for frequency in machine.natural_frequencies()]
    if not modes or any(band.low <= mode <= band.high for mode in modes):
        return []
    near = min(modes, key=lambda value: max(band.low - value, value - band.high))
    return [
        f"excitations.{name}: its {_run(scene, name)} passes no resonance; the nearest natural frequency is "
        f"{show(near, unit, ROTATION)}."
    ]


def _torque(scene: Scene, machine: Machine, name: str) -> list[str]:
    """How much of the torque that is left the vibration takes up, and that it may take all."""
    motor = motor_of(scene.excitations[name])
    if motor is None:
        return []
    unit, course = scene.excitations[name].speed.unit, ByTorque(machine, motor, scene.excitations[name].on)
    speed, taken, left = course.dearest
    where, much, rest = show(speed, unit, ROTATION), show(taken, "N m", "moment"), show(left, "N m", "moment")
    if course.sticks:
        much = much if isfinite(taken) else "more than any motor gives"
        return [
            f"excitations.{name}: the motor may stick at about {where}. The vibration takes up {much} there, torque "
            f"and load leave {rest}. Take more damping, less unbalance or more torque."
        ]
    share = taken / abs(left)
    part = f"{100.0 * share:.2g} %"
    if left < 0.0:
        part = f"{part} of" if share < 1.0 else f"{share:.2g} times"
        return [
            f"excitations.{name}: where it counts most, at {where}, the vibration would brake by up to {much}, {part} "
            f"the {show(-left, 'N m', 'moment')} that slow it down; none of it is counted, which is on the safe side "
            "for one resonance."
        ]
    return [
        f"excitations.{name}: of the {rest} that torque and load leave at {where} the vibration takes up {much} "
        f"({part}); it passes as slowly as if that were steady, which is on the safe side for one resonance."
    ]


def _run(scene: Scene, name: str) -> str:
    begins, stays = ends_of(scene.excitations[name])
    return "run-up" if stays > begins else "run-down"
