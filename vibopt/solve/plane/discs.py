"""Stiffness and damping of one link on any machine, proven: discs at the worst speeds, and a third variable in slices.

A good design comes from many tries and exact polishing.  Then the rows at a few speeds, with the goal
asked to be better by the gap, must leave nothing; where they leave a point, its worst speeds are added.
"""

from __future__ import annotations

from dataclasses import field, replace

import numpy as np

from vibopt.answer.entry import TOLERANCE
from vibopt.arrays import FloatArray
from vibopt.frontier import Frontier
from vibopt.program.program import Aim, Limit, Program
from vibopt.records import dataclass
from vibopt.solve.branch import Judge, violation
from vibopt.solve.local import improved, refined, rescued
from vibopt.solve.method import VANISHED, Found, Progress
from vibopt.solve.plane.absorber_newton import equal_peaks
from vibopt.solve.plane.conics import Conics, monomials
from vibopt.solve.plane.link_plane import Interval, LinkPlane
from vibopt.solve.ranges import halton, log_box, on_values, starts
from vibopt.solve.screen import is_cheap
from vibopt.work import Budget, worked

GAP = 1e-6
MOST_SLICES = 5000
_COST = 3.0
"""Work of a slice, in exact measurements."""
_ROUNDS = 40
_BOLDER, _MOST_ASKED = 16.0, 0.25
"""By how many times more is asked of the goal behind a design that was better, and at most [part of the goal]."""
_NEAR_GAP = 4.0
"""By how many times more than the gap is hardly more than the gap, where nothing is left."""
_FIRST = 13
_TRIED = 128
_NEAR = 48
_REACHES = (0.3, 0.08, 0.02)
_DECADE = 5.0
_NARROW = 1e-12
_MET = 1e-11
"""Part of a bound by which exchange may miss it."""
_SAME = 1e-9
"""Part by which speeds differ that count as two."""


class DiscsOfOneLink:
    """Two or three variables, two of them the stiffness and the damping of one link."""

    name = "discs"
    summary = "exact in stiffness and damping of one link on any machine, over the worst speeds"

    def __init__(
        self,
        gap: float = GAP,
        most: int = MOST_SLICES,
        start: FloatArray | None = None,
        patience: int = MOST_SLICES,
    ) -> None:
        self.gap, self.most, self.start, self.patience = gap, most, start, patience
        self._last: tuple[Program | None, LinkPlane | None] = None, None

    def refuses(self, program: Program) -> str | None:
        """Anything but one link's stiffness and damping, with at most one variable beside them."""
        if program.several:
            return "the limits speak of several machines, the same design within its tolerances."
        plane = LinkPlane.of(program)
        self._last = program, plane
        if plane is None:
            return "the variables are not the stiffness and the damping of one link, with at most one other."
        for part in program.parts:
            if not plane.accepts(as_limit(part, 1.0)):
                return f"{part.name} is no disc in the plane of stiffness and damping."
        return None

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """Status "optimal" with the gap, "infeasible", or "feasible" when its slices are used up."""
        known, plane = self._last
        plane = plane if known is program else LinkPlane.of(program)
        assert plane is not None
        budget = Budget(self.most, "slices", _COST * program.cost)
        return _Run(plane, self.gap, budget, progress, self.name, self.start, self.patience).answer()


def as_limit(part: Limit | Aim, level: float) -> Limit:
    """A limit as it is; the goal as the limit that it be at least as good as `level` (its own value)."""
    if isinstance(part, Limit):
        return part
    side = "at_most" if part.sense > 0 else "at_least"
    return Limit(part.name, part.model, part.form, side, level)  # type: ignore[arg-type]


@dataclass
class _Run:
    plane: LinkPlane
    gap: float
    budget: Budget
    progress: Progress | None
    name: str
    start: FloatArray | None = None
    patience: int = MOST_SLICES
    speeds: list[list[float]] = field(default_factory=list)
    best: FloatArray | None = None
    value: float = np.inf
    rounds: int = 0
    stuck: bool = False
    _zero: float = 0.0
    _worst: list[list[float]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.program = self.plane.program
        self.judge = Judge(self.program)
        self.parts = self.program.parts
        self.speeds = [_first(part) for part in self.parts]
        self._cheap = all(is_cheap(part) for part in self.parts)

    @property
    def slices(self) -> int:
        """Intervals of the third variable looked at; one where there is none."""
        return self.budget.spent

    def answer(self) -> Found:
        self._begin()
        if self.value == -np.inf:
            return self._found("unbounded", "the goal is infinite: an undamped resonance lies within reach")
        if self._nothing_left():
            return replace(self._found("optimal", VANISHED), zero=True)
        slices = Frontier(self.budget, self.progress, "slices")
        for interval in reversed(self._whole()):
            slices.push(0.0, interval)
        while slices:
            if self.stuck or slices.over or (self.best is None and self.slices > self.patience):
                return self._stopped()
            depth, interval = slices.pop()
            for half in reversed(self._search(interval)):
                slices.push(depth - 1.0, half)  # narrow ones first: designs that are found there drop the others
            if self._nothing_left():
                return replace(self._found("optimal", VANISHED), zero=True)
            if self.best is not None and self.program.aim is None:
                return self._found("optimal", "a design that meets every limit")
        if self.best is None:
            each = "nothing is left" if self.slices == 1 else f"{self.slices} slices, each left empty"
            claim = f"proven by discs in the plane of stiffness and damping: {each}"
            return Found("infeasible", None, claim, self.name, details=self._details())
        how = "proven by discs in the plane of stiffness and damping"
        return self._found("optimal", f"{how}: nothing is better by more than {self.gap:.0e} of the goal")

    def _nothing_left(self) -> bool:
        """Whether an amplitude to be made least is zero."""
        return self.best is not None and self.value <= self._zero and self.judge.vanishes(self.best)

    def _whole(self) -> list[Interval]:
        if self.plane.other < 0:
            return [(1.0, 1.0)]
        axis = self.program.axes[self.plane.other]
        if axis.values is not None:
            return [(value, value) for value in axis.values]
        return [(axis.low, axis.high)]

    def _begin(self) -> None:
        """A design to beat: what exchange leads to, what is near the start, or the best of many points, polished."""
        if self.start is not None:
            self.start = on_values(self.program, self.start)
            there = refined(self.program, self.start, near=True)
            self.start = self.start if there is None else there
            self._learn_from(self.start)
        if self._exchanged() or self._balanced():
            return
        for known, first in zip(self.speeds, map(_first, self.parts), strict=True):
            known += [value for value in first if _is_new(value, known)]
        tried = on_values(self.program, np.exp(starts(self.program, _TRIED)))
        merit = self._rough(tried)
        self._zero = 1e-12 * float(np.median(self._goals[np.isfinite(self._goals)])) if self.program.aim else 0.0
        if self.start is not None and self._offer(self.start):
            return
        tried, merit = self._nearer(tried, merit)
        for x in tried[np.argsort(merit)[:3]]:
            self._offer(x)
            if self.best is not None:
                break
        if self.best is None and self.plane.other < 0 and not self._empty_at(1.0):
            return
        if self.best is None:
            x = rescued(self.program, tried[np.argsort(merit)[:2]], self.judge)
            if x is not None:
                self._offer(x)

    def _learn_from(self, x: FloatArray) -> None:
        """Begin with the speeds at which limits and goal are worst at a design x (n_vars,), and few others."""
        first = self.speeds
        self.speeds = [[] for _ in first]
        self._learn(x)
        self.speeds = [known or other for known, other in zip(self.speeds, first, strict=True)]

    def _exchanged(self) -> bool:
        """For a goal in stiffness or damping alone: the best that rows at a few speeds leave, until all allow it.

        What meets the limits at some of its speeds only is no worse than the best, so nothing is left to be polished.
        """
        aim = self.program.aim
        axis, power = self.plane.power_of(aim.form) if aim is not None and self.plane.other < 0 else (0, 0.0)
        if aim is None or not power:
            return False
        for _ in range(_ROUNDS):
            conics = self.plane.conics(list(zip(self.program.limits, self.speeds, strict=False)), (1.0, 1.0))
            corners = np.zeros((0, 2)) if conics is None else conics.extreme(-np.sign(aim.sense * power), axis)
            if not len(corners):
                return False
            k, c = corners[corners[:, 1 - axis].argmin()].tolist()
            x = self.plane.design(k, c, 1.0)
            if self._learn(x) <= _MET:
                self.best, self.value = x, self.judge.goal(x).value
                return True
        return False

    def _balanced(self) -> bool:
        """For the least of a worst response: where two peaks are equal, if that is within all limits."""
        x = equal_peaks(self.plane)
        if x is None or self._learn(x) > self.judge.tolerance:
            return False
        self.best, self.value = x, self.judge.goal(x).value
        return True

    def _nearer(self, tried: FloatArray, merit: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The designs and more around the best of them, ever closer, where a look at many speeds is cheap."""
        if not self._cheap or any(axis.values is not None for axis in self.program.axes):
            return tried, merit
        low, high = log_box(self.program)
        spread = halton(_NEAR, len(low)) - 0.5
        for reach in _REACHES:
            best = np.log(tried[merit.argmin()])
            fresh = np.exp(np.clip(best + 2.0 * reach * np.minimum(high - low, _DECADE) * spread, low, high))
            tried = np.concatenate([tried, fresh])
            merit = np.concatenate([merit, self._rough(fresh)])
        return tried, merit

    def _rough(self, x: FloatArray) -> FloatArray:
        """Merit of designs (n, n_vars) at the first speeds: log violation, then the goal."""
        missed, goal = np.zeros(len(x)), np.zeros(len(x))
        for part, speeds in zip(self.parts, self.speeds, strict=True):
            few = part.form.glance(part.model, x) if self._cheap else None
            value = self.plane.rough(as_limit(part, 1.0), np.array(speeds), x) if few is None else few
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
                if isinstance(part, Aim):
                    self._goals = value
                    goal = part.sense * np.nan_to_num(np.log(value), nan=700.0, posinf=700.0, neginf=-700.0)
                else:
                    sign = 1.0 if part.side == "at_most" else -1.0
                    miss = sign * (np.log(value) - np.log(max(part.bound, 1e-300)))
                    missed = np.maximum(missed, np.nan_to_num(miss, nan=700.0, posinf=700.0, neginf=0.0))
        return np.where(missed > 0.0, 1e3 + missed, 0.0) + goal

    def _offer(self, x: FloatArray) -> bool:
        """Measure a design exactly, learn its worst speeds, keep and polish it if it is the best; whether it was."""
        if self._learn(x) > self.judge.tolerance:
            return False
        goal = self.judge.goal(x).value
        if self.best is not None and not goal < self.value - (
            0.5 * self.gap * abs(self.value) if np.isfinite(self.value) else 0.0
        ):
            return False
        there = improved(self.program, x, self.judge) if np.isfinite(goal) else x
        self.best, self.value = there, self.judge.goal(there).value
        self._learn(there)
        return True

    def _learn(self, x: FloatArray) -> float:
        """Add the speeds at which limits and goal are worst at x (n_vars,).

        Returns the part of its bound by which the worst limit is missed.
        """
        worst = -np.inf
        self._worst = []
        for part, known in zip(self.parts, self.speeds, strict=True):
            least, found = part.least_wanted, part.candidates(x)
            worked(part.cost)
            self._worst.append([at[0] if at else 0.0 for at, _ in found if not at or np.isfinite(at[0])])
            if part.form.drives:
                known += [at for at in self._worst[-1] if _is_new(at, known)]
            if isinstance(part, Limit):
                worst = max(worst, violation(part, (min if least else max)(value for _, value in found), x))
        return worst

    def _search(self, interval: Interval) -> list[Interval]:
        """What is left of an interval of v: nothing, or its two halves."""
        self.budget.spend()
        if self.plane.other < 0 and self.best is not None and self._left_empty(interval):
            return []
        corners = self._corners(interval)
        if corners is None or not len(corners):
            return []
        middle = _middle(*interval)
        stuck = self._empty_at(middle)
        if interval[0] == interval[1] and not stuck:
            return []
        if stuck or interval[1] - interval[0] <= _NARROW * interval[1]:
            self.stuck = True
            return [interval]
        return [(interval[0], middle), (middle, interval[1])]

    def _empty_at(self, v: float) -> bool:
        """Learn worst speeds until the rows leave nothing at one v; whether that came to no end.

        Behind a better design one that is better by far is asked for, so that no way of many small steps is gone.
        """
        asked, room, floor = self.gap, True, -np.inf
        for _ in range(_ROUNDS):
            self.rounds += 1
            corners = self._corners((v, v), asked, room=room)
            if corners is None or not len(corners):
                if asked <= self.gap:
                    return False
                floor = self.value - asked * abs(self.value)
                asked = float(np.sqrt(self.gap * asked)) if asked > _NEAR_GAP * self.gap else self.gap
                continue
            if self.budget.over:
                return True
            before, known = sum(len(speed) for speed in self.speeds), np.isfinite(self.value)
            if self._try(corners, v):
                left = (self.value - floor) / max(abs(self.value), 1e-300)
                asked = max(min(_BOLDER * asked, _MOST_ASKED, 0.5 * left), self.gap) if known else asked
            elif sum(len(speed) for speed in self.speeds) == before:
                if not room:
                    return True
                room = False  # what was tried misses a limit by rounding: what meets it may be left
        return True

    def _corners(self, interval: Interval, better: float | None = None, *, room: bool = True) -> FloatArray | None:
        """Corner points of what the rows leave of an interval that is better than the best by a part of it."""
        conics = self._rows(interval, self.speeds, self.gap if better is None else better, room=room)
        if conics is None:
            return None
        corners = conics.corners(None if self.best is None else np.array(self.plane.point(self.best)))
        self._conics = conics
        return corners

    def _rows(self, interval: Interval, every: list[list[float]], better: float, *, room: bool = True) -> Conics | None:
        """What limits leave at these speeds of each part, and what of it is better than the best by a part of it."""
        limits = []
        for part, speeds in zip(self.parts, every, strict=True):
            if isinstance(part, Aim):
                if not np.isfinite(self.value):
                    continue
                wanted = part.sense * (self.value - better * max(abs(self.value), 1e-300))
                limits.append((as_limit(part, wanted), speeds))
            else:
                limits.append((_widened(part) if room else part, speeds))
        return self.plane.conics(limits, interval)

    def _left_empty(self, interval: Interval) -> bool:
        """Whether one sum of the rows at the worst speeds of the best design shows that nothing is better."""
        assert self.best is not None
        conics = self._rows(interval, self._worst, self.gap)
        return conics is not None and conics.left_empty(np.array(self.plane.point(self.best)))

    def _try(self, corners: FloatArray, v: float) -> bool:
        """Exact measurement of a point or two of what the rows leave; whether a better design was found."""
        middle = corners.mean(axis=0)
        values = self._conics.rows @ monomials(middle[None, :])
        points = [middle] if (values <= 0.0).all() else [corners[0], corners[len(corners) // 2]]
        found = [self._offer(self.plane.design(float(k), float(c), v)) for k, c in points]
        return any(found)

    def _stopped(self) -> Found:
        if self.value == np.inf and self.best is not None:
            return self._found("feasible", "the goal is infinite at every design that was looked at")
        if self.best is None:
            return Found(
                "unproven", None, "nothing found and nothing proven by discs", self.name, details=self._details()
            )
        return self._found("feasible", f"discs stopped after {self.budget} before all was proven")

    def _details(self) -> dict[str, float]:
        return {"slices": self.slices, "rounds": self.rounds, "speeds": sum(len(speed) for speed in self.speeds)}

    def _found(self, status: str, claim: str) -> Found:
        aim = self.program.aim
        goal = self.value * (aim.sense if aim is not None else 1.0)
        bound = self.value - self.gap * abs(self.value) if status == "optimal" and aim is not None else float("nan")
        return Found(status, self.best, claim, self.name, bound, {**self._details(), "goal": goal})


def _is_new(speed: float, known: list[float]) -> bool:
    return all(abs(speed - value) > _SAME * abs(value) for value in known)


def _widened(limit: Limit) -> Limit:
    """A limit with the room that the exact check allows as well."""
    room = TOLERANCE * abs(limit.bound)
    return replace(limit, bound=limit.bound + room if limit.side == "at_most" else limit.bound - room)


def _first(part: Limit | Aim) -> list[float]:
    if not part.form.drives:
        return [0.0]
    found: list[float] = []
    for band in part.form.drives[0].bands:
        if band.is_point:
            found.append(band.low)
        else:
            found += np.linspace(band.low, band.high, _FIRST).tolist()
    return list(dict.fromkeys(found))


def _middle(low: float, high: float) -> float:
    return float(np.sqrt(low * high)) if low > 0.0 and high > 2.0 * low else 0.5 * (low + high)
