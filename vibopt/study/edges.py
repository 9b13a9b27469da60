"""Where along a sweep an answer begins or ends: between two points, by bisection."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby, pairwise
from math import sqrt

from vibopt.errors import InputError
from vibopt.records import dataclass
from vibopt.study.sweep import Sweep, answer_at

CLOSE = 1e-6
"""Distance between the two sides of an edge, as a part of the value."""
MOST_STEPS = 60
GOOD = ("optimal", "feasible", "met")


@dataclass(frozen=True, slots=True)
class Stretch:
    """Values of the fact from `low` to `high` [SI] without a good answer; at both ends this status was found."""

    low: float
    high: float
    status: str


def stretches(sweep: Sweep) -> Iterator[Stretch]:
    """Runs of neighbouring points without a good answer, each out to where the answers change."""
    runs = [(status, [one.value.value for one in run]) for status, run in groupby(sweep.points, lambda one: one.status)]
    edges = [_edge(sweep, before, after) for before, after in pairwise(runs)]
    for index, (status, values) in enumerate(runs):
        if status not in GOOD:
            low = edges[index - 1][1] if index else values[0]
            high = edges[index][0] if index < len(edges) else values[-1]
            yield Stretch(low, high, status)


def _edge(sweep: Sweep, before: tuple[str, list[float]], after: tuple[str, list[float]]) -> tuple[float, float]:
    """The last value with the status before and the first with the one after, as close as `CLOSE`.

    Where a third status lies between, each side ends before it.
    """
    low, high = before[1][-1], after[1][0]
    for _ in range(MOST_STEPS):
        if high - low <= CLOSE * max(abs(low), abs(high)):
            break
        middle = sqrt(low * high) if sweep.by_ratios else 0.5 * (low + high)
        try:
            status = answer_at(sweep, middle).status
        except InputError:  # there is nothing between, as between two whole numbers
            break
        if status == before[0]:
            low = middle
        elif status == after[0]:
            high = middle
        else:
            break
    return low, high


__all__ = ["CLOSE", "GOOD", "Stretch", "stretches"]
