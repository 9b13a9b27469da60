"""Speeds at which a reading of the machine as built turns, all of them: read off a few frequencies, as polynomials."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isfinite, nan
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, some

_NODES = 1.0 + np.cos(np.pi * (np.arange(8) + 0.5) / 8)
"""Squares of frequencies over that of the natural frequency, at which a numerator is read."""
_TO_POWERS = np.linalg.inv(np.vander(_NODES, increasing=True))
_NOTHING = 1e-10
"""Part of the greatest coefficient of a numerator below which one is rounding."""
_NEAR = 0.1
"""Part of the greatest pole above which others keep their digits beside it."""
_LIGHT = 3e-3
"""Damping of a pole, of critical, below which a peak is too sharp for polynomials in the square of the frequency."""
_SURE = 1e-11
"""Part of the greatest coefficient that may be left where there should be none."""


def turning_points(
    read: Callable[[FloatArray], FloatArray], bottom: Sequence[Any], unit: Any, power: float
) -> FloatArray | None:
    """Every frequency [rad/s] at which a reading times w**power turns, (n, ...), nan for those that are not real.

    With u = w^2 / unit, |r|^2 = u^power N(u) / D(u).  D is `bottom`, ascending; N is a polynomial, read off the machine
    at a few frequencies.  The slope vanishes at the roots of power N D + u (N' D - N D').
    """
    u = _NODES.reshape(-1, *[1] * np.ndim(unit))
    below: Any = 0.0
    for one in reversed(bottom):
        below = below * u + one
    rows = _powers(read(np.sqrt(u * unit)) ** 2 * below)
    if not np.isfinite(rows).all():
        return None
    rows[np.abs(rows) <= _NOTHING * np.abs(rows).max(axis=0)] = 0.0
    parts: list[Any] = rows.tolist() if rows.ndim == 1 else list(rows)  # of one machine plain numbers
    used = [i for i, row in enumerate(parts) if some(row)]
    if not used:
        return None
    first = used[0]
    level: list[Any] = [0.0] * (used[-1] - first + len(bottom))
    for i, row in enumerate(parts[first : used[-1] + 1]):  # power more, for u^first
        for j, part in enumerate(bottom):
            level[i + j] = level[i + j] + (power + first + i - j) * row * part
    with np.errstate(all="ignore"):
        return np.asarray(np.sqrt(_real_roots(level) * unit))


def of_two(
    read: Callable[[FloatArray], FloatArray], matrices: tuple[FloatArray, ...], poles: ComplexArray, power: float
) -> FloatArray | None:
    """Where a reading of two bodies may be greatest, with M, C, K and hysteretic stiffness, each (2, 2).

    None where digits would be lost, beside a pole that is hardly damped or far below another, and with structural
    damping.  Where it is least it may be zero, and that these speeds are not near enough to.
    """
    mass, damping, stiffness, hysteretic = matrices
    size = np.abs(poles)
    most = float(size.max())
    if hysteretic.any() or size.min() < _NEAR * most or (np.abs(poles.imag) < _LIGHT * size).any():
        return None
    unit = most**2
    u = _NODES[:, None, None]
    z = (stiffness - u * unit * mass) + 1j * np.sqrt(u * unit) * damping
    bottom = _powers(np.abs(z[:, 0, 0] * z[:, 1, 1] - z[:, 0, 1] * z[:, 1, 0]) ** 2)
    if np.abs(bottom[5:]).max() > _SURE * np.abs(bottom).max():
        return None
    found = turning_points(read, (bottom[:5] / bottom[4]).tolist(), unit, power)
    return None if found is None else np.concatenate([np.abs(poles.real), found[np.isfinite(found)]])


def _powers(values: FloatArray) -> FloatArray:
    """Coefficients, ascending, of polynomials with these values at the nodes, (8, ...)."""
    return np.asarray((_TO_POWERS @ values.reshape(len(values), -1)).reshape(values.shape))


def _real_roots(level: list[Any]) -> FloatArray:
    """Real roots of polynomials, ascending coefficients (numbers or arrays), polished; nan where there is none."""
    used = [i for i, one in enumerate(level) if some(one)]
    level = level[used[0] : used[-1] + 1] if used else level[:1]
    count = len(level) - 1
    if count < 1:
        return np.zeros((0, *np.shape(level[0])))
    if count == 1:
        return np.asarray([-level[0] / level[1]])
    if count == 2:
        c, b, a = level
        large = -0.5 * (b + np.copysign(np.sqrt(b * b - 4.0 * a * c), b))
        return np.asarray([large / a, c / large])
    # in 1 / u, so that light damping (a small highest coefficient) leaves the eigenvalues of size one
    rows = np.array(np.broadcast_arrays(*level))
    lead = np.where(rows[0] == 0.0, 1e-300, rows[0])
    companion = np.zeros((*rows.shape[1:], count, count))
    companion[..., 0, :] = np.moveaxis(-rows[1:] / lead, 0, -1)
    companion[..., range(1, count), range(count - 1)] = 1.0
    inverse = np.moveaxis(np.linalg.eigvals(companion), -1, 0)
    roots: Any = np.where(np.abs(inverse.imag) <= 1e-7 * np.abs(inverse), 1.0 / inverse.real, np.nan)
    if rows.ndim == 1:
        return np.array([_newton(level, root) for root in roots.tolist() if isfinite(root)])
    for _ in range(3):
        value, slope = rows[-1], np.zeros(rows.shape[1:])
        for row in rows[-2::-1]:
            value, slope = value * roots + row, slope * roots + value
        roots = roots - value / slope
    return np.asarray(roots)


def _newton(level: list[float], root: float) -> float:
    """A real root of one polynomial, ascending, polished."""
    for _ in range(3):
        value = slope = 0.0
        for one in reversed(level):
            value, slope = value * root + one, slope * root + value
        root = root - value / slope if slope else nan
    return root
