"""Listed values beside more continuous variables than one search takes: each combination of them is solved."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.errors import counted
from vibopt.program.held import held
from vibopt.program.program import Program
from vibopt.records import dataclass
from vibopt.solve.branch import Judge
from vibopt.solve.method import Found, Method, Progress

MOST_COMBINATIONS = 200
_PROVEN = ("optimal", "infeasible")


@dataclass
class EachListed:
    """Every combination of listed values, what is left solved by the method that proves most of it.

    rest
        Gives that method, for a program and a design to start from.
    """

    rest: Callable[[Program, None, Sequence[float] | None], Method]
    name: str = "each_listed"
    summary: str = "each combination of listed values, and the rest by the method that proves most"

    def refuses(self, program: Program) -> str | None:
        listed = [len(axis.values) for axis in program.axes if axis.values is not None]
        if not listed:
            return "there are no listed values."
        if math.prod(listed) > MOST_COMBINATIONS:
            return f"{math.prod(listed)} combinations of listed values are more than the {MOST_COMBINATIONS} solved."
        return None

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """ "optimal" and "infeasible" only where that is proven of each combination."""
        judge, free = Judge(program), [i for i, axis in enumerate(program.axes) if axis.values is None]
        choices = list(product(*[axis.values or (axis.low,) for axis in program.axes]))
        best, value, statuses, near = None, np.inf, [], None
        for index, choice in enumerate(choices):
            if progress is not None:
                progress("listed values", index / len(choices))
            x = np.array(choice, dtype=float)
            found = self._with(program, judge, x, free, near)
            statuses.append(found.status)
            if found.status == "unbounded":
                return found
            if found.x is None:
                continue
            goal = judge.goal(found.x).value
            near = found.x[free]
            if best is None or goal < value:
                best, value = found, goal
        return self._whole(program, best, value, statuses)

    def _with(self, program: Program, judge: Judge, x: FloatArray, free: list[int], near: FloatArray | None) -> Found:
        """The answer with the listed values of x (n_vars,)."""
        if not free:
            return Found("optimal" if judge.feasible(x) else "infeasible", x if judge.feasible(x) else None, "", "")
        part = held(program, x, free)
        found = self.rest(part, None, None if near is None else near.tolist()).solve(part)
        if found.x is None:
            return found
        whole = x.copy()
        whole[free] = found.x
        if found.status == "feasible" and _settled_by_lists(program, free):
            found = replace(found, status="optimal", claim="the listed values alone decide the goal")
        return replace(found, x=whole)

    def _whole(self, program: Program, best: Found | None, value: float, statuses: list[str]) -> Found:
        many, proven = len(statuses), sum(statuse in _PROVEN for statuse in statuses)
        details: dict[str, float] = {"listed combinations": many, "proven": proven}
        every = counted(many, "combinations of listed values")
        what = f"{'each of ' * (many != 1)}{every}"
        if best is None:
            if proven == many:
                return Found("infeasible", None, f"proven for {what}", self.name, details=details)
            claim = f"nothing found in any of {every}, {proven} of them proven impossible"
            return Found("unproven", None, claim, self.name, details=details)
        details["goal"] = value * (program.aim.sense if program.aim is not None else 1.0)
        if proven == many:
            claim = f"proven for {what}; with those chosen: {best.claim}" if best.claim else f"measured for {what}"
            return Found("optimal", best.x, claim, self.name, value, details)
        kinds = Counter(statuses)
        said = ", ".join(f"{count} {kind}" for kind, count in kinds.most_common())
        claim = f"the best of {every} ({said}); with those chosen: {best.claim}"
        return Found("feasible", best.x, claim, self.name, details=details)


def _settled_by_lists(program: Program, free: list[int]) -> bool:
    """Whether the goal is a number of the listed values alone: with them one design is as good as any."""
    aim = program.aim
    return aim is not None and all(
        piece.form.powers is not None and not piece.form.powers.exponents[:, free].any() for piece in aim.pieces
    )
