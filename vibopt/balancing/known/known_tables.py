"""Tables of a job with known masses: [shaft], [masses.NAME], [planes.NAME], their limits and goal."""

from __future__ import annotations

import cmath
from typing import Any, ClassVar, Literal

from pydantic import Field, field_validator, model_validator

from vibopt.balancing.planes import UNBALANCE
from vibopt.balancing.rotor_tables import Bounded, PlaneTable, inner
from vibopt.values import Fact, Table, number
from vibopt.values.fields import word

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
        places = {name: inner(at, "length") for name, at in given.items()}
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
    def phasor(self) -> complex:
        """Unbalance at its angle; material that was removed counts backwards [kg m]."""
        full = self.unbalance.value if self.unbalance is not None else 1.0
        for part in (self.mass, self.radius):
            full *= part.value if part is not None else 1.0
        return cmath.rect(-full if self.removed else full, self.angle.value)


class KnownPlaneTable(PlaneTable):
    """[planes.NAME]: where a correction may be fitted, and what there is to fit.

    Keys
    ----
    at: Place along the shaft.
    radius: Where weights sit, one length or a list to choose from; without it a plane counts in unbalance alone:
        `radius = "50 mm"`.
    weight: The most that may be fitted, `weight = { from = "0 g", to = "60 g" }`; or weights that are fitted, "10 g
        @ 270 deg".
    """

    at: Fact | None = number("length", choice=False, sign="any")
    bare: ClassVar[str] = UNBALANCE


class KnownLimitTable(Bounded):
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
    unit: str = ""

    @model_validator(mode="after")
    def _bound(self) -> KnownLimitTable:
        if self.at_most is not None:
            inner(self.at_most, self.dimension)
        if self.response == "correction" and (self.of is None) != self.total:
            raise word('needs of = "PLANE" or total = true, one of the two.')
        return self

    @property
    def dimension(self) -> str:
        """Dimension of the response."""
        return _DIMENSION_OF[self.response]


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
