"""A sweep as series in the user's units."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import isfinite, nan

import numpy as np

from vibopt.answer.blocks import spoken, spoken_path
from vibopt.answer.entry import Entry
from vibopt.jobs import is_open, is_scene
from vibopt.report.catalogue_choices import tied
from vibopt.report.series import Line, Strip, Strips
from vibopt.responses.response import place_of
from vibopt.study.edges import stretches
from vibopt.study.points import DECIBEL, Point, in_unit
from vibopt.study.sweep import Sweep
from vibopt.units import best_unit
from vibopt.units.spelling import split_detector

WORDS = {
    "infeasible": "no design meets all limits",
    "unbounded": "the goal has no best value",
    "unproven": "nothing found, nothing proven",
    "check_failed": "the independent check refused the design",
    "violated": "a limit is broken",
}


def strips(sweep: Sweep) -> Strips:
    """Goal and variables against the varied fact; for a machine that is kept, the margins of its limits."""
    fact = sweep.fact
    points = list(sweep.points)
    x = in_unit(np.array([point.value.value for point in points]), fact.unit, fact.dimension)
    unit = f"{fact.unit} pk" if fact.amplitude and not split_detector(fact.unit)[1] else fact.unit
    chosen = is_open(sweep.job) and not sweep.keep_design
    return Strips(
        title=sweep.job.title,
        x_label=f"{spoken_path(sweep.path)} [{unit}]" if unit else spoken_path(sweep.path),
        x=x,
        log_x=sweep.by_ratios,
        strips=tuple(_answers(sweep, points) if chosen else _measured(points)),
        shaded=tuple(_shaded(sweep)) if chosen else (),
    )


def _answers(sweep: Sweep, points: list[Point]) -> Iterable[Strip]:
    """The goal, then each variable that is not the goal itself."""
    scene = sweep.job
    if not is_scene(scene):
        yield from _numbers({sweep.goal or "goal": [point.goal for point in points]})
        yield from _numbers(_by_path([point.variables for point in points]))
        return
    goal = [point.goal for point in points]
    drawn = ""
    if scene.goal is not None and any(goal):
        response = scene.goal.response
        drawn = f"links.{getattr(response, 'of', '')}.{response.response}"
        yield _strip(spoken(response.response, place_of(response)), goal, response.dimension, response.unit or "")
    part_of = tied(scene)
    for variable in scene.variables:
        column = variable.path.startswith(f"{part_of.get(variable.path)}.")  # a price or rating, of no device
        if variable.path != drawn and not column:
            values = [point.variables.get(variable.path) for point in points]
            yield _strip(spoken_path(variable.path), values, variable.dimension, "")


def _strip(name: str, values: list[Entry | None], dimension: str, unit: str) -> Strip:
    si = np.array([one.value if one is not None else nan for one in values])
    si[~np.isfinite(si)] = nan
    finite = si[np.isfinite(si)]
    shown = unit or best_unit(float(np.median(finite)) if len(finite) else 0.0, dimension)
    y = in_unit(si, shown, dimension)
    log = bool(
        shown != DECIBEL
        and dimension != "angle"
        and len(finite)
        and finite.min() > 0.0
        and finite.max() > 30.0 * finite.min()
    )
    return Strip(f"{name}\n[{shown}]" if shown else name, (Line(name, y),), log)


def _by_path(points: list[Mapping[str, Entry]]) -> dict[str, list[Entry | None]]:
    return {path: [one.get(path) for one in points] for path in dict.fromkeys(path for one in points for path in one)}


def _numbers(values: Mapping[str, list[Entry | None]]) -> Iterable[Strip]:
    """A strip of each number that some points have, in the user's unit."""
    for name, entries in values.items():
        first = next((one for one in entries if one is not None), None)
        if first is not None:
            yield _strip(spoken_path(name), entries, first.dimension, first.unit)


def _measured(points: list[Point]) -> Iterable[Strip]:
    """Margins of the limits; without limits what was measured."""
    if any(point.margins for point in points) or not any(point.results for point in points):
        yield _margins(points)
    else:
        yield from _numbers(_by_path([point.results for point in points]))


def _margins(points: list[Point]) -> Strip:
    names = list(dict.fromkeys(name for point in points for name in point.margins))
    lines = tuple(Line(name, np.array([_percent(point.margins.get(name, nan)) for point in points])) for name in names)
    return Strip("margin of each limit [%]", lines, bad_below=0.0)


def _percent(margin: float) -> float:
    """A broken limit further out than its bound is of no interest to the eye."""
    return max(100.0 * margin, -100.0) if isfinite(margin) else -100.0 if margin < 0 else nan


def _shaded(sweep: Sweep) -> Iterable[tuple[float, float, str]]:
    """Stretches without a good answer, in the unit of the fact."""
    for one in stretches(sweep):
        low, high = in_unit(np.array([one.low, one.high]), sweep.fact.unit, sweep.fact.dimension)
        yield float(low), float(high), WORDS.get(one.status, one.status)
