"""What turns: rotations, twists and moments, and the properties of shafts and discs.  Peak amplitudes."""

from typing import ClassVar

import numpy as np

from vibopt.arrays import ComplexArray
from vibopt.forms import Form
from vibopt.mechanics.built import Motion
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import INERTIA, Model, Term
from vibopt.responses.motion import MotionOf
from vibopt.responses.parameters import Damping, Stiffness, owned_by
from vibopt.responses.relative_displacement import RelativeDisplacement
from vibopt.responses.response import HarmonicResponse, Response
from vibopt.responses.transmitted import Transmitted
from vibopt.signals import Combine, Drive, Output
from vibopt.values.directions import Direction


class Rotation(MotionOf):
    """`response = "rotation"`: of a body that turns, absolute [rad] peak; in space about `axis`.

    Keys
    ----
    axis: In space, about which it is asked: `axis = "x"`.
    """

    axis: Direction | None = None
    dimension: ClassVar[str] = "angle"
    moves: ClassVar[str] = "axis"
    in_space: ClassVar[str] = "axis"
    turns: ClassVar[bool] = True
    twin: ClassVar[str] = "displacement"


class Twist(RelativeDisplacement):
    """`response = "twist"`: across a link, one end against the other [rad] peak."""

    dimension: ClassVar[str] = "angle"
    moves: ClassVar[str] = "axis"
    twin: ClassVar[str] = "relative_displacement"
    noise_twin: ClassVar[str] = ""


class TransmittedMoment(Transmitted):
    """`response = "transmitted_moment"`: total over all links `into` a place, or in one shaft `through` a link.

    Dynamic part only [N m] peak.
    """

    dimension: ClassVar[str] = "moment"
    moves: ClassVar[str] = "axis"
    twin: ClassVar[str] = "transmitted_force"


class GearTorque(HarmonicResponse):
    """`response = "gear_torque"`: what the teeth hand to a body that is geared to another, at its speed [N m] peak.

    Dynamic part only: gears hammer where it is greater than the mean torque that they hand over.

    Keys
    ----
    of: The geared body: `of = "wheel"`.
    """

    of: str
    names: ClassVar[dict[str, str]] = {"of": "geared body"}
    dimension: ClassVar[str] = "moment"
    amplitude: ClassVar[bool] = True
    moves: ClassVar[str] = "axis"

    def output(self, model: Model) -> Output:
        """All inertia that turns with it behind the teeth, less the torques of the links there."""
        ratios, gears = {self.of: 1.0}, list(model.gears.items())
        for _ in gears:
            ratios |= {name: ratio * ratios[to] for name, (to, ratio) in gears if to in ratios}

        def balances(term: Term) -> float:
            if not term.across:
                return ratios.get(term.owner, 0.0)
            first, second = (ratios.get(end, 0.0) for end in model.ends[term.owner])
            return second - first

        return Output(np.zeros(model.n_coords), np.array([balances(term) for term in model.terms]))

    def measure(self, machine: Machine, motion: Motion) -> ComplexArray:
        from vibopt.mechanics.geared import GearedMachine

        assert isinstance(machine, GearedMachine)
        return machine.tooth_torque(self.of, motion)


class TorsionalStiffness(Stiffness):
    """`response = "torsional_stiffness"`: of one single shaft [N m/rad]."""

    dimension: ClassVar[str] = "torsional_stiffness"
    moves: ClassVar[str] = "axis"
    twin: ClassVar[str] = "stiffness"
    of_mount: ClassVar[str] = ""


class TorsionalDamping(Damping):
    """`response = "torsional_damping"`: viscous, of one single damper [N m s/rad]."""

    dimension: ClassVar[str] = "torsional_damping"
    moves: ClassVar[str] = "axis"
    twin: ClassVar[str] = "damping"
    of_mount: ClassVar[str] = ""


class Inertia(Response):
    """`response = "inertia"`: of one body that turns [kg m^2].

    Keys
    ----
    of: The body that turns: `of = "rotor"`.
    """

    of: str
    names: ClassVar[dict[str, str]] = {"of": "mass"}
    dimension: ClassVar[str] = "inertia"
    moves: ClassVar[str] = "axis"
    twin: ClassVar[str] = "mass"

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        return owned_by(model, self.of, INERTIA)

    def measure_static(self, machine: Machine) -> float:
        return machine.own(self.of)
