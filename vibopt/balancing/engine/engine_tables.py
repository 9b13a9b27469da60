"""Tables of an engine's file: [engine], [[cylinders]], [counterweights.NAME], [balance_shafts.NAME], limits, goal."""

from __future__ import annotations

from math import inf
from typing import Any, Literal

from pydantic import Field, field_validator, model_validator

from vibopt.balancing.conventions import read_angle
from vibopt.balancing.rotor_tables import Bounded, MadeSmall, inner
from vibopt.values import Choice, Fact, Table, number
from vibopt.values.fields import complaint, word

Response = Literal["primary_force", "primary_couple", "secondary_force", "secondary_couple", "force", "couple"]
HIGHEST_ORDER = 20


_LONGEST_CRANK = 0.9999
"""Part of the rod; the series of its orders have some 21 / (1 - ratio) terms."""


def _known_order(order: int | None, key: str, response: str) -> None:
    """Refuse an order that no series goes up to, or beside the response under `key` that says its own."""
    if order is not None and response not in ("force", "couple"):
        plain = "couple" if response.endswith("couple") else "force"
        raise word(f'has an order, but {response} says its own. Write {key} = "{plain}".')
    if order is not None and not 1 <= order <= HIGHEST_ORDER:
        raise word(f"has order = {order}. Write a number from 1 to {HIGHEST_ORDER}.")


def _as_said(given: Fact | Choice | None) -> Fact | Choice | None:
    """A number that is chosen from a range, or is what it says: what would be ignored is refused."""
    if given is not None and given.tolerance:
        raise complaint(
            "has a tolerance, but what balances an engine is taken as it is said. Write it without; vibopt sweep FILE "
            '--keep-design --vary PATH="-3 %..+3 %" shows what being off does.'
        )
    if isinstance(given, Choice) and given.options:
        raise complaint(
            "is a list, but what balances an engine is chosen from a range. Write { from = ..., to = ... }; vibopt "
            'sweep FILE --vary PATH="ONE, OTHER" answers each value.'
        )
    return given


class EngineTable(Table):
    """[engine]: one slider-crank for all cylinders; a cylinder may have masses of its own.

    Keys
    ----
    stroke: Of the pistons; or `crank_radius`, half of it: `stroke = "86 mm"`.
    crank_radius: Instead of `stroke`.
    rod: Length of the connecting rod: `rod = "145 mm"`. Longer than the crank.
    speed: Of the crankshaft: `speed = "6000 rpm"`.
    reciprocating: Mass of each cylinder that goes to and fro: `reciprocating = "0.5 kg"`.
    rotating: Mass of each cylinder that goes round at the crank radius: `rotating = "0.4 kg"`.
    spacing: From cylinder to cylinder, the first at 0 mm; or `at` in each: `spacing = "90 mm"`.
    reference: Place about which couples are taken; the middle of the cylinders without it: `reference = "135 mm"`.
    counterweight_share: Part of the reciprocating mass that stands opposite each crank: `counterweight_share = {
        from = 0, to = 1 }`. 0 without it.
    rotating_share: Part of the rotating mass that the counterweights carry: `rotating_share = "100 %"`.
    kinematics: "exact": all orders up to `orders`; "truncated": the first two.
    orders: How many orders are shown; more where a limit, a measure or the goal asks for a higher one.
    cranks: Angles to be shared out among the throws that choose, each taken once: `cranks = ["0 deg", "90 deg",
        "180 deg", "270 deg"]`.
    firing_order: Gives the cranks that are not written, at equal distances from the first that is, and must be how
        those fire that are: `firing_order = [1, 3, 4, 2]`.
    strokes: Of the working cycle.
    even_firing: Only settings that fire at equal distances: `even_firing = true`.
    """

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
        return [inner(one, "angle", read_angle) for one in given]

    @field_validator("counterweight_share", "rotating_share")
    @classmethod
    def _shares(cls, given: Fact | Choice | None) -> Fact | Choice | None:
        if isinstance(given, Choice) and given.high == inf:
            raise complaint("has no upper end. Write { from = 0, to = 1 }.")
        return _as_said(given)

    @model_validator(mode="after")
    def _fits(self) -> EngineTable:
        if (self.stroke is None) == (self.crank_radius is None):
            raise word('needs stroke or crank_radius, one of the two. Write stroke = "86 mm".')
        if self.radius >= self.rod.value:
            raise word(
                "has a rod that is not longer than the crank radius: such a crank cannot turn. Write a longer rod."
            )
        if self.radius > _LONGEST_CRANK * self.rod.value:
            raise word(
                "has a rod that is longer than the crank radius by less than 0.01 %: its piston is thrown about "
                "without end at half a stroke. Write a longer rod."
            )
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
    """[[cylinders]]: crank angle in the sense of rotation, "choose", or from the firing order; bank and place.

    Keys
    ----
    crank: Angle of its throw in the sense of rotation, or "choose": `crank = "180 deg"`.
    throw: Name of a throw that it shares with another cylinder: `throw = "p1"`.
    bank: Angle of its axis, for a V: `bank = "-45 deg"`.
    at: Place along the crankshaft; from `spacing` without it.
    reciprocating: Of its own, where it differs.
    rotating: Of its own, where it differs.
    """

    crank: Any = None
    throw: str | None = None
    bank: Fact | None = number("angle", choice=False, sign="any")
    at: Fact | None = number("length", choice=False, sign="any")
    reciprocating: Fact | None = number("mass", choice=False)
    rotating: Fact | None = number("mass", choice=False, sign="not negative")

    @field_validator("crank")
    @classmethod
    def _crank(cls, given: Any) -> Any:
        return given if given is None or given == "choose" else inner(given, "angle", read_angle)


class CounterweightTable(Table):
    """[counterweights.NAME]: an unbalance on the crankshaft; without angle both size and angle are chosen.

    Keys
    ----
    at: Place along the crankshaft: `at = "-40 mm"`.
    unbalance: Mass times radius; chosen with its angle, `unbalance = { from = "0 g mm", to = "5 kg mm" }`, or a
        fact.
    angle: Of the weight; a fact needs one, a choice has none: `angle = "180 deg"`.
    """

    at: Fact = number("length", choice=False, sign="any", required=True)
    unbalance: Fact | Choice = number("unbalance", required=True, sign="not negative")
    angle: Fact | None = number("angle", choice=False, sign="any")

    @field_validator("unbalance")
    @classmethod
    def _size(cls, given: Fact | Choice) -> Fact | Choice | None:
        if isinstance(given, Choice) and given.low > 0.0 and not given.options:
            raise complaint("does not start at zero. No weight at all is always possible: write from zero.")
        return _as_said(given)

    @model_validator(mode="after")
    def _given(self) -> CounterweightTable:
        """A given size needs its angle, a range must have none."""
        if isinstance(self.unbalance, Fact) and self.angle is None:
            raise word('has a given unbalance but no angle. Add angle = "180 deg", or a range { from, to } to choose.')
        if isinstance(self.unbalance, Choice) and self.angle is not None:
            raise word("chooses its unbalance but has an angle. Leave angle out: it is chosen with the unbalance.")
        return self

    @property
    def turning(self) -> tuple[int, int]:
        """Its speed over that of the crank, and +1 with the rotation or -1 against it."""
        return 1, 1


class BalanceShaftTable(CounterweightTable):
    """[balance_shafts.NAME]: turns `order` times as fast as the crank; without angle both size and angle are chosen.

    The angle is that of its weight when the cranks stand at the angles of the file, from the axis of bank zero in the
    sense in which the crankshaft turns.

    Keys
    ----
    order: Times crank speed.
    turns: Its sense: `turns = "against rotation"`.
    at: Place along the crankshaft: `at = "135 mm"`.
    unbalance: Mass times radius; chosen with its angle, `unbalance = { from = "0 g mm", to = "50 kg mm" }`, or a
        fact.
    angle: Of the weight when the cranks stand at the angles of the file; a fact needs one, a choice has none:
        `angle = "180 deg"`.
    """

    order: Literal[1, 2]
    turns: Literal["with rotation", "against rotation"]

    @property
    def turning(self) -> tuple[int, int]:
        return self.order, 1 if self.turns == "with rotation" else -1


class EngineLimitTable(Bounded):
    """[limits.NAME] or [measures.NAME]: greatest force or couple over a turn, of one order or of all together.

    Keys
    ----
    response: What is limited or measured.
    order: Of the force or couple, up to 20; all together without it: `order = 2`. Refused of primary and secondary
        ones, which say their own.
    when: At this crank angle, of a measure: `when = "30 deg"`. Refused in a limit.
    kinematics: Exact or truncated, of a measure. Refused in a limit.
    at_most: The greatest over a turn: `at_most = "600 N"`.
    soft: Of a limit, how easily it may be loosened where not all can hold: with `soft = 2` a loosening by 20 % counts
        as one by 10 %. An answer keeps every limit, soft or not. Refused in a measure.
    unit: How the value is shown: `unit = "kN"`.
    """

    response: Response
    order: int | None = None
    when: Fact | None = number("angle", choice=False, sign="any")
    kinematics: Literal["exact", "truncated"] | None = None

    @model_validator(mode="after")
    def _bound(self) -> EngineLimitTable:
        _known_order(self.order, "response", self.response)
        if self.at_most is not None:
            if self.when is not None or self.kinematics is not None:
                raise word("has a bound, but when and kinematics are for [measures.NAME] only. Leave them out.")
            inner(self.at_most, self.dimension)
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


class EngineGoalTable(MadeSmall):
    """[goal] minimise = a response; `then` names responses that decide between equally good crank phasings.

    Keys
    ----
    minimise: What is made small.
    order: Of the force or couple: `order = 2`.
    then: Decides between settings of the cranks that are equally good: `then = ["secondary_couple"]`.
    """

    minimise: Response
    order: int | None = None
    then: list[Response] = Field(default_factory=list)

    @model_validator(mode="after")
    def _knows(self) -> EngineGoalTable:
        _known_order(self.order, "minimise", self.minimise)
        return self
