"""Sums of powers of the variables: prices, masses, damping ratios of links; they need no machine."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.form import WITHOUT_END, Form
from vibopt.records import dataclass

if TYPE_CHECKING:
    from vibopt.forms.tangents import Tangent
    from vibopt.mechanics.model import Model


@dataclass(frozen=True, slots=True)
class Monomials(Form):
    """Sum of scale_j * prod_i x_i**exponents_ji.  scale (n,), exponents (n, n_vars)."""

    scale: FloatArray
    exponents: FloatArray

    @property
    def powers(self) -> Monomials:
        return self

    def at(self, x: FloatArray) -> FloatArray:
        """At designs x (..., n_vars), shape (...)."""
        with np.errstate(divide="ignore"):
            powers = np.where(self.exponents == 0.0, 1.0, np.asarray(x)[..., None, :] ** self.exponents)
        value: FloatArray = (self.scale * powers.prod(axis=-1)).sum(axis=-1)
        return value

    def value(self, model: Model, x: FloatArray) -> float:
        return float(self.at(x))

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        parts = self._parts(x)
        slope: FloatArray = parts @ self.exponents / parts.sum()
        return slope

    def bend(self, model: Model, x: FloatArray) -> FloatArray:
        parts = self._parts(x)
        slope = parts @ self.exponents / parts.sum()
        bend: FloatArray = (self.exponents.T * parts) @ self.exponents / parts.sum() - np.outer(slope, slope)
        return bend

    @property
    def tangents_of(self) -> tuple[float, ...]:
        return 1.0, -1.0

    def tangents(
        self, model: Model, x: FloatArray, reach: FloatArray, level: float = WITHOUT_END, times: Sequence[float] = ()
    ) -> Iterator[Tangent]:
        from vibopt.forms.tangents import Tangent, bent

        parts = self._parts(x)
        rest = float(np.abs(parts) @ bent(self.exponents, reach))
        yield Tangent(float(parts.sum()), parts @ self.exponents, rest, np.zeros(len(x)))

    def cost(self, model: Model) -> float:
        return 0.02

    def _parts(self, x: FloatArray) -> FloatArray:
        parts: FloatArray = self.scale * np.where(self.exponents == 0.0, 1.0, x**self.exponents).prod(axis=1)
        return parts
