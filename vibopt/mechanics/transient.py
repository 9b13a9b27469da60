"""Motion under loads that change with time, from rest, exactly; and its greatest value.

Between two joints the load itself answers a linear system (a ramp, a sine, a decaying one), so that motion and load
together follow z' = A z.  Behind the last joint the machine vibrates freely, or under sines that go on for ever: the
search goes on until the energy that is left cannot lift the reading above what was found, or only what lasts is left,
or over a thousand periods of what is next to undamped.

Many like machines go through the load side by side: all that is of one has their number in front, written "...".
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from vibopt.arrays import FloatArray, IntArray
from vibopt.errors import InputError
from vibopt.mechanics.joints import UnlikeError
from vibopt.mechanics.normalised import Normalised
from vibopt.mechanics.panels import Along, Numbers, TooLongError, exponential
from vibopt.mechanics.peaks_in_time import Peak, Peaks
from vibopt.mechanics.pulsed import peaks_by_modes
from vibopt.mechanics.readout import Reading
from vibopt.mechanics.ringing import Behind
from vibopt.mechanics.stacked import moved, read_at, stepped, wide
from vibopt.mechanics.stretches import (
    Stretch,
    add_before,
    after,
    back_at_rest,
    own_lengths,
    steps_of,
)
from vibopt.records import cached_property, dataclass
from vibopt.signals import Segment

_JOINED = 1e-12
"""Part of a time within which it is a joint."""
_LOOKED_AT, _FEW, _MANY = 3.0, 8, 4096
"""Samples in a radian of the fastest motion, and in one segment, of a rough look."""
_TOO_OFTEN = (
    "The machine moves to and fro more often while a load lasts than is followed. Write a shorter load, a smaller "
    '"to" for the stiffness or damping of what is fastest, or a greater "from" for its mass.'
)


@dataclass(frozen=True)
class Transient(Normalised):
    """The same machines under the load: states from joint to joint, and what is read of them at any time."""

    def peak(self, reading: Reading) -> Peak:
        """Greatest size of a reading from the beginning on, for ever."""
        return self.peaks(reading).each()[0]

    def peaks(self, reading: Reading) -> Peaks:
        """The same of each of many machines.

        Raises
        ------
        InputError
            A machine moves to and fro too often while a load lasts.
        """
        row = self.row_of_one if self.mass.ndim == 2 else self
        known = peaks_by_modes(row, reading)
        if known is None:
            return row._peaks_of_row(reading)
        found, good = known
        if not good.all():
            rest = np.flatnonzero(~good)
            found.put(rest, row.some(rest)._peaks_of_row(reading.of(rest)))
        return found

    def _peaks_of_row(self, reading: Reading) -> Peaks:
        """By exponentials of matrices, of machines in a row."""
        try:
            return self._peaks(reading)
        except (TooLongError, UnlikeError) as error:
            if len(self.mass) == 1:
                raise InputError(_TOO_OFTEN) if isinstance(error, TooLongError) else error from None
            each = np.arange(len(self.mass))[:, None]
            return Peaks.of([self.some(one).peaks(reading.of(one)) for one in each])

    def _peaks(self, reading: Reading) -> Peaks:
        count = len(self.mass)
        peaks, begun, ended, seen = Peaks.none(count), 0, np.zeros(count), np.zeros((count, self.size))
        for stretch in self.stretches:
            seen = np.maximum(seen, stretch.sizes)
            best = stretch.highest(self._row_on(stretch, reading), np.abs(peaks.value))
            joints = np.broadcast_to(stretch.joints, (count, stretch.count + 1))
            low, high = (np.take_along_axis(joints, best.start[:, None] + k, 1)[:, 0] for k in (0, 1))
            part = best.at * (high - low)
            peaks.take(best.value, ended + low + part, begun + best.start, part)
            begun, ended = begun + stretch.count, ended + joints[:, -1]
        self.behind.follow(reading, peaks, begun, ended, seen)
        return peaks

    @cached_property
    def row_of_one(self) -> Transient:
        """A lone machine, in a row."""
        return replace(self, mass=self.mass[None], damping=self.damping[None], stiffness=self.stiffness[None])

    def some(self, those: IntArray) -> Transient:
        """One or some machines of many, in a row."""
        return replace(self, mass=self.mass[those], damping=self.damping[those], stiffness=self.stiffness[those],
                       segments=tuple(segment.of(those) for segment in self.segments))  # fmt: skip

    @cached_property
    def behind(self) -> Behind:
        """What follows the last joint."""
        return Behind(self)

    def glimpses(self, reading: Reading, behind: FloatArray) -> FloatArray:
        """Greatest size of a reading at many times of the load and so long behind it [s], (...), its peak or less."""
        sizes = [np.abs(values[0]).max(axis=(-2, -1)) for _, values in self.samples([reading], behind)]
        return np.asarray(np.max(sizes, axis=0))

    def few_samples(self, readings: Sequence[Reading], behind: FloatArray, few: int) -> tuple[FloatArray, FloatArray]:
        """About so many times [s] of machines in a row, (n, many), and all readings there, (n_readings, n, many).

        Some early, with growing distances, and those at which the first reading is greatest.
        """
        every: list[tuple[FloatArray, FloatArray]] = []
        for times, values in self.samples(readings, behind):
            flat = values.reshape(*values.shape[:2], -1)
            early = np.unique(np.geomspace(1.0, flat.shape[-1], few).astype(int)) - 1
            top = np.abs(flat[0]).argmax(axis=-1)[:, None]
            chosen = np.concatenate([np.broadcast_to(early, (len(top), len(early))), top], axis=1)
            times = np.broadcast_to(times, values.shape[1:]).reshape(len(top), -1)
            every.append((np.take_along_axis(times, chosen, 1), np.take_along_axis(flat, chosen[None], 2)))
        return np.concatenate([one for one, _ in every], axis=1), np.concatenate([one for _, one in every], axis=2)

    def times_above(self, reading: Reading, levels: FloatArray, times: FloatArray) -> FloatArray:
        """About the first times [s] at which a reading is as great in size, (...); `times` where none is earlier."""
        first = np.array(times)
        load = sum((segment.length for segment in self.finite), np.zeros(()))
        for at, (values,) in self.samples([reading], np.maximum(times - load, 0.0)):
            above = np.where(np.abs(values) >= levels[..., None, None], at, np.inf)
            first = np.minimum(first, above.min(axis=(-2, -1)))
        return first

    def samples(self, readings: Sequence[Reading], behind: FloatArray) -> Iterator[tuple[FloatArray, FloatArray]]:
        """Times [s], (..., n, many), and each reading at them: of all segments of a stretch, and of what follows so
        long.
        """
        ended: FloatArray = np.zeros(())
        for stretch in self.stretches:
            joints, starts = stretch.joints, stretch.starts[..., None, :] if stretch.uneven else stretch.starts
            parts, values = self._sampled(readings, stretch.a, starts, stretch.length)
            lengths = stretch.length[:, None] if stretch.uneven else wide(stretch.length)
            yield (
                ended[..., None, None] + joints[..., :-1, None] + parts * lengths,
                values.reshape(*values.shape[: stretch.starts.ndim], len(parts)),
            )
            ended = ended + joints[..., -1]
        a, start = self.onward(self.left)
        parts, values = self._sampled(readings, a * wide(self.rate * behind), start[..., None, :], behind)
        yield wide(ended) + parts * wide(behind), values

    def _sampled(
        self, readings: Sequence[Reading], a: Numbers, starts: Numbers, length: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Parts of pieces of so many seconds, (many,), and each reading there from each start, (..., n, many)."""
        span = self._span(a, length)
        count = int(np.clip(_LOOKED_AT * float(np.max(span)), _FEW, _MANY))
        whole = a / wide(np.maximum(span, 1e-300))
        rows = stepped(exponential(a / count).mT, np.stack([self.row(reading, whole) for reading in readings]), count)
        return np.arange(count + 1) / count, starts @ rows.mT

    def at(self, reading: Reading, within: int | IntArray, part: float | FloatArray) -> Numbers:
        """The reading so many seconds behind the beginning of a segment, each (...), as of a peak of a like machine."""
        within, part = np.broadcast_arrays(within, part)
        begun, found = 0, np.zeros(within.shape, dtype=np.result_type(self.own, reading.row, reading.rates))
        for stretch in self.stretches:
            inside = (within >= begun) & (within < begun + stretch.count)
            if inside.any():
                a, length, starts = stretch.of(np.clip(within - begun, 0, stretch.count - 1))
                row = self.row(reading, a / wide(self.rate * length))
                found = np.where(inside, moved(row, a * wide(part / length), starts), found)
            begun += stretch.count
        if (within >= begun).any():
            a, start = self.onward(self.left)
            found = np.where(within >= begun, moved(self.row(reading, a), a * wide(self.rate * part), start), found)
        return found

    def placed(self, times: FloatArray) -> tuple[IntArray, FloatArray]:
        """Segments and seconds behind their beginnings of times [s], as of peaks."""
        begins = np.cumsum([0.0, *(segment.length for segment in self.finite)])
        within = np.searchsorted(begins[1:], times, side="right")
        return within, times - begins[within]

    def history(self, reading: Reading, times: FloatArray) -> FloatArray:
        """The reading of a lone machine at times [s] that rise, (n,)."""
        found, ended = np.zeros(len(times)), 0.0
        for stretch in self.stretches:
            through = ended + float(stretch.joints[-1])
            inside = np.flatnonzero((times >= ended * (1.0 - _JOINED)) & (times < through * (1.0 - _JOINED)))
            found[inside] = stretch.read(self._row_on(stretch, reading), times[inside] - ended)
            ended = through
        a, begin = self.onward(self.left)
        behind = np.flatnonzero(times >= ended * (1.0 - _JOINED))
        gone = np.maximum(times[behind] - ended, 0.0)
        longest = float(gone.max(initial=0.0)) or 1.0
        row = self.row(reading, a)
        found[behind] = read_at(row, a * (self.rate * longest), gone / longest, begin[None, :])
        return found

    def reached(self, reading: Reading) -> float:
        """How great a reading of a lone machine could be of free motions as large as come while the load lasts."""
        a, left = self.onward(self.left)
        free = np.r_[: self.parts[3], self.size // 2 : self.size // 2 + self.parts[3]]
        last = self.segments[-1]
        driven = np.abs(self._pushed @ last.read).sum(axis=-1) * np.abs(last.start).max()
        every = [left, driven, *(stretch.starts for stretch in self.stretches)]
        largest = np.max([np.abs(one[..., free]).reshape(-1, len(free)).max(axis=0) for one in every], axis=0)
        return float(np.linalg.norm(self.row(reading, a)[free]) * np.linalg.norm(largest))

    @cached_property
    def stretches(self) -> list[Stretch]:
        """The whole load, from rest on."""
        found, state = [], self.begun
        for alike in self.runs:
            lengths = own_lengths(alike)
            a = self.whole(alike[0], lengths)
            along = Along(a) if lengths is None and a.ndim == 3 and not np.iscomplexobj(a) else None
            starts, state = self._through(alike, state, steps_of(a) if along is None else along.whole)
            found.append(Stretch(a, np.asarray(alike[0].length if lengths is None else lengths), starts, state, along))
        return found

    def _span(self, a: Numbers, length: FloatArray) -> FloatArray:
        """Of segments a (..., N, N) or (..., n, N, N) of these lengths [s], in 1 / rate."""
        return np.asarray((self.rate[..., None] if a.ndim > self.mass.ndim else self.rate) * length)

    def _row_on(self, stretch: Stretch, reading: Reading) -> Numbers:
        """Row over the states on a stretch, (..., N), or on each of its segments (..., n, N)."""
        return self.row(reading, stretch.a / wide(self._span(stretch.a, stretch.length)))

    @cached_property
    def left(self) -> Numbers:
        """State behind the load, (..., size)."""
        if not self.stretches:
            return self.begun
        long = self.rate * sum(segment.length for segment in self.finite)
        return back_at_rest(self.stretches, self.parts[3], long)

    def onward(self, state: Numbers) -> tuple[Numbers, Numbers]:
        """A of what follows behind the last joint, time in 1 / rate, and the states there, those of signals last."""
        last = self.segments[-1]
        if not last.endless:
            return self.own, state
        struck = state + (self._pushed @ last.blows[..., None])[..., 0] * self.rate[..., None]
        start = np.broadcast_to(last.start, (*state.shape[:-1], last.start.shape[-1]))
        return self.whole(last) / wide(self.rate * last.length), np.concatenate([struck, start], axis=-1)

    def _through(self, alike: list[Segment], state: Numbers, step: Numbers) -> tuple[Numbers, Numbers]:
        """States at the beginning of each of a run of segments, (..., n, N), and behind the last, (..., size)."""
        size = self.size
        signals = np.stack([segment.start for segment in alike], axis=-2)
        blows = np.stack([segment.blows for segment in alike], axis=-2) @ self._pushed.mT * wide(self.rate)
        states = np.empty((*state.shape[:-1], len(alike) + 1, size), dtype=np.result_type(state, self.own))
        states[..., 0, :] = state + blows[..., 0, :]
        signals = np.broadcast_to(signals, (*state.shape[:-1], *signals.shape[-2:]))
        states[..., 1:, :] = after(step[..., :size, size:], signals)
        states[..., 1:-1, :] += blows[..., 1:, :]
        add_before(states, step[..., :size, :size])
        return np.concatenate([states[..., :-1, :], signals], axis=-1), states[..., -1, :]
