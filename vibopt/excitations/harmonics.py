"""A periodic force: several harmonics (orders) of one speed."""

from pydantic import model_validator

from vibopt.arrays import FloatArray
from vibopt.excitations.directed import Directed
from vibopt.excitations.excitation import OneSpeed, Varies, check_orders, order_lines
from vibopt.signals import Line
from vibopt.values import Fact, Table, number


class Harmonic(Table):
    """One order: force [N] peak at `order` times the speed, leading by `phase`.

    Keys
    ----
    order: How many times the speed: `order = 2`.
    amplitude: Amplitude of this order.
    phase: How far it leads; zero without it.
    """

    order: Fact = number("ratio", choice=False, required=True)
    amplitude: Fact = number("force", amplitude=True, choice=False, required=True)
    phase: Fact | None = number("angle", choice=False, sign="any")


class Harmonics(Directed):
    """`kind = "harmonics"`: sum of F_h cos(h w t + phase_h).

    Keys
    ----
    harmonics: Orders of the force: `harmonics = [{ order = 1, amplitude = "18 kN", phase = "0 deg" }]`. An order
        twice is refused.
    varies: How all amplitudes change away from their own speed: `varies = "constant"`, "speed", "speed^2" or a
        table.
    amplitude_at: The speed to which the amplitudes belong: `amplitude_at = "2000 rpm"`.
    """

    harmonics: tuple[Harmonic, ...]
    varies: Varies = None
    amplitude_at: OneSpeed | None = None

    @model_validator(mode="after")
    def _orders_differ(self) -> "Harmonics":
        check_orders(self.harmonics, '{ order = 1, amplitude = "18 kN" }')
        return self

    def lines(self, direction: FloatArray) -> tuple[Line, ...]:
        return order_lines(self, self.harmonics, direction)
