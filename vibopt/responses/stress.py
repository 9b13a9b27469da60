"""Stress in what bends or twists between two points: shafts and beams that the file gives by their sizes."""

from dataclasses import replace
from typing import ClassVar, Literal

import numpy as np
from pydantic import field_validator

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.forms import Added, Form, Monomials, StaticBending, StaticLoad, StaticMoment
from vibopt.mechanics.built import Course, Joint, Motion
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import INERTIA, STIFFNESS, Model, forced, stressed
from vibopt.mechanics.monomial import Monomial
from vibopt.responses.relative_displacement import RelativeDisplacement
from vibopt.responses.response import HarmonicResponse, RandomResponse, Response, TransientResponse, UnsteadyResponse
from vibopt.responses.response_rows import forces_of_beam
from vibopt.signals import Combine, Drive, Output
from vibopt.values.fields import complaint


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
    names: ClassVar[dict[str, str]] = {"of": "link"}


class BendingStress(_OfBeam, HarmonicResponse):
    """`response = "bending_stress"`: greatest in a beam or shaft that bends [Pa] peak.

    Dynamic part only, without that of the weight, at the outermost fibre where a force at its load bends it most; with
    the forces of its own mass, where it has one.  Of a shaft that whirls alike in both planes it goes round with it.
    Of a rotor it is the greatest at its stations, discs and ends of sections, on either side of each.
    """

    names: ClassVar[dict[str, str]] = {"of": "link or rotor"}
    of_rotor: ClassVar[bool] = True
    in_planes: ClassVar[bool] = True
    amplitude: ClassVar[bool] = True
    against_friction: ClassVar[str] = ""
    twin: ClassVar[str] = "shear_stress"
    noise_twin: ClassVar[str] = "rms_bending_stress"
    transient_twin: ClassVar[str] = "peak_bending_stress"

    @property
    def _stretch(self) -> RelativeDisplacement:
        return RelativeDisplacement(response="relative_displacement", across=self.of)

    def output(self, model: Model) -> Output:
        if "@" in self.of:
            return Output(np.zeros(model.n_coords), _tilting(model, self.of), shared_by=stressed(self.of))
        if (self.of, "stress") in model.readings:
            return replace(forces_of_beam(model, self.of, "stress"), shared_by=forced(self.of))
        return self.of_shape(model)

    def of_shape(self, model: Model) -> Output:
        """That of the shape under a static load alone, as it is followed in time and shaken by noise."""
        return replace(self._stretch.output(model), shared_by=stressed(self.of))

    def measure(self, machine: Machine, motion: Motion) -> ComplexArray:
        if "@" in self.of:
            return machine.stress_at(self.of, motion)
        joint, stress = machine.joint(self.of), self.measured_shape(machine, motion)
        return stress - _inert(machine, joint, joint.borne.stress, motion) if joint.borne is not None else stress

    def measured_shape(self, machine: Machine, motion: Motion) -> ComplexArray:
        """As `of_shape`, on the built machine."""
        return self._stretch.measure(machine, motion) * machine.joint(self.of).stress

    def trace(self, machine: Machine, course: Course) -> FloatArray:
        return self._stretch.trace(machine, course) * machine.joint(self.of).stress


class StaticBendingStress(_OfBeam):
    """`response = "static_bending_stress"`: greatest in a beam or shaft under all weights [Pa].

    As the machine stands upright along its line.  In a shaft that turns every fibre has it to and fro once a turn.
    Of a rotor it is the greatest at its stations, discs and ends of sections, on either side of each.
    """

    against_friction: ClassVar[str] = "is not known, for friction holds the weight anywhere near where the spring would"
    names: ClassVar[dict[str, str]] = {"of": "link or rotor"}
    of_rotor: ClassVar[bool] = True
    sags: ClassVar[bool] = True

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        if "@" in self.of:
            pulls = np.where(model.kinds == STIFFNESS, _tilting(model, self.of), 0.0)
            return StaticBending(pulls, Monomials.of(model, model.counts[stressed(self.of)] ** -1.0))
        (spring,) = (term for term in model.terms if term.owner == self.of and term.kind == STIFFNESS)
        stress = model.counts[stressed(self.of)] ** -1.0
        pulled = Monomials.of(model, stress.times(spring.static_scale / spring.scale))
        if (self.of, "stress") not in model.readings:
            return StaticLoad(model.links[self.of], pulled)
        weighs = next(
            term for term in model.terms if term.owner == self.of and term.kind == INERTIA and term.static_scale
        )
        alone = -model.readings[self.of, "stress"][1]
        sagging = Monomial(weighs.scale, dict(enumerate(weighs.exponents))) * model.counts[forced(self.of)] ** -1.0
        return StaticMoment(-model.links[self.of], pulled, Monomials.of(model, sagging.times(GRAVITY * alone)))

    def measure_static(self, machine: Machine) -> float:
        if "@" in self.of:
            return machine.weight_stress_at(self.of)
        joint, sag = machine.joint(self.of), machine.sag()
        if sag is None:
            return float("inf")
        stretch = sag.get(joint.ends[0], 0.0) - sag.get(joint.ends[1], 0.0)
        own = GRAVITY * joint.borne.stress[1] if joint.borne is not None else 0.0
        return abs(stretch * joint.stress * joint.static_stiffness / joint.stiffness + own)


class CombinedBendingStress(BendingStress):
    """`response = "combined_bending_stress"`: the greatest of weight and whirl together in a shaft that bends [Pa].

    The whirl bends one fibre steadily, the weight every fibre to and fro once a turn: where both are greatest, at the
    worst turn, they add up to it.
    """

    against_friction: ClassVar[str] = StaticBendingStress.against_friction
    in_planes: ClassVar[bool] = False
    amplitude: ClassVar[bool] = False
    sags: ClassVar[bool] = True
    twin: ClassVar[str] = ""
    noise_twin: ClassVar[str] = ""
    transient_twin: ClassVar[str] = ""

    @property
    def _weight(self) -> StaticBendingStress:
        return StaticBendingStress(response="static_bending_stress", of=self.of)

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        return Added((super().form(model, drives, combine), self._weight.form(model, (), combine)))

    def beside(self, machine: Machine) -> float:
        return self._weight.measure_static(machine)


class BearingForce(_OfBeam, HarmonicResponse):
    """`response = "bearing_force"`: on one of the two supports of a beam or shaft that bends [N] peak.

    Dynamic part only; of spring, damper and mass of the link, as forces at its load go to either support.

    Keys
    ----
    bearing: Which one, as the beam is written down, from the left: `bearing = "right"`.
    """

    bearing: Literal["left", "right"]
    dimension: ClassVar[str] = "force"
    amplitude: ClassVar[bool] = True
    against_friction: ClassVar[str] = "is shared by shaft and friction, and where the friction acts nobody said"

    @field_validator("bearing", mode="before")
    @classmethod
    def _side(cls, given: object) -> object:
        if given not in ("left", "right"):
            raise complaint('is neither "left" nor "right". Write which support is meant.')
        return given

    def output(self, model: Model) -> Output:
        return replace(forces_of_beam(model, self.of, self.bearing), shared_by=self.of)

    def measure(self, machine: Machine, motion: Motion) -> ComplexArray:
        joint = machine.joint(self.of)
        assert joint.borne is not None
        shares = joint.borne.left if self.bearing == "left" else joint.borne.right
        elastic = joint.dynamic(motion.omega) + motion.omega**2 * joint.inertance
        pulled = elastic * machine.stretch_of(joint, motion) / joint.count
        return shares[0] * pulled - _inert(machine, joint, shares, motion)


def _inert(machine: Machine, joint: Joint, read: tuple[float, float, float], motion: Motion) -> ComplexArray:
    """What the mass of a beam adds to what its load does, in the direction of its load."""
    support, deflected = machine.position(joint.ends[1], motion), -machine.stretch_of(joint, motion)
    return np.asarray(motion.omega**2 * (read[1] * support + read[2] * deflected))


def _tilting(model: Model, end: str) -> FloatArray:
    """How far tilting one end of a span of a rotor moves each term, (n_terms,): what the moment there does work on."""
    span, _, side = end.rpartition(".")
    return np.array([term.tilts[side == "right"] if term.owner == span else 0.0 for term in model.terms])


class ShearStress(BendingStress):
    """`response = "shear_stress"`: greatest in a round shaft that twists [Pa] peak, the dynamic part at its surface."""

    moves: ClassVar[str] = "axis"
    names: ClassVar[dict[str, str]] = {"of": "link"}
    of_rotor: ClassVar[bool] = False
    twin: ClassVar[str] = "bending_stress"
    noise_twin: ClassVar[str] = ""
    transient_twin: ClassVar[str] = ""


class _OfShape(_OfBeam, UnsteadyResponse):
    """Read off the shape under a static load."""

    @property
    def steady(self) -> BendingStress:
        return BendingStress(response="bending_stress", of=self.of)

    def output(self, model: Model) -> Output:
        return self.steady.of_shape(model)


class RmsBendingStress(_OfShape, RandomResponse):
    """`response = "rms_bending_stress"`: greatest in a beam or shaft that bends [Pa] rms."""

    def measure(self, machine: Machine, motion: Motion) -> ComplexArray:
        return self.steady.measured_shape(machine, motion)


class PeakBendingStress(_OfShape, TransientResponse):
    """`response = "peak_bending_stress"`: greatest in a beam or shaft that bends, the greatest in time [Pa]."""
