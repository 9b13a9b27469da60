"""Forbidden sectors: what is left is not convex, so the allowed arcs are branched over, half a turn at most each."""

from __future__ import annotations

import heapq
from dataclasses import replace
from itertools import count

import numpy as np

from vibopt.balancing.convex import KEPT, Convex, pull_in, solve_convex
from vibopt.balancing.question import Sectors
from vibopt.balancing.scaled import Scaled, into_wedge
from vibopt.forms import ComplexArray
from vibopt.records import dataclass

Wedge = tuple[float, float]
CLOSED = 1e-9
MOST_PROGRAMS = 3000


@dataclass(frozen=True)
class Branched:
    """The best answer over all arcs with the bound over all of them."""

    best: Convex
    bound: float
    programs: int
    factor: float


def allowed_arcs(sectors: Sectors) -> tuple[Wedge, ...]:
    """What the forbidden sectors leave, as (middle, half width <= pi/2); empty where they leave nothing."""
    turn = 2.0 * np.pi
    if not sectors:
        return ()
    spans = sorted((low % turn, low % turn + ((high - low) % turn or turn)) for low, high in sectors)
    start = spans[0][0]
    reach, gaps = start, []
    for low, high in spans:
        if low > reach + 1e-12:
            gaps.append((reach, low))
        reach = max(reach, high)
    around = max(0.0, reach - start - turn)  # what the last sector covers of the first gaps, once around
    if reach < start + turn - 1e-12:
        gaps.append((reach, start + turn))
    wrapped = [(max(low, start + around), high) for low, high in gaps if high > start + around]
    return tuple(piece for low, high in wrapped for piece in _halves(low, high))


def _halves(low: float, high: float) -> list[Wedge]:
    """The arc low..high in equal pieces of half a turn at most."""
    pieces = int(np.ceil((high - low) / np.pi - 1e-12)) or 1
    step = (high - low) / pieces
    return [(low + (k + 0.5) * step, 0.5 * step) for k in range(pieces)]


def covers_all(sectors: Sectors) -> bool:
    """Whether no direction is left."""
    return bool(sectors) and not allowed_arcs(sectors)


def into_arcs(value: complex, sectors: Sectors) -> complex:
    """Nearest point outside the forbidden sectors to `value`; the value itself where none is left."""
    return _nearest(complex(value), allowed_arcs(sectors))


def _nearest(value: complex, wedges: tuple[Wedge, ...]) -> complex:
    points = np.array([into_wedge(value, *wedge) for wedge in wedges])
    return complex(points[np.argmin(np.abs(points - value))]) if len(points) else value


def solve_over_arcs(scene: Scaled, sectors: tuple[Sectors, ...]) -> Branched:
    """Best-first over the choice of an arc per plane; each program's own dual bound closes its branch."""
    arcs = [allowed_arcs(entry) for entry in sectors] or [()] * scene.n_planes
    order = count()
    root = solve_convex(scene)
    heap = [(root.bound, next(order), scene, root)]
    best, closed, programs = Convex(None, np.inf, np.inf, None), np.inf, 1
    factors: list[float] = []
    while heap and programs < MOST_PROGRAMS:
        bound, _, node, answer = heapq.heappop(heap)
        if best.x is not None and bound >= best.value - CLOSED * max(abs(best.value), 1e-6):
            closed = min(closed, bound)
            break
        if answer.x is None:
            factors.append(answer.factor)
            closed = min(closed, bound if np.isnan(answer.factor) else np.inf)
            continue
        outside = [_outside(answer.x[p], arcs[p]) for p in range(scene.n_planes)]
        if max(outside) <= 1e-12 * float(np.abs(answer.x).max()):
            best = answer if answer.value < best.value else best
            closed = min(closed, bound)
            continue
        best = _snapped(scene, answer, arcs, best)
        plane = int(np.argmax(outside))
        for wedge in arcs[plane]:
            child = replace(node, wedges=(*node.wedges[:plane], wedge, *node.wedges[plane + 1 :]))
            solved = solve_convex(child)
            programs += 1
            heapq.heappush(heap, (max(solved.bound, bound), next(order), child, solved))
    if heap:
        closed = min(closed, heap[0][0])
    sure = not heap and len(factors) > 0 and not np.isnan(factors).any()
    return Branched(best, min(closed, best.value), programs, min(factors) if sure else float("nan"))


def _outside(value: complex, arcs: tuple[Wedge, ...]) -> float:
    """Distance of a plane's correction from its allowed arcs, zero where it may point anywhere."""
    return min((abs(value - into_wedge(value, *wedge)) for wedge in arcs), default=0.0)


def _snapped(scene: Scaled, answer: Convex, arcs: list[tuple[Wedge, ...]], best: Convex) -> Convex:
    """The nearest allowed point to a relaxed answer, if it keeps the limits and beats the best so far."""
    assert answer.x is not None
    near: ComplexArray = answer.x.copy()
    for plane, wedges in enumerate(arcs):
        near[plane] = _nearest(complex(near[plane]), wedges)
    near = pull_in(replace(scene, wedges=(None,) * scene.n_planes), near)
    if np.abs(scene.F @ near + scene.f).max(initial=0.0) > 1.0 + KEPT:
        return best
    value = scene.value(near)
    return replace(answer, x=near, value=value) if value < best.value else best
