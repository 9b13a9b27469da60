"""From where on the free motion of what depends on one number grows: by steps that are sure."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.bracketing import crossing

_NOTHING = 1e-10
"""Part of the unit of rates below which a growth is rounding, of a motion that nothing damps."""
_SURE, _LEAST, _NEAR = 0.9, 0.05, 1e-9
"""Part of a sure step that is taken; the least step over the unit, where hardly anything is damped; part of itself by
which the number is known, which is solved for all states from there."""


def first_growth(first: ComplexArray, slope: ComplexArray, low: float, high: float, unit: float) -> float | None:
    """Least number w from `low` to `high` beyond which a motion of x' = (first + w slope) x grows; None where none is.

    With rates L and vectors V of A at w, A at w + d stays stable while Re L + d (V^-1 slope V + its adjoint) / 2 is
    negative: the squares of its motions in V then fall.  So a step as long as that steps over no growth; within a
    longer one, where hardly anything is damped, a summit is looked for.

    Parameters
    ----------
    first, slope
        Over states whose squares add up to an energy, (n, n).
    unit
        A rate that is slow and a number that is small: the lowest frequency at rest [rad/s].
    """
    at, before, none = low, low, _NOTHING * unit
    ahead, sure = 0.0, True

    def growth(at: float) -> float:
        return float(np.linalg.eigvals(first + at * slope).real.max()) - none

    while True:
        rates, ways = np.linalg.eig(first + at * slope)
        top = int(rates.real.argmax())
        if rates[top].real > none:
            return low if at == low else crossing(growth, before, at, _NEAR)[1]
        back = np.linalg.solve(ways, slope @ ways)
        if not sure and ahead > 0.0 > back[top, top].real and (between := _summit(growth, before, at)):
            return crossing(growth, before, between, _NEAR)[1]
        if at >= high:
            return None
        room = 1.0 / np.sqrt(none - np.minimum(rates.real, 0.0))
        most = float(np.linalg.eigvalsh(0.5 * (back + back.conj().T) * np.outer(room, room))[-1])
        before, sure = at, most * _LEAST * unit <= _SURE
        at = min(at + max(_SURE / most, _LEAST * unit), high) if most > 0.0 else high
        ahead = float(rates[top].real - none + (at - before) * back[top, top].real)


def _summit(growth: Callable[[float], float], low: float, high: float) -> float:
    """Where something grows between two numbers at which nothing does; 0 where nothing does there."""
    from scipy.optimize import minimize_scalar

    found = minimize_scalar(lambda at: -growth(at), bounds=(low, high), method="bounded")
    return float(found.x) if found.fun < 0.0 else 0.0


def states(squares: FloatArray, damping: ComplexArray, extra: ComplexArray) -> ComplexArray:
    """Rates (2 n, 2 n) of w q and q', whose squares are an energy, of q'' + damping q' + (diag(w^2) + extra) q = 0."""
    size = np.sqrt(squares)
    zero = np.zeros((len(size), len(size)), dtype=complex)
    return np.block([[zero, np.diag(size)], [-np.diag(size) - extra / size, -damping]])
