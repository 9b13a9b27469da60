"""A sweep as series in the user's units: lines against one fact, a map over two."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from math import isfinite, nan
from typing import TYPE_CHECKING

import numpy as np

from vibopt.answer.blocks import spoken, spoken_path
from vibopt.answer.entry import Entry
from vibopt.arrays import FloatArray
from vibopt.errors import InputError
from vibopt.jobs import is_open, is_scene
from vibopt.program.drawn import OPEN
from vibopt.report.catalogue_choices import tied
from vibopt.report.series import Front, Line, Map, Side, Strip, Strips
from vibopt.scene.places import place_of
from vibopt.study.edges import Boundary, State, stretches
from vibopt.study.points import Point, in_unit
from vibopt.study.seen import is_measured
from vibopt.study.sweep import Sweep
from vibopt.study.tradeoff import Tradeoff
from vibopt.study.tradeoff_surface import Surface
from vibopt.study.varied import DECIBEL
from vibopt.units import best_unit
from vibopt.units.spelling import split_detector
from vibopt.values.fact_at import FactAt

if TYPE_CHECKING:
    from vibopt.jobs import Job

_LEVEL = 1e-6
"""Part of a number by which answers may differ that are drawn as one: as far as the coarsest proof goes."""
WORDS = {
    "infeasible": "no design meets all limits",
    "unbounded": "the goal has no best value",
    "unproven": "nothing found, nothing proven",
    "check_failed": "the independent check refused the design",
    "violated": "a limit is broken",
}


def strips(sweep: Sweep) -> Strips:
    """Goal and variables against the varied fact; for a machine that is kept, the margins of its limits.

    Lines pass through the answers on both sides of every boundary that was found between the points.
    """
    fact = sweep.fact
    beside = [side for boundary in sweep.boundaries for side in boundary.sides]
    known = {point.value.value: point for point in (*beside, *sweep.points)}
    points = [known[value] for value in sorted(known)]
    chosen = _chosen(sweep)
    active = [boundary for boundary in sweep.boundaries if not boundary.of_feasibility] if chosen else []
    return Strips(
        title=sweep.job.title,
        x_label=_label(fact, spoken_path(fact.path)),
        x=_shown(np.array([point.value.value for point in points]), fact),
        log_x=sweep.by_ratios,
        strips=tuple(_answers(sweep, points) if chosen else _measured(points, sweep.drawn)),
        shaded=tuple(_shaded(sweep)) if chosen else (),
        marks=tuple(
            (float(_shown(np.array([boundary.at]), fact)[0]), change_words(boundary, briefly=True))
            for boundary in active
        ),
        joined=fact.dimension != "count",
    )


def map_of(sweep: Sweep) -> Map:
    """Goal over two facts, or the least margin of a kept design, with the edges between the points of the grid.

    Raises
    ------
    InputError
        It is no grid over two facts.
    """
    if sweep.axes == () or len(sweep.axes) != 2:
        why = "a sample has no neighbours" if sweep.axes == () else f"{len(sweep.axes)} facts have no page"
        raise InputError(f"--figure: {why}. Leave it out, and write the points with --csv FILE.")
    points = list(sweep.points)
    first, second = sweep.facts
    shape = tuple(len(axis) for axis in sweep.axes)
    told = _results(points) if is_measured(sweep.job) else {}
    strip = next(iter(_answers(sweep, points) if _chosen(sweep) else _numbers(told)), None)
    shown = _margin_strip(points) if strip is None else strip
    values = shown.lines[0].y.reshape(shape).T
    goal = next((point.goal for point in points if point.goal is not None), None) if _chosen(sweep) else None

    words = {**WORDS, "unproven": OPEN} if sweep.drawn else WORDS

    def level(one: Boundary) -> float:
        known = [value for value in one.goals if isfinite(value)]
        if goal is None or not known:
            return nan
        return float(in_unit(np.array([np.mean(known)]), shown.unit, goal.dimension)[0])

    return Map(
        title=sweep.job.title,
        x_label=_label(first, spoken_path(first.path)),
        y_label=_label(second, spoken_path(second.path)),
        x=_shown(sweep.axes[0], first),
        y=_shown(sweep.axes[1], second),
        log=(sweep.varied[0].by_ratios, sweep.varied[1].by_ratios),
        label=shown.label.replace("\n", " "),
        values=values,
        good=np.array([point.good for point in points]).reshape(shape).T,
        sides=tuple(_side(sweep, boundary, level(boundary)) for boundary in sweep.boundaries),
        bad_words=tuple(dict.fromkeys(words.get(point.status, point.status) for point in points if not point.good)),
    )


def change_words(boundary: Boundary, *, briefly: bool = False) -> str:
    """What changes where a fact rises over a boundary; in a figure `briefly`, without the weights themselves."""
    (before, first, had), (after, then, has) = boundary.before, boundary.after
    if before != after and "good" in (before, after):
        status = before if after == "good" else after
        what, bad = "designs" if status == "infeasible" else "answers", WORDS.get(status, "no design")
        return f"{what} begin; below, {bad}" if after == "good" else f"{what} end; beyond, {bad}"
    if {before, after} == {"met", "violated"}:
        return f"breaks {', '.join(then)}" if after == "violated" else f"holds; below, {', '.join(first)} broken"
    if before != after:
        return f"{WORDS.get(before, before)}, then {WORDS.get(after, after)}"
    verb = ("becomes broken", "holds") if before == "violated" else ("becomes active", "no longer active")
    said = [f"{name} {verb[0]}" for name in then if name not in first]
    said += [f"{name} {verb[1]}" for name in first if name not in then]
    old, new = _by_plane(had), _by_plane(has)
    other = [path for path, now in new.items() if old.get(path, now) != now]
    planes = [path.removeprefix("planes.") for path in other if path.startswith("planes.")]
    if briefly and planes:
        return ", ".join([*said, f"other weights in {' and '.join(planes)}"])
    names = [path.removeprefix("links.").removeprefix("planes.") for path in other]
    return ", ".join([*said, *(f"{name} {old[path]} -> {new[path]}" for name, path in zip(names, other, strict=True))])


def _by_plane(chosen: Iterable[tuple[str, str]]) -> dict[str, str]:
    """What was chosen, by path; the weights of a plane together, "40 g @ 251.3 deg"."""
    found: dict[str, str] = {}
    for path, shown in sorted(chosen, key=lambda one: one[0].endswith(".angle")):
        plane = path.rpartition(".")[0] if path.startswith("planes.") else path
        found[plane] = f"{found[plane]} @ {shown}" if plane in found else shown
    return found


def _side(sweep: Sweep, boundary: Boundary, level: float) -> Side:
    """A place on a boundary, in the units of the axes."""
    first, second = sweep.facts
    across = boundary.path == first.path
    other = next(iter(boundary.others.values())).value
    x, y = (boundary.at, other) if across else (other, boundary.at)
    names: tuple[State, State] = (boundary.before, boundary.after)
    words = tuple(sorted(_state_words(state) for state in names))
    if words[0] == words[1]:
        words = tuple(sorted(", ".join(chosen for _, chosen in state[2]) for state in names))
    return Side(
        float(_shown(np.array([x]), first)[0]), float(_shown(np.array([y]), second)[0]), across,
        boundary.of_feasibility, (words[0], words[1]), level,
    )  # fmt: skip


def _state_words(state: State) -> str:
    status, names, _ = state
    if status == "violated":
        return f"{', '.join(names)} broken"
    if status != "good":
        return WORDS.get(status, status) if status != "met" else "all limits hold"
    return f"{', '.join(names)} active" if names else "no limit active"


def _label(fact: FactAt, name: str) -> str:
    unit = f"{fact.unit} pk" if fact.amplitude and not split_detector(fact.unit)[1] else fact.unit
    return f"{name} [{unit}]" if unit else name


def _shown(values: FloatArray, fact: FactAt) -> FloatArray:
    return in_unit(values, fact.unit, fact.dimension)


def _chosen(sweep: Sweep) -> bool:
    return is_open(sweep.job) and not sweep.keep_design


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
        yield _strip(spoken(response.response, place_of(response)), goal, response.dimension)
    part_of = tied(scene)
    for variable in scene.variables:
        column = variable.path.startswith(f"{part_of.get(variable.path)}.")  # a price or rating, of no device
        if variable.path != drawn and not column:
            values = [point.variables.get(variable.path) for point in points]
            yield _strip(spoken_path(variable.path), values, variable.dimension)


def _strip(name: str, values: list[Entry | None], dimension: str) -> Strip:
    si = np.array([value.value if value is not None else nan for value in values])
    si[~np.isfinite(si)] = nan
    finite = si[np.isfinite(si)]
    users = next((value.unit for value in values if value is not None), "")
    shown = users or best_unit(float(np.median(finite)) if len(finite) else 0.0, dimension)
    y = in_unit(si, shown, dimension)
    if len(finite) and np.ptp(finite) <= _LEVEL * np.abs(finite).max():
        y = np.where(np.isfinite(si), np.median(y[np.isfinite(si)]), nan)
    log = bool(
        shown != DECIBEL
        and dimension != "angle"
        and len(finite)
        and finite.min() > 0.0
        and finite.max() > 30.0 * finite.min()
    )
    return Strip(f"{name}\n[{shown}]" if shown else name, (Line(name, y),), log, unit=shown)


def _by_path(points: list[Mapping[str, Entry]]) -> dict[str, list[Entry | None]]:
    return {
        path: [point.get(path) for point in points]
        for path in dict.fromkeys(path for point in points for path in point)
    }


def _numbers(values: Mapping[str, list[Entry | None]]) -> Iterable[Strip]:
    """A strip of each number that some points have, in the user's unit."""
    for name, entries in values.items():
        first = next((entry for entry in entries if entry is not None), None)
        if first is not None:
            yield _strip(spoken_path(name), entries, first.dimension)


def _measured(points: list[Point], drawn: Collection[str]) -> Iterable[Strip]:
    """Margins of the limits; without limits what was measured."""
    if any(point.margins for point in points) or not any(point.results for point in points):
        yield replace(_margins(points), bad_word=f"limit broken, or it {OPEN}") if drawn else _margins(points)
    else:
        yield from _numbers(_results(points))


def _results(points: list[Point]) -> dict[str, list[Entry | None]]:
    """What was measured beside limits, measures of a scene by their names."""
    every = _by_path([point.results for point in points])
    return {path.removeprefix("measures."): entries for path, entries in every.items()}


def _margins(points: list[Point]) -> Strip:
    names = list(dict.fromkeys(name for point in points for name in point.margins))
    lines = tuple(Line(name, np.array([_percent(point.margins.get(name, nan)) for point in points])) for name in names)
    return Strip("margin of each limit [%]", lines, bad_below=0.0)


def _margin_strip(points: list[Point]) -> Strip:
    """The least margin of all limits."""
    least = [_percent(min(point.margins.values(), default=nan)) for point in points]
    return Strip("least margin of all limits [%]", (Line("margin", np.array(least)),))


def _percent(margin: float) -> float:
    """A broken limit further out than its bound is of no interest to the eye."""
    return max(100.0 * margin, -100.0) if isfinite(margin) else -100.0 if margin < 0 else nan


def _shaded(sweep: Sweep) -> Iterable[tuple[float, float, str]]:
    """Stretches without a good answer, in the unit of the fact."""
    for stretch in stretches(sweep):
        low, high = in_unit(np.array([stretch.low, stretch.high]), sweep.fact.unit, sweep.fact.dimension)
        yield float(low), float(high), WORDS.get(stretch.status, stretch.status)


def front_of(tradeoff: Tradeoff) -> Front:
    """A trade-off in the user's units."""
    points = tradeoff.points
    marks = [(0, f"tightest\n{tradeoff.reached[0].shown}")]
    if tradeoff.free:
        marks.append((len(points) - 1, "goal's own best"))
    if tradeoff.knee is not None:
        at, best = tradeoff.reached[tradeoff.knee], points[tradeoff.knee].goal
        marks.append((tradeoff.knee, f"knee\n{at.shown}, {best.shown if best is not None else ''}"))
    drawn = _drawn(tradeoff.job, tradeoff.fact, tradeoff.goal, points, tradeoff.reached)
    return replace(drawn, jumps=tradeoff.jumps, marks=tuple(marks))


def fronts_of(surface: Surface) -> tuple[Front, ...]:
    """The curves of a trade-off of three quantities, each named by the bound of the first, in the user's units."""
    second = [pair[1] for pair in surface.reached]
    drawn = _drawn(surface.job, surface.facts[1], surface.goal, surface.points, second)
    return tuple(
        replace(drawn, x=drawn.x[at], y=drawn.y[at], name=f"{surface.names[0]} {surface.points[at[0]].value.shown}")
        for at in surface.curves.values()
    )


def _drawn(job: Job, fact: FactAt, name: str, points: Sequence[Point], reached: Sequence[Entry]) -> Front:
    """Points as one curve, nothing marked."""
    goal = [point.goal for point in points]
    first = next(entry for entry in goal if entry is not None)
    response = job.goal.response if is_scene(job) and job.goal is not None else None
    said = spoken(response.response, place_of(response)) if response is not None else name or "goal"
    shown = _strip(said.replace("_", " "), goal, first.dimension)
    x, label = _shown(np.array([entry.value for entry in reached]), fact), _label(fact, fact.path.split(".")[1])
    return Front(job.title, label, shown.label.replace("\n", " "), x, shown.lines[0].y, (), ())
