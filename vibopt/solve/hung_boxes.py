"""Very many boxes where all that can be chosen acts on a few places of a host: rows close what they leave open.

Boxes that promise most are cut first, each across one side.  Which side is best is tried on a few of them, and the
others follow by the lengths of their sides: alone each would be cut where it gains at once, which is a longer way.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from vibopt.forms.hung_on_boxes import Hosted, Pulls, places_of
from vibopt.forms.read_on_places import Read, read
from vibopt.frontier import Frontier
from vibopt.mechanics.model import Model
from vibopt.program.program import Aim, Limit
from vibopt.records import dataclass
from vibopt.solve.branch import first_speeds
from vibopt.solve.log_boxes import LogBoxes
from vibopt.work import Budget

MOST, _COST = 400_000, 0.005
"""Boxes, and the work of each of them [nominal ms]."""
_PATIENCE = 0.3
"""Part of the boxes by which something must be known."""
_BATCH, _TRIED, _SHARE = 512, 16, 32
"""Boxes that are cut together at most, and of these how many try each side."""
_SPEEDS, _SAME, _HIGHEST = 48, 5e-3, 3
"""Frequencies at most, by what part of it the next one is off, and peaks that are learnt at once."""
_GAIN, _FAR = 0.3, 100.0
"""The most that one cut counts, as a log, and how near a box is that may resonate at every frequency."""
_SURE = 1e-9
"""Part of a response that rounding may take."""
_MODEL = "kinds", "vectors", "scales", "exponents"


@dataclass(frozen=True, slots=True)
class _Known:
    """A response, by the log of what it is compared with: the bound of a limit, one of a goal."""

    part: Limit | Aim
    is_goal: bool
    level: float
    hosted: Hosted
    order: float


class HungBoxes:
    """The goals and limits of a program that are known on boxes, at frequencies that are learnt.

    Parameters
    ----------
    space
        The boxes.
    goals, limits
        What is asked of designs; limits as goals are counted by how far they are exceeded.
    most
        Boxes that are looked at where all acts on one place; fewer where each takes longer.
    """

    def __init__(
        self, space: LogBoxes, goals: Sequence[Limit | Aim], limits: Sequence[Limit], most: int = MOST
    ) -> None:
        self.space = space
        self.sums, self.known = list[tuple[Limit | Aim, bool, float]](), list[_Known]()
        hosts = _Hosts()
        for index, part in enumerate((*goals, *limits)):
            level, is_goal = float(np.log(part.bound)) if isinstance(part, Limit) else 0.0, index < len(goals)
            form = part.form.harmonic
            if part.least_wanted or (isinstance(part, Limit) and part.side != "at_most"):
                continue
            if part.form.powers is not None and (part.form.powers.scale >= 0.0).all():
                self.sums.append((part, is_goal, level))
            elif form is None or form.line is None:
                continue
            elif (hosted := hosts.of(part.model, form.output.signs, form.line.vector)) is not None:
                self.known.append(_Known(part, is_goal, level, hosted, form.line.order))
        self.places = max((len(one.hosted.places) for one in self.known), default=1)
        self.budget = Budget(2 * most // (1 + self.places), "boxes", 0.5 * _COST * (1 + self.places))
        self.w, self.reads, self.pulls = np.zeros(0), list[tuple[_Known, Read]](), dict[int, Pulls]()
        self._add([one.order * w for one in self.known for some in first_speeds(one.part.form).values() for w in some])

    @property
    def says(self) -> bool:
        """Whether anything is known of a response, and of the goal."""
        goal = any(one.is_goal for one, _ in self.reads) or any(is_goal for _, is_goal, _ in self.sums)
        return goal and any(one.asked.any() for _, one in self.reads)

    def left(
        self, boxes: tuple[FloatArray, FloatArray, FloatArray], bar: float, floor: Callable[[], float], near: float,
        most: float = np.inf,
    ) -> tuple[FloatArray, FloatArray, FloatArray]:  # fmt: skip
        """What stays open of boxes: bounds of the log of the goal (n_boxes,) below `bar`, logs (n_boxes, n_vars).

        It ends where all are within `near` of the bar, all or `most` are counted, or they stay far below `floor`.
        """
        frontier, (bounds, low, high) = Frontier(self.budget), boxes
        frontier.add(bounds, low, high, self._on(low, high, bar)[1])
        while frontier and not frontier.over and self.budget.spent < most and frontier.bound <= bar - near:
            if self.budget.spent > _PATIENCE * self.budget.most and frontier.bound < floor():
                break
            begun, low, high, way = frontier.take(max(_BATCH, len(frontier) // _SHARE))
            self._learn(np.exp(0.5 * (low + high)[0]), bar)
            low, high = self.space.halves(low, high, self._side(low, high, way, bar))
            bound, way = self._on(low, high, bar)
            bound = np.maximum(bound, begun.repeat(2))
            bound[self.space.in_other_order(low, high)] = np.inf
            self.budget.spend(len(low))
            some = bound < bar
            frontier.add(bound[some], low[some], high[some], way[some])
        if not frontier:
            return bounds[:0], low[:0], high[:0]
        return frontier.bounds, frontier.columns[0], frontier.columns[1]

    def _side(self, low: FloatArray, high: FloatArray, way: FloatArray, bar: float) -> IntArray:
        """The side across which each box is cut."""
        side, wide = np.zeros(len(low), dtype=int), high - low
        for every in (np.flatnonzero(way < -_FAR), np.flatnonzero(way >= -_FAR)):
            if len(every):
                some = every[np.linspace(0, len(every) - 1, min(len(every), _TRIED)).astype(int)]
                gain = self._gained(low[some], high[some], way[some], bar)
                weight = (gain / np.maximum(wide[some], _SURE)).mean(axis=0) + _SURE
                side[every] = (wide[every] * weight).argmax(axis=1)
        return side

    def _gained(self, low: FloatArray, high: FloatArray, way: FloatArray, bar: float) -> FloatArray:
        """By how much both halves of boxes across each side are nearer to being out, (n_boxes, n_vars)."""
        gain, sides = np.zeros(low.shape), np.flatnonzero((high > low).any(axis=0))
        many, side = len(sides), sides.repeat(len(low))
        halves = self.space.halves(np.tile(low, (many, 1)), np.tile(high, (many, 1)), side)
        there = self._on(*halves, bar)[1].reshape(many, len(low), 2)
        gain[:, sides] = np.clip(there - way[:, None], 0.0, _GAIN).sum(axis=2).T
        return gain

    def _on(self, low: FloatArray, high: FloatArray, bar: float) -> tuple[FloatArray, FloatArray]:
        """Bound of the log of the goal on boxes of logs, inf where a limit is broken, and how near to that they are.

        A log, zero where they are out, far below it where a device may resonate at every frequency; each (n_boxes,).
        """
        ends = self.space.ends(low, high)
        bound, way = np.full(len(low), -np.inf), np.full(len(low), -np.inf)
        with np.errstate(divide="ignore"):
            for part, is_goal, level in self.sums:
                assert part.form.powers is not None
                _counted(bound, np.log(part.form.powers.extent(*ends)[0]) - level, is_goal)
            pulled = {key: pulls.on(*ends) for key, pulls in self.pulls.items()}
            for one, response in self.reads:
                least = np.log(response.least(*pulled[id(one.hosted)])) - one.level - _SURE
                _counted(bound, least, one.is_goal)
                way = np.maximum(way, least - (bar if one.is_goal else 0.0))
        if len(lost := np.flatnonzero(way < -_FAR)):
            for one, response in self.reads:
                apart = one.hosted.apart(ends[0][lost], ends[1][lost], self.w[response.asked]).max(axis=1, initial=-1.0)
                way[lost] = np.maximum(way[lost], apart - 2.0 * _FAR)
        return bound, way

    def _learn(self, x: FloatArray, bar: float) -> None:
        """Look at the frequencies at which the design x (n_vars,) is worst, too."""
        if len(self.w) < _SPEEDS:
            self._add(
                [
                    one.order * local.speeds[0]
                    for one, _ in self.reads
                    for local in one.part.extremes(x)[:_HIGHEST]
                    if local.value - one.level > (bar if one.is_goal else 0.0)
                ]
            )

    def _add(self, fresh: list[float]) -> None:
        known = self.w.tolist()
        for w in fresh:
            if w > 0.0 and all(abs(w - old) > _SAME * w for old in known):
                known.append(w)
        if len(known) > len(self.w):
            self.w = np.array(known)
            each = ((one, read(one.part.form, one.hosted, self.w)) for one in self.known)
            self.reads = [(one, found) for one, found in each if found is not None]
            hosts = {id(one.hosted): one.hosted for one, _ in self.reads}
            self.pulls = {
                key: Pulls(hosted, self.w, {found.of for one, found in self.reads if one.hosted is hosted})
                for key, hosted in hosts.items()
            }


class _Hosts:
    """Machines as hosts with places, which all models alike share: what acts there is worked out once."""

    def __init__(self) -> None:
        self.known: list[tuple[Hosted, BoolArray]] = []

    def of(self, model: Model, signs: FloatArray, load: ComplexArray) -> Hosted | None:
        marks = np.concatenate([(signs != 0.0) & model.exponents.any(axis=1), load != 0.0])
        for one, own in self.known:
            alike = all(np.array_equal(getattr(one.model, key), getattr(model, key)) for key in _MODEL)
            if alike and np.array_equal(own, marks):
                return one
        if (hosted := places_of(model, load, signs)) is not None:
            self.known.append((hosted, marks))
        return hosted


def _counted(bound: FloatArray, least: FloatArray, is_goal: bool) -> None:
    """Take into account on each box what a goal is at least, or how far a limit is exceeded (n_boxes,)."""
    if is_goal:
        np.maximum(bound, least, out=bound)
    else:
        bound[least > _SURE] = np.inf
