"""Reading a measured rotor: from the document of a problem file to a job, or all mistakes at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import isclose
from pathlib import Path as FilePath
from typing import Any

from vibopt.balancing.check_rotor import check_runs
from vibopt.balancing.coefficients import Saved, read_influence
from vibopt.balancing.conventions import Conventions
from vibopt.balancing.influence import tells_apart
from vibopt.balancing.parse_asks import (
    check_added,
    check_shares,
    check_without_phase,
    read_goal,
    read_limits,
    read_quality,
    read_scatter,
)
from vibopt.balancing.parse_machine import read_conventions, read_planes, read_sensors
from vibopt.balancing.parse_runs import Measured, gather, has_angles, merge, read_runs, with_units
from vibopt.balancing.planes import MASS, Plane
from vibopt.balancing.rotor_job import RotorGoal, RotorJob
from vibopt.balancing.rotor_tables import (
    TOP,
    PairTable,
    QualityTable,
    RotorTable,
    headed,
    known_keys,
    optional_table,
    read_table,
)
from vibopt.document.mistakes import Mistakes, Path, name_fault, named_tables
from vibopt.errors import InputError
from vibopt.units import show
from vibopt.values.grade import grade_velocity


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
            way = 'Write kind = "static" (same angle) or kind = "couple" (opposite).'
            mistakes.value((*path, "kind"), table.kind, f"is no kind of pair. {way}")
            continue
        if not isinstance(table.planes, list) or len(table.planes) != 2 or not set(table.planes) <= set(names):
            mistakes.value(
                (*path, "planes"), table.planes, f"is not two planes of this job. Known: {', '.join(names)}."
            )
            continue
        first, second = (names.index(plane) for plane in table.planes)
        if first == second:
            other = next((one for one in names if one != names[first]), "right")
            way = f'Write two planes, for example planes = ["{names[first]}", "{other}"].'
            mistakes.value((*path, "planes"), table.planes, f"is one plane with itself. {way}")
            continue
        bare = [plane for plane in (planes[first], planes[second]) if plane.kind == MASS and not plane.radii]
        if len(bare) == 1:
            mistakes.add(
                path, f"pairs.{name} sets unbalances equal, but planes.{bare[0].name} has no radius. Add its radius."
            )
            continue
        if planes[first].keep and planes[second].keep:
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


def read_rotor(
    document: Mapping[str, Any], mistakes: Mistakes, folder: FilePath | None = None,
    saved: Callable[[], Saved | None] = lambda: None, like: RotorJob | None = None,
) -> RotorJob:  # fmt: skip
    """A balancing job from a parsed problem file.

    Parameters
    ----------
    document
        The file as `tomli` gives it.
    mistakes
        Collects what is wrong, with lines; rows and columns of a CSV file come behind.
    folder
        Where the file lies, for the name of its CSV file.
    saved
        Reads the file of coefficients that `influence` names.
    like
        A job whose document this one is but for some values: what was measured is not read again where it is the same.

    Raises
    ------
    InputError
        All mistakes at once.
    """
    again = None if like is None else _other_bounds(document, like)
    if again is not None:
        return again
    coefficients = saved()
    known_keys(document, TOP, mistakes)
    if "quality" in document and "runs" not in document and "readings" not in document:
        return _grade_only(document, mistakes)
    before = len(mistakes.found)
    raws, own = gather(document, mistakes, folder)
    whole = len(mistakes.found) == before and not (own is not mistakes and own.found)
    with_angles = has_angles(raws, document)
    conventions = read_conventions(document, with_angles, mistakes)
    planes = read_planes(document, mistakes)
    measured = None
    if planes == ():
        mistakes.add(("planes",), 'there is no correction plane. Write [planes.NAME] with radius = "150 mm".')
    if conventions is not None and planes:
        planes = with_units(planes, ((name, given) for raw in raws for name, given in raw.weights.items()))
        if not raws and whole and not mistakes.found:
            way = "Add [[runs]] with speed and readings as found, and without weights."
            mistakes.add(("runs",), f"there is no initial run. {way}")
        sensors = read_sensors(document, conventions, mistakes)
        measured = read_runs(document, raws, conventions, planes, sensors, mistakes)
        for sensor in measured.sensors if measured is not None and "readings" in document else ():
            if wrong := name_fault(sensor.name):
                mistakes.add(("readings",), f'readings: "{sensor.name}" {wrong}')
    merge(own, mistakes)
    if conventions is None or not planes or measured is None or not raws or not whole:
        if conventions is not None and planes:
            _read_asked(document, conventions, planes, mistakes)
        mistakes.raise_any()
        raise AssertionError("a job that cannot be read has a mistake")
    before = len(mistakes.found)
    influence = read_influence(document, conventions, planes, measured, mistakes, coefficients)
    only_found = "rotor" in document and "influence" not in document and all(run.is_initial for run in measured.runs)
    pairs = read_pairs(document, planes, mistakes)
    if len(mistakes.found) == before and not only_found:
        check_runs(measured, planes, influence, conventions, pairs, mistakes, has_phase=with_angles)
    return _job(document, conventions, planes, measured, with_angles, mistakes, influence, pairs)


def _read_asked(
    document: Mapping[str, Any], conventions: Conventions, planes: Sequence[Plane], mistakes: Mistakes
) -> None:
    """Mistakes of what is asked, where what was measured cannot be read: all are said at once."""
    scatter = read_scatter(document, conventions, mistakes)
    if scatter is not None or "scatter" not in document:
        read_goal(document, conventions, planes, scatter, mistakes)
    read_pairs(document, planes, mistakes)
    optional_table(RotorTable, document, "rotor", mistakes)
    optional_table(QualityTable, document, "quality", mistakes)


def _other_bounds(document: Mapping[str, Any], like: RotorJob) -> RotorJob | None:
    """The job with other bounds, goal or scatter on what `like` has measured; None where more than that is new."""
    same = all(document.get(key) is like.document.get(key) for key in _MEASURED)
    if not same or not like.runs or like.pairs or "pairs" in document or not document.keys() <= {*TOP}:
        return None
    mistakes = Mistakes(like.name, None)
    planes = read_planes(document, mistakes)
    if not planes or [_as_measured(plane) for plane in planes] != [_as_measured(plane) for plane in like.planes]:
        return None
    if any(plane.fitted is not None for plane in planes) and not _tells_each(like):
        return None  # what the runs say of other weights is to be looked at
    texts = [(like.planes[plane].name, text) for run in like.runs for plane, text in run.fitted]
    measured = Measured(like.runs, like.sensors, like.speeds, like.speed_units, (), like.notes)
    try:
        planes = with_units(planes, texts)
        return _job(document, like.conventions, planes, measured, like.has_phase, mistakes, like.influence)
    except InputError:
        return None  # read as a whole it says what is wrong


def _tells_each(job: RotorJob) -> bool:
    """Whether the runs tell what a weight does in each plane, and not only in several planes together."""
    for speed, places in enumerate(map(list, job.places)):
        ready, W = {plane for at, _, plane in job.influence if at == speed}, job.weights[places]
        asked = [k for k in range(len(job.planes)) if k not in ready and (k in job.free or W[:, k].any())]
        if not tells_apart(W[W.any(axis=1)][:, asked]):
            return False
    return True


_MEASURED = ("conventions", "sensors", "runs", "readings", "influence", "speed", "rotor", "quality")


def _as_measured(plane: Plane) -> Any:
    """What the runs say of a plane hangs on."""
    return plane.name, plane.kind, plane.radii, plane.holes, plane.keep


def _job(
    document: Mapping[str, Any], conventions: Conventions, planes: tuple[Plane, ...], measured: Measured,
    with_angles: bool, mistakes: Mistakes, influence: Mapping[tuple[int, int, int], complex],
    pairs: tuple[tuple[str, int, int, float], ...] = (),
) -> RotorJob:  # fmt: skip
    scatter = read_scatter(document, conventions, mistakes)
    residual, correction = read_limits(document, conventions, planes, measured.sensors, measured.speeds, mistakes)
    goal = read_goal(document, conventions, planes, scatter, mistakes)
    if scatter is not None or "scatter" not in document:
        check_shares(residual, goal, scatter, mistakes, angles=with_angles)
    check_added(measured.sensors, residual, goal, mistakes, angles=with_angles)
    _check_importance(measured, goal, document, mistakes)
    if not with_angles:
        check_without_phase(document, goal, mistakes)
    machine = optional_table(RotorTable, document, "rotor", mistakes)
    quality = read_quality(
        document,
        conventions,
        machine.mass.value if machine else None,
        machine.speed.value if machine and machine.speed else max(measured.speeds),
        mistakes,
        [plane.name for plane in planes],
    )
    title, expected = headed(document, mistakes)
    job = RotorJob(
        name=mistakes.name, title=title, conventions=conventions, planes=planes,
        sensors=measured.sensors, runs=measured.runs, speeds=measured.speeds, speed_units=measured.speed_units,
        influence=influence, scatter=scatter, residual_limits=residual, correction_limits=correction, goal=goal,
        pairs=pairs, rotor_mass=machine.mass.value if machine else None,
        trial_force=machine.trial_force.value if machine and machine.trial_force else 0.1,
        quality=quality, has_phase=with_angles, expected=expected,
        notes=(*measured.notes, *pair_notes(pairs, planes), *grade_notes(document)), document=document,
    )  # fmt: skip
    mistakes.raise_any()
    return job


def _grade_only(document: Mapping[str, Any], mistakes: Mistakes) -> RotorJob:
    """A file that asks for permissible unbalances, and the grade of measured ones, without a balancing job."""
    conventions = Conventions("", "", "", "pk", "")
    if "conventions" in document:
        conventions = read_conventions(document, False, mistakes) or conventions
    machine = optional_table(RotorTable, document, "rotor", mistakes)
    speed = machine.speed.value if machine and machine.speed else None
    quality = read_quality(document, conventions, machine.mass.value if machine else None, speed, mistakes)
    title, expected = headed(document, mistakes)
    job = RotorJob(
        name=mistakes.name, title=title, conventions=conventions, quality=quality, expected=expected,
        notes=grade_notes(document), document=document,
    )  # fmt: skip
    mistakes.raise_any()
    return job


def grade_notes(document: Mapping[str, Any]) -> tuple[str, ...]:
    """How a grade that is no velocity was read."""
    quality = document.get("quality", {})
    given = quality.get("grade") if isinstance(quality, Mapping) else None
    read = grade_velocity(given)
    return (
        () if read == given else (f'quality.grade: "{given}" read as {read}, the velocity that the grade stands for.',)
    )


def _check_importance(measured: Measured, goal: RotorGoal, document: Mapping[str, Any], mistakes: Mistakes) -> None:
    """Whether what is left at the sensors can be added, and any of it counts."""
    kinds = {sensor.dimension for sensor in measured.sensors}
    sensors = named_tables(document, "sensors", mistakes)
    weighed = len(kinds) < 2 or all(
        isinstance(sensors.get(sensor.name), Mapping) and "importance" in sensors[sensor.name]
        for sensor in measured.sensors
    )
    if goal.goal != "correction" and not weighed:
        first, second = (
            next(sensor for sensor in measured.sensors if sensor.dimension == kind) for kind in sorted(kinds)[:2]
        )
        mistakes.add(
            ("sensors",),
            f"sensors {first.name} and {second.name} read in {first.unit} and {second.unit}, which cannot be added. "
            "Give every sensor its importance (a factor on its amplitude in SI units).",
        )
    if goal.goal != "correction" and not any(sensor.importance for sensor in measured.sensors):
        mistakes.add(
            ("sensors",),
            "every sensor has importance = 0, so nothing is left to make small. Give one of them an importance greater "
            'than zero, or write minimise = "correction" under limits on the residual.',
        )
