"""Places and directions in space: three lengths, a letter or three numbers."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import BeforeValidator, WithJsonSchema

from vibopt.errors import QuantityError
from vibopt.units import read_quantity
from vibopt.values.fields import complaint

Vector = tuple[float, float, float]

AXES = ("x", "y", "z")
UNIT: dict[str, Vector] = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
WAYS = 'Write "x", "y", "z" or three numbers, for example [0.5, 0, 0.866].'


def read_place(given: object) -> Vector:
    """Three lengths as coordinates [m]."""
    if isinstance(given, tuple):
        return given  # read already
    if not isinstance(given, list) or len(given) != 3:
        raise complaint('is no place. Write its three coordinates, for example ["0.8 m", "0.4 m", "0 m"].')
    return _lengths(given)


def _lengths(given: list[object]) -> Vector:
    found = []
    for axis, one in zip(AXES, given, strict=True):
        if isinstance(one, dict):
            raise complaint(
                f"leaves its {axis} open, but a place cannot be anywhere in a range. Name places to choose from: at = "
                '{ one_of = [["0.6 m", "0.4 m", "0 m"], ["0.8 m", "0.4 m", "0 m"]] }.'
            )
        try:
            found.append(0.0 if one == 0 and not isinstance(one, bool) else read_quantity(one, "length").value)
        except QuantityError as error:
            raise complaint(f"has a wrong {axis}: {one!r} {error}".replace("'", '"')) from None
    return found[0], found[1], found[2]


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
    if not isinstance(given, list) or len(given) != 3 or not all(_is_number(one) for one in given):
        raise complaint(f"is no direction. {WAYS}")
    size = math.sqrt(sum(one * one for one in given))
    if not 0.0 < size < math.inf:
        raise complaint(f"points nowhere. {WAYS}")
    return given[0] / size, given[1] / size, given[2] / size


def _is_number(given: object) -> bool:
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

__all__ = ["AXES", "UNIT", "Direction", "Place", "Reach", "Vector", "read_direction", "read_place", "read_reach"]
