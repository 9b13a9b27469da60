"""Nonlinear programming from several starts: IPOPT on sampled speeds, then exact peaks.

IPOPT finds the region; what it calls success is not believed.  Every design is measured at its
exact peaks, the worst speeds are added, and what is left is done by Newton on the peaks themselves.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from vibopt.answer.entry import TOLERANCE
from vibopt.arrays import FloatArray
from vibopt.errors import counted
from vibopt.program.casadi_nlp import SampledProgram, Samples
from vibopt.program.program import Program
from vibopt.records import dataclass
from vibopt.solve.branch import Judge
from vibopt.solve.coalesce import polished
from vibopt.solve.link_by_link import improved_by_links
from vibopt.solve.measured_pieces import SLOPES, Exact, Point
from vibopt.solve.method import Found, Progress
from vibopt.solve.ranges import corners, halton, log_box, on_ends, starts
from vibopt.solve.regrouped import exchanged, likes
from vibopt.solve.screen import beside, on_one_body, promising, screenable
from vibopt.solve.sqp import Sqp
from vibopt.work import Budget, is_limited, late, worked

Design = tuple[float, tuple[float, ...]]
"""Goal and variables y = log x."""
_SAME = 1e-6
_MOST_FREE = 30
"""Continuous variables."""
_ROUNDING, _PLACES, _ROUNDS = 1e-9, 6, 3
_IPOPT = 50.0
"""Work of one run of IPOPT, in exact measurements."""
_MANY, _SCREENED, _BY_LIMITS = 128, 32, 10.0
"""Points to measure where no start led anywhere, and before any where most of them lead nowhere; weight of a limit."""
_AGREED, _BATCHES, _PER_VARIABLE = 4, 3, 2
"""Starts that should agree on the best, how many batches of them there may be, and how many there are per variable.

Where like devices are exchanged one start per variable is enough: all orders of them follow from one."""
_PROVABLE = 4
"""Continuous variables up to which the first design found may be proven."""
_MEASUREMENTS = 5000
"""Exact measurements of designs."""
_VAIN, _HOPS, _HOP = 2, 8, (0.8, 0.3)
"""Batches of designs beside the best, and designs, that are followed in vain before no more are, and how far (in logs)
those are put in turn."""
_FAR, _LOST = 0.05, 0.5
"""Log violation beyond which a start is not followed: where a design is known and little is to be done; at all."""
_DAMPING, _MUCH = (".damping", ".damping_ratio"), 0.25
"""Variables that limits want great, and the part of the greatest from which a start is led within limits."""
_LITTLE = 0.01
"""Part of its greatest value below which a variable may be zero."""
_ALIKE = 0.02
"""Designs this near to each other (in logs) lead to the same local optimum."""


@dataclass
class Nlp:
    """Best of several local optima, each measured at its exact peaks.

    count
        Number of starts spread over the box; its corners come on top, all of them for one or two variables.
    given
        Further starts x, each (n_vars,).
    most
        Exact measurements after which no new start is tried.
    brief
        Whether what leads nowhere better than the first design found is left as it is, and no start is added.
    proof
        Says of the first design found, in the best order of like devices, whether it is proven: then no more are tried.
    """

    count: int = 8
    most: int = _MEASUREMENTS
    given: tuple[FloatArray, ...] = ()
    brief: bool = False
    proof: Callable[[Found], Found] | None = None
    name: str = "nlp"
    summary: str = "nonlinear programming (IPOPT on sampled speeds, Newton on the exact peaks), best of several starts"

    def refuses(self, program: Program) -> str | None:
        """Discrete variables and more than thirty continuous ones."""
        for axis in program.axes:
            if axis.values is not None and len(axis.values) > 1:
                return f"nlp takes continuous variables only, but {axis.path} is chosen from {len(axis.values)} values."
        free = sum(axis.high > axis.low for axis in program.axes)
        if free > _MOST_FREE:
            return f"nlp takes at most {_MOST_FREE} variables, and there are {free}."
        for limit in program.limits:
            if limit.side == "at_most" and limit.bound <= 0.0:
                return f"nlp needs a bound greater than zero, but {limit.name} has none."
        return None

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """Best of the local optima reached from all starts."""
        return _Run(program.of_what_varies(), self, progress).answer()


def told(starts: int, agreed: int, outside: int, left: int) -> str:
    """How often the best was found from so many starts, and whether some ended outside the limits or were left.

    In words beyond a few, for such counts hang on rounding, which differs between processors.
    """
    found = f"{_AGREED} or more" if agreed >= _AGREED else agreed
    count = counted(starts, "starts")
    claim = f"best of {count}, {found} agreed" if agreed else f"better than what {count} led to"
    for failed, how in ((outside, "ended outside the limits"), (left, "were left far behind")):
        claim += f", {'most' if 2 * failed > starts else 'some'} {how}" if failed > 0 else ""
    return claim


def _first(good: list[Design]) -> Design:
    """The best; among designs whose goals differ by rounding alone the one that comes first in the order of numbers."""
    best = min(goal for goal, _ in good)
    room = _ROUNDING * abs(best) if np.isfinite(best) else 0.0
    even = [one for one in good if one[0] <= best + room]
    return min(even, key=lambda one: ([round(value, _PLACES) for value in one[1]], one[0]))


def sampleable(program: Program) -> bool:
    """Whether the sampled program says more than first slopes at one design: no poles and no mean squares in it."""
    return all(part.form.sampleable(part.model) for part in program.parts)


def blind(program: Program) -> bool:
    """Whether starts and exact slopes are all there is: a goal, continuous variables, and forms without bounds."""
    return program.aim is not None and not sampleable(program) and Nlp().refuses(program) is None


@dataclass
class _Run:
    program: Program
    method: Nlp
    progress: Progress | None

    def __post_init__(self) -> None:
        self.budget = Budget(self.method.most, "exact measurements", SLOPES * self.program.cost)
        self.low, self.high = log_box(self.program)
        self.exact = Exact(self.program, self.low, self.high, self.budget)
        self.judge = Judge(self.program)
        self.samples = Samples(self.program).spread(9)
        self.built = self.iterations = self.starts = self.left = 0
        self.ends: list[Design] = []
        self.bar = np.inf
        self.orders: list[float] = []
        self.likes = [] if self.method.brief else likes(self.program)
        self.proven: Found | None = None

    def answer(self) -> Found:
        good = self._straight() or self._searched(self._starts())
        if self.proven is not None:
            return self.proven
        if not good:
            claim = f"no design found from {counted(self.starts, 'starts')}, which proves nothing"
            return Found("unproven", None, claim, self.method.name, details=self._details(0))
        if self.program.is_best(min(good)[0]):
            x, claim = self._x(np.array(min(good)[1])), "the ranges alone permit no better goal"
            return Found("feasible", x, claim, self.method.name, details=self._details(1))
        good += self._mirrored(good)
        good += self._beside(good)
        good += self._mirrored(good)
        good += self._settled(good)
        goal, y = _first(good)
        agreed = self._agree(good)
        x, details = self._x(np.array(y)), self._details(agreed)
        if goal == np.inf:
            claim = "the goal is infinite at every design that was looked at"
            return Found("feasible", x, claim, self.method.name, details=details)
        claim = told(self.starts, agreed, self.outside, self.left)
        x, settled = improved_by_links(self.program, x, self.judge, self.budget)
        if self.judge.goal(x).value < goal - _SAME * abs(goal):
            claim = f"best of {counted(self.starts, 'starts')}, made better one link at a time"
        if settled:
            claim += "; no other spring and damper of one link alone is better, which is proven"
        return Found("feasible", x, claim, self.method.name, details=details)

    @property
    def outside(self) -> int:
        """How many starts were followed to their end and are outside the limits there."""
        return self.starts - self.left - len(self.ends)

    def _straight(self) -> list[Design]:
        """Sharpened at once from the most promising of many designs, where many can be looked at for little."""
        if self.method.given or not screenable(self.program):
            return []
        least = max(int(self.exact.free.sum()) * (1 if self.likes else _PER_VARIABLE), _AGREED)
        better = list[Design]()
        told = self.method.proof is None or int(self.exact.free.sum()) > _PROVABLE or is_limited()
        for y in promising(self.program, _BATCHES * self.method.count):
            self._sharpened([y])
            last = self.starts >= least
            better += self._mirrored([*self.ends, *better]) if self.ends and (last or not told) else []
            if self.ends and not told and self._is_proven([*self.ends, *better]):
                break
            told = told or bool(self.ends)
            last = last and (not self.ends or self._agree(better) >= _AGREED)
            if last or self.budget.over or (self.ends and self.program.is_best(min(self.ends)[0])):
                break
        return [*self.ends, *better]

    def _is_proven(self, good: list[Design]) -> bool:
        """Whether the best is proven, by what is asked before further starts."""
        goal, y = _first(good)
        if self.method.proof is not None and np.isfinite(goal) and not self.program.is_best(goal):
            begun = Found(
                "feasible", self._x(np.array(y)), "", self.method.name, details=self._details(self._agree(good))
            )
            found = self.method.proof(begun)
            self.proven = found if found.status == "optimal" else None
        return self.proven is not None

    def _mirrored(self, good: list[Design]) -> list[Design]:
        """What the best leads to with the numbers of two like devices exchanged, as long as that is better.

        Absorbers on one body have a local optimum for each order of their tunings, and starts may see one of them only.
        The goals of all orders that were tried are kept: a start that ends at one of them agrees with the best.
        """
        found: list[Design] = []
        if not self.likes or _among(min(good)[0], self.orders):
            return found
        self.orders, waiting = [min(good)[0]], [*self.likes]
        while waiting and not self.budget.over:
            goal, best = min([*good, *found])
            y = np.clip(exchanged(self.program, np.array(best), *waiting.pop(0)), self.low, self.high)
            same = abs(self.judge.goal(self._x(y)).value - goal) <= _ROUNDING * abs(goal)
            if not np.isfinite(goal) or same:  # the like of it is the same machine
                continue
            ends = self._good([self._sharp(y, bar=np.inf)])  # far above it begins, below it may end
            self.orders += [end for end, _ in ends]
            better = [one for one in ends if one[0] < goal - _SAME * abs(goal)]
            waiting = [*self.likes] if better else waiting
            found += better
        return found

    def _settled(self, good: list[Design]) -> list[Design]:
        """What the best leads to when it is followed to its end, what is next to zero in it at zero or not.

        Next to zero a slope in logs is next to nothing, and steps towards the end of a range stop short of it.
        """
        goal, best = min(good)
        if self.method.brief or self.program.aim is None or self.budget.over or not np.isfinite(goal):
            return []
        y = np.array(best)
        none = [axis.low <= 0.0 for axis in self.program.axes] & (y < self.high + np.log(_LITTLE))
        begun = [np.where(none, self.low, y), y] if none.any() else [y]
        ends = self._good([Sqp(self.exact).run(one, within=True).y for one in begun])
        return [one for one in ends if one[0] < goal - _ROUNDING * abs(goal)]

    def _beside(self, good: list[Design]) -> list[Design]:
        """What designs beside the best lead to: with devices in other ways, or where the best was not found again."""
        if self.method.brief or self.method.given or not screenable(self.program) or len(self.exact.free) < 3:
            return []
        found: list[Design] = []
        found_again = on_one_body(self.program) and self._agree(good) >= _AGREED
        vain, batch, several = 0, 0, not found_again
        while several and vain < _VAIN and not self.budget.over:
            goal, best = min([*good, *found])
            fresh = beside(self.program, np.array(best), batch)[:_HOPS]
            several, batch = bool(fresh), batch + 1
            for y in fresh:
                found += self._sharpened([y])
            vain = 0 if min([*good, *found])[0] < goal - _SAME * abs(goal) else vain + 1
        vain = 0
        for number, step in enumerate(halton(_BATCHES * _HOPS, len(self.low)) - 0.5):
            goal, best = min([*good, *found])
            if several or vain == _HOPS or self.budget.over or self._agree([*good, *found]) >= _AGREED:
                break
            found += self._sharpened([np.clip(np.array(best) + _HOP[number % 2] * step, self.low, self.high)])
            vain = 0 if min([*good, *found])[0] < goal - _SAME * abs(goal) else vain + 1
        return found

    def _searched(self, begun: list[FloatArray]) -> list[Design]:
        """What all starts lead to that meets every limit: by sampled speeds first, then refined."""
        reached = self._sampled(begun) if sampleable(self.program) else list(begun)
        if sampleable(self.program) and not any(self._missed(y) < _LOST for y in reached):
            reached = self._sampled(begun, elastic=True)
        reached = sorted(reached, key=self._missed)
        self.starts = self.left = 0
        good = self._sharpened(reached)
        if not good:
            self.starts = self.left = 0
            good = self._sharpened(reached, rescue=True)
        if not good:
            good = self._good(reached)
            self.ends += good
        good = good or self._sharpened(self._likely(), rescue=True)
        return good + self._more(good) if good else good

    def _more(self, good: list[Design]) -> list[Design]:
        """What further starts lead to, where few of the first ones agree on the best."""
        found: list[Design] = []
        for batch in range(1, 1 if self.method.brief else _BATCHES):
            best, agreed = min([*good, *found])[0], self._agree([*good, *found])
            if self.budget.over or not np.isfinite(best) or agreed >= _AGREED or not sampleable(self.program):
                break
            if self.program.is_best(best):
                break
            count = self.method.count
            fresh = [
                np.clip(y, self.low, self.high) for y in starts(self.program, (batch + 1) * count)[batch * count :]
            ]
            found += self._sharpened(sorted(self._sampled(fresh), key=self._missed))
        return found

    def _good(self, points: Sequence[FloatArray | None]) -> list[Design]:
        """Goal and design of the points at which every limit holds."""
        return [(self.judge.goal(self._x(y)).value, tuple(y)) for y in points if y is not None and self._feasible(y)]

    def _likely(self) -> list[FloatArray]:
        """Of many points spread over the box, those that miss the limits least."""
        points = [np.clip(y, self.low, self.high) for y in starts(self.program, _MANY)]
        return sorted(points, key=self._missed)[: self.method.count]

    def _starts(self) -> list[FloatArray]:
        spread = [*starts(self.program, self.method.count), *corners(self.low, self.high)]
        if any(part.form.screened for part in self.program.parts):
            spread = self._screened(spread)
        given = [np.log(np.maximum(x, np.exp(self.low))) for x in self.method.given]
        return [np.clip(one, self.low, self.high) for one in [*given, *spread]]

    def _screened(self, spread: list[FloatArray]) -> list[FloatArray]:
        """The most promising of many designs, where some lie on plains on which nothing leads anywhere."""
        points = [np.clip(y, self.low, self.high) for y in [*spread, *starts(self.program, _SCREENED)]]
        merit = [self._merit(self._x(y)) for y in points]
        return [points[i] for i in np.argsort(merit, kind="stable")[: self.method.count]]

    def _merit(self, x: FloatArray) -> float:
        """Log of the goal and what limits are missed by, the less the better."""
        missed = max((self.judge.limit(limit, x)[0] for limit in self.program.limits), default=0.0)
        goal = self.judge.goal(x).value
        level = np.sign(goal) * np.log(abs(goal)) if goal and np.isfinite(goal) else 0.0
        return float(level + _BY_LIMITS * np.log1p(max(missed, 0.0))) if np.isfinite(goal) else np.inf

    def _sampled(self, begun: list[FloatArray], *, elastic: bool = False) -> list[FloatArray]:
        """Where IPOPT leads from every start, the worst speeds added and solved again a few times."""
        if self.program.aim is None:
            elastic = True
        here = list(begun)
        for step in range(_ROUNDS):
            fresh = [not self.budget.over and self._learn(y) for y in here] if step else [True]
            if not any(fresh):
                break
            reference = here[0] if step else 0.5 * (self.low + self.high)
            nlp = SampledProgram(self.samples, np.exp(reference), self.low, self.high, elastic=elastic)
            self.built += 1
            for i, y in enumerate(here):
                if late("the search from several starts"):
                    return here
                if step == 0 or fresh[i]:
                    here[i] = nlp.solve(y).y
                    self.iterations += 1
                    worked(_IPOPT * self.program.cost)
                if self.progress:
                    self.progress("starts", (step + (i + 1) / len(here)) / _ROUNDS)
        return here

    def _learn(self, y: FloatArray) -> bool:
        """Add the speeds at which the design y is worst; whether it is worth solving again from it."""
        return self.samples.learn(np.exp(y), 3) and self._missed(y) > 1e-6

    def _sharpened(self, begun: list[FloatArray], *, rescue: bool = False) -> list[Design]:
        """What starts lead to within the limits, each followed to its exact optimum, until one is as good as may be."""
        done: list[tuple[FloatArray, FloatArray | None]] = []
        found: list[Design] = []
        for y in begun:
            way = next((one for one in done if np.abs(one[0] - y).max() < _ALIKE), None)
            if way is None:
                idle = self.budget.over or (self.method.brief and self._beaten(y, [*self.ends, *found]))
                way = y, None if idle else self._sharp(y, rescue=rescue)
                done.append(way)
            self.starts, self.left = self.starts + 1, self.left + (way[1] is None)
            good = self._good([way[1]])
            found += good
            if good and self.program.is_best(good[0][0]):
                break
        self.ends += found
        return found

    def _agree(self, others: Sequence[Design] = ()) -> int:
        """How many starts agree on the best of all: they are as good, or as what it leads to in another order."""
        best = min([*self.ends, *others], default=(np.inf,))[0]
        orders = self.orders if _among(best, self.orders) else [best]
        return sum(_among(goal, orders) for goal, _ in self.ends) if np.isfinite(best) else 0

    def _beaten(self, y: FloatArray, found: list[Design]) -> bool:
        """Whether a design found is no worse than y, which holds at some speeds only, or y is far from holding."""
        best = min((goal for goal, _ in found), default=np.inf)
        far = best < np.inf and self._missed(y) > _FAR
        return far or self.judge.goal(self._x(y)).value >= best - _SAME * abs(best)

    def _missed(self, y: FloatArray) -> float:
        """Log violation, 0 where every limit holds or where no measurement is left."""
        return max(self.exact.at(y).missed, 0.0) if not self.budget.over else 0.0

    def _sharp(self, y: FloatArray, *, rescue: bool = False, bar: float | None = None) -> FloatArray | None:
        """The exact optimum that y leads to; None where it falls behind the best known and is left."""
        sharpener = Sqp(self.exact, bar=self.bar if bar is None else bar)
        if rescue:
            y = sharpener.run(y, only_feasible=True).y
        point: Point = sharpener.run(y)
        if sharpener.behind:
            return None
        if point.missed > TOLERANCE and not rescue and not self.budget.over:
            held = sharpener.run(self._damped(y), only_feasible=True)
            point = sharpener.run(held.y, within=True) if held.missed <= TOLERANCE else point
        if point.missed <= TOLERANCE and self.program.aim is not None:
            self.bar = min(self.bar, point.goal)
        return polished(
            self.program, point.y, (self.low, self.high), self._feasible, lambda y: self.judge.goal(self._x(y)).value
        )

    def _damped(self, y: FloatArray) -> FloatArray:
        """The start with no little damping: next to nothing of it bounds no stroke, and no slope in logs says so."""
        damping = [axis.path.endswith(_DAMPING) and not axis.open_high for axis in self.program.axes]
        return np.asarray(np.where(damping, np.maximum(y, self.high + np.log(_MUCH)), y))

    def _x(self, y: FloatArray) -> FloatArray:
        """Design at y: exactly on the ends of its ranges where it is next to them."""
        return on_ends(self.program, y)

    def _feasible(self, y: FloatArray) -> bool:
        return self.judge.feasible(self._x(y))

    def _details(self, agreed: int) -> dict[str, float]:
        return {
            "starts": self.starts,
            "agreed": agreed,
            "ended outside the limits": self.outside,
            "left far behind": self.left,
            "programs built": self.built,
            "ipopt runs": self.iterations,
            "exact measurements": self.budget.spent,
            "sampled speeds": sum(len(speed) for speed in self.samples.speeds.values()),
        }


def _among(goal: float, known: Sequence[float]) -> bool:
    """Whether a goal is one of those known, which may be endless."""
    return any(abs(goal - other) <= _SAME * max(abs(other), 1e-300) for other in known if np.isfinite(other))
