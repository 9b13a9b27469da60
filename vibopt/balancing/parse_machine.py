"""The machine's side of a measured rotor's file: conventions, planes, sensors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf, isclose, radians
from typing import Any, cast

from vibopt.balancing.conventions import (
    CHOICES,
    MARK,
    Conventions,
    read_amplitude,
    read_angle,
    read_reading,
)
from vibopt.balancing.decided import is_fitted, with_fitted
from vibopt.balancing.plane_options import (
    ALL_FORBIDDEN,
    KEPT_AND_REMOVED,
    MOST_OPTIONS,
    count_options,
    listed_twice,
)
from vibopt.balancing.planes import MASS, UNBALANCE, Drill, Plane, open_arcs, read_arc
from vibopt.balancing.rotor_job import Sensor
from vibopt.balancing.rotor_tables import (
    DrillTable,
    PlaneTable,
    SensorTable,
    positive,
    read_each,
    read_table,
    read_value,
)
from vibopt.document.mistakes import Mistakes, Path, dotted, named_tables
from vibopt.errors import QuantityError
from vibopt.records import replace
from vibopt.units import Detector
from vibopt.units.showing import show_angle
from vibopt.units.spelling import split_detector
from vibopt.values.fields import read_end

_MOST_HOLES = 720


def read_conventions(document: Mapping[str, Any], has_angles: bool, mistakes: Mistakes) -> Conventions | None:
    """The conventions; nothing is assumed. Where no reading has an angle, `phase` and `readings` say nothing."""
    given = document.get("conventions")
    if not isinstance(given, Mapping):
        mistakes.add(
            ("conventions",),
            'the table [conventions] is missing. Write phase = "lag", readings = "phase", angles = "against rotation", '
            'detector = "pp" and zero = "reflective tape" as they are on your instrument; vibopt does not guess them.',
        )
        return None
    before = len(mistakes.found)
    said = {key: _choice(key, given, has_angles, mistakes) for key in CHOICES}
    for key in given:
        if key not in (*CHOICES, "zero"):
            mistakes.unknown_key(("conventions", key), [*CHOICES, "zero"])
    if given.get("readings") == MARK and "phase" in given:
        mistakes.value(
            ("conventions", "phase"),
            given["phase"],
            'is for phase angles, but readings = "mark" says that the readings are positions of the mark. Leave phase '
            'out, or write readings = "phase".',
        )
    zero = given.get("zero", "")
    if not isinstance(zero, str):
        mistakes.value(
            ("conventions", "zero"), zero, 'is no text: where angle zero is, in words. Write zero = "reflective tape".'
        )
    elif not zero.strip():
        mistakes.add(
            ("conventions",), 'conventions has no zero: where angle zero is, in words. Write zero = "reflective tape".'
        )
    if len(mistakes.found) > before:
        return None
    readings = said["readings"] if has_angles else ""
    phase = said["phase"] if has_angles and readings != MARK else ""
    return Conventions(phase, readings, said["angles"], cast(Detector, said["detector"]), str(zero).strip())


def _choice(key: str, given: Mapping[str, Any], has_angles: bool, mistakes: Mistakes) -> str:
    options, meaning = CHOICES[key]
    value = given.get(key)
    if isinstance(value, str) and value in options:
        return value
    listed = " or ".join(f'{key} = "{option}"' for option in options)
    if value is None:
        if key in ("detector", "angles") or (has_angles and not (key == "phase" and given.get("readings") == MARK)):
            mistakes.add(("conventions",), f"conventions has no {key}: {meaning}. Write {listed}.")
        return ""
    mistakes.value(("conventions", key), value, f"is no word for {meaning}. Write {listed}.")
    return ""


def read_planes(
    document: Mapping[str, Any], mistakes: Mistakes, kind: type[PlaneTable] = PlaneTable
) -> tuple[Plane, ...] | None:
    """The planes in the order of the file, tables of one kind; None where one cannot be read."""
    known: dict[str, Plane] = {}  # planes often say the same but for their names
    read = []
    for name, table in named_tables(document, "planes", mistakes).items():
        alike = known.get(said := repr(table))
        read.append(_plane(name, table, kind, mistakes) if alike is None else replace(alike, name=name))
        if read[-1] is not None:
            known[said] = read[-1]
    planes = [plane for plane in read if plane is not None]
    _check_stock(planes, mistakes)
    return tuple(planes) if len(planes) == len(read) else None


def _plane(name: str, given: object, of: type[PlaneTable], mistakes: Mistakes) -> Plane | None:
    path: Path = ("planes", name)
    before = len(mistakes.found)
    table = read_table(of, given, path, mistakes)
    if table is None:
        return None
    place = getattr(table, "at", None)
    radii, length_unit = _radii((*path, "radius"), table.radius, mistakes)
    kind, cap, unit = _cap(path, table, radii, mistakes)
    holes = _holes((*path, "holes"), table.holes, mistakes)
    shelf, stock, shelf_unit = _shelf((*path, "shelf"), table.shelf, mistakes)
    forbidden = _forbidden((*path, "forbidden"), table.forbidden, mistakes)
    most = _most_weights((*path, "most_weights"), table, mistakes)
    plane = Plane(
        name=name, kind=kind, radii=radii, unit=unit or shelf_unit, length_unit=length_unit, cap=cap,
        moment=len(radii) > 1 and table.unbalance is not None, holes=holes, shelf=shelf, stock=stock, most_weights=most,
        split=table.split, forbidden=forbidden, remove=table.remove, keep=table.keep,
        drill=_drill((*path, "drill"), table, mistakes), at=None if place is None else place.value,
    )  # fmt: skip
    plane = with_fitted(path, plane, cast(Mapping[str, Any], given), mistakes)
    if len(mistakes.found) == before:
        _check_plane(path, plane, mistakes)
    return plane if len(mistakes.found) == before else None


def _radii(path: Path, given: object, mistakes: Mistakes) -> tuple[tuple[float, ...], str]:
    if given is None:
        return (), "mm"
    listed = given if isinstance(given, list) else [given]
    if not listed:
        mistakes.value(path, given, 'is an empty list. Write radius = "150 mm".')
    good = [found for one in listed if (found := read_value(path, one, mistakes, positive, "length")) is not None]
    return tuple(sorted({value for value, _ in good})), good[0][1] if good else "mm"


def _cap(path: Path, table: PlaneTable, radii: tuple[float, ...], mistakes: Mistakes) -> tuple[str, float, str]:
    """Kind of the plane, its cap in kg (kg m) and the unit of it."""
    bare = MASS if radii else table.bare
    if bare == UNBALANCE and (table.weight is not None or table.shelf is not None or table.drill is not None):
        mistakes.add(
            path,
            f"{dotted(path)} has weights or a drill but no radius: what a mass does there is not known. "
            'Write radius = "150 mm", or cap its unbalance.',
        )
        return MASS, inf, ""
    if table.weight is not None and table.unbalance is not None:
        mistakes.add(path, f"{dotted(path)} has weight and unbalance. Keep one of them.")
        return MASS, inf, ""
    if is_fitted(table.weight) or is_fitted(table.unbalance):
        return (UNBALANCE if table.unbalance is not None and not radii else MASS), inf, ""
    if table.unbalance is not None:
        found = read_value(
            (*path, "unbalance"), table.unbalance, mistakes, _range, "unbalance", '{ from = "0 g mm", to = "900 g mm" }'
        )
        return (MASS if radii else UNBALANCE), *(
            (found[0] / (radii[-1] if radii else 1.0), "" if radii else found[1]) if found else (inf, "")
        )
    if table.weight is not None:
        found = read_value((*path, "weight"), table.weight, mistakes, _range, "mass", '{ from = "0 g", to = "60 g" }')
        return MASS, *(found or (inf, ""))
    return bare, inf, ""


def _range(given: object, dimension: str, example: str) -> tuple[float, str]:
    """Upper end of a range from zero."""
    if not isinstance(given, Mapping) or not set(given) <= {"from", "to"} or "to" not in given:
        raise QuantityError(
            f"is no range. The correction is to be chosen: write {example}; or write the weight that is fitted with "
            'its angle, "10 g @ 270 deg".'
        )
    high = read_end(given, "to", dimension)
    low = read_end(given, "from", dimension).value if "from" in given else 0.0
    if low != 0.0:
        raise QuantityError("does not start at zero. No weight at all is always possible: write from zero.")
    if high.value == 0.0:
        raise QuantityError(
            "is a cap of zero: nothing could be put here. Write keep = true to leave the plane untouched, or a cap."
        )
    if high.value < 0.0:
        raise QuantityError("is a reversed range: from is greater than to. Exchange the two.")
    return high.value, high.unit


def _most_weights(path: Path, table: PlaneTable, mistakes: Mistakes) -> int:
    given = table.most_weights
    if "most_weights" in table.model_fields_set and table.shelf is None:
        mistakes.add(
            path, f"{dotted(path)} is for weights of a shelf, and there is none. Add shelf = [...], or leave it out."
        )
    if isinstance(given, int) and not isinstance(given, bool) and given >= 1:
        return given
    mistakes.value(path, given, "is no number of weights. Write 1 or more.")
    return 1


def _holes(path: Path, given: object, mistakes: Mistakes) -> tuple[float, ...]:
    """Angles as written [rad]; of a count, evenly from zero."""
    if given is None:
        return ()
    if isinstance(given, int) and not isinstance(given, bool):
        if not 2 <= given <= _MOST_HOLES:
            mistakes.value(
                path, given, f"is no number of holes from 2 to {_MOST_HOLES}. Write holes = 24, or a list of angles."
            )
            return ()
        return tuple(radians(360.0 * index / given) for index in range(given))
    if not isinstance(given, list) or not given:
        mistakes.value(
            path, given, 'is no count and no list of angles. Write holes = 24, or holes = ["0 deg", "30 deg"].'
        )
        return ()
    holes = tuple(read_each(path, given, mistakes, read_angle))
    if len(holes) == len(given) and (twice := listed_twice(holes)):
        mistakes.add(path, f"{dotted(path)} {twice}")
    return holes


def _shelf(path: Path, given: object, mistakes: Mistakes) -> tuple[tuple[float, ...], tuple[float, ...], str]:
    """Masses [kg], rising, how many there are of each (empty where none is counted), and the unit."""
    if given is None:
        return (), (), ""
    if not isinstance(given, list) or not given:
        mistakes.value(path, given, 'is no list of weights. Write shelf = ["5 g", "10 g"].')
        return (), (), ""
    good = read_each(path, given, mistakes, _on_the_shelf)
    found = {mass: many for mass, _, many in good}
    if len({(mass, many) for mass, _, many in good}) > len(found):
        mistakes.value(path, given, "names a weight twice with different stocks. Write it once, with all there are.")
    counted = any(many < inf for many in found.values())
    masses = tuple(sorted(found))
    return masses, tuple(found[mass] for mass in masses) if counted else (), good[0][1] if good else ""


def _on_the_shelf(given: object) -> tuple[float, str, float]:
    """Mass, unit and number of a weight: "5 g", or { mass = "5 g", stock = 3 }."""
    if not isinstance(given, Mapping):
        return *positive(given, "mass"), inf
    stock = given.get("stock")
    if set(given) != {"mass", "stock"} or isinstance(stock, bool) or not isinstance(stock, int) or stock < 1:
        raise QuantityError(
            'is no weight with its stock. Write { mass = "5 g", stock = 3 } with 1 or more, or leave the weight out.'
        )
    return *positive(given["mass"], "mass"), float(stock)


def _check_stock(planes: Sequence[Plane], mistakes: Mistakes) -> None:
    """A stock is that of one box for all planes: each says the same of a weight."""
    said: dict[float, tuple[Plane, float]] = {}
    for plane in planes:
        for mass, many in zip(plane.shelf, plane.stock or (inf,) * len(plane.shelf), strict=True):
            other, known = next((one for key, one in said.items() if isclose(key, mass)), (plane, many))
            said.setdefault(mass, (plane, many))
            if known != many:
                first, second = ("no stock" if value == inf else f"a stock of {value:g}" for value in (known, many))
                mistakes.add(
                    ("planes", plane.name, "shelf"),
                    f"planes.{plane.name}.shelf has {plane.show(mass)} with {second}, planes.{other.name}.shelf with "
                    f"{first}. A stock is for all planes together: write the same in each.",
                )


def _forbidden(path: Path, given: object, mistakes: Mistakes) -> tuple[tuple[float, float], ...]:
    listed = given if isinstance(given, list) or given is None else [given]
    return tuple(read_each(path, listed or [], mistakes, read_arc))


def _drill(path: Path, table: PlaneTable, mistakes: Mistakes) -> Drill | None:
    if table.drill is None:
        return None
    if not table.remove:
        mistakes.add(
            path,
            f"{dotted(path[:2])} has a drill, but adds weights. Write remove = true, or leave the drill out.",
        )
    drill = read_table(DrillTable, table.drill, path, mistakes)
    if drill is None:
        return None
    return Drill(drill.diameter.value, drill.density.value, drill.deepest.value if drill.deepest else inf)


def _check_plane(path: Path, plane: Plane, mistakes: Mistakes) -> None:
    """What the keys of one plane must be among themselves."""
    where = f"planes.{plane.name}"
    if plane.keep and plane.remove:
        mistakes.add((*path, "remove"), f"{where} {KEPT_AND_REMOVED}")
    anywhere = bool(open_arcs(plane.forbidden))
    if not anywhere:
        mistakes.add((*path, "forbidden"), f"{where} {ALL_FORBIDDEN}")
    if plane.holes and not plane.shelf and not plane.split and plane.fitted is None:
        mistakes.add(
            (*path, "holes"),
            f'{where} has holes without weights. Add shelf = ["5 g", "10 g"] with the weights there are, '
            "or split = true for a weight cut to measure in the two neighbouring holes.",
        )
    if plane.shelf and not plane.holes:
        mistakes.add(
            (*path, "shelf"),
            f"{where} has weights on the shelf, but no holes to put them. Add holes = 24, or a list of angles.",
        )
    if plane.split and (plane.shelf or not plane.holes):
        mistakes.add(
            (*path, "split"),
            f"{where}.split needs holes and no shelf: the weight is cut to measure. Remove split, or the shelf.",
        )
    if plane.holes and plane.kind == UNBALANCE:
        mistakes.add((*path, "holes"), f"{where} has holes, but no radius. Add its radius.")
    elif plane.holes and anywhere and not any(plane.may_sit_at(angle) for angle in plane.holes):
        mistakes.add(
            (*path, "forbidden"),
            f"{where}: every hole lies in a forbidden sector. Narrow the sectors, or write keep = true.",
        )
    elif plane.split and plane.gaps and len(plane.gaps) <= len(plane.out_of_reach):
        sitting = " and ".join(show_angle(low) for low, _ in plane.gaps)
        mistakes.add(
            (*path, "holes"),
            f"{where}.split needs two neighbouring holes less than 180 deg apart to cut a weight between, and there "
            f"{'are only holes' if len(plane.gaps) > 1 else 'is only a hole'} at {sitting}. List more holes, or write "
            f"shelf with the weights there are instead of split.",
        )
    if plane.shelf and plane.most < plane.shelf[0]:
        mistakes.add(
            (*path, "weight"),
            f"{where}: the cap is less than the lightest weight of the shelf. Widen the cap, or write keep = true.",
        )
    if plane.shelf and plane.holes and count_options(plane) > MOST_OPTIONS:
        mistakes.add(
            (*path, "most_weights"),
            f"{where} has more than {MOST_OPTIONS} ways to fill its holes. Lower most_weights, or shorten the shelf.",
        )


def read_sensors(document: Mapping[str, Any], conventions: Conventions, mistakes: Mistakes) -> dict[str, Sensor]:
    """The sensors named by the file, with their unit where it says one; what they read is known from their readings.

    One whose table has a mistake is among them: its readings are not those of a stranger.
    """
    sensors = {}
    for name, given in named_tables(document, "sensors", mistakes).items():
        path: Path = ("sensors", name)
        table = read_table(SensorTable, given, path, mistakes)
        unit = given.get("unit") if isinstance(given, Mapping) else ""
        unit = unit if isinstance(unit, str) else ""
        if unit and read_value((*path, "unit"), unit, mistakes, _unit, conventions) is None:
            unit = ""
        importance = 1.0 if table is None or table.importance is None else table.importance.value
        added_to = "" if table is None else table.added_to or ""
        sensor = Sensor(name, "", unit, split_detector(unit)[1] or conventions.detector, 0.0, importance, added_to)
        if table is not None and table.runout is not None:
            sensor = _with_runout(sensor, (*path, "runout"), table.runout, conventions, mistakes)
        sensors[name] = sensor
    return sensors


def _unit(given: str, conventions: Conventions) -> str:
    """A unit of amplitudes, with or without its detector."""
    try:
        return read_amplitude(f"1 {given}", conventions.detector).unit
    except QuantityError:
        raise QuantityError('is no unit of vibration. Write for example "mil pp", "µm" or "mm/s rms".') from None


def _with_runout(sensor: Sensor, path: Path, given: object, conventions: Conventions, mistakes: Mistakes) -> Sensor:
    found = read_value(path, given, mistakes, read_reading, conventions, sensor.unit)
    if found is None:
        return sensor
    amplitude, z, has_angle = found
    if not has_angle:
        mistakes.value(path, given, 'has no angle: runout is subtracted as a vector. Write "0.4 mil pp @ 20 deg".')
    return replace(sensor, dimension=amplitude.dimension, runout=z)
