"""What springs do under the weights alone, with static stiffness."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.form import Form, row_said
from vibopt.forms.monomials import Monomials
from vibopt.forms.rational import Groups, Sampled, box_coefficients, ratio_bounds, sampled_static
from vibopt.forms.reduce import Reach, weighed
from vibopt.mechanics.harmonic import carried, dynamic_stiffness, stretches
from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS
from vibopt.mechanics.modes import sag, sag_bend, sag_slope, sags_at
from vibopt.records import dataclass

if TYPE_CHECKING:
    from vibopt.arrays import IntArray
    from vibopt.forms.asking import ConvexRows, LogRows, Proof
    from vibopt.forms.bounds import FormBounds
    from vibopt.forms.form import Bounds
    from vibopt.mechanics.model import Model

_MOST_CORNERS = 12
"""Variables up to which a proof looks at every corner of their box."""


class UnderWeights(Form):
    """What is read of the displacement u under the weights alone: row . u, and forces of springs."""

    __slots__ = ()
    row: FloatArray
    once = 0.04

    @property
    def signed(self) -> bool:
        """Whether it keeps its sign."""
        return False

    @property
    def factor(self) -> Monomials | None:
        """What it is multiplied by."""
        return None

    def reading(self, model: Model) -> tuple[FloatArray, FloatArray]:
        """Signs of the forces of springs (n_terms,), and the row (n_coords,)."""
        return np.zeros(len(model.terms)), self.row

    def acting(self, model: Model) -> FloatArray:
        own: FloatArray = model.exponents[np.isin(model.kinds, (STIFFNESS, INERTIA)) & (model.static_scales != 0.0)]
        return own

    def groups(self, model: Model) -> Groups:
        return Groups.of(model, static=True)

    def known(self, at: FormBounds) -> bool:
        return True

    def around(self, proof: Proof) -> bool:
        return proof.of_weights(self)

    def squeezed(self, at: FormBounds, row: FloatArray, x: FloatArray) -> FloatArray:
        """row . u at designs x (n, n_vars), shape (n,)."""
        if at.direct:
            found: FloatArray = sags_at(at.model, x) @ row[: at.model.n_free]
            return found
        top, bottom = self._sample(at, row).at(x)
        with np.errstate(divide="ignore", invalid="ignore"):
            value: FloatArray = (top[:, 0] / bottom[:, 0]).real
        return np.where(np.isnan(value), np.inf, value)

    def stretched(self, at: FormBounds, row: FloatArray, low: FloatArray, high: FloatArray) -> Bounds:
        """Bounds of |row . u| on boxes."""
        lower, upper = ratio_bounds(*box_coefficients(self._sample(at, row), low, high))
        return np.sqrt(lower[:, 0]), np.sqrt(upper[:, 0])

    def _sample(self, at: FormBounds, row: FloatArray) -> Sampled:
        key = ("static", 0)
        if key not in at.samples:
            at.samples[key] = sampled_static(at.model, row, at.reference)
        return at.samples[key]

    def _carried(self, model: Model, x: FloatArray, rounding: float) -> float:
        """What rounding of the coefficients makes of it."""
        down, z = sag(model, x), np.where(model.kinds == STIFFNESS, model.values(x, static=True), 0.0)
        if down is None:
            return np.inf
        signs, row = self.reading(model)
        row = (signs * z) @ model.vectors if signs.any() else row
        moved = carried(model, z, dynamic_stiffness(model, z.astype(complex))[:, : model.n_free], row, down)
        return rounding * (moved + float(np.abs(signs * z) @ stretches(model, down)))


class Sagging(UnderWeights):
    """Of the size of row . u alone, however it is weighed: a quotient of two polynomials in the variables."""

    __slots__ = ()
    rough = ""

    def at_corners(self, model: Model, *, least_wanted: bool) -> bool:
        """Where it is monotone in each variable by itself, as each coefficient has one of its own."""
        if (self.acting(model) != 0.0).any(axis=0).sum() > _MOST_CORNERS or (least_wanted and model.n_free > 1):
            return False  # its size may pass through zero in between
        acts = np.isin(model.kinds, (STIFFNESS, INERTIA)) & (model.static_scales != 0.0)
        return bool(((model.exponents[acts] != 0.0).sum(axis=0) <= 1).all())

    def sampleable(self, model: Model) -> bool:
        return True

    def bounded(self, model: Model) -> bool:
        return not model.mixed


@dataclass(frozen=True, slots=True)
class StaticRow(Sagging):
    """Response under the weights alone, static stiffness: row . u [m]."""

    row: FloatArray
    one_line = True
    ratio = True
    rank = 2

    def value(self, model: Model, x: FloatArray) -> float:
        down = sag(model, x)
        return float("inf") if down is None else float(abs(self.row @ down))

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        return sag_slope(model, self.row, x)

    def bend(self, model: Model, x: FloatArray) -> FloatArray | None:
        return sag_bend(model, self.row, x)

    def reach(self, model: Model) -> Reach:
        return weighed(model, [self.row])

    def rises(self, model: Model, index: int) -> float | None:
        """A single mass sags less the stiffer it is held."""
        moved = [term for term in model.terms if term.exponents[index]]
        kinds = {term.kind for term in moved}
        simple = model.n_free == 1 and kinds <= {STIFFNESS, DAMPING} and STIFFNESS in kinds
        return -1.0 if simple and not any(term.exponents[index] < 0.0 for term in moved) else None

    def room(self, model: Model, x: FloatArray, value: float, other: float, rounding: float) -> float:
        return self._carried(model, x, rounding)

    def said(self, model: Model, order: IntArray) -> tuple[Any, ...]:
        return (row_said(self.row),)

    def sampled(self, model: Model, speeds: FloatArray, reference: FloatArray) -> Sampled:
        return sampled_static(model, self.row, reference)

    def is_polynomial(self, model: Model, most_degree: int) -> bool:
        return Groups.of(model).degrees[0] <= most_degree

    def on_boxes(self, known: FormBounds, low: FloatArray, high: FloatArray) -> Bounds:
        return self.stretched(known, self.row, low, high)

    def on_points(self, at: FormBounds, x: FloatArray) -> Bounds:
        value = np.abs(self.squeezed(at, self.row, x))
        return value, value

    def logged(self, rows: LogRows, model: Model, bound: float) -> Any:
        return rows.of_sag(model, self, bound)

    def convex_limit(self, rows: ConvexRows, limit: Any, sense: float, bound: float) -> Any:
        return rows.sag(limit, self, sense, bound)

    def convex_goal(self, rows: ConvexRows, aim: Any) -> Any:
        return rows.sag_goal(aim, self)


@dataclass(frozen=True, slots=True)
class StaticLoad(Sagging):
    """Static force of one mount under the weights alone, as a part of what it is rated for: factor(x) * |row . u|.

    `factor` is one monomial: static stiffness of one mount over its rating.  `signed` keeps the sign of row . u:
    a mount that is lifted has a force below zero.
    """

    row: FloatArray
    factor: Monomials
    signed: bool = False
    rank = 1
    not_convex = "is a part of a rated load"

    def value(self, model: Model, x: FloatArray) -> float:
        down = sag(model, x)
        if down is None:
            return float("inf")
        squeezed = float(self.row @ down)
        return (squeezed if self.signed else abs(squeezed)) * float(self.factor.at(x))

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        return sag_slope(model, self.row, x) + self.factor.slope(model, x)

    def acting(self, model: Model) -> FloatArray:
        return np.vstack([UnderWeights.acting(self, model), self.factor.exponents])

    def held(self, x: FloatArray, free: list[int]) -> StaticLoad:
        return StaticLoad(self.row, self.factor.held(x, free), self.signed)

    def said(self, model: Model, order: IntArray) -> tuple[Any, ...]:
        return (row_said(self.row), self.factor.said(model, order))

    def on_boxes(self, known: FormBounds, low: FloatArray, high: FloatArray) -> Bounds:
        small, large = self.factor.extent(low, high)
        lower, upper = self.stretched(known, self.row, low, high)
        return -large * upper if self.signed else small * lower, large * upper

    def on_points(self, at: FormBounds, x: FloatArray) -> Bounds:
        squeezed = self.squeezed(at, self.row, x)
        value = (squeezed if self.signed else np.abs(squeezed)) * self.factor.at(x)
        return value, value

    def logged(self, rows: LogRows, model: Model, bound: float) -> Any:
        return rows.of_load(model, self, bound)


@dataclass(frozen=True, slots=True)
class StaticMoment(UnderWeights):
    """What bends a beam under the weights, its own among them: |pulled(x) * (row . u) + own(x)|, one monomial each."""

    row: FloatArray
    pulled: Monomials
    own: Monomials
    rank = 1
    no_bounds = "is what two weights bend that may pull against each other"
    not_convex = "is what two weights bend that may pull against each other"
    rough = "is what two weights bend that may pull against each other, and has a kink where it is nothing"

    def value(self, model: Model, x: FloatArray) -> float:
        down = sag(model, x)
        if down is None:
            return float("inf")
        return abs(float(self.row @ down) * float(self.pulled.at(x)) + float(self.own.at(x)))

    def acting(self, model: Model) -> FloatArray:
        return np.vstack([UnderWeights.acting(self, model), self.pulled.exponents, self.own.exponents])

    def held(self, x: FloatArray, free: list[int]) -> StaticMoment:
        return StaticMoment(self.row, self.pulled.held(x, free), self.own.held(x, free))

    def on_points(self, at: FormBounds, x: FloatArray) -> Bounds:
        value = np.abs(self.squeezed(at, self.row, x) * self.pulled.at(x) + self.own.at(x))
        return value, value


@dataclass(frozen=True, slots=True)
class StaticForce(UnderWeights):
    """Force of some springs under the weights alone, with its sign: sum_t signs_t p_t b_t . u [N], u downward."""

    signs: FloatArray
    signed = True
    solved_directly = True
    no_bounds = "is a static force with its sign: bounds of its size do not tell the sign"
    not_convex = "is a static force with its sign, which is not convex in the stiffnesses"
    rough = "is a static force with its sign, which is no power of the variables and may be zero"

    def value(self, model: Model, x: FloatArray) -> float:
        down = sag(model, x)
        if down is None:
            return float("inf")
        return float((self.signs * model.values(x, static=True)) @ (model.vectors @ down))

    def reading(self, model: Model) -> tuple[FloatArray, FloatArray]:
        return self.signs, np.zeros(model.n_coords)

    def reach(self, model: Model) -> Reach:
        return weighed(model, [model.vectors[t] for t in np.flatnonzero(self.signs)])

    def room(self, model: Model, x: FloatArray, value: float, other: float, rounding: float) -> float:
        return self._carried(model, x, rounding)

    def on_points(self, at: FormBounds, x: FloatArray) -> Bounds:
        model = at.model
        squeezed = sags_at(model, x) @ model.vectors[:, : model.n_free].T
        found: FloatArray = ((model.values(x, static=True) * self.signs) * squeezed).sum(axis=-1)
        return found, found


@dataclass(frozen=True, slots=True)
class StaticBending(StaticForce):
    """What bends a shaft under the weights: |factor(x) sum_t signs_t p_t b_t . u|, of one monomial [Pa]."""

    factor: Monomials
    signed = False
    no_bounds = "is what weights bend that may pull against each other"
    not_convex = no_bounds
    rough = "is what weights bend that may pull against each other, and has a kink where it is nothing"

    def value(self, model: Model, x: FloatArray) -> float:
        return abs(StaticForce.value(self, model, x)) * float(self.factor.at(x))

    def acting(self, model: Model) -> FloatArray:
        return np.vstack([UnderWeights.acting(self, model), self.factor.exponents])

    def held(self, x: FloatArray, free: list[int]) -> StaticBending:
        return StaticBending(self.signs, self.factor.held(x, free))

    def room(self, model: Model, x: FloatArray, value: float, other: float, rounding: float) -> float:
        return self._carried(model, x, rounding) * float(self.factor.at(x))

    def on_points(self, at: FormBounds, x: FloatArray) -> Bounds:
        value = np.abs(StaticForce.on_points(self, at, x)[0]) * self.factor.at(x)
        return value, value
