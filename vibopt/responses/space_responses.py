"""What only machines in space are asked for: loads of mounts, tilt, travel, shares of energy, gaps between modes."""

from collections.abc import Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import model_validator

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.forms import EnergyShare, Form, ModeGap, StaticForce, StaticRow
from vibopt.mechanics.built import Course, Motion
from vibopt.mechanics.machine import Machine, is_in_space
from vibopt.mechanics.model import STIFFNESS, Model
from vibopt.responses.response import FEW_MODES, HarmonicResponse, Response
from vibopt.responses.response_rows import across_link, along_mount
from vibopt.signals import Combine, Drive, Output
from vibopt.values import word
from vibopt.values.directions import AXES, Direction, Vector

if TYPE_CHECKING:
    from vibopt.mechanics.rigid import SpaceMachine


def space(machine: Machine) -> "SpaceMachine":
    """The machine as one in space."""
    assert is_in_space(machine)
    return machine


class StaticLoadOfMount(Response):
    """`response = "static_load"`: what one mount carries under all weights [N], along its own axis.

    Positive where it presses up on what it carries, the first of its ends; below zero it is lifted.  With
    `direction` the force in that direction instead.  Of a group the worst single mount.

    Keys
    ----
    of: A mount, or a group: `of = "foot"`, or "foot.2".
    direction: Along which; its own axis without it: `direction = "z"`.
    """

    of: str
    direction: Direction | None = None
    names: ClassVar[dict[str, str]] = {"of": "mount"}
    dimension: ClassVar[str] = "force"
    other_bound: ClassVar[str] = " (or give the mount its rating)"
    moves: ClassVar[str] = "line"
    of_mount: ClassVar[str] = "each"

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        way = self._way(model.axes[f"{self.of}.z"])
        parts = {f"{self.of}.{axis}": float(model.axes[f"{self.of}.{axis}"] @ way) for axis in AXES}
        signs = [-parts.get(term.owner, 0.0) if term.kind == STIFFNESS else 0.0 for term in model.terms]
        return StaticForce(np.array(signs) * (-1.0 if self._hangs(model.ends[f"{self.of}.z"], model) else 1.0))

    def _way(self, own: object) -> Vector:
        """The direction asked for; of the mount's own axis the end that points up."""
        if self.direction is not None:
            return self.direction
        axis = np.asarray(own, dtype=float)
        up = axis if axis[2] >= 0.0 else -axis
        return float(up[0]), float(up[1]), float(up[2])

    @staticmethod
    def _hangs(ends: tuple[str, str], model: Model) -> bool:
        """Whether the support is named first, so that the second end is what is carried."""
        return not any(name == ends[0] or name.startswith(f"{ends[0]}.") for name in model.points)

    def measure_static(self, machine: Machine) -> float:
        built = space(machine)
        mount = built.mount(self.of)
        force = built.static_force(self.of)
        if force is None:
            return float("inf")
        turned = -1.0 if mount.ends[0] not in (*built.rigid, *built.line, *built.bases) else 1.0
        return turned * float(force @ np.array(self._way(mount.axes[2])))


class Tilt(Response):
    """`response = "tilt"`: rotation of a body about an axis under all weights [rad].

    Keys
    ----
    of: The body in space: `of = "genset"`.
    axis: About which: `axis = "x"`.
    """

    of: str
    axis: Direction
    names: ClassVar[dict[str, str]] = {"of": "body"}
    dimension: ClassVar[str] = "angle"
    moves: ClassVar[str] = "axis"
    in_space: ClassVar[str] = "whole"

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        return StaticRow(
            np.sum([p * model.points[f"{self.of}.r{axis}"] for p, axis in zip(self.axis, AXES, strict=True)], axis=0)
        )

    def measure_static(self, machine: Machine) -> float:
        down = machine.sag()
        if down is None:
            return float("inf")
        return abs(sum(part * down[f"{self.of}.r{axis}"] for part, axis in zip(self.axis, AXES, strict=True)))


class OfMount(Response):
    """How far a mount moves in itself: the most along any of its own axes, or along `direction` in space.

    Keys
    ----
    of: A mount, or a group: `of = "foot"`.
    direction: Along which; the most along any of its own axes without it: `direction = "z"`.
    """

    of: str
    direction: Direction | None = None
    names: ClassVar[dict[str, str]] = {"of": "mount"}
    dimension: ClassVar[str] = "length"
    moves: ClassVar[str] = "line"
    of_mount: ClassVar[str] = "axes"


class Travel(OfMount, HarmonicResponse):
    """`response = "travel"`: how far a mount moves in itself [m] peak: the most along any of its own axes.

    With `direction` along that direction in space.
    """

    other_bound: ClassVar[str] = " (or give the mount its gap)"
    amplitude: ClassVar[bool] = True
    noise_twin: ClassVar[str] = "rms_travel"
    transient_twin: ClassVar[str] = "peak_travel"

    def output(self, model: Model) -> Output:
        if self.direction is None:
            return across_link(model, self.of)
        return along_mount(model, self.of, self.direction)

    def measure(self, machine: Machine, motion: Motion) -> ComplexArray:
        return np.asarray(self._apart(space(machine), motion.points))

    def trace(self, machine: Machine, course: Course) -> FloatArray:
        return np.asarray(self._apart(space(machine), course.points)[0])

    def _apart(self, machine: "SpaceMachine", points: Mapping[str, Any]) -> Any:
        """How far the mount is apart, of motion as `points` has it, shape (...)."""
        if self.direction is not None:
            mount = machine.mount(self.of)
            return (machine.stretch(mount, points) @ mount.axes) @ np.array(self.direction)
        single, _, axis = self.of.rpartition(".")
        return machine.stretch(machine.mount(single), points)[..., AXES.index(axis)]


class EnergyShareOfBody(Response):
    """`response = "energy_share"`: the greatest part of a mode's kinetic energy in one motion of a body.

    Along `direction`, or about `axis`; 1 means that a mode is nothing but that motion.

    Keys
    ----
    of: The body in space: `of = "genset"`.
    direction: The motion along this direction: `direction = "z"`. One of `direction` and `axis`.
    axis: The turn about this axis: `axis = "x"`.
    """

    of: str
    direction: Direction | None = None
    axis: Direction | None = None
    names: ClassVar[dict[str, str]] = {"of": "body"}
    in_space: ClassVar[str] = "whole"

    @model_validator(mode="after")
    def _one_way(self) -> "EnergyShareOfBody":
        if (self.direction is None) == (self.axis is None):
            raise word('needs either direction or axis: which motion of the body? Write direction = "z".')
        return self

    @property
    def way(self) -> Vector:
        """Direction or axis."""
        way = self.direction or self.axis
        assert way is not None
        return way

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        kind = "r" if self.axis is not None else ""
        parts = zip(self.way, AXES, strict=True)
        row = np.sum([part * model.points[f"{self.of}.{kind}{one}"] for part, one in parts], axis=0)
        return EnergyShare(row, self.of)

    def measure_static(self, machine: Machine) -> float:
        return space(machine).energy_share(self.of, self.way, turn=self.axis is not None)


class FrequencySeparation(Response):
    """`response = "frequency_separation"`: least difference between neighbouring natural frequencies [rad/s]."""

    dimension: ClassVar[str] = "angular_rate"

    @property
    def modes(self) -> int:
        return FEW_MODES

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        return ModeGap()

    def measure_static(self, machine: Machine) -> float:
        found = machine.natural_frequencies()
        return min((float(b - a) for a, b in pairwise(found)), default=float("inf"))
