"""A few boxes where forms have bounds on them but no rows at sampled speeds, and starts where those leave it open."""

from __future__ import annotations

from dataclasses import replace

from vibopt.arrays import FloatArray
from vibopt.program.program import Program
from vibopt.records import dataclass
from vibopt.solve.branch import Judge
from vibopt.solve.global_search import BranchAndBound, provable
from vibopt.solve.method import OPEN, Found, Progress
from vibopt.solve.nlp import Nlp

_BOXES, _FEW = 4000, 2
"""Boxes, and starts before them."""


@dataclass(frozen=True)
class BoxesFirst:
    """Branch and bound for mean squares; the best of it and of `starts` where it is not proven, with its bound."""

    starts: Nlp
    near: FloatArray | None = None
    name = "branch_and_bound"
    summary = "interval branch and bound, and the best of several starts where it leaves something open"

    def refuses(self, program: Program) -> str | None:
        if not provable(program):
            return "something has no bounds on boxes of designs."
        return BranchAndBound().refuses(program) or self.starts.refuses(program)

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """As branch and bound; starts come first where the goal is light: at its limits boxes find no design alone."""
        light = program.aim is not None and program.aim.form.powers is not None
        first = replace(self.starts, count=_FEW, brief=True).solve(program, progress).x if light else None
        near = self.near if first is None else first
        boxes = BranchAndBound(most=_BOXES, near=near, alone=False).solve(program, progress)
        if boxes.status not in OPEN:
            return boxes
        other, judge = self.starts.solve(program, progress), Judge(program)
        if other.x is None or other.status != "feasible":
            return boxes if other.x is None else other
        if boxes.x is not None and judge.goal(boxes.x).value < judge.goal(other.x).value:
            other = replace(other, x=boxes.x)
        return replace(other, claim=f"{other.claim}; {boxes.claim}", bound=boxes.bound)


__all__ = ["BoxesFirst"]
