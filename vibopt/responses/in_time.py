"""Greatest motions and forces over all time, under what comes once: pulses, drops, records."""

from typing import ClassVar

from pydantic import model_validator

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

    @property
    def steady(self) -> HarmonicResponse:
        return Displacement(response="displacement", of=self.of)


class PeakVelocity(PeakDisplacement):
    """`response = "peak_velocity"`: of a body, absolute, the greatest in time [m/s].

    Keys
    ----
    of: The body: `of = "instrument"`.
    """

    dimension: ClassVar[str] = "velocity"

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


__all__ = ["PeakAcceleration", "PeakDisplacement", "PeakForce", "PeakRelativeDisplacement", "PeakVelocity"]
