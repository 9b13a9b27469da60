"""How fast the goal of a convex answer falls where a limit or cap of the file is widened: its exact tangent."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from vibopt.balancing.planes import Plane
from vibopt.balancing.question import Question, Solved
from vibopt.records import dataclass

_SAME, _NOTHING = 1e-9, 1e-9
NOISE = 1e-6
"""Part of the goal that all of a bound would have to be worth for it to count: multipliers are no better known."""


@dataclass(frozen=True)
class Bounding:
    """What a limit or a cap of the file is in a question: rows of readings, one plane, or, where neither, all planes.

    bound
        In the question [SI peak, kg m, or kg in total].
    size
        One of it in the file [SI].
    """

    bound: float
    size: float = 1.0
    rows: Sequence[int] = ()
    plane: int | None = None


def own_caps(planes: Iterable[Plane]) -> dict[str, Bounding]:
    """The greatest weight of each plane that may be changed, by its path."""
    return {
        f"planes.{plane.name}.{plane.kind_word}": cap_of(plane, k, plane.cap)
        for k, plane in enumerate(planes) if plane.is_open and np.isfinite(plane.cap)
    }  # fmt: skip


def cap_of(plane: Plane, index: int, most: float) -> Bounding:
    """That no more than so much [kg; kg m without a radius] is put into one plane."""
    return Bounding(most * plane.radius, 1.0 / plane.radius, plane=index)


def rates(question: Question, solved: Solved, known: Mapping[str, Bounding]) -> dict[str, float] | None:
    """What the goal falls by per unit of each bound [SI], zero of one that holds nothing back; None of lists."""
    if question.is_search or solved.u is None:
        return None
    prices, found = solved.prices, dict.fromkeys(known, 0.0)
    whole = 0.0 if question.goal == "correction" else float(question.measure(np.abs(question.y0)))
    least = NOISE * max(solved.value, 1e-3 * whole)
    for name, bounding in known.items() if prices is not None and solved.value > _NOTHING * whole else ():
        assert prices is not None
        if not np.isfinite(bounding.bound):  # the open end of a range holds nothing back
            continue
        if bounding.rows:
            rate = sum(
                prices.readings[k] for k in bounding.rows if bounding.bound <= question.limits[k] * (1.0 + _SAME)
            )
        elif bounding.plane is not None:
            tightest = bounding.bound <= question.caps[bounding.plane] * (1.0 + _SAME)
            rate = prices.caps[bounding.plane] if tightest else 0.0
        else:
            rate = prices.total
        if rate * bounding.bound > least or (rate > 0.0 and not bounding.bound):
            found[name] = float(rate) / bounding.size
    return found
