"""Branch and bound over boxes of options, many boxes at a time, best first."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.balancing.continuous import solve_pieces
from vibopt.balancing.convex_rounds import KEPT, Convex
from vibopt.balancing.question import Sectors
from vibopt.balancing.rounding import Boxes, goal_bounds, judge, mass_bounds, short_of
from vibopt.balancing.scaled import Scaled
from vibopt.frontier import Frontier
from vibopt.records import dataclass
from vibopt.work import Budget, worked

Places = IntArray


class Cells:
    """Boxes of options: cell 0 holds all; the children of a cell halve it along its longer side.

    Attributes
    ----------
    points, masses, uses
        The options, their masses, and how many of each counted weight they take (n_options, n_kinds), in an order that
        keeps each cell together; `order` leads back to the asker's.
    centre, half
        Middle of each cell's box and half its sides (half.real along Re, half.imag along Im), shape (n_cells,).
    lightest, fewest
        Least mass in the cell, and least use of each counted weight (n_cells, n_kinds).
    start, stop, left
        Its range of points, and its first child (the second is the next; -1: not split yet).
    """

    def __init__(self, points: ComplexArray, masses: FloatArray, uses: FloatArray) -> None:
        self.points, self.masses, self.order, self.uses = points, masses, np.arange(len(points)), uses.copy()
        room = 256
        self.fewest = np.zeros((room, self.uses.shape[1]))
        self.centre, self.half = np.zeros(room, dtype=complex), np.zeros(room, dtype=complex)
        self.lightest = np.zeros(room)
        self.start, self.stop, self.left = (np.zeros(room, dtype=int) for _ in range(3))
        self.count = 0
        self._add(0, len(points))

    def children(self, cells: Places) -> Places:
        """First child of each cell (which must hold two options at least), split now where that was not done."""
        for cell in np.unique(cells[self.left[cells] < 0]):
            self._split(int(cell))
        return self.left[cells]

    def sizes(self, cells: Places) -> Places:
        """Number of options in each cell."""
        return self.stop[cells] - self.start[cells]

    def _split(self, cell: int) -> None:
        start, stop = int(self.start[cell]), int(self.stop[cell])
        part = self.points[start:stop]
        side = part.real if self.half[cell].real >= self.half[cell].imag else part.imag
        order = start + np.argsort(side, kind="stable")
        for name in ("points", "masses", "order", "uses"):
            values = getattr(self, name)
            values[start:stop] = values[order]
        middle = (start + stop) // 2
        self.left[cell] = self.count
        self._add(start, middle)
        self._add(middle, stop)

    def _add(self, start: int, stop: int) -> None:
        if self.count == len(self.centre):
            for name in ("centre", "half", "lightest", "start", "stop", "left", "fewest"):
                values = getattr(self, name)
                setattr(self, name, np.concatenate([values, np.zeros_like(values)]))
        part = self.points[start:stop]
        low, high = complex(part.real.min(), part.imag.min()), complex(part.real.max(), part.imag.max())
        cell = self.count
        self.centre[cell], self.half[cell] = 0.5 * (low + high), 0.5 * (high - low)
        self.lightest[cell] = self.masses[start:stop].min()
        self.fewest[cell] = self.uses[start:stop].min(axis=0)
        self.start[cell], self.stop[cell], self.left[cell] = start, stop, -1
        self.count += 1


BATCH = 512  # boxes opened at a time
LEAF = 64  # a box with so few choices is enumerated
CLOSED = 1e-9
FINISHED = 1e-7  # gap to which the planes without a list are closed
MOST_BOXES = 1_500_000  # kept open at a time
WORK = 1e9  # rows times planes times sweeps of all boxes looked at
FINISH = 1000  # boxes that take as long as one program for the planes without a list
BOX, ROUND = 0.02, 0.5  # of nominal work [ms], and of a round of boxes opened together


@dataclass
class Open:
    """Boxes to look at: bound, cell per plane (-1: a plane without a list), best place and Lawson's weights."""

    bound: FloatArray
    cells: Places
    x: ComplexArray
    goal_weights: FloatArray
    limit_weights: FloatArray

    def take(self, rows: Places) -> Open:
        return Open(*(column[rows] for column in self.columns))

    @property
    def columns(self) -> tuple[np.ndarray[Any, Any], ...]:
        """As a frontier keeps them."""
        return tuple(vars(self).values())


class Tree:
    """The search for the best joint choice.

    Parameters
    ----------
    scene
        Every row: what is judged.
    rows
        The same with the rows that matter for bounds.
    planes
        Cells of each plane's list; None where the plane takes any correction up to its cap.
    v
        Multipliers of the limits of `rows` at the continuous answer.
    sectors
        Forbidden arcs of the planes without a list (the lists hold only what is allowed); empty: none.

    stock
        How many of each kind of weight there are for all planes; empty: not counted.

    Attributes
    ----------
    best_places
        Places in the lists of the best correction found, -1 for a plane without a list.
    undecided
        Least bound of the choices whose own program for the planes without a list could not be closed.
    """

    def __init__(
        self, scene: Scaled, rows: Scaled, planes: list[Cells | None], v: ComplexArray, sectors: tuple[Sectors, ...],
        stock: FloatArray,
    ) -> None:  # fmt: skip
        self.scene, self.rows, self.planes, self.v = scene, rows, planes, v
        self.limits = replace(rows, G=rows.F, g=rows.f, goal="worst")  # the worst of the limits as the goal
        self.sectors = sectors or ((),) * len(planes)
        self.undecided, self.stock = np.inf, stock
        self.best_places = np.full(len(planes), -1)
        self.any_size = [p for p, cells in enumerate(planes) if cells is None]
        self.rounds = 12 if self.any_size else 4
        self.norms = np.sqrt((np.abs(rows.G) ** 2).sum(axis=0) + (np.abs(rows.F) ** 2).sum(axis=0))
        self.slope, self.constant = rows.F.conj().T @ v, float((v.conj() @ rows.f).real - np.abs(v).sum())
        self.best_value, self.best_x = np.inf, np.zeros(len(planes), dtype=complex)
        self.boxes = self.leaves = self.programs = 0

    def offer(self, x: ComplexArray, value: float, places: Places) -> None:
        """Remember a correction that keeps every limit."""
        if value < min(self.best_value, 1e6):
            self.best_value, self.best_x, self.best_places = value, x.copy(), places.copy()

    @property
    def work(self) -> int:
        """Boxes looked at, programs counted as boxes."""
        return self.boxes + self.leaves // LEAF + FINISH * self.programs

    @property
    def goal_to_beat(self) -> float:
        """Boxes with a bound of so much or more hold nothing that is better; inf as long as nothing was found."""
        if not np.isfinite(self.best_value):
            return np.inf
        return self.best_value - CLOSED * max(abs(self.best_value), 1e-3)

    def budget(self) -> Budget:
        """Boxes that a question of this size may look at."""
        each = self.rounds * max(len(self.planes), 1) * max(len(self.rows.g) + len(self.rows.f), 1)
        return Budget(int(np.clip(WORK / each, 20_000, 5_000_000)), "boxes")

    def search(self, x: ComplexArray, budget: Budget) -> float:
        """Look at every box that may hold something better; the bound proven when done or when the budget is spent."""
        n, m = len(self.rows.g), len(self.rows.f)
        root = np.array([[-1 if cells is None else 0 for cells in self.planes]])
        weights = np.full((1, n), 1 / max(n, 1)), np.full((1, m), 1 / max(m, 1))
        frontier = Frontier(budget)
        frontier.add(*self._bounded(Open(np.array([-np.inf]), root, x[None, :].copy(), *weights)).columns)
        while frontier and not frontier.over and len(frontier) <= MOST_BOXES:
            before, seen = self.work, self.boxes + self.leaves // LEAF
            grown = self._grow(Open(*frontier.take(BATCH)))
            budget.spend(self.work - before)
            worked(ROUND + BOX * (self.boxes + self.leaves // LEAF - seen))  # programs count themselves
            if grown is not None:
                frontier.add(*grown.columns)
            frontier.keep(self.goal_to_beat)
        return min(frontier.bound, self.goal_to_beat, self.undecided)

    def _grow(self, picked: Open) -> Open | None:
        """Enumerate the small boxes, halve the others; bounds of the halves."""
        picked = picked.take(np.flatnonzero(picked.bound < self.goal_to_beat))
        sizes = self._sizes(picked.cells)
        small = np.prod(sizes.astype(float), axis=1) <= (LEAF if not self.any_size else 1)
        if small.any():
            self._enumerate(picked.cells[small], sizes[small])
        large = picked.take(np.flatnonzero(~small))
        if not len(large.bound):
            return None
        return self._bounded(self._halved(large, sizes[~small]))

    def _sizes(self, cells: Places) -> Places:
        """Number of options per box and plane; one where the plane has no list."""
        sizes = np.ones(cells.shape, dtype=int)
        for p, tree in enumerate(self.planes):
            if tree is not None:
                sizes[:, p] = tree.sizes(cells[:, p])
        return sizes

    def _halved(self, large: Open, sizes: Places) -> Open:
        """Both halves of each box, along the plane whose options still differ most in their effect."""
        spread = np.zeros(large.cells.shape)
        for p, tree in enumerate(self.planes):
            if tree is not None:
                spread[:, p] = np.where(
                    sizes[:, p] > 1, self.norms[p] * np.abs(tree.half[large.cells[:, p]]) + 1e-300, -1.0
                )
        widest = spread.argmax(axis=1)
        first = large.cells.copy()
        for p, tree in enumerate(self.planes):
            mine = np.flatnonzero(widest == p)
            if tree is not None and len(mine):
                first[mine, p] = tree.children(large.cells[mine, p])
        second = first.copy()
        second[np.arange(len(widest)), widest] += 1
        twice = large.take(np.tile(np.arange(len(widest)), 2))
        twice.cells = np.vstack([first, second])
        return twice

    def _bounded(self, nodes: Open) -> Open:
        """Bounds of boxes; those that cannot keep the limits or the total get infinity."""
        boxes = self._boxes(nodes.cells)
        self.boxes += len(nodes.bound)
        for p in range(len(self.planes)):
            nodes.x[:, p] = boxes.clip(nodes.x[:, p], p)
        bound = nodes.bound.copy()
        if len(self.rows.f):
            ratio = goal_bounds(self.limits, boxes, nodes.x.copy(), nodes.limit_weights, self.rounds)
            bound[ratio > 1.0 + KEPT] = np.inf
        if self.rows.goal == "correction":
            for factor in (0.5, 1.0):
                bound = np.maximum(bound, mass_bounds(self.rows, boxes, factor * self.v[None, :]))
        else:
            own = goal_bounds(self.rows, boxes, nodes.x, nodes.goal_weights, self.rounds, self.slope, self.constant)
            bound = np.maximum(bound, own)
        bound[boxes.lightest.sum(axis=1) > self.scene.total * (1.0 + KEPT)] = np.inf
        if len(self.stock):
            fewest = sum(tree.fewest[nodes.cells[:, p]] for p, tree in enumerate(self.planes) if tree is not None)
            bound[short_of(np.asarray(fewest), self.stock) > 0.0] = np.inf
        nodes.bound = bound
        return nodes.take(np.flatnonzero(np.isfinite(bound)))

    def _boxes(self, cells: Places) -> Boxes:
        centre, half = np.zeros(cells.shape, dtype=complex), np.zeros(cells.shape, dtype=complex)
        lightest = np.zeros(cells.shape)
        for p, tree in enumerate(self.planes):
            if tree is None:
                half[:, p] = (1 + 1j) * self.rows.reach[p]
            else:
                own = cells[:, p]
                centre[:, p], half[:, p], lightest[:, p] = tree.centre[own], tree.half[own], tree.lightest[own]
        return Boxes(centre, half, lightest)

    def _enumerate(self, cells: Places, sizes: Places) -> None:
        """Judge every choice of these boxes."""
        totals = sizes.prod(axis=1)
        box = np.repeat(np.arange(len(totals)), totals)
        place = np.arange(len(box)) - np.repeat(np.cumsum(totals) - totals, totals)
        x, masses = np.zeros((len(box), cells.shape[1]), dtype=complex), np.zeros((len(box), cells.shape[1]))
        places, used = np.full(x.shape, -1), np.zeros((len(box), len(self.stock)))
        for p, tree in enumerate(self.planes):
            if tree is not None:
                at = tree.start[cells[box, p]] + place % sizes[box, p]
                place //= sizes[box, p]
                x[:, p], masses[:, p], places[:, p] = tree.points[at], tree.masses[at], tree.order[at]
                used += tree.uses[at]
        self.leaves += len(box)
        if len(self.stock):
            there = short_of(used, self.stock) == 0.0
            x, masses, places = x[there], masses[there], places[there]
            if not len(x):
                return
        if self.any_size:
            self._finish(x, masses, places)
            return
        values = judge(self.scene, x, masses)
        best = int(np.argmin(values))
        self.offer(x[best], float(values[best]), places[best])

    def _finish(self, x: ComplexArray, masses: FloatArray, places: Places) -> None:
        """Choose the planes without a list, the others being fixed."""
        scene, free = self.scene, self.any_size
        for row, mass, place in zip(x, masses, places, strict=True):
            left = scene.total - mass.sum()
            if left < 0:
                continue
            inner = replace(
                scene, G=scene.G[:, free], g=scene.g + scene.G @ row, F=scene.F[:, free], f=scene.f + scene.F @ row,
                caps=scene.caps[free], mass=scene.mass[free], total=left, wedges=tuple(scene.wedges[p] for p in free),
                fans={k: scene.fans[p] for k, p in enumerate(free) if p in scene.fans},
            )  # fmt: skip
            answer, bound = self._free_planes(inner)
            self.programs += answer.rounds if any(fan.bulges for fan in inner.fans.values()) else 1
            extra = float(mass.sum()) if scene.goal == "correction" else 0.0
            if answer.x is not None:
                full = row.copy()
                full[free] = answer.x
                self.offer(full, answer.value + extra, place)
            if not (answer.value - bound <= FINISHED * max(abs(answer.value), 1e-3) or bound == np.inf):
                self.undecided = min(self.undecided, bound + extra)

    def _free_planes(self, inner: Scaled) -> tuple[Convex, float]:
        """The planes without a list outside their forbidden arcs, and a bound; inf where none is proven to fit."""
        answer = solve_pieces(inner, tuple(self.sectors[p] for p in self.any_size))
        return answer, np.inf if answer.x is None and answer.factor > 1.0 else answer.bound
