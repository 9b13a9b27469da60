"""Performance profiles over random questions: how many a method answers rightly within how many times the best time.

After Dolan and More, "Benchmarking optimization software with performance profiles", Mathematical Programming 91, 2002.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from vibopt.answer.entry import TOLERANCE
from vibopt.arrays import FloatArray
from vibopt.charts.random_cases import BEST, DRAWN, drawn, table
from vibopt.charts.runner import Chart, Progress, charted
from vibopt.charts.trial import against, left_out
from vibopt.records import dataclass

EXACT, FAIR = 1e-6, 1e-3
"""True error up to which an answer counts, in either of the two profiles."""
COUNT, QUICK_COUNT = 50, 4
"""Questions of a family."""


@dataclass(frozen=True, slots=True)
class Profiles:
    """Charts by family, with the seed and the number of questions that they were drawn with."""

    seed: int
    count: int
    charts: dict[str, Chart]


def profiles(
    family: str | None = None,
    *,
    seed: int = 1,
    count: int | None = None,
    quick: bool = False,
    progress: Progress | None = None,
) -> Profiles:
    """Random questions of a family (None: of all), every method asked once on each; a count of None is the chart's."""
    count = count or (QUICK_COUNT if quick else COUNT)
    charts = {name: _charted(name, seed, count, quick, progress) for name in ([family] if family else DRAWN)}
    return Profiles(seed, count, charts)


def _charted(family: str, seed: int, count: int, quick: bool, progress: Progress | None) -> Chart:
    asked = table(family, drawn(family, seed, count), quick=quick)
    if quick:
        every = table(family, [], quick=False).methods
        lines = left_out([], [], tuple(every), tuple(asked.methods))
        more = (f"{COUNT - count} more questions of {family}",) if count < COUNT else ()
        asked = replace(asked, left=(*more, *lines))
    return _against_best(charted(asked, progress))


def _against_best(chart: Chart) -> Chart:
    """Questions whose best is not known, judged against the best answer of all methods that keeps every limit."""
    asked = {case.name for case in chart.cases if case.known_by == BEST}
    best: dict[str, float] = {}
    for one in chart.trials:
        if one.case in asked and one.missed <= TOLERANCE:
            best[one.case] = min(best.get(one.case, math.inf), one.goal)
    cases = (replace(case, goal=abs(best.get(case.name, math.nan))) if case.name in asked else case
             for case in chart.cases)  # fmt: skip
    trials = (against(one, best.get(one.case, math.nan)) if one.case in asked else one for one in chart.trials)
    return replace(chart, cases=tuple(cases), trials=tuple(trials))


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
