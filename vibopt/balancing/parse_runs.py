"""The measured side of a rotor's file: runs (typed or from CSV) and ready influence coefficients."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import tau
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.conventions import Amplitude, Conventions, read_angle, read_reading
from vibopt.balancing.csv_runs import read_csv
from vibopt.balancing.planes import Plane, read_weight, unit_of
from vibopt.balancing.rotor_job import Run, Sensor
from vibopt.balancing.rotor_tables import RunTable, listed_tables, positive, read_table, read_value
from vibopt.balancing.written import Written, numbers, phasors
from vibopt.document.mistakes import Mistakes, Path
from vibopt.errors import QuantityError, way_out
from vibopt.records import dataclass, replace
from vibopt.units.parsing import LARGEST
from vibopt.units.spelling import split_detector
from vibopt.values import Fact, rule_of
from vibopt.values.fields import read_fact

Fitted = tuple[tuple[int, str], ...]
"""Weights as written, by the place of their plane."""
SAME_SPEED = 0.01
"""Runs whose speeds differ by no more than this part belong together."""


@dataclass
class Raw:
    """A run before its values are read: its name, speed and words, its path, and where its mistakes go."""

    name: str | None
    speed: Fact | None
    path: Path
    mistakes: Mistakes
    weights: Mapping[str, Any]
    readings: Mapping[str, Any]
    stayed: bool = False
    verification: bool = False

    @property
    def label(self) -> str:
        return self.name or f"run {int(self.path[1]) + 1}"


@dataclass(frozen=True)
class Measured:
    """Runs and sensors as read, the speeds they belong to, and remarks."""

    runs: tuple[Run, ...]
    sensors: tuple[Sensor, ...]
    speeds: tuple[float, ...]
    speed_units: tuple[str, ...]
    paths: tuple[Path, ...]
    notes: tuple[str, ...]


def gather(document: Mapping[str, Any], mistakes: Mistakes, folder: FilePath | None) -> tuple[list[Raw], Mistakes]:
    """All runs, from [[runs]] or from the CSV file that `readings` names, and where their mistakes go."""
    given = document.get("readings")
    if given is None:
        return _in_one_piece(_raws(listed_tables(document, "runs", mistakes), mistakes), document), mistakes
    if not isinstance(given, str) or not given.strip():
        mistakes.value(("readings",), given, 'is no file name. Write readings = "job.csv".')
        return [], mistakes
    if "runs" in document:
        mistakes.add(("readings",), "the file has readings and [[runs]]. Keep one of them.")
    planes, sensors = _named(document, "planes"), _named(document, "sensors")
    if both := sorted(set(planes) & set(sensors)):
        mistakes.add(
            ("sensors", both[0]), f'"{both[0]}" is a plane and a sensor: the CSV file could mean either. Rename one.'
        )
        return [], mistakes
    rows, csv_mistakes = read_csv((folder or FilePath()) / given, planes, sensors, mistakes)
    return _raws(rows, csv_mistakes), csv_mistakes


def merge(own: Mistakes, mistakes: Mistakes) -> None:
    """Mistakes of a CSV file behind those of the problem file, in the order of its rows."""
    if own is not mistakes:
        mistakes.found.extend((10**9 + row, message) for row, message in own.found)


def has_angles(raws: Sequence[Raw], document: Mapping[str, Any]) -> bool:
    """Whether any reading or coefficient has an angle."""
    return "influence" in document or any(
        isinstance(raw.readings, Written) or any("@" in str(text) for text in raw.readings.values()) for raw in raws
    )


def read_runs(
    document: Mapping[str, Any], raws: Sequence[Raw], conventions: Conventions, planes: Sequence[Plane],
    declared: Mapping[str, Sensor], mistakes: Mistakes,
) -> Measured | None:  # fmt: skip
    """Runs with their numbers; None where something is wrong."""
    before = len(mistakes.found) + sum(len(raw.mistakes.found) for raw in raws[:1])
    in_arrays = _in_arrays(raws, conventions, declared)
    sensors, readings, notes, written = in_arrays or _all_readings(raws, conventions, declared)
    weights, fitted = _all_weights(raws, conventions, planes)
    speeds = [_speed(raw, document, mistakes) for raw in raws]
    _check_names(raws, [speed for speed, _ in speeds])
    if len(mistakes.found) + sum(len(raw.mistakes.found) for raw in raws[:1]) > before:
        return None
    bare = {key: not any(weight.tolist()) for key, weight in {id(weight): weight for weight in weights}.items()}
    initial = [bare[id(weight)] for weight in weights]
    groups, units = _groups([*(own for own, first in zip(speeds, initial, strict=True) if first), *speeds])
    near = {speed: [abs(group - speed) for group in groups] for speed, _ in dict.fromkeys(speeds)}
    of_speed = {speed: off.index(min(off)) for speed, off in near.items()}
    runs = tuple(
        Run(raw.label, of_speed[speed], speed, total, bare, y, texts, own, raw.stayed, raw.verification)
        for raw, (speed, _), total, bare, y, texts, own in zip(
            raws, speeds, weights, initial, readings, fitted, written, strict=True
        )
    )
    return Measured(runs, tuple(sensors), groups, units, tuple(raw.path for raw in raws), tuple(dict.fromkeys(notes)))


def _raws(tables: Sequence[Any], mistakes: Mistakes) -> list[Raw]:
    raws = []
    speeds: dict[str, Fact] = {}
    for index, given in enumerate(tables):
        path: Path = ("runs", index)
        if _is_plain(given, speeds):
            weights = given.get("weights", _NONE)
            raws.append(Raw(given.get("name"), speeds[given["speed"]], path, mistakes, weights, given["readings"]))
            continue
        table = read_table(RunTable, given, path, mistakes)
        if table is None:
            continue
        weights = _mapping((*path, "weights"), table.weights, mistakes, 'weights = { left = "10 g @ 270 deg" }')
        readings = _mapping((*path, "readings"), table.readings, mistakes, 'readings = { a = "8.6 mil pp @ 63 deg" }')
        if not readings and table.readings is None:
            mistakes.add(
                path,
                f'run "{table.name or index + 1}" has no readings. Add readings = {{ a = "8.6 mil pp @ 63 deg" }}.',
            )
        raws.append(Raw(table.name, table.speed, path, mistakes, weights, readings, table.stayed, table.verification))
    return raws


_NONE: dict[str, Any] = {}
_PLAIN = frozenset(("name", "speed", "weights", "readings"))
_SPEED = rule_of(RunTable, "speed")


def _is_plain(given: Any, speeds: dict[str, Fact]) -> bool:
    """Whether a run has nothing but a name, a speed, which is then among `speeds`, weights and readings of its own."""
    if type(given) is not dict or not given.keys() <= _PLAIN:
        return False
    speed, readings = given.get("speed"), given.get("readings")
    if type(speed) is not str or (type(readings) is not Written and not (type(readings) is dict and readings)):
        return False
    if type(given.get("name", "")) is not str or type(given.get("weights", _NONE)) is not dict:
        return False
    if speed not in speeds and _SPEED is not None:
        try:
            speeds[speed] = read_fact(_SPEED, speed)
        except QuantityError:
            return False
    return speed in speeds


def _in_one_piece(raws: list[Raw], document: Mapping[str, Any]) -> list[Raw]:
    """The runs with their readings as arrays, where all of them have the same sensors and units."""
    names = tuple(_named(document, "sensors") or raws[0].readings) if raws else ()
    if any(type(raw.readings) is not dict or len(raw.readings) != len(names) for raw in raws):
        return raws
    found = phasors(names, [text for raw in raws for text in map(raw.readings.get, names)])
    for raw, own in zip(raws, found or (), strict=found is not None):
        raw.readings = own
    return raws


def _check_names(raws: Sequence[Raw], speeds: Sequence[float]) -> None:
    """Messages and reports name runs: at one speed each needs a name of its own."""
    if len({raw.name for raw in raws}) == len(raws):
        return
    first: dict[str, list[tuple[int, float]]] = {}
    for index, (raw, speed) in enumerate(zip(raws, speeds, strict=True)):
        if raw.name is None:
            continue
        same = first.setdefault(raw.name, [])
        other = next((one for one, its in same if same_speed(speed, its)), None) if same else None
        if other is not None:
            raw.mistakes.value(
                (*raw.path, "name"), raw.name,
                f"is the name of run {other + 1} at the same speed already: messages and reports could not tell the "
                "two apart. Write another name, or remove one of the runs if it is a copy.",
            )  # fmt: skip
        same.append((index, speed))


def _mapping(path: Path, given: object, mistakes: Mistakes, example: str) -> Mapping[str, Any]:
    if given is None:
        return {}
    if isinstance(given, Mapping):
        return given
    mistakes.value(path, given, f"is not a table. Write {example}.")
    return {}


def _named(document: Mapping[str, Any], family: str) -> Mapping[str, Any]:
    tables = document.get(family, {})
    return tables if isinstance(tables, Mapping) else {}


Readings = tuple[list[Sensor], list[ComplexArray], list[str], list[Written | None]]
"""Sensors completed by what they read, the readings of each run in their order, remarks, and readings as written."""


def _in_arrays(raws: Sequence[Raw], conventions: Conventions, declared: Mapping[str, Sensor]) -> Readings | None:
    """All readings at once, where each sensor has one unit throughout and nothing has to be said; else None."""
    names = tuple(declared) or tuple(raws[0].readings) if raws else ()
    rows = [_written(raw, names) for raw in raws]
    first = rows[0] if rows else None
    if not conventions.readings or first is None:
        return None
    if any(row is None or row.units != first.units or row.turns != first.turns for row in rows):
        return None
    values = [
        numbers([*row.amounts, *row.angles], (2, len(names))) if row.parsed is None else row.parsed
        for row in rows if row is not None
    ]  # fmt: skip
    scales = _scales(names, declared, first, conventions)
    if scales is None or any(value is None for value in values):
        return None
    completed, factors, turns = scales
    sizes, angles = np.array(values).swapaxes(0, 1)
    sizes, angles = sizes * factors, angles * turns
    if sizes.min(initial=0.0) < 0.0 or sizes.max(initial=0.0) > LARGEST or np.abs(angles).max(initial=0.0) > tau:
        return None
    turned = conventions.reading_sense * angles
    return completed, list(sizes * np.cos(turned) + 1j * (sizes * np.sin(turned))), [], rows


def _scales(
    names: Sequence[str], declared: Mapping[str, Sensor], written: Written, conventions: Conventions
) -> tuple[list[Sensor], FloatArray, FloatArray] | None:
    """Sensors completed by their units, and the sizes of these [SI peak, rad]; None where something is to be said."""
    done: dict[Any, tuple[Amplitude, float, float]] = {}
    completed, sizes = [], []
    for name, unit, turn in zip(names, written.units, written.turns, strict=True):
        own = declared.get(name)
        key = (unit, turn) if own is None else (unit, turn, own.dimension, own.unit, own.detector)
        found = done.get(key)
        if found is None:
            like = own or Sensor(name, "", "", conventions.detector)
            try:
                amplitude = _reading(f"1 {unit} @ 0 {turn}", conventions, like, False)[0]
                found = done[key] = amplitude, amplitude.value, read_angle(f"1 {turn}")
            except QuantityError:
                return None
            if amplitude.echo:
                return None
        alike = found[0]
        completed.append(
            Sensor(name, alike.dimension, alike.unit, alike.detector) if own is None else _completed(own, alike)
        )
        sizes.append(found[1:])
    factors, turns = np.array(sizes).T
    return completed, factors, turns


def _all_readings(raws: Sequence[Raw], conventions: Conventions, declared: Mapping[str, Sensor]) -> Readings:
    """Reading by reading, with what is wrong."""
    names = list(declared) or list(dict.fromkeys(name for raw in raws for name in raw.readings))
    sensors = {name: declared.get(name, Sensor(name, "", "", conventions.detector)) for name in names}
    first: dict[str, Path] = {}
    rows, notes = [], []
    for raw in raws:
        for name in raw.readings:
            if name not in sensors:
                raw.mistakes.add(
                    (*raw.path, "readings", name), _stranger(raw, f"a reading of sensor {name}", name, names)
                )
        row = np.zeros(len(names), dtype=complex)
        for column, name in enumerate(names):
            path = (*raw.path, "readings", name)
            if name not in raw.readings:
                raw.mistakes.add(
                    (*raw.path, "readings"),
                    f'run "{raw.label}" has no reading of sensor {name}, which other runs or [sensors] have. Add it, '
                    f"or leave {name} out of every run.",
                )
                continue
            unit = declared[name].unit if name in declared else ""
            found = read_value(
                path, raw.readings[name], raw.mistakes, _reading, conventions, sensors[name], name in first, unit
            )
            if found is not None:
                amplitude, row[column] = found
                sensors[name] = _completed(sensors[name], amplitude)
                first.setdefault(name, path)
                notes += [amplitude.echo] if amplitude.echo else []
        rows.append(row)
    return list(sensors.values()), rows, notes, [_written(raw, tuple(names)) for raw in raws]


def _stranger(raw: Raw, what: str, name: str, known: list[str]) -> str:
    return f'run "{raw.label}" has {what}, which is not there.{way_out(name, known)}'


def _reading(
    text: object, conventions: Conventions, sensor: Sensor, seen: bool, unit: str = ""
) -> tuple[Amplitude, complex]:
    """One reading, of the same kind as the sensor's others; `unit` is that of bare numbers, with its detector."""
    amplitude, z, has_angle = read_reading(text, conventions, unit or sensor.unit)
    if conventions.readings and not has_angle and amplitude.value > 0.0:
        raise QuantityError(
            'has no angle, but other readings have one. Write "8.6 mil pp @ 63 deg"; '
            "balancing without phase needs every reading without an angle."
        )
    if sensor.dimension and amplitude.dimension != sensor.dimension:
        raise QuantityError(
            f"is {kind_of(amplitude.dimension)}, but sensor {sensor.name} otherwise reads {kind_of(sensor.dimension)}. "
            "Read one kind."
        )
    if (seen or sensor.unit.split()[-1:] == [sensor.detector]) and amplitude.detector != sensor.detector:
        raise QuantityError(
            f"is {amplitude.detector}, but sensor {sensor.name} otherwise reads {sensor.detector}. Mixed detectors are "
            f"seldom meant: write every reading of {sensor.name} with the same one."
        )
    return amplitude, z


def kind_of(dimension: str) -> str:
    return {"length": "a displacement", "velocity": "a velocity", "acceleration": "an acceleration"}[dimension]


def _completed(sensor: Sensor, amplitude: Amplitude) -> Sensor:
    bare = split_detector(sensor.unit)[0] if sensor.dimension and sensor.unit else amplitude.unit
    return replace(sensor, dimension=amplitude.dimension, unit=bare, detector=amplitude.detector)


def _all_weights(
    raws: Sequence[Raw], conventions: Conventions, planes: Sequence[Plane]
) -> tuple[list[ComplexArray], list[Fitted]]:
    """Everything fitted in each run, those that stayed on included; and the weights of its own as they are written."""
    places = {plane.name: place for place, plane in enumerate(planes)}
    totals: list[ComplexArray] = []
    fitted: list[Fitted] = []
    known: dict[tuple[int, str], complex] = {}
    done: dict[int, tuple[ComplexArray, Fitted]] = {}  # rows of a sheet share their tables
    for raw in raws:
        found = done.get(id(raw.weights))
        if found is None:
            before = len(raw.mistakes.found)
            found = _weights_of(raw, places, planes, conventions, known)
            if len(raw.mistakes.found) == before:
                done[id(raw.weights)] = found
        if raw.stayed and not totals:
            raw.mistakes.add(
                (*raw.path, "stayed"), "the first run has stayed = true, but no run is before it. Remove stayed."
            )
        totals.append(found[0] + totals[-1] if raw.stayed and totals else found[0])
        fitted.append(found[1])
    return totals, fitted


def _weights_of(
    raw: Raw, places: Mapping[str, int], planes: Sequence[Plane], conventions: Conventions,
    known: dict[tuple[int, str], complex],
) -> tuple[ComplexArray, Fitted]:  # fmt: skip
    """Unbalances of the weights of a run (n_planes,) and their texts by plane; `known` are those read before."""
    total = np.zeros(len(planes), dtype=complex)
    fitted = []
    for name, given in raw.weights.items():
        path, place = (*raw.path, "weights", name), places.get(name)
        if place is None:
            raw.mistakes.add(path, _stranger(raw, f"a weight in plane {name}", name, list(places)))
            continue
        for text in given if isinstance(given, list) else [given]:
            key = place, str(text)
            weight = known.get(key) or read_value(path, text, raw.mistakes, read_weight, planes[place], conventions)
            if weight is not None:
                known[key] = weight
                total[place] += weight
                fitted.append(key)
    return total, tuple(fitted)


def with_units(planes: Sequence[Plane], weights: Iterable[tuple[str, Any]]) -> tuple[Plane, ...]:
    """Planes shown in the unit of their shelf, else of the first of the weights (by name), else of their cap."""
    units: dict[str, str] = {}
    missing = {plane.name: plane for plane in planes if not (plane.unit and (plane.shelf or plane.fitted))}
    for name, given in weights if missing else ():
        if name in missing:
            texts = given if isinstance(given, list) else [given]
            units[name] = next((one for text in texts if (one := unit_of(text, missing[name]))), "")
            if units[name]:
                missing.pop(name)
        if not missing:
            break
    usual = {plane.name: plane.unit or ("g" if plane.dimension == "mass" else "g mm") for plane in planes}
    shown = [(plane, units.get(plane.name) or usual[plane.name]) for plane in planes]
    return tuple(plane if unit == plane.unit else replace(plane, unit=unit) for plane, unit in shown)


def _written(raw: Raw, names: tuple[str, ...]) -> Written | None:
    """The readings of a run as they stand in the file; None where it has others, or texts of another shape."""
    own = raw.readings
    if type(own) is Written and own.names == names:
        return own
    texts = [own[name] for name in names if name in own]
    if not len(own) == len(texts) == len(names) or not all(isinstance(text, str) for text in texts):
        return None
    return Written.of(names, texts)


def _speed(raw: Raw, document: Mapping[str, Any], mistakes: Mistakes) -> tuple[float, str]:
    if raw.speed is not None:
        return raw.speed.value, raw.speed.unit
    if "speed" not in document:
        raw.mistakes.add(
            raw.path, f'run "{raw.label}" has no speed. Write speed = "1200 rpm" in each run, or once at the top level.'
        )
        return 0.0, ""
    return read_value(("speed",), document["speed"], mistakes, positive, "angular_rate") or (0.0, "")


def _groups(speeds: Sequence[tuple[float, str]]) -> tuple[tuple[float, ...], tuple[str, ...]]:
    """Speeds that differ by more than SAME_SPEED from those before them, and their units."""
    groups: dict[float, str] = {}
    for speed, unit in dict.fromkeys(speeds):
        if not any(same_speed(speed, group) for group in groups):
            groups[speed] = unit
    return tuple(groups), tuple(groups.values())


def same_speed(speed: float, other: float) -> bool:
    return abs(speed - other) <= SAME_SPEED * other


def speed_index(speed: float, speeds: Sequence[float]) -> int | None:
    """Which of the speeds is the same; None where nothing was measured at it."""
    return next((index for index, value in enumerate(speeds) if same_speed(speed, value)), None)
