"""Deflection under the weights alone."""

from __future__ import annotations

from typing import ClassVar

from vibopt.forms import Combine, Drive, Form, StaticRow
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import Model
from vibopt.responses.kind import Response


class StaticDeflection(Response):
    """`response = "static_deflection"`: sag of a body, or compression of a link, under all weights [m].

    The size of it, with the static stiffness of every link.
    """

    of: str
    dimension: ClassVar[str] = "length"

    def places(self) -> dict[str, tuple[str, str]]:
        return {"of": (self.of, "body or link")}

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        if self.of in model.links:
            return StaticRow(model.links[self.of])
        return StaticRow(model.points[self.of])

    def measure_static(self, machine: Machine) -> float:
        sag = machine.sag()
        if sag is None:
            return float("inf")
        for joint in machine.joints:
            if joint.name == self.of:
                return abs(sag.get(joint.ends[1], 0.0) - sag.get(joint.ends[0], 0.0))
        return abs(sag[self.of])
