"""Interval branch and bound: proves an optimum with its gap, or that no design exists.

Boxes of designs are dropped when a limit is broken on all of the box (a polynomial inequality at
one sampled speed, by Bernstein coefficients) or when nothing on it beats the best design known by
more than the gap.  Speeds are added where the exact measurement of a box's middle shows the worst.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field
from typing import TYPE_CHECKING

import numpy as np

from vibopt.answer.entry import TOLERANCE
from vibopt.arrays import BoolArray, FloatArray
from vibopt.forms import Form, Monomials
from vibopt.forms.form import Worst
from vibopt.mechanics.modes import natural_frequencies
from vibopt.program.program import Aim, Limit, Program
from vibopt.records import cached_property, dataclass
from vibopt.solve.ranges import on_values
from vibopt.work import Budget, worked

if TYPE_CHECKING:
    from vibopt.forms.bounds import FormBounds

BATCH, _STEP = 256, 1.5
"""Boxes of a step at most, and its work [nominal ms]."""
MOST_BOXES, MOST_WORK = 100_000, 200_000_000
ZERO = 1e-12
"""Part of the greatest amplitude met below which an amplitude is zero."""
_LISTS_FIRST = 1e3
"""How much wider than a range a list counts: boxes of several values are loose, and there are few of them."""
SAFETY = 1e-10
"""Part of a bound that rounding may take; a box must fail by more than this to be dropped."""


@dataclass(frozen=True, slots=True)
class Proof:
    """Outcome of the search.

    status
        "optimal", "infeasible" or "open" (stopped before the end).
    x
        Best design found, shape (n_vars,); None where there is none.
    value
        Its goal, in the sense to be minimised.
    bound
        No design is better than this.
    boxes
        Number of boxes looked at.
    """

    status: str
    x: FloatArray | None
    value: float
    bound: float
    boxes: int


@dataclass
class Judge:
    """Exact feasibility and goal at single designs, and the speeds at which limits are worst."""

    program: Program
    tolerance: float = TOLERANCE

    def limit(self, limit: Limit, x: FloatArray) -> tuple[float, Worst]:
        """Violation as a part of the bound (negative when met), and the worst."""
        worked(limit.cost)
        worst = limit.worst(x)
        return violation(limit, worst.value, x), worst

    def ahead(self, x: FloatArray) -> None:
        """Measure at once at designs x (n, n_vars), one or more, what takes less for many together."""
        with np.errstate(all="ignore"):
            for part in self.program.parts if len(x) else ():
                part.form.ahead(part.model, x)

    def goal(self, x: FloatArray) -> Worst:
        """Goal to be minimised at x, with the speeds of its worst; 0 without a goal."""
        aim = self.program.aim
        if aim is None:
            return Worst(0.0)
        worked(sum(piece.cost for piece in aim.pieces))
        found = [piece.worst(x) for piece in aim.pieces]
        first = max(found, key=lambda worst: aim.sense * worst.value)
        return Worst(aim.sense * first.value, first.speeds)

    def vanishes(self, x: FloatArray) -> bool:
        """Whether an amplitude to be made small is at x (n_vars,) what is left of greater ones that cancel."""
        from vibopt.verify.routes import cancels

        aim = self.program.aim
        if aim is None or aim.sense < 0 or not aim.form.drives:
            return False
        for piece in aim.pieces:
            form = piece.form.harmonic
            if form is not None and not cancels(piece.model, form, x, piece.worst(x)):
                return False
        return True

    def feasible(self, x: FloatArray) -> bool:
        return all(self.limit(limit, x)[0] <= self.tolerance for limit in self.program.limits)


def violation(limit: Limit, value: float, x: FloatArray) -> float:
    """How far a value misses its bound, as a part of the bound; negative when it is met."""
    return _inside_band(limit, x) if limit.side == "outside" else limit.missed(value)


def _inside_band(limit: Limit, x: FloatArray) -> float:
    """Depth of the deepest mode inside the band, as a part of the band's lower end."""
    modes = natural_frequencies(limit.model, limit.model.values(x))
    return float(np.minimum(modes - limit.bound, limit.upper - modes).max()) / max(limit.bound, 1e-300)


@dataclass
class Search:
    """State of one branch and bound.

    judge
        Exact evaluation.
    gap
        Part of the goal by which the proven bound may be away from the best design.
    budget
        Boxes of all runs together, after which the search stops.
    patience
        Boxes after which it stops when no design has been found at all.
    work
        Coefficients on all boxes together, after which it stops too: boxes of many speeds and powers take longer.
    """

    judge: Judge
    gap: float = 1e-9
    budget: Budget = field(default_factory=lambda: Budget(MOST_BOXES, "boxes"))
    progress: Callable[[str, float], None] | None = None
    patience: int = MOST_BOXES
    work: Budget = field(default_factory=lambda: Budget(MOST_WORK, "coefficients"))
    greatest: float = 0.0
    forms: list[FormBounds] = field(default_factory=list)
    aim_bounds: list[FormBounds] = field(default_factory=list)
    best_x: FloatArray | None = None
    best: float = np.inf

    @property
    def each(self) -> int:
        """Coefficients of one box at the speeds known."""
        if not self.forms and not self.aim_bounds:
            self._prepare()
        return sum(bounds.work for _, bounds in self._parts())

    def run(self, start: FloatArray | None = None) -> Proof:
        """Search the whole box; `start` (n_vars,) is a feasible design to beat."""
        from vibopt.frontier import Frontier

        if not self.forms and not self.aim_bounds:
            self._prepare()
        self.best_x, self.best = None, np.inf
        if start is not None:
            self._offer(start)
        program = self.judge.program
        low, high = np.array([program.low, program.high], dtype=float)[:, None, :]
        self.open = Frontier(self.budget, self.progress, "branch and bound")
        self.open.add(np.full(len(low), -np.inf), low, high)
        looked = 0
        while self.open:
            waiting = not np.isfinite(self.best) and looked > self.patience
            if waiting or self.open.over or self.work.over:
                dropped = self.best - self._room() if np.isfinite(self.best) else np.inf
                return Proof("open", self.best_x, self.best, min(self.open.bound, dropped), looked)
            each = self.each
            count = self._step(min(BATCH, max((self.work.most - self.work.spent) // max(each, 1), 1)))
            looked += count
            self.budget.spend(count)
            self.work.spend(count * each)
            if self.best == -np.inf:
                return Proof("optimal", self.best_x, self.best, self.best, looked)
            if self.judge.program.aim is None and self.best_x is not None:
                return Proof("optimal", self.best_x, 0.0, 0.0, looked)
            if self.vanishes():
                return Proof("optimal", self.best_x, self.best, 0.0, looked)
        if self.best_x is None:
            return Proof("infeasible", None, np.inf, np.inf, looked)
        return Proof("optimal", self.best_x, self.best, self.best - self._room(), looked)

    def vanishes(self) -> bool:
        """Whether the goal is an amplitude to be made least, and is zero up to rounding: it cannot be less."""
        small = self.best_x is not None and self.best <= ZERO * self.greatest
        return small and self.best_x is not None and self.judge.vanishes(self.best_x)

    def open_middles(self, count: int) -> FloatArray:
        """Middles of boxes that were left open, spread over them, shape (at most count, n_vars)."""
        low, high = self.open.columns
        picks = np.linspace(0, len(low) - 1, min(count, len(low))).astype(int)
        return _middle(low[picks], high[picks])

    def _prepare(self) -> None:
        from vibopt.forms.bounds import FormBounds

        program = self.judge.program
        middle = _middle(program.low, program.high)
        self.forms = [FormBounds(limit.model, limit.form, middle) for limit in program.limits]
        aims = program.aim.pieces if program.aim is not None else ()
        self.aim_bounds = [FormBounds(aim.model, aim.form, middle) for aim in aims]
        for part, bounds in self._parts():
            bounds.add(first_speeds(part.form))

    def _parts(self) -> list[tuple[Limit | Aim, FormBounds]]:
        parts: list[tuple[Limit | Aim, FormBounds]] = list(zip(self.judge.program.limits, self.forms, strict=True))
        if self.judge.program.aim is not None:
            parts += zip(self.judge.program.aim.pieces, self.aim_bounds, strict=True)
        return parts

    def _untold(self, goal: FloatArray) -> BoolArray:
        """Boxes that bounds say nothing of, (n_boxes,): single designs among them are told apart by measuring alone."""
        blind, aim = not all(bounds.bounded for _, bounds in self._parts()), self.judge.program.aim
        if blind or aim is None:
            return np.full(len(goal), blind)
        least: BoolArray = goal <= (0.0 if aim.sense > 0 else -np.inf)
        return least

    def _room(self) -> float:
        return self.gap * max(abs(self.best), 1e-300)

    def _step(self, most: int) -> int:
        """Look at the best open boxes, at most so many, and split what is left of them; how many there were.

        A box that is a single design is measured, and settled by that; until then it waits as it is.
        """
        worked(_STEP)
        _, low, high = self.open.take(most)
        count = len(low)
        low, high = self._listed(*self._contract(low, high))
        alive, goal = self._judge_boxes(low, high)
        low, high, goal = low[alive], high[alive], goal[alive]
        if len(low):
            single = (low == high).all(axis=1)
            tried = single & self._untold(goal)
            tried[np.argsort(goal, kind="stable")[:3]] = True
            for index in tried.nonzero()[0]:
                self._offer(on_values(self.judge.program, _middle(low[index], high[index])))
            kept = goal < self.best - self._room() if np.isfinite(self.best) else np.ones(len(goal), dtype=bool)
            left = kept & single & ~tried
            self.open.add(goal[left], low[left], high[left])
            kept &= ~single
            low, high, goal = low[kept], high[kept], goal[kept]
            for _ in range(3 if len(low) <= 24 else 1):
                low, high, goal = self._split(low, high, goal)
        self.open.add(goal, low, high)
        return count

    def _contract(self, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Cut off the part of each box on which the goal itself, a sum of powers, cannot beat the best."""
        aim = self.judge.program.aim
        form = aim.form.powers if aim is not None else None
        if aim is None or form is None or not np.isfinite(self.best) or aim.others:
            return low, high
        if (form.exponents < 0.0).any() or ((form.exponents != 0.0).sum(axis=1) > 1).any():
            return low, high
        cut = aim.sense * (self.best - self._room())
        return _cut_sum(form, low, high, cut, below=aim.sense > 0)

    def _listed(self, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Boxes from the first to the last listed value within them; without those that hold none."""
        for i, values in self._lists:
            first, last = np.searchsorted(values, low[:, i]), np.searchsorted(values, high[:, i], side="right") - 1
            some = first <= last
            low, high, first, last = low[some].copy(), high[some].copy(), first[some], last[some]
            low[:, i], high[:, i] = values[first], values[last]
        return low, high

    @cached_property
    def _lists(self) -> list[tuple[int, FloatArray]]:
        """Variables that are chosen from a list, and its values in order."""
        axes = enumerate(self.judge.program.axes)
        return [(i, np.unique(axis.values)) for i, axis in axes if axis.values is not None]

    def _judge_boxes(self, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Which boxes may still hold a better design, and the bound of the goal on each."""
        alive = np.ones(len(low), dtype=bool)
        goal = np.full(len(low), -np.inf)
        aim = self.judge.program.aim
        if aim is not None:
            for bounds in self.aim_bounds:
                lower, upper = bounds.on(low, high)
                goal = np.maximum(goal, lower if aim.sense > 0 else -upper)
            if np.isfinite(self.best):
                alive &= goal < self.best - self._room()
        for limit, bounds in zip(self.judge.program.limits, self.forms, strict=True):
            if alive.any():
                alive[alive] = may_hold(limit, bounds, low[alive], high[alive])
        return alive, goal

    def _offer(self, x: FloatArray) -> None:
        x = np.array(x, dtype=float)
        good = True
        for limit, bounds in zip(self.judge.program.limits, self.forms, strict=True):
            missed, worst = self.judge.limit(limit, x)
            bounds.add(worst.speeds)
            good = good and missed <= self.judge.tolerance
        goal = self.judge.goal(x)
        if np.isfinite(goal.value):
            self.greatest = max(self.greatest, goal.value)
        for bounds in self.aim_bounds:
            bounds.add(goal.speeds)
        if good and (goal.value < self.best or self.best_x is None):
            self.best, self.best_x = goal.value, x

    def _split(self, low: FloatArray, high: FloatArray, goal: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Halve every box along its relatively widest side, lists first; single designs stay as they are."""
        program = self.judge.program
        least = np.maximum(program.high * 1e-12, 1e-300)
        whole = np.log(np.maximum(program.high, 1e-300)) - np.log(np.maximum(program.low, least))
        width = np.log(np.maximum(high, 1e-300)) - np.log(np.maximum(low, least))
        width = np.where(low < high, width / np.where(whole > 0, whole, 1.0), -1.0)
        width[:, [i for i, _ in self._lists]] *= _LISTS_FIRST
        side = width.argmax(axis=1)
        rows = np.arange(len(low))
        first_high, second_low = high.copy(), low.copy()
        first_high[rows, side] = second_low[rows, side] = _middle(low[rows, side], high[rows, side])
        for i, values in self._lists:  # between two of them
            at = np.flatnonzero((side == i) & (low[:, i] < high[:, i]))
            behind = np.searchsorted(values, second_low[at, i], side="right")
            behind = np.minimum(behind, np.searchsorted(values, high[at, i]))
            first_high[at, i], second_low[at, i] = values[behind - 1], values[behind]
        two = np.repeat(width.max(axis=1) >= 0.0, 2)
        two[::2] = True
        pairs = (
            np.stack(one, axis=1).reshape(-1, low.shape[1])[two] for one in ((low, second_low), (first_high, high))
        )
        return *pairs, np.repeat(goal, 2)[two]


def _cut_sum(
    form: Monomials, low: FloatArray, high: FloatArray, cut: float, *, below: bool
) -> tuple[FloatArray, FloatArray]:
    """Boxes narrowed to where sum_j scale_j x_i(j)**e_j can be below (above) `cut`; never made empty."""
    low, high = low.copy(), high.copy()
    small, large = form.extent(low, high)
    for scale, exponents in zip(form.scale, form.exponents, strict=True):
        if not exponents.any():
            continue
        i = int(np.flatnonzero(exponents)[0])
        power = exponents[i]
        own = scale * (low[:, i] if below else high[:, i]) ** power
        rest = (small if below else large) - own
        edge = (np.maximum(cut - rest, 0.0) / scale) ** (1.0 / power)
        if below:
            high[:, i] = np.clip(edge * (1.0 + 1e-15), low[:, i], high[:, i])
        else:
            low[:, i] = np.clip(edge * (1.0 - 1e-15), low[:, i], high[:, i])
    return low, high


def may_hold(limit: Limit, bounds: FormBounds, low: FloatArray, high: FloatArray) -> BoolArray:
    """Boxes on which the limit is not proven to be broken, shape (n_boxes,)."""
    if limit.side == "outside":
        return _may_avoid(limit, low, high)
    if not bounds.bounded:
        return np.ones(len(low), dtype=bool)
    lower, upper = bounds.on(low, high)
    if limit.side == "at_most":
        fine: BoolArray = lower <= limit.bound * (1.0 + SAFETY) + (0.0 if limit.bound else 1e-300)
        return fine
    return upper >= limit.bound * (1.0 - SAFETY)


def _may_avoid(limit: Limit, low: FloatArray, high: FloatArray) -> BoolArray:
    """Boxes on which no mode is proven to lie inside the forbidden band."""
    from vibopt.forms.undamped import frequencies_on

    free = np.ones(len(low), dtype=bool)
    for mode in range(limit.model.n_free):
        lower, upper = frequencies_on(limit.model, low, high, mode)
        free &= ~((lower > limit.bound * (1 + SAFETY)) & (upper < limit.upper * (1 - SAFETY)))
    return free


def first_speeds(form: Form) -> dict[str, list[float]]:
    """Speeds to begin with, by excitation: the ends of every band and a few between."""
    found: dict[str, list[float]] = {}
    for drive in form.drives:
        own = found.setdefault(drive.name, [])
        for band in drive.bands:
            parts = [band.low] if band.is_point else np.linspace(band.low, band.high, 9).tolist()
            own += [speed for speed in parts if speed > 0.0 or band.is_point]
    return found


def _middle(low: FloatArray, high: FloatArray) -> FloatArray:
    """Geometric middle where the range spans more than a factor four, arithmetic elsewhere."""
    floor = np.maximum(low, high * 1e-6)
    geometric = np.sqrt(floor * high)
    middle: FloatArray = np.where(high > 4.0 * floor, geometric, 0.5 * (low + high))
    return middle
