"""Branch and bound on tangents: proves designs whose peaks in time are limited or made least.

On a box of designs every limit and the goal are no less than some tangents less their rests (what is to be great is no
more than a plane above its corners and a rest), or than the bounds on boxes that what has no tangents has (responses at
speeds).  A box is dropped where their linear program shows that no design in it keeps all limits and is better than the
best known by more than the gap.
The rests are of second order in the size of the box, and so the boxes that are left do not multiply around the optimum.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import field

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.cones import LINEAR, solve_cones
from vibopt.errors import counted
from vibopt.forms.bounds import FormBounds
from vibopt.forms.tangent import Tangent
from vibopt.frontier import Frontier
from vibopt.program.program import Aim, Limit, Program
from vibopt.records import dataclass
from vibopt.solve.branch import SAFETY, Judge, first_speeds, may_hold
from vibopt.solve.local import improved, refined
from vibopt.solve.method import Found, Progress
from vibopt.solve.nlp import Nlp
from vibopt.solve.proportional import reaching, towards
from vibopt.solve.ranges import starts
from vibopt.solve.screen import best_of_many
from vibopt.work import Budget, metered

_AT_ONCE, _DEEP = 32, 3
"""Boxes that are looked at side by side; how often one is halved at once where they are few."""
_STARTS, _FIRST, _SOME = 4, 8, 500
"""Starts of descents, and boxes that are looked at before the first of them and, without a goal, before the second:
where none holds a design, no descent finds one."""
_GIVEN = 6
"""Starts beside those all over the ranges where boxes are used up: the best of many designs, for peaks in time have
many valleys."""
_BOX, _LONG, _SEARCHED = 1.5, 1e4, 1.5e4
"""Work of a box beside its measurements and tangents, of all boxes at most, and of all designs that are measured by a
search, or followed, beside them [nominal ms]."""
_BETTER = 1e-3
"""Part of the goal by which the middle of a box must be better to be sharpened."""
_KNOWN, _APART = 3, 0.01
"""Times of a peak that are kept for the boxes that follow, and the part of itself by which they must differ."""
_TRIED, _LEFT = 1.0 / 3.0, 0.9
"""Part of all boxes that are looked at in any case, and boxes left for each of them from which on others say no more
where nothing is known of the goal."""
_FEWEST = 40
"""Measurements that those starts may take, where each is dear."""
_FAR = 0.5
"""Part of a floor lost for one variable from which on tangents say no more."""
_SLACK = 4.0
"""Reaches of a box, in parts of its bound, by which a limit is kept that says nothing there."""
_WIDE = 4.0
"""A side whose ends are further apart than this factor is halved in logarithms."""


class Tangents:
    """Branch and bound on tangents of peaks in time."""

    name = "tangents"
    summary = "branch and bound on tangents of peaks in time, each with a bound of what it leaves out"

    def __init__(
        self, gap: float = 1e-6, most: int = 1500, near: Sequence[float] | None = None, *, enough: float = 0.0
    ) -> None:
        """`enough` is the gap with which no other starts are tried where boxes are used up."""
        self.gap = gap
        self.most = most
        self.near = near
        self.enough = enough

    def refuses(self, program: Program) -> str | None:
        if program.ties or any(axis.values is not None for axis in program.axes):
            return "it takes continuous variables alone."
        most = min((part.form.tangents_up_to for part in program.parts), default=0)
        if not 1 <= len(program.axes) <= most:
            return f"{len(program.axes)} continuous variables are not 1 to {most}."
        loose = next((part for part in program.parts if not _bounded(part, program)), None)
        if loose is not None:
            return f"{loose.name} {loose.form.no_bounds}."
        timed = any(part.form.tangents_of and part.form.powers is None for part in program.parts)
        return None if timed else "no peak in time is asked for."

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """Status "optimal" with `bound`, "infeasible", or "feasible" and "unproven" where the boxes are used up."""
        return _Search(program, progress, self).answer()


def _sign(part: Limit | Aim) -> float:
    """With which a part is a form that is to be small."""
    return part.sense if isinstance(part, Aim) else -1.0 if part.side == "at_least" else 1.0


def _bounded(part: Limit | Aim, program: Program) -> bool:
    return _tangible(part) or FormBounds(part.model, part.form, program.high).bounded


def _tangible(part: Limit | Aim) -> bool:
    known = _sign(part) in part.form.tangents_of or _majorised(part)
    return known and not (isinstance(part, Limit) and part.side == "outside")


def _majorised(part: Limit | Aim) -> bool:
    """Whether it is a peak that is to be great."""
    return _sign(part) < 0.0 and part.form.majorised(part.model)


@dataclass
class _Part:
    """A limit or the goal with tangents: sign * (form - bound) / size, and times or durations of the greatest [s]."""

    of: Limit | Aim
    bound: float
    size: float
    times: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.floors = self.of.form.floors(self.of.model) if _sign(self.of) > 0.0 else None
        self.majorised = _majorised(self.of)

    @property
    def cost(self) -> float:
        """Work of its tangents on a box [nominal ms]; those of what is to be great measure each corner."""
        form, model = self.of.form, self.of.model
        corners = 2 ** int(model.exponents.any(axis=1).sum()) if self.majorised else 0
        return form.tangents_cost(model) + corners * form.cost(model)

    def learn(self, x: FloatArray) -> None:
        """Keep the time of the peak at a design, or the duration at which it is greatest."""
        time = self.of.form.greatest_at(self.of.model, x)
        if time is not None and np.isfinite(time):
            self.times = [time, *(other for other in self.times if abs(time - other) > _APART * other)][:_KNOWN]

    def far(self, boxes: Sequence[_Box]) -> list[_Box]:
        """Boxes on which a limit is kept by so much in the middle that hardly any corner comes near its bound."""
        if not boxes or self.of.form.searched:  # whose values take more work than its tangents
            return []
        values = self.of.form.values(self.of.model, np.array([box.x for box in boxes]))
        missed = _sign(self.of) * (values - self.bound) / self.size
        return [box for box, one in zip(boxes, missed, strict=True) if one < -_SLACK * box.reach.max()]

    def tangents(self, boxes: Sequence[_Box], level: float) -> Iterator[tuple[_Box, list[Tangent]]]:
        """Each box, and what is known there."""
        if not boxes:
            return
        x, reach = (np.array(column) for column in zip(*((one.x, one.reach) for one in boxes), strict=True))
        form, model, sign = self.of.form, self.of.model, _sign(self.of)
        if self.majorised:
            many = form.majorants(model, x, reach)
        else:
            many = [[one.signed(sign) for one in some] for some in form.tangents(model, x, reach, level, self.times)]
        for box, some in zip(boxes, many, strict=True):
            yield box, [tangent.scaled(sign * self.bound, self.size) for tangent in some]


@dataclass(eq=False)
class _Box:
    """Designs x (1 + s), |s| <= reach, with what is known of their limits (at most 0 where kept) and of their goal.

    The goal is no less than `floor`; `lost` (n_vars,) is about what part of floors is lost for each variable's sake.
    """

    low: FloatArray
    high: FloatArray
    floor: float
    lost: FloatArray
    limits: list[Tangent] = field(default_factory=list)
    goals: list[Tangent] = field(default_factory=list)
    middle_feasible: bool = True

    def __post_init__(self) -> None:
        self.x = 0.5 * (self.low + self.high)
        self.reach = (self.high - self.low) / np.maximum(self.high + self.low, 1e-300)

    def cut(self, times: int, best: float) -> tuple[FloatArray, FloatArray]:
        """Halved so many times along the side on which most is left out, and most changes of what is known."""
        size = abs(best) if np.isfinite(best) else max([abs(goal.value) for goal in self.goals], default=1.0)
        bends, slopes = np.zeros(len(self.reach)), np.zeros(len(self.reach))
        for tangent in [*self.limits, *(goal.scaled(0.0, size or 1.0) for goal in self.goals)]:
            bends += np.minimum(tangent.sides, 1e9)
            slopes += np.abs(tangent.slope) * self.reach
        if not (bends + slopes).any():
            slopes = self.lost.copy() if self.lost.any() else self.reach.copy()
        low, high = self.low[None], self.high[None]
        for _ in range(times):
            side = int(np.argmax(bends + slopes))
            low, high = _halves(low, high, side)
            bends[side], slopes[side] = 0.25 * bends[side], 0.5 * slopes[side]
        return low, high


@dataclass
class _Search:
    program: Program
    progress: Progress | None
    method: Tangents

    def __post_init__(self) -> None:
        program = self.program
        self.judge = Judge(program)
        self.limits = [_Part(one, one.bound, abs(one.bound) or 1.0) for one in program.limits if _tangible(one)]
        aims = program.aim.pieces if program.aim else ()
        self.aims = [_Part(aim, 0.0, 1.0) for aim in aims if _tangible(aim)]
        self.others = [
            (one, FormBounds(one.model, one.form, program.high)) for one in program.limits if not _tangible(one)
        ]
        self.other_aims = [(one, FormBounds(one.model, one.form, program.high)) for one in aims if not _tangible(one)]
        for part, bounds in [*self.others, *self.other_aims]:
            bounds.add(first_speeds(part.form))
        self.along = towards(program)
        self.best_x: FloatArray | None = None
        self.best = np.inf
        self.beside = metered()
        box = _BOX + sum(one.cost for one in self.limits + self.aims)
        box += sum(part.cost for part in program.parts if not part.form.searched)
        self.budget = Budget(min(self.method.most, int(_LONG / box)), "boxes", box)

    def answer(self) -> Found:
        frontier = Frontier(self.budget, self.progress, "branch and bound")
        frontier.add(np.array([-np.inf]), self.program.low[None, :], self.program.high[None, :])
        self.cut(frontier, _FIRST)
        near = [] if self.method.near is None else [np.log(np.maximum(self.method.near, 1e-300))]
        for number, y in enumerate([*near, *starts(self.program, _STARTS)]):
            if not frontier or self.best_x is not None or self.tired:
                break  # one start that leads to a feasible design is enough, for the boxes see all others
            with self.beside:
                there = refined(self.program, np.exp(y), only_feasible=self.program.aim is None)
                if there is not None:
                    self.offer(there)
            if not number and self.program.aim is None:
                self.cut(frontier, _SOME)
        self.cut(frontier)
        return self.found(frontier)

    def cut(self, frontier: Frontier, most: float = np.inf) -> None:
        """Look at boxes, so many in all, and halve what is left of them; without a goal until a design is found."""
        while frontier and not frontier.over and self.budget.spent < most and not self.stuck(frontier):
            if self.best_x is not None and self.program.aim is None:
                break
            _, low, high = frontier.take(_AT_ONCE)
            left = list(self.look(low, high))
            times = next(k for k in range(_DEEP, 0, -1) if k == 1 or len(left) << k <= _AT_ONCE)
            for goal, box in left:  # the fewer there are, the smaller the next: many take little more than one
                frontier.add(np.full(2**times, goal), *box.cut(times, self.best))
            frontier.keep(self.bar)

    def stuck(self, frontier: Frontier) -> bool:
        """Whether boxes are halved and hardly one is dropped, for nothing is known on those that come first."""
        if self.budget.part < _TRIED or len(frontier) < _LEFT * self.budget.spent:
            return False
        return not self.best - frontier.bound < abs(self.best)

    @property
    def bar(self) -> float:
        """A box whose goal is no less than this holds nothing that matters."""
        return self.best - self.method.gap * abs(self.best) if np.isfinite(self.best) else np.inf

    def offer(self, x: FloatArray) -> None:
        """Keep a design that is feasible and better, and the times of its peaks.

        Where it is neither, a duration was left out, which is kept.
        """
        good, goal = self.judge.feasible(x), np.inf
        if good:
            worst = self.judge.goal(x)
            goal = worst.value
            for _, bounds in self.other_aims:
                bounds.add(worst.speeds)
        better = goal < self.best or (good and self.best_x is None)
        if better:
            self.best, self.best_x = goal, x
        for part in [*self.limits, *self.aims]:
            if better or part.of.form.searched:
                part.learn(x)

    def look(self, low: FloatArray, high: FloatArray) -> Iterator[tuple[float, _Box]]:
        """Boxes low, high (n, n_vars) that may hold something better, each with the bound of the goal on it."""
        holds = np.ones(len(low), dtype=bool) if self.along is None else reaching(self.program, self.along, low, high)
        for limit, bounds in self.others:
            holds &= may_hold(limit, bounds, low, high)
        boxes = self.floored(low[holds], high[holds])
        self.budget.spend(max(1, len(boxes)))
        wide = [one for one in boxes if one.lost.max() > _FAR]
        yield from ((one.floor, one) for one in wide)
        boxes = self.aimed(self.limited([one for one in boxes if one not in wide]))
        for box in sorted((one for one in boxes if one.middle_feasible), key=self.middle):
            if self.better(box) and not self.tired:
                with self.beside:
                    self.offer(self.followed(box.x))
        for box in boxes:
            goal = _together(box)
            if goal is not None and goal < self.bar:
                yield goal, box

    def floored(self, low: FloatArray, high: FloatArray) -> list[_Box]:
        """Those of the boxes (n, n_vars) on which no limit, and not the goal, is greater than it may be for sure."""
        least, lost = np.full(len(low), -np.inf), np.zeros(low.shape)
        for part in [*self.limits, *self.aims]:
            if part.floors is None or not len(low):
                continue
            floor, sides = part.floors.on(low, high)
            lost += sides
            if isinstance(part.of, Limit):
                left = floor <= part.bound + SAFETY * part.size
            else:
                least = np.maximum(least, floor)
                left = floor < self.bar
            low, high, least, lost = low[left], high[left], least[left], lost[left]
        for aim, bounds in self.other_aims if len(low) else ():
            lower, upper = bounds.on(low, high)
            least = np.maximum(least, lower if aim.sense > 0 else -upper)
        some = least < self.bar
        return [_Box(*one) for one in zip(low[some], high[some], least[some], lost[some], strict=True)]

    def limited(self, boxes: list[_Box]) -> list[_Box]:
        """Take up what the limits are no less than; boxes on which they may all be kept."""
        for part in self.limits:
            left = part.far(boxes)
            for box, known in part.tangents([box for box in boxes if box not in left], part.bound):
                box.limits += known
                box.middle_feasible &= bool(known) and max(tangent.value for tangent in known) <= 0.0
                left += [] if any(tangent.least(box.reach) > SAFETY for tangent in known) else [box]
            boxes = left
        for limit, bounds in self.others:
            for box in boxes:
                if box.middle_feasible:
                    missed, worst = self.judge.limit(limit, box.x)
                    bounds.add(worst.speeds)
                    box.middle_feasible = missed <= self.judge.tolerance
        return boxes

    def aimed(self, boxes: list[_Box]) -> list[_Box]:
        """Take up what the goal is no less than; boxes on which it may be better than the best."""
        for part in self.aims:
            left = []
            for box, known in part.tangents(boxes, self.best if _sign(part.of) > 0.0 else np.inf):
                box.goals += known
                left += [] if any(tangent.least(box.reach) >= self.bar for tangent in known) else [box]
            boxes = left
        return boxes

    def middle(self, box: _Box) -> float:
        """What the goal is at least in the middle of a box."""
        return max((goal.value for goal in box.goals), default=-np.inf)

    def better(self, box: _Box) -> bool:
        """Whether the middle of a box may be worth while."""
        if not np.isfinite(self.best):
            return True
        return self.promises(max(goal.value for goal in box.goals) if box.goals else self.judge.goal(box.x).value)

    @property
    def tired(self) -> bool:
        """Whether designs that a search must measure have taken what they may."""
        searched = any(part.form.searched for part in self.program.parts)
        return searched and self.beside.done > _SEARCHED

    def followed(self, x: FloatArray) -> FloatArray:
        """What a design leads to where it is better; where tangents alone said so, itself: a duration was left out."""
        if not self.judge.feasible(x) or not self.promises(self.judge.goal(x).value):
            return x
        return improved(self.program, x, self.judge)

    def promises(self, value: float) -> bool:
        """Whether a goal is better than the best by so much that it may be worth while."""
        return not np.isfinite(self.best) or value < self.best - _BETTER * abs(self.best)

    def found(self, frontier: Frontier) -> Found:
        boxes, name = self.budget.spent, Tangents.name
        details = {"boxes": boxes}
        if self.best_x is None:
            if frontier:
                claim = f"nothing found and nothing proven in {counted(boxes, 'boxes')}"
                return Found("unproven", None, claim, name, details=details)
            claim = f"proven by branch and bound: every one of {counted(boxes, 'boxes')} breaks a limit"
            return Found("infeasible", None, claim, name, details=details)
        if self.program.aim is None:
            return Found("optimal", self.best_x, "a design that meets every limit", name, details=details)
        if not frontier:
            claim = f"proven by branch and bound: nothing is better by more than {self.method.gap:.0e} of the goal"
            return Found("optimal", self.best_x, claim, name, self.bar, details)
        return self.open(frontier.bound, details)

    def open(self, bound: float, details: dict[str, int]) -> Found:
        """The best where the boxes are used up: of this search and, unless it is near enough, of many starts."""
        claim = "the best of boxes and of a descent"
        if not self.best - bound <= self.method.enough * abs(self.best):
            given = tuple(np.exp(y) for y in best_of_many(self.program, _GIVEN))
            most = int(np.clip(_LONG / self.program.cost, _FEWEST, Nlp.most))
            other = Nlp(given=given, most=most).solve(self.program, self.progress)
            claim = other.claim
            if other.x is not None:
                self.offer(other.x)
        gap = abs(self.best - bound) / max(abs(self.best), 1e-300)
        left = f"with a gap of {gap:.1e} of the goal" if np.isfinite(bound) else "without a bound"
        claim = f"{claim}; branch and bound stopped after {counted(details['boxes'], 'boxes')} {left}"
        return Found("feasible", self.best_x, claim, Tangents.name, bound, details)


def _together(box: _Box) -> float | None:
    """Bound of the goal where all limits are kept at once, -inf without one; None where they cannot be kept.

    The weights of a linear program are only a proposal: any weights of what is known give a bound.
    """
    reach = box.reach
    alone = max([box.floor, *(goal.least(reach) for goal in box.goals)])
    limits, goals = ([one for one in some if np.isfinite(one.rest)] for some in (box.limits, box.goals))
    if not limits:
        return alone
    if goals:
        size = max(abs(goal.value) for goal in goals) or 1.0
        goals = [goal.scaled(0.0, size) for goal in goals]
        weights = _weights([*goals, *limits], len(goals), reach)
        if weights is not None:
            return max(alone, size * _weighed([*goals, *limits], weights, reach))
    weights = _weights(limits, len(limits), reach)
    return None if weights is not None and _weighed(limits, weights, reach) > SAFETY else alone


def _weights(tangents: Sequence[Tangent], count: int, reach: FloatArray) -> FloatArray | None:
    """Least t with the first `count` of tangents at most t, the others at most 0; None where those clash for sure."""
    n, goal = len(reach), np.arange(len(tangents)) < count
    unit = np.eye(n, n + 1)
    slopes = np.array([tangent.slope for tangent in tangents])
    rows = np.concatenate([np.column_stack([slopes, -1.0 * goal]), unit, -unit])
    rest = np.array([tangent.rest - tangent.value for tangent in tangents])
    solved = solve_cones(np.eye(n + 1)[n], rows, np.concatenate([rest, reach, reach]), [(LINEAR, len(rows))])
    weights = np.maximum(solved.z[: len(tangents)], 0.0)
    total = float(weights[:count].sum())
    return np.asarray(weights / total) if np.finfo(float).eps * weights.max() < total < np.inf else None


def _weighed(tangents: Sequence[Tangent], weights: FloatArray, reach: FloatArray) -> float:
    """What the weighed sum of tangents is no less than on the box."""
    value = sum(weight * (tangent.value - tangent.rest) for weight, tangent in zip(weights, tangents, strict=True))
    slope = sum(
        (weight * tangent.slope for weight, tangent in zip(weights, tangents, strict=True)), np.zeros(len(reach))
    )
    return float(value - np.abs(slope) @ reach)


def _halves(low: FloatArray, high: FloatArray, side: int) -> tuple[FloatArray, FloatArray]:
    """Boxes (n, n_vars) each cut in two: lower ends and upper ends (2 n, n_vars)."""
    least, most = low[:, side], high[:, side]
    wide = np.sqrt(np.maximum(least, 1e-6 * most) * most)
    cut = np.where(most > _WIDE * least, wide, 0.5 * (least + most))
    lows, highs = np.concatenate([low, low]), np.concatenate([high, high])
    highs[: len(low), side] = lows[len(low) :, side] = cut
    return lows, highs
