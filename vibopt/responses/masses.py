"""Masses: of the whole machine, and of one body of it."""

from typing import ClassVar

from vibopt.forms import Form
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import INERTIA, Model
from vibopt.responses.parameters import owned_by, sum_of
from vibopt.responses.response import Response
from vibopt.signals import Combine, Drive


class TotalMass(Response):
    """`response = "total_mass"`: of all bodies, absorbers, rotors and beams with a mass [kg].

    What turns has an inertia instead.
    """

    dimension: ClassVar[str] = "mass"
    sums: ClassVar[tuple[str, ...]] = ("bodies", "absorbers", "rotors")
    against_friction: ClassVar[str] = ""

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        return sum_of(model, [term for term in model.terms if term.kind == INERTIA and term.static_scale])

    def measure_static(self, machine: Machine) -> float:
        beams = sum(joint.count * joint.borne.mass for joint in machine.joints if joint.borne is not None)
        return sum(machine.weights.values()) - sum(machine.carried.values()) + beams + machine.spinning


class Mass(Response):
    """`response = "mass"`: of one body or absorber [kg]; of several together ask `absorber_mass` or `total_mass`.

    Keys
    ----
    of: The body or absorber: `of = "press"`.
    """

    of: str
    names: ClassVar[dict[str, str]] = {"of": "mass"}
    against_friction: ClassVar[str] = ""
    dimension: ClassVar[str] = "mass"
    moves: ClassVar[str] = "line"
    twin: ClassVar[str] = "inertia"
    in_space: ClassVar[str] = "body"

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        return owned_by(model, self.of, INERTIA, weighs=True)

    def measure_static(self, machine: Machine) -> float:
        return machine.weights[self.of] - machine.carried.get(self.of, 0.0)
