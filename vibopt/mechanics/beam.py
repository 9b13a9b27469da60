"""Deflection of a beam under a load, from two finite elements that meet under it; exact for point loads."""

from __future__ import annotations

import numpy as np

from vibopt.forms import FloatArray

_HELD = {
    "simply_supported": (0, 4),
    "cantilever": (0, 1),
    "fixed": (0, 1, 4, 5),
    "fixed_pinned": (0, 1, 4),
}
"""Of deflection and slope at the left end, the load and the right end (0 to 5), those that the supports hold."""


def sag_under_load(kind: str, length: float, at: float, bending: float) -> float:
    """Deflection per force where the load stands [m/N].

    Parameters
    ----------
    kind
        "simply_supported", "cantilever", "fixed" or "fixed_pinned".
    length, at
        Of the beam, and place of the load from its left end [m]; `at` = `length` is the free tip.
    bending
        Modulus times second moment of area [N m^2].
    """
    if at >= length:
        return float(np.linalg.solve(_element(length)[2:, 2:], [1.0, 0.0])[0] / bending)
    stiff = np.zeros((6, 6))
    stiff[:4, :4] += _element(at)
    stiff[2:, 2:] += _element(length - at)
    free = [i for i in range(6) if i not in _HELD[kind]]
    load = np.array([float(i == 2) for i in free])
    return float(np.linalg.solve(stiff[np.ix_(free, free)], load)[free.index(2)] / bending)


def _element(length: float) -> FloatArray:
    """Stiffness of a beam element of unit bending stiffness: deflection and slope at both ends, (4, 4)."""
    a = length
    table = [[12.0, 6 * a, -12.0, 6 * a], [6 * a, 4 * a * a, -6 * a, 2 * a * a],
             [-12.0, -6 * a, 12.0, -6 * a], [6 * a, 2 * a * a, -6 * a, 4 * a * a]]  # fmt: skip
    return np.array(table) / a**3
