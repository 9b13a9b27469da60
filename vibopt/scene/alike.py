"""Whether two tables of a file say the same device: by their numbers, in whatever words and units they stand."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any

from pydantic import BaseModel

_WORDING = ("unit", "echo")
_DIGITS = 12


def numbers_of(given: Any) -> Any:
    """What a table says [SI], without the units and texts in which it says it; comparable."""
    from vibopt.devices.absorber import Places

    if isinstance(given, BaseModel):
        return tuple((name, numbers_of(getattr(given, name))) for name in type(given).model_fields)
    if isinstance(given, Places):
        return tuple(sorted(given.names))
    if is_dataclass(given) and not isinstance(given, type):
        return tuple(
            (one.name, numbers_of(getattr(given, one.name))) for one in fields(given) if one.name not in _WORDING
        )
    if isinstance(given, list | tuple):
        return tuple(numbers_of(one) for one in given)
    if isinstance(given, float):
        return float(f"{given:.{_DIGITS}g}")
    return given if isinstance(given, str | int | bool | None) else repr(given)


__all__ = ["numbers_of"]
