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

_IN_A_PERIOD, _HALVINGS, _BEST, _CLOSE, _ROUNDS, _LEVEL, _MOST_BESIDE = 5.0, 8, 3, 2e-4, 6, 1e-9, 50
"""Durations in the shortest period, and halvings of the first of them; tops that are looked at; part of a duration to
which one is found, how often an edge there is made better, part by which it must be higher; and periods of what comes
beside, at most."""

_ALIKE = 0.998
"""Part of the greatest from which durations are told apart closely."""


def peaks_over_durations(
    machine: Machine, excitations: Sequence[Once], responses: Sequence[TransientResponse],
    between: tuple[float, float], others: Sequence[TransientResponse] = (),
) -> list[float]:  # fmt: skip
    """Greatest size of each response over time and over every duration between two [s].

    Samples at all durations say roughly, for these responses and for others to the same at once, where the tops are.
    """

    def peak(response: TransientResponse, duration: float, *, closely: bool = True) -> float:
        return simulated(duration, closely=closely).peak(response)[0]

    def simulated(duration: float, *, closely: bool) -> Simulated:
        return Simulated(machine, tuple(excitation.lasting(duration) for excitation in excitations), closely)

    def greatest(response: TransientResponse, values: FloatArray) -> float:
        if not np.isfinite(values).all():
            return np.inf
        alike = np.flatnonzero(values >= _ALIKE * values.max())
        values = values + 0.0
        values[alike] = [peak(response, float(times[i])) for i in alike]
        best, beside = float(values[alike].max()), np.concatenate([[-np.inf], values, [-np.inf]])
        tops = np.flatnonzero((values >= beside[:-2]) & (values >= beside[2:]) & (values >= 0.9 * values.max()))
        for i in tops[np.argsort(-values[tops])[:_BEST]]:
            left, right = times[max(i - 1, 0)], times[min(i + 1, len(times) - 1)]
            if left < right:
                best = max(best, _top(lambda duration: peak(response, duration), left, right))
        return best

    low, high = between
    beside = max((one.fastest for one in excitations if one.durations is None), default=0.0)
    fastest = float(np.abs(machine.poles()).max(initial=min(beside, _MOST_BESIDE * 2.0 * np.pi / high)))
    step = min(2.0 * np.pi / fastest / _IN_A_PERIOD if fastest > 0.0 else high, high)
    short = step * 0.5 ** np.arange(_HALVINGS, 0, -1)
    every = np.concatenate([short, np.arange(step, high, step), [low or LEAST * high, high]])
    times = np.unique(every[(every >= low) & (every <= high)])
    known: dict[tuple[object, ...], tuple[object, FloatArray]] = vars(machine).setdefault("over_durations", {})
    keys = [(id(one), *map(id, excitations), *between) for one in (*responses, *others)]
    if any(key not in known for key in keys[: len(responses)]):
        moved = (simulated(float(time), closely=False) for time in times)
        values = np.array([[one.peak(response)[0] for response in (*responses, *others)] for one in moved])
        kept = [(one, excitations) for one in (*responses, *others)]
        known |= dict(zip(keys, zip(kept, values.T, strict=True), strict=True))
    return [greatest(one, known[key][1]) for one, key in zip(responses, keys, strict=False)]


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
        high = (1.0 + _LEVEL) * max(seen.values())
        for one, height in [*_edges(times, np.array([seen[time] for time in times]))]:
            if height > high and one not in seen:
                fallen(one)
    return max(seen.values())


def _edges(times: FloatArray, values: FloatArray) -> Iterator[tuple[float, float]]:
    """Where straight lines through two points on either side meet, in the gaps beside the greatest, and how high."""
    at = int(values.argmax())
    for i in (at, at + 1):
        if 2 <= i < len(times) - 1:
            rise, fall = ((values[j] - values[j - 1]) / (times[j] - times[j - 1]) for j in (i - 1, i + 1))
            met = (values[i] - values[i - 1] + rise * times[i - 1] - fall * times[i]) / (rise - fall or 1.0)
            if rise > fall and times[i - 1] < met < times[i]:
                yield float(met), float(values[i] + fall * (met - times[i]))
