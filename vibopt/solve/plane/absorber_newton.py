"""One absorber by Newton on its equal peaks, from the optimum without damping: a candidate for the proof, and no more.

At the optimum of one absorber two peaks are equally high, and the slopes of their heights in stiffness and damping
point against each other.  Nothing is claimed here: that the point is best is shown by the rows of all designs.
"""

from __future__ import annotations

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms import Modulus
from vibopt.forms.few import followed, heights_of
from vibopt.mechanics.modes import free_matrices
from vibopt.program.program import Aim
from vibopt.solve.plane.link_plane import LinkPlane

_STEPS = 20
_LONGEST = 0.3
_SQUARED = 1e-7
"""A step of Newton this short leaves nothing: the next is as short as its square."""
_HELD = 1e-9


def equal_peaks(plane: LinkPlane) -> FloatArray | None:
    """A design (n_vars,) at which two peaks of the goal are equally high and no direction lowers both.

    None where the link holds no absorber on a machine of two coordinates, or Newton leads nowhere within the ranges.
    """
    aim = plane.program.aim
    form = aim.form.harmonic if aim is not None else None
    if aim is None or form is None or aim.sense < 0.0 or aim.others or plane.other >= 0:
        return None
    x = _undamped(plane, aim)
    speeds = None if x is None else _two_peaks(aim, form, x)
    if x is None or speeds is None:
        return None
    y = np.log(x)
    for _ in range(_STEPS):
        found = followed(aim.model, form, np.exp(y), speeds)
        if found is None or len(found) != 2:
            return None
        speeds = np.array([peak.at.speed for peak in found])
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
        y = y + step * min(1.0, _LONGEST / max(longest, 1e-300))
        x = np.exp(y)
        if not np.isfinite(y).all() or (x <= plane.program.low).any() or (x >= plane.program.high).any():
            return None
        if longest <= _SQUARED:
            return x
    return None


def _two_peaks(aim: Aim, form: Modulus, x: FloatArray) -> FloatArray | None:
    """Speeds of the two peaks of the goal [rad/s], roughly; None where there are not two."""
    found = heights_of(aim.model, form, x[None, :])
    if found is None:
        return None
    speeds, heights = found[0], found[1][0]
    inner = np.flatnonzero((heights[1:-1] > heights[:-2]) & (heights[1:-1] >= heights[2:])) + 1
    return speeds[inner] if len(inner) == 2 else None


def _undamped(plane: LinkPlane, aim: Aim) -> FloatArray | None:
    """The mass that only the link holds, on the machine without its damping: Nishihara and Asami (2002), exactly."""
    model, x = aim.model, plane.program.high
    if model.n_free != 2:
        return None
    of_link = model.exponents[:, [plane.spring, plane.damper]].any(axis=1)
    b = model.vectors[of_link, :2][0]
    mass, _, stiffness, _ = free_matrices(model, np.where(of_link, 0.0, model.values(x)))
    if np.linalg.eigvalsh(mass)[0] <= 0.0:
        return None  # what has no mass has no second peak
    values, vectors = np.linalg.eigh(stiffness)
    loose, locked = vectors[:, 0], np.array([b[1], -b[0]])
    held = float(locked @ stiffness @ locked)
    if abs(values[0]) > _HELD * values[1] or held <= 0.0 or not (along := float(b @ loose)):
        return None
    own = float(loose @ mass @ loose) / along**2
    free = float(np.trace(np.linalg.solve(mass, stiffness)))
    ratio = free * float(locked @ mass @ locked) / held - 1.0
    if not (0.0 < ratio < np.inf and free > 0.0):
        return None
    root = np.sqrt(4.0 + 3.0 * ratio)
    above = 16.0 + 23.0 * ratio + 9.0 * ratio**2 + 2.0 * (2.0 + ratio) * root
    tuned = np.sqrt(free * above / (1.5 * (64.0 + 80.0 * ratio + 27.0 * ratio**2))) * 2.0 / (1.0 + ratio)
    damping = 0.5 * np.sqrt((8.0 + 9.0 * ratio - 4.0 * root) / (1.0 + ratio)) * own * tuned
    return plane.design(own * tuned**2, damping, 1.0)
