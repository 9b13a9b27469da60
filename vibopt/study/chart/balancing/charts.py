"""Balancing in the charts of speed and of stability."""

from __future__ import annotations

from vibopt.solve.rivals.hsbalance import installed
from vibopt.study.chart.balancing.built import Asked, asked, worst
from vibopt.study.chart.balancing.cases import stock
from vibopt.study.chart.balancing.hard import families
from vibopt.study.chart.balancing.methods import GIVEN_CLARABEL, METHODS, tried
from vibopt.study.chart.speed_accuracy import Progress, SpeedAccuracy
from vibopt.study.chart.stability import Stability
from vibopt.study.chart.trial import REFUSES, Trial


def speed_accuracy(*, quick: bool = False, progress: Progress | None = None) -> SpeedAccuracy:
    """Least squares, smallest worst residual and discrete weights, timed in one run."""
    methods = _methods()
    cases = stock(quick=quick)
    trials = _all(cases, methods, 2 if quick else 5, progress)
    return SpeedAccuracy(tuple(one.case for one in cases), tuple(methods), tuple(trials), ())


def stability(*, quick: bool = False, progress: Progress | None = None) -> Stability:
    """Planes alike, dead and spoilt sensors, units and scatter."""
    methods = _methods()
    cases = families(quick=quick)
    trials = _all(cases, methods, 1, progress)
    answering = tuple(name for name in methods if any(t.method == name and t.status != REFUSES for t in trials))
    kept = tuple(one for one in trials if one.method in answering)
    return Stability(tuple(one.case for one in cases), answering, kept, ())


def _methods() -> list[str]:
    """A rival that is not installed is named once."""
    return [name for name in METHODS if name != GIVEN_CLARABEL or installed()]


def _all(cases: list[Asked], methods: list[str], runs: int, progress: Progress | None) -> list[Trial]:
    for method in methods:  # load what they need, so that no import is timed
        tried(asked("", worst(8, 2), 1.0, ""), method, 1)
    trials = []
    for number, one in enumerate(cases):
        if progress:
            progress(f"balancing: {one.case.name}", number / len(cases))
        trials += [tried(one, method, runs) for method in methods]
    return trials
