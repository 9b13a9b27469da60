"""A few boxes where forms have bounds on them but no rows at sampled speeds, and starts where those leave it open."""

from __future__ import annotations

from dataclasses import replace

from vibopt.arrays import FloatArray
from vibopt.forms.bounds import FormBounds
from vibopt.program.program import Limit, Program
from vibopt.records import dataclass
from vibopt.solve.boundable import unbounded
from vibopt.solve.branch import Judge, Search
from vibopt.solve.global_search import BranchAndBound
from vibopt.solve.method import OPEN, Found, Progress
from vibopt.solve.nlp import Nlp
from vibopt.work import Budget

_BOXES, _LOOSE, _WORK = 40_000, 4000, 8e7
"""Boxes, those where a limit has no bounds on them, and numbers on all of them together."""
_FEW, _LOOK = 2, 500
"""Starts before them, and boxes before those: where there is no design no start finds one."""


@dataclass(frozen=True)
class BoxesFirst:
    """Branch and bound for mean squares; the best of it and of `starts` where it is not proven, with its bound.

    Limits without bounds on boxes are measured where designs are: what is proven without them is true with them.
    """

    starts: Nlp
    near: FloatArray | None = None
    name = "branch_and_bound"
    summary = "interval branch and bound, and the best of several starts where it leaves something open"

    def refuses(self, program: Program) -> str | None:
        squares = program.aim is not None and program.aim.form.random
        if unbounded(program.aim.pieces if program.aim is not None and squares else program.parts):
            return "something has no bounds on boxes of designs."
        return BranchAndBound().refuses(program) or self.starts.refuses(program)

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """As branch and bound; starts come first where the goal is light: at its limits boxes find no design alone."""
        light = program.aim is not None and program.aim.form.powers is not None
        tried = light and Search(Judge(program), budget=Budget(_LOOK, "boxes")).run().status != "infeasible"
        first = replace(self.starts, count=_FEW, brief=True).solve(program, progress).x if tried else None
        near = self.near if first is None else first
        boxes = BranchAndBound(most=_most(program), near=near, alone=False).solve(program, progress)
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


def _most(program: Program) -> int:
    """Boxes to look at: determinants of a mean square are made of ever more minors, two for each row."""
    squares = [part for part in program.parts if part.form.random]
    each = sum(4.0**part.model.n_free * FormBounds(part.model, part.form, program.high).size for part in squares)
    most = _BOXES if unbounded(program.limits) is None else _LOOSE
    return int(min(most, _WORK / max(each, 1.0)))
