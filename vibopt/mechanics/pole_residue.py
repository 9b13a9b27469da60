"""One harmonic of a response as a sum over its poles, h(w) = sum_j r_j / (w - p_j) + c0 + c1 w, at any design.

The residue is what the row reads of a mode's shape times what the load gives to it, both taken at the pole itself
where forces of dampers make them depend on the frequency.
"""

from __future__ import annotations

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.mechanics.model import DAMPING, HYSTERETIC, INERTIA, STIFFNESS, Model
from vibopt.mechanics.oscillator import Modes, Oscillator, oscillator_of
from vibopt.mechanics.polynomials import Fractions
from vibopt.records import cached_property, dataclass
from vibopt.signals import Amplitude, Line, Output

_KEPT = 64


@dataclass(frozen=True, slots=True)
class Ends:
    """Load, row and what goes from the base straight into the reading, each a + s b, at one design and on q.

    load, row
        Shape (2, n): constant and factor of s.
    constant, growth
        Direct part and its factor of s.
    """

    load: ComplexArray
    row: ComplexArray
    constant: complex
    growth: complex


@dataclass(frozen=True, eq=False)
class Reading:
    """One line of a response to unit amplitude on a model, prepared for many designs.

    fixed
        Shape (4 n + 2,): load and its factor of s, row and its factor of s, on the free coordinates, and the direct
        part and its factor of s, as far as no term has a part in them.
    table
        The same per coefficient of each term, shape (n_terms, 4 n + 2); None where there is nothing.
    power
        Power of i w.
    """

    model: Model
    oscillator: Oscillator
    fixed: ComplexArray
    table: ComplexArray | None
    power: int
    order: float
    amplitude: Amplitude

    @classmethod
    def of(cls, model: Model, output: Output, line: Line, p: FloatArray) -> Reading | None:
        """None where masses act on bases or are read, which makes the load or the row quadratic."""
        n, kinds = model.n_free, model.kinds
        rows, moved = model.vectors[:, :n], model.vectors[:, n:] @ line.vector[n:]
        heavy = kinds == INERTIA
        if output.power < 0 or moved[heavy].any() or output.signs[heavy].any():
            return None
        prepared = oscillator_of(model, p)
        if prepared is None:
            return None
        unit, zero = prepared.unit, np.zeros(n)
        direct = [output.row[n:] @ line.vector[n:], 0.0]
        fixed = np.concatenate([line.vector[:n] / unit**2, zero, output.row[:n], zero, direct]).astype(complex)
        table: ComplexArray | None = None
        if moved.any() or output.signs.any():
            still = np.where(kinds == STIFFNESS, 1.0, np.where(kinds == HYSTERETIC, 1j, 0.0))
            turned = np.where(kinds == DAMPING, unit, 0.0)
            parts: list[ComplexArray | FloatArray] = []
            for factor in (still, turned):
                parts.append(-(factor * moved)[:, None] * rows / unit**2)
            for factor in (still, turned):
                parts.append((factor * output.signs)[:, None] * rows)
            for factor in (still, turned):
                parts.append((factor * output.signs * moved)[:, None])
            table = np.concatenate(parts, axis=1).astype(complex)
        return cls(model, prepared, fixed, table, output.power, line.order, line.amplitude)

    def size(self, speed: FloatArray) -> FloatArray:
        """What |h| is multiplied by at speeds (n,) [rad/s], shape (n,)."""
        found: FloatArray = np.abs(self.amplitude.at(speed)) * (self.order * speed) ** self.power
        return found

    def ends(self, modes: Modes) -> Ends:
        """Load, row and direct part at one design."""
        if self.always is not None:
            return self.always
        return self._on(self.fixed if self.table is None else self.fixed + modes.p @ self.table, modes.root)

    @cached_property
    def always(self) -> Ends | None:
        """Load, row and direct part where they are the same at every design."""
        root = self.oscillator.root
        return None if root is None or self.table is not None else self._on(self.fixed, root)

    def _on(self, made: ComplexArray, root: FloatArray) -> Ends:
        n = self.model.n_free
        both = made[: 4 * n].reshape(4, n) @ root.T
        return Ends(both[:2], both[2:], complex(made[4 * n]), complex(made[4 * n + 1]))

    def fractions(self, modes: Modes, ends: Ends) -> Fractions | None:
        """The response against the frequency in units; None at a mode of frequency zero or a singular basis."""
        n = self.model.n_free
        constant, growth = ends.constant, 1j * ends.growth
        rates, vectors = modes.spectrum
        if modes.damping is None:
            loaded = np.linalg.solve(vectors, ends.load[0])
            root = np.sqrt(rates + 0j)
            if (np.abs(root) < 1e-6 * np.abs(root).max()).any():
                return None
            half = 0.5 * (ends.row[0] @ vectors) * loaded / root
            return _sum(np.concatenate([root, -root]), np.concatenate([-half, half]), constant, growth)
        shapes = vectors[:n]
        if self.table is None:
            only = np.zeros(2 * n, dtype=complex)
            only[n:] = ends.load[0]
            loaded, read = np.linalg.solve(vectors, only), ends.row[0] @ shapes
        else:
            load = np.zeros((2 * n, 2), dtype=complex)
            load[n:] = ends.load.T
            both, rows = np.linalg.solve(vectors, load), ends.row @ shapes
            loaded, read = both[:, 0] + rates * both[:, 1], rows[0] + rates * rows[1]
            constant = constant + complex(ends.row[1] @ ends.load[1])
        return _sum(-1j * np.asarray(rates, dtype=complex), -1j * read * loaded, constant, growth)

    def direct(self, modes: Modes, ends: Ends, v: FloatArray) -> ComplexArray:
        """The response at frequencies v (n,) in units, each by a direct solution; shape (n,).

        Raises
        ------
        numpy.linalg.LinAlgError
            A frequency is an undamped resonance.
        """
        n, s = self.model.n_free, 1j * v
        if modes.damping is None:
            stiff = np.empty((len(v), n, n), dtype=complex)
            stiff[:] = modes.stiffness
        else:
            stiff = s[:, None, None] * modes.damping
            stiff += modes.stiffness
        stiff.reshape(len(v), n * n)[:, :: n + 1] -= (v * v)[:, None]
        size: FloatArray | float = 1.0
        if not modes.stiffness.diagonal().all():  # what no spring holds: its small row would be lost under a great one
            size = np.abs(stiff).max(axis=2, keepdims=True)
            stiff /= size
        if self.table is None:
            moved = np.linalg.solve(stiff, ends.load[0][:, None] / size)[:, :, 0]
            return np.asarray(moved @ ends.row[0] + ends.constant, dtype=complex)
        load = ends.load[0] + s[:, None] * ends.load[1]
        row = ends.row[0] + s[:, None] * ends.row[1]
        moved = np.linalg.solve(stiff, load[:, :, None] / size)[:, :, 0]
        return np.asarray((row * moved).sum(axis=1) + ends.constant + s * ends.growth, dtype=complex)


def _sum(poles: ComplexArray, residues: ComplexArray, constant: complex, growth: complex) -> Fractions:
    return Fractions(poles, residues, np.abs(residues), constant, growth)


_known: dict[tuple[int, int, int], tuple[Model, Output, Line, Reading | None]] = {}


def reading_of(model: Model, output: Output, line: Line, x: FloatArray) -> Reading | None:
    """A line of a response prepared once, at first for a design x (n_vars,)."""
    key = (id(model), id(output), id(line))
    if key not in _known:
        while len(_known) >= _KEPT:
            _known.pop(next(iter(_known)), None)
        _known[key] = (model, output, line, Reading.of(model, output, line, model.values(x)))
    return _known[key][3]
