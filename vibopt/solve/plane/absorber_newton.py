"""One absorber by Newton on its equal peaks, from the optimum without damping: a candidate for the proof, and no more.

At the optimum of one absorber two peaks are equally high, and the slopes of their heights in stiffness and damping
point against each other.  Nothing is claimed here: that the point is best is shown by the rows of all designs.
"""

from __future__ import annotations

from math import inf, sqrt

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.few import few_peaks, followed
from vibopt.mechanics.model import INERTIA, STIFFNESS
from vibopt.program.program import Aim
from vibopt.solve.plane.link_plane import LinkPlane

_STEPS = 20
_LONGEST = 0.3
_SQUARED = 1e-7
"""A step of Newton this short leaves nothing: the next is as short as its square."""
_ROUNDING = 1e-13
_COUNTED = 0.5
"""Part of the higher peak that the other must have."""
_HELD = 1e-9
_MATRICES = INERTIA, STIFFNESS


def equal_peaks(plane: LinkPlane) -> FloatArray | None:
    """A design (n_vars,) at which two peaks of the goal are equally high and no direction lowers both.

    None where the link holds no absorber on a machine of two coordinates, or Newton leads nowhere within the ranges.
    """
    aim = plane.program.aim
    form = aim.form.harmonic if aim is not None else None
    if aim is None or form is None or aim.sense < 0.0 or aim.others or plane.other >= 0:
        return None
    x = _undamped(plane, aim)
    found = None if x is None else few_peaks(aim.model, form, form.drives[0], x, _COUNTED)
    if x is None or found is None:
        return None
    for _ in range(_STEPS):
        if found is None or len(found) != 2:
            return None
        first, second = found
        apart = first.slope - second.slope
        size = float(apart @ apart)
        part = float(np.clip(-(second.slope @ apart) / size, 0.0, 1.0)) if size else 0.5
        matrix = np.zeros((3, 3))
        matrix[:2, :2] = part * first.bend + (1.0 - part) * second.bend
        matrix[:2, 2] = matrix[2, :2] = apart
        slope = part * first.slope + (1.0 - part) * second.slope
        try:
            step = np.linalg.solve(matrix, -np.append(slope, np.log(first.at.value / second.at.value)))[:2]
        except np.linalg.LinAlgError:
            return None
        longest = float(np.abs(step).max())
        if longest <= _ROUNDING:
            return x
        x = x * np.exp(step * min(1.0, _LONGEST / longest))
        if not np.isfinite(x).all() or (x <= plane.program.low).any() or (x >= plane.program.high).any():
            return None
        if longest <= _SQUARED:
            return x
        found = followed(aim.model, form, x, np.array([peak.at.speed for peak in found]))
    return None


def _undamped(plane: LinkPlane, aim: Aim) -> FloatArray | None:
    """The mass that only the link holds, on the machine without its damping: Nishihara and Asami (2002), exactly."""
    model, x = aim.model, plane.program.high
    if model.n_free != 2:
        return None
    of_link = model.exponents[:, [plane.spring, plane.damper]].any(axis=1)
    b = model.vectors[of_link, :2][0].tolist()
    rest = np.where(of_link, 0.0, model.values(x))
    (m, cross, _, n), (k, tied, _, q) = (model.matrix(kind, rest)[:2, :2].ravel().tolist() for kind in _MATRICES)
    mass = m * n - cross * cross
    if m <= 0.0 or mass <= _HELD * m * n or k * q - tied * tied > _HELD * (k + q) ** 2:
        return None  # what has no mass has no second peak
    loose, locked = (q, -tied) if q > k else (-tied, k), (b[1], -b[0])
    held, along = _of(k, tied, q, locked), b[0] * loose[0] + b[1] * loose[1]
    if held <= 0.0 or not along:
        return None
    own = _of(m, cross, n, loose) / along**2
    free = (n * k - 2.0 * cross * tied + m * q) / mass
    ratio = free * _of(m, cross, n, locked) / held - 1.0
    if not (0.0 < ratio < inf and free > 0.0):
        return None
    root = sqrt(4.0 + 3.0 * ratio)
    above = 16.0 + 23.0 * ratio + 9.0 * ratio**2 + 2.0 * (2.0 + ratio) * root
    tuned = sqrt(free * above / (1.5 * (64.0 + 80.0 * ratio + 27.0 * ratio**2))) * 2.0 / (1.0 + ratio)
    damping = 0.5 * sqrt((8.0 + 9.0 * ratio - 4.0 * root) / (1.0 + ratio)) * own * tuned
    return plane.design(own * tuned**2, damping, 1.0)


def _of(first: float, tied: float, second: float, row: tuple[float, float]) -> float:
    """What a symmetric matrix of two makes of a motion: twice its energy."""
    a, b = row
    return first * a * a + 2.0 * tied * a * b + second * b * b
