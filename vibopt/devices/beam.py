"""A beam, or a shaft in bending: its stiffness, mass and stress where it carries, by formulas and as built."""

import math
from typing import Annotated, Literal, cast

import numpy as np
from pydantic import BeforeValidator, model_validator

from vibopt.devices.beam_elements import bent
from vibopt.devices.beam_shape import Shape
from vibopt.devices.spring import bore, check_bore
from vibopt.devices.symbols import Numbers, Symbols
from vibopt.errors import way_out
from vibopt.mechanics.built import Borne
from vibopt.mechanics.monomial import Monomial
from vibopt.values import Fact, Table, Value, number, word
from vibopt.values.fields import Choice, complaint

_BEAMS = ("simply_supported", "cantilever", "fixed", "fixed_pinned", "overhung")


def _beam_kind(given: object) -> object:
    if given not in _BEAMS:
        raise complaint(f"is no kind of beam that vibopt knows.{way_out(str(given), _BEAMS)}")
    return given


class Beam(Table):
    """`beam = { kind, length, modulus, ... }`: a beam, or a shaft in bending, where it carries.

    kind
        How it is held: simply_supported, cantilever (fixed at the left end), fixed (at both), fixed_pinned, overhung
        (on two supports and loaded beyond the right one).
    at
        Place of the load from the left end; without it the middle, or the tip of a cantilever.
    second_moment
        Of area [m^4]; or width and height of a rectangle (height along the load), or the diameter of a rod.

    Keys
    ----
    kind: "simply_supported", "cantilever", "fixed", "fixed_pinned", or "overhung": two supports, loaded beyond the
        second.
    length: From support to support, or of a cantilever; it may be chosen: `length = { from = "0.6 m", to = "1 m" }`.
    modulus: Modulus of elasticity: `modulus = "207 GPa"`.
    at: Place of the load from the (left, or fixed) end; the middle, or the tip of a cantilever, without it; beyond the
        length where overhung. Not beside a length that is to be chosen.
    at_ratio: The same over the length: `at_ratio = 0.4`. One of `at` and `at_ratio`.
    second_moment: Second moment of area: `second_moment = "80 cm4"`. Instead: `diameter`, or `width` and `height`.
    width: Of a rectangle.
    height: Of a rectangle, in the direction of the load.
    diameter: Of a round beam or shaft; it may be chosen: `diameter = { from = "20 mm", to = "60 mm" }`.
    inner_diameter: Of a hollow shaft. Not beside `inner_ratio`, nor a diameter that is to be chosen.
    inner_ratio: Inner over outer diameter: `inner_ratio = 0.6`.
    density: Of its material, where its own mass counts: `density = "7850 kg/m3"`. Not beside a second_moment.
    mass: Of the whole beam, instead: `mass = "12 kg"`.
    """

    kind: Annotated[
        Literal["simply_supported", "cantilever", "fixed", "fixed_pinned", "overhung"], BeforeValidator(_beam_kind)
    ]
    length: Value = number("length", required=True)
    modulus: Fact = number("modulus", choice=False, required=True)
    at: Fact | None = number("length", choice=False)
    at_ratio: Fact | None = number("ratio", choice=False, most=1e3)
    second_moment: Fact | None = number("second_moment", choice=False)
    width: Value | None = number("length")
    height: Value | None = number("length")
    diameter: Value | None = number("length")
    inner_diameter: Fact | None = number("length", choice=False)
    inner_ratio: Fact | None = number("ratio", choice=False)
    density: Fact | None = number("density", choice=False)
    mass: Value | None = number("mass")

    @model_validator(mode="after")
    def _one_section(self) -> "Beam":
        said = [one for one in ("second_moment", "diameter", "width") if getattr(self, one) is not None]
        if len(said) > 1:
            raise word(f"gives {' and '.join(said)}. Keep one: each says its section.")
        if (self.width is None) != (self.height is None) or not said:
            raise word('needs one of second_moment, diameter, or width and height. Write diameter = "50 mm".')
        check_bore(self, "bend")
        inner = next((one for one in ("inner_diameter", "inner_ratio") if getattr(self, one) is not None), "")
        if inner and self.diameter is None:
            raise word(f"has an {inner}, but no diameter to which it belongs. Write the diameter.")
        if self.density is not None and self.mass is not None:
            raise word("gives density and mass. Keep one: each says how heavy it is.")
        if self.density is not None and self.second_moment is not None:
            raise word(
                'has a density, but says of its section the second moment alone, which is no area. Write mass = "12 '
                'kg", or its diameter.'
            )
        return self

    @model_validator(mode="after")
    def _carries(self) -> "Beam":
        if self.at is not None and self.at_ratio is not None:
            raise word("gives at and at_ratio. Keep one.")
        if self.at is not None and isinstance(self.length, Choice):
            raise word(
                "says its place (at) in numbers while its length is to be chosen. Write at_ratio = 0.4 (the place over "
                "the length) instead."
            )
        if self.kind == "overhung":
            if self.at is None and self.at_ratio is None:
                raise word('is overhung, but nothing says how far out it carries. Write at = "1.2 m", from the first '
                           "support on.")  # fmt: skip
            if self.ratio <= 1.0:
                raise word(
                    "is overhung, but carries (at) between its supports. Write a place beyond the second support, or "
                    'kind = "simply_supported".'
                )
        elif not (self.ratio < 1.0 or (self.kind == "cantilever" and self.ratio == 1.0)):
            raise word("has its load (at) on or beyond the far support. Write a place along its length.")
        return self

    @property
    def ratio(self) -> float:
        """Place of the load over the length."""
        if self.at_ratio is not None:
            return self.at_ratio.value
        if self.at is not None:
            return self.at.value / cast(Fact, self.length).value
        return 1.0 if self.kind == "cantilever" else 0.5

    def spring(self, path: str, symbols: Symbols) -> Monomial:
        """Force over deflection where it carries [N/m]; `path` is where the table stands in the file."""
        long = symbols.read(f"{path}.length", self.length)
        a = self.ratio
        b = 1.0 - a
        over_bending = {
            "cantilever": lambda: 3.0 / a**3,
            "simply_supported": lambda: 3.0 / (a * b) ** 2,
            "fixed": lambda: 3.0 / (a * b) ** 3,
            "fixed_pinned": lambda: 12.0 / (a**3 * b**2 * (3.0 + b)),
            "overhung": lambda: 3.0 / (a * b**2),
        }
        return (self._second_moment(path, symbols) * long**-3.0).times(self.modulus.value * over_bending[self.kind]())

    def stress(self, path: str, symbols: Symbols) -> Monomial | None:
        """Greatest bending stress over deflection where it carries [Pa/m]; None of a section without a depth."""
        if self.second_moment is not None:
            return None
        depth = "height" if self.height is not None else "diameter"
        outermost = symbols.read(f"{path}.{depth}", cast(Value, getattr(self, depth))).times(0.5)
        arm = symbols.read(f"{path}.length", self.length).times(float(self.shape.moment(np.array(self.ratio))))
        return self.spring(path, symbols) * arm * outermost * self._second_moment(path, symbols) ** -1.0

    def _second_moment(self, path: str, symbols: Symbols) -> Monomial:
        """Of area [m^4]."""
        if self.second_moment is not None:
            return Monomial(self.second_moment.value)
        if self.diameter is not None:
            solid = symbols.read(f"{path}.diameter", self.diameter) ** 4.0
            return solid.times(math.pi * (1.0 - bore(self) ** 4) / 64.0)
        wide = symbols.read(f"{path}.width", cast(Value, self.width))
        high = symbols.read(f"{path}.height", cast(Value, self.height))
        return (wide * high**3.0).times(1.0 / 12.0)

    @property
    def heavy(self) -> bool:
        """Whether its own mass counts."""
        return self.density is not None or self.mass is not None

    def weight(self, path: str, symbols: Symbols) -> Monomial:
        """Its own mass [kg], of one that is `heavy`."""
        if self.mass is not None:
            return symbols.read(f"{path}.mass", self.mass)
        long = symbols.read(f"{path}.length", self.length)
        return (self._area(path, symbols) * long).times(cast(Fact, self.density).value * self.shape.end)

    @property
    def shape(self) -> Shape:
        """Under a force where it carries."""
        return Shape(self.kind, self.ratio)

    def _area(self, path: str, symbols: Symbols) -> Monomial:
        """Of its section [m^2]."""
        if self.diameter is not None:
            solid = symbols.read(f"{path}.diameter", self.diameter) ** 2.0
            return solid.times(math.pi * (1.0 - bore(self) ** 2) / 4.0)
        wide = symbols.read(f"{path}.width", cast(Value, self.width))
        return wide * symbols.read(f"{path}.height", cast(Value, self.height))

    def built(self, path: str, numbers: Numbers) -> "Borne":
        """All of it from finite elements, for the machine as built."""
        long, high = numbers(f"{path}.length", self.length), numbers(f"{path}.height", self.height)
        outer, inner = (
            numbers(f"{path}.diameter", self.diameter),
            numbers(f"{path}.inner_diameter", self.inner_diameter),
        )
        if self.inner_ratio is not None:
            inner = outer * self.inner_ratio.value
        wide = numbers(f"{path}.width", self.width)
        second = numbers(f"{path}.second_moment", self.second_moment)
        second += math.pi * (outer**4 - inner**4) / 64.0 + wide * high**3 / 12.0  # one of them at most
        usual = long if self.kind == "cantilever" else 0.5 * long
        at = numbers(f"{path}.at", self.at, long * numbers(f"{path}.at_ratio", self.at_ratio, usual / long))
        area = math.pi * (outer**2 - inner**2) / 4.0 + wide * high
        mass = numbers(f"{path}.mass", self.mass) + numbers(f"{path}.density", self.density) * area * max(long, at)
        of = bent(self.kind, at / long)
        stiffness, depth = self.modulus.value * second / long**3, 0.5 * max(high, outer)
        each = mass / max(1.0, at / long)
        moment = [
            value * long * depth / second for value in (stiffness * of.moment[0], *(each * m for m in of.moment[1:]))
        ]
        right = [of.right[0] / of.force, each * of.right[1], each * of.right[2]]
        whole = [1.0, mass * (1.0 - of.means[0]), mass * (of.means[0] - of.means[1])]
        return Borne(
            stiffness=stiffness * of.force,
            mass=mass,
            means=of.means,
            frequency=of.frequency * math.sqrt(stiffness / each) if mass else math.inf,
            stress=cast("tuple[float, float, float]", tuple(moment)),
            left=cast("tuple[float, float, float]", tuple(a - b for a, b in zip(whole, right, strict=True))),
            right=cast("tuple[float, float, float]", tuple(right)),
        )
