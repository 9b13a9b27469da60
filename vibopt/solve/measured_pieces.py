"""A program measured exactly at one design: every local extreme of its limits and goal as a row with its slopes.

Everything is in y = log x.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import field

import numpy as np

from vibopt.arrays import BoolArray, FloatArray
from vibopt.forms.form import Local
from vibopt.mechanics.modes import frequency_bends, frequency_slopes
from vibopt.program.program import Aim, Limit, Program
from vibopt.records import dataclass
from vibopt.work import Budget

BEYOND = 40.0
"""Log violation from which on a limit is missed without end (an undamped resonance within its band)."""
_NEVER = -20.0
"""Log of the part of its bound below which a row holds nothing back, and may be rounding with endless slopes."""
SLOPES = 4.0
"""Work of a measurement with its slopes, in exact measurements."""
_AWAY = 3.0
"""Log of the factor by which a mode that is looked at may be away from a forbidden band."""


@dataclass(frozen=True, slots=True)
class Piece:
    """One local extreme as a row: value <= 0 for a limit, the value itself for the goal.

    part
        Index of the limit; -1 for the goal, -2 and on for it on other machines.
    mark
        Logs of its speeds, to find it again at a near design.
    bend
        Second derivative in y, shape (n_vars, n_vars); None where not known.
    """

    part: int
    value: float
    slope: FloatArray
    mark: tuple[float, ...]
    bend: FloatArray | None = None


@dataclass(frozen=True)
class Point:
    """A design y (n_vars,) with all its pieces."""

    y: FloatArray
    limits: tuple[Piece, ...]
    goals: tuple[Piece, ...]

    @property
    def missed(self) -> float:
        """Log of the factor by which the worst limit is missed; negative when all are met."""
        return max((piece.value for piece in self.limits), default=-BEYOND)

    @property
    def bends_known(self) -> bool:
        return all(piece.bend is not None for piece in (*self.goals, *self.limits))

    @property
    def goal(self) -> float:
        return max((piece.value for piece in self.goals), default=0.0)


@dataclass
class Exact:
    """Exact pieces of a program at any design.

    free
        Axes that can be chosen, shape (n_vars,).
    budget
        Measurements that there may be.
    """

    program: Program
    low: FloatArray
    high: FloatArray
    budget: Budget
    known: dict[bytes, Point] = field(default_factory=dict)
    free: BoolArray = field(init=False)

    def __post_init__(self) -> None:
        self.free = self.high > self.low

    def at(self, y: FloatArray) -> Point:
        """All pieces at y (n_vars,); remembered, for a lightly damped machine takes long to measure."""
        key = np.asarray(y, dtype=float).tobytes()
        if key not in self.known:
            self.known[key] = self._at(y)
        return self.known[key]

    def some(self, y: FloatArray, parts: set[int]) -> list[Point]:
        """The pieces of some parts alone, numbered as in `Piece`, at designs y (n, n_vars) that are told once."""
        missing = [np.exp(one) for one in y if one.tobytes() not in self.known]
        with np.errstate(all="ignore"):  # at once what takes less for many together
            for number, part in self._numbered if len(missing) > 1 else ():
                if number in parts:
                    part.form.ahead(part.model, np.array(missing))
        return [self.known.get(one.tobytes()) or self._at(one, parts) for one in y]

    @property
    def _numbered(self) -> list[tuple[int, Limit | Aim]]:
        aims = self.program.aim.pieces if self.program.aim is not None else ()
        return [*enumerate(self.program.limits), *((-1 - i, each) for i, each in enumerate(aims))]

    def _at(self, y: FloatArray, parts: set[int] | None = None) -> Point:
        self.budget.spend()
        x, limits, goals = np.exp(y), list[Piece](), list[Piece]()
        for number, part in self._numbered:
            if parts is None or number in parts:
                if isinstance(part, Limit):
                    limits += self._limit(number, part, x)
                else:
                    goals += (_piece(number, extreme, part.sense, 0.0) for extreme in part.extremes(x))
        limits = [piece for piece in limits if piece.value > _NEVER] or limits  # as the bending of a free end
        return Point(np.array(y), tuple(limits), tuple(goals if self.program.aim is not None else limits))

    def _limit(self, index: int, limit: Limit, x: FloatArray) -> Iterator[Piece]:
        if limit.side == "outside":
            yield from _outside(index, limit, x)
            return
        sense = 1.0 if limit.side == "at_most" else -1.0
        bound = np.log(limit.bound) if limit.bound > 0.0 else -1e30
        for extreme in limit.extremes(x):
            yield _piece(index, extreme, sense, bound)


def _piece(index: int, local: Local, sense: float, bound: float) -> Piece:
    mark = tuple(np.log(np.maximum(local.speeds, 1e-300)))
    value = sense * (local.value - bound)
    if not np.isfinite(value):
        value = np.copysign(BEYOND, value)
    bend = None if local.bend is None else sense * local.bend
    return Piece(index, float(np.clip(value, -BEYOND, BEYOND)), sense * local.slope, mark, bend)


def _outside(index: int, limit: Limit, x: FloatArray) -> Iterator[Piece]:
    """Depth of each mode in the forbidden band, to the nearer end; of those that are not far beyond it."""
    omega, slopes = frequency_slopes(limit.model, x)
    log = np.log(np.maximum(omega, 1e-300))
    low, high = np.log(max(limit.bound, 1e-300)), np.log(limit.upper)
    away = np.maximum(np.maximum(low - log, log - high), 0.0)
    modes = np.flatnonzero(away <= max(_AWAY, float(away.min()))).tolist()
    bends: Sequence[FloatArray | None] = frequency_bends(limit.model, x, modes) or [None] * len(modes)
    for mode, bend in zip(modes, bends, strict=True):
        value, sign = log[mode], -1.0 if high - log[mode] < log[mode] - low else 1.0
        depth = float(min(value - low, high - value))
        yield Piece(index, depth, sign * slopes[mode], (float(mode),), None if bend is None else sign * bend)
