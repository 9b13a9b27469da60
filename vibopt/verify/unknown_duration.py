"""Greatest response of the machine as built to a pulse that may have any duration, by simulations alone.

Many durations are simulated to a few digits, and those around the best to all: no search and no peak of the first
route is asked.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vibopt.excitations.excitation import Once
from vibopt.mechanics.machine import Machine
from vibopt.responses import TransientResponse
from vibopt.verify.simulated import Simulated

_IN_A_PERIOD, _HALVINGS, _BEST, _CLOSE = 5.0, 8, 2, 2e-4
"""Durations in the shortest period, and halvings of the first of them; tops that are looked at; part of a duration."""


def peak_over_durations(
    machine: Machine, excitations: Sequence[Once], response: TransientResponse, low: float, high: float
) -> float:
    """Greatest size over time and over every duration from `low` to `high` [s]."""
    from scipy.optimize import minimize_scalar

    def value(duration: float, *, loose: bool = False) -> float:
        return Simulated(machine, tuple(excitation.lasting(duration) for excitation in excitations), loose).peak(
            response
        )[0]

    fastest = float(np.abs(machine.poles()).max(initial=0.0))
    step = min(2.0 * np.pi / fastest / _IN_A_PERIOD if fastest > 0.0 else high, high)
    short = step * 0.5 ** np.arange(_HALVINGS, 0, -1)
    every = np.concatenate([short, np.arange(step, high, step), [low or short[0], high]])
    times = np.unique(every[(every >= low) & (every <= high)])
    values = np.array([value(float(time), loose=True) for time in times])
    best = max(value(float(one)) for one in (times[0], times[-1]))
    beside = np.concatenate([[-np.inf], values, [-np.inf]])
    tops = np.flatnonzero((values >= beside[:-2]) & (values >= beside[2:]))
    for i in tops[np.argsort(-values[tops])[:_BEST]]:
        left, right = times[max(i - 1, 0)], times[min(i + 1, len(times) - 1)]
        if values[i] < 0.9 * values.max() or not np.isfinite(values[i]) or left >= right:
            continue
        top = minimize_scalar(
            lambda one: -value(float(one)), bounds=(left, right), method="bounded", options={"xatol": _CLOSE * right}
        )
        best = max(best, -float(top.fun))
    return float(best if np.isfinite(values).all() else np.inf)


__all__ = ["peak_over_durations"]
