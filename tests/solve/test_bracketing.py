"""Where something ends: laws of the one search, beside brentq and beside looking everywhere."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from vibopt.bracketing import Places, crossing, halved, narrowed

ENDS = st.tuples(st.floats(-50.0, 50.0), st.floats(-50.0, 50.0)).filter(lambda ends: abs(ends[0] - ends[1]) > 1e-3)
SHAPES: dict[str, Callable[[float], float]] = {
    "line": lambda t: t,
    "steep": lambda t: math.copysign(abs(t) ** 0.2, t),
    "flat": lambda t: t**5,
    "bent": lambda t: math.expm1(3.0 * t),
    "step": lambda t: math.copysign(1.0, t),
    "endless": lambda t: math.inf if t > 0.0 else -1.0,
    "no number": lambda t: math.nan if t > 0.0 else -1.0,
    "huge": lambda t: 1e9 if t > 0.1 else t,
}


@given(ends=ENDS, inside=st.floats(0.01, 0.99), shape=st.sampled_from(sorted(SHAPES)))
def test_a_crossing_is_enclosed_to_the_last_digit(ends: tuple[float, float], inside: float, shape: str) -> None:
    """In few looks, in either order of the ends; the root is that of another's search where this one takes it."""
    good, bad = ends
    root = good + inside * (bad - good)
    looked: list[float] = []

    def height(place: float) -> float:
        looked.append(place)
        return SHAPES[shape]((place - root) / (bad - good))

    left, right = crossing(height, good, bad)
    assert not height(left) > 0.0
    assert not height(right) <= 0.0
    assert abs(right - left) <= 4.0 * math.ulp(max(abs(good), abs(bad)))
    assert min(ends) <= min(left, right) <= max(left, right) <= max(ends)
    assert len(looked) <= 75
    if shape in ("line", "bent"):
        assert len(looked) <= 15
        assert left == pytest.approx(brentq(height, good, bad, xtol=1e-14, rtol=1e-14), rel=1e-12, abs=1e-12)


@given(ends=ENDS, inside=st.floats(0.01, 0.99), part=st.sampled_from([1e-3, 1e-9]), least=st.sampled_from([0.0, 1e-2]))
def test_a_crossing_is_as_near_as_asked_and_takes_no_more(
    ends: tuple[float, float], inside: float, part: float, least: float
) -> None:
    good, bad = ends
    root, looks = good + inside * (bad - good), [0, 0]

    def height(place: float, k: int = 0) -> float:
        looks[k] += 1
        return math.expm1((place - root) / (bad - good))

    left, right = crossing(height, good, bad, part, least=least)
    assert abs(right - left) <= max(part * max(abs(left), abs(right)), least)
    crossing(lambda place: height(place, 1), good, bad)
    assert looks[0] <= looks[1]


@given(ends=ENDS, inside=st.floats(0.0, 1.0), part=st.sampled_from([0.0, 1e-6]))
def test_halves_end_at_the_edge_of_a_verdict(ends: tuple[float, float], inside: float, part: float) -> None:
    good, bad = ends
    root = good + inside * (bad - good)
    left, right = halved(lambda place: (place - root) * (bad - good) <= 0.0, good, bad, part)
    assert (left - root) * (bad - good) <= 0.0 or left == good
    assert (right - root) * (bad - good) > 0.0 or right == bad
    assert abs(right - left) <= max(part * max(abs(left), abs(right)), 4.0 * math.ulp(max(map(abs, ends))))


def test_halves_by_ratios_count_in_decades() -> None:
    """Nine of them bring a factor 2^512 down to 2: as many looks as halvings of the logarithm."""
    looked: list[float] = []
    left, right = halved(lambda place: bool(looked.append(place)) or place < 3.0, 1.0, 2.0**512, 0.5, by_ratios=True)
    assert (left, right) == (2.0, 4.0)
    assert len(looked) == 9


@given(
    verdicts=st.lists(st.sampled_from([True, False, None]), min_size=1, max_size=40), at_once=st.integers(1, 9)
)  # fmt: skip
def test_of_many_places_the_first_that_fails_counts(verdicts: list[bool | None], at_once: int) -> None:
    """Both sides are next to each other but for what nobody knows; places are looked at once, none behind a failure."""
    told: list[bool | None] = [True, *verdicts, False]
    asked: list[float] = []

    def holds(places: Places) -> Iterator[bool | None]:
        failed = False
        for place in places:
            assert not failed
            asked.append(place)
            failed = told[int(place)] is False
            yield told[int(place)]

    def inner(good: float, bad: float) -> list[float]:
        every = np.unique(np.round(np.linspace(good, bad, at_once + 2)[1:-1]))
        return [float(place) for place in every if good < place < bad and place not in asked]

    good, bad = narrowed(holds, 0.0, len(told) - 1.0, inner)
    assert told[int(good)] is True
    assert told[int(bad)] is False
    assert len(set(asked)) == len(asked)
    assert good < bad
