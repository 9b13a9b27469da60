"""Many designs followed together, to where the mean of a high power of what is to be little is least.

Least pth optimisation (Charalambous and Bandler 1974): the sum of powers of a response over its speeds is smooth where
its greatest value is not, and of a low power it has few local optima.  The power rises in steps, each followed by
Levenberg and Marquardt's method.  What limits are missed by counts by its square.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from vibopt.arrays import BoolArray, FloatArray
from vibopt.forms.few import along
from vibopt.program.program import Aim, Limit
from vibopt.work import worked

_POWERS = ((1.0, 10, 64), (2.0, 5, 64), (4.0, 5, 32), (8.0, 8, 32), (24.0, 10, 24))
"""Powers, how many steps are made of each, and how many designs are kept then, those with the least greatest values."""
_WEIGHT, _REACH, _BEGUN = 10.0, 0.7, 0.01
"""Weight of what a limit is missed by (log), the longest step in a variable (log), and the damping of the first."""
_APART = 0.03
"""Distance of designs that are kept, in parts of the range of logs."""
_WORK = 1e-4
"""Work of one slope of one value at one design [nominal ms]."""
Rows = tuple[FloatArray, FloatArray, BoolArray]
"""Of n designs the logs of all that is to be little (n, m), its slopes (n, m, n_vars), and what are limits (m,)."""


def least_pth(
    parts: list[Limit | Aim], y: FloatArray, low: FloatArray, high: FloatArray, *, rungs: int = len(_POWERS)
) -> list[FloatArray]:
    """Designs apart from each other that logs y (n, n_vars) lead to between low and high, the most promising first.

    With few `rungs`, the last ones, they begin with a high power and stay next to where they are.
    """
    span = np.where(high > low, high - low, np.inf)
    for power, rounds, most in _POWERS[-rungs:]:
        y, level = _followed(parts, y, low, high, power, rounds)
        kept = list[FloatArray]()
        for one in y[np.argsort(level, kind="stable")]:
            if len(kept) < most and all((np.abs(one - other) / span).max() > _APART for other in kept):
                kept.append(one)
        y = np.array(kept)
    return kept


def _followed(
    parts: list[Limit | Aim], y: FloatArray, low: FloatArray, high: FloatArray, power: float, rounds: int
) -> tuple[FloatArray, FloatArray]:
    """Where so many steps for one power lead, and the greatest value there (log) with what limits are missed by."""
    y = y.copy()
    rows, damping = _rows(parts, y), np.full(len(y), _BEGUN)
    for _ in range(rounds):
        residuals, slopes = _residuals(rows, power)
        slope, bend = (slopes * residuals[:, :, None]).sum(axis=1), np.swapaxes(slopes, 1, 2) @ slopes
        free = ~(((y <= low) & (slope > 0.0)) | ((y >= high) & (slope < 0.0)))
        bend *= free[:, :, None] & free[:, None]
        size = np.einsum("nii->ni", bend)
        size += damping[:, None] * (size + 1e-3 * size.max(axis=1, keepdims=True) + 1e-12) + ~free
        step = np.linalg.solve(bend, -(slope * free)[..., None])[..., 0]
        step *= _REACH / np.maximum(np.abs(step).max(axis=1, keepdims=True), _REACH)
        there = np.clip(y + step, low, high)
        found = _rows(parts, there)
        better = _norm(found, power) < _norm(rows, power)
        y[better] = there[better]
        for old, new in zip(rows[:2], found[:2], strict=True):
            old[better] = new[better]
        damping = np.clip(damping * np.where(better, 0.3, 4.0), 1e-5, 1e4)
    value, _, limits = rows
    return y, value[:, ~limits].max(axis=1) + _WEIGHT * np.maximum(value[:, limits], 0.0).max(axis=1, initial=0.0)


def _norm(rows: Rows, power: float) -> FloatArray:
    """Log of the mean of powers, and squares of what limits are missed by, (n,)."""
    goal, missed = rows[0][:, ~rows[2]], np.maximum(rows[0][:, rows[2]], 0.0)
    top = goal.max(axis=1)
    mean = np.log(np.exp(2.0 * power * (goal - top[:, None])).sum(axis=1)) / (2.0 * power)
    return np.asarray(top + mean + 0.5 * _WEIGHT**2 * (missed**2).sum(axis=1))


def _residuals(rows: Rows, power: float) -> tuple[FloatArray, FloatArray]:
    """Residuals (n, m) and slopes (n, m, n_vars), whose products are the slope of the norm and nearly its bend."""
    value, slope, limits = rows
    parts = np.exp(power * np.where(limits, -np.inf, value - value[:, ~limits].max(axis=1, keepdims=True)))
    parts *= np.sqrt(2.0 * power / (parts**2).sum(axis=1, keepdims=True))
    missed = np.maximum(value, 0.0)
    residuals = np.where(limits, _WEIGHT * missed, parts / (2.0 * power))
    return residuals, np.where(limits, _WEIGHT * (missed > 0.0), parts)[:, :, None] * slope


def _rows(parts: list[Limit | Aim], y: FloatArray) -> Rows:
    with np.errstate(all="ignore"):
        values, slopes, limits = zip(*_asked(parts, y), strict=True)
    worked(_WORK * sum(slope.size for slope in slopes))
    return (
        np.nan_to_num(np.concatenate(values, axis=1), nan=1e3, posinf=1e3, neginf=-1e3),
        np.nan_to_num(np.concatenate(slopes, axis=1), posinf=0.0, neginf=0.0),
        np.concatenate(limits),
    )


def _asked(parts: list[Limit | Aim], y: FloatArray) -> Iterator[Rows]:
    swung = [(part.model, part.form.harmonic) for part in parts if part.form.powers is None]
    over_speeds = iter(along([(model, form) for model, form in swung if form is not None], np.exp(y)))
    for part in parts:
        powers = part.form.powers
        if powers is not None:
            terms = powers.scale * np.exp(y @ powers.exponents.T)
            value = terms.sum(axis=1, keepdims=True)
            value, slope = np.log(value), (terms @ powers.exponents / value)[:, None]
        else:
            value, slope = next(over_speeds)
        if isinstance(part, Limit):
            sense, value = 1.0 if part.side == "at_most" else -1.0, value - np.log(max(part.bound, 1e-300))
        else:
            sense = part.sense
        yield sense * value, sense * slope, np.full(value.shape[1], isinstance(part, Limit))
