"""Machines of which all masses, springs and dampers are open: a larger one of the same proportions moves alike.

Where no limit and not the goal is the worse for it, a best design reaches an end of some range.
"""

from __future__ import annotations

import numpy as np

from vibopt.arrays import BoolArray, FloatArray
from vibopt.program.program import Aim, Limit, Program

_SAME = 1e-12


def towards(program: Program) -> FloatArray | None:
    """Powers of s (n_vars,) by which variables go on a way that makes no design worse; None where none is known."""
    parts: list[Limit | Aim] = [*program.limits, *(program.aim.pieces if program.aim else ())]
    rows = np.unique(np.concatenate([part.model.exponents for part in parts]), axis=0)
    along = np.linalg.lstsq(rows, np.ones(len(rows)), rcond=None)[0] if len(rows) else np.zeros(0)
    if not len(rows) or np.abs(rows @ along - 1.0).max() > _SAME:
        return None
    along = np.where(np.abs(along) > _SAME, along, 0.0)
    worse = []
    for part in parts:
        power = part.form.by_size(part.model, along)
        if power is None:
            return None
        worse.append(power * _sense(part) if power else 0.0)
    if np.max(worse) <= 0.0:  # of nan neither holds
        return along
    return -along if np.min(worse) >= 0.0 else None


def _sense(part: Limit | Aim) -> float:
    """1 of what is to be small, -1 of what is to be great; nan of what is kept away from both sides."""
    if isinstance(part, Aim):
        return part.sense
    return {"at_most": 1.0, "at_least": -1.0}.get(part.side, np.nan)


def reaching(program: Program, along: FloatArray, low: FloatArray, high: FloatArray) -> BoolArray:
    """Which of boxes low, high (n, n_vars) hold designs that go no further that way, (n,)."""
    up, down = along > 0.0, along < 0.0
    return np.asarray(((high >= program.high) & up).any(axis=1) | ((low <= program.low) & down).any(axis=1))
