"""Forms of the undamped modes: natural frequencies, the gaps between them, their energies and shapes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.form import Form, bend_of_slopes
from vibopt.mechanics.free_motion import TOGETHER, shape_ratio
from vibopt.mechanics.model import INERTIA
from vibopt.mechanics.modes import frequency_slopes, mode_shapes, natural_frequencies
from vibopt.records import dataclass

if TYPE_CHECKING:
    from vibopt.mechanics.model import Model


@dataclass(frozen=True, slots=True)
class ModeFrequency(Form):
    """Undamped natural frequency number `mode` (1 is the lowest) [rad/s]; 0 means each of them."""

    mode: int

    @property
    def index(self) -> int:
        """Of the mode among the natural frequencies, the lowest for each of them."""
        return max(self.mode - 1, 0)

    def value(self, model: Model, x: FloatArray) -> float:
        return float(natural_frequencies(model, model.values(x))[self.index])

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        of_mode: FloatArray = frequency_slopes(model, x)[1][self.index]
        return of_mode

    def bend(self, model: Model, x: FloatArray) -> FloatArray:
        return bend_of_slopes(self, model, x)


@dataclass(frozen=True, slots=True)
class ModeGap(Form):
    """Least difference between neighbouring undamped natural frequencies [rad/s]."""

    def value(self, model: Model, x: FloatArray) -> float:
        return float(np.diff(natural_frequencies(model, model.values(x))).min(initial=np.inf))


@dataclass(frozen=True, slots=True)
class EnergyShare(Form):
    """Part of the kinetic energy that a mode has in one motion of one body: (r . phi) (r . M phi) / (phi . M phi).

    The greatest over all modes; modes of one frequency count together.  row (n_coords,).
    """

    row: FloatArray

    def value(self, model: Model, x: FloatArray) -> float:
        n, p = model.n_free, model.values(x)
        omega, shapes = mode_shapes(model, p)
        moved = self.row[:n] @ shapes
        pushed = self.row[:n] @ model.matrix(INERTIA, np.where(model.across, 0.0, p))[:n, :n] @ shapes
        best = 0.0
        for group in _together(omega):
            share = np.outer(moved[group], pushed[group])
            best = max(best, float(np.linalg.eigvalsh(0.5 * (share + share.T))[-1]))
        return best


@dataclass(frozen=True, slots=True)
class ModeRatio(Form):
    """Motion over motion in undamped mode number `mode`, with its sign: (of . phi) / (to . phi); rows (n_coords,)."""

    mode: int
    of: FloatArray
    to: FloatArray

    def value(self, model: Model, x: FloatArray) -> float:
        n = model.n_free
        return shape_ratio(*mode_shapes(model, model.values(x)), self.mode, self.of[:n], self.to[:n])


def _together(omega: FloatArray) -> list[list[int]]:
    """Indices of modes, those of one frequency as one group; omega ascending."""
    groups: list[list[int]] = []
    for index, one in enumerate(omega):
        if groups and one - omega[groups[-1][-1]] <= TOGETHER * one:
            groups[-1].append(index)
        else:
            groups.append([index])
    return groups
