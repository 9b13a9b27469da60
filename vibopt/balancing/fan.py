"""A weight cut in two for neighbouring holes: what two masses on the rim can do together.

In the gap between two neighbouring holes less than half a turn apart, u = m1 e1 + m2 e2 with m1, m2 >= 0 has one
solution, and m1 + m2 is linear in u.  Over all gaps the sum of both parts is the gauge of the polygon of the holes,
greatest of Re n* u over its sides: convex, and never less than |u|.  A cap on the sum is therefore convex whatever the
holes are.  Only a cap on each hole (a drill goes no deeper) leaves a set that bulges between the holes; then sets of
neighbouring gaps are branched over, and in one gap alone both parts are linear in u.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.records import cached_property, dataclass

HAIR, _ROUNDING = 1e-9, 1e-14
OVER = 1e-9
"""A hole holds more than its cap where it is exceeded by more than this share."""


@dataclass(frozen=True, eq=False)
class Fan:
    """The holes of one plane that may be used.

    holes
        Unit phasors in rising angle, shape (n_holes,).
    gaps
        Neighbouring holes (i, j), j behind i, less than half a turn apart.
    each
        The most one hole takes [kg m]; inf without such a cap.
    """

    holes: ComplexArray
    gaps: tuple[tuple[int, int], ...]
    each: float = float("inf")

    @staticmethod
    def of(angles: Sequence[float], each: float = float("inf")) -> Fan:
        """From the internal angles of the holes [rad] in any order."""
        around = np.sort(np.mod(angles, 2.0 * np.pi))
        around = around[np.diff(around, append=around[:1] + 2.0 * np.pi) > HAIR]
        return Fan(np.exp(1j * around), _near(around), each)

    @cached_property
    def angles(self) -> FloatArray:
        return np.asarray(np.angle(self.holes) % (2.0 * np.pi))

    @cached_property
    def sides(self) -> ComplexArray:
        """Normals n of the polygon of the holes, Re n* e <= 1 for every hole and 1 for the ends of a side."""
        near = _near(self.angles)
        found = [_normal(self.holes[i], self.holes[j]) for i, j in near]
        alone = [k for k in range(len(self.holes)) if not any(k in gap for gap in near)]
        return np.array([*found, *self.holes[alone]], dtype=complex)

    @property
    def most(self) -> float:
        """What all holes take at most [kg m], as u has no more than two parts."""
        return self.each * (2.0 if self.gaps else 1.0)

    @property
    def bulges(self) -> bool:
        """Whether what the holes bear is no convex set."""
        return self.line is not None or (len(self.gaps) > 1 and bool(np.isfinite(self.each)))

    @property
    def faces(self) -> ComplexArray:
        """Normals n of what a hole bears, Re n* u <= each, where one gap or one hole alone is left; else none."""
        if len(self.holes) == 1:
            return self.holes
        if len(self.gaps) != 1 or not np.isfinite(self.each):
            return self.holes[:0]
        first, second = (complex(self.holes[k]) for k in self.gaps[0])
        area = (first.conjugate() * second).imag
        return np.array([-1j * second / area, 1j * first / area])

    def won(self, pulls: FloatArray, cap: float) -> float:
        """Greatest sum of pulls (n_holes,) times parts that neighbouring holes bear under a cap on their sum."""
        pulls, value = np.maximum(pulls, 0.0), min(self.each, cap)
        pairs = np.sort(pulls[np.array(self.gaps, dtype=int).reshape(-1, 2)], axis=1)
        both = pairs @ np.array([min(self.each, cap - value), value])
        return float(max(both.max(initial=0.0), value * pulls.max(initial=0.0)))

    @property
    def line(self) -> complex | None:
        """Direction of two opposite holes, between which nothing acts; None elsewhere."""
        return complex(self.holes[0]) if len(self.holes) == 2 and not _near(self.angles) else None

    @property
    def wedge(self) -> tuple[float, float] | None:
        """(middle, half width) of the directions that the holes reach; None: every direction, or a line."""
        around = self.angles
        if len(around) == 1:
            return float(around[0]), 0.0
        widths = np.diff(around, append=around[0] + 2.0 * np.pi)
        widest = int(np.argmax(widths))
        if self.line is not None or widths[widest] < np.pi - HAIR:
            return None
        half = min(np.pi - 0.5 * float(widths[widest]), 0.5 * np.pi)
        return float(around[(widest + 1) % len(around)]) + half, half

    def gauge(self, u: ComplexArray | complex) -> FloatArray:
        """Both parts together of u (any shape), u being within reach of the holes."""
        return np.asarray(np.maximum((np.asarray(u)[..., None] * self.sides.conj()).real.max(axis=-1), 0.0))

    def parts(self, u: complex) -> tuple[tuple[int, float], ...]:
        """(hole, part) of u cut for the holes around it; the nearest hole alone where no gap reaches."""
        for i, j in self.gaps:
            first, second = _shares(u, complex(self.holes[i]), complex(self.holes[j]))
            if min(first, second) >= -1e-12 * abs(u):
                return (i, max(first, 0.0)), (j, max(second, 0.0))
        near = int(np.argmax((np.conj(u) * self.holes).real))
        return ((near, max(float((np.conj(u) * self.holes[near]).real), 0.0)),)

    def bears(self, u: complex, slack: float) -> bool:
        """Whether parts at the holes around u, none above the cap of a hole, do together what u does."""
        parts = self.parts(u)
        off = abs(sum(part * complex(self.holes[hole]) for hole, part in parts) - u)
        return off <= max(slack, _ROUNDING) * abs(u) and max(part for _, part in parts) <= self.each * (1.0 + slack)

    def excess(self, u: complex) -> float:
        """How much more than its cap a hole would have to take."""
        if not np.isfinite(self.each):
            return 0.0
        return max(self.greatest(u) - self.each * (1.0 + OVER), 0.0)

    def greatest(self, u: complex) -> float:
        """The greater part of u at one hole."""
        return max(part for _, part in self.parts(u))

    def split_at(self, u: complex) -> tuple[Fan, ...]:
        """The gaps in two or three sets of neighbouring ones, cut at the hole next to u; itself where it has one."""
        count = len(self.gaps)
        if count < 2:
            return tuple(Fan(self.holes[k : k + 1], (), self.each) for k in range(len(self.holes)))
        near = int(np.argmax((np.conj(u) * self.holes).real))
        if count == len(self.holes):  # all around
            start = next(k for k, gap in enumerate(self.gaps) if gap[0] == near)
            order = [self.gaps[(start + k) % count] for k in range(count)]
            cuts = sorted({0, -(-count // 3), -(-2 * count // 3), count})
        else:
            first = next(k for k, gap in enumerate(self.gaps) if gap[0] not in [j for _, j in self.gaps])
            order = [self.gaps[(first + k) % count] for k in range(count)]
            inner = [k for k in range(1, count) if order[k][0] == near]
            cuts = [0, inner[0] if inner else count // 2, count]
        return tuple(self._only(order[low:high]) for low, high in pairwise(cuts))

    def _only(self, gaps: Sequence[tuple[int, int]]) -> Fan:
        used = sorted({hole for gap in gaps for hole in gap})
        return Fan(self.holes[used], tuple((used.index(i), used.index(j)) for i, j in gaps), self.each)


def _near(around: FloatArray) -> tuple[tuple[int, int], ...]:
    """Neighbours less than half a turn apart, of rising angles."""
    count = len(around)
    widths = np.diff(around, append=around[:1] + 2.0 * np.pi)
    return tuple((k, (k + 1) % count) for k in range(count) if count > 1 and widths[k] < np.pi - HAIR)


def _normal(first: complex, second: complex) -> complex:
    """n with Re n* first = Re n* second = 1."""
    both = first + second
    return complex(2.0 * both / abs(both) ** 2)


def _shares(u: complex, first: complex, second: complex) -> tuple[float, float]:
    """m1, m2 with u = m1 first + m2 second."""
    area = (first.conjugate() * second).imag
    return (u.conjugate() * second).imag / area, (first.conjugate() * u).imag / area
