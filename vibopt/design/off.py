"""The machine as built with its numbers off: masses, springs and dampers of the nominal one, scaled part by part."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from vibopt.devices import AbsorberTable
from vibopt.devices.offset import offset_of
from vibopt.mechanics.machine import Joint, Machine
from vibopt.scene.scene import Scene

_HEAVY = ("mass", "weight", "inertia", "disc", "mass_ratio")
_POWERS = {"stiffness": 1, "torsional_stiffness": 1, "shaft": 1, "beam": 1, "frequency": 2, "tuning": 2, "length": -1}
_SHAFT = {"length": -1, "diameter": 4}
_VISCOUS = ("damping", "torsional_damping", "damping_ratio")


def as_built(scene: Scene, nominal: Machine) -> Machine:
    """The nominal machine with every part off by the factors of `scene.off`."""
    machine = nominal
    for path, factor in scene.off.items():
        family, name, *steps = path.split(".")
        if factor == 1.0:
            continue
        if steps[0] in _HEAVY:
            machine = _heavier(scene, machine, family, name, factor)
        else:
            joints = tuple(_altered(one, steps, factor) if one.name == name else one for one in machine.joints)
            machine = replace(machine, joints=joints)
    if machine is nominal:
        return nominal
    return replace(machine, joints=tuple(_ratios(scene, nominal, machine)))


def differing(scene: Scene, off: Mapping[str, float]) -> dict[str, float]:
    """By how much numbers are off: as a part of themselves, a centre of mass in metres; others are left out."""
    found = {}
    for path, factor in off.items():
        family, name, *steps = path.split(".")
        centre = family == "bodies" and steps[0] == "centre"
        if factor != 1.0:
            found[path] = offset_of(factor, scene.bodies[name].reaches[steps[1]]) if centre else factor - 1.0
    return found


def _heavier(scene: Scene, machine: Machine, family: str, name: str, factor: float) -> Machine:
    """Another mass; what rolling adds to it stays, and a pendulum pulls back with its own weight."""
    rolls = family == "bodies" and scene.bodies[name].rolling is not None
    part = machine.weights[name] if rolls else machine.masses[name]
    masses = {**machine.masses, name: machine.masses[name] + (factor - 1.0) * part}
    weights = {**machine.weights, name: factor * machine.weights.get(name, 0.0)}
    table = scene.absorbers.get(name)
    joints = machine.joints
    if isinstance(table, AbsorberTable) and table.length is not None:
        joints = tuple(_stiffer(one, factor) if one.name == name else one for one in joints)
    return replace(machine, masses=masses, weights=weights, joints=joints)


def _altered(joint: Joint, steps: list[str], factor: float) -> Joint:
    if steps[0] in _VISCOUS:
        return replace(joint, damping=joint.damping * factor)
    if steps[0] == "loss_factor":
        return replace(joint, loss_factor=joint.loss_factor * factor)
    powers: Mapping[str, int] = _SHAFT if len(steps) > 1 else _POWERS
    return _stiffer(joint, float(factor ** powers[steps[-1]]))


def _stiffer(joint: Joint, factor: float) -> Joint:
    return replace(joint, stiffness=joint.stiffness * factor, static_stiffness=joint.static_stiffness * factor)


def _ratios(scene: Scene, nominal: Machine, machine: Machine) -> Iterator[Joint]:
    """Damping ratios of the machine as built: to its own stiffness and mass."""
    only = next(iter(scene.bodies)) if len(scene.bodies) == 1 else None
    for joint in machine.joints:
        was = nominal.joint(joint.name)
        owner = joint.name if joint.name in scene.absorbers else (scene.links[joint.name].relative_to or only)
        if owner is None or was.damping_ratio == 0.0 or joint.stiffness == 0.0:
            yield joint
            continue
        grown = (joint.stiffness * machine.masses[owner]) / (was.stiffness * nominal.masses[owner])
        yield replace(joint, damping_ratio=was.damping_ratio * joint.damping / was.damping / grown**0.5)


__all__ = ["as_built", "differing"]
