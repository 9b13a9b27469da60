"""From which spin on the whirl of a rotor grows."""

from __future__ import annotations

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.form import Form
from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS, Model
from vibopt.mechanics.modes import free_matrices
from vibopt.mechanics.whirl import rotor_threshold, threshold
from vibopt.records import dataclass


@dataclass(frozen=True, slots=True)
class WhirlThreshold(Form):
    """Least spin [rad/s] beyond which a whirl grows; infinite where none does."""

    no_bounds = "is a threshold of whirl: the poles of what spins have no bounds on boxes of designs"
    not_convex = "is a threshold of whirl, which is not convex in stiffness and damping"
    rough = "is the least threshold of several whirls, which has a kink where two of them are equal"

    def acting(self, model: Model) -> FloatArray:
        rows = [term.exponents for term in model.rotating]
        own = model.exponents[np.isin(model.kinds, (STIFFNESS, INERTIA, DAMPING))]
        return np.vstack([own, *rows])

    def value(self, model: Model, x: FloatArray) -> float:
        p = model.values(x)
        mass, damping, stiffness, _ = free_matrices(model, p)
        if model.spins:
            turns = np.array([term.polar for term in model.terms])
            polar = -model.matrix(INERTIA, np.where(turns, p, 0.0))[: model.n_free, : model.n_free]
            return rotor_threshold(mass + polar, polar, damping, model.turning(x), stiffness)
        return threshold(mass, damping, model.turning(x), stiffness)
