"""Periodic forces and moments: several harmonics (orders) of one speed."""

from typing import Any, ClassVar

from pydantic import model_validator

from vibopt.arrays import FloatArray
from vibopt.excitations.directed import Directed
from vibopt.excitations.excitation import Excitation, Meant, OneSpeed, Varies, unit_line
from vibopt.signals import Line
from vibopt.values import Fact, number, word


class Order(Meant):
    """One order, at `order` times the speed, leading by `phase`.

    Keys
    ----
    order: How many times the speed: `order = 2`.
    amplitude: Amplitude of this order.
    phase: How far it leads; zero without it.
    """

    order: Fact = number("ratio", choice=False, required=True)
    phase: Fact | None = number("angle", choice=False, sign="any")


class Harmonic(Order):
    """One order: force [N] peak at `order` times the speed, leading by `phase`."""

    amplitude: Fact = number("force", amplitude=True, choice=False, required=True)
    instead: ClassVar[tuple[str, str]] = "moment", "moment_harmonics"


class OfOrders(Excitation):
    """Several orders of one speed.

    Keys
    ----
    varies: How all amplitudes change away from their own speed: `varies = "constant"`, "speed", "speed^2" or a
        table.
    amplitude_at: The speed to which the amplitudes belong: `amplitude_at = "2000 rpm"`.
    """

    varies: Varies = None
    amplitude_at: OneSpeed | None = None
    example: ClassVar[str] = '{ order = 1, amplitude = "18 kN" }'

    @model_validator(mode="after")
    def _orders_differ(self) -> "OfOrders":
        orders = [one.order.value for one in vars(self)["harmonics"]]
        if not orders:
            raise word(f"has no harmonics. Write harmonics = [{self.example}].")
        if len(set(orders)) < len(orders):
            raise word("gives an order twice. Add the two as phasors and give the order once.")
        return self

    def lines(self, direction: FloatArray) -> tuple[Line, ...]:
        harmonics: tuple[Any, ...] = vars(self)["harmonics"]
        return tuple(
            unit_line(
                harmonic.order.value, direction, harmonic.phase.value if harmonic.phase is not None else 0.0,
                self.varied(harmonic.amplitude.value),
            )
            for harmonic in harmonics
        )  # fmt: skip


class Harmonics(OfOrders, Directed):
    """`kind = "harmonics"`: sum of F_h cos(h w t + phase_h).

    Keys
    ----
    harmonics: Orders of the force: `harmonics = [{ order = 1, amplitude = "18 kN", phase = "0 deg" }]`. An order
        twice is refused.
    """

    harmonics: tuple[Harmonic, ...]
