"""All ways to set the crank throws at the angles there are, one of each class that shakes alike.

Turning the whole crankshaft changes no force or couple, so the first free throw keeps the first angle where no throw is
fixed.  Looking at an in-line engine from behind (angles mirrored) or from the other end (places mirrored) changes none
either; of each such class one member is tried, and the number of them all is said.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import permutations
from math import factorial, tau

import numpy as np

from vibopt.balancing.engine.job import EngineJob
from vibopt.errors import InputError

MOST = 5_000_000


def count(job: EngineJob) -> int:
    """Ways to set the free throws, before symmetry."""
    return factorial(len(job.offered)) if job.is_search else 1


def classes(job: EngineJob) -> Iterator[tuple[float, ...]]:
    """Crank angles per throw, one member of each class, the first in numbers."""
    free = [k for k, one in enumerate(job.cranks) if one is None]
    turns_free = len(free) == len(job.cranks) and all(one.fixed is None for one in job.weights)
    if factorial(max(len(free) - int(turns_free), 0)) > MOST:
        raise InputError(f"{job.name}: {len(free)} throws can be set in more than {MOST} ways. Fix some of the cranks.")
    offered = tuple(sorted(one % tau for one in job.offered))
    seen: set[tuple[float, ...]] = set()
    heads = permutations(offered[1:]) if turns_free else permutations(offered)
    for rest in heads:
        chosen = (offered[0], *rest) if turns_free else rest
        cranks = [0.0 if one is None else one for one in job.cranks]
        for k, angle in zip(free, chosen, strict=True):
            cranks[k] = angle
        key = _key(job, cranks, turns_free)
        if key not in seen:
            seen.add(key)
            yield tuple(cranks)


def _key(job: EngineJob, cranks: list[float], turns_free: bool) -> tuple[float, ...]:
    """The same for all members of a class: the smallest of the members' angles, turned so that throw 1 is at zero."""
    if not turns_free or job.weights:
        return tuple(cranks)
    members = [np.array(cranks)]
    if all(one.bank == 0.0 for one in job.cylinders):
        members.append(-members[0])
    back = _from_behind(job)
    if back is not None:
        members += [one[back] for one in members]
    return min(tuple(_rounded(one - one[0])) for one in members)


def _rounded(angles: np.ndarray[tuple[int], np.dtype[np.float64]]) -> list[float]:
    """Angles in 0..360 deg in whole billionths of a turn."""
    return [float(v) for v in np.round((angles / tau) % 1.0, 9) % 1.0]


def _from_behind(job: EngineJob) -> list[int] | None:
    """Throw that takes the place of each throw from the other end; None where the engine is not the same from there."""
    plain = len(job.cylinders) == len(job.cranks) and all(one.bank == 0.0 for one in job.cylinders)
    alike = len({(one.reciprocating, one.rotating) for one in job.cylinders}) == 1
    if not plain or not alike:
        return None
    order = sorted(range(len(job.cylinders)), key=lambda k: job.cylinders[k].at)
    places = np.array([job.cylinders[k].at for k in order])
    if not np.allclose(np.diff(places), np.diff(places)[::-1]):
        return None
    partner = dict(zip(order, order[::-1], strict=True))
    by_throw = {one.throw: k for k, one in enumerate(job.cylinders)}
    return [job.cylinders[partner[by_throw[throw]]].throw for throw in range(len(job.cranks))]
