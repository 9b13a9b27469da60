"""A plane's options as a tree of boxes in the complex plane, split only where the search looks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vibopt.forms import ComplexArray, FloatArray

Places = NDArray[np.intp]


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

    def __init__(self, points: ComplexArray, masses: FloatArray, uses: FloatArray | None = None) -> None:
        self.points, self.masses, self.order = points.copy(), masses.copy(), np.arange(len(points))
        self.uses = np.zeros((len(points), 0)) if uses is None else uses.copy()
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
