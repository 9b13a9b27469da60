"""The characteristic polynomial of a machine, D(s) = sum a_j s^j, on boxes of designs.

The a_j are multi-affine in the impedances, and so polynomials in the variables: Bernstein coefficients bound them, and
what is made of them by sums and products, on a box.
"""

from __future__ import annotations

from itertools import product
from math import comb

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.forms.rational import Groups, to_bernstein
from vibopt.mechanics.model import INERTIA, STIFFNESS, Model

_NOTHING = 1e-9
"""Part of the greatest natural frequency squared below which nothing is held."""
ROUNDING = 50.0 * float(np.finfo(float).eps)
"""Part of a sum of products that rounding may take."""


def typical_rate(model: Model, x: FloatArray) -> float:
    """A typical natural frequency [rad/s]: s is counted in it."""
    n, p = model.n_free, model.values(x)
    mass, stiff = (model.matrix(kind, p)[:n, :n] for kind in (INERTIA, STIFFNESS))
    squares = np.linalg.eigvals(np.linalg.solve(mass, stiff)).real
    held = squares[squares > _NOTHING * squares.max()]
    return float(np.exp(0.5 * np.log(held).mean())) if len(held) else 1.0


def circle(model: Model, rate: float) -> ComplexArray:
    """Frequencies [rad/s] with s on a circle of a radius of one rate, enough for N and D of a machine."""
    count = 2 * model.n_free + 4
    return np.asarray(-1j * rate * np.exp(2j * np.pi * np.arange(count) / count))


def powers(values: ComplexArray) -> FloatArray:
    """Numbers of polynomials by ascending powers of s / rate, from values on the circle (..., n): (..., n)."""
    return np.asarray(np.fft.fft(values).real / values.shape[-1], dtype=float)


def nodes(groups: Groups, low: FloatArray, high: FloatArray) -> FloatArray:
    """Designs on boxes low, high (n_boxes, n_vars) from which `tables` are made, (n_boxes, n_nodes, n_vars)."""
    grid = np.array(
        list(product(*[np.linspace(0.0, 1.0, degree + 1) if degree else [0.0] for degree in groups.degrees]))
    )
    ends = low ** (1.0 / groups.roots), high ** (1.0 / groups.roots)
    return np.asarray((ends[0][:, None] + (ends[1] - ends[0])[:, None] * grid) ** groups.roots)


def tables(values: FloatArray, groups: Groups) -> FloatArray:
    """Numbers at the nodes (n_boxes, n_nodes, m) as Bernstein coefficients times binomials, (m, n_boxes, ...).

    One axis a variable: so a product of two is a convolution.
    """
    table = np.moveaxis(values, -1, 0).reshape(-1, len(values), *(degree + 1 for degree in groups.degrees))
    for axis, degree in enumerate(groups.degrees, 2):
        change = to_bernstein(degree) * np.array([comb(degree, k) for k in range(degree + 1)])[:, None]
        table = np.moveaxis(np.tensordot(table, change, axes=(axis, 1)), -1, axis)
    return np.asarray(table)


def plain(one: FloatArray) -> FloatArray:
    """Bernstein coefficients alone, (n_boxes, n_coefficients)."""
    for axis, size in enumerate(one.shape[1:], 1):
        binomials = np.array([float(comb(size - 1, k)) for k in range(size)])
        one = one / binomials.reshape(-1, *[1] * (one.ndim - 1 - axis))
    return one.reshape(len(one), -1)
