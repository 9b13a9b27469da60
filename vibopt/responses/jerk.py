"""Jerk: the rate at which an acceleration changes; peak amplitudes."""

from __future__ import annotations

from typing import ClassVar

from vibopt.responses.motion import Displacement
from vibopt.responses.torsion import Rotation


class Jerk(Displacement):
    """`response = "jerk"`: of a body, absolute [m/s^3] peak; in space along `direction`."""

    dimension: ClassVar[str] = "jerk"
    against_friction: ClassVar[str] = "is infinite, for friction turns at once where the slip does"
    power: ClassVar[int] = 3
    twin: ClassVar[str] = "angular_jerk"
    noise_twin: ClassVar[str] = ""
    transient_twin: ClassVar[str] = ""


class AngularJerk(Rotation):
    """`response = "angular_jerk"`: of a body that turns, absolute [rad/s^3] peak; in space about `axis`."""

    dimension: ClassVar[str] = "angular_jerk"
    power: ClassVar[int] = 3
    twin: ClassVar[str] = "jerk"
