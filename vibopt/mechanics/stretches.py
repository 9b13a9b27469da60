"""Segments of a load of one kind that follow each other, of one length or each of its own, and the states between."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

import numpy as np

from vibopt.arrays import FloatArray, IntArray
from vibopt.mechanics.panels import Along, Greatest, Numbers, exponential, greatest, halvings_of
from vibopt.mechanics.stacked import moved, read_at, wide
from vibopt.records import dataclass
from vibopt.signals import Segment

_JOINED = 1e-12
"""Part of a time within which it is a joint."""
_BACK = 16.0 * np.finfo(float).eps
"""Part of the fastest that a base has been which is none: rounding of a motion that ends."""
_MANY, _AT_ONCE, _PANELS = 16, 2048, 15
"""Runs of one length from which on they are one of any; segments that are looked at together, and halvings of each by
which they are fewer."""


@dataclass(frozen=True, slots=True)
class Stretch:
    """Segments of one kind, each z' = a z over times 0 to 1.

    a
        Of machine and signal together, (..., N, N), or of each segment (..., n, N, N).
    length
        Of all segments [s], (...), or of each (n,).
    starts, left
        States at the beginning of each, (..., n, N), and of the machine behind the last, (..., size).
    along
        exp(a t) where machines stand in a row.
    """

    a: Numbers
    length: FloatArray
    starts: Numbers
    left: Numbers
    along: Along | None = None

    @property
    def count(self) -> int:
        """Of segments."""
        return int(self.starts.shape[-2])

    @property
    def uneven(self) -> bool:
        """Whether each segment has a length of its own."""
        return bool(self.a.ndim > self.starts.ndim)

    @property
    def joints(self) -> FloatArray:
        """Where each segment begins and the last ends, from the beginning of the first [s], (..., n + 1)."""
        if self.uneven:
            return np.append(0.0, np.cumsum(self.length))
        return np.arange(self.count + 1.0) * self.length[..., None]

    @property
    def sizes(self) -> FloatArray:
        """Of each state of the machine, at the joints or as its load drives it between two of them, (..., size)."""
        size = self.left.shape[-1]
        driven = np.abs(self.a[..., :size, size:]).sum(axis=-1)
        driven = driven if self.uneven else driven[..., None, :]
        load = np.abs(self.starts[..., size:]).max(axis=-1, initial=0.0)
        return np.asarray(np.maximum(np.abs(self.starts[..., :size]), driven * load[..., None]).max(axis=-2))

    def of(self, which: IntArray) -> tuple[Numbers, FloatArray, Numbers]:
        """a, length and start of one segment of each machine (...)."""
        starts = np.take_along_axis(self.starts, which[..., None, None], axis=-2)[..., 0, :]
        if not self.uneven:
            return self.a, self.length, starts
        return (
            np.take_along_axis(self.a, which[..., None, None, None], axis=-3)[..., 0, :, :],
            self.length[which],
            starts,
        )

    def highest(self, row: FloatArray, least: FloatArray) -> Greatest:
        """Greatest size of row . z of machines in a row, (n,), as `greatest` tells it; rows as those of `a`."""
        if not self.uneven:
            return greatest(self.a, row, self.starts, least, self.along)
        count = len(self.starts)
        best = Greatest(np.zeros(count), np.zeros(count, dtype=int), np.zeros(count))
        step = min(_AT_ONCE, 2 ** max(_PANELS - int(halvings_of(self.a).max()), 0))
        for machine in range(count):
            for first in range(0, self.count, step):
                some, most = slice(first, first + step), max(float(least[machine]), abs(float(best.value[machine])))
                found = greatest(self.a[machine, some], row[machine, some], self.starts[machine, some, None], most)
                top = int(np.abs(found.value).argmax())
                if abs(found.value[top]) > abs(best.value[machine]):
                    best.value[machine], best.start[machine] = found.value[top], first + top
                    best.at[machine] = found.at[top]
        return best

    def read(self, row: Numbers, times: FloatArray) -> FloatArray:
        """row . z of a lone machine at times from the beginning of the first segment [s], (n,)."""
        joints = self.joints
        which = np.searchsorted(
            joints[1:-1], times * (1.0 + _JOINED) + _JOINED * float(np.min(self.length)), side="right"
        )
        parts = np.clip((times - joints[which]) / (joints[which + 1] - joints[which]), 0.0, 1.0)
        if not self.uneven:
            return read_at(row, self.a, parts, self.starts[which])
        cut = [slice(k, k + _AT_ONCE) for k in range(0, len(times), _AT_ONCE)]
        each = ((which[some], parts[some]) for some in cut)
        return np.concatenate([np.zeros(0), *(moved(row[k], self.a[k] * wide(t), self.starts[k]) for k, t in each)])


def runs_of(segments: Sequence[Segment]) -> list[list[Segment]]:
    """Segments of one kind that follow each other: of one length, or, where there are very many of any, all of them."""
    alike = [list(run) for _, run in groupby(segments, lambda one: (_kind(one), np.asarray(one.length).tobytes()))]
    found: list[list[Segment]] = []
    for _, several in groupby(alike, lambda run: _kind(run[0])):
        runs = list(several)
        together = len(runs) > _MANY and not any(np.ndim(run[0].length) for run in runs)
        found += [[segment for run in runs for segment in run]] if together else runs
    return found


def own_lengths(alike: Sequence[Segment]) -> FloatArray | None:
    """Lengths of segments of a run [s], (n,); None where they are one."""
    if np.ndim(alike[0].length) or len({segment.length for segment in alike}) == 1:
        return None
    return np.array([segment.length for segment in alike])


def joints_of(alike: Sequence[Segment]) -> FloatArray:
    """Where each segment of a run begins and the last ends [s], (n + 1,)."""
    lengths = own_lengths(alike)
    if lengths is None:
        return np.arange(len(alike) + 1.0) * alike[0].length
    return np.append(0.0, np.cumsum(lengths))


def _kind(segment: Segment) -> tuple[bytes, bytes]:
    return segment.rates.tobytes(), segment.read.tobytes()


def steps_of(a: Numbers) -> Numbers:
    """exp(a) of many, (..., N, N)."""
    flat = a.reshape(-1, *a.shape[-2:])
    each = [exponential(flat[k : k + _AT_ONCE]) for k in range(0, len(flat), _AT_ONCE)]
    return np.concatenate(each).reshape(a.shape)


def after(matrices: Numbers, states: Numbers) -> Numbers:
    """One matrix (..., k, N), or that of each (..., n, k, N), times states (..., n, N)."""
    if matrices.ndim == states.ndim:
        return np.asarray(states @ matrices.mT)
    return np.asarray((matrices @ states[..., None])[..., 0])


def add_before(states: Numbers, steps: Numbers) -> None:
    """Take up in states (..., n + 1, size) what came before each, through one step, or n, as `after` has them.

    Each takes it up over twice the distance every time.
    """
    reach, power = 1, steps
    while reach < states.shape[-2]:
        if steps.ndim == states.ndim:
            states[..., reach:, :] += after(power, states[..., :-reach, :])
            power = power @ power
        else:
            states[..., reach:, :] += after(power[..., reach - 1 :, :, :], states[..., :-reach, :])
            further = power[..., reach:, :, :] @ power[..., :-reach, :, :]
            power = np.concatenate([power[..., :reach, :, :], further], axis=-3)
        reach *= 2


def back_at_rest(stretches: Sequence[Stretch], n_free: int, long: FloatArray) -> Numbers:
    """State behind the last of some stretches, (..., size), with bases at rest that are so up to rounding.

    Bases come behind the free coordinates, and take `long` (...) for all of the load, in 1 / rate.  What rounding
    leaves of their rate would carry away all that stands on them.
    """
    found = np.array(stretches[-1].left)
    half = found.shape[-1] // 2
    places, rates = found[..., n_free:half], found[..., half + n_free :]
    fast = np.max([stretch.sizes[..., half + n_free : 2 * half] for stretch in stretches], axis=0)
    back = (np.abs(rates) <= _BACK * fast) & (np.abs(places) <= _BACK * fast * np.asarray(long)[..., None])
    places[back] = rates[back] = 0.0
    return found


def come_back(runs: Sequence[Sequence[Segment]], led: IntArray) -> bool:
    """Whether the bases that some signals lead, by their accelerations, are at rest behind runs of segments."""
    speed, most = np.zeros(()), np.zeros(())
    for alike in runs:
        rates, read, count = alike[0].rates, alike[0].read, alike[0].rates.shape[-1]
        grown = np.zeros((*rates.shape[:-2], *(count + read.shape[-2],) * 2))
        grown[..., :count, :count], grown[..., count:, :count] = rates, read
        gained = exponential(grown)[..., count:, :count]
        for segment in alike:
            length = wide(segment.length)[..., 0]
            speed = speed + segment.blows + _times(gained, segment.start) * length
            most = most + np.abs(segment.blows) + _times(np.abs(read), np.abs(segment.start)) * length
    return bool((np.abs(speed) <= _BACK * most)[..., led].all())


def _times(matrix: FloatArray, vector: FloatArray) -> FloatArray:
    return np.asarray((matrix @ vector[..., None])[..., 0])
