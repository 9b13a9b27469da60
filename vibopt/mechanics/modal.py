"""Many coordinates at many frequencies: the response through complex modes, once per design.

A direct solution costs n^3 per frequency; through the modes it costs n^2.  The decomposition is
tried on direct solutions before it is believed, because nearly defective modes lose digits.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray
from vibopt.records import cached_property, dataclass

WORTH = 6
"""Number of coordinates from which the modes are worth their cost."""
_TRUST = 1e-8
_NEAREST, _BEYOND, _STEPS, _AROUND = 2, 4.0, 2, 0.1
_ABOVE, _SERIES = 10.0, 8
"""Modes that are unknowns of their own, how far beyond the top modes are counted as such, and the polish of poles."""
_NONE, _STILL = 1e-300, 1e-12


@dataclass(frozen=True, slots=True)
class Modal:
    """(-w^2 M + i w C + K)^-1 = shapes diag(1 / (i w - rates)) weights.

    rates (2n,), shapes (n, 2n), weights (2n, n).
    """

    rates: ComplexArray
    shapes: ComplexArray
    weights: ComplexArray

    @property
    def poles(self) -> ComplexArray:
        """Complex frequencies of free motion [rad/s], time factor e^{i w t}; shape (2n,)."""
        return -1j * self.rates

    def amplitudes(self, load: ComplexArray, omega: FloatArray) -> ComplexArray:
        """Of each mode (..., 2n) under what `weights` take of a load (..., 2n) at omega (...) [rad/s]; inf at one."""
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            return np.asarray(load / (1j * omega[..., None] - self.rates))

    def seen(self, lines: FloatArray, load: ComplexArray, omega: FloatArray) -> ComplexArray:
        """What lines (m, n) read of the motion under loads (..., n) at omega (...) [rad/s], (..., m)."""
        return np.asarray(self.amplitudes(load @ self.weights.T, omega) @ (lines @ self.shapes).T)

    def motion(self, load: ComplexArray, omega: FloatArray) -> ComplexArray:
        """Displacements (..., n) under loads (..., n) at omega (...) [rad/s]; inf at an undamped mode."""
        return np.asarray(self.amplitudes(load @ self.weights.T, omega) @ self.shapes.T)


@dataclass(frozen=True)
class Undamped:
    """The same inverse by the modes without damping, coupled by a few dampers.

    squares
        1 / w^2 of each mode, (n,).
    shapes
        Motions of potential energy 1/2, (n, n).
    dampers
        What each damper feels of each mode, times the root of its size, (n, r).
    viscous
        Whether each grows with the frequency, (r,).
    top
        Highest frequency that is looked at [rad/s].
    """

    squares: FloatArray
    shapes: FloatArray
    dampers: FloatArray
    viscous: BoolArray
    top: float

    def amplitudes(self, load: ComplexArray, omega: ComplexArray | FloatArray) -> ComplexArray:
        """As those of `Modal`, of loads (n, n_modes) at frequencies (n,)."""
        many = len(self.viscous)
        felt, passed = np.zeros((len(omega), many)), np.zeros((len(omega), many, many))
        return self._coupled(np.ones(len(self.squares), dtype=bool), load, omega, felt, passed)[0]

    def _coupled(
        self, low: BoolArray, load: ComplexArray, omega: Any, felt: Any, passed: Any
    ) -> tuple[ComplexArray, ComplexArray]:
        """Amplitudes of the modes `low` (n, n_low) under loads (n, n_low), and forces of the dampers (n, r).

        Of other modes dampers feel (n, r) by the load, and (n, r, r) by their own forces.  Modes near omega (n,) are
        unknowns beside the dampers, so that nothing cancels.
        """
        dampers, factor = self.dampers[low], np.where(self.viscous, 1j * omega[:, None], 1j)
        left = 1.0 - omega[:, None] ** 2 * self.squares[low]
        count, rows = min(_NEAREST, left.shape[1]), np.arange(len(omega))[:, None]
        near = np.argpartition(np.abs(left), count - 1, axis=1)[:, :count]
        here, beside = left[rows, near], dampers[near]
        left[rows, near] = np.inf
        taken = load / left
        size = count + len(self.viscous)
        matrix = np.zeros((len(omega), size, size), dtype=complex)
        matrix[:, range(count), range(count)] = np.where(here == 0.0, _NONE, here)
        matrix[:, :count, count:] = beside * factor[:, None, :]
        matrix[:, count:, :count] = -np.swapaxes(beside, 1, 2)
        own = passed + (dampers.T / left[:, None, :]) @ dampers
        matrix[:, count:, count:] = np.eye(len(self.viscous)) + own * factor[:, None, :]
        right = np.concatenate([load[rows, near], felt + taken @ dampers], axis=1)
        try:
            solved = np.linalg.solve(matrix, right[..., None])[..., 0]
        except np.linalg.LinAlgError:  # just at a mode
            return self._coupled(low, load, omega * (1.0 + 2.0 * np.finfo(float).eps), felt, passed)
        forces = factor * solved[:, count:]
        found = taken - (forces @ dampers.T) / left
        found[rows, near] = solved[:, :count]
        return found, forces

    def seen(self, lines: FloatArray, load: ComplexArray, omega: FloatArray) -> ComplexArray:
        """What lines (m, n) read of the motion under loads (n,) or (..., n) at omega (...) [rad/s], (..., m).

        Modes far above follow like springs and their inertia: a short series in the square of the frequency.
        """
        reads, pushed = lines @ self.shapes, np.asarray(load @ self.shapes)
        speeds, r = np.ravel(omega), len(self.viscous)
        alone = pushed.size == len(self.squares)
        low = np.abs(self.squares) * (_ABOVE * self.top) ** 2 >= 1.0
        if low.sum() < _NEAREST or not alone or speeds.max(initial=0.0) > 1.1 * self.top:
            low[:] = True
        pushed = pushed.reshape(-1) if alone else np.broadcast_to(pushed, (*np.shape(omega), len(low)))
        above, rest = self.dampers[~low], pushed[..., ~low] if alone else np.zeros(0)
        powers = np.vander(self.squares[~low], _SERIES, increasing=True).T
        moments = (np.vstack([above.T, reads[:, ~low]])[:, None] * powers) @ np.column_stack([above, rest])
        both = np.tensordot(np.vander(speeds**2, _SERIES, increasing=True), moments, axes=(1, 1))
        load_low = np.broadcast_to(pushed[..., low].reshape(-1, int(low.sum())), (len(speeds), int(low.sum())))
        found, forces = self._coupled(low, load_low, speeds, both[:, :r, r], both[:, :r, :r])
        value = found @ reads[:, low].T + both[:, r:, r] - (both[:, r:, :r] @ forces[..., None])[..., 0]
        return np.asarray(value.reshape(*np.shape(omega), len(lines)))

    @cached_property
    def poles(self) -> ComplexArray:
        """Complex frequencies of free motion up to some times `top` [rad/s], exact to the last digits up to it.

        Modes above follow like springs at first; steps of inverse iteration make up for that.
        """
        low = np.abs(self.squares) * (_BEYOND * self.top) ** 2 >= 1.0
        low[np.argsort(-np.abs(self.squares))[:_NEAREST]] = True
        unit = 1.0 / float(np.sqrt(np.abs(self.squares).max()))
        squares, felt = self.squares * unit**2, self.dampers * np.where(self.viscous, np.sqrt(unit), 1.0)
        m, r, near, rest = int(low.sum()), felt.shape[1], felt[low], felt[~low].T @ felt[~low]
        still = np.where(self.viscous, 0.0, 1j) if not self.viscous.all() else np.zeros(r)
        # q + s^2 mu q + (s or i) B g = 0 and v = s q of the low ones, B^T q - g = (s or i) F g of the others
        left, right = np.eye(2 * m + r, dtype=still.dtype), np.zeros((2 * m + r, 2 * m + r))
        left[:m, 2 * m :], left[2 * m :, :m] = near * still, near.T
        left[2 * m :, 2 * m :] = -np.eye(r) - rest * still
        right[:m, m : 2 * m], right[m : 2 * m, :m] = -np.diag(squares[low]), np.eye(m)
        right[:m, 2 * m :], right[2 * m :, 2 * m :] = -near * self.viscous, rest * self.viscous
        periods, vectors = np.linalg.eig(np.linalg.solve(left, right))
        real = np.abs(periods) > _STILL * np.abs(periods).max()
        found = -1j * unit / periods[real]
        motion = np.zeros((len(found), len(squares)), dtype=complex)
        motion[:, low] = vectors[:m, real].T
        inside = np.abs(found) <= 2.0 * self.top
        found[inside] = self._polished(found[inside], motion[inside])
        return np.asarray(found, dtype=complex)

    def _polished(self, omega: ComplexArray, motion: ComplexArray) -> ComplexArray:
        """Poles near omega (k,) by inverse iteration from motions (k, n)."""
        for _ in range(_STEPS):
            motion = self.amplitudes(motion, omega)
            motion = motion / np.abs(motion).max(axis=1, keepdims=True)
            felt = (motion @ self.dampers) ** 2
            a = (motion**2).sum(axis=1) + 1j * felt @ ~self.viscous
            b, c = 1j * felt @ self.viscous, -(motion**2) @ self.squares
            with np.errstate(divide="ignore", invalid="ignore"):
                root = np.sqrt(b * b - 4.0 * a * c)
                both = np.stack([(-b + root) / (2.0 * c), (-b - root) / (2.0 * c)])
                nearest = np.take_along_axis(both, np.abs(both - omega).argmin(axis=0)[None], axis=0)[0]
            omega = np.where(np.abs(nearest - omega) <= _AROUND * np.abs(omega), nearest, omega)
        return np.asarray(omega, dtype=complex)


def undamped(
    squares: FloatArray, shapes: FloatArray, vectors: FloatArray, sizes: FloatArray, viscous: BoolArray, top: float
) -> Undamped | None:
    """The modes of what few dampers of sizes (r,) along `vectors` (r, n) hold back; None where they are many."""
    if len(sizes) > len(squares) // 3 or (sizes < 0.0).any():
        return None
    return Undamped(squares, shapes, shapes.T @ (vectors.T * np.sqrt(sizes)), viscous, top)


def decompose(mass: FloatArray, damping: FloatArray, stiffness: ComplexArray) -> Modal | None:
    """Complex modes of M, C, K (n, n), K complex with structural damping; None where they cannot be trusted."""
    n = len(mass)
    if not mass.any(axis=1).all():  # a joint without mass
        return None
    full, c = np.linalg.solve(mass, stiffness), np.linalg.solve(mass, damping)
    scale = float(np.sqrt(np.abs(full).max()) + np.abs(c).max()) or 1.0
    k = full if full.imag.any() else full.real
    state = np.zeros((2 * n, 2 * n), dtype=k.dtype)
    state[:n, n:] = np.eye(n)
    state[n:, :n] = -k / scale**2
    state[n:, n:] = -c / scale
    try:
        rates, vectors = np.linalg.eig(state)
        inverse = np.linalg.inv(vectors)
    except np.linalg.LinAlgError:
        return None
    weights = np.linalg.solve(mass.T, inverse[:, n:].T).T / scale
    found = Modal((rates * scale).astype(complex), vectors[:n].astype(complex), weights.astype(complex))
    return found if _trusted(found, mass, damping, stiffness) else None


def _trusted(modal: Modal, mass: FloatArray, damping: FloatArray, stiffness: ComplexArray) -> bool:
    """Compare with direct solutions between and beside the modes."""
    turning = np.sort(np.abs(modal.rates.imag))
    picks = turning[:: max(len(turning) // 6, 1)]
    omega = np.concatenate([0.97 * picks, 1.003 * picks, [0.5 * turning[-1]]])
    dynamic = stiffness - omega[:, None, None] ** 2 * mass + 1j * omega[:, None, None] * damping
    load = np.linspace(1.0, 2.0, len(mass)).astype(complex) * np.diag(mass)
    try:
        direct = np.linalg.solve(dynamic, np.broadcast_to(load[:, None], (len(omega), len(mass), 1)))[..., 0]
    except np.linalg.LinAlgError:  # rigid motion, or an undamped mode just there
        return False
    through = modal.motion(np.broadcast_to(load, direct.shape), omega)
    error = np.abs(through - direct).max(axis=1) / np.abs(direct).max(axis=1)
    return bool(np.all(error <= _TRUST))
