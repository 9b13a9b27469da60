"""Motion across a link; peak amplitudes."""

from typing import ClassVar

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.mechanics.built import Course, Motion
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import Model
from vibopt.responses.response import HarmonicResponse
from vibopt.responses.response_rows import across_link
from vibopt.signals import Output


class RelativeDisplacement(HarmonicResponse):
    """`response = "relative_displacement"`: across a link (rattle space) [m] peak.

    Keys
    ----
    across: The link: `across = "mount"`.
    """

    across: str
    names: ClassVar[dict[str, str]] = {"across": "link"}
    against_friction: ClassVar[str] = ""
    dimension: ClassVar[str] = "length"
    amplitude: ClassVar[bool] = True
    moves: ClassVar[str] = "line"
    in_planes: ClassVar[bool] = True
    twin: ClassVar[str] = "twist"
    noise_twin: ClassVar[str] = "rms_relative_displacement"
    transient_twin: ClassVar[str] = "peak_relative_displacement"

    def output(self, model: Model) -> Output:
        return across_link(model, self.across)

    def measure(self, machine: Machine, motion: Motion) -> ComplexArray:
        return machine.stretch_of(machine.joint(self.across), motion)

    def trace(self, machine: Machine, course: Course) -> FloatArray:
        return np.asarray(machine.stretch_course(machine.joint(self.across), course)[0])
