"""A run-up or a run-down: the speed of a steady excitation changes evenly from one to another."""

import math
from collections.abc import Mapping
from itertools import pairwise
from typing import Annotated, Any

import numpy as np
from pydantic import create_model, model_validator

from vibopt.arrays import ComplexArray
from vibopt.errors import QuantityError
from vibopt.excitations.excitation import Excitation, straight_between
from vibopt.mechanics.motor import Motor
from vibopt.signals import Amplitude, Band, Piece, Sweep, Sweeps
from vibopt.units import read_quantity
from vibopt.values import Choice, Fact, Table, Value, number, word
from vibopt.values.fields import ReadBy, complaint

_WHOLE = 'chooses the duration. What may be chosen is the rate: acceleration = { from = "5 rpm/s", to = "500 rpm/s" }.'


def _torque(given: object, key: str) -> Amplitude:
    if not isinstance(given, list):
        if isinstance(given, Mapping) and "tolerance" in given:
            raise complaint(
                f'has a tolerance, and none is counted here. Write {key} = "15 N m", and solve again with the least '
                f'and the greatest: --set excitations.NAME.run_up.{key}="13.5 N m".'
            )
        try:
            return Amplitude((Piece(Band(0.0, math.inf), read_quantity(given, "moment").value),))
        except QuantityError as error:
            raise complaint(str(error)) from None
    if len(given) < 2 or not all(isinstance(row, list) and len(row) == 2 for row in given):
        raise complaint(
            f'is not a table of at least two rows [speed, torque]. Write {key} = [["0 rpm", "40 N m"], ["1500 rpm", '
            '"25 N m"]].'
        )
    try:
        at = [read_quantity(row[0], "angular_rate").value for row in given]
        torques = [read_quantity(row[1], "moment").value for row in given]
    except QuantityError as error:
        raise complaint(f"has a row that cannot be read: it {error}") from None
    return straight_between(at, torques)


def _driving(given: object) -> Amplitude:
    return given if isinstance(given, Amplitude) else _torque(given, "torque")


def _load(given: object) -> Amplitude:
    if isinstance(given, Amplitude):
        return given
    if not isinstance(given, Mapping):
        return _torque(given, "load")
    if {*given} != {"torque", "at", "varies"} or given["varies"] not in [*_POWERS]:
        raise complaint(
            'is no load that vibopt knows. Write { torque = "20 N m", at = "1500 rpm", varies = "speed^2" } (or '
            '"speed"), one torque, or rows of speed and torque.'
        )
    try:
        torque, at = read_quantity(given["torque"], "moment").value, read_quantity(given["at"], "angular_rate").value
    except QuantityError as error:
        raise complaint(f"has a value that cannot be read: it {error}") from None
    if not at > 0.0:
        raise complaint('grows with the speed, but is given at standstill. Write at = "1500 rpm".')
    power = _POWERS[given["varies"]]
    return Amplitude((Piece(Band(0.0, math.inf), torque / at**power, 0.0, power),))


_POWERS = {"speed": 1, "speed^2": 2}
_ROWS = {"anyOf": [{"type": "string"}, {"type": "array", "description": "rows [speed, torque]"}]}
Curve = Annotated[Amplitude, ReadBy(_driving, _ROWS)]
Load = Annotated[Amplitude, ReadBy(_load, {"anyOf": [*_ROWS["anyOf"], {"type": "object"}]})]


class RunUpTable(Table):
    """`run_up`, of an unbalance or a force: its speed rises or falls evenly, and stays at the last.

    Keys
    ----
    from: Speed at which it begins, in steady vibration: `from = "0 rpm"`, which is also what is taken without it.
    to: Speed at which it stays: `to = "3000 rpm"`; without it the greatest of the excitation's own.
    acceleration: Size of the change of the speed, also where it falls: `acceleration = "50 rpm/s"`, or to be chosen,
        `{ from = "5 rpm/s", to = "500 rpm/s" }`. One of `acceleration`, `duration` and `torque`.
    duration: How long it takes from the one speed to the other: `duration = "60 s"`.
    torque: Of the motor, of an unbalance: the speed then follows from torque, load and inertia, and the vibration takes
        up its part. One value, or rows of speed and torque, straight between them: `torque = [["0 rpm", "40 N m"],
        ["1500 rpm", "25 N m"]]`; below zero it brakes.
    load: Torque that the machine takes against the speed, as `torque`, or by a power of the speed: `load = { torque =
        "20 N m", at = "1500 rpm", varies = "speed^2" }`. Nothing without it.
    inertia: Of all that turns, with `torque`: `inertia = "3 kg m2"`.
    """

    to: Fact | None = number("angular_rate", choice=False, sign="not negative")
    acceleration: Value | None = number("angular_acceleration")
    duration: Fact | None = number("time", choice=False)
    torque: Curve | None = None
    load: Load | None = None
    inertia: Fact | None = number("inertia", choice=False)

    @model_validator(mode="before")
    @classmethod
    def _given_rate(cls, given: Any) -> Any:
        for key in given if isinstance(given, Mapping) else ():
            if key == "duration" and isinstance(given[key], Mapping):
                raise word(_WHOLE)
        return given

    @model_validator(mode="after")
    def _one_rate(self) -> "RunUpTable":
        said = [key for key in ("acceleration", "duration", "torque") if getattr(self, key) is not None]
        if len(said) > 1:
            raise word(f"gives {' and '.join(said)}. Keep one: each says how fast the speed changes.")
        if not said:
            raise word('needs one of acceleration, duration and torque. Write acceleration = "50 rpm/s".')
        if self.torque is not None and self.inertia is None:
            raise word('gives a torque, but to what inertia? Add inertia = "3 kg m2", of all that turns.')
        rate = self.acceleration
        if rate is not None and rate.tolerance:
            raise word(
                "gives the acceleration a tolerance: peaks rise and fall with the rate, and are worst anywhere in it. "
                'Write acceleration = { from = "45 rpm/s", to = "55 rpm/s" }, and [goal] with maximise and the peak.'
            )
        if isinstance(rate, Choice) and (rate.open_low or math.isinf(rate.high)):
            raise word(
                "chooses the acceleration in a range without both ends: a run-up at no rate takes for ever. Write { "
                'from = "5 rpm/s", to = "500 rpm/s" }.'
            )
        idle = [key for key in ("load", "inertia") if getattr(self, key) is not None and self.torque is None]
        if idle:
            raise word(
                f"gives {idle[0]} and {said[0]}, which says the rate already. Write torque instead, or remove it."
            )
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
    return table.begins, table.to.value if table.to is not None else max(band.high for band in excitation.own_bands())


def motor_of(excitation: Excitation) -> Motor | None:
    """What turns it, where its speed follows from torque."""
    table = _ramp(excitation)
    if table.torque is None or table.inertia is None:
        return None
    load = table.load or Amplitude((Piece(Band(0.0, math.inf), 0.0),))
    return Motor(*ends_of(excitation), table.torque, load, table.inertia.value, abs(excitation.swung))


def rate_of(excitation: Excitation) -> float:
    """Change of its speed [rad/s^2], the slowest where it may be chosen; below zero where it falls."""
    table = _ramp(excitation)
    low, high = ends_of(excitation)
    if table.duration is not None:
        return (high - low) / table.duration.value
    size = table.acceleration
    assert size is not None
    return math.copysign(size.low if isinstance(size, Choice) else size.value, high - low)


def at_rate(excitation: Excitation, size: float | None) -> Excitation:
    """Itself with its rate as it was chosen [rad/s^2]; as it is with None."""
    if size is None:
        return excitation
    table = _ramp(excitation).model_copy(update={"acceleration": Fact(size, "rad/s²")})
    return excitation.model_copy(update={"run_up": table})


def course_of(excitation: Excitation, places: Mapping[str, int], name: str) -> Sweep | Sweeps | Motor:
    """Its force against the speed, and how that changes, or what changes it; places of the variables by path."""
    motor = motor_of(excitation)
    if motor is not None:
        return motor
    if isinstance(_ramp(excitation).acceleration, Choice):
        return Sweeps(lambda size: _sweep(at_rate(excitation, size)), places[RATE.format(name)])
    return _sweep(excitation)


def _sweep(excitation: Excitation) -> Sweep:
    low, high = ends_of(excitation)
    [line] = excitation.lines(np.ones(1))
    rate, amplitude, own = rate_of(excitation), line.amplitude, sorted((low, high))
    joints = [own[0], *(value for value in amplitude.breaks() if own[0] < value < own[1]), own[1]]
    powers = [_powers(amplitude, 0.5 * (a + b), -1j * rate * excitation.swung) for a, b in pairwise(joints)]
    still = amplitude.at(np.array([low, high]))
    if rate < 0.0:
        joints, powers = joints[::-1], powers[::-1]
    return Sweep(tuple(joints), (rate,) * len(powers), tuple(powers), (float(still[0]), float(still[1])))


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


RATE = "excitations.{}.run_up.acceleration"
"""Path of a rate that may be chosen."""
