"""What the parts of catalogues cost."""

from typing import ClassVar

from vibopt.forms import Form, Monomials
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import Model
from vibopt.responses.response import Response
from vibopt.signals import Combine, Drive


class TotalPrice(Response):
    """`response = "price"`: of all bought parts together, number of mounts times price."""

    dimension: ClassVar[str] = "price"
    priced: ClassVar[bool] = True
    against_friction: ClassVar[str] = ""

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        return Monomials.of(model, *(one for (_, word), one in model.properties.items() if word == "price"))

    def measure_static(self, machine: Machine) -> float:
        from vibopt.mechanics.rigid import SpaceMachine

        mounts = machine.mounts if isinstance(machine, SpaceMachine) else ()
        return float(sum(joint.price for joint in machine.joints) + sum(mount.price for mount in mounts))
