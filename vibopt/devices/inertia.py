"""Mass properties of a body in space: its tensor, simple shapes, and sums of pieces."""

from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, WithJsonSchema, model_validator

from vibopt.arrays import FloatArray
from vibopt.errors import QuantityError, way_out
from vibopt.records import dataclass
from vibopt.units import read_quantity
from vibopt.values import Fact, Table, number, word
from vibopt.values.directions import AXES, SIX, Direction, Place, axis_words
from vibopt.values.fields import complaint, wrong_part

_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True)
class Solid:
    """Mass [kg], centre of mass (3,) [m], inertia tensor about it (3, 3) [kg m^2]."""

    mass: float
    centre: FloatArray
    tensor: FloatArray


class Rolling(Table):
    """`rolling = { inertia, radius }`: the body rolls as it moves, and J / r^2 adds to its mass.

    Keys
    ----
    inertia: Moment of inertia about the axis it rolls about.
    radius: Radius at which it rolls.
    """

    inertia: Fact = number("inertia", choice=False, required=True)
    radius: Fact = number("length", choice=False, required=True)

    @property
    def added(self) -> float:
        """What rolling adds to the mass [kg]."""
        return self.inertia.value / self.radius.value**2


class Principal(Table):
    """Moments of inertia about x, y, z through the centre of mass, which are its principal axes."""

    x: Fact = number("inertia", choice=False, sign="not negative", required=True)
    y: Fact = number("inertia", choice=False, sign="not negative", required=True)
    z: Fact = number("inertia", choice=False, sign="not negative", required=True)

    @property
    def tensor(self) -> FloatArray:
        """Shape (3, 3) [kg m^2]."""
        return np.diag([self.x.value, self.y.value, self.z.value])


class Tensor(Table):
    """Moments and products of inertia through the centre of mass; a product is that of xy = integral of x y dm."""

    xx: Fact = number("inertia", choice=False, sign="not negative", required=True)
    yy: Fact = number("inertia", choice=False, sign="not negative", required=True)
    zz: Fact = number("inertia", choice=False, sign="not negative", required=True)
    xy: Fact | None = number("inertia", choice=False, sign="any")
    yz: Fact | None = number("inertia", choice=False, sign="any")
    zx: Fact | None = number("inertia", choice=False, sign="any")

    @property
    def tensor(self) -> FloatArray:
        """Shape (3, 3) [kg m^2]; products with a minus sign, as the tensor has them."""
        xy, yz, zx = (0.0 if fact is None else fact.value for fact in (self.xy, self.yz, self.zx))
        return np.array([[self.xx.value, -xy, -zx], [-xy, self.yy.value, -yz], [-zx, -yz, self.zz.value]], dtype=float)


class Cylinder(Table):
    """`cylinder = { diameter, length, axis = "x" }`, solid.

    Keys
    ----
    diameter: Its diameter.
    length: Its length along the axis.
    axis: "x", "y" or "z": `axis = "x"`.
    """

    diameter: Fact = number("length", choice=False, required=True)
    length: Fact = number("length", choice=False, required=True)
    axis: Direction


def _sides(given: object) -> object:
    if isinstance(given, tuple):
        return given
    if not isinstance(given, list) or len(given) != 3:
        raise complaint('is no box. Write its three sides: box = ["2 m", "0.9 m", "1.1 m"].')
    try:
        sides = tuple(read_quantity(one, "length").value for one in given)
    except QuantityError as error:
        raise complaint(f"has a side that cannot be read: it {error}") from None
    if min(sides) <= 0.0:
        raise complaint('has a side that is not greater than zero. Write three lengths, ["2 m", "0.9 m", "1.1 m"].')
    return sides


Sides = Annotated[
    tuple[float, float, float],
    BeforeValidator(_sides),
    WithJsonSchema({"type": "array", "minItems": 3, "maxItems": 3, "description": "sides along x, y, z"}),
]


class Shape(Table):
    """`shape = { box = [a, b, c] }` or `{ cylinder = { ... } }`: of even density, about its own centre.

    Keys
    ----
    box: Edges along x, y, z: `box = ["2.2 m", "1.4 m", "0.5 m"]`. Not beside `cylinder`.
    cylinder: A cylinder: `cylinder = { diameter = "0.4 m", length = "1 m", axis = "x" }`.
    """

    box: Sides | None = None
    cylinder: Cylinder | None = None

    @model_validator(mode="after")
    def _one(self) -> "Shape":
        if (self.box is None) == (self.cylinder is None):
            raise word('needs either a box or a cylinder. Write shape = { box = ["2 m", "0.9 m", "1.1 m"] }.')
        return self

    @property
    def per_mass(self) -> FloatArray:
        """Inertia tensor over the mass, shape (3, 3) [m^2]."""
        if self.box is not None:
            squares = np.array(self.box) ** 2
            return np.diag(squares.sum() - squares) / 12.0
        assert self.cylinder is not None
        square, long = 0.25 * self.cylinder.diameter.value**2, self.cylinder.length.value**2
        along = np.outer(self.cylinder.axis, self.cylinder.axis)
        value: FloatArray = 0.5 * square * along + (square / 4.0 + long / 12.0) * (np.eye(3) - along)
        return value


def read_inertia(given: object) -> object:
    """Three moments or a table of a tensor; anything else is left for the field to read."""
    if isinstance(given, list):
        if len(given) != 3:
            raise complaint(
                'is no list of three moments of inertia. Write those about x, y, z: ["310 kg m2", "620 kg m2", '
                '"590 kg m2"].'
            )
        made: Principal | Tensor = Principal(
            **dict(zip(AXES, _facts(dict(zip(AXES, given, strict=True))), strict=True))
        )
    elif isinstance(given, Mapping) and set(given) & set(SIX):
        for key in given:
            if key not in SIX:
                raise complaint(f'has the unknown key "{key}".{way_out(str(key), SIX)}')
        missing = [key for key in SIX[:3] if key not in given]
        if missing:
            raise complaint(f"has no {missing[0]}. Write xx, yy and zz; products xy, yz, zx are zero where left out.")
        made = Tensor(**dict(zip(given, _facts(given), strict=True)))
    else:
        _refuse_other_names(given)
        return given
    fault = tensor_fault(made.tensor)
    if fault:
        raise complaint(fault)
    return made


def _refuse_other_names(given: object) -> None:
    """Moments about x, y, z called as elsewhere: x, Ixx, J_z."""
    meant = (
        {str(key).lower().lstrip("ij").lstrip("_"): one for key, one in given.items()}
        if isinstance(given, Mapping)
        else {}
    )
    principal = [meant.get(2 * axis, meant.get(axis)) for axis in AXES]
    if all(one is None for one in principal):
        return
    listed = (
        ", ".join(f'"{one}"' for one in principal) if None not in principal else '"310 kg m2", "620 kg m2", "590 kg m2"'
    )
    raise complaint(
        f"is no choice, nor a tensor by its components. Write the moments about x, y, z, [{listed}], or "
        '{ xx = "...", yy = "...", zz = "..." } with products xy, yz, zx.'
    )


def _facts(given: Mapping[str, object]) -> list[Fact]:
    found = []
    for key, one in given.items():
        try:
            quantity = read_quantity(one, "inertia")
        except QuantityError as error:
            raise wrong_part(key, one, error) from None
        if quantity.value < 0.0 and key in (*AXES, *SIX[:3]):
            raise complaint(f"has a negative moment of inertia about {key[0]}. Write a positive value.")
        found.append(Fact(quantity.value, quantity.unit, quantity.echo))
    return found


def tensor_fault(tensor: FloatArray) -> str:
    """Why no body has this inertia tensor (3, 3); "" where one may."""
    values, axes = np.linalg.eigh(tensor)
    size = float(np.abs(values).max())
    if values[0] < -_ROUNDING * size:
        return (
            f"is no inertia of a body: about the axis {axis_words(axes[:, 0])} it would be {values[0]:.4g} kg m². "
            "Check the products of inertia and their signs: xy is the integral of x y dm."
        )
    if values[0] <= _ROUNDING * size:
        return (
            f"is zero about the axis {axis_words(axes[:, 0])}, but a body in space turns there as well. Write its real "
            'inertia, or motion = "plane".'
        )
    if values[2] > (values[0] + values[1]) * (1.0 + _ROUNDING):
        return (
            f"is no inertia of a body: the greatest principal moment, {values[2]:.4g} kg m² about the axis "
            f"{axis_words(axes[:, 2])}, is more than the other two together, {values[0]:.4g} and {values[1]:.4g} kg "
            "m². Check the three values and their units."
        )
    return ""


class Piece(Table):
    """One entry of `made_of`: mass, centre, and inertia or shape; without either a point.

    Keys
    ----
    mass: Mass of the piece.
    centre: Its centre of mass: `centre = ["0 m", "0 m", "0.1 m"]`.
    inertia: About its own centre, as that of a body: `inertia = ["3 kg m2", "6 kg m2", "5 kg m2"]`. Not beside
        `shape`.
    shape: A box or a cylinder: `shape = { box = ["1 m", "1 m", "0.2 m"] }`.
    """

    mass: Fact = number("mass", choice=False, required=True)
    centre: Place
    inertia: Any = None
    shape: Shape | None = None

    @model_validator(mode="before")
    @classmethod
    def _tensor(cls, given: Any) -> Any:
        if not isinstance(given, dict) or given.get("inertia") is None:
            return given
        made = read_inertia(given["inertia"])
        if not isinstance(made, (Principal, Tensor)):
            raise word('has an inertia about one axis only. Write three: inertia = ["3 kg m2", "6 kg m2", "5 kg m2"].')
        return {**given, "inertia": made}

    @model_validator(mode="after")
    def _one(self) -> "Piece":
        if self.inertia is not None and self.shape is not None:
            raise word("gives inertia and shape. Keep one.")
        return self

    @property
    def solid(self) -> Solid:
        """The piece as mass, centre and tensor."""
        tensor = np.zeros((3, 3))
        if self.inertia is not None:
            tensor = self.inertia.tensor
        if self.shape is not None:
            tensor = self.mass.value * self.shape.per_mass
        return Solid(self.mass.value, np.array(self.centre), tensor)


def together(pieces: tuple[Piece, ...]) -> Solid:
    """The sum of pieces: mass, common centre, tensor about it."""
    solids = [piece.solid for piece in pieces]
    mass = sum(solid.mass for solid in solids)
    centre = sum((solid.mass * solid.centre for solid in solids), np.zeros(3)) / mass
    tensor = np.zeros((3, 3))
    for solid in solids:
        arm = solid.centre - centre
        tensor = tensor + solid.tensor + solid.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return Solid(mass, centre, tensor)


class Disc(Table):
    """`disc = { mass, diameter }`: J = m d^2 / 8 [kg m^2].

    Keys
    ----
    mass: Its mass.
    diameter: Its diameter; the inertia is m d²/8.
    """

    mass: Fact = number("mass", choice=False, required=True)
    diameter: Fact = number("length", choice=False, required=True)

    @property
    def inertia(self) -> Fact:
        """About the axis of the disc [kg m^2]."""
        return Fact(self.mass.value * self.diameter.value**2 / 8.0, "kg m²")

    @property
    def built(self) -> float:
        """The same from half the mass times the square of the radius, for the machine as built [kg m^2]."""
        return 0.5 * self.mass.value * (0.5 * self.diameter.value) ** 2
