"""A squeeze-film damper by its sizes: a film of oil between two rings that do not turn on each other."""

import math

from pydantic import model_validator

from vibopt.devices.symbols import Numbers, Symbols
from vibopt.mechanics.monomial import Monomial
from vibopt.values import Fact, Table, Value, number, word

_LONGEST = 0.5
"""Length over diameter up to which the formula of the short bearing holds."""


class SqueezeFilm(Table):
    """`squeeze_film` of a bearing: damping c = pi mu R L^3 / C^3 of small motions round its middle.

    Formula of the short bearing, uncavitated and centred (Vance, Rotordynamics of Turbomachinery, 1988): viscosity mu,
    radius R, length L, radial clearance C. It holds for orbits much smaller than the clearance, for L / D up to a half.

    Keys
    ----
    clearance: Radial: `clearance = "0.12 mm"`. It may be chosen, as the next two.
    length: Of the land along the shaft: `length = "25 mm"`.
    diameter: Of the ring: `diameter = "100 mm"`.
    viscosity: Of the oil as warm as it runs: `viscosity = "0.012 Pa s"`.
    cavitated: Whether half of the film is torn, which halves the damping.
    """

    clearance: Value = number("length", required=True)
    length: Value = number("length", required=True)
    diameter: Value = number("length", required=True)
    viscosity: Fact = number("viscosity", choice=False, required=True, tolerance=True)
    cavitated: bool = False

    @model_validator(mode="after")
    def _short(self) -> "SqueezeFilm":
        long, wide = (getattr(one, "high", getattr(one, "value", 0.0)) for one in (self.length, self.diameter))
        least = getattr(self.diameter, "low", wide)
        if long > _LONGEST * least:
            raise word(
                "is longer than half its diameter, where the formula of the short bearing no longer holds. Write a "
                "shorter film, two of them, or the damping itself: c_yy and c_zz."
            )
        if getattr(self.clearance, "high", getattr(self.clearance, "value", 0.0)) > 0.05 * least:
            raise word(
                "has a clearance of more than a twentieth of its diameter, which is no film. Write a smaller one."
            )
        return self

    @property
    def _part(self) -> float:
        return 0.5 if self.cavitated else 1.0

    def damping(self, path: str, symbols: Symbols) -> Monomial:
        """Its damping [N s/m] in the variables."""

        def read(key: str) -> Monomial:
            return symbols.read(f"{path}.{key}", getattr(self, key))

        whole = read("viscosity") * read("diameter") * read("length") ** 3.0 * read("clearance") ** -3.0
        return whole.times(0.5 * math.pi * self._part)

    def built(self, path: str, numbers: Numbers) -> float:
        """The same, by pressure: mu times the speed over the third power of the film, twice integrated [N s/m].

        Along the short way the pressure is a parabola, 6 mu v cos(t) (L^2 / 4 - z^2) / C^3; its mean is two thirds of
        its greatest, over the length, and its part along the motion the half of a turn.
        """

        def given(key: str) -> float:
            return numbers(f"{path}.{key}", getattr(self, key))

        long, film = given("length"), given("clearance")
        pressure = 6.0 * given("viscosity") * (0.5 * long) ** 2 / film**3
        return self._part * pressure * (2.0 / 3.0) * long * math.pi * (0.5 * given("diameter"))
