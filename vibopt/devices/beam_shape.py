"""The shape of a beam under a force where it carries, and what goes with it, by formulas of the handbooks.

Lengths are over that of the beam: its far support stands at 1.  A load w(x) on a beam that carries at a moves it by
r(x) = (1 - psi(x)) b + psi(x) d, where b is the motion of its supports, d that of the load and psi its shape, as long
as its own vibration between load and supports is slow.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.records import dataclass

Influence = Callable[[FloatArray], FloatArray]
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)


@dataclass(frozen=True, slots=True)
class Shape:
    """A beam of one kind that carries at `at`, its length being one.

    kind
        As of a `Beam`.
    """

    kind: str
    at: float

    @property
    def end(self) -> float:
        """Where the beam ends."""
        return max(1.0, self.at)

    def deflection(self, x: FloatArray) -> FloatArray:
        """psi at places x (n,): one where it carries."""
        a, c = self.at, 1.0 - self.at
        held: dict[str, Influence] = {
            "cantilever": lambda s: s**2 * (3.0 * a - s),
            "simply_supported": lambda s: c * s * (1.0 - c**2 - s**2),
            "fixed": lambda s: (c * s) ** 2 * (3.0 * a - (1.0 + 2.0 * a) * s),
            "fixed_pinned": lambda s: 1.5 * a * c * (1.0 + c) * s**2 - (1.0 - 0.5 * a**2 * (3.0 - a)) * s**3,
            "overhung": lambda s: -c * s * (s**2 - 1.0) - a * np.maximum(s - 1.0, 0.0) ** 3,
        }
        beyond = np.maximum(x - a, 0.0) ** 3
        return np.asarray((held[self.kind](x) + beyond) / held[self.kind](np.array(a)))

    @property
    def moment(self) -> Influence:
        """Bending moment, per force at a place, where a force at `at` bends it most."""
        a, c = self.at, 1.0 - self.at
        left: Influence = lambda s: s * (1.0 - s) ** 2  # noqa: E731
        right: Influence = lambda s: s**2 * (1.0 - s)  # noqa: E731
        root: Influence = lambda s: 0.5 * s * (1.0 - s) * (2.0 - s)  # noqa: E731
        under: Influence = lambda s: 0.5 * s**2 * (3.0 - s) * c - np.maximum(s - a, 0.0)  # noqa: E731
        here = np.array(a)
        tables: dict[str, Influence] = {
            "cantilever": lambda s: s,
            "simply_supported": lambda s: np.minimum(s * c, a * (1.0 - s)),
            "fixed": left if c >= a else right,
            "fixed_pinned": root if root(here) >= under(here) else under,
            "overhung": lambda s: np.maximum(s - 1.0, 0.0),
        }
        return tables[self.kind]

    def reaction(self, right: bool) -> Influence:
        """Force on one support per force at a place."""
        tables: dict[str, Influence] = {
            "cantilever": lambda s: 0.0 * s,
            "simply_supported": lambda s: s,
            "fixed": lambda s: s**2 * (3.0 - 2.0 * s),
            "fixed_pinned": lambda s: 0.5 * s**2 * (3.0 - s),
            "overhung": lambda s: s,
        }
        of = tables[self.kind]
        return of if right else lambda s: 1.0 - of(s)

    def readings(self, heavy: bool) -> dict[str, Influence]:
        """What is read of it by words, the stress where it must be `heavy` for it."""
        supports = {"left": self.reaction(right=False), "right": self.reaction(right=True)}
        return {**supports, "stress": self.moment} if heavy else supports

    @property
    def means(self) -> tuple[float, float]:
        """Of psi and of its square over the beam."""
        return self._mean(self.deflection), self._mean(lambda s: self.deflection(s) ** 2)

    def read(self, influence: Influence) -> tuple[float, float, float]:
        """What a force at the load does, and what loads m a / end do: one, and psi, on a beam held where it carries.

        Times the force that bends the massless beam as far, and its mass times the accelerations of b and d - b.
        """
        point = float(influence(np.array(self.at)))
        alone = self._mean(lambda s: influence(s) - point * self.deflection(s))
        shaped = self._mean(lambda s: self.deflection(s) * (influence(s) - point * self.deflection(s)))
        return point, alone, shaped

    def _mean(self, of: Influence) -> float:
        """Over the beam, of what is a polynomial of degree seven at most between load, supports and end."""
        places = sorted({0.0, self.at, 1.0, self.end})
        total = 0.0
        for low, high in pairwise(places):
            half = 0.5 * (high - low)
            total += half * float(_WEIGHTS @ of(low + half * (1.0 + _NODES)))
        return total / self.end
