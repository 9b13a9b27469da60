"""One method on one case: what it claims, how long it takes, and what is true of its answer."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from statistics import median
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.records import dataclass
from vibopt.scene.scene import Scene
from vibopt.solve.branch import Judge
from vibopt.solve.method import METHODS
from vibopt.solve.ranges import closed
from vibopt.work import answering

FEASIBLE, INFEASIBLE = "feasible", "infeasible"


@dataclass(frozen=True)
class Case:
    """One scene with its true answer.

    family
        What makes it hard, for the chart of stability; "" in the chart of speed.
    text
        The problem file.
    truth
        "feasible" or "infeasible".
    goal
        Best value of the goal [SI]; nan where there is none.
    known_by
        How the answer is known, in words.
    """

    name: str
    text: str
    truth: str
    goal: float
    known_by: str
    family: str = ""

    def scene(self) -> Scene:
        """The scene as read from its text."""
        from vibopt.scene.read import from_text

        return from_text(self.text, name=self.name)


DEFAULT = "vibopt"
"""What `vibopt solve` does by itself, from the job as read to the answer that was checked."""

BROKEN, OFF = 1e-6, 1e-3
"""Part of a bound by which a limit counts as broken, and part of the goal by which it counts as missed."""

RIGHT, SAYS_SO, UNPROVEN, SILENT, REFUSES = (
    "right",
    "fails and says so",
    "wrong but says unproven",
    "silently wrong",
    "refuses",
)
NOWHERE = (math.nan, math.nan)
"""Violation and distance where there is no design."""
MISSING = "not installed"
"""Status and verdict of a rival that is not there; its claim says how to get it."""


@dataclass(frozen=True, slots=True)
class Said:
    """What a method says, before anybody has judged it.

    answer
        Design, correction or parts; None where there is none.
    kernel
        Seconds in the optimiser alone; nan where the whole run is that.
    seconds
        Of the whole run, where the method leaves something out of it (reading its file); else nan.
    cut
        Why the run did less than the chart promises, in words; "" where it did all.
    quartiles, runs
        Of the seconds of so many runs, where it was timed.
    """

    status: str
    claim: str
    answer: Any = None
    kernel: float = math.nan
    seconds: float = math.nan
    cut: str = ""
    quartiles: tuple[float, float] = (math.nan, math.nan)
    runs: int = 0


@dataclass(frozen=True, slots=True)
class Trial:
    """Outcome of one method on one case.

    seconds, quartiles
        Median of the runs, from the job as read to the answer, and between what the middle half of them lies.
    kernel
        The part of it that is the optimiser alone, without posing the question or checking its answer.
    status, claim
        What the method says.
    missed
        Greatest violation, as a part of the bound, measured at the exact peaks; nan without a design.
    off
        Distance of the goal from the best possible, as a part of it; nan without a design.
    error
        The greater of the two: true error.
    fault
        What is wrong although the method claims success; "" where nothing is.
    verdict
        One of the five classes of the chart of stability.
    cut
        Why less was asked than the chart promises; "" where all was.
    runs
        How many were timed.
    """

    case: str
    method: str
    seconds: float
    kernel: float
    status: str
    claim: str
    missed: float
    off: float
    error: float
    fault: str
    verdict: str
    cut: str = ""
    quartiles: tuple[float, float] = (math.nan, math.nan)
    runs: int = 0


@dataclass(frozen=True)
class Table:
    """What one chart asks in one family.

    cases
        Each case with what a method is given: a scene, a question, a machine with its shelf.
    methods
        What each method says of that, by name.
    judge
        The trial of what was said: (case, given, method, said).
    runs
        Runs of each method on each case.
    warm
        Given to every method once, untimed, so that no import is timed.
    drops
        Whether a method that refuses every case is left out.
    """

    cases: Sequence[tuple[Case, Any]]
    methods: Mapping[str, Callable[[Any], Said]]
    judge: Callable[[Case, Any, str, Said], Trial]
    runs: int = 1
    warm: Sequence[tuple[Case, Any]] = ()
    drops: bool = False

    def tried(self, case: Case, given: Any, method: str, runs: int | None = None) -> Trial:
        """A method on a case: the medians of its runs, its last answer judged."""
        said = timed(lambda: self.methods[method](given), self.runs if runs is None else runs)
        return self.judge(case, given, method, said)


def scene_table(
    cases: Sequence[tuple[Case, Scene]], methods: Sequence[str], runs: int, warm: Sequence[Case] = ()
) -> Table:
    """Registered methods on scenes."""

    def by(method: str) -> Callable[[Scene], Said]:
        return lambda scene: said_of(scene, method)

    return Table(cases, {name: by(name) for name in methods}, judged_scene, runs, [(one, one.scene()) for one in warm])


def trial(case: Case, scene: Scene, method: str, runs: int) -> Trial:
    """Run a registered method `runs` times on a scene, and judge its last answer."""
    return scene_table([], [method], runs).tried(case, scene, method)


def judged_scene(case: Case, scene: Scene, method: str, said: Said) -> Trial:
    """A design judged at its exact peaks."""
    return judged(case, method, said, *(NOWHERE if said.answer is None else measured(case, pose(scene), said.answer)))


def timed(method: Callable[[], Said], runs: int) -> Said:
    """What the last of the runs says, with the medians of their times.

    A method that breaks down, or that the user's time limit ends, ends its own trial only.
    """
    times: list[tuple[float, float]] = []
    said = Said("error", "")
    for _ in range(max(runs, 1)):
        with answering() as limit:
            begin = time.perf_counter()
            try:
                said = method()
            except Exception as error:
                said = Said("error", f"{type(error).__name__}: {error}")
            took = time.perf_counter() - begin
        if said.status in ("error", REFUSES, MISSING):
            return replace(said, seconds=math.nan, kernel=math.nan)
        whole = took if math.isnan(said.seconds) else said.seconds
        times.append((whole, whole if math.isnan(said.kernel) else said.kernel))
        if limit is not None and limit.ended:
            said = replace(said, cut=f"the time limit of {limit.seconds:g} s ended it after {limit.ended}")
            break
    wholes, kernels = zip(*times, strict=True)
    low, high = np.quantile(wholes, (0.25, 0.75)).tolist()
    return replace(
        said, seconds=median(wholes), kernel=median(kernels), quartiles=(low, high), runs=len(times)
    )  # fmt: skip


def said_of(scene: Scene, method: str) -> Said:
    """What a method says of a scene; the status is REFUSES where it does not take it."""
    if method == DEFAULT:
        from vibopt.solve.solve import solve

        design = solve(scene, explain=False)
        x = np.array(design.x) if design.x else None
        return Said(design.status, f"{design.method}: {design.claim}", x, design.timings.get("solve", math.nan))
    program = closed(pose(scene))
    chosen = METHODS[method]()
    refusal = chosen.refuses(program)
    if refusal is not None:
        return Said(REFUSES, refusal)
    begin = time.perf_counter()
    found = chosen.solve(program)
    return Said(found.status, found.claim, found.x, time.perf_counter() - begin)


def judged(case: Case, method: str, said: Said, missed: float, off: float) -> Trial:
    """What is claimed against what is true; `missed` and `off` are nan where there is no design."""
    error = math.nan if math.isnan(missed) else max(missed, off, 0.0)
    fault = _fault(case, said.status, missed, off)
    verdict = _verdict(case, said.status, missed, off, fault)
    return Trial(
        case.name, method, said.seconds, said.kernel, said.status, said.claim, missed, off, error, fault, verdict,
        said.cut, said.quartiles, said.runs,
    )  # fmt: skip


def measured(case: Case, program: Program, x: FloatArray) -> tuple[float, float]:
    """Greatest violation and distance from the best goal, both relative, of a design."""
    judge = Judge(program)
    missed = max((judge.limit(limit, x)[0] for limit in program.limits), default=0.0)
    if program.aim is None or math.isnan(case.goal):
        return missed, 0.0
    goal = judge.goal(x).value * program.aim.sense
    return missed, abs(goal - case.goal) / max(abs(case.goal), 1e-300)


def _fault(case: Case, status: str, missed: float, off: float) -> str:
    if status == "infeasible" and case.truth == FEASIBLE:
        return "calls a feasible scene infeasible"
    if status not in ("optimal", "feasible"):
        return ""
    if missed > BROKEN:
        return f"limit broken by {missed:.1e}" if missed < 1e3 else "limit broken without end"
    return f"goal off by {off:.1e}" if case.truth == FEASIBLE and off > OFF else ""


def _verdict(case: Case, status: str, missed: float, off: float, fault: str) -> str:
    if status in (REFUSES, MISSING):
        return status
    if status == "infeasible":
        return SILENT if fault else RIGHT
    if status not in ("optimal", "feasible"):
        return SAYS_SO
    if fault and (missed > BROKEN or status == "optimal"):
        return SILENT
    return UNPROVEN if fault else RIGHT


def as_row(one: Trial) -> dict[str, Any]:
    """Plain data of a trial."""
    return {key: getattr(one, key) for key in Trial.__slots__}
