"""A harmonic force on a body."""

from vibopt.arrays import FloatArray
from vibopt.excitations.directed import Directed, RunUp
from vibopt.excitations.excitation import OneSpeed, Varies, unit_line
from vibopt.signals import Line
from vibopt.values import Fact, number


class Force(Directed):
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
    """

    amplitude: Fact = number("force", amplitude=True, choice=False, required=True)
    varies: Varies = None
    amplitude_at: OneSpeed | None = None
    run_up: RunUp | None = None

    def lines(self, direction: FloatArray) -> tuple[Line, ...]:
        return (unit_line(1.0, direction, 0.0, self.varied(self.amplitude.value)),)
