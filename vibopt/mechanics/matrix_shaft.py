"""A whirling shaft by the matrices of both its planes, as another program wrote them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.mechanics.shaft_waves import Disc
from vibopt.records import cached_property, dataclass


@dataclass(frozen=True)
class MatrixShaft:
    """What `WhirlingShaft` is to sections; a whirl is a motion of both planes, z a quarter turn behind or ahead of y.

    both
        M, C, G and K over the plane y, then z, deflection and tilt of each node in turn, (2 n, 2 n) [SI], of
        M u'' + (C + W G) u' + K u at the spin W, from y to z.
    discs, points, lags
        As of `WhirlingShaft`; what lags is its stiffness.
    """

    both: tuple[FloatArray, FloatArray, FloatArray, FloatArray]
    discs: tuple[Disc, ...]
    points: Mapping[str, int]
    lags: float = 0.0
    quick: float = float("inf")

    @property
    def size(self) -> int:
        return len(self.both[0]) // 2

    @property
    def weighs(self) -> float:
        """Its mass and that of its discs [kg]."""
        along = np.concatenate([np.tile([1.0, 0.0], self.size // 2), np.zeros(self.size)])
        return float(along @ self.both[0] @ along) + sum(disc.mass for disc in self.discs)

    def cut(self, omega: float) -> MatrixShaft:
        """Itself: it is as good at every frequency as its matrices are."""
        return self

    @cached_property
    def _whirling(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """M, C, K, and what the frequency times the spin is multiplied by, of motions (u, -i u), each (n, n)."""
        n = self.size
        ways = np.concatenate([np.eye(n), -1j * np.eye(n)])
        resists, drags, joins, holds = self.both
        four = (resists, drags, holds, 1j * joins)
        mass, damping, stiffness, polar = (0.5 * (ways.conj().T @ one @ ways).real for one in four)
        for disc in self.discs:
            at = 2 * disc.node
            mass[at, at] += disc.mass
            mass[at + 1, at + 1] += disc.diametral
            polar[at + 1, at + 1] += disc.polar
        return mass, damping, stiffness, polar

    @property
    def slow(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Stiffness, inertia and polar inertia, each (n, n)."""
        mass, _, stiffness, polar = self._whirling
        return stiffness, mass, polar

    @property
    def drag(self) -> FloatArray:
        """Damping at rest (n, n)."""
        return self._whirling[1]

    def on_nodes(self, moved: ComplexArray, omega: float) -> ComplexArray:
        """As of `WhirlingShaft`."""
        return moved

    def place(self, point: str) -> int:
        """Number of a point's deflection among the coordinates."""
        return 2 * self.points[point]

    def dynamic(
        self, omega: ComplexArray | FloatArray, spin: ComplexArray | FloatArray | None = None, *, braked: bool = False
    ) -> ComplexArray:
        """As of `WhirlingShaft`."""
        mass, damping, stiffness, polar = self._whirling
        at = np.asarray(omega)[:, None, None]
        turned = at if spin is None else np.asarray(spin)[:, None, None]
        stiff = stiffness * (1.0 + 1j * self.lags * (at - turned)) if braked else stiffness
        return np.asarray(stiff + 1j * at * damping - at**2 * mass + at * turned * polar, dtype=complex)
