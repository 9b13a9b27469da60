"""Names and values of the file in words, short enough for a column or a picture."""

from __future__ import annotations

from collections.abc import Mapping

END = 4
LAST_DRAWN = "\u0530"
"""The font of figures knows Latin, Greek and Cyrillic letters, all below this."""


def short(name: str, longest: int) -> str:
    """A name without its middle where it is longer than `longest` letters; the number at its end is kept."""
    if len(name) <= longest:
        return name
    return f"{name[: longest - END - 3]}...{name[-END:]}"


def drawn(name: str, longest: int) -> str:
    """A name for a figure: short, no formula, and "?" for letters that its font does not have."""
    known = "".join(letter if letter < LAST_DRAWN else "?" for letter in short(name, longest))
    return known.replace("$", r"\$")


def said(value: object) -> str:
    """A value of the file in its own words; of a list of plain ones in brackets, of a single one without."""
    if isinstance(value, Mapping):
        return " ".join(f"{key} {said(one)}" for key, one in value.items())
    if isinstance(value, (list, tuple)):
        flat = len(value) > 1 and all(not isinstance(one, (Mapping, list, tuple)) for one in value)
        listed = ", ".join(said(one) for one in value)
        return f"({listed})" if flat else listed
    return str(value)


__all__ = ["drawn", "said", "short"]
