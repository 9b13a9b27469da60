"""A good design made better one link at a time, each time globally, to leave local optima that starts do not see."""

from __future__ import annotations

from itertools import combinations

from vibopt.arrays import FloatArray
from vibopt.program.held import held
from vibopt.program.program import Program
from vibopt.solve.branch import Judge
from vibopt.solve.local import improved
from vibopt.solve.plane.discs import DiscsOfOneLink
from vibopt.solve.plane.link_plane import LinkPlane
from vibopt.work import Budget

_GAIN = 1e-6
_SLICES = 200
"""Slices of one link."""


def links_of(program: Program, x: FloatArray) -> list[tuple[int, int]]:
    """Pairs of variables that are stiffness and damping of one link, the others held at x (n_vars,)."""
    pairs = combinations(range(len(program.axes)), 2)
    return [pair for pair in pairs if LinkPlane.of(held(program, x, pair)) is not None]


def improved_by_links(program: Program, x: FloatArray, judge: Judge, budget: Budget) -> tuple[FloatArray, bool]:
    """A design no worse than the feasible x (n_vars,), and whether no link alone can make it better (proven).

    budget
        Where nothing is left of it, no further link is tried.
    """
    pairs = links_of(program, x)
    if program.aim is None or len(program.axes) < 3 or not pairs:
        return x, False
    settled: set[tuple[int, int]] = set()
    value = judge.goal(x).value
    while len(settled) < len(pairs):
        pair = next(one for one in pairs if one not in settled)
        part = held(program, x, pair)
        method = DiscsOfOneLink(most=_SLICES, start=x[list(pair)])
        if budget.over or method.refuses(part) is not None:
            return x, False
        found = method.solve(part)
        if found.x is None:
            return x, False
        there = x.copy()
        there[list(pair)] = found.x
        goal = judge.goal(there).value
        if goal < value - _GAIN * abs(value) and judge.feasible(there):
            x = improved(program, there, judge)
            value = judge.goal(x).value
            settled.clear()
        elif found.status != "optimal":
            return x, False
        settled.add(pair)
    return x, True
