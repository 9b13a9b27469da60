"""The user's own scenes with parts of catalogues: vibopt, every choice measured, and choices at random."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from vibopt.errors import InputError
from vibopt.forms import FloatArray
from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.scene.scene import Scene
from vibopt.scene.uncertain import uncertain
from vibopt.solve.box import closed
from vibopt.solve.branch import Judge
from vibopt.solve.shelf.method import Catalogue
from vibopt.solve.shelf.tree import Shelf, factors_of
from vibopt.study.chart.cases import FEASIBLE, INFEASIBLE, Case
from vibopt.study.chart.mounts.asked import MOUNTS
from vibopt.study.chart.speed_accuracy import Progress, SpeedAccuracy
from vibopt.study.chart.trial import DEFAULT, Trial, judged, measured

EVERY, RANDOM = "every choice", "at random"
METHODS = (DEFAULT, EVERY, RANDOM)
DRAWS = 300
QUICK_SECONDS, FULL_SECONDS = 15.0, 60.0
"""For measuring every choice."""
Answer = tuple[str, str, FloatArray | None]


def has_parts(scene: Scene) -> bool:
    """Whether a part of a catalogue is to be chosen."""
    return any(".part." in one.path for one in scene.variables)


def on_file(scenes: Sequence[Scene], *, quick: bool = False, progress: Progress | None = None) -> SpeedAccuracy:
    """Every scene by three methods, as if no number had a tolerance.

    Raises
    ------
    InputError
        vibopt's method refuses the scene.
    """
    cases, trials = [], []
    for number, scene in enumerate(scenes):
        if progress:
            progress(scene.name, number / len(scenes))
        case, found = _charted(scene, QUICK_SECONDS if quick else FULL_SECONDS)
        cases.append(case)
        trials += found
    return SpeedAccuracy(tuple(cases), METHODS, tuple(trials), ())


def _charted(scene: Scene, patience: float) -> tuple[Case, list[Trial]]:
    """The case with its truth, and the trials."""
    program = closed(pose(scene))
    refusal = Catalogue().refuses(program)
    if refusal is not None:
        raise InputError(f"{scene.name}: {refusal}")
    roads: dict[str, Callable[[], Answer]] = {
        DEFAULT: lambda: _by_vibopt(program),
        EVERY: lambda: _every(program, patience),
        RANDOM: lambda: _random(program),
    }
    answers = {}
    for name, road in roads.items():
        began = time.perf_counter()
        answer = road()
        answers[name] = (time.perf_counter() - began, *answer)
    case = _known(scene, program, answers[EVERY][1:], answers[DEFAULT][1:])
    return case, [_judged(case, program, name, *answer) for name, answer in answers.items()]


def _known(scene: Scene, program: Program, every: Answer, own: Answer) -> Case:
    """Measured choice by choice where there was time, else as proven by vibopt itself, which is then said."""
    (status, _, x), road = every, "every choice measured"
    if status == "unproven":
        (status, _, x), road = own, f"vibopt itself: {own[1]}"
    if uncertain(scene):
        road += ", without tolerances"
    name = scene.name.removesuffix(".toml")
    if x is None or program.aim is None:
        return Case(name, "", INFEASIBLE if status == "infeasible" else FEASIBLE, math.nan, road, MOUNTS)
    return Case(name, "", FEASIBLE, Judge(program).goal(x).value * program.aim.sense, road, MOUNTS)


def _judged(
    case: Case, program: Program, method: str, seconds: float, status: str, claim: str, x: FloatArray | None
) -> Trial:
    """A choice that is not claimed to be the best is not wrong for being dearer."""
    missed, off = (math.nan, math.nan) if x is None else measured(case, program, x)
    found = judged(case, method, seconds, status, claim, missed, off)
    return replace(found, fault="") if status == "feasible" and found.fault.startswith("goal off") else found


def _by_vibopt(program: Program) -> Answer:
    found = Catalogue().solve(program)
    return found.status, found.claim, found.x


def _every(program: Program, patience: float) -> Answer:
    """Every choice measured with exact peaks, one by one."""
    shelf = Shelf(factors_of(program), len(program.axes))
    entries = product(*(range(len(one.table)) for one in shelf.factors))
    designs = (shelf.designs(np.array([one]))[0] for one in entries)
    x, count = _best(program, designs, time.perf_counter() + patience)
    if count < shelf.root.size:
        return "unproven", f"no time: {count} of {shelf.root.size} choices in {patience:.0f} s", None
    if x is None:
        return "infeasible", f"each of {count} choices breaks a limit", None
    return "optimal", f"the best of all {count} choices", x


def _random(program: Program) -> Answer:
    """The best of 300 choices at random."""
    shelf, rng = Shelf(factors_of(program), len(program.axes)), np.random.default_rng(0)
    drawn = np.stack([rng.integers(0, len(one.table), DRAWS) for one in shelf.factors], axis=1)
    x, _ = _best(program, iter(shelf.designs(drawn)), math.inf)
    return ("unproven", "no draw keeps the limits", None) if x is None else ("feasible", "best of the draws", x)


def _best(program: Program, designs: Iterator[FloatArray], deadline: float) -> tuple[FloatArray | None, int]:
    """The best of those that keep every limit, and how many were looked at before the deadline."""
    judge, best, least, count = Judge(program), None, math.inf, 0
    for x in designs:
        if time.perf_counter() > deadline:
            break
        count += 1
        if judge.feasible(x):
            goal = judge.goal(x).value if program.aim is not None else 0.0
            if best is None or goal < least:
                best, least = x, goal
    return best, count
