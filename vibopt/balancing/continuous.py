"""Corrections of any size and angle: the planes that are free, their arcs and holes, closed form, convex programs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray, IntArray, inverted
from vibopt.balancing.convex_rounds import KEPT, Convex, pull_in, solve_convex
from vibopt.balancing.fan import Fan
from vibopt.balancing.planes import open_arcs
from vibopt.balancing.question import (
    Options,
    Prices,
    Question,
    Sectors,
    Solved,
    breaks,
    greatest,
    inside_arc,
    relative_gap,
    tied,
    together,
    wider_words,
    worst_part,
)
from vibopt.balancing.scaled import Scaled, into_wedge, scaled
from vibopt.errors import counted
from vibopt.frontier import Frontier
from vibopt.records import dataclass, replace
from vibopt.work import Budget

Wedge = tuple[float, float]
CLOSED = 1e-9
MOST_PROGRAMS = 3000
PROGRAM = 10.0  # of nominal work [ms]


def allowed_arcs(sectors: Sectors) -> tuple[Wedge, ...]:
    """What the forbidden sectors leave, as (middle, half width <= pi/2); empty where they leave nothing."""
    found = []
    for low, high in open_arcs(sectors) if sectors else ():
        pieces = int(np.ceil((high - low) / np.pi - 1e-12)) or 1  # equal ones of half a turn at most
        step = (high - low) / pieces
        found += [(low + (k + 0.5) * step, 0.5 * step) for k in range(pieces)]
    return tuple(found)


def into_set(value: complex, wedges: Sequence[Wedge], fan: Fan | None) -> complex:
    """The allowed point next to `value` in one of the arcs, or as much of it as its holes bear; itself without any."""
    if fan is not None:
        return value * (fan.each / max(fan.greatest(value), fan.each) if np.isfinite(fan.each) else 1.0)
    points = np.array([into_wedge(value, *wedge) for wedge in wedges])
    return complex(points[np.argmin(np.abs(points - value))]) if len(points) else value


def solve_pieces(scene: Scaled, sectors: tuple[Sectors, ...], budget: Budget | None = None) -> Convex:
    """Least goal where what a plane may be is several convex pieces: arcs between sectors, gaps between holes.

    Best-first over the choice of a piece per plane; each program's own dual bound closes its branch.  `bound` and
    `factor` of the answer hold over all pieces, `rounds` counts the programs.
    """
    if not any(sectors) and not any(fan.bulges for fan in scene.fans.values()):
        return solve_convex(scene)
    arcs = [allowed_arcs(entry) for entry in sectors] or [()] * scene.n_planes
    frontier, root = Frontier(budget or Budget(MOST_PROGRAMS - 1, "programs")), solve_convex(scene)
    frontier.push(root.bound, (scene, root))
    best, closed, programs = Convex(None, np.inf, np.inf, None), np.inf, 1
    factors: list[float] = []
    while frontier and not frontier.over:
        bound, (node, answer) = frontier.pop()
        if best.x is not None and bound >= best.value - CLOSED * max(abs(best.value), 1e-6):
            closed = min(closed, bound)
            break
        if answer.x is None:
            factors.append(answer.factor)
            closed = min(closed, bound if np.isnan(answer.factor) else np.inf)
            continue
        outside = [_outside(complex(answer.x[p]), arcs[p], node.fans.get(p)) for p in range(scene.n_planes)]
        if max(outside) <= 1e-12 * float(np.abs(answer.x).max()):
            best = answer if answer.value < best.value else best
            closed = min(closed, bound)
            continue
        best = _snapped(scene, answer, arcs, best)
        plane = int(np.argmax(outside))
        for child in _parts(node, plane, arcs[plane], complex(answer.x[plane])):
            solved = solve_convex(child)
            programs += 1
            frontier.budget.spend()
            frontier.push(max(solved.bound, bound), (child, solved))
    closed = min(closed, frontier.bound)
    sure = not frontier and len(factors) > 0 and not np.isnan(factors).any()
    factor = min(factors) if sure else float("nan")
    return replace(best, bound=min(closed, best.value), factor=factor, rounds=programs)


def _parts(node: Scaled, plane: int, arcs: Sequence[Wedge], value: complex) -> Iterator[Scaled]:
    """The same with one plane held to each of its arcs, or to fewer of its holes."""
    fan = node.fans.get(plane)
    fewer = () if fan is None else fan.split_at(value)
    held = (
        [(wedge, node.fans) for wedge in arcs] if fan is None else [(f.wedge, {**node.fans, plane: f}) for f in fewer]
    )
    for wedge, fans in held:
        yield replace(node, wedges=(*node.wedges[:plane], wedge, *node.wedges[plane + 1 :]), fans=fans)


def _outside(value: complex, arcs: Sequence[Wedge], fan: Fan | None) -> float:
    """Distance of a plane's correction from what is allowed, zero where it is."""
    if fan is not None:
        return 0.0 if fan.bears(value, KEPT) else fan.excess(value) or abs(value)
    return min((abs(value - into_wedge(value, *wedge)) for wedge in arcs), default=0.0)


def _snapped(scene: Scaled, answer: Convex, arcs: list[tuple[Wedge, ...]], best: Convex) -> Convex:
    """The nearest allowed point to a relaxed answer, if it keeps the limits and beats the best so far."""
    assert answer.x is not None
    near: ComplexArray = answer.x.copy()
    for plane, wedges in enumerate(arcs):
        near[plane] = into_set(complex(near[plane]), wedges, scene.fans.get(plane))
    near = pull_in(replace(scene, wedges=(None,) * scene.n_planes), near)
    if scene.held(near).max(initial=0.0) > 1.0 + KEPT:
        return best
    value = scene.value(near)
    return replace(answer, x=near, value=value) if value < best.value else best


Places = IntArray
SAME = 1e-9  # two unbalances this close (as a share of the greatest) are one


@dataclass(frozen=True)
class Free:
    """A question in independent planes: u of the asker = spread @ x.

    spread
        Shape (n_planes, n_free), complex; one entry per row at most.
    question
        The same question in x, without pairs; each list holds only what caps, sectors and the stock allow.
    places
        Per free plane the rows of its list that are left; None without a list.
    """

    spread: ComplexArray
    question: Question
    places: tuple[Places | None, ...] = ()


def free_planes(question: Question) -> Free:
    """Merge pairs, drop planes with a cap of zero and planes that no reading sees."""
    plain = not question.pairs and not any(question.sectors) and not question.is_discrete
    if plain and (question.caps > 0).all() and question.H.any(axis=0).all():
        return Free(np.eye(question.n_planes, dtype=complex), question)
    whole = tied(question.n_planes, question.pairs)
    densities = np.abs(whole).T @ question.densities
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = np.where(whole != 0, question.caps[:, None] / np.abs(whole), np.inf).min(axis=0)
    for column in range(whole.shape[1]):
        sectors = _sectors(question, whole[:, column])
        if sectors and not allowed_arcs(sectors):
            reach[column] = 0.0
    H = question.H @ whole
    kept = [c for c in range(whole.shape[1]) if reach[c] > 0 and (np.any(H[:, c] != 0) or _must(question, whole, c))]
    spread = whole[:, kept]
    lists = [_list(question, spread[:, c]) for c in range(len(kept))]
    stock = question.stock if any(options is not None for options, _ in lists) else np.empty(0)
    inner = replace(
        question,
        H=H[:, kept],
        caps=reach[kept],
        sectors=tuple(_sectors(question, spread[:, c]) for c in range(len(kept))),
        options=tuple(options for options, _ in lists),
        stock=stock,
        mass_per_unbalance=densities[kept],
        fans=tuple(question.fans[int(np.argmax(one != 0))] for one in spread.T) if question.fans else (),
        ends=tuple(question.ends[int(np.argmax(one != 0))] for one in spread.T) if question.ends else (),
        pairs=(),
    )
    return Free(spread, inner, tuple(places for _, places in lists))


def _must(question: Question, spread: ComplexArray, column: int) -> bool:
    """Whether an unseen plane has a list without zero: something has to be fitted there."""
    lists = [question.options[p] for p in np.flatnonzero(spread[:, column]) if question.options]
    return any(entry is not None and np.abs(entry.u).min() > 0 for entry in lists)


def _sectors(question: Question, column: ComplexArray) -> Sectors:
    """Forbidden arcs of every plane of a set, turned into the angle of its first."""
    if not question.sectors:
        return ()
    turned = [(p, float(np.angle(column[p]))) for p in np.flatnonzero(column)]
    return tuple((low - by, high - by) for p, by in turned for low, high in question.sectors[p])


def _list(question: Question, column: ComplexArray) -> tuple[Options | None, Places | None]:
    """The options that a plane with a list has within its cap, its sectors and the stock, and their places."""
    plane = int(np.argmax(column != 0))
    option = question.options[plane] if question.options else None
    if option is None:
        return None, None
    fits = _allowed(question, plane, option.u)
    # a cap is one on masses: weights that act against each other weigh more than what they do together
    fits &= option.masses <= question.caps[plane] * question.densities[plane] * (1.0 + SAME)
    uses = option.uses if len(question.stock) else np.zeros((len(option.u), 0))
    fits &= np.all(uses <= question.stock, axis=1)
    return Options(option.u, option.masses, uses).take(fits), np.flatnonzero(fits)


def _allowed(question: Question, plane: int, values: ComplexArray) -> BoolArray:
    """Which unbalances the cap and the forbidden sectors of a plane allow."""
    fine = np.abs(values) <= question.caps[plane] * (1.0 + SAME)
    slack = SAME * float(np.abs(values).max(initial=0.0))
    for low, high in question.sectors[plane] if question.sectors else ():
        fine &= ~inside_arc(values, low, high, slack)
    return np.asarray(fine)


RANK = 1e-13
_SURE = 1e6
NOTHING = 1e-13  # residual that counts as nothing, as a share of the goal as found


def least_squares(triangle: ComplexArray) -> tuple[ComplexArray, int]:
    """The x of least norm |A x + b|, and the rank.

    Parameters
    ----------
    triangle
        R of (A, b) = Q R, shape (n_rows, n_planes + 1); columns are divided by their norms before the singular values
        are compared.

    Returns
    -------
    tuple
        x (n_planes,) and the rank; below full rank x is the solution of least Euclidean norm.
    """
    A = triangle[:, :-1]
    norms = np.sqrt((A.real**2 + A.imag**2).sum(axis=0))
    norms[norms == 0] = 1.0
    level = A / norms
    solution, _, rank, _ = np.linalg.lstsq(level, -triangle[:, -1], rcond=RANK)
    x: ComplexArray = solution / norms
    if rank < A.shape[1]:
        _, _, right = np.linalg.svd(level, full_matrices=True)
        idle = right[rank:].conj().T / norms[:, None]
        x = x - idle @ np.linalg.lstsq(idle, x, rcond=None)[0]
    return x, int(rank)


def closed_form(question: Question) -> Solved | None:
    """The answer where no program is needed; None otherwise.

    That is so where the least-squares solution keeps every limit and is asked for (or leaves nothing, which no goal
    can better), and where least mass is asked for and nothing has to be fitted.
    """
    if question.goal == "correction":
        return _nothing_needed(question)
    if question.pairs or not (question.caps > 0).all():
        return None
    if question.goal != "rms" and question.n_readings > question.n_planes and np.isfinite(question.caps).any():
        return None  # more readings than planes and caps: something will be left
    if question.goal == "rms" and _held_by_caps(question):
        return None
    u, rank = least_squares(question.triangle)
    held = question.sectors or question.ends or np.isfinite(question.total_cap)
    bare = not held and np.all(np.isinf(question.limits))
    if not np.all(np.abs(u) <= question.caps) or not (bare or not breaks(replace(question, options=()), u, 0.0)):
        return None
    value = question.value(u)
    if question.goal != "rms" and value > NOTHING * float(question.measure(np.abs(question.y0))):
        return None
    n = question.n_planes
    claim = "least squares in closed form"
    if rank < n:
        told = f"only {rank} of {counted(n, 'planes')} can be told apart by what they do"
        claim += f"; {told}, so of all such corrections this is the smallest"
    return Solved(u, "optimal", claim, value, value, 0.0, details={"rank": rank})


def _held_by_caps(question: Question) -> bool:
    """Whether least squares ask for more than the caps allow: surely, or where they are well determined."""
    slope, most = question.H.conj().T @ (question.importance**2 * question.y0), 1.0 + 1.0 / _SURE
    with suppress(np.linalg.LinAlgError), np.errstate(invalid="ignore"):  # a plane without a cap may do nothing
        if (np.abs(slope) > most * (np.abs(question.square) @ question.caps)).any():
            return True  # no weights within the caps end the slope
        inverse = inverted(question.square)
        u = inverse @ slope
        sure = float(np.abs(inverse).max() * np.abs(question.square).max()) < _SURE
        return sure and bool((np.abs(u) > question.caps * most).any())
    return False


def _nothing_needed(question: Question) -> Solved | None:
    """No correction, where the readings keep their limits as found."""
    none = np.zeros(question.n_planes, dtype=complex)
    if breaks(replace(question, options=()), none, 0.0):
        return None
    return Solved(none, "optimal", "the limits are kept as found: nothing has to be fitted", 0.0, 0.0, 0.0)


PROVEN = 1e-7
_REMAINDER = 1e-3  # of what the solver leaves of a goal that is zero: more than that is left where it cannot be
_NO_WEIGHT = 1e-9  # of the greatest


def solve_continuous(question: Question, budget: Budget | None = None) -> Solved:
    """The best correction of any size and angle, with its proof.

    Parameters
    ----------
    question
        Lists of options are not looked at here (see `vibopt.balancing.discrete`).
    budget
        Programs over pieces of what is allowed, 3000 where none is given.

    Returns
    -------
    Solved
        "optimal" with a gap below 1e-7 by our own dual bound; "infeasible" only with a bound above the limits, then
        `least_factor` says how much wider those on readings would have to be; "feasible" or "unproven" otherwise.
    """
    plain = closed_form(question)
    if plain is not None:
        return plain
    free = free_planes(question)
    scene = scaled(free.question, merge=not free.question.has_caps_alone)
    return _solved(question, free, scene, solve_pieces(scene, free.question.sectors, budget))


def _solved(question: Question, free: Free, scene: Scaled, answer: Convex) -> Solved:
    """The answer in the asker's planes and units."""
    details = {"programs": answer.rounds}
    if answer.x is None:
        if answer.factor > 1.0:
            factor = max(answer.factor, _wider(question) if any(free.question.sectors) or scene.fans else 0.0)
            return Solved(None, "infeasible", wider_words(question, factor), least_factor=factor, details=details)
        return Solved(
            None, "unproven", "no correction was found, and that there is none is not proven", details=details
        )
    answer = _without_remainder(scene, answer)
    assert answer.x is not None
    u = question.base + free.spread @ (answer.x * scene.column)
    value = question.value(u)
    low = max(answer.bound, 0.0) * scene.goal_size  # no goal is less than nothing
    gap = relative_gap(value, low, scene.goal_size)
    status = "optimal" if gap <= PROVEN else "feasible"
    claim = f"convex program, gap {gap:.1e} by our own dual bound"
    if any(free.question.sectors):
        many = counted(answer.rounds, "convex programs")
        claim = f"all arcs outside the forbidden sectors compared in {many}, gap {gap:.1e}"
    elif scene.fans:
        claim = (
            f"cone program over the holes of split weights, {answer.rounds} solved, gap {gap:.1e} by our own dual bound"
        )
    return Solved(u, status, claim, value, low, gap, _prices(question, free, scene, answer), details=details)


def _without_remainder(scene: Scaled, answer: Convex) -> Convex:
    """The answer moved to where nothing is left, if its goal is zero up to the solver's gap and may well be zero.

    Planes that the solver leaves a rounding in get nothing, those with an arc or holes keep their angle.
    """
    x = answer.x
    if x is None or scene.goal == "correction" or not 0.0 < answer.value <= PROVEN:
        return answer
    nothing = np.abs(x) <= _NO_WEIGHT * float(np.abs(x).max(initial=0.0))
    ways = np.diag(np.where(nothing, 0.0, 1.0)).astype(complex)
    held = np.array([wedge is not None or plane in scene.fans for plane, wedge in enumerate(scene.wedges)])
    radial = ways * np.exp(1j * np.angle(x))
    across = np.where(held, 0.0, 1j) * radial
    lines = scene.G @ np.hstack([radial, across])
    start = np.where(nothing, 0.0, x)
    left = scene.G @ start + scene.g
    step = np.linalg.lstsq(np.vstack([lines.real, lines.imag]), -np.concatenate([left.real, left.imag]), rcond=1e-12)[0]
    moved = pull_in(scene, start + np.hstack([radial, across]) @ step)
    value = scene.value(moved)
    if value >= _REMAINDER * answer.value or scene.held(moved).max(initial=0.0) > 1.0 + KEPT:
        return answer
    return replace(answer, x=moved, value=value, bound=min(answer.bound, value))


def _wider(question: Question) -> float:
    """By how much wider limits on readings must be at least, arcs and holes looked at: the least worst part of them."""
    if not question.limits.all():
        return 0.0
    bound = solve_continuous(worst_part(question, question.limits)).bound
    return bound if np.isfinite(bound) else 0.0


def _prices(question: Question, free: Free, scene: Scaled, answer: Convex) -> Prices | None:
    """Prices of the asker's limits from the multipliers of the scaled ones."""
    if answer.dual is None:
        return None
    readings = np.zeros(question.n_readings)
    if len(scene.limited):
        limits = np.maximum(question.limits[scene.limited], 1e-300)
        pulls = np.abs(answer.dual.v)  # of amplitudes that are added up each has its part
        parts = greatest(pulls, scene.sums) / np.maximum(together(pulls, scene.sums), 1e-300)
        readings[scene.limited] = pulls * parts * scene.goal_size / limits
    own = answer.dual.caps * scene.goal_size / scene.column
    total = answer.dual.total * scene.goal_size / scene.mass_size
    return Prices(readings, _cap_prices(question, free, own), float(total))


def _cap_prices(question: Question, free: Free, own: FloatArray) -> FloatArray:
    """The price of a merged plane belongs to the member whose cap it meets first."""
    if free.question is question:
        return own
    prices = np.zeros(question.n_planes)
    sizes = np.abs(free.spread)
    for column in range(sizes.shape[1]):
        members = np.flatnonzero(sizes[:, column])
        first = members[np.argmin(question.caps[members] / sizes[members, column])]
        prices[first] = own[column] / sizes[first, column]
    return prices
