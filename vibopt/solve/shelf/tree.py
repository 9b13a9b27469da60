"""Sets of choices: some rows of each table and some values of each discrete variable."""

from __future__ import annotations

import math

import numpy as np

from vibopt.forms import BoolArray, FloatArray, IntArray
from vibopt.program.program import Program, Tie
from vibopt.records import dataclass


@dataclass(frozen=True, slots=True)
class Factor:
    """What is chosen at once: a part of a table, or one value of a discrete variable.

    path
        In the file.
    axes
        Indices of the variables that take their values from it.
    table
        Values [SI], shape (n_entries, n_axes).
    names
        Of the parts; empty for a discrete variable.
    """

    path: str
    axes: tuple[int, ...]
    table: FloatArray
    names: tuple[str, ...] = ()


def factors_of(program: Program) -> tuple[Factor, ...]:
    """Tables first, then the discrete variables that no table has."""
    tied = {axis for tie in program.ties for axis in tie.axes}
    found = [_of_tie(tie) for tie in program.ties]
    for index, axis in enumerate(program.axes):
        if index not in tied:
            assert axis.values is not None
            found.append(Factor(axis.path, (index,), np.array(axis.values)[:, None]))
    return tuple(found)


def _of_tie(tie: Tie) -> Factor:
    return Factor(tie.path, tie.axes, tie.table, tie.names)


@dataclass(frozen=True, slots=True)
class Node:
    """Entries left of each factor."""

    entries: tuple[IntArray, ...]

    @property
    def size(self) -> int:
        """Number of choices."""
        return math.prod(len(one) for one in self.entries)


@dataclass(frozen=True)
class Shelf:
    """All choices of a program.

    factors
        What is chosen.
    n_vars
        Number of variables.
    """

    factors: tuple[Factor, ...]
    n_vars: int

    @property
    def root(self) -> Node:
        return Node(tuple(np.arange(len(one.table)) for one in self.factors))

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
        return Node(tuple(entries if i == index else one for i, one in enumerate(node.entries)))


__all__ = ["Factor", "Node", "Shelf", "factors_of"]
