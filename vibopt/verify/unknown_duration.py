"""Greatest response of the machine as built to a pulse that may have any duration, by simulations alone.

Many durations are simulated, the ends among them, and more around the best: no search and no peak of the first route is
asked.  Where one peak in time overtakes another the top is an edge, which is found as one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.excitations.excitation import Once
from vibopt.forms.any_duration import LEAST
from vibopt.mechanics.machine import Machine
from vibopt.responses import TransientResponse
from vibopt.verify.simulated import Simulated

_IN_A_PERIOD, _HALVINGS, _BEST, _CLOSE, _ROUNDS = 5.0, 8, 2, 2e-4, 6
"""Durations in the shortest period, and halvings of the first of them; tops that are looked at; part of a duration to
which one is found, and how often an edge there is made better."""


def peaks_over_durations(
    machine: Machine, excitations: Sequence[Once], responses: Sequence[TransientResponse], low: float, high: float
) -> list[float]:
    """Greatest size of each response over time and over every duration from `low` to `high` [s].

    The durations that all are looked at are simulated once for all responses.
    """

    def simulated(duration: float) -> Simulated:
        return Simulated(machine, tuple(excitation.lasting(duration) for excitation in excitations))

    def greatest(response: TransientResponse, values: FloatArray) -> float:
        best = float(values.max())
        beside = np.concatenate([[-np.inf], values, [-np.inf]])
        tops = np.flatnonzero((values >= beside[:-2]) & (values >= beside[2:]))
        for i in tops[np.argsort(-values[tops])[:_BEST]]:
            left, right = times[max(i - 1, 0)], times[min(i + 1, len(times) - 1)]
            if values[i] < 0.9 * values.max() or not np.isfinite(values[i]) or left >= right:
                continue
            best = max(best, _top(lambda duration: simulated(duration).peak(response)[0], left, right))
        return float(best if np.isfinite(values).all() else np.inf)

    fastest = float(np.abs(machine.poles()).max(initial=0.0))
    step = min(2.0 * np.pi / fastest / _IN_A_PERIOD if fastest > 0.0 else high, high)
    short = step * 0.5 ** np.arange(_HALVINGS, 0, -1)
    every = np.concatenate([short, np.arange(step, high, step), [low or LEAST * high, high]])
    times = np.unique(every[(every >= low) & (every <= high)])
    moved = (simulated(float(time)) for time in times)
    values = np.array([[one.peak(response)[0] for response in responses] for one in moved])
    return [greatest(response, row) for response, row in zip(responses, values.T, strict=True)]


def _top(value: Callable[[float], float], left: float, right: float) -> float:
    """The greatest value between two durations [s] with one top between them, round or an edge."""
    from scipy.optimize import minimize_scalar

    seen: dict[float, float] = {}

    def fallen(duration: float) -> float:
        seen[duration] = value(duration)
        return -seen[duration]

    minimize_scalar(lambda one: fallen(float(one)), bounds=(left, right), method="bounded",
                    options={"xatol": _CLOSE * right})  # fmt: skip
    for _ in range(_ROUNDS):
        times = np.array(sorted(seen))
        for one in [edge for edge in _edges(times, np.array([seen[time] for time in times])) if edge not in seen]:
            fallen(one)
    return max(seen.values())


def _edges(times: FloatArray, values: FloatArray) -> Iterator[float]:
    """Where straight lines through two points on either side meet, in the gaps beside the greatest."""
    at = int(values.argmax())
    for i in (at, at + 1):
        if 2 <= i < len(times) - 1:
            rise, fall = ((values[j] - values[j - 1]) / (times[j] - times[j - 1]) for j in (i - 1, i + 1))
            met = (values[i] - values[i - 1] + rise * times[i - 1] - fall * times[i]) / (rise - fall or 1.0)
            if rise > fall and times[i - 1] < met < times[i]:
                yield float(met)
