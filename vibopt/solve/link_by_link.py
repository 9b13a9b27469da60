"""A good design made better one link at a time, each time globally, to leave local optima that starts do not see."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.program.held import held
from vibopt.program.program import Aim, Program
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

    Where nothing is left of `budget`, no further link is tried.
    """
    pairs = links_of(program, x)
    if program.aim is None or len(program.axes) < 3 or not pairs:
        return x, False
    value, waiting = judge.goal(x).value, _asked(program, x, pairs, judge)
    while waiting:
        pair, asked = waiting.pop(0)
        part = held(asked, x, pair)
        method = DiscsOfOneLink(most=_SLICES, start=x[list(pair)])
        if budget.over or method.refuses(part) is not None:
            return x, False
        found = method.solve(part)
        if found.x is None:
            return x, False
        there = x.copy()
        there[list(pair)] = found.x
        before, after = (Judge(asked).goal(one).value for one in (x, there))
        if after < before - _GAIN * abs(before) and judge.feasible(there):
            there = improved(program, there, judge)
        if judge.goal(there).value < value - _GAIN * abs(value) and judge.feasible(there):
            x, value = there, judge.goal(there).value
            waiting = _asked(program, x, pairs, judge)
        elif found.status != "optimal":
            return x, False
    return x, True


def _asked(
    program: Program, x: FloatArray, pairs: list[tuple[int, int]], judge: Judge
) -> list[tuple[tuple[int, int], Program]]:
    """Links, and what each is to make best: the goal, or every limit that holds x (n_vars,) where no link counts in it.

    A link has no part in the mass of absorbers, but what it takes off a response leaves room for less of it.
    """
    powers = None if program.aim is None else program.aim.form.powers
    if powers is None or powers.exponents[:, np.unique(pairs)].any():
        return [(pair, program) for pair in pairs]
    asked, most = [], [limit for limit in program.limits if limit.side == "at_most" and limit.form.drives]
    for one in (limit for limit in most if judge.limit(limit, x)[0] > -_GAIN):
        others = tuple(other for other in program.limits if other is not one)
        asked.append(replace(program, limits=others, aim=Aim(one.name, one.model, one.form, 1.0, one.complement)))
    return [(pair, each) for each in asked for pair in pairs]
