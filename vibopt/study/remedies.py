"""Where there is no design: which number of the file, changed alone and by how much, gives one.

Every number that a price is asked of is moved both ways, and the whole job is answered again.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from vibopt.answer.answer import Answer
from vibopt.answer.entry import Entry
from vibopt.answer.tabular import Tabular
from vibopt.bracketing import narrowed
from vibopt.errors import InputError
from vibopt.jobs import answer, is_scene, noun_of, with_changes
from vibopt.records import dataclass
from vibopt.scene.open_places import open_positions
from vibopt.solve.method import Progress
from vibopt.study.axis import NO_STEP, Axis, axis_of
from vibopt.study.holding import LEAST_WORK, Road
from vibopt.study.price_words import CAPS, LIMITS
from vibopt.study.prices import ALLOWANCE, asked_of, tables_of
from vibopt.study.purse import length_of
from vibopt.study.seen import GOOD, shown_value
from vibopt.units import to_unit
from vibopt.values.fact_at import FactAt
from vibopt.values.soft import softness
from vibopt.work import SpentError

if TYPE_CHECKING:
    from vibopt.jobs import Job

_DIGITS, _SHOWN = 3, 9
"""Digits to which a change is brought, and with which the number is then shown in full."""
_DECADES = (0.01, 0.04, 0.1, 0.2, 0.4, 0.7, 1.0)
"""Decades at which a number is looked at, each way; parts of the whole extent for places and angles."""
_BOUNDS = (0.04, 0.1, 0.2, 0.4, 0.7, 1.0, 2.0, 4.0)
"""The same for a bound or the end of a range, which is moved in the way that loosens it."""
_CLOSE = 1e-7
"""Part to which a number is known that is not rounded."""
_LOOSER = {"at_most": 1, "to": 1, "most": 1, "holes": 1, "most_weights": 1, "stock": 1, "deepest": 1,
           "at_least": -1, "from": -1, "least": -1}  # fmt: skip
"""The way in which what a path ends with is loosened."""


@dataclass(frozen=True, slots=True)
class Remedy:
    """A number of the file, and the nearest value found with which the whole job has a design.

    sort
        "limit", "cap" (the end of a range that is chosen from), or "fact".
    then
        In steps of the third digit of the change, solved again; None where no value helps, or none was looked for.
    change
        Part of what it is (of an angle or a place: of the extent) by which it moves; inf without one.
    weighed
        The same divided by `soft` of a limit: by this numbers are ranked.
    goal
        Of the answer with it; None without a goal.
    why
        Why there is no value; "" where there is one.
    """

    path: str
    sort: str
    now: Entry
    then: Entry | None = None
    change: float = math.inf
    weighed: float = math.inf
    goal: Entry | None = None
    why: str = ""

    @property
    def part(self) -> str:
        """The change with its sign: "-23 %"; "" where there is none."""
        if self.then is None or not math.isfinite(self.change):
            return ""
        sign = "+" if self.then.value > self.now.value else "-"
        return f"{sign}{100.0 * self.change:.3g} %"


@dataclass(frozen=True)
class Remedies(Tabular):
    """What would give a job without a design one, each number alone, the least change on top.

    found
        The answer without a design, with the limits that clash.
    rows
        Of every number that was looked at; those that do not help come last.
    notes
        What was left out, and how to get it.
    """

    job: Job
    found: Answer[Any]
    rows: tuple[Remedy, ...]
    notes: tuple[str, ...] = ()

    @property
    def helpful(self) -> tuple[Remedy, ...]:
        """Those with a value that helps."""
        return tuple(row for row in self.rows if row.then is not None)

    @property
    def first(self) -> str:
        """The least change that helps, as a sentence."""
        if not self.helpful:
            left = [row.why == _LEFT for row in self.rows]
            if left and all(left):
                return "Whether a limit, range or fact, changed alone, gives a design was not looked at."
            sought = "of those that were looked at, " * any(left)
            return f"No limit, range or fact, {sought}changed alone, was found to give a design."
        remedy = self.helpful[0]
        assert remedy.then is not None
        weighed = ", by the weights of soft limits" if remedy.change > min(row.change for row in self.helpful) else ""
        return f"The least change of one number{weighed}: {remedy.path} {remedy.now.shown} -> {remedy.then.shown}."

    @property
    def reordered(self) -> bool:
        """Whether `soft` of limits ranks the numbers otherwise than their changes do."""
        return any(remedy.change > other.change for remedy, other in pairwise(self.helpful))

    @property
    def lines(self) -> list[tuple[str, ...]]:
        """Number, change, part, and the goal with it, of those that help."""
        return [
            (row.path, f"{row.now.shown} -> {row.then.shown}", row.part, row.goal.shown if row.goal is not None else "")
            for row in self.helpful
            if row.then is not None
        ]

    @property
    def useless(self) -> str:
        """Numbers that were moved both ways and do not help, as a sentence; "" where there are none."""
        paths = [row.path for row in self.rows if row.then is None and row.why != _LEFT]
        return f"Alone no value that was looked at helps of {', '.join(paths)}." if paths else ""

    def table(self) -> list[dict[str, Any]]:
        """A row for each number, ranked: what it is and what would help, in SI and as shown."""
        return [
            {
                "path": row.path, "sort": row.sort, "unit": row.now.si, "now": row.now.value,
                "now_shown": row.now.shown, "then": None if row.then is None else row.then.value,
                "then_shown": None if row.then is None else row.then.shown,
                "change": None if row.then is None else row.change,
                "goal": None if row.goal is None else row.goal.value, "why": row.why,
            }
            for row in self.rows
        ]  # fmt: skip

    def heading(self) -> tuple[str, ...]:
        """Title, and the least change that helps."""
        return self.job.title, self.first, *self.notes

    def as_said(self) -> dict[str, Any]:
        """What helps, and the answer."""
        return {"first": self.first, "rows": self.table(), "notes": self.notes, "answer": self.found}


def without_design(job: Job, answer: Answer[Any]) -> bool:
    """Whether a job asks for a design and has none, so that remedies may be looked for."""
    return answer.status in ("infeasible", "unproven") and not (is_scene(job) and job.find_all is not None)


def remedies(
    job: Job,
    *,
    found: Answer[Any] | None = None,
    only: Collection[str] | None = None,
    thorough: bool = False,
    most: float = ALLOWANCE,
    progress: Progress | None = None,
) -> Remedies:
    """The numbers of a job without a design that, changed alone, give one, and by how much.

    Parameters
    ----------
    job
        Of any kind.
    found
        Its answer, where it is known.
    only
        Paths to look at; None for all.
    thorough
        Whatever the work.
    most
        Work [nominal ms] after which the rest is named as not looked at.
    progress
        Called with a stage and the part that is done.

    Raises
    ------
    InputError
        A job that has a design, or asks for none; a path of `only` that the file does not have.
    """
    found = answer(job) if found is None else found
    if not without_design(job, found):
        raise InputError(f"{job.name}: is {found.status}, so there is nothing to mend. See vibopt whatif FILE.")
    asked, read = asked_of(found, only, ends=True)
    search = _Search(job, found, math.inf if thorough else most)
    rows = []
    for k, (fact, sort) in enumerate(asked):
        if progress is not None:
            progress("what would help", k / len(asked))
        rows.append(search.looked_at(fact, sort))
    ranked = sorted(range(len(rows)), key=lambda k: (rows[k].weighed, k))
    left = [row.path for row in rows if row.why == _LEFT]
    notes = []
    if left:
        way = "`vibopt whatif FILE --thorough` looks at all."
        notes.append(f"Not looked at because of the work: {', '.join(left)}. {way}")
    ordered = tuple(rows[k] for k in ranked)
    if Remedies(job, found, ordered).reordered:
        said = ", ".join(f"{name} {soft:g}" for name, soft in search.soft.items())
        notes.append(f"Ranked by the change divided by the weight of a soft limit (soft: {said}).")
    if read:
        notes.append(f"The numbers of {tables_of(read)} were left as they are: they are data of {noun_of(job)}.")
    return Remedies(job, found, ordered, tuple(notes))


_LEFT = "left out because of the work"


class _Search:
    """Remedies one after the other, from one allowance of work [nominal ms]."""

    def __init__(self, job: Job, answer: Answer[Any], most: float) -> None:
        self.job, self.found, self.most, self.spent = job, answer, most, 0.0
        self.each = max(answer.work if is_scene(job) else 0.0, LEAST_WORK)
        self.extent = length_of(job)
        near = answer.nearest
        self.soft = softness(job.limits) if is_scene(job) else dict(near.soft) if near is not None else {}

    def looked_at(self, fact: FactAt, sort: str) -> Remedy:
        """The nearest value of one number with which there is a design."""
        now, axis = shown_value(fact, fact.value), axis_of(fact, lambda: self.extent, self.job)
        if axis is None:
            return self._known(fact, now) or Remedy(fact.path, sort, now, why=NO_STEP)
        if is_scene(self.job) and open_positions(self.job) and self.spent + self.each > self.most:
            return Remedy(fact.path, sort, now, why=_LEFT)
        road = Road(self.job, fact, None, self.most - self.spent)
        try:
            best = min((one for way in self._ways(fact, sort) if (one := _along(road, axis, way))), default=None)
        except SpentError:
            return self._known(fact, now) or Remedy(fact.path, sort, now, why=_LEFT)
        finally:
            self.spent += road.work
        if best is None:
            return Remedy(fact.path, sort, now, why=_none(axis, self._ways(fact, sort), sort))
        far, value = best
        answer = self._confirmed(fact, value)
        if answer is None:
            return Remedy(fact.path, sort, now, why="what helps could not be told in the digits of its unit")
        then = replace(shown_value(fact, value), digits=_SHOWN)
        part = far if axis.extent else abs(value / fact.value - 1.0)
        soft = self._soft(fact) if sort == LIMITS else 1.0
        goal = answer.goal[1] if answer.goal is not None else None
        return Remedy(fact.path, sort, now, then, part, part / soft, goal)

    def _known(self, fact: FactAt, now: Entry) -> Remedy | None:
        """The loosening of a limit that stands beside the answer, and was solved there; None where there is none."""
        name, known = fact.path.split(".")[1:2], self.found.conflict
        for limit, _, then in known.loosenings if known is not None and fact.path.startswith("limits.") else ():
            if [limit] == name and (then.value - fact.value) * _LOOSER.get(fact.path.rpartition(".")[2], 0) > 0.0:
                part = abs(then.value / fact.value - 1.0) if fact.value else math.inf
                return Remedy(fact.path, LIMITS, now, then, part, part / self._soft(fact))
        return None

    def _soft(self, fact: FactAt) -> float:
        return self.soft.get(fact.path.split(".")[1], 1.0)

    def _ways(self, fact: FactAt, sort: str) -> tuple[int, ...]:
        way = _LOOSER.get(fact.path.rpartition(".")[2], 0) if sort in (LIMITS, CAPS) else 0
        return (way,) if way else (-1, 1)

    def _confirmed(self, fact: FactAt, value: float) -> Answer[Any] | None:
        """The answer with the value as it is shown; None where that has no design."""
        found = answer(with_changes(self.job, fact.changes(value)), explain=False, brief=True)
        self.spent += found.work if is_scene(self.job) else LEAST_WORK
        return found if found.status in GOOD else None


def _along(road: Road, axis: Axis, way: int) -> tuple[float, float] | None:
    """How far the nearest value with a design is found to lie one way, and that value [SI]; None where there is none.

    Between the last value without a design and the first with one it is halved, in steps of the change's third digit.
    """
    fact = axis.fact
    steps = _BOUNDS if fact.path.startswith("limits.") or fact.path.endswith((".to", ".from")) else _DECADES
    values = list(dict.fromkeys(_rounded(fact, axis.value(way * t)) for t in steps))
    values = [one for one in values if way * (one - fact.value) > 0.0]
    bad, good = fact.value, None
    for value, state in zip(values, _states(road, values), strict=False):
        if state:
            good = value
            break
        bad = value
    if good is None:
        return None

    def middle(good: float, bad: float) -> list[float]:
        value = _rounded(fact, 0.5 * (bad + good), good)
        between = min(bad, good) < value < max(bad, good) and abs(good - bad) > _CLOSE * abs(good)
        return [value] if between else []

    good, _ = narrowed(lambda values: [_good(road, value) for value in values], good, bad, middle)
    far = abs(axis.at(good))
    return (far if math.isfinite(far) else math.inf), good


def _states(road: Road, values: list[float]) -> Iterator[bool]:
    """Whether there is a design at each value: at once where that is one batch, else one by one as they are asked."""
    if road.together:
        found = zip(values, road.at(values), strict=True)  # what the batch has not proven is asked alone
        yield from (_good(road, value) if state is None else state.status in GOOD for value, state in found)
    else:
        yield from (_good(road, value) for value in values)


def _good(road: Road, value: float) -> bool:
    return road(value).status in GOOD


def _rounded(fact: FactAt, value: float, good: float | None = None) -> float:
    """A value [SI] with three digits in the unit of the file; in steps of the third digit of a change that is good."""
    if fact.dimension == "count":
        return float(round(value))

    def in_unit(one: float) -> float:
        return to_unit(one, fact.unit, fact.dimension) if fact.unit else one

    number = in_unit(value)
    sizes = [number] if good is None else [in_unit(good), in_unit(good) - in_unit(fact.value)]
    if not all(sizes) or fact.dimension == "level":
        return value
    step = min(10.0 ** (math.floor(math.log10(abs(size) * (1.0 - 1e-9))) - _DIGITS + 1) for size in sizes)
    said = f"{round(number / step) * step:.12g}"
    return fact.read(f"{said} {fact.unit}") if fact.unit else float(said)


def _none(axis: Axis, ways: tuple[int, ...], sort: str) -> str:
    """Why a number does not help."""
    ends = [axis.value(way * (_BOUNDS if sort == LIMITS else _DECADES)[-1]) for way in ways]
    fact = axis.fact
    shown = " or ".join(shown_value(fact, end).shown for end in ends)
    return f"no value looked at up to {shown} helps alone"
