"""Velocity and acceleration of a body; peak amplitudes."""

from typing import ClassVar

from vibopt.responses.motion import Displacement


class Velocity(Displacement):
    """`response = "velocity"`: of a body, absolute [m/s] peak."""

    dimension: ClassVar[str] = "velocity"
    power: ClassVar[int] = 1
    noise_twin: ClassVar[str] = "rms_velocity"
    transient_twin: ClassVar[str] = "peak_velocity"


class Acceleration(Displacement):
    """`response = "acceleration"`: of a body, absolute [m/s^2] peak."""

    dimension: ClassVar[str] = "acceleration"
    power: ClassVar[int] = 2
    noise_twin: ClassVar[str] = "rms_acceleration"
    transient_twin: ClassVar[str] = "peak_acceleration"
