"""Answers of one job by the bound that gave them, and where they begin and end."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from vibopt.balancing import is_rotor
from vibopt.bracketing import narrowed
from vibopt.errors import InputError, counted
from vibopt.jobs import answer, is_scene
from vibopt.solve.loosen import as_goal
from vibopt.solve.method import Progress
from vibopt.study.holding import in_steps
from vibopt.study.many import FEWEST_TOGETHER, answered, batch
from vibopt.study.points import Point
from vibopt.study.together import Seen
from vibopt.values.fact_at import FactAt
from vibopt.work import metered

if TYPE_CHECKING:
    from vibopt.jobs import Job

CLOSE = 1e-6
"""Part of a bound to which both ends are found."""
MOST_WORK, ROUGHLY = 60_000.0, 1e-3
"""Work that is done unasked [nominal ms]; part of a bound to which ends are found where that is short."""
_ENDS = 60
"""Answers for which the work must do, or the ends are found roughly."""
_STEPS = (0.5 * CLOSE, *(CLOSE * 8.0**k for k in range(1, 6)))
"""Parts of a bound by which it is tightened to see where the goal feels it, one after the other."""
FAR = 1e6
"""Factor by which a bound is loosened to hold nothing back."""
_WIDE = 1e3
"""Factor by which a bound is wider than what is reached, so that digits are lost."""
_SCAN, _TOGETHER = 64, 26
"""Bounds that are looked at together, where many answers cost little more than one."""
_REACH = 60
"""Halvings of a bound after which it is said to have no least value."""
SAME, _ROUNDED = 1e-9, 4.0 * np.finfo(float).eps

Holds = Callable[[Point | None], bool]
Gap = tuple[float, float, Holds]


class MovedBound:
    """Answers by the bound that gave them; the bound `b` counts so that less is tighter."""

    def __init__(self, job: Job, fact: FactAt, progress: Progress | None = None, most: float = MOST_WORK) -> None:
        self.job, self.fact, self.progress, self.most = job, fact, progress, most
        self.work, self.short, self.seen = 0.0, False, Seen()
        self.least = fact.path.endswith(".at_least")
        self.sense = -1.0 if is_scene(job) and job.goal is not None and job.goal.sense == "maximise" else 1.0
        self.known: dict[float, Point | None] = {}
        self.steps: set[float] = set()
        """Bounds that designs which were found at looser ones reach: tighter by a hair the answer is another one."""
        self.asked, self.impossible, self.fades = 0, 0.0, False
        near, far = fact.value * np.array([[1.0], [1.5]]), fact.value * np.geomspace(1.0 / FAR, FAR, 4)[:, None]
        looked = (far, near) if is_scene(job) else (near,)
        self.many = any(batch(job, (fact,), one, seen=self.seen) is not None for one in looked)
        self.batch = is_scene(job) and self.many
        robust = bool(getattr(job.goal, "robust", "")) if is_rotor(job) else False
        self.tells = not (self.batch or robust)
        chosen = job.variables if is_scene(job) else ()
        self._listed = all(one.values is not None for one in chosen) if chosen else is_rotor(job) and in_steps(job)
        if not fact.value > 0.0:
            raise InputError(f"{job.name}: {fact.path} is {fact.now(1.0)}: a bound that is moved is more than zero.")

    @property
    def close(self) -> float:
        """Part of a bound to which ends are found."""
        if self.work * _ENDS <= self.most * self.asked:
            return CLOSE
        self.short = True
        return ROUGHLY

    def spent(self, part: float = 1.0) -> bool:
        """Whether a part of the work that may be done is done."""
        over = self.work > part * self.most
        self.short = self.short or over
        return over

    def value(self, b: float) -> float:
        """The bound [SI]."""
        return 1.0 / b if self.least else b

    def all(self, bounds: Sequence[float]) -> None:
        """Answer some bounds; what is close to an end may stay open where many are answered together."""
        new = [b for b in dict.fromkeys(bounds) if b not in self.known]
        if self.batch or (self.many and len(new) >= FEWEST_TOGETHER):
            self._answer(new)
        else:
            for b in sorted(new, reverse=True):
                if not self._told(b):
                    self._answer([b])
        if self.progress is not None:
            self.progress(f"trade-off, {counted(self.asked, 'answers')}", 0.0)

    def _answer(self, new: Sequence[float], *, sparing: bool = True) -> None:
        values = np.array([[self.value(b)] for b in new]).reshape(-1, 1)
        self.asked += len(new)
        try:
            sparing = sparing and self.batch
            with metered() as meter:
                points = answered(self.job, (self.fact,), values, sparing=sparing, seen=self.seen if sparing else None)
            self.work += meter.done
            for b, point in zip(new, points, strict=True):
                if point.status:
                    self._keep(b, point)
        except InputError:
            if len(new) == 1:
                self.known[new[0]] = None
            else:  # one of them no file may ask, as an isolation of more than 100 %
                self.asked -= len(new)
                for half in (new[: len(new) // 2], new[len(new) // 2 :]):
                    self._answer(half, sparing=sparing)

    def _keep(self, b: float, point: Point) -> None:
        """Remember an answer, and that the best design at a bound is the best down to what it reaches."""
        self.known[b] = point if point.good else None
        if self.tells and point.status == "infeasible":
            self.impossible = max(self.impossible, b)
        if self.tells and point.status == "optimal" and 0.0 < self.bound(point) < b * (1.0 - CLOSE):
            self.steps.add(self.bound(point))
            self.known.setdefault(self.bound(point), point)

    def _told(self, b: float) -> bool:
        """Whether the answer at a bound follows from others."""
        point = self.known.get(min((c for c in self.known if c > b), default=b))
        if b <= self.impossible:
            point = None
        elif point is None or not self.tells or point.status != "optimal" or self.bound(point) > b:
            return False
        self.known[b] = point
        return True

    def bound(self, point: Point) -> float:
        """What a design reaches, as a bound that it just keeps, whatever margins round away of it."""
        reached = self.reached(point)
        if self.least:
            return 1.0 / reached if reached > 0.0 else np.inf
        return reached + _ROUNDED * point.varied[self.fact.path].value

    def cost(self, point: Point) -> float:
        """The goal, to be small."""
        return self.sense * (point.goal.value if point.goal is not None else 0.0)

    def reached(self, point: Point) -> float:
        """The quantity itself as measured [SI]."""
        name = self.fact.path.split(".")[1]
        side = self.fact.path.rpartition(".")[2]
        margin = point.margins.get(f"{name} ({side})", point.margins.get(name, 0.0))
        bound = point.varied[self.fact.path].value
        if is_scene(self.job) and self.job.limits[name].complement:  # margins are parts of what may come through
            return 1.0 - (1.0 - bound) * (1.0 - margin if self.least else 1.0 + margin)
        return bound * (1.0 + margin if self.least else 1.0 - margin)

    def loss(self, point: Point) -> float:
        """The quantity, to be small."""
        return -self.reached(point) if self.least else self.reached(point)

    def ends(self) -> tuple[float, float, bool]:
        """The tightest bound with a design, the tightest with the goal's own best value, and whether there is one."""
        begin = 1.0 / self.fact.value if self.least else self.fact.value
        scan = [float(b) for b in begin * np.geomspace(1.0 / FAR, FAR, _SCAN)] if self.batch else []
        self.all([*scan, begin * FAR])
        open_end = self.known.get(begin * FAR)
        if all(one is None for one in self.known.values()):
            self.all([begin * 4.0**k for k in range(6)])
        good = sorted(b for b, one in self.known.items() if one is not None)
        if not good:
            raise InputError(
                f"{self.job.name}: no design was found at any bound of {self.fact.path}, so there is nothing to "
                "weigh. vibopt explain says which limits clash."
            )
        free = open_end is not None and open_end.goal is not None
        own = self.cost(open_end) if open_end is not None else 0.0

        best = self.as_good(own)
        if free and not self.batch and open_end is not None:
            high = self.bound(open_end) * (1.0 + 1e-12)  # the tightest bound, if no other design is as good
            self._from_high(high if 0.0 < high < np.inf else begin, best)
        if not self.batch:
            self._from_least()
        gaps: list[Gap] = [self._falling(lambda one: one is not None)]
        if free:
            gaps.append(self._falling(best))
        tight, *loose = [self._tightest(gap, gaps) for gap in gaps]
        return tight, (max(tight, loose[0]) if free else max(good)), free  # where they are one, in any order

    def _from_high(self, high: float, best: Holds) -> None:
        """Ask just tighter than the best design needs, and further away while another is as good: a goal is flat."""
        self.all([high])
        for step in _STEPS:
            self.all([high * (1.0 - step)])
            if not best(self.known[high * (1.0 - step)]) or self.spent(0.5):
                return

    def _from_least(self) -> None:
        """Ask on both sides of the best value that what is bounded has as a goal: that is the tightest bound."""
        name, _, side = self.fact.path.removeprefix("limits.").rpartition(".")
        if not is_scene(self.job):
            return
        try:
            with metered() as meter:
                best = answer(as_goal(self.job, name, side), explain=False, brief=True)
        except InputError:
            return
        self.work += meter.done
        self.asked += 1
        least = best.goal[1].value if best.goal is not None and best.variables else 0.0
        if 0.0 < least < np.inf:
            tight = 1.0 / least if self.least else least
            self.all([tight * (1.0 + 0.25 * CLOSE), tight * (1.0 - 0.5 * CLOSE)])

    def _falling(self, holds: Holds) -> Gap:
        """The loosest known bound that fails below those that hold, and the next; further down where none fails."""
        most = max((self.bound(point) for point in self.known.values() if point is not None), default=0.0)
        for _ in range(_REACH):
            bounds = sorted(self.known)
            fails = [
                i for i, b in enumerate(bounds[:-1]) if not holds(self.known[b]) and holds(self.known[bounds[i + 1]])
            ]
            if fails:
                return bounds[fails[-1]], bounds[fails[-1] + 1], holds
            tightest = self.known[bounds[0]]
            if min(bounds[0], self.bound(tightest) if tightest is not None else np.inf) <= CLOSE * most:
                self.fades = True
                return bounds[0], bounds[0], holds
            self.all([0.5 * bounds[0]])
        return 0.5 * bounds[0], bounds[0], holds

    def _tightest(self, gap: Gap, gaps: Sequence[Gap] = ()) -> float:
        """The tightest bound that holds: one that fails is so close to it that both are one.

        Where answers are found together those that the other `gaps` will need are asked for at once.
        """
        fails, loose, holds = gap

        def told(bounds: Sequence[float]) -> list[bool | None]:
            new = any(b not in self.known for b in bounds)
            self.all([*bounds, *(b for one in gaps if new and self.batch for b in self._inside(*self._cut(one)))])
            if not any(b in self.known for b in bounds):  # beyond what is answered together: one by one
                self._answer([bounds[len(bounds) // 2]], sparing=False)
            return [holds(self.known[b]) if b in self.known else None for b in bounds]

        return narrowed(told, loose, fails, self._inside)[0]

    def _inside(self, good: float, bad: float) -> list[float]:
        """Where to look between a bound that holds and one that fails: at what is known there, or anew."""
        count, known = _TOGETHER if self.batch else 1, sorted(b for b in self.known if bad < b < good)
        if known or good - bad <= self.close * good or self.spent(0.5):
            return known[::-1]
        return [*self.beside([good]), *(good * (bad / good) ** (k / (count + 1)) for k in range(1, count + 1))]

    def _cut(self, gap: Gap) -> tuple[float, float]:
        """The tightest bound of a gap that is known to hold, and the next, which fails."""
        bad, good, holds = gap
        inside = sorted((b for b in self.known if bad <= b < good), reverse=True)
        return next(((before, b) for before, b in pairwise((good, *inside)) if not holds(self.known[b])), (good, bad))

    def beside(self, bounds: Iterable[float]) -> list[float]:
        """Just tighter than what designs reach at some bounds: there the next design is, if there is one."""
        return [b * (1.0 - 0.5 * CLOSE) for b in bounds if b in self.steps]

    def as_good(self, cost: float) -> Holds:
        return lambda point: point is not None and self.cost(point) <= cost + SAME * abs(cost)

    def sharpen(self) -> None:
        """What designs reach that were found far inside of their bound is told anew at a near one: margins round it."""
        far = {b: point for b, point in self.known.items() if point is not None and self._far(point)}
        near = {b: self.bound(point) * (1.0 + CLOSE) for b, point in far.items()}
        if new := [b for b in dict.fromkeys(near.values()) if b not in self.known]:
            self._answer(new)
        for b, at in near.items():
            self.known[b] = self.known.get(at) or self.known[b]

    def _far(self, point: Point) -> bool:
        """Whether a design was found far inside of its bound."""
        bound = point.varied[self.fact.path].value
        return (1.0 / bound if self.least else bound) > _WIDE * self.bound(point) > 0.0

    def untie(self) -> None:
        """Of choices from lists each is asked for the tightest bound at which another is as good: ties hide it."""
        for point in self.best() if self.tells and self._listed and not self.spent() else ():
            holds, good = self.as_good(self.cost(point)), self.bound(point)
            fails = max((b for b, one in self.known.items() if b < good and not holds(one)), default=good)
            if fails < good:
                self._tightest((fails, good, holds))

    def best(self) -> list[Point]:
        """Points than which no other is better in one quantity and as good in the other, the best quantity first."""
        good = [one for one in self.known.values() if one is not None and one.goal is not None]
        good.sort(key=lambda one: (self.loss(one), self.cost(one)))
        kept: list[Point] = []
        for one in good:
            if not kept or self.cost(one) < self.cost(kept[-1]) - 1e-12 * abs(self.cost(kept[-1])):
                while kept and self.loss(one) <= self.loss(kept[-1]) * (1.0 + np.sign(self.loss(one)) * 1e-12):
                    kept.pop()
                kept.append(one)
        return kept

    def along(self, tight: float, loose: float) -> list[tuple[float, Point]]:
        """Bounds with their designs, the tightest first."""
        known = ((b, self.known[b]) for b in sorted(self.known) if tight <= b <= loose)
        return [(b, point) for b, point in known if point is not None]
