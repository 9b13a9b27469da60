"""Sums of powers of the variables: prices, masses, damping ratios of links; they need no machine."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.form import WITHOUT_END, Form
from vibopt.mechanics.monomial import Monomial, product
from vibopt.records import dataclass

if TYPE_CHECKING:
    from vibopt.arrays import IntArray
    from vibopt.forms.asking import ConvexRows, LogRows, OneVariable
    from vibopt.forms.bounds import FormBounds
    from vibopt.forms.form import Bounds
    from vibopt.forms.tangent import Tangent
    from vibopt.mechanics.model import Model
    from vibopt.signals import Output


@dataclass(frozen=True, slots=True)
class Monomials(Form):
    """Sum of scale_j * prod_i x_i**exponents_ji.  scale (n,), exponents (n, n_vars)."""

    scale: FloatArray
    exponents: FloatArray
    one_line = True
    rank = 0
    rough = ""

    @classmethod
    def of(cls, model: Model, *powers: Monomial) -> Monomials:
        """Their sum, in the variables of a model."""
        exponents = np.array([one.row(model.n_vars) for one in powers]).reshape(len(powers), model.n_vars)
        return cls(np.array([one.scale for one in powers]), exponents)

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
        at = np.asarray(x).tolist()
        rows = zip(self.scale.tolist(), self.exponents.tolist(), strict=True)
        return sum((product(scale, at, powers) for scale, powers in rows), 0.0)

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        slope: FloatArray = self._shares(x) @ self.exponents
        return slope

    def bend(self, model: Model, x: FloatArray) -> FloatArray:
        shares = self._shares(x)
        slope = shares @ self.exponents
        bend: FloatArray = (self.exponents.T * shares) @ self.exponents - np.outer(slope, slope)
        return bend

    def _shares(self, x: FloatArray) -> FloatArray:
        """Part of each power in the sum, (n_powers,); all alike where every one is zero."""
        parts = self._parts(x)
        total = parts.sum()
        return parts / total if total else np.full(len(parts), 1.0 / len(parts))

    @property
    def tangents_of(self) -> tuple[float, ...]:
        return 1.0, -1.0

    def tangents(
        self, model: Model, x: FloatArray, reach: FloatArray, level: float = WITHOUT_END, times: Sequence[float] = ()
    ) -> list[list[Tangent]]:
        from vibopt.forms.tangent import Tangent, bent

        found = []
        for one, off in zip(x, reach, strict=True):
            parts = self._parts(one)
            rest = float(np.abs(parts) @ bent(self.exponents, off))
            found.append([Tangent(float(parts.sum()), parts @ self.exponents, rest, np.zeros(len(one)))])
        return found

    def cost(self, model: Model) -> float:
        return 0.006

    def values(self, model: Model, x: FloatArray, *, least_wanted: bool = False) -> FloatArray:
        return self.at(x)

    def glance(self, model: Model, x: FloatArray) -> FloatArray:
        return self.at(x)

    def acting(self, model: Model) -> FloatArray:
        return self.exponents

    def senses(self, model: Model) -> FloatArray:
        return self.exponents

    def rises(self, model: Model, index: int) -> float | None:
        rows = self.exponents.tolist()
        own = [row.pop(index) for row in rows]
        if any(map(any, rows)):
            return None
        return 1.0 if all(one > 0.0 for one in own) else -1.0 if all(one < 0.0 for one in own) else None

    def held(self, x: FloatArray, free: list[int]) -> Monomials:
        fixed = [i for i in range(len(x)) if i not in free]
        sizes = [float(np.prod(np.where(row == 0.0, 1.0, x[fixed] ** row))) for row in self.exponents[:, fixed]]
        return Monomials(self.scale * np.array(sizes), self.exponents[:, free])

    def room(self, model: Model, x: FloatArray, value: float, other: float, rounding: float) -> float:
        return 0.0

    def said(self, model: Model, order: IntArray) -> tuple[Any, ...]:
        rows = zip(self.scale.tolist(), self.exponents[:, order].tolist(), strict=True)
        return tuple(sorted((scale, tuple(one + 0.0 for one in row)) for scale, row in rows))

    def polynomial(self, rows: OneVariable, model: Model, bound: float) -> FloatArray:
        powers = np.round(self.exponents[:, 0] * rows.root).astype(int)
        row = np.zeros(int(powers.max(initial=0)) + 1)
        for scale, power, exponent in zip(self.scale, powers, self.exponents[:, 0], strict=True):
            row[power] += scale * rows.reference**exponent
        row[0] -= bound
        return row

    def is_polynomial(self, model: Model, most_degree: int) -> bool:
        return bool((self.exponents >= 0).all())

    def sampleable(self, model: Model) -> bool:
        return True

    def bounded(self, model: Model) -> bool:
        return True

    def on_boxes(self, known: FormBounds, low: FloatArray, high: FloatArray) -> Bounds:
        return self.extent(low, high)

    def extent(self, low: FloatArray, high: FloatArray) -> Bounds:
        """Exact range on boxes (n_boxes, n_vars) where all scales are positive, term by term, each (n_boxes,)."""
        rising = self.exponents > 0.0
        lower = np.zeros(len(low))
        upper = np.zeros(len(low))
        for scale, exponents, up in zip(self.scale, self.exponents, rising, strict=True):
            monomials = Monomials(np.array([scale]), exponents[None, :])
            lower += monomials.at(np.where(up, low, high))
            upper += monomials.at(np.where(up, high, low))
        return lower, upper

    def known(self, at: FormBounds) -> bool:
        return True

    def on_points(self, at: FormBounds, x: FloatArray) -> Bounds:
        value = self.at(x)
        return value, value

    def logged(self, rows: LogRows, model: Model, bound: float) -> Any:
        return rows.of_powers(self, bound)

    def convex_limit(self, rows: ConvexRows, limit: Any, sense: float, bound: float) -> Any:
        return rows.powers(limit, self, sense, bound)

    def convex_goal(self, rows: ConvexRows, aim: Any) -> Any:
        return rows.powers_goal(aim, self)

    def _parts(self, x: FloatArray) -> FloatArray:
        parts: FloatArray = self.scale * np.where(self.exponents == 0.0, 1.0, x**self.exponents).prod(axis=1)
        return parts


def mounts(model: Model, output: Output) -> Monomials:
    """Number of mounts by which what an output reads is divided: one without any."""
    return Monomials.of(model, model.counts[output.shared_by] if output.shared_by else Monomial(1.0))
