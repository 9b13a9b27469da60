"""A few boxes where forms have bounds on them but no rows at sampled speeds, and starts where those leave it open."""

from __future__ import annotations

from dataclasses import replace

from vibopt.arrays import FloatArray
from vibopt.forms.bounds import FormBounds
from vibopt.program.program import Aim, Limit, Program
from vibopt.records import dataclass
from vibopt.solve.boundable import unbounded
from vibopt.solve.branch import Judge, Search
from vibopt.solve.global_search import COARSE, FINE, BranchAndBound
from vibopt.solve.method import OPEN, Found, Progress
from vibopt.solve.nlp import Nlp
from vibopt.work import Budget

_BOXES, _OF_POLES, _LOOSE, _WORK = 40_000, 100_000, 4000, 8e7
"""Boxes, those without mean squares, those where a limit has no bounds on them, and numbers on all of them together."""
_FEW, _LOOK, _LONGER = 2, 500, 50_000
"""Starts before them, and boxes before those, of a goal of poles more: where there is no design no start finds one."""


@dataclass(frozen=True)
class BoxesFirst:
    """Branch and bound for mean squares and poles; the best of it and of `starts`, with its bound, if it is not proven.

    Limits without bounds on boxes are measured where designs are: what is proven without them is true with them.
    """

    starts: Nlp
    near: FloatArray | None = None
    name = "branch_and_bound"
    summary = "interval branch and bound, and the best of several starts where it leaves something open"

    def refuses(self, program: Program) -> str | None:
        aimed = program.aim is not None and (program.aim.form.random or _of_poles(program.aim))
        if unbounded(program.aim.pieces if program.aim is not None and aimed else program.parts):
            return "something has no bounds on boxes of designs."
        return BranchAndBound().refuses(program) or self.starts.refuses(program)

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """As branch and bound; starts come first where the goal is light or a number of poles.

        At the limits of the one, and where poles meet, boxes find no design alone.
        """
        aim = program.aim
        looks = 0 if aim is None else _LONGER if _of_poles(aim) else _LOOK if aim.form.powers is not None else 0
        budget = Budget(looks, "boxes")
        if looks and program.limits and Search(Judge(program), gap=COARSE, budget=budget).run().status == "infeasible":
            return BranchAndBound().none_in(budget.spent)
        begun = replace(self.starts, count=_FEW, brief=True).solve(program, progress).x if looks else None
        near = self.near if begun is None else begun
        gap = max([FINE, *(piece.form.closed_to(piece.model) for piece in (aim.pieces if aim is not None else ()))])
        boxes = BranchAndBound(gap, _most(program), near, alone=False).solve(program, progress)
        if boxes.status not in OPEN:
            return boxes
        other, judge = self.starts.solve(program, progress), Judge(program)
        if other.x is None or other.status != "feasible":
            return boxes if other.x is None else other
        if boxes.x is not None and judge.goal(boxes.x).value < judge.goal(other.x).value:
            other = replace(other, x=boxes.x)
        loose = unbounded(program.limits)
        without = f", without limit {loose.name}, which has no bounds on boxes" if isinstance(loose, Limit) else ""
        return replace(other, claim=f"{other.claim}; {boxes.claim}{without}", bound=boxes.bound)


def _of_poles(aim: Aim) -> bool:
    return any(piece.form.closed_to(piece.model) > 0.0 for piece in aim.pieces)


def _most(program: Program) -> int:
    """Boxes to look at: determinants of a mean square are made of ever more minors, two for each row."""
    each, most = 1.0, _OF_POLES
    for part in program.parts:
        if part.form.random or part.form.closed_to(part.model):
            numbers = 4.0**part.model.n_free if part.form.random else 6.0 * part.model.n_free
            each += numbers * FormBounds(part.model, part.form, program.high).size
            most = min(most, _BOXES if part.form.random else _OF_POLES)
    return int(min(most if unbounded(program.limits) is None else _LOOSE, _WORK / each))
