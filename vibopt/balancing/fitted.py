"""Weights that are decided: a plane whose weight is a value and no range to choose from, as a saved plan has them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from vibopt.balancing.planes import Fitted, Plane, read_fitted, unit_of
from vibopt.balancing.rotor_tables import read_value
from vibopt.document.mistakes import Mistakes, Path, dotted
from vibopt.units import best_unit, to_unit

_CHOOSING = ("shelf", "split", "forbidden", "keep")
"""Keys of a plane that say what may be chosen."""


def is_fitted(given: object) -> bool:
    """Whether weights are decided: texts that say where they sit."""
    listed = given if isinstance(given, list) else [given]
    return isinstance(given, list) or any(isinstance(one, str) and ("@" in one or "hole" in one) for one in listed)


def with_fitted(path: Path, plane: Plane, table: Mapping[str, Any], mistakes: Mistakes) -> Plane:
    """The plane with the weights that its table decides."""
    key = "weight" if table.get("weight") is not None else "unbalance"
    given = table.get(key)
    if not is_fitted(given):
        return plane
    listed = given if isinstance(given, list) else [given]
    if idle := [word for word in _CHOOSING if table.get(word)]:
        mistakes.add(
            (*path, idle[0]),
            f"{dotted(path)} has {idle[0]}, which is for a weight that is chosen, but its {key} is decided. Leave "
            f"{idle[0]} out, or write {key} as a range {{ from, to }}.",
        )
        return plane
    read = [
        read_value((*path, key, index) if isinstance(given, list) else (*path, key), one, mistakes, read_fitted, plane)
        for index, one in enumerate(listed)
    ]
    unit = next((unit for one in listed if (unit := unit_of(one, plane))), plane.unit)
    return replace(plane, fitted=tuple(one for one in read if one is not None), unit=unit)


def decided(table: Mapping[str, Any], plane: Plane, weights: Iterable[Fitted]) -> dict[str, Any]:
    """The table of a plane with its weights as facts, and without what was there to choose them."""
    kept = {key: one for key, one in table.items() if key not in (*_CHOOSING, "weight", "unbalance", "most_weights")}
    texts = [text_of(one, plane) for one in weights]
    return {**kept, plane.kind_word: texts[0] if len(texts) == 1 else texts}


def text_of(one: Fitted, plane: Plane) -> str:
    """A decided weight as it stands in a file, exact to the last digit."""
    unit = plane.unit or best_unit(one.mass, plane.dimension)
    amount = f"{to_unit(one.mass, unit, plane.dimension):.15g} {unit}"
    at = f" at {to_unit(one.radius, plane.length_unit, 'length'):.15g} {plane.length_unit}"
    where = f"in hole {one.hole + 1}" if one.hole is not None else f"@ {to_unit(one.angle, 'deg', 'angle'):.15g} deg"
    return f"{amount}{at if len(plane.radii) > 1 else ''} {where}"
