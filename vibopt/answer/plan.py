"""Parts of a balancing plan: planes with their weights, readings with what is left, and what is worked out later."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from math import nan
from typing import Any, TypeVar, overload

from vibopt.answer.entry import Checked, Entry, Value, at_most, direction
from vibopt.arrays import ComplexArray
from vibopt.records import cached_property, dataclass

T = TypeVar("T")


class DeferredMapping(Mapping[str, T]):
    """A table by name: what is `known`, and so many `more` entries, which are made once, at the first look at one."""

    def __init__(self, known: Mapping[str, T], more: int, make: Callable[[], Mapping[str, T]]) -> None:
        self._known, self.more, self._make = known, more, make

    @cached_property
    def _made(self) -> Mapping[str, T]:
        return {**self._known, **self._make()}

    def __getitem__(self, name: str) -> T:
        return self._known[name] if name in self._known else self._made[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._made)

    def __len__(self) -> int:
        return len(self._known) + self.more

    def __reduce__(self) -> Any:
        return dict, (dict(self._made),)


class DeferredRows(Sequence[T]):
    """A list; `make` is called once, when one of its entries, or a length that is not known, is looked at."""

    def __init__(self, length: int | None, make: Callable[[], Sequence[T]]) -> None:
        self._length, self._make = length, make

    @cached_property
    def _made(self) -> tuple[T, ...]:
        return tuple(self._make())

    @overload
    def __getitem__(self, place: int) -> T: ...
    @overload
    def __getitem__(self, place: slice) -> tuple[T, ...]: ...
    def __getitem__(self, place: int | slice) -> T | tuple[T, ...]:
        return self._made[place]

    def __len__(self) -> int:
        return len(self._made) if self._length is None else self._length

    def __eq__(self, other: object) -> bool:
        return self._made == tuple(other) if isinstance(other, (tuple, DeferredRows)) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._made)

    def __reduce__(self) -> Any:
        return tuple, (self._made,)


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
    mass
        Of all its weights together [kg]; of a plane in unbalance what they do together [kg m].
    turn
        Where they act together [rad as counted].
    weights
        What is really fitted.
    say
        The same in plain words, made when they are looked at.
    acts_as
        Of several weights the one at the greatest radius that does the same [kg]; else None.
    """

    name: str
    action: str
    u: complex
    mass: Entry
    turn: float
    radius: Entry | None
    weights: tuple[Weight, ...]
    say: Callable[[], str]
    acts_as: Entry | None = None

    @property
    def angle(self) -> Entry | None:
        """Where they act together; None where nothing is fitted, or weights cancel."""
        acts = self.mass if self.acts_as is None else self.acts_as
        return direction(self.turn) if acts.value else None

    @property
    def words(self) -> str:
        """What is fitted, in plain words."""
        return self.say()

    def to_json(self) -> dict[str, Any]:
        return {
            "action": self.action,
            "mass" if self.mass.dimension == "mass" else "unbalance": self.mass.to_json(),
            **({} if self.acts_as is None else {"acts_as": self.acts_as.to_json()}),
            "angle": None if self.angle is None else self.angle.to_json(),
            "radius": None if self.radius is None else self.radius.to_json(),
            "weights": [_weight_json(weight, self.mass) for weight in self.weights],
            "words": self.words,
        }


def _weight_json(weight: Weight, mass: Entry) -> dict[str, Any]:
    return {
        "mass" if mass.dimension == "mass" else "unbalance": Entry(weight.mass, mass.dimension, mass.unit).to_json(),
        "radius": None if weight.radius is None else Entry(weight.radius, "length", "mm").to_json(),
        "angle": direction(weight.angle).to_json(),
        "hole": None if weight.hole is None else weight.hole + 1,
        "depth": None if weight.depth is None else Entry(weight.depth, "length", "mm").to_json(),
    }


@dataclass(frozen=True, slots=True)
class RowAnswer:
    """One sensor at one speed.

    found, residual
        Amplitudes as read and left [SI peak]; `found_phasor`, `residual_phasor` as text with their angle.
    fitted_phasor
        What the fit of all runs takes for the rotor as found; "" where that is what was read.
    band
        Ends of the 95 % band of the amplitude left; None where the scatter is not known.
    limit
        Greatest amplitude allowed, None without a limit.
    greatest
        Greatest reading of this kind [SI peak], beside which rounding is nothing.
    """

    sensor: str
    speed: Entry
    found: Entry
    residual: Entry
    found_phasor: str
    residual_phasor: str
    y0: complex
    left: complex
    fitted_phasor: str = ""
    band: tuple[Entry, Entry] | None = None
    limit: Entry | None = None
    greatest: float = 0.0

    @property
    def check(self) -> Checked | None:
        """Its row of a limit; None without one."""
        if self.limit is None:
            return None
        return at_most(self.sensor, "residual", "", self.residual, self.limit, self.greatest)

    def to_json(self) -> dict[str, Any]:
        return {
            "speed": self.speed.to_json(),
            "found": self.found.to_json(),
            "found_phasor": self.found_phasor,
            "fitted_phasor": self.fitted_phasor,
            "residual": self.residual.to_json(),
            "residual_phasor": self.residual_phasor,
            "band": None if self.band is None else [entry.to_json() for entry in self.band],
            "limit": None if self.limit is None else self.limit.to_json(),
            "margin": None if self.check is None else self.check.margin,
        }


@dataclass(frozen=True, slots=True)
class Remedy:
    """One way round planes that act alike, with what it costs.

    worst, rms
        What is left; where sensors measure several kinds of vibration the worst and the root mean square of parts of
        the greatest reading of its kind.
    part
        By which ways are compared: the worst of what is left, of several kinds as such a part.
    """

    name: str
    worst: Entry
    rms: Entry
    masses: tuple[str, ...]
    band: str = ""
    part: float = 0.0

    def to_json(self) -> dict[str, Any]:
        return {
            "remedy": self.name,
            "worst": self.worst.to_json(),
            "rms": self.rms.to_json(),
            "masses": list(self.masses),
            "band": self.band,
        }


@dataclass(frozen=True, slots=True)
class Fitting:
    """One complete answer: planes and rows; there are several where readings without phase leave more than one.

    left
        What is left per row, internal (n_rows,) [SI peak].
    """

    planes: tuple[PlaneAnswer, ...]
    rows: Sequence[RowAnswer]
    left: ComplexArray

    def to_json(self) -> dict[str, Any]:
        sensors: dict[str, Any] = {}
        for row in self.rows:
            sensors.setdefault(row.sensor, {"speeds": []})["speeds"].append(row.to_json())
        for sensor in sensors.values():
            worst = max(sensor["speeds"], key=lambda entry: entry["residual"]["value"])
            sensor["residual"], sensor["found"] = (
                worst["residual"],
                max((s["found"] for s in sensor["speeds"]), key=lambda e: e["value"]),
            )
        return {"planes": {plane.name: plane.to_json() for plane in self.planes}, "sensors": sensors}

    def entries(self, before: str = "") -> dict[str, Value]:
        """Every number by its path, with `before` in front."""
        found: dict[str, Value] = {}
        for plane in self.planes:
            path = f"{before}planes.{plane.name}"
            found[f"{path}.mass" if plane.mass.dimension == "mass" else f"{path}.unbalance"] = plane.mass
            if plane.acts_as is not None:
                found[f"{path}.acts_as"] = plane.acts_as
            if plane.angle is not None:
                found[f"{path}.angle"] = plane.angle
            if plane.radius is not None:
                found[f"{path}.radius"] = plane.radius
        greatest: dict[str, Entry] = {}
        for row in self.rows:
            path = f"{before}sensors.{row.sensor}"
            found[f"{path}.at {row.speed.shown}.residual"] = row.residual
            for key, entry in (("residual", row.residual), ("found", row.found)):
                known = greatest.get(f"{path}.{key}")
                if known is None or known.value < entry.value:
                    greatest[f"{path}.{key}"] = entry
        return {**found, **greatest}


@dataclass(frozen=True)
class Plan:
    """What to do with a measured rotor; empty for other kinds of job.

    fittings
        The answer; several where readings without phase allow them; empty where nothing was found.
    conventions
        In plain sentences, to be repeated wherever the plan is shown.
    words
        What to do, one sentence a line.
    remedies
        Side by side, where planes act almost alike.
    beside
        Plans by other runs side by side, where the runs contradict each other.
    condition
        Condition number of what the planes do at the sensors.
    gap
        Of the optimum, relative.
    """

    fittings: tuple[Fitting, ...] = ()
    conventions: tuple[str, ...] = ()
    words: Sequence[str] = ()
    remedies: tuple[Remedy, ...] = ()
    beside: tuple[Remedy, ...] = ()
    condition: float = 1.0
    gap: float = nan

    @property
    def planes(self) -> tuple[PlaneAnswer, ...]:
        """Of the first answer."""
        return self.fittings[0].planes if self.fittings else ()

    @property
    def rows(self) -> Sequence[RowAnswer]:
        """Of the first answer."""
        return self.fittings[0].rows if self.fittings else ()

    def entries(self) -> dict[str, Value]:
        """Every number by its path; of several answers by number as well."""
        found: dict[str, Value] = {}
        for number, fitting in enumerate(self.fittings, start=1):
            if len(self.fittings) > 1:
                found.update(fitting.entries(f"answers.{number}."))
            if number == 1:
                found.update(fitting.entries())
        return found

    def to_json(self) -> dict[str, Any]:
        first = self.fittings[0].to_json() if self.fittings else {"planes": {}, "sensors": {}}
        return {
            "words": self.words, **first,
            "answers": [fitting.to_json() for fitting in self.fittings] if len(self.fittings) > 1 else [],
            "remedies": self.remedies, "beside": self.beside, "condition": self.condition, "gap": self.gap,
        }  # fmt: skip
