"""From where on the free motion of what depends on one number grows: by steps that are sure."""

from __future__ import annotations

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.bracketing import crossing

_NOTHING = 1e-10
"""Part of the unit of rates below which a growth is rounding, of a motion that nothing damps."""
_SURE, _LEAST = 0.9, 0.05
"""Part of a sure step that is taken, and the least step over the unit, where hardly anything is damped."""


def first_growth(first: ComplexArray, slope: ComplexArray, low: float, high: float, unit: float) -> float | None:
    """Least number w from `low` to `high` beyond which a motion of x' = (first + w slope) x grows; None where none is.

    With rates L and vectors V of A at w, A at w + d stays stable while Re L + d (V^-1 slope V + its adjoint) / 2 is
    negative: the squares of its motions in V then fall.  So a step as long as that steps over no growth.

    Parameters
    ----------
    first, slope
        Over states whose squares add up to an energy, (n, n).
    unit
        A rate that is slow and a number that is small: the lowest frequency at rest [rad/s].
    """
    at, before, none = low, low, _NOTHING * unit

    def growth(at: float) -> float:
        return float(np.linalg.eigvals(first + at * slope).real.max()) - none

    while True:
        rates, ways = np.linalg.eig(first + at * slope)
        if rates.real.max() > none:
            return low if at == low else crossing(growth, before, at)[1]
        if at >= high:
            return None
        back = np.linalg.solve(ways, slope @ ways)
        room = 1.0 / np.sqrt(none - np.minimum(rates.real, 0.0))
        most = float(np.linalg.eigvalsh(0.5 * (back + back.conj().T) * np.outer(room, room))[-1])
        before = at
        at = min(at + max(_SURE / most, _LEAST * unit), high) if most > 0.0 else high


def states(squares: FloatArray, damping: ComplexArray, extra: ComplexArray) -> ComplexArray:
    """Rates (2 n, 2 n) of w q and q', whose squares are an energy, of q'' + damping q' + (diag(w^2) + extra) q = 0."""
    size = np.sqrt(squares)
    zero = np.zeros((len(size), len(size)), dtype=complex)
    return np.block([[zero, np.diag(size)], [-np.diag(size) - extra / size, -damping]])
