"""Machines beyond a box: drawn where numbers are far off, which few of all machines are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vibopt.arrays import BoolArray, FloatArray
from vibopt.program.drawn import shares_of
from vibopt.program.program import Axis
from vibopt.records import dataclass
from vibopt.scene.uncertain import Uncertain
from vibopt.values.tolerance import DATA, Scatter


@dataclass(frozen=True)
class Beyond:
    """All machines but those of a box of the numbers that are `bounded`, each alike far off to either side.

    doubts
        All uncertain numbers.
    bounded
        Whether the box bounds each number, (n_doubts,).
    part
        Share of all machines that lies beyond.
    """

    doubts: tuple[Uncertain, ...]
    bounded: BoolArray
    part: float

    @classmethod
    def of(cls, doubts: Sequence[Uncertain], acting: BoolArray, part: float) -> Beyond:
        """The box in the numbers that act (n_doubts,) beyond which a share of all machines lies; data is not cut."""
        cut = [isinstance(doubt.tolerance, Scatter) and doubt.tolerance.kind != DATA for doubt in doubts]
        return cls(tuple(doubts), acting & np.array(cut), part)

    @property
    def tail(self) -> float:
        """Share of all machines beyond either end of one number."""
        return 0.5 * float(-np.expm1(np.log1p(-self.part) / self.bounded.sum()))

    @property
    def axes(self) -> tuple[Axis, ...]:
        """The box, in factors."""
        ends = np.array([self.tail, 1.0 - self.tail])
        return tuple(
            Axis(uncertain.path, *(_factors(uncertain, ends) if bounded else uncertain.ends))
            for uncertain, bounded in zip(self.doubts, self.bounded, strict=True)
        )

    def machines(self, count: int, stream: str = "") -> FloatArray:
        """Factors of machines that lie beyond, shape (count, n_doubts), as `drawn` draws them of all.

        The first of the bounded numbers that is outside is drawn by its chance; those before it are inside, those
        behind it anywhere.
        """
        shares = shares_of([doubt.path for doubt in self.doubts], count, stream)
        where = np.flatnonzero(self.bounded)
        inside = 1.0 - 2.0 * self.tail
        ends = np.cumsum((1.0 - inside) * inside ** np.arange(len(where))) / self.part
        (chance,) = shares_of(["first outside"], count, stream).T
        first = np.minimum(np.searchsorted(ends, chance, side="right"), len(where) - 1)
        for k, column in enumerate(where):
            own = shares[:, column]
            outside = np.where(own < 0.5, 2.0 * own * self.tail, 1.0 - 2.0 * (1.0 - own) * self.tail)
            shares[:, column] = np.where(first > k, self.tail + inside * own, np.where(first == k, outside, own))
        return np.stack([_factors(uncertain, shares[:, k]) for k, uncertain in enumerate(self.doubts)], axis=1)


def _factors(uncertain: Uncertain, shares: FloatArray) -> FloatArray:
    assert isinstance(uncertain.tolerance, Scatter)
    return uncertain.tolerance.factors(shares)
