"""What a response asks of the free whirls of a rotor: at which spins, up to which frequency, in which sense."""

from __future__ import annotations

from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import field_validator, model_validator

from vibopt.errors import QuantityError
from vibopt.forms import Form, WhirlDamping
from vibopt.mechanics.machine import Machine
from vibopt.responses.asked_speeds import At, Over
from vibopt.responses.response import FEW_MODES, Bound, Response
from vibopt.signals import Band
from vibopt.units import Quantity, read_quantity, show
from vibopt.values import SpeedRange, word
from vibopt.values.fields import complaint
from vibopt.values.speeds import ROTATION

SENSES = {"forward": 1.0, "backward": -1.0, None: 0.0}


def of_rotation(found: object) -> object:
    """Spins of a rotor: no speeds of a vehicle, none by excitation, none without an end."""
    if found is not None and (not isinstance(found, SpeedRange) or found.dimension != ROTATION):
        raise complaint('is no spin of a rotor. Write at = "3000 rpm" or over = "0..3000 rpm".')
    if isinstance(found, SpeedRange) and found.highest == np.inf:
        raise complaint('has no upper end. Write one: over = "0..3000 rpm".')
    return found


class OfWhirls(Response):
    """Damping of the `mode`-th least damped mode of a machine, or of the free whirls of a rotor at a spin.

    Keys
    ----
    mode: Which of the least damped modes, 1 is the least damped.
    at: Of a rotor: the spins at which its free whirls are looked at: `at = "3000 rpm"`. Not beside `over`.
    over: Of a rotor: every spin of a range; the least counts: `over = "0..3600 rpm"`.
    up_to: Of a rotor: whirls that are no quicker than this count, and it must be said: `up_to = "6000 rpm"`.
    whirl: Of a rotor: "forward" or "backward" whirls alone; both without it: `whirl = "forward"`.
    """

    mode: int = 1
    at: At = None
    over: Over = None
    up_to: Bound = None
    whirl: Literal["forward", "backward"] | None = None
    ratio: ClassVar[bool] = False

    @field_validator("at", "over", mode="after")
    @classmethod
    def _rotation(cls, given: Any) -> Any:
        return of_rotation(given)

    @field_validator("up_to", mode="before")
    @classmethod
    def _up_to(cls, given: Any) -> Any:
        if given is None or isinstance(given, Quantity):
            return given
        try:
            quantity = read_quantity(given, ROTATION)
        except QuantityError as error:
            raise complaint(str(error)) from None
        if quantity.value <= 0.0:
            raise complaint('is not above zero. Write the greatest frequency that counts: up_to = "6000 rpm".')
        return quantity

    @model_validator(mode="after")
    def _spins(self) -> OfWhirls:
        if self.at is not None and self.over is not None:
            raise word("has both at and over. Keep one: at for single spins, over for ranges.")
        alone = next((key for key in ("up_to", "whirl") if getattr(self, key) is not None), None)
        if not self.spins and alone is not None:
            raise word(f'has {alone}, but says no spin of the rotor. Add at = "3000 rpm" or over = "0..3600 rpm".')
        if self.spins and self.up_to is None:
            raise word(
                "does not say which whirls of the rotor count, and the quickest are the least telling. Add the "
                'greatest frequency that counts: up_to = "6000 rpm".'
            )
        if self.mode < 1:
            raise word("has a mode below 1. Modes are counted from 1, the least damped.")
        return self

    @property
    def modes(self) -> int:
        return 0 if self.spins else max(self.mode, FEW_MODES)

    @property
    def spins(self) -> tuple[Band, ...]:
        given = self.at if self.at is not None else self.over
        return given.bands if isinstance(given, SpeedRange) else ()

    @property
    def reaches(self) -> tuple[float, ...]:
        return (self.up_to.value, *(band.high for band in self.spins)) if self.spins else ()

    @property
    def said_of(self) -> str:
        given = self.at if self.at is not None else self.over
        if not isinstance(given, SpeedRange):
            return ""
        spins = ", ".join(
            show(band.low, given.unit, ROTATION)
            if band.is_point
            else f"{show(band.low, given.unit, ROTATION).rpartition(' ')[0]}..{show(band.high, given.unit, ROTATION)}"
            for band in given.bands
        )
        up_to = show(self.up_to.value, self.up_to.unit, ROTATION)
        return f"of {self.whirl or 'free'} whirls up to {up_to} at {spins}"

    @property
    def absent(self) -> str:
        if not self.spins:
            return ""
        which = " ".join(filter(None, ("no" if self.mode == 1 else f"fewer than {self.mode}", self.whirl)))
        what = "whirl" if self.mode == 1 else "whirls"
        return f"{which} {what} up to {show(self.up_to.value, self.up_to.unit, ROTATION)}"

    def whirl_form(self) -> Form:
        bands = tuple((band.low, band.high) for band in self.spins)
        return WhirlDamping(self.ratio, bands, self.up_to.value, SENSES[self.whirl], self.mode)

    def whirl_damping(self, machine: Machine) -> float:
        """Of the built machine, by its waves."""
        from vibopt.mechanics.rotating import RotatingMachine
        from vibopt.mechanics.whirls_as_built import in_planes, least_over

        assert isinstance(machine, RotatingMachine)
        built, sense = in_planes(machine), SENSES[self.whirl]
        damping = _ratio if self.ratio else _decrement
        bands = [(band.low, band.high) for band in self.spins]
        return min(least_over(built, band, self.up_to.value, sense, self.mode, damping) for band in bands)


def _decrement(rate: complex) -> float:
    return 2.0 * np.pi * rate.imag / rate.real


def _ratio(rate: complex) -> float:
    return rate.imag / abs(rate)
