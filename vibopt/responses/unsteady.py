"""Motions and forces that are not steady: their rms under white noise, the greatest in time of what comes once."""

from typing import ClassVar

from vibopt.responses.motion import Displacement
from vibopt.responses.relative_displacement import RelativeDisplacement
from vibopt.responses.response import RandomResponse, ReadAs, TransientResponse, UnsteadyResponse
from vibopt.responses.space_responses import OfMount, Travel
from vibopt.responses.transmitted import IntoOrThrough, TransmittedForce
from vibopt.responses.velocity import Acceleration, Velocity
from vibopt.values.directions import Direction


class OfBody(UnsteadyResponse):
    """Of a body, absolute; in space along `direction`.

    Keys
    ----
    of: The body, or a point: `of = "deck"`.
    direction: In space, along which it is asked: `direction = "y"`.
    """

    of: str
    direction: Direction | None = None
    moves: ClassVar[str] = "line"
    in_space: ClassVar[str] = "direction"


class RmsDisplacement(OfBody, RandomResponse):
    """`response = "rms_displacement"`: of a body, absolute [m] rms."""

    dimension: ClassVar[str] = "length"
    read_as: ClassVar[ReadAs] = ("displacement", Displacement)


class RmsVelocity(OfBody, RandomResponse):
    """`response = "rms_velocity"`: of a body, absolute [m/s] rms."""

    dimension: ClassVar[str] = "velocity"
    read_as: ClassVar[ReadAs] = ("velocity", Velocity)


class RmsAcceleration(OfBody, RandomResponse):
    """`response = "rms_acceleration"`: of a body, absolute [m/s^2] rms."""

    dimension: ClassVar[str] = "acceleration"
    read_as: ClassVar[ReadAs] = ("acceleration", Acceleration)


class PeakDisplacement(OfBody, TransientResponse):
    """`response = "peak_displacement"`: of a body, absolute, the greatest in time [m]."""

    dimension: ClassVar[str] = "length"
    read_as: ClassVar[ReadAs] = ("displacement", Displacement)


class PeakVelocity(OfBody, TransientResponse):
    """`response = "peak_velocity"`: of a body, absolute, the greatest in time [m/s]."""

    dimension: ClassVar[str] = "velocity"
    read_as: ClassVar[ReadAs] = ("velocity", Velocity)


class PeakAcceleration(OfBody, TransientResponse):
    """`response = "peak_acceleration"`: of a body, absolute, the greatest in time [m/s^2]."""

    dimension: ClassVar[str] = "acceleration"
    read_as: ClassVar[ReadAs] = ("acceleration", Acceleration)


class AcrossLink(UnsteadyResponse):
    """Across a link.

    Keys
    ----
    across: The link: `across = "mount"`.
    """

    across: str
    dimension: ClassVar[str] = "length"
    moves: ClassVar[str] = "line"
    read_as: ClassVar[ReadAs] = ("relative_displacement", RelativeDisplacement)


class RmsRelativeDisplacement(AcrossLink, RandomResponse):
    """`response = "rms_relative_displacement"`: across a link [m] rms."""


class PeakRelativeDisplacement(AcrossLink, TransientResponse):
    """`response = "peak_relative_displacement"`: across a link (rattle space), the greatest in time [m]."""


class ForceOfLinks(IntoOrThrough, UnsteadyResponse):
    """Dynamic force of links and mounts; in space along `direction`.

    Keys
    ----
    direction: In space, along which it is asked: `direction = "z"`.
    """

    direction: Direction | None = None
    moves: ClassVar[str] = "line"
    of_mount: ClassVar[str] = "each"
    read_as: ClassVar[ReadAs] = ("transmitted_force", TransmittedForce)


class RmsForce(ForceOfLinks, RandomResponse):
    """`response = "rms_force"`: total over all links `into` a place, or in one mount `through` a link [N] rms."""


class PeakForce(ForceOfLinks, TransientResponse):
    """`response = "peak_force"`: total over all links `into` a place, or in one mount `through` a link [N].

    Dynamic part only, without the weight, the greatest in time.
    """


class RmsTravel(OfMount, RandomResponse):
    """`response = "rms_travel"`: how far a mount in space moves in itself [m] rms."""

    read_as: ClassVar[ReadAs] = ("travel", Travel)


class PeakTravel(OfMount, TransientResponse):
    """`response = "peak_travel"`: how far a mount in space moves in itself, the greatest in time [m]."""

    read_as: ClassVar[ReadAs] = ("travel", Travel)
    other_bound: ClassVar[str] = " (or give the mount its gap)"
