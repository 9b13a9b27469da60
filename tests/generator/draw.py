"""What a generator draws from: numbers, units and choices, the same ones for the same seed."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Any, TypeVar

from vibopt.units import DIMENSIONS, plain, to_unit

T = TypeVar("T")
_SKIPPED = {"lb in", "lb s/in", "lb/in", "lb", "mg", "nm", "um", "km", "oz", "g"}
"""Units that read otherwise at another place, or are of another size than machines."""


class Draw:
    """A stream of drawn numbers; `left` is how many design variables may still be drawn.

    With `listed` every variable has a list of values, as beside parts from a catalogue, which are `bought`.  What is
    `small` is answered quickly: nothing is free; what is `sure` goes without tolerances.  Where it is `bent`, links are
    beams with a depth.
    """

    def __init__(self, seed: int | str, *, listed: bool = False, bought: bool = False, small: bool = False) -> None:
        self.random = random.Random(seed)
        self.left = 0
        self.listed = listed
        self.bought = bought
        self.small = small
        self.sure = False
        self.bent = False

    def pick(self, among: Sequence[T]) -> T:
        return among[self.random.randrange(len(among))]

    def chance(self, part: float) -> bool:
        return self.random.random() < part

    def doubt(self, part: float) -> bool:
        """Whether something has a tolerance."""
        return self.chance(part) and not self.sure

    def size(self, low: float, high: float) -> float:
        """A positive number, as likely of one magnitude as of another, three digits long."""
        return float(f"{low * (high / low) ** self.random.random():.3g}")

    def unit(self, value: float, dimension: str) -> str:
        """Any unit of a dimension that suits the size of a value [SI]."""
        kind = DIMENSIONS[dimension]
        units = [one for one in kind.units if one not in _SKIPPED and 1e-3 <= abs(to_unit(value, one, dimension)) < 1e6]
        return self.pick(units) if units else kind.si

    def said(self, value: float, dimension: str, *, amplitude: bool = False, unit: str = "") -> str | float:
        """An SI value as a file says it."""
        if not DIMENSIONS[dimension].si:
            return float(f"{value:.4g}")
        unit = unit or self.unit(value, dimension)
        word = self.pick(["", "", "", " pk", " pp", " rms"]) if amplitude else ""
        return f"{plain(to_unit(value, unit + word, dimension), 4)} {unit}{word}"

    def value(self, typical: float, dimension: str, *, spread: float = 5.0, vary: float = 0.5) -> Any:
        """A value about `typical` [SI]: a fact, or a design variable with the chance `vary`."""
        value = self.size(typical / 1.5, typical * 1.5)
        if self.left and self.chance(vary):
            self.left -= 1
            return self._choice(value, dimension, spread)
        return self.fact(value, dimension)

    def fact(self, value: float, dimension: str) -> Any:
        """A fact, now and then with a tolerance."""
        if dimension not in _UNCERTAIN or not self.doubt(0.04):
            return self.said(value, dimension)
        return {"value": self.said(value, dimension), "tolerance": self.pick(["5 %", 0.1, "2 %"])}

    def _choice(self, value: float, dimension: str, spread: float) -> dict[str, Any]:
        unit = self.unit(value, dimension) if self.chance(0.85) else ""
        low, high = (self.said(one, dimension, unit=unit) for one in (value / spread, value * spread))
        if self.listed or self.chance(0.25):
            parts = sorted({0.5, 1.0, *(self.size(1.0 / spread, spread) for _ in range(2))})
            return {"one_of": [self.said(part * value, dimension) for part in parts]}
        if self.chance(0.1):
            return self.pick([{"from": low}, {"to": high}])
        loose = {"tolerance": "10 %"} if dimension in _UNCERTAIN and self.doubt(0.06) else {}
        return {"from": low, "to": high, **loose}

    def whole(self, low: int, high: int) -> Any:
        """A number of mounts: a fact, or a variable."""
        if self.left and self.chance(0.5):
            self.left -= 1
            return {"from": low, "to": high, "whole": True}
        return self.random.randint(low, high)


_UNCERTAIN = ("mass", "stiffness", "damping", "inertia", "torsional_stiffness", "torsional_damping")


def aside(table: dict[str, Any]) -> Draw:
    """Chances that hang on what has been drawn, and take nothing from what will be."""
    return Draw(sum(map(ord, str(table))))
