"""What an answer is made of: numbers, words, chosen values, and one row per limit or measure."""

from __future__ import annotations

from cmath import phase
from collections.abc import Iterable, Mapping
from dataclasses import field, replace
from math import inf, isfinite, tau
from typing import Any, TypeAlias, TypeVar, cast

from vibopt.records import dataclass
from vibopt.units import best_unit, plain, show, si_unit
from vibopt.units.showing import show_angle

TOLERANCE, ROUTES = 1e-9, 1e-7
"""Part of its bound by which a limit may be missed and still is met, by the search and when it is measured; in a
measured rotor, of the greatest reading.  The same by the second route of what the first one keeps, where they agree."""
ACTIVE = 1e-6
"""Part of its bound below which what is left over of a limit is nothing: the limit holds the answer back."""
_DECIMALS = 12
"""Decimals of a margin in JSON: what is behind them is rounding."""


@dataclass(frozen=True, slots=True)
class Entry:
    """One number of an answer.

    value
        In SI; amplitudes peak.
    dimension
        Name in `vibopt.units`.
    unit
        The user's unit, with its detector word; "" lets the size choose.
    amplitude
        Whether "pk" belongs behind the number where the unit has no detector word.
    text
        As it is to be shown; "" for the number with `digits` digits in the user's unit.
    """

    value: float
    dimension: str
    unit: str = ""
    amplitude: bool = False
    text: str = ""
    digits: int = 4

    @property
    def shown(self) -> str:
        """As text in the user's unit."""
        return self.text or show(self.value, self.unit, self.dimension, digits=self.digits, amplitude=self.amplitude)

    def short(self, digits: int) -> str:
        """As `shown`, with at most so many digits."""
        return replace(self, digits=digits).shown

    @property
    def si(self) -> str:
        """The SI unit of `value`; "" for ratios and counts."""
        return si_unit(self.dimension)

    def to_json(self) -> dict[str, Any]:
        """`value` and `unit` are SI, `shown` is in the user's unit."""
        return {"value": self.value, "unit": self.si, "shown": self.shown}


def direction(turn: float) -> Entry:
    """Where on a shaft: an angle [rad] shown in degrees from 0 to below 360, to a tenth."""
    return Entry(turn, "angle", "deg", text=show_angle(turn))


def direction_of(phasor: complex) -> Entry:
    """The direction of a phasor, in 0..360 deg; a full turn but for rounding counts as zero."""
    turned = phase(phasor) % tau
    return direction(0.0 if tau - turned < 1e-9 else turned)


@dataclass(frozen=True, slots=True)
class Word:
    """One word of an answer: a place or a part as chosen, or what is said of something.

    options
        What it was chosen from; `among` says that in words.
    """

    value: str
    options: tuple[str, ...] = ()
    among: str = ""

    @property
    def shown(self) -> str:
        return self.value

    def short(self, digits: int) -> str:
        return self.value

    def to_json(self) -> str:
        return self.value


Value: TypeAlias = Entry | Word


Cell = TypeVar("Cell", bound=str | Entry | Word)


def in_one_unit(column: Iterable[Cell]) -> list[Cell]:
    """Numbers that measure the same thing in one unit, where the user gave none: the one with the shortest texts.

    Texts, and numbers in a unit of the user's, stay as they are.
    """
    cells = list(column)
    free = [cell for cell in cells if isinstance(cell, Entry) and not cell.unit and not cell.text]
    for dimension in dict.fromkeys(one.dimension for one in free):
        alike = [one for one in free if one.dimension == dimension]
        ladder = dict.fromkeys(
            best_unit(one.value, dimension) for one in sorted(alike, key=lambda one: -abs(one.value))
        )
        if len(ladder) > 1:
            longest = {unit: max(len(replace(one, unit=unit).shown) for one in alike) for unit in ladder}
            unit = min(ladder, key=longest.__getitem__)
            cells = [
                cast("Cell", replace(cell, unit=unit)) if isinstance(cell, Entry) and cell in alike else cell
                for cell in cells
            ]
    return cells


@dataclass(frozen=True, slots=True)
class Chosen:
    """A design variable as chosen; `at_bound` is "from", "to" or "" (not at an end of its range)."""

    value: Entry
    at_bound: str = ""


@dataclass(frozen=True, slots=True)
class Way:
    """One way from a number of the file: what a sensible step does, how far that goes on, and what then.

    value, status, goal
        After a step: the number, the status of the answer, and what was made best; None without a design.
    change
        Part of the goal by which that is better, negative where worse; of an analysis, of the margin, the difference.
    until, there, then
        The last number at which the same limits hold the answer back, what was made best there, and what takes over
        behind it, in words.  None, None and "" where that was not looked for, or is further than was looked.
    ends, beyond
        The number from which on more of it changes nothing, or behind which there is no design, and which of the two.
    far
        As far as was looked; None where it was not.
    looked, again
        Of a fact how many values were looked at from where designs end as far as that, and the first of them that has a
        design again; 0 and None where a limit is tightened, behind whose end there is none for sure.
    """

    value: Entry
    status: str
    goal: Entry | None = None
    change: float | None = None
    until: Entry | None = None
    there: Entry | None = None
    then: str = ""
    ends: Entry | None = None
    beyond: str = ""
    far: Entry | None = None
    looked: int = 0
    again: Entry | None = None

    def to_json(self) -> dict[str, Any]:
        """Every field."""
        names = (
            "value", "status", "goal", "change", "until", "there", "then", "ends", "beyond", "far", "looked", "again",
        )  # fmt: skip
        return {name: getattr(self, name) for name in names}


@dataclass(frozen=True, slots=True)
class Price:
    """What a loosened limit buys, checked by solving again.

    words
        The whole as one sentence.
    loosened
        The bound after a sensible step.
    goal
        Goal with the loosened bound.
    until
        The bound beyond which loosening buys nothing more; None when there is no such point.
    rate
        What the goal falls by per unit of the bound [SI]; None where it was not found out.
    ways
        What another bound does, downward and upward, and how far that goes; empty where it was not looked for.
    """

    words: str
    loosened: Entry | None = None
    goal: Entry | None = None
    until: Entry | None = None
    rate: float | None = None
    ways: tuple[Way, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Every field; the rate and both ways only where they are known."""
        said = {"words": self.words, "loosened": self.loosened, "goal": self.goal, "until": self.until}
        known = {} if self.rate is None else {"rate": self.rate}
        return {**said, **known, **({"ways": list(self.ways)} if self.ways else {})}


@dataclass(frozen=True, slots=True)
class Checked:
    """One limit (or measure) of the finished thing, measured by another road than the optimiser's.

    name
        As in the file.
    response
        Kind of response, with its place in `place` ("into ground").
    side
        "at_most", "at_least", "outside", or "" for a measure.
    value
        Worst value.
    limit
        The bound; None for a measure.
    margin
        Part of the bound that is left over, (bound - value) / bound for at_most; negative when broken.
    slack
        Part of the bound by which it may be missed and still is met.
    tight
        Margin at which it holds the answer back: the least of all where that was made greatest.
    worst_at
        Where the worst is reached: speed per excitation.
    off
        By how much numbers of the machine are off at its worst, by path: -0.2 is 20 % less.
    band
        Ends of the 95 % band of the value; None where the scatter is not known.
    doubt
        What the optimiser's model says of it where that is another number; "" where both routes agree.
    unknown
        Why it is beyond what the model of a part is good for, as a sentence; "" where it is not.
    unsteady
        Why a whirl grows and there is no steady motion to measure, as a sentence; "" where there is.
    open
        Whether it cannot be told if the limit holds: too few machines were drawn, or nothing was found. It then does
        not count as met.
    """

    name: str
    response: str
    place: str
    side: str
    value: Entry
    limit: Entry | None = None
    margin: float = inf
    slack: float = TOLERANCE
    tight: float = 0.0
    worst_at: Mapping[str, Entry] = field(default_factory=dict)
    price: Price | None = None
    off: Mapping[str, float] = field(default_factory=dict)
    band: tuple[Entry, Entry] | None = None
    doubt: str = ""
    unknown: str = ""
    unsteady: str = ""
    open: bool = False

    @property
    def met(self) -> bool:
        """Whether the limit holds."""
        return not self.side or self.margin >= -self.slack

    @property
    def active(self) -> bool:
        """Whether the limit holds the answer back."""
        return bool(self.side) and abs(self.margin - self.tight) <= ACTIVE

    @property
    def met_by_band(self) -> bool | None:
        """Whether the upper end of the 95 % band is under the limit as well; None where the scatter is not known."""
        if self.band is None or self.limit is None:
            return None
        return self.band[1].value <= self.limit.value * (1.0 + self.slack)

    @property
    def state(self) -> str:
        """OPEN, BROKEN, ACTIVE or nothing."""
        return "OPEN" if self.open else "BROKEN" if not self.met else "ACTIVE" if self.active else ""

    @property
    def margin_shown(self) -> str:
        """How much of the bound is left over: "48 %"; "" where a share makes no sense, as what is missed of nothing."""
        if not isfinite(self.margin) or (self.limit is not None and not self.limit.value and not self.met):
            return ""
        percent = 100.0 * self.margin
        return f"{plain(0.0 if abs(percent) < 1e-4 else percent, 2 if abs(percent) < 10 else 3)} %"

    @property
    def missed_by(self) -> str:
        """By which part of its bound it is missed: "12 %", "met", or that this cannot be told."""
        if self.open:
            return "cannot be told"
        return "met" if self.met else self.margin_shown.removeprefix("-") or "without end"

    def to_json(self) -> dict[str, Any]:
        """`value`, `unit`, `shown` as of an entry; of a limit also its bound, what is left over, and the price."""
        bound: dict[str, Any] = {}
        if self.limit is not None:
            bound = {
                "side": self.side, "limit": self.limit.value, "limit_shown": self.limit.shown,
                "margin": round(self.margin, _DECIMALS) + 0.0 if isfinite(self.margin) else self.margin,
                "active": self.active, "met": self.met,
            }  # fmt: skip
        return {
            "response": self.response,
            "place": self.place,
            **self.value.to_json(),
            **bound,
            "worst_at": dict(self.worst_at),
            **({"off": dict(self.off)} if self.off else {}),
            **({"band": list(self.band), "met_by_band": self.met_by_band} if self.band is not None else {}),
            **({} if self.limit is None else {"price": self.price}),
        }


def at_most(
    name: str, response: str, place: str, value: Entry, limit: Entry | None, greatest: float | None = None
) -> Checked:
    """The row of an upper limit, or of a measure where there is none.

    greatest
        What rounding is measured by [SI], the bound itself where None.
    """
    if limit is None:
        return Checked(name, response, place, "", value)
    size = abs(limit.value) or 1.0
    slack = TOLERANCE * (size if greatest is None else max(greatest, size)) / size
    return Checked(name, response, place, "at_most", value, limit, (limit.value - value.value) / size, slack)
