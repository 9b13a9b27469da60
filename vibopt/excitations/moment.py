"""Harmonic moments on a body that turns."""

from typing import ClassVar

from pydantic import model_validator

from vibopt.arrays import FloatArray
from vibopt.excitations.excitation import Excitation, OneSpeed, Varies, check_orders, order_lines, unit_line
from vibopt.signals import Line
from vibopt.values import Fact, Table, number
from vibopt.values.directions import AXES, Direction, Vector


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


class MomentHarmonic(Table):
    """One order: moment [N m] peak at `order` times the speed, leading by `phase`.

    Keys
    ----
    order: How many times the speed: `order = 2`.
    amplitude: Amplitude of this order.
    phase: How far it leads; zero without it.
    """

    order: Fact = number("ratio", choice=False, required=True)
    amplitude: Fact = number("moment", amplitude=True, choice=False, required=True)
    phase: Fact | None = number("angle", choice=False, sign="any")


class MomentHarmonics(Excitation):
    """`kind = "moment_harmonics"`: sum of T_h cos(h w t + phase_h), the torque of an engine against its block.

    Keys
    ----
    harmonics: Orders of the torque: `harmonics = [{ order = 2, amplitude = "400 N m" }]`. An order twice is
        refused.
    axis: In space the axis of the torque: `axis = "x"`.
    varies: How all amplitudes change away from their own speed: `varies = "constant"`, "speed", "speed^2" or a
        table.
    amplitude_at: The speed to which the amplitudes belong: `amplitude_at = "2000 rpm"`.
    """

    harmonics: tuple[MomentHarmonic, ...]
    axis: Direction | None = None
    varies: Varies = None
    amplitude_at: OneSpeed | None = None
    moment: ClassVar[str] = "harmonics"

    @model_validator(mode="after")
    def _orders_differ(self) -> "MomentHarmonics":
        check_orders(self.harmonics, '{ order = 2, amplitude = "400 N m" }')
        return self

    @property
    def acts(self) -> dict[str, complex]:
        return super().acts if self.axis is None else about(self.on, self.axis)

    def lines(self, direction: FloatArray) -> tuple[Line, ...]:
        return order_lines(self, self.harmonics, direction)


def about(place: str, axis: Vector) -> dict[str, complex]:
    """A moment about an axis, by the coordinates of a body."""
    return {f"{place}.r{one}": complex(part) for one, part in zip(AXES, axis, strict=True) if part}
