"""Balancing in the charts of speed and of stability."""

from __future__ import annotations

from vibopt.solve.rivals.hsbalance import installed
from vibopt.study.chart.asking import Progress, trials_of
from vibopt.study.chart.balancing.built import Asked, asked, worst
from vibopt.study.chart.balancing.cases import stock
from vibopt.study.chart.balancing.hard import families
from vibopt.study.chart.balancing.methods import GIVEN_CLARABEL, METHODS, tried
from vibopt.study.chart.speed_accuracy import SpeedAccuracy
from vibopt.study.chart.stability import Stability
from vibopt.study.chart.trial import REFUSES, Trial


def speed_accuracy(*, quick: bool = False, progress: Progress | None = None) -> SpeedAccuracy:
    """Least squares, smallest worst residual and discrete weights, timed in one run."""
    methods = _methods()
    cases = stock(quick=quick)
    trials = _all(cases, methods, 2 if quick else 5, progress)
    return SpeedAccuracy(tuple(one.case for one in cases), tuple(methods), trials)


def stability(*, quick: bool = False, progress: Progress | None = None) -> Stability:
    """Planes alike, dead and spoilt sensors, units and scatter."""
    methods = _methods()
    cases = families(quick=quick)
    trials = _all(cases, methods, 1, progress)
    answering = tuple(name for name in methods if any(t.method == name and t.status != REFUSES for t in trials))
    kept = tuple(one for one in trials if one.method in answering)
    return Stability(tuple(one.case for one in cases), answering, kept)


def _methods() -> list[str]:
    """A rival that is not installed is named once."""
    return [name for name in METHODS if name != GIVEN_CLARABEL or installed()]


def _all(cases: list[Asked], methods: list[str], runs: int, progress: Progress | None) -> tuple[Trial, ...]:
    warm = asked("", worst(8, 2), 1.0, "")
    for method in methods:  # load what they need, so that no import is timed
        tried(warm, method, 1)
    named = [(f"balancing: {one.case.name}", one) for one in cases]
    return trials_of(named, methods, lambda one, method: tried(one, method, runs), progress)
