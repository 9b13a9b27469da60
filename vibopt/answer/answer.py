"""The answer to a job of any kind, with its evidence: status, claim, values, limits, and how each was checked."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import field, replace
from math import ceil, floor
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar

from vibopt.answer.entry import Checked, Chosen, Entry, Price, Value, Word
from vibopt.answer.jsonable import said_of
from vibopt.answer.plan import Plan
from vibopt.answer.tabular import Tabular
from vibopt.answer.text import claim, text_of, verdict
from vibopt.errors import NotProven, UnknownName
from vibopt.records import dataclass
from vibopt.units import outward

if TYPE_CHECKING:
    from vibopt.answer.clashes import Conflict

EXIT_CODES = {
    "optimal": 0,
    "feasible": 0,
    "met": 0,
    "violated": 7,
    "infeasible": 3,
    "unbounded": 4,
    "unproven": 5,
    "check_failed": 6,
}
UNPROVEN = EXIT_CODES["unproven"]
OPEN = ("feasible", "unproven", "check_failed")
"""Statuses of answers that may be good, but nothing proves it."""
EMPTY = ("infeasible", "unbounded", "unproven", "check_failed")
"""Statuses of answers without a design to keep, to round or to save."""


class Asked(Protocol):
    """What an answer knows of its job."""

    @property
    def name(self) -> str: ...
    @property
    def title(self) -> str: ...
    @property
    def kind(self) -> str: ...
    @property
    def document(self) -> Mapping[str, Any]: ...


J_co = TypeVar("J_co", bound=Asked, covariant=True)


@dataclass(frozen=True, slots=True)
class Odds:
    """What machines that were drawn say of a limit with a probability.

    wanted
        Share of all machines that shall keep it.
    kept, drawn
        Machines that keep it, of those that were drawn.
    low, high
        Ends of the interval of Clopper and Pearson for the share of all machines, at the confidence over all looks.
    verdict
        "met", "not met", or "cannot be told".
    worst
        Value on the worst machine within the tolerances (three standard deviations of a normal distribution).
    worst_met
        Whether that one keeps the limit.
    within
        Share of all machines that are proven to keep it; the drawn ones are from the others.
    counted
        Whether `drawn` are all machines that there are, each as likely as the others, and `low` and `high` the share.
    """

    wanted: float
    kept: int
    drawn: int
    low: float
    high: float
    confidence: float
    verdict: str
    worst: Entry
    worst_met: bool
    within: float = 0.0
    counted: bool = False

    @property
    def words(self) -> str:
        """All of it in words."""
        asked = f"{100.0 * self.wanted:.8g} % asked: {self.verdict}; worst within the tolerances {self.worst.shown}"
        if self.counted:
            return f"{self.kept} of all {self.drawn} machines keep it, counted one by one: {self.least}; {asked}"
        ends = f"{_share(self.low)} to {_share(self.high, up=True)}"
        proven = f"{_share(self.within)} % of all machines keep it (proven), and of the others " if self.within else ""
        return (
            f"{proven}{self.kept} of {self.drawn} machines drawn keep it, of all {ends} % at a confidence of "
            f"{100.0 * self.confidence:g} %; {asked}"
        )

    @property
    def least(self) -> str:
        """Which share at least keeps it: "98.41 %"."""
        return f"{_share(self.low)} %"


_EVEN = 1e-6
"""Part of the last digit by which rounding may miss a whole one."""


def _share(part: float, *, up: bool = False) -> str:
    """A share of all machines in percent, with as many digits as it differs from all of them.

    It is rounded down, or up: "100" is all of them.
    """
    steps = 10 ** (2 if part < 0.999 else 4 if part < 0.99999 else 7)
    count = 100.0 * part * steps
    return f"{(ceil(count - _EVEN) if up else floor(count + _EVEN)) / steps:.10g}"


@dataclass(frozen=True, slots=True)
class Tolerances:
    """What tolerances do to an answer.

    status, goal, variables, parts
        Of the answer without tolerances; empty for an analysis.
    uncertain
        How far each number may be off at most, by path.
    goal_off
        By how much numbers are off where the goal is worst.
    open
        Limits, "the goal" and measures ("measures.NAME") of which the worst machine is found, but not proven to be so.
    odds
        Of each limit with a probability.
    """

    status: str
    goal: Entry | None
    variables: Mapping[str, Entry]
    uncertain: Mapping[str, float]
    goal_off: Mapping[str, float] = field(default_factory=dict)
    open: tuple[str, ...] = ()
    parts: Mapping[str, str] = field(default_factory=dict)
    odds: Mapping[str, Odds] = field(default_factory=dict)


def odds_said(answer: Answer[Any]) -> str:
    """Which share of all machines each limit with a probability asks for: "floor in 99 % of all machines"."""
    odds = answer.tolerances.odds if answer.tolerances is not None else {}
    return ", ".join(f"{name} in {100.0 * one.wanted:.8g} % of all machines" for name, one in odds.items())


@dataclass(frozen=True, slots=True)
class Used:
    """Degrees of freedom declared by the file and needed by the questions asked, with the reason."""

    declared_dof: int
    used_dof: int
    why: str


@dataclass(frozen=True, slots=True)
class Least:
    """What a limit could be if there were no other: its best value, whether that is proven, whether it is enough."""

    value: Entry
    proven: bool
    enough: bool

    @property
    def known(self) -> str:
        """How it is known."""
        return "proven" if self.proven else "best found"

    def to_json(self) -> dict[str, Any]:
        return {**self.value.to_json(), "proven": self.proven, "enough": self.enough}


_TIMES, _ENDLESS = 9.0, 1e6
"""Parts of a bound from which a loosening is told by its factor, and is none."""


def _wider(part: float) -> str:
    """How much wider is surely enough: "wider by 21 %", of much "16.1 times as wide"."""
    if part < _TIMES:
        return f"wider by {outward(100.0 * part, 'at_most'):.12g} %"
    return f"{outward(1.0 + part, 'at_most'):.12g} times as wide"


@dataclass(frozen=True)
class Nearest:
    """The design that misses its limits least, where none is known that meets them all.

    variables, places, x
        As of an answer.
    values
        Further numbers and words by path, of jobs without design variables.
    words
        What it is, one sentence a line, where a job says it so.
    limits
        Each measured on it.
    least
        What each limit could be alone; without those that have no least, and those `left` because of the work.
    soft
        How easily a limit may be loosened, beside 1 of those that are not named.
    """

    variables: Mapping[str, Chosen] = field(default_factory=dict)
    places: Mapping[str, Word] = field(default_factory=dict)
    x: tuple[float, ...] = ()
    values: Mapping[str, Value] = field(default_factory=dict)
    words: tuple[str, ...] = ()
    limits: Mapping[str, Checked] = field(default_factory=dict)
    least: Mapping[str, Least] = field(default_factory=dict)
    left: tuple[str, ...] = ()
    soft: Mapping[str, float] = field(default_factory=dict)

    @property
    def together(self) -> tuple[str, ...]:
        """By how much every limit at once has to give way, a sentence; none where one alone is missed, or endlessly."""
        rows = list(self.limits.values())
        worst = max((-row.margin for row in rows), default=0.0)
        sides = {row.side for row in rows}
        if any(not row.met and not row.margin_shown for row in rows):  # nothing, however much wider, is nothing
            return ()
        if len(rows) < 2 or not 0.0 < worst < (_ENDLESS if sides == {"at_most"} else 1.0) or "outside" in sides:
            return ()
        if not self.soft:
            return (f"With every limit {_wider(worst)} all could hold.",)
        missed = [f"{row.name} {_wider(-row.margin).removeprefix('wider ')}" for row in rows if not row.met]
        weighed = ", ".join(f"{name} {soft:g}" for name, soft in self.soft.items())
        return (f"With wider limits all could hold: {', '.join(missed)} (soft: {weighed}).",)

    def to_json(self) -> dict[str, Any]:
        variables = {path: variable.value.to_json() for path, variable in self.variables.items()}
        named = {**self.places, **self.values}
        return {
            "values": {**variables, **{path: one.to_json() for path, one in named.items()}}, "words": list(self.words),
            "limits": self.limits, "least": self.least, "left": list(self.left),
        }  # fmt: skip


@dataclass(frozen=True)
class Answer(Tabular, Generic[J_co]):
    """Answer to a job: a machine (scene), a measured rotor, known masses on a shaft, or an engine.

    status
        A key of EXIT_CODES.
    claim
        How the status is known, in words.
    reason
        Why there is no answer, in words; "" elsewhere.
    goal
        Name and value; None for an analysis.
    variables
        Design variables of a machine by path; empty for an analysis or where nothing was found.
    x
        Their values [SI], in the order of the job's variables.
    places
        Places and parts chosen, by path; `job` is then the one in which they have been.
    values
        Further numbers and words by path ("planes.A.mass", "influence.a.left.value").
    limits, measures
        Each measured on the finished thing.
    prices
        What a wider cap buys, by the path of the cap; prices of limits stand in `limits`.
    rates
        What the goal of a balancing job falls by per unit of a limit [SI], or of a cap by its path, that is wider: zero
        where it holds nothing back; None where that is not known.
    plan
        What to fit where, for a measured rotor; empty elsewhere.
    found
        `find_all`: intervals (low, high) in the user's unit, else None.
    conflict
        Limits that cannot hold together; None where none are. Of a balancing job `reason` says it in words.
    nearest
        Where limits cannot all be met, or no such design was found, the one that misses them least; None elsewhere,
        and where it was not looked for.
    model
        What was needed of a machine; None for other kinds.
    tolerances
        With numbers that may be off: `goal`, `limits` and `measures` are then the worst over all machines.
    method, details
        What answered, by name, and what it says of its search.
    timings
        Seconds by stage.
    work
        What the answer took [nominal ms], the same on any machine; studies decide by it what they compute.
    """

    job: J_co
    status: str
    claim: str
    goal: tuple[str, Entry] | None = None
    variables: Mapping[str, Chosen] = field(default_factory=dict)
    x: tuple[float, ...] = ()
    limits: Mapping[str, Checked] = field(default_factory=dict)
    measures: Mapping[str, Checked] = field(default_factory=dict)
    method: str = ""
    reason: str = ""
    notes: tuple[str, ...] = ()
    values: Mapping[str, Value] = field(default_factory=dict)
    places: Mapping[str, Word] = field(default_factory=dict)
    prices: Mapping[str, Price] = field(default_factory=dict)
    rates: Mapping[str, float] | None = None
    plan: Plan = field(default_factory=Plan)
    found: tuple[tuple[Entry, Entry], ...] | None = None
    conflict: Conflict | None = None
    nearest: Nearest | None = None
    model: Used | None = None
    tolerances: Tolerances | None = None
    details: Mapping[str, Any] = field(default_factory=dict)
    timings: Mapping[str, float] = field(default_factory=dict)
    work: float = 0.0

    @property
    def tried(self) -> Answer[J_co]:
        """The nearest design as an answer that breaks limits; this answer where there is none."""
        near = self.nearest
        if near is None:
            return self
        return replace(
            self, status="violated", variables=near.variables, places=near.places, x=near.x, limits=near.limits
        )

    @property
    def name(self) -> str:
        return self.job.name

    @property
    def title(self) -> str:
        return self.job.title

    @property
    def scene(self) -> J_co:
        """The job, where it is a machine."""
        return self.job

    @property
    def exit_code(self) -> int:
        """Exit code of the command line."""
        return EXIT_CODES[self.status]

    @property
    def proven(self) -> bool:
        """Whether nothing about the status is left open."""
        off = self.tolerances
        sure = off is None or not (off.open or off.odds) or (self.status == "violated" and not off.odds)
        return sure and self.status not in OPEN

    def require_proof(self) -> Answer[J_co]:
        """This answer, if its status is proven.

        Raises
        ------
        NotProven
            The answer may be good, but nothing proves it.
        """
        if not self.proven:
            raise NotProven(f"{self.name}: {self.status}: {self.claim}")
        return self

    def with_plan(self, **changes: Any) -> Answer[J_co]:
        """The same answer with parts of its plan replaced."""
        return replace(self, plan=replace(self.plan, **changes))

    def entries(self) -> dict[str, Value]:
        """Every number and word by its path, as the records of a problem file name them."""
        found: dict[str, Value] = {"status": Word(self.status), **self.plan.entries(), **self.values}
        found.update({f"variables.{path}": place for path, place in self.places.items()})
        found.update({f"variables.{path}": variable.value for path, variable in self.variables.items()})
        for family, rows in (("limits", self.limits), ("measures", self.measures)):
            found.update({f"{family}.{name}.value": row.value for name, row in rows.items()})
        if self.goal is not None:
            found["goal"] = self.goal[1]
        return found

    def find(self, path: str) -> Value:
        """The number or word at a path; UnknownName where there is none."""
        entries = self.entries()
        if path not in entries:
            raise UnknownName.among("path", path, entries)
        return entries[path]

    def table(self) -> list[dict[str, Any]]:
        """A row for each number and word, by its path: value and unit in SI, as shown, and of a limit its bound."""
        rows = {
            f"{family}.{name}.value": checked
            for family in ("limits", "measures")
            for name, checked in self._rows(family)
        }
        return [_row(path, entry, rows.get(path)) for path, entry in self.entries().items()]

    def _rows(self, family: str) -> Iterable[tuple[str, Checked]]:
        found: Mapping[str, Checked] = getattr(self, family)
        return found.items()

    def heading(self) -> tuple[str, ...]:
        """Title, verdict and how it is known."""
        return self.title, verdict(self), claim(self), *(f"Note: {note}" for note in self.notes)

    def report(self) -> str:
        """The answer as text, as the command line prints it."""
        return text_of(self)

    def __str__(self) -> str:
        return self.report()

    def as_said(self) -> dict[str, Any]:
        """What all kinds of job have, then what its kind adds."""
        return said_of(self)


def _row(path: str, one: Value, checked: Checked | None) -> dict[str, Any]:
    """A number or a word as a row of the table."""
    bound = checked.limit if checked is not None else None
    return {
        "path": path,
        "value": one.value,
        "unit": one.si if isinstance(one, Entry) else "",
        "shown": one.shown,
        "side": checked.side.replace("_", " ") if checked is not None and checked.side else None,
        "limit": bound.value if bound is not None else None,
        "limit_shown": bound.shown if bound is not None else None,
        "margin": checked.margin if checked is not None and bound is not None else None,
        "met": checked.met if checked is not None and bound is not None else None,
    }
