"""Choices that are equally good: the rule takes the first in the order of planes and lists, never rounding."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from vibopt.balancing.question import Question, breaks
from vibopt.forms import ComplexArray

SAME = 1e-9
"""Part of the goal, and of the mass, by which equal choices may differ."""
_PASSES = 20


def first_of_equals(question: Question, u: ComplexArray, chosen: list[int]) -> tuple[ComplexArray, list[int]]:
    """The choice that comes first among those as good that differ in one plane, or in two planes exchanged.

    Nothing is exchanged that breaks a limit or takes more mass.  Where weights are counted the choice stays as it is.
    """
    if len(question.stock) or question.pairs:
        return u, chosen
    for _ in range(_PASSES):
        before = list(chosen)
        u, chosen = _each_plane(question, u, chosen)
        u, chosen = _exchanged(question, u, chosen)
        if chosen == before:
            break
    return u, chosen


def _each_plane(question: Question, u: ComplexArray, chosen: list[int]) -> tuple[ComplexArray, list[int]]:
    value, left = _no_worse(question, question.chosen_only(chosen).value(u)), question.residual(u)
    for plane, options in enumerate(question.options):
        if options is None or not chosen[plane]:
            continue
        earlier = options[: chosen[plane]]
        masses = question.option_masses[plane] if question.option_masses else None
        if masses is not None:
            earlier = np.where(masses[: chosen[plane]] <= masses[chosen[plane]] * (1.0 + SAME), earlier, np.nan)
        if question.goal != "correction":
            moved = left[None, :] + (earlier - u[plane])[:, None] * question.H[None, :, plane]
            near = np.flatnonzero(question.measure(np.abs(moved)) <= value)
        else:
            near = np.flatnonzero(np.isfinite(earlier.real))
        for place in near.tolist():
            new = u.copy()
            new[plane] = options[place]
            picked = [*chosen[:plane], place, *chosen[plane + 1 :]]
            if _as_good(question, new, picked, value):
                return new, picked
    return u, chosen


def _exchanged(question: Question, u: ComplexArray, chosen: list[int]) -> tuple[ComplexArray, list[int]]:
    """Planes with the same list whose choices may be exchanged, the earlier plane with the earlier one."""
    value = _no_worse(question, question.chosen_only(chosen).value(u))
    listed = [plane for plane, one in enumerate(question.options) if one is not None]
    for first, second in combinations(listed, 2):
        if chosen[first] <= chosen[second] or not _same_lists(question, first, second):
            continue
        new, picked = u.copy(), list(chosen)
        new[[first, second]] = u[[second, first]]
        picked[first], picked[second] = chosen[second], chosen[first]
        if _as_good(question, new, picked, value):
            u, chosen = new, picked
    return u, chosen


def _no_worse(question: Question, value: float) -> float:
    """What an equal choice may come to: rounding of the value, and of the readings where nothing is left."""
    nothing = 0.0 if question.goal == "correction" else float(question.measure(np.abs(question.y0)))
    return value + SAME * (abs(value) + 1e-3 * nothing)


def _same_lists(question: Question, first: int, second: int) -> bool:
    one, other = question.options[first], question.options[second]
    if one is None or other is None or one.shape != other.shape or not np.allclose(one, other, rtol=1e-12, atol=0.0):
        return False
    masses = (question.option_masses[first], question.option_masses[second]) if question.option_masses else (None, None)
    return masses[0] is None or masses[1] is None or bool(np.allclose(masses[0], masses[1], rtol=1e-12, atol=0.0))


def _as_good(question: Question, u: ComplexArray, chosen: list[int], value: float) -> bool:
    only = question.chosen_only(chosen)
    return only.value(u) <= value and not breaks(only, u, slack=SAME)
