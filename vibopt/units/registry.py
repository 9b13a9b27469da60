"""The field's units and no others: factor and dimensions of each, from our own small definitions file.

The file is in pint's notation, and a law holds every unit against pint; pint itself would take longer to load than
all the rest of a small job.
"""

import re
from functools import cache
from pathlib import Path
from typing import TypeAlias

from vibopt.records import dataclass

DEFINITIONS = Path(__file__).with_name("definitions.txt")

Dimensionality: TypeAlias = frozenset[tuple[str, float]]

_PART = re.compile(r"([*/]?)(?:([\d.]+(?:e-?\d+)?)|([A-Za-z]+)|(\()|(\)))(?:\*\*(-?\d+))?")


@dataclass(frozen=True, slots=True)
class _Unit:
    """SI value of one unit, and the powers of its base dimensions."""

    factor: float
    powers: tuple[tuple[str, int], ...] = ()

    def times(self, other: "_Unit", power: int) -> "_Unit":
        """This unit times a power of another."""
        powers = dict(self.powers)
        for base, one in other.powers:
            powers[base] = powers.get(base, 0) + power * one
        return _Unit(self.factor * other.factor**power, tuple((base, one) for base, one in powers.items() if one))


@cache
def _units() -> dict[str, _Unit]:
    """Every unit of the file by name; each is defined by those above it: "kN = 1e3 * N = other name"."""
    found: dict[str, _Unit] = {}
    for line in DEFINITIONS.read_text(encoding="utf-8").splitlines():
        if line and line[0] != "#":
            name, meaning, *others = line.replace(" ", "").split("=")
            base = meaning.startswith("[")
            found[name] = _Unit(1.0, ((meaning, 1),)) if base else _product(meaning, found)
            found |= dict.fromkeys(others, found[name])
    return found


def _product(expression: str, known: dict[str, _Unit]) -> _Unit:
    """Numbers, units and products in brackets, multiplied and divided from left to right."""
    done = _Unit(1.0)
    outside: list[tuple[_Unit, int]] = []
    """What stands before each open bracket, and the way it goes on."""
    for sign, number, name, opens, closes, power in _PART.findall(expression):
        way = -1 if sign == "/" else 1
        if opens:
            outside.append((done, way))
            done = _Unit(1.0)
        elif closes:
            before, way = outside.pop()
            done = before.times(done, way * int(power or 1))
        else:
            done = done.times(known[name] if name else _Unit(float(number)), way * int(power or 1))
    return done


@cache
def symbols() -> frozenset[str]:
    """The units that the file defines."""
    return frozenset(_units())


@cache
def factor_and_dimensionality(expression: str) -> tuple[float, Dimensionality]:
    """SI value of one `expression` (pint's notation, as "kN*s/m") and the powers of its base dimensions."""
    unit = _product(expression, _units())
    return unit.factor, frozenset(unit.powers)
