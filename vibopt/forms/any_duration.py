"""Greatest response to a pulse over every duration that it may have.

The greatest over time is exact at each duration.  Over durations it rises and falls once in about a period of the
machine: it is looked at more closely than that, and the greatest tops are refined.  It is found, and not proven.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray, IntArray
from vibopt.forms.form import WITHOUT_END, Form, Local, by_differences, kept
from vibopt.forms.peak_in_time import PeakInTime
from vibopt.records import dataclass
from vibopt.signals import Output, Segment, side_by_side, stretched

if TYPE_CHECKING:
    from vibopt.forms.floors import Floors
    from vibopt.forms.reduce import Reach
    from vibopt.forms.tangent import Tangent
    from vibopt.mechanics.model import Model
    from vibopt.mechanics.readout import Reading
    from vibopt.mechanics.transient import Transient

    _Asked = Callable[[Transient, Reading, IntArray], FloatArray]

_TOPS, _NOTHING, _BEHIND = 4, 1e-9, 8.0
"""Tops that are kept; part of the fastest rate that is none; radians of the slowest looked at behind."""
_IN_A_PERIOD, _SHORT, _RATIO, _MOST_BESIDE = 6.0, 1e-3, 2.0, 50
"""Durations in the shortest period; part of it from which they are looked at, each so many times the one before; and
periods of what comes beside, at most."""
_ACROSS, _AT_ONCE, _NARROWER = 7, 128, 0.2
"""Places across a top at which it is looked at; durations side by side; part of a step around the top of a parabola."""
_PART, _EVEN = 0.37, 1e-14
"""Part of the longest duration at which a pulse is seen to be the same but shorter, and rounding of lengths."""
_HIGH, _APART = 0.7, 0.1
"""Part of the greatest that another top is at least, and of its duration by which another one differs."""
_SHARED, _MADE, _AT_DURATIONS = 8.0, 10.0, 3.0
"""Work of a search with signals that are shared, and of each segment of others and each coordinate; of tangents at the
durations that are known, for each coordinate [nominal ms]."""
LEAST = 1e-8
"""Part of the longest duration that stands for none at all."""
_CLOSE, _LEVEL, _NEAR = 1e-7, 1e-11, 0.95
"""Parts: of a duration to which a top is found, of a top that is level, of the greatest from which a top may be it."""


@dataclass(frozen=True, slots=True)
class PeakOverDurations(Form):
    """Greatest size of a response over all time and over every duration of a pulse.

    loads
        (n_coords, n_signals), as of `PeakInTime`.
    signals
        The signals at a duration [s].
    low, high
        The shortest duration, zero where any is possible, and the longest [s].
    beside
        About the fastest rate of what comes with it [rad/s], which it may meet at any duration.
    """

    output: Output
    loads: FloatArray
    signals: Callable[[float], tuple[Segment, ...]]
    low: float
    high: float
    beside: float = 0.0
    no_bounds = "is greatest at a duration that is found by a search: tangents alone bound it"
    not_convex = "is a peak in time, which is not convex in stiffness and damping"
    rough = "is greatest at a duration that is found by a search, and jumps from one to another"

    @property
    def searched(self) -> str:
        return "the greatest over every duration is found by a search"

    def value(self, model: Model, x: FloatArray) -> float:
        return self.worst_of(model, x)[0]

    def values(self, model: Model, x: FloatArray, *, least_wanted: bool = False) -> FloatArray:
        return np.array([tops[0][0] for tops in self._worst(model, x)])

    def ahead(self, model: Model, x: FloatArray) -> None:
        with suppress(np.linalg.LinAlgError):  # told where it is asked for alone
            self.values(model, x)

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        value, duration = self.worst_of(model, x)
        if not 0.0 < value < np.inf:
            return by_differences(lambda at: self.value(model, at), x)
        return self.lasting(duration).slope(model, x)

    @property
    def tangents_of(self) -> tuple[float, ...]:
        return (1.0,)  # it is no less than at any one duration

    def tangents(
        self, model: Model, x: FloatArray, reach: FloatArray, level: float = WITHOUT_END, times: Sequence[float] = ()
    ) -> list[list[Tangent]]:
        """At the durations `times` [s], or at the longest where none is known."""
        at_each = [self.lasting(time).tangents(model, x, reach, level) for time in times or (self.high,)]
        return [[tangent for some in many for tangent in some] for many in zip(*at_each, strict=True)]

    def greatest_at(self, model: Model, x: FloatArray) -> float:
        return self.worst_of(model, x)[1]

    def by_size(self, model: Model, along: FloatArray) -> float | None:
        return self.lasting(self.high).by_size(model, along)

    def floors(self, model: Model) -> Floors | None:
        return self.lasting(self.high).floors(model)

    def room(self, model: Model, x: FloatArray, value: float, other: float, rounding: float) -> float:
        return self.lasting(self.high).room(model, x, value, other, rounding)

    def lasting(self, duration: float) -> PeakInTime:
        """At one duration [s]."""
        return PeakInTime(self.output, self.loads, self.signals(duration))

    def extremes(self, model: Model, x: FloatArray, *, least_wanted: bool, within: float = 0.5) -> list[Local]:
        """Tops in time at the duration at which it is greatest and, where it is to be small, at others beside it."""
        (value, _), *_ = tops = self._worst(model, x[None])[0]
        if least_wanted or not 0.0 < value < np.inf:
            return Form.extremes(self, model, x, least_wanted=least_wanted)
        found = [
            replace(local, speeds=(duration, *local.speeds))
            for size, duration in tops
            if size >= _HIGH * value
            for local in self.lasting(duration).extremes(model, x, least_wanted=False)
        ]
        return sorted(found, key=lambda local: -local.value)

    def worst_of(self, model: Model, x: FloatArray) -> tuple[float, float]:
        """The greatest response, and the duration [s] at which it is."""
        return self._worst(model, x[None])[0][0]

    def _worst(self, model: Model, x: FloatArray) -> list[list[tuple[float, float]]]:
        """The same at designs x (n, n_vars), and behind it other durations at which it is greater than beside them."""
        return kept(model, self, x, lambda some: self._search(model, some))

    def _search(self, model: Model, x: FloatArray) -> list[list[tuple[float, float]]]:
        """At designs (n, n_vars): a rough look at many durations, and all tops that may be the greatest, closer."""
        from vibopt.mechanics.harmonic import mount_count
        from vibopt.mechanics.modes import poles

        rates = [np.abs(poles(model, model.values(one))) for one in x]
        slow = np.array([one[one > _NOTHING * one.max(initial=0.0)].min(initial=np.inf) for one in rates])
        beside = min(self.beside, _MOST_BESIDE * 2.0 * np.pi / self.high)
        times = [durations(self.low, self.high, float(one.max(initial=beside))) for one in rates]
        of = np.repeat(np.arange(len(x)), [len(time) for time in times])

        def look(machine: Transient, read: Reading, of: IntArray) -> FloatArray:
            return machine.glimpses(read, _BEHIND / slow[of])

        seen = self._by(model, x, of, np.concatenate(times), look)
        tops: list[tuple[int, float, float, float, float]] = []
        for i, (here, values) in enumerate(zip(times, np.split(seen, np.flatnonzero(np.diff(of)) + 1), strict=True)):
            tops += [(i, end, end, end, end) for end in {self.high, max(self.low, float(here[0]))}]
            tops += [(i, *between) for between in _tops(here, values)]
        every: list[list[tuple[float, float]]] = [[] for _ in x]
        for i, found in self._climbed(model, x, tops):
            every[i].append(found)
        counts = [mount_count(model, self.output, one) for one in x]
        return [_apart([(value / count, at) for value, at in one]) for one, count in zip(every, counts, strict=True)]

    def _climbed(
        self, model: Model, x: FloatArray, tops: list[tuple[int, float, float, float, float]]
    ) -> Iterator[tuple[int, tuple[float, float]]]:
        """The greatest response of a design between two durations with one top between them, and its duration [s].

        Of each the design, the two durations, and those to which the top may have been seen too far away by a step.

        Around the top of a parabola durations draw together fast; where two tops meet in an edge it leads astray, and
        the places beside the best are looked at again.
        """
        of, low, high, *wider = (np.array(column) for column in zip(*tops, strict=True))
        of, before = of.astype(int), np.array(wider)
        while len(of):
            times = np.linspace(low, high, _ACROSS, axis=1)
            values = self._peaks(model, x, np.repeat(of, _ACROSS), times.ravel()).reshape(times.shape)
            at, rows = values.argmax(axis=1), np.arange(len(of))
            greatest = zip(values[rows, at].tolist(), times[rows, at].tolist(), strict=True)
            yield from zip(of.tolist(), greatest, strict=True)
            inside = np.clip(at, 1, _ACROSS - 2)
            near, there = (np.array([one[rows, inside + k] for k in (-1, 0, 1)]) for one in (values, times))
            left = near.max(axis=0) - near.min(axis=0) > _LEVEL * near.max(axis=0)
            left &= (there[2] - there[0] > _CLOSE * high) & np.isfinite(near).all(axis=0)
            first, last = (at == 0) & (before[0] < low), (at == _ACROSS - 1) & (before[1] > high)
            beside = np.array([np.where(first, before[0], there[0]), np.where(last, before[1], there[2])])
            low, high = np.where(first | last, beside, _around(near, there))
            of, low, high, before = of[left], low[left], high[left], beside[:, left]

    def _peaks(self, model: Model, x: FloatArray, of: IntArray, times: FloatArray) -> FloatArray:
        """The greatest response of designs x[of] to pulses of many durations [s]."""
        return np.abs(self._by(model, x, of, times, lambda machine, read, _: machine.peaks(read).value))

    def _by(self, model: Model, x: FloatArray, of: IntArray, times: FloatArray, asked: _Asked) -> FloatArray:
        """What is asked of designs x[of] (n, n_vars) under pulses of durations (n,) [s], many side by side."""
        from vibopt.forms.peak_in_time import matrices, reading
        from vibopt.mechanics.joints import UnlikeError
        from vibopt.mechanics.transient import Transient

        p, found = model.values(x), np.zeros(len(times))
        for alike, pulses in self._pulses(times):
            left = np.array_split(alike, -(-len(alike) // _AT_ONCE))
            while left:
                those = left.pop()
                here = p[of[those]]
                machine = Transient(*matrices(model, here), model.n_free, self.loads, pulses(those))
                try:
                    found[those] = asked(machine, reading(model, self.output, here), of[those])
                except UnlikeError:  # a joint that a damper holds at some designs alone
                    if len(those) == 1:
                        raise
                    left += np.array_split(those, len(those))
        return found

    def _pulses(self, times: FloatArray) -> Iterator[tuple[IntArray, Callable[[IntArray], tuple[Segment, ...]]]]:
        """Which of the durations [s] have signals of one kind, and what gives those of some of them side by side."""
        if self._stretches:
            whole = self.signals(self.high)
            yield np.arange(len(times)), lambda those: stretched(whole, times[those] / self.high)
            return
        signals = [self.signals(float(time)) for time in times]
        kinds = [tuple((*segment.rates.shape, segment.endless) for segment in signal) for signal in signals]
        for kind in dict.fromkeys(kinds):  # several pulses may come in another order
            alike = np.flatnonzero([one == kind for one in kinds])
            yield alike, lambda those: side_by_side([signals[i] for i in those])

    @property
    def _stretches(self) -> bool:
        """Whether another duration stretches all signals alike, and changes nothing else: one pulse of a force."""
        every = zip(self.signals(self.high), part := self.signals(_PART * self.high), strict=False)
        return len(part) == len(self.signals(self.high)) and all(
            not segment.endless
            and segment.released is None
            and abs(other.length - _PART * segment.length) <= _EVEN * other.length
            and all(np.array_equal(*pair) for pair in zip(segment.states, other.states, strict=True))
            for segment, other in every
        )

    def reach(self, model: Model) -> Reach | None:
        return self.lasting(self.high).reach(model)

    def cost(self, model: Model) -> float:
        """Signals that one pulse stretches are shared by all durations; others are made for each of them.

        Of those alone, and of coordinates: how many durations are looked at hangs on how fast a design is, which is not
        known before.  One mass takes half to six times as long, from pulses of a period to fifty.
        """
        return _SHARED if self._stretches else _MADE * len(self.signals(self.high)) * (2.0 + model.n_free)

    def tangents_cost(self, model: Model) -> float:
        return _AT_DURATIONS * model.n_free


def _tops(times: FloatArray, values: FloatArray) -> Iterator[tuple[float, float, float, float]]:
    """Durations [s] beside the tops of what was seen that may be the greatest, and those beside these."""
    beside = np.concatenate([[-np.inf], values, [-np.inf]])
    tops = np.flatnonzero((values >= beside[:-2]) & (values >= beside[2:]))
    for i in tops[np.argsort(-values[tops])[:_TOPS]]:
        low, high, *wider = times[np.clip([i - 1, i + 1, i - 2, i + 2], 0, len(times) - 1)].tolist()
        if np.isfinite(values[i]) and values[i] >= _NEAR * values.max() and low < high:
            yield low, high, wider[0], wider[1]


def _apart(found: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Of values and the durations [s] at which they are, the greatest first, those that are no neighbours."""
    kept_ones = list[tuple[float, float]]()
    for value, at in sorted(found, reverse=True):
        if len(kept_ones) < _TOPS and all(abs(at - other) > _APART * other for _, other in kept_ones):
            kept_ones.append((value, at))
    return kept_ones


def _around(values: FloatArray, times: FloatArray) -> FloatArray:
    """A little on both sides of the top of the parabola through three values (3, n), between the outer two, (2, n)."""
    rise, fall, step = values[1] - values[0], values[1] - values[2], 0.5 * (times[2] - times[0])
    top = times[1] + 0.5 * step * (rise - fall) / np.maximum(rise + fall, 1e-300)
    return np.asarray(np.clip([top - _NARROWER * step, top + _NARROWER * step], times[0], times[2]))


def durations(low: float, high: float, fastest: float) -> FloatArray:
    """Durations to look at [s], rising: as dense as the fastest rate of a machine [1/s] asks for."""
    step = 2.0 * np.pi / max(fastest, 1e-300) / _IN_A_PERIOD
    begin = low if low > 0.0 else min(_SHORT * step * _IN_A_PERIOD, 1e-3 * high)
    bend = min(max(step / (_RATIO - 1.0), begin), high)
    short = np.geomspace(begin, bend, max(2, int(np.ceil(np.log(bend / begin) / np.log(_RATIO))) + 1))
    short = np.append(low or LEAST * high, short)
    return np.unique(np.concatenate([short, np.linspace(bend, high, int(np.ceil((high - bend) / step)) + 1)]))
