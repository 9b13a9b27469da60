"""What is asked of a measured rotor: its limits, its goal, the scatter of its readings, and its quality grade."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf, isclose
from typing import Any

from vibopt.balancing.conventions import Conventions, read_amplitude, split_angle
from vibopt.balancing.grades import Quality
from vibopt.balancing.parse_runs import speed_index
from vibopt.balancing.planes import UNBALANCE, Plane
from vibopt.balancing.rotor_job import CorrectionLimit, ResidualLimit, RotorGoal, Scatter, Sensor
from vibopt.balancing.rotor_tables import CorrectionLimit as CorrectionTable
from vibopt.balancing.rotor_tables import (
    GoalTable,
    QualityTable,
    ScatterTable,
    one_of,
    optional_table,
    place_of,
    read_table,
    read_value,
)
from vibopt.balancing.rotor_tables import ResidualLimit as ResidualTable
from vibopt.document.mistakes import Mistakes, Path, dotted, named_tables
from vibopt.errors import QuantityError, way_out
from vibopt.units import read_quantity, show
from vibopt.values import Fact

COMBINE = ("rms", "worst", "sum", "huber")
RESPONSES = ("residual", "correction")
ROBUST = ("worst", "mean")
_RESPONSE = "response of a measured rotor"


def read_scatter(document: Mapping[str, Any], conventions: Conventions, mistakes: Mistakes) -> Scatter | None:
    """Standard deviation of single readings, where given."""
    table = optional_table(ScatterTable, document, "scatter", mistakes)
    if table is None:
        return None
    ratio, amplitude, angle = 0.0, 0.0, 0.0
    if table.amplitude is not None:
        found = read_value(("scatter", "amplitude"), table.amplitude, mistakes, _scatter_amplitude, conventions)
        ratio, amplitude = found or (0.0, 0.0)
    if table.angle is not None:
        angle = read_value(("scatter", "angle"), table.angle, mistakes, not_negative, "angle") or 0.0
    if ratio == amplitude == angle == 0.0 and not mistakes.found:
        mistakes.add(
            ("scatter",), 'scatter is zero. Write { amplitude = "5 %", angle = "2 deg" }, or leave scatter out.'
        )
    return Scatter(ratio, amplitude, angle)


def _scatter_amplitude(given: object, conventions: Conventions) -> tuple[float, float]:
    """Part of the amplitude, or an amplitude."""
    try:
        return 0.0, read_amplitude(str(given), conventions.detector).value
    except QuantityError:
        return not_negative(given, "ratio"), 0.0


def not_negative(given: object, dimension: str) -> float:
    """A value in SI that is zero or more."""
    quantity = read_quantity(given, dimension)
    if quantity.value < 0.0:
        raise QuantityError("is negative. Write zero or more.")
    return quantity.value


def check_shares(
    limits: Sequence[ResidualLimit], goal: RotorGoal, scatter: Scatter | None, mistakes: Mistakes, *, angles: bool
) -> None:
    """A probability goes over the scatter of readings with angles, as a goal over the worst rotors does already."""
    text = "" if angles else "readings without angles scatter in a way that nobody knows. Remove with_probability."
    if angles and scatter is None:
        text = 'no reading scatters. Add scatter = { amplitude = "5 %", angle = "2 deg" }.'
    elif goal.robust == "worst":
        text = 'goal.robust = "worst" keeps every limit on all rotors within the scatter. Remove one of the two.'
    for limit in limits if text else ():
        if limit.share is not None:
            path: Path = ("limits", limit.name, "with_probability")
            mistakes.add(path, f"{dotted(path[:-1])} has with_probability, but {text}")


def check_added(
    sensors: Sequence[Sensor], limits: Sequence[ResidualLimit], goal: RotorGoal, mistakes: Mistakes, *, angles: bool
) -> None:
    """Whether sensors are added to others that are there, read alike, count as much, and are added to none."""
    known = {sensor.name: sensor for sensor in sensors}
    for sensor in (one for one in sensors if one.added_to):
        path: Path = ("sensors", sensor.name, "added_to")
        names = [name for name, one in known.items() if not one.added_to]
        other = known.get(sensor.added_to)
        if other is None:
            text = f"is no sensor.{way_out(sensor.added_to, names)}"
        elif other is sensor:
            text = "is the sensor itself. Name another one, or leave it out."
        elif other.added_to:
            text = f"is itself added to {other.added_to}. Name one that is added to none, or leave it out."
        elif (other.dimension, other.importance) != (sensor.dimension, sensor.importance):
            text = "does not read the same kind with the same importance, so that nothing adds up. Write both alike."
        elif not angles:
            text = "adds up readings of which none has an angle. Write them with their angles, or leave it out."
        elif goal.robust or any(limit.share is not None for limit in limits):
            text = "goes neither with robust nor with with_probability. Leave it or them out."
        else:
            continue
        mistakes.value(path, sensor.added_to, text)


def check_without_phase(document: Mapping[str, Any], goal: RotorGoal, mistakes: Mistakes) -> None:
    """What readings without angles cannot answer: bands and goals over the scatter."""
    way = "Write the readings with their angles, or leave {} out."
    if "scatter" in document:
        mistakes.add(
            ("scatter",),
            f"scatter gives bands to readings with angles, and these have none. {way.format('scatter')}",
        )
    if goal.robust:
        mistakes.add(
            ("goal", "robust"),
            f'goal.robust = "{goal.robust}" goes over the scatter of readings with angles, and these have none. '
            f"{way.format('robust')}",
        )


Limits = tuple[tuple[ResidualLimit, ...], tuple[CorrectionLimit, ...]]


def read_limits(
    document: Mapping[str, Any], conventions: Conventions, planes: Sequence[Plane], sensors: Sequence[Sensor],
    speeds: Sequence[float], mistakes: Mistakes,
) -> Limits:  # fmt: skip
    """Limits on what is left and on what is fitted."""
    residual, correction = [], []
    for name, given in named_tables(document, "limits", mistakes).items():
        path: Path = ("limits", name)
        kind = given.get("response") if isinstance(given, Mapping) else None
        if not one_of((*path, "response"), kind, RESPONSES, _RESPONSE, mistakes):
            continue
        if kind == "residual":
            residual.append(_residual(name, path, given, conventions, sensors, speeds, mistakes))
        else:
            correction.append(_correction(name, path, given, planes, mistakes))
    return tuple(filter(None, residual)), tuple(filter(None, correction))


def _residual(
    name: str, path: Path, given: object, conventions: Conventions, sensors: Sequence[Sensor], speeds: Sequence[float],
    mistakes: Mistakes,
) -> ResidualLimit | None:  # fmt: skip
    table = read_table(ResidualTable, given, path, mistakes)
    if table is None:
        return None
    names = [sensor.name for sensor in sensors]
    sensor = None if table.at is None else place_of((*path, "at"), table.at, "sensor", names, mistakes)
    if sensor is None and table.at is not None:
        return None
    if sensor is not None and (other := sensors[sensor].added_to):
        mistakes.value(
            (*path, "at"), table.at, f'is added to {other}. Write at = "{other}", which limits both together.'
        )
    speed = None if table.speed is None else _speed_index(path, table.speed, given, speeds, mistakes)
    ones = [sensors[sensor]] if sensor is not None else list(sensors)
    bound = read_value((*path, "at_most"), table.at_most, mistakes, _bound, conventions, ones)
    return ResidualLimit(name, sensor, speed, bound[0], bound[1], table.soft, table.with_probability) if bound else None


def _bound(given: object, conventions: Conventions, sensors: Sequence[Sensor]) -> tuple[float, str]:
    front, angle = split_angle(str(given), "1 mil pp")
    if angle is not None:
        raise QuantityError('has an angle. A limit is an amplitude: write "1 mil pp".')
    amplitude = read_amplitude(front, conventions.detector)
    for sensor in sensors:
        if sensor.dimension != amplitude.dimension:
            raise QuantityError(
                f"does not fit sensor {sensor.name}, which reads in {sensor.unit}. Write a limit in such a unit, or "
                f"name the sensor with at."
            )
    if amplitude.value == 0.0:
        raise QuantityError("is zero. Nothing turns without any vibration: write a limit greater than zero.")
    return amplitude.value, amplitude.shown_unit


def _speed_index(path: Path, speed: Fact, given: Any, speeds: Sequence[float], mistakes: Mistakes) -> int | None:
    index = speed_index(speed.value, speeds)
    if index is None:
        known = ", ".join(show(one, speed.unit, "angular_rate") for one in speeds)
        text = f"is a speed at which nothing was measured. Measured: {known}."
        mistakes.value((*path, "speed"), given["speed"], text)
    return index


def _correction(
    name: str, path: Path, given: object, planes: Sequence[Plane], mistakes: Mistakes
) -> CorrectionLimit | None:
    table = read_table(CorrectionTable, given, path, mistakes)
    if table is None:
        return None
    names = [plane.name for plane in planes]
    if (table.of is None) != table.total:
        mistakes.add(path, f'limits.{name} needs either of = "{names[0]}" or total = true.')
        return None
    index = None if table.of is None else place_of((*path, "of"), table.of, "plane", names, mistakes)
    if index is None and table.of is not None:
        return None
    asked = planes if index is None else [planes[index]]
    bound = read_value((*path, "at_most"), table.at_most, mistakes, _amount, asked)
    return CorrectionLimit(name, index, *bound) if bound else None


def _amount(given: object, planes: Sequence[Plane]) -> tuple[float, str]:
    kinds = {plane.kind for plane in planes}
    if len(kinds) > 1:
        raise QuantityError("adds masses and unbalances. Give every plane its radius, or bound each plane alone.")
    dimension = "unbalance" if kinds == {UNBALANCE} else "mass"
    quantity = read_quantity(given, dimension)
    if quantity.value == 0.0:
        raise QuantityError("is a cap of zero: nothing could be put there. Write keep = true in the plane, or a cap.")
    if quantity.value < 0.0:
        raise QuantityError("is negative. Write a positive cap.")
    return quantity.value, quantity.unit


def read_goal(
    document: Mapping[str, Any],
    conventions: Conventions,
    planes: Sequence[Plane],
    scatter: Scatter | None,
    mistakes: Mistakes,
) -> RotorGoal:
    """The goal; least squares without one."""
    table = optional_table(GoalTable, document, "goal", mistakes)
    if table is None:
        return RotorGoal()
    one_of(("goal", "minimise"), table.minimise, RESPONSES, _RESPONSE, mistakes)
    combine = table.combine or "rms"
    one_of(("goal", "combine"), combine, COMBINE, "way to combine amplitudes", mistakes)
    if table.minimise == "correction":
        return _least_correction(table, planes, document, mistakes)
    huber = inf
    if combine == "huber":
        if table.huber_at is None:
            mistakes.add(
                ("goal",),
                'goal has combine = "huber" without huber_at. Write huber_at = "1 mil pp", from where amplitudes '
                "count linearly.",
            )
        else:
            huber = read_value(("goal", "huber_at"), table.huber_at, mistakes, _huber, conventions) or inf
    elif table.huber_at is not None:
        mistakes.add(("goal", "huber_at"), 'goal has huber_at without combine = "huber". Remove one.')
    return RotorGoal(combine, _robust(table, combine, scatter, mistakes), huber)


def _huber(given: object, conventions: Conventions) -> float:
    amplitude = read_amplitude(str(given), conventions.detector)
    if amplitude.value == 0.0:
        raise QuantityError("is zero. Write an amplitude greater than zero.")
    return amplitude.value


def _least_correction(
    table: GoalTable, planes: Sequence[Plane], document: Mapping[str, Any], mistakes: Mistakes
) -> RotorGoal:
    for key in ("combine", "huber_at", "robust"):
        if getattr(table, key) is not None:
            mistakes.add(("goal", key), f'goal.{key} belongs to minimise = "residual". Remove it.')
    limits = document.get("limits", {})
    if not isinstance(limits, Mapping) or not any(
        isinstance(limit, Mapping) and limit.get("response") == "residual" for limit in limits.values()
    ):
        mistakes.add(
            ("goal",),
            "the least correction without a limit on the residual is none at all. Add [limits.NAME] with response = "
            '"residual".',
        )
    if len({plane.kind for plane in planes}) > 1:
        mistakes.add(("goal",), "the least correction adds masses and unbalances. Give every plane its radius.")
    return RotorGoal("correction")


def _robust(table: GoalTable, combine: str, scatter: Scatter | None, mistakes: Mistakes) -> str:
    if table.robust is None:
        return ""
    if not one_of(("goal", "robust"), table.robust, ROBUST, "robust goal", mistakes):
        return ""
    if scatter is None:
        mistakes.add(
            ("goal", "robust"),
            'goal.robust needs the scatter of the readings. Add scatter = { amplitude = "5 %", angle = "2 deg" }.',
        )
    if table.robust == "mean" and combine != "rms":
        mistakes.add(
            ("goal", "robust"), 'goal.robust = "mean" goes with combine = "rms". Write that, or robust = "worst".'
        )
    return table.robust


def read_quality(
    document: Mapping[str, Any], conventions: Conventions, mass: float | None, speed: float | None, mistakes: Mistakes,
    known: Sequence[str] = (),
) -> Quality | None:  # fmt: skip
    """The grade asked for, with the places along the shaft; `known` are the correction planes of the job, if any."""
    path: Path = ("quality",)
    table = optional_table(QualityTable, document, "quality", mistakes)
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
    error = 0.0 if table.measurement_error is None else table.measurement_error.value
    residual = _residuals((*path, "residual"), table.residual or {}, planes or bearings, conventions, mistakes)
    if len(mistakes.found) > before or weight is None or turning is None:
        return None
    first, second = bearings.items()
    return Quality(
        table.grade.value, weight, turning, (first, second), table.centre_of_mass.value, planes, error, residual,
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
