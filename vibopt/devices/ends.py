"""The two ends of what acts between points, as a file says them: a pair, or pairs of which the best is found."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any

from vibopt.values.fields import ReadBy, complaint

if TYPE_CHECKING:
    from vibopt.devices.device import Ends


class OpenEnds(tuple[str, str]):
    """Pairs of ends of which the best is to be found; until it is, it stands for the first of them."""

    options: tuple[Ends, ...]

    @classmethod
    def of(cls, options: tuple[Ends, ...]) -> OpenEnds:
        """Of at least one pair."""
        made = cls(options[0])
        made.options = options
        return made


def _pair(given: object) -> Ends:
    if not isinstance(given, (list, tuple)) or len(given) != 2 or not all(isinstance(one, str) for one in given):
        raise complaint('is not a pair of names. Write between = ["machine", "ground"].')
    if given[0] == given[1]:
        raise complaint("joins a point with itself. Name two different ends.")
    return given[0], given[1]


def _chosen(given: object) -> Ends:
    if not isinstance(given, Mapping):
        return given if isinstance(given, OpenEnds) else _pair(given)
    listed = given.get("one_of")
    if "value" in given:
        return _pair(given)
    if set(given) != {"one_of"} or not isinstance(listed, (list, tuple)) or not listed:
        raise complaint(
            'is a choice without pairs. Write between = { one_of = [["machine", "joint"], ["joint", "ground"]] }.'
        )
    options = tuple(_pair(one) for one in listed)
    if len({frozenset(one) for one in options}) < len(options):
        raise complaint("names a pair twice. Name each once.")
    return options[0] if len(options) == 1 else OpenEnds.of(options)


_PAIR: dict[str, Any] = {"type": "array", "items": {"type": "string"}, "minItems": 2, "maxItems": 2}
_CHOICE = {
    "type": "object",
    "properties": {"one_of": {"type": "array", "items": _PAIR, "minItems": 1}},
    "required": ["one_of"],
    "additionalProperties": False,
}
TwoEnds = Annotated[tuple[str, str], ReadBy(_pair, _PAIR)]
ChosenEnds = Annotated[tuple[str, str], ReadBy(_chosen, {"anyOf": [_PAIR, _CHOICE]})]
"""`OpenEnds` where the file says `{ one_of = [...] }`."""
