"""White noise: a force on a body, or the acceleration of a base, of the same density at every frequency."""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import BeforeValidator, WithJsonSchema

from vibopt.errors import QuantityError
from vibopt.excitations.kind import Excitation
from vibopt.forms import Band, FloatArray, Line
from vibopt.units import read_quantity
from vibopt.values import Fact, SpeedRange
from vibopt.values.fields import complaint
from vibopt.values.speeds import ROTATION

FORCE, ACCELERATION = "force_density", "acceleration_density"
EVERYWHERE = SpeedRange((Band(0.0, math.inf),), ROTATION, "Hz")


def _no_speed(given: object) -> object:
    if isinstance(given, SpeedRange):
        return given
    raise complaint("is a speed, but white noise shakes at every frequency at once. Leave it out.")


def _density(given: object) -> object:
    """A density of force, else one of acceleration; what is neither is told the way out of both."""
    if isinstance(given, Fact):
        return given
    if isinstance(given, dict):
        raise complaint("is a choice, but this value must be a fact. Write one value.")
    try:
        found = read_quantity(given, FORCE)
    except QuantityError as error:
        try:
            found = read_quantity(given, ACCELERATION)
        except QuantityError:
            text = str(error).replace(
                'Write a spectral density of force, for example "100 N²/Hz".',
                'Write "100 N²/Hz" for a force, or "0.01 (m/s²)²/Hz" for the acceleration of a base.',
            )
            raise complaint(text) from None
    if found.value <= 0.0:
        raise complaint('is not greater than zero. Write a positive value, for example "100 N²/Hz".')
    return Fact(found.value, found.unit, found.echo)


NoSpeed = Annotated[SpeedRange, BeforeValidator(_no_speed), WithJsonSchema({"not": {}})]
Density = Annotated[
    Any,
    BeforeValidator(_density),
    WithJsonSchema({"type": "string", "description": "spectral density, for example 100 N²/Hz or 0.01 (m/s²)²/Hz"}),
]


class WhiteNoise(Excitation):
    """`kind = "white_noise"`: one-sided spectral density, of a force on a body or of the acceleration of a base.

    Inside, densities are over the angular frequency [N^2 s/rad, (m/s^2)^2 s/rad].
    """

    density: Density
    speed: NoSpeed = EVERYWHERE
    inherent = True
    random = True

    @property
    def quantity(self) -> str:
        """Dimension of the density, by its unit."""
        try:
            read_quantity(f"1 {self.density.unit}", FORCE)
        except QuantityError:
            return ACCELERATION
        return FORCE

    @property
    def family(self) -> str:  # type: ignore[override]  # only the unit tells force from acceleration
        """Where it acts: a force on bodies, an acceleration on bases."""
        return "bodies" if self.quantity == FORCE else "bases"

    def lines(self, direction: FloatArray) -> tuple[Line, ...]:
        """None: noise has no lines."""
        return ()
