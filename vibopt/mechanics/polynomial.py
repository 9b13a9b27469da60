"""Roots of polynomials, ascending coefficients, by their companion matrix."""

from __future__ import annotations

import numpy as np

from vibopt.forms import ComplexArray, FloatArray


def roots(ascending: FloatArray) -> ComplexArray:
    """Roots of a polynomial (degree + 1,); those at zero are left out, and all are nan where it has no digits."""
    used = np.flatnonzero(ascending)
    if len(used) < 2:
        return np.zeros(0, dtype=complex)
    rows = ascending[used[0] : used[-1] + 1]
    n = len(rows) - 1
    companion = np.zeros((n, n))
    companion[0] = -rows[-2::-1] / rows[-1]
    companion[np.arange(1, n), np.arange(n - 1)] = 1.0
    if not np.isfinite(companion).all():
        return np.full(n, np.nan, dtype=complex)
    return np.asarray(np.linalg.eigvals(companion), dtype=complex)


def real_roots(ascending: FloatArray, near: float, steps: int, least: float = 0.0) -> FloatArray:
    """Real roots of a polynomial, polished by Newton's rule.

    Parameters
    ----------
    ascending
        Coefficients, shape (degree + 1,).
    near
        Imaginary part over the size of a root up to which it counts as real.
    steps
        Of Newton's rule.
    least
        Size that a small root is taken to have for that.
    """
    every = roots(ascending)
    real = every[np.abs(every.imag) <= near * np.maximum(np.abs(every.real), least)].real
    for _ in range(steps):
        value, slope = np.zeros(len(real)), np.zeros(len(real))
        for one in ascending[::-1].tolist():
            value, slope = value * real + one, slope * real + value
        real = real - np.divide(value, slope, out=np.zeros(len(real)), where=slope != 0.0)
    if len(ascending) > 1 and ascending[0] == 0.0 and ascending.any():
        real = np.append(real, 0.0)
    found: FloatArray = real
    return found


__all__ = ["real_roots", "roots"]
