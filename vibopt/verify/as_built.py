"""The machine as it would be built: every value of the scene with the choice put in.

Each device builds itself from the file's own words; nothing is shared with the road of the optimiser.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.devices.offset import factor_of, offset_of
from vibopt.devices.symbols import Numbers
from vibopt.mechanics.assembly import Assembly
from vibopt.mechanics.machine import Machine
from vibopt.scene.assemble import bare
from vibopt.scene.places import devices, ends
from vibopt.scene.scene import Scene
from vibopt.scene.space import bodies_in_space, guides, is_spatial, pins, spatial_bases


def machine_of(scene: Scene, chosen: Mapping[str, float]) -> Machine:
    """All devices in numbers, off by `scene.off`.

    Parameters
    ----------
    scene
        What is there.
    chosen
        Value of each design variable by path [SI].
    """
    known, key = vars(scene), tuple(chosen.items())
    if known.get("built", (None,))[0] != key:  # every row of an answer asks for the same one
        rates = {path: value for path, value in chosen.items() if path.startswith("excitations.")}
        machine = built(scene, chosen)
        known["built"] = key, replace(machine, rates=rates) if rates else machine
    found: Machine = known["built"][1]
    return found


def built(scene: Scene, chosen: Mapping[str, Any]) -> Machine:
    """The machine of `chosen` values, which may be arrays [SI]: then one body on links alone is many at once.

    A fact whose path is among them has that value instead of its own.
    """

    def alone() -> FloatArray:
        return machine_of(bare(replace(scene, off={})), chosen).natural_frequencies()

    space = is_spatial(scene)
    bodies = [name for name in scene.bodies if name not in bodies_in_space(scene)]
    assembly = Assembly(only=bodies[0] if len(bodies) == 1 else None, alone=alone)
    assembly.spatial, assembly.guides = spatial_bases(scene) if space else (), guides(scene)
    if scene.structures or scene.rotors:
        from vibopt.scene.drives import looked_at

        assembly.top, assembly.modes = looked_at(scene)
    acted = {name: pin for name, pin in pins(scene).items() if name not in scene.points}
    for name, (body, at) in acted.items() if space else ():
        assembly.fixed[name] = (body, np.array(at))
    numbers = Numbers(chosen, scene.off)
    waiting = {name: table for _, name, table in devices(scene)}
    order = {link: place for place, link in enumerate(ends(scene))}
    while waiting:
        there = assembly.points
        ready = [name for name, table in waiting.items() if table.needs(name) <= there]
        assert ready, f"what {', '.join(waiting)} need is not there"
        for name in ready:
            waiting.pop(name).built(assembly, name, numbers)
    return assembly.machine(order, space=space)


def differing(scene: Scene, off: Mapping[str, float]) -> dict[str, float]:
    """By how much numbers are off: as a part of themselves, a centre of mass in metres; others are left out."""
    found = {}
    for path, factor in off.items():
        family, name, *steps = path.split(".")
        centre = family == "bodies" and steps[0] == "centre"
        if factor != 1.0:
            found[path] = offset_of(factor, scene.bodies[name].reaches[steps[1]]) if centre else factor - 1.0
    return found


def factors_of(scene: Scene, differs: Mapping[str, float]) -> dict[str, float]:
    """The `off` of a scene of which `differing` says so much."""
    found = {}
    for path, size in differs.items():
        family, name, *steps = path.split(".")
        centre = family == "bodies" and steps[0] == "centre"
        found[path] = factor_of(size, scene.bodies[name].reaches[steps[1]]) if centre else 1.0 + size
    return found
