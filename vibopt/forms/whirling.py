"""From which spin on the whirl of a rotor grows."""

from __future__ import annotations

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.form import Form
from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS, Model
from vibopt.mechanics.modes import free_matrices
from vibopt.mechanics.orbits import spun
from vibopt.mechanics.whirl import rotor_threshold, threshold
from vibopt.records import dataclass


@dataclass(frozen=True, slots=True)
class WhirlThreshold(Form):
    """Least spin [rad/s] beyond which a whirl grows; infinite where none does.

    top
        Highest spin that is looked at of a rotor in bearings that are not alike in both planes [rad/s]; 0 where nobody
        says one.
    """

    top: float = 0.0
    no_bounds = "is a threshold of whirl: the poles of what spins have no bounds on boxes of designs"
    not_convex = "is a threshold of whirl, which is not convex in stiffness and damping"
    rough = "is the least threshold of several whirls, which has a kink where two of them are equal"

    def acting(self, model: Model) -> FloatArray:
        rows = [term.exponents for term in model.rotating]
        rows += [power.row(model.n_vars) for bearing in model.bearings for power in bearing.powers]
        own = model.exponents[np.isin(model.kinds, (STIFFNESS, INERTIA, DAMPING))]
        return np.vstack([own, *rows])

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        return np.zeros(len(x)) if np.isinf(self.value(model, x)) else Form.slope(self, model, x)

    def value(self, model: Model, x: FloatArray) -> float:
        if model.bearings:
            return spun(model, x).threshold(self.top)
        p = model.values(x)
        mass, damping, stiffness, _ = free_matrices(model, p)
        if model.spins:
            turns = np.array([term.polar for term in model.terms])
            polar = -model.matrix(INERTIA, np.where(turns, p, 0.0))[: model.n_free, : model.n_free]
            return rotor_threshold(mass + polar, polar, damping, model.turning(x), stiffness)
        return threshold(mass, damping, model.turning(x), stiffness)
