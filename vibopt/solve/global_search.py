"""The default for up to three variables: coarse branch and bound, exact polish, proof of the rest."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.errors import counted
from vibopt.program.program import Program
from vibopt.solve.boundable import unbounded
from vibopt.solve.branch import MOST_BOXES, MOST_WORK, Judge, Search
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
        if many > MOST_VALUES:
            return f"{many} combinations of discrete values are more than the {MOST_VALUES} that are enumerated."
        return None

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """Status "optimal" with `gap`, "infeasible", or what is left when the boxes are used up."""
        judge = Judge(program)
        budget = Budget(self.most, "boxes")
        search = Search(judge, gap=COARSE, budget=budget, progress=progress, patience=PATIENCE)
        beside = None if self.near is None else refined(program, self.near, near=True)
        known = beside is not None and judge.feasible(beside)
        proof = search.run(beside if known else None)
        bound, tried = proof.bound, proof.x is not None and search.work.spent >= search.work.most
        if proof.status == "open" and proof.x is None:
            x = rescued(program, search.open_middles(6), judge)
            search.patience = self.most if x is None else PATIENCE
            proof = search.run(x)
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
        if search.vanishes():
            return replace(self._found(program, "optimal", x, boxes, VANISHED, 0.0), zero=True)
        long = () if tried else ((self.gap, MOST_WORK),)  # what was too much for a wide gap is for a small one
        for gap, most in ((MIDDLE, _QUICK), (self.gap, _QUICK), (MIDDLE, _SOON), (self.gap, _SOON), *long):
            search.gap, search.work = gap, Budget(most, "coefficients")
            proof = search.run(x)
            boxes, bound = budget.spent, max(bound, proof.bound)
            x = x if proof.x is None or np.array_equal(proof.x, x) else improved(program, proof.x, judge)
            if search.vanishes():
                return replace(self._found(program, "optimal", x, boxes, VANISHED, 0.0), zero=True)
            value = judge.goal(x).value
            proven = proof.status == "optimal" and gap == self.gap
            if proven or value - bound <= self.gap * abs(value):
                claim = f"proven by branch and bound: nothing is better by more than {self.gap:.0e} of the goal"
                return self._found(program, "optimal", x, boxes, claim, proof.bound if proven else min(bound, value))
            if gap == self.gap and most == _QUICK:
                sloped = with_least(program, self._found(program, "feasible", x, boxes, ""), told=self.told)
                if sloped.status == "optimal":
                    return sloped
        x = from_starts(program, x, judge) if self.alone else x
        return self._found(program, "feasible", x, boxes, _open_words(boxes, bound, judge.goal(x).value), bound)

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
