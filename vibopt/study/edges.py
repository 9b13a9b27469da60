"""Where between the points of a grid an answer begins or ends, and where other limits become active."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from itertools import groupby, pairwise
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.answer.entry import ACTIVE, Entry
from vibopt.arrays import FloatArray
from vibopt.balancing import is_rotor
from vibopt.errors import InputError
from vibopt.jobs import is_scene
from vibopt.records import dataclass
from vibopt.report.catalogue_choices import tied
from vibopt.study.many import answered
from vibopt.study.points import Point, Points
from vibopt.study.seen import shown_value
from vibopt.study.together import Seen
from vibopt.study.varied import Varied
from vibopt.units import show
from vibopt.work import SpentError, metered

if TYPE_CHECKING:
    from vibopt.jobs import Job
    from vibopt.study.sweep import Sweep

CLOSE = 1e-6
"""Distance between the two sides of a boundary, as a part of the range and of the value."""
BY_SEARCH = 2e-5
"""The same where a limit becomes active and answers are iterated ones: near there rounding is as large as margins."""
ALONG_EDGES = 1e-3
"""The same along the edges of a grid whose points are answered one by one."""
_MOST_ROUNDS, _MOST_ANSWERS = 60, 4000
MOST_WORK = 60_000.0
"""Work of all boundaries [nominal ms], beyond which they stay as wide as they are."""
_TOGETHER = 15
"""Places looked at between two sides at a time, where many answers cost little more than one."""
_FINEST, _HALVED, _ASIDE = 1e-9, 5, 0.05
"""Distance that is never cut further; rounds of which one halves where the others follow a straight line, and part of
the way to the nearer side by which they go beyond its root.  A root that is met leaves the other side where it was."""
_ONE_EVENT = 4.0
"""Widths of a closed gap within which another is the same event."""

State = tuple[str, tuple[str, ...], tuple[tuple[str, str], ...]]
"""Status; limits that are active or broken; what was chosen from a catalogue or a list, by path."""


@dataclass(frozen=True, slots=True)
class Boundary:
    """Two neighbouring places along one fact with different answers.

    path
        Of the fact along which it was found.
    below, above
        Its value on either side, no further apart than `CLOSE`, or `BY_SEARCH`, unless `wide`.
    before, after
        Status on either side, names of the limits that are active there or, without a design, broken, and what was
        chosen from catalogues and lists.
    others
        Values of the other facts, by path.
    sides
        The answers on either side.
    wide
        Whether the search ended before the two were so close.
    """

    path: str
    below: Entry
    above: Entry
    before: State
    after: State
    others: dict[str, Entry]
    sides: tuple[Point, Point]
    wide: bool = False

    @property
    def at(self) -> float:
        """The middle [SI]."""
        return 0.5 * (self.below.value + self.above.value)

    @property
    def goals(self) -> tuple[float, ...]:
        """The goal on either side [SI], where there is one."""
        return tuple(side.goal.value for side in self.sides if side.goal is not None and side.good)

    @property
    def precise(self) -> str:
        """The place with as many digits as are known of it; of whole numbers, and where it is wide, both sides."""
        if self.below.dimension == "count" or (self.wide and self.below.shown != self.above.shown):
            return f"between {self.below.shown} and {self.above.shown}"
        size, apart = abs(self.at), abs(self.above.value - self.below.value)
        digits = int(np.clip(np.ceil(np.log10(size / apart)), 3, 7)) if size and apart else 7
        below = self.below
        return show(self.at, below.unit, below.dimension, digits=digits, amplitude=below.amplitude)

    @property
    def of_feasibility(self) -> bool:
        """Whether designs begin or end here."""
        return self.before[0] != self.after[0]

    def to_json(self) -> dict[str, Any]:
        """Both sides with their status and limits."""
        sides = (("below", self.below, self.before), ("above", self.above, self.after))
        return {
            "path": self.path,
            **({"others": self.others} if self.others else {}),
            **{
                name: {
                    **value.to_json(),
                    "status": state[0],
                    "limits": state[1],
                    **({"chosen": dict(state[2])} if state[2] else {}),
                }
                for name, value, state in sides
            },
            **({"wide": True} if self.wide else {}),
        }


@dataclass(frozen=True, slots=True)
class _Gap:
    """Two neighbouring places with different answers, values (n_facts,) [SI], along the fact `axis`."""

    axis: int
    low: FloatArray
    high: FloatArray
    before: State
    after: State
    sides: tuple[Point, Point]


def boundaries(job: Job, varied: Sequence[Varied], axes: Sequence[FloatArray], points: Points) -> tuple[Boundary, ...]:
    """All changes between neighbouring points of a grid, each followed until its sides are close, along each fact."""
    many = list(points)
    batch = len(points.single) < len(points) // 2
    closed = batch or is_scene(job)
    fine = _fineness(many) if closed else ACTIVE
    steps = is_rotor(job) and any(one.whole for one in varied)  # each value is a filling of its own, and a point
    listed = frozenset() if steps else _listed(job)
    states = np.empty(len(many), dtype=object)
    states[:] = [(state_of(point, fine, listed), point) for point in many]
    grid = states.reshape([len(axis) for axis in axes])
    open_gaps = list(_gaps(grid, axes))
    close = CLOSE if batch or len(axes) == 1 else ALONG_EDGES
    narrow = _Narrowing(job, tuple(varied), (fine, listed), (close, close if closed else max(close, BY_SEARCH)), batch)
    return tuple(_boundary(varied, gap, wide) for gap, wide in _merged(narrow.all(open_gaps), narrow))


def _listed(job: Job) -> frozenset[str]:
    """What is chosen from a list or as a whole number, by path; columns of a part go with its name.

    Of a measured rotor the sums of weights from a shelf in holes.
    """
    if is_rotor(job):
        filled = [plane for plane in job.planes if plane.is_open and plane.shelf and plane.holes]
        return frozenset(f"planes.{plane.name}.{part}" for plane in filled for part in (plane.dimension, "angle"))
    if not is_scene(job):
        return frozenset()
    of_parts = tied(job)
    return frozenset(one.path for one in job.variables if one.values is not None and one.path not in of_parts)


def state_of(point: Point, fine: float, listed: Collection[str] = ()) -> State:
    """What is told apart: whether there is a design, which limits are active, and what of the `listed` was chosen.

    Without a design: which limits are broken.
    """
    if point.status in ("met", "violated"):
        return point.status, tuple(sorted(point.broken)), ()
    if not point.good:
        return point.status, (), ()
    chosen = {**{path: point.variables[path].shown for path in listed if path in point.variables}, **point.parts}
    active = sorted(name for name, margin in point.margins.items() if abs(margin) <= fine)
    return "good", tuple(active), tuple(sorted(chosen.items()))


def _fineness(points: Sequence[Point]) -> float:
    """Margin up to which a limit counts as active: as small as the answers let it be told from rounding."""
    near = [abs(m) for point in points if point.good for m in point.margins.values() if abs(m) <= ACTIVE]
    return float(np.clip(4.0 * np.percentile(near, 90), _FINEST, ACTIVE)) if near else ACTIVE


def _gaps(grid: Any, axes: Sequence[FloatArray]) -> Iterator[_Gap]:
    for axis, values in enumerate(axes):
        for index in np.ndindex(*grid.shape):
            if index[axis] + 1 < len(values):
                beyond = (*index[:axis], index[axis] + 1, *index[axis + 1 :])
                if grid[index][0] != grid[beyond][0]:
                    low, high = (np.array([one[i] for one, i in zip(axes, at, strict=True)]) for at in (index, beyond))
                    (before, first), (after, last) = grid[index], grid[beyond]
                    yield _Gap(axis, low, high, before, after, (first, last))


def _merged(gaps: list[_Gap], narrow: _Narrowing) -> Iterator[tuple[_Gap, bool]]:
    """Gaps along a line that follow each other more closely than each is known are one; what ends as it began is none.

    Of several the one where designs begin or end gives the place; two of these are never one.  Beside each, whether the
    search ended before it was closed: several that are closed are, however far they reach together.
    """
    runs: list[list[_Gap]] = []
    for one in gaps:
        last = runs[-1] if runs else []
        both = sum(gap.before[0] != gap.after[0] for gap in (*last, one)) > 1
        if last and not both and narrow.follows(last[-1], one):
            last.append(one)
        else:
            runs.append([one])
    for run in runs:
        first, last_one = run[0], run[-1]
        edge = next((gap for gap in run if gap.before[0] != gap.after[0]), None)
        low, high = (edge.low, edge.high) if edge is not None else (first.low, last_one.high)
        if first.before != last_one.after:
            sides = (first.sides[0], last_one.sides[1])
            whole = _Gap(first.axis, low, high, first.before, last_one.after, sides)
            yield whole, any(map(narrow.is_wide, run))


class _Narrowing:
    """Gaps cut until their two sides are close; where a third answer lies between, both halves are followed."""

    def __init__(
        self,
        job: Job,
        varied: tuple[Varied, ...],
        told: tuple[float, Collection[str]],
        close: tuple[float, float],
        batch: bool,
    ) -> None:
        self.job, self.varied, self.told = job, varied, told
        self.of_designs, self.of_limits = close
        self.inner, self.seen = _TOGETHER if batch else 1, Seen()
        self.seen.compared = batch  # with the grid between whose points the boundaries lie
        self.left, self.work = _MOST_ANSWERS * self.inner, 0.0

    def is_wide(self, gap: _Gap) -> bool:
        """Whether the sides are further apart than they should be."""
        low, high = gap.low[gap.axis], gap.high[gap.axis]
        return bool(high - low > (1.5 if self.varied[gap.axis].whole else self._known_to(gap)))

    def _known_to(self, gap: _Gap) -> float:
        varied, close = self.varied[gap.axis], self.of_limits if gap.before[0] == gap.after[0] else self.of_designs
        return close * min(varied.high - varied.low, float(np.abs([gap.low, gap.high])[:, gap.axis].max()) or inf)

    def follows(self, gap: _Gap, other: _Gap) -> bool:
        """Whether another gap begins on the same line, behind this one by no more than a few times what is known."""
        axis, near = gap.axis, _ONE_EVENT * self._known_to(other)
        same = axis == other.axis and np.array_equal(np.delete(gap.low, axis), np.delete(other.low, axis))
        closed = not (self.varied[axis].whole or self.is_wide(gap) or self.is_wide(other))
        return bool(same and closed and 0.0 <= other.low[axis] - gap.high[axis] <= near)

    def all(self, gaps: list[_Gap]) -> list[_Gap]:
        for self.round in range(_MOST_ROUNDS):
            wide = [gap for gap in gaps if self.is_wide(gap)]
            if not wide or len(wide) * self.inner > self.left:
                break
            try:
                cut = self._cut(wide)
            except (InputError, SpentError):  # there is nothing between, or no more work is done
                break
            gaps = [one for gap in gaps for one in (cut.pop(0) if self.is_wide(gap) else [gap])]
        return gaps

    def _cut(self, wide: list[_Gap]) -> list[list[_Gap]]:
        places = [self._places(one) for one in wide]
        facts = tuple(varied.fact for varied in self.varied)
        with metered(MOST_WORK - self.work) as meter:
            found = list(answered(self.job, facts, np.concatenate(places), seen=self.seen))
        self.work += meter.done
        self.left -= len(found)
        parts, begin = [], 0
        for gap, inner in zip(wide, places, strict=True):
            here = found[begin : begin + len(inner)]
            begin += len(inner)
            between = [(at, state_of(point, *self.told), point) for at, point in zip(inner, here, strict=True)]
            steps = [(gap.low, gap.before, gap.sides[0]), *between, (gap.high, gap.after, gap.sides[1])]
            parts.append([_Gap(gap.axis, a, b, s, t, (g, h)) for (a, s, g), (b, t, h) in pairwise(steps) if s != t])
        return parts

    def _places(self, gap: _Gap) -> FloatArray:
        varied, low, high = self.varied[gap.axis], gap.low[gap.axis], gap.high[gap.axis]
        parts = np.arange(1, self.inner + 1) / (self.inner + 1)
        along = low * (high / low) ** parts if varied.by_ratios else low + parts * (high - low)
        if self.inner == 1 and not varied.whole and (self.round + 1) % _HALVED:
            along = self._met_between(gap, low, high, along)
        along = np.unique(np.clip(np.round(along), low + 1, high - 1)) if varied.whole else along
        places = np.tile(gap.low, (len(along), 1))
        places[:, gap.axis] = along
        return places

    def _met_between(self, gap: _Gap, low: float, high: float, middle: FloatArray) -> FloatArray:
        """Where the one bound that is broken on one side alone is met on a straight line, a little to the far side."""
        slack = ACTIVE if gap.before[0] == gap.after[0] else 0.0
        before, after = ({name: value + slack for name, value in side.margins.items()} for side in gap.sides)
        turned = [(value, after[name]) for name, value in before.items() if name in after and value * after[name] < 0.0]
        measured = {gap.before[0], gap.after[0]} <= {"met", "violated"}
        if not measured or len(turned) != 1 or not np.isfinite(turned).all():
            return middle
        [(first, last)] = turned
        at, least = low + (high - low) * first / (first - last), 0.4 * self._known_to(gap)
        off = max(least, _ASIDE * min(at - low, high - at))
        return np.clip([at + (off if high - at > at - low else -off)], low + 0.1 * least, high - 0.1 * least)


def _boundary(varied: Sequence[Varied], gap: _Gap, wide: bool) -> Boundary:
    facts = [one.fact for one in varied]
    ends = [shown_value(facts[gap.axis], float(one[gap.axis])) for one in (gap.low, gap.high)]
    others = {
        fact.path: shown_value(fact, float(value))
        for index, (fact, value) in enumerate(zip(facts, gap.low, strict=True))
        if index != gap.axis
    }
    return Boundary(facts[gap.axis].path, ends[0], ends[1], gap.before, gap.after, others, gap.sides, wide)


@dataclass(frozen=True, slots=True)
class Stretch:
    """Values of the fact from `low` to `high` [SI] without a good answer; at both ends this status was found."""

    low: float
    high: float
    status: str


def stretches(sweep: Sweep) -> Iterator[Stretch]:
    """Runs of one fact without a good answer, each out to where the answers change."""
    ends = [boundary for boundary in sweep.boundaries if boundary.of_feasibility]
    first, last = sweep.points[0], sweep.points[-1]
    fine = ACTIVE
    cuts = [
        (first.value.value, state_of(first, fine)[0]),
        *((side.value, state[0]) for end in ends for side, state in ((end.below, end.before), (end.above, end.after))),
        (last.value.value, state_of(last, fine)[0]),
    ]
    for status, run in groupby(cuts, lambda one: one[1]):
        values = [one[0] for one in run]
        if status not in ("good", "met"):
            yield Stretch(values[0], values[-1], status)
