"""Motion of a body; peak amplitudes."""

from typing import ClassVar

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.mechanics.built import Course, Motion
from vibopt.mechanics.machine import Machine, is_in_space
from vibopt.mechanics.model import Model
from vibopt.responses.response import HarmonicResponse
from vibopt.responses.response_rows import along, at_point
from vibopt.signals import Output
from vibopt.values.directions import Direction


class MotionOf(HarmonicResponse):
    """Motion of a body along its line or about its axis.

    Keys
    ----
    of: The body, or a point: `of = "press"`.
    """

    of: str
    names: ClassVar[dict[str, str]] = {"of": "body"}
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
