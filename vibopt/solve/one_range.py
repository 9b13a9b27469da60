"""One variable, always decided: every limit and the goal are followed over its whole range.

The range is cut into pieces.  On each the limits and the goal, measured exactly at the nodes, are polynomials
to within what their last coefficients say; a piece is dropped where a limit is broken or the goal is no better
on all of it, and halved until everything that matters there is known to the last digits.  Resonances can be
narrower than any piece, so pieces end wherever a natural frequency meets a frequency that a limit looks at.
"""

from __future__ import annotations

import heapq
import warnings
from collections.abc import Iterator
from dataclasses import field, replace
from itertools import pairwise

import numpy as np

from vibopt.answer.entry import TOLERANCE
from vibopt.arrays import FloatArray, crossing, joined
from vibopt.errors import counted
from vibopt.mechanics.model import Model
from vibopt.program.meetings import meetings, watched
from vibopt.program.program import Aim, Limit, Program
from vibopt.records import dataclass
from vibopt.solve.branch import ZERO, Judge
from vibopt.solve.method import VANISHED, Found, Progress
from vibopt.work import Budget, late

_DEGREE = 8
_NODES = 0.5 - 0.5 * np.cos(np.pi * np.arange(_DEGREE + 1) / _DEGREE)
"""Places of the nodes on a piece, from 0 to 1."""
_FIRST = 16
"""Pieces to begin with, at least, a quarter of them where values are dear and known to less; two for each factor e."""
_MET = 0.5 * TOLERANCE
"""Violation [share of value and bound] that counts as none: half of what the judge lets pass."""
_CLEAR = 1e-10
"""Doubt of a limit or of the goal at which it is known."""
_FLOOR = 1e-12
_SAFETY = 4.0
_NARROW = 1e-12
"""Part of the range below which nothing is halved."""
_SHORT, _LEAP, _SPECK, _LEAPT = 1.0 / 64.0, 0.6, 1e-10, 1e-6
"""Part of the range from which down leaps of a limit are looked for; part of all of its changes on a piece that one is;
part of the range that is too narrow to be told beside a leap; by which limits hold where one of them leaps."""
_PIECES, _FEWEST, _WORK = 20_000, 500, 1e5
"""Most pieces, and how many where each is dear: work of all of them [nominal ms]."""
_GAP = 1e-9
_ROUNDED = 1e-12, 1e-10
"""Part by which coefficients may be off, and of the size that a goal is given which is nothing but that."""
_SLOW = 1e-2
"""Part of the goal that it may still gain towards an open end and yet come near to a best value there."""


@dataclass(frozen=True)
class _Piece:
    """A part [low, high] of the range, measured at its nodes: rows are the limits and, last, the goal.

    coefficients
        Of Chebyshev's polynomials, shape (n_rows, degree + 1).
    doubt, clear
        How far they may be wrong, and how far at which they are known, shape (n_rows,) each.
    """

    low: float
    high: float
    coefficients: FloatArray
    doubt: FloatArray
    clear: FloatArray

    @property
    def least(self) -> FloatArray:
        """No row is less than this on the piece, shape (n_rows,)."""
        return np.asarray(self.coefficients[:, 0] - np.abs(self.coefficients[:, 1:]).sum(axis=1) - self.doubt)

    @property
    def most(self) -> FloatArray:
        """No row is greater than this on the piece, shape (n_rows,)."""
        return np.asarray(self.coefficients[:, 0] + np.abs(self.coefficients[:, 1:]).sum(axis=1) + self.doubt)

    @property
    def matters(self) -> list[int]:
        """Indices of limits that may be broken somewhere on the piece."""
        return np.flatnonzero(self.most[:-1] > _MET).tolist()

    @property
    def known(self) -> bool:
        """Whether what matters is known to the last digits, or nothing is left to halve."""
        rows = [*self.matters, len(self.doubt) - 1]
        return self.high - self.low <= _NARROW or bool((self.doubt <= self.clear)[rows].all())

    def turns(self) -> Iterator[tuple[int, float]]:
        """Row and place of every root of a limit that matters and of every level place of any row that matters."""
        cheb = np.polynomial.chebyshev
        for row in [*self.matters, len(self.doubt) - 1]:
            values = np.trim_zeros(self.coefficients[row], "b")
            lines = [cheb.chebder(values)] if len(values) > 1 else []
            lines += [values] if row < len(self.doubt) - 1 else []
            for line in lines:
                roots = cheb.chebroots(line) if len(line) > 1 else np.zeros(0)
                real = roots[(np.abs(roots.imag) < 1e-6) & (np.abs(roots.real) <= 1.0)].real
                yield from ((int(row), self.low + 0.5 * (one + 1.0) * (self.high - self.low)) for one in real)


def _nodes(low: float, high: float) -> FloatArray:
    places = low + (high - low) * _NODES
    places[0], places[-1] = low, high
    return places


def _fitted(low: float, high: float, values: FloatArray, clear: FloatArray) -> _Piece:
    """A piece by values (degree + 1, n_rows) at its nodes."""
    coefficients = (_TO_CHEBYSHEV @ values).T
    return _Piece(low, high, coefficients, _SAFETY * np.abs(coefficients[:, -3:]).sum(axis=1) + _FLOOR, clear)


@dataclass(frozen=True)
class OneRange:
    """One continuous variable with limits and goal of any kind.

    gap
        Part of the goal by which a better design may be missed.
    fewest
        Pieces that it may look at, however dear each is.
    """

    gap: float = _GAP
    fewest: int = _FEWEST
    name = "one_range"
    summary = "every limit and the goal followed over the whole range of the one variable"

    def refuses(self, program: Program) -> str | None:
        if len(program.axes) != 1 or program.axes[0].values is not None:
            return "there is not exactly one continuous variable."
        return None

    def solve(self, program: Program, progress: Progress | None = None) -> Found:
        """Status "optimal", "infeasible" or "unbounded"; "feasible" or "unproven" where the pieces are used up."""
        return _Run(program, progress, self.gap, self.fewest).answer()


@dataclass(frozen=True)
class Permitted:
    """Every value of the one variable at which all limits hold, as closed intervals [SI].

    ends
        Per interval the limits that end it below and above, by name; "" at an end of the range.
    complete
        Whether nothing was left open.
    """

    intervals: tuple[tuple[float, float], ...]
    ends: tuple[tuple[str, str], ...]
    complete: bool


def permitted(program: Program) -> Permitted:
    """All values of the one continuous variable at which every limit of a program holds."""
    return _Run(replace(program, aim=None), None).permitted()


@dataclass
class _Run:
    program: Program
    progress: Progress | None
    gap: float = _GAP
    fewest: int = _FEWEST
    rows: dict[float, FloatArray] = field(default_factory=dict)
    best: tuple[float, float] | None = None
    """Goal as it is compared, and the place of the best design."""
    looked: tuple[float, float] | None = None
    """The last of them that might have left nothing of the goal."""

    def __post_init__(self) -> None:
        self.judge = Judge(self.program)
        most = int(np.clip(_WORK / (_DEGREE * self.program.cost), self.fewest, _PIECES))
        self.budget = Budget(most, "pieces")  # its measurements are counted one by one
        axis = self.program.axes[0]
        low, high = float(axis.low), float(axis.high)
        self.bend = low if low > 0.0 else high * (1e-15 if axis.open_high else 1e-6)
        self.span = float(np.log1p((high - low) / self.bend))
        self.size = 1.0
        self.missed: dict[tuple[float, int], tuple[float, float]] = {}
        parts = [*([limit] for limit in self.program.limits), self.program.aim.pieces if self.program.aim else ()]
        self.clear = np.array([max([_CLEAR, *(part.form.known_to for part in row)]) for row in parts])
        ranks = [(limit.form.dear, bool(getattr(limit.form, "bands", ()))) for limit in self.program.limits]
        self.groups = [[k for k, rank in enumerate(ranks) if rank == one] for one in sorted(set(ranks))]

    def x(self, place: float) -> FloatArray:
        """Design at a place of the range, 0 to 1; even in logarithms."""
        axis = self.program.axes[0]
        if place in (0.0, 1.0):
            return np.array([axis.low if place == 0.0 else axis.high], dtype=float)
        inside = float(axis.low + self.bend * np.expm1(place * self.span))
        return np.array([min(max(inside, axis.low), axis.high)])

    def answer(self) -> Found:
        if self.span == 0.0:
            self.row(0.0)
            return self._found("one value is all there is", proven=True)
        ends = self._ends()
        self._scale(ends)
        if self.program.aim is None:  # one design is enough
            for end in ends:
                self.row(end)
                if self.best is not None:
                    return Found("optimal", self.x(end), "a design that meets every limit", OneRange.name)
        heap = [(piece.least[-1], index, piece) for index, piece in enumerate(self._pieces(ends))]
        heapq.heapify(heap)
        count = len(heap)
        while heap:
            if self.best is not None and self._vanishes(self.best):
                details = {"pieces": self.budget.spent, "goal": 0.0}
                return Found("optimal", self.x(self.best[1]), VANISHED, OneRange.name, 0.0, details, zero=True)
            goal, _, piece = heapq.heappop(heap)
            if self._done(goal):
                heap = []
            elif not self._broken(piece):
                if self.budget.over:
                    return self._found(f"{self.budget} did not settle it", proven=False)
                if self.progress is not None:
                    self.progress("one range", self.budget.part)
                if piece.known:
                    self._settle(piece)
                else:
                    for half in self._halves(piece):
                        heapq.heappush(heap, (half.least[-1], count, half))
                        count += 1
        return self._found(counted(count, "pieces"), proven=True)

    def _vanishes(self, best: tuple[float, float]) -> bool:
        """Whether a design leaves nothing of an amplitude that is to be least; looked at where it may."""
        goals = [row[-1] for row in self.rows.values() if np.isfinite(row[-1])]
        first = self.looked is None
        if best == self.looked or not (first or best[0] <= ZERO * max(goals)):
            return False
        self.looked = best
        return self.judge.vanishes(self.x(best[1]))

    def permitted(self) -> Permitted:
        """The pieces on which every limit holds, put together."""
        ends = self._ends()
        left = self._pieces(ends)[::-1]
        good: list[tuple[float, float]] = []
        while left and not self.budget.over:
            piece = left.pop()
            if self._broken(piece):
                continue
            if not piece.matters:
                good.append((piece.low, piece.high))
            elif piece.known:
                good += self._good(piece)
            else:
                left += self._halves(piece)[::-1]
        merged = _without_specks(joined(good))
        values = tuple((float(self.x(low)[0]), float(self.x(high)[0])) for low, high in merged)
        ended = tuple((self._holder(low, -1.0), self._holder(high, 1.0)) for low, high in merged)
        return Permitted(values, ended, not left)

    def _good(self, piece: _Piece) -> list[tuple[float, float]]:
        """Parts of a known piece on which every limit holds, and places where the worst of them just does."""
        if piece.high - piece.low <= _NARROW:  # a leap: nothing is told of between
            held = [end for end in (piece.low, piece.high) if self._holds(end)]
            return [(held[0], held[-1])] if held else []
        places = [self._cross(row, place, piece) for row, place in piece.turns() if row < len(self.program.limits)]
        cuts = sorted({piece.low, piece.high, *places})
        parts = [two for two in pairwise(cuts) if self._holds(0.5 * (two[0] + two[1]))]
        return [*parts, *((cut, cut) for cut in cuts if self._holds(cut))]

    def _holds(self, place: float) -> bool:
        return all(self._missed(place, k)[1] <= 2.0 * _MET for some in self.groups for k in some)

    def _holder(self, place: float, outward: float) -> str:
        """The limit that ends an interval at a place; "" where the range itself does."""
        row = self.row(place)[:-1]
        if place in (0.0, 1.0) or not len(row):
            return ""
        if row.max() >= -_LEAPT:
            return self.program.limits[int(row.argmax())].name
        places = {one for one, _ in self.missed if outward * (one - place) > 0.0}
        broken = [one for one in places if not self._holds(one)]
        if broken:
            row = self.row(min(broken, key=lambda one: abs(one - place)))[:-1]
        return self.program.limits[int(row.argmax())].name

    def _done(self, goal: float) -> bool:
        """Whether nothing from here on is better: pieces come with the least goal first."""
        if self.best is None:
            return False
        return self.program.aim is None or goal >= self.best[0] - self.gap * max(abs(self.best[0]), 1e-3)

    @staticmethod
    def _broken(piece: _Piece) -> bool:
        return bool((piece.least[:-1] > 1.2 * _MET).any())

    def _halves(self, piece: _Piece) -> list[_Piece]:
        """A piece in two, or in what lies before and behind a leap of a limit that matters."""
        cuts = self._leap(piece) if piece.high - piece.low <= _SHORT else ()
        return self._pieces(sorted({piece.low, *(cuts or (0.5 * (piece.low + piece.high),)), piece.high}))

    def _leap(self, piece: _Piece) -> tuple[float, ...]:
        """Two places next to each other between which a limit leaps; none where it only changes quickly."""
        places = _nodes(piece.low, piece.high).tolist()
        for row in piece.matters:
            values = {place: self._missed(place, row)[1] for place in places}
            steps = np.abs(np.diff(list(values.values())))
            k = int(steps.argmax())
            (low, high), most = places[k : k + 2], _LEAP * float(steps.sum())
            while not late() and high - low > _NARROW and abs(values[high] - values[low]) > most:
                middle = 0.5 * (low + high)
                values[middle] = self._missed(middle, row)[1]
                before, behind = (abs(values[middle] - values[end]) for end in (low, high))
                low, high = (low, middle) if before > behind else (middle, high)
            if high - low <= _NARROW:
                return low, high
        return ()

    def _pieces(self, ends: list[float]) -> list[_Piece]:
        """Pieces side by side: what is measured sooner at many designs at once is."""
        places = {float(node) for two in pairwise(ends) for node in _nodes(*two)} - self.rows.keys()
        self.judge.ahead(np.array([self.x(place) for place in sorted(places)]))
        return [self._piece(*two) for two in pairwise(ends)]

    def _piece(self, low: float, high: float) -> _Piece:
        rows = len(self.program.limits) + 1
        if self.best is not None and late(str(self.budget)):  # nothing is known of what is not measured any more
            return _Piece(low, high, np.zeros((rows, 1)), np.full(rows, np.inf), self.clear)
        places = _nodes(low, high).tolist()
        for some in self.groups:  # what takes less work comes first, and may rule the piece out
            values = np.array([[self._missed(place, k)[1] for k in some] + [0.0] for place in places])
            piece = _fitted(low, high, values, self.clear[[*some, -1]])
            if self._broken(piece):
                return piece
        self.budget.spend()
        return _fitted(low, high, np.array([self.row(place) for place in places]), self.clear)

    def row(self, place: float) -> FloatArray:
        """Violations, each from -1 to 1, and the goal as it is compared; a feasible design is kept if it is best."""
        if place not in self.rows:
            self.rows[place] = self._measured(place)
        return self.rows[place]

    def _measured(self, place: float) -> FloatArray:
        found = [self._missed(place, k) for k in range(len(self.program.limits))]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            goal = self._compared(self.judge.goal(self.x(place)).value)
        good = not np.isnan(goal) and max((part for part, _ in found), default=-1.0) <= self.judge.tolerance
        if good and (self.best is None or goal < self.best[0]):
            self.best = goal, place
        return np.array([*(shown for _, shown in found), 1.0 if np.isnan(goal) else goal])

    def _missed(self, place: float, index: int) -> tuple[float, float]:
        """By which part of its bound a limit is missed, and its violation from -1 to 1."""
        if (place, index) not in self.missed:
            limit = self.program.limits[index]
            with warnings.catch_warnings():  # far ends have matrices without digits; what comes of it is no design
                warnings.simplefilter("ignore")
                part, worst = self.judge.limit(limit, self.x(place))
            told = part if np.isfinite(worst.value) or worst.value > 0.0 else np.inf
            self.missed[place, index] = told, _violation(limit, part, worst.value)
        return self.missed[place, index]

    def _compared(self, value: float) -> float:
        """The goal between -1 and 1, in the same order."""
        return float(np.sign(value)) if np.isinf(value) else value / (abs(value) + self.size)

    def _scale(self, ends: list[float]) -> None:
        """Take the size of the goal from its values."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            values = np.abs([self.judge.goal(self.x(end)).value for end in ends])
        aim = self.program.aim
        rounded = 0.0 if aim is None else aim.form.room(aim.model, self.x(ends[0]), 0.0, 0.0, _ROUNDED[0])
        good = values[np.isfinite(values) & (values > rounded)]
        self.size = float(np.exp(np.log(good).mean())) if len(good) else rounded / _ROUNDED[1] or 1.0

    def _ends(self) -> list[float]:
        """Ends of the first pieces: evenly spread, and where a natural frequency meets one that is looked at."""
        count = max(_FIRST if self.clear.max() <= _CLEAR else _FIRST // 4, int(np.ceil(2.0 * self.span)))
        return sorted({*np.linspace(0.0, 1.0, count + 1).tolist(), *self._meetings()})

    def _meetings(self) -> list[float]:
        """Places at which a free motion of a machine meets a frequency that is looked at there."""
        least = int(np.ceil(4.0 * self.span))
        return [place for model, asked in self._watched() for place in meetings(model, asked, self.x, least)]

    def _watched(self) -> list[tuple[Model, FloatArray]]:
        """Models, each with the frequencies that matter on it."""
        every: list[Limit | Aim] = [*self.program.limits]
        every += self.program.aim.pieces if self.program.aim is not None else ()
        groups: dict[int, list[Limit | Aim]] = {}
        for part in every:
            groups.setdefault(id(part.model), []).append(part)
        found = [(parts[0].model, watched(parts)) for parts in groups.values()]
        return [(model, asked) for model, asked in found if len(asked) and model.n_free]

    def _settle(self, piece: _Piece) -> None:
        """Measure every design of a known piece that could be the best on it."""
        for row, place in piece.turns():
            self.row(place)
            if row < len(self.program.limits):
                self._cross(row, place, piece)

    def _cross(self, row: int, place: float, piece: _Piece) -> float:
        """Where one limit is just met, near a place at which its polynomial is zero; that place itself elsewhere."""
        part = 1e-4 if self.clear[row] <= _CLEAR else 1.0
        reach = max(part * (piece.high - piece.low), 4.0 * np.finfo(float).eps)
        low, high = max(place - reach, piece.low), min(place + reach, piece.high)
        if self._missed(low, row)[1] * self._missed(high, row)[1] < 0.0:
            place = crossing(lambda value: self._missed(value, row)[1], low, high)
        self.row(place)
        return place

    def _found(self, count: str, *, proven: bool) -> Found:
        path = self.program.axes[0].path
        details: dict[str, float] = {"pieces": self.budget.spent, "settled": proven and self._settled()}
        claim = f"decided over the whole range of {path}: every limit and the goal were followed over it in {count}"
        if not proven:
            claim = f"the limits and the goal were followed over the range of {path}, but {count}"
        if self.clear.max() > _CLEAR:
            claim += f", measured to {100.0 * self.clear.max():.2g} % of each, with which to spare limits are kept"
        if self.best is None:
            return Found("infeasible" if proven else "unproven", None, claim, OneRange.name, details=details)
        end, near = self._open_end(), 1e-6
        if end and not self._within(near) and not self._within(near := _SLOW):
            claim = f"every limit holds and the goal keeps improving as {path} {end}"
            return Found("unbounded", self.x(self.best[1]), claim, OneRange.name)
        if end:
            claim = f"the goal nears its best value as {path} {end}, less than {near:.0e} of it away here; {claim}"
        return self._designed(claim, details, proven=proven)

    def _designed(self, claim: str, details: dict[str, float], *, proven: bool) -> Found:
        assert self.best is not None
        x = self.x(self.best[1])
        value = self.judge.goal(x).value
        details["goal"] = value * (self.program.aim.sense if self.program.aim is not None else 1.0)
        if value == -np.inf:
            return Found("unbounded", x, "the goal is infinite: an undamped resonance lies within reach", OneRange.name)
        if value == np.inf:
            claim = f"the goal is infinite at every design that meets the limits; {claim}"
        bound = value if proven else float("nan")
        return Found("optimal" if proven else "feasible", x, claim, OneRange.name, bound, details)

    def _open_end(self) -> str:
        """Which end that only stands for one the best design lies at, in words; "" for none."""
        assert self.best is not None
        axis = self.program.axes[0]
        if self.program.aim is None:
            return ""
        if axis.open_high and self.best[1] >= 1.0 - 0.01 / self.span:
            return "grows without end"
        return "goes to zero" if axis.open_low and self.best[1] <= 0.01 / self.span else ""

    def _within(self, near: float) -> bool:
        """Take the design farthest inside from an open end that is hardly worse; whether the goal settles there."""
        assert self.best is not None
        way = -1.0 if self.best[1] > 0.5 else 1.0
        best, inside = self.judge.goal(self.x(self.best[1])).value, self.best[1]
        for step in range(1, int(4.0 * self.span)):
            there = self.best[1] + way * 0.25 * step / self.span
            x = self.x(there)
            if not self.judge.feasible(x) or not self.judge.goal(x).value <= best + near * abs(best):
                break
            inside = there
        if abs(inside - self.best[1]) * self.span < 2.0:
            return False
        self.best = self.best[0], inside
        return True

    def _settled(self) -> bool:
        """Whether a limit is broken towards an end that stands for infinity, and hardly changes there any more."""
        if not self.program.axes[0].open_high:
            return True
        far = np.array([self.row(1.0 - part / self.span)[:-1] for part in (0.0, 2.0, 4.0, 6.0)])
        return bool(((far.min(axis=0) > _FLOOR) & (np.ptp(far, axis=0) <= 0.1 * far[0])).any())


def _violation(limit: Limit, missed: float, value: float) -> float:
    """By how much a limit is broken, as a share of value and bound: -1 to 1, without jumps, positive where broken."""
    if limit.side == "outside":
        return float(np.clip(missed, -1.0, 1.0))
    if not np.isfinite(value):
        return 1.0 if np.isnan(value) or ((value > 0.0) == (limit.side == "at_most")) else -1.0
    sign = 1.0 if limit.side == "at_most" else -1.0
    return sign * (value - limit.bound) / (abs(value) + (abs(limit.bound) or 1.0))


_TO_CHEBYSHEV = np.asarray(np.linalg.inv(np.polynomial.chebyshev.chebvander(2.0 * _NODES - 1.0, _DEGREE)))
"""Values at the nodes to coefficients of Chebyshev's polynomials."""


def _without_specks(parts: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Without what is left or right of a leap by rounding: parts of no width close to one that has some."""
    wide = [part for part in parts if part[1] - part[0] > _SPECK]
    beside = [min((max(low - part[1], part[0] - high) for low, high in wide), default=np.inf) for part in parts]
    return [one for one, far in zip(parts, beside, strict=True) if one in wide or far > _SPECK]
