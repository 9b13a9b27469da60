"""Greatest response to a pulse over every duration that it may have.

The greatest over time is exact at each duration.  Over durations it rises and falls once in about a period of the
machine: it is looked at more closely than that, and the greatest tops are refined.  It is found, and not proven.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.form import Form, by_differences
from vibopt.forms.peak_in_time import PeakInTime
from vibopt.records import dataclass
from vibopt.signals import Output, Segment

if TYPE_CHECKING:
    from vibopt.forms.reduce import Reach
    from vibopt.mechanics.model import Model

_KEPT, _TOPS, _NOTHING, _BEHIND = 64, 4, 1e-9, 8.0
"""Answers and tops that are kept; part of the fastest rate that is none; radians of the slowest looked at behind."""
_IN_A_PERIOD, _SHORT, _RATIO = 6.0, 1e-3, 2.0
"""Durations in the shortest period; part of it from which they are looked at, each so many times the one before."""
_CLOSE, _NEAR = 1e-5, 0.95
"""Part of a duration to which the greatest are found, and of the greatest from which a top may be it."""


@dataclass(frozen=True, slots=True)
class PeakOverDurations(Form):
    """Greatest size of a response over all time and over every duration of a pulse.

    loads
        (n_coords, n_signals), as of `PeakInTime`.
    signals
        The signals at a duration [s].
    low, high
        The shortest duration, zero where any is possible, and the longest [s].
    """

    output: Output
    loads: FloatArray
    signals: Callable[[float], tuple[Segment, ...]]
    low: float
    high: float
    no_bounds = "is greatest at a duration that is found by a search: it has no bounds on boxes of designs"
    not_convex = "is a peak in time, which is not convex in stiffness and damping"
    rough = "is greatest at a duration that is found by a search, and jumps from one to another"

    @property
    def searched(self) -> str:
        return "the greatest over every duration is found by a search"

    def value(self, model: Model, x: FloatArray) -> float:
        return self.worst_of(model, x)[0]

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        value, duration = self.worst_of(model, x)
        if not 0.0 < value < np.inf:
            return by_differences(lambda at: self.value(model, at), x)
        return self.lasting(duration).slope(model, x)

    def lasting(self, duration: float) -> PeakInTime:
        """At one duration [s]."""
        return PeakInTime(self.output, self.loads, self.signals(duration))

    def worst_of(self, model: Model, x: FloatArray) -> tuple[float, float]:
        """The greatest response, and the duration [s] at which it is; the last ones are kept."""
        known: dict[tuple[int, bytes], tuple[PeakOverDurations, tuple[float, float]]]
        known = vars(model).setdefault("peaks_over_durations", {})
        key = id(self), np.asarray(x, dtype=float).tobytes()
        if key not in known:
            if len(known) >= _KEPT:
                known.pop(next(iter(known)))
            known[key] = self, self._search(model, x)  # the form stays, and so its number
        return known[key][1]

    def _search(self, model: Model, x: FloatArray) -> tuple[float, float]:
        from scipy.optimize import minimize_scalar

        from vibopt.mechanics.harmonic import mount_count
        from vibopt.mechanics.modes import poles

        def value(duration: float) -> float:
            return self.lasting(duration).value(model, x)

        rates = np.abs(poles(model, model.values(x)))
        slow = float(rates[rates > _NOTHING * rates.max(initial=0.0)].min(initial=np.inf))
        times = durations(self.low, self.high, float(rates.max(initial=0.0)))
        count = mount_count(model, self.output, x)
        values = np.array([self._glimpse(model, x, float(one), _BEHIND / slow) for one in times]) / count
        best = max((value(float(one)), float(one)) for one in {self.high, max(self.low, float(times[0]))})
        beside = np.concatenate([[-np.inf], values, [-np.inf]])
        tops = np.flatnonzero((values >= beside[:-2]) & (values >= beside[2:]))
        for i in tops[np.argsort(-values[tops])[:_TOPS]]:
            low, high = times[max(i - 1, 0)], times[min(i + 1, len(times) - 1)]
            if np.isfinite(values[i]) and values[i] >= _NEAR * values.max() and low < high:
                top = minimize_scalar(
                    lambda one: -value(float(one)), bounds=(low, high), method="bounded",
                    options={"xatol": _CLOSE * float(high)},
                )  # fmt: skip
                best = max(best, (-float(top.fun), float(top.x)))
        return best

    def _glimpse(self, model: Model, x: FloatArray, duration: float, behind: float) -> float:
        machine, reading = self.lasting(duration).transient(model, model.values(x))
        return machine.glimpse(reading, behind)

    def reach(self, model: Model) -> Reach:
        from vibopt.forms.reduce import driven

        return driven(model, self.output, list(self.loads.T))

    def cost(self, model: Model) -> float:
        return 200.0


def durations(low: float, high: float, fastest: float) -> FloatArray:
    """Durations to look at [s], rising: as dense as the fastest rate of a machine [1/s] asks for."""
    step = 2.0 * np.pi / max(fastest, 1e-300) / _IN_A_PERIOD
    begin = low if low > 0.0 else min(_SHORT * step * _IN_A_PERIOD, 1e-3 * high)
    bend = min(max(step / (_RATIO - 1.0), begin), high)
    short = np.geomspace(begin, bend, max(2, int(np.ceil(np.log(bend / begin) / np.log(_RATIO))) + 1))
    return np.unique(np.concatenate([short, np.linspace(bend, high, int(np.ceil((high - bend) / step)) + 1)]))


__all__ = ["PeakOverDurations", "durations"]
