"""Influence coefficients that are known: listed or in a file of their own, read here and saved for the next job."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import degrees
from typing import Any

from vibopt.balancing.conventions import Conventions, read_amplitude, split_angle
from vibopt.balancing.parse_machine import read_conventions
from vibopt.balancing.parse_runs import Measured, kind_of, speed_index
from vibopt.balancing.planes import MASS, Plane, read_weight
from vibopt.balancing.rotor_job import RotorJob, Sensor
from vibopt.balancing.rotor_tables import InfluenceTable, known_keys, listed_tables, place_of, read_table, read_value
from vibopt.document.mistakes import Mistakes, Path
from vibopt.errors import InputError, QuantityError
from vibopt.records import dataclass
from vibopt.units import read_quantity, show, to_unit

Influence = dict[tuple[int, int, int], complex]
FILE_KEYS = ("title", "statement", "source", "conventions", "influence")
"""What a file of coefficients may have."""
_SAME = 1e-9
"""Part of a coefficient by which it may stand twice: another unit."""


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
    known_keys(document, FILE_KEYS, mistakes)
    own = read_conventions(document, True, mistakes)
    if own is None:
        return {}
    if wrong := _other_zero(conventions.zero, own.zero):
        mistakes.add(("conventions", "zero"), wrong)
    listed = listed_tables(document, "influence", mistakes)
    mine = {"plane": [plane.name for plane in planes], "sensor": [sensor.name for sensor in measured.sensors]}
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
    at = speed is None or speed_index(speed, measured.speeds) is not None
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
    said: dict[tuple[int, int, int], tuple[int, complex]] = {}
    listed = listed_tables(document, "influence", mistakes)
    for index, given in enumerate(listed):
        path: Path = ("influence", index)
        table = read_table(InfluenceTable, given, path, mistakes)
        if table is None:
            continue
        plane = place_of((*path, "plane"), table.plane, "plane", [one.name for one in planes], mistakes)
        sensor = place_of((*path, "sensor"), table.sensor, "sensor", [one.name for one in measured.sensors], mistakes)
        speed = _speed_of(path, table, measured, mistakes)
        if plane is None or sensor is None or speed is None:
            continue
        value = read_value(
            (*path, "value"), table.value, mistakes, _coefficient, conventions, planes[plane], measured.sensors[sensor]
        )
        if value is None:
            continue
        first, known = said.setdefault((speed, sensor, plane), (index, value))
        if abs(value - known) > _SAME * max(abs(value), abs(known)):
            both = [f'"{one}"' for one in (listed[first]["value"], table.value)]
            mistakes.add(
                path,
                f"influence[{index + 1}] says {both[1]} for sensor {table.sensor} and a weight in {table.plane}, "
                f"influence[{first + 1}] {both[0]} at the same speed. Keep the one that holds.",
            )
    return {place: value for place, (_, value) in said.items()}


def _speed_of(path: Path, table: InfluenceTable, measured: Measured, mistakes: Mistakes) -> int | None:
    if table.speed is None and len(measured.speeds) == 1:
        return 0
    if table.speed is None:
        mistakes.add(
            path, f'influence[{int(path[1]) + 1}] has no speed, but the runs have several. Write speed = "1200 rpm".'
        )
        return None
    index = speed_index(table.speed.value, measured.speeds)
    if index is None:
        mistakes.add(
            (*path, "speed"),
            f"influence[{int(path[1]) + 1}] is for a speed at which no run as found was made. Add that run, or remove "
            f"the coefficient.",
        )
    return index


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
    per = per.strip(" ()")
    if len(plane.radii) > 1 and len(per.split()) == 1:  # a mass alone
        own = show(plane.radii[0], "mm", "length")
        raise QuantityError(
            f"does not say at which radius of planes.{plane.name} the {per} sits. Write "
            f'"{amount.strip()}/({per} at {own}) @ {str(text).partition("@")[2].strip()}".'
        )
    size = abs(read_weight(f"1 {per} @ 0 deg", plane, conventions))
    return conventions.reading(amplitude.value, angle) / size


def coefficients_document(job: RotorJob) -> dict[str, Any]:
    """What a unit weight in each plane reads at each sensor and speed, with the conventions of the job.

    Raises
    ------
    InputError
        The job has no coefficients: readings without phase, or no run with weights.
    """
    if not job.has_phase:
        raise InputError(
            f"{job.name}: readings without phase tell no influence coefficient: its angle is not known. "
            "Leave --save-coefficients out."
        )
    if not job.runs or job.is_advice:
        raise InputError(f"{job.name}: no run has weights, so no influence coefficient is known. Add a trial run.")
    from vibopt.balancing.contradictions import heard

    identified = heard(job).identified
    alone = identified.alone
    lost = (alone != identified.H).any(axis=0).tolist()
    if together := [plane.name for plane, one in zip(job.planes, lost, strict=True) if one]:
        names = " and ".join(together)
        raise InputError(
            f"{job.name}: the runs tell what weights in {names} do together, not what one does alone. Add a run with a "
            f"weight in {together[0]} alone, or leave --save-coefficients out."
        )
    speeds = [
        f"{to_unit(value, unit, 'angular_rate'):.15g} {unit}"
        for value, unit in zip(job.speeds, job.speed_units, strict=True)
    ]
    rows = [
        {
            "speed": speeds[speed],
            "sensor": job.sensors[sensor].name,
            "plane": plane.name,
            "value": _saved_text(job, complex(alone[row, column]), sensor, column),
        }
        for row, (speed, sensor) in enumerate(job.readings)
        for column, plane in enumerate(job.planes)
        if not plane.keep or alone[row, column]
    ]
    said = {key: word for key, word in job.conventions.said().items() if word}
    return {"title": f"Influence coefficients of {job.title}", "conventions": said, "influence": rows}


def _saved_text(job: RotorJob, H: complex, sensor: int, column: int) -> str:
    """A coefficient with all digits, per unbalance where the plane has a radius: so it holds at any radius."""
    plane, reads = job.planes[column], job.sensors[sensor]
    per = "g mm" if plane.radii or plane.kind != MASS else "g"
    size = abs(H) * (1.0 / to_unit(1.0, per, "unbalance" if per == "g mm" else "mass"))
    amount = to_unit(size, reads.shown_unit, reads.dimension)
    angle = degrees(job.conventions.reading_angle(H)) if H else 0.0
    return f"{amount:.15g} {reads.shown_unit}/({per}) @ {angle:.15g} deg"
