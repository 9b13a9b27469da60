"""Numbers of a mount along its own three axes, and what it is rated for."""

from typing import Annotated, Any

from vibopt.errors import QuantityError
from vibopt.records import dataclass
from vibopt.units import Quantity, read_range
from vibopt.values import Table, Value, number
from vibopt.values.directions import AXES
from vibopt.values.fields import ReadBy, Rule, RuleSchema, complaint, read_value, wrong_part


class StiffnessAxes(Table):
    """Stiffness along the mount's own x, y and z."""

    x: Value = number("stiffness", required=True)
    y: Value = number("stiffness", required=True)
    z: Value = number("stiffness", required=True)


class DampingAxes(Table):
    """Viscous damping along the mount's own x, y and z."""

    x: Value = number("damping", sign="not negative", required=True)
    y: Value = number("damping", sign="not negative", required=True)
    z: Value = number("damping", sign="not negative", required=True)


class ThreeSchema(RuleSchema):
    """Schema of a number or of a list of three."""

    def __call__(self, schema: dict[str, Any]) -> None:
        super().__call__(schema)
        one = dict(schema)
        schema.clear()
        schema.update({"anyOf": [one, {"type": "array", "items": one, "minItems": 3, "maxItems": 3}]})


def three(kind: type[Table], dimension: str, sign: str, given: object) -> object:
    """A list of three values as its table; anything else is left for the field to read."""
    if not isinstance(given, list):
        return given
    if len(given) != 3:
        raise complaint(f"is a list of {len(given)}. Write one value, or three: along the mount's own x, y and z.")
    rule, read = Rule(dimension, sign=sign), {}
    for axis, one in zip(AXES, given, strict=True):
        try:
            read[axis] = read_value(rule, one)
        except QuantityError as error:
            raise wrong_part(axis, one, error) from None
    return kind(**read)


@dataclass(frozen=True, slots=True)
class Rating:
    """Least and greatest static load of one mount."""

    least: Quantity
    most: Quantity

    @property
    def rated(self) -> tuple[float, float]:
        """Both ends [N]."""
        return self.least.value, self.most.value


def _rating(given: object) -> object:
    if isinstance(given, Rating):
        return given
    example = 'Write "500..3500 N".'
    if not isinstance(given, str) or ".." not in given:
        raise complaint(f"is no range of loads. {example}")
    try:
        least, most = read_range(given, "force")
    except QuantityError as error:
        raise complaint(str(error)) from None
    if least.value < 0.0:
        raise complaint(f"is negative: a mount is rated for loads that press on it. {example}")
    return Rating(least, most)


Rated = Annotated[Any, ReadBy(_rating, {"type": "string", "description": "500..3500 N"})]
