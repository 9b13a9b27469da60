"""One method on one case: what it claims, how long it takes, and what is true of its answer."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, replace
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.charts.scene_rivals import absent
from vibopt.charts.scene_rivals import method as rival
from vibopt.charts.stopwatch import answered, spent
from vibopt.charts.verdicts import FEASIBLE, MISSING, REFUSES, verdict_of
from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.records import dataclass
from vibopt.scene.scene import Scene
from vibopt.solve.branch import Judge
from vibopt.solve.ranges import closed
from vibopt.work import answering


@dataclass(frozen=True)
class Case:
    """One scene with its true answer.

    family
        What makes it hard, for the chart of stability; "" in the chart of speed.
    text
        The problem file; "" where the question writes it (`filed`).
    truth
        "feasible" or "infeasible".
    goal
        Best value of the goal [SI]; nan where there is none.
    known_by
        How the answer is known, in words.
    beside
        Files that lie beside it, by name: a catalogue, a record.
    """

    name: str
    text: str
    truth: str
    goal: float
    known_by: str
    family: str = ""
    beside: Mapping[str, str] = field(default_factory=dict)

    def scene(self) -> Scene:
        """The scene as read from its text."""
        from vibopt.scene.read import from_text, read

        if not self.beside:
            return from_text(self.text, name=self.name)
        with TemporaryDirectory() as folder:
            for name, text in {JOB: self.text, **self.beside}.items():
                Path(folder, name).write_text(text, encoding="utf-8")
            return read(Path(folder, JOB))


JOB = "job.toml"
"""Name of a problem file that others lie beside."""


def filed(case: Case, given: Any) -> Case:
    """The case with its problem file and what lies beside it, as its question writes them."""
    if case.text:
        return case
    return replace(case, text=getattr(given, "text", ""), beside=getattr(given, "beside", {}))


DEFAULT = "vibopt"
"""What `vibopt solve` does by itself, from the job as read to the answer that was checked."""

NOWHERE = (math.nan, math.nan)
"""Violation and distance where there is no design."""


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
    bound, past
        What is claimed to bound the goal, in the sense to be minimised, and by what part of the best goal it excludes
        that; nan where none is.
    within
        How exact the answer is said to be, as a part.
    """

    status: str
    claim: str
    answer: Any = None
    kernel: float = math.nan
    seconds: float = math.nan
    cut: str = ""
    quartiles: tuple[float, float] = (math.nan, math.nan)
    runs: int = 0
    bound: float = math.nan
    past: float = math.nan
    within: float = 0.0


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
    fault, verdict
        What is wrong although the method claims success, "" where nothing is, and the class by the law of `verdicts`.
    cut
        Why less was asked than the chart promises; "" where all was.
    runs
        How many were timed.
    goal
        Of the answer, to be minimised [SI]; nan where its judge does not say.
    within
        How exact the answer is said to be, as a part.
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
    goal: float = math.nan
    within: float = 0.0


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
    left
        Cases and methods that only the whole chart asks, where this is a shorter one.
    """

    cases: Sequence[tuple[Case, Any]]
    methods: Mapping[str, Callable[[Any], Said]]
    judge: Callable[[Case, Any, str, Said], Trial]
    runs: int = 1
    warm: Sequence[tuple[Case, Any]] = ()
    drops: bool = False
    left: tuple[str, ...] = ()

    def tried(self, case: Case, given: Any, method: str, runs: int | None = None) -> Trial:
        """A method on a case: the medians of its runs, its last answer judged."""
        said = timed(lambda: self.methods[method](given), self.runs if runs is None else runs)
        return self.judge(case, given, method, said)


def left_out(
    cases: Sequence[Case], fewer: Sequence[Case], methods: Sequence[str], less: Sequence[str]
) -> tuple[str, ...]:
    """What a shorter chart does not ask, in words: cases and methods by their names."""
    asked = {case.name for case in fewer}
    names = [case.name for case in cases if case.name not in asked]
    unasked = [name for name in methods if name not in less]
    lines: dict[str, list[str]] = {}
    for name in unasked:
        line, setting = setting_of(name)
        lines.setdefault(line or name, []).extend([setting] * bool(setting))
    listed = [f"{line} at {' '.join(settings)}" if settings else line for line, settings in lines.items()]
    said = [("cases", names), ("methods", listed)]
    return tuple(f"{words} {', '.join(some)}" for words, some in said if some)


_SETTING = re.compile(r"(.*?) ([0-9.]+(?:e-?[0-9]+)?)")


def setting_of(method: str) -> tuple[str, str]:
    """A rival that is asked at several settings, and the setting behind its name; "" twice for any other."""
    match = _SETTING.fullmatch(method)
    return ("", "") if match is None else (match[1], match[2])


def scene_table(
    cases: Sequence[tuple[Case, Scene]],
    methods: Sequence[str],
    runs: int,
    warm: Sequence[Case] = (),
    left: tuple[str, ...] = (),
) -> Table:
    """Registered methods on scenes."""

    def by(method: str) -> Callable[[Scene], Said]:
        return lambda scene: said_of(scene, method)

    return Table(
        cases,
        {name: by(name) for name in methods},
        judged_scene,
        runs,
        [(case, case.scene()) for case in warm],
        left=left,
    )


def trial(case: Case, scene: Scene, method: str, runs: int) -> Trial:
    """Run a registered method `runs` times on a scene, and judge its last answer."""
    return scene_table([], [method], runs).tried(case, scene, method)


def judged_scene(case: Case, scene: Scene, method: str, said: Said) -> Trial:
    """A design judged at its exact peaks, and a bound by the best goal."""
    if said.answer is None:
        return judged(case, method, said, *NOWHERE)
    program = pose(scene)
    sense = program.aim.sense if program.aim is not None else math.nan
    past = (said.bound - sense * case.goal) / max(abs(case.goal), 1e-300)
    return judged(case, method, replace(said, past=past), *measured(case, program, said.answer))


def timed(method: Callable[[], Said], runs: int) -> Said:
    """What the last of the runs says, with the medians of their times.

    A method that breaks down, or that the user's time limit ends, ends its own trial only.
    """
    times: list[tuple[float, float]] = []
    said = Said("error", "")
    for _ in range(max(runs, 1)):
        with answering() as limit:
            begin = spent()
            try:
                said = method()
            except Exception as error:
                said = Said("error", f"{type(error).__name__}: {error}")
            took = spent() - begin
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


def greatest_in(scene: Scene) -> Said:
    """The one number that a scene without variables measures, checked on the machine as built."""
    from vibopt.solve.solve import solve

    design, whole, _ = answered(lambda: solve(scene, explain=False))
    (row,) = design.measures.values()
    return Said("optimal" if design.status == "met" else design.status, design.claim, row.value.value, seconds=whole)


def judged_number(case: Case, one: Any, method: str, said: Said) -> Trial:
    """A greatest value judged against the true one."""
    if said.answer is None:
        return judged(case, method, said, *NOWHERE)
    return judged(case, method, said, 0.0, abs(said.answer / case.goal - 1.0))


def said_of(scene: Scene, method: str) -> Said:
    """What a method says of a scene; the status is REFUSES where it does not take it."""
    if method == DEFAULT:
        from vibopt.solve.solve import solve

        design, _, kernel = answered(lambda: solve(scene, explain=False))
        x = np.array(design.x) if design.x else None
        return Said(design.status, f"{design.method}: {design.claim}", x, kernel)
    program = closed(pose(scene))
    how = absent(method)
    if how:
        return Said(MISSING, how)
    chosen = rival(method)
    refusal = chosen.refuses(program)
    if refusal is not None:
        return Said(REFUSES, refusal)
    begin = spent()
    found = chosen.solve(program)
    return Said(found.status, found.claim, found.x, spent() - begin, bound=found.bound,
                within=float(found.details.get("within", 0.0)))  # fmt: skip


def judged(case: Case, method: str, said: Said, missed: float, off: float, goal: float = math.nan) -> Trial:
    """What is claimed against what is true; `missed` and `off` are nan where there is no design."""
    error = math.nan if math.isnan(missed) else max(missed, off, 0.0)
    found = verdict_of(case.truth, said.status, missed, off, said.past, said.within)
    return Trial(
        case.name, method, said.seconds, said.kernel, said.status, said.claim, missed, off, error,
        found.fault, found.verdict, said.cut, said.quartiles, said.runs, goal, said.within,
    )  # fmt: skip


def against(trial: Trial, least: float) -> Trial:
    """The same answer judged against the least goal there is, of a question that has an answer; nan: unknown."""
    off = abs(trial.goal - least) / max(abs(least), 1e-300)
    judged = verdict_of(FEASIBLE, trial.status, trial.missed, off, within=trial.within)
    error = math.nan if math.isnan(trial.missed) else max(trial.missed, off, 0.0)
    return replace(trial, off=off, error=error, fault=judged.fault, verdict=judged.verdict)


def measured(case: Case, program: Program, x: FloatArray) -> tuple[float, float]:
    """Greatest violation and distance from the best goal, both relative, of a design."""
    judge = Judge(program)
    missed = max((judge.limit(limit, x)[0] for limit in program.limits), default=0.0)
    if program.aim is None or math.isnan(case.goal):
        return missed, 0.0
    goal = judge.goal(x).value * program.aim.sense
    return missed, abs(goal - case.goal) / max(abs(case.goal), 1e-300)


def as_row(trial: Trial) -> dict[str, Any]:
    """Plain data of a trial."""
    return {key: getattr(trial, key) for key in Trial.__slots__}
