"""Where between two places something ends: the one search of a root, of the edge of a verdict, of the last that holds.

A search begins at a place where it holds and one where it does not, in any order of size, and both stay what they were
called: the pair that comes back encloses an end however the ends lie, and is as near as was asked.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from math import isfinite, sqrt, ulp

Places = Sequence[float]
Point = tuple[float, float]


def narrowed(
    holds: Callable[[Places], Iterable[bool | None]], good: float, bad: float, inner: Callable[[float, float], Places]
) -> tuple[float, float]:
    """The last place that holds and the first that does not, as near as `inner` takes them.

    Parameters
    ----------
    holds
        Whether it holds at each of some places, asked together and looked at up to the first that fails; None where
        nobody knows.
    good, bad
        Where it holds, and where it does not.
    inner
        Where to look between the two, from the first to the second; nothing ends the search.
    """
    while len(places := inner(good, bad)):
        before = good, bad
        for place, held in zip(places, holds(places), strict=True):
            if held:
                good = place
            elif held is not None:
                bad = place
                break
        if (good, bad) == before:
            break
    return good, bad


def halved(
    holds: Callable[[float], bool], good: float, bad: float, part: float = 0.0, *, least: float = 0.0,
    by_ratios: bool = False,
) -> tuple[float, float]:  # fmt: skip
    """The same one place after the other, in the middle (`by_ratios`: of positive numbers), until both are one.

    part, least
        How near that is: a part of the larger, or so much; of nothing until there is no number between.
    """

    def middle(good: float, bad: float) -> Places:
        place = sqrt(good * bad) if by_ratios else 0.5 * (good + bad)
        return [place] if not _near(good, bad, part, least) and place not in (good, bad) else []

    return narrowed(lambda places: [holds(places[0])], good, bad, middle)


def crossing(
    height: Callable[[float], float], good: float, bad: float, part: float = 0.0, *, least: float = 0.0
) -> tuple[float, float]:
    """Both sides of a place where a height comes up through zero: not above at the first, above at the second.

    The parabola through three heights is followed to where it is at nothing while it rises all the way, else halves
    are (Chandrupatla, Advances in Engineering Software 28, 1997, 145-149): a little beside it, so that both sides come
    near.

    Parameters
    ----------
    height
        At a place; what is no number counts as above.
    good, bad
        The ends, of which it is known that it is not above at the first, and above at the second.
    part, least
        As for `halved`.
    """
    here, at_here = good, min(height(good), 0.0)  # the newest place
    there, at_there = bad, max(height(bad), 0.0)  # the nearest on the other side
    step, is_good = 0.5, True
    while not _near(here, there, part, least):
        place = here + step * (there - here)
        if place in (here, there):
            break
        value = height(place)
        before, at_before = here, at_here
        if (value <= 0.0) is not is_good:
            before, at_before, there, at_there, is_good = there, at_there, here, at_here, not is_good
        here, at_here = place, value
        step = _at_nothing((here, at_here), (there, at_there), (before, at_before))
        size = max(abs(here), abs(there))
        beside = max(0.25 * max(part * size, least), 2.0 * ulp(size)) / (abs(there - here) or 1.0)
        step = min(max(step, beside), 1.0 - beside) if beside < 0.5 else 0.5
    return (here, there) if is_good else (there, here)


def _at_nothing(here: Point, there: Point, before: Point) -> float:
    """Part of the way from here to there at which the parabola through three points is at nothing; else one half."""
    (a, low), (b, high), (c, last) = here, there, before
    if last == high or not all(map(isfinite, (low, high, last))):
        return 0.5
    along, up = (a - b) / (c - b), (low - high) / (last - high)
    if not (up * up < along and (1.0 - up) ** 2 < 1.0 - along):
        return 0.5
    past = low / (high - low) * last / (high - last)
    return past + (c - a) / (b - a) * low / (last - low) * high / (last - high)


def _near(good: float, bad: float, part: float, least: float) -> bool:
    return abs(bad - good) <= max(part * max(abs(good), abs(bad)), least)
