"""Stress in what bends or twists between two points: shafts and beams that the file gives by their sizes."""

from dataclasses import replace
from typing import ClassVar

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.mechanics.machine import Course, Machine, Motion
from vibopt.mechanics.model import Model, stressed
from vibopt.responses.motion import RelativeDisplacement
from vibopt.responses.response import HarmonicResponse, RandomResponse, TransientResponse
from vibopt.signals import Output


class BendingStress(HarmonicResponse):
    """`response = "bending_stress"`: greatest in a beam or shaft that bends [Pa] peak.

    Dynamic part only, without that of the weight, at the outermost fibre where the moment is greatest; of the shape
    under a static load.  Of a shaft that whirls alike in both planes it goes round with the shaft.

    Keys
    ----
    of: The link with the beam: `of = "shaft"`.
    """

    of: str
    dimension: ClassVar[str] = "stress"
    amplitude: ClassVar[bool] = True
    moves: ClassVar[str] = "line"
    of_link: ClassVar[bool] = True
    against_friction: ClassVar[str] = ""
    twin: ClassVar[str] = "shear_stress"
    noise_twin: ClassVar[str] = "rms_bending_stress"
    transient_twin: ClassVar[str] = "peak_bending_stress"

    def places(self) -> dict[str, tuple[str, str]]:
        return {"of": (self.of, "link")}

    @property
    def _stretch(self) -> RelativeDisplacement:
        return RelativeDisplacement(response="relative_displacement", across=self.of)

    def output(self, model: Model) -> Output:
        return replace(self._stretch.output(model), shared_by=stressed(self.of))

    def measure(self, machine: Machine, motion: Motion) -> ComplexArray:
        return self._stretch.measure(machine, motion) * machine.joint(self.of).stress

    def trace(self, machine: Machine, course: Course) -> FloatArray:
        return self._stretch.trace(machine, course) * machine.joint(self.of).stress


class ShearStress(BendingStress):
    """`response = "shear_stress"`: greatest in a round shaft that twists [Pa] peak, the dynamic part at its surface.

    Keys
    ----
    of: The link with the shaft: `of = "shaft"`.
    """

    moves: ClassVar[str] = "axis"
    twin: ClassVar[str] = "bending_stress"
    noise_twin: ClassVar[str] = ""
    transient_twin: ClassVar[str] = ""


class RmsBendingStress(RandomResponse):
    """`response = "rms_bending_stress"`: greatest in a beam or shaft that bends [Pa] rms.

    Keys
    ----
    of: The link with the beam: `of = "shaft"`.
    """

    of: str
    dimension: ClassVar[str] = "stress"
    moves: ClassVar[str] = "line"
    of_link: ClassVar[bool] = True

    @property
    def steady(self) -> HarmonicResponse:
        return BendingStress(response="bending_stress", of=self.of)


class PeakBendingStress(TransientResponse):
    """`response = "peak_bending_stress"`: greatest in a beam or shaft that bends, the greatest in time [Pa].

    Keys
    ----
    of: The link with the beam: `of = "shaft"`.
    """

    of: str
    dimension: ClassVar[str] = "stress"
    moves: ClassVar[str] = "line"
    of_link: ClassVar[bool] = True

    @property
    def steady(self) -> HarmonicResponse:
        return BendingStress(response="bending_stress", of=self.of)


__all__ = ["BendingStress", "PeakBendingStress", "RmsBendingStress", "ShearStress"]
