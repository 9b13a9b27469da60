"""Root mean square of a response under white noise."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vibopt.forms.form import Form
from vibopt.forms.rational import Groups
from vibopt.records import dataclass
from vibopt.signals import Noise, Output

if TYPE_CHECKING:
    from vibopt.arrays import FloatArray
    from vibopt.forms.bounds import FormBounds
    from vibopt.forms.form import Bounds
    from vibopt.forms.reduce import Reach
    from vibopt.mechanics.model import Model

_MANY = 8
"""Designs from which on all together take less."""


@dataclass(frozen=True, slots=True)
class RootMeanSquare(Form):
    """Root of the mean square of a response under independent white noises."""

    output: Output
    noises: tuple[Noise, ...]
    random = True
    no_bounds = (
        "is a mean square under white noise of more than four coordinates or three numbers, "
        "or one that its boxes bound too loosely in the work allowed"
    )
    not_convex = "is a mean square under white noise, which is not convex in stiffness and damping"
    rough = "is a mean square under white noise: not a row for each speed but a matrix equation"

    def value(self, model: Model, x: FloatArray) -> float:
        from vibopt.forms.mean_square import root_mean_square

        return root_mean_square(model, self, x)

    def values(self, model: Model, x: FloatArray, *, least_wanted: bool = False) -> FloatArray:
        """Of many designs at once; those that this leaves in doubt, and few of them, one by one."""
        from vibopt.forms.mean_square_on_boxes import at_designs

        if len(x) < _MANY or not self.bounded(model):
            return Form.values(self, model, x, least_wanted=least_wanted)
        found = at_designs(self, model, x)
        for i in np.flatnonzero(np.isnan(found)):
            found[i] = self.value(model, x[i])
        return found

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        from vibopt.forms.mean_square import root_mean_square_slope

        return root_mean_square_slope(model, self, x)

    def room(self, model: Model, x: FloatArray, value: float, other: float, rounding: float) -> float:
        """What all states together hardly leave of a reading is rounding of theirs."""
        from vibopt.forms.mean_square import LOST, reached

        known = Form.room(self, model, x, value, other, rounding)
        if not 0.0 <= max(value, other) < np.inf:
            return known
        parts = (rounding if value else max(rounding, float(np.sqrt(LOST)))) * reached(model, self, x)
        return max(known, parts if max(value, other) <= parts else 0.0)

    def groups(self, model: Model) -> Groups:
        return Groups.of(model, self.output.signs)

    def bounded(self, model: Model) -> bool:
        from vibopt.forms.mean_square_on_boxes import bounded

        return bounded(self, model)

    def on_boxes(self, known: FormBounds, low: FloatArray, high: FloatArray) -> Bounds:
        from vibopt.forms.mean_square_on_boxes import on_boxes

        return on_boxes(self, known, low, high)

    def reach(self, model: Model) -> Reach:
        from vibopt.forms.reduce import driven

        return driven(model, self.output, [noise.vector for noise in self.noises])
