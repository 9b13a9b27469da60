"""More listed values than can be looked at one by one: lists relaxed to ranges, rounded, and exchanged by turns."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import field, replace
from itertools import combinations, product

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.errors import counted
from vibopt.program.program import Axis, Program
from vibopt.records import dataclass
from vibopt.solve.branch import Judge
from vibopt.solve.local import refined
from vibopt.solve.method import Found, Progress
from vibopt.solve.nlp import Nlp
from vibopt.solve.ranges import on_values, starts
from vibopt.work import Budget

_STARTS, _FEW = 6, 2
"""Starts spread over lists and ranges beside the best design of ranges alone, and starts of that."""
_MOST, _FITTED = 6000, 20
"""Designs that are measured, and as how many of them a fit of the ranges counts."""
_NEAREST = 12
"""Values of a list that are tried, those nearest, and about as many of the others."""
_WORTH, _FAR = 2.0, 1.0
"""Part of a goal, and of a bound, by which a design with other values may be worse before its ranges are fitted."""
_SAME = 1e-12
"""Part of the goal that is no gain."""


@dataclass
class RoundAndExchange:
    """The best design that no exchange of one listed value, or of two for the next ones, makes better.

    near
        A design to begin with, (n_vars,), instead of starts spread over lists and ranges.
    """

    near: FloatArray | None = None
    name: str = "round_and_exchange"
    summary: str = "lists relaxed to ranges, rounded, and one or two values after another exchanged"

    def refuses(self, program: Program) -> str | None:
        if all(axis.values is None for axis in program.axes):
            return "there are no listed values."
        return None

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """Status "feasible" or "unproven"."""
        ranges = replace(program, axes=tuple(_as_range(axis) for axis in program.axes))
        led = Nlp(count=_FEW, brief=True)
        x = led.solve(ranges).x if led.refuses(ranges) is None else None
        run, first = _Run(program, progress), [] if x is None else [x]
        first += [self.near] if self.near is not None else list(np.exp(starts(program, _STARTS)))
        for x in first:
            run.follow(on_values(program, x))
        return run.answer(self.name)


def _as_range(axis: Axis) -> Axis:
    return replace(axis, values=None) if axis.values is not None and axis.high > axis.low else axis


@dataclass
class _Run:
    program: Program
    progress: Progress | None
    best: FloatArray | None = None
    rank: tuple[float, float] = (np.inf, np.inf)
    """How much the best design misses a limit, and its goal."""
    tried: set[tuple[float, ...]] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.judge = Judge(self.program)
        self.budget = Budget(_MOST, "designs")
        axes = enumerate(self.program.axes)
        self.lists = [(i, np.unique(axis.values)) for i, axis in axes if axis.values is not None]

    def follow(self, x: FloatArray) -> None:
        """From x (n_vars,) on, until no exchange is better."""
        better: tuple[tuple[float, float], FloatArray] | None = self._fitted(x)
        here = np.inf, np.inf
        while better is not None:
            here, x = better
            if here < self.rank:
                self.rank, self.best = here, x
            if self.program.aim is None and not here[0]:
                return
            better = next((one for y in self._exchanges(x) if (one := self._gain(y, here)) is not None), None)

    def _gain(self, x: FloatArray, here: tuple[float, float]) -> tuple[tuple[float, float], FloatArray] | None:
        """The design with the listed values of x (n_vars,) where it is better than what ranks `here`."""
        listed = tuple(float(x[i]) for i, _ in self.lists)
        if listed in self.tried or self.budget.over:
            return None
        rank = self._rank(x)
        if rank[0] > here[0] + _FAR or (not here[0] and rank[1] - here[1] > _WORTH * abs(here[1])):
            return None
        self.tried.add(listed)
        if self.progress is not None:
            self.progress("listed values", self.budget.part)
        rank, x = self._fitted(x)
        less = rank[1] < here[1] - _SAME * abs(here[1])
        return (rank, x) if rank[0] < here[0] or (rank[0] == here[0] and less) else None

    def _fitted(self, x: FloatArray) -> tuple[tuple[float, float], FloatArray]:
        """The ranges fitted to the listed values of x (n_vars,); x itself where that is no better."""
        rank, there = self._rank(x), refined(self.program, x, near=True)
        if there is None:
            return rank, x
        self.budget.spend(_FITTED)
        other = self._rank(there)
        return (other, there) if other < rank else (rank, x)

    def _rank(self, x: FloatArray) -> tuple[float, float]:
        """How much of a bound x (n_vars,) misses, zero within rounding, and its goal."""
        self.budget.spend()
        missed = max((self.judge.limit(limit, x)[0] for limit in self.program.limits), default=0.0)
        goal = self.judge.goal(x).value
        return (np.inf if np.isnan(missed) else missed if missed > self.judge.tolerance else 0.0, goal)

    def _exchanges(self, x: FloatArray) -> Iterator[FloatArray]:
        """Designs (n_vars,) with another value of one list, the nearest first, and with the next ones of two.

        Of a long list the nearest, and some of those farther off.
        """
        for i, values in self.lists:
            others = values[np.argsort(np.abs(values - x[i]), kind="stable")][1:]
            step = max(len(others) // _NEAREST, 1)
            yield from (_with(x, {i: value}) for value in (*others[:_NEAREST], *others[_NEAREST::step]))
        for (i, one), (j, other) in combinations(self.lists, 2):
            for first, second in product(_beside(one, x[i]), _beside(other, x[j])):
                yield _with(x, {i: first, j: second})

    def answer(self, name: str) -> Found:
        """What was found, and from how much."""
        details = {"designs measured": self.budget.spent}
        if self.best is None or self.rank[0] > 0.0:
            many = counted(self.budget.spent, "designs")
            return Found("unproven", None, f"nothing found in {many} with listed values", name, details=details)
        if self.program.aim is None:
            return Found("optimal", self.best, "a design that meets every limit", name, details=details)
        claim = "the best of several starts, none of which an exchange of one or two listed values makes better"
        return Found("feasible", self.best, claim, name, details=details)


def _with(x: FloatArray, changed: Mapping[int, float]) -> FloatArray:
    moved = x.copy()
    moved[list(changed)] = list(changed.values())
    return moved


def _beside(values: FloatArray, value: float) -> list[float]:
    """The values next to one in a list in order."""
    at = int(np.searchsorted(values, value))
    return [float(values[k]) for k in (at - 1, at + 1) if 0 <= k < len(values)]
