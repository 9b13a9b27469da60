"""Sag and whirl together."""

from typing import ClassVar

from vibopt.forms import Added, Form
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import Model
from vibopt.responses.motion import MotionOf
from vibopt.responses.static_deflection import StaticDeflection
from vibopt.signals import Combine, Drive


class CombinedDisplacement(MotionOf):
    """`response = "combined_displacement"`: sag and whirl of a body together, from where it would be weightless [m].

    Against a gap it is `at_most` the gap: the greatest of both together, under the body.
    """

    amplitude: ClassVar[bool] = False
    sags: ClassVar[bool] = True
    against_friction: ClassVar[str] = StaticDeflection.against_friction

    @property
    def _weight(self) -> StaticDeflection:
        return StaticDeflection(response="static_deflection", of=self.of)

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        return Added((super().form(model, drives, combine), self._weight.form(model, (), combine)))

    def beside(self, machine: Machine) -> float:
        return self._weight.measure_static(machine)
