"""How two bodies move against each other in a natural mode."""

from typing import ClassVar

from pydantic import model_validator

from vibopt.forms import Form, ModeRatio
from vibopt.mechanics.free_motion import shape_ratio
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import Model
from vibopt.responses.response import Response
from vibopt.signals import Combine, Drive
from vibopt.values import word


class RatioInMode(Response):
    """`response = "mode_ratio"`: motion `of` a body over that of `relative_to`, in undamped mode number `mode`.

    Positive where both move the same way; infinite where the other stands still, or where the mode shares its
    frequency with another, so that it has no shape of its own.

    Keys
    ----
    of: The body whose motion stands above: `of = "second"`.
    relative_to: The body whose motion stands below: `relative_to = "first"`.
    mode: Number of the mode, 1 is the lowest.
    """

    of: str
    relative_to: str
    mode: int = 1
    names: ClassVar[dict[str, str]] = {"of": "body", "relative_to": "body"}
    signed: ClassVar[bool] = True

    @model_validator(mode="after")
    def _words(self) -> "RatioInMode":
        if self.mode < 1:
            raise word("has a mode below 1. Modes are counted from 1, the lowest.")
        return self

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        return ModeRatio(self.mode, model.points[self.of], model.points[self.relative_to])

    def measure_static(self, machine: Machine) -> float:
        return shape_ratio(*machine.mode_shapes(), self.mode, machine.row(self.of), machine.row(self.relative_to))
