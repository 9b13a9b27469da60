"""The design that misses its worst limit least, or where every limit holds has the most room in the least one."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import field, replace

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.program.program import Program
from vibopt.records import dataclass
from vibopt.solve.measured_pieces import BEYOND, SLOPES, Exact, Piece, Point
from vibopt.solve.ranges import log_box, on_values, starts
from vibopt.solve.sqp import Sqp
from vibopt.values.soft import bent, counted
from vibopt.work import Budget

_MEASUREMENTS, _WORK, _FEWEST = 800, 8_000.0, 40
"""Most exact measurements; work of all where each is dear [nominal ms], and how many it may be then."""
_STARTS, _FOLLOWED = 16, 4
_BETTER = 1e-9
_EVEN = 1e-7
"""Log of a factor within which limits are missed alike."""


@dataclass
class Missing(Exact):
    """By which factor each limit is missed, as its weight counts it: to be made least; those in `kept` no more."""

    kept: Mapping[int, float] = field(default_factory=dict)

    def _at(self, y: FloatArray, parts: set[int] | None = None) -> Point:
        limits = None if parts is None else {part if part >= 0 else -1 - part for part in parts}
        every = tuple(self._counted(limit) for limit in super()._at(y, limits).limits)
        kept = tuple(
            replace(piece, value=piece.value - self.kept[piece.part]) for piece in every if piece.part in self.kept
        )
        goals = tuple(replace(piece, part=-1 - piece.part) for piece in every if piece.part not in self.kept)
        return Point(np.array(y), kept, goals)

    def _counted(self, piece: Piece) -> Piece:
        """A piece as the weight of its limit counts it."""
        limit = self.program.limits[piece.part]
        at_least = limit.side == "at_least"
        if limit.soft == 1.0 and at_least != (piece.value > 0.0):
            return piece
        value, first, second = counted(piece.value, limit.soft, at_least=at_least)
        bend = bent(piece.slope, piece.bend, first, second)
        return replace(piece, value=value, slope=first * piece.slope, bend=bend)


def nearest_to(
    program: Program, given: Sequence[FloatArray] = (), kept: Collection[int] = (), *, spread: int = _STARTS
) -> FloatArray:
    """The design x (n_vars,) whose worst limit is missed by the least factor, of all that some starts lead to.

    Continuous variables follow the slopes of the limits that are missed most; values of a list and parts change one at
    a time as long as that helps.

    Parameters
    ----------
    given, spread
        Starts x, each (n_vars,), and how many more there are all over the ranges.
    kept
        Indices of limits that are to hold and do not count beyond that.
    """
    budget = _budget(program)
    bare = replace(program, aim=None)
    begun = [np.asarray(one, dtype=float) for one in given]
    begun += [_snapped(program, x) for x in np.exp(starts(program, spread))]
    search = _Search(bare, budget, dict.fromkeys(kept, 0.0))
    ranked = sorted(((search.missed(x), number) for number, x in enumerate(begun)))
    best, least = begun[ranked[0][1]], ranked[0][0]
    for _, number in ranked[:_FOLLOWED]:
        x, value = search.followed(begun[number])
        if value < least - _BETTER:
            best, least = x, value
        if budget.over:
            break
    return search.settled(best)


def slid(program: Program, x: FloatArray) -> tuple[FloatArray, float]:
    """Where slopes lead from x (n_vars,) towards missing the worst limit least, and the log of that factor."""
    return _Search(program, _budget(program)).slid(x)


def _budget(program: Program) -> Budget:
    most = int(np.clip(_WORK / program.cost, _FEWEST, _MEASUREMENTS))
    return Budget(most, "exact measurements", SLOPES * program.cost)


@dataclass
class _Search:
    program: Program
    budget: Budget
    kept: Mapping[int, float] = field(default_factory=dict)

    def missed(self, x: FloatArray) -> float:
        """Log of the factor by which the worst limit is missed at x (n_vars,)."""
        return _goal(self._exact(x).at(np.log(np.maximum(x, 1e-300))))

    def followed(self, x: FloatArray) -> tuple[FloatArray, float]:
        """Where slopes and single changes lead from x (n_vars,), and what is missed there."""
        x, value = self.slid(x)
        while not self.budget.over:
            better = min(((self.missed(one), tuple(one)) for one in self._changed(x)), default=(np.inf, ()))
            if better[0] >= value - _BETTER:
                break
            x, value = self.slid(np.array(better[1]))
        return x, value

    def settled(self, x: FloatArray) -> FloatArray:
        """Near x, the worst limit missed no more: the next worst made least in turn, until the rest are met."""
        kept: dict[int, float] = {}
        for _ in self.program.limits:
            exact = self._exact(x, kept)
            here = exact.at(np.log(np.maximum(x, 1e-300)))
            if here.goal <= 0.0 or not exact.free.any() or self.budget.over:
                break
            kept |= {-1 - goal.part: here.goal for goal in here.goals if goal.value >= here.goal - _EVEN}
            if len(kept) == len(self.program.limits):
                break
            there, _ = self.slid(x, kept)
            moved = self._exact(there, kept).at(np.log(np.maximum(there, 1e-300)))
            x = there if moved.missed <= _EVEN and moved.goal < here.goal - _BETTER else x
        return x

    def _exact(self, x: FloatArray, kept: Mapping[int, float] | None = None) -> Missing:
        low, high = log_box(self.program)
        for i, axis in enumerate(self.program.axes):
            if axis.values is not None:
                low[i] = high[i] = np.log(max(x[i], 1e-300))
        return Missing(self.program, low, high, self.budget, kept={**self.kept, **(kept or {})})

    def slid(self, x: FloatArray, kept: Mapping[int, float] | None = None) -> tuple[FloatArray, float]:
        """Where the slopes of the limits that are missed most lead from x, and what is missed there."""
        exact, start = self._exact(x, kept), np.log(np.maximum(x, 1e-300))
        if not exact.free.any():
            return x, _goal(exact.at(start))
        point = Sqp(exact).run(np.clip(start, exact.low, exact.high))
        there = np.where(exact.free, np.exp(point.y), x)
        for i in np.flatnonzero(exact.free):
            axis = self.program.axes[i]
            there[i] = np.clip(there[i], axis.low, axis.high)
        return there, _goal(point)

    def _changed(self, x: FloatArray) -> Iterator[FloatArray]:
        """Designs with one part, or one value of a list, exchanged."""
        tied = {i for tie in self.program.ties for i in tie.axes}
        for tie in self.program.ties:
            for row in tie.table:
                yield _with(x, dict(zip(tie.axes, row, strict=True)))
        for i, axis in enumerate(self.program.axes):
            for value in axis.values or () if i not in tied else ():
                if value != x[i]:
                    yield _with(x, {i: value})


def _goal(point: Point) -> float:
    """What is to be made least; beyond all of it where a limit that is to hold does not."""
    return point.goal if point.missed <= _EVEN else BEYOND + point.missed


def _with(x: FloatArray, values: Mapping[int, float]) -> FloatArray:
    found = x.copy()
    for i, value in values.items():
        found[i] = value
    return found


def _snapped(program: Program, x: FloatArray) -> FloatArray:
    """The nearest values and parts that there are."""
    found = on_values(program, x)
    for tie in program.ties:
        found[list(tie.axes)] = tie.table[tie.chosen(found)]
    return found
