"""Where the mounts of a group stand, and which way they point, as a file says it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from vibopt.records import dataclass
from vibopt.values.directions import AXES, OpenVector, Span, Vector, read_direction, read_open_place, read_shift
from vibopt.values.fields import ReadBy, complaint

Single = tuple[Vector, ...]
OpenSingle = tuple[OpenVector, ...]


@dataclass(frozen=True, slots=True)
class Sites:
    """Places that a group may stand at: one of these sets is to be chosen; `given` is how the file says each."""

    options: tuple[Single, ...]
    given: tuple[object, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """A single place by its coordinates, a set by its number."""
        if all(len(option) == 1 for option in self.options):
            return tuple(", ".join(str(part) for part in one) for one in self.given if isinstance(one, list))
        return tuple(f"set {index + 1}" for index in range(len(self.options)))


def _set(given: object) -> OpenSingle:
    """One place or a list of them."""
    if isinstance(given, list) and given and all(isinstance(one, list) for one in given):
        found = tuple(read_open_place(one) for one in given)
        known = [one for one in found if not is_open(one)]
        if len(set(known)) < len(known):
            raise complaint("names a place twice. Give each mount a place of its own.")
        return found
    return (read_open_place(given),)


def is_open(place: OpenVector) -> bool:
    return any(isinstance(one, Span) for one in place)


def _at(given: object) -> object:
    if isinstance(given, (Sites, tuple)):
        return given
    if not isinstance(given, Mapping):
        return _set(given)
    listed = given.get("one_of")
    if set(given) != {"one_of"} or not isinstance(listed, list) or not listed:
        raise complaint(
            'is a choice without places. Write at = { one_of = [["0.6 m", "0.4 m", "0 m"], ["0.8 m", "0.4 m", '
            '"0 m"]] }.'
        )
    options: tuple[Any, ...] = tuple(_set(one) for one in listed)
    if any(is_open(place) for option in options for place in option):
        raise complaint("has a range in a place of one_of. Keep one of them: a list of places, or places with ranges.")
    if len({len(option) for option in options}) > 1:
        raise complaint("names sets of different sizes. Every set needs a place for each mount of the group.")
    return options[0] if len(options) == 1 else Sites(options, tuple(listed))


At = Annotated[
    Any,
    ReadBy(
        _at,
        {
            "anyOf": [{"type": "array"}, {"type": "object", "properties": {"one_of": {"type": "array"}}}],
            "description": "a place, a list of places, or { one_of = [...] }; a coordinate may be { from, to }",
        },
    ),
]
_SHIFTED = {"type": ["string", "number", "object"], "description": "a length, or { from, to }"}
Shift = Annotated[
    Any,
    ReadBy(
        read_shift,
        {"type": "object", "properties": dict.fromkeys(AXES, _SHIFTED), "additionalProperties": False},
    ),
]


def _directions(given: object) -> object:
    if isinstance(given, list) and given and all(isinstance(one, (list, str)) for one in given):
        return tuple(read_direction(one) for one in given)
    if isinstance(given, tuple) and given and isinstance(given[0], tuple):
        return given
    return (read_direction(given),)


Directions = Annotated[
    Any,
    ReadBy(_directions, {"type": ["string", "array"], "description": "one, or one a mount"}),
]
