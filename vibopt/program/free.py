"""Free vibration of a model: ratios in a mode, and motion some time after it is let go."""

from __future__ import annotations

import numpy as np

from vibopt.forms import FloatArray, FreeMotion, ModeRatio
from vibopt.mechanics.free import shape_ratio
from vibopt.mechanics.model import Model
from vibopt.mechanics.modes import free_matrices, mode_shapes


def free_value(model: Model, form: ModeRatio | FreeMotion, p: FloatArray) -> float:
    """Value of such a form, with its sign, at coefficients p (n_terms,)."""
    n = model.n_free
    if isinstance(form, ModeRatio):
        return shape_ratio(*mode_shapes(model, p), form.mode, form.of[:n], form.to[:n])
    from scipy.linalg import expm

    mass, damping, stiffness, _ = free_matrices(model, p)
    root = np.linalg.cholesky(mass)
    inverse = np.linalg.inv(root)
    own, drag = inverse @ stiffness @ inverse.T, inverse @ damping @ inverse.T
    rate = float(np.sqrt(np.abs(own).max(initial=0.0))) or 1.0
    state = np.block([[np.zeros((n, n)), rate * np.eye(n)], [-own / rate, -drag]])
    started = np.concatenate([root.T @ form.displacements, root.T @ form.velocities / rate])
    return float(form.row[:n] @ inverse.T @ (expm(form.after * state) @ started)[:n])
