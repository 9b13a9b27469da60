"""When the cylinders of an engine fire, and which angles of its cranks that leaves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import permutations, product
from math import factorial, tau

import numpy as np

from vibopt.balancing.engine.engine_job import EngineJob
from vibopt.balancing.engine.throws import fires_in
from vibopt.errors import InputError
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
        return max(abs(interval - mean) for interval in self.intervals)

    @property
    def text(self) -> str:
        """As engineers write it: 1-3-4-2."""
        return "-".join(map(str, self.order))


def best_firing(job: EngineJob, cranks: Sequence[float]) -> Firing:
    """The most even order; of equally even ones that with the fewest neighbours in succession, then the first.

    A four-stroke cylinder may fire at either of its two top dead centres in two turns. In the order that the file says
    each fires where it is nearest to equal distances.
    """
    tops = np.array(job.tops(cranks))
    cycle = tau * job.strokes / 2.0
    n = len(tops)
    if job.fires:
        places = np.array([job.fires.index(k + 1) * cycle / n for k in range(n)])
        tops = tops - tops[job.fires[0] - 1]
        return _firing(job, (tops + tau * np.round((places - tops) / tau)) % cycle, cycle)
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


def may_fire(job: EngineJob, cranks: Sequence[float]) -> bool:
    """Whether the cylinders can fire as the file says: in its order, and at equal distances where it wants that."""
    if job.fires and not fires_in(job.fires, job.tops(cranks), job.strokes):
        return False
    return not job.even_firing or is_even(best_firing(job, cranks))


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
    return Firing(tuple(int(one) + 1 for one in ranked), tuple(float(gap) for gap in gaps), beside)


MOST = 5_000_000


def count(job: EngineJob) -> int:
    """Ways to set the free throws, before symmetry."""
    return factorial(len(job.offered)) if job.is_search else 1


def classes(job: EngineJob, others: Sequence[EngineJob] = ()) -> Iterator[tuple[float, ...]]:
    """Crank angles per throw, one member of each class, the first in numbers; a class is one of `others`, too."""
    free = [k for k, crank in enumerate(job.cranks) if crank is None]
    every = (job, *others)
    turns_free = len(free) == len(job.cranks) and all(weight.fixed is None for one in every for weight in one.weights)
    offered = tuple(sorted(value % tau for value in job.offered))
    firsts = _unlike(offered) if turns_free else []
    if factorial(len(free) - 1) * len(firsts) > MOST if turns_free else factorial(len(free)) > MOST:
        raise InputError(f"{job.name}: {len(free)} throws can be set in more than {MOST} ways. Fix some of the cranks.")
    seen: set[tuple[tuple[float, ...], ...]] = set()
    turned = ((offered[k], *rest) for k in firsts for rest in permutations(offered[:k] + offered[k + 1 :]))
    for chosen in turned if turns_free else permutations(offered):
        cranks = [0.0 if crank is None else crank for crank in job.cranks]
        for k, angle in zip(free, chosen, strict=True):
            cranks[k] = angle
        key = tuple(_key(one, cranks, turns_free) for one in every)
        if key not in seen:
            seen.add(key)
            yield tuple(cranks)


def _unlike(offered: tuple[float, ...]) -> list[int]:
    """Angles, by number, that throw 1 may take: one of those that turning the whole list takes into each other."""
    seen: dict[tuple[float, ...], int] = {}
    for k, angle in enumerate(offered):
        seen.setdefault(tuple(sorted(_rounded(np.array(offered) - angle))), k)
    return list(seen.values())


def _key(job: EngineJob, cranks: list[float], turns_free: bool) -> tuple[float, ...]:
    """The same for all members of a class: the smallest of the members' angles, turned so that throw 1 is at zero.

    Turned over or seen from behind an engine fires in another order: where the file says one, each is for itself.
    """
    if not turns_free or job.weights or job.fires:
        return tuple(cranks)
    members = [np.array(cranks)]
    if all(cylinder.bank == 0.0 for cylinder in job.cylinders):
        members.append(-members[0])
    back = _from_behind(job)
    if back is not None:
        members += [member[back] for member in members]
    return min(tuple(_rounded(member - member[0])) for member in members)


def _rounded(angles: np.ndarray[tuple[int], np.dtype[np.float64]]) -> list[float]:
    """Angles in 0..360 deg in whole billionths of a turn."""
    return [float(v) for v in np.round((angles / tau) % 1.0, 9) % 1.0]


def _from_behind(job: EngineJob) -> list[int] | None:
    """Throw that takes the place of each throw from the other end; None where the engine is not the same from there."""
    plain = len(job.cylinders) == len(job.cranks) and all(cylinder.bank == 0.0 for cylinder in job.cylinders)
    alike = len({(cylinder.reciprocating, cylinder.rotating) for cylinder in job.cylinders}) == 1
    if not plain or not alike:
        return None
    order = sorted(range(len(job.cylinders)), key=lambda k: job.cylinders[k].at)
    places = np.array([job.cylinders[k].at for k in order])
    if not np.allclose(np.diff(places), np.diff(places)[::-1]):
        return None
    partner = dict(zip(order, order[::-1], strict=True))
    by_throw = {cylinder.throw: k for k, cylinder in enumerate(job.cylinders)}
    return [job.cylinders[partner[by_throw[throw]]].throw for throw in range(len(job.cranks))]
