"""The answer to a balancing job of known masses or an engine: status, claim, and every number by its path."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import tau
from typing import Any

from vibopt.answer.entry import Checked, Entry, Price, Value, Word, direction
from vibopt.answer.status import Judged
from vibopt.errors import UnknownName


@dataclass(frozen=True)
class Outcome(Judged):
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
    values: Mapping[str, Value]
    limits: Mapping[str, Checked] = field(default_factory=dict)
    measures: Mapping[str, Checked] = field(default_factory=dict)
    goal: tuple[str, Entry] | None = None
    method: str = ""
    notes: tuple[str, ...] = ()
    details: Mapping[str, Any] = field(default_factory=dict)
    expected: tuple[Mapping[str, Any], ...] = ()
    reason: str = ""
    prices: Mapping[str, Price] = field(default_factory=dict)

    def entries(self) -> dict[str, Value]:
        """Every number and word by its path, as the records of a problem file name them."""
        found = {"status": Word(self.status), **self.values}
        for family, table in (("limits", self.limits), ("measures", self.measures)):
            found.update({f"{family}.{name}.value": held.value for name, held in table.items()})
        if self.goal is not None:
            found["goal"] = self.goal[1]
        return found

    def find(self, path: str) -> Value:
        """The number at a path; UnknownName where there is none."""
        entries = self.entries()
        if path not in entries:
            raise UnknownName.among("path", path, entries)
        return entries[path]

    def to_json(self) -> dict[str, Any]:
        """The answer as plain data; values are nested by their paths."""
        from vibopt.design.jsonable import plain

        data: dict[str, Any] = {
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
            here = data
            for step in steps:
                here = here.setdefault(step, {})
            here[last] = entry.to_json()
        return dict(plain(data))


def angle(z: complex) -> Entry:
    """The angle of a phasor, in 0..360 deg; a full turn but for rounding counts as zero."""
    from cmath import phase

    turned = phase(z) % tau
    return direction(0.0 if tau - turned < 1e-9 else turned)
