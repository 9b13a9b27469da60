"""Machines on mounts of a catalogue in the charts of speed and of stability."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from vibopt.scene.scene import Scene
from vibopt.study.chart.asking import Progress, trials_of
from vibopt.study.chart.mounts.asked import Asked, asked, machine_on, stock
from vibopt.study.chart.mounts.hard import METHODS as HARD_METHODS
from vibopt.study.chart.mounts.hard import families
from vibopt.study.chart.mounts.methods import METHODS, Method, tried
from vibopt.study.chart.mounts.own import on_file
from vibopt.study.chart.speed_accuracy import SpeedAccuracy
from vibopt.study.chart.stability import Stability
from vibopt.study.chart.trial import Trial


def speed_accuracy(
    scenes: Sequence[Scene] = (), *, quick: bool = False, progress: Progress | None = None
) -> SpeedAccuracy:
    """Time against excess price over the proven best, on random shelves or on the user's scenes with parts."""
    if scenes:
        return on_file(scenes, quick=quick, progress=progress)
    cases = stock(quick=quick)
    trials = _all(cases, METHODS, 2, progress)
    return SpeedAccuracy(tuple(one.case for one in cases), tuple(METHODS), trials)


def stability(*, quick: bool = False, progress: Progress | None = None) -> Stability:
    """Like modes, mounts in a line, no inertia, uplift, free motions, no damping, wide ratios, no part that will do."""
    cases = families(quick=quick)
    trials = _all(cases, HARD_METHODS, 1, progress)
    return Stability(tuple(one.case for one in cases), tuple(HARD_METHODS), trials)


def _all(cases: Sequence[Asked], methods: dict[str, Method], runs: int, progress: Progress | None) -> tuple[Trial, ...]:
    with TemporaryDirectory() as name:
        warm = asked(*machine_on("space", 6, 2, 3, False))
        for one in methods.values():  # load what they need, so that no import is timed
            tried(warm, one, "", 1, Path(name))
        named = [(f"mounts: {one.case.name}", one) for one in cases]
        return trials_of(
            named, tuple(methods), lambda one, method: tried(one, methods[method], method, runs, Path(name)), progress
        )
