"""Root mean square of motions and forces under white noise."""

from typing import ClassVar

from pydantic import model_validator

from vibopt.responses.motion import Acceleration, Displacement, RelativeDisplacement, Velocity
from vibopt.responses.response import HarmonicResponse, RandomResponse
from vibopt.responses.transmitted import TransmittedForce
from vibopt.values import word


class RmsDisplacement(RandomResponse):
    """`response = "rms_displacement"`: of a body, absolute [m] rms.

    Keys
    ----
    of: The body: `of = "deck"`.
    """

    of: str
    dimension: ClassVar[str] = "length"
    moves: ClassVar[str] = "line"

    @property
    def steady(self) -> HarmonicResponse:
        return Displacement(response="displacement", of=self.of)


class RmsVelocity(RandomResponse):
    """`response = "rms_velocity"`: of a body, absolute [m/s] rms.

    Keys
    ----
    of: The body: `of = "deck"`.
    """

    of: str
    dimension: ClassVar[str] = "velocity"
    moves: ClassVar[str] = "line"

    @property
    def steady(self) -> HarmonicResponse:
        return Velocity(response="velocity", of=self.of)


class RmsAcceleration(RandomResponse):
    """`response = "rms_acceleration"`: of a body, absolute [m/s^2] rms.

    Keys
    ----
    of: The body: `of = "deck"`.
    """

    of: str
    dimension: ClassVar[str] = "acceleration"
    moves: ClassVar[str] = "line"

    @property
    def steady(self) -> HarmonicResponse:
        return Acceleration(response="acceleration", of=self.of)


class RmsRelativeDisplacement(RandomResponse):
    """`response = "rms_relative_displacement"`: across a link [m] rms.

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


class RmsForce(RandomResponse):
    """`response = "rms_force"`: total over all links `into` a place, or in one mount `through` a link [N] rms.

    Keys
    ----
    into: The body, base or ground: `into = "ground"`. One of `into` and `through`.
    through: The link; the force is that in each single mount: `through = "mount"`.
    """

    into: str | None = None
    through: str | None = None
    dimension: ClassVar[str] = "force"
    moves: ClassVar[str] = "line"

    @model_validator(mode="after")
    def _one_place(self) -> "RmsForce":
        if (self.into is None) == (self.through is None):
            raise word('needs either into (a place) or through (a link). Write into = "ground".')
        return self

    @property
    def steady(self) -> HarmonicResponse:
        return TransmittedForce(response="transmitted_force", into=self.into, through=self.through)
