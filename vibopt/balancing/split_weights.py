"""Weights cut in two for neighbouring holes, under caps: a cone program over what every hole takes.

What two neighbours do together is a sum of non-negative parts at the holes, and the lightest such sum uses two
neighbours.  So a cap on both parts is a cap on the sum over all holes, and the program is convex.  A cap on each hole
(a drill goes no deeper) may spread the best over more holes; then pairs of neighbours are branched over.
"""

from __future__ import annotations

import numpy as np

from vibopt.arrays import ComplexArray
from vibopt.balancing.fan import Fan
from vibopt.balancing.lengths import Box, Lengths, least
from vibopt.balancing.question import Question, Solved, felt
from vibopt.errors import counted
from vibopt.frontier import Frontier
from vibopt.records import dataclass
from vibopt.work import Budget

GAP = 1e-7
PROGRAMS = 500
PROGRAM = 10.0  # of nominal work [ms]
_TINY = 1e-300


def takes(question: Question) -> bool:
    """Whether caps on split weights are what makes the question, and all else in it is convex."""
    if not any(_bound(question, plane) for plane in range(len(question.fans))):
        return False
    others = [plane for plane in range(question.n_planes) if question.fans[plane] is None]
    arcs = any(question.sectors[plane] for plane in others) if question.sectors else False
    return not (question.pairs or question.is_discrete or arcs)


def _bound(question: Question, plane: int) -> bool:
    fan = question.fans[plane]
    limited = (np.isfinite(question.caps[plane]) and question.caps[plane] > 0.0) or np.isfinite(question.total_cap)
    return fan is not None and bool(np.isfinite(fan.each) or limited)


def solve_split(question: Question, budget: Budget | None = None) -> Solved:
    """The best correction, its gap worked out from multipliers; branching only where holes have caps of their own."""
    frontier = Frontier(budget or Budget(PROGRAMS, "programs"))
    first = _relaxed(question, question.fans)
    if first is None:
        return Solved(None, "unproven", "the cone program over the holes found no weights")
    best, value, bar, solved = None, np.inf, np.inf, 1
    frontier.push(first.bound, (first, question.fans))
    while frontier and not frontier.over and frontier.bound < bar:
        found, fans = frontier.pop()[1]
        worst = _overfull(found.u, fans)
        if worst is None:
            if found.value < value:
                best, value, bar = found.u, found.value, found.value - GAP * max(abs(found.value), _TINY)
            continue
        fan = fans[worst]
        assert fan is not None
        for part in fan.split_at(complex(found.u[worst])) if len(fan.gaps) > 1 else ():
            narrowed = tuple(part if plane == worst else one for plane, one in enumerate(fans))
            inner = _relaxed(question, narrowed)
            solved += 1
            frontier.budget.spend()
            if inner is not None:
                frontier.push(inner.bound, (inner, narrowed))
    if best is None:
        return Solved(None, "unproven", f"no split weights were found in {counted(solved, 'programs')}")
    bound = frontier.bound if frontier else first.bound if solved == 1 else value
    gap = max(value - bound, 0.0) / max(abs(value), _TINY)
    sure = bool(gap <= 1e-4)
    claim = f"cone program over the holes of split weights, {solved} solved, gap {gap:.1e} by our own dual bound"
    return Solved(best, "optimal" if sure else "feasible", claim, value, bound, gap, details={"programs": solved})


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
    u: ComplexArray
    value: float
    bound: float


def _relaxed(question: Question, fans: tuple[Fan | None, ...]) -> _Found | None:
    """Best correction with any number of holes of each plane, and a bound that no correction can be better than."""
    spread, box = _choices(question, fans)
    H, masses = question.H @ spread, _masses(question, spread, len(box.shares))
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
    for plane in [k for k, fan in enumerate(fans) if fan is not None and 0.0 < question.caps[k] < np.inf]:
        parts = np.abs(spread[plane : plane + 1]) + 0j
        limits.append(Lengths(np.zeros(1, dtype=complex), parts, limit=float(question.caps[plane])))
    answer = least(goal, limits, box)
    if answer.x is None:
        return None
    u: ComplexArray = spread @ answer.x
    value = question.value(u)
    return _Found(u, value, min(answer.bound, value)) if _kept(question, u) else None


def _choices(question: Question, fans: tuple[Fan | None, ...]) -> tuple[ComplexArray, Box]:
    """u = spread @ x: parts at the holes of the planes that have some, then both components of the free ones."""
    used = [k for k in range(question.n_planes) if question.caps[k] > 0.0]
    holes = [(k, hole, fan.each) for k in used for fan in [fans[k]] if fan is not None for hole in fan.holes]
    free = [k for k in used if fans[k] is None]
    spread = np.zeros((question.n_planes, len(holes) + 2 * len(free)), dtype=complex)
    for column, (plane, hole, _) in enumerate(holes):
        spread[plane, column] = hole
    for place, plane in enumerate(free):
        spread[plane, len(holes) + 2 * place : len(holes) + 2 * place + 2] = 1.0, 1j
    shares = tuple((0.0, float(min(question.caps[plane], each))) for plane, _, each in holes)
    return spread, Box(shares, tuple(float(question.caps[k]) for k in free), felt(question.y0, question.H) or 1.0)


def _masses(question: Question, spread: ComplexArray, n_parts: int) -> ComplexArray:
    """Rows whose lengths are the masses of the parts and of the free planes (n_masses, n_x) [kg]."""
    pairs = (spread.shape[1] - n_parts) // 2
    rows = np.zeros((n_parts + pairs, spread.shape[1]), dtype=complex)
    density = np.abs(spread).T @ question.densities
    rows[np.arange(n_parts), np.arange(n_parts)] = density[:n_parts]
    for k in range(pairs):
        both = slice(n_parts + 2 * k, n_parts + 2 * k + 2)
        rows[n_parts + k, both] = density[both] * (1.0, 1j)
    return rows


def _kept(question: Question, u: ComplexArray) -> bool:
    """Whether all limits hold, to within what rounding of the solver is."""
    left, masses, room = np.abs(question.residual(u)), question.masses(u), 1.0 + 1e-7
    caps = np.where(np.isfinite(question.caps), question.caps * question.densities, np.inf)
    return bool(
        (left <= question.limits * room).all()
        and (masses <= caps * room + 1e-12 * masses.max(initial=0.0)).all()
        and masses.sum() <= question.total_cap * room
    )
