"""Harmonic moments on a body that turns."""

from typing import ClassVar

from vibopt.arrays import FloatArray
from vibopt.excitations.excitation import Excitation, Meant, OneSpeed, Varies, unit_line
from vibopt.excitations.harmonics import OfOrders, Order
from vibopt.signals import Line
from vibopt.values import Fact, number
from vibopt.values.directions import AXES, Direction, Vector


class _About(Excitation):
    """What turns a body to and fro about an axis."""

    axis: Direction | None = None

    @property
    def acts(self) -> dict[str, complex]:
        return super().acts if self.axis is None else about(self.on, self.axis)


class Moment(Meant, _About):
    """`kind = "moment"`: T cos(w t), amplitude [N m] peak.

    Keys
    ----
    axis: In space the axis about which it turns to and fro: `axis = "x"`. Refused of what turns about one axis.
    amplitude: Amplitude at its own speed.
    varies: How the amplitude changes away from its own speed: `varies = "constant"`, "speed", "speed^2" or a table.
    amplitude_at: The speed to which the amplitude belongs, where it grows and there are several: `amplitude_at =
        "2000 rpm"`.
    """

    amplitude: Fact = number("moment", amplitude=True, choice=False, required=True)
    varies: Varies = None
    amplitude_at: OneSpeed | None = None
    moment: ClassVar[str] = "force"
    instead: ClassVar[tuple[str, str]] = "force", "force"

    def lines(self, direction: FloatArray) -> tuple[Line, ...]:
        return (unit_line(1.0, direction, 0.0, self.varied(self.amplitude.value)),)


class MomentHarmonic(Order):
    """One order: moment [N m] peak at `order` times the speed, leading by `phase`."""

    amplitude: Fact = number("moment", amplitude=True, choice=False, required=True)
    instead: ClassVar[tuple[str, str]] = "force", "harmonics"


class MomentHarmonics(_About, OfOrders):
    """`kind = "moment_harmonics"`: sum of T_h cos(h w t + phase_h), the torque of an engine against its block.

    Keys
    ----
    harmonics: Orders of the torque: `harmonics = [{ order = 2, amplitude = "400 N m" }]`. An order twice is
        refused.
    axis: In space the axis of the torque: `axis = "x"`.
    """

    harmonics: tuple[MomentHarmonic, ...]
    moment: ClassVar[str] = "harmonics"
    example: ClassVar[str] = '{ order = 2, amplitude = "400 N m" }'


def about(place: str, axis: Vector) -> dict[str, complex]:
    """A moment about an axis, by the coordinates of a body."""
    return {f"{place}.r{one}": complex(part) for one, part in zip(AXES, axis, strict=True) if part}
