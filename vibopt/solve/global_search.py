"""The default for up to three variables: coarse branch and bound, exact polish, proof of the rest."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.errors import counted
from vibopt.program.program import Program
from vibopt.solve.boundable import unbounded
from vibopt.solve.branch import MOST_BOXES, MOST_WORK, Judge, Proof, Search
from vibopt.solve.least_missed import nearest_to
from vibopt.solve.local import from_starts, improved, refined, rescued
from vibopt.solve.method import OPEN, VANISHED, Found, Progress, Told
from vibopt.solve.relaxed import with_least
from vibopt.work import Budget

COARSE = 3e-2
MIDDLE = 1e-3
FINE = 1e-6
PATIENCE = 3000
_QUICK, _SOON = 2_500_000, 20_000_000
"""Work of boxes by coefficients after which boxes by slopes are tried, and with which it goes on."""
_BEFORE, _NEARLY = 10_000_000, 0.05
"""The same after which listed values are exchanged, and part of the goal that is open where it goes on for long."""
_DEAR = 125_000
"""Coefficients of a box beyond which few of them are looked at."""
MOST_VARIABLES = 3
MOST_VALUES = 5000


class BranchAndBound:
    """Interval branch and bound with exact peaks; proves the optimum or that there is none."""

    name = "branch_and_bound"
    summary = "interval branch and bound on Bernstein bounds, with exact peaks"

    def __init__(
        self,
        gap: float = FINE,
        most: int = MOST_BOXES,
        near: FloatArray | None = None,
        *,
        alone: bool = True,
        told: Told | None = None,
    ) -> None:
        """With `alone` what is left open is followed from several starts; `told` is what boxes by slopes have said."""
        self.gap, self.most, self.near, self.alone, self.told = gap, most, near, alone, told

    def refuses(self, program: Program) -> str | None:
        free = sum(axis.values is None for axis in program.axes)
        if free > MOST_VARIABLES:
            return f"{free} continuous variables are more than the {MOST_VARIABLES} that branch and bound takes."
        many = math.prod(len(axis.values) for axis in program.axes if axis.values is not None)
        if many > MOST_VALUES and not provable(program):
            return (
                f"{many} combinations of discrete values are more than the {MOST_VALUES} that are measured one by one."
            )
        return None

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """Status "optimal" with `gap`, "infeasible", or what is left when the boxes are used up."""
        judge, budget = Judge(program), Budget(self.most, "boxes")
        work = Budget(_BEFORE if _listed(program) else MOST_WORK, "coefficients")
        search = Search(judge, gap=COARSE, budget=budget, progress=progress, patience=PATIENCE, work=work)
        beside = None if self.near is None else refined(program, self.near, near=True)
        proof, bound, tried = self._first(program, search, beside)
        boxes = budget.spent
        if proof.status == "infeasible":
            return self.none_in(boxes)
        if proof.x is None and judge.feasible(near := nearest_to(program)):  # which boxes are too wide to show
            proof = replace(proof, x=near, value=judge.goal(near).value)
        if proof.x is None:
            return Found("unproven", None, f"nothing found and nothing proven in {counted(boxes, 'boxes')}", self.name)
        if proof.value == -np.inf:
            claim = "the goal is infinite: an undamped resonance lies within reach"
            return self._found(program, "unbounded", proof.x, boxes, claim)
        x = proof.x if beside is not None and np.array_equal(proof.x, beside) else improved(program, proof.x, judge)
        if program.aim is None:
            return self._found(program, "optimal", x, boxes, "a design that meets every limit")
        if judge.goal(x).value == np.inf:
            return self._found(program, "feasible", x, boxes, "the goal is infinite at every design that was looked at")
        return self._narrowed(program, search, x, bound, tried=tried)

    def _first(self, program: Program, search: Search, beside: FloatArray | None) -> tuple[Proof, float, bool]:
        """What a wide gap leaves, its bound, and whether more work on it is in vain; of lists what exchange finds."""
        judge = search.judge
        proof = search.run(beside if beside is not None and judge.feasible(beside) else None)
        bound, tried = proof.bound, proof.x is not None and search.work.over and not _listed(program)
        if proof.status == "open" and proof.x is None:
            x = rescued(program, search.open_middles(6), judge)
            search.patience = self.most if x is None else PATIENCE
            proof = search.run(x)
        if _listed(program) and proof.status == "open":
            proof = _exchanged(program, proof, judge)
            if proof.x is None:  # there may be none
                search.work = Budget(MOST_WORK, "coefficients")
                proof = search.run()
        return proof, bound, tried

    def _narrowed(self, program: Program, search: Search, x: FloatArray, bound: float, *, tried: bool) -> Found:
        """The best design from the feasible x (n_vars,) on, proven to ever smaller gaps."""
        judge, budget = search.judge, search.budget
        if search.vanishes():
            return self._nothing(program, x, budget.spent)
        steps = ((MIDDLE, _QUICK), (self.gap, _QUICK), (MIDDLE, _SOON), (self.gap, _SOON), (self.gap, MOST_WORK))
        for gap, most in steps[:-1] if tried else steps:  # what was too much for a wide gap is for a small one
            value = judge.goal(x).value
            if most == MOST_WORK and _listed(program) and value - bound > _NEARLY * abs(value):
                break
            search.gap, search.work = gap, Budget(most, "coefficients")
            proof = search.run(x)
            bound = max(bound, proof.bound)
            x = x if proof.x is None or np.array_equal(proof.x, x) else improved(program, proof.x, judge)
            if search.vanishes():
                return self._nothing(program, x, budget.spent)
            value = judge.goal(x).value
            proven = proof.status == "optimal" and gap == self.gap
            if proven or value - bound <= self.gap * abs(value):
                claim = f"proven by branch and bound: nothing is better by more than {self.gap:.0e} of the goal"
                bound = proof.bound if proven else min(bound, value)
                return self._found(program, "optimal", x, budget.spent, claim, bound)
            if gap == self.gap and most == _QUICK:
                sloped = with_least(program, self._found(program, "feasible", x, budget.spent, ""), told=self.told)
                if sloped.status == "optimal":
                    return sloped
                bound = max(bound, sloped.bound) if np.isfinite(sloped.bound) else bound
        x = from_starts(program, x, judge) if self.alone else x
        boxes = budget.spent
        return self._found(program, "feasible", x, boxes, _open_words(boxes, bound, judge.goal(x).value), bound)

    def _nothing(self, program: Program, x: FloatArray, boxes: int) -> Found:
        return replace(self._found(program, "optimal", x, boxes, VANISHED, 0.0), zero=True)

    def none_in(self, boxes: int) -> Found:
        """That each of so many boxes, which are all there is, breaks a limit."""
        each = "every one of " * (boxes != 1)
        claim = f"proven by branch and bound: {each}{counted(boxes, 'boxes')} breaks a limit"
        return Found("infeasible", None, claim, self.name, details={"boxes": boxes})

    def _found(
        self,
        program: Program,
        status: str,
        x: FloatArray,
        boxes: int,
        claim: str,
        bound: float = float("nan"),
    ) -> Found:
        aim = program.aim
        goal = Judge(program).goal(x).value * (aim.sense if aim is not None else 1.0)
        return Found(status, x, claim, self.name, bound, {"boxes": boxes, "goal": goal})


def dear(program: Program) -> bool:
    """Whether each box of lists and ranges takes so long that exchange finds the better designs."""
    return _listed(program) and Search(Judge(program)).each > _DEAR


def _listed(program: Program) -> bool:
    return any(axis.values is not None for axis in program.axes)


def _exchanged(program: Program, proof: Proof, judge: Judge) -> Proof:
    """What few boxes have left open, with the design that exchange of listed values leads to where that is better."""
    from vibopt.solve.round_and_exchange import RoundAndExchange

    x = RoundAndExchange().solve(program).x
    if x is None or (proof.x is not None and judge.goal(x).value >= proof.value):
        return proof
    return replace(proof, x=x, value=judge.goal(x).value)


def _open_words(boxes: int, bound: float, value: float) -> str:
    """What a search that was stopped can still say."""
    if not np.isfinite(bound):
        return f"branch and bound stopped after {counted(boxes, 'boxes')} without a bound"
    gap = abs(bound - value) / max(abs(value), 1e-300)
    return f"branch and bound stopped after {counted(boxes, 'boxes')} with a gap of {gap:.1e} of the goal"


def beside_slices(program: Program, found: Found, progress: Progress | None) -> Found:
    """What slices of a third variable leave open, by boxes of all three, and where they do too by many more slices."""
    from vibopt.solve.plane.discs import DiscsOfOneLink

    told: Told = {}
    search = BranchAndBound(near=found.x, told=told)
    if search.refuses(program) is not None or not provable(program) or len(program.axes) < MOST_VARIABLES:
        return found
    sloped = with_least(program, found, told=told)
    if sloped.status == "optimal":
        return sloped
    boxes = search.solve(program, progress)
    if boxes.status not in OPEN:
        return boxes
    whole = DiscsOfOneLink(start=boxes.x).solve(program, progress)
    return whole if whole.status not in OPEN or whole.x is not None else boxes


def provable(program: Program) -> bool:
    """Whether every form has bounds on boxes."""
    return unbounded(program.parts) is None
