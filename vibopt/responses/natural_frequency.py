"""Undamped natural frequencies."""

import math
from collections.abc import Mapping
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import model_validator

from vibopt.arrays import FloatArray
from vibopt.errors import QuantityError
from vibopt.forms import DampedCriticalSpeed, Form, ModeFrequency
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import Model
from vibopt.records import dataclass
from vibopt.responses.response import Response
from vibopt.signals import Band, Combine, Drive
from vibopt.units import read_quantity
from vibopt.values import SpeedRange, read_speeds, word
from vibopt.values.fields import KeyedError
from vibopt.values.speeds import ROTATION, merged

_BEYOND = 1.25
"""Times the highest band up to which critical speeds are looked for."""
_EXAMPLE = 'Write outside = { orders = [0.5, 1, 2], of = "engine", margin = "20 %" }.'


@dataclass(frozen=True, slots=True)
class Orders:
    """Orders of the speeds of the excitation `of`, each widened by `margin` either way."""

    orders: tuple[float, ...]
    of: str
    margin: float

    def bands(self, speeds: tuple[Band, ...], unit: str) -> SpeedRange:
        """The bands that they are at the speeds of the excitation [rad/s], shown in a unit."""
        wide = 1.0 - self.margin, 1.0 + self.margin
        found = [Band(n * speed.low * wide[0], n * speed.high * wide[1]) for n in self.orders for speed in speeds]
        return SpeedRange(merged(tuple(sorted(found, key=lambda band: band.low))), ROTATION, unit)


def _orders(given: Mapping[str, Any]) -> Orders:
    unknown = sorted(set(given) - {"orders", "of", "margin"})
    if unknown:
        raise QuantityError(f'has an unknown key "{unknown[0]}". {_EXAMPLE}')
    missing = [key for key in ("orders", "of", "margin") if key not in given]
    if missing:
        raise QuantityError(f"has no {missing[0]}. {_EXAMPLE}")
    listed = given["orders"] if isinstance(given["orders"], list) else [given["orders"]]
    if not listed or not all(isinstance(n, (int, float)) and not isinstance(n, bool) and 0 < n < 1e6 for n in listed):
        raise QuantityError(f"has orders that are no numbers above zero. {_EXAMPLE}")
    if not isinstance(given["of"], str):
        raise QuantityError(f"names no excitation in of. {_EXAMPLE}")
    try:
        margin = read_quantity(given["margin"], "ratio").value
    except QuantityError:
        raise QuantityError(f"has a margin that is no ratio. {_EXAMPLE}") from None
    if not 0.0 < margin < 1.0:
        raise QuantityError(f"has a margin that is not between 0 and 100 %. {_EXAMPLE}")
    return Orders(tuple(float(n) for n in listed), given["of"], margin)


class NaturalFrequency(Response):
    """`response = "natural_frequency"`: mode number `mode` [rad/s], or all modes `outside` bands or orders.

    Keys
    ----
    mode: Number of the mode, 1 is the lowest.
    outside: No mode may lie in these ranges, or near these orders of a speed: `outside = "20..30 Hz"`, or `{ orders
        = [1, 2], of = "engine", margin = "20 %" }`. Limits only; not beside `mode`. A bound in the same limit is one on
        the lowest mode.
    """

    mode: int = 1
    outside: Any = None
    dimension: ClassVar[str] = "angular_rate"
    against_friction: ClassVar[str] = ""
    other_bound: ClassVar[str] = " (or outside)"
    unit_without: ClassVar[str] = "Hz"

    @model_validator(mode="before")
    @classmethod
    def _band(cls, given: Any) -> Any:
        if not isinstance(given, dict) or isinstance(given.get("outside"), (type(None), SpeedRange, Orders)):
            return given
        try:
            if isinstance(given["outside"], Mapping):
                return {**given, "outside": _orders(given["outside"])}
            speeds = read_speeds(given["outside"])
        except QuantityError as error:
            raise KeyedError("outside", given["outside"], str(error)) from None
        if any(band.is_point for band in speeds.bands):
            raise KeyedError("outside", given["outside"], 'is no range. Write outside = "20..30 Hz".')
        return {**given, "outside": speeds}

    @model_validator(mode="after")
    def _words(self) -> "NaturalFrequency":
        if self.mode < 1:
            raise word("has a mode below 1. Modes are counted from 1, the lowest.")
        if self.outside is not None and "mode" in self.model_fields_set:
            raise word("has both mode and outside. `outside` speaks of all modes: leave mode out.")
        return self

    @property
    def modes(self) -> int:
        return self.mode

    @property
    def outside_bands(self) -> tuple[Band, ...]:
        return self.outside.bands if isinstance(self.outside, SpeedRange) else ()

    @property
    def orders_of(self) -> str:
        return self.outside.of if isinstance(self.outside, Orders) else ""

    def at_orders(self, speeds: tuple[Band, ...]) -> Response:
        return self.model_copy(update={"outside": self.outside.bands(speeds, self.unit_without)})

    def asked_by(self, side: str) -> Response:
        """Bands speak of all modes; beside them `at_most` and `at_least` speak of the lowest, as by themselves."""
        one_sided = self.outside is not None and side in ("at_most", "at_least")
        return self.model_copy(update={"outside": None}) if one_sided else self

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        return ModeFrequency(0 if self.outside is not None else self.mode)

    def measure_static(self, machine: Machine) -> float:
        found = self.frequencies_of(machine)
        if self.mode > len(found):
            return float("inf")
        value: float = found[self.mode - 1]
        return value if np.ndim(value) else float(value)  # of many machines it is an array


class CriticalSpeed(NaturalFrequency):
    """`response = "critical_speed"`: speed at which a rotor whirls freely as fast as it spins [rad/s].

    Keys
    ----
    whirl: "forward", with the spin, as an unbalance drives it, or "backward": `whirl = "backward"`. Without it forward;
        in bearings that are not alike in both planes both, for an unbalance drives both there. One along a line,
        forward and backward alike, counts in either.
    damped: Whether dampers count, and bearings that change with the speed or drive a whirl: `damped = true`. Whirls
        damped by 1/sqrt(2) of critical and more have no resonance, and are left out. Without it the rotor is undamped.
    """

    whirl: Literal["forward", "backward"] | None = None
    damped: bool = False
    whirls: ClassVar[bool] = True
    unit_without: ClassVar[str] = "rpm"

    @property
    def modes(self) -> int:
        looked_for = self.damped and self.outside is not None and self.at_most is None and self.at_least is None
        return 0 if looked_for else self.mode

    @property
    def free_vibration(self) -> str:
        return "damped critical speed" if self.damped else ""

    @property
    def reaches(self) -> tuple[float, ...]:
        """The one told is the nearest to a band: the lowest, or no farther from a band than what is below that one."""
        if self.damped:
            return (self._top,) if self.outside is not None else ()
        return tuple(band.low + band.high for band in self.outside_bands)

    @property
    def said_of(self) -> str:
        return (
            f"of {self.whirl} damped whirl" if self.damped and self.whirl else "of damped whirl" if self.damped else ""
        )

    @property
    def _top(self) -> float:
        """Highest spin at which what bands forbid, or what is nearest to them, is looked for [rad/s]; 0 of a mode."""
        return _BEYOND * max((band.high for band in self.outside_bands), default=0.0)

    def seen_in(self, model: Model) -> Model:
        if not self.damped and model.bearings:
            return model.undamped
        return model.backward if self.whirl == "backward" and not self.damped else model

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        if not (self.damped or model.bearings):
            return super().form(model, drives, combine)
        bands = tuple((band.low, band.high) for band in self.outside_bands)
        top = self._top if self.damped else 0.0
        return DampedCriticalSpeed(self._sense(bool(model.bearings)), 0 if bands else self.mode, bands, top)

    def frequencies_of(self, machine: Machine) -> FloatArray:
        from vibopt.mechanics.orbiting import OrbitingMachine
        from vibopt.mechanics.rotating import RotatingMachine
        from vibopt.mechanics.whirls_as_built import as_fast, in_planes, undamped_as_fast

        assert isinstance(machine, RotatingMachine)
        sense = self._sense(isinstance(machine, OrbitingMachine))
        if not self.damped and isinstance(machine, OrbitingMachine):
            return undamped_as_fast(machine, sense)
        if not self.damped:
            return machine.critical_speeds(sense)
        many = 0 if self.outside is not None else self.mode
        return as_fast(in_planes(machine), sense, 1.0 / math.sqrt(2.0), self._top, many)

    def looked_to(self, machine: Machine) -> float:
        if not (self.damped and self.outside is not None):
            return super().looked_to(machine)
        from vibopt.mechanics.orbiting import OrbitingMachine

        return machine.searched(self._top) if isinstance(machine, OrbitingMachine) else self._top

    def _sense(self, in_unlike: bool) -> float:
        """1 of whirls with the spin, -1 against it, 0 of both, in bearings that are not alike in both planes."""
        return -1.0 if self.whirl == "backward" else 0.0 if in_unlike and self.whirl is None else 1.0
