"""Forms that few machines ask for: free vibration, signed static forces, gaps between modes, shares of energy."""

from __future__ import annotations

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms import EnergyShare, FreeMotion, ModeGap, ModeRatio, StaticForce
from vibopt.mechanics.free_motion import shape_ratio
from vibopt.mechanics.model import INERTIA, Model
from vibopt.mechanics.modes import free_matrices, mode_shapes, natural_frequencies, sag


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


TOGETHER = 1e-6
"""Relative distance of natural frequencies below which modes count as one."""


def spatial_value(model: Model, form: StaticForce | ModeGap | EnergyShare, x: FloatArray) -> float:
    """Value of such a form at design x (n_vars,)."""
    if isinstance(form, StaticForce):
        down = sag(model, x)
        if down is None:
            return float("inf")
        return float((form.signs * model.values(x, static=True)) @ (model.vectors @ down))
    p = model.values(x)
    if isinstance(form, ModeGap):
        return float(np.diff(natural_frequencies(model, p)).min(initial=np.inf))
    return energy_share(model, p, form.row)


def energy_share(model: Model, p: FloatArray, row: FloatArray) -> float:
    """The greatest part of kinetic energy that any mode, or modes of one frequency, has in a motion (n_coords,)."""
    n = model.n_free
    omega, shapes = mode_shapes(model, p)
    moved = row[:n] @ shapes
    pushed = row[:n] @ model.matrix(INERTIA, np.where(model.across, 0.0, p))[:n, :n] @ shapes
    best = 0.0
    for group in together(omega):
        share = np.outer(moved[group], pushed[group])
        best = max(best, float(np.linalg.eigvalsh(0.5 * (share + share.T))[-1]))
    return best


def together(omega: FloatArray) -> list[list[int]]:
    """Indices of modes, those of one frequency as one group; omega ascending."""
    groups: list[list[int]] = []
    for index, one in enumerate(omega):
        if groups and one - omega[groups[-1][-1]] <= TOGETHER * one:
            groups[-1].append(index)
        else:
            groups.append([index])
    return groups
