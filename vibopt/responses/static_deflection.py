"""Deflection under the weights alone."""

from typing import ClassVar

import numpy as np

from vibopt.forms import Form, StaticRow
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import Model
from vibopt.responses.response import Response
from vibopt.signals import Combine, Drive
from vibopt.values.directions import AXES, Direction

_LEVEL = 1e-13
"""Part of a sag below which the difference of two is their rounding: what hangs below carries nothing."""


class StaticDeflection(Response):
    """`response = "static_deflection"`: sag of a body, or compression of a link, under all weights [m].

    The size of it, with the static stiffness of every link.

    Keys
    ----
    of: A link (how far it is compressed) or a body or point (how far it sags): `of = "mount"`.
    direction: In space, along which; z without it: `direction = "z"`.
    """

    of: str
    direction: Direction = (0.0, 0.0, 1.0)
    names: ClassVar[dict[str, str]] = {"of": "body or link"}
    dimension: ClassVar[str] = "length"
    against_friction: ClassVar[str] = "is not known, for friction holds the weight anywhere near where the spring would"
    moves: ClassVar[str] = "line"
    twin: ClassVar[str] = "rotation"
    in_space: ClassVar[str] = "place"
    of_mount: ClassVar[str] = "axis"
    sags: ClassVar[bool] = True

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        if self.of in model.links:
            return StaticRow(model.links[self.of])
        if f"{self.of}.z" in model.points:
            rows = [part * model.points[f"{self.of}.{axis}"] for part, axis in zip(self.direction, AXES, strict=True)]
            return StaticRow(np.sum(rows, axis=0))
        return StaticRow(model.points[self.of])

    def measure_static(self, machine: Machine) -> float:
        sag = machine.sag()
        if sag is None:
            return float("inf")
        for joint in machine.joints:
            if joint.name == self.of:
                first, second = (sag.get(end, 0.0) for end in joint.ends)
                gap = abs(second - first)  # of one machine, or of many
                return gap * (gap > _LEVEL * abs(first))
        return abs(sag[self.of]) if self.of in sag else self._in_space(machine, sag)

    def _in_space(self, machine: Machine, sag: dict[str, float]) -> float:
        """Of a place along the direction; of a mount, one own axis of it, or an absorber, force over stiffness."""
        from vibopt.mechanics.rigid import SpaceMachine

        assert isinstance(machine, SpaceMachine)
        slides = self.of in machine.guided
        if f"{self.of}.z" in sag and not slides:
            return abs(sum(part * sag[f"{self.of}.{axis}"] for part, axis in zip(self.direction, AXES, strict=True)))
        single, _, axis = self.of.rpartition(".")
        k, name = (0, self.of) if slides else (AXES.index(axis), single)
        force, mount = machine.static_force(name), machine.mount(name)
        assert force is not None
        return abs(float(mount.axes[k] @ force)) / float(mount.static_stiffness[k])
