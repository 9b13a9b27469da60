"""Motion of a body, and motion across a link; peak amplitudes."""

from typing import ClassVar

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.mechanics.built import Course, Motion
from vibopt.mechanics.machine import Machine, is_in_space
from vibopt.mechanics.model import Model
from vibopt.responses.response import HarmonicResponse
from vibopt.responses.response_rows import across_link, along, at_point
from vibopt.signals import Output
from vibopt.values.directions import Direction


class MotionOf(HarmonicResponse):
    """Motion of a body along its line or about its axis.

    Keys
    ----
    of: The body, or a point: `of = "press"`.
    """

    of: str
    dimension: ClassVar[str] = "length"
    amplitude: ClassVar[bool] = True
    power: ClassVar[int] = 0
    moves: ClassVar[str] = "line"
    in_planes: ClassVar[bool] = True
    turns: ClassVar[bool] = False

    @property
    def way(self) -> Direction | None:
        """In space, the direction or the axis that is asked about, of kinds that have one."""
        way: Direction | None = getattr(self, self.in_space, None)
        return way

    def places(self) -> dict[str, tuple[str, str]]:
        return {"of": (self.of, "body")}

    def output(self, model: Model) -> Output:
        if self.way is None:
            return at_point(model, self.of, self.power)
        return along(model, self.of, self.way, power=self.power, turn=self.turns)

    def measure(self, machine: Machine, motion: Motion) -> ComplexArray:
        power = (1j * motion.omega) ** self.power
        if self.way is None:
            return np.asarray(motion.points[self.of] * power)
        assert is_in_space(machine)
        return np.asarray(machine.moved(self.of, self.way, motion.points, turn=self.turns) * power)

    def trace(self, machine: Machine, course: Course) -> FloatArray:
        if self.way is None:
            return np.asarray(course.points[self.of][self.power])
        assert is_in_space(machine)
        return np.asarray(machine.moved(self.of, self.way, course.points, turn=self.turns)[self.power])


class Displacement(MotionOf):
    """`response = "displacement"`: of a body, absolute [m] peak; in space along `direction`.

    Keys
    ----
    direction: In space, along which it is asked: `direction = "y"`.
    """

    direction: Direction | None = None
    against_friction: ClassVar[str] = ""
    in_space: ClassVar[str] = "direction"
    twin: ClassVar[str] = "rotation"
    noise_twin: ClassVar[str] = "rms_displacement"
    transient_twin: ClassVar[str] = "peak_displacement"


class Velocity(Displacement):
    """`response = "velocity"`: of a body, absolute [m/s] peak."""

    dimension: ClassVar[str] = "velocity"
    power: ClassVar[int] = 1
    noise_twin: ClassVar[str] = "rms_velocity"
    transient_twin: ClassVar[str] = "peak_velocity"


class Acceleration(Displacement):
    """`response = "acceleration"`: of a body, absolute [m/s^2] peak."""

    dimension: ClassVar[str] = "acceleration"
    power: ClassVar[int] = 2
    noise_twin: ClassVar[str] = "rms_acceleration"
    transient_twin: ClassVar[str] = "peak_acceleration"


class RelativeDisplacement(HarmonicResponse):
    """`response = "relative_displacement"`: across a link (rattle space) [m] peak.

    Keys
    ----
    across: The link: `across = "mount"`.
    """

    across: str
    against_friction: ClassVar[str] = ""
    dimension: ClassVar[str] = "length"
    amplitude: ClassVar[bool] = True
    moves: ClassVar[str] = "line"
    in_planes: ClassVar[bool] = True
    twin: ClassVar[str] = "twist"
    noise_twin: ClassVar[str] = "rms_relative_displacement"
    transient_twin: ClassVar[str] = "peak_relative_displacement"

    def places(self) -> dict[str, tuple[str, str]]:
        return {"across": (self.across, "link")}

    def output(self, model: Model) -> Output:
        return across_link(model, self.across)

    def measure(self, machine: Machine, motion: Motion) -> ComplexArray:
        return machine.stretch_of(machine.joint(self.across), motion)

    def trace(self, machine: Machine, course: Course) -> FloatArray:
        return np.asarray(machine.stretch_course(machine.joint(self.across), course)[0])
