"""Greatest motions and forces over all time, under what comes once: pulses, drops, records."""

from typing import ClassVar

import numpy as np
from pydantic import model_validator

from vibopt.arrays import FloatArray
from vibopt.mechanics.machine import Course, Machine
from vibopt.responses.motion import Acceleration, Displacement, RelativeDisplacement, Velocity
from vibopt.responses.response import HarmonicResponse, TransientResponse
from vibopt.responses.transmitted import TransmittedForce
from vibopt.values import word


class PeakDisplacement(TransientResponse):
    """`response = "peak_displacement"`: of a body, absolute, the greatest in time [m].

    Keys
    ----
    of: The body: `of = "instrument"`.
    """

    of: str
    dimension: ClassVar[str] = "length"
    moves: ClassVar[str] = "line"
    power: ClassVar[int] = 0

    @property
    def steady(self) -> HarmonicResponse:
        return Displacement(response="displacement", of=self.of)

    def trace(self, machine: Machine, course: Course) -> FloatArray:
        return np.asarray(course.points[self.of][self.power])


class PeakVelocity(PeakDisplacement):
    """`response = "peak_velocity"`: of a body, absolute, the greatest in time [m/s].

    Keys
    ----
    of: The body: `of = "instrument"`.
    """

    dimension: ClassVar[str] = "velocity"
    power: ClassVar[int] = 1

    @property
    def steady(self) -> HarmonicResponse:
        return Velocity(response="velocity", of=self.of)


class PeakAcceleration(PeakDisplacement):
    """`response = "peak_acceleration"`: of a body, absolute, the greatest in time [m/s^2].

    Keys
    ----
    of: The body: `of = "instrument"`.
    """

    dimension: ClassVar[str] = "acceleration"
    power: ClassVar[int] = 2

    @property
    def steady(self) -> HarmonicResponse:
        return Acceleration(response="acceleration", of=self.of)


class PeakRelativeDisplacement(TransientResponse):
    """`response = "peak_relative_displacement"`: across a link (rattle space), the greatest in time [m].

    Keys
    ----
    across: The link: `across = "mount"`.
    """

    across: str
    dimension: ClassVar[str] = "length"
    moves: ClassVar[str] = "line"

    @property
    def steady(self) -> HarmonicResponse:
        return RelativeDisplacement(response="relative_displacement", across=self.across)

    def trace(self, machine: Machine, course: Course) -> FloatArray:
        first, second = (course.points.get(end, np.zeros((3, 1))) for end in machine.joint(self.across).ends)
        return np.asarray((second - first)[0])


class PeakForce(TransientResponse):
    """`response = "peak_force"`: total over all links `into` a place, or in one mount `through` a link [N].

    Dynamic part only, without the weight, the greatest in time.

    Keys
    ----
    into: A place: the sum over all links there. `into = "ground"`. One of `into` and `through`.
    through: A link: the force in one of its mounts: `through = "mount"`.
    """

    into: str | None = None
    through: str | None = None
    dimension: ClassVar[str] = "force"
    moves: ClassVar[str] = "line"

    @model_validator(mode="after")
    def _one_place(self) -> "PeakForce":
        if (self.into is None) == (self.through is None):
            raise word('needs either into (a place) or through (a link). Write into = "ground".')
        return self

    @property
    def steady(self) -> HarmonicResponse:
        return TransmittedForce(response="transmitted_force", into=self.into, through=self.through)

    def trace(self, machine: Machine, course: Course) -> FloatArray:
        if self.through is not None:
            joint = machine.joint(self.through)
            return machine.joint_course(joint, course) / joint.count
        if self.into is not None and self.into in machine.masses:
            outside = course.forces.get(self.into, np.zeros(1))
            return np.asarray(machine.masses[self.into] * course.points[self.into][2] - outside)
        signs = {True: 1.0, False: -1.0}
        into = [one for one in machine.joints if self.into in one.ends]
        forces = [signs[one.ends[1] == self.into] * machine.joint_course(one, course) for one in into]
        return np.asarray(sum(forces, np.zeros(1)))


__all__ = ["PeakAcceleration", "PeakDisplacement", "PeakForce", "PeakRelativeDisplacement", "PeakVelocity"]
