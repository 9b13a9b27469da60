"""An answer of any kind with the values that stand on the drawing: rounded, and measured as rounded."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING, Any, ClassVar

from vibopt.errors import InputError, counted
from vibopt.jobs import facts
from vibopt.records import dataclass
from vibopt.study.grids import DIGITS, Grid, Number, grids
from vibopt.study.holding import wider
from vibopt.units import plain

if TYPE_CHECKING:
    from vibopt.answer.answer import Answer
    from vibopt.answer.entry import Entry
    from vibopt.jobs import Job

MOST_FREE = 8
"""Numbers that are moved; of more, those that lie nearest to the middle between two steps."""
ROOMS = (0.001, 0.003, 0.01, 0.03, 0.1)
"""Parts by which bounds are tightened for an answer with room to be rounded, where none near the best holds."""
MOST_TRIED = 512
"""Most combinations of one reach; of a wider one none are looked at."""
_SAME = 1e-12
_BEYOND = 100.0
"""A goal so many times worse was as good as zero, and is not said as a part of it."""
Texts = Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Near:
    """One rounding: texts by path, the job with them as facts, and its measurement.

    broken, by
        What is broken most, and by what part of its bound; "" and 0 where nothing is.
    x
        Of a machine its design.
    """

    texts: Texts
    kept: Job
    answer: Answer[Any]
    broken: str
    by: float
    x: tuple[float, ...] = ()
    tried: int = 1

    @property
    def good(self) -> bool:
        return not self.broken


@dataclass(frozen=True, slots=True)
class Value:
    """A number of the design: exact, rounded, and the text that stands on the drawing."""

    exact: Entry
    rounded: Entry


@dataclass(frozen=True, slots=True)
class Rounded:
    """What rounding does to a design.

    design
        With the rounded values, every limit measured on the machine that has them.  Its status is `feasible`
        where they keep all limits and `violated` where no rounding does.
    kept
        The scene with the rounded values as facts.
    exact
        The answer that was rounded.
    values
        By path of the number in `kept`.
    worse_by
        What rounding costs, as a part of the exact goal; negative where the rounded one is better; None without a
        goal, or where the exact one is zero.
    tried
        Roundings looked at.
    goal
        With the rounded values.
    broken, by
        The limit that the nearest rounding breaks most, and by what part of its bound; "" and 0 where none breaks.
    enough
        Digits with which all limits hold, where they do not as asked; None where none was found.
    """

    design: Answer[Any]
    kept: Job
    exact: Answer[Any]
    values: Mapping[str, Value]
    worse_by: float | None
    tried: int
    goal: Entry | None = None
    broken: str = ""
    by: float = 0.0
    enough: int | None = None


class Rounding(ABC):
    """How an answer to one kind of job is rounded.

    The nearest values are taken where they keep every limit; else every combination of the values below and above,
    best goal first; where none of them does, those further away (`reaches`), and at last those near the best answer for
    bounds that are tighter by up to a tenth.
    """

    reaches: ClassVar[tuple[int, ...]] = (1,)
    """Steps below and above that are looked at, one reach after another."""
    sense = 1.0
    """-1 where more of the goal is better."""

    def __init__(self, job: Any, answer: Answer[Any]) -> None:
        self.job, self.found = job, answer

    @abstractmethod
    def kept(self, answer: Answer[Any]) -> Any:
        """The job with what an answer chose as facts."""

    @abstractmethod
    def numbers(self, kept: Any) -> list[Number]:
        """What is rounded."""

    @abstractmethod
    def measured(self, kept: Any, texts: Texts) -> Near | None:
        """A rounding measured; None where it leaves the ranges of the file."""

    @abstractmethod
    def cost(self, kept: Any, texts: Texts) -> float | None:
        """The goal with some values, to be small; None where these leave the ranges of the file."""

    def missed(self, kept: Any, texts: Texts) -> float:
        """By how much the worst limit is missed; nothing is above zero."""
        near = self.measured(kept, texts)
        return math.inf if near is None else near.by

    @abstractmethod
    def again(self, changes: Mapping[str, str | float]) -> Answer[Any] | None:
        """The best answer under other bounds; None where it is no neighbour."""

    @abstractmethod
    def goal(self, best: Near) -> Entry | None:
        """What was made best, with the rounded values."""

    @abstractmethod
    def design(self, best: Near, values: Mapping[str, Value]) -> Answer[Any]:
        """The answer with the rounded values, every limit as measured."""

    def rounded(self, asked: Sequence[str]) -> Rounded:
        """The nearest rounding with what is known of it."""
        exact, (steps, best, enough) = self.found, self._nearest(asked)
        values = {step.path: Value(step.exact, step.shown(best.texts[step.path])) for step in steps}
        same = all(
            abs(value.rounded.value - value.exact.value) <= _SAME * abs(value.exact.value) for value in values.values()
        )
        goal, words = self.goal(best), f"to {', '.join(dict.fromkeys(step.words for step in steps))}"
        worse = 0.0 if same and goal is not None else self._worse(goal)
        done = Rounded(exact, best.kept, exact, values, worse, best.tried, goal, best.broken, best.by, enough)
        made = self.design(best, values)
        status = "violated" if not best.good else exact.status if same else "feasible"
        claim = exact.claim if same and best.good else claim_of(done, words)
        named = None if exact.goal is None or goal is None else (exact.goal[0], goal)
        details = {**made.details, "rounded": _plain(done, words)}
        return replace(done, design=replace(made, status=status, claim=claim, goal=named, details=details))

    def _worse(self, goal: Entry | None) -> float | None:
        """What rounding costs as a part of the exact goal; None where that is nothing but rounding."""
        if self.found.goal is None or goal is None:
            return None
        exact = self.found.goal[1].value
        size = max(abs(exact), abs(goal.value))
        if abs(exact) <= size / _BEYOND:
            return None if size else 0.0
        return self.sense * (goal.value - exact) / abs(exact)

    def _nearest(self, asked: Sequence[str]) -> tuple[list[Grid], Near, int | None]:
        """Where numbers may stand, the best rounding, and, where it breaks a limit, the digits that would do."""
        kept = self.kept(self.found)
        own = self.numbers(kept)
        steps = grids(own, asked)
        best = self.search(kept, steps, self.reaches)
        if best.good:
            return steps, best, None
        roomy = list(self._roomy())
        spare = self._roomiest(roomy, asked)
        if spare is not None and spare.texts.keys() == best.texts.keys():
            return steps, replace(spare, tried=best.tried + spare.tried), None
        finer = range(min(max(step.digits for step in steps) + 1, DIGITS), DIGITS + 1)
        return steps, best, next((n for n in finer if self._holds(kept, own, roomy, str(n))), None)

    def _holds(self, kept: Any, own: Sequence[Number], roomy: Sequence[Any], digits: str) -> bool:
        near = self.search(kept, grids(own, (digits,)), (1,))
        return near.good or self._roomiest(roomy, (digits,)) is not None

    def search(self, kept: Any, steps: Sequence[Grid], reaches: Sequence[int]) -> Near:
        """The nearest rounding if it holds, else the best that does, else the one that misses least."""
        nearest = {step.path: step.nearest for step in steps}
        tried = {tuple(nearest.values())}
        found = [one] if (one := self.measured(kept, nearest)) is not None else []
        if found and found[0].good:
            return found[0]
        missing: tuple[float, Texts] | None = None
        for reach in reaches:
            for texts in self._by_goal(kept, _combinations(steps, reach)):
                if tuple(texts.values()) in tried:
                    continue
                tried.add(tuple(texts.values()))
                missed = self.missed(kept, texts)
                one = self.measured(kept, texts) if missed <= 0.0 else None
                if one is not None and one.good:
                    return replace(one, tried=len(tried))
                if missing is None or missed < missing[0]:
                    missing = missed, texts
        if missing is not None and (one := self.measured(kept, missing[1])) is not None:
            found.append(one)
        if not found:
            raise InputError(f"{self.job.name}: no rounded value lies within the range that was given. Round finer.")
        return replace(min(found, key=lambda one: one.by), tried=len(tried))

    def _by_goal(self, kept: Any, given: Iterator[dict[str, str]]) -> list[dict[str, str]]:
        """Those within the ranges, best goal first."""
        ranked = [(self.cost(kept, texts), texts) for texts in given]
        inside = [(cost, texts) for cost, texts in ranked if cost is not None]
        return [texts for _, texts in sorted(inside, key=lambda one: one[0])]

    def _roomy(self) -> Iterator[Any]:
        """Answers that are best for tighter bounds, as facts under the bounds as they are."""
        bounds = [fact for fact in facts(self.job) if fact.path.startswith("limits.") and fact.value > 0.0]
        for part in ROOMS:
            try:
                answer = self.again(wider(bounds, -part))
            except InputError:
                return
            if answer is None:
                return
            yield self.kept(answer)

    def _roomiest(self, roomy: Sequence[Any], asked: Sequence[str]) -> Near | None:
        """A rounding near one of them that keeps the bounds as they are, the first with the best goal."""
        for kept in roomy:
            steps = grids(self.numbers(kept), asked)
            found = self.search(kept, steps, (1,)) if len(steps) <= MOST_FREE else None
            if found is not None and found.good:
                return found
        return None


def _combinations(steps: Sequence[Grid], reach: int) -> Iterator[dict[str, str]]:
    """Every number so many steps down and up; of more than eight the rest to the nearest."""
    free = sorted(steps, key=lambda grid: grid.doubt, reverse=True)[:MOST_FREE]
    ways = [step.around(reach) if step in free else (step.nearest,) for step in steps]
    if reach > 1 and math.prod(map(len, ways)) > MOST_TRIED:
        return
    for texts in product(*ways):
        yield {step.path: text for step, text in zip(steps, texts, strict=True)}


def claim_of(found: Rounded, asked: str) -> str:
    """What is known of the rounded values, and what of the exact ones."""
    exact = found.exact
    if found.broken:
        by = f" by {plain(100.0 * found.by, 2)} %" if math.isfinite(found.by) else ""  # a rule of a plane has no size
        words = f"no rounding {asked} near the exact values keeps every limit ({found.tried} tried)"
        words += f"; the best breaks {found.broken}{by}"
        way = f"{counted(found.enough, 'digits')} would do" if found.enough else f"nor do {DIGITS} digits"
        return f"{words}; {way}"
    cost = cost_words(found)
    known = {"optimal": "which are proven best", "feasible": "of which it is not proven that they are the best"}
    of = f"the exact values, {known.get(exact.status, 'which were found')} ({exact.claim})"
    return f"values rounded {asked}, every limit measured with them; {cost} {of}"


def cost_words(found: Rounded) -> str:
    """What rounding costs in the goal: "the goal is 0.12 % worse than that of"."""
    if found.worse_by is None:
        goals = found.goal.shown if found.goal is not None else "not known", found.exact.goal
        return f"the goal is {goals[0]} instead of {goals[1][1].shown if goals[1] else 'none'} with"
    if abs(found.worse_by) < 1e-9:
        return "the goal is the same as that of"
    way = "worse" if found.worse_by > 0.0 else "better, for ratios of the file hold only nearly,"
    return f"the goal is {plain(100.0 * abs(found.worse_by), 2)} % {way} than that of"


def _plain(found: Rounded, asked: str) -> dict[str, Any]:
    """For JSON."""
    goal = found.exact.goal
    return {
        "asked": asked,
        "exact": {
            "status": found.exact.status,
            "claim": found.exact.claim,
            "goal": goal[1] if goal else None,
        },
        "worse_by": found.worse_by,
        "values": dict(found.values),
        "tried": found.tried,
        "broken": found.broken,
        "broken_by": found.by if math.isfinite(found.by) else None,
        "enough_digits": found.enough,
    }
