"""The frontier of searches: best first, equals in the order in which they came, and a bound that holds on exit."""

from __future__ import annotations

import heapq
import re
from itertools import count

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from vibopt.frontier import Frontier
from vibopt.work import Budget

BOUNDS = st.lists(st.sampled_from([-np.inf, 0.0, 0.25, 0.5, 1.0, 2.0]), max_size=40)


@settings(max_examples=80, deadline=None)
@given(rounds=st.lists(st.tuples(BOUNDS, st.integers(1, 9)), max_size=8))
def test_sets_are_taken_as_from_a_heap_with_tickets(rounds: list[tuple[list[float], int]]) -> None:
    frontier, heap, ticket = Frontier(Budget(10, "sets")), list[tuple[float, int]](), count()
    for bounds, most in rounds:
        numbers = [next(ticket) for _ in bounds]
        frontier.add(np.array(bounds), np.array(numbers, dtype=int))
        for pair in zip(bounds, numbers, strict=True):
            heapq.heappush(heap, pair)
        assert frontier.bound == (heap[0][0] if heap else np.inf)
        taken = [heapq.heappop(heap) for _ in range(min(most, len(heap)))]
        found = frontier.take(most) if frontier else (np.zeros(0), np.zeros(0))
        assert [*zip(*(one.tolist() for one in found), strict=True)] == taken
        assert len(frontier) == len(heap)


@settings(max_examples=80, deadline=None)
@given(bounds=BOUNDS, bar=st.sampled_from([-1.0, 0.25, 3.0]))
def test_only_sets_below_the_bar_are_kept(bounds: list[float], bar: float) -> None:
    frontier = Frontier(Budget(10, "sets"))
    for bound in bounds:
        frontier.push(bound, ("set", bound))
    frontier.keep(bar)
    assert sorted(frontier.bounds.tolist()) == sorted(one for one in bounds if one < bar)
    while frontier:
        bound, item = frontier.pop()
        assert item == ("set", bound)


@settings(max_examples=60, deadline=None)
@given(values=st.lists(st.integers(1, 40), min_size=1, max_size=8), most=st.integers(1, 60))
def test_a_search_ends_with_a_bound_that_no_choice_beats(values: list[int], most: int) -> None:
    """The sum of some numbers nearest to 57 from above: halves are sets with a number taken or left."""
    every = [sum(one for i, one in enumerate(values) if mask >> i & 1) for mask in range(2 ** len(values))]
    least = min((one for one in every if one >= 57), default=np.inf)
    frontier, best, seen = (
        Frontier(Budget(most, "sets"), lambda stage, part: told.append((stage, part)), "sums"),
        np.inf,
        0,
    )
    told: list[tuple[str, float]] = []
    frontier.push(0.0, (0, 0))
    while frontier and frontier.bound < best and not frontier.over:
        total, (index, _) = frontier.pop()
        frontier.budget.spend()
        seen += 1
        if index == len(values):
            best = total if total >= 57 else best
            continue
        for more in (0, values[index]):
            if total + more + sum(values[index + 1 :]) >= 57:
                frontier.push(total + more, (index + 1, seen))
    assert min(frontier.bound, best) <= least <= best
    assert best == least or seen == most
    assert told
    assert all(re.fullmatch(r"sums, \d+ sets?", stage) for stage, _ in told)


def test_a_spent_budget_ends_a_search_with_its_sets_still_open() -> None:
    frontier = Frontier(Budget(2, "sets"))
    frontier.add(np.array([3.0, 1.0]), np.array([[3.0, 0.0], [1.0, 0.0]]))
    assert not frontier.over
    frontier.budget.spend(2)
    assert frontier.over
    assert frontier.bound == 1.0
    assert frontier.columns[0].tolist() == [[3.0, 0.0], [1.0, 0.0]]
