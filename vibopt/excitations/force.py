"""A harmonic force on a body."""

from typing import ClassVar, Literal

from pydantic import model_validator

from vibopt.arrays import FloatArray
from vibopt.excitations.directed import Directed, RunUp
from vibopt.excitations.excitation import Meant, OneSpeed, Varies, unit_line
from vibopt.signals import Line
from vibopt.values import Fact, number, word


class Force(Meant, Directed):
    """`kind = "force"`: F cos(w t), amplitude [N] peak.

    Keys
    ----
    amplitude: Amplitude at its own speed.
    varies: How the amplitude changes away from its own speed: `varies = "speed^2"`, "constant", "speed", or a table
        [["0 rpm", 0.0], ["3000 rpm", 1.0]]. Compulsory as soon as a limit looks at another speed.
    amplitude_at: The speed to which the amplitude belongs, where it grows with speed and there are several own
        speeds: `amplitude_at = "2000 rpm"`.
    run_up: How its speed rises or falls, for responses in time: `run_up = { from = "0 rpm", to = "3000 rpm",
        acceleration = "50 rpm/s" }`.
    begins: `begins = "suddenly"`: for responses in time a sine from zero at its one speed, from rest and for ever.
    """

    amplitude: Fact = number("force", amplitude=True, choice=False, required=True)
    varies: Varies = None
    amplitude_at: OneSpeed | None = None
    run_up: RunUp | None = None
    begins: Literal["suddenly"] | None = None
    instead: ClassVar[tuple[str, str]] = "moment", "moment"

    @model_validator(mode="after")
    def _one_beginning(self) -> "Force":
        if self.run_up is not None and self.run_up.torque is not None:
            raise word(
                "has a run_up by torque, but what a force takes from a motor nobody knows. Write an unbalance, or the "
                'acceleration that the motor reaches: run_up = { acceleration = "50 rpm/s" }.'
            )
        if self.run_up is not None and self.begins is not None:
            raise word("has run_up and begins: does it gain speed, or begin suddenly at full speed? Keep one.")
        return self

    def lines(self, direction: FloatArray) -> tuple[Line, ...]:
        return (unit_line(1.0, direction, 0.0, self.varied(self.amplitude.value)),)
