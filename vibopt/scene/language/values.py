"""Values as Python gives them, turned into what a problem file would hold."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Integral, Real
from typing import TypeAlias

Bound: TypeAlias = str | float
"""A value with its unit, "6 kN"; pure ratios may be numbers."""

Given: TypeAlias = str | float | Mapping[str, object]
"""A fact as Bound, or a choice made by `choose` or `one_of`."""

Way: TypeAlias = str | Sequence[float]
"""A direction or an axis in space: "x", "y", "z" or three numbers."""

Speeds: TypeAlias = str | Sequence[str] | Mapping[str, object]
"""A speed, "800..2000 rpm", or a list of those; a choice; per excitation as a mapping."""


def plain_table(words: Mapping[str, object]) -> dict[str, object]:
    """The words as a table of a problem file; what is None is not said."""
    return {key: plain(value) for key, value in words.items() if value is not None}


def plain(value: object) -> object:
    """A value as TOML knows it, in new lists and tables; what TOML does not know is left to the reader to refuse."""
    if isinstance(value, (str, bool)):
        return value
    if isinstance(value, Integral):
        return int(value)
    if isinstance(value, Real):
        return float(value)
    if isinstance(value, Mapping):
        return plain_table(value)
    if isinstance(value, (list, tuple)):
        return [plain(one) for one in value]
    return value
