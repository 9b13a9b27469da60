"""Tables of an engine's file: [engine], [[cylinders]], [counterweights.NAME], [balance_shafts.NAME], limits, goal."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field, field_validator, model_validator

from vibopt.balancing.words import read_angle
from vibopt.errors import QuantityError
from vibopt.units import read_quantity
from vibopt.values import Choice, Fact, Table, number
from vibopt.values.fields import complaint, word

Response = Literal["primary_force", "primary_couple", "secondary_force", "secondary_couple", "force", "couple"]
HIGHEST_ORDER = 20


class EngineTable(Table):
    """[engine]: one slider-crank for all cylinders; a cylinder may have masses of its own."""

    stroke: Fact | None = number("length", choice=False)
    crank_radius: Fact | None = number("length", choice=False)
    rod: Fact = number("length", choice=False, required=True)
    speed: Fact = number("angular_rate", choice=False, required=True)
    reciprocating: Fact | None = number("mass", choice=False)
    rotating: Fact | None = number("mass", choice=False, sign="not negative")
    spacing: Fact | None = number("length", choice=False)
    reference: Fact | None = number("length", choice=False, sign="any")
    counterweight_share: Fact | Choice | None = number("ratio", sign="not negative")
    rotating_share: Fact | Choice | None = number("ratio", sign="not negative")
    kinematics: Literal["exact", "truncated"] = "exact"
    orders: int = 8
    cranks: list[Any] = Field(default_factory=list)
    firing_order: list[int] = Field(default_factory=list)
    strokes: Literal[2, 4] = 4
    even_firing: bool = False

    @field_validator("cranks")
    @classmethod
    def _angles(cls, given: list[Any]) -> list[float]:
        return [_angle(one) for one in given]

    @model_validator(mode="after")
    def _fits(self) -> EngineTable:
        if (self.stroke is None) == (self.crank_radius is None):
            raise word('needs stroke or crank_radius, one of the two. Write stroke = "86 mm".')
        if self.radius >= self.rod.value:
            raise word("has a rod that is not longer than the crank radius: such a crank cannot turn.")
        if not 2 <= self.orders <= HIGHEST_ORDER:
            raise word(f"has orders = {self.orders}. Write a number from 2 to {HIGHEST_ORDER}.")
        return self

    @property
    def radius(self) -> float:
        """Crank radius [m]."""
        if self.crank_radius is not None:
            return self.crank_radius.value
        return 0.5 * self.stroke.value if self.stroke is not None else 0.0


class CylinderTable(Table):
    """[[cylinders]]: crank angle in the sense of rotation, "choose", or from the firing order; bank and place."""

    crank: Any = None
    throw: str | None = None
    bank: Fact | None = number("angle", choice=False, sign="any")
    at: Fact | None = number("length", choice=False, sign="any")
    reciprocating: Fact | None = number("mass", choice=False)
    rotating: Fact | None = number("mass", choice=False, sign="not negative")

    @field_validator("crank")
    @classmethod
    def _crank(cls, given: Any) -> Any:
        return given if given is None or given == "choose" else _angle(given)


class CounterweightTable(Table):
    """[counterweights.NAME]: an unbalance on the crankshaft; without angle both size and angle are chosen."""

    at: Fact = number("length", choice=False, sign="any", required=True)
    unbalance: Fact | Choice = number("unbalance", required=True)
    angle: Fact | None = number("angle", choice=False, sign="any")

    @model_validator(mode="after")
    def _given(self) -> CounterweightTable:
        _check_angle(self.unbalance, self.angle)
        return self


class BalanceShaftTable(Table):
    """[balance_shafts.NAME]: turns `order` times as fast as the crank; without angle both size and angle are chosen.

    The angle is that of its weight when the first crank angle is zero, from the axis of bank zero in the sense in
    which the crankshaft turns.
    """

    order: Literal[1, 2]
    turns: Literal["with rotation", "against rotation"]
    at: Fact = number("length", choice=False, sign="any", required=True)
    unbalance: Fact | Choice = number("unbalance", required=True)
    angle: Fact | None = number("angle", choice=False, sign="any")

    @model_validator(mode="after")
    def _given(self) -> BalanceShaftTable:
        _check_angle(self.unbalance, self.angle)
        return self


class EngineLimitTable(Table):
    """[limits.NAME] or [measures.NAME]: greatest force or couple over a turn, of one order or of all together."""

    response: Response
    order: int | None = None
    when: Fact | None = number("angle", choice=False, sign="any")
    kinematics: Literal["exact", "truncated"] | None = None
    at_most: Any = None
    unit: str = ""

    @model_validator(mode="after")
    def _bound(self) -> EngineLimitTable:
        if self.order is not None and self.response not in ("force", "couple"):
            plain = "couple" if self.is_couple else "force"
            raise word(f'has an order, but {self.response} says its own. Write response = "{plain}".')
        if self.at_most is not None:
            if self.when is not None or self.kinematics is not None:
                raise word("has a bound, but when and kinematics are for [measures.NAME] only. Leave them out.")
            _quantity(self.at_most, self.dimension)
        return self

    @property
    def is_couple(self) -> bool:
        return self.response.endswith("couple")

    @property
    def of_order(self) -> int:
        """The order meant; 0: all orders together."""
        named = {"primary": 1, "secondary": 2}.get(self.response.partition("_")[0])
        return named or self.order or 0

    @property
    def dimension(self) -> str:
        return "moment" if self.is_couple else "force"

    @property
    def bound(self) -> float:
        """at_most in SI; inf for a measure."""
        return float("inf") if self.at_most is None else _quantity(self.at_most, self.dimension)


class EngineGoalTable(Table):
    """[goal] minimise = a response; `then` names responses that decide between equally good crank phasings."""

    minimise: Response
    order: int | None = None
    then: list[Response] = Field(default_factory=list)


def _angle(given: object) -> float:
    try:
        return read_angle(given)
    except QuantityError as error:
        raise complaint(f'holds "{given}", which {error.complaint}') from None


def _quantity(given: object, dimension: str) -> float:
    try:
        return read_quantity(given, dimension).value
    except QuantityError as error:
        raise complaint(f'holds "{given}", which {error.complaint}') from None


def _check_angle(unbalance: Fact | Choice, angle: Fact | None) -> None:
    """A given size needs its angle, a range must have none."""
    if isinstance(unbalance, Fact) and angle is None:
        raise word('has a given unbalance but no angle. Add angle = "180 deg", or a range { from, to } to choose.')
    if isinstance(unbalance, Choice) and angle is not None:
        raise word("chooses its unbalance but has an angle. Leave angle out: it is chosen with the unbalance.")
