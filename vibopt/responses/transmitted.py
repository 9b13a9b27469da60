"""Dynamic force handed on by links, and its ratio to what shakes the machine."""

from dataclasses import replace
from math import log10
from typing import Any, ClassVar

import numpy as np
from pydantic import model_validator

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.mechanics.built import Course, Motion
from vibopt.mechanics.machine import Machine, is_in_space
from vibopt.mechanics.model import Model
from vibopt.responses.response import HarmonicResponse, Response
from vibopt.responses.response_rows import at_point, forces_along, link_forces
from vibopt.signals import Output
from vibopt.units import Quantity
from vibopt.values import word
from vibopt.values.directions import AXES, Direction
from vibopt.values.fields import KeyedError


def _into(model: Model, place: str) -> Output:
    signs = {}
    for name, (first, second) in model.ends.items():
        if place in (first, second):
            signs[name] = 1.0 if place == first else -1.0
    return link_forces(model, signs)


class IntoOrThrough(Response):
    """Total over all links `into` a place, or in one mount `through` a link.

    Keys
    ----
    into: The body, base or ground whose net force from all links is meant: `into = "ground"`. One of `into` and
        `through`.
    through: The link or mount; the force is that in each single mount: `through = "mount"`.
    """

    into: str | None = None
    through: str | None = None
    names: ClassVar[dict[str, str]] = {"into": "point", "through": "link"}
    dimension: ClassVar[str] = "force"

    @model_validator(mode="after")
    def _one_place(self) -> "IntoOrThrough":
        if (self.into is None) == (self.through is None):
            raise word('needs either into (a place) or through (a link). Write into = "ground".')
        return self


class Transmitted(IntoOrThrough, HarmonicResponse):
    """What links hand on."""

    amplitude: ClassVar[bool] = True

    def output(self, model: Model) -> Output:
        if self.into is not None:
            return _into(model, self.into)
        whole = link_forces(model, {self.through or "": -1.0})
        return replace(whole, shared_by=self.through or "")

    def measure(self, machine: Machine, motion: Motion) -> ComplexArray:
        if self.into is not None:
            return machine.force_into(self.into, motion)
        joint = machine.joint(self.through or "")
        return machine.joint_force(joint, motion) / joint.count

    def trace(self, machine: Machine, course: Course) -> FloatArray:
        if self.into is not None:
            return machine.force_course(self.into, course)
        joint = machine.joint(self.through or "")
        return machine.joint_course(joint, course) / joint.count


class TransmittedForce(Transmitted):
    """`response = "transmitted_force"`: total over all links `into` a place, or in one mount `through` a link.

    Dynamic part only [N] peak, without the weight; in space along `direction`.

    Keys
    ----
    direction: In space, along which it is asked: `direction = "z"`.
    """

    direction: Direction | None = None
    against_friction: ClassVar[str] = ""
    moves: ClassVar[str] = "line"
    in_planes: ClassVar[bool] = True
    twin: ClassVar[str] = "transmitted_moment"
    noise_twin: ClassVar[str] = "rms_force"
    transient_twin: ClassVar[str] = "peak_force"
    of_mount: ClassVar[str] = "each"

    def output(self, model: Model) -> Output:
        if self.direction is None:
            return super().output(model)
        if self.into is None:
            return forces_along(model, {f"{self.through}.{axis}": 1.0 for axis in AXES}, self.direction)
        signs = {name: 1.0 if self.into == two[0] else -1.0 for name, two in model.ends.items() if self.into in two}
        return forces_along(model, signs, self.direction)

    def measure(self, machine: Machine, motion: Motion) -> ComplexArray:
        if self.direction is None:
            return super().measure(machine, motion)
        assert is_in_space(machine)
        if self.into is not None:
            return np.asarray(machine.force_along(self.into, self.direction, motion))
        force: ComplexArray = machine.mount_force(machine.mount(self.through or ""), motion) @ self.direction
        return force

    def trace(self, machine: Machine, course: Course) -> FloatArray:
        if self.direction is None:
            return super().trace(machine, course)
        assert is_in_space(machine)
        if self.into is not None:
            return np.asarray(machine.force_along(self.into, self.direction, course))
        return np.asarray(machine.mount_force(machine.mount(self.through or ""), course) @ np.array(self.direction))


class Transmissibility(HarmonicResponse):
    """`response = "transmissibility"`: force ratio `into` a place, or motion ratio `of` a body over its base.

    Keys
    ----
    into: Force into it over the exciting force: `into = "ground"`. One of `into` and `of`.
    of: Motion of this body over that of its base: `of = "table"`.
    """

    into: str | None = None
    of: str | None = None
    names: ClassVar[dict[str, str]] = {"into": "point", "of": "body"}
    normalised: ClassVar[bool] = True
    against_friction: ClassVar[str] = ""

    @model_validator(mode="after")
    def _one_place(self) -> "Transmissibility":
        if (self.into is None) == (self.of is None):
            raise word('needs either into (force ratio) or of (motion ratio). Write into = "ground".')
        return self

    @property
    def ratio_to(self) -> tuple[str, str, str]:
        if self.into is not None:
            return "bodies", "transmissibility into a place is the force ratio to a force", ' Write of = "BODY".'
        moving = "transmissibility of a body is the motion ratio to a moving base"
        return "bases", moving, ' Write into = "ground".'

    def output(self, model: Model) -> Output:
        return _into(model, self.into) if self.into is not None else at_point(model, self.of or "")

    def measure(self, machine: Machine, motion: Motion) -> ComplexArray:
        if self.into is not None:
            return machine.force_into(self.into, motion)
        return motion.points[self.of or ""]

    def trace(self, machine: Machine, course: Course) -> FloatArray:
        if self.into is not None:
            return machine.force_course(self.into, course)
        return np.asarray(course.points[self.of or ""][0])


class Isolation(Transmissibility):
    """`response = "isolation"`: one minus the transmissibility, a share below 1; negative where it amplifies."""

    complement: ClassVar[bool] = True
    less_is_worse: ClassVar[bool] = True

    @classmethod
    def _check_unit(cls, unit: object) -> None:
        if unit == "dB":
            raise KeyedError("unit", unit, 'is of levels, but isolation is a share. Write "%".')
        super()._check_unit(unit)

    @classmethod
    def _read_bounds(cls, given: dict[str, Any]) -> dict[str, Quantity]:
        """Shares below 1: a level of them could mean what is handed on as well as what is kept back."""
        read = super()._read_bounds(given)
        for key, quantity in read.items():
            if quantity.unit == "dB":
                level = abs(20.0 * log10(quantity.value))
                share = f"{100.0 * (1.0 - 10.0 ** (-level / 20.0)):.4g} %"
                other = "at_most" if key == "at_least" else "at_least"
                raise KeyedError(
                    key, given[key],
                    f'is a level, but isolation is a share of 1. Write "{share}", or response = '
                    f'"transmissibility" with {other} = "{-level:.4g} dB".',
                )  # fmt: skip
            if quantity.value >= 1.0:
                meant = f'"{quantity.value:g} %"' if not quantity.unit and quantity.value < 100.0 else "less than 100 %"
                raise KeyedError(key, given[key], f"is as much as nothing coming through, or more. Write {meant}.")
        return read
