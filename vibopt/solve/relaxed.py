"""How much better any design could be: a bound beside what starts have led to, by boxes of several variables.

On a box every response at a sampled speed lies above a row that is linear in the logs of the variables
(`rows_on_boxes`).  With weights of the goal's rows that sum to one, and any weights of the limits', the least of their
sum on the box is a bound of the goal: what a linear program would say, of which any weights say no more than is true.
Boxes are split, those that promise most first, until none promises more than the gap or all are counted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field, replace

import numpy as np

from vibopt.arrays import FloatArray, IntArray
from vibopt.forms.rational import Sampled, sampled
from vibopt.forms.rows_on_boxes import Rows, coefficients, power_rows, response_rows
from vibopt.frontier import Frontier
from vibopt.program.program import Aim, Limit, Program
from vibopt.records import dataclass
from vibopt.solve.branch import first_speeds
from vibopt.solve.method import Found
from vibopt.work import Budget

NAME = "boxes"
_GAP = 1e-6
"""Part of the goal that an optimum may be away from its bound."""
_GROUPS, _FREE = 6, 6
"""Groups of impedances of a response, and variables, up to which boxes are looked at: each doubles the work."""
_WORK, _COST = 120_000, 0.02
"""Coefficients of responses on all boxes together, and the work of each of them [nominal ms]."""
_PATIENCE, _HOPELESS, _FIRST = 0.3, 2.0, 1000
"""Part of the boxes by which something must be known, the log within which it counts as such, and boxes that are
looked at before any search whether there is a design."""
_BATCH, _SPEEDS = 64, 48
_ROWS, _ROUNDS = 10, 6
"""Rows of the goal and of the limits that are weighed, and rounds of it."""
_NOTHING, _LONG = -1e3, 1e-9
"""A bound that is none, and the weight of the length of a side beside what its halves promise."""
_HOLDS = 1e-8
_FAR = 4.6
"""Log of a bound that says nothing."""


def with_least(program: Program, found: Found, known: float = float("nan")) -> Found:
    """An answer that starts have led to with what boxes prove about it: optimal, or how far from it at most.

    They are not looked at to the end where they soon promise no better bound than the one `known`.  Where nothing was
    found and no box may hold a design, that there is none.
    """
    aim = program.aim
    if found.status == "unproven":
        return none_holds(program) or found
    if found.status != "feasible" or found.x is None or aim is None or not _boundable(program, aim.pieces):
        return found
    value = max(piece.sense * piece.form.value(piece.model, found.x) for piece in aim.pieces)
    if not 0.0 < abs(value) < np.inf:
        return found
    boxes = _Relaxed(program, aim.pieces)
    boxes.learn(found.x)
    sign = float(np.sign(value))
    best = sign * float(np.log(abs(value)))
    floor = sign * float(np.log(abs(known))) if known * sign > 0.0 else -np.inf
    least = boxes.search(best + float(np.log1p(-_GAP)), max(floor, best - _HOPELESS))
    bound = sign * float(np.exp(sign * least))
    details = {**found.details, "boxes": boxes.budget.spent, "bound": bound}
    if best - least <= 1.01 * _GAP:
        claim = f"proven by {boxes.budget} of all variables: nothing is better by more than {_GAP:.0e} of the goal"
        return replace(found, status="optimal", claim=claim, bound=bound, details=details)
    part = 100.0 * abs(float(np.expm1(sign * (best - least))))
    if not best - least < _FAR:
        return found
    way = "above the least" if sign > 0.0 else "below the greatest"
    claim = f"{found.claim}; at most {_no_less(part)} % {way} possible"
    return replace(found, claim=claim, bound=bound, details=details)


def _no_less(percent: float) -> str:
    """Two digits of a number above zero, whole from ten on, rounded up: never less than what is true."""
    step = min(10.0 ** (np.floor(np.log10(percent)) - 1.0), 1.0)
    return f"{np.ceil(percent / step * (1.0 - 1e-12)) * step:.{max(0, round(-np.log10(step)))}f}"


def none_holds(program: Program, most: int = _WORK) -> Found | None:
    """That no design keeps all limits, where that many boxes prove it."""
    if not _boundable(program, program.limits):
        return None
    boxes = _Relaxed(program, (), most)
    if boxes.search(_HOLDS) < _HOLDS:
        return None
    claim = f"proven by boxes of all variables: every one of {boxes.budget} breaks a limit"
    return Found("infeasible", None, claim, NAME, details={"boxes": boxes.budget.spent})


def hopeless(program: Program) -> Found | None:
    """The same before a search from several starts, where few boxes show it."""
    return none_holds(program, _FIRST)


def _boundable(program: Program, asked: Sequence[Limit | Aim]) -> bool:
    """Whether boxes say anything of what is asked, of a few continuous variables from above zero to an end."""
    free = [a for a in program.axes if a.high > a.low]
    closed = all(a.values is None and a.low > 0.0 and not (a.open_low or a.open_high) for a in program.axes)
    if program.ties or not closed or not 0 < len(free) <= _FREE:
        return False
    every = all(isinstance(one, Limit) or _has_rows(one) for one in asked)
    return every and any(_has_rows(one) for one in asked)


def _has_rows(part: Limit | Aim) -> bool:
    form, powers = part.form.harmonic, part.form.powers
    most = part.sense > 0.0 if isinstance(part, Aim) else part.side == "at_most"
    if not isinstance(part, Aim) and not 0.0 < part.bound < np.inf:
        return False
    if powers is not None:
        return bool((powers.scale > 0.0).all()) and (most or (len(powers.scale) == 1 and part.least_wanted))
    if not most or form is None or form.line is None or form.output.shared_by or part.model.spins:
        return False
    return not form.endless and len(form.groups(part.model).members) <= _GROUPS


class _Relaxed:
    """The rows of a program on boxes, and the search with them; without goals, of limits that cannot hold together."""

    def __init__(self, program: Program, aims: Sequence[Aim], most: int = _WORK) -> None:
        self.program = program
        kept = [limit for limit in program.limits if _has_rows(limit)]
        self.goals: Sequence[Limit | Aim] = list(aims) or kept
        self.limits: Sequence[Limit] = kept if aims else []
        self.lines = {id(one): _Speeds(program, one) for one in (*self.goals, *self.limits) if one.form.powers is None}
        each = sum(line.count for line in self.lines.values()) or 1
        self.budget = Budget(min(most, max(_WORK // each, 1)), "boxes", _COST * each)

    def learn(self, x: FloatArray) -> None:
        """Look at the speeds at which the design x (n_vars,) is worst."""
        for line in self.lines.values():
            line.learn(x)

    def search(self, bar: float, floor: float = -np.inf) -> float:
        """No design has a goal whose log is below this, which is no greater than `bar`; given up far below `floor`."""
        frontier = Frontier(self.budget)
        frontier.add(np.array([-np.inf]), np.log(self.program.low)[None], np.log(self.program.high)[None])
        while frontier and not frontier.over:
            if frontier.bound < floor and self.budget.spent > _PATIENCE * self.budget.most:
                break
            known, low, high = frontier.take(_BATCH)
            if not (high > low).any():  # rounding leaves nothing to split
                frontier.add(known, low, high)
                break
            self.learn(np.exp(0.5 * (low + high)[0]))
            bound, low, high = self._split(known, low, high, bar)
            left = bound < bar
            frontier.add(bound[left], low[left], high[left])
        return min(frontier.bound, bar)

    def _split(
        self, known: FloatArray, low: FloatArray, high: FloatArray, bar: float
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Both halves of every box across the side whose halves promise least, with their bounds."""
        sides = np.flatnonzero((high > low).any(axis=0))
        halves = [_halves(low, high, np.full(len(low), side)) for side in sides]
        lows, highs = (np.stack(one, axis=1) for one in zip(*halves, strict=True))  # (2 n_boxes, n_sides, n_vars)
        bound = self.on(lows.reshape(-1, low.shape[1]), highs.reshape(-1, low.shape[1]))
        self.budget.spend(len(bound))
        bound = np.maximum(bound.reshape(len(low), 2, -1), known[:, None, None])
        merit = np.clip(bound, _NOTHING, bar).sum(axis=1) + _LONG * (high - low)[:, sides]
        best = merit.argmax(axis=1)
        rows, at = np.arange(2 * len(low)), np.repeat(best, 2)
        return bound.swapaxes(1, 2)[np.arange(len(low)), best].ravel(), lows[rows, at], highs[rows, at]

    def on(self, low: FloatArray, high: FloatArray) -> FloatArray:
        """Bound of the log of the goal on boxes of logs (n_boxes, n_vars), shape (n_boxes,)."""
        x, half = np.exp(0.5 * (low + high)), 0.5 * (high - low)
        goals = Rows.joined([self._rows(goal, x, half) for goal in self.goals]).highest(_ROWS)
        limits = [self._rows(limit, x, half) for limit in self.limits]
        return _weighed(goals, Rows.joined(limits).highest(_ROWS) if limits else None, half)

    def _rows(self, part: Limit | Aim, x: FloatArray, half: FloatArray) -> Rows:
        log = 0.0 if isinstance(part, Aim) else float(np.log(part.bound))
        powers = part.form.powers
        if powers is None:
            return response_rows(self.lines[id(part)].sampled, x, half).less(log)
        made = power_rows(powers.scale, powers.exponents, x, half).less(log)
        return made.falling() if part.least_wanted else made


@dataclass
class _Speeds:
    """A response at the speeds that are looked at [rad/s]."""

    program: Program
    part: Limit | Aim
    known: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._add([speed for one in first_speeds(self.part.form) for speed in one.values()])

    @property
    def count(self) -> int:
        """Coefficients of a response."""
        return coefficients(self.sampled)

    def learn(self, x: FloatArray) -> None:
        if len(self.known) < _SPEEDS:
            self._add([extreme.speeds[0] for extreme in self.part.extremes(x)])

    def _add(self, speeds: list[float]) -> None:
        fresh: list[float] = []
        for speed in speeds:
            if speed > 0.0 and all(abs(speed - old) > 1e-4 * speed for old in [*self.known, *fresh]):
                fresh.append(speed)
        form = self.part.form.harmonic
        if fresh and form is not None and form.line is not None:
            middle = np.sqrt(self.program.low * self.program.high)
            made = sampled(self.part.model, form.output, form.line, np.array(fresh), middle)
            self.sampled: Sampled = self.sampled.joined(made) if self.known else made
            self.known += fresh


def _weighed(goal: Rows, limits: Rows | None, half: FloatArray) -> FloatArray:
    """The greatest bound that a few rounds of weighing rows against each other find."""
    lows, boxes = goal.lows(half), np.arange(len(half))
    first = lows.argmax(axis=1)
    sums = _Sums(goal.value[boxes, first], goal.slope[boxes, first], lows[boxes, first])
    dead = np.zeros(len(half), dtype=bool) if limits is None else np.asarray((limits.lows(half) > _HOLDS).any(axis=1))
    for turn in range(_ROUNDS):
        mixed = limits is not None and turn % 2 == 1
        sums = sums.with_one(limits if mixed and limits is not None else goal, half, free=mixed)
    return np.asarray(np.where(dead, np.inf, sums.bound))


@dataclass(frozen=True, slots=True)
class _Sums:
    """A weighed sum of rows on each box, value (n_boxes,) and slope (n_boxes, n_vars), and the best bound so far."""

    value: FloatArray
    slope: FloatArray
    bound: FloatArray

    def with_one(self, rows: Rows, half: FloatArray, *, free: bool) -> _Sums:
        """The best sum with one row more: a share of both, or (`free`) any weight of the other on top.

        The bound bends where a part of the slope vanishes: the best is at one of those shares.
        """
        value, step = self.value[:, None], rows.slope if free else rows.slope - self.slope[:, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            share = -self.slope[:, None] / step
        share = np.where(np.isfinite(share) & (share > 0.0), share, 0.0)  # (n_boxes, n_rows, n_vars)
        share = share if free else np.minimum(share, 1.0)
        known = np.isfinite(rows.value) & np.isfinite(value)
        lift = np.where(known, rows.value - (0.0 if free else np.where(np.isfinite(value), value, 0.0)), 0.0)
        tilted = np.abs(self.slope[:, None, None] + share[..., None] * step[:, :, None]) * half[:, None, None]
        raised = np.where(known[..., None], value[..., None] + share * lift[..., None], -np.inf)
        flat = (raised - tilted.sum(axis=-1)).reshape(len(half), -1)
        best, boxes = flat.argmax(axis=1), np.arange(len(half))
        row, at = best // half.shape[1], best % half.shape[1]
        top = flat[boxes, best]
        part = np.where(top > self.bound, share[boxes, row, at], 0.0)
        moved = self.slope + part[:, None] * step[boxes, row]
        return _Sums(self.value + part * lift[boxes, row], moved, np.maximum(self.bound, top))


def _halves(low: FloatArray, high: FloatArray, side: IntArray) -> tuple[FloatArray, FloatArray]:
    """Boxes (n_boxes, n_vars) cut in two across a side of each."""
    rows = np.arange(len(low))
    first, second = high.copy(), low.copy()
    first[rows, side] = second[rows, side] = 0.5 * (low + high)[rows, side]
    lows, highs = np.stack([low, second], axis=1), np.stack([first, high], axis=1)
    return lows.reshape(-1, low.shape[1]), highs.reshape(-1, low.shape[1])


__all__ = ["hopeless", "with_least"]
