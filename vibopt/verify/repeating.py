"""The state at which a motion begins that is the negative of itself half a cycle later, by simulation alone.

The second route's own search: it knows half a cycle as a map of states.  Half cycle follows half cycle, ever more of
them left out while each changes as much as that before, and from time to time a root is looked for by Broyden's method.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.records import dataclass

_FIRST, _EARLIER, _AGAIN, _MOST, _SLACK = 6, 4, 50, 600, 1e-3
"""Half cycles before roots are looked for, so many less beside a motion that is known, and again, and at most; part by
which one may change more than that before."""
_APART, _TRIED, _LESS, _POLISHED = 1e-7, 20, 0.5, 6
"""Of a search for a root: part by which places are moved for slopes, most steps, and what each leaves at most; searches
where hardly anything moves."""


@dataclass(frozen=True)
class Repeating:
    """A motion under a harmonic, known by what half a cycle makes of a state.

    after
        The negative of the state (n,) half a cycle behind one.
    scale
        Sizes that states are likely to have, (n,).
    part
        Part of these by which half a cycle may be off.
    free
        Whether each state is one of its own: what joints without mass do follows from the rest, and none is left out.
    known
        Whether it begins beside a motion that repeats.
    brief
        Whether hardly anything moves: what is missing may be as great.
    """

    after: Callable[[FloatArray], FloatArray]
    scale: FloatArray
    part: float
    free: bool
    known: bool
    brief: bool

    def found(self, state: FloatArray) -> tuple[FloatArray, float]:
        """From a state (n,) on to one that repeats, and what is left between both ends of its half cycle."""
        leap, last, least, begun = 1.0, state, np.inf, _FIRST - _EARLIER * self.known
        for count in range(_MOST):
            following = self.after(state)
            missed = float(np.abs((following - state) / self.scale).max())
            left = missed / (1.0 + float(np.abs(state / self.scale).max()))
            if left <= 10.0 * self.part:
                near = self._rooted(following, missed) if leap > 1.0 else following
                return (self._closest(near) if self.brief else near), left
            far = self.free and missed > (1.0 + _SLACK) * least
            last = last if far else following
            if far or count % _AGAIN == begun:
                state, least, leap = self._rooted(last, min(missed, least)), np.inf, 1.0
            else:
                least, state = missed, state + leap * (following - state)
                leap *= 1.0 + (self.free and count > begun)
        return last, left

    def _missing(self, one: FloatArray) -> FloatArray:
        """Between both ends of a half cycle, in parts of the scale as its beginning is."""
        return one - self.after(one * self.scale) / self.scale

    def _rooted(self, one: FloatArray, missed: float) -> FloatArray:
        found = _root(self._missing, one / self.scale, self.part)
        if found is not None:
            return found * self.scale
        from scipy.optimize import root

        sought: Any = root(self._missing, one / self.scale, tol=10.0 * self.part)
        good = np.isfinite(sought.x).all() and np.abs(sought.fun).max() < missed
        return sought.x * self.scale if good else one

    def _closest(self, one: FloatArray) -> FloatArray:
        for _ in range(_POLISHED):
            found = _root(self._missing, one / self.scale, _LESS * float(np.abs(self._missing(one / self.scale)).max()))
            if found is None:
                break
            one = found * self.scale
        return one


def _root(missing: Callable[[FloatArray], FloatArray], place: FloatArray, close: float) -> FloatArray | None:
    """Where nothing is missing, by Broyden's method; None where that does not get there by ever greater steps."""
    value, small = missing(place), _APART * np.maximum(np.abs(place), _APART)
    slopes = np.array([(missing(place + own) - value) / own.sum() for own in np.diag(small)]).T
    for _ in range(_TRIED):
        if not np.isfinite(slopes).all() or np.linalg.cond(slopes) > 1.0 / _APART:
            return None
        step = np.linalg.solve(slopes, -value)
        place, before, value = place + step, value, missing(place + step)
        if np.abs(value).max() <= close:
            return place
        if not np.abs(value).max() <= _LESS * np.abs(before).max():
            return None
        slopes += np.outer(value, step) / (step @ step)
    return None
