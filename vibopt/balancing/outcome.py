"""The answer to a balancing job of known masses or an engine: status, claim, and every number by its path."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import tau
from typing import Any

from vibopt.errors import NotProven, UnknownName
from vibopt.units import show, si_unit

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


@dataclass(frozen=True, slots=True)
class Entry:
    """One number (SI, amplitudes peak, angles in 0..2 pi) or one word of the answer.

    value
        In SI; a text where the answer is a word.
    dimension
        Name in `vibopt.units`; "" for a word.
    unit
        The user's unit; "" lets the size choose.
    amplitude
        Whether "pk" belongs behind the number.
    """

    value: float | str
    dimension: str = ""
    unit: str = ""
    amplitude: bool = False

    @property
    def shown(self) -> str:
        """As text in the user's unit."""
        if isinstance(self.value, str):
            return self.value
        return show(self.value, self.unit, self.dimension, digits=6, amplitude=self.amplitude)

    def to_json(self) -> Any:
        """`value` and `unit` are SI, `shown` is in the user's unit; a word is itself."""
        if isinstance(self.value, str):
            return self.value
        return {"value": self.value, "unit": si_unit(self.dimension), "shown": self.shown}


@dataclass(frozen=True, slots=True)
class Held:
    """One limit (bound given) or measure (bound None) of the finished design, measured on its simulated motion.

    response
        Kind of response with its place ("bearing_reaction of A").
    price
        What the goal falls by per unit of the loosened limit [SI], None where it was not found out.
    buys
        What a sensible step buys, in words; "" where it buys nothing or was not found out.
    """

    response: str
    value: Entry
    limit: Entry | None = None
    price: float | None = None
    buys: str = ""

    @property
    def met(self) -> bool:
        """Whether the limit holds, to 1e-6 of itself."""
        if self.limit is None or isinstance(self.limit.value, str) or isinstance(self.value.value, str):
            return True
        return self.value.value <= self.limit.value * (1.0 + 1e-6) + 1e-12

    @property
    def margin(self) -> float:
        """Part of the limit that is left over."""
        if self.limit is None or not isinstance(self.limit.value, float) or not isinstance(self.value.value, float):
            return float("inf")
        return 1.0 - self.value.value / self.limit.value if self.limit.value else 0.0

    def to_json(self) -> dict[str, Any]:
        """As in the JSON of a design."""
        plain = {"response": self.response, **self.value.to_json()}
        if self.limit is None:
            return plain
        bound = {"limit": self.limit.value, "limit_shown": self.limit.shown, "margin": self.margin}
        return {**plain, **bound, "active": self.margin < 1e-6, "met": self.met, "price": self.price, "buys": self.buys}


@dataclass(frozen=True)
class Outcome:
    """Answer to a job; the same surface as the plan of a measured rotor.

    values
        Every number of the answer by its path ("planes.A.mass").
    limits, measures
        Measured on the balanced machine.
    goal
        (name, value); None for an analysis.
    notes
        Conventions, readings of units, and what else must be known to use the answer.
    prices
        What a wider cap buys, in words, by the path of the cap.
    reason
        Limits that cannot hold together, and the smallest loosening that helps; "" elsewhere.
    """

    name: str
    title: str
    status: str
    claim: str
    values: Mapping[str, Entry]
    limits: Mapping[str, Held] = field(default_factory=dict)
    measures: Mapping[str, Held] = field(default_factory=dict)
    goal: tuple[str, Entry] | None = None
    method: str = ""
    notes: tuple[str, ...] = ()
    details: Mapping[str, Any] = field(default_factory=dict)
    expected: tuple[Mapping[str, Any], ...] = ()
    reason: str = ""
    prices: Mapping[str, str] = field(default_factory=dict)

    @property
    def exit_code(self) -> int:
        """Exit code of the command line."""
        return EXIT_CODES[self.status]

    @property
    def proven(self) -> bool:
        """Whether nothing about the status is left open."""
        return self.status not in ("feasible", "unproven", "check_failed")

    def require_proof(self) -> Outcome:
        """This answer, if its status is proven; NotProven otherwise."""
        if not self.proven:
            raise NotProven(f"{self.name}: {self.status}: {self.claim}")
        return self

    def entries(self) -> dict[str, Entry]:
        """Every number and word by its path, as the records of a problem file name them."""
        found = {"status": Entry(self.status), **self.values}
        for family, table in (("limits", self.limits), ("measures", self.measures)):
            found.update({f"{family}.{name}.value": held.value for name, held in table.items()})
        if self.goal is not None:
            found["goal"] = self.goal[1]
        return found

    def find(self, path: str) -> Entry:
        """The number at a path; UnknownName where there is none."""
        entries = self.entries()
        if path not in entries:
            raise UnknownName.among("path", path, entries)
        return entries[path]

    def to_json(self) -> dict[str, Any]:
        """The answer as plain data; values are nested by their paths."""
        plain: dict[str, Any] = {
            "name": self.name,
            "title": self.title,
            "status": self.status,
            "claim": self.claim,
            "reason": self.reason,
            "goal": None if self.goal is None else {"name": self.goal[0], **self.goal[1].to_json()},
            "limits": {name: held.to_json() for name, held in self.limits.items()},
            "measures": {name: held.to_json() for name, held in self.measures.items()},
            "prices": dict(self.prices),
            "method": self.method,
            "notes": list(self.notes),
            "details": dict(self.details),
        }
        for path, entry in self.values.items():
            *steps, last = path.split(".")
            here = plain
            for step in steps:
                here = here.setdefault(step, {})
            here[last] = entry.to_json()
        return plain

    def text(self) -> str:
        """The answer for the terminal: verdict, numbers by path, limits, notes."""
        lines = [self.title, f"{self.status}: {self.claim}", *([self.reason] if self.reason else []), ""]
        lines += [f"  {path:<34} {entry.shown}" for path, entry in self.values.items()]
        for name, held in {**self.limits, **self.measures}.items():
            bound = "" if held.limit is None else f"   at most {held.limit.shown}   {'met' if held.met else 'BROKEN'}"
            lines.append(f"  {name:<34} {held.value.shown}{bound}")
        return "\n".join([*lines, "", *self.notes]).rstrip() + "\n"


def angle(z: complex) -> Entry:
    """The angle of a phasor, in 0..360 deg; a full turn but for rounding counts as zero."""
    from cmath import phase

    turned = phase(z) % tau
    return Entry(0.0 if tau - turned < 1e-9 else turned, "angle", "deg")
