"""Places on a shaft: a length from its left end, or the end of a section, wherever that comes to lie."""

import re
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, WithJsonSchema

from vibopt.errors import QuantityError
from vibopt.records import dataclass
from vibopt.units import read_quantity
from vibopt.values import Fact
from vibopt.values.fields import Choice, Rule, complaint, read_number

_END = re.compile(r"end of section (\d{1,4})")
_AT = Rule("length", choice=False, sign="not negative")


@dataclass(frozen=True, slots=True)
class EndOf:
    """The right end of a section, counted from 1."""

    section: int


Place = Fact | EndOf


def _end(given: object) -> EndOf | None:
    match = _END.fullmatch(given.strip()) if isinstance(given, str) else None
    return EndOf(int(match[1])) if match else None


def _at(given: object) -> Place:
    if isinstance(given, EndOf):
        return given
    found = _end(given) or read_number(_AT, given)
    assert not isinstance(found, Choice)  # the rule of a place has none
    return found


def _stations(given: object) -> object:
    if not isinstance(given, Mapping) or not given:
        raise complaint('names no station. Write stations = { left = "0 mm", right = "800 mm" }.')
    found = {}
    for name, place in given.items():
        try:
            found[str(name)] = place if isinstance(place, (Fact, EndOf)) else _end(place) or _place(place)
        except QuantityError as error:
            raise complaint(f'puts {name} at "{place}", which {error} Write {name} = "800 mm".') from None
    return found


def _place(given: object) -> Fact:
    quantity = read_quantity(given, "length")
    if quantity.value < 0.0:
        raise QuantityError("is left of the shaft.")
    return Fact(quantity.value, quantity.unit)


_WORDS = {"type": "string", "description": 'a length from the left end, or "end of section 2"'}
At = Annotated[Any, BeforeValidator(_at), WithJsonSchema(_WORDS)]
Stations = Annotated[
    Any, BeforeValidator(_stations), WithJsonSchema({"type": "object", "description": "places from the left end"})
]
