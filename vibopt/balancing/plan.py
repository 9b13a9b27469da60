"""The plan: what to fit where, what will be left, and how far that is known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from vibopt.answer.entry import Checked, Entry, Price, Value, Word
from vibopt.answer.status import Judged
from vibopt.balancing.answers import Fitting, PlaneAnswer, Remedy, RowAnswer
from vibopt.balancing.job import RotorJob
from vibopt.errors import UnknownName


@dataclass(frozen=True)
class Plan(Judged):
    """Answer to a balancing job on a measured rotor.

    status
        A key of EXIT_CODES.
    claim
        How the status is known, in words.
    fittings
        The answer; several where readings without phase allow them; empty where nothing was found.
    limits
        Of the file, by name.
    conventions
        In plain sentences, to be repeated wherever the plan is shown.
    words
        What to do, one sentence a line.
    values
        Further numbers by path (grades, coefficients, trial weights).
    prices
        What a wider cap of a plane buys, in words, by the path of the cap.
    remedies
        Side by side, where planes act almost alike.
    beside
        Plans by other runs side by side, where the runs contradict each other.
    gap
        Of the optimum, relative.
    """

    job: RotorJob
    status: str
    claim: str
    goal: tuple[str, Entry] | None = None
    fittings: tuple[Fitting, ...] = ()
    limits: Mapping[str, Checked] = field(default_factory=dict)
    conventions: tuple[str, ...] = ()
    words: tuple[str, ...] = ()
    values: Mapping[str, Value] = field(default_factory=dict)
    remedies: tuple[Remedy, ...] = ()
    beside: tuple[Remedy, ...] = ()
    condition: float = 1.0
    gap: float = float("nan")
    reason: str = ""
    method: str = ""
    notes: tuple[str, ...] = ()
    details: Mapping[str, Any] = field(default_factory=dict)
    prices: Mapping[str, Price] = field(default_factory=dict)

    @property
    def name(self) -> str:
        return self.job.name

    @property
    def title(self) -> str:
        return self.job.title

    @property
    def expected(self) -> tuple[Mapping[str, Any], ...]:
        return self.job.expected

    @property
    def measures(self) -> Mapping[str, Checked]:
        return {}

    @property
    def planes(self) -> tuple[PlaneAnswer, ...]:
        """Of the first answer."""
        return self.fittings[0].planes if self.fittings else ()

    @property
    def rows(self) -> Sequence[RowAnswer]:
        """Of the first answer."""
        return self.fittings[0].rows if self.fittings else ()

    def entries(self) -> dict[str, Value]:
        """Every number and word by its path, as the records of a problem file name them."""
        found = {"status": Word(self.status), **self.values}
        for number, fitting in enumerate(self.fittings, start=1):
            before = "" if len(self.fittings) == 1 else f"answers.{number}."
            found.update(_entries_of(fitting, before))
            if number == 1:
                found.update(_entries_of(fitting, ""))
        found.update({f"limits.{name}.value": one.value for name, one in self.limits.items()})
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
        """The plan as plain data: values in SI (amplitudes peak), `shown` in the user's units and conventions."""
        from vibopt.design.jsonable import plain

        first = self.fittings[0].to_json() if self.fittings else {"planes": {}, "sensors": {}}
        nested: dict[str, Any] = {}
        for path, entry in self.values.items():
            *steps, last = path.split(".")
            here = nested
            for step in steps:
                here = here.setdefault(step, {})
            here[last] = entry.to_json()
        data = {
            "name": self.name, "title": self.title, "status": self.status, "claim": self.claim, "reason": self.reason,
            "goal": None if self.goal is None else {"name": self.goal[0], **self.goal[1].to_json()},
            "conventions": {**_spoken(self.job), "words": list(self.conventions)},
            "words": list(self.words), **first,
            "answers": [one.to_json() for one in self.fittings] if len(self.fittings) > 1 else [],
            "limits": {name: one.to_json() for name, one in self.limits.items()},
            "values": nested, "prices": dict(self.prices),
            "remedies": [one.to_json() for one in self.remedies],
            "beside": [one.to_json() for one in self.beside],
            "condition": self.condition, "gap": self.gap, "method": self.method,
            "notes": list(self.notes), "details": dict(self.details),
        }  # fmt: skip
        return dict(plain(data))


_CONVENTIONS = ("phase", "readings", "angles", "detector", "zero")


def _spoken(job: RotorJob) -> dict[str, str]:
    return {key: getattr(job.conventions, key) for key in _CONVENTIONS}


def _entries_of(fitting: Fitting, before: str) -> dict[str, Value]:
    found: dict[str, Value] = {}
    for plane in fitting.planes:
        path = f"{before}planes.{plane.name}"
        found[f"{path}.mass" if plane.mass.dimension == "mass" else f"{path}.unbalance"] = plane.mass
        found[f"{path}.angle"] = plane.angle
        if plane.radius is not None:
            found[f"{path}.radius"] = plane.radius
    for row in fitting.rows:
        path = f"{before}sensors.{row.sensor}"
        found[f"{path}.at {row.speed.shown}.residual"] = row.residual
        for key, entry in (("residual", row.residual), ("found", row.found)):
            known = found.get(f"{path}.{key}")
            if known is None or float(known.value) < float(entry.value):
                found[f"{path}.{key}"] = entry
    return found
