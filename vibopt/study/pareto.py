"""The Pareto front of the goal against a bound: which bounds are asked, and which designs are kept."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.study.many import FEWEST_TOGETHER
from vibopt.study.moved_bound import CLOSE, SAME, MovedBound
from vibopt.study.points import Point

FEWEST = 3
_COARSE, _SPARE = 4, 1.05
"""Where each costs an answer: steps of the curve to one of those with which it begins; by how much they are shorter."""
_ROUNDS = 40
RATIO = 100.0
"""Greatest part to least from which on a quantity is counted by ratios."""
Spaced = Callable[[float, float, int], FloatArray]
"""Places from one to another, so many."""


class Front:
    """Designs of which none is better in both quantities, from end to end; one where one is best in both.

    moved
        The bound, whose answers are asked for.
    count
        Neighbours are no further apart than the whole over so many steps, but where there is nothing between.
    """

    def __init__(self, moved: MovedBound, count: int) -> None:
        self.moved, self.wide = moved, 2.0 / (count - 1)
        tight, loose, self.free = moved.ends()
        self.done = self._between(tight, loose, count)
        moved.sharpen()
        moved.untie()
        found = moved.best()
        self.points = self._thinned(found) if len(found) > 1 else found

    def _between(self, tight: float, loose: float, count: int) -> bool:
        """Bounds between both ends until no two neighbours are further apart than the whole over the count.

        Whether it came so far: what is still apart has nothing between.
        """
        spaced = np.geomspace if loose > RATIO * tight else np.linspace
        wished, count = count, self._fitting(count)
        begun = count if self.moved.batch else max(FEWEST, -(-count // _COARSE))
        self.moved.all([tight, *map(float, spaced(tight, loose, begun)[1:-1]), loose])
        left = 4 * count * (FEWEST_TOGETHER if self.moved.batch else 1) + 100
        for _ in range(_ROUNDS):
            wide = list(self._wide(tight, loose, count))
            cut = spaced if self.moved.batch else self._evenly(tight, loose, spaced)
            new = [float(b) for a, c, parts in wide for b in cut(a, c, parts + 1)[1:-1]]
            new += self.moved.beside(c for _, c, _ in wide)
            left -= len(new)
            if not new or left < 0 or self.moved.spent():
                return not new and count == wished
            before = len(self.moved.known)
            self.moved.all(new)
            if len(self.moved.known) == before:
                return False
        return False

    def _evenly(self, tight: float, loose: float, spaced: Spaced) -> Spaced:
        """Bounds between two that are known, so that designs of which each costs an answer lie evenly on the curve."""
        known = self.moved.along(tight, loose)
        bounds = np.array([b for b, _ in known])
        along = np.r_[0.0, self._gaps([point for _, point in known]).cumsum()]
        moves = np.r_[True, np.diff(along) > 0.0]
        by_ratios = spaced is np.geomspace
        if moves.sum() < FEWEST:
            return spaced
        passed, given = along[moves], np.log(bounds[moves]) if by_ratios else bounds[moves]

        def cut(a: float, c: float, count: int) -> FloatArray:
            begin, end = along[np.searchsorted(bounds, [a, c])]
            inside = rising(np.linspace(begin, end, count), passed, given)
            return np.clip(np.exp(inside) if by_ratios else inside, a, c)

        return cut

    def _fitting(self, count: int) -> int:
        """As many steps as the work that is left allows, and no more than are asked for."""
        if self.moved.batch or self.moved.most == np.inf or not self.moved.work:
            return count
        fit = int((self.moved.most - self.moved.work) * self.moved.asked / self.moved.work)
        self.moved.short = self.moved.short or fit < count
        return max(min(count, fit), FEWEST)

    def _wide(self, tight: float, loose: float, count: int) -> Iterator[tuple[float, float, int]]:
        """Neighbouring bounds that are too far apart, and in how many parts to cut them."""
        good = self.moved.along(tight, loose)
        parts_of = self.parts([point for _, point in good])
        gaps = []
        for index, ((a, _), (c, _)) in enumerate(pairwise(good)):
            gap = float(np.abs(parts_of[index + 1] - parts_of[index]).sum())
            if gap > 2.0 / (count - 1) and c - a > CLOSE * min(loose - tight, c):
                steps = gap * (count - 1) / 2.0 * (1.0 if self.moved.batch else _SPARE)
                gaps.append((a, c, min(int(np.ceil(steps)), 64)))
        finer = -(-(FEWEST_TOGETHER + 1) // max(sum(parts - 1 for _, _, parts in gaps), 1)) if self.moved.batch else 1
        for a, c, parts in gaps:
            yield a, c, max(parts, 2) * finer

    def _thinned(self, points: list[Point]) -> list[Point]:
        """As few of the points as keep neighbours as near as they should be, both ends among them."""
        along = np.abs(np.diff(self.parts(points), axis=0)).sum(axis=1).cumsum()
        kept, last = [0], 0.0
        for index in range(1, len(points) - 1):
            if along[index] - last > self.wide * (1.0 + SAME):
                kept.append(index)
                last = float(along[index - 1])
        return [points[index] for index in (*kept, len(points) - 1)]

    @property
    def gap(self) -> float:
        """Greatest distance of neighbours between which something lies: parts of both spans, added."""
        jumps = self.jumps
        return max((float(gap) for i, gap in enumerate(self._gaps(self.points)) if i not in jumps), default=0.0)

    def _gaps(self, found: Sequence[Point]) -> FloatArray:
        return np.asarray(np.abs(np.diff(self.parts(found), axis=0)).sum(axis=1))

    @property
    def jumps(self) -> tuple[int, ...]:
        """Points behind which nothing lies, by index."""
        wide = self.wide * (1.0 + SAME)
        return tuple(i for i, gap in enumerate(self._gaps(self.points)) if self.done and gap > wide)

    def parts(self, points: Sequence[Point]) -> FloatArray:
        """Both quantities from their best (0) to their worst (1), (n, 2); by ratios where they span a factor 100."""
        columns: list[FloatArray] = []
        for values in (
            np.array([self.moved.loss(point) for point in points]),
            np.array([self.moved.cost(point) for point in points]),
        ):
            size, way = np.abs(values), np.sign(values.sum())
            if not (self.moved.fades and not columns) and size.min() > 0.0 and size.max() > RATIO * size.min():
                values = way * np.log(size)
            columns.append((values - values.min()) / (np.ptp(values) or 1.0))
        return np.stack(columns, axis=-1)


def rising(at: FloatArray, x: FloatArray, y: FloatArray) -> FloatArray:
    """A smooth curve through three or more points (n,), both rising, at places between them: it rises everywhere.

    Cubic pieces with harmonic means of the slopes beside each point (Fritsch and Butland 1984); scipy has the same, and
    takes longer to load than a trade-off to find.
    """
    widths = np.diff(x)
    slopes = np.diff(y) / widths
    before, behind = 2.0 * widths[1:] + widths[:-1], widths[1:] + 2.0 * widths[:-1]
    inner = (before + behind) / (before / slopes[:-1] + behind / slopes[1:])
    slope = np.r_[slopes[0], inner, slopes[-1]]
    piece = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(widths) - 1)
    h = widths[piece]
    t = (at - x[piece]) / h
    left, right, m = slope[piece], slope[piece + 1], slopes[piece]
    return np.asarray(y[piece] + h * t * (left + t * (3.0 * m - 2.0 * left - right + t * (left + right - 2.0 * m))))
