"""Ready influence coefficients of a measured rotor, from an earlier job or a rotor model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from vibopt.balancing.conventions import Conventions, read_amplitude, split_angle
from vibopt.balancing.parse_machine import read_conventions
from vibopt.balancing.parse_runs import Measured, kind_of, same_speed
from vibopt.balancing.planes import Plane, read_weight
from vibopt.balancing.rotor_job import Sensor
from vibopt.balancing.rotor_tables import InfluenceTable, listed_tables, read_table, read_value
from vibopt.document.mistakes import Mistakes, Path
from vibopt.errors import QuantityError, way_out
from vibopt.records import dataclass
from vibopt.units import read_quantity

Influence = dict[tuple[int, int, int], complex]
FILE_KEYS = ("title", "statement", "source", "conventions", "influence")
"""What a file of coefficients may have."""


@dataclass(frozen=True)
class Saved:
    """A file of coefficients that a job names: its document, and where its mistakes go."""

    document: Mapping[str, Any]
    mistakes: Mistakes


def read_influence(
    document: Mapping[str, Any],
    conventions: Conventions,
    planes: Sequence[Plane],
    measured: Measured,
    mistakes: Mistakes,
    saved: Saved | None = None,
) -> Influence:
    """Ready coefficients, internal [SI peak per kg m], by (speed, sensor, plane)."""
    if not isinstance(document.get("influence"), str):
        return _listed(document, conventions, planes, measured, mistakes)
    if saved is None:
        return {}
    found = _of_file(saved, conventions, planes, measured)
    mistakes.found.extend((10**9 + line, message) for line, message in saved.mistakes.found)
    return found


def _of_file(saved: Saved, conventions: Conventions, planes: Sequence[Plane], measured: Measured) -> Influence:
    """Those of a file for the planes, sensors and speeds of this job, by the conventions of that file."""
    document, mistakes = saved.document, saved.mistakes
    for key in document:
        if key not in FILE_KEYS:
            mistakes.unknown_key((key,), list(FILE_KEYS))
    own = read_conventions(document, True, mistakes)
    if own is None:
        return {}
    if wrong := _other_zero(conventions.zero, own.zero):
        mistakes.add(("conventions", "zero"), wrong)
    listed = listed_tables(document, "influence", mistakes)
    mine = {"plane": [one.name for one in planes], "sensor": [one.name for one in measured.sensors]}
    kept = [one for one in listed if not isinstance(one, Mapping) or _is_mine(one, mine, measured)]
    if not kept:
        mistakes.add(
            ("influence",), "no coefficient is for a plane, a sensor and a speed of this job. Name another file."
        )
    return _listed({**document, "influence": kept}, own, planes, measured, mistakes)


def _is_mine(given: Mapping[str, Any], mine: Mapping[str, Sequence[str]], measured: Measured) -> bool:
    """Whether a coefficient is for something that this job has."""
    try:
        speed = read_quantity(given["speed"], "angular_rate").value if "speed" in given else None
    except QuantityError:
        return True  # said where it is read
    at = speed is None or any(same_speed(speed, one) for one in measured.speeds)
    return at and all(given.get(key) in known for key, known in mine.items() if isinstance(given.get(key), str))


def _other_zero(mine: str, theirs: str) -> str:
    """What is wrong where two files count angles from different marks; "" where they name the same."""
    if " ".join(mine.split()).casefold() == " ".join(theirs.split()).casefold():
        return ""
    return (
        f'counts angles from "{theirs}", this job from "{mine}": nothing says how the two lie to each other. Write the '
        "same words where they are one mark; else measure the coefficients anew."
    )


def _listed(
    document: Mapping[str, Any],
    conventions: Conventions,
    planes: Sequence[Plane],
    measured: Measured,
    mistakes: Mistakes,
) -> Influence:
    found = {}
    for index, given in enumerate(listed_tables(document, "influence", mistakes)):
        path: Path = ("influence", index)
        table = read_table(InfluenceTable, given, path, mistakes)
        if table is None:
            continue
        plane = _find((*path, "plane"), table.plane, "plane", [one.name for one in planes], mistakes)
        sensor = _find((*path, "sensor"), table.sensor, "sensor", [one.name for one in measured.sensors], mistakes)
        speed = _speed_of(path, table, document, measured, mistakes)
        if plane is None or sensor is None or speed is None:
            continue
        value = read_value(
            (*path, "value"), table.value, mistakes, _coefficient, conventions, planes[plane], measured.sensors[sensor]
        )
        if value is not None:
            found[speed, sensor, plane] = value
    return found


def _find(path: Path, name: str, what: str, known: list[str], mistakes: Mistakes) -> int | None:
    if name in known:
        return known.index(name)
    mistakes.value(path, name, f"names no {what} of this job.{way_out(name, known)}")
    return None


def _speed_of(
    path: Path, table: InfluenceTable, document: Mapping[str, Any], measured: Measured, mistakes: Mistakes
) -> int | None:
    if table.speed is None and len(measured.speeds) == 1:
        return 0
    if table.speed is None:
        mistakes.add(
            path, f'influence[{int(path[1]) + 1}] has no speed, but the runs have several. Write speed = "1200 rpm".'
        )
        return None
    for index, speed in enumerate(measured.speeds):
        if same_speed(table.speed.value, speed):
            return index
    mistakes.add(
        (*path, "speed"),
        f"influence[{int(path[1]) + 1}] is for a speed at which no run as found was made. Add that run, or remove "
        f"the coefficient.",
    )
    return None


def _coefficient(text: object, conventions: Conventions, plane: Plane, sensor: Sensor) -> complex:
    """What a unit weight at angle zero would read, per kg m."""
    example = "0.43 mil pp/g @ 120 deg"
    front, angle = split_angle(text, example) if isinstance(text, str) else ("", None)
    amount, sign, per = front.rpartition("/")
    if angle is None or not sign:
        raise QuantityError(f'is no influence coefficient. Write what a unit weight at 0 deg would read, "{example}".')
    amplitude = read_amplitude(amount.strip(), conventions.detector, sensor.unit)
    if sensor.dimension and amplitude.dimension != sensor.dimension:
        raise QuantityError(
            f"is {kind_of(amplitude.dimension)}, but sensor {sensor.name} reads {kind_of(sensor.dimension)}."
        )
    size = abs(read_weight(f"1 {per.strip(' ()')} @ 0 deg", plane, conventions))
    return conventions.reading(amplitude.value, angle) / size
