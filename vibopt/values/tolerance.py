"""How far a number of the machine as built may be off."""

from __future__ import annotations

from collections.abc import Mapping

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


__all__ = ["read_tolerance"]
