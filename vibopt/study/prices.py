"""What every number of a file buys or costs, each way: by how much, over which range, and what takes over then.

One service for every kind of job: limits, caps, ratings, counts of holes and facts are moved in the file, and the whole
job is answered again.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from vibopt.answer.answer import Answer
from vibopt.answer.entry import Checked, Entry, Price, Way
from vibopt.answer.tabular import Tabular
from vibopt.errors import InputError, UnknownName, counted
from vibopt.jobs import answer, asks_shares, facts, is_scene, noun_of
from vibopt.records import dataclass
from vibopt.report.machine_words import THOROUGH
from vibopt.solve.method import Progress
from vibopt.study.axis import is_shelf
from vibopt.study.holding import caps_of, in_steps, is_looser, is_touched, measured_by
from vibopt.study.many import of_one_machine
from vibopt.study.price_words import CAPS, FACTS, GAIN, LIMITS, NOT_ASKED, first_words, words_of
from vibopt.study.purse import Purse, Ranked
from vibopt.study.seen import goal_of, reason
from vibopt.values.fact_at import FactAt

if TYPE_CHECKING:
    from vibopt.jobs import Job
    from vibopt.study.workers import Pool

PATIENCE = 2_000.0
"""Work of an answer [nominal ms] beyond which it is priced only when that is asked for."""
ALLOWANCE, _OF_ACTIVE, _OF_STEPS = 20_000.0, 30_000.0, 100_000.0
"""Work of a table of prices [nominal ms] where not all is asked for; beyond it of the ranges of the limits that hold
the answer back, which come before others; and the most of steps of limits, of which none begins beyond `ALLOWANCE`."""
OF_LIMITS = 2_000.0
"""The same for the limits alone, beside an answer."""
_READ = ("runs", "readings", "influence", "conventions", "scatter", "quality")
"""What was measured of a rotor: data, and nothing to argue about."""
_CAPPED = ("to", "from", "most", "least", "holes", "most_weights", "stock", "deepest")
_OF_THE_GOAL = ("importance", "huber_at")
"""What the goal of a rotor counts by: another one is another goal, whose values do not compare."""


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

    def as_said(self) -> dict[str, Any]:
        """Every number with its ways, the one to argue about first on top."""
        keys = ("measure", "now", "first", "notes", "rows")
        return {key: getattr(self, key) for key in keys}


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
    pool: Pool | None = None,
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
    pool
        Those who answer; what is answered does not depend on them.
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
    purse, most = Purse(found, sense, pool), float("inf") if thorough else most

    def told(stage: str) -> Callable[[int], None]:
        return lambda k: None if progress is None else progress(stage, k / len(asked))

    ways = told("what a step buys")
    limits = sum(sort == LIMITS for _, sort in asked)
    # which limit to argue about is what is asked for first, whatever one answer takes
    rows = purse.stepped(asked[:limits], max(most, _OF_STEPS if most == ALLOWANCE else 0.0), ways, begin=most)
    rows += purse.stepped(asked[limits:], most, lambda k: ways(limits + k))
    rows.sort(key=lambda row: row.weight, reverse=True)
    rows = _ranged(purse, rows, most, told("how far that goes on"))
    notes = (*_left(rows), *_radii(job, rows), *_unpriced(job, rows, read))
    return Prices(job, found, measure, purse.here.measure, tuple(rows), notes)


def _unpriced(job: Job, rows: Sequence[Ranked], read: Sequence[str]) -> Iterator[str]:
    """What has no price: ways that are no question, and numbers that were `read` as data."""
    if any(way.status == "refused" for row in rows for way in row.ways):
        yield NOT_ASKED
    if read:
        yield (
            f"{counted(len(read), 'numbers')} of {tables_of(read)} have no price: they are data of {noun_of(job)}. "
            f"What another would do: vibopt sweep FILE --vary {read[0]}=RANGE."
        )


def _ranged(purse: Purse, rows: list[Ranked], most: float, told: Callable[[int], None]) -> list[Ranked]:
    """The rows with how far each goes on: first those of the limits that hold the answer back."""
    if most != ALLOWANCE:
        return purse.ranged(rows, most, told)
    active = {name for name, one in purse.found.limits.items() if one.active}
    first = [row for row in rows if row.sort == LIMITS and _is_of(row.path, active, purse.found)]
    held = purse.ranged(first, max(most, purse.spent + _OF_ACTIVE), told, shared=True)
    rest = [row for row in rows if row not in first]
    after = purse.ranged(rest, most, lambda k: told(len(first) + k))
    found = {row.path: row for row in (*held, *after)}
    return [found[row.path] for row in rows]


def answered(job: Job) -> Answer[Any]:
    """The answer; where a balancing job has none, with what stands in the way."""
    with of_one_machine(job, ()):  # limits that are moved begin with what was measured here
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
    purse, most = Purse(found, measured_by(job)[1]), OF_LIMITS if steps else float("inf")
    rows = purse.stepped([(fact, LIMITS) for fact in asked.values()], most, lambda k: None, loosened=True)
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


def prices_of_limits(found: Answer[Any], *, thorough: bool = False, pool: Pool | None = None) -> Prices | None:
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
    return prices(job, found=found, only=paths, thorough=thorough, most=OF_LIMITS, pool=pool)


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
