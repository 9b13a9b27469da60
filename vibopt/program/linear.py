"""A response in the neighbourhood of a machine: its value and slopes, and a rest that a Neumann series bounds.

With D = D0 + sum_g s_g D_g the response R = d + c D^-1 f moves by what its slopes say, and by a rest that follows from
|e| <= (I - P)^-1 q with P = sum_g |s_g| |D0^-1 D_g|.  Groups g of terms go with one product of factors and one power
of the frequency, so a machine of many mounts has few.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import Any

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from vibopt.forms import Modulus
from vibopt.forms.sags import UnderWeights
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.harmonic import bordered
from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS, Model, factors
from vibopt.mechanics.modes import mode_shapes
from vibopt.program.boxes import Boxes, Scalar, powers_on
from vibopt.records import dataclass
from vibopt.signals import Line

_POWERS = {INERTIA: 2, DAMPING: 1}
_ROUNDING = 1e-13
"""Part by which coefficients may be off, so that no box around a singular machine is too narrow to count."""
Array = FloatArray | ComplexArray


@dataclass(frozen=True)
class Linear:
    """One line of a response, or a static one, by groups of terms; in the modes of the machine as said.

    exponents, powers
        Of factors and of the speed, per group: (n_groups, n_factors), (n_groups,).
    blocks
        [D_g f_g; -c_g d_g] of each group, and behind them of what is in none: (n_groups + 1, n + 1, n + 1); real where
        nothing moves, as under the weights, which takes a third of the time.
    """

    exponents: FloatArray
    powers: IntArray
    blocks: Array

    @classmethod
    def of_line(cls, model: Model, form: Modulus, line: Line) -> Linear:
        """A line of a harmonic response at an amplitude of one; the speed is that of its excitation."""
        size = model.scales * factors(model.kinds, np.array(line.order))
        nothing = bordered(model, np.zeros(len(size), dtype=complex), form.output, line.vector)[1]

        def block(chosen: IntArray) -> ComplexArray:
            z = np.zeros(len(size), dtype=complex)
            z[chosen] = size[chosen]
            found: ComplexArray = bordered(model, z, form.output, line.vector)[1] - nothing
            return found

        powers = np.array([_POWERS.get(kind, 0) for kind in model.kinds.tolist()])
        return cls._of_groups(model, powers, block, nothing)

    @classmethod
    def of_weights(cls, model: Model, form: UnderWeights) -> Linear:
        """What springs do under the weights alone."""
        n, size = model.n_free, model.static_scales
        signs, row_read = form.reading(model)
        nothing = np.zeros((n + 1, n + 1), dtype=complex)
        nothing[n, :n] = -row_read[:n]

        def block(chosen: IntArray) -> ComplexArray:
            found, row = np.zeros((n + 1, n + 1), dtype=complex), model.vectors[chosen, :n]
            stiff, heavy = (np.where(model.kinds == kind, size, 0.0)[chosen] for kind in (STIFFNESS, INERTIA))
            found[:n, :n] = (row.T * stiff) @ row
            found[n, :n] = -(signs[chosen] * stiff) @ row
            found[:n, n] = GRAVITY * heavy @ row
            return found

        return cls._of_groups(model, np.zeros(len(size), dtype=int), block, nothing)

    @classmethod
    def of_modes(cls, model: Model) -> Linear:
        """K - w^2 M alone, without any response: where its series converges no natural frequency is w."""
        n = model.n_free
        size = model.scales * factors(model.kinds, np.array(1.0)).real

        def block(chosen: IntArray) -> ComplexArray:
            own = chosen[np.isin(model.kinds[chosen], (INERTIA, STIFFNESS))]
            found = np.zeros((n + 1, n + 1), dtype=complex)
            found[:n, :n] = (model.vectors[own, :n].T * size[own]) @ model.vectors[own, :n]
            return found

        powers = np.array([_POWERS.get(kind, 0) for kind in model.kinds.tolist()])
        return cls._of_groups(model, powers, block, np.zeros((n + 1, n + 1), dtype=complex))

    @classmethod
    def _of_groups(
        cls, model: Model, powers: IntArray, block: Callable[[IntArray], ComplexArray], nothing: ComplexArray
    ) -> Linear:
        keys = np.column_stack([model.exponents, powers])
        table, which = np.unique(keys, axis=0, return_inverse=True)
        blocks = [block(np.flatnonzero(which.ravel() == g)) for g in range(len(table))]
        n = model.n_free
        change = np.eye(n + 1)
        p = model.values(np.ones(model.n_vars))
        held = (
            model.matrix(STIFFNESS, p)[:n, :n].any(axis=0).all()
        )  # else rigid motion, which stands by itself as it is
        if held and not model.spins:  # a whirl has fewer modes than freedoms, where polar inertia outweighs the other
            with contextlib.suppress(np.linalg.LinAlgError):
                change[:n, :n] = mode_shapes(model, p)[1]
        whole = change.T @ np.array([*blocks, nothing], dtype=complex) @ change
        return cls(table[:, :-1], table[:, -1].astype(int), whole if whole.imag.any() else whole.real)

    def on(self, boxes: Boxes) -> tuple[Scalar, FloatArray]:
        """The response on boxes, and what each axis adds to its uncertainty (n_boxes, n_axes)."""
        sizes, half = powers_on(boxes, self.exponents, self.powers), boxes.half
        sizes = sizes._replace(rest=sizes.rest + _ROUNDING * np.abs(sizes.at))
        return self._moved(*sizes, sizes.spread(half[:, None, :]), half)

    def _moved(
        self, at: FloatArray, slope: FloatArray, rest: FloatArray, far: FloatArray, half: FloatArray
    ) -> tuple[Scalar, FloatArray]:
        """`on` from the coefficients of the groups.

        at, rest, far (n_boxes, n_groups), slope (n_boxes, n_groups, n_axes), half (n_boxes, n_axes).
        """
        own, n = self.blocks[:-1], self.blocks.shape[-1] - 1
        boxes, many = at.shape
        here = (at @ own.reshape(many, -1)).reshape(boxes, n + 1, n + 1) + self.blocks[-1]
        inner, load, row, plain = own[:, :n, :n], own[:, :n, n], -own[:, n, :n], own[:, n, n]
        beside = inner.transpose(1, 0, 2).reshape(n, many * n)  # D_g beside each other: one product for all of them
        inverse = _inverse(here[:, :n, :n])
        u = (inverse @ here[:, :n, n, None])[..., 0]
        y = (-here[:, n, None, :n] @ inverse)[:, 0]
        push = load - (inner.reshape(many * n, n) @ u.T).reshape(many, n, boxes).transpose(2, 0, 1)
        first = push @ inverse.transpose(0, 2, 1)
        read = row - (y @ beside).reshape(boxes, many, n)
        each = plain + u @ row.T + (push @ y[:, :, None])[..., 0]
        shift = np.abs(inverse.reshape(-1, n) @ beside).reshape(boxes, n, many, n)
        P = (far[:, None, None, :] @ shift)[:, :, 0]
        q = (far[:, None, :] @ np.abs(first))[:, 0]
        E = _bounded(P, q)
        twice, heard = np.abs(read @ first.transpose(0, 2, 1)), np.abs(read)
        loose = (heard @ (P @ E[..., None]))[..., 0]
        second = (far * ((twice @ far[..., None])[..., 0] + loose)).sum(axis=1)
        value = here[:, n, n] - (here[:, n, :n] * u).sum(axis=1)
        tilt = (each[:, None, :] @ slope)[:, 0]
        lost: BoolArray = ~np.all(np.isfinite(E), axis=1)
        weight = (heard @ np.where(lost[:, None], 0.0, E)[..., None])[..., 0]
        weight[lost] = shift[lost].sum(axis=3).max(axis=1)
        share = (weight[:, None, :] @ np.abs(slope))[:, 0] * half
        return Scalar(value, tilt, (rest * np.abs(each)).sum(axis=1) + second), share


def _inverse(stiff: Array) -> Any:
    """Inverses; of what has none, NaN."""
    try:
        return np.linalg.inv(stiff)
    except np.linalg.LinAlgError:
        return np.array([_inverse_of(one) for one in stiff])


def _inverse_of(stiff: Array) -> Any:
    try:
        return np.linalg.inv(stiff)
    except np.linalg.LinAlgError:
        return np.full_like(stiff, np.nan)


def _bounded(P: FloatArray, q: FloatArray) -> FloatArray:
    """(I - P)^-1 q for P without negative entries, (n_boxes, n); infinite where the series does not converge.

    A positive vector that I - P maps to a positive one proves that it does.
    """
    n = q.shape[1]
    room = q + 1e-12 * q.max(axis=1, keepdims=True, initial=0.0) + 1e-300
    matrix = np.eye(n) - P
    bad: BoolArray = ~np.all(np.isfinite(matrix), axis=(1, 2))
    matrix[bad] = np.eye(n)
    try:
        E = np.linalg.solve(matrix, room[..., None])[..., 0]
    except np.linalg.LinAlgError:
        return np.full_like(q, np.inf)
    lost: BoolArray = bad | ~np.all(E > 0.0, axis=1)
    found: FloatArray = np.where(lost[:, None], np.inf, E)
    return found
