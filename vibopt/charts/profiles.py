"""Performance profiles over random questions: how many a method answers rightly within how many times the best time.

After Dolan and More, "Benchmarking optimization software with performance profiles", Mathematical Programming 91, 2002.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.charts.random_cases import DRAWN, drawn, methods_of, table
from vibopt.charts.runner import Chart, Progress, charted
from vibopt.charts.trial import DEFAULT, Case, Said, Trial, judged, scene_table
from vibopt.program.pose import pose
from vibopt.records import dataclass
from vibopt.scene.scene import Scene
from vibopt.solve.branch import Judge

EXACT, FAIR = 1e-6, 1e-3
"""True error up to which an answer counts, in either of the two profiles."""
KEPT = 1e-9
"""Part of a bound that a design may miss and still tell how good an answer can be."""


@dataclass(frozen=True, slots=True)
class Profiles:
    """Charts by family, with the seed and the number of questions that they were drawn with."""

    seed: int
    count: int
    charts: dict[str, Chart]


def profiles(
    family: str | None = None, *, seed: int = 1, count: int = 50, quick: bool = False, progress: Progress | None = None
) -> Profiles:
    """Random questions of a family (None: of all), every method asked once on each."""
    charts = {name: _charted(name, seed, count, quick, progress) for name in ([family] if family else DRAWN)}
    return Profiles(seed, count, charts)


def _charted(family: str, seed: int, count: int, quick: bool, progress: Progress | None) -> Chart:
    questions = drawn(family, seed, count)
    known = table(family, questions, quick=quick)
    if known is not None:
        return charted(known, progress)
    cases = [(case, case.scene()) for case in questions]
    seen: dict[tuple[str, str], _Seen] = {}

    def judge(case: Case, scene: Scene, method: str, said: Said) -> Trial:
        seen[case.name, method] = one = _seen(scene, said)
        return judged(case, method, said, one.missed, 0.0)

    asked = scene_table(cases, (DEFAULT, *methods_of(family, quick=quick)), 1, [cases[0][0]])
    return _against_best(charted(replace(asked, judge=judge), progress), seen)


@dataclass(frozen=True, slots=True)
class _Seen:
    """What a run said, with the greatest violation and the goal (to be minimised) of its design, measured exactly."""

    said: Said
    missed: float = math.nan
    goal: float = math.nan


def _seen(scene: Scene, said: Said) -> _Seen:
    if said.answer is None:
        return _Seen(said)
    judge = Judge(pose(scene))
    missed = max((judge.limit(limit, said.answer)[0] for limit in judge.program.limits), default=0.0)
    return _Seen(said, missed, judge.goal(said.answer).value)


def _against_best(chart: Chart, seen: Mapping[tuple[str, str], _Seen]) -> Chart:
    """The same runs judged against the best design that any of them found and that keeps every limit."""
    best: dict[str, float] = {}
    for (case, _), one in seen.items():
        if one.missed <= KEPT:
            best[case] = min(best.get(case, math.inf), one.goal)
    cases = tuple(replace(case, goal=abs(best.get(case.name, math.nan))) for case in chart.cases)
    by_name = {case.name: case for case in cases}
    trials = []
    for trial in chart.trials:
        one, least = seen[trial.case, trial.method], best.get(trial.case, math.nan)
        off = abs(one.goal - least) / max(abs(least), 1e-300)
        trials.append(judged(by_name[trial.case], trial.method, one.said, one.missed, off))
    return Chart(cases, chart.methods, tuple(trials))


def times(chart: Chart, error: float, *, absolute: bool = False) -> dict[str, FloatArray]:
    """Per method the time on each question over the best one there; infinite where its answer is none, or off.

    absolute
        In CPU seconds, as a data profile has it.
    """
    best: dict[str, float] = {}
    for one in chart.trials:
        if one.error <= error:
            best[one.case] = min(best.get(one.case, math.inf), one.seconds)
    return {
        method: np.array([
            trial.seconds / (1.0 if absolute else best[trial.case]) if trial.error <= error else math.inf
            for trial in chart.trials if trial.method == method
        ])
        for method in chart.methods
    }  # fmt: skip
