"""Motion under loads that change with time, from rest, exactly; and its greatest value.

Between two joints the load itself answers a linear system (a ramp, a sine, a decaying one), so that motion and load
together follow z' = A z.  Behind the last joint the machine vibrates freely, or under sines that go on for ever: the
search goes on until the energy that is left cannot lift the reading above what was found, or only what lasts is left,
or over a thousand periods of what is next to undamped.

Displacements are counted in mass-normalised coordinates and time in the inverse of the fastest rate, so that
exponentials keep their digits.  States and readings take complex coefficients, too: an imaginary part is a slope.
"""

from __future__ import annotations

from functools import cached_property
from itertools import groupby

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.mechanics.joints import Condensed, condensed, eliminated
from vibopt.mechanics.panels import Numbers, exponential, exponentials, greatest
from vibopt.mechanics.ringing import Peak, Ringing
from vibopt.records import dataclass
from vibopt.signals import Segment

_NOTHING = 1e-12
"""Part of its size below which a state, a reading or a damping is rounding."""
_HELD, _FOLLOWS = 1e6, 1e-9
"""Condition of the stiffness up to which bodies follow a base that moves slowly; rounding of how far."""
_JOINED, _AT_ONCE = 1e-12, 256
"""Part of a time within which it is a joint; exponentials that are made at once."""
_LOOKED_AT, _FEW, _MANY = 3.0, 8, 4096
"""Samples in a radian of the fastest motion, and in one segment, of a rough look."""


@dataclass(frozen=True, slots=True)
class Reading:
    """row . u + rates . u' + inertia . u'', differentiated `power` times; rows (n_coords,), real or complex."""

    row: Numbers
    rates: Numbers
    inertia: Numbers
    power: int = 0


@dataclass(frozen=True, slots=True)
class Stretch:
    """Segments of one length and one kind, each z' = a z over times 0 to 1.

    a
        Of machine and signal together, (N, N).
    length
        Of each [s].
    starts, left
        States at the beginning of each, (n, N), and of the machine behind the last, (size,).
    """

    a: Numbers
    length: float
    starts: Numbers
    left: Numbers


@dataclass(frozen=True)
class Transient:
    """A linear machine at rest, and the load that then comes.

    mass, damping, stiffness
        Of all coordinates, those of the bases last, (n_coords, n_coords) [kg, N s/m, N/m].
    n_free
        Number of free coordinates.
    loads
        (n_coords, n_signals): force on free coordinates [N], acceleration of bases [m/s^2], for a signal of one.
    segments
        The signals.
    """

    mass: Numbers
    damping: Numbers
    stiffness: Numbers
    n_free: int
    loads: FloatArray
    segments: tuple[Segment, ...]

    def peak(self, reading: Reading) -> Peak:
        """Greatest size of a reading from the beginning on, for ever."""
        found = Peak(0.0, 0.0)
        begun, ended, seen = 0, 0.0, np.zeros(self.size)
        for one in self.stretches:
            seen = np.maximum(seen, np.abs(one.starts[:, : self.size]).max(axis=0))
            best = greatest(one.a, self.row(reading, one.a / (self.rate * one.length)), one.starts, abs(found.value))
            if best is not None:
                part = best.at * one.length
                found = Peak(best.value, ended + best.start * one.length + part, begun + best.start, part)
            begun, ended = begun + len(one.starts), ended + len(one.starts) * one.length
        return Ringing(self, reading, self.left).peak(found, begun, ended, seen)

    def glimpse(self, reading: Reading, behind: float) -> float:
        """Greatest size of a reading at many times of the load and so long behind it [s]: no more than the peak."""
        found = 0.0
        for one in self.stretches:
            count = int(np.clip(_LOOKED_AT * self.rate * one.length, _FEW, _MANY))
            step, row = exponential(one.a / count), self.row(reading, one.a / (self.rate * one.length))
            found = max(found, *(float(np.abs(_steps(step, start, count) @ row).max()) for start in one.starts))
        a, start = self.onward(self.left)
        count = int(np.clip(_LOOKED_AT * self.rate * behind, _FEW, _MANY))
        values = _steps(exponential(a * (self.rate * behind / count)), start, count) @ self.row(reading, a)
        return max(found, float(np.abs(values).max()))

    def at(self, reading: Reading, peak: Peak) -> complex:
        """The reading where a peak of the like machine lies."""
        begun = 0
        for one in self.stretches:
            if begun <= peak.within < begun + len(one.starts):
                row = self.row(reading, one.a / (self.rate * one.length))
                return complex(row @ exponential(one.a, peak.part / one.length) @ one.starts[peak.within - begun])
            begun += len(one.starts)
        a, start = self.onward(self.left)
        return complex(self.row(reading, a) @ exponential(a * (self.rate * peak.part)) @ start)

    def placed(self, time: float) -> Peak:
        """A time [s] as the place of a peak."""
        begun = 0.0
        for index, segment in enumerate(self.finite):
            if time < begun + segment.length:
                return Peak(0.0, time, index, time - begun)
            begun += segment.length
        return Peak(0.0, time, len(self.finite), time - begun)

    def first_above(self, reading: Reading, level: float, peak: Peak) -> float:
        """About the first time [s] at which the size of the reading is `level`; that of `peak` if none is earlier."""
        state, ended = np.zeros(self.size), 0.0
        for segment in (*self.finite[: peak.within + 1], None):
            whole = peak.time - ended if segment is None else segment.length
            length = min(whole, peak.time - ended)
            if length <= 0.0:
                break
            behind, start = self.onward(state)
            starts, after = (start[None, :], state) if segment is None else self.through([segment], state)
            a = behind * (self.rate * length) if segment is None else self.whole(segment) * (length / whole)
            count = int(np.clip(_LOOKED_AT * self.rate * length, _FEW, _MANY))
            values = _steps(exponential(a / count), starts[0], count) @ self.row(reading, a / (self.rate * length))
            above = np.flatnonzero(np.abs(values) >= level)
            if len(above):
                return float(ended + length * above[0] / count)
            state, ended = after, ended + length
        return peak.time

    def history(self, reading: Reading, times: FloatArray) -> FloatArray:
        """The reading at times [s] that rise, (n,)."""
        found, ended = np.zeros(len(times)), 0.0
        for one in self.stretches:
            through, length = ended + len(one.starts) * one.length, one.length
            inside = np.flatnonzero((times >= ended * (1.0 - _JOINED)) & (times < through * (1.0 - _JOINED)))
            parts = (times[inside] - ended) / length
            which = np.minimum((parts * (1.0 + _JOINED) + _JOINED).astype(int), len(one.starts) - 1)
            row = self.row(reading, one.a / (self.rate * length))
            found[inside] = _read(row, one.a, np.clip(parts - which, 0.0, 1.0), one.starts[which])
            ended = through
        a, begin = self.onward(self.left)
        behind = np.flatnonzero(times >= ended * (1.0 - _JOINED))
        gone = np.maximum(times[behind] - ended, 0.0)
        longest = float(gone.max(initial=0.0)) or 1.0
        row = self.row(reading, a)
        found[behind] = _read(row, a * (self.rate * longest), gone / longest, begin[None, :])
        return found

    @cached_property
    def stretches(self) -> list[Stretch]:
        """The whole load, from rest on."""
        found, state = [], np.zeros(self.size)
        for alike in self.runs:
            starts, state = self.through(alike, state)
            found.append(Stretch(self.whole(alike[0]), alike[0].length, starts, state))
        return found

    @property
    def left(self) -> Numbers:
        """State behind the load, (size,)."""
        return self.stretches[-1].left if self.stretches else np.zeros(self.size)

    @cached_property
    def jointed(self) -> Condensed | None:
        """The machine without coordinates that only springs hold; None where all have mass."""
        if self.mass[: self.n_free].any(axis=1).all():
            return None
        return condensed(self.mass, self.damping, self.stiffness, self.n_free)

    @cached_property
    def parts(self) -> tuple[Numbers, Numbers, Numbers, int, int]:
        """Mass, damping, stiffness of the coordinates that are states, the number of free ones, and with mass."""
        one = self.jointed
        if one is None:
            return self.mass, self.damping, self.stiffness, self.n_free, self.n_free
        return one.mass, one.damping, one.stiffness, one.n, one.heavy

    @cached_property
    def root(self) -> Numbers:
        """Free coordinates from normalised ones, (n, n): of mass one, or next to that of damping one without mass."""
        mass, damping, _, n, heavy = self.parts
        kind = np.result_type(self.mass, self.damping, self.stiffness)
        root = np.asarray(np.linalg.inv(_cholesky(mass[:heavy, :heavy])).T, dtype=kind)
        if heavy == n:
            return root
        whole = np.zeros((n, n), dtype=kind)
        whole[:heavy, :heavy] = root
        size = np.sqrt(self._rate_of(root, heavy))
        whole[heavy:, heavy:] = np.linalg.inv(_cholesky(damping[heavy:n, heavy:n])).T * size
        return whole

    def _rate_of(self, root: Numbers, n: int) -> float:
        """A rate [1/s] that none of the first n coordinates has by itself."""
        stiff, damped = (root.T @ one[:n, :n] @ root for one in (self.parts[2], self.parts[1]))
        fast = float(np.sqrt(np.abs(stiff.real).sum(axis=1).max()) + np.abs(damped.real).sum(axis=1).max())
        return fast or 1.0 / sum(one.length for one in self.segments)

    @cached_property
    def rate(self) -> float:
        """A rate [1/s] that none of the machine's exceeds."""
        _, damping, stiffness, n, heavy = self.parts
        rate = self._rate_of(self.root[:heavy, :heavy], heavy)
        if heavy == n:
            return rate
        elastic, braked = (self.root.T @ one[:n, :n] @ self.root for one in (stiffness / rate**2, damping / rate))
        return rate * max(1.0, float(np.abs(eliminated(elastic, braked, heavy).real).sum(axis=1).max()))

    @property
    def size(self) -> int:
        """Number of states without those of the signals: all motions, those of the bases last, and their rates.

        The rate of what has no mass is no state: its place stays empty.
        """
        return 2 * len(self.parts[0])

    @cached_property
    def scale(self) -> float:
        """Unit of the states."""
        return float(np.abs(self._pushed_by_one).max(initial=0.0)) or 1.0

    @cached_property
    def places(self) -> Numbers:
        """All coordinates from the first half of the states, (n_coords, size / 2)."""
        return self._turned if self.jointed is None else np.asarray(self.jointed.lift @ self._turned)

    @cached_property
    def _turned(self) -> Numbers:
        """Coordinates that are states from the first half of the states, (size / 2, size / 2)."""
        mass, _, _, n, _ = self.parts
        whole = np.zeros(mass.shape, dtype=self.root.dtype)
        whole[:n, :n] = self.root
        own = np.arange(n, len(whole))
        whole[own, own] = 1.0 / np.sqrt(np.trace(mass[:n, :n]).real)
        whole[:n, n:] = self.ride * whole[own, own]
        return whole

    @cached_property
    def ride(self) -> Numbers:
        """How free coordinates follow the bases when these move slowly, (n, n_bases): places count from there.

        A base that is pushed for a thousand periods is far away, and what is near it would be lost in rounding.
        """
        _, _, stiffness, n, heavy = self.parts
        held, led = stiffness[:n, :n], stiffness[:n, n:]
        if heavy < n or self.jointed is not None or not led.shape[1] or np.linalg.cond(held.real) > _HELD:
            return np.zeros(led.shape, dtype=self.root.dtype)
        back = np.linalg.inv(held.real)
        found, whole = -back @ led.real, np.rint(-back @ led.real)
        found = np.where(np.abs(found - whole) < _FOLLOWS, whole, found)
        if not np.iscomplexobj(stiffness):
            return np.asarray(found)
        turned = held.imag @ found + led.imag
        size = np.abs(back) @ (np.abs(held.imag) @ np.abs(found) + np.abs(led.imag))
        return np.asarray(found - 1j * np.where(np.abs(back @ turned) > _FOLLOWS * size, back @ turned, 0.0))

    @cached_property
    def elastic(self) -> Numbers:
        """Forces on the normalised free coordinates per place, (n, size / 2), time in 1 / rate."""
        found = np.asarray(self.root.T @ self.parts[2][: self.parts[3]] @ self._turned / self.rate**2)
        if self.ride.any():
            found[:, self.parts[3] :] = 0.0
        return found

    @cached_property
    def braked(self) -> Numbers:
        """The same per rate."""
        n = self.parts[3]
        found = np.asarray(self.root.T @ self.parts[1][:n] @ self._turned / self.rate)
        if self.ride.any():
            found[:, n:] = self.root.T @ _product(self.parts[1][:n], self._turned[:, n:]) / self.rate
        return found

    @cached_property
    def own(self) -> Numbers:
        """A of the machine by itself, (size, size), time in 1 / rate."""
        n, heavy = self.parts[3:]
        half = self.size // 2
        a = np.zeros((self.size, self.size), dtype=self.root.dtype)
        a[:half, half:] = np.eye(half)
        if heavy == n:
            a[half : half + n, :half], a[half : half + n, half:] = -self.elastic, -self.braked
            return a
        rows = eliminated(self.elastic, self.braked, heavy)
        a[heavy:n], a[half : half + heavy] = rows[heavy:], rows[:heavy]
        return a

    @cached_property
    def struck(self) -> Numbers:
        """States behind a blow of one on each free coordinate, (size, n_free), time in 1 / rate."""
        n, heavy = self.parts[3:]
        half, forces = self.size // 2, self.root.T
        if self.jointed is not None:
            forces = forces @ self.jointed.lift[: self.n_free, :n].T
        b = np.zeros((self.size, self.n_free), dtype=self.root.dtype)
        b[half : half + heavy] = forces[:heavy]
        if heavy < n:
            b[heavy:n] = np.linalg.solve(self.braked[heavy:, heavy:n], forces[heavy:])
            b[half : half + heavy] -= self.braked[:heavy, heavy:n] @ b[heavy:n]
        return b / self.rate

    @cached_property
    def _pushed_by_one(self) -> Numbers:
        """What signals of one add to the rates of the states, (size, n_signals), time in 1 / rate."""
        own, n, half = self.n_free, self.parts[3], self.size // 2
        led = self.mass[:own, own:]
        if self.ride.any():
            led = led + self.mass[:own, :own] @ self.ride
        b = self.struck @ (self.loads[:own] - led @ self.loads[own:]) / self.rate
        b[half + n :] = self.loads[own:] * np.sqrt(np.trace(self.mass[:own, :own]).real) / self.rate**2
        return b

    @cached_property
    def _pushed(self) -> Numbers:
        return self._pushed_by_one / self.scale

    def whole(self, segment: Segment) -> Numbers:
        """A of machine and signal together, time from 0 to 1 on a segment."""
        size, span = self.size, self.rate * segment.length
        a = np.zeros((size + len(segment.start),) * 2, dtype=self.own.dtype)
        a[:size, :size] = self.own * span
        a[:size, size:] = self._pushed @ segment.read * span
        a[size:, size:] = segment.rates
        return a

    def row(self, reading: Reading, a: Numbers) -> Numbers:
        """Row over the states that a reading is, where z' = a z, time in 1 / rate."""
        places = np.zeros((len(self.mass), len(a)), dtype=self.root.dtype)
        places[:, : self.size // 2] = self.places
        placed, moved, pushed = _product(np.array([reading.row, reading.rates, reading.inertia]), places)
        row = placed + (moved + pushed @ a * self.rate) @ a * self.rate
        for _ in range(reading.power):
            row = row @ a * self.rate
        return np.asarray(row * self.scale)

    @property
    def finite(self) -> tuple[Segment, ...]:
        """All segments but one that goes on for ever, which is the last."""
        return self.segments[:-1] if self.segments[-1].endless else self.segments

    @cached_property
    def runs(self) -> list[list[Segment]]:
        """Segments of one length and one kind that follow each other, as far as they end."""
        return [
            list(run)
            for _, run in groupby(self.finite, lambda one: (one.length, one.rates.tobytes(), one.read.tobytes()))
        ]

    def onward(self, state: Numbers) -> tuple[Numbers, Numbers]:
        """A of what follows behind the last joint, time in 1 / rate, and the states there, those of signals last."""
        last = self.segments[-1]
        if not last.endless:
            return self.own, state
        struck = state + self._pushed @ last.blows * self.rate
        return self.whole(last) / (self.rate * last.length), np.concatenate([struck, last.start])

    def through(self, alike: list[Segment], state: Numbers) -> tuple[Numbers, Numbers]:
        """States at the beginning of each of a run of segments, (n, N), and behind the last, (size,)."""
        size = self.size
        step = exponential(self.whole(alike[0]))
        signals = np.array([one.start for one in alike])
        blows = np.array([one.blows for one in alike]) @ self._pushed.T * self.rate
        states = np.empty((len(alike) + 1, size), dtype=np.result_type(state, self.own))
        states[0] = state + blows[0]
        states[1:] = signals @ step[:size, size:].T
        states[1:-1] += blows[1:]
        reach, power = 1, step[:size, :size]
        while reach < len(states):  # each state takes up what came before it, over twice the distance every time
            states[reach:] += states[:-reach] @ power.T
            reach, power = 2 * reach, power @ power
        return np.hstack([states[:-1], signals]), states[-1]


def _product(left: Numbers, right: Numbers) -> Numbers:
    """Product without what is left of sums that cancel; real, or complex with the imaginary part as a slope."""
    found = np.asarray(left @ right)
    kept = np.abs(found.real) > _NOTHING * (np.abs(left.real) @ np.abs(right.real))
    if not np.iscomplexobj(found):
        return np.where(kept, found, 0.0)
    size = np.abs(left.real) @ np.abs(right.imag) + np.abs(left.imag) @ np.abs(right.real)
    slopes = np.where(np.abs(found.imag) > _NOTHING * size, found.imag, 0.0)
    return np.asarray(np.where(kept, found.real, 0.0) + 1j * slopes)


def _read(row: Numbers, a: Numbers, parts: FloatArray, starts: Numbers) -> FloatArray:
    """row . z at parts of a piece of time (n,), 0 to 1, each from its own start, (n, N) or (1, N)."""
    starts = np.broadcast_to(starts, (len(parts), len(a)))
    found = [
        np.einsum("i,nij,nj->n", row, exponentials(a, parts[k : k + _AT_ONCE]), starts[k : k + _AT_ONCE], optimize=True)
        for k in range(0, len(parts), _AT_ONCE)
    ]
    return np.concatenate([np.zeros(0), *found])


def _steps(step: Numbers, start: Numbers, count: int) -> Numbers:
    """States (count + 1, N): the start, and after each of so many like steps."""
    states = np.empty((count + 1, len(start)), dtype=np.result_type(step, start))
    states[0] = start
    known, power = 1, step
    while known <= count:
        more = min(known, count + 1 - known)
        states[known : known + more] = states[:more] @ power.T
        known, power = known + more, power @ power
    return states


def _cholesky(matrix: Numbers) -> Numbers:
    """L with L L^T = matrix, without a conjugate."""
    if not np.iscomplexobj(matrix):
        return np.asarray(np.linalg.cholesky(matrix))
    lower = np.linalg.cholesky(matrix.real)
    inner = np.linalg.solve(lower, np.linalg.solve(lower, matrix.imag).T)
    half = np.tril(inner, -1) + 0.5 * np.diag(np.diag(inner))
    return np.asarray(lower + 1j * lower @ half)
