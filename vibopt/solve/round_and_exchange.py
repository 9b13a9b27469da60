"""More listed values than can be looked at one by one: lists relaxed to ranges, rounded, and exchanged by turns.

Rows of a catalogue beside ranges are exchanged in the same way: a row sets several numbers at once.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field, replace
from itertools import combinations, product

import numpy as np

from vibopt.arrays import FloatArray, IntArray
from vibopt.errors import counted
from vibopt.program.program import Axis, Program
from vibopt.records import dataclass
from vibopt.solve.branch import Judge
from vibopt.solve.local import refined
from vibopt.solve.method import Found, Progress
from vibopt.solve.nlp import Nlp
from vibopt.solve.ranges import starts
from vibopt.work import Budget

_STARTS, _FEW = 6, 2
"""Starts spread over lists and ranges beside the best design of ranges alone, and starts of that."""
_MOST, _FITTED = 6000, 20
"""Designs that are measured, and as how many of them a fit of the ranges counts."""
_NEAREST, _BESIDE = 12, 2
"""Values of a list that are tried, those nearest and about as many of the others, and those of two lists at once."""
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
        if all(axis.values is None for axis in program.axes) and not program.ties:
            return "there are no listed values."
        return None

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """Status "feasible" or "unproven"."""
        ranges = replace(program, axes=tuple(_as_range(axis) for axis in program.axes), ties=())
        led = Nlp(count=_FEW, brief=True)
        x = led.solve(ranges).x if led.refuses(ranges) is None else None
        run, first = _Run(program, progress), [] if x is None else [x]
        first += [self.near] if self.near is not None else list(np.exp(starts(program, _STARTS)))
        for x in first:
            run.follow(run.rounded(x))
            if run.settled:
                break
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
        tied = {i for tie in self.program.ties for i in tie.axes}
        listed = {
            i: axis.values for i, axis in enumerate(self.program.axes) if axis.values is not None and i not in tied
        }
        self.factors = [(list(tie.axes), np.asarray(tie.table)) for tie in self.program.ties]
        self.factors += [([i], np.unique(values)[:, None]) for i, values in listed.items()]
        chosen = {*tied, *listed}
        axes = [replace(axis, values=(axis.low,)) if i in chosen else axis for i, axis in enumerate(self.program.axes)]
        self.fixed = replace(self.program, axes=tuple(axes), ties=())

    def rounded(self, x: FloatArray) -> FloatArray:
        """The design with the nearest values and rows to x (n_vars,)."""
        found = np.array(x, dtype=float)
        for axes, table in self.factors:
            found[axes] = table[_nearest(table, found[axes])[0]]
        return found

    def follow(self, x: FloatArray) -> None:
        """From x (n_vars,) on, until no exchange is better."""
        better: tuple[tuple[float, float], FloatArray] | None = self._fitted(x)
        here = np.inf, np.inf
        while better is not None:
            here, x = better
            if here < self.rank:
                self.rank, self.best = here, x
            if self.settled:
                return
            better = next((one for y in self._exchanges(x) if (one := self._gain(y, here)) is not None), None)

    @property
    def settled(self) -> bool:
        """Whether no design is better than the best, whatever else is tried."""
        return not self.rank[0] and (self.program.aim is None or self.program.is_best(self.rank[1]))

    def _gain(self, x: FloatArray, here: tuple[float, float]) -> tuple[tuple[float, float], FloatArray] | None:
        """The design with the listed values of x (n_vars,) where it is better than what ranks `here`."""
        listed = tuple(float(x[i]) for axes, _ in self.factors for i in axes)
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
        rank, there = self._rank(x), refined(self.fixed, x, near=True)
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
        near = [(axes, table[_nearest(table, x[axes])[1:]]) for axes, table in self.factors]
        for axes, others in near:
            step = max(len(others) // _NEAREST, 1)
            yield from (_with(x, (axes, row)) for row in (*others[:_NEAREST], *others[_NEAREST::step]))
        for (one, first), (two, second) in combinations(near, 2):
            for a, b in product(first[:_BESIDE], second[:_BESIDE]):
                yield _with(x, (one, a), (two, b))

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


def _with(x: FloatArray, *rows: tuple[list[int], FloatArray]) -> FloatArray:
    moved = x.copy()
    for axes, values in rows:
        moved[axes] = values
    return moved


def _nearest(table: FloatArray, row: FloatArray) -> IntArray:
    """Rows of a table (n_rows, n) in the order of their distance in logs from a row, (n_rows,)."""
    logs, here = (np.log(np.maximum(one, 1e-12 * table.max(axis=0, initial=1e-300))) for one in (table, row))
    return np.argsort(np.sum((logs - here) ** 2, axis=1), kind="stable")
