"""Excitations on bodies in space: where they act, along which direction or about which axis."""

import math
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import model_validator

from vibopt.arrays import FloatArray
from vibopt.excitations.excitation import Excitation, OneSpeed, Varies, unit_line
from vibopt.mechanics.vectors import cross
from vibopt.signals import Line
from vibopt.values import Fact, Table, number, word
from vibopt.values.directions import AXES, Direction, Place, Vector
from vibopt.values.fields import Later

RunUp = Annotated[Any, Later("vibopt.excitations", "run_up.RunUp")]


class Directed(Excitation):
    """Words of a force at a place: `at` (else the centre of mass, or the point that it is on), `direction`.

    Keys
    ----
    direction: In space the direction in which it goes to and fro: `direction = "z"`, or three numbers. Refused
        along a line.
    at: In space its place; without it the centre of mass, or the point it is on: `at = ["0.2 m", "0 m", "0.4 m"]`.
        Refused along a line.
    """

    direction: Direction | None = None
    at: Place | None = None

    @property
    def place(self) -> str:
        """Name of the place where it acts: a body, a point, or one that only this excitation knows."""
        return self.on if self.at is None else place_name(self.on, self.at)

    @property
    def acts(self) -> dict[str, complex]:
        if self.direction is None:
            return super().acts
        return {f"{self.place}.{axis}": complex(part) for axis, part in zip(AXES, self.direction, strict=True) if part}


def place_name(body: str, at: Vector) -> str:
    """Name of a place on a body without a name of its own."""
    return f"{body} ({', '.join(repr(one) for one in at)})"


def turned(axis: Vector) -> tuple[FloatArray, FloatArray]:
    """Two directions at right angles to an axis, the second a quarter turn on about it."""
    own = np.array(axis)
    least = int(np.abs(own).argmin())
    first = cross(own, np.eye(3)[least])
    if np.abs(own).max() > 1.0 - 1e-12:
        first = np.eye(3)[(int(np.abs(own).argmax()) + 1) % 3]
    first = first / math.sqrt(float(first @ first))
    return first, cross(own, first)


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
        orders = [one.order.value for one in self.harmonics]
        if not orders:
            raise word('has no harmonics. Write harmonics = [{ order = 2, amplitude = "400 N m" }].')
        if len(set(orders)) < len(orders):
            raise word("gives an order twice. Add the two as phasors and give the order once.")
        return self

    @property
    def acts(self) -> dict[str, complex]:
        return super().acts if self.axis is None else about(self.on, self.axis)

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


def about(place: str, axis: Vector) -> dict[str, complex]:
    """A moment about an axis, by the coordinates of a body."""
    return {f"{place}.r{one}": complex(part) for one, part in zip(AXES, axis, strict=True) if part}


__all__ = ["Directed", "MomentHarmonics", "RunUp", "about", "place_name", "turned"]
