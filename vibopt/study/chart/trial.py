"""One method on one scene: what it claims, how long it takes, and what is true of its answer."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from statistics import median
from typing import Any

import numpy as np

from vibopt.forms import FloatArray
from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.scene.scene import Scene
from vibopt.solve.box import closed
from vibopt.solve.branch import Judge
from vibopt.solve.registry import METHODS
from vibopt.study.chart.cases import FEASIBLE, INFEASIBLE, Case

DEFAULT = "vibopt"
"""The method that `vibopt solve` chooses by itself, its check of the built machine included."""

BROKEN, OFF = 1e-6, 1e-3
"""Part of a bound by which a limit counts as broken, and part of the goal by which it counts as missed."""

RIGHT, SAYS_SO, UNPROVEN, SILENT, REFUSES = (
    "right",
    "fails and says so",
    "wrong but says unproven",
    "silently wrong",
    "refuses",
)
MISSING = "not installed"
"""Status and verdict of a rival that is not there; its claim says how to get it."""


@dataclass(frozen=True, slots=True)
class Trial:
    """Outcome of one method on one case.

    seconds
        Median of the runs, from the scene read to the answer.
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
    """

    case: str
    method: str
    seconds: float
    status: str
    claim: str
    missed: float
    off: float
    error: float
    fault: str
    verdict: str


def trial(case: Case, scene: Scene, method: str, runs: int, patience: float = math.inf) -> Trial:
    """Run a method `runs` times on a scene, and judge its last answer.

    A method with a time limit of its own is held to `patience` [s]; the default is not.  A method that
    breaks down ends its own trial only.
    """
    times: list[float] = []
    answer: tuple[str, str, FloatArray | None] = ("error", "", None)
    try:
        for _ in range(max(runs, 1)):
            begin = time.perf_counter()
            answer = _answer(scene, method, patience)
            times.append(time.perf_counter() - begin)
            if times[-1] > 5.0 or answer[0] == REFUSES:
                break
    except Exception as error:
        times.append(math.nan)
        answer = ("error", f"{type(error).__name__}: {error}", None)
    status, claim, x = answer
    return _judged(case, pose(scene), method, float(median(times)), status, claim, x)


def _answer(scene: Scene, method: str, patience: float) -> tuple[str, str, FloatArray | None]:
    """Status, claim and design; the status is REFUSES where the method does not take the scene."""
    if method == DEFAULT:
        from vibopt.solve.solve import solve

        design = solve(scene, explain=False)
        return design.status, f"{design.method}: {design.claim}", np.array(design.x) if design.x else None
    program = closed(pose(scene))
    chosen: Any = METHODS[method]()
    if hasattr(chosen, "seconds"):
        chosen.seconds = min(chosen.seconds, patience)
    refusal = chosen.refuses(program)
    if refusal is not None:
        return REFUSES, refusal, None
    found = chosen.solve(program)
    return found.status, found.claim, found.x


def _judged(
    case: Case, program: Program, method: str, seconds: float, status: str, claim: str, x: FloatArray | None
) -> Trial:
    missed, off = (math.nan, math.nan) if x is None else measured(case, program, x)
    return judged(case, method, seconds, status, claim, missed, off)


def judged(case: Case, method: str, seconds: float, status: str, claim: str, missed: float, off: float) -> Trial:
    """What is claimed against what is true; `missed` and `off` are nan where there is no design."""
    error = math.nan if math.isnan(missed) else max(missed, off, 0.0)
    fault = _fault(case, status, missed, off)
    verdict = _verdict(case, status, missed, off, fault)
    return Trial(case.name, method, seconds, status, claim, missed, off, error, fault, verdict)


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


def warm_up(methods: list[str]) -> None:
    """Load what the methods need, so that no import is timed."""
    from vibopt.study.chart.cases import WARM

    for case in WARM:
        scene = case.scene()
        for method in methods:
            trial(case, scene, method, 1, 1.0)


def as_row(one: Trial) -> dict[str, Any]:
    """Plain data of a trial."""
    return {key: getattr(one, key) for key in Trial.__slots__}


__all__ = [
    "DEFAULT",
    "INFEASIBLE",
    "MISSING",
    "REFUSES",
    "RIGHT",
    "SAYS_SO",
    "SILENT",
    "UNPROVEN",
    "Trial",
    "as_row",
    "judged",
    "trial",
    "warm_up",
]
