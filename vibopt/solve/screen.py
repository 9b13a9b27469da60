"""Many designs looked at for little, to begin a search at the few that promise most."""

from __future__ import annotations

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.few import applies
from vibopt.program.program import Aim, Limit, Program
from vibopt.solve.ranges import log_box, starts

_TRIED, _ASKED = 512, 64
"""Designs looked at, and those of them at which forms that take longer are asked."""
_APART = 0.05
"""Distance of two beginnings, in parts of the range of logs."""
_WEIGHT = 10.0


def is_cheap(part: Limit | Aim) -> bool:
    """Whether many speeds of many designs can be looked at in no time."""
    if part.form.powers is not None:
        return True
    greatest = part.sense > 0 if isinstance(part, Aim) else part.side == "at_most"
    return greatest and part.form.harmonic is not None and applies(part.model, part.form.harmonic)


def screenable(program: Program) -> bool:
    """Whether the goal is a response over speeds, and it and every limit over speeds are cheap.

    Of designs that are to be light or stiff those that promise most break limits: starts by sampled speeds do better.
    """
    aims = () if program.aim is None else program.aim.pieces
    asked: list[Limit | Aim] = [part for part in program.limits if part.form.drives]
    return (
        bool(aims) and all(one.form.drives and is_cheap(one) for one in aims) and all(is_cheap(part) for part in asked)
    )


def promising(program: Program, count: int) -> list[FloatArray]:
    """Up to `count` designs y = log x (n_vars,), apart from each other, that promise most comes first."""
    low, high = log_box(program)
    y = np.clip(starts(program, _TRIED), low, high)
    cheap = [part for part in program.parts if is_cheap(part)]
    slow = [part for part in program.parts if not is_cheap(part)]
    merit = _merit(cheap, np.exp(y))
    asked = np.argsort(merit, kind="stable")[:_ASKED]
    if slow:
        merit[asked] += np.array([_merit(slow, np.exp(one)[None, :])[0] for one in y[asked]])
        asked = asked[np.argsort(merit[asked], kind="stable")]
    chosen: list[FloatArray] = []
    span = np.where(high > low, high - low, np.inf)
    for one in y[asked]:
        if len(chosen) < count and all((np.abs(one - other) / span).max() > _APART for other in chosen):
            chosen.append(one)
    return chosen


def _merit(parts: list[Limit | Aim], x: FloatArray) -> FloatArray:
    """Log of the goal, and what limits are missed by, of designs (n, n_vars); shape (n,)."""
    missed, goal = np.zeros(len(x)), np.full(len(x), -np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        for part in parts:
            log = np.log(_values(part, x))
            if isinstance(part, Aim):
                goal = np.maximum(goal, part.sense * np.nan_to_num(log, nan=700.0, posinf=700.0, neginf=-700.0))
            elif part.side != "outside":
                by = (1.0 if part.side == "at_most" else -1.0) * (log - np.log(max(part.bound, 1e-300)))
                missed = np.maximum(missed, np.nan_to_num(by, nan=700.0, posinf=700.0, neginf=0.0))
    return _WEIGHT * missed + np.where(np.isneginf(goal), 0.0, goal)


def _values(part: Limit | Aim, x: FloatArray) -> FloatArray:
    """Values of a form at designs (n, n_vars), no greater than the worst; shape (n,)."""
    few = part.form.glance(part.model, x) if is_cheap(part) else None
    return part.form.values(part.model, x) if few is None else few
