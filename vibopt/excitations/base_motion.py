"""Harmonic motion of a base."""

from typing import ClassVar, Literal

from pydantic import model_validator

from vibopt.arrays import FloatArray
from vibopt.excitations.directed import Along
from vibopt.excitations.excitation import OneSpeed, Varies, unit_line
from vibopt.signals import Line
from vibopt.values import Fact, number, word


class BaseMotion(Along):
    """`kind = "base_motion"`: amplitude of displacement, velocity or acceleration, peak.

    Keys
    ----
    displacement: Amplitude of the base. One of `displacement`, `velocity`, `acceleration`.
    velocity: Amplitude of its velocity.
    acceleration: Amplitude of its acceleration.
    varies: How the amplitude changes away from its own speed: `varies = "constant"`, "speed", "speed^2" or a table.
    amplitude_at: The speed to which the amplitude belongs: `amplitude_at = "2000 rpm"`.
    begins: `begins = "suddenly"`: for responses in time its displacement is a sine from zero at its one speed, from
        rest and for ever, whichever of the three is given.
    """

    displacement: Fact | None = number("length", amplitude=True, choice=False)
    velocity: Fact | None = number("velocity", amplitude=True, choice=False)
    acceleration: Fact | None = number("acceleration", amplitude=True, choice=False)
    varies: Varies = None
    amplitude_at: OneSpeed | None = None
    begins: Literal["suddenly"] | None = None
    family: ClassVar[str] = "bases"

    @model_validator(mode="after")
    def _one_of_three(self) -> "BaseMotion":
        given = [fact for fact in (self.displacement, self.velocity, self.acceleration) if fact is not None]
        if len(given) != 1:
            raise word('needs one of displacement, velocity and acceleration. Write displacement = "1 mm".')
        return self

    def lines(self, direction: FloatArray) -> tuple[Line, ...]:
        for power, given in ((0, self.displacement), (-1, self.velocity), (-2, self.acceleration)):
            if given is not None:
                return (unit_line(1.0, direction, 0.0, self.varied(given.value, power)),)
        return ()
