"""What absorbers are asked for: their stroke, and how they are tuned."""

from typing import ClassVar

import numpy as np

from vibopt.arrays import ComplexArray
from vibopt.forms import Form, Monomials
from vibopt.mechanics.built import Motion
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import INERTIA, Model
from vibopt.responses.parameters import sum_of
from vibopt.responses.response import HarmonicResponse, Response
from vibopt.responses.response_rows import across_link
from vibopt.signals import Combine, Drive, Output


class Stroke(HarmonicResponse):
    """`response = "stroke"`: motion of an absorber against what it sits on [m] peak.

    Keys
    ----
    of: The absorber: `of = "tmd"`.
    """

    of: str
    names: ClassVar[dict[str, str]] = {"of": "absorber"}
    dimension: ClassVar[str] = "length"
    amplitude: ClassVar[bool] = True
    moves: ClassVar[str] = "line"
    twin: ClassVar[str] = "twist"
    noise_twin: ClassVar[str] = "rms_relative_displacement"

    def output(self, model: Model) -> Output:
        return across_link(model, self.of)

    def measure(self, machine: Machine, motion: Motion) -> ComplexArray:
        return machine.stretch_of(machine.joint(self.of), motion)


class OfAbsorber(Response):
    """A number that belongs to one absorber, one product of powers of the design variables.

    Keys
    ----
    of: The absorber: `of = "tmd"`.
    """

    of: str
    names: ClassVar[dict[str, str]] = {"of": "absorber"}

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        return Monomials.of(model, model.properties[self.of, self.response])


class OwnFrequency(OfAbsorber):
    """`response = "own_frequency"`: root of k/m of an absorber, on a host at rest [rad/s]."""

    dimension: ClassVar[str] = "angular_rate"
    unit_without: ClassVar[str] = "Hz"

    def measure_static(self, machine: Machine) -> float:
        return float(np.sqrt(machine.joint(self.of).stiffness / machine.own(self.of)))


class MassRatio(OfAbsorber):
    """`response = "mass_ratio"`: mass of an absorber over that of what it refers to."""

    refers_to: ClassVar[str] = "mass"

    def measure_static(self, machine: Machine) -> float:
        return machine.own(self.of) / machine.tuned[self.of].mass


class Tuning(OfAbsorber):
    """`response = "tuning"`: own frequency of an absorber over the frequency that it refers to."""

    refers_to: ClassVar[str] = "frequency"

    def measure_static(self, machine: Machine) -> float:
        own = float(np.sqrt(machine.joint(self.of).stiffness / machine.own(self.of)))
        return own / machine.tuned[self.of].frequency


class AbsorberMass(Response):
    """`response = "absorber_mass"`: of all absorbers together [kg]."""

    dimension: ClassVar[str] = "mass"
    sums: ClassVar[tuple[str, ...]] = ("absorbers",)

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        own = model.families.get("absorbers", ())
        weighing = [term for term in model.terms if term.kind == INERTIA and term.static_scale]
        return sum_of(model, [term for term in weighing if term.owner in own])

    def measure_static(self, machine: Machine) -> float:
        return float(sum(machine.weights[name] for name in machine.tuned))
