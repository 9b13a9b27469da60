"""Firing orders that a crankshaft allows, and how even they are."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from math import tau

import numpy as np

from vibopt.balancing.engine.job import EngineJob
from vibopt.records import dataclass

EVEN = 1e-6
MOST_CYLINDERS = 12


@dataclass(frozen=True)
class Firing:
    """A firing order (cylinder numbers from 1), its intervals [rad], and how often neighbours fire in succession."""

    order: tuple[int, ...]
    intervals: tuple[float, ...]
    neighbours: int

    @property
    def unevenness(self) -> float:
        """Greatest deviation of an interval from their mean [rad]."""
        mean = sum(self.intervals) / len(self.intervals)
        return max(abs(one - mean) for one in self.intervals)

    @property
    def text(self) -> str:
        """As engineers write it: 1-3-4-2."""
        return "-".join(map(str, self.order))


def best_firing(job: EngineJob, cranks: Sequence[float]) -> Firing:
    """The most even order; of equally even ones that with the fewest neighbours in succession, then the first.

    A four-stroke cylinder may fire at either of its two top dead centres in two turns.
    """
    tops = np.array([(one.bank - cranks[one.throw]) % tau for one in job.cylinders])
    cycle = tau * job.strokes / 2.0
    n = len(tops)
    turns = product((0.0,), *[(0.0, tau)] * (n - 1)) if job.strokes == 4 and n <= MOST_CYLINDERS else [(0.0,) * n]
    best: tuple[float, int, tuple[int, ...]] | None = None
    found = None
    for later in turns:
        firing = _firing(job, (tops + np.array(later)) % cycle, cycle)
        rank = (round(firing.unevenness, 6), firing.neighbours, firing.order)
        if best is None or rank < best:
            best, found = rank, firing
    assert found is not None
    return found


def is_even(firing: Firing) -> bool:
    return firing.unevenness < EVEN


def _firing(job: EngineJob, times: np.ndarray[tuple[int], np.dtype[np.float64]], cycle: float) -> Firing:
    """The order of given firing times, begun with cylinder 1."""
    times = (times - times[0]) % cycle
    times[np.isclose(times, cycle)] = 0.0
    ranked = np.lexsort((np.arange(len(times)), times.round(9)))
    gaps = np.diff(np.append(times[ranked], cycle))
    beside = 0
    for k, one in enumerate(ranked):
        other = ranked[(k + 1) % len(ranked)]
        places = sorted({c.at for c in job.cylinders if c.bank == job.cylinders[one].bank})
        same_bank = job.cylinders[one].bank == job.cylinders[other].bank
        if same_bank and len(places) > 2:
            a, b = (places.index(job.cylinders[c].at) for c in (one, other))
            beside += int(abs(a - b) == 1)
    return Firing(tuple(int(one) + 1 for one in ranked), tuple(float(one) for one in gaps), beside)
