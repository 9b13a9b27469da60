"""The one frontier of every branch and bound: sets that are still open, those that promise most first.

A set is a row of columns: corners of boxes, places in lists, or any object.  A search goes

    frontier = Frontier(budget, progress, "branch and bound")
    frontier.add(np.array([-np.inf]), low, high)       # bounds (n,) [goal, to be minimised] and columns (n, ...)
    while frontier and not frontier.over:              # `over`: budget spent, or the user's time limit
        bounds, low, high = frontier.take(BATCH)       # the best ones; of equals those that were added first
        ...                                            # drop, measure, split
        budget.spend(len(bounds))
        frontier.add(...)                              # what is left of them
        frontier.keep(best - room)                     # and of the others, where that saves more than it takes
    frontier.bound                                     # no open set holds anything better; inf where none is open

or, for few sets that each take long, with `push(bound, item)` and `pop()`.  The order depends on bounds alone, never
on a clock, so the same question takes the same steps on any machine.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray, IntArray
from vibopt.work import Budget

Columns = tuple[np.ndarray[Any, Any], ...]
_FEW = 8
"""Times as many sets as are taken from which on they are not all sorted."""


class Frontier:
    """Open sets with their bounds.

    Parameters
    ----------
    budget
        What the search may look at; the search itself spends it.
    progress
        Told `stage` and the part that is spent, whenever it is asked whether the search is over.

    Attributes
    ----------
    bounds
        Of the open sets, in the order in which they came, shape (n,).
    """

    def __init__(
        self, budget: Budget, progress: Callable[[str, float], None] | None = None, stage: str = "search"
    ) -> None:
        self.budget, self.progress, self.stage = budget, progress, stage
        self.bounds: FloatArray = np.zeros(0)
        self.columns: Columns = ()

    def __len__(self) -> int:
        return len(self.bounds)

    @property
    def bound(self) -> float:
        """The least bound of an open set; inf where none is open."""
        return float(self.bounds.min(initial=np.inf))

    @property
    def over(self) -> bool:
        """Whether the search is to end with sets still open."""
        if self.progress is not None:
            self.progress(f"{self.stage}, {self.budget}", self.budget.part)
        return self.budget.over

    def add(self, bounds: FloatArray, *columns: np.ndarray[Any, Any]) -> None:
        """More sets: bounds (n,), and columns of the same length."""
        if not len(self.bounds):
            self.bounds, self.columns = bounds, columns
        elif len(bounds):
            self.bounds = np.concatenate([self.bounds, bounds])
            self.columns = tuple(np.concatenate(both) for both in zip(self.columns, columns, strict=True))

    def take(self, most: int) -> tuple[np.ndarray[Any, Any], ...]:
        """Bounds and columns of the best sets, at most so many, best first; they are open no longer."""
        chosen = self._best(most)
        taken = (self.bounds[chosen], *(column[chosen] for column in self.columns))
        self._leave(chosen)
        return taken

    def keep(self, bar: float) -> None:
        """Only sets with a bound below the bar stay open."""
        if not (good := self.bounds < bar).all():
            self.bounds, self.columns = self.bounds[good], tuple(column[good] for column in self.columns)

    def push(self, bound: float, item: object) -> None:
        """One set more, as any object."""
        column = np.empty(1, dtype=object)
        column[0] = item
        self.add(np.array([bound]), column)

    def pop(self) -> tuple[float, Any]:
        """Bound and object of the best set, which is open no longer."""
        bounds, items = self.take(1)
        return float(bounds[0]), items[0]

    def _best(self, most: int) -> IntArray:
        if len(self.bounds) <= _FEW * most:
            return np.asarray(np.argsort(self.bounds, kind="stable")[:most])
        level = np.partition(self.bounds, most - 1)[most - 1]
        below = np.flatnonzero(self.bounds < level)
        level_with = np.flatnonzero(self.bounds == level)[: most - len(below)]
        return np.concatenate([below[np.argsort(self.bounds[below], kind="stable")], level_with])

    def _leave(self, chosen: IntArray) -> None:
        left = np.ones(len(self.bounds), dtype=bool)
        left[chosen] = False
        self.bounds, self.columns = self.bounds[left], tuple(column[left] for column in self.columns)
