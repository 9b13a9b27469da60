"""Weights cut in two for neighbouring holes, under caps: a cone program over what every hole takes.

What two neighbours do together is a sum of non-negative parts at the holes, and the lightest such sum uses two
neighbours.  So a cap on both parts is a cap on the sum over all holes, and the program is convex.  A cap on each hole
(a drill goes no deeper) may spread the best over more holes; then pairs of neighbours are branched over.

Beside planes with a list of weights, or with forbidden sectors, the question whose weights need not be cut is asked
first: what it finds is the answer where the holes bear it, and a bound where not.  Then every filling of the lists, and
every arc between the sectors, is a set of the same search.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise, product
from math import isinf, pi, prod

import numpy as np

from vibopt.arrays import ComplexArray
from vibopt.balancing.continuous import Free, allowed_arcs, free_planes
from vibopt.balancing.fan import Fan
from vibopt.balancing.lengths import Box, Lengths, least
from vibopt.balancing.question import Question, Solved, breaks, felt, relative_gap
from vibopt.errors import counted
from vibopt.frontier import Frontier
from vibopt.records import dataclass
from vibopt.work import Budget

GAP = 1e-7
PROGRAMS = 500
PROGRAM = 10.0  # of nominal work [ms]
MOST = 400
"""Fillings of lists, times arcs between sectors, up to which each is a set of the search."""
_SURE = 1e-6
_HAIR = 1e-9
"""Part by which a limit may be passed as it is told."""
_WIDE = 0.35 * pi
"""Half width of an arc from which on it is cut: its edges would cancel each other."""

Edges = Mapping[int, tuple[complex, complex]]
"""Unit phasors along both edges of the arc in which a plane's correction lies, by plane."""

Piece = int | tuple[complex, complex] | None
"""What a plane is held to: a row of its list, the edges of an arc, or nothing."""


def takes(question: Question) -> bool:
    """Whether it matters that weights are cut in two: what their parts weigh is asked, or capped."""
    return any(_bound(question, plane) for plane in range(len(question.fans)))


def _bound(question: Question, plane: int) -> bool:
    fan, cap = question.fans[plane], question.caps[plane]
    limited = (np.isfinite(cap) and cap > 0.0) or np.isfinite(question.total_cap) or question.goal == "correction"
    return fan is not None and bool(np.isfinite(fan.each) or limited)


def solve_split(
    question: Question, budget: Budget | None = None, without: Callable[[Question], Solved] | None = None
) -> Solved:
    """The best correction, its gap worked out from multipliers.

    `without` answers the question with weights that need not be cut; it is asked where there are lists or sectors.
    """
    free = free_planes(question)
    uncut = without(question) if without is not None and _choices_beside(free.question) else None
    if uncut is not None and (uncut.status == "infeasible" or _borne(question, uncut)):
        return uncut
    search = _Search(free, uncut, budget or Budget(PROGRAMS + MOST, "programs"))
    search.run()
    return search.answer(question)


def _choices_beside(question: Question) -> bool:
    """Whether planes choose from lists or lie between sectors, beside those of cut weights."""
    listed = question.is_discrete
    return listed or any(arcs and fan is None for arcs, fan in zip(question.sectors, question.fans, strict=False))


def _borne(question: Question, uncut: Solved) -> bool:
    """Whether the holes bear an answer that is proven without them."""
    if uncut.u is None or uncut.status != "optimal":
        return False
    return not breaks(question.chosen_only(uncut.chosen), uncut.u, _HAIR)


@dataclass(frozen=True, eq=False)
class _Beside:
    """One filling of the lists, and an arc for each plane between sectors: the question that is left of it.

    places
        Row of each plane's list, -1 without a list.
    """

    question: Question
    u: ComplexArray
    mass: float
    places: tuple[int, ...]
    edges: Edges


class _Search:
    """Sets of holes, fillings and arcs, the most promising first."""

    def __init__(self, free: Free, uncut: Solved | None, budget: Budget) -> None:
        self.free, self.frontier, self.solved = free, Frontier(budget), 0
        question = free.question
        nothing = 0.0 if question.goal == "correction" else float(question.measure(np.abs(question.y0)))
        self.least_size = 1e-3 * nothing
        self.low = 0.0 if uncut is None or not np.isfinite(uncut.bound) else uncut.bound
        self.best: tuple[ComplexArray, _Beside] | None = None
        self.value, self.bound = np.inf, np.inf
        pieces: list[Sequence[Piece]] = [_pieces(question, plane) for plane in range(question.n_planes)]
        self.every = prod(len(one) for one in pieces) <= MOST
        if not self.every:
            self.bound = self.low
            pieces = [] if uncut is None or uncut.u is None else _as_in(free, uncut.u, pieces)
        for beside in _besides(question, pieces) if pieces else ():
            self._open(beside, question.fans, self.low)

    def _open(self, beside: _Beside, fans: tuple[Fan | None, ...], known: float) -> None:
        """One set more; `known` bounds all that is in it."""
        self.solved += 1
        self.frontier.budget.spend()
        found = _relaxed(beside, fans)
        shift = beside.mass if self.free.question.goal == "correction" else 0.0
        bound = max(found.bound + shift, known)
        if found.u is None and not isinf(found.bound):
            self.bound = min(self.bound, bound)
        elif found.u is not None:
            self.frontier.push(bound, (replace(found, value=found.value + shift), beside, fans))

    def run(self) -> None:
        """Look at the sets until none can be better by more than a part in ten million."""
        frontier, bar = self.frontier, np.inf
        while frontier and not frontier.over and frontier.bound < bar:
            bound, (found, beside, fans) = frontier.pop()
            worst = _overfull(found.u, fans)
            if worst is None:
                self.bound = min(self.bound, bound)
                if found.value < self.value:
                    self.best, self.value = (found.u, beside), found.value
                    bar = self.value - GAP * max(self.value, self.least_size)
                continue
            fan = fans[worst]
            assert fan is not None
            parts = fan.split_at(complex(found.u[worst])) if len(fan.gaps) > 1 else ()
            for part in parts:
                narrowed = tuple(part if plane == worst else one for plane, one in enumerate(fans))
                self._open(beside, narrowed, bound)
            if not parts:
                self.bound = min(self.bound, bound)

    def answer(self, question: Question) -> Solved:
        """The best, in the asker's planes."""
        bound, said = min(self.bound, self.frontier.bound), counted(self.solved, "programs")
        details = {"programs": self.solved}
        if self.best is None:
            if isinf(bound):
                claim = "no split weights keep the limits: certified by dual rays"
                return Solved(None, "infeasible", claim, details=details)
            claim = f"no split weights were found in {said}, and that there are none is not proven"
            return Solved(None, "unproven", claim, details=details)
        u = self.free.spread @ (self.best[0] + self.best[1].u)
        chosen = [-1] * question.n_planes
        for column, place in enumerate(self.best[1].places):
            plane, own = int(np.flatnonzero(self.free.spread[:, column])[0]), self.free.places[column:][:1]
            chosen[plane] = -1 if place < 0 or own[0] is None else int(own[0][place])
        only = question.chosen_only(chosen)
        value = only.value(u)
        bound = min(max(bound, self.low), value)
        gap = relative_gap(value, bound, 1e3 * self.least_size)
        how = f"cone program over the holes of split weights, {self.solved} solved"
        status = "optimal" if gap <= _SURE else "feasible"
        claim = f"{how}, gap {gap:.1e} by our own dual bound"
        return Solved(u, status, claim, value, bound, gap, chosen=tuple(chosen), details=details)


def _pieces(question: Question, plane: int) -> Sequence[Piece]:
    """What a plane may be held to: rows of its list, edges of its arcs; None alone where nothing is to be chosen."""
    options = question.options[plane] if question.options else None
    if options is not None:
        return range(len(options))
    if not question.sectors or not question.sectors[plane] or question.fans[plane] is not None:
        return (None,)
    pieces: list[tuple[complex, complex]] = []
    for middle, half in allowed_arcs(question.sectors[plane]):
        count = 1 if half < _WIDE else 2
        ends = np.exp(1j * (middle + half * np.linspace(-1.0, 1.0, count + 1)))
        pieces += [(complex(a), complex(b)) for a, b in pairwise(ends)]
    return pieces


def _as_in(free: Free, u: ComplexArray, pieces: Sequence[Sequence[Piece]]) -> list[Sequence[Piece]]:
    """Of each plane's pieces the one in which the correction u lies."""
    own = [complex(u[np.flatnonzero(column)[0]] / column[np.flatnonzero(column)[0]]) for column in free.spread.T]
    found: list[Sequence[Piece]] = []
    for plane, (x, several) in enumerate(zip(own, pieces, strict=True)):
        options = free.question.options[plane] if free.question.options else None
        if options is not None:
            found.append((int(np.argmin(np.abs(options - x))),))
            continue
        near = max(several, key=partial(_towards, x))
        found.append((near,))
    return found


def _towards(x: complex, piece: Piece) -> float:
    """How far x reaches along the middle of an arc."""
    return (x.conjugate() * sum(piece)).real if isinstance(piece, tuple) else 0.0


def _besides(question: Question, pieces: Sequence[Sequence[Piece]]) -> Iterator[_Beside]:
    """Every joint choice of pieces that the stock and the total mass allow."""
    for joint in product(*pieces):
        rows = {plane: one for plane, one in enumerate(joint) if isinstance(one, int)}
        u = np.zeros(question.n_planes, dtype=complex)
        mass, used, caps = 0.0, np.zeros(len(question.stock)), question.caps.copy()
        for plane, row in rows.items():
            options, weighs = question.options[plane], question.option_masses[plane]
            assert options is not None
            u[plane], caps[plane] = options[row], 0.0
            mass += abs(options[row]) * question.densities[plane] if weighs is None else float(weighs[row])
            uses = question.option_uses[plane] if len(question.stock) else None
            used += 0.0 if uses is None else uses[row]
        if (used > question.stock).any() or mass > question.total_cap * (1.0 + 1e-12):
            continue
        left = replace(
            question, y0=question.residual(u), caps=caps, total_cap=max(question.total_cap - mass, 0.0), options=(),
            option_masses=(), option_uses=(), stock=np.empty(0), sectors=(),
        )  # fmt: skip
        edges = {plane: one for plane, one in enumerate(joint) if isinstance(one, tuple)}
        yield _Beside(left, u, mass, tuple(rows.get(plane, -1) for plane in range(len(joint))), edges)


def _overfull(u: ComplexArray, fans: tuple[Fan | None, ...]) -> int | None:
    """The plane in which a hole of the pair around u takes most above its cap."""
    over = [
        0.0 if fan is None or abs(u[plane]) == 0.0 else fan.excess(complex(u[plane])) / abs(u[plane])
        for plane, fan in enumerate(fans)
    ]
    worst = int(np.argmax(over)) if over else 0
    return worst if over and over[worst] > 1e-7 else None


@dataclass(frozen=True)
class _Found:
    """The best with any number of holes, its goal, and a bound of them all: inf where there is none at all.

    Without u and with the bound -inf nothing is known.
    """

    u: ComplexArray | None
    value: float
    bound: float


def _relaxed(beside: _Beside, fans: tuple[Fan | None, ...]) -> _Found:
    """Best correction with any number of holes of each plane, and a bound that no correction can be better than."""
    question = beside.question
    spread, box = _columns(question, fans, beside.edges)
    H, masses = question.H @ spread, _masses(question, spread, box, beside.edges)
    weight, none = question.importance, np.zeros(len(masses), dtype=complex)
    if question.goal == "correction":
        goal = Lengths(none, masses)
    else:
        goal = Lengths(weight * question.y0, weight[:, None] * H, question.goal, huber=question.huber)
    rows = np.flatnonzero(np.isfinite(question.limits))
    ends = np.maximum(question.limits[rows], 1e-12 * float(np.abs(question.y0).max(initial=0.0)) or 1e-300)
    limits = [Lengths(question.y0[rows] / ends, H[rows] / ends[:, None], "worst", 1.0)] if len(rows) else []
    if np.isfinite(question.total_cap):
        limits.append(Lengths(none, masses, limit=question.total_cap))
    for plane in [k for k in range(len(question.caps)) if 0.0 < question.caps[k] < np.inf]:
        parts = spread[plane : plane + 1]
        if fans[plane] is not None or plane in beside.edges:
            parts = parts if plane in beside.edges else np.abs(parts) + 0j
            limits.append(Lengths(np.zeros(1, dtype=complex), parts, limit=float(question.caps[plane])))
    if not box.size:
        kept = all(one.value(np.zeros(0)) <= one.limit * (1.0 + 1e-9) for one in limits)
        value = goal.value(np.zeros(0)) if kept else np.inf
        return _Found(np.zeros(question.n_planes, dtype=complex) if kept else None, value, value)
    answer = least(goal, limits, box)
    if answer.x is None:
        return _Found(None, np.nan, np.inf if answer.status == "infeasible" else -np.inf)
    u: ComplexArray = spread @ answer.x
    value = question.value(u)
    return _Found(u, value, min(answer.bound, value)) if _kept(question, u) else _Found(None, np.nan, -np.inf)


def _columns(question: Question, fans: tuple[Fan | None, ...], edges: Edges) -> tuple[ComplexArray, Box]:
    """u = spread @ x: parts at the holes, parts along the edges of arcs, then both components of the free planes."""
    used = [k for k in range(question.n_planes) if question.caps[k] > 0.0]
    shares = [
        (k, hole, float(min(question.caps[k], fan.each)))
        for k in used for fan in [fans[k] if fans else None] if fan is not None for hole in fan.holes
    ]  # fmt: skip
    shares += [(k, edge, np.inf) for k in used if k in edges for edge in edges[k]]
    free = [k for k in used if k not in edges and (not fans or fans[k] is None)]
    spread = np.zeros((question.n_planes, len(shares) + 2 * len(free)), dtype=complex)
    for column, (plane, hole, _) in enumerate(shares):
        spread[plane, column] = hole
    for place, plane in enumerate(free):
        spread[plane, len(shares) + 2 * place : len(shares) + 2 * place + 2] = 1.0, 1j
    ends = tuple((0.0, most) for _, _, most in shares)
    return spread, Box(ends, tuple(float(question.caps[k]) for k in free), felt(question.y0, question.H) or 1.0)


def _masses(question: Question, spread: ComplexArray, box: Box, edges: Edges) -> ComplexArray:
    """Rows whose lengths are the masses of the parts, of the arcs and of the free planes (n_masses, n_x) [kg]."""
    owner = np.argmax(np.abs(spread), axis=0) if spread.size else np.zeros(0, dtype=int)
    rows, at = [], 0
    while at < spread.shape[1]:
        together = 2 if at >= len(box.shares) or int(owner[at]) in edges else 1
        row = np.zeros(spread.shape[1], dtype=complex)
        own = slice(at, at + together)
        plane = int(owner[at])
        row[own] = question.densities[plane] * (np.abs(spread[plane, own]) if together == 1 else spread[plane, own])
        rows.append(row)
        at += together
    return np.array(rows, dtype=complex).reshape(len(rows), spread.shape[1])


def _kept(question: Question, u: ComplexArray) -> bool:
    """Whether all limits hold, to within what rounding of the solver is."""
    left, masses, room = np.abs(question.residual(u)), question.masses(u), 1.0 + 1e-7
    caps = np.where(np.isfinite(question.caps), question.caps * question.densities, np.inf)
    return bool(
        (left <= question.limits * room).all()
        and (masses <= caps * room + 1e-12 * masses.max(initial=0.0)).all()
        and masses.sum() <= question.total_cap * room
    )
