"""Bearings that are not alike in both planes, for the model: what they do to a forward and to a backward whirl.

A place moves by y + i z = F e^{i w t} + conj(B e^{i w t}), z being a quarter turn ahead of y in the sense of the spin.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.mechanics.monomial import Monomial
from vibopt.records import dataclass

COEFFICIENTS = ("k_yy", "k_yz", "k_zy", "k_zz", "c_yy", "c_yz", "c_zy", "c_zz")
"""Force along the first letter, against it, per displacement or velocity along the second [N/m] and [N s/m]."""


@dataclass(frozen=True, slots=True)
class Bearing:
    """Eight coefficients of one stretch.

    row
        Second end less first, (n_coords,).
    powers
        The coefficients, each a product of powers of the variables; none of a table.
    speeds, table
        Spins, ascending, (n,) [rad/s], and the coefficients there (n, 8), straight between them; else empty.
    """

    name: str
    row: FloatArray
    powers: tuple[Monomial, ...]
    speeds: FloatArray
    table: FloatArray

    def coefficients(self, x: FloatArray, spin: FloatArray) -> FloatArray:
        """At a design (n_vars,) and spins (...) [rad/s], (..., 8)."""
        if self.powers:
            found = [one.scale * np.prod([x[i] ** power for i, power in one.exponents.items()]) for one in self.powers]
            return np.broadcast_to(np.array(found), (*np.shape(spin), 8))
        left = np.clip(np.searchsorted(self.speeds, spin) - 1, 0, len(self.speeds) - 2)
        part = (spin - self.speeds[left]) / (self.speeds[left + 1] - self.speeds[left])
        return np.asarray(self.table[left] + part[..., None] * (self.table[left + 1] - self.table[left]))

    def whirling(self, x: FloatArray, spin: FloatArray) -> tuple[ComplexArray, ComplexArray]:
        """Stiffness and damping against forward and backward whirl, each (..., 2, 2), as the motion (F, B) feels it."""
        eight = self.coefficients(x, spin)
        return whirling(eight[..., :4]), whirling(eight[..., 4:])

    @property
    def undamped(self) -> Bearing:
        """Its springs alone, of one without a table."""
        return replace(self, powers=(*self.powers[:4], *(Monomial(0.0) for _ in self.powers[4:])))

    def changed(self, change: Callable[[Monomial], Monomial]) -> Bearing:
        """The same in other variables."""
        return replace(self, powers=tuple(map(change, self.powers)))


def whirling(four: FloatArray) -> ComplexArray:
    """yy, yz, zy, zz (..., 4) over forward and backward whirl (..., 2, 2): F = (Y + i Z) / 2, B = (Y - i Z) / 2."""
    yy, yz, zy, zz = np.moveaxis(four, -1, 0)
    found = np.empty((*yy.shape, 2, 2), dtype=complex)
    found[..., 0, 0], found[..., 0, 1] = 0.5 * (yy + zz + 1j * (zy - yz)), 0.5 * (yy - zz + 1j * (zy + yz))
    found[..., 1, 0], found[..., 1, 1] = found[..., 0, 1].conj(), found[..., 0, 0].conj()
    return found
