"""The free coordinates of a model in mass-normalised form, and its modes, prepared once for many designs.

What does not change with the design is multiplied out beforehand: K, C and the structural damping are then one
product of the terms' coefficients with a table.
"""

from __future__ import annotations

from dataclasses import field

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.mechanics.model import DAMPING, HYSTERETIC, INERTIA, STIFFNESS, Model
from vibopt.records import cached_property, dataclass

_WORST_MASS = 1e6
_KEPT = 32


@dataclass(frozen=True, eq=False)
class Modes:
    """One design, frequencies in units of `unit` [rad/s], coordinates q with M = 1.

    p
        Coefficients of the terms, shape (n_terms,).
    root
        From loads to loads on q, shape (n, n): q-loads are root @ loads, rows are root @ rows.
    stiffness, damping
        Of q, shape (n, n); the first complex with structural damping, the second None without dashpots.
    """

    x: bytes
    p: FloatArray
    root: FloatArray
    stiffness: ComplexArray | FloatArray
    damping: FloatArray | None

    @cached_property
    def spectrum(self) -> tuple[ComplexArray | FloatArray, ComplexArray | FloatArray]:
        """Eigenvalues and eigenvectors, of the state matrix (2n,) and (2n, 2n) with dashpots, else of the stiffness.

        Raises
        ------
        numpy.linalg.LinAlgError
            No decomposition was found.
        """
        stiffness, n = self.stiffness, len(self.stiffness)
        if self.damping is None:
            found = np.linalg.eig(stiffness) if np.iscomplexobj(stiffness) else np.linalg.eigh(stiffness)
            return found[0], found[1]
        state = np.zeros((2 * n, 2 * n), dtype=stiffness.dtype)
        state[:n, n:] = _identity(n)
        np.negative(stiffness, out=state[n:, :n])
        np.negative(self.damping, out=state[n:, n:])
        rates, shapes = np.linalg.eig(state)
        return rates, shapes


@dataclass(eq=False)
class Oscillator:
    """A model whose modes are wanted at many designs.

    size
        What each coordinate is multiplied by, shape (n,).
    unit
        Unit of frequency [rad/s].
    table
        Shape (n_terms, 3 n^2): K / unit^2, C / unit and structural damping / unit^2 per coefficient, of q where no
        mass varies, else of the sized coordinates.
    root
        Inverse of the Cholesky factor of the mass times `size`, shape (n, n); None where a mass varies.
    """

    model: Model
    size: FloatArray
    unit: float
    table: FloatArray
    masses: FloatArray
    root: FloatArray | None
    damped: bool
    hysteretic: bool
    last: Modes | None = field(default=None)

    @classmethod
    def of(cls, model: Model, p: FloatArray) -> Oscillator | None:
        """Prepared with the coefficients p (n_terms,) of some design; None where the masses are next to singular."""
        n, kinds, rows = model.n_free, model.kinds, model.vectors[:, : model.n_free]
        diagonal = p[kinds == INERTIA] @ rows[kinds == INERTIA] ** 2
        if not (diagonal > 0.0).all():
            return None
        size = 1.0 / np.sqrt(diagonal)
        rows = rows * size
        heavy = kinds == INERTIA
        masses = (rows[:, :, None] * rows[:, None, :])[heavy].reshape(-1, n * n)
        mass = (p[heavy] @ masses).reshape(n, n)
        if np.linalg.cond(mass) > _WORST_MASS:
            return None
        varies = bool(model.exponents[heavy].any())
        root = None if varies else np.linalg.inv(np.linalg.cholesky(mass))
        if root is not None:
            rows = rows @ root.T
        outer = (rows[:, :, None] * rows[:, None, :]).reshape(-1, n * n)
        springs = (kinds == STIFFNESS) | (kinds == HYSTERETIC)
        unit = float(np.sqrt(np.abs(p[springs] @ outer[springs]).max(initial=0.0)))
        if not 0.0 < unit < np.inf:
            return None
        parts = ((STIFFNESS, unit**2), (DAMPING, unit), (HYSTERETIC, unit**2))
        table = np.concatenate([outer * (kinds == kind)[:, None] / by for kind, by in parts], axis=1)
        hysteretic = bool((kinds == HYSTERETIC).any())
        table = table if hysteretic else np.ascontiguousarray(table[:, : 2 * n * n])
        whole = None if root is None else root * size
        return cls(model, size, unit, table, masses, whole, bool((kinds == DAMPING).any()), hysteretic)

    def modes(self, x: FloatArray) -> Modes:
        """At a design x (n_vars,); the last one is kept.

        Raises
        ------
        numpy.linalg.LinAlgError
            The masses are next to singular.
        """
        key = x.tobytes()
        if self.last is None or self.last.x != key:
            self.last = self._modes(x, key)
        return self.last

    def _modes(self, x: FloatArray, key: bytes) -> Modes:
        model, n = self.model, self.model.n_free
        p = self._coefficients(x)
        made = (p @ self.table).reshape(-1, n, n)
        root = self.root
        if root is None:
            mass = (p[model.kinds == INERTIA] @ self.masses).reshape(n, n)
            root = np.linalg.inv(np.linalg.cholesky(mass))
            if mass.trace() * (root * root).sum() > n * n * _WORST_MASS:
                raise np.linalg.LinAlgError("The mass matrix is next to singular.")
            made = root @ made @ root.T
            root = root * self.size
        stiffness = made[0] + 1j * made[2] if self.hysteretic else made[0]
        return Modes(key, p, root, stiffness, made[1] if self.damped else None)

    def _coefficients(self, x: FloatArray) -> FloatArray:
        """Of the terms, as the model has them; only those that vary cost time."""
        rows, exponents = self._varying
        p = self.model.scales.copy()
        if len(rows):
            p[rows] *= (x**exponents).prod(axis=1)
        return p

    @cached_property
    def _varying(self) -> tuple[IntArray, FloatArray]:
        rows = np.flatnonzero(self.model.exponents.any(axis=1))
        return rows, self.model.exponents[rows]


_ones: dict[int, FloatArray] = {}


def _identity(n: int) -> FloatArray:
    if n not in _ones:
        _ones[n] = np.eye(n)
    return _ones[n]


_known: dict[int, tuple[Model, Oscillator | None]] = {}


def oscillator_of(model: Model, p: FloatArray) -> Oscillator | None:
    """A model prepared once; p (n_terms,) are the coefficients of some design."""
    if id(model) not in _known:
        while len(_known) >= _KEPT:
            _known.pop(next(iter(_known)), None)
        _known[id(model)] = (model, Oscillator.of(model, p))
    return _known[id(model)][1]
