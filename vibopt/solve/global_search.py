"""The default for up to three variables: coarse branch and bound, exact polish, proof of the rest."""

from __future__ import annotations

import math

import numpy as np

from vibopt.program.bounds import FormBounds
from vibopt.program.program import Program
from vibopt.solve.branch import Judge, Search
from vibopt.solve.method import Found, Progress
from vibopt.solve.polish import polish

COARSE = 3e-2
MIDDLE = 1e-3
FINE = 1e-6
MOST_VARIABLES = 3
MOST_VALUES = 5000


class BranchAndBound:
    """Interval branch and bound with exact peaks; proves the optimum or that there is none."""

    name = "branch_and_bound"
    summary = "interval branch and bound on Bernstein bounds, with exact peaks"

    def __init__(self, gap: float = FINE, seconds: float = 30.0) -> None:
        self.gap = gap
        self.seconds = seconds

    def refuses(self, program: Program) -> str | None:
        free = sum(axis.values is None for axis in program.axes)
        if free > MOST_VARIABLES:
            return f"{free} continuous variables are more than the {MOST_VARIABLES} that branch and bound takes."
        many = math.prod(len(axis.values) for axis in program.axes if axis.values is not None)
        if many > MOST_VALUES:
            return f"{many} combinations of discrete values are more than the {MOST_VALUES} that are enumerated."
        return None

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """Status "optimal" with `gap`, "infeasible", or what is left when the time is over."""
        judge = Judge(program)
        search = Search(judge, gap=COARSE, seconds=self.seconds, progress=progress)
        first = search.run()
        if first.status == "infeasible":
            return self._none(first.boxes)
        if first.x is None:
            return Found("unproven", None, f"nothing found and nothing proven in {first.boxes} boxes", self.name)
        x = polish(program, first.x)
        if program.aim is None:
            return self._found(program, "optimal", x, first.boxes, "a design that meets every limit")
        search.gap = MIDDLE
        middle = search.run(x)
        x = polish(program, middle.x if middle.x is not None else x)
        search.gap = self.gap
        proof = search.run(x)
        boxes = first.boxes + middle.boxes + proof.boxes
        best = proof.x if proof.x is not None else x
        better = polish(program, best)
        kept = better if judge.goal(better).value <= judge.goal(best).value else best
        if proof.status == "optimal":
            claim = f"proven by branch and bound: nothing is better by more than {self.gap:.0e} of the goal"
            return self._found(program, "optimal", kept, boxes, claim, proof.bound)
        left = abs(proof.bound - judge.goal(kept).value) / max(abs(proof.value), 1e-300)
        claim = f"branch and bound stopped after {boxes} boxes with a gap of {left:.1%}" if np.isfinite(left) else (
            f"branch and bound stopped after {boxes} boxes without a bound"
        )
        return self._found(program, "feasible", kept, boxes, claim, proof.bound)

    def _none(self, boxes: int) -> Found:
        claim = f"proven by branch and bound: every one of {boxes} boxes breaks a limit"
        return Found("infeasible", None, claim, self.name, details={"boxes": boxes})

    def _found(
        self, program: Program, status: str, x: np.ndarray[tuple[int], np.dtype[np.float64]], boxes: int, claim: str,
        bound: float = float("nan"),
    ) -> Found:
        aim = program.aim
        goal = Judge(program).goal(x).value * (aim.sense if aim is not None else 1.0)
        return Found(status, x, claim, self.name, bound, {"boxes": boxes, "goal": goal})


def provable(program: Program) -> bool:
    """Whether every form has bounds on boxes."""
    middle = program.high
    parts = [*program.limits, *([program.aim] if program.aim else [])]
    return all(FormBounds(part.model, part.form, middle).bounded for part in parts)
