"""Motion under loads that change with time, from rest, exactly; and its greatest value.

Between two joints the load itself answers a linear system (a ramp, a sine, a decaying one), so that motion and load
together follow z' = A z.  Behind the last joint the machine vibrates freely, or under sines that go on for ever: the
search goes on until the energy that is left cannot lift the reading above what was found, or only what lasts is left,
or over a thousand periods of what is next to undamped.

Displacements are counted in mass-normalised coordinates and time in the inverse of the fastest rate, so that
exponentials keep their digits.  States and readings take complex coefficients, too: an imaginary part is a slope.
Many like machines go through the load side by side: all that is of one has their number in front, written "...".
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from vibopt.arrays import BoolArray, FloatArray, IntArray
from vibopt.errors import InputError
from vibopt.mechanics.joints import Condensed, UnlikeError, condensed, eliminated, riding
from vibopt.mechanics.panels import Along, Numbers, TooLongError, exponential
from vibopt.mechanics.peaks_in_time import Peak, Peaks
from vibopt.mechanics.pulsed import peaks_by_modes
from vibopt.mechanics.ringing import Behind
from vibopt.mechanics.stacked import cholesky, moved, product, read_at, row_sum, stepped, trace, wide
from vibopt.mechanics.stretches import (
    Stretch,
    add_before,
    after,
    back_at_rest,
    come_back,
    own_lengths,
    runs_of,
    steps_of,
)
from vibopt.records import cached_property, dataclass
from vibopt.signals import Segment

_JOINED, _CANCELLED = 1e-12, 1e-15
"""Part of a time within which it is a joint, and of what cancels in a reading that is its rounding."""
_LONG = 1e3
"""Radians of the fastest motion from which on a load is never brief."""
_LOOKED_AT, _FEW, _MANY = 3.0, 8, 4096
"""Samples in a radian of the fastest motion, and in one segment, of a rough look."""
_TOO_OFTEN = (
    "The machine moves to and fro more often while a load lasts than is followed. Write a shorter load, a smaller "
    '"to" for the stiffness or damping of what is fastest, or a greater "from" for its mass.'
)


@dataclass(frozen=True, slots=True)
class Reading:
    """row . u + rates . u' + inertia . u'', differentiated `power` times; rows (..., n_coords), real or complex.

    grip
        Dry friction in it, against a stretch of the link that rubs.
    """

    row: Numbers
    rates: Numbers
    inertia: Numbers
    power: int = 0
    grip: float = 0.0

    def of(self, index: int | IntArray) -> Reading:
        """Of one or some of many machines."""
        row, rates, inertia = (one if one.ndim == 1 else one[index] for one in (self.row, self.rates, self.inertia))
        return Reading(row, rates, inertia, self.power)


@dataclass(frozen=True)
class Transient:
    """Linear machines at rest, and the load that then comes.

    mass, damping, stiffness
        Of all coordinates, those of the bases last, (..., n_coords, n_coords) [kg, N s/m, N/m].
    n_free
        Number of free coordinates.
    loads
        (n_coords, n_signals): force on free coordinates [N], acceleration of bases [m/s^2], for a signal of one.
    segments
        The signals, of all machines or of each.
    """

    mass: Numbers
    damping: Numbers
    stiffness: Numbers
    n_free: int
    loads: FloatArray
    segments: tuple[Segment, ...]

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

    @cached_property
    def begun(self) -> Numbers:
        """State before the first blow, (..., size): at rest, or as bodies are let go."""
        released, half = self.segments[0].released, self.size // 2
        state = np.zeros((*self.mass.shape[:-2], self.size), dtype=self.root.dtype)
        if released is None:
            return state
        n, heavy = self.parts[3:]
        kept = np.arange(n) if self.jointed is None else self.jointed.kept
        begins = np.linalg.solve(self.root, (self.loads[kept] @ released) / wide(self.scale))
        state[..., :n], state[..., half : half + heavy] = begins[..., 0], begins[..., :heavy, 1] / self.rate[..., None]
        return state

    @cached_property
    def jointed(self) -> Condensed | None:
        """The machine without coordinates that only springs hold; None where all have mass."""
        if self.mass[..., : self.n_free, :].any(axis=-1).all():
            return None
        return condensed(self.mass, self.damping, self.stiffness, self.n_free)

    @cached_property
    def parts(self) -> tuple[Numbers, Numbers, Numbers, int, int]:
        """Mass, damping, stiffness of the coordinates that are states, the number of free ones, and with mass."""
        condensed = self.jointed
        if condensed is None:
            return self.mass, self.damping, self.stiffness, self.n_free, self.n_free
        return condensed.mass, condensed.damping, condensed.stiffness, condensed.n, condensed.heavy

    @cached_property
    def root(self) -> Numbers:
        """Free coordinates from normalised ones, (..., n, n): of mass one, or where there is none of damping one."""
        mass, damping, _, n, heavy = self.parts
        kind = np.result_type(self.mass, self.damping, self.stiffness)
        root = np.asarray(np.linalg.inv(cholesky(mass[..., :heavy, :heavy])).mT, dtype=kind)
        if heavy == n:
            return root
        whole = np.zeros((*mass.shape[:-2], n, n), dtype=kind)
        whole[..., :heavy, :heavy] = root
        size = np.sqrt(self._rate_of(root, heavy))
        whole[..., heavy:, heavy:] = np.linalg.inv(cholesky(damping[..., heavy:n, heavy:n])).mT * wide(size)
        return whole

    def _rate_of(self, root: Numbers, n: int) -> FloatArray:
        """A rate [1/s] that none of the first n coordinates has by itself."""
        stiff, damped = (root.mT @ one[..., :n, :n] @ root for one in (self.parts[2], self.parts[1]))
        fast = np.sqrt(row_sum(stiff.real)) + row_sum(damped.real)
        return np.where(fast > 0.0, fast, 1.0 / sum(segment.length for segment in self.segments))

    @cached_property
    def rate(self) -> FloatArray:
        """A rate [1/s] that none of the machine's exceeds, (...)."""
        _, damping, stiffness, n, heavy = self.parts
        rate = self._rate_of(self.root[..., :heavy, :heavy], heavy)
        if heavy == n:
            return rate
        elastic, braked = (
            self.root.mT @ one[..., :n, :n] @ self.root for one in (stiffness / wide(rate**2), damping / wide(rate))
        )
        return np.asarray(rate * np.maximum(1.0, row_sum(eliminated(elastic, braked, heavy).real)))

    @property
    def size(self) -> int:
        """Number of states without those of the signals: all motions, those of the bases last, and their rates.

        The rate of what has no mass is no state: its place stays empty.
        """
        return 2 * int(self.parts[0].shape[-1])

    @cached_property
    def scale(self) -> FloatArray:
        """Unit of the states, (...): what signals of one push, or halvings of what is pushed much would take digits."""
        kinds = [self.segments[-1].read, *(alike[0].read for alike in self.runs)]
        most = np.max([np.abs(self._pushed_by_one @ one).max(axis=(-2, -1), initial=0.0) for one in kinds], axis=0)
        return np.where(most > 0.0, most, 1.0)

    @cached_property
    def places(self) -> Numbers:
        """All coordinates from the first half of the states, (..., n_coords, size / 2)."""
        return self._turned if self.jointed is None else np.asarray(self.jointed.lift @ self._turned)

    @cached_property
    def _turned(self) -> Numbers:
        """Coordinates that are states from the first half of the states, (..., size / 2, size / 2)."""
        mass, _, _, n, _ = self.parts
        whole = np.zeros(mass.shape, dtype=self.root.dtype)
        whole[..., :n, :n] = self.root
        own = np.arange(n, mass.shape[-1])
        unit = 1.0 / np.sqrt(trace(mass[..., :n, :n]))
        whole[..., own, own] = unit[..., None]
        whole[..., :n, n:] = self.ride * wide(unit)
        return whole

    @cached_property
    def ride(self) -> Numbers:
        """How free coordinates follow the bases when these move slowly, (..., n, n_bases): places count from there.

        A base that is pushed for a thousand periods is far away, and what is near it would be lost in rounding.  One
        that comes back before anything follows it is not: what hardly moves would be lost beside it.
        """
        found = riding(self.parts[2], self.parts[3])
        brief = self._brief if found.any() else np.zeros(())
        return np.where(wide(brief), 0.0, found) if brief.any() else found

    @cached_property
    def _brief(self) -> BoolArray:
        """Whether bases are moved to and back so briefly that fast coordinates follow them less than slow ones do not,
        (...).
        """
        long = sum(segment.length for segment in self.segments)
        heavy, turned = self.parts[4], np.asarray(self.rate * long)
        if self.segments[-1].endless or (turned >= _LONG).all():
            return np.zeros(turned.shape, dtype=bool)
        root = self.root[..., :heavy, :heavy].real
        held = np.linalg.eigvalsh(root.mT @ self.parts[2][..., :heavy, :heavy].real @ root)[..., 0]
        brief = (turned < _LONG) & (turned * np.sqrt(np.maximum(held, 0.0)) * long < 1.0)
        led = np.flatnonzero(self.loads[self.n_free :].any(axis=0))
        return np.asarray(brief & (brief.any() and come_back(self.runs, led)))

    @cached_property
    def _rides(self) -> FloatArray:
        return wide(self.ride.any(axis=(-2, -1)))

    @cached_property
    def elastic(self) -> Numbers:
        """Forces on the normalised free coordinates per place, (..., n, size / 2), time in 1 / rate."""
        n = self.parts[3]
        found = np.asarray(self.root.mT @ self.parts[2][..., :n, :] @ self._turned / wide(self.rate**2))
        if self._rides.any():
            found[..., n:] = np.where(self._rides, 0.0, found[..., n:])
        return found

    @cached_property
    def braked(self) -> Numbers:
        """The same per rate."""
        n = self.parts[3]
        found = np.asarray(self.root.mT @ self.parts[1][..., :n, :] @ self._turned / wide(self.rate))
        if self._rides.any():
            riding = self.root.mT @ product(self.parts[1][..., :n, :], self._turned[..., n:]) / wide(self.rate)
            found[..., n:] = np.where(self._rides, riding, found[..., n:])
        return found

    @cached_property
    def own(self) -> Numbers:
        """A of the machine by itself, (..., size, size), time in 1 / rate."""
        n, heavy = self.parts[3:]
        half = self.size // 2
        a = np.zeros((*self.mass.shape[:-2], self.size, self.size), dtype=self.root.dtype)
        a[..., :half, half:] = np.eye(half)
        if heavy == n:
            a[..., half : half + n, :half], a[..., half : half + n, half:] = -self.elastic, -self.braked
            return a
        rows = eliminated(self.elastic, self.braked, heavy)
        a[..., heavy:n, :], a[..., half : half + heavy, :] = rows[..., heavy:, :], rows[..., :heavy, :]
        return a

    @cached_property
    def struck(self) -> Numbers:
        """States behind a blow of one on each free coordinate, (..., size, n_free), time in 1 / rate."""
        n, heavy = self.parts[3:]
        half, forces = self.size // 2, self.root.mT
        if self.jointed is not None:
            forces = forces @ self.jointed.lift[..., : self.n_free, :n].mT
        b = np.zeros((*self.mass.shape[:-2], self.size, self.n_free), dtype=self.root.dtype)
        b[..., half : half + heavy, :] = forces[..., :heavy, :]
        if heavy < n:
            b[..., heavy:n, :] = np.linalg.solve(self.braked[..., heavy:, heavy:n], forces[..., heavy:, :])
            b[..., half : half + heavy, :] -= self.braked[..., :heavy, heavy:n] @ b[..., heavy:n, :]
        return b / wide(self.rate)

    @cached_property
    def _pushed_by_one(self) -> Numbers:
        """What signals of one add to the rates of the states, (..., size, n_signals), time in 1 / rate."""
        own, n, half = self.n_free, self.parts[3], self.size // 2
        led = self.mass[..., :own, own:]
        if self._rides.any():
            lift = np.eye(own, self.mass.shape[-1]) if self.jointed is None else self.jointed.lift[..., :own, :]
            led = led + self.mass[..., :own, :own] @ (lift[..., :n] @ self.ride + lift[..., n:] * self._rides)
        b = self.struck @ (self.loads[:own] - led @ self.loads[own:]) / wide(self.rate)
        unit = np.sqrt(trace(self.mass[..., :own, :own])) / self.rate**2
        b[..., half + n :, :] = self.loads[own:] * wide(unit)
        return b

    @cached_property
    def _pushed(self) -> Numbers:
        return self._pushed_by_one / wide(self.scale)

    def whole(self, segment: Segment, lengths: FloatArray | None = None) -> Numbers:
        """A of machine and signal together, (..., N, N), time from 0 to 1 on a segment.

        Of segments like it with lengths (n,) of their own (..., n, N, N).
        """
        own, pushed, size, more = self.own, self._pushed @ segment.read, self.size, segment.start.shape[-1]
        span, front = wide(self.rate * segment.length), self.mass.shape[:-2]
        if lengths is not None:
            own, pushed = own[..., None, :, :], pushed[..., None, :, :]
            span, front = wide(self.rate[..., None] * lengths), (*front, len(lengths))
        a = np.zeros((*front, size + more, size + more), dtype=own.dtype)
        a[..., :size, :size] = own * span
        a[..., :size, size:] = pushed * span
        a[..., size:, size:] = segment.rates
        return a

    def row(self, reading: Reading, a: Numbers) -> Numbers:
        """Row over the states that a reading is, (..., N), where z' = a z, time in 1 / rate."""
        places = np.zeros((*self.places.shape[:-1], a.shape[-1]), dtype=self.root.dtype)
        places[..., : self.size // 2] = self.places
        rows = np.stack([reading.row, reading.rates, reading.inertia], axis=-2)
        found, rate, scale = product(rows, places), wide(self.rate), wide(self.scale)
        if a.ndim > places.ndim:  # of each segment
            found, rate, scale = found[..., None, :, :], rate[..., None], scale[..., None]
        both = (found, a * rate), (np.abs(found), np.abs(a) * rate)
        row, size = (self._read_by(one, many, reading.power) for one, many in both)
        row = np.where(np.abs(row) > _CANCELLED * size, row, 0.0)
        return np.asarray(row * scale)[..., 0, :]

    @staticmethod
    def _read_by(found: Numbers, rates: Numbers, power: int) -> Numbers:
        """Displacement, rate and acceleration (..., 3, N) of states with z' = rates z as one row (..., 1, N)."""
        row = found[..., :1, :] + (found[..., 1:2, :] + found[..., 2:, :] @ rates) @ rates
        for _ in range(power):
            row = row @ rates
        return np.asarray(row)

    @property
    def finite(self) -> tuple[Segment, ...]:
        """All segments but one that goes on for ever, which is the last."""
        return self.segments[:-1] if self.segments[-1].endless else self.segments

    @cached_property
    def runs(self) -> list[list[Segment]]:
        """Segments of one kind that follow each other, as far as they end: of one length, or very many of any."""
        return runs_of(self.finite)

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
