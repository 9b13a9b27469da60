"""Fidelity: what is declared and what is needed, and what the smaller model costs and saves."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from statistics import median
from typing import TypeVar

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.charts.stopwatch import spent
from vibopt.errors import VibOptError
from vibopt.forms.reduce import reason
from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.records import dataclass
from vibopt.scene.scene import Scene
from vibopt.solve.branch import Judge
from vibopt.solve.choose import choose
from vibopt.solve.ranges import closed
from vibopt.work import answering

RUNS, QUICK_RUNS = 5, 3
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Fidelity:
    """One scene on its reduced and on its full model.

    declared, used
        Degrees of freedom in the file, and those of the largest model that a question needs.
    why
        Reason for the difference, in words.
    measuring, measuring_full
        Seconds for measuring every limit at one design.
    solving, solving_full
        Seconds for the answer; nan where there is none to be had.
    value_error
        Greatest difference of any limit's value between the two models over some designs, as a part of it.
    goal_error
        Difference of the best goals found on the two, as a part of it; nan where one is missing.
    cut
        Why less was asked than the chart promises; "" where all was.
    noise
        Greatest factor between the times of two runs of the same model; nan where there were none.
    kinds
        The whole model and the simpler one in a word each, where they differ in kind and not in freedoms.
    """

    case: str
    declared: int
    used: int
    why: str
    measuring: float
    measuring_full: float
    solving: float
    solving_full: float
    value_error: float
    goal_error: float
    cut: str = ""
    noise: float = math.nan
    kinds: tuple[str, str] | None = None

    @property
    def counts(self) -> tuple[str, str]:
        """Freedoms declared and used, or the kinds of model, in words."""
        return self.kinds or (str(self.declared), str(self.used))

    @property
    def saved(self) -> tuple[float, float]:
        """Times of measuring and of solving on the full model over those on the smaller one."""
        return self.measuring_full / self.measuring, self.solving_full / self.solving


def of_kinds(
    case: str, kinds: tuple[str, str], whole: Callable[[], float], simple: Callable[[], float], runs: int
) -> list[Fidelity]:
    """A number by a whole model and by a simpler one, both timed; nothing is chosen."""
    (lasted, true), (short, value) = seconds(whole, runs), seconds(simple, runs)
    error = abs(value / true - 1.0)
    return [Fidelity(case, 0, 0, "", short, lasted, math.nan, math.nan, error, math.nan, kinds=kinds)]


def on_both_models(scenes: Sequence[Scene], *, quick: bool) -> list[tuple[str, Callable[[], Sequence[Fidelity]]]]:
    """Every scene posed twice, with and without reduction: its name, and what makes its row."""
    runs = QUICK_RUNS if quick else RUNS
    return [(scene.name, partial(_compared, scene, runs)) for scene in scenes]


def seconds(call: Callable[[], T], runs: int) -> tuple[float, T]:
    """Median time, and what the first call gave, which is not timed: it loads what is needed."""
    times, first = [], call()
    for _ in range(runs):
        begin = spent()
        call()
        times.append(spent() - begin)
    return median(times), first


def _compared(scene: Scene, runs: int) -> list[Fidelity]:
    small = closed(pose(scene))
    full = closed(pose(scene, reduce=False))
    own, whole = _solved(small, runs), _solved(full, runs)
    points = _designs(small, own.x)
    return [Fidelity(
        case=scene.name.removesuffix(".toml"),
        declared=small.model.n_free,
        used=small.used_dof,
        why=reason(small.model.n_free, small.used_dof),
        measuring=_measuring(small, points[0]),
        measuring_full=_measuring(full, points[0]),
        solving=own.seconds,
        solving_full=whole.seconds,
        value_error=max(_value_error(small, full, point) for point in points),
        goal_error=abs(own.goal - whole.goal) / max(abs(whole.goal), 1e-300),
        noise=max(own.noise, whole.noise),
        cut="; ".join(f"{name}: {one.cut}" for name, one in (("smaller model", own), ("full model", whole)) if one.cut),
    )]  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Solved:
    """Seconds, goal and design of the method that vibopt would choose, and why there is less of it."""

    seconds: float = math.nan
    goal: float = math.nan
    x: FloatArray | None = None
    cut: str = ""
    noise: float = math.nan


def _solved(program: Program, runs: int) -> _Solved:
    times, goal, x = [], math.nan, None
    for number in range(runs + 1):
        with answering() as limit:
            begin = spent()
            try:
                found = choose(program, None).solve(program)
            except VibOptError as error:
                return _Solved(cut=str(error))
            if number or runs < 2:  # the first loads what is needed
                times.append(spent() - begin)
        if found.x is not None:
            goal, x = Judge(program).goal(found.x).value, found.x
        if limit is not None and limit.ended:
            return _Solved(
                median(times or [spent() - begin]), goal, x, f"the time limit of {limit.seconds:g} s ended it"
            )
    noise = max(times) / min(times) if len(times) > 1 else math.nan
    return _Solved(median(times), goal, x, noise=noise)


def _designs(program: Program, best: FloatArray | None) -> list[FloatArray]:
    """The best design and a few others, at which the two models are compared."""
    from vibopt.solve.ranges import starts

    spread = [np.clip(np.exp(y), program.low, program.high) for y in starts(program, 8)]
    return spread if best is None else [best, *spread]


def _measuring(program: Program, x: FloatArray) -> float:
    judge = Judge(program)
    return seconds(lambda: [judge.limit(limit, x) for limit in program.limits], 5)[0]


def _value_error(small: Program, full: Program, x: FloatArray) -> float:
    """Greatest relative difference of a limit's value, measured on both models."""
    worst = 0.0
    for one, other in zip(small.limits, full.limits, strict=True):
        a, b = (Judge(p).limit(limit, x)[1].value for p, limit in ((small, one), (full, other)))
        if np.isfinite(a) and np.isfinite(b):
            worst = max(worst, abs(a - b) / max(abs(b), 1e-300))
        elif a != b:
            return math.inf
    return worst
