"""A run-up or a run-down: the speed of a steady excitation changes evenly from one to another."""

import math
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from pydantic import create_model, model_validator

from vibopt.arrays import ComplexArray
from vibopt.excitations.excitation import Excitation
from vibopt.signals import Amplitude, Band, Sweep
from vibopt.values import Fact, Table, number, word

_WHOLE = (
    "chooses the {}, but a run-up has a given one: its greatest amplitude rises and falls with the rate, so that no "
    "rate between two good ones is sure to be good. Write one value, and look at all of them with vibopt sweep."
)


class RunUpTable(Table):
    """`run_up`, of an unbalance or a force: its speed rises or falls evenly, and stays at the last.

    Keys
    ----
    from: Speed at which it begins, in steady vibration: `from = "0 rpm"`, which is also what is taken without it.
    to: Speed at which it stays: `to = "3000 rpm"`; without it the greatest of the excitation's own.
    acceleration: Size of the change of the speed, also where it falls: `acceleration = "50 rpm/s"`. One of
        `acceleration` and `duration`.
    duration: How long it takes from the one speed to the other: `duration = "60 s"`.
    """

    to: Fact | None = number("angular_rate", choice=False, sign="not negative")
    acceleration: Fact | None = number("angular_acceleration", choice=False)
    duration: Fact | None = number("time", choice=False)

    @model_validator(mode="before")
    @classmethod
    def _given_rate(cls, given: Any) -> Any:
        for key in given if isinstance(given, Mapping) else ():
            if key in ("torque", "inertia", "load"):
                raise word(
                    f"speaks of a {key}. Near a resonance the vibration takes up torque, so that a weak motor may "
                    'stick there, which is not answered yet. Write the rate that it reaches: acceleration = "50 rpm/s".'
                )
            if key in ("acceleration", "duration") and isinstance(given[key], Mapping):
                raise word(_WHOLE.format(key))
        return given

    @model_validator(mode="after")
    def _one_rate(self) -> "RunUpTable":
        if (self.acceleration is None) == (self.duration is None):
            raise word('needs one of acceleration and duration. Write acceleration = "50 rpm/s".')
        if self.to is not None and self.to.value == self.begins:
            raise word("ends at the speed at which it begins. Write another to, or leave run_up out.")
        return self

    @property
    def begins(self) -> float:
        """Speed at which it begins [rad/s]."""
        given: Fact | None = getattr(self, "from")
        return given.value if given is not None else 0.0


RunUp = create_model(
    "RunUpTable",
    __base__=RunUpTable,
    __module__=__name__,
    **{"from": (Fact | None, number("angular_rate", choice=False, sign="not negative"))},  # type: ignore[call-overload]
)
"""With the key that is no name of Python."""


def _ramp(excitation: Excitation) -> RunUpTable:
    assert excitation.ramp is not None
    return excitation.ramp


def ends_of(excitation: Excitation) -> tuple[float, float]:
    """Speeds at which its run-up begins and stays [rad/s]."""
    table = _ramp(excitation)
    return table.begins, table.to.value if table.to is not None else max(one.high for one in excitation.own_bands())


def rate_of(excitation: Excitation) -> float:
    """Change of its speed [rad/s^2]; below zero where it falls."""
    table = _ramp(excitation)
    low, high = ends_of(excitation)
    if table.duration is not None:
        return (high - low) / table.duration.value
    assert table.acceleration is not None
    return math.copysign(table.acceleration.value, high - low)


def sweep_of(excitation: Excitation) -> Sweep:
    """Its force against the speed, and how that changes."""
    low, high = ends_of(excitation)
    [line] = excitation.lines(np.ones(1))
    rate, amplitude, own = rate_of(excitation), line.amplitude, sorted((low, high))
    joints = [own[0], *(one for one in amplitude.breaks() if own[0] < one < own[1]), own[1]]
    powers = [_powers(amplitude, 0.5 * (a + b), -1j * rate * excitation.swung) for a, b in pairwise(joints)]
    still = amplitude.at(np.array([low, high]))
    if rate < 0.0:
        joints, powers = joints[::-1], powers[::-1]
    return Sweep(tuple(joints), rate, tuple(powers), (float(still[0]), float(still[1])))


def _powers(amplitude: Amplitude, speed: float, along: complex) -> ComplexArray:
    """Powers of the speed of the piece that holds at one, and what the change of speed adds."""
    piece = next((one for one in amplitude.pieces if one.band.holds(speed)), amplitude.pieces[-1])
    found = np.zeros(piece.power + (2 if piece.slope else 1), dtype=complex)
    found[piece.power] = piece.constant
    if piece.slope:
        found[piece.power + 1] = piece.slope
    found[0] += along
    return found


def band_of(excitation: Excitation) -> Band:
    """All speeds that its run-up goes through [rad/s]."""
    return Band(*sorted(ends_of(excitation)))


__all__ = ["RunUp", "RunUpTable", "band_of", "ends_of", "rate_of", "sweep_of"]
