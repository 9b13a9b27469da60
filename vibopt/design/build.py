"""The machine as it would be built: every value of the scene with the choice put in.

Plain numbers from the tables' own words, link by link; nothing is shared with the road of the optimiser.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from vibopt.design.off import as_built
from vibopt.design.space import in_space, line_part
from vibopt.devices import AbsorberTable, BodyTable, LinkTable
from vibopt.devices.spring import Beam, Shaft
from vibopt.mechanics.beam import sag_under_load
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.lone import LoneMachine
from vibopt.mechanics.machine import Joint, Machine, Tuned
from vibopt.scene.lookout import looked_at
from vibopt.scene.scene import Scene
from vibopt.scene.space import is_spatial
from vibopt.values.fields import Choice, Fact

if TYPE_CHECKING:
    from vibopt.mechanics.hosted import Carrier


@dataclass(frozen=True, slots=True)
class _Numbers:
    """Reads values of a table in the file: facts as they are, choices as chosen [SI]."""

    chosen: Mapping[str, float]

    def __call__(self, path: str, value: Fact | Choice | None, default: float = 0.0) -> float:
        if value is None:
            return default
        return value.value if isinstance(value, Fact) else self.chosen[path]


def machine_of(scene: Scene, chosen: Mapping[str, float]) -> Machine:
    """Bodies, absorbers and links in numbers, off by `scene.off`.

    Parameters
    ----------
    scene
        What is there.
    chosen
        Value of each design variable by path [SI].
    """
    known, key = vars(scene), tuple(chosen.items())
    if known.get("built", (None,))[0] != key:  # every row of an answer asks for the same one
        known["built"] = key, _machine(scene, chosen)
    found: Machine = known["built"][1]
    return found


def _machine(scene: Scene, chosen: Mapping[str, float]) -> Machine:
    if is_spatial(scene):
        return in_space(scene, chosen, machine_of(line_part(scene), chosen))
    nominal = _nominal(scene, chosen)
    return as_built(scene, nominal) if scene.off else nominal


def _nominal(scene: Scene, chosen: Mapping[str, float]) -> Machine:
    number = _Numbers(chosen)
    both = {name: _body(name, body, number) for name, body in scene.bodies.items()}
    masses, weights = ({name: one[i] for name, one in both.items()} for i in (0, 1))
    only = next(iter(masses)) if len(masses) == 1 else None
    own = [name for name, link in scene.links.items() if not any(end in scene.absorbers for end in link.between)]
    joints = {name: _joint(name, scene.links[name], number, masses, only) for name in own}
    alone = len(masses) == 1 and not scene.absorbers
    machine = (LoneMachine if alone else Machine)(masses, tuple(joints.values()), tuple(scene.bases), weights)
    if scene.structures:
        from vibopt.mechanics.hosted import HostedMachine

        machine = HostedMachine(masses, machine.joints, machine.bases, weights, carriers=_carriers(scene))
    if not scene.absorbers:
        return machine
    while len(machine.tuned) < len(scene.absorbers):
        machine = _with_absorbers(scene, machine, number, joints)
    for name, link in scene.links.items():
        if name not in own:
            joints[name] = _joint(name, link, number, machine.masses, only)
    ordered = tuple(joints[name] for name in (*scene.absorbers, *scene.links))
    return replace(machine, joints=ordered)


def _carriers(scene: Scene) -> dict[str, Carrier]:
    """The structures, each with its matrices in full where it has them."""
    from vibopt.mechanics.host import Reduction
    from vibopt.mechanics.hosted import Carrier

    top, modes = looked_at(scene)
    found = {}
    for name, table in scene.structures.items():
        if table.modes is not None:
            found[name] = Carrier(table.modal)
            continue
        host = table.host(top, modes)
        assert isinstance(host, Reduction)
        found[name] = Carrier(host.coordinates, table.whole, np.array(list((table.points or {}).values())))
    return found


def _body(name: str, body: BodyTable, number: _Numbers) -> tuple[float, float]:
    """What resists acceleration, and the part of it on which gravity acts [kg] or [kg m^2]."""
    if body.disc is not None:
        return 0.5 * body.disc.mass.value * (0.5 * body.disc.diameter.value) ** 2, 0.0
    if body.inertia is not None:
        assert isinstance(body.inertia, (Fact, Choice))
        return number(f"bodies.{name}.inertia", body.inertia), 0.0
    mass = number(f"bodies.{name}.mass", body.mass) if body.weight is None else body.weight.value / GRAVITY
    if body.rolling is not None:
        return mass + body.rolling.inertia.value / body.rolling.radius.value**2, mass
    return mass, mass


def _shaft(path: str, shaft: Shaft, number: _Numbers) -> float:
    """G J / L with the polar moment of area from the two radii [N m/rad]."""
    outer = 0.5 * number(f"{path}.diameter", shaft.diameter)
    inner = outer * shaft.inner_ratio.value if shaft.inner_ratio is not None else 0.0
    if shaft.inner_diameter is not None:
        inner = 0.5 * shaft.inner_diameter.value
    polar = 0.5 * math.pi * (outer**4 - inner**4)
    return shaft.shear_modulus.value * polar / number(f"{path}.length", shaft.length)


def _beam(beam: Beam) -> float:
    """Force over deflection, from finite elements [N/m]."""
    long = beam.length.value
    at = long if beam.kind == "cantilever" else 0.5 * long
    moment = beam.area_moment
    return 1.0 / sag_under_load(beam.kind, long, at if beam.at is None else beam.at.value, beam.modulus.value * moment)


def _joint(name: str, link: LinkTable, number: _Numbers, masses: Mapping[str, float], only: str | None) -> Joint:
    def given(key: str, default: float = 0.0) -> float:
        return number(f"links.{name}.{key}", getattr(link, key), default)

    count, ratio = given("count", 1.0), given("damping_ratio")
    single = given("stiffness") or given("torsional_stiffness")
    if link.shaft is not None:
        single = _shaft(f"links.{name}.shaft", link.shaft, number)
    if link.beam is not None:
        single = _beam(link.beam)
    stiffness = count * single
    part = link.part

    def of_part(key: str, default: float = 0.0) -> float:
        return number(f"links.{name}.part.{key}", getattr(part, key, None), default)

    static = of_part("dynamic_to_static", 1.0) if part is not None else given("dynamic_to_static", 1.0)
    damping = count * (given("damping") or given("torsional_damping"))
    relative = link.relative_to or only
    if relative is not None and stiffness > 0.0:
        critical = 2.0 * float((stiffness * masses[relative]) ** 0.5)
        damping = damping or ratio * critical
        ratio = ratio or damping / critical
    return Joint(
        name=name,
        ends=link.between,
        stiffness=stiffness,
        damping=damping,
        loss_factor=given("loss_factor"),
        static_stiffness=stiffness / static,
        count=count,
        damping_ratio=ratio,
        price=count * of_part("price"),
    )


def _with_absorbers(scene: Scene, machine: Machine, number: _Numbers, joints: dict[str, Joint]) -> Machine:
    """The machine with the absorbers on it whose hosts are there."""
    for name, table in scene.absorbers.items():
        under = {table.host, table.relative_to or table.host}
        if name in machine.tuned or not under <= {*machine.places}:
            continue
        joint, mass, tuned = _absorber(scene, machine, name, table, number)
        joints[name] = joint
        hangs = table.host not in machine.masses or machine.weights.get(table.host, 0.0) > 0.0
        heavy = mass if hangs else 0.0
        machine = replace(
            machine,
            masses={**machine.masses, name: mass},
            weights={**machine.weights, name: heavy},
            tuned={**machine.tuned, name: tuned},
        )
    return machine


def _absorber(
    scene: Scene, machine: Machine, name: str, table: AbsorberTable, number: _Numbers
) -> tuple[Joint, float, Tuned]:
    """Its spring and damper, its mass, and what its tuning and its mass ratio refer to."""

    def given(key: str) -> float:
        return number(f"absorbers.{name}.{key}", getattr(table, key))

    base = machine.masses.get(table.relative_to or table.host, 0.0)
    mass = given("mass") or given("inertia") or given("mass_ratio") * base
    if table.disc is not None:
        mass = 0.5 * table.disc.mass.value * (0.5 * table.disc.diameter.value) ** 2
    reference = _reference(scene, machine, table)
    stiffness = given("stiffness") or given("torsional_stiffness")
    own = given("frequency") or given("tuning") * reference
    if own:
        stiffness = mass * own * own
    if table.length is not None:
        stiffness = mass * GRAVITY / given("length")
    if table.shaft is not None:
        stiffness = _shaft(f"absorbers.{name}.shaft", table.shaft, number)
    critical = 2.0 * mass * math.sqrt(stiffness / mass)
    damping = given("damping") or given("torsional_damping") or given("damping_ratio") * critical
    joint = Joint(
        name=name,
        ends=(table.host, name),
        stiffness=stiffness,
        damping=damping,
        loss_factor=given("loss_factor"),
        static_stiffness=stiffness,
        count=1.0,
        damping_ratio=damping / critical if critical else 0.0,
    )
    return joint, mass, Tuned(base, reference)


def _reference(scene: Scene, machine: Machine, table: AbsorberTable) -> float:
    """What the tuning refers to [rad/s]; 0 where there is nothing."""
    if table.tuning_to is not None:
        return table.tuning_to.value
    bare = replace(
        machine,
        masses={name: machine.masses[name] for name in scene.bodies},
        joints=tuple(one for one in machine.joints if not any(end in scene.absorbers for end in one.ends)),
    )
    found = bare.natural_frequencies()
    mode = table.mode or 1
    return float(found[mode - 1]) if mode <= len(found) else 0.0
