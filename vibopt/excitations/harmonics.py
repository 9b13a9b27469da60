"""A periodic force: several harmonics (orders) of one speed."""

from pydantic import model_validator

from vibopt.arrays import FloatArray
from vibopt.excitations.directed import Directed
from vibopt.excitations.excitation import OneSpeed, Varies, unit_line
from vibopt.signals import Line
from vibopt.values import Fact, Table, number, word


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
        orders = [one.order.value for one in self.harmonics]
        if not orders:
            raise word('has no harmonics. Write harmonics = [{ order = 1, amplitude = "18 kN" }].')
        if len(set(orders)) < len(orders):
            raise word("gives an order twice. Add the two as phasors and give the order once.")
        return self

    def lines(self, direction: FloatArray) -> tuple[Line, ...]:
        return tuple(
            unit_line(
                one.order.value,
                direction,
                one.phase.value if one.phase is not None else 0.0,
                self.varied(one.amplitude.value),
            )
            for one in self.harmonics
        )
