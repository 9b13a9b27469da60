"""A wavy road under a vehicle."""

import math
from typing import ClassVar

from pydantic import model_validator

from vibopt.arrays import FloatArray
from vibopt.excitations.excitation import Excitation, unit_line
from vibopt.signals import Amplitude, Band, Line, Piece
from vibopt.values import Fact, number, word


class Road(Excitation):
    """`kind = "road"`: y = Y sin(2 pi s / wavelength); frequency = 2 pi v / wavelength.

    Keys
    ----
    amplitude: Amplitude of the waves.
    wavelength: From crest to crest: `wavelength = "5 m"`. One of `wavelength` and `wavenumber`.
    wavenumber: 2 π over the wavelength.
    """

    amplitude: Fact = number("length", amplitude=True, choice=False, required=True)
    wavelength: Fact | None = number("length", choice=False)
    wavenumber: Fact | None = number("wavenumber", choice=False)
    family: ClassVar[str] = "bases"
    of_vehicle: ClassVar[bool] = True
    inherent: ClassVar[bool] = True

    @model_validator(mode="after")
    def _one_of_two(self) -> "Road":
        if (self.wavelength is None) == (self.wavenumber is None):
            raise word('needs either wavelength or wavenumber. Write wavelength = "5 m".')
        return self

    @property
    def rate(self) -> float:
        """Angular rate per vehicle speed [rad/m]."""
        if self.wavenumber is not None:
            return self.wavenumber.value
        assert self.wavelength is not None
        return 2.0 * math.pi / self.wavelength.value

    def to_rotation(self, band: Band) -> Band:
        return Band(band.low * self.rate, band.high * self.rate)

    def from_rotation(self, omega: float) -> float:
        return omega / self.rate

    def lines(self, direction: FloatArray) -> tuple[Line, ...]:
        amplitude = Amplitude((Piece(Band(0.0, math.inf), self.amplitude.value),))
        return (unit_line(1.0, direction, 0.0, amplitude),)
