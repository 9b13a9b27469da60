"""Products of powers of the design variables."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from vibopt.forms import FloatArray


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

    def row(self, n_vars: int) -> FloatArray:
        """Exponents as an array, shape (n_vars,)."""
        row = np.zeros(n_vars)
        for index, power in self.exponents.items():
            row[index] = power
        return row
