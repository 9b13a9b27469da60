"""A beam of finite elements, for the machine as built: exact under forces at its nodes and loads that are cubics."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.records import dataclass

_HELD = {
    "simply_supported": (0, 4),
    "cantilever": (0, 1),
    "fixed": (0, 1, 4, 5),
    "fixed_pinned": (0, 1, 4),
    "overhung": (0, 2),
}
"""Of deflection and slope at three places from left to right (0 to 5), those that the supports hold."""
_EQUAL = 1e-9
"""Part by which moments differ that are the same but for rounding."""
_FINE = 8
"""Elements on each side of the load whose frequencies are those of the beam within 1e-5."""


@dataclass(frozen=True, slots=True)
class Bent:
    """Of a beam of unit bending stiffness and unit mass per length, of some length [m].

    force
        That bends it by one where it carries [N/m].
    means
        Of its shape and of the square of it, over the beam.
    moment, right
        Where it is bent most, and on its second support: of that force, and of a load of one and one of its shape while
        it is held where it carries.
    frequency
        The lowest of its own, held where it carries [rad/s].
    """

    force: float
    means: tuple[float, float]
    moment: tuple[float, float, float]
    right: tuple[float, float, float]
    frequency: float


@lru_cache(maxsize=256)
def bent(kind: str, at: float, length: float = 1.0) -> Bent:
    """The beam of a kind, loaded `at` a place from its left end [m]; at its length that is a free tip."""
    places = [0.0, *sorted((at, length))] if at != length else [0.0, length]
    spans = [after - before for before, after in pairwise(places)]
    stiff, mass = _assembled(spans, _stiffness), _assembled(spans, _mass)
    loaded, held = 2 * places.index(at), _HELD[kind]
    free = [i for i in range(len(stiff)) if i not in held]
    moved = np.zeros(len(stiff))
    moved[free] = np.linalg.solve(stiff[np.ix_(free, free)], [float(i == loaded) for i in free])
    force = 1.0 / moved[loaded]
    shape, along = force * moved, np.array([1.0, 0.0] * len(places))
    fixed = [i for i in free if i != loaded]
    ends = [(span, end) for span in range(len(spans)) for end in (1, 3)]
    tables = []  # of the force, the load of one, the load of its shape: forces on supports, and moments at ends
    for load, place in ((np.zeros(len(stiff)), shape), (mass @ along, along), (mass @ shape, shape)):
        still = place if not load.any() else np.zeros(len(stiff))
        still[fixed] = np.linalg.solve(stiff[np.ix_(fixed, fixed)], load[fixed]) if load.any() else still[fixed]
        pulled = stiff @ still - load
        inner = [
            (_stiffness(spans[k]) @ still[2 * k : 2 * k + 4])[end]
            - (load.any() and (_mass(spans[k]) @ place[2 * k : 2 * k + 4])[end])
            for k, end in ends
        ]
        tables.append((-pulled[_second(kind, held)] if _second(kind, held) else 0.0, inner))
    sizes = np.abs(tables[0][1])
    worst = int(np.flatnonzero(sizes >= (1.0 - _EQUAL) * sizes.max())[0])
    sign = np.sign(tables[0][1][worst])
    moment = tuple(float(sign * table[1][worst]) for table in tables)
    right = tuple(float(table[0]) for table in tables)
    total = float(along @ mass @ along)
    means = float(along @ mass @ shape) / total, float(shape @ mass @ shape) / total
    return Bent(float(force), means, moment, right, _own(kind, spans, places.index(at)))  # type: ignore[arg-type]


def _second(kind: str, held: tuple[int, ...]) -> int:
    """The deflection that the second support holds; 0 where there is none."""
    return held[-1] - held[-1] % 2 if kind != "cantilever" else 0


def _own(kind: str, spans: Sequence[float], load: int) -> float:
    """Lowest natural frequency, held at its supports and where it carries; of unit stiffness and mass [rad/s]."""
    fine = [span / _FINE for span in spans for _ in range(_FINE)]
    stiff, mass = _assembled(fine, _stiffness), _assembled(fine, _mass)
    places = {2 * _FINE * (i // 2) + i % 2 for i in _HELD[kind]} | {2 * _FINE * load}
    free = [i for i in range(len(stiff)) if i not in places]
    root = np.linalg.cholesky(mass[np.ix_(free, free)])  # the greatest compliance: short elements do not round it away
    return float(np.linalg.eigvalsh(root.T @ np.linalg.solve(stiff[np.ix_(free, free)], root))[-1] ** -0.5)


def _assembled(spans: Sequence[float], element: Callable[[float], FloatArray]) -> FloatArray:
    whole = np.zeros((2 * len(spans) + 2, 2 * len(spans) + 2))
    for k, span in enumerate(spans):
        whole[2 * k : 2 * k + 4, 2 * k : 2 * k + 4] += element(span)
    return whole


def _stiffness(length: float) -> FloatArray:
    """Of a beam element of unit bending stiffness: deflection and slope at both ends, (4, 4)."""
    a = length
    table = [[12.0, 6 * a, -12.0, 6 * a], [6 * a, 4 * a * a, -6 * a, 2 * a * a],
             [-12.0, -6 * a, 12.0, -6 * a], [6 * a, 2 * a * a, -6 * a, 4 * a * a]]  # fmt: skip
    return np.array(table) / a**3


def _mass(length: float) -> FloatArray:
    """Of a beam element of unit mass per length, (4, 4)."""
    a = length
    table = [[156.0, 22 * a, 54.0, -13 * a], [22 * a, 4 * a * a, 13 * a, -3 * a * a],
             [54.0, 13 * a, 156.0, -22 * a], [-13 * a, -3 * a * a, -22 * a, 4 * a * a]]  # fmt: skip
    return np.array(table) * a / 420.0
