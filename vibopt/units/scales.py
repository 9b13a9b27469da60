"""From a unit text and the place where it stands to a scale, worked out once per text."""

import re
from collections.abc import Mapping
from functools import cache
from math import isclose, log10, tau

from vibopt.errors import QuantityError
from vibopt.records import dataclass
from vibopt.units import complaints
from vibopt.units.dimensions import DIMENSIONS
from vibopt.units.spelling import Dimensionality, expression, factor_and_dimensionality

_POUND_FORCE = {"lb": "lbf"}
_KILOGRAM_FORCE = {"kg": "kgf"}
"""Asked about, not read: catalogues have loads in kg, but so have masses that were meant."""
READINGS: dict[str, dict[str, str]] = {
    "force": _POUND_FORCE,
    "stiffness": _POUND_FORCE,
    "damping": _POUND_FORCE,
    "torsional_stiffness": _POUND_FORCE,
    "torsional_damping": _POUND_FORCE,
    "acceleration": {"g": "gn", "mg": "mgn"},
    "force_density": _POUND_FORCE,
    "acceleration_density": {"g": "gn", "mg": "mgn"},
}
"""Symbols that mean something else in some places; tried only if their plain meaning does not fit."""


@dataclass(frozen=True, slots=True)
class Scale:
    """SI value of one unit.

    Attributes
    ----------
    factor, divisor
        SI value of one unit is factor / divisor; two numbers, so that 20 mm is 0.02 m and
        1200 rpm is 20 Hz to the last bit.
    decibel
        The unit is 20 log10 of a ratio, and factor and divisor have no meaning.
    reading
        Unit text as understood, where that is not as written ("lbf/in" for "lb/in").
    """

    factor: float
    divisor: float = 1.0
    decibel: bool = False
    reading: str | None = None

    def to_si(self, number: float) -> float:
        """SI value of `number` units; OverflowError for decibels beyond all numbers."""
        return float(10.0 ** (number / 20.0)) if self.decibel else number / self.divisor * self.factor

    def from_si(self, value: float) -> float:
        """Number of units in an SI `value`; ValueError for decibels of a value that is not positive."""
        return 20.0 * log10(value) if self.decibel else value / self.factor * self.divisor


@cache
def scale_of(unit: str, dimension: str, place: str | None = None) -> Scale:
    """Scale of a unit text without detector word where `dimension` is expected.

    Raises
    ------
    QuantityError
        The unit is unknown or of another dimension; `place` names who needs the dimension.
    """
    written = expression(unit)
    if written is None:
        raise QuantityError(complaints.unknown_unit(unit, dimension))
    factor, powers = factor_and_dimensionality(written)
    if dimension == "ratio" and written == "dB":
        return Scale(1.0, decibel=True)
    if powers == _powers(dimension) and not (dimension == "count" and written):
        return _exact(factor)
    reading = _as_expected(unit, dimension, READINGS.get(dimension, {}))
    if reading is None:
        weight = _as_expected(unit, dimension, _KILOGRAM_FORCE)
        meant = str(weight.reading) if weight is not None else ""
        raise QuantityError(complaints.wrong_dimension(unit, _names().get(powers), dimension, place, meant))
    return reading


def _as_expected(unit: str, dimension: str, readings: Mapping[str, str]) -> Scale | None:
    """Scale with the symbols read as this place expects, or None if that does not fit either."""
    meant = unit
    for symbol, other in readings.items():
        meant = re.sub(rf"(?<![A-Za-z]){symbol}(?![A-Za-z])", other, meant)
    written = expression(meant)
    if meant == unit or written is None:
        return None
    factor, powers = factor_and_dimensionality(written)
    return Scale(factor, reading=meant) if powers == _powers(dimension) else None


def _exact(factor: float) -> Scale:
    """Scale in whole numbers, of radians or of turns, where `factor` is one up to rounding."""
    for base in (1.0, tau):
        divisor = float(round(base / factor))
        if divisor and isclose(factor * divisor, base, rel_tol=1e-14):
            return Scale(base, divisor)
        multiple = float(round(factor / base))
        if multiple and isclose(factor, multiple * base, rel_tol=1e-14):
            return Scale(multiple * base)
    return Scale(factor)


@cache
def _powers(dimension: str) -> Dimensionality:
    """Powers of the base dimensions."""
    return factor_and_dimensionality(expression(DIMENSIONS[dimension].si) or "")[1]


@cache
def _names() -> dict[Dimensionality, str]:
    """Dimension by its powers; of ratio and count, which share theirs, the ratio."""
    return {_powers(name): name for name in reversed(DIMENSIONS)}
