"""The share of all machines that shall keep a limit."""

from __future__ import annotations

from functools import partial
from typing import Annotated

from vibopt.errors import QuantityError
from vibopt.units import read_quantity
from vibopt.values.fields import ReadBy, complaint

LEAST, MOST = 0.5, 0.999999
_HAIR = 1e-12
"""Part by which "99.9999 %" may be read beside the number of that name."""


def _read(given: object, all_of: str, without: str) -> float:
    """A share of all machines, or of all rotors that the readings leave possible."""
    way = 'Write a share from "50 %" to "99.9999 %", for example with_probability = "99 %".'
    try:
        value = read_quantity(given, "ratio").value
    except QuantityError:
        raise complaint(f"is no share of all {all_of}. {way}") from None
    if value >= 1.0:
        what = f"{'more than ' * (value > 1.0)}all {all_of}"
        raise complaint(f"is {what}. For {without} leave it out. {way}")
    if not LEAST - _HAIR <= value <= MOST + _HAIR:
        raise complaint(f"is no share that {all_of} which are drawn can tell. {way}")
    return min(max(value, LEAST), MOST)


_SCHEMA = {"type": ["string", "number"], "description": "share of all machines that shall keep the limit"}
_MACHINES = partial(_read, all_of="machines", without="every machine within the tolerances")
_ROTORS = partial(_read, all_of="rotors", without="the rotor that the readings predict")

Probability = Annotated[float | None, ReadBy(_MACHINES, _SCHEMA)]
ProbabilityOfRotors = Annotated[float | None, ReadBy(_ROTORS, _SCHEMA)]
