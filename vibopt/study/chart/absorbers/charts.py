"""Absorbers in the charts of speed and of stability: the same methods and verdicts as for isolators."""

from __future__ import annotations

from vibopt.study.chart import speed_accuracy as speed
from vibopt.study.chart import stability as hard_ground
from vibopt.study.chart.absorbers.cases import QUICK, STOCK
from vibopt.study.chart.absorbers.hard import families
from vibopt.study.chart.asking import Progress
from vibopt.study.chart.speed_accuracy import SpeedAccuracy
from vibopt.study.chart.stability import Stability


def _taking(methods: tuple[str, ...]) -> tuple[str, ...]:
    """Newton on equal peaks as well; no convex form of an absorber is known, so cvxpy would only refuse."""
    return (*(name for name in methods if not name.startswith("cvxpy")), "equal_peaks")


def speed_accuracy(*, quick: bool = False, progress: Progress | None = None) -> SpeedAccuracy:
    """One to five absorbers, and one on chains of up to a hundred masses."""
    methods = _taking(speed.QUICK_METHODS if quick else speed.METHODS)
    return speed.speed_accuracy(cases=QUICK if quick else STOCK, methods=methods, quick=quick, progress=progress)


def stability(*, quick: bool = False, progress: Progress | None = None) -> Stability:
    """Small masses, limits out of reach, band edges on a resonance, like modes."""
    methods = _taking(hard_ground.QUICK_METHODS if quick else hard_ground.METHODS)
    return hard_ground.stability(cases=families(), methods=methods, quick=quick, progress=progress)
