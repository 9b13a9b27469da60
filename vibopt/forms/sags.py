"""What springs do under the weights alone, with static stiffness."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.form import Form, bend_of_slopes
from vibopt.forms.monomials import Monomials
from vibopt.records import dataclass

if TYPE_CHECKING:
    from vibopt.forms.reduce import Reach
    from vibopt.mechanics.model import Model


@dataclass(frozen=True, slots=True)
class StaticRow(Form):
    """Response under the weights alone, static stiffness: row . u [m]."""

    row: FloatArray

    def value(self, model: Model, x: FloatArray) -> float:
        from vibopt.mechanics.modes import sag

        down = sag(model, x)
        return float("inf") if down is None else float(abs(self.row @ down))

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        from vibopt.mechanics.modes import sag_slope

        return sag_slope(model, self.row, x)

    def reach(self, model: Model) -> Reach:
        from vibopt.forms.reduce import weighed

        return weighed(model, [self.row])

    def bend(self, model: Model, x: FloatArray) -> FloatArray:
        return bend_of_slopes(self, model, x)


@dataclass(frozen=True, slots=True)
class StaticLoad(Form):
    """Static force of one mount under the weights alone, as a part of what it is rated for: factor(x) * |row . u|.

    `factor` is one monomial: static stiffness of one mount over its rating.  `signed` keeps the sign of row . u:
    a mount that is lifted has a force below zero.
    """

    row: FloatArray
    factor: Monomials
    signed: bool = False

    def value(self, model: Model, x: FloatArray) -> float:
        from vibopt.mechanics.modes import sag

        down = sag(model, x)
        if down is None:
            return float("inf")
        squeezed = float(self.row @ down)
        return (squeezed if self.signed else abs(squeezed)) * float(self.factor.at(x))

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        from vibopt.mechanics.modes import sag_slope

        return sag_slope(model, self.row, x) + self.factor.slope(model, x)


@dataclass(frozen=True, slots=True)
class StaticForce(Form):
    """Force of some springs under the weights alone, with its sign: sum_t signs_t p_t b_t . u [N], u downward."""

    signs: FloatArray

    def value(self, model: Model, x: FloatArray) -> float:
        from vibopt.mechanics.modes import sag

        down = sag(model, x)
        if down is None:
            return float("inf")
        return float((self.signs * model.values(x, static=True)) @ (model.vectors @ down))

    def reach(self, model: Model) -> Reach:
        from vibopt.forms.reduce import weighed

        return weighed(model, [model.vectors[t] for t in np.flatnonzero(self.signs)])
