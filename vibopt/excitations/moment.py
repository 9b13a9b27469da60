"""A harmonic moment on a body that turns."""

from typing import ClassVar

from vibopt.arrays import FloatArray
from vibopt.excitations.directed import about
from vibopt.excitations.excitation import Excitation, OneSpeed, Varies, unit_line
from vibopt.signals import Line
from vibopt.values import Fact, number
from vibopt.values.directions import Direction


class Moment(Excitation):
    """`kind = "moment"`: T cos(w t), amplitude [N m] peak.

    Keys
    ----
    axis: In space the axis about which it turns to and fro: `axis = "x"`. Refused of what turns about one axis.
    amplitude: Amplitude at its own speed.
    varies: How the amplitude changes away from its own speed: `varies = "constant"`, "speed", "speed^2" or a table.
    amplitude_at: The speed to which the amplitude belongs, where it grows and there are several: `amplitude_at =
        "2000 rpm"`.
    """

    axis: Direction | None = None
    amplitude: Fact = number("moment", amplitude=True, choice=False, required=True)
    varies: Varies = None
    amplitude_at: OneSpeed | None = None
    moment: ClassVar[str] = "force"

    @property
    def acts(self) -> dict[str, complex]:
        return super().acts if self.axis is None else about(self.on, self.axis)

    def lines(self, direction: FloatArray) -> tuple[Line, ...]:
        return (unit_line(1.0, direction, 0.0, self.varied(self.amplitude.value)),)
