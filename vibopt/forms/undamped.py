"""Forms of the undamped modes: natural frequencies, the gaps between them, their energies and shapes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.form import ROOTS, Form, bend_of_slopes, plus
from vibopt.mechanics.free_motion import TOGETHER, shape_ratio
from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS
from vibopt.mechanics.modes import (
    frequency_bends,
    frequency_slopes,
    mode_shapes,
    modes_at,
    natural_frequencies,
    undamped,
)
from vibopt.records import dataclass

if TYPE_CHECKING:
    from vibopt.arrays import IntArray
    from vibopt.forms.asking import ConvexRows, LogRows, OneVariable, Proof
    from vibopt.forms.bounds import FormBounds
    from vibopt.forms.form import Bounds
    from vibopt.mechanics.model import Model


@dataclass(frozen=True, slots=True)
class ModeFrequency(Form):
    """Undamped natural frequency number `mode` (1 is the lowest) [rad/s]; 0 means each of them."""

    mode: int
    one_line = True
    once = 0.04

    @property
    def frequency(self) -> ModeFrequency:
        return self

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
        found = frequency_bends(model, x, [self.index])
        return bend_of_slopes(self, model, x) if found is None else found[0]

    def ahead(self, model: Model, x: FloatArray) -> None:
        if model.spins:
            modes_at(model, x)

    def acting(self, model: Model) -> FloatArray:
        return of_modes(model)

    def senses(self, model: Model) -> FloatArray:
        """It rises with every stiffness and falls with every mass."""
        return frequency_senses(model)

    def rises(self, model: Model, index: int) -> float | None:
        moved = [term for term in model.terms if term.exponents[index]]
        kinds = {term.kind for term in moved}
        if self.mode < 1 or not kinds <= {STIFFNESS, DAMPING} or STIFFNESS not in kinds:
            return None
        return None if any(term.exponents[index] < 0.0 for term in moved) else 1.0

    def watched(self, ends: tuple[float, ...]) -> list[float]:
        return list(ends)

    def room(self, model: Model, x: FloatArray, value: float, other: float, rounding: float) -> float:
        modes = natural_frequencies(model, model.values(x))
        top = float(modes[np.isfinite(modes)].max(initial=0.0))
        return float(rounding * top**2 / max(abs(other), np.sqrt(rounding) * top)) if top else 0.0

    def said(self, model: Model, order: IntArray) -> tuple[Any, ...]:
        return (self.mode,)

    def polynomial(self, rows: OneVariable, model: Model, bound: float) -> FloatArray:
        """One mass: k - w^2 m."""
        return plus(rows.total(model, STIFFNESS), -(bound**2) * rows.total(model, INERTIA))

    def is_polynomial(self, model: Model, most_degree: int) -> bool:
        return model.n_free == 1 and self.mode == 1

    def sampleable(self, model: Model) -> bool:
        return not model.spins

    def not_smooth(self, model: Model) -> str:
        return "keeps every natural frequency out of a band: above it or below is a choice for each" * (not self.mode)

    def bounded(self, model: Model) -> bool:
        return not model.spins

    def on_boxes(self, known: FormBounds, low: FloatArray, high: FloatArray) -> Bounds:
        return frequencies_on(known.model, low, high, self.index)

    def known(self, at: FormBounds) -> bool:
        return True

    def on_points(self, at: FormBounds, x: FloatArray) -> Bounds:
        value = modes_at(at.model, x)[:, self.index]
        return value, value

    def logged(self, rows: LogRows, model: Model, bound: float) -> Any:
        return rows.of_mode(model, self.index, bound)

    def convex_limit(self, rows: ConvexRows, limit: Any, sense: float, bound: float) -> Any:
        return rows.frequency(limit, self, sense, bound) if self.mode else None

    def convex_goal(self, rows: ConvexRows, aim: Any) -> Any:
        return rows.frequency_goal(aim, self)

    def around(self, proof: Proof) -> bool:
        return proof.of_modes(self)


@dataclass(frozen=True, slots=True)
class ModeGap(Form):
    """Least difference between neighbouring undamped natural frequencies [rad/s]."""

    no_bounds = "is a gap between natural frequencies, whose bounds do not bound their difference closely"
    not_convex = "is a gap between natural frequencies, which is not convex in the stiffnesses"
    rough = "is the least gap between neighbouring natural frequencies, which has a kink where two gaps are equal"

    def acting(self, model: Model) -> FloatArray:
        return of_modes(model)

    def watched(self, ends: tuple[float, ...]) -> list[float]:
        return list(ends)

    def room(self, model: Model, x: FloatArray, value: float, other: float, rounding: float) -> float:
        return float(ROOTS * natural_frequencies(model, model.values(x))[-1])

    def said(self, model: Model, order: IntArray) -> tuple[Any, ...]:
        return ()

    def value(self, model: Model, x: FloatArray) -> float:
        return float(np.diff(natural_frequencies(model, model.values(x))).min(initial=np.inf))


@dataclass(frozen=True, slots=True)
class EnergyShare(Form):
    """Part of the kinetic energy that a mode has in one motion of one body: (r . phi) (r . B phi) / (phi . M phi).

    The greatest over all modes; modes of one frequency count together.  row (n_coords,); B is the inertia of `body`.
    """

    row: FloatArray
    body: str
    no_bounds = "is a share of the energy of a mode: shapes have no bounds on boxes of designs"
    not_convex = "is a share of the energy of a mode, which is not convex in the stiffnesses"
    rough = "is the greatest share of several modes, which jumps where modes change places"

    def acting(self, model: Model) -> FloatArray:
        return of_modes(model)

    def value(self, model: Model, x: FloatArray) -> float:
        n, p = model.n_free, model.values(x)
        omega, shapes = mode_shapes(model, p)
        moved = self.row[:n] @ shapes
        own = np.array([term.owner == self.body for term in model.terms])
        pushed = self.row[:n] @ model.matrix(INERTIA, np.where(own, p, 0.0))[:n, :n] @ shapes
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
    no_bounds = "is a ratio of motions in a mode: shapes have no bounds on boxes of designs"
    not_convex = "is a ratio of motions in a mode, which is not convex in the stiffnesses"
    rough = "is a ratio of motions in a mode, which has no end where the second one stands still"

    def room(self, model: Model, x: FloatArray, value: float, other: float, rounding: float) -> float:
        return ROOTS * (1.0 + abs(value * other))

    def value(self, model: Model, x: FloatArray) -> float:
        n = model.n_free
        return shape_ratio(*mode_shapes(model, model.values(x)), self.mode, self.of[:n], self.to[:n])


def of_modes(model: Model) -> FloatArray:
    """Exponents of springs and masses, (n, n_vars): dampers do not matter to what is undamped."""
    return model.exponents[np.isin(model.kinds, (STIFFNESS, INERTIA))]


def frequencies_on(model: Model, low: FloatArray, high: FloatArray, index: int) -> Bounds:
    """Bounds of one natural frequency (0 is the lowest) on boxes (n_boxes, n_vars), each (n_boxes,)."""
    small, large = model.extent(low, high)
    return _frequency(model, small, large, index), _frequency(model, large, small, index)


def _frequency(model: Model, springs: FloatArray, masses: FloatArray, index: int) -> FloatArray:
    n = model.n_free
    vectors = model.vectors[:, :n]
    stiff = np.einsum("bt,ti,tj->bij", springs * (model.kinds == STIFFNESS), vectors, vectors)
    mass = np.einsum("bt,ti,tj->bij", masses * (model.kinds == INERTIA), vectors, vectors)
    if n == 1:
        only: FloatArray = np.sqrt(stiff[:, 0, 0] / mass[:, 0, 0])
        return only
    return undamped(mass, stiff)[:, index]


def frequency_senses(model: Model) -> FloatArray:
    """Sense in which each term moves the natural frequencies with each variable, shape (n_terms, n_vars)."""
    sense = np.where(model.kinds == STIFFNESS, 1.0, np.where(model.kinds == INERTIA, -1.0, 0.0))
    senses: FloatArray = (sense * np.sign(model.scales))[:, None] * model.exponents
    return senses


def _together(omega: FloatArray) -> list[list[int]]:
    """Indices of modes, those of one frequency as one group; omega ascending."""
    groups: list[list[int]] = []
    for index, one in enumerate(omega):
        if groups and one - omega[groups[-1][-1]] <= TOGETHER * one:
            groups[-1].append(index)
        else:
            groups.append([index])
    return groups
