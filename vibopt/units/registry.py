"""The only door to pint: one question per unit text, answered from our own small definitions file."""

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias, cast

if TYPE_CHECKING:
    import pint

DEFINITIONS = Path(__file__).with_name("definitions.txt")

Dimensionality: TypeAlias = frozenset[tuple[str, float]]


@cache
def registry() -> "pint.UnitRegistry[float]":
    """Pint with the field's units and no others; loaded when first asked."""
    import pint

    return pint.UnitRegistry(str(DEFINITIONS))


@cache
def symbols() -> frozenset[str]:
    """The units that the file defines; pint alone would also take plurals, and read "Ns" as newtons."""
    lines = [line for line in DEFINITIONS.read_text(encoding="utf-8").splitlines() if line and line[0] != "#"]
    parts = [[part.strip() for part in line.split("=")] for line in lines]
    return frozenset(name for line in parts for name in (line[0], *line[2:]))


@cache
def factor_and_dimensionality(expression: str) -> tuple[float, Dimensionality]:
    """SI value of one `expression` (pint's notation, as "kN*s/m") and the powers of its base dimensions."""
    unit = registry().parse_units(expression)
    factor: float = registry().Quantity(1.0, unit).to_root_units().magnitude
    powers = {str(base): cast(float, power) for base, power in unit.dimensionality.items()}
    return factor, frozenset(powers.items())
