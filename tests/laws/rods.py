"""Rods and beams of finite elements, with exact answers of their own recurrences in many digits."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import scipy.sparse as sparse

from vibopt.mechanics.host import Matrices

ROD = {"length": 10.0, "stiffness": 2e9, "mass": 80.0}
"""Length [m], E A [N], mass per length [kg/m]; held at the left end, free at the right."""


def rod(n: int, *, mass_damping: float = 0.0, stiffness_damping: float = 0.0, held: bool = True) -> Matrices:
    """n linear elements with consistent mass; coordinate i is node i + 1 (node i of a free rod)."""
    piece = ROD["length"] / n
    k, m = ROD["stiffness"] / piece, ROD["mass"] * piece / 6.0
    count = n if held else n + 1
    ends = np.full(count, 2.0)
    ends[-1] = 1.0
    if not held:
        ends[0] = 1.0
    off = np.ones(count - 1)
    stiffness = sparse.diags_array([k * ends, -k * off, -k * off], offsets=[0, 1, -1]).tocsc()
    mass = sparse.diags_array([2.0 * m * ends, m * off, m * off], offsets=[0, 1, -1]).tocsc()
    damping = (mass_damping * mass + stiffness_damping * stiffness).tocsc()
    damping.eliminate_zeros()
    return Matrices(mass, damping, stiffness)


def rod_receptance(n: int, node: int, omega: float) -> float:
    """Displacement of a node per force at the free end [m/N], from u_i = A sin(i theta) in 40 digits."""
    with mpmath.workdps(40):
        piece = mpmath.mpf(ROD["length"]) / n
        k, m = mpmath.mpf(ROD["stiffness"]) / piece, mpmath.mpf(ROD["mass"]) * piece / 6 * mpmath.mpf(omega) ** 2
        if omega == 0.0:
            return float(node / k)
        angle = mpmath.acos((k - 2 * m) / (k + m))
        size = (k - 2 * m) * mpmath.sin(n * angle) - (k + m) * mpmath.sin((n - 1) * angle)
        return float(mpmath.re(mpmath.sin(node * angle) / size))


BEAM = {"length": 3.0, "stiffness": 2.1e5, "mass": 15.0}
"""Length [m], E I [N m^2], mass per length [kg/m]; a cantilever."""


def beam(n: int) -> Matrices:
    """n Euler beam elements; the deflection of the tip is coordinate 2 n - 2."""
    e = BEAM["length"] / n
    stiff = np.array(
        [
            [12, 6 * e, -12, 6 * e],
            [6 * e, 4 * e * e, -6 * e, 2 * e * e],
            [-12, -6 * e, 12, -6 * e],
            [6 * e, 2 * e * e, -6 * e, 4 * e * e],
        ]
    )
    heavy = np.array(
        [
            [156, 22 * e, 54, -13 * e],
            [22 * e, 4 * e * e, 13 * e, -3 * e * e],
            [54, 13 * e, 156, -22 * e],
            [-13 * e, -3 * e * e, -22 * e, 4 * e * e],
        ]
    )
    stiffness = _assembled(n, stiff * BEAM["stiffness"] / e**3)
    mass = _assembled(n, heavy * BEAM["mass"] * e / 420.0)
    return Matrices(mass, sparse.csc_array(mass.shape), stiffness)


def _assembled(n: int, element: Any) -> Any:
    at = 2 * np.arange(n)[:, None] + np.arange(4)
    rows, columns = np.repeat(at, 4, axis=1).ravel(), np.tile(at, (1, 4)).ravel()
    whole = sparse.coo_array((np.tile(element.ravel(), n), (rows, columns))).tocsc()
    return whole[2:, 2:].tocsc()
