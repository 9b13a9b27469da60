"""Root mean square of motions and forces under white noise."""

from __future__ import annotations

from typing import Any, ClassVar

from pydantic import model_validator

from vibopt.forms import Combine, ComplexArray, Drive, Form, Noise, Output, RootMeanSquare
from vibopt.mechanics.machine import Machine, Motion
from vibopt.mechanics.model import Model
from vibopt.responses.kind import BoundError, HarmonicResponse, Response
from vibopt.responses.motion import Acceleration, Displacement, RelativeDisplacement, Velocity
from vibopt.responses.transmitted import TransmittedForce
from vibopt.units import Quantity
from vibopt.units.spelling import split_detector
from vibopt.values import word


class RandomResponse(Response):
    """A response under white noise: the square root of its mean square.

    Independent noises add as mean squares.  `steady` is the harmonic response of which it is the root
    mean square.
    """

    due_to: tuple[str, ...] | None = None
    random: ClassVar[bool] = True

    @model_validator(mode="before")
    @classmethod
    def _bounds(cls, given: Any) -> Any:
        if not isinstance(given, dict):
            return given
        bare = {key: _without_rms(key, given[key]) for key in ("at_most", "at_least", "unit") if key in given}
        cls._check_unit(bare.get("unit"))
        given = {**given, **bare}
        return {**given, **cls._read_bounds(given)}

    @property
    def steady(self) -> HarmonicResponse:
        """The same reading of a steady vibration."""
        raise NotImplementedError

    def places(self) -> dict[str, tuple[str, str]]:
        return self.steady.places()

    def output(self, model: Model) -> Output:
        """The row that reads this response off the motion."""
        return self.steady.output(model)

    def noise_form(self, model: Model, noises: tuple[Noise, ...]) -> Form:
        """What the optimiser gets."""
        return RootMeanSquare(self.output(model), noises)

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        return self.noise_form(model, ())

    def measure(self, machine: Machine, motion: Motion) -> ComplexArray:
        """Complex amplitude of the built machine in a given harmonic motion; another road than `output`."""
        return self.steady.measure(machine, motion)


def _without_rms(key: str, given: object) -> object:
    """A value of which "rms" is said once more; peak values are refused, for noise has no peak."""
    if not isinstance(given, str) or isinstance(given, Quantity):
        return given
    bare, detector, said = split_detector(given)
    if detector in ("pk", "pp"):
        raise BoundError(key, given, f'says "{said}", but random vibration has no peak. Write the rms value.')
    return bare


class RmsDisplacement(RandomResponse):
    """`response = "rms_displacement"`: of a body, absolute [m] rms."""

    of: str
    dimension: ClassVar[str] = "length"

    @property
    def steady(self) -> HarmonicResponse:
        return Displacement(response="displacement", of=self.of)


class RmsVelocity(RandomResponse):
    """`response = "rms_velocity"`: of a body, absolute [m/s] rms."""

    of: str
    dimension: ClassVar[str] = "velocity"

    @property
    def steady(self) -> HarmonicResponse:
        return Velocity(response="velocity", of=self.of)


class RmsAcceleration(RandomResponse):
    """`response = "rms_acceleration"`: of a body, absolute [m/s^2] rms."""

    of: str
    dimension: ClassVar[str] = "acceleration"

    @property
    def steady(self) -> HarmonicResponse:
        return Acceleration(response="acceleration", of=self.of)


class RmsRelativeDisplacement(RandomResponse):
    """`response = "rms_relative_displacement"`: across a link [m] rms."""

    across: str
    dimension: ClassVar[str] = "length"

    @property
    def steady(self) -> HarmonicResponse:
        return RelativeDisplacement(response="relative_displacement", across=self.across)


class RmsForce(RandomResponse):
    """`response = "rms_force"`: total over all links `into` a place, or in one mount `through` a link [N] rms."""

    into: str | None = None
    through: str | None = None
    dimension: ClassVar[str] = "force"

    @model_validator(mode="after")
    def _one_place(self) -> RmsForce:
        if (self.into is None) == (self.through is None):
            raise word('needs either into (a place) or through (a link). Write into = "ground".')
        return self

    @property
    def steady(self) -> HarmonicResponse:
        return TransmittedForce(response="transmitted_force", into=self.into, through=self.through)
