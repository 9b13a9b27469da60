"""Parts of a balancing plan: planes with their weights, readings with what is left, limits with their price."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from vibopt.answer.entry import Checked, Entry, at_most, direction
from vibopt.forms import ComplexArray


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
        Of one weight that does the same at the greatest radius [kg; kg m for planes in unbalance; rad as counted].
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
    price
        What a wider limit buys, in words; "" where it buys nothing.
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
    price: str = ""
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
            "band": None if self.band is None else [one.to_json() for one in self.band],
            "limit": None if self.limit is None else self.limit.to_json(),
            "margin": None if self.check is None else self.check.margin,
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
        for one in sensors.values():
            worst = max(one["speeds"], key=lambda entry: entry["residual"]["value"])
            one["residual"], one["found"] = (
                worst["residual"],
                max((s["found"] for s in one["speeds"]), key=lambda e: e["value"]),
            )
        return {"planes": {one.name: one.to_json() for one in self.planes}, "sensors": sensors}
