"""The plan: what to fit where, what will be left, and how far that is known."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from vibopt.balancing.job import RotorJob
from vibopt.balancing.outcome import EXIT_CODES, Entry
from vibopt.errors import NotProven, UnknownName


@dataclass(frozen=True, slots=True)
class Weight:
    """One weight to bolt on, or one place to take material away.

    mass
        [kg]; unbalance [kg m] for a plane in unbalance.
    radius
        [m]; None where the file has none.
    angle
        As the user counts it, 0 to 2 pi [rad].
    hole
        Index of the hole, None away from holes.
    depth
        Of the hole to drill [m], None without a drill.
    """

    mass: float
    radius: float | None
    angle: float
    hole: int | None = None
    depth: float | None = None


@dataclass(frozen=True, slots=True)
class PlaneAnswer:
    """What happens in one plane.

    action
        "add", "remove", "nothing" (no weight is best) or "keep" (as asked).
    u
        Internal unbalance added [kg m].
    mass, angle
        Of one weight that does the same at the greatest radius [kg, kg m for planes in unbalance; rad as the user counts].
    weights
        What is really fitted.
    words
        The same in plain words.
    """

    name: str
    action: str
    u: complex
    mass: Entry
    angle: Entry
    radius: Entry | None
    weights: tuple[Weight, ...]
    words: str

    def to_json(self) -> dict[str, Any]:
        return {
            "action": self.action,
            "mass" if self.mass.dimension == "mass" else "unbalance": self.mass.to_json(),
            "angle": self.angle.to_json(),
            "radius": None if self.radius is None else self.radius.to_json(),
            "weights": [_weight_json(one, self.mass) for one in self.weights],
            "words": self.words,
        }


def _weight_json(weight: Weight, mass: Entry) -> dict[str, Any]:
    return {
        "mass" if mass.dimension == "mass" else "unbalance": Entry(weight.mass, mass.dimension, mass.unit).to_json(),
        "radius": None if weight.radius is None else Entry(weight.radius, "length", "mm").to_json(),
        "angle": Entry(weight.angle, "angle", "deg").to_json(),
        "hole": None if weight.hole is None else weight.hole + 1,
        "depth": None if weight.depth is None else Entry(weight.depth, "length", "mm").to_json(),
    }


@dataclass(frozen=True, slots=True)
class RowAnswer:
    """One sensor at one speed.

    found, residual
        Amplitudes as found and left [SI peak]; `found_phasor`, `residual_phasor` as text with their angle.
    band
        Ends of the 95 % band of the amplitude left; None where the scatter is not known.
    limit
        Greatest amplitude allowed, None without a limit.
    price
        What a wider limit buys, in words; "" where it buys nothing.
    """

    sensor: str
    speed: Entry
    found: Entry
    residual: Entry
    found_phasor: str
    residual_phasor: str
    y0: complex
    left: complex
    band: tuple[Entry, Entry] | None = None
    limit: Entry | None = None
    price: str = ""

    @property
    def margin(self) -> float:
        """Part of the limit that is left over; inf without a limit."""
        if self.limit is None or not isinstance(self.limit.value, float) or not isinstance(self.residual.value, float):
            return float("inf")
        return 1.0 - self.residual.value / self.limit.value

    def to_json(self) -> dict[str, Any]:
        return {
            "speed": self.speed.to_json(),
            "found": self.found.to_json(),
            "found_phasor": self.found_phasor,
            "residual": self.residual.to_json(),
            "residual_phasor": self.residual_phasor,
            "band": None if self.band is None else [one.to_json() for one in self.band],
            "limit": None if self.limit is None else self.limit.to_json(),
            "margin": None if self.limit is None else self.margin,
            "price": self.price,
        }


@dataclass(frozen=True, slots=True)
class LimitAnswer:
    """A limit of the file: its worst value, bound, and price in words."""

    response: str
    place: str
    value: Entry
    limit: Entry
    price: str = ""

    @property
    def margin(self) -> float:
        value, limit = self.value.value, self.limit.value
        return 1.0 - value / limit if isinstance(value, float) and isinstance(limit, float) else 0.0

    @property
    def met(self) -> bool:
        return self.margin >= -1e-6

    def to_json(self) -> dict[str, Any]:
        return {
            "response": self.response,
            "place": self.place,
            **self.value.to_json(),
            "limit": self.limit.value,
            "limit_shown": self.limit.shown,
            "margin": self.margin,
            "active": self.margin < 1e-6,
            "met": self.met,
            "price": self.price,
        }


@dataclass(frozen=True, slots=True)
class Remedy:
    """One way round planes that act alike, with what it costs."""

    name: str
    worst: Entry
    rms: Entry
    masses: tuple[str, ...]
    band: str = ""

    def to_json(self) -> dict[str, Any]:
        return {"remedy": self.name, "worst": self.worst.to_json(), "rms": self.rms.to_json(), "masses": list(self.masses), "band": self.band}


@dataclass(frozen=True, slots=True)
class Fitting:
    """One complete answer: planes and rows; there are several where readings without phase leave more than one."""

    planes: tuple[PlaneAnswer, ...]
    rows: tuple[RowAnswer, ...]

    def to_json(self) -> dict[str, Any]:
        sensors: dict[str, Any] = {}
        for row in self.rows:
            sensors.setdefault(row.sensor, {"speeds": []})["speeds"].append(row.to_json())
        for one in sensors.values():
            worst = max(one["speeds"], key=lambda entry: entry["residual"]["value"])
            one["residual"], one["found"] = worst["residual"], max((s["found"] for s in one["speeds"]), key=lambda e: e["value"])
        return {"planes": {one.name: one.to_json() for one in self.planes}, "sensors": sensors}


@dataclass(frozen=True)
class Plan:
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
    remedies
        Side by side, where planes act almost alike.
    gap
        Of the optimum, relative.
    """

    job: RotorJob
    status: str
    claim: str
    goal: tuple[str, Entry] | None = None
    fittings: tuple[Fitting, ...] = ()
    limits: Mapping[str, LimitAnswer] = field(default_factory=dict)
    conventions: tuple[str, ...] = ()
    words: tuple[str, ...] = ()
    values: Mapping[str, Entry] = field(default_factory=dict)
    remedies: tuple[Remedy, ...] = ()
    condition: float = 1.0
    gap: float = float("nan")
    reason: str = ""
    method: str = ""
    notes: tuple[str, ...] = ()
    details: Mapping[str, Any] = field(default_factory=dict)

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
    def planes(self) -> tuple[PlaneAnswer, ...]:
        """Of the first answer."""
        return self.fittings[0].planes if self.fittings else ()

    @property
    def rows(self) -> tuple[RowAnswer, ...]:
        """Of the first answer."""
        return self.fittings[0].rows if self.fittings else ()

    @property
    def exit_code(self) -> int:
        """Exit code of the command line."""
        return EXIT_CODES[self.status]

    @property
    def proven(self) -> bool:
        """Whether nothing about the status is left open."""
        return self.status not in ("feasible", "unproven", "check_failed")

    def require_proof(self) -> Plan:
        """This plan, if its status is proven; NotProven otherwise."""
        if not self.proven:
            raise NotProven(f"{self.name}: {self.status}: {self.claim}")
        return self

    def entries(self) -> dict[str, Entry]:
        """Every number and word by its path, as the records of a problem file name them."""
        found = {"status": Entry(self.status), **self.values}
        for number, fitting in enumerate(self.fittings, start=1):
            before = "" if len(self.fittings) == 1 else f"answers.{number}."
            found.update(_entries_of(fitting, before))
            if number == 1:
                found.update(_entries_of(fitting, ""))
        found.update({f"limits.{name}.value": one.value for name, one in self.limits.items()})
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
            "conventions": {**{key: getattr(self.job.conventions, key) for key in _CONVENTIONS}, "words": list(self.conventions)},
            "words": list(self.words), **first,
            "answers": [one.to_json() for one in self.fittings] if len(self.fittings) > 1 else [],
            "limits": {name: one.to_json() for name, one in self.limits.items()},
            "values": nested, "remedies": [one.to_json() for one in self.remedies],
            "condition": self.condition, "gap": self.gap, "method": self.method,
            "notes": list(self.notes), "details": dict(self.details),
        }  # fmt: skip
        return dict(plain(data))

    def text(self) -> str:
        """The plan for the terminal, bare: verdict, what to do, what is left, notes."""
        lines = [self.title, f"{self.status}: {self.claim}", *([self.reason] if self.reason else []), "", *self.conventions, ""]
        lines += [*self.words, ""]
        for row in self.rows:
            band = "" if row.band is None else f"  (95 %: {row.band[0].shown} to {row.band[1].shown})"
            bound = "" if row.limit is None else f"  at most {row.limit.shown}"
            lines.append(f"  {row.sensor:<12} {row.speed.shown:<10} {row.found_phasor} -> {row.residual.shown}{band}{bound}")
        lines += ["", *(f"  {path:<40} {entry.shown}" for path, entry in self.values.items())]
        return "\n".join([*lines, "", *self.notes]).rstrip() + "\n"


_CONVENTIONS = ("phase", "readings", "angles", "detector", "zero")


def _entries_of(fitting: Fitting, before: str) -> dict[str, Entry]:
    found: dict[str, Entry] = {}
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


__all__ = ["EXIT_CODES", "Fitting", "LimitAnswer", "Plan", "PlaneAnswer", "Remedy", "RowAnswer", "Weight"]
