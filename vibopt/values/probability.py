"""The share of all machines that shall keep a limit."""

from __future__ import annotations

from typing import Annotated

from vibopt.errors import QuantityError
from vibopt.units import read_quantity
from vibopt.values.fields import ReadBy, complaint

LEAST, MOST = 0.5, 0.999999
_HAIR = 1e-12
"""Part by which "99.9999 %" may be read beside the number of that name."""


def _read(given: object) -> float:
    """A share of all machines."""
    way = 'Write a share from "50 %" to "99.9999 %", for example with_probability = "99 %".'
    try:
        value = read_quantity(given, "ratio").value
    except QuantityError:
        raise complaint(f"is no share of all machines. {way}") from None
    if value >= 1.0:
        what = "more than all machines" if value > 1.0 else "all machines"
        raise complaint(f"is {what}. For every machine within the tolerances leave it out. {way}")
    if not LEAST - _HAIR <= value <= MOST + _HAIR:
        raise complaint(f"is no share that machines which are drawn can tell. {way}")
    return min(max(value, LEAST), MOST)


Probability = Annotated[
    float | None,
    ReadBy(_read, {"type": ["string", "number"], "description": "share of all machines that shall keep the limit"}),
]
