"""A shaft in torsion: its stiffness and stress, by formulas of its diameter and by its polar moment of area."""

import math

from pydantic import model_validator

from vibopt.devices.symbols import Numbers, Symbols
from vibopt.mechanics.monomial import Monomial
from vibopt.values import Fact, Table, Value, number, word
from vibopt.values.fields import Choice


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
        check_bore(self, "twist")
        return self

    def spring(self, path: str, symbols: Symbols) -> Monomial:
        """Torsional stiffness [N m/rad]; `path` is where the table stands in the file."""
        long = symbols.read(f"{path}.length", self.length)
        wide = symbols.read(f"{path}.diameter", self.diameter)
        scale = math.pi * self.shear_modulus.value * (1.0 - bore(self) ** 4) / 32.0
        return (wide**4.0 * long**-1.0).times(scale)

    def stress(self, path: str, symbols: Symbols) -> Monomial:
        """Greatest shear stress over twist [Pa/rad], G d / (2 L)."""
        wide = symbols.read(f"{path}.diameter", self.diameter)
        long = symbols.read(f"{path}.length", self.length)
        return (wide * long**-1.0).times(0.5 * self.shear_modulus.value)

    def built(self, path: str, numbers: Numbers) -> tuple[float, float]:
        """Both from the polar moment of area of two radii, G J / L and that times r / J, for the machine as built."""
        outer = 0.5 * numbers(f"{path}.diameter", self.diameter)
        inner = outer * self.inner_ratio.value if self.inner_ratio is not None else 0.0
        if self.inner_diameter is not None:
            inner = 0.5 * self.inner_diameter.value
        polar = 0.5 * math.pi * (outer**4 - inner**4)
        stiffness = self.shear_modulus.value * polar / numbers(f"{path}.length", self.length)
        return stiffness, stiffness * outer / polar


def check_bore(hollow: Table, does: str) -> None:
    """Inner and outer diameter of a round bar that is to bend or twist."""
    diameter, inner, ratio = (getattr(hollow, one) for one in ("diameter", "inner_diameter", "inner_ratio"))
    if inner is not None and ratio is not None:
        raise word("gives inner_diameter and inner_ratio. Keep one.")
    open_ended = isinstance(diameter, Choice)
    if inner is not None and (open_ended or diameter.tolerance):
        raise word(
            f"has an inner_diameter while its diameter {'is to be chosen' if open_ended else 'has a tolerance'}. Write "
            "inner_ratio = 0.5 (inner over outer diameter) instead."
        )
    if bore(hollow) >= 1.0:
        raise word(
            f"is as wide inside as outside, or wider: nothing is left to {does}. Write a smaller inner diameter."
        )


def bore(hollow: Table) -> float:
    """Inner over outer diameter; 0 of a solid bar."""
    diameter, inner, ratio = (getattr(hollow, one) for one in ("diameter", "inner_diameter", "inner_ratio"))
    if ratio is not None:
        return float(ratio.value)
    return float(inner.value / diameter.value) if inner is not None and isinstance(diameter, Fact) else 0.0
