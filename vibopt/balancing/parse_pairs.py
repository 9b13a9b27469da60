"""Pairs of planes that a measured rotor's file ties together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isclose
from typing import Any

from vibopt.balancing.planes import MASS, Plane
from vibopt.balancing.tables import PairTable, named_tables, read_table
from vibopt.document.mistakes import Mistakes, Path
from vibopt.units import show


def read_pairs(
    document: Mapping[str, Any], planes: Sequence[Plane], mistakes: Mistakes
) -> tuple[tuple[str, int, int, float], ...]:
    """Pairs of planes that get the same (static) or opposite (couple) unbalances."""
    names = [plane.name for plane in planes]
    pairs = []
    for name, given in named_tables(document, "pairs", mistakes).items():
        path: Path = ("pairs", name)
        table = read_table(PairTable, given, path, mistakes)
        if table is None:
            continue
        if table.kind not in ("static", "couple"):
            mistakes.value(
                (*path, "kind"),
                table.kind,
                'is no kind of pair. Write kind = "static" (same angle) or kind = "couple" (opposite).',
            )
            continue
        if not isinstance(table.planes, list) or len(table.planes) != 2 or not set(table.planes) <= set(names):
            mistakes.value(
                (*path, "planes"), table.planes, f"is not two planes of this job. Known: {', '.join(names)}."
            )
            continue
        first, second = (names.index(one) for one in table.planes)
        if first == second:
            other = next((one for one in names if one != names[first]), "right")
            mistakes.value(
                (*path, "planes"),
                table.planes,
                f'is one plane with itself. Write two planes, for example planes = ["{names[first]}", "{other}"].',
            )
            continue
        bare = [one for one in (planes[first], planes[second]) if one.kind == MASS and not one.radii]
        if len(bare) == 1:
            mistakes.add(
                path, f"pairs.{name} sets unbalances equal, but planes.{bare[0].name} has no radius. Add its radius."
            )
            continue
        if any(planes[one].is_discrete or planes[one].keep or planes[one].split for one in (first, second)):
            mistakes.add(
                path, f"pairs.{name} has a plane that is kept or has holes. A pair needs two planes with free weights."
            )
            continue
        pairs.append((name, first, second, 1.0 if table.kind == "static" else -1.0))
    return tuple(pairs)


def pair_notes(pairs: Sequence[tuple[str, int, int, float]], planes: Sequence[Plane]) -> tuple[str, ...]:
    """That a pair at two radii has equal unbalances, so different weights."""
    notes = []
    for name, *both, _ in pairs:
        one, other = (planes[index] for index in both)
        if one.kind == other.kind == MASS and not isclose(one.radius, other.radius):
            radii = (show(plane.radius, plane.length_unit, "length") for plane in (one, other))
            notes.append(
                f"Pair {name}: planes {one.name} and {other.name} get equal unbalances, so their weights differ as "
                f"their radii do ({' and '.join(radii)})."
            )
    return tuple(notes)
