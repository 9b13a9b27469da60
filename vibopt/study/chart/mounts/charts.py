"""Machines on mounts of a catalogue in the charts of speed and of stability."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from vibopt.scene.scene import Scene
from vibopt.study.chart.mounts.asked import Asked, asked, machine_on, stock
from vibopt.study.chart.mounts.hard import METHODS as HARD_METHODS
from vibopt.study.chart.mounts.hard import families
from vibopt.study.chart.mounts.methods import METHODS, Method, tried
from vibopt.study.chart.mounts.own import on_file
from vibopt.study.chart.speed_accuracy import Progress, SpeedAccuracy
from vibopt.study.chart.stability import Stability
from vibopt.study.chart.trial import Trial

FULL_SECONDS = 120.0


def speed_accuracy(
    scenes: Sequence[Scene] = (), *, quick: bool = False, progress: Progress | None = None
) -> SpeedAccuracy:
    """Time against excess price over the proven best, on random shelves or on the user's scenes with parts."""
    if scenes:
        return on_file(scenes, quick=quick, progress=progress)
    cases = stock(quick=quick)
    trials, skipped = _all(cases, METHODS, 2, progress)
    return SpeedAccuracy(tuple(one.case for one in cases), tuple(METHODS), tuple(trials), tuple(skipped))


def stability(*, quick: bool = False, progress: Progress | None = None) -> Stability:
    """Like modes, mounts in a line, no inertia, uplift, free motions, no damping, wide ratios, no part that will do."""
    cases = families(quick=quick)
    trials, skipped = _all(cases, HARD_METHODS, 1, progress)
    return Stability(tuple(one.case for one in cases), tuple(HARD_METHODS), tuple(trials), tuple(skipped))


def _all(
    cases: Sequence[Asked], methods: dict[str, Method], runs: int, progress: Progress | None
) -> tuple[list[Trial], list[tuple[str, str]]]:
    """Every method on every case, and those for which there was no time."""
    trials: list[Trial] = []
    skipped: list[tuple[str, str]] = []
    deadline = time.perf_counter() + FULL_SECONDS
    with TemporaryDirectory() as name:
        warm = asked(*machine_on("space", 6, 2, 3, False))
        for one in methods.values():  # load what they need, so that no import is timed
            tried(warm, one, "", 1, Path(name))
        for number, case in enumerate(cases):
            if progress:
                progress(f"mounts: {case.case.name}", number / len(cases))
            for method, road in methods.items():
                if time.perf_counter() > deadline:
                    skipped.append((case.case.name, method))
                else:
                    trials.append(tried(case, road, method, runs, Path(name)))
    return trials, skipped
