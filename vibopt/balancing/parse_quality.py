"""The quality grade that a measured rotor's file asks for, with its places along the shaft."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf, isclose
from typing import Any

from vibopt.balancing.grades import Quality
from vibopt.balancing.parse_asks import not_negative
from vibopt.balancing.tables import QualityTable, read_table, read_value
from vibopt.balancing.words import Conventions, split_angle
from vibopt.document.mistakes import Mistakes, Path
from vibopt.errors import QuantityError, way_out
from vibopt.units import read_quantity, show


def read_quality(
    document: Mapping[str, Any], conventions: Conventions, mass: float | None, speed: float | None, mistakes: Mistakes,
    known: Sequence[str] = (),
) -> Quality | None:  # fmt: skip
    """The grade asked for, with the places along the shaft; `known` are the correction planes of the job, if any."""
    if "quality" not in document:
        return None
    path: Path = ("quality",)
    table = read_table(QualityTable, document["quality"], path, mistakes)
    if table is None:
        return None
    before = len(mistakes.found)
    bearings = _places((*path, "bearings"), table.bearings, mistakes)
    planes = _places((*path, "planes"), table.planes or {}, mistakes)
    _check_planes((*path, "planes"), planes, known, mistakes)
    weight = table.mass.value if table.mass else mass
    turning = table.speed.value if table.speed else speed
    if weight is None:
        mistakes.add(path, 'quality has no mass. Write mass = "500 kg", of the whole rotor.')
    if turning is None:
        mistakes.add(path, 'quality has no speed. Write speed = "3000 rpm", the highest in service.')
    if len(bearings) != 2 or len(set(bearings.values())) != 2:
        mistakes.value(
            (*path, "bearings"),
            table.bearings,
            'is not two bearings at two places. Write { A = "0 mm", B = "900 mm" }.',
        )
    error = (
        read_value((*path, "measurement_error"), table.measurement_error, mistakes, not_negative, "unbalance")
        if table.measurement_error
        else 0.0
    )
    residual = _residuals((*path, "residual"), table.residual or {}, planes or bearings, conventions, mistakes)
    if len(mistakes.found) > before or weight is None or turning is None:
        return None
    first, second = bearings.items()
    return Quality(
        table.grade.value, weight, turning, (first, second), table.centre_of_mass.value, planes, error or 0.0, residual,
        table.least_share.value if table.least_share else 0.0, table.most_share.value if table.most_share else inf,
    )  # fmt: skip


def _places(path: Path, given: object, mistakes: Mistakes) -> dict[str, float]:
    if not isinstance(given, Mapping):
        mistakes.value(path, given, 'is no table of places. Write { A = "0 mm", B = "900 mm" }.')
        return {}
    read = {name: read_value((*path, name), one, mistakes, read_quantity, "length") for name, one in given.items()}
    return {name: one.value for name, one in read.items() if one is not None}


def _check_planes(path: Path, planes: Mapping[str, float], known: Sequence[str], mistakes: Mistakes) -> None:
    """Whether every plane of the job has its place, no other has one, and no two the same."""
    for name in planes if known else ():
        if name not in known:
            mistakes.add(
                (*path, name), f'quality.planes names no plane "{name}" of this job.{way_out(name, list(known))}'
            )
    for name in known if planes and set(planes) <= set(known) else ():
        if name not in planes:
            mistakes.add(
                path, f'quality.planes has no place for plane {name}. Add {name} = "750 mm", or leave planes out.'
            )
    names = list(planes)
    for k, one in enumerate(names):
        for other in names[:k]:
            if isclose(planes[one], planes[other], abs_tol=1e-9):
                mistakes.add(
                    (*path, one),
                    f"quality.planes has {other} and {one} at the same place, {show(planes[one], 'mm', 'length')}: "
                    f"such planes cannot hold a couple. Write the place of each along the shaft.",
                )


def _residuals(
    path: Path, given: object, places: Mapping[str, float], conventions: Conventions, mistakes: Mistakes
) -> dict[str, complex]:
    if not isinstance(given, Mapping):
        mistakes.value(path, given, 'is no table of unbalances. Write { left = "300 g mm @ 20 deg" }.')
        return {}
    found = {}
    for name, text in given.items():
        if name not in places:
            mistakes.value((*path, name), text, f"is in no plane of [quality].{way_out(name, list(places))}")
            continue
        value = read_value((*path, name), text, mistakes, _unbalance, conventions)
        if value is not None:
            found[name] = value
    return found


def _unbalance(text: object, conventions: Conventions) -> complex:
    front, angle = split_angle(str(text), "300 g mm @ 20 deg")
    if angle is None:
        raise QuantityError('has no angle. Write "300 g mm @ 20 deg".')
    return conventions.weight(not_negative(front, "unbalance"), angle)
