"""Tables of a job with known masses: [shaft], [masses.NAME], [planes.NAME], their limits and goal."""

from __future__ import annotations

from math import tau
from typing import Any, Literal

from pydantic import Field, field_validator, model_validator

from vibopt.balancing.fitted import is_fitted
from vibopt.balancing.plane_options import ALL_FORBIDDEN, KEPT_AND_REMOVED, listed_twice
from vibopt.balancing.planes import open_arcs, read_arc
from vibopt.errors import QuantityError
from vibopt.units import read_quantity
from vibopt.values import Choice, Fact, Table, number
from vibopt.values.fields import complaint, word

_DIMENSION_OF = {
    "static_unbalance": "unbalance",
    "couple_unbalance": "couple_unbalance",
    "bearing_reaction": "force",
    "correction": "mass",
}


class ShaftTable(Table):
    """[shaft]: bearings by name and place, and the speed of the reactions; all optional.

    Keys
    ----
    speed: At which the reactions of the bearings are taken: `speed = "1500 rpm"`.
    bearings: Two, by name and place along the shaft: `bearings = { A = "0 mm", B = "900 mm" }`.
    """

    speed: Fact | None = number("angular_rate", choice=False)
    bearings: dict[str, Any] = Field(default_factory=dict)

    @field_validator("bearings")
    @classmethod
    def _places(cls, given: dict[str, Any]) -> dict[str, float]:
        if given and len(given) != 2:
            example = 'bearings = { A = "0 mm", B = "900 mm" }'
            raise word(f"names {len(given)} bearings, but two carry a shaft. Write {example}.")
        places = {name: quantity(at, "length") for name, at in given.items()}
        if len(set(places.values())) < len(places):
            raise word("has both bearings at the same place.")
        return places


class MassTable(Table):
    """[masses.NAME]: a mass at a radius, or an unbalance, at an angle and an axial place.

    Keys
    ----
    mass: Of the piece, beside its `radius`; or `unbalance` alone.
    radius: Of its centre of mass from the axis.
    unbalance: Mass times radius: `unbalance = "50 kg mm"`.
    angle: Where it is: `angle = "90 deg"`.
    at: Place along the shaft; none anywhere: all in one plane.
    removed: It is a hole: `removed = true`.
    """

    mass: Fact | None = number("mass", choice=False)
    radius: Fact | None = number("length", choice=False)
    unbalance: Fact | None = number("unbalance", choice=False)
    angle: Fact = number("angle", choice=False, sign="any", required=True)
    at: Fact | None = number("length", choice=False, sign="any")
    removed: bool = False

    @model_validator(mode="after")
    def _size(self) -> MassTable:
        if (self.unbalance is None) == (self.mass is None and self.radius is None):
            raise word('needs mass and radius, or an unbalance alone. Write mass = "1 kg" and radius = "50 mm".')
        if self.unbalance is None and (self.mass is None or self.radius is None):
            absent = "radius" if self.radius is None else "mass"
            raise word(f'has no {absent}. Add it, or write unbalance = "50 kg mm" instead of both.')
        return self

    @property
    def size(self) -> float:
        """Unbalance, signed: material that was removed counts backwards [kg m]."""
        full = self.unbalance.value if self.unbalance is not None else 1.0
        for part in (self.mass, self.radius):
            full *= part.value if part is not None else 1.0
        return -full if self.removed else full


class DrillTable(Table):
    """drill = { diameter, density }: turns a removed mass into the depth of a flat-bottomed hole.

    Keys
    ----
    diameter: Of the drill.
    density: Of the material.
    deepest: The deepest hole that is allowed.
    """

    diameter: Fact = number("length", choice=False, required=True)
    density: Fact = number("density", choice=False, required=True)
    deepest: Fact | None = number("length", choice=False)


class Decided(Table):
    """The weights of a plane where they are no range to choose from: texts as those of runs are written."""

    texts: Any


class KnownPlaneTable(Table):
    """[planes.NAME]: where a correction may be fitted, and what there is to fit.

    Keys
    ----
    at: Place along the shaft.
    radius: Where weights sit: `radius = "50 mm"`. Without it a plane counts in unbalance alone.
    weight: The most that may be fitted, `weight = { from = "0 g", to = "60 g" }`; or weights that are fitted, "10 g
        @ 270 deg".
    unbalance: Instead of `weight` the most mass times radius: `unbalance = { from = "0 g mm", to = "5000 g mm" }`.
    holes: A count, the first hole at 0 deg, or their angles: `holes = 24`. Needs a shelf.
    shelf: The weights there are, one a hole: `shelf = ["5 g", "10 g", "20 g"]`. Needs holes and a radius.
    most_weights: How many weights may be fitted in this plane.
    forbidden: Sectors without weights; "350..10 deg" goes through zero: `forbidden = ["80..110 deg"]`.
    remove: Material is taken away, on the other side: `remove = true`. Not beside a shelf.
    drill: Says the depth of what is removed: `drill = { diameter = "10 mm", density = "7850 kg/m³" }`.
    keep: The plane stays untouched: `keep = true`.
    """

    at: Fact | None = number("length", choice=False, sign="any")
    radius: Fact | None = number("length", choice=False)
    weight: Fact | Choice | Decided | None = number("mass")
    unbalance: Fact | Choice | Decided | None = number("unbalance")
    holes: Any = None
    shelf: list[str] = Field(default_factory=list)
    most_weights: int = 1
    forbidden: list[Any] = Field(default_factory=list)
    remove: bool = False
    drill: DrillTable | None = None
    keep: bool = False

    @model_validator(mode="before")
    @classmethod
    def _decided(cls, given: Any) -> Any:
        if not isinstance(given, dict):
            return given
        return {
            key: Decided(texts=one) if key in ("weight", "unbalance") and is_fitted(one) else one
            for key, one in given.items()
        }

    @field_validator("weight", "unbalance")
    @classmethod
    def _cap(cls, given: Any) -> Any:
        if isinstance(given, Fact):
            raise word(
                'is one value, but a plane needs the range to choose from. Write { from = "0 g", to = "60 g" }, or '
                'the weight that is fitted with its angle, "10 g @ 270 deg".'
            )
        return given

    @field_validator("holes")
    @classmethod
    def _angles(cls, given: Any) -> tuple[float, ...] | None:
        """Angles [rad]; a count starts at zero."""
        if isinstance(given, int) and not isinstance(given, bool) and given > 0:
            return tuple(tau * k / given for k in range(given))
        if isinstance(given, list) and given:
            holes = tuple(quantity(one, "angle") for one in given)
            if twice := listed_twice(holes):
                raise complaint(twice)
            return holes
        raise complaint('is neither a number of holes nor a list of angles. Write 24, or ["0 deg", "30 deg"].')

    @field_validator("shelf")
    @classmethod
    def _weights(cls, given: list[str]) -> list[str]:
        for one in given:
            if quantity(one, "mass") <= 0.0:
                raise complaint(f'holds "{one}", which is no weight. Write the mass of each, shelf = ["5 g", "10 g"].')
        return given

    @field_validator("forbidden")
    @classmethod
    def _sectors(cls, given: list[Any]) -> list[tuple[float, float]]:
        try:
            return [read_arc(one) for one in given]
        except QuantityError as error:
            raise complaint(f"holds a sector that {error.complaint}") from None

    @model_validator(mode="after")
    def _fits(self) -> KnownPlaneTable:
        for wrong, sentence in (
            (
                self.holes is not None and not self.shelf and not self.is_decided,
                'has holes but no weights to put in. Write shelf = ["5 g", "10 g"].',
            ),
            (bool(self.shelf) and self.holes is None, "has weights on the shelf but no holes. Write holes = 24."),
            (self.radius is None and bool(self.shelf), 'has weights but no radius. Write radius = "150 mm".'),
            (self.drill is not None and not self.remove, "has a drill but adds weights. Write remove = true."),
            (self.radius is None and self.drill is not None, 'has a drill but no radius. Write radius = "150 mm".'),
            (
                self.radius is None and self.weight is not None,
                'limits its weight but has no radius. Write radius = "150 mm", or limit unbalance.',
            ),
            (self.remove and bool(self.shelf), "removes material and has weights on the shelf. Keep one of them."),
            (self.holes is None and not open_arcs(self.forbidden), ALL_FORBIDDEN),
            (self.keep and self.remove, KEPT_AND_REMOVED),
            (self.most_weights < 1, "has most_weights below 1. Write 1, or keep = true where nothing may change."),
        ):
            if wrong:
                raise word(sentence)
        return self

    @property
    def is_decided(self) -> bool:
        """Whether its weights are given."""
        return isinstance(self.weight, Decided) or isinstance(self.unbalance, Decided)

    @property
    def weights(self) -> tuple[float, ...]:
        """Masses on the shelf [kg]."""
        return tuple(sorted({quantity(one, "mass") for one in self.shelf}))


class KnownLimitTable(Table):
    """[limits.NAME] or [measures.NAME]: what is left after the correction, or the correction itself.

    Keys
    ----
    response: What is limited or measured.
    of: The bearing of a reaction, or the plane of a correction: `of = "A"`.
    total: Mass of all planes together: `total = true`.
    at_most: The greatest value that is allowed; a measure has none: `at_most = "20 N"`.
    unit: How the value is shown: `unit = "N"`.
    """

    response: Literal["static_unbalance", "couple_unbalance", "bearing_reaction", "correction"]
    of: str | None = None
    total: bool = False
    at_most: Any = None
    unit: str = ""

    @model_validator(mode="after")
    def _bound(self) -> KnownLimitTable:
        if self.at_most is not None:
            quantity(self.at_most, self.dimension)
        if self.response == "correction" and (self.of is None) != self.total:
            raise word('needs of = "PLANE" or total = true, one of the two.')
        return self

    @property
    def dimension(self) -> str:
        """Dimension of the response."""
        return _DIMENSION_OF[self.response]

    @property
    def bound(self) -> float:
        """at_most in SI; inf for a measure."""
        return float("inf") if self.at_most is None else quantity(self.at_most, self.dimension)


class KnownGoalTable(Table):
    """[goal] minimise = "unbalance" or "reaction" at the bearings, combined as rms, worst or sum; or one quantity.

    Keys
    ----
    minimise: What is made small; "unbalance" and "reaction" at both bearings.
    combine: Of both bearings: least squares, the greater one, or their sum. Refused beside what is one quantity.
    """

    minimise: Literal["unbalance", "static_unbalance", "couple_unbalance", "reaction", "correction"]
    combine: Literal["rms", "worst", "sum"] = "rms"

    @model_validator(mode="after")
    def _combines(self) -> KnownGoalTable:
        if "combine" in self.model_fields_set and self.minimise not in ("unbalance", "reaction"):
            raise word(f'has combine, but minimise = "{self.minimise}" is one quantity. Leave combine out.')
        return self


def quantity(given: object, dimension: str) -> float:
    """A value inside a list or a table without a field of its own, in SI."""
    try:
        return read_quantity(given, dimension).value
    except QuantityError as error:
        said = error.complaint
        raise complaint(f'holds "{given}", which {said}' if isinstance(given, str) else said) from None
