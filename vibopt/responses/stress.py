"""Stress in what bends or twists between two points: shafts and beams that the file gives by their sizes."""

from dataclasses import replace
from typing import ClassVar

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.forms import Form, Monomials, StaticLoad
from vibopt.mechanics.machine import Course, Machine, Motion
from vibopt.mechanics.model import STIFFNESS, Model, stressed
from vibopt.responses.motion import RelativeDisplacement
from vibopt.responses.response import HarmonicResponse, RandomResponse, Response, TransientResponse
from vibopt.responses.static_deflection import StaticDeflection
from vibopt.signals import Combine, Drive, Output


class _OfBeam(Response):
    """What is asked of the link with a beam.

    Keys
    ----
    of: The link with the beam, or with the shaft that twists: `of = "shaft"`.
    """

    of: str
    dimension: ClassVar[str] = "stress"
    moves: ClassVar[str] = "line"
    of_link: ClassVar[bool] = True

    def places(self) -> dict[str, tuple[str, str]]:
        return {"of": (self.of, "link")}


class BendingStress(_OfBeam, HarmonicResponse):
    """`response = "bending_stress"`: greatest in a beam or shaft that bends [Pa] peak.

    Dynamic part only, without that of the weight, at the outermost fibre where the moment is greatest; of the shape
    under a static load.  Of a shaft that whirls alike in both planes it goes round with the shaft.
    """

    amplitude: ClassVar[bool] = True
    against_friction: ClassVar[str] = ""
    twin: ClassVar[str] = "shear_stress"
    noise_twin: ClassVar[str] = "rms_bending_stress"
    transient_twin: ClassVar[str] = "peak_bending_stress"

    @property
    def _stretch(self) -> RelativeDisplacement:
        return RelativeDisplacement(response="relative_displacement", across=self.of)

    def output(self, model: Model) -> Output:
        return replace(self._stretch.output(model), shared_by=stressed(self.of))

    def measure(self, machine: Machine, motion: Motion) -> ComplexArray:
        return self._stretch.measure(machine, motion) * machine.joint(self.of).stress

    def trace(self, machine: Machine, course: Course) -> FloatArray:
        return self._stretch.trace(machine, course) * machine.joint(self.of).stress


class StaticBendingStress(_OfBeam):
    """`response = "static_bending_stress"`: greatest in a beam or shaft under all weights [Pa].

    As the machine stands upright along its line.  In a shaft that turns every fibre has it to and fro once a turn.
    """

    against_friction: ClassVar[str] = "is not known, for friction holds the weight anywhere near where the spring would"
    sags: ClassVar[bool] = True

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        (spring,) = (one for one in model.terms if one.owner == self.of and one.kind == STIFFNESS)
        stress = model.counts[stressed(self.of)] ** -1.0
        scale = stress.scale * spring.static_scale / spring.scale
        return StaticLoad(model.links[self.of], Monomials(np.array([scale]), stress.row(model.n_vars)[None, :]))

    def measure_static(self, machine: Machine) -> float:
        joint = machine.joint(self.of)
        stretch = StaticDeflection(response="static_deflection", of=self.of).measure_static(machine)
        return stretch * joint.stress * joint.static_stiffness / joint.stiffness


class ShearStress(BendingStress):
    """`response = "shear_stress"`: greatest in a round shaft that twists [Pa] peak, the dynamic part at its surface."""

    moves: ClassVar[str] = "axis"
    twin: ClassVar[str] = "bending_stress"
    noise_twin: ClassVar[str] = ""
    transient_twin: ClassVar[str] = ""


class RmsBendingStress(_OfBeam, RandomResponse):
    """`response = "rms_bending_stress"`: greatest in a beam or shaft that bends [Pa] rms."""

    @property
    def steady(self) -> HarmonicResponse:
        return BendingStress(response="bending_stress", of=self.of)


class PeakBendingStress(_OfBeam, TransientResponse):
    """`response = "peak_bending_stress"`: greatest in a beam or shaft that bends, the greatest in time [Pa]."""

    @property
    def steady(self) -> HarmonicResponse:
        return BendingStress(response="bending_stress", of=self.of)


__all__ = ["BendingStress", "PeakBendingStress", "RmsBendingStress", "ShearStress", "StaticBendingStress"]
