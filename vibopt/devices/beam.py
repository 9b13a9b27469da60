"""A beam, or a shaft in bending: its stiffness and stress where it carries, by formulas and by finite elements."""

import math
from itertools import pairwise
from typing import Annotated, Literal, cast

import numpy as np
from pydantic import BeforeValidator, model_validator

from vibopt.arrays import FloatArray
from vibopt.devices.spring import bore, check_bore
from vibopt.devices.symbols import Numbers, Symbols
from vibopt.errors import way_out
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
        numbers = {
            "cantilever": lambda: 3.0 / a**3,
            "simply_supported": lambda: 3.0 / (a * b) ** 2,
            "fixed": lambda: 3.0 / (a * b) ** 3,
            "fixed_pinned": lambda: 12.0 / (a**3 * b**2 * (3.0 + b)),
            "overhung": lambda: 3.0 / (a * b**2),
        }
        return (self._second_moment(path, symbols) * long**-3.0).times(self.modulus.value * numbers[self.kind]())

    def stress(self, path: str, symbols: Symbols) -> Monomial | None:
        """Greatest bending stress over deflection where it carries [Pa/m]; None of a section without a depth."""
        if self.second_moment is not None:
            return None
        depth = "height" if self.height is not None else "diameter"
        outermost = symbols.read(f"{path}.{depth}", cast(Value, getattr(self, depth))).times(0.5)
        a = self.ratio
        b = 1.0 - a
        moments = {
            "cantilever": a,
            "simply_supported": a * b,
            "fixed": max(a * b**2, a**2 * b),
            "fixed_pinned": max(0.5 * a * b * (1.0 + b), 0.5 * a**2 * b * (3.0 - a)),
            "overhung": -b,
        }
        arm = symbols.read(f"{path}.length", self.length).times(moments[self.kind])
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

    def built(self, path: str, numbers: Numbers) -> tuple[float, float]:
        """Stiffness [N/m] and greatest stress over deflection [Pa/m] from finite elements, for the machine as built.

        The stress is 0 of a section without a depth.
        """
        long, high = numbers(f"{path}.length", self.length), numbers(f"{path}.height", self.height)
        outer, inner = (
            numbers(f"{path}.diameter", self.diameter),
            numbers(f"{path}.inner_diameter", self.inner_diameter),
        )
        if self.inner_ratio is not None:
            inner = outer * self.inner_ratio.value
        areas = (
            numbers(f"{path}.second_moment", self.second_moment),
            math.pi * (outer**4 - inner**4) / 64.0,
            numbers(f"{path}.width", self.width) * high**3 / 12.0,
        )
        usual = long if self.kind == "cantilever" else 0.5 * long
        at = numbers(f"{path}.at", self.at, long * numbers(f"{path}.at_ratio", self.at_ratio, usual / long))
        force, moment = bent_by_one(self.kind, long, at)
        return self.modulus.value * sum(areas) * force, self.modulus.value * 0.5 * max(high, outer) * moment


_HELD = {
    "simply_supported": (0, 4),
    "cantilever": (0, 1),
    "fixed": (0, 1, 4, 5),
    "fixed_pinned": (0, 1, 4),
    "overhung": (0, 2),
}
"""Of deflection and slope at three places from left to right (0 to 5), those that the supports hold."""


def bent_by_one(kind: str, length: float, at: float) -> tuple[float, float]:
    """Force [N/m] and greatest bending moment [N m/m] per deflection where it carries, of unit bending stiffness.

    Parameters
    ----------
    kind
        As of a `Beam`.
    length, at
        Of the beam, and place of the load from its left end [m]; `at` = `length` is the free tip of a cantilever.
    """
    places = [0.0, *sorted((at, length))] if at != length else [0.0, length]
    spans = [_element(after - before) for before, after in pairwise(places)]
    stiff = np.zeros((2 * len(places), 2 * len(places)))
    for k, span in enumerate(spans):
        stiff[2 * k : 2 * k + 4, 2 * k : 2 * k + 4] += span
    free = [i for i in range(len(stiff)) if i not in _HELD[kind]]
    loaded, moved = 2 * places.index(at), np.zeros(len(stiff))
    moved[free] = np.linalg.solve(stiff[np.ix_(free, free)], [float(i == loaded) for i in free])
    moments = [abs((span @ moved[2 * k : 2 * k + 4])[end]) for k, span in enumerate(spans) for end in (1, 3)]
    return float(1.0 / moved[loaded]), float(max(moments) / moved[loaded])


def _element(length: float) -> FloatArray:
    """Stiffness of a beam element of unit bending stiffness: deflection and slope at both ends, (4, 4)."""
    a = length
    table = [[12.0, 6 * a, -12.0, 6 * a], [6 * a, 4 * a * a, -6 * a, 2 * a * a],
             [-12.0, -6 * a, 12.0, -6 * a], [6 * a, 2 * a * a, -6 * a, 4 * a * a]]  # fmt: skip
    return np.array(table) / a**3
