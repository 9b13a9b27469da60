"""The user's own scenes: their best goal proven first, or every choice of parts measured."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import product

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.charts.isolation_cases import METHODS as SCENE_METHODS
from vibopt.charts.isolation_cases import QUICK_METHODS, QUICK_RUNS, RUNS, WARM
from vibopt.charts.mount_cases import MOUNTS
from vibopt.charts.stopwatch import answered
from vibopt.charts.trial import (
    DEFAULT,
    NOWHERE,
    Case,
    Said,
    Table,
    Trial,
    judged,
    left_out,
    measured,
    scene_table,
    timed,
)
from vibopt.charts.verdicts import FEASIBLE, INFEASIBLE
from vibopt.errors import InputError
from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.scene.open_places import open_places
from vibopt.scene.scene import Scene
from vibopt.scene.uncertain import uncertain
from vibopt.solve.branch import Judge
from vibopt.solve.catalogue.choices import Choices, factors_of
from vibopt.solve.catalogue.parts import Catalogue
from vibopt.solve.global_search import BranchAndBound
from vibopt.solve.ranges import closed
from vibopt.solve.solve import solve
from vibopt.work import late

EVERY, RANDOM = "every choice", "at random"
METHODS = (DEFAULT, EVERY, RANDOM)
DRAWS = 300
QUICK_MOST, MOST = 2_000, 20_000
"""Choices of a file that are measured one by one."""
_PROOF_BOXES = 600_000


def has_parts(scene: Scene) -> bool:
    """Whether a part of a catalogue is to be chosen."""
    return any(".part." in variable.path for variable in scene.variables)


def speed(scenes: Sequence[Scene], *, quick: bool) -> Table:
    """Every method on the user's scenes; their best goals are proven first, with a gap of 1e-8."""
    cases = [(referenced(scene), scene) for scene in scenes]
    methods = QUICK_METHODS if quick else SCENE_METHODS
    return scene_table(cases, methods, QUICK_RUNS if quick else RUNS, WARM, left_out([], [], SCENE_METHODS, methods))


def refuse_more(scene: Scene) -> None:
    """Places and tolerances, which vibopt would answer and the others not: their numbers could not be compared."""
    refuse_places(scene)
    found = uncertain(scene)
    if found and not has_parts(scene):
        raise InputError(
            f"{scene.name}: {found[0].path} has a tolerance, and the other methods of the chart know none. Remove it."
        )


def refuse_places(scene: Scene) -> None:
    """Several places left open."""
    for path in open_places(scene):
        raise InputError(
            f"{scene.name}: {path} leaves several places open, and the chart compares one machine at a time. Name one "
            "place."
        )


def referenced(scene: Scene) -> Case:
    """The user's scene with its best goal, proven by branch and bound before anything is charted."""
    program = closed(pose(scene))
    search = BranchAndBound(gap=1e-8, most=_PROOF_BOXES)
    name = scene.name.removesuffix(".toml")
    if program.aim is None or not program.axes or search.refuses(program) is not None:
        return Case(name, "", FEASIBLE, math.nan, "not known: no proof was possible")
    found = search.solve(program)
    if found.status == "infeasible":
        return Case(name, "", INFEASIBLE, math.nan, "branch and bound: no design exists")
    if found.x is None:
        return Case(name, "", FEASIBLE, math.nan, "not known: branch and bound found nothing")
    goal = Judge(program).goal(found.x).value
    left = abs(goal - found.bound) / max(abs(goal), 1e-300)
    words = (
        f"branch and bound, proven to {left:.0e}"
        if found.status == "optimal"
        else f"best known, proven to {left:.0e} only"
    )
    return Case(name, "", FEASIBLE, goal * program.aim.sense, words)


def with_parts(scene: Scene, most: int) -> tuple[Case, list[Trial]]:
    """The case with its truth, and the trials of three methods, as if no number had a tolerance.

    Raises
    ------
    InputError
        vibopt's method refuses the scene.
    """
    program = closed(pose(scene))
    refusal = Catalogue().refuses(program)
    if refusal is not None:
        raise InputError(f"{scene.name}: {refusal}")
    roads: dict[str, Callable[[], Said]] = {
        DEFAULT: lambda: _by_vibopt(scene, program),
        EVERY: lambda: _every(program, most),
        RANDOM: lambda: _random(program),
    }
    answers = {name: timed(road, 1) for name, road in roads.items()}
    case = _known(scene, program, answers[EVERY], answers[DEFAULT])
    return case, [_judged(case, program, name, said) for name, said in answers.items()]


def _known(scene: Scene, program: Program, every: Said, own: Said) -> Case:
    """Measured choice by choice where there are few enough, else as proven by vibopt itself, which is then said."""
    said, road = (
        (own, f"vibopt itself: {own.claim}") if every.status == "unproven" else (every, "every choice measured")
    )
    if uncertain(scene):
        road += ", without tolerances"
    name, x = scene.name.removesuffix(".toml"), said.answer
    if x is None or program.aim is None:
        return Case(name, "", INFEASIBLE if said.status == "infeasible" else FEASIBLE, math.nan, road, MOUNTS)
    return Case(name, "", FEASIBLE, Judge(program).goal(x).value * program.aim.sense, road, MOUNTS)


def _judged(case: Case, program: Program, method: str, said: Said) -> Trial:
    return judged(case, method, said, *(NOWHERE if said.answer is None else measured(case, program, said.answer)))


def _by_vibopt(scene: Scene, program: Program) -> Said:
    """The answer certified; where tolerances are left out, the search alone, as no other machine was asked for."""
    if uncertain(scene):
        found = Catalogue().solve(program)
        return Said(found.status, found.claim, found.x)
    design, _, kernel = answered(lambda: solve(scene, explain=False))
    x = np.array(design.x) if design.x else None
    return Said(design.status, design.claim, x, kernel)


def _every(program: Program, most: int) -> Said:
    """Every choice measured with exact peaks, one by one; not asked where there are more than `most`."""
    choices = Choices(factors_of(program), len(program.axes))
    size = choices.root.size
    if size > most:
        why = f"{size} choices are more than the {most} that are measured one by one"
        return Said("unproven", why, cut=why)
    entries = product(*(range(len(factor.table)) for factor in choices.factors))
    x, count = _best(program, (choices.designs(np.array([entry]))[0] for entry in entries))
    if count < size:
        return Said("unproven", f"ended after {count} of {size} choices")
    if x is None:
        return Said("infeasible", f"each of {count} choices breaks a limit")
    return Said("optimal", f"the best of all {count} choices", x)


def _random(program: Program) -> Said:
    """The best of 300 choices at random."""
    choices, rng = Choices(factors_of(program), len(program.axes)), np.random.default_rng(0)
    drawn = np.stack([rng.integers(0, len(factor.table), DRAWS) for factor in choices.factors], axis=1)
    x, _ = _best(program, iter(choices.designs(drawn)))
    return Said("unproven", "no draw keeps the limits") if x is None else Said("feasible", "best of the draws", x)


def _best(program: Program, designs: Iterator[FloatArray]) -> tuple[FloatArray | None, int]:
    """The best of those that keep every limit, and how many were looked at before the user's time limit."""
    judge, best, least, count = Judge(program), None, math.inf, 0
    for x in designs:
        if late(f"{count} choices"):
            break
        count += 1
        if judge.feasible(x):
            goal = judge.goal(x).value if program.aim is not None else 0.0
            if best is None or goal < least:
                best, least = x, goal
    return best, count
