"""Springs of standard shape, a shaft in torsion and a beam under a load, by their formulas and by finite elements."""

import math
from typing import Annotated, Literal

import numpy as np
from pydantic import BeforeValidator, model_validator

from vibopt.arrays import FloatArray
from vibopt.devices.symbols import Numbers, Symbols
from vibopt.errors import way_out
from vibopt.mechanics.monomial import Monomial
from vibopt.values import Fact, Table, Value, number, word
from vibopt.values.fields import Choice, complaint


class Shaft(Table):
    """`shaft = { length, diameter, shear_modulus }`: k = pi G d^4 (1 - r^4) / (32 L) [N m/rad].

    r is the inner over the outer diameter of a hollow shaft.

    Keys
    ----
    length: Its length.
    diameter: Outer diameter.
    shear_modulus: Of the material: `shear_modulus = "80 GPa"`.
    inner_diameter: Of a hollow shaft. Not beside `inner_ratio`.
    inner_ratio: Inner over outer diameter: `inner_ratio = 0.6`.
    """

    length: Value = number("length", required=True)
    diameter: Value = number("length", required=True)
    shear_modulus: Fact = number("modulus", choice=False, required=True)
    inner_diameter: Fact | None = number("length", choice=False)
    inner_ratio: Fact | None = number("ratio", choice=False)

    @model_validator(mode="after")
    def _hollow(self) -> "Shaft":
        if self.inner_diameter is not None and self.inner_ratio is not None:
            raise word("gives inner_diameter and inner_ratio. Keep one.")
        if self.inner_diameter is not None and isinstance(self.diameter, Choice):
            raise word(
                "has an inner_diameter while its diameter is to be chosen. Write inner_ratio = 0.5 (inner over outer "
                "diameter) instead."
            )
        if self.ratio >= 1.0:
            raise word("is as wide inside as outside: nothing is left to twist. Write a smaller inner diameter.")
        return self

    @property
    def ratio(self) -> float:
        """Inner over outer diameter; 0 for a solid shaft."""
        if self.inner_ratio is not None:
            return self.inner_ratio.value
        if self.inner_diameter is not None and isinstance(self.diameter, Fact):
            return self.inner_diameter.value / self.diameter.value
        return 0.0

    def spring(self, path: str, symbols: Symbols) -> Monomial:
        """Torsional stiffness [N m/rad]; `path` is where the table stands in the file."""
        long = symbols.read(f"{path}.length", self.length)
        wide = symbols.read(f"{path}.diameter", self.diameter)
        scale = math.pi * self.shear_modulus.value * (1.0 - self.ratio**4) / 32.0
        return (wide**4.0 * long**-1.0).times(scale)

    def built(self, path: str, numbers: Numbers) -> float:
        """The same from the polar moment of area of two radii, G J / L, for the machine as built [N m/rad]."""
        outer = 0.5 * numbers(f"{path}.diameter", self.diameter)
        inner = outer * self.inner_ratio.value if self.inner_ratio is not None else 0.0
        if self.inner_diameter is not None:
            inner = 0.5 * self.inner_diameter.value
        polar = 0.5 * math.pi * (outer**4 - inner**4)
        return self.shear_modulus.value * polar / numbers(f"{path}.length", self.length)


_BEAMS = ("simply_supported", "cantilever", "fixed", "fixed_pinned")


def _beam_kind(given: object) -> object:
    if given not in _BEAMS:
        raise complaint(f"is no kind of beam that vibopt knows.{way_out(str(given), _BEAMS)}")
    return given


class Beam(Table):
    """`beam = { kind, length, modulus, ... }`: the stiffness of a beam where the load stands [N/m].

    kind
        How it is held at the left and the right end: simply_supported, cantilever (fixed, free), fixed
        (both ends), fixed_pinned.
    at
        Place of the load from the left end; without it the middle, or the tip of a cantilever.
    second_moment
        Of area [m^4]; or width and height of a rectangle (height along the load), or the diameter of a rod.

    Keys
    ----
    kind: "simply_supported", "cantilever", "fixed" or "fixed_pinned".
    length: Its length.
    modulus: Modulus of elasticity: `modulus = "207 GPa"`.
    at: Place of the load from the (left, or fixed) end; the middle, or the tip of a cantilever, without it.
    second_moment: Second moment of area: `second_moment = "80 cm4"`. Instead: `diameter`, or `width` and `height`.
    width: Of a rectangle.
    height: Of a rectangle, in the direction of the load.
    diameter: Of a round beam.
    """

    kind: Annotated[Literal["simply_supported", "cantilever", "fixed", "fixed_pinned"], BeforeValidator(_beam_kind)]
    length: Fact = number("length", choice=False, required=True)
    modulus: Fact = number("modulus", choice=False, required=True)
    at: Fact | None = number("length", choice=False)
    second_moment: Fact | None = number("second_moment", choice=False)
    width: Fact | None = number("length", choice=False)
    height: Fact | None = number("length", choice=False)
    diameter: Fact | None = number("length", choice=False)

    @model_validator(mode="after")
    def _one_section(self) -> "Beam":
        section = (self.second_moment is not None, self.diameter is not None, self.width is not None)
        if (self.width is None) != (self.height is None) or sum(section) != 1:
            raise word('needs one of second_moment, diameter, or width and height. Write diameter = "50 mm".')
        end = self.length.value if self.kind == "cantilever" else math.nextafter(self.length.value, 0.0)
        if self.at is not None and not self.at.value <= end:
            raise word("has its load (at) on or beyond the far support. Write a place along its length.")
        return self

    @property
    def area_moment(self) -> float:
        """Second moment of area [m^4]."""
        if self.second_moment is not None:
            return self.second_moment.value
        if self.diameter is not None:
            return math.pi * self.diameter.value**4 / 64.0
        assert self.width is not None
        assert self.height is not None
        return self.width.value * self.height.value**3 / 12.0

    @property
    def stiffness(self) -> float:
        """Force over deflection where the load stands [N/m]."""
        long = self.length.value
        a = self.at.value if self.at is not None else long if self.kind == "cantilever" else 0.5 * long
        b = long - a
        bending = self.modulus.value * self.area_moment
        if self.kind == "cantilever":
            return 3.0 * bending / a**3
        if self.kind == "simply_supported":
            return 3.0 * bending * long / (a**2 * b**2)
        if self.kind == "fixed":
            return 3.0 * bending * long**3 / (a**3 * b**3)
        return 12.0 * bending * long**3 / (a**3 * b**2 * (3.0 * long + b))

    @property
    def built(self) -> float:
        """The same from finite elements, for the machine as built [N/m]."""
        long = self.length.value
        usual = long if self.kind == "cantilever" else 0.5 * long
        at = usual if self.at is None else self.at.value
        return 1.0 / sag_under_load(self.kind, long, at, self.modulus.value * self.area_moment)


_HELD = {
    "simply_supported": (0, 4),
    "cantilever": (0, 1),
    "fixed": (0, 1, 4, 5),
    "fixed_pinned": (0, 1, 4),
}
"""Of deflection and slope at the left end, the load and the right end (0 to 5), those that the supports hold."""


def sag_under_load(kind: str, length: float, at: float, bending: float) -> float:
    """Deflection per force where the load stands [m/N].

    Parameters
    ----------
    kind
        "simply_supported", "cantilever", "fixed" or "fixed_pinned".
    length, at
        Of the beam, and place of the load from its left end [m]; `at` = `length` is the free tip.
    bending
        Modulus times second moment of area [N m^2].
    """
    if at >= length:
        return float(np.linalg.solve(_element(length)[2:, 2:], [1.0, 0.0])[0] / bending)
    stiff = np.zeros((6, 6))
    stiff[:4, :4] += _element(at)
    stiff[2:, 2:] += _element(length - at)
    free = [i for i in range(6) if i not in _HELD[kind]]
    load = np.array([float(i == 2) for i in free])
    return float(np.linalg.solve(stiff[np.ix_(free, free)], load)[free.index(2)] / bending)


def _element(length: float) -> FloatArray:
    """Stiffness of a beam element of unit bending stiffness: deflection and slope at both ends, (4, 4)."""
    a = length
    table = [[12.0, 6 * a, -12.0, 6 * a], [6 * a, 4 * a * a, -6 * a, 2 * a * a],
             [-12.0, -6 * a, 12.0, -6 * a], [6 * a, 2 * a * a, -6 * a, 4 * a * a]]  # fmt: skip
    return np.array(table) / a**3
