"""Sets of choices: some rows of each table and some values of each discrete variable; groups that may be exchanged."""

from __future__ import annotations

import math
from itertools import combinations
from typing import Any

import numpy as np

from vibopt.arrays import BoolArray, FloatArray, IntArray
from vibopt.forms import Form
from vibopt.forms.form import row_said
from vibopt.mechanics.model import Model
from vibopt.program.program import Program, Tie
from vibopt.records import dataclass


def factors_of(program: Program) -> tuple[Tie, ...]:
    """What is chosen at once: parts of tables first, then values of the discrete variables that no table has."""
    tied = {axis for tie in program.ties for axis in tie.axes}
    found = [*program.ties]
    for index, axis in enumerate(program.axes):
        if index not in tied:
            assert axis.values is not None
            found.append(Tie(axis.path, (index,), np.array(axis.values)[:, None], ()))
    return tuple(found)


@dataclass(frozen=True, slots=True)
class Node:
    """Entries left of each factor."""

    entries: tuple[IntArray, ...]

    @property
    def size(self) -> int:
        """Number of choices."""
        return math.prod(len(entry) for entry in self.entries)


@dataclass(frozen=True)
class Choices:
    """All choices of a program.

    factors
        What is chosen.
    n_vars
        Number of variables.
    """

    factors: tuple[Tie, ...]
    n_vars: int

    @property
    def root(self) -> Node:
        return Node(tuple(np.arange(len(factor.table)) for factor in self.factors))

    def designs(self, chosen: IntArray) -> FloatArray:
        """Designs (n, n_vars) of choices given by entry of each factor (n, n_factors)."""
        x = np.ones((len(chosen), self.n_vars))
        for index, factor in enumerate(self.factors):
            x[:, list(factor.axes)] = factor.table[chosen[:, index]]
        return x

    def all_in(self, node: Node) -> IntArray:
        """Every choice of a node by entries, (size, n_factors), in the order of the tables."""
        grids = np.meshgrid(*node.entries, indexing="ij")
        return np.stack([grid.ravel() for grid in grids], axis=-1)

    def hull(self, node: Node) -> tuple[FloatArray, FloatArray]:
        """The box around all designs of a node, each (n_vars,)."""
        low, high = np.ones(self.n_vars), np.ones(self.n_vars)
        for factor, entries in zip(self.factors, node.entries, strict=True):
            values = factor.table[entries]
            low[list(factor.axes)] = values.min(axis=0)
            high[list(factor.axes)] = values.max(axis=0)
        return low, high

    def singles(self, node: Node, index: int) -> tuple[FloatArray, FloatArray]:
        """Boxes of a node with each entry of one factor by itself, each (n_entries, n_vars)."""
        low, high = self.hull(node)
        factor, entries = self.factors[index], node.entries[index]
        lows, highs = np.tile(low, (len(entries), 1)), np.tile(high, (len(entries), 1))
        lows[:, list(factor.axes)] = highs[:, list(factor.axes)] = factor.table[entries]
        return lows, highs

    def halves(self, node: Node, weight: FloatArray) -> tuple[Node, Node]:
        """A node cut in two along the table with most rows, by the column that spreads most; `weight` (n_vars,)."""
        index = max(range(len(node.entries)), key=lambda i: len(node.entries[i]))
        factor, entries = self.factors[index], node.entries[index]
        values = factor.table[entries]
        floor = np.maximum(values.min(axis=0, initial=np.inf), 1e-6 * values.max(axis=0, initial=0.0))
        with np.errstate(divide="ignore", invalid="ignore"):
            spread = np.nan_to_num(np.log(values.max(axis=0) / floor)) * weight[list(factor.axes)]
        column = int(spread.argmax()) if len(factor.axes) else 0
        order = entries[np.argsort(values[:, column], kind="stable")] if len(factor.axes) else entries
        middle = len(order) // 2
        first, second = np.sort(order[:middle]), np.sort(order[middle:])
        return self._with(node, index, first), self._with(node, index, second)

    def kept(self, node: Node, index: int, mask: BoolArray) -> Node:
        """A node with only some entries of one factor."""
        return self._with(node, index, node.entries[index][mask])

    def _with(self, node: Node, index: int, entries: IntArray) -> Node:
        return Node(tuple(entries if i == index else entry for i, entry in enumerate(node.entries)))


@dataclass(frozen=True, slots=True)
class Mirror:
    """Factors (part, count, ...) of one group and those of another, in the same order."""

    one: tuple[int, ...]
    other: tuple[int, ...]

    def first(self, chosen: IntArray) -> BoolArray:
        """Choices (n, n_factors) that stand for themselves and their mirror image, shape (n,)."""
        kept = np.ones(len(chosen), dtype=bool)
        level = np.ones(len(chosen), dtype=bool)
        for here, there in zip(self.one, self.other, strict=True):
            kept &= ~(level & (chosen[:, here] > chosen[:, there]))
            level &= chosen[:, here] == chosen[:, there]
        return kept

    def images(self, chosen: IntArray) -> IntArray:
        """Mirror images of choices, those left out that are their own."""
        turned = chosen.copy()
        turned[:, list(self.one)], turned[:, list(self.other)] = chosen[:, list(self.other)], chosen[:, list(self.one)]
        found: IntArray = turned[(turned != chosen).any(axis=1)]
        return found


def mirrors(program: Program, choices: Choices) -> list[Mirror]:
    """Pairs of groups that may be exchanged, so that each chain of them keeps one order."""
    groups: dict[str, list[int]] = {}
    for index, factor in enumerate(choices.factors):
        groups.setdefault(".".join(factor.path.split(".")[:2]), []).append(index)
    found = []
    for one, other in combinations(groups.values(), 2):
        if _alike(choices, one, other) and _unchanged(program, choices, one, other):
            found.append(Mirror(tuple(one), tuple(other)))
    return found


def _alike(choices: Choices, one: list[int], other: list[int]) -> bool:
    if len(one) != len(other):
        return False
    pairs = [(choices.factors[i], choices.factors[j]) for i, j in zip(one, other, strict=True)]
    return all(
        a.path.split(".")[2:] == b.path.split(".")[2:] and np.array_equal(a.table, b.table) and a.names == b.names
        for a, b in pairs
    )


def _unchanged(program: Program, choices: Choices, one: list[int], other: list[int]) -> bool:
    """Whether the limits and the goal are the same with the variables of both groups exchanged."""
    order = np.arange(len(program.axes))
    for i, j in zip(one, other, strict=True):
        here, there = list(choices.factors[i].axes), list(choices.factors[j].axes)
        order[here], order[there] = order[there], order[here]
    asked = [_said(part, order) for part in program.parts]
    return sorted(map(repr, asked)) == sorted(repr(_said(part, np.arange(len(order)))) for part in program.parts)


def _said(part: Any, order: IntArray) -> tuple[Any, ...]:
    """A limit or the goal as plain data, its variables renumbered."""
    model, form = part.model, part.form
    own = (type(form).__name__, getattr(part, "side", "goal"), getattr(part, "bound", 0.0), getattr(part, "upper", 0.0))
    return (*own, form.said(model, order), () if form.powers is not None else _terms(model, form, order))


def _terms(model: Model, form: Form, order: IntArray) -> tuple[Any, ...]:
    signs = form.harmonic.output.signs if form.harmonic is not None else np.zeros(len(model.terms))
    return tuple(
        sorted(
            (
                term.kind,
                row_said(term.vector),
                term.scale,
                term.static_scale,
                tuple(float(exponent) + 0.0 for exponent in term.exponents[order]),
                float(sign),
            )
            for term, sign in zip(model.terms, signs, strict=True)
        )
    )
