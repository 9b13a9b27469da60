"""A motion that is the negative of itself half a cycle later, by Newton's method on the exact derivative of its end."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeVar

import numpy as np

from vibopt.arrays import FloatArray

_Pieces = TypeVar("_Pieces")
_WARM, _CLOSED, _ROUND, _ENOUGH, _FAR = 2, 1e-13, 1e-15, 1e-9, 3.0
"""Half cycles before Newton's method; part that may be left of a closed one, of a size of one, and at the latest; how
far a step of Newton's may lead."""


def closing(
    half: Callable[[FloatArray], tuple[_Pieces, FloatArray, FloatArray]],
    size: Callable[[FloatArray], float],
    state: FloatArray,
    turns: int,
    *,
    warm: int = _WARM,
) -> Iterator[_Pieces | None]:
    """Half a cycle where it closes, and before none after each step; plain half cycles never move it away.

    Newton's steps are only taken where they make what is missing less.

    half
        From a state (n,) at the beginning of half a cycle its pieces, the state at its end and the derivative (n, n).
    size
        Of a state or a difference of two, which plain half cycles never make greater.
    warm
        Plain half cycles before Newton's method.
    """
    known, left = half(state), np.inf
    for turn in range(turns):
        miss = state + known[1]
        left = size(miss)
        if left <= _CLOSED * size(state) + _ROUND:
            yield known[0]
        yield None
        if turn >= warm:
            step: FloatArray = np.linalg.lstsq(np.eye(len(state)) + known[2], miss, rcond=None)[0].astype(float)
            step *= min(1.0, _FAR * (1.0 + size(state)) / (size(step) + 1e-300))
            tried = [(state - step, half(state - step))]
            for part in (0.25, 0.0625):
                if size(tried[-1][0] + tried[-1][1][1]) > 0.5 * left:
                    tried.append((state - part * step, half(state - part * step)))
            best = min(tried, key=lambda one: size(one[0] + one[1][1]))
            if size(best[0] + best[1][1]) < 0.9 * left:
                state, known = best
                continue
        state = -known[1]
        known = half(state)
    if left < _ENOUGH * size(state):
        yield known[0]
