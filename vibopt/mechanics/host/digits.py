"""How many digits of a structure's receptances its matrices really hold."""

from __future__ import annotations

import numpy as np

from vibopt.mechanics.host.matrices import Matrices, solve
from vibopt.records import dataclass

_HALF_DIGIT = 2.0**-53


@dataclass(frozen=True, slots=True)
class Lost:
    """Relative errors of the receptances of the points.

    rounding
        From rounding each entry of the stiffness matrix once, root of mean square: what the file cannot say.
    arithmetic
        Of a plain sparse solution, and `refined` of one with residuals in long doubles.
    place
        The coordinate that it shows at.
    """

    rounding: float
    arithmetic: float
    refined: float
    place: int

    @property
    def worst(self) -> float:
        return max(self.rounding, self.refined)


def digits_lost(matrices: Matrices, places: list[int], omega: float) -> Lost:
    """Digits lost at standstill, or beside it at omega [rad/s] where nothing holds the structure.

    Notes
    -----
    u solves K u = f.  A change dK of the matrix moves the receptance f.u by u.dK.u; with independent
    rounding of every entry that is a root of a sum of squares.  No norm is estimated, so a structure
    whose norm-wise condition is bad but whose points do not feel it passes.
    """
    loads = matrices.units(np.array(places, dtype=np.intp))
    try:
        found = solve(matrices, loads, 0.0)
    except RuntimeError:
        found = solve(matrices, loads, 0.0, shift=omega**2)
    motion = np.asarray(found.motion, dtype=float)
    moved = motion[places, np.arange(len(places))]
    squared = matrices.stiffness.copy()
    squared.data = squared.data**2
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        sums = np.einsum("ij,ij->j", motion**2, squared @ motion**2)
        rounding = _HALF_DIGIT / np.sqrt(3.0) * np.sqrt(np.abs(sums)) / np.abs(moved)
    rounding = np.nan_to_num(rounding, nan=np.inf)
    worst = int(rounding.argmax())
    return Lost(float(rounding[worst]), found.plain, found.left, places[worst])
