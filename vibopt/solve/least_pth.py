"""Many designs followed together, to where the mean of a high power of what is to be little is least.

Least pth optimisation (Charalambous and Bandler 1974): the sum of powers of a response over its speeds is smooth where
its greatest value is not, and of a low power it has few local optima.  The power rises in steps, each followed by
Levenberg and Marquardt's method.  What limits are missed by counts by its square.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.few import Picked, along
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
Rows = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]
"""Of n designs the logs of the goal (n, m) and their slopes (n, m, n_vars); the greatest log that a limit is missed by,
the sum of the squares of all of them (n,), half its slope (n, n_vars) and nearly half its bend (n, n_vars, n_vars)."""


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
        slope, bend = _steepness(rows, power)
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
        for old, new in zip(rows, found, strict=True):
            old[better] = new[better]
        damping = np.clip(damping * np.where(better, 0.3, 4.0), 1e-5, 1e4)
    return y, rows[0].max(axis=1) + _WEIGHT * rows[2]


def _norm(rows: Rows, power: float) -> FloatArray:
    """Log of the mean of powers, and squares of what limits are missed by, (n,)."""
    goal, _, _, squares, _, _ = rows
    top = goal.max(axis=1)
    mean = np.log(np.exp(2.0 * power * (goal - top[:, None])).sum(axis=1)) / (2.0 * power)
    return np.asarray(top + mean + 0.5 * _WEIGHT**2 * squares)


def _steepness(rows: Rows, power: float) -> tuple[FloatArray, FloatArray]:
    """Slope of the norm (n, n_vars), and nearly its bend (n, n_vars, n_vars)."""
    goal, slopes, _, _, pull, bend = rows
    parts = np.exp(power * (goal - goal.max(axis=1, keepdims=True)))
    parts *= np.sqrt(2.0 * power / (parts**2).sum(axis=1, keepdims=True))
    lifted = parts[:, :, None] * slopes
    slope = (np.swapaxes(lifted, 1, 2) @ parts[:, :, None])[..., 0] / (2.0 * power)
    return slope + _WEIGHT**2 * pull, np.swapaxes(lifted, 1, 2) @ lifted + _WEIGHT**2 * bend


def _rows(parts: list[Limit | Aim], y: FloatArray) -> Rows:
    n, n_vars = y.shape
    values, slopes = list[FloatArray](), list[FloatArray]()
    missed = np.zeros(n), np.zeros(n), np.zeros((n, n_vars)), np.zeros((n, n_vars, n_vars))
    with np.errstate(all="ignore"):
        for each, (value, slope) in zip(map(_Height, parts), _asked(parts, y), strict=True):
            above, slope = each.of(value), np.nan_to_num(each.sense * slope, posinf=0.0, neginf=0.0)
            worked(_WORK * above.size * n_vars)
            if each.missed is None:
                values.append(above)
                slopes.append(slope.reshape(*above.shape, n_vars))
            else:
                _add_missed(missed, above, slope)
    return np.concatenate(values, axis=1), np.concatenate(slopes, axis=1), *missed


def _add_missed(sums: tuple[FloatArray, ...], above: FloatArray, slopes: FloatArray) -> None:
    """Add what a limit is missed by: of logs (n, m) those above zero, with their slopes (n_missed, n_vars)."""
    worst, squares, pull, bend = sums
    np.maximum(worst, above.max(axis=1), out=worst)
    missed = above > 0.0
    ends, off = [0, *missed.sum(axis=1).cumsum().tolist()], above[missed]
    for i in np.flatnonzero(missed.any(axis=1)).tolist():
        own = slice(ends[i], ends[i + 1])
        squares[i] += off[own] @ off[own]
        pull[i] += off[own] @ slopes[own]
        bend[i] += slopes[own].T @ slopes[own]


def _asked(parts: list[Limit | Aim], y: FloatArray) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Logs (n, m) of the values of each, and slopes (n_slopes, n_vars): of a goal all, of a limit what is missed."""
    swung = [(part.model, part.form.harmonic, _Height(part).missed) for part in parts if part.form.powers is None]
    over_speeds = iter(along([(model, form, missed) for model, form, missed in swung if form is not None], np.exp(y)))
    for part in parts:
        powers, missed = part.form.powers, _Height(part).missed
        if powers is None:
            yield next(over_speeds)
        else:
            terms = powers.scale * np.exp(y @ powers.exponents.T)
            value = terms.sum(axis=1, keepdims=True)
            logs, slope = np.log(value), terms @ powers.exponents / value
            yield logs, slope if missed is None else slope[missed(logs)[:, 0]]


class _Height:
    """How far logs of values are above what they may be: of a goal above one."""

    def __init__(self, part: Limit | Aim) -> None:
        self.bound = np.log(max(part.bound, 1e-300)) if isinstance(part, Limit) else 0.0
        self.sense = part.sense if isinstance(part, Aim) else 1.0 if part.side == "at_most" else -1.0
        self.missed: Picked | None = (lambda logs: self.of(logs) > 0.0) if isinstance(part, Limit) else None

    def of(self, logs: FloatArray) -> FloatArray:
        return np.nan_to_num(self.sense * (logs - self.bound), nan=1e3, posinf=1e3, neginf=-1e3)
