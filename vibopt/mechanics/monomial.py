"""Products of powers of the design variables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from math import inf, prod

import numpy as np

from vibopt.arrays import FloatArray, IntArray
from vibopt.records import dataclass


@dataclass(frozen=True)
class Monomial:
    """scale * prod_i x_i**exponents[i]; exponents by index of the design variable."""

    scale: float
    exponents: dict[int, float] = field(default_factory=dict)

    def __mul__(self, other: Monomial) -> Monomial:
        powers = dict(self.exponents)
        for index, power in other.exponents.items():
            powers[index] = powers.get(index, 0.0) + power
        return Monomial(self.scale * other.scale, powers)

    def __pow__(self, power: float) -> Monomial:
        return Monomial(self.scale**power, {i: e * power for i, e in self.exponents.items()})

    def times(self, factor: float) -> Monomial:
        return Monomial(self.scale * factor, self.exponents)

    def only(self, count: int) -> Monomial:
        """The product without the powers of all variables from index `count` on."""
        return Monomial(self.scale, {i: e for i, e in self.exponents.items() if i < count})

    def held(self, kept: IntArray, values: FloatArray) -> Monomial:
        """With all variables but those `kept` (indices) at their `values` (n_vars,); kept ones are counted anew."""
        places = {int(old): new for new, old in enumerate(kept)}
        scale = self.scale
        for i, power in self.exponents.items():
            scale *= 1.0 if i in places or power == 0.0 else float(values[i]) ** power
        return Monomial(scale, {places[i]: e for i, e in self.exponents.items() if i in places})

    def placed(self, where: IntArray) -> Monomial:
        """With variable i counted as number `where[i]` of more variables."""
        return Monomial(self.scale, {int(where[i]): e for i, e in self.exponents.items()})

    def row(self, n_vars: int) -> FloatArray:
        """Exponents as an array, shape (n_vars,)."""
        row = np.zeros(n_vars)
        for index, power in self.exponents.items():
            row[index] = power
        return row


def product(scale: float, x: Sequence[float], powers: Sequence[float]) -> float:
    """scale * prod_i x_i**powers_i at one design; what divides by zero, or is beyond all numbers, has no end."""
    try:
        return float(scale * prod(value**power for value, power in zip(x, powers, strict=True) if power))
    except ArithmeticError:
        return scale * inf
