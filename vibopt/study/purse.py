"""What numbers of a file buy, one after the other, from one allowance of work; the same by several processes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from vibopt.answer.answer import Answer
from vibopt.answer.entry import Entry, Way
from vibopt.document.mistakes import Mistakes
from vibopt.errors import VibOptError
from vibopt.jobs import facts, is_scene, of_document
from vibopt.records import cached_property, dataclass
from vibopt.study.axis import NO_STEP, Axis, axis_of
from vibopt.study.holding import LEAST_WORK, Road, State, is_looser, state_of
from vibopt.study.one_way import Along
from vibopt.study.price_words import LIMITS, OF_WORK
from vibopt.study.seen import shown_value
from vibopt.values.fact_at import FactAt
from vibopt.work import SpentError, each_answer_within, seconds_of_each_answer

if TYPE_CHECKING:
    from vibopt.jobs import Job
    from vibopt.study.workers import Lost, Pool

_A_RANGE, _FEW = 30, 6
"""Answers that both ranges of a number take, one by one; and fewer, with which something is told of them."""
_DEAR, _SMALL = 8.0, 2_000.0
"""How much more work than the answer as it is another may take, and how much any may [nominal ms]."""


@dataclass(frozen=True, slots=True)
class Ranked:
    """A number of the file and what moving it does.

    sort
        "limit", "cap" (the end of a range that is chosen from), or "fact".
    now
        As it is.
    ways
        Downward and upward, as far as they were looked at.
    why
        Why there is none, or no range; "" where both are there.
    """

    path: str
    sort: str
    now: Entry
    ways: tuple[Way, ...] = ()
    why: str = ""

    @property
    def name(self) -> str:
        """As it is spoken of: a limit by its name."""
        steps = self.path.split(".")
        return steps[1] if self.sort == LIMITS and len(steps) == 3 else self.path

    @property
    def best(self) -> Way | None:
        """The way that helps most, or hurts least; None where neither has a design."""
        known = [way for way in self.ways if way.change is not None]
        return max(known, key=lambda one: one.change or 0.0, default=None)

    @property
    def gain(self) -> float:
        """Part of the goal that a sensible step buys, 0 where it buys nothing."""
        best = self.best
        return max((best.change or 0.0) if best is not None else 0.0, 0.0)

    @property
    def weight(self) -> tuple[float, float]:
        """By which numbers are ranked: what a step buys, then what one may cost."""
        return self.gain, max((abs(way.change or 0.0) for way in self.ways), default=-1.0)

    @property
    def ranged(self) -> bool:
        """Whether its ranges were looked for."""
        return bool(self.ways) and all(way.far is not None or way.until is not None for way in self.ways)

    def to_json(self) -> dict[str, Any]:
        """Every field, the gain and the name too."""
        said = {name: getattr(self, name) for name in ("path", "name", "sort", "now", "gain", "why")}
        return {**said, "ways": list(self.ways)}


@dataclass(frozen=True, slots=True)
class _Errand:
    """One number to be looked at, here or by another process.

    document, name
        The job, which travels lightly so.
    known, beside
        Answers and designs that are there already, by value.
    ways
        Directions in which it steps, or the steps that are followed.
    most, each, share, step
        Work that all of it may take, one answer, and each way, which then tells what it knows; and what a step took
        [nominal ms].
    """

    document: Mapping[str, Any]
    name: str
    axis: Axis
    here: State
    near: Sequence[float] | None
    sense: int
    key: str
    loose: int
    ways: tuple[int, ...] | tuple[Way, ...]
    each: float
    seconds: float | None
    known: Mapping[float, State]
    beside: Mapping[float, tuple[float, ...]]
    most: float = math.inf
    share: float = math.inf
    step: float = 0.0

    @property
    def fact(self) -> FactAt:
        """The number."""
        return self.axis.fact

    def road(self, job: Job) -> Road:
        """The answers along it."""
        return Road(job, self.fact, self.near, self.most, self.each, dict(self.known), dict(self.beside))


@dataclass(frozen=True, slots=True)
class _Seen:
    """What an errand has found: ways, None where the work did not do; the work, and the answers, also for others."""

    ways: tuple[Way, ...] | None
    work: float
    known: Mapping[float, State]
    beside: Mapping[float, tuple[float, ...]]


def _looked(errand: _Errand, job: Job) -> _Seen:
    """What is found of a number of a job."""
    road = errand.road(job)
    along = Along(
        road, errand.axis, errand.here, errand.sense, errand.key, errand.loose,
        lambda state: state.worst.get(errand.key),
    )  # fmt: skip
    ways: tuple[Way, ...] | None
    found = list[Way]()
    try:
        for way in errand.ways:
            road.most = min(errand.most, road.work + errand.share)
            if isinstance(way, Way):
                found.append(along.ranged(way, 1 if errand.axis.at(way.value.value) > 0.0 else -1))
            else:
                found.append(along.stepped(way))
        ways = tuple(found)
    except SpentError:
        ways = None
    return _Seen(ways, road.work, road.known, road.beside)


def _sent(errand: _Errand) -> _Seen | VibOptError:
    """The same in another process."""
    try:
        with each_answer_within(errand.seconds):
            return _looked(errand, of_document(errand.document, Mistakes(errand.name, None)))
    except VibOptError as error:
        return error


class Purse:
    """Prices one after the other, from one allowance of work.

    Each number is looked at as long as the work of those before it, which counts in their order, leaves what it takes;
    so several processes of a `pool` find what one finds.
    """

    def __init__(self, found: Answer[Any], sense: int, pool: Pool | None = None) -> None:
        self.found, self.sense, self.pool = found, sense, pool
        self.job: Job = (found.job.asked or found.job) if is_scene(found.job) else found.job
        self.each = max(found.work, LEAST_WORK)
        self.spent = 0.0
        self._errands: dict[str, _Errand] = {}

    @cached_property
    def extent(self) -> float:
        """How far apart places are [m]."""
        return length_of(self.job)

    @cached_property
    def here(self) -> State:
        """What holds the answer back as it is."""
        return state_of(self.job, self.found, 0.0)

    def stepped(
        self, asked: Sequence[tuple[FactAt, str]], most: float, told: Callable[[int], None], *, loosened: bool = False,
        begin: float = math.inf,
    ) -> list[Ranked]:  # fmt: skip
        """What a sensible step each way of each number does, or of a bound the `loosened` one alone.

        Of none that does not `begin` before so much work is done.
        """
        rows = [Ranked(fact.path, sort, shown_value(fact, fact.value)) for fact, sort in asked]
        errands = [self._errand(fact, loosened) for fact, _ in asked]
        needs = [0.0 if one is None else len(one.ways) for one in errands]
        for k, seen in self._in_order(errands, needs, most, told, begin):
            errand = errands[k]
            if errand is None:
                rows[k] = replace(rows[k], why=NO_STEP)
            elif seen is None or seen.ways is None:
                rows[k] = replace(rows[k], why=OF_WORK)
            else:
                rows[k] = replace(rows[k], ways=seen.ways)
                step = seen.work / max(len(seen.ways), 1)
                self._errands[rows[k].path] = replace(errand, known=seen.known, beside=seen.beside, step=step)
        return rows

    def ranged(
        self, rows: Sequence[Ranked], most: float, told: Callable[[int], None], *, shared: bool = False
    ) -> list[Ranked]:
        """The same rows with how far each way goes on; where the work is `shared`, each with as much of it."""
        found, share = list(rows), (most - self.spent) / (2.0 * max(len(rows), 1)) if shared else math.inf
        known = [self._errands.get(row.path) for row in rows]
        errands = [
            None if one is None or 2.0 * share < _FEW * one.step else replace(one, ways=row.ways, share=share)
            for one, row in zip(known, rows, strict=True)
        ]
        needs = [0.0 if one is None or shared or one.road(self.job).together else _A_RANGE for one in errands]
        for k, seen in self._in_order(errands, needs, math.inf if shared else most, told):
            if known[k] is not None:
                found[k] = replace(rows[k], ways=rows[k].ways if seen is None or seen.ways is None else seen.ways)
                found[k] = replace(
                    found[k], why=f"its range was {OF_WORK}" if found[k].ways and not found[k].ranged else ""
                )
        return found

    def _errand(self, fact: FactAt, loosened: bool) -> _Errand | None:
        """What is asked of a number; None where nothing says how large a step is."""
        axis = axis_of(fact, lambda: self.extent, self.job)
        if axis is None:
            return None
        ways = [way for way in (-1, 1) if axis.step(way) != fact.value]
        if loosened:
            ways = [way for way in ways if is_looser(fact.path, axis.step(way) - fact.value)]
        near = self.found.x if is_scene(self.job) and self.job is self.found.job else None
        here = replace(self.here, value=fact.value)
        key, loose = self._key(fact.path)
        return _Errand(
            self.job.document, self.job.name, axis, here, near, self.sense, key, loose, tuple(ways),
            max(_DEAR * self.each, _SMALL), seconds_of_each_answer(), {fact.value: here}, {},
        )  # fmt: skip

    def _in_order(
        self, errands: Sequence[_Errand | None], needs: Sequence[float], most: float, told: Callable[[int], None],
        begin: float = math.inf,
    ) -> Iterator[tuple[int, _Seen | None]]:  # fmt: skip
        """The number of each errand, and what was seen; None where the work done before leaves too little for it."""
        ahead = None if self.pool is None else _Ahead(errands, needs, most, self)
        try:
            for k, errand in enumerate(errands):
                told(k)
                seen = None
                if errand is not None and self.spent <= begin and self.leaves(needs[k], most):
                    left = replace(errand, most=most - self.spent)
                    seen = _looked(left, self.job) if ahead is None else ahead.of(k)
                    self.spent += seen.work
                yield k, seen if self.spent <= most else None
        finally:
            if ahead is not None:
                ahead.end()

    def leaves(self, answers: float, most: float) -> bool:
        """Whether so much work allows so many more answers."""
        return self.spent + answers * self.each <= most

    def _key(self, path: str) -> tuple[str, int]:
        """What a number is called among the things that hold the answer back, and the way in which it is loosened."""
        steps = path.split(".")
        if steps[0] == "limits":
            rows = {key: limit for key, limit in self.found.limits.items() if limit.name == steps[1]}
            key = next((key for key, row in rows.items() if row.side == steps[2]), next(iter(rows), steps[1]))
            ways = {"at_most": 1, "at_least": -1, "lowest": 1, "highest": -1}
            return key, ways.get(steps[-1], 0)
        if steps[-1] in ("to", "from", "deepest"):
            end, loose = ("lowest", -1) if steps[-1] == "from" else ("highest", 1)
            return f"{path.rpartition('.')[0]} at its {end}", loose
        return "", 0


class _Ahead:
    """What other processes see of errands, a few ahead of the one that is asked for."""

    def __init__(self, errands: Sequence[_Errand | None], needs: Sequence[float], most: float, purse: Purse) -> None:
        self._purse, self._needs, self._most = purse, needs, most
        self._waiting = [(k, replace(one, most=most)) for k, one in enumerate(errands) if one is not None]
        self._running: list[Any] = []
        self._seen: dict[int, _Seen | VibOptError | Lost] = {}

    def of(self, k: int) -> _Seen:
        """What is seen of errand `k`, once it is there."""
        from vibopt.study.workers import taken

        pool = self._purse.pool
        assert pool is not None
        while k not in self._seen:
            while self._waiting and len(self._running) < pool.most:
                index, errand = self._waiting.pop(0)
                if self._purse.leaves(self._needs[index], self._most):
                    self._running.append(pool.begin(_sent, index, errand))
            for one in pool.ready(self._running):
                self._seen[one.index] = one.result()
                self._running.remove(one)
        return taken(self._seen.pop(k), "An answer", pool)

    def end(self) -> None:
        """End what nobody waits for any more."""
        for one in self._running:
            one.end()


def length_of(job: Job) -> float:
    """How far apart the places of a machine, or along a shaft, are [m]."""
    if is_scene(job):
        from vibopt.study.thresholds import extent_of

        return extent_of(list(facts(job)))
    places = [fact.value for fact in facts(job) if fact.path.endswith(".at") and fact.dimension == "length"]
    return (max(places) - min(places) if places else 0.0) or 1.0
