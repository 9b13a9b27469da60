"""Deflection under the weights."""

from __future__ import annotations

import numpy as np

from vibopt.forms import FloatArray
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.model import STIFFNESS, Model


def sag(model: Model, x: FloatArray) -> FloatArray | None:
    """Displacement under all weights [m], shape (n_coords,); None where nothing holds the machine."""
    n = model.n_free
    p = model.values(x, static=True)
    stiff = model.matrix(STIFFNESS, p)[:n, :n]
    load = model.weights(p)[:n] * GRAVITY
    root = np.sqrt(np.abs(np.diag(stiff)))
    if not np.all(root > 0.0):
        return None
    scaled = stiff / np.outer(root, root)
    if np.linalg.cond(scaled) > 1e14:
        return None
    down = np.zeros(model.n_coords)
    down[:n] = np.linalg.solve(scaled, load / root) / root
    return down
