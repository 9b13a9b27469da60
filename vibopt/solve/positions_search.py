"""Search of a box by comparisons alone: scan and golden section of one coordinate; lattice and simplex of several."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import field

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.records import dataclass
from vibopt.work import Budget

Score = tuple[int, float]
"""Less is better: 0 and the goal where every limit holds, else 1 and by how much they are missed."""
FINE = 1e-9
"""Width of a last bracket, as a part of the range."""
_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
_SCAN = 33
_BRACKETS = 4
_STARTS = 3
_LATTICE = 24
"""Points of the lattice per coordinate."""
_SNAP = 1e-5
_EQUAL = 1e-11


class _EnoughError(Exception):
    """The points are used up."""


@dataclass
class Search:
    """Points of the unit box looked at so far, each once; `cut` where the search was cut short."""

    ask: Callable[[FloatArray], Score]
    count: int
    budget: Budget
    tell: Callable[[int], None]
    seen: dict[tuple[float, ...], Score] = field(default_factory=dict)
    cut: bool = False
    finished: bool = False

    def score(self, u: FloatArray) -> Score:
        """Of a point, moved into the box."""
        u = np.clip(u, 0.0, 1.0)
        key = tuple(float(one) for one in u)
        if key not in self.seen:
            if self.finished or self.budget.over:
                self.cut = not self.finished
                raise _EnoughError
            self.budget.spend()
            self.tell(self.budget.spent)
            self.seen[key] = self.ask(u)
            self.finished = self.seen[key] == (0, -np.inf)
        return self.seen[key]

    def best(self) -> FloatArray:
        """The best point; among equals the first that was looked at."""
        return np.array(min(self.seen, key=lambda one: self.seen[one]))

    def run(self) -> FloatArray:
        """The best point of the box that is found."""
        try:
            if self.count == 1:
                self._line()
            else:
                self._box()
            self._ends()
        except _EnoughError:
            pass
        return self.best()

    def _line(self) -> None:
        """A scan, then golden section in the best brackets."""
        grid = np.linspace(0.0, 1.0, _SCAN)
        scores = [self.score(np.array([u])) for u in grid]
        padded = [(2, np.inf), *scores, (2, np.inf)]
        lows = [i for i in range(_SCAN) if scores[i] <= padded[i] and scores[i] <= padded[i + 2]]
        for i in sorted(lows, key=lambda one: scores[one])[:_BRACKETS]:
            low, high = grid[max(i - 1, 0)], grid[min(i + 1, _SCAN - 1)]
            self._golden(np.zeros(1), np.ones(1), low, high)

    def _golden(self, base: FloatArray, way: FloatArray, low: float, high: float, fine: float = FINE) -> None:
        """Golden section of base + t way for t between low and high."""
        step = _GOLDEN * (high - low)
        a, b = high - step, low + step
        at, bt = self.score(base + a * way), self.score(base + b * way)
        while high - low > fine:
            if at <= bt:
                high, b, bt = b, a, at
                a = high - _GOLDEN * (high - low)
                at = self.score(base + a * way)
            else:
                low, a, at = a, b, bt
                b = low + _GOLDEN * (high - low)
                bt = self.score(base + b * way)

    def _box(self) -> None:
        """Lattice, then from the best points apart a simplex and a poll."""
        for u in _lattice(self.count):
            self.score(u)
        for start in self._apart():
            self._simplex(start, 0.12)
        for size in (0.02, 1e-3, 1e-5):
            self._simplex(self.best(), size)
            self._poll(size)
            self._axes(size)

    def _apart(self) -> list[FloatArray]:
        """The best points that lie apart from each other."""
        chosen: list[FloatArray] = []
        for key in sorted(self.seen, key=lambda one: self.seen[one]):
            here = np.array(key)
            if all(np.abs(here - other).max() > 0.15 for other in chosen):
                chosen.append(here)
            if len(chosen) == _STARTS:
                break
        return chosen

    def _simplex(self, start: FloatArray, size: float) -> None:
        """The simplex of Nelder and Mead, Computer Journal 7 (1965), kept in the box by clipping."""
        inward = np.where(start > 0.5, -size, size)
        points = [start, *(start + inward * one for one in np.eye(self.count))]
        for _ in range(60 * self.count):
            points.sort(key=self.score)
            if np.abs(np.array(points[1:]) - points[0]).max() < 1e-4 * size:
                return
            worst, centre = points[-1], np.mean(points[:-1], axis=0)

            def along(t: float, worst: FloatArray = worst, centre: FloatArray = centre) -> FloatArray:
                return np.clip(centre + t * (centre - worst), 0.0, 1.0)

            mirrored = along(1.0)
            score = self.score(mirrored)
            if score < self.score(points[0]):
                far = along(2.0)
                points[-1] = far if self.score(far) < score else mirrored
            elif score < self.score(points[-2]):
                points[-1] = mirrored
            else:
                near = along(0.5 if score < self.score(worst) else -0.5)
                if self.score(near) < min(score, self.score(worst)):
                    points[-1] = near
                else:
                    points = [points[0], *(0.5 * (point + points[0]) for point in points[1:])]

    def _poll(self, size: float) -> None:
        """Steps both ways along turned axes, a new turn each round; finds its way along kinks and limits.

        Audet and Dennis, SIAM J. Optim. 17 (2006), with the reflected axes of Abramson et al., ibid. 20 (2009).
        """
        turns = _directions(self.count)
        while size > FINE:
            here = self.best()
            before = self.score(here)
            basis = next(turns)
            for way in np.concatenate([basis, -basis]):
                if self.score(here + size * way) < before:
                    self.score(here + 3.0 * size * way)
                    break
            size *= 1.5 if self.score(self.best()) < before else 0.6

    def _axes(self, size: float) -> None:
        """Golden section along each axis about the best point."""
        for way in np.eye(self.count):
            here = self.best()
            at = float(here @ way)
            low, high = max(-size, -at), min(size, 1.0 - at)
            self._golden(here, way, low, high, 1e-4 * size)

    def _ends(self) -> None:
        """A coordinate next to an end is put on it, where that is no worse than rounding."""
        for i in range(self.count):
            here = self.best()
            for end in (0.0, 1.0):
                if 0.0 < abs(here[i] - end) <= _SNAP:
                    other = here.copy()
                    other[i] = end
                    rank, value = self.score(other)
                    old_rank, old = self.score(here)
                    if rank == old_rank and value <= old + _EQUAL * abs(old):
                        self.seen[tuple(float(one) for one in other)] = rank, min(value, np.nextafter(old, -np.inf))


def _lattice(count: int) -> list[FloatArray]:
    """Middle, corners, middles of faces, and a rank-one lattice: the same points every time, shape (count,)."""
    points = [np.full(count, 0.5)]
    points += [np.clip(0.5 + 0.5 * side * one, 0.0, 1.0) for one in np.eye(count) for side in (-1.0, 1.0)]
    if count <= 5:
        points += [np.array([(n >> i) & 1 for i in range(count)], dtype=float) for n in range(2**count)]
    root = 2.0
    for _ in range(60):
        root = (1.0 + root) ** (1.0 / (count + 1))
    step = np.array([root ** -(i + 1) for i in range(count)])
    points += [(0.5 + step * (n + 1)) % 1.0 for n in range(_LATTICE * count)]
    return points


def _directions(count: int) -> Iterator[FloatArray]:
    """Orthogonal axes, turned anew each time by the same sequence of mirrors, (count, count)."""
    number = 0
    yield np.eye(count)
    while True:
        number += 1
        v = np.array([((number * one) % 1.0) - 0.5 for one in np.sqrt([2, 3, 5, 7, 11, 13, 17, 19, 23, 29][:count])])
        size = float(np.linalg.norm(v))
        yield np.eye(count) - 2.0 * np.outer(v, v) / size**2 if size > 1e-9 else np.eye(count)
