"""What every number of a file buys or costs, each way: by how much, over which range, and what takes over then.

One service for every kind of job: limits, caps, ratings, counts of holes and facts are moved in the file, and the whole
job is answered again.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from vibopt.answer.answer import Answer
from vibopt.answer.entry import Checked, Entry, Price, Way
from vibopt.answer.tabular import Tabular
from vibopt.errors import InputError, UnknownName, counted
from vibopt.jobs import answer, asks_shares, facts, is_scene, noun_of
from vibopt.records import cached_property, dataclass
from vibopt.report.machine_words import THOROUGH
from vibopt.solve.method import Progress
from vibopt.study.holding import (
    LEAST_WORK,
    Road,
    SpentError,
    State,
    caps_of,
    in_steps,
    is_looser,
    is_touched,
    measured_by,
    state_of,
)
from vibopt.study.one_way import NO_STEP, Along, Axis, axis_of, is_shelf
from vibopt.study.price_words import CAPS, FACTS, GAIN, LIMITS, NOT_ASKED, OF_WORK, first_words, words_of
from vibopt.study.seen import goal_of, reason, shown_value
from vibopt.values.fact_at import FactAt

if TYPE_CHECKING:
    from vibopt.jobs import Job

PATIENCE = 2_000.0
"""Work of an answer [nominal ms] beyond which it is priced only when that is asked for."""
ALLOWANCE = 20_000.0
"""Work that a table of prices may take [nominal ms] where not all is asked for."""
OF_LIMITS, _STEPS_OF_LIMITS = 2_000.0, 100_000.0
"""The same for the limits alone: beside an answer, and what a step of each buys where prices are asked for."""
_A_RANGE = 30
"""Answers that both ranges of a number take, one by one."""
_READ = ("runs", "readings", "influence", "conventions", "scatter", "quality")
"""What was measured of a rotor: data, and nothing to argue about."""
_CAPPED = ("to", "from", "most", "least", "holes", "most_weights", "stock", "deepest")
_OF_THE_GOAL = ("importance", "huber_at")
"""What the goal of a rotor counts by: another one is another goal, whose values do not compare."""


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


@dataclass(frozen=True)
class Prices(Tabular):
    """What each number of a job buys or costs, the one to argue about first on top.

    measure, now
        What a price is counted in, and what it is: the goal, or of an analysis the least margin of its limits.
    rows
        Ranked; those that were not computed come last, and say why.
    notes
        What was left out, and how to get it.
    """

    job: Job
    found: Answer[Any]
    measure: str
    now: Entry | None
    rows: tuple[Ranked, ...]
    notes: tuple[str, ...] = ()

    @property
    def shown(self) -> str:
        """What a price is counted in, as it is."""
        return self.now.shown if self.now is not None else ""

    @property
    def first(self) -> str:
        """What to argue about first, as a sentence."""
        return first_words(self)

    def find(self, path: str) -> Ranked:
        """The row of a number; UnknownName where there is none."""
        found = next((row for row in self.rows if row.path == path), None)
        if found is None:
            raise UnknownName.among("number", path, [row.path for row in self.rows])
        return found

    def table(self) -> list[dict[str, Any]]:
        """A row for each way of each number, ranked: the number in SI and as shown, what a step and the range do."""
        return [_row(rank, row, way) for rank, row in enumerate(self.rows, 1) for way in (row.ways or (None,))]

    def heading(self) -> tuple[str, ...]:
        """Title, and what to argue about first."""
        return self.job.title, self.first, *self.notes

    def to_json(self) -> dict[str, Any]:
        """As plain data."""
        from vibopt.answer.jsonable import plain as as_plain

        keys = ("measure", "now", "first", "notes", "rows")
        said: dict[str, Any] = as_plain({key: getattr(self, key) for key in keys})
        return said


def _row(rank: int, one: Ranked, way: Way | None) -> dict[str, Any]:
    def number(entry: Entry | None) -> float | None:
        return None if entry is None else entry.value

    blank = way or Way(one.now, "")
    return {
        "rank": rank, "path": one.path, "sort": one.sort, "unit": one.now.si, "now": one.now.value,
        "now_shown": one.now.shown, "step": None if way is None else blank.value.value,
        "step_shown": None if way is None else blank.value.shown, "status": blank.status, "goal": number(blank.goal),
        "change": blank.change, "until": number(blank.until), "goal_until": number(blank.there), "then": blank.then,
        "ends": number(blank.ends), "beyond": blank.beyond, "why": one.why,
    }  # fmt: skip


def prices(
    job: Job,
    *,
    found: Answer[Any] | None = None,
    only: Collection[str] | None = None,
    thorough: bool = False,
    most: float = ALLOWANCE,
    progress: Progress | None = None,
) -> Prices:
    """What each number of a job buys or costs both ways, over which range, and what takes over behind it.

    Parameters
    ----------
    job
        Of any kind, with a goal, or limits to be measured by.
    found
        Its answer, where it is known.
    only
        Paths to look at; None for all.
    thorough
        Whatever the work.
    most
        Work [nominal ms] after which the rest is named as not computed.
    progress
        Called with a stage and the part that is done.

    Raises
    ------
    InputError
        A job that answers with a set, that has nothing to count a price in, or that has no design; a path of `only`
        that the file does not have.
    """
    found = answered(job) if found is None else found
    measure, sense = measured_by(job)
    refused = _refusal(job, found, measure)
    if refused:
        raise InputError(f"{job.name}: {refused}")
    asked, read = asked_of(found, only)
    purse = _Purse(found, sense, float("inf") if thorough else most)
    if most == ALLOWANCE:  # which limit to argue about is what is asked for first
        purse.limits = max(purse.most, _STEPS_OF_LIMITS)
    rows = [purse.priced(fact, sort, progress, k / max(2 * len(asked), 1)) for k, (fact, sort) in enumerate(asked)]
    ranked = sorted(range(len(rows)), key=lambda k: (*(-one for one in rows[k].weight), k))
    for place, k in enumerate(ranked):
        rows[k] = purse.ranged(asked[k][0], rows[k], progress, 0.5 + place / max(2 * len(asked), 1))
    notes = [*_left(rows), *_radii(job, rows)]
    if any(way.status == "refused" for row in rows for way in row.ways):
        notes.append(NOT_ASKED)
    if read:
        notes.append(
            f"{counted(len(read), 'numbers')} of {tables_of(read)} have no price: they are data of {noun_of(job)}. "
            f"What another would do: vibopt sweep FILE --vary {read[0]}=RANGE."
        )
    return Prices(job, found, measure, purse.here.measure, tuple(rows[k] for k in ranked), tuple(notes))


def answered(job: Job) -> Answer[Any]:
    """The answer; where a balancing job has none, with what stands in the way."""
    found = answer(job, explain=False)
    return answer(job) if found.status == "infeasible" and not is_scene(job) else found


def _refusal(job: Job, found: Answer[Any], measure: str) -> str:
    """Why a job has no prices; "" where it has."""
    if is_scene(job) and job.find_all is not None:
        return (
            f"find_all answers with {job.finds}, and a price is counted in a goal. Set a goal, or see how the set "
            "moves with vibopt whatif FILE --set PATH=VALUE."
        )
    if asks_shares(job):
        return (
            "a limit asks for a probability, and what a step buys of it is the luck of the draw. Leave "
            "with_probability out for prices, or compare two answers: vibopt whatif FILE --set PATH=VALUE."
        )
    if not measure:
        return "there is neither a goal nor a limit, so nothing to count a price in. Add one of them."
    if found.status == "check_failed":
        return (
            "its answer is check_failed, and numbers on which two routes do not agree have no price. vibopt solve FILE "
            "says where they part."
        )
    if goal_of(job, found) is None and found.status not in ("met", "violated"):
        why = reason(found) or found.claim
        return f"there is no design whose price could be told: {found.status}. {why[:1].upper()}{why[1:]}".rstrip()
    return ""


def asked_of(
    found: Answer[Any], only: Collection[str] | None = None, *, ends: bool = False
) -> tuple[list[tuple[FactAt, str]], list[str]]:
    """Numbers in the order in which they are looked at, and paths of those left out as measured data, of all or `only`.

    With `ends` also the ends of all ranges of a machine, not only those on which a chosen value rests.  UnknownName
    where one of `only` is none of them.
    """
    job = _job(found)
    known, read = [], list[str]()
    for fact in facts(job):
        if fact.path.split(".")[0] in _READ:
            read.append(fact.path)
            continue
        if not is_scene(job) and fact.path.rpartition(".")[2] in _OF_THE_GOAL:
            continue
        limit = fact.path.startswith("limits.")
        known.append((fact, LIMITS if limit else CAPS if fact.path.rpartition(".")[2] in _CAPPED else FACTS))
    known += [(one, CAPS) for one in _ends_of(found, every=ends)]
    active = {name for name, one in found.limits.items() if one.active}
    order = {LIMITS: 1, CAPS: 2, FACTS: 3}
    known.sort(key=lambda one: 0 if _is_of(one[0].path, active, found) else order[one[1]])
    if only is None:
        return known, read
    if unknown := sorted(set(only) - {one.path for one, _ in known}):
        raise UnknownName.among("number", unknown[0], [one.path for one, _ in known])
    return [(one, sort) for one, sort in known if one.path in only], []


def tables_of(paths: Sequence[str]) -> str:
    """The tables in which numbers stand, as words."""
    return " and ".join(dict.fromkeys(path.split(".")[0] for path in paths))


def _is_of(path: str, active: Collection[str], found: Answer[Any]) -> bool:
    steps = path.split(".")
    return steps[0] == "limits" and any(found.limits[key].name == steps[1] for key in active)


def _job(found: Answer[Any]) -> Job:
    """The job as it was asked, with the places open that were."""
    job: Job = found.job
    return (job.asked or job) if is_scene(job) else job


def _ends_of(found: Answer[Any], *, every: bool) -> Iterator[FactAt]:
    """Ends of ranges of a machine on which a chosen value rests, or all of them."""
    job = _job(found)
    if not is_scene(job):
        return
    from vibopt.document.toml_reading import inside

    for variable in job.variables:
        rests = found.variables[variable.path].at_bound if variable.path in found.variables else ""
        given = inside(job.document, variable.path) if every or rests else None
        for end in ("from", "to") if every else (rests,):
            if isinstance(given, dict) and end in given:
                value = variable.high if end == "to" else variable.low
                yield FactAt(f"{variable.path}.{end}", value, variable.unit, variable.dimension)


class _Purse:
    """Prices one after the other, from one allowance of work [nominal ms]."""

    def __init__(self, found: Answer[Any], sense: int, most: float) -> None:
        self.found, self.sense, self.most, self.limits = found, sense, most, most
        self.job = _job(found)
        self.each = max(found.work, LEAST_WORK)
        self.roads: dict[str, Along] = {}

    @cached_property
    def extent(self) -> float:
        """How far apart places are [m]."""
        return length_of(self.job)

    @property
    def here(self) -> State:
        """What holds the answer back as it is."""
        return state_of(self.job, self.found, 0.0)

    @property
    def spent(self) -> float:
        """Work done [nominal ms]."""
        return sum(road.road.work for road in self.roads.values())

    def _may(self, answers: int, most: float) -> bool:
        return self.spent + answers * self.each <= most

    def priced(
        self, fact: FactAt, sort: str, progress: Progress | None, part: float, *, loosened: bool = False
    ) -> Ranked:
        """What a sensible step each way does, or of a bound the `loosened` one alone: each is an answer of its own."""
        now, axis = shown_value(fact, fact.value), axis_of(fact, lambda: self.extent, self.job)
        if axis is None:
            return Ranked(fact.path, sort, now, why=NO_STEP)
        asked = [way for way in (-1, 1) if axis.step(way) != fact.value]
        if loosened:
            asked = [way for way in asked if is_looser(fact.path, axis.step(way) - fact.value)]
        most = self.limits if sort == LIMITS else self.most
        if not self._may(len(asked), most):
            return Ranked(fact.path, sort, now, why=OF_WORK)
        if progress is not None:
            progress("what a step buys", part)
        along = self._along(fact, axis, most)
        try:
            ways = [along.stepped(way) for way in asked]
        except SpentError:
            return Ranked(fact.path, sort, now, why=OF_WORK)
        return Ranked(fact.path, sort, now, tuple(ways))

    def ranged(self, fact: FactAt, row: Ranked, progress: Progress | None, part: float) -> Ranked:
        """The same row with how far each way goes on."""
        along = self.roads.get(row.path)
        if along is None:
            return row
        if not along.road.together and not self._may(_A_RANGE, self.most):
            return replace(row, why=f"its range was {OF_WORK}")
        if progress is not None:
            progress("how far that goes on", part)
        try:
            ways = [along.ranged(way, -1 if way.value.value < fact.value else 1) for way in row.ways]
        except SpentError:
            return replace(row, why=f"its range was {OF_WORK}")
        return replace(row, ways=tuple(ways))

    def _along(self, fact: FactAt, axis: Axis, most: float) -> Along:
        near = self.found.x if is_scene(self.job) and self.job is self.found.job else None
        road = Road(self.job, fact, near, lambda: self.spent <= most)
        here = replace(self.here, value=fact.value)
        road.known[fact.value] = here
        key, loose = self._key(fact.path)
        along = Along(road, axis, here, self.sense, key, loose, lambda state: state.worst.get(key))
        self.roads[fact.path] = along
        return along

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


def length_of(job: Job) -> float:
    """How far apart the places of a machine, or along a shaft, are [m]."""
    if is_scene(job):
        from vibopt.study.thresholds import extent_of

        return extent_of(list(facts(job)))
    places = [fact.value for fact in facts(job) if fact.path.endswith(".at") and fact.dimension == "length"]
    return (max(places) - min(places) if places else 0.0) or 1.0


def _left(rows: list[Ranked]) -> Iterator[str]:
    """What was left out because of the work, and what computes it."""
    steps = [row.path for row in rows if row.why.startswith("left out")]
    ranges = [row.path for row in rows if row.why.startswith("its range")]
    way = "`vibopt whatif FILE --thorough` computes all."
    if steps:
        yield f"No price was computed for {', '.join(steps)}: each takes answers of its own. {way}"
    if any(is_shelf(row.path) and row.ranged for row in rows):
        yield _SHELVES
    if ranges:
        yield f"How far the prices of {', '.join(ranges)} go on was not looked for: some thirty answers each. {way}"


_SHELVES = (
    "The range of a shelf weight is that over which the same weights were found in the same holes. Beyond it, and "
    "between the values that were looked at, other fillings may be better: vibopt sweep FILE --vary PATH=RANGE."
)


def _radii(job: Job, rows: list[Ranked]) -> Iterator[str]:
    """What else moves with a plane of which the influence was measured."""
    if "runs" in job.document and any(row.path.endswith(".radius") and row.ways for row in rows):
        yield "With the radius of a plane its trial weights move, too: the readings ask for the same weights in grams."


def priced(found: Answer[Any]) -> Answer[Any]:
    """The same answer with a price on all that holds it back, one step looser; `with_prices` has both ways and ranges.

    Analyses and failures are returned as they are.

    Notes
    -----
    Where weights are chosen from lists, and where a goal is robust, a limit may hold the answer back without being
    touched: there every limit and cap is looked at, as far as the work goes.
    """
    if found.goal is None or found.status not in ("optimal", "feasible") or asks_shares(found.job):
        return found
    asked = _holding_back(found)
    if not asked:
        return found
    if found.work > PATIENCE:
        names = ", ".join(dict.fromkeys(found.limits[key].name if key in found.limits else key for key in asked))
        note = f"No price was computed for {names}: each is an answer of its own. {THOROUGH} computes it."
        return replace(found, notes=(*found.notes, note))
    job = _job(found)
    steps = not is_scene(job) and in_steps(job)
    purse = _Purse(found, measured_by(job)[1], OF_LIMITS if steps else float("inf"))
    rows = [purse.priced(fact, LIMITS, None, 0.0, loosened=True) for fact in asked.values()]
    return _with_rows(found, asked, {row.path: row for row in rows}, _left(rows))


def _holding_back(found: Answer[Any]) -> dict[str, FactAt]:
    """What holds an answer back, or may: a limit by its key, a cap by the path of what it bounds, with its number."""
    job = _job(found)
    steps = not is_scene(job) and in_steps(job)
    known = {fact.path: fact for fact in facts(job)}
    asked = {
        key: _bound_of(row, known)
        for key, row in found.limits.items()
        if steps or (row.active if is_scene(job) else is_touched(1.0 - row.margin))
    }
    held = {key: known[path] for key, path in asked.items() if path}
    if is_scene(job):
        return held
    return held | {path: fact for path, fact, part in caps_of(job, found) if steps or is_touched(part)}


def prices_of_limits(found: Answer[Any], *, thorough: bool = False) -> Prices | None:
    """What every limit and cap of an answer buys or costs, each way; None where there is none, or nothing to count in.

    thorough
        Whatever the work.
    """
    job = _job(found)
    if (found.work > PATIENCE and not thorough) or _refusal(job, found, measured_by(job)[0]):
        return None
    paths = {one.path for one, sort in asked_of(found)[0] if sort != FACTS}
    if not paths:
        return None
    return prices(job, found=found, only=paths, thorough=thorough, most=OF_LIMITS)


def with_prices(found: Answer[Any], every: Prices) -> Answer[Any]:
    """The same answer with the prices of what holds it back from a table, and what that left out."""
    return _with_rows(found, _holding_back(found), {one.path: one for one in every.rows}, every.notes)


def _with_rows(
    found: Answer[Any], asked: Mapping[str, FactAt], rows: Mapping[str, Ranked], notes: Iterable[str]
) -> Answer[Any]:
    """The same answer with prices from the rows of a table, by the path of what is moved."""
    bought = {key: _price(found, key, rows[fact.path]) for key, fact in asked.items() if fact.path in rows}
    limits = {key: replace(row, price=bought[key]) if key in bought else row for key, row in found.limits.items()}
    caps = {key: price for key, price in bought.items() if key not in limits and price is not None}
    return replace(found, limits=limits, prices=caps, notes=(*found.notes, *notes))


def _bound_of(row: Checked, known: Mapping[str, FactAt]) -> str:
    """Path of the bound on which a limit rests, of two edges the one that is touched; "" where it has none."""
    paths = [path for path in known if path.startswith(f"limits.{row.name}.{row.side}")]
    return min(paths, key=lambda one: abs(known[one].value - row.value.value), default="")


def _price(found: Answer[Any], key: str, row: Ranked) -> Price | None:
    """What a wider limit buys, and what is known of both ways; None where a balancing job gains nothing by it."""
    way = next((one for one in row.ways if is_looser(row.path, one.value.value - row.now.value)), None)
    if way is None or way.goal is None or found.goal is None:
        return None
    if not (is_scene(found.job) or (way.change or 0.0) > 0.0):
        return None
    ways = row.ways if row.ranged else ()
    said, rate = words_of(found, row.now, way, ways), (found.rates or {}).get(key)
    return Price(said, way.value, way.goal, way.ends if way.beyond == GAIN else None, rate, ways)
