"""Choices from lists of weights and holes, proven best by the tree; of those equally good the first is taken."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from math import sqrt

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.balancing.continuous import Free, allowed_arcs, free_planes, into_set
from vibopt.balancing.convex_rounds import KEPT, Convex, first_rows, solve_convex
from vibopt.balancing.option_tree import Cells, Tree
from vibopt.balancing.question import Options, Question, Solved, breaks, felt, relative_gap, wider_words
from vibopt.balancing.rounding import rounded
from vibopt.balancing.scaled import Scaled, scaled
from vibopt.errors import counted
from vibopt.work import Budget

SAME = 1e-9
"""Part of the goal, and of the mass, by which equal choices may differ."""
_PASSES = 20


def first_of_equals(question: Question, u: ComplexArray, chosen: list[int]) -> tuple[ComplexArray, list[int]]:
    """The choice that comes first among those as good that differ in one plane, or in two planes exchanged.

    Nothing is exchanged that breaks a limit or takes more mass.  Where weights are counted the choice stays as it is.
    """
    if len(question.stock) or question.pairs:
        return u, chosen
    for _ in range(_PASSES):
        before = list(chosen)
        u, chosen = _each_plane(question, u, chosen)
        u, chosen = _exchanged(question, u, chosen)
        if chosen == before:
            break
    return u, chosen


def _each_plane(question: Question, u: ComplexArray, chosen: list[int]) -> tuple[ComplexArray, list[int]]:
    value, left = _no_worse(question, question.chosen_only(chosen).value(u)), question.residual(u)
    for plane, options in enumerate(question.options):
        if options is None or not chosen[plane]:
            continue
        masses = options.masses
        lighter = masses[: chosen[plane]] <= masses[chosen[plane]] * (1.0 + SAME)
        earlier = np.where(lighter, options.u[: chosen[plane]], np.nan)
        if question.goal != "correction":
            moved = left[None, :] + (earlier - u[plane])[:, None] * question.H[None, :, plane]
            near = np.flatnonzero(question.measure(np.abs(moved)) <= value)
        else:
            near = np.flatnonzero(np.isfinite(earlier.real))
        for place in near.tolist():
            new = u.copy()
            new[plane] = options.u[place]
            picked = [*chosen[:plane], place, *chosen[plane + 1 :]]
            if _as_good(question, new, picked, value):
                return new, picked
    return u, chosen


def _exchanged(question: Question, u: ComplexArray, chosen: list[int]) -> tuple[ComplexArray, list[int]]:
    """Planes with the same list whose choices may be exchanged, the earlier plane with the earlier one."""
    value = _no_worse(question, question.chosen_only(chosen).value(u))
    listed = [plane for plane, option in enumerate(question.options) if option is not None]
    for first, second in combinations(listed, 2):
        if chosen[first] <= chosen[second] or not _same_lists(question, first, second):
            continue
        new, picked = u.copy(), list(chosen)
        new[[first, second]] = u[[second, first]]
        picked[first], picked[second] = chosen[second], chosen[first]
        if _as_good(question, new, picked, value):
            u, chosen = new, picked
    return u, chosen


def _no_worse(question: Question, value: float) -> float:
    """What an equal choice may come to: rounding of the value, and of the readings where nothing is left."""
    nothing = 0.0 if question.goal == "correction" else float(question.measure(np.abs(question.y0)))
    return value + SAME * (abs(value) + 1e-3 * nothing)


def _same_lists(question: Question, first: int, second: int) -> bool:
    options, other = question.options[first], question.options[second]
    if options is None or other is None or options.u.shape != other.u.shape:
        return False
    pairs = (options.u, other.u), (options.masses, other.masses)
    return all(np.allclose(mine, its, rtol=1e-12, atol=0.0) for mine, its in pairs)


def _as_good(question: Question, u: ComplexArray, chosen: list[int], value: float) -> bool:
    only = question.chosen_only(chosen)
    return only.value(u) <= value and not breaks(only, u, slack=SAME)


DONE = 1e-8
_TURNS, _EXCHANGES = 6, 40
"""Turns with which sums of amplitudes begin, and how often others are added."""
_NO_CHOICE = "stopped before a choice that keeps the limits was found"


def solve_discrete(question: Question, budget: Budget | None = None) -> Solved:
    """The best joint choice from the lists of all planes.

    Parameters
    ----------
    question
        At least one plane has a list; planes without one take any correction up to their caps, outside their
        forbidden sectors.
    budget
        Boxes to be looked at, by the size of the question where none is given; when it is spent the best choice
        found is given with its gap.

    Returns
    -------
    Solved
        "optimal": no other choice is better by more than 1e-9 of the goal; "feasible": stopped, `gap` says how much
        better another choice could be; "infeasible": every choice was ruled out by a bound;
        "unproven": stopped with nothing found.
    """
    return _turned(question, budget) if question.adds_up else _by_tree(question, budget)


def _turned(question: Question, budget: Budget | None) -> Solved:
    """The same where amplitudes are added up: |a| + |b| is the greatest of all |a + e^{it} b|, which the tree bounds.

    It begins with a few turns t; those of the best choice are added until it is as good as all of them say.
    """
    worst, many = question.goal == "worst", question.n_readings
    _, first, own = np.unique(question.sums, return_index=True, return_inverse=True)
    member, importance = own == np.arange(len(first))[:, None], question.importance[first] * worst
    place = np.cumsum(member, axis=1)[own, np.arange(many)]  # of a reading among those of its number
    turned = [member * np.exp(2j * np.pi * place * k / _TURNS) for k in range(_TURNS)]
    numbers = [np.arange(len(first))] * _TURNS
    alone = replace(
        question, sums=question.sums[:0], limits=np.full(many, np.inf), importance=question.importance * (not worst)
    )
    best, low, details = Solved(None, "unproven", _NO_CHOICE), -np.inf, {"boxes": 0, "choices": 0}
    unbalance = felt(question.y0, question.H) * float(question.densities.max(initial=0.0))
    size = unbalance if question.goal == "correction" else float(question.measure(np.abs(question.y0)))
    for _ in range(_EXCHANGES):
        rows, of = np.concatenate(turned), np.concatenate(numbers)
        asked = alone.with_rows(rows @ question.y0, rows @ question.H, importance[of], question.limits[first[of]])
        found = _by_tree(asked, budget)
        details = {name: count + found.details.get(name, 0) for name, count in details.items()}
        if found.u is None:
            return replace(found, details=details)
        scale = sqrt(asked.n_readings / many) if question.goal == "rms" else 1.0
        low = max(low, found.bound * scale)
        value = question.chosen_only(found.chosen).value(found.u)
        if value < best.value or best.u is None:
            kept = not breaks(question.chosen_only(found.chosen), found.u, KEPT)
            best = replace(found, value=value) if kept else best
        if (
            best.u is not None
            and found.status == "optimal"
            and relative_gap(best.value, found.value * scale, size) <= DONE
        ):
            low = min(low, best.value)
            gap = relative_gap(best.value, low, size)
            return replace(best, status="optimal", claim=found.claim, bound=low, gap=gap, details=details)
        if found.status == "feasible":  # its work is done
            break
        left = question.residual(found.u)
        sums = member @ np.abs(left)
        more = np.flatnonzero((sums > question.limits[first]) | (importance * sums > low))
        turned.append(member[more] * (left.conj() / np.maximum(np.abs(left), 1e-300)))
        numbers.append(more)
    if best.u is None:
        return replace(best, details=details)
    low = min(low, best.value)
    gap = relative_gap(best.value, low, size)
    claim = f"stopped after {counted(details['boxes'], 'boxes')}; none is better by more than {100 * gap:.3g} %"
    return replace(best, status="feasible", claim=claim, bound=low, gap=gap, details=details)


def _by_tree(question: Question, budget: Budget | None) -> Solved:
    """The same where each reading stands by itself."""
    free = free_planes(question)
    lists = free.question.options
    empty = [p for p, entry in enumerate(lists) if entry is not None and not len(entry.u)]
    if empty:
        names = ", ".join(str(p) for p in np.flatnonzero(free.spread[:, empty[0]]))
        return Solved(None, "infeasible", f"caps and forbidden sectors leave nothing of the list of plane {names}")
    scene = _with_lists(scaled(free.question), free)
    relaxed = solve_convex(scene)
    if relaxed.x is None and relaxed.factor > 1.0 + KEPT:
        claim = f"even of weights that need not be listed {wider_words(question, relaxed.factor)}"
        return Solved(None, "infeasible", claim, least_factor=relaxed.factor)
    tree = _tree(scene, free, relaxed)
    start = relaxed.x if relaxed.x is not None else np.zeros(scene.n_planes, dtype=complex)
    _first_guess(tree, scene, start)
    bound = tree.search(start, tree.budget() if budget is None else budget)
    return _solved(question, free, scene, tree, max(bound, relaxed.bound))


def _with_lists(scene: Scaled, free: Free) -> Scaled:
    """Caps and masses of the continuous relaxation: the disc that holds a list, the least mass per unbalance in it."""
    caps, mass = scene.caps.copy(), scene.mass.copy()
    for p, options in enumerate(free.question.options):
        if options is not None:
            size = np.abs(options.u) / scene.column[p]
            caps[p] = float(size.max())
            some = size > 1e-9 * caps[p]
            mass[p] = float((options.masses[some] / size[some]).min()) / scene.mass_size if some.any() else 0.0
    return replace(scene, caps=caps, mass=mass)


def _tree(scene: Scaled, free: Free, relaxed: Convex) -> Tree:
    """The search with its cells and the rows that matter."""
    v = relaxed.dual.v if relaxed.dual is not None else np.zeros(len(scene.f), dtype=complex)
    goal_rows, limit_rows = first_rows(scene)
    limit_rows = np.union1d(limit_rows, np.flatnonzero(np.abs(v) > 1e-9 * np.abs(v).max(initial=0.0)))
    far = 30.0 * (1.0 + float(np.abs(relaxed.x).max(initial=0.0))) if relaxed.x is not None else 1e3
    rows = replace(
        scene, G=scene.G[goal_rows], g=scene.g[goal_rows], F=scene.F[limit_rows], f=scene.f[limit_rows],
        caps=np.minimum(scene.caps, far),
    )  # fmt: skip
    cells = [
        None if options is None else Cells(options.u / scene.column[p], options.masses / scene.mass_size, options.uses)
        for p, options in enumerate(free.question.options)
    ]
    return Tree(scene, rows, cells, v[limit_rows], free.question.sectors, free.question.stock)


def _first_guess(tree: Tree, scene: Scaled, x: ComplexArray) -> None:
    """Round the continuous answer, so that the search has something to beat."""
    lists: list[ComplexArray] = []
    masses: list[FloatArray] = []
    arcs = map(allowed_arcs, tree.sectors)
    near = [
        into_set(complex(value), own, scene.fans.get(p)) for p, (value, own) in enumerate(zip(x, arcs, strict=True))
    ]
    x = np.array(near, dtype=complex)
    sizes = scene.sizes(x)
    for p, cells in enumerate(tree.planes):
        lists.append(np.array([x[p]]) if cells is None else cells.points.copy())
        masses.append(np.array([sizes[p] * scene.mass[p]]) if cells is None else cells.masses.copy())
    none = np.zeros((1, len(tree.stock)))
    uses = [none if cells is None else cells.uses for cells in tree.planes]
    chosen, value = rounded(scene, lists, masses, x, uses=uses, stock=tree.stock)
    places = np.array([-1 if cells is None else k for cells, k in zip(tree.planes, chosen, strict=True)])
    tree.offer(np.array([lists[p][k] for p, k in enumerate(chosen)], dtype=complex), value, places)


def _place(free: Free, tree: Tree, plane: int, options: Options, u: complex) -> int:
    """Place of a plane's correction in its own list; where weights are counted, of the very option that was taken."""
    columns = np.flatnonzero(free.spread[plane])
    if len(tree.stock) and len(columns):
        kept = free.places[columns[0]]
        assert kept is not None
        return int(kept[tree.best_places[columns[0]]])
    return options.nearest(u)


def _solved(question: Question, free: Free, scene: Scaled, tree: Tree, bound: float) -> Solved:
    """The answer in the asker's planes and units."""
    details = {"boxes": tree.boxes, "choices": tree.leaves}
    choices = float(np.prod([float(len(cells.points)) for cells in tree.planes if cells is not None]))
    if not np.isfinite(tree.best_value):
        if bound == np.inf:
            claim = f"none of the {counted(choices, 'choices')} keeps the limits (branch and bound over all of them)"
            return Solved(None, "infeasible", claim, details=details)
        return Solved(
            None,
            "unproven",
            f"stopped after {counted(tree.boxes, 'boxes')} before a choice that keeps the limits was found",
            details=details,
        )
    u = free.spread @ (tree.best_x * scene.column)
    chosen = []
    for plane, options in enumerate(question.options):
        place = -1 if options is None else _place(free, tree, plane, options, complex(u[plane]))
        chosen.append(place)
        if options is not None:
            u[plane] = options.u[place]
    u, chosen = first_of_equals(question, u, chosen)
    value = question.chosen_only(chosen).value(u)
    low = min(bound * scene.goal_size, value)
    gap = relative_gap(value, low, scene.goal_size)
    done = gap <= DONE
    claim = f"none of the {counted(choices, 'choices')} is better (branch and bound over all of them)"
    if not done:
        most = f"none is better by more than {100 * gap:.3g} %"
        claim = f"stopped after {counted(tree.boxes, 'boxes')}; of the {counted(choices, 'choices')} {most}"
    return Solved(u, "optimal" if done else "feasible", claim, value, low, gap, chosen=tuple(chosen), details=details)
