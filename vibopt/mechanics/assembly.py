"""Puts the machine as built together, part by part: what `ModelBuilder` is to the model, on the second route."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.mechanics.built import GROUND, Joint, PlaneBearing, Tuned
from vibopt.mechanics.lone import LoneMachine
from vibopt.mechanics.machine import Machine
from vibopt.records import dataclass

if TYPE_CHECKING:
    from vibopt.mechanics.hosted import Carrier
    from vibopt.mechanics.matrix_shaft import MatrixShaft
    from vibopt.mechanics.rigid_parts import Guided, Rigid, Spring3
    from vibopt.mechanics.shaft_waves import WhirlingShaft


def _nothing() -> FloatArray:
    return np.zeros(0)


@dataclass
class Assembly:
    """Masses, and the forces between them.

    only
        The one body of the machine; None of several.
    top, modes
        How high structures are looked at [rad/s], and how many of their lowest modes are asked for.
    alone
        Natural frequencies [rad/s] of the machine as said, without what is tuned to it.
    spatial, fixed
        Bases that move in any direction; places on bodies in space, by name: the body and the place [m].
    masses, weights
        What resists acceleration as built, by point, and the part of it on which gravity acts [kg] or [kg m^2].
    said
        The same masses as the file says them: what its ratios refer to.
    joints, tuned, bases
        As of `Machine`.
    guides
        Per absorber in space what carries it, a body or another one, and where [m].
    rigid, guided, mounts, groups
        As of `SpaceMachine`.
    carriers, shafts, bearings
        Structures, shafts of rotors, and bearings that are not alike in both planes, by name.
    gears
        As of `GearedMachine`.
    """

    only: str | None = None
    top: float = 1.0
    modes: int = 0
    alone: Callable[[], FloatArray] = _nothing
    spatial: tuple[str, ...] = ()
    fixed: dict[str, tuple[str, FloatArray]] = field(default_factory=dict)
    guides: Mapping[str, tuple[str, Sequence[float]]] = field(default_factory=dict)
    masses: dict[str, float] = field(default_factory=dict)
    weights: dict[str, float] = field(default_factory=dict)
    said: dict[str, float] = field(default_factory=dict)
    joints: dict[str, Joint] = field(default_factory=dict)
    tuned: dict[str, Tuned] = field(default_factory=dict)
    bases: list[str] = field(default_factory=list)
    rigid: dict[str, Rigid] = field(default_factory=dict)
    guided: dict[str, Guided] = field(default_factory=dict)
    mounts: list[Spring3] = field(default_factory=list)
    groups: dict[str, tuple[str, ...]] = field(default_factory=dict)
    carriers: dict[str, Carrier] = field(default_factory=dict)
    shafts: dict[str, WhirlingShaft | MatrixShaft] = field(default_factory=dict)
    bearings: dict[str, PlaneBearing] = field(default_factory=dict)
    gears: dict[str, tuple[str, float]] = field(default_factory=dict)

    def add_mass(self, name: str, mass: float, weight: float, said: float) -> None:
        """A mass that moves along the line or about the axis: as built, what of it weighs, and as said."""
        self.masses[name], self.weights[name], self.said[name] = mass, weight, said

    def add_rigid(self, name: str, body: Rigid, said: float) -> None:
        """A body in space, and its mass as the file says it."""
        self.rigid[name], self.weights[name], self.said[name] = body, body.mass, said

    def add_slider(self, joint: Joint, way: Sequence[float], mass: float, said: float) -> None:
        """A mass that slides along a direction in space on a spring and a damper, and its mass as the file says it."""
        from vibopt.mechanics.rigid_parts import Guided, Spring3

        name, (host, at) = joint.name, self.guides[joint.name]
        self.guided[name] = Guided(host, np.array(at), np.array(way), mass, joint)
        self.weights[name], self.said[name] = mass, said
        stiffness, damping = np.array([joint.stiffness]), np.array([joint.damping])
        lossy = joint.loss_factor
        spring = Spring3(name, (host, name), np.array(at), np.array([way]), stiffness, stiffness, damping, lossy)
        self.mounts.append(spring)

    def add_joint(self, joint: Joint) -> None:
        """Forces between two points, along the line or about the axis."""
        self.joints[joint.name] = joint

    def add_mounts(self, group: str, mounts: Sequence[Spring3]) -> None:
        """Forces between two places in space, several of one name."""
        self.mounts += mounts
        self.groups[group] = tuple(mount.name for mount in mounts)

    @property
    def points(self) -> set[str]:
        """What is there to be joined."""
        held = [point for carrier in self.carriers.values() for point in carrier.coordinates.points]
        held += [point for shaft in self.shafts.values() for point in shaft.points]
        return {GROUND, *self.masses, *self.rigid, *self.guided, *self.fixed, *self.bases, *held}

    def machine(self, order: Mapping[str, int], *, space: bool) -> Machine:
        """The whole; joints in an order by name, and `space` where anything has a place there."""
        joints = tuple(sorted(self.joints.values(), key=lambda one: order[one.name]))
        carried: dict[str, float] = {}
        for joint in joints:
            for end, mass in zip(joint.ends, joint.carried, strict=True):
                if mass and end in self.masses:
                    carried[end] = carried.get(end, 0.0) + mass
        masses, weights = ({k: m + carried.get(k, 0.0) for k, m in of.items()} for of in (self.masses, self.weights))
        core = (joints, tuple(self.bases), weights, self.tuned)
        if space:
            from vibopt.mechanics.rigid import SpaceMachine

            moves = [
                (name, i, own[2]) for name, rigid in self.rigid.items() for i, own in enumerate(rigid.moves, start=1)
            ]
            sliding = {name: slider.mass for name, slider in self.guided.items()}
            return SpaceMachine(
                {**masses, **{f"{name}.{i}": resists for name, i, resists in moves}, **sliding},
                *core,
                rigid=self.rigid,
                line=tuple(self.masses),
                guided=self.guided,
                carried=carried,
                mounts=tuple(self.mounts),
                groups=self.groups,
                fixed=self.fixed,
                spatial=self.spatial,
            )
        if self.bearings:
            from vibopt.mechanics.orbiting import OrbitingMachine

            return OrbitingMachine(self.masses, *core, shafts=self.shafts, bearings=self.bearings)
        if self.shafts:
            from vibopt.mechanics.rotating import RotatingMachine

            return RotatingMachine(self.masses, *core, shafts=self.shafts)
        if self.gears:
            from vibopt.mechanics.geared import GearedMachine

            return GearedMachine(masses, *core, carried=carried, gears=self.gears)
        if self.carriers:
            from vibopt.mechanics.hosted import HostedMachine

            return HostedMachine(masses, *core, carriers=self.carriers, carried=carried)
        return (LoneMachine if len(masses) == 1 else Machine)(masses, *core, carried=carried)
