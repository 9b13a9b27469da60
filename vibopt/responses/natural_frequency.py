"""Undamped natural frequencies."""

from __future__ import annotations

from typing import Any, ClassVar

from pydantic import model_validator

from vibopt.errors import QuantityError
from vibopt.forms import Combine, Drive, Form, ModeFrequency
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import Model
from vibopt.responses.kind import BoundError, Response
from vibopt.values import SpeedRange, read_speeds, word


class NaturalFrequency(Response):
    """`response = "natural_frequency"`: mode number `mode` [rad/s], or all modes `outside` a band."""

    mode: int = 1
    outside: Any = None
    dimension: ClassVar[str] = "angular_rate"

    @model_validator(mode="before")
    @classmethod
    def _band(cls, given: Any) -> Any:
        if not isinstance(given, dict) or given.get("outside") is None or isinstance(given["outside"], SpeedRange):
            return given
        try:
            speeds = read_speeds(given["outside"])
        except QuantityError as error:
            raise BoundError("outside", given["outside"], str(error)) from None
        if any(band.is_point for band in speeds.bands):
            raise BoundError("outside", given["outside"], 'is no range. Write outside = "20..30 Hz".')
        return {**given, "outside": speeds}

    @model_validator(mode="after")
    def _words(self) -> NaturalFrequency:
        if self.mode < 1:
            raise word("has a mode below 1. Modes are counted from 1, the lowest.")
        if self.outside is not None and "mode" in self.model_fields_set:
            raise word("has both mode and outside. `outside` speaks of all modes: leave mode out.")
        return self

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        return ModeFrequency(0 if self.outside is not None else self.mode)

    def measure_static(self, machine: Machine) -> float:
        return float(machine.natural_frequencies()[self.mode - 1])
