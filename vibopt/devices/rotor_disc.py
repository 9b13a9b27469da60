"""A rigid disc on a rotor."""

import math

from pydantic import model_validator

from vibopt.devices.shaft_places import At
from vibopt.devices.symbols import Numbers, Symbols
from vibopt.mechanics.monomial import Monomial
from vibopt.values import Choice, Fact, Table, Value, number, word


class RotorDisc(Table):
    """One entry of `discs`: a rigid disc, by mass and moments of inertia or by its sizes.

    Keys
    ----
    name: What it is called: a point as any other, at which links end and `on` which an unbalance acts: `name =
        "wheel"`.
    at: Its place from the left end of the shaft, or the end of a section: `at = "0.5 m"`, `at = "end of section 2"`.
    mass: Its mass; beside it both moments of inertia, or none of a mass that is a point.
    diametral: Moment of inertia about a diameter.
    polar: Moment of inertia about the axis of the shaft, which says how much it resists tilting as it spins.
    outer_diameter: Of a round disc, beside `width` and `density`, instead of `mass`.
    inner_diameter: Of its bore; none without it.
    width: Along the shaft.
    density: Of its material: `density = "7850 kg/m3"`.
    """

    name: str
    at: At
    mass: Value | None = number("mass")
    diametral: Value | None = number("inertia")
    polar: Value | None = number("inertia")
    outer_diameter: Value | None = number("length")
    inner_diameter: Fact | None = number("length", choice=False)
    width: Value | None = number("length")
    density: Fact | None = number("density", choice=False)

    @model_validator(mode="after")
    def _one_way(self) -> "RotorDisc":
        sizes = [key for key in ("outer_diameter", "width", "density") if getattr(self, key) is not None]
        if self.mass is not None:
            if sizes:
                raise word(f"gives mass and {sizes[0]}. Keep the mass with its moments of inertia, or the sizes.")
            if (self.diametral is None) != (self.polar is None):
                raise word('gives one moment of inertia. Write both: diametral = "0.4 kg m2" and polar = "0.8 kg m2".')
            ways = [one for one in (self.polar, self.diametral) if one is not None]
            if ways and _ends(ways[0])[1] > 2.0 * _ends(ways[1])[0] * (1.0 + 1e-9):
                how = "may have" if any(isinstance(one, Choice) for one in ways) else "has"
                raise word(
                    f"{how} a polar moment of inertia of more than twice the diametral one: there is no such body. "
                    "A thin disc has twice."
                )
            return self
        if len(sizes) < 3:
            raise word('needs its mass, or outer_diameter, width and density. Write mass = "30 kg".')
        if self.diametral is not None or self.polar is not None:
            raise word("gives its sizes and a moment of inertia, which follows from them. Keep one.")
        least = getattr(self.outer_diameter, "low", getattr(self.outer_diameter, "value", 0.0))
        if self.inner_diameter is not None and self.inner_diameter.value >= least:
            raise word("is as wide inside as outside, or wider. Write a smaller inner_diameter.")
        return self

    def inertias(self, path: str, symbols: Symbols) -> tuple[list[Monomial], list[Monomial], list[Monomial]]:
        """Mass [kg], diametral and polar moment of inertia [kg m^2], each a sum."""

        def read(key: str) -> Monomial:
            return symbols.read(f"{path}.{key}", getattr(self, key))

        if self.mass is not None:
            tilts = [[read(key)] if getattr(self, key) is not None else [] for key in ("diametral", "polar")]
            return [read("mass")], tilts[0], tilts[1]
        assert self.density is not None
        hole = self.inner_diameter.value if self.inner_diameter is not None else 0.0
        ring = read("width").times(0.25 * math.pi * self.density.value)
        squares = [ring * read("outer_diameter") ** 2.0, *([ring.times(-(hole**2))] if hole else [])]
        fourths = [ring * read("outer_diameter") ** 4.0, *([ring.times(-(hole**4))] if hole else [])]
        flat = [square * read("width") ** 2.0 for square in squares]
        diametral = [fourth.times(1.0 / 16.0) for fourth in fourths] + [one.times(1.0 / 12.0) for one in flat]
        return squares, diametral, [fourth.times(1.0 / 8.0) for fourth in fourths]

    def built(self, path: str, numbers: Numbers) -> tuple[float, float, float]:
        """Mass [kg], diametral and polar moment of inertia [kg m^2], of radii."""

        def given(key: str) -> float:
            return numbers(f"{path}.{key}", getattr(self, key))

        if self.mass is not None:
            return given("mass"), given("diametral"), given("polar")
        outer, inner, wide = 0.5 * given("outer_diameter"), 0.5 * given("inner_diameter"), given("width")
        mass = given("density") * math.pi * (outer - inner) * (outer + inner) * wide
        about = outer**2 + inner**2
        return mass, mass * (3.0 * about + wide**2) / 12.0, 0.5 * mass * about


def _ends(one: Value) -> tuple[float, float]:
    return (one.low, one.high) if isinstance(one, Choice) else (one.value, one.value)
