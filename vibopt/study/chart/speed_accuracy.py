"""Speed against accuracy: every method on scenes whose answer is known, timed in one run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from vibopt.scene.scene import Scene
from vibopt.study.chart.asking import Progress, trials_of
from vibopt.study.chart.cases import FEASIBLE, INFEASIBLE, QUICK, STOCK, Case
from vibopt.study.chart.trial import DEFAULT, REFUSES, Trial, trial, warm_up

METHODS = (
    DEFAULT, "branch_and_bound", "nlp", "grid", "slsqp_50", "slsqp", "slsqp_1000", "slsqp_exchange", "trust_constr_50",
    "trust_constr", "ipopt_sampled", "ipopt_sampled_1000", "cvxpy", "cvxpy_dpp",
)  # fmt: skip
QUICK_METHODS = tuple(name for name in METHODS if name not in ("trust_constr", "slsqp_1000", "ipopt_sampled_1000"))
RUNS, QUICK_RUNS = 3, 2
_PROOF_BOXES = 600_000


@dataclass(frozen=True, slots=True)
class SpeedAccuracy:
    """All trials, one for each method on each case."""

    cases: tuple[Case, ...]
    methods: tuple[str, ...]
    trials: tuple[Trial, ...]

    def of(self, case: str) -> list[Trial]:
        """Trials of one case that gave any answer to its question, in the order of the methods."""
        return [one for one in self.trials if one.case == case and one.status != REFUSES]

    def ratio(self, one: Trial) -> float:
        """Time over that of the default on the same case."""
        base = next((t.seconds for t in self.trials if t.case == one.case and t.method == DEFAULT), math.nan)
        return one.seconds / base

    @property
    def cut(self) -> tuple[Trial, ...]:
        """Trials that were asked less than the chart promises."""
        return tuple(one for one in self.trials if one.cut)


def speed_accuracy(
    scenes: Sequence[Scene] = (),
    *,
    cases: Sequence[Case] | None = None,
    methods: Sequence[str] | None = None,
    quick: bool = False,
    progress: Progress | None = None,
) -> SpeedAccuracy:
    """Run every method on the stock set, or on the user's scenes.

    Parameters
    ----------
    scenes
        The user's scenes; their best goals are proven first, with a gap of 1e-8.
    cases, methods
        Another stock set, and other methods than the usual ones.
    quick
        Fewer cases, methods and runs.
    """
    chosen = tuple(methods or (QUICK_METHODS if quick else METHODS))
    runs = QUICK_RUNS if quick else RUNS
    warm_up(list(chosen))
    pairs = [(referenced(scene), scene) for scene in scenes] or [
        (case, case.scene()) for case in cases or (QUICK if quick else STOCK)
    ]
    trials = trials_of(
        [(pair[0].name, pair) for pair in pairs], chosen, lambda pair, method: trial(*pair, method, runs), progress
    )
    return SpeedAccuracy(tuple(case for case, _ in pairs), chosen, trials)


def referenced(scene: Scene) -> Case:
    """The user's scene with its best goal, proven by branch and bound before anything is charted."""
    from vibopt.program.pose import pose
    from vibopt.solve.box import closed
    from vibopt.solve.branch import Judge
    from vibopt.solve.global_search import BranchAndBound

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
