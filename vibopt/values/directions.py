"""Places and directions in space: three lengths, a letter or three numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Annotated

from pydantic import BeforeValidator, WithJsonSchema

from vibopt.errors import QuantityError
from vibopt.records import dataclass
from vibopt.units import plain, read_quantity
from vibopt.values.fields import complaint, wrong_part

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Span:
    """A coordinate that is to be chosen between `low` and `high` [m]; `unit` is how the user wrote it."""

    low: float
    high: float
    unit: str

    @property
    def middle(self) -> float:
        """Half way [m]."""
        return 0.5 * (self.low + self.high)


Coordinate = float | Span
OpenVector = tuple[Coordinate, Coordinate, Coordinate]
AXES = ("x", "y", "z")
SIX = ("xx", "yy", "zz", "xy", "yz", "zx")
UNIT: dict[str, Vector] = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
WAYS = 'Write "x", "y", "z" or three numbers, for example [0.5, 0, 0.866].'


def axis_words(vector: Iterable[float]) -> str:
    """An axis in words, "x" or "(0.5, 0, 0.87)", whichever way along it."""
    given = [float(one) for one in vector]
    unit = [one / math.hypot(*given) for one in given]
    for axis, part in zip(AXES, unit, strict=True):
        if abs(part) > 1.0 - 1e-6:
            return axis
    sense = math.copysign(1.0, max(unit, key=abs))
    return f"({', '.join(f'{round(sense * one, 3) + 0.0:g}' for one in unit)})"


def is_tensor(given: object) -> bool:
    """Whether an inertia, as it stands in a file, is that of a body in space."""
    return isinstance(given, list) or (isinstance(given, Mapping) and bool(set(given) & set(SIX)))


def read_place(given: object) -> Vector:
    """Three lengths as coordinates [m]."""
    if isinstance(given, tuple):
        return given  # read already
    if not isinstance(given, list) or len(given) != 3:
        raise complaint('is no place. Write its three coordinates, for example ["0.8 m", "0.4 m", "0 m"].')
    return _lengths(given)


def read_open_place(given: object) -> OpenVector:
    """Three coordinates, each a length [m] or a range to choose from."""
    if isinstance(given, tuple):
        return given
    if not isinstance(given, list) or len(given) != 3:
        return read_place(given)
    x, y, z = (_coordinate(axis, one) for axis, one in zip(AXES, given, strict=True))
    return x, y, z


def read_shift(given: object) -> OpenVector:
    """How far all places of a group are moved along each axis: a length [m] or a range to choose from."""
    if isinstance(given, tuple):
        return given
    if not isinstance(given, Mapping) or not given or not set(given) <= set(AXES):
        raise complaint(
            'is no shift. Write how far along each axis, shift = { x = { from = "-0.2 m", to = "0.2 m" } }.'
        )
    x, y, z = (_coordinate(axis, given.get(axis, 0)) for axis in AXES)
    return x, y, z


def _coordinate(axis: str, given: object) -> Coordinate:
    return _span(axis, given) if isinstance(given, Mapping) else _length(axis, given)


def _span(axis: str, given: Mapping[str, object]) -> Span:
    """A coordinate { from, to }."""
    if "one_of" in given:
        raise complaint(
            f"has a list of values for its {axis}, but a coordinate is one value or a range. Name whole places to "
            'choose from: at = { one_of = [["0.6 m", "0.4 m", "0 m"], ["0.8 m", "0.4 m", "0 m"]] }.'
        )
    for key in given:
        if key not in ("from", "to"):
            raise complaint(f'has the unknown key "{key}" in its {axis}. A range of places has from and to.')
    if set(given) != {"from", "to"}:
        raise complaint(
            f'has an {axis} without an end, but a place is somewhere. Write both: {{ from = "0.6 m", to = "1 m" }}.'
        )
    ends = []
    for key in ("from", "to"):
        try:
            ends.append(read_quantity(given[key], "length"))
        except QuantityError as error:
            raise wrong_part(f"{key} of its {axis}", given[key], error) from None
    low, high = ends
    if low.value > high.value:
        raise complaint(f"has a reversed range for its {axis}: from is greater than to. Exchange the two.")
    if low.value == high.value:
        raise complaint(f"has an empty range for its {axis}: from equals to. Write the value alone.")
    return Span(low.value, high.value, low.unit or high.unit)


def _lengths(given: list[object]) -> Vector:
    for axis, one in zip(AXES, given, strict=True):
        if isinstance(one, Mapping):
            raise complaint(f"leaves its {axis} open, but only mounts have places to choose. Write one length.")
    x, y, z = (_length(axis, one) for axis, one in zip(AXES, given, strict=True))
    return x, y, z


def _length(axis: str, given: object) -> float:
    try:
        return 0.0 if given == 0 and not isinstance(given, bool) else read_quantity(given, "length").value
    except QuantityError as error:
        raise wrong_part(axis, given, error) from None


def read_reach(given: object) -> Vector:
    """How far a place may be off along x, y, z [m]: one length for all three, or three."""
    if isinstance(given, tuple):
        return given
    three = given if isinstance(given, list) else [given] * 3
    if len(three) != 3:
        raise complaint('is neither a length nor three. Write "20 mm", or ["20 mm", "10 mm", "0 m"].')
    found = _lengths(three)
    if min(found) < 0.0:
        raise complaint("is negative, but a tolerance goes both ways. Write it without the sign.")
    return found


def read_direction(given: object) -> Vector:
    """A direction of length one."""
    if isinstance(given, tuple):
        return given
    if isinstance(given, str) and given in UNIT:
        return UNIT[given]
    if not isinstance(given, list) or len(given) != 3 or not all(is_number(one) for one in given):
        raise complaint(f"is no direction. {WAYS}")
    size = math.sqrt(sum(one * one for one in given))
    if not 0.0 < size < math.inf:
        raise complaint(f"points nowhere. {WAYS}")
    return given[0] / size, given[1] / size, given[2] / size


def way_words(way: Vector) -> str:
    """A direction as it is said: "z", or "(0.6, 0, 0.8)"."""
    letter = next((one for one in AXES if way == UNIT[one]), None)
    return letter or f"({', '.join(plain(one, 3) for one in way)})"


def is_number(given: object) -> bool:
    """Whether it is a number, and neither a truth value nor a text."""
    return isinstance(given, (int, float)) and not isinstance(given, bool)


_PLACE = {"type": "array", "minItems": 3, "maxItems": 3, "description": "coordinates, for example 0.8 m"}
_DIRECTION = {
    "anyOf": [{"enum": list(AXES)}, {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3}]
}
Place = Annotated[Vector, BeforeValidator(read_place), WithJsonSchema(_PLACE)]
Reach = Annotated[
    Vector,
    BeforeValidator(read_reach),
    WithJsonSchema({"anyOf": [{"type": "string"}, _PLACE], "description": "how far it may be off, 20 mm"}),
]
Direction = Annotated[Vector, BeforeValidator(read_direction), WithJsonSchema(_DIRECTION)]
