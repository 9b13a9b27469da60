"""Best first over sets of choices; sets that no limit or goal allows are dropped with the reason counted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field

import numpy as np

from vibopt.arrays import BoolArray, FloatArray, IntArray
from vibopt.forms.bounds import FormBounds
from vibopt.frontier import Frontier
from vibopt.program.program import Program
from vibopt.records import dataclass
from vibopt.solve.branch import SAFETY, Judge, first_speeds, may_hold
from vibopt.solve.catalogue.choices import Choices, Mirror, Node, factors_of, mirrors
from vibopt.solve.catalogue.pointwise import bounds_of, fails
from vibopt.work import Budget

LEAF = 1 << 16
"""Choices that are looked at one by one, but all at once."""
_BATCH = 4
_MOST_NODES = 100
"""Most Bernstein nodes of a form that is bounded on boxes."""
_QUICK_NODES, _MANY = 16, 20_000_000
"""Nodes up to which every row is asked by itself, and combinations from which on it is worth more nodes."""
_SAME = 1e-12
MOST_STEPS, COST = 50_000_000, 3e-4
"""Steps of a search; work of one [nominal ms]."""
_OF_SET, _OF_MEASURING = 200, 500
_REFRESH = 200_000
"""Most choices in waiting that are filtered again as soon as a speed has been learnt."""


@dataclass(frozen=True, slots=True)
class Pick:
    """A choice that meets every limit, measured.

    entries
        Entry of each factor.
    goal
        In the sense to be minimised.
    tightest, margin
        The limit with the least margin, and that margin as a part of its bound.
    """

    entries: tuple[int, ...]
    x: FloatArray
    goal: float
    tightest: str
    margin: float

    @property
    def rank(self) -> tuple[float, tuple[int, ...]]:
        """Less is better; choices with the same goal in the order of the tables."""
        size = float(f"{self.goal:.12g}") if np.isfinite(self.goal) else self.goal
        return size, self.entries


@dataclass
class Tally:
    """How many choices were dropped by what.

    limits
        Per limit of the program.
    rows
        Per factor, shape (n_entries, n_limits): dropped choices that have the entry.
    mirrors
        Groups that may be exchanged; a row's dropped choices include the mirror images.
    mirrored, measured
        Mirror images of others; choices measured exactly.
    """

    limits: FloatArray
    rows: list[FloatArray]
    mirrors: list[Mirror] = field(default_factory=list)
    mirrored: int = 0
    measured: int = 0
    nodes: int = 0

    def node(self, node: Node, limit: int, *, alike: bool = False) -> None:
        """A whole set dropped by one limit; `alike` where the mirror image of the set is dropped too."""
        self.limits[limit] += node.size
        if self.mirrors and not alike:  # of its choices some are mirror images of those of other sets
            return
        for table, entries in zip(self.rows, node.entries, strict=True):
            table[entries, limit] += node.size / len(entries)

    def each(self, chosen: IntArray, limit: int) -> None:
        """Single choices (n, n_factors) dropped by one limit."""
        self.limits[limit] += len(chosen)
        for image in (chosen, *(mirror.images(chosen) for mirror in self.mirrors)):
            for index, table in enumerate(self.rows):
                table[:, limit] += np.bincount(image[:, index], minlength=len(table))


@dataclass
class Search:
    """One search.

    keep
        How many of the best choices are proven.
    looked
        Choices looked at one by one.
    budget
        Steps after which the search stops without proof: one a choice, more a set or an exact measurement.
    """

    program: Program
    keep: int = 10
    budget: Budget = field(default_factory=lambda: Budget(MOST_STEPS, "steps", COST))
    progress: Callable[[str, float], None] | None = None
    best: list[Pick] = field(default_factory=list)
    stopped: bool = False
    looked: int = 0

    def __post_init__(self) -> None:
        program = self.program
        self.judge = Judge(program)
        self.choices = Choices(factors_of(program), len(program.axes))
        self.total = self.choices.root.size
        middle = np.where(program.low > 0.0, np.sqrt(np.maximum(program.low, 1e-300) * program.high), program.high)
        middle = np.where(middle > 0.0, middle, 1.0)
        self.limits = [bounds_of(limit.model, limit.form, middle) for limit in program.limits]
        aims = program.aim.pieces if program.aim is not None else ()
        self.aims = [bounds_of(aim.model, aim.form, middle) for aim in aims]
        for form_bounds in (*self.limits, *self.aims):
            form_bounds.add(first_speeds(form_bounds.form))
        self.order = sorted(range(len(self.limits)), key=lambda i: _cost(self.limits[i]))
        self.boxed = [_boxed(limit) for limit in self.limits]
        self.aim_boxed = [_boxed(aim) for aim in self.aims]
        self.mirrors = [] if program.several else mirrors(program, self.choices)
        rows = [np.zeros((len(factor.table), len(self.limits))) for factor in self.choices.factors]
        self.tally = Tally(np.zeros(len(self.limits)), rows, self.mirrors)
        self._weight = np.ones(len(program.axes))

    def run(self) -> None:
        """Search until the best are proven, or the budget is spent."""
        sets = Frontier(self.budget, self.progress, "catalogue")
        for node in self._presolved(self.choices.root):
            sets.push(-np.inf, node)
        goals, waiting = np.zeros(0), np.zeros((0, len(self.choices.factors)), dtype=int)
        while sets or len(waiting):
            if sets.over:
                self.stopped = True
                return
            first = sets.bound
            if min(first, goals[0] if len(goals) else np.inf) > self._bar:
                return
            if len(goals) and goals[0] < first:
                goals, waiting = self._measure(goals, waiting, first)
                continue
            _, node = sets.pop()
            self.tally.nodes += 1
            self.budget.spend(_OF_SET)
            if node.size <= LEAF:
                goals, waiting = _merged((goals, waiting), self._leaf(node))
                continue
            for part in self.choices.halves(node, self._weight):
                bound = self._bound(part)
                if bound <= self._bar:
                    sets.push(bound, part)

    @property
    def _bar(self) -> float:
        """A goal above this is not among the best."""
        if self.program.aim is None:
            return -np.inf if self.best else np.inf
        if len(self.best) < self.keep:
            return np.inf
        last = self.best[-1].goal
        return last + _SAME * abs(last)

    def _presolved(self, root: Node) -> list[Node]:
        """Rows that break a limit whatever goes with them are taken out first."""
        node = root
        for index in range(len(self.choices.factors)):
            for i in self.order:
                quick = not self.limits[i].form.drives or _nodes(self.limits[i]) <= _QUICK_NODES
                if not self.boxed[i] or not node.size or not (quick or self.total > _MANY):
                    continue  # to ask it of every row by itself saves less than it takes
                low, high = self.choices.singles(node, index)
                good = self._may_hold(i, low, high)
                if not good.all():
                    self.tally.node(self.choices.kept(node, index, ~good), i, alike=True)
                    node = self.choices.kept(node, index, good)
        return [node] if node.size else []

    def _may_hold(self, i: int, low: FloatArray, high: FloatArray) -> BoolArray:
        parts = [
            may_hold(self.program.limits[i], self.limits[i], low[at : at + 64], high[at : at + 64])
            for at in range(0, len(low), 64)
        ]
        return np.concatenate(parts)

    def _bound(self, node: Node) -> float:
        """Bound of the goal on a set; infinite where a limit is broken on all of it."""
        low, high = (one[None, :] for one in self.choices.hull(node))
        for i in self.order:
            if self.boxed[i] and not self._may_hold(i, low, high)[0]:
                self.tally.node(node, i)
                return np.inf
        aim = self.program.aim
        if aim is None:
            return -np.inf
        bound = -np.inf
        for form_bounds, boxed in zip(self.aims, self.aim_boxed, strict=True):
            if boxed:
                lower, upper = form_bounds.on(low, high)
                bound = max(bound, float(lower[0] if aim.sense > 0 else -upper[0]))
        return bound - SAFETY * abs(bound) if np.isfinite(bound) else -np.inf

    def _goals(self, x: FloatArray) -> FloatArray:
        """Lower bound of the goal at designs, in the sense to be minimised."""
        aim = self.program.aim
        if aim is None:
            return np.zeros(len(x))
        bound = np.full(len(x), -np.inf)
        for form_bounds in self.aims:
            most, least = form_bounds.at(x)
            value = most if aim.sense > 0 else -least
            value = np.where(np.isfinite(value), value - form_bounds.slack * np.abs(value), value)
            bound = np.maximum(bound, np.nan_to_num(value, nan=-np.inf, posinf=np.inf, neginf=-np.inf))
        return bound

    def _leaf(self, node: Node) -> tuple[FloatArray, IntArray]:
        """Choices of a small set that may be among the best, with the bound of their goal, best first."""
        chosen = self.choices.all_in(node)
        self.looked += len(chosen)
        self.budget.spend(len(chosen))
        for mirror in self.mirrors:
            kept = mirror.first(chosen)
            self.tally.mirrored += int((~kept).sum())
            chosen = chosen[kept]
        chosen = self._filtered(chosen)
        return self._best_first(chosen)

    def _best_first(self, chosen: IntArray) -> tuple[FloatArray, IntArray]:
        """Choices that may be among the best, with the bound of their goal."""
        goals = self._goals(self.choices.designs(chosen))
        kept = goals <= self._bar
        return _sorted(goals[kept], chosen[kept])

    def _filtered(self, chosen: IntArray, *, moving: bool = False) -> IntArray:
        """Choices that no limit is known to forbid; with `moving` only limits with speeds are asked again."""
        x = self.choices.designs(chosen)
        for i in self.order:
            if not len(chosen):
                break
            if moving and not self.limits[i].form.drives:
                continue
            broken = fails(self.program.limits[i], self.limits[i], x) > 0.0
            if broken.any():
                self.tally.each(chosen[broken], i)
                chosen, x = chosen[~broken], x[~broken]
        return chosen

    def _measure(self, goals: FloatArray, waiting: IntArray, first: float) -> tuple[FloatArray, IntArray]:
        """Measure the most promising choices; what their worst speeds teach is asked of the others."""
        taken = min(_BATCH, int((goals < first).sum()))
        learnt = False
        for entries in waiting[:taken]:
            learnt |= self._offer(entries)
        goals, waiting = goals[taken:], waiting[taken:]
        if learnt and len(waiting) <= _REFRESH:
            return self._best_first(self._filtered(waiting, moving=True))
        return goals, waiting

    def _offer(self, entries: IntArray) -> bool:
        """Measure one choice; whether a speed was learnt from it."""
        x = self.choices.designs(entries[None, :])[0]
        self.tally.measured += 1
        self.budget.spend(_OF_MEASURING)
        learnt, margin, tightest = False, np.inf, ""
        for i in self.order:
            missed, worst = self.judge.limit(self.program.limits[i], x)
            learnt |= self.limits[i].add(worst.speeds)
            if missed > self.judge.tolerance:
                self.tally.each(entries[None, :], i)
                return learnt
            if -missed < margin:
                margin, tightest = -missed, self.program.limits[i].name
        goal = self.judge.goal(x)
        for aim in self.aims:
            learnt |= aim.add(goal.speeds)
        self.best.append(Pick(tuple(int(entry) for entry in entries), x, goal.value, tightest, float(margin)))
        self.best.sort(key=lambda pick: pick.rank)
        del self.best[self.keep :]
        return learnt


def _cost(values: FormBounds) -> tuple[int, int]:
    """Cheap and telling limits first."""
    return values.form.rank + 20 * (not values.known), values.model.n_free


def _boxed(values: FormBounds) -> bool:
    """Whether a form has bounds on boxes that are cheap enough."""
    return values.bounded and _nodes(values) <= _MOST_NODES


def _nodes(values: FormBounds) -> int:
    """Number of Bernstein nodes of a form with polynomials."""
    groups = values.form.groups(values.model)
    return 1 if groups is None else int(np.prod([degree + 1 for degree in groups.degrees], initial=1))


def _sorted(goals: FloatArray, chosen: IntArray) -> tuple[FloatArray, IntArray]:
    order = np.lexsort((*chosen.T[::-1], goals))
    return goals[order], chosen[order]


def _merged(one: tuple[FloatArray, IntArray], other: tuple[FloatArray, IntArray]) -> tuple[FloatArray, IntArray]:
    return _sorted(np.concatenate([one[0], other[0]]), np.concatenate([one[1], other[1]]))
