"""Poles of free vibration as functions of the design: each with its slope, and the polynomial whose roots they are."""

from __future__ import annotations

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.forms import DecayRate, ModeDamping
from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS, Model
from vibopt.mechanics.modes import decay_rates, free_matrices, rigid_count

_NEAR = 2.0
"""Poles with up to so many times the least decay rate (damping ratio) are pieces of their own."""


def rates_and_shapes(model: Model, p: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """Rates s of free motion e^{s t} [1/s] (m,) with Im s >= 0 and no rigid motion, and shapes (n_free, m)."""
    mass, damping, stiffness, _ = free_matrices(model, p)
    n = model.n_free
    root = np.linalg.inv(np.linalg.cholesky(mass))
    k, c = root @ stiffness @ root.T, root @ damping @ root.T
    scale = float(np.sqrt(np.abs(k).max()) or np.abs(c).max() or 1.0)
    state = np.block([[np.zeros((n, n)), np.eye(n)], [-k / scale**2, -c / scale]])
    rates, vectors = np.linalg.eig(state)
    order = np.argsort(np.abs(rates))[rigid_count(model, p) :]
    chosen = order[rates[order].imag >= 0.0]
    return (rates[chosen] * scale).astype(complex), (root.T @ vectors[:n, chosen]).astype(complex)


def pole_slopes(model: Model, x: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """Rates of free motion (m,) and their slopes in log x (m, n_vars); large where two poles nearly meet."""
    p = model.values(x)
    rates, shapes = rates_and_shapes(model, p)
    share = (model.vectors[:, : model.n_free] @ shapes) ** 2
    power = np.select([model.kinds == INERTIA, model.kinds == DAMPING, model.kinds == STIFFNESS], [2, 1, 0], 0)
    each = share.T * p * rates[:, None] ** power
    with np.errstate(divide="ignore", invalid="ignore"):
        slopes = -(each @ model.exponents) / ((power * each).sum(axis=1) / rates)[:, None]
    return rates, np.nan_to_num(slopes)


def pole_pieces(model: Model, form: DecayRate | ModeDamping, x: FloatArray) -> list[tuple[float, FloatArray, float]]:
    """Decay rate (damping ratio) of every pole near the least, its slope in log x, and |s|; the least first."""
    if isinstance(form, ModeDamping) and form.mode > 1:
        return []
    rates, slopes = pole_slopes(model, x)
    size = np.abs(rates)
    if isinstance(form, DecayRate):
        values, changes = -rates.real, -slopes.real
        if len(values):
            values = np.maximum(values, decay_rates(model, model.values(x)).min())
    else:
        turning = rates.imag > 1e-9 * size
        rates, slopes, size = rates[turning], slopes[turning], size[turning]
        values = -rates.real / size
        along = (np.conj(rates)[:, None] * slopes).real / size[:, None] ** 2
        changes = -slopes.real / size[:, None] - values[:, None] * along
    if not len(values) or (isinstance(form, ModeDamping) and values.min() > 1.0 - 1e-9):
        return []
    order = [i for i in np.argsort(values) if values[i] <= _NEAR * values.min()]
    return [(float(values[i]), changes[i], float(size[i])) for i in order]


def characteristic(model: Model, p: FloatArray, scale: float) -> FloatArray:
    """Coefficients of det(s^2 M + s C + K) in s / scale, ascending, the last of them 1; shape (2 n_free + 1,)."""
    mass, damping, stiffness, _ = free_matrices(model, p)
    n = model.n_free
    root = np.linalg.inv(np.linalg.cholesky(mass))
    k, c = root @ stiffness @ root.T / scale**2, root @ damping @ root.T / scale
    circle = np.exp(2j * np.pi * np.arange(2 * n + 1) / (2 * n + 1))[:, None, None]
    values = np.linalg.det(circle**2 * np.eye(n) + circle * c + k)
    found: FloatArray = (np.fft.fft(values) / (2 * n + 1)).real
    return found


__all__ = ["characteristic", "pole_pieces", "pole_slopes", "rates_and_shapes"]
