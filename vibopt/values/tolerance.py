"""How far a number of the machine as built may be off."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

from pydantic import BeforeValidator, WithJsonSchema
from pydantic_core import PydanticCustomError

from vibopt.errors import QuantityError
from vibopt.units import read_quantity

_WAY_OUT = 'Write less than 100 %, for example tolerance = "5 %".'


def read_tolerance(given: object) -> float:
    """A part of the value, "5 %" as 0.05.

    Raises
    ------
    QuantityError
        No ratio, negative, or so much that nothing of the value may be left.
    """
    if isinstance(given, str) and given.strip().endswith("dB"):
        raise QuantityError(f"has a tolerance in dB. {_WAY_OUT}")
    if isinstance(given, (Mapping, list, bool)):
        raise QuantityError(f"has a tolerance that is no number. {_WAY_OUT}")
    try:
        value = read_quantity(given, "ratio").value
    except QuantityError:
        raise QuantityError(f"has a tolerance that is no ratio. {_WAY_OUT}") from None
    if value < 0.0:
        raise QuantityError("has a negative tolerance, but a tolerance goes both ways. Write it without the sign.")
    if not value < 1.0:
        raise QuantityError(f"has a tolerance that may leave nothing of it. {_WAY_OUT}")
    return value


def _of_table(given: object) -> object:
    try:
        return read_tolerance(given)
    except QuantityError as error:
        raise PydanticCustomError("complaint", "{text}", {"text": str(error)}) from None


Tolerance = Annotated[
    float,
    BeforeValidator(_of_table),
    WithJsonSchema({"type": ["string", "number"], "description": "how far each number of the table may be off, 5 %"}),
]
"""`tolerance = "5 %"` of a whole table: each of its numbers on its own."""

__all__ = ["Tolerance", "read_tolerance"]
